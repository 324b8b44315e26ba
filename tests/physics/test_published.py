#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Published numbers of turbid media and of lamps, each within four standard errors (names of cases as in the corpus).

VOL-01 slab, matched index, albedo 0.9, g = 0.75, tau 2: van de Hulst 1980, vol. 2, table 35 (R 0.09739, T 0.66096)
VOL-02 half space of n = 1.5, albedo 0.9, isotropic: Giovanelli 1955 (0.2600 with the 4 % of the face)
VOL-07 half space, matched, isotropic: Chandrasekhar 1950, R = 1 - sqrt(1 - a) H(1)
VOL-10 a walk in endless medium: <z> and <r^2> of n free flights, from <u_i u_j> = g^|i - j|, <s^2> = 2
VOL-13 a slab that absorbs nothing: R + T = 1 to the ray; T by reciprocity the same from either side of a layered one
RAD-04 CIE 171 TC 5.6: light that a floor reflects to the ceiling, by the configuration factor
RAD-18 a downlight's IES file (ITL78222): 531.98 lm by zones, illuminance by the inverse square
RAD-24 an isotropic point source over a plane
"""
import math
import re

import numpy

from raymap import Checks, columns, drop, many, rays, run, some, trace

checks = Checks()


def slab(index, absorption, scattering, g, depth, ends="clear", steps=100000):
    return f"""raymap: 1
units: cm
spectrum: {{wavelengths: [550]}}
limits: {{steps: {steps}}}
media: {{air: {{index: 1}}, fog: {{index: {index}, absorption: {absorption!r}, scattering: {scattering!r}, scattering_g: {g}}}}}
surfaces: {{clear: {{type: fresnel}}, black: {{type: absorber}}}}
geometries: {{face: {{type: rectangle, size: [1e5, 1e5]}}}}
objects:
  - {{name: top, geometry: face, surface: clear, front: air, back: fog}}
  - {{name: bottom, geometry: face, at: [0, 0, {-depth!r}], surface: {ends}, front: fog, back: air}}
sources: [{{name: s, type: rays, flux: 1 W, medium: air, rays: [{{origin: [0, 0, 1], direction: [0, 0, -1], wavelength: 550}}]}}]
"""


def check_slabs():
    target = trace("hulst", slab(1, 10, 90, 0.75, 0.02), many(50_000))
    (back, through, straight), n = rays(target, "hit(top) >= 2", "hit(bottom)", "hit(bottom) and not event(scatter_volume)")
    checks.share("VOL-01 R", back, n, 0.0973946387)
    checks.share("VOL-01 T", through, n, 0.6609577002)
    checks.share("VOL-01 unscattered", straight, n, math.exp(-2))
    drop(target)
    target = trace("giovanelli", slab(1.5, 10, 90, 0, 2), many(30_000))
    (left, face, through), n = rays(target, "ended(left)", "path(\"R@top .*\")", "hit(bottom)")
    checks.share("VOL-02 R", left, n, 0.259919)
    checks.share("VOL-02 face", face, n, 0.04)
    checks.true("VOL-02 is deep enough", through == 0)
    drop(target)
    for albedo, want in some(((0.3, 0.057214350601), (0.5, 0.115225877707), (0.8, 0.285254502717), (0.9, 0.41494747913), (0.95, 0.535540989171),
                              (0.99, 0.75272071716)), 1, 4):
        target = trace("half", slab(1, 1 - albedo, albedo, 0, 300, "black"), many(30_000))
        (left,), n = rays(target, "ended(left)")
        checks.share(f"VOL-07 R of albedo {albedo}", left, n, want)
        drop(target)


def check_conservative():
    for index, g, tau in some(((index, g, tau) for index in (1, 1.5) for g in (0, 0.9) for tau in (0.5, 5, 50)), 1, 9, 8):
        n = 3000 if tau < 50 else 400
        target = trace("white", slab(index, 0, tau / (1 - g), g, 1 - g), n)
        (left, absorbed, reflected), total = rays(target, "ended(left)", "ended(absorbed)", "ended(left) and not hit(bottom, transmit)")
        checks.true(f"VOL-13 n {index}, g {g}, tau {tau}: {left} of {total} leave, {reflected} in front",
                    left == total == n and absorbed == 0 and 0 < reflected < n)
        drop(target)
    # Two layers: what gets through does not depend on the side, of Lambertian light (Helmholtz reciprocity).
    layers = """raymap: 1
