#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Thin films on plates, counted in a million rays per case, and the double bounce that films are there for.

A plate whose entrance face has a film (R1, either way) and whose exit face is bare (R2) passes, all bounces added without
interference, T = (1 - R1)(1 - R2) / (1 - R1 R2); light is not polarised, so each R is (Rs + Rp) / 2. Those of the film: a
quarter wave of 1.38 at 550 nm on 1.52 (Macleod, Thin-Film Optical Filters; computed). The films themselves are held to 1e-12
in tests/unit.
"""
import json
import math

from raymap import Checks, count, drop, many, run, rays, trace, write_scene

checks = Checks()
RAYS = many(400_000)
PLATE = """raymap: 1
units: mm
spectrum: {{wavelengths: [550]}}
media: {{air: {{index: 1}}, glass: {{index: {n}}}}}
films:
  ar: {{reference: 550, layers: [{{n: 1.38, quarter: 1}}]}}
  dark: {{layers: [{{n: 2.4, k: 3.3, thickness: 8 nm}}, {{n: 1.46, thickness: 85 nm}}]}}
surfaces:
  one: {{type: fresnel{one}}}
  two: {{type: fresnel{two}}}
geometries:
  face: {{type: rectangle, size: [1000, 1000]}}
objects:
  - {{name: entrance, geometry: face, at: [0, 0, 0], rotate: [180, 0, 0], surface: one, outside: air, inside: glass}}
  - {{name: exit, geometry: face, at: [0, 0, 5], surface: two, outside: air, inside: glass}}
sources:
  - {{name: s, type: rays, flux: 1 W, medium: air, rays: [{{origin: [0, 0, -1], direction: [0, {s!r}, {c!r}], wavelength: 550}}]}}
"""


def plate(n, one, two, degrees=0):
    angle = math.radians(degrees)
    return PLATE.format(n=n, one=one and f", coat: {{film: {one}}}", two=two and f", coat: {{film: {two}}}",
                        s=math.sin(angle), c=math.cos(angle))


def bare(n, degrees):
    c = math.cos(math.radians(degrees))
    t = math.sqrt(1 - (1 - c * c) / n ** 2)
    return (((c - n * t) / (c + n * t)) ** 2 + ((n * c - t) / (n * c + t)) ** 2) / 2


def check_coated_plate():
    film = {0: (0.0126007902146303, 0.0126007902146303), 30: (0.0206357526841605, 0.00701741609757578),
            60: (0.100818426939448, 0.00604933794797111)}
    for degrees, (rs, rp) in film.items():
        r1, r2 = (rs + rp) / 2, bare(1.52, degrees)
        passed = (1 - r1) * (1 - r2) / (1 - r1 * r2)
        target = trace("plate", plate(1.52, "ar", "", degrees), RAYS)
        (back, through), total = rays(target, "ended(left) and not hit(exit, transmit_specular)",
                                      "hit(exit, transmit_specular)")
        checks.share(f"T of the plate at {degrees}", through, total, passed)
        checks.true("every ray comes back or goes through", back + through == total)
        if degrees == 0:
            checks.close("T straight on, as published", passed, 0.945863251375257, abs=1e-12)
        drop(target)


def check_ghost():
    """The light that bounces back and forth once in a plate of 1.5168: R^2, bare and with a film on either face."""
    for film, want in (("", ((1.5168 - 1) / (1.5168 + 1)) ** 4), ("ar", 1.648e-4)):
        target = trace("ghost", plate(1.5168, film, film), RAYS)
        once = math.sqrt(want)
        (twice,), total = rays(target, 'path("T@entrance R@exit R@entrance T@exit .*")')
        checks.share(f"double bounce, film '{film}'", twice, total, want * (1 - once) ** 2)
        drop(target)


def check_absorbing():
    """What is traced is what `check --surface` says, from either side."""
    text = plate(1.52, "dark", "")
    told = json.loads(run("check", write_scene("dark", text), "--surface", "one", "--json"))["surface"]
    side = told["sides"][0]
    assert (side["from"], side["into"]) == ("air", "glass"), told
    target = trace("dark", text, RAYS)
    (first,), total = rays(target, 'path("R@entrance .*")')
    checks.share("reflected by an absorbing film", first, total, side["by_angle"]["reflect_specular"][0])
    (first,), total = rays(target, "segments == 1 and ended(absorbed, entrance)")
    checks.share("absorbed in it", first, total, side["by_angle"]["absorb"][0])
    back = told["sides"][1]["by_angle"]
    (exit_r, again), _ = rays(target, 'path("T@entrance R@exit .*")', 'path("T@entrance R@exit R@entrance .*")')
    checks.share("reflected from behind", again, exit_r, back["reflect_specular"][0])
    passed = side["by_angle"]["transmit_specular"]
    checks.true("as much passes either way", abs(passed[0] - back["transmit_specular"][0]) < 1e-12)
    drop(target)


RGB = """raymap: 1
units: mm
spectrum: {mode: rgb, coatings: %s}
media: {air: {index: 1}, glass: {index: 1.52}}
films: {ar: {reference: 550, layers: [{n: 1.38, quarter: 1}]}}
surfaces:
  metal: {type: mirror, metal: {table: {wavelength: [445, 535, 640], n: [1.5, 0.6, 0.2], k: [1.9, 2.1, 3.4]}}}
  coated: {type: fresnel, coat: {film: ar}}
