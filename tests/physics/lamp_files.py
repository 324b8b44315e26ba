# SPDX-License-Identifier: MIT
"""Writes lamp makers' files of a function of the direction in the lamp's frame (gamma 0 is +z, C 0
+x, C 90 -y): IES LM-63 of every goniometer, and EULUMDAT of every symmetry. And reads them back."""
import math


def c_plane(c, gamma):
    c, gamma = math.radians(c), math.radians(gamma)
    return (math.sin(gamma) * math.cos(c), -math.sin(gamma) * math.sin(c), math.cos(gamma))


def type_b(h, v):
    """H about C 0, clockwise from straight down; V towards C 0."""
    h, v = math.radians(h), math.radians(v)
    return (math.sin(v), math.cos(v) * math.sin(h), math.cos(v) * math.cos(h))


def type_a(h, v):
    """H about the vertical, clockwise; V above the horizon, away from gamma 0."""
    h, v = math.radians(h), math.radians(v)
    return (math.cos(v) * math.cos(h), math.cos(v) * math.sin(h), -math.sin(v))


def steps(low, high, step):
    return [low + step * k for k in range(round((high - low) / step) + 1)]


def wrapped(numbers, form="%.5f"):
    words = [form % x for x in numbers]
    return "\n".join(" ".join(words[i:i + 12]) for i in range(0, len(words), 12)) + "\n"


def ies(function, kind="C", horizontal=None, vertical=None, first="IESNA:LM-63-2002", tilt="NONE",
        multiplier=1, unit=2, size=(0, 0, 0), ballast=1, ballast_lamp=1, lumens=-1):
    at = {"C": c_plane, "B": type_b, "A": type_a}[kind]
    vertical = vertical or (steps(0, 180, 2.5) if kind == "C" else steps(-90, 90, 2.5))
    text = f"{first}\n[TEST] none\n[MANUFAC] Example\n[LUMINAIRE] of {kind}\nTILT={tilt}\n"
    text += f"1 {lumens} {multiplier} {len(vertical)} {len(horizontal)} {' CBA'.index(kind)} {unit} "
    text += f"{size[0]} {size[1]} {size[2]}\n{ballast} {ballast_lamp} 20\n"
    text += wrapped(vertical, "%g") + wrapped(horizontal, "%g")
    for h in horizontal:
        text += wrapped(function(at(h, v)) for v in vertical)
    return text


def eulumdat(function, symmetry=0, lumens=(1000,), lamps=1, conversion=1, size=(0, 0, 0, 0, 0, 0),
             planes=72, gammas=73):
    """size: length, width, and heights at C 0, 90, 180, 270, mm."""
    c = [360 / planes * k for k in range(planes)]
    rows = {0: c, 1: c[:1], 2: c[:planes // 2 + 1],
            3: c[3 * planes // 4:] + c[:planes // 4 + 1], 4: c[:planes // 4 + 1]}[symmetry]
    gamma = steps(0, 180, 180 / (gammas - 1))
    lines = ["Example", 1, symmetry, planes, 360 / planes, gammas, 180 / (gammas - 1), "report",
             f"with symmetry {symmetry}", "number", "name.ldt", "2026-01-01", 0, 0, 0, *size, 50, 100,
             conversion, 0, len(lumens)]
    for flux in lumens:
        lines += [lamps, "LED", flux, 3000, 80, 20]
    lines += [0.5] * 10 + c + gamma
    lines += [f"{function(c_plane(a, g)):.6f}".replace(".", ",") for a in rows for g in gamma]
    return "".join(f"{line}\r\n" for line in lines)


def numbers(text):
    return [float(word) for word in text.replace(",", " ").split()]


def read_ies(path):
    """(C, gamma, candela[C][gamma]) of a file of type C without factors."""
    with open(path, encoding="ascii") as file:
        head, body = file.read().split("TILT=NONE\n")
    assert head.startswith("IES")
    value = numbers(body)
    n_gamma, n_c = int(value[3]), int(value[4])
    assert value[1] == -1 and value[2] == 1 and value[5] == 1 and value[10] == 1
    gamma, rest = value[13:13 + n_gamma], value[13 + n_gamma:]
    c, rest = rest[:n_c], rest[n_c:]
    assert len(rest) == n_c * n_gamma
    return c, gamma, [rest[k * n_gamma:(k + 1) * n_gamma] for k in range(n_c)]


def read_eulumdat(path):
    """(C, gamma, candela[C][gamma]) of a file without symmetry."""
    with open(path, encoding="ascii") as file:
        line = [text.strip() for text in file]
    n_c, n_gamma = int(line[3]), int(line[5])
    assert line[2] == "0" and line[25] == "1"
    factor = float(line[23]) * float(line[28]) / 1000
    value = [float(text) for text in line[42:]]
    c, gamma, rest = value[:n_c], value[n_c:n_c + n_gamma], value[n_c + n_gamma:]
    assert len(rest) == n_c * n_gamma
    return c, gamma, [[factor * x for x in rest[k * n_gamma:(k + 1) * n_gamma]] for k in range(n_c)]