units: cm
spectrum: {wavelengths: [550]}
media: {air: {index: 1}, milk: {index: 1.4, scattering: 5, scattering_g: 0.6}, haze: {index: 1.2, scattering: 0.7}}
surfaces: {clear: {type: fresnel}}
geometries: {face: {type: rectangle, size: [1e5, 1e5]}}
objects:
  - {name: top, geometry: face, at: [0, 0, 1], surface: clear, front: air, back: milk}
  - {name: middle, geometry: face, surface: clear, front: milk, back: haze}
  - {name: bottom, geometry: face, at: [0, 0, -1], surface: clear, front: haze, back: air}
sources:
  - {name: up, type: area, shape: {disc: 1}, at: [0, 0, -1.5], flux: 1 W, medium: air}
  - {name: down, type: area, shape: {disc: 1}, at: [0, 0, 1.5], direction: [0, 0, -1], flux: 1 W, medium: air}
"""
    target = trace("layers", layers, many(40_000))
    (up, down), n = rays(target, "source(up) and hit(top, transmit)", "source(down) and hit(bottom, transmit)")
    share = (up + down) / n
    checks.z("VOL-13 reciprocity", (up - down) / (n / 2), 0, math.sqrt(4 * share * (1 - share) / n))
    drop(target)


def check_walk():
    """With limits of n steps a ray ends after n free flights; a row more is the leg that would follow."""
    for g, means in some(((0, {1: (1, 2), 5: (1, 10), 50: (1, 100)}), (0.5, {1: (1, 2), 5: (1.9375, 16.125), 50: (2, 196)}),
                          (0.9, {1: (1, 2), 5: (4.0951, 26.2882), 50: (9.9484622479268, 820.927679537318)})), 0, 2):
        scene = f"""raymap: 1
units: cm
spectrum: {{wavelengths: [550]}}
limits: {{steps: 50}}
media: {{fog: {{index: 1, scattering: 1, scattering_g: {g}}}}}
surfaces: {{black: {{type: absorber}}}}
geometries: {{ball: {{type: sphere, radius: 1e6}}}}
objects: [{{name: shell, geometry: ball, surface: black, inside: fog}}]
sources: [{{name: s, type: rays, flux: 1 W, medium: fog, rays: [{{origin: [0, 0, 0], direction: [0, 0, 1], wavelength: 550}}]}}]
"""
        target = trace("walk", scene, many(8000), encoding="plain")
        count, place = columns(target, "/ray/segment_count", "/segment/position")
        checks.true(f"VOL-10 g {g}: 50 flights each", (count == 50).all())
        place = place.reshape(len(count), 50, 3).astype(float)
        for n, (z, r2) in means.items():
            end = place[:, n - 1]
            for what, values, want in (("z", end[:, 2], z), ("r^2", (end ** 2).sum(axis=1), r2)):
                checks.z(f"VOL-10 g {g}, {n} flights, mean {what}", values.mean(), want, values.std() / math.sqrt(len(values)))
        drop(target)


def check_floor():
    """Each of 8 x 8 cells of the ceiling against the configuration factor of the floor, averaged over the cell."""
    scene = """raymap: 1
units: m
spectrum: {mode: rgb}
media: {air: {index: 1}}
surfaces: {grey: {type: lambert, reflectance: 0.3}, black: {type: absorber}}
geometries: {floor: {type: rectangle, size: [4, 4]}}
objects:
  - {name: floor, geometry: floor, surface: {front: grey, back: black}, front: air}
  - {name: ceiling, geometry: floor, at: [0, 0, 3], rotate: [180, 0, 0], surface: black, front: air}
