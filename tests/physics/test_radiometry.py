#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Illuminance, flux balance and view factors against closed forms and CIE 171:2006.

CIE's own tables differ from the closed forms by up to 0.03 % (interpolation of the luminaire
file), so the closed forms are what the z-scores (at most 4) compare with; cells are compared with
the closed form averaged over the cell by Gauss-Legendre quadrature. Of the corpus: RAD-01 (point source), RAD-02 (area),
RAD-03 (flux), RAD-06 (interreflections), RAD-09 and RAD-10 (view factors), RAD-12 (integrating sphere), RAD-14 (cos^4),
RAD-15 (disc and sphere), RAD-16 (furnace), RAD-25 (immersed emitter).
"""
import math

import numpy

from raymap import Checks, columns, count, drop, many, rays, some, trace

checks = Checks()
RAYS = many(80_000)

NODES, WEIGHTS = numpy.polynomial.legendre.leggauss(8)


def mean_over(function, x0, x1, y0, y1):
    """Mean of function(x, y) over a rectangle."""
    x = (x0 + x1) / 2 + (x1 - x0) / 2 * NODES
    y = (y0 + y1) / 2 + (y1 - y0) / 2 * NODES
    return sum(wx * wy * function(px, py) for px, wx in zip(x, WEIGHTS)
               for py, wy in zip(y, WEIGHTS)) / 4


HEAD = """raymap: 1
units: m
spectrum: {mode: rgb}
media: {air: {index: 1}}
surfaces:
  black: {type: absorber}
  mirror: {type: mirror, reflectance: 1}
"""


def flux_check(what, answer, want):
    """A matched flux against its expectation, with the standard error the query reports."""
    checks.z(what, answer["flux"]["matched"], want, answer["flux"]["standard_error"])


def check_point_source():
    """CIE 171 test case 5.2: I = 1000 cos(theta) cd from 3 m: E = 1000 cos^2 (cos) / d^2 =
    1000 h^2 / d^4 on the floor. Cells of 5 cm."""
    exact = {(0, 0): 111.111111111111, (0.5, 0): 105.18626734843, (1, 0): 90.0,
             (1.5, 0): 71.1111111111111, (0.5, 0.5): 99.7229916897507, (1, 0.5): 85.6632956573468,
             (1.5, 0.5): 68.0529300567108, (1, 1): 74.3801652892562, (1.5, 1): 59.9750104123282,
             (1.5, 1.5): 49.3827160493827}
    text = HEAD + """geometries:
  floor: {type: rectangle, size: [4, 4]}
objects:
  - {name: floor, geometry: floor, surface: black, front: air, back: air}
sources:
  - {name: lamp, type: point, at: [0, 0, 3], direction: [0, 0, -1], distribution: cosine, flux: 3141.592653589793 lm,
     spectrum: {rgb: [1, 1, 1]}, medium: air}
detectors:
  - {name: lux, type: plane, on: floor, size: [4, 4], cells: [80, 80], at: [0, 0, 0], direction: [0, 0, 1]}
