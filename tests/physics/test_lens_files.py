#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Lens files that `raymap import` brings: first-order numbers and real rays against what is published of them.

tests/data/lenses/README.md says where the files are from. Rays are traced through the scene as it was written, but for its
sources and coats, which are replaced."""
import json
import math
import os
import re

from raymap import Checks, report, run

checks = Checks()
LENSES = os.path.join(os.environ["SOURCE_DIR"], "tests", "data", "lenses")


def bring(path, *more):
    folder = os.path.basename(path).rsplit(".", 1)[0]
    told = json.loads(run("import", path, "-o", folder, "--force", "--json", *more))
    check = json.loads(run("check", told["scene"], "--json"))
    checks.true(f"{folder}: check says nothing: {check['diagnostics']}", not check["diagnostics"])
    with open(told["scene"], encoding="utf-8") as file:
        return told, file.read()


def with_ray(text, origin, direction, wavelength):
    """The scene with one ray for its sources, and surfaces that transmit all light."""
    text = re.sub(r"polished: \{type: fresnel\}", "polished: {type: fresnel, coat: ideal}", text)
    text = re.sub(r"(?s)\nsources:.*?\n\n", f"\nsources:\n  - {{name: ray, type: rays, medium: air, rays: [{{origin: {list(origin)}, "
                  f"direction: {list(direction)}, wavelength: {wavelength}}}]}}\n\n", text)
    return text


def direction_after(steps, k):
    return steps[k + 1]["direction"]


def check_double_gauss():
    """Listing of CODE V 10.8 (ray-optics, src/rayoptics/codev/tests/ag_dblgauss.lis): first order to its printed digits, and
    the real marginal ray."""
    told, text = bring(os.path.join(LENSES, "rayoptics_codev_ag_dblgauss.seq"))
    for key, want, within in (("focal_length", 100.0038, 5e-5), ("back_focus", 61.4875, 5e-5), ("f_number", 2.0001, 5e-5),
                              ("entrance_pupil", 57.912, 5e-5), ("entrance_pupil_diameter", 50, 0)):
        checks.close(f"double Gauss {key}", told[key], want, abs=within)
    checks.true("double Gauss: all is understood", told["understood"])
    rows = [[25.0, 5.866433], [24.109772, 1.920632], [22.844992, 7.714534], [20.958242, 0], [16.784894, 6.754936], None,
            [14.610682, -4.050377], [15.815163, 0], [16.882946, -3.965091], [16.583956, 0.776812], [16.261006, -1.682704],
            [0.014138, 0]]
    vertex = [0, 8.75, 9.25, 21.75, 25.55, 41.9194449265356, 55.6674018904247, 59.4674018904247, 70.4674018904247,
              70.9674018904247, 77.9674018904247, 77.9674018904247 + 61.4875364179821 - 0.4002686453541377]
    steps = report("double-gauss", with_ray(text, (25, 0, -10), (0, 0, 1), 587.6))["steps"]
    seen = [(row, z) for row, z in zip(rows, vertex) if row]  # the stop is a hole
    checks.true("double Gauss: the marginal ray meets all surfaces", len(steps) == len(seen))
    for k, ((x, sag), z) in enumerate(seen):
        checks.close(f"marginal ray {k} x", steps[k]["position"][0], x, abs=2e-6)
        checks.close(f"marginal ray {k} z", steps[k]["position"][2] - z, sag, abs=2e-6)
    # The stop is as large as the marginal ray is high there in the listing.
    stop = float(re.search(r"aperture: ([0-9.]+), stop: true", text).group(1))
    checks.close("stop of the double Gauss", stop, 15.702464, abs=3e-5)


# Subaru's Hyper Suprime-Cam: batoid (github.com/jmeyers314/batoid, batoid/data/HSC/HSC_old.yaml and tests/testdata/
# HSC_raytrace_1.txt, BSD 2-Clause; the ray is of Zemax). z in m from the primary mirror towards the sky: curvature, even
# asphere from r^4 on, and the index behind it.
HSC = [
    ("PM", 0, 0.0333333333333333, [], 1.0),
    ("G1_entrance", 13.4564, 1.31578947368421, [], 1.45421013),
    ("G1_exit", 13.55358, 0.727008360596147, [-0.1497488783073, -0.07579068214673, -0.7705293869522, 10.26626319251,
                                              -70.78826218129, 255.9600617806, -376.1551480578], 1),
    ("G2_entrance", 13.92643, -0.28328611898017, [0.06914718060975, 0.603728126364, -15.32623173462, 361.8110894954,
                                                  -4741.677881169, 32173.09071692, -88598.7809163], 1.51225242),
    ("G2_exit", 13.97243, 1.52380976201997, [], 1),
    ("ADC1_entrance", 14.29043, 0.0, [], 1.51225242),
    ("ADC1_exit", 14.33043, 0.945179584120983, [], 1),
    ("ADC2_entrance", 14.33343, 0.961538461538461, [], 1.54157395),
    ("ADC2_exit", 14.41543, 0.0, [], 1),
    ("G3_entrance", 14.68973, -1.19047594934125, [2.768476102307, -48.55642009259, 717.6113272766, -10763.70261452,
                                                  118744.321781, -798382.1197395, 2393556.961408], 1.54157395),
    ("G3_exit", 14.72973, 0.102040816326531, [], 1),
    ("G4_entrance", 14.81973, 2.08333333333333, [-4.355533915492, 36.35867914913, -595.1267151922, 7658.839741989, -71941.20343205, 394282.0924898, -954342.843455], 1.51225242),
    ("G4_exit", 14.92173, 0.248647418889157, [], 1),
    ("G5_entrance", 15.02193, 0.239420695942602, [], 1.45421013),
    ("G5_exit", 15.10993, -0.785655626266704, [-1.064687616564, 3.377750239208, -110.26471335, 2282.368582236,
                                               -27430.39658171, 175577.1152898, -482194.9608578], 1),
    ("F_entrance", 15.1999712564515, 0.0, [], 1.45421013),
    ("F_exit", 15.2149712564515, 0.0, [], 1),
    ("W_entrance", 15.2474712564515, 0.0, [], 1.45421013),
    ("W_exit", 15.2844712564515, 0.0, [], 1),
    ("D", 15.2994712564515, 0.0, [], 1),
]
# Where the ray meets them, and its direction behind each: y, z, dy, dz.
HSC_RAY = [
    ("PM", 4.1, 0.280155744, -0.2683015265, 0.9633349837),
    ("G1_entrance", 0.39876497152, 13.5694173901, -0.3528959894, 0.9356625571),
    ("G1_exit", 0.38533222173, 13.6050327595, -0.4008868242, 0.9161275862),
    ("G2_entrance", 0.24837399129, 13.9180168874, -0.2415156978, 0.9703969125),
    ("G2_exit", 0.22493734407, 14.0121840587, -0.1881478503, 0.9821407162),
    ("ADC1_entrance", 0.17163400897, 14.29043, -0.1244156385, 0.9922301895),
    ("ADC1_exit", 0.16499527734, 14.3433747103, -0.108200669, 0.9941290737),
    ("ADC2_entrance", 0.16465009391, 14.3465461962, -0.1258534554, 0.9920488434),
    ("ADC2_exit", 0.15591134602, 14.41543, -0.1940124084, 0.9809990751),
    ("G3_entrance", 0.10286177669, 14.6836684023, -0.0847704814, 0.9964005046),
    ("G3_exit", 0.098900548933, 14.7302290596, -0.1251907828, 0.9921326866),
    ("G4_entrance", 0.086641388993, 14.8273824843, -0.1405990237, 0.9900666213),
    ("G4_exit", 0.073148654637, 14.9223952771, -0.2031964695, 0.9791379856),
    ("G5_entrance", 0.052424344952, 15.02225901434, -0.143700238, 0.9896212617),
    ("G5_exit", 0.03978457071, 15.10930542082, -0.2236181174, 0.9746768375),
    ("F_entrance", 0.018983293105, 15.19997125645, -0.1537729058, 0.9881062157),
    ("F_exit", 0.016648935168, 15.21497125645, -0.2236181174, 0.9746768375),
    ("W_entrance", 0.0091925265054, 15.24747125645, -0.1537729058, 0.9881062157),
    ("W_exit", 0.0034344435937, 15.28447125645, -0.2236181174, 0.9746768375),
    ("D", -6.9757890286e-06, 15.29947125645, -0.2236181174, 0.9746768375),
]


def hsc_zmx():
    """As a designer has it: light towards +z, z turned about, thicknesses negative behind the mirror; in UTF-16. And its
    three glasses as a catalogue, of a formula without dispersion."""
    glass = {1.45421013: "SIL", 1.51225242: "BSL7Y", 1.54157395: "PBL1Y"}
    lines = ["VERS 1", "MODE SEQ", "NAME Hyper Suprime-Cam", "UNIT METER X W X CM MR CPMM", "ENPD 8.2", "GCAT MY",
             "FTYP 0 0 1 1 0 0 0", "XFLN 0", "YFLN 0", "WAVM 1 0.75 1", "PWAV 1", "SURF 0", "  TYPE STANDARD", "  DISZ INFINITY"]
    for k, (name, z, c, asphere, index) in enumerate(HSC):
        lines += [f"SURF {k + 1}", f"  COMM {name}", f"  TYPE {'EVENASPH' if asphere else 'STANDARD'}", f"  CURV {-c!r} 0 0 0 0 \"\""]
        if k == 0:
            lines += ["  STOP", "  CONI -1.00835", "  GLAS MIRROR 0 0 1.5 40 0 0 0 0 0 0"]
        lines += [f"  PARM {i + 2} {-a!r}" for i, a in enumerate(asphere)]
        if index != 1:
            lines.append(f"  GLAS {glass[index]} 0 0 1.5 40 0 0 0 0 0 0")
        lines += [f"  DISZ {z - HSC[k + 1][1] if k + 1 < len(HSC) else 0!r}",
                  f"  DIAM {4.2 if k == 0 else abs(HSC_RAY[k][1]) + 0.02!r} 1 0 0 1 \"\""]
    with open("hsc.zmx", "wb") as file:
        file.write(("\r\n".join(lines) + "\r\n").encode("utf-16"))
    with open("glasses.cat.agf", "w", encoding="ascii") as file:
        for n, name in glass.items():
            file.write(f"NM {name} 2 0 {n!r} 60 0\nCD {n * n - 1!r} 0 0 0 0 0\nLD 0.3 2.5\n")


def check_hyper_suprime_cam():
    """Twenty surfaces, five aspheres, a mirror before them: the ray of Zemax to 1e-9 m, at every surface."""
    hsc_zmx()
    told, text = bring("hsc.zmx")  # glasses.cat.agf lies beside it
    checks.true(f"HSC: all is understood: {told['findings']}", told["understood"])
    lens = [e for e in told["elements"] if e["kind"] == "lens"]
    checks.true("HSC: the corrector is one lens, its rows by z", len(lens) == 1 and lens[0]["surfaces"] == list(range(19, 1, -1)))
    steps = report("hsc", with_ray(text, (0, 4.1, -16.0), (0, 0, 1), 750))["steps"]
    checks.true(f"HSC: {len(steps)} steps", len(steps) == len(HSC))
    for k, (name, y, z, dy, dz) in enumerate(HSC_RAY):
        checks.close(f"HSC {name} y", steps[k]["position"][1], y, abs=1e-9)
        checks.close(f"HSC {name} z", steps[k]["position"][2], -z, abs=1e-9)
        if k + 1 < len(HSC_RAY):
            d = direction_after(steps, k)
            checks.close(f"HSC {name} direction", [d[1], d[2]], [dy, -dz], abs=1e-9)


def write_lens(name, um, catalogue, rows, stop=1):
    lines = ["UNIT MM X W X CM MR CPMM", "ENPD 10" if name == "cooke" else "ENPD 1", f"GCAT {catalogue}", "FTYP 0 0 1 1", f"WAVM 1 {um} 1", "SURF 0",
             "  DISZ INFINITY"]
    for k, (radius, thickness, glass) in enumerate(rows):
        lines += [f"SURF {k + 1}", f"  CURV {1 / radius!r}", f"  DISZ {thickness}"] + ([f"  GLAS {glass}"] if glass else []) + \
            (["  STOP"] if k + 1 == stop else [])
    with open(name + ".zmx", "w", encoding="ascii") as file:
        file.write("\n".join(lines + [f"SURF {len(rows) + 1}", "  DISZ 0"]))


# First-order numbers of optiland's tests (tests/test_paraxial.py, MIT), and of the files' own makers.
def check_first_order():
    hubble = ["UNIT MM X W X CM MR CPMM", "ENPD 2400", "FTYP 0 0 1 1", "WAVM 1 0.55 1", "SURF 0", "  DISZ INFINITY", "SURF 1",
              "  STOP", "  CURV {!r}".format(1 / -11040.02286), "  CONI -1.001152", "  GLAS MIRROR", "  DISZ -4910.01016", "SURF 2",
              "  CURV {!r}".format(1 / -1349.31166), "  CONI -1.483014", "  GLAS MIRROR", "  DISZ 6365.20955", "SURF 3", "  DISZ 0"]
    with open("hubble.zmx", "w", encoding="ascii") as file:
        file.write("\n".join(hubble))
    told, text = bring("hubble.zmx")
    checks.close("Hubble EFL", told["focal_length"], 57600.0809984036, rel=1e-9)
    checks.close("Hubble focus behind the image", told["back_focus"] - 6365.20955, 0.0168642375298487, rel=1e-6)
    checks.close("Hubble f-number", told["f_number"], 24.0000337493348, rel=1e-9)
    checks.true("Hubble: light goes through a hole in the primary, and it is said",
                re.search(r"inner: [0-9]", text) and "the file has no hole in it" in text)
    rows = ((22.01359, 3.25896, "SK16"), (-435.76044, 6.00755, ""), (-22.21328, 0.99997, "F2"), (20.29192, 4.75041, ""),
            (79.6836, 2.95208, "SK16"), (-18.39533, 42.20778, ""))
    write_lens("cooke", 0.55, "SCHOTT HIKARI", rows, stop=4)
    told, text = bring("cooke.zmx")
    checks.close("Cooke triplet EFL", told["focal_length"], 49.9997830714319, rel=1e-9)
    checks.close("Cooke triplet BFL", told["back_focus"], 42.4148575589589, rel=1e-9)
    checks.close("Cooke triplet entrance pupil", told["entrance_pupil"], 11.5121586737468, rel=1e-9)
    # `check` works the same numbers out of the scene's own lens.
    scene = json.loads(run("check", told["scene"], "--json"))["scene"]
    lens = [group for group in scene["lenses"]][0] if "lenses" in scene else None
    if lens:
        checks.close("Cooke triplet EFL of the scene", lens["focal_length"], told["focal_length"], rel=1e-12)
    # Laikin's achromat (Lens Design, 4th edition, p. 45), Edmund 49-847, a singlet of LAC9, a telescope's triplet.
    for name, um, catalogue, rows, focal, back in (
            ("laikin", 0.5875618, "SCHOTT", ((12.38401, 0.434, "N-BAK1"), (-7.9414, 0.321, "SF2"), (-48.44396, 19.6059, "")),
             20.0059952749227, 19.6069926337591),
            ("edmund", 0.5875618, "SCHOTT", ((19.93, 7, "N-SF11"), (math.inf, 21.48, "")), 25.397595913429, 21.475411914667),
            ("lac9", 0.5875618, "HOYA", ((63.73364157, 10.0, "LAC9"), (653.2939232, 92.7383463, "")), 101.501825948855, 94.9939680861907),
            ("objective", 0.5876, "SCHOTT", ((50.098, 4.5, "N-BK7"), (-983.42, 0.1, ""), (56.671, 4.5, "N-BK7"), (-171.15, 5.571, ""),
                                             (-97.339, 3.5, "SF1"), (81.454, 75.132, "")), 100.001261421799, 75.1335145573977)):
        write_lens(name, um, catalogue, rows)
        told, text = bring(name + ".zmx")
        checks.close(f"{name} EFL", told["focal_length"], focal, rel=1e-9)
        checks.close(f"{name} BFL", told["back_focus"], back, rel=1e-9)
    for name, focal, back in (("rayoptics_codev_schmidt_sph.seq", 100.0, None), ("optiland_lens2.zmx", 22.5, 19.982263937046813),
                              ("rayoptics_HoO-V2C18Ex03.zmx", None, 24.035)):
        told, text = bring(os.path.join(LENSES, name))
        if focal:
            checks.close(f"{name} EFL", told["focal_length"], focal, rel=5e-5)
        if back:  # the file's own paraxial solve, or its image
            checks.close(f"{name} BFL", told["back_focus"], back, abs=5e-5)


def check_folds():
    """Coordinate breaks (Zemax) and bends (CODE V): a ray along the axis meets the middle of each mirror and of the image, and
    comes in straight; where, closed form."""
    told, text = bring(os.path.join(LENSES, "optiland_simple_fold_mirror_up.zmx"))
    steps = report("fold", with_ray(text, (0, 0, -5), (0, 0, 1), 550))["steps"]
    for k, want in enumerate(([0, 0, 40], [0, 50, 40], [0, 50, 90])):
        checks.close(f"fold {k}", steps[k]["position"], want, abs=1e-12)
    told, text = bring(os.path.join(LENSES, "rayoptics_codev_dec_tilt_test.seq"))
    steps = report("bend", with_ray(text, (0, 0, -5), (0, 0, 1), 555))["steps"]
    sine, cosine = 5 * math.sin(math.radians(60)), 5 * math.cos(math.radians(60))
    for k, want in enumerate(([0, 0, 5], [0, -sine, 5 + cosine], [0, -sine, 10 + cosine], [0, 5 - sine, 10 + cosine])):
        checks.close(f"bend {k}", steps[k]["position"], want, abs=1e-12)


def check_aim():
    """Of a decentred system of CODE V the middle ray of each field goes through the middle of the stop, behind a mirror."""
    with open("aim.seq", "w", encoding="ascii") as file:
        file.write("RDM;LEN\nEPD 20\nWL 550\nXAN 0 1\nYAN 0 -1.5\nSO 0 1e20\nS 0 100\nS -500 -200 REFL\nDAR; YDE 40; ADE 5\n"
                   "S 0 -50\nSTO; DAR; YDE 12; XDE 3; ADE -4\nSI 0 0\nYDE 20; ADE 9\n")
    told, text = bring("aim.seq")
    stop = [float(v) for v in re.search(r"name: stop_3, .*?at: \[(.*?)\]", text).group(1).split(",")]
    for name in ("field_1", "field_2"):
        beam = re.search(rf"name: {name}, .*?at: \[(.*?)\], direction: \[(.*?)\]", text)
        origin, direction = ([float(v) for v in beam.group(k).split(",")] for k in (1, 2))
        steps = report("aim", with_ray(text, origin, direction, 550))["steps"]
        d = direction_after(steps, 0)
        off = [s - p for s, p in zip(stop, steps[0]["position"])]
        along = sum(a * b for a, b in zip(off, d))
        checks.close(f"{name} from the stop's middle", math.dist(off, [along * v for v in d]), 0, abs=1e-6)


def check_mangin():
    """Its front surface is met twice and stands there once: back focus of the listing's numbers by a y-nu trace of our own."""
    told, text = bring(os.path.join(LENSES, "rayoptics_codev_mangin.seq"))
    n = [m["index"] for m in told["media"] if m["name"] == "N-BK7"][0]
    y, nu, index = 1.0, 0.0, 1.0
    for c, after, gap in ((-1 / 1200, n, 10), (-1 / 1000, -n, -10), (-1 / 1200, -1, 0)):
        nu -= y * c * (after - index)
        index = after
        y += gap * nu / index
    checks.close("Mangin BFL", told["back_focus"], y / nu, rel=1e-12)
    height = 1.0
    steps = report("mangin", with_ray(text, (0, height, -5), (0, 0, 1), 555))["steps"]
    checks.true("Mangin: glass, mirror, glass, image", [s["object"] for s in steps] == ["lens.1", "lens.2", "lens.1", "image"])
    at, d = steps[3]["position"], steps[3]["direction"]
    focus = at[2] - at[1] * d[2] / d[1]
    checks.close("Mangin focus of a ray near the axis", focus, told["back_focus"], abs=2e-3)


