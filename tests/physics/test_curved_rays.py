#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Single rays through gradient media against closed forms and published tables.

Luneburg's lens (Luneburg 1944, Mathematical Theory of Optics, sec. 28): every ray of a parallel beam
to the antipode, all with the same optical length. The parabolic rod (Ghatak & Thyagarajan 1978,
Contemporary Optics): a sine of z; Tz is kept. The refraction of stars: a spherical exponential
atmosphere (quadrature of -dn/n tan(psi) along Bouguer's invariant), and the two-layer model of
Hohenkerk & Sinclair (NAO Technical Note 63, 1985) that ERFA's refco.c tabulates.
"""
import math

from raymap import Checks, report

checks = Checks()


def source(at, direction, medium, extra=""):
    return (f"  - {{name: beam, type: collimated, shape: {{disc: 1.0e-13}}, at: {at}, "
            f"direction: {direction}, flux: 1 W, spectrum: {{lines: {{550: 1}}}}, medium: {medium}"
            f"{extra}}}\n")


HEAD = "raymap: 1\nunits: {}\nspectrum: {{mode: spectral, wavelengths: [550]}}\n"


def luneburg(at, direction, options=""):
    return (HEAD.format("mm") + f"""media:
  air: {{index: 1}}
  lens: {{gradient: {{type: luneburg, radius: 1{options}}}}}
geometries: {{ball: {{type: sphere, radius: 1}}}}
objects:
  - {{name: ball, geometry: ball, surface: fresnel, outside: air, inside: lens}}
sources:
""" + source(at, direction, "air"))


LENS = ((0.1, 2.56578376390152, 1.99811039072191), (0.3, 2.52473552821184, 1.98256005803073),
        (0.6, 2.3707963267949, 1.92297663892336), (0.9, 2.00668622114896, 1.77288520139354),
        (0.99, 1.71186368659156, 1.63948492778588))
for options, within in (("", 1e-6), (", tolerance: 1.0e-10", 1e-9)):
    optical = []
    for h, opl, length in LENS:
        ray = report("luneburg", luneburg([-2, h, 0], [1, 0, 0], options))
        enter, leave = ray["steps"][:2]
        x = math.sqrt(1 - h * h)
        name = f"Luneburg {h}{options}"
        checks.close(name + " in", enter["position"], [-x, h, 0], abs=within)
        checks.close(name + " out", leave["position"], [1, 0, 0], abs=within)
        checks.close(name + " direction", leave["direction"], [x, -h, 0], abs=within)
        checks.close(name + " length", leave["length"], length, abs=within)
        outside = ray["path_length"] - leave["length"]
        checks.close(name + " optical", ray["optical_path"] - outside, opl, abs=within)
        # Malus and Dupin: the same from the plane x = -1 for every ray.
        optical.append(opl + 1 - x)
        back = [-c for c in leave["direction"]]
        start = [p - c for p, c in zip(leave["position"], back)]
        reverse = report("luneburg-back", luneburg(start, back, options))
        checks.close(name + " sent back", reverse["steps"][1]["position"], enter["position"],
                     abs=10 * within)
        checks.close(name + " sent back", reverse["steps"][1]["direction"], [-1, 0, 0],
                     abs=10 * within)
    checks.close("Malus-Dupin", optical, [1 + math.pi / 2] * len(optical), abs=within)

# Planes across the rod with the rod's medium on both sides show where the light is.
PLANES = (5, 15, 30, 62.8, 150)


def rod(x0, angle, options=""):
    a = math.radians(angle)
    planes = "".join(f"  - {{name: p{k}, geometry: plane, at: [0, 0, {z}], surface: fresnel, "
                     f"front: rod, back: rod}}\n" for k, z in enumerate(PLANES))
    return (HEAD.format("mm") + f"""media:
  air: {{index: 1}}
  rod: {{gradient: {{type: parabolic, n0: 1.5, alpha: 0.1, frame: world{options}}}}}
geometries: {{side: {{type: cylinder, radius: 8, length: 162}}, plane: {{type: disc, radius: 8}}}}
objects:
  - {{name: side, geometry: side, at: [0, 0, -1], surface: absorber, outside: air, inside: rod}}
  - {{name: first, geometry: plane, at: [0, 0, -1], surface: absorber, front: rod, back: air}}
  - {{name: last, geometry: plane, at: [0, 0, 161], surface: absorber, front: air, back: rod}}
""" + planes + "sources:\n" + source([x0, 0, 0], [math.sin(a), 0, math.cos(a)], "rod"))


ROD = ((1, 0, (0.876372150436984, 0.0631974605293906, -0.992012161965272, 0.999595264240583,
               -0.806613576367208), -0.0594056877884365),
       (1, 5, (1.29457210922336, 0.923205796200586, -0.893924883913572, 1.04417879924206,
               -0.367826741470131), -0.128278993505032),
       (0, 10, (0.844243183566266, 1.73451025903586, 0.16525848993265, 0.16245966660496,
                0.796574237672354), -0.156679978894951),
       (3, -3, (2.34600726077311, -0.510616119990987, -2.99613072110493, 2.70598031083917,
                -2.97893556609494), 0.0642990232584499))
for options, within in (("", 1e-8), (", tolerance: 1.0e-9", 1e-10)):
    for x0, angle, places, slope in ROD:
        ray = report("rod", rod(x0, angle, options))
        Tz = 1.5 * math.sqrt(1 - 0.01 * x0 * x0) * math.cos(math.radians(angle))
        for step, z, x in zip(ray["steps"], PLANES, places):
            name = f"rod {x0} {angle}{options} at {z}"
            checks.close(name, step["position"], [x, 0, z], abs=1e-6)
            n = 1.5 * math.sqrt(1 - 0.01 * step["position"][0] ** 2)
            checks.close(name + " Tz", n * step["direction"][2], Tz, abs=within)
        d = ray["steps"][len(PLANES) - 1]["direction"]
        checks.close(f"rod {x0} {angle}{options} slope", d[0] / d[2], slope, abs=1e-6)


def bending(ray):
    """Arc seconds between the start's direction, in `ray`, and the end's."""
    a, b = ray
    cross = math.hypot(a[0] * b[2] - a[2] * b[0], a[0] * b[1] - a[1] * b[0],
                       a[1] * b[2] - a[2] * b[1])
    return math.degrees(math.atan2(cross, sum(p * q for p, q in zip(a, b)))) * 3600


def upward(zenith):
    return [math.sin(math.radians(zenith)), 0, math.cos(math.radians(zenith))]


def exponential_air(zenith):
    return (HEAD.format("m") + """media:
  space: {index: 1}
  air: {gradient: {type: exponential, refractivity: 2.8e-4, scale_height: 8000, radius: 6371000}}
geometries: {top: {type: sphere, radius: 6571000}}
objects:
  - {name: top, geometry: top, surface: fresnel, outside: space, inside: air}
sources:
""" + source([0, 0, 6371000], upward(zenith), "air"))


for zenith, want in ((0, 0), (45, 57.617982558566), (60, 99.5785143984546), (75, 212.094134659877),
                     (85, 590.120111434127), (90, 2263.57137944343)):
    ray = report("exponential", exponential_air(zenith))
    checks.close(f"exponential atmosphere {zenith}",
                 bending((upward(zenith), ray["steps"][-1]["direction"])), want, rel=1e-5, abs=1e-3)

# n = 1 + c1 q^(gamma - 1) - c2 q^(delta - 1), q = 1 - alpha (r - r0) / T0, and its derivative
Q = "(1 - 0.0065 * (r - 6378120) / 280.15)"
C1, C2, GAMMA, DELTA = 0.000283391188170501, 6.67531344908129e-07, 5.24610431095467, 18.36
INDEX = f"1 + {C1} * {Q}^{GAMMA - 1} - {C2} * {Q}^{DELTA - 1}"
SLOPE = (f"(-0.0065 / 280.15) * ({C1 * (GAMMA - 1)} * {Q}^{GAMMA - 2} "
         f"- {C2 * (DELTA - 1)} * {Q}^{DELTA - 2})")


def layered_air(zenith):
    slope = ", ".join(f"'{SLOPE} * {axis} / r'" for axis in "xyz")
    # The model ends at 80 km: light goes on as it is there.
    top = 1 + 0.00008109263451 * math.exp(-0.000163430040839709 * 69000)
    return (HEAD.format("m") + f"""media:
  space: {{index: {top!r}}}
  low: {{gradient: {{type: formula, formula: '{INDEX}', slope: [{slope}], tolerance: 1.0e-3}}}}
  high: {{gradient: {{type: exponential, refractivity: 0.00008109263451,
    scale_height: {1 / 0.000163430040839709!r}, radius: 6389120, tolerance: 1.0e-3}}}}
geometries: {{top: {{type: sphere, radius: 6458120}}, tropopause: {{type: sphere, radius: 6389120}}}}
objects:
  - {{name: tropopause, geometry: tropopause, surface: fresnel, outside: high, inside: low}}
  - {{name: top, geometry: top, surface: fresnel, outside: space, inside: high}}
sources:
""" + source([0, 0, 6378120], upward(zenith), "low"))


# What is published is rounded, and of one program more among several: 4e-4.
STARS = ((10, 10.27, 10.2690320738269), (45, 58.16, 58.1742169194543), (60, 100.51, 100.532672982218),
         (74, 200.35, 200.383141832345), (80, 319.13, 319.192855891476),
         (85, None, 591.912274058208), (90, None, 2046.00837585128))
for zenith, published, want in STARS:
    ray = report("layers", layered_air(zenith))
    got = bending((upward(zenith), ray["steps"][-1]["direction"]))
    checks.close(f"refraction {zenith}", got, want, rel=1e-6)
    if published:
        checks.close(f"refraction {zenith}, published", got, published, rel=4e-4)
checks.finish()