geometries: {face: {type: rectangle, size: [1000, 1000]}}
objects:
  - {name: mirror, geometry: face, at: [0, 0, 5], rotate: [180, 0, 0], surface: metal, front: air, back: air}
  - {name: plate, geometry: face, at: [0, 0, -20], surface: coated, outside: air, inside: glass}
sources:
  - {name: red, type: collimated, shape: {disc: 1}, flux: 1 W, medium: air, spectrum: {rgb: [1, 0, 0]}}
  - {name: green, type: collimated, shape: {disc: 1}, flux: 1 W, medium: air, spectrum: {rgb: [0, 1, 0]}}
  - {name: blue, type: collimated, shape: {disc: 1}, flux: 1 W, medium: air, spectrum: {rgb: [0, 0, 1]}}
"""


def check_rgb():
    """In rgb, films and metals at the middles of the bands, where that is asked for; else alike for all colours."""
    def metal(n, k):
        return ((n - 1) ** 2 + k * k) / ((n + 1) ** 2 + k * k)

    def film(nm):  # air / 1.38, a quarter wave at 550 / 1.52, straight on (Born & Wolf 1.6.4)
        r1, r2, d = (1 - 1.38) / 2.38, (1.38 - 1.52) / 2.9, math.cos(math.pi * 550 / nm)
        return (r1 * r1 + r2 * r2 + 2 * r1 * r2 * d) / (1 + r1 * r1 * r2 * r2 + 2 * r1 * r2 * d)
    part = (587.56 - 535) / 105
    line = metal(0.6 - 0.4 * part, 2.1 + 1.3 * part), film(587.56)
    want = {"bands": {"red": (metal(0.2, 3.4), film(640)), "green": (metal(0.6, 2.1), film(535)),
                      "blue": (metal(1.5, 1.9), film(445))},
            "line": dict.fromkeys(("red", "green", "blue"), line)}
    for coatings, shares in want.items():
        target = trace("rgb", RGB % coatings, 3 * many(100_000))
        for colour, (mirror, coat) in shares.items():
            (back, again), _ = rays(target, f'source({colour}) and path("R@mirror .*")',
                                    f'source({colour}) and path("R@mirror R@plate .*")')
            (whole,), _ = rays(target, f"source({colour})")
            checks.share(f"{coatings}: {colour} reflected by the metal", back, whole, mirror)
            checks.share(f"{coatings}: {colour} reflected by the film", again, back, coat)
        drop(target)


check_coated_plate()
check_rgb()
check_ghost()
check_absorbing()
checks.finish()