def check_model_glass():
    """nd and Vd to all digits, and the normal line: 0.5 um^-1 glasses of SCHOTT lie within 2e-4 of it."""
    told, text = bring(os.path.join(LENSES, "rayoptics_codev_schmidt_sph.seq"))
    b, c = (list(map(float, part.split(","))) for part in re.search(r"B: \[(.*?)\], C: \[(.*?)\]", text).groups())

    def n(nm):
        l2 = (nm * 1e-3) ** 2
        return math.sqrt(1 + sum(x * l2 / (l2 - y) for x, y in zip(b, c)))

    checks.close("model glass nd", n(587.5618), 1.569, abs=1e-12)
    checks.close("model glass Vd", (n(587.5618) - 1) / (n(486.1327) - n(656.2725)), 63.1, rel=1e-9)
    checks.close("model glass P_gF", (n(435.8343) - n(486.1327)) / (n(486.1327) - n(656.2725)), 0.6438 - 0.001682 * 63.1, abs=1e-9)
    # N-PSK3, 1.55232 63.46, at lines far from d, F and C.
    glass = json.loads(run("glass", "N-PSK3", "--at", "404.7,546.1,706.5,852.1", "--json"))["glasses"][0]
    with open("psk.seq", "w", encoding="ascii") as file:
        file.write("LEN\nEPD 5\nWL 587.6\nSO 0 1e20\nS 0.02 3 %s\nS 0 10\nSI 0 0\n" % "552320.634600")
    text = bring("psk.seq")[1]
    b, c = (list(map(float, part.split(","))) for part in re.search(r"B: \[(.*?)\], C: \[(.*?)\]", text).groups())
    for at in glass["at"]:
        checks.close(f"model of N-PSK3 at {at['wavelength']}", n(at["wavelength"]), at["n"], abs=1e-4)


