#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Fresnel's equations at single surfaces and plates, counted in a million rays per case.

Light is not polarised here: each surface reflects R = (Rs + Rp) / 2, so a clear plate passes
(1 - R) / (1 + R) and an absorbing one, with single-pass transmittance a,
T = (1 - R)^2 a / (1 - R^2 a^2) (Born & Wolf, 7th ed., 1.5.2; geometric series of the two faces).
Every comparison is a binomial z-score of at most 4. The equations themselves are held to 1e-12
in tests/unit.
"""
import math

from raymap import Checks, count, drop, many, rays, trace

checks = Checks()
RAYS = many(400_000)


def beams(angles, geometry, media, objects, inside="air"):
    """One beam per angle of incidence on plates that lie side by side along x, 100 apart."""
    text = f"""raymap: 1
units: mm
spectrum: {{mode: spectral, wavelengths: [587.56]}}
media:
  air: {{index: 1}}
{media}surfaces:
  bare: {{type: fresnel}}
  black: {{type: absorber}}
geometries:
{geometry}objects:
"""
    sources = "sources:\n"
    for k, angle in enumerate(angles):
        x, s, c = 100 * k, math.sin(math.radians(angle)), math.cos(math.radians(angle))
        text += objects.format(k=k, x=x)
        # From 1 mm above the face, towards its centre.
        sources += (f"  - {{name: beam{k}, type: rays, flux: 1 W, medium: {inside}, rays: [{{origin: "
                    f"[{x}, {-s / c!r}, -1], direction: [0, {s!r}, {c!r}], wavelength: 587.56}}]}}\n")
    return text + sources


FACE = """  - {{name: face{k}, geometry: face, at: [{x}, 0, 0], surface: bare, front: {back}, back: {front}}}
"""


def reflectance(n1, n2, degrees):
    """(Rs, Rp) of a dielectric face, Born & Wolf 1.5.2 (21)."""
    ci = math.cos(math.radians(degrees))
    ct = math.sqrt(1 - (n1 / n2) ** 2 * (1 - ci * ci))
    rs = (n1 * ci - n2 * ct) / (n1 * ci + n2 * ct)
    rp = (n2 * ci - n1 * ct) / (n2 * ci + n1 * ct)
    return rs * rs, rp * rp


def single_faces(name, cases):
    """cases: (n1, n2, angle, published R). The face is a disc; light leaves either side."""
    for n1, n2, angle, want in cases:
        objects = FACE.replace("{back}", "far").replace("{front}", "near")
        text = beams([angle], "  face: {type: disc, radius: 20}\n",
                     f"  near: {{index: {n1}}}\n  far: {{index: {n2}}}\n", objects, "near")
        target = trace(name, text, RAYS)
        (reflected, passed), total = rays(target, "hit(face0, reflect_specular)",
                                          "hit(face0, transmit_specular)")
        checks.true("every ray is reflected or refracted", reflected + passed == total == RAYS)
        checks.share(f"R from {n1} into {n2} at {angle}", reflected, total, want)
        drop(target)


def check_single_surfaces():
    # Normal incidence: R = ((n - 1) / (n + 1))^2.
    normal = {1.5: 0.04, 1.5168: 0.0421645625945458, 2.4: 0.169550173010381, 1.333: 0.0203731878419714}
    single_faces("normal", [(1, n, 0, r) for n, r in normal.items()])
    # mitsuba3 src/render/tests/test_fresnel.py (BSD-3): amplitudes at 45 degrees into 1.5 and at 10
    # degrees out of it; R = (rs^2 + rp^2) / 2.
    single_faces("oblique", [
        (1, 1.5, 45, 0.050239911012236),
        (1.5, 1, 10, (0.20949431963852 ** 2 + 0.190467971977794 ** 2) / 2)])
    # Brewster's angle, atan n: Rp = 0, so R = Rs / 2 (test_mueller.py gives 0.0739645).
    single_faces("brewster", [(1, 1.5, 56.3099324740202, 0.14792899408284 / 2)])


PLATE = """  - {{name: front{k}, geometry: face, at: [{x}, 0, 0], surface: bare, front: glass, back: air}}
  - {{name: back{k}, geometry: face, at: [{x}, 0, 0.1], surface: bare, front: air, back: glass}}