"""
    target = trace("point-source", text, 2 * RAYS)

    def illuminance(x, y):
        return 1000 * 9 / (9 + x * x + y * y) ** 2

    # The four cells about each point and about its mirror images: up to 32 of 6,400 cells.
    criteria, wanted = [], []
    for (px, py), lux in exact.items():
        checks.close(f"E({px}, {py}) closed form", illuminance(px, py), lux, rel=1e-12)
        spots = {(sx * a, sy * b) for a, b in ((px, py), (py, px)) for sx in (1, -1) for sy in (1, -1)}
        cells = [(round((x + 2) / 0.05), round((y + 2) / 0.05)) for x, y in sorted(spots)]
        criteria.append(" or ".join(f"registered(lux, cells({i - 1}..{i}, {j - 1}..{j}))"
                                    for i, j in cells))
        wanted.append(len(cells) * 0.01 * mean_over(illuminance, px - .05, px + .05, py - .05, py + .05))
    for point, answer, want in zip(exact, count(target, *criteria), wanted):
        flux_check(f"lumens about {point}", answer, want)
    whole = count(target, "registered(lux)")[0]
    flux_check("lumens on the floor", whole, 16 * mean_over(illuminance, -2, 2, -2, 2))
    drop(target)


def parallel_element(a, b, h):
    """View factor from a surface element to a parallel a x b rectangle at height h with one corner
    above the element (Howell's catalogue B-3)."""
    x, y = a / h, b / h
    return (x / math.sqrt(1 + x * x) * math.atan(y / math.sqrt(1 + x * x)) +
            y / math.sqrt(1 + y * y) * math.atan(x / math.sqrt(1 + y * y))) / (2 * math.pi)


def normal_element(a, b, h):
    """From an element to a rectangle in a plane normal to the element's own: it lies h away from
    the element, begins where the planes meet, is a wide along that line and b deep; the element
    is level with a corner (Howell B-4)."""
    return (math.atan(a / h) - h / math.hypot(h, b) * math.atan(a / math.hypot(h, b))) / (2 * math.pi)


def corners(function, x0, x1, y0, y1):
    """A rectangle as a signed sum of rectangles that begin at the origin."""
    def signed(x, y):
        return math.copysign(1, x) * math.copysign(1, y) * function(abs(x), abs(y)) if x and y else 0.0
    return signed(x1, y1) - signed(x0, y1) - signed(x1, y0) + signed(x0, y0)


def check_area_source():
    """CIE 171 test case 5.3: a Lambertian square of 1 m^2, 1000 cd/m^2, in the ceiling of a black room of
    4 x 4 x 3 m; points along the middle of the floor and of a wall."""
    floor = {0.25: 61.4240985384615, 0.75: 79.2551573162312, 1.25: 95.6672763333351,
             1.75: 105.778242176294}
    wall = {2.75: 32.6768980143919, 2.25: 75.1939245662954, 1.75: 81.3231721249446,
            1.25: 69.0606270130494, 0.75: 53.4035311081542, 0.25: 40.0018520198511}
    exitance = 1000 * math.pi

    def on_floor(x, y):  # about the floor's centre
        return exitance * corners(lambda a, b: parallel_element(a, b, 3), -.5 - x, .5 - x, -.5 - y, .5 - y)

    def on_wall(x, z):  # the wall y = -2; the source runs from 1.5 to 2.5 m away from it
        def strip(a, depth):
            return normal_element(a, depth, 3 - z)
        return exitance * corners(strip, -.5 - x, .5 - x, 1.5, 2.5)

    for y, lux in floor.items():
        checks.close(f"floor {y} closed form", on_floor(0, y - 2), lux, rel=1e-9)
    for z, lux in wall.items():
        checks.close(f"wall {z} closed form", on_wall(0, z), lux, rel=1e-9)
    text = HEAD + f"""geometries:
  floor: {{type: rectangle, size: [4, 4]}}
  side: {{type: rectangle, size: [4, 3]}}
objects:
  - {{name: floor, geometry: floor, surface: black, front: air, back: air}}
  - {{name: wall, geometry: side, rotate: [-90, 0, 0], at: [0, -2, 1.5], surface: black, front: air, back: air}}
sources:
  - {{name: panel, type: area, shape: {{rectangle: [1, 1]}}, at: [0, 0, 3], direction: [0, 0, -1], flux: {exitance!r} lm,
     spectrum: {{rgb: [1, 1, 1]}}, medium: air}}
detectors:
  - {{name: floor_lux, type: plane, on: floor, size: [4, 4], cells: [40, 40], at: [0, 0, 0], direction: [0, 0, 1]}}
"""
    target = trace("area-source", text, RAYS)
    # Cells of 10 cm; (x, y) beside (0, y): two columns of cells meet there, two rows as well.
    criteria, wanted = [], []
    for y in floor:
        i, j = 20, round(y / 0.1 - 0.5)
        low = j * 0.1
        criteria.append(f"registered(floor_lux, cells({i - 1}..{i}, {j}..{j})) or "
                        f"registered(floor_lux, cells({i - 1}..{i}, {39 - j}..{39 - j}))")
        wanted.append(2 * 0.02 * mean_over(on_floor, -.1, .1, low - 2, low - 1.9))
    for y, answer, want in zip(floor, count(target, *criteria), wanted):
        flux_check(f"lumens on the floor at {y}", answer, want)
    found, total = rays(target, "hit(wall)", "hit(floor)")
    checks.share("share of the wall", found[0], total, mean_over(on_wall, -2, 2, 0, 3) * 12 / exitance)
    checks.share("share of the floor", found[1], total, mean_over(on_floor, -2, 2, -2, 2) * 16 / exitance)
    drop(target)


BOX = """geometries:
  z_face: {{type: rectangle, size: [{x}, {y}]}}
  x_face: {{type: rectangle, size: [{z}, {y}]}}
  y_face: {{type: rectangle, size: [{x}, {z}]}}
{more}objects:
  - {{name: floor, geometry: z_face, at: [0, 0, {mz}], surface: {wall}, front: air, back: air}}
  - {{name: ceiling, geometry: z_face, rotate: [180, 0, 0], at: [0, 0, {pz}], surface: {wall}, front: air, back: air}}
  - {{name: west, geometry: x_face, rotate: [0, 90, 0], at: [{mx}, 0, 0], surface: {wall}, front: air, back: air}}
  - {{name: east, geometry: x_face, rotate: [0, -90, 0], at: [{px}, 0, 0], surface: {wall}, front: air, back: air}}
  - {{name: south, geometry: y_face, rotate: [-90, 0, 0], at: [0, {my}, 0], surface: {wall}, front: air, back: air}}
  - {{name: north, geometry: y_face, rotate: [90, 0, 0], at: [0, {py}, 0], surface: {wall}, front: air, back: air}}
"""
WALLS = ("floor", "ceiling", "west", "east", "south", "north")


def box(x, y, z, wall, more=""):
    return BOX.format(x=x, y=y, z=z, mx=-x / 2, px=x / 2, my=-y / 2, py=y / 2, mz=-z / 2, pz=z / 2,
                      wall=wall, more=more)


LAMP = """sources:
  - {name: lamp, type: point, at: [0, 0, 0], distribution: isotropic, flux: 10000 lm, spectrum: {rgb: [1, 1, 1]}, medium: air}
"""


def check_flux_conservation():
    """CIE 171 test case 5.4: all of 10,000 lm arrives; each surface gets its solid angle's share,
    4 asin(a b / sqrt((a^2 + h^2)(b^2 + h^2))) / 4 pi."""
    target = trace("flux", HEAD + box(4, 4, 3, "black") + LAMP, RAYS)
    answers = count(target, *[f"ended(absorbed, {w})" for w in WALLS])
    checks.true("every ray is absorbed by a wall", sum(a["rays"]["matched"] for a in answers) == RAYS)
    checks.close("sum of fluxes", sum(a["flux"]["matched"] for a in answers), 10000, rel=1e-12)
    for wall, answer in zip(WALLS, answers):
        want = 0.221065663886429 if wall in ("floor", "ceiling") else 0.139467168056785
        checks.share(f"share of {wall}", answer["rays"]["matched"], RAYS, want)
    drop(target)


def check_interreflections():
    """CIE 171 test case 5.8: cube of 4 m, reflectance rho: the mean illuminance over all walls is
    flux / (A (1 - rho)), whatever the shape. Arrivals per ray are geometric: mean 1 / (1 - rho),
    variance rho / (1 - rho)^2. Relative error at most 0.3 % besides."""
    for rho, lux, n in some(((0.05, 109.649122807018, 150_000), (0.5, 208.333333333333, 150_000),
                             (0.8, 520.833333333333, 100_000), (0.95, 2083.33333333333, 75_000)), 0, 2):
        head = HEAD + f"  wall: {{type: lambert, reflectance: {rho}}}\n"
        n = many(n)
        target = trace("cube", head + box(4, 4, 4, "wall") + LAMP, n)
        answer = count(target, "all")[0]
        arrivals = answer["segments"]["total"] / n
        sigma = math.sqrt(rho) / (1 - rho) / math.sqrt(n)
        checks.z(f"mean illuminance, rho = {rho}", arrivals * 10000 / 96, lux, sigma * 10000 / 96)
        checks.close(f"mean illuminance, rho = {rho}, ceiling", arrivals * 10000 / 96, lux, rel=0.005 if n > 1e6 else 0.01)
        drop(target)


def check_view_factors():
    """Howell's catalogue C-41 (coaxial discs), C-11 and C-14 (rectangles): the share of a
    Lambertian emitter's light that meets the other surface."""
    discs = [(0.2, 0.2, 1, 0.0370879821637402), (0.5, 0.5, 1, 0.17157287525381),
             (1, 1, 1, 0.381966011250105), (2, 2, 1, 0.609611796797792),
             (1, 0.5, 2, 0.048058983988962)]
    parallel = [(1, 1, 0.199824895698387), (2, 2, 0.415253283577147), (0.5, 1, 0.116653691803623),
                (2, 1, 0.285875384850715)]
    upright = [(1, 1, 0.200043776075403), (2, 1, 0.232852602795362), (1, 2, 0.116426301397681),
               (0.5, 1, 0.146186679105713)]
    # Thirteen pairs side by side, 1000 apart, in one scene.
    geometries, objects, sources, wanted = "geometries:\n", "objects:\n", "sources:\n", []

    def pair(emitter, receiver, at, rotate, share):
        nonlocal geometries, objects, sources
        k = len(wanted)
        geometries += f"  g{k}: {receiver}\n"
        objects += (f"  - {{name: receiver{k}, geometry: g{k}, rotate: {rotate}, "
                    f"at: [{1000 * k + at[0]}, {at[1]}, {at[2]}], surface: black, front: air, back: air}}\n")
        sources += (f"  - {{name: emitter{k}, type: area, shape: {emitter}, at: [{1000 * k}, 0, 0], "
                    "direction: [0, 0, 1], flux: 1 lm, spectrum: {rgb: [1, 1, 1]}, medium: air}\n")
        wanted.append(share)

    for r1, r2, gap, share in discs:
        pair(f"{{disc: {r1}}}", f"{{type: disc, radius: {r2}}}", (0, 0, gap), [0, 0, 0], share)
    for x, y, share in parallel:
        pair(f"{{rectangle: [{x}, {y}]}}", f"{{type: rectangle, size: [{x}, {y}]}}", (0, 0, 1), [0, 0, 0],
             share)
    for height, width, share in upright:  # emitter 1 x width; receiver 1 high along its edge y = width / 2
        pair(f"{{rectangle: [1, {width}]}}", f"{{type: rectangle, size: [1, {height}]}}",
             (0, width / 2, height / 2), [90, 0, 0], share)
    n = many(30_000) * len(wanted)
    target = trace("view-factors", HEAD + geometries + objects + sources, n)
    found, _ = rays(target, *[f"source(emitter{k}) and hit(receiver{k})" for k in range(len(wanted))])
    for k, (matched, share) in enumerate(zip(found, wanted)):
        checks.share(f"view factor {k}", matched, n // len(wanted), share)
    drop(target)


def check_integrating_sphere():
    """Goebel, Appl. Opt. 6, 125 (1967): a sphere with a black port of area share f = 0.01, first
    strike on the wall: port signal rho f / (1 - rho (1 - f)), the wall absorbs the rest. The
    port is a disc across the cap that it closes off: no light gets behind it."""
    signal = {0.5: 0.0099009900990099, 0.9: 0.0825688073394496, 0.95: 0.159663865546219,
              0.98: 0.328859060402684}
    for rho, want in some(signal.items(), 0, 2):
        n = many(80_000 if rho < 0.95 else 40_000)
        text = HEAD + f"""  wall: {{type: lambert, reflectance: {rho}}}
geometries:
  ball: {{type: sphere, radius: 1}}
  port: {{type: disc, radius: {math.sqrt(1 - 0.98 ** 2)!r}}}
objects:
  - {{name: ball, geometry: ball, surface: wall, inside: air, outside: air}}
  - {{name: port, geometry: port, at: [0, 0, 0.98], surface: black, front: air, back: air}}
sources:
  - {{name: lamp, type: point, at: [0, 0, 0], direction: [0, 0, -1], distribution: {{cone: 20}}, flux: 1 lm,
     spectrum: {{rgb: [1, 1, 1]}}, medium: air}}
"""
        target = trace("sphere", text, n)
        (port, wall), total = rays(target, "ended(absorbed, port)", "ended(absorbed, ball)")
        checks.share(f"port, rho = {rho}", port, total, want)
        checks.true(f"sphere, rho = {rho}: port and wall take all", port + wall == total == n)
        drop(target)


def check_disc_on_axis():
    """A Lambertian disc (R = 0.5, 1000 cd/m^2) seen from a small square on its axis: Howell B-13,
    E = pi L (1 - (Z - 2 R^2) / sqrt(Z^2 - 4 R^2)) / 2 off axis, pi L R^2 / (R^2 + d^2) on it."""
    on_axis = {0.1: 3020.76216691326, 0.5: 1570.7963267949, 1: 628.318530717959, 5: 31.1048777583148}
    radius, luminance = 0.5, 1000
    flux = math.pi * luminance * math.pi * radius ** 2
    for distance, lux in some(on_axis.items(), 0, 2):
        half = 0.02 if distance < 1 else 0.05 * distance

        def illuminance(x, y):
            rho = math.hypot(x, y)
            h, r = distance / rho, radius / rho
            z = 1 + h * h + r * r
            return math.pi * luminance * (1 - (z - 2 * r * r) / math.sqrt(z * z - 4 * r * r)) / 2

        checks.close(f"disc at {distance} closed form", illuminance(1e-5, 0), lux, rel=1e-5)
        text = HEAD + f"""geometries:
  patch: {{type: rectangle, size: [{2 * half}, {2 * half}]}}
objects:
  - {{name: patch, geometry: patch, at: [0, 0, {distance}], surface: black, front: air, back: air}}
sources:
  - {{name: disc, type: area, shape: {{disc: {radius}}}, at: [0, 0, 0], direction: [0, 0, 1], flux: {flux!r} lm,
     spectrum: {{rgb: [1, 1, 1]}}, medium: air}}
"""
        target = trace("disc", text, RAYS)
        answer = count(target, "hit(patch)")[0]
        flux_check(f"lumens from a disc at {distance}", answer,
                   (2 * half) ** 2 * mean_over(illuminance, -half, half, -half, half))
        drop(target)


def check_small_aperture():
    """RAD-14: under a small hole in front of uniform radiance (an even sky through its portal) the illuminance falls as cos^4."""
    text = HEAD + """geometries: {floor: {type: disc, radius: 1000}}
objects: [{name: floor, geometry: floor, surface: black, front: air, back: air}]
sources: [{name: sky, type: sky, kind: 5, horizontal: 3141.592653589793 lx, toward: [hole], medium: air}]
detectors: [{name: hole, type: plane, at: [0, 0, 1], direction: [0, 0, 1], size: 0.002, cells: 1}]
"""
    target = trace("hole", text, many(80_000), encoding="plain")
    (end,) = columns(target, "segment/position")
    tangent = numpy.hypot(end[:, 0], end[:, 1])
    area = 0.002 ** 2
    for degrees in 0, 20, 40, 60:
        low, high = (math.tan(math.radians(max(degrees + d, 0))) for d in (-2, 2))
        share = high ** 2 / (1 + high ** 2) - low ** 2 / (1 + low ** 2)  # of the flux, in the ring
        matched = ((tangent >= low) & (tangent < high)).sum()
        checks.share(f"cos^4 at {degrees} degrees", matched, len(tangent), share)
        lux = matched / len(tangent) * math.pi * 1000 * area / (math.pi * (high ** 2 - low ** 2))
        law = 1000 * area * math.cos(math.radians(degrees)) ** 4  # L A cos^4 / d^2
        checks.close(f"cos^4 at {degrees} degrees: lx", lux, law, rel=0.01 + 4 / math.sqrt(matched))
    drop(target)


def check_sphere_source():
    """RAD-15: a shining sphere is as bright at a point as its disc: E = pi L R^2 / d^2, wherever it is seen whole (here one of 160 x 80
    flat pieces, of nearly its area)."""
    n_around, n_along, radius = 160, 80, 0.2
    with open("ball.obj", "w", encoding="utf-8") as file:
        for i in range(n_along + 1):
            for k in range(n_around):
                t, p = math.pi * i / n_along, 2 * math.pi * k / n_around
                file.write(f"v {radius * math.sin(t) * math.cos(p)!r} {radius * math.sin(t) * math.sin(p)!r} {radius * math.cos(t)!r}\n")
        for i in range(n_along):
            for k in range(n_around):
                a, b = i * n_around + k + 1, i * n_around + (k + 1) % n_around + 1
                file.write((f"f {a} {a + n_around} {b}\n" if i < n_along - 1 else "") + (f"f {b} {a + n_around} {b + n_around}\n" if i else ""))
    for distance, want in some(((0.25, 2010.61929829747), (1, 125.663706143592), (3, 13.9626340159546)), 0, 2):
        half = 0.02 * distance if distance < 1 else 0.05 * distance
        lux = mean_over(lambda x, y, d=distance: want * d ** 3 / (d * d + x * x + y * y) ** 1.5, -half, half, -half, half)
        text = HEAD + f"""geometries:
  patch: {{type: rectangle, size: [{2 * half}, {2 * half}]}}
  ball: {{type: mesh, file: ball.obj}}
objects:
  - {{name: patch, geometry: patch, at: [0, 0, {distance}], surface: black, front: air, back: air}}
sources:
  - {{name: ball, type: area, shape: {{mesh: ball}}, flux: {1000 * math.pi * 4 * math.pi * radius ** 2!r} lm, spectrum: {{rgb: [1, 1, 1]}}, medium: air}}
"""
        target = trace("ball", text, many(60_000))
        answer = count(target, "hit(patch)")[0]["flux"]
        checks.z(f"lumens from a sphere at {distance}", answer["matched"], lux * 4 * half * half,
                 math.hypot(answer["standard_error"], 1e-3 * answer["matched"]))
        drop(target)


def check_furnace():
    """Second law: in a closed cube whose six faces shine alike, radiance is the same everywhere and
    a body that absorbs nothing changes nothing: each cell of each wall receives what its area
    sends, wherever the body stands (Veach 1997). A body of reflectance 1/2 takes half of what
    falls on it: its surface's share of the walls'."""
    panels = "sources:\n"
    for name, at, axis, size in (("floor", (0, 0, -1), (0, 0, 1), 2), ("ceiling", (0, 0, 1), (0, 0, -1), 2),
                                 ("west", (-1, 0, 0), (1, 0, 0), 2), ("east", (1, 0, 0), (-1, 0, 0), 2),
                                 ("south", (0, -1, 0), (0, 1, 0), 2), ("north", (0, 1, 0), (0, -1, 0), 2)):
        inset = [a * (1 - 1e-9) for a in at]
        panels += (f"  - {{name: {name}_panel, type: area, shape: {{rectangle: [{size}, {size}]}}, at: {inset}, "
                   f"direction: {list(axis)}, flux: 1 lm, spectrum: {{rgb: [1, 1, 1]}}, medium: air}}\n")
    panels += "detectors:\n" + "".join(
        f"  - {{name: {n}_map, type: plane, on: {n}, size: [2, 2], cells: [4, 4], at: {list(at)}, direction: {list(axis)}}}\n"
        for n, at, axis in (("floor", (0, 0, -1), (0, 0, 1)), ("west", (-1, 0, 0), (1, 0, 0)),
                            ("north", (0, 1, 0), (0, -1, 0))))
    bodies = {"white": ("lambert, reflectance: 1", "air"), "glass": ("fresnel", "glass"),
              "mirror_ball": ("mirror, reflectance: 1", "air"), "grey": ("lambert, reflectance: 0.5", "air"),
              "luneburg": ("fresnel", "luneburg"), "cloud": ("fresnel", "cloud")}
    radius = 0.55
    for name, (surface, inside) in some(bodies.items(), 1, 3, 4, 5):
        head = HEAD.replace("{air: {index: 1}}", "{air: {index: 1}, glass: {index: 1.5}, "
                            f"luneburg: {{gradient: {{type: luneburg, radius: {radius}}}}}, "
                            f"cloud: {{index: 1, scattering: {5 / radius}, scattering_g: 0.8}}}}")
        text = head + f"  body: {{type: {surface}}}\n" + box(
            2, 2, 2, "black", f"  ball: {{type: sphere, radius: {radius}}}\n") + (
            f"  - {{name: ball, geometry: ball, at: [0.3, -0.2, -0.4], surface: body, inside: {inside}, outside: air}}\n"
        ) + panels
        n = many({"glass": 50_000, "luneburg": 20_000, "cloud": 20_000}.get(name, 80_000))
        target = trace("furnace", text, n, options=("--set", "limits.steps=100000"))
        cells = [f"registered({wall}_map, cells({i}..{i}, {j}..{j}))"
                 for wall in ("floor", "west", "north") for i in range(4) for j in range(4)]
        found, total = rays(target, "ended(absorbed, ball)", "hit(ball)", *cells)
        if name == "grey":
            share = 4 * math.pi * radius ** 2 / 24
            checks.share("furnace, grey body is met", found[1], total, share)
            checks.share("furnace, grey body absorbs half", found[0], total, share / 2)
        else:
            checks.true(f"furnace, {name}: absorbs nothing", found[0] == 0)
            for criterion, matched in zip(cells, found[2:]):
                checks.share(f"furnace, {name}, {criterion}", matched, total, 1 / 96)
        drop(target)


def check_immersed_emitter():
    """A Lambertian emitter in glass, n = 1.5, behind a flat face to air: 1 / n^2 of the light can leave
    (etendue), 0.40365 with Fresnel losses in a single pass; of an isotropic point source
    (1 - sqrt(1 - 1 / n^2)) / 2 on one side."""
    cases = [("area, shape: {disc: 0.01}", "ideal", 0.444444444444444, "no losses"),
             ("area, shape: {disc: 0.01}", None, 0.403654240292312, "Fresnel"),
             ("point, distribution: isotropic", "ideal", 0.127322003750035, "isotropic")]
    for source, coat, want, what in some(cases, 1, 2):
        surface = "{type: fresnel, coat: ideal}" if coat else "{type: fresnel}"
        text = HEAD.replace("{air: {index: 1}}", "{air: {index: 1}, glass: {index: 1.5}}") + f"""  face: {surface}
geometries:
  sheet: {{type: disc, radius: 100}}
objects:
  - {{name: exit, geometry: sheet, at: [0, 0, 1], surface: face, front: air, back: glass}}
  - {{name: back, geometry: sheet, at: [0, 0, -0.001], surface: black, front: glass, back: glass}}
sources:
  - {{name: led, type: {source}, at: [0, 0, 0], direction: [0, 0, 1], flux: 1 lm, spectrum: {{rgb: [1, 1, 1]}}, medium: glass}}
"""
        target = trace("immersed", text, RAYS)
        found, total = rays(target, "hit(exit, transmit_specular)")
        checks.share(f"escape, {what}", found[0], total, want)
        drop(target)


check_small_aperture()
check_sphere_source()
check_point_source()
check_area_source()
check_flux_conservation()
check_interreflections()
check_view_factors()
check_integrating_sphere()
check_disc_on_axis()
check_furnace()
check_immersed_emitter()
checks.finish()