def radial(n, m, u):
    return sum((-1) ** k * math.factorial(n - k) / (math.factorial(k) * math.factorial((n + m) // 2 - k) * math.factorial((n - m) // 2 - k))
               * u ** (n - 2 * k) for k in range((n - m) // 2 + 1))


def zernike(n, m, x, y):
    """Of peak 1; m < 0: the sine."""
    angle = math.atan2(y, x)
    return radial(n, abs(m), math.hypot(x, y)) * (math.cos(m * angle) if m >= 0 else math.sin(-m * angle))


def conic(x, y, c, k=0.0):
    r2 = x * x + y * y
    return c * r2 / (1 + math.sqrt(1 - (1 + k) * c * c * r2))


def biconic(x, y, cx, kx, cy, ky):
    return (cx * x * x + cy * y * y) / (1 + math.sqrt(1 - (1 + kx) * cx * cx * x * x - (1 + ky) * cy * cy * y * y))


def turned(y, x, profile, radius):
    """Height of a profile of y that is turned about a line along y at z = radius."""
    return radius - math.copysign(math.sqrt((radius - profile(y)) ** 2 - x * x), radius)


def q_bfs(m, x):
    """The first three by Forbes 2007 (doi 10.1364/OE.15.005218), appendix A."""
    return (1, (13 - 16 * x) / math.sqrt(19), math.sqrt(2 / 95) * (29 - 4 * x * (25 - 19 * x)))[m]


def q_con(m, x):
    return (1, 6 * x - 5, 15 - 14 * x * (3 - 2 * x))[m]


def slope_factor(r, c, k):
    return math.sqrt((1 - k * c * c * r * r) / (1 - (1 + k) * c * c * r * r))


C, K = 0.012, -0.7
# Lines of a Zemax surface beside its curvature and conic, and its height.
ZMX_SHAPES = [
    ("ODDASPHE", "PARM 1 1e-3|PARM 3 2e-5|PARM 4 -1e-6", lambda x, y: conic(x, y, C, K) + 1e-3 * math.hypot(x, y) +
     2e-5 * math.hypot(x, y) ** 3 - 1e-6 * math.hypot(x, y) ** 4),
    ("XASPHERE", "XDAT 1 2|XDAT 2 20|XDAT 3 0.1|XDAT 4 -0.3", lambda x, y: conic(x, y, C, K) + 0.1 * (x * x + y * y) / 400 -
     0.3 * (x * x + y * y) ** 2 / 160000),
    ("XOSPHERE", "XDAT 1 3|XDAT 2 20|XDAT 3 0.01|XDAT 5 0.2", lambda x, y: conic(x, y, C, K) + 0.01 * math.hypot(x, y) / 20 +
     0.2 * (math.hypot(x, y) / 20) ** 3),
    ("BICONICX", "PARM 1 120|PARM 2 -2", lambda x, y: biconic(x, y, 1 / 120, -2, C, K)),
    ("TOROIDAL", "PARM 1 -60|PARM 2 1e-3|PARM 3 2e-6", lambda x, y: turned(y, x, lambda v: conic(0, v, C, K) + 1e-3 * v * v + 2e-6 * v ** 4, -60)),
    ("TOROIDAL", "PARM 1 0|PARM 3 2e-6", lambda x, y: conic(0, y, C, K) + 2e-6 * y ** 4),
    ("XPOLYNOM", "XDAT 1 9|XDAT 2 10|XDAT 3 0.02|XDAT 6 0.03|XDAT 8 -0.04|XDAT 10 0.05", lambda x, y: conic(x, y, C, K) + 0.02 * x / 10 +
     0.03 * x * y / 100 - 0.04 * x ** 3 / 1000 + 0.05 * x * y * y / 1000),
    ("SZERNSAG", "PARM 2 1e-6|XDAT 1 11|XDAT 2 12|XDAT 6 0.02|XDAT 7 -0.01|XDAT 9 0.01|XDAT 13 0.005",
     lambda x, y: conic(x, y, C, K) + 1e-6 * (x * x + y * y) ** 2 + 0.02 * math.sqrt(3) * zernike(2, 0, x / 12, y / 12)
     - 0.01 * math.sqrt(6) * zernike(2, -2, x / 12, y / 12) + 0.01 * math.sqrt(8) * zernike(3, -1, x / 12, y / 12)
     + 0.005 * math.sqrt(5) * zernike(4, 0, x / 12, y / 12)),
    ("FZERNSAG", "XDAT 1 9|XDAT 2 12|XDAT 7 0.02|XDAT 9 -0.01|XDAT 11 0.03",
     lambda x, y: conic(x, y, C, K) + 0.02 * zernike(2, 2, x / 12, y / 12) - 0.01 * zernike(3, 1, x / 12, y / 12)
     + 0.03 * zernike(4, 0, x / 12, y / 12)),
    ("QED_TYPE", "XDAT 1 0|XDAT 2 3|XDAT 3 12|XDAT 4 0.1|XDAT 5 -0.05|XDAT 6 0.02", lambda x, y: conic(x, y, C, K) +
     (x * x + y * y) / 144 * (1 - (x * x + y * y) / 144) * slope_factor(math.hypot(x, y), C, K) *
     sum(a * q_bfs(m, (x * x + y * y) / 144) for m, a in enumerate((0.1, -0.05, 0.02)))),
    ("QED_TYPE", "XDAT 1 1|XDAT 2 3|XDAT 3 12|XDAT 4 0.1|XDAT 5 -0.05|XDAT 6 0.02", lambda x, y: conic(x, y, C, K) +
     ((x * x + y * y) / 144) ** 2 * sum(a * q_con(m, (x * x + y * y) / 144) for m, a in enumerate((0.1, -0.05, 0.02)))),
    ("TILTSURF", "PARM 1 0.02|PARM 2 -0.05", lambda x, y: 0.02 * x - 0.05 * y),
]
# The same of CODE V, after `S radius thickness REFL`.
SEQ_SHAPES = [
    ("SPS ODD 0|SCO K -0.7|SCO AR1 1e-3|SCO C4 2e-5", lambda x, y: conic(x, y, C, K) + 1e-3 * math.hypot(x, y) + 2e-5 * math.hypot(x, y) ** 3),
    ("SPS XYP 10|SCO K -0.7|SCO C2 0.02|SCO C5 0.03|SCO X1Y2 0.05", lambda x, y: conic(x, y, C, K) + 0.02 * x / 10 + 0.03 * x * y / 100
     + 0.05 * x * y * y / 1000),
    ("SPS ZRN|SCO NRADIUS 12|SCO K -0.7|SCO C7 0.02|SCO C8 -0.03|SCO Z9 0.01|SCO C17 0.02", lambda x, y: conic(x, y, C, K)
     + 0.02 * zernike(2, 2, x / 12, y / 12) - 0.03 * zernike(2, 0, x / 12, y / 12) + 0.01 * zernike(3, -1, x / 12, y / 12)
     + 0.02 * zernike(4, -2, x / 12, y / 12)),
    ("SPS ZFR 12|SCO K -0.7|SCO C8 0.02|SCO C12 0.03", lambda x, y: conic(x, y, C, K) + 0.02 * zernike(2, 2, x / 12, y / 12)
     + 0.03 * zernike(4, 0, x / 12, y / 12)),
    ("SPS QCN|SCO NRADIUS 12|SCO K -0.7|SCO C4 0.1|SCO QC6 -0.05", lambda x, y: conic(x, y, C, K) + ((x * x + y * y) / 144) ** 2 *
     (0.1 - 0.05 * q_con(1, (x * x + y * y) / 144))),
    ("SPS QBF|SCO NRADIUS 12|SCO C3 0.1|SCO C4 -0.05", lambda x, y: conic(x, y, C) + (x * x + y * y) / 144 * (1 - (x * x + y * y) / 144) *
     slope_factor(math.hypot(x, y), C, 0) * (0.1 - 0.05 * q_bfs(1, (x * x + y * y) / 144))),
    ("AAS|RDX 120|KX -2|K -0.7|AR 1e-6|AP 0.3|BR 1e-9|BP -0.2", lambda x, y: biconic(x, y, 1 / 120, -2, C, K)
     + 1e-6 * (0.7 * x * x + 1.3 * y * y) ** 2 + 1e-9 * (1.2 * x * x + 0.8 * y * y) ** 3),
    ("YTO|RDX -60|K -0.7|A 2e-6", lambda x, y: turned(y, x, lambda v: conic(0, v, C, K) + 2e-6 * v ** 4, -60)),
    ("XTO|RDX -60|K -0.7|A 2e-6", lambda x, y: turned(x, y, lambda v: conic(0, v, -1 / 60, K) + 2e-6 * v ** 4, 1 / C)),
    ("CYL|K -0.7", lambda x, y: conic(0, y, C, K)),
]


def check_shape(path, name, sag):
    """Parallel rays meet the surface, a mirror, at its height, and leave by its normal (differences of the height)."""
    told, text = bring(path)
    checks.true(f"{name}: all is understood: {told['findings']}", told["understood"])
    for x, y in ((3.0, 2.0), (-1.5, 4.5)):
        steps = report("shape", with_ray(text, (x, y, -5), (0, 0, 1), 587.6))["steps"]
        checks.close(f"{name} z at {x}, {y}", steps[0]["position"][2], sag(x, y), abs=1e-10)
        h = 1e-4
        dx = (8 * (sag(x + h, y) - sag(x - h, y)) - sag(x + 2 * h, y) + sag(x - 2 * h, y)) / (12 * h)
        dy = (8 * (sag(x, y + h) - sag(x, y - h)) - sag(x, y + 2 * h) + sag(x, y - 2 * h)) / (12 * h)
        size = 1 + dx * dx + dy * dy
        checks.close(f"{name} direction at {x}, {y}", direction_after(steps, 0), [2 * dx / size, 2 * dy / size, 1 - 2 / size], abs=1e-9)


def check_shapes():
    head = "UNIT MM X W X CM MR CPMM\nENPD 10\nFTYP 0 0 1 1\nWAVM 1 0.5876 1\nSURF 0\n  DISZ INFINITY\nSURF 1\n  STOP\n  GLAS MIRROR\n" \
           "  DISZ -40\n  DIAM 8\n"
    for kind, lines, sag in ZMX_SHAPES:
        with open("shape-zmx.zmx", "w", encoding="ascii") as file:
            file.write(head + f"  TYPE {kind}\n  CURV {C}\n  CONI {K}\n  " + lines.replace("|", "\n  ") + "\nSURF 2\n  DISZ 0\n")
        check_shape("shape-zmx.zmx", kind, sag)
    for lines, sag in SEQ_SHAPES:
        with open("shape-seq.seq", "w", encoding="ascii") as file:
            file.write(f"RDM;LEN\nEPD 10\nWL 587.6\nSO 0 1e20\nS {1 / C!r} -40 REFL\nSTO\nCIR 8\n" + lines.replace("|", "\n") + "\nSI 0 0\n")
        check_shape("shape-seq.seq", lines.split("|")[0], sag)


check_double_gauss()
check_hyper_suprime_cam()
check_first_order()
check_folds()
check_aim()
check_mangin()
check_model_glass()
check_shapes()
checks.finish()