"""


def check_plate_ghosts():
    """A plate of n = 1.5168 at normal incidence: every order of the series, r = R of one face."""
    text = beams([0], "  face: {type: disc, radius: 20}\n", "  glass: {index: 1.5168}\n", PLATE)
    target = trace("plate-ghosts", text, RAYS)
    orders = {1: 0.0421645625945458, 3: 0.0386838241988607, 5: 6.8774049957613e-05}
    transmitted = {2: 0.917448725149698, 4: 0.00163108652682927}
    # A ray with 2 m + 1 legs before it left came back; with 2 m it went through.
    wanted = [(f"segments == {legs + 1}", share) for legs, share in {**orders, **transmitted}.items()]
    found, total = rays(target, *[c for c, _ in wanted], "ended(left) and hit(back0) and "
                        "hit(back0, transmit_specular)", "not hit(back0, transmit_specular)")
    for (criterion, share), matched in zip(wanted, found):
        checks.share(f"plate, {criterion}", matched, total, share)
    checks.share("plate, transmitted", found[-2], total, 0.919082716668903)
    checks.share("plate, reflected", found[-1], total, 0.080917283331097)
    checks.true("nothing is lost", found[-1] + found[-2] == total)
    drop(target)


def check_slab_over_angle():
    """Clear slab, n = 1.52, all internal reflections (geometry of CIE 171:2006 test case 5.5):
    T = (1 - R) / (1 + R)."""
    angles = [0, 15, 30, 45, 60, 75, 80]
    published = [0.918318028032866, 0.918165048528813, 0.915445528130436, 0.899253649348101,
                 0.830692596136012, 0.591450262984577, 0.437866347771944]
    text = beams(angles, "  face: {type: disc, radius: 40}\n", "  glass: {index: 1.52}\n", PLATE)
    target = trace("slab", text, RAYS * len(angles) // 2)
    answers = count(target, *[f"source(beam{k}) and hit(back{k}, transmit_specular)"
                              for k in range(len(angles))])
    for k, (angle, want) in enumerate(zip(angles, published)):
        r = sum(reflectance(1, 1.52, angle)) / 2
        checks.close(f"slab at {angle}: the formula", (1 - r) / (1 + r), want, abs=1e-10)
        emitted = answers[k]["rays"]["total"] / len(angles)
        checks.share(f"slab at {angle}", answers[k]["rays"]["matched"], round(emitted), want)
    drop(target)


def check_absorbing_plate():
    """n = 1.5, 0.5 per mm, 2 mm: Fresnel and Beer-Lambert together. At normal incidence the
    published closed form; at 45 and 70 degrees the same series with the unpolarised R."""
    plate = PLATE.replace("0.1]", "2]")
    angles = [0, 45, 70]
    text = beams(angles, "  face: {type: disc, radius: 40}\n",
                 "  glass: {index: 1.5, absorption: 0.5}\n", plate)
    target = trace("absorbing", text, RAYS * len(angles))
    criteria = []
    for k in range(len(angles)):
        criteria += [f"source(beam{k}) and hit(back{k}, transmit_specular)",
                     f"source(beam{k}) and ended(left) and not hit(back{k}, transmit_specular)",
                     f"source(beam{k}) and ended(absorbed, glass)"]
    found, total = rays(target, *criteria)
    for k, angle in enumerate(angles):
        r = sum(reflectance(1, 1.5, angle)) / 2
        cos_t = math.sqrt(1 - (math.sin(math.radians(angle)) / 1.5) ** 2)
        a = math.exp(-0.5 * 2 / cos_t)
        passed = (1 - r) ** 2 * a / (1 - (r * a) ** 2)
        back = r + r * (1 - r) ** 2 * a * a / (1 - (r * a) ** 2)
        if angle == 0:
            checks.close("absorbing plate, published T", passed, 0.339111122903388, abs=1e-10)
            checks.close("absorbing plate, published R", back, 0.0449900804155488, abs=1e-10)
        emitted = total // len(angles)
        for what, matched, want in zip(("T", "R", "A"), found[3 * k:3 * k + 3],
                                       (passed, back, 1 - passed - back)):
            checks.share(f"absorbing plate at {angle}, {what}", matched, emitted, want)
        checks.true("nothing is lost", sum(found[3 * k:3 * k + 3]) == emitted)
    drop(target)


check_single_surfaces()
check_plate_ghosts()
check_slab_over_angle()
check_absorbing_plate()
checks.finish()