sources: [{name: sun, type: collimated, shape: {rectangle: [4, 4]}, at: [0, 0, 2.99], direction: [0, 0, -1], medium: air, flux: 16 lm}]
detectors: [{name: seen, type: plane, on: ceiling, at: [0, 0, 3], size: [4, 4], cells: [8, 8]}]
"""
    nodes, weights = numpy.polynomial.legendre.leggauss(24)
    floor = numpy.stack(numpy.meshgrid(2 * nodes, 2 * nodes), axis=-1).reshape(-1, 2)
    area = 4 * numpy.outer(weights, weights).reshape(-1)

    def factor(x, y):
        d2 = ((floor - [x, y]) ** 2).sum(axis=1) + 9
        return (area * 9 / (math.pi * d2 ** 2)).sum()

    printed = {0.25: 26.8, 0.75: 30.94, 1.25: 33.98, 1.75: 35.57}  # CIE 171, table 17: x = 2 m
    for y, percent in printed.items():
        checks.close(f"RAD-04 factor at {y}", 100 * factor(0, y - 2), percent, rel=1e-3)
    n = many(120_000)
    target = trace("floor", scene, n)
    found, _ = rays(target, *[f"registered(seen, cells({i}..{i}, {j}..{j}))" for j in range(8) for i in range(8)])
    inside, w = numpy.polynomial.legendre.leggauss(3)
    square = 0.0
    for k, got in enumerate(found):
        x, y = (k % 8 - 3.5) / 2, (k // 8 - 3.5) / 2
        want = 0.3 / 64 * sum(a * b / 4 * factor(x + u / 4, y + v / 4) for u, a in zip(inside, w) for v, b in zip(inside, w))
        square += (got - n * want) ** 2 / (n * want * (1 - want))
    checks.z("RAD-04 chi-square of 64 cells", square, 64, math.sqrt(2 * 64))
    drop(target)


CANDELA = [269, 268, 266, 264, 260, 256, 251, 245, 237, 229, 221, 211, 200, 189, 177, 165, 152, 140, 127, 114, 102, 90, 79, 68, 58, 48, 39, 31, 24,
           17, 12, 8, 6, 4, 3, 1, 0]


def over_plane(name, source, places, intensity, flux, n):
    """Light in discs of 0.5 m on a plane 3 m below, against I cos^3 / h^2 averaged over each."""
    target = trace(name, f"""raymap: 1
units: m
spectrum: {{mode: rgb}}
media: {{air: {{index: 1}}}}
surfaces: {{black: {{type: absorber}}}}
geometries: {{floor: {{type: rectangle, size: [20, 20]}}}}
objects: [{{name: floor, geometry: floor, surface: black, front: air}}]
sources: [{source}]
detectors: [{{name: lit, type: plane, on: floor, size: [20, 20], cells: [4, 4]}}]
""", n)
    found, total = rays(target, *[f"registered(lit, ellipse({x}, 0, 0.5, 0.5))" for x in places])
    drop(target)
    rho, turn = (numpy.arange(40) + 0.5) / 40, (numpy.arange(60) + 0.5) / 60 * 2 * math.pi
    r, phi = numpy.meshgrid(0.5 * numpy.sqrt(rho), turn)
    for x, got in zip(places, found):
        d2 = (x + r * numpy.cos(phi)) ** 2 + (r * numpy.sin(phi)) ** 2 + 9
        lux = (intensity(numpy.degrees(numpy.arccos(3 / numpy.sqrt(d2)))) * 3 / d2 ** 1.5).mean()
        checks.share(f"{name} at {x} m", got, total, lux * math.pi * 0.25 / flux)


def check_lamps():
    angles = [2.5 * k for k in range(37)]
    with open("rab.ies", "w", encoding="ascii") as file:
        file.write("IESNA:LM-63-2002\n[TEST] ITL78222\n[MANUFAC] RAB\nTILT=NONE\n1 -1 1 37 1 1 2 0 0 0\n1 1 10\n"
                   + " ".join(map(str, angles)) + "\n0\n" + " ".join(map(str, CANDELA)) + "\n")
    source = "{name: lamp, type: lamp, file: rab.ies, at: [0, 0, 3], rotate: [180, 0, 0], emitter: point}"
    fine = numpy.radians(numpy.linspace(0, 90, 36001))
    ring = 2 * math.pi * numpy.sin(fine) * numpy.interp(numpy.degrees(fine), angles, CANDELA)
    flux = ((ring[1:] + ring[:-1]) / 2 * numpy.diff(fine)).sum()
    checks.close("RAD-18 linear in angle", flux, 531.800585134251, rel=1e-6)
    over_plane("RAD-18", source, (0, 1, 2, 4), lambda gamma: numpy.interp(gamma, angles, CANDELA), flux, many(150_000))
    told = float(re.search(r"source lamp: ([\d.]+) lm", run("check", "RAD-18.yaml")).group(1))
    checks.close("RAD-18 lumens by zones", told, 531.98, rel=2e-3)
    checks.close("RAD-18 lumens, linear in angle", told, flux, rel=5e-5)
    point = "{name: s, type: point, at: [0, 0, 3], flux: 10000 lm, medium: air}"
    over_plane("RAD-24", point, (0, 1, 2, 3, 4, 5), lambda gamma: 10000 / (4 * math.pi) + 0 * gamma, 10000, many(150_000))


check_slabs()
check_conservative()
check_walk()
check_floor()
check_lamps()
checks.finish()
