#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rays through lenses and mirrors, against published listings and a 50-digit trace.

Each case holds to its published digits within the tolerance of the print, and to the independent
decimal trace within 1e-12 relative (double precision through a dozen surfaces).
"""
import math

import numpy

from exact_trace import Surface, trace as exact_rays
from raymap import Checks, columns, report, reports, trace

checks = Checks()
REL = 1e-12

# Schott's Sellmeier coefficients as at refractiveindex.info (CC0): B1 C1 B2 C2 B3 C3, um^2.
SELLMEIER = {
    "N-SSK2": (1.4306027, 0.00823982975, 0.153150554, 0.0333736841, 1.01390904, 106.870822),
    "N-SK2": (1.28189012, 0.0072719164, 0.257738258, 0.0242823527, 0.96818604, 110.377773),
    "F5": (1.3104463, 0.00958633048, 0.19603426, 0.0457627627, 0.96612977, 115.011883),
    "N-SK16": (1.34317774, 0.00704687339, 0.241144399, 0.0229005, 0.994317969, 92.7508526),
    "N-BK7": (1.03961212, 0.00600069867, 0.231792344, 0.0200179144, 1.01046945, 103.560653),
    "N-SF11": (1.73759695, 0.013188707, 0.313747346, 0.0623068142, 1.89878101, 155.23629),
}


def sellmeier(name):
    b1, c1, b2, c2, b3, c3 = SELLMEIER[name]
    return f"{{sellmeier: {{B: [{b1}, {b2}, {b3}], C: [{c1}, {c2}, {c3}]}}, wavelength_unit: um}}"


def scene(body, rays, wavelengths=(587.6,), media=""):
    """A scene with an explicit list of rays; every boundary transmits all light."""
    listing = "\n".join(
        f"      - {{origin: {list(o)}, direction: {list(d)}, wavelength: {w}}}" for o, d, w in rays)
    return f"""raymap: 1
units: mm
spectrum: {{mode: spectral, wavelengths: {list(wavelengths)}}}
media:
  air: {{index: 1}}
{media}surfaces:
  clear: {{type: fresnel, coat: ideal}}
  mirror: {{type: mirror, reflectance: 1}}
  black: {{type: absorber}}
{body}sources:
  - name: probe
    type: rays
    flux: 1 W
    medium: air
    rays:
{listing}
"""


def compare(what, history, reference):
    """Positions, leg directions and path lengths of the first legs against the decimal trace."""
    steps = history["steps"]
    checks.true(f"{what}: {len(steps)} legs, at least {len(reference)} wanted",
                len(steps) >= len(reference))
    scale = max(abs(float(v)) for r in reference for v in r["position"])
    for k, (step, wanted) in enumerate(zip(steps, reference)):
        checks.close(f"{what} surface {k + 1} position", step["position"],
                     [float(v) for v in wanted["position"]], abs=REL * scale)
        checks.close(f"{what} surface {k + 1} length", step["length"], wanted["length"],
                     abs=REL * scale)


# CODE V sample lens dblgauss, listing of CODE V 10.8 in ray-optics (github.com/mjhoptics/
# ray-optics, src/rayoptics/codev/tests/ag_dblgauss.lis, BSD-3). EPD 50, stop: surface 6.
CURVATURE = [0.0177928409409154, 0.00656660053692557, 0.0265374329467098, 0, 0.0412689287857008, 0,
             -0.0352394265442907, 0, -0.0263675082865771, 0.00563660495174855, -0.0125926458590576]
THICKNESS = [8.75, 0.5, 12.5, 3.8, 16.3694449265356, 13.7479569638891, 3.8, 11.0, 0.5, 7.0,
             61.4875364179821]
DEFOCUS = -0.400268645354138
INDEX = [1.62229150078871, 1, 1.60737885858432, 1.60341717819097, 1, 1, 1.60341717819097,
         1.62040793306981, 1, 1.62040793306981, 1]
APERTURE = [26, 26, 26, 23, 18, 18, 18, 20, 20, 20, 20]
VERTEX = [sum(THICKNESS[:k]) for k in range(11)]
IMAGE = VERTEX[10] + THICKNESS[10] + DEFOCUS


def double_gauss(rays, screen=True):
    media = "".join(f"  m{k}: {{index: {n}}}\n" for k, n in enumerate(INDEX) if n != 1)
    rows = "".join(
        f"      - {{curvature: {c}, thickness: {t}, medium: {'air' if n == 1 else f'm{k}'}, "
        f"aperture: {APERTURE[k]}}}\n"
        for k, (c, t, n) in enumerate(zip(CURVATURE, THICKNESS, INDEX)))
    body = f"""geometries:
  gauss:
    type: lens
    surface: clear
    edge: black
    surfaces:
{rows}  screen: {{type: disc, radius: 100}}
objects:
  - {{name: lens, geometry: gauss, outside: air}}
"""
    if screen:
        body += (f"  - {{name: image, geometry: screen, at: [0, 0, {IMAGE!r}], surface: black, "
                 "front: air, back: air}\n")
    return scene(body, rays, media=media)


GAUSS = [Surface(z, curvature=c, index=n) for z, c, n in zip(VERTEX, CURVATURE, INDEX)]
GAUSS_IMAGE = GAUSS + [Surface(IMAGE)]


def check_marginal_ray():
    """The real marginal ray at all surfaces: published rows to 2e-6, decimal trace to 1e-12."""
    rows = [[25.0, 5.866433, -0.185302, 5.866433], [24.109772, 1.920632, -0.200953, 4.885983],
            [22.844992, 7.714534, -0.394267, 6.419725], [20.958242, 0, -0.395393, 5.143978],
            [16.784894, 6.754936, -0.112583, 11.350044], [15.702464, 0, -0.112583, 9.675248],
            [14.610682, -4.050377, 0.15343, 9.758844], [15.815163, 0, 0.151784, 7.942241],
            [16.882946, -3.965091, -0.057039, 7.115484], [16.583956, 0.776812, -0.071127, 5.250422],
            [16.261006, -1.682704, -0.258832, 4.551955], [0.014138, 0, -0.258832, 64.838492]]
    angles = [[26.41, 15.91], [1.39, 2.25], [25.96, 15.8], [21.52, 21.57], [22.27, 37.42],
              [6.42, 6.42], [37.41, 22.27], [8.72, 8.63], [17.8, 29.7], [2.1, 1.3], [15.88, 26.33]]
    ray = ((25, 0, -10), (0, 0, 1), 587.6)
    history = report("double-gauss-marginal", double_gauss([ray]))
    compare("marginal ray", history, exact_rays(ray[0], ray[1], GAUSS_IMAGE))
    steps = history["steps"]
    for k, (x, z, tangent, path) in enumerate(rows):
        what, step = f"marginal ray, listing, surface {k + 1}", steps[k]
        vertex = VERTEX[k] if k < 11 else IMAGE
        checks.close(what + " x", step["position"][0], x, abs=2e-6)
        checks.close(what + " y", step["position"][1], 0, abs=1e-12)
        checks.close(what + " z", step["position"][2] - vertex, z, abs=2e-6)
        checks.close(what + " path", step["length"] - (10 if k == 0 else 0), path, abs=2e-6)
        if k < 11:
            a, b = steps[k]["position"], steps[k + 1]["position"]
            leg = [q - p for p, q in zip(a, b)]
            checks.close(what + " tan", leg[0] / leg[2], tangent, abs=2e-6)
            into = [p - q for p, q in zip(a, steps[k - 1]["position"] if k else ray[0])]
            for side, inward in enumerate((into, leg)):
                cosine = abs(sum(p * q for p, q in zip(inward, step["normal"]))) / math.hypot(*inward)
                checks.close(what + " angle", math.degrees(math.acos(min(1.0, cosine))),
                             angles[k][side], abs=0.0051)


def crossing(steps, k):
    """Height z at which the ray meets the axis after step k, and its slope there."""
    point, direction = steps[k]["position"], steps[k + 1]["direction"]
    slope = direction[0] / direction[2]
    return point[2] - point[0] / slope, slope


def check_first_order():
    """Near-axis rays give the paraxial constants: listing to 5e-5. At a height of 0.0025 mm the
    third-order error is below (0.0025 / 25)^2 of the marginal aberration, 1e-9 mm."""
    h = 0.0025
    rays = [((h, 0, -10), (0, 0, 1), 587.6), ((h, 0, 100), (0, 0, -1), 587.6),
            ((0, 0, VERTEX[5] - 1e-6), (h / 25, 0, -1), 587.6),
            ((0, 0, VERTEX[5] + 1e-6), (h / 25, 0, 1), 587.6)]
    text = double_gauss(rays, screen=False)
    forward, backward, front, rear = reports("double-gauss-paraxial", text, 4)
    steps = forward["steps"]
    paraxial = [25.0, 23.507005, 23.41663, 19.075817, 17.75295, 15.852527, 14.256448, 14.699756,
                15.969559, 15.932466, 15.371307]
    for k, y in enumerate(paraxial):
        checks.close(f"paraxial marginal height {k + 1}", steps[k]["position"][0] * 25 / h, y,
                     abs=5e-5)
    focus, slope = crossing(steps, 10)
    checks.close("paraxial height at the image", (focus - IMAGE) * -slope * 25 / h, 0.100063, abs=5e-5)
    checks.close("EFL", -h / slope, 100.0038, abs=5e-5)
    checks.close("FNO", -h / slope / 50, 2.0001, abs=5e-5)
    checks.close("BFL", focus - VERTEX[10], 61.4875, abs=5e-5)
    checks.close("OAL", VERTEX[10], 77.9674, abs=5e-5)
    steps = backward["steps"]
    focus, slope = crossing(steps, 10)
    checks.close("EFL backwards", h / slope, 100.0038, abs=5e-5)
    checks.close("FFL", focus, -29.3208, abs=5e-5)
    # The stop's centre seen through the front and the rear group: the pupils. The listing counts
    # the entrance pupil from surface 1, the exit pupil from the last surface. A pupil's size is
    # the stop's times the index-free angular magnification.
    steps = front["steps"]
    pupil, slope = crossing(steps, len(steps) - 2)
    checks.close("entrance pupil", pupil, 57.912, abs=5e-5)
    checks.close("entrance pupil diameter", 2 * 15.852527 * (h / 25) / abs(slope), 50, abs=5e-5)
    steps = rear["steps"]
    pupil, slope = crossing(steps, len(steps) - 2)
    checks.close("exit pupil", pupil - VERTEX[10], -53.1569, abs=5e-5)
    checks.close("exit pupil diameter", 2 * 15.852527 * (h / 25) / abs(slope), 57.3201, abs=1e-4)


# Zemax OpticStudio values in OpticSim.jl (github.com/microsoft/OpticSim.jl, test/testsets/
# Comparison.jl, MIT): N-BK7 at 550 nm, light towards -z, vertices at z = 0 and z = -10.
ZEMAX_RAYS = [((0, 0, 1), (0, 0, -1)), ((2, 2, 1), (0, 0, -1)), ((5, 5, 1), (0, 0, -1)),
              ((0, -5, 1), (0, 0.0871557427476582, -0.996194698091745)),
              ((-5, -5, 1), (0.0871557427476582, -0.0173859947617641, -0.996042972814049))]
N_BK7_550 = 1.51852238762079


def check_zemax(name, top, bottom, screen, points, paths):
    """top, bottom: (radius, conic) with our sign, > 0 bends towards +z."""
    mirror = screen > 0
    body = f"""geometries:
  upper: {{type: conic, radius: {top[0]}, conic: {top[1]}, aperture: 9}}
  lower: {{type: conic, radius: {bottom[0]}, conic: {bottom[1]}, aperture: 9}}
  screen: {{type: disc, radius: 100}}
objects:
  - {{name: upper_face, geometry: upper, surface: clear, front: air, back: bk7}}
  - {{name: lower_face, geometry: lower, at: [0, 0, -10], surface: {'mirror' if mirror else 'clear'}, front: bk7, back: air}}
  - {{name: screen, geometry: screen, at: [0, 0, {screen}], surface: black, front: air, back: air}}
"""
    text = scene(body, [(o, d, 550) for o, d in ZEMAX_RAYS], (550,),
                 f"  bk7: {sellmeier('N-BK7')}\n")
    faces = [Surface(0, top[0], conic=top[1], index=N_BK7_550),
             Surface(-10, bottom[0], conic=bottom[1], mirror=mirror, index=1)]
    if mirror:
        faces.append(Surface(0, top[0], conic=top[1], index=1))
    for k, ((origin, direction), history) in enumerate(zip(ZEMAX_RAYS, reports(name, text, len(ZEMAX_RAYS)))):
        compare(f"{name} ray {k}", history,
                exact_rays(origin, direction, faces + [Surface(screen)]))
        checks.close(f"{name} ray {k} Zemax point", history["steps"][-1]["position"],
                     list(points[k]) + [screen], rel=REL, abs=1e-12)
        checks.close(f"{name} ray {k} Zemax path", history["optical_path"], paths[k], rel=REL)


def check_all_zemax():
    check_zemax("plate", (0, 0), (0, 0), -67.8,
                [(0, 0), (2, 2), (5, 5), (0, 0.719232101161923),
                 (0.720053536292889, -6.14104725269719)],
                [73.9852238762079, 73.9852238762079, 73.9852238762079, 74.234903851062,
                 74.2448952769065])
    check_zemax("biconvex", (-60, 0), (60, 0), -67.8,
                [(0, 0), (-0.0619152159071103, -0.0619152159071103),
                 (-0.249110506789766, -0.249110506789766), (0, 5.63987691317936),
                 (5.70545233156267, -0.767971358789485)],
                [73.9852238762079, 73.987421926598, 74.0110871422915, 74.6758349889372,
                 74.6175821043825])
    check_zemax("mangin", (0, 0), (41, 0), 47.8,
                [(0, 0), (-6.19723306038804, -6.19723306038804),
                 (-17.7546255175372, -17.7546255175372), (0, 19.5349836031196),
                 (21.2477706541112, 17.3463704045055)],
                [79.1704477524159, 80.0979229417755, 86.2063094599075, 83.5364646376395,
                 87.4033932087711])
    check_zemax("hyperboloid", (0, 0), (15, -5), -67.8,
                [(0, 0), (-1.80279270185495, -1.80279270185495),
                 (-2.8229241607807, -2.8229241607807), (0, 9.01421545841289),
                 (8.13946939328266, 2.23006981338816)],
                [73.9852238762079, 74.1000975813922, 74.282094499601, 75.2211078071893,
                 75.1025133542546])


def check_hubble():
    """Hubble's two mirrors (Laikin, Lens Design, p. 200; optiland tests/test_paraxial.py, MIT):
    EFL and focus to 1e-9 of the lengths involved. A ray at h = 1 mm is paraxial to
    (h / f)^2 / 2 = 2e-10."""
    r1, k1, to_m2, r2, k2, to_image = (-11040.02286, -1.001152, 4910.01016, -1349.31166, -1.483014,
                                       6365.20955)
    heights = (1, 600, 1200)
    for h in heights:
        body = f"""geometries:
  primary: {{type: conic, radius: {r1}, conic: {k1}, aperture: 1201, inner: {0.4 * h}}}
  secondary: {{type: conic, radius: {r2}, conic: {k2}, aperture: 160}}
  screen: {{type: disc, radius: 1000}}
objects:
  - {{name: primary, geometry: primary, surface: mirror, front: air, back: air}}
  - {{name: secondary, geometry: secondary, at: [0, 0, {-to_m2}], surface: mirror, front: air, back: air}}
  - {{name: focal_plane, geometry: screen, at: [0, 0, {to_image - to_m2}], surface: black, front: air, back: air}}
"""
        ray = ((h, 0, -2000), (0, 0, 1), 587.6)
        history = report("hubble", scene(body, [ray]))
        mirrors = [Surface(0, r1, conic=k1, mirror=True), Surface(-to_m2, r2, conic=k2, mirror=True),
                   Surface(to_image - to_m2)]
        compare(f"Hubble h={h}", history, exact_rays(ray[0], ray[1], mirrors))
        if h == 1:
            focus, slope = crossing(history["steps"], 1)
            checks.close("Hubble EFL", -h / slope, 57600.0809984036, rel=1e-9)
            checks.close("Hubble focus", focus - (to_image - to_m2), 0.0168642375298487,
                         abs=1e-9 * 6365)


def check_indices():
    """Sellmeier indices, read as the optical length of 1 mm of glass. Listing of CODE V to its six
    decimals, catalogue n_d and V_d to theirs; N-BK7 and N-SF11 against the equation itself."""
    lines = (656.3, 587.6, 486.1)
    listing = {"N-SSK2": [1.618769, 1.622292, 1.630455], "N-SK2": [1.604134, 1.607379, 1.61486],
               "F5": [1.598744, 1.603417, 1.614617], "N-SK16": [1.617271, 1.620408, 1.627559]}
    equation = {"N-BK7": [1.51432148995205, 1.51679843790501, 1.5223786557709],
                "N-SF11": [1.77595218662473, 1.78471410302463, 1.80652258390298]}
    catalogue = {"N-BK7": (1.5168, 64.17), "N-SK16": (1.62041, 60.32)}
    d_line, f_line, c_line = 587.5618, 486.1327, 656.2725
    wavelengths = sorted({*lines, d_line, f_line, c_line})

    def indices(glass, medium):
        body = """geometries:
  face: {type: disc, radius: 5}
objects:
  - {name: entry, geometry: face, surface: clear, front: glass, back: air}
  - {name: exit, geometry: face, at: [0, 0, 1], surface: black, front: air, back: glass}
"""
        text = scene(body, [((0, 0, -1), (0, 0, 1), w) for w in wavelengths], wavelengths,
                     f"  glass: {medium}\n")
        return {w: report(f"index-{glass}", text, k)["optical_path"] - 1
                for k, w in enumerate(wavelengths)}

    for glass in SELLMEIER:
        found = indices(glass, sellmeier(glass))
        if glass in listing:
            checks.close(f"{glass} CODE V", [found[w] for w in lines], listing[glass], abs=6e-7)
        if glass in equation:
            checks.close(f"{glass} Sellmeier", [found[w] for w in lines], equation[glass], rel=REL)
        if glass in catalogue:
            n_d, v_d = catalogue[glass]
            checks.close(f"{glass} n_d", found[d_line], n_d, abs=6e-6)
            checks.close(f"{glass} V_d", (found[d_line] - 1) / (found[f_line] - found[c_line]), v_d,
                         abs=6e-3)
    built_in = {name: indices(name, f"{{glass: {name}}}") for name in ("N-BK7", "N-SF2", "N-SF14")}
    checks.close("built-in N-BK7", [built_in["N-BK7"][w] for w in lines], equation["N-BK7"], rel=REL)
    for name, (n_d, v_d) in {"N-SF2": (1.64769, 33.82), "N-SF14": (1.76182, 26.53)}.items():
        n = built_in[name]
        checks.close(f"built-in {name} n_d", n[d_line], n_d, abs=6e-6)
        checks.close(f"built-in {name} V_d", (n[d_line] - 1) / (n[f_line] - n[c_line]), v_d, abs=6e-3)


def distance_to_line(point, a, b):
    way = [q - p for p, q in zip(a, b)]
    to = [q - p for p, q in zip(a, point)]
    along = sum(p * q for p, q in zip(way, to)) / sum(p * p for p in way)
    return math.dist(point, [p + along * d for p, d in zip(a, way)])


def check_stigmatic():
    """Descartes: conics image one point into one point. Within 1e-10."""
    heights = (10, 50, 100)
    body = """geometries:
  dish: {type: conic, radius: -200, conic: -1, aperture: 120}
  screen: {type: disc, radius: 500}
objects:
  - {name: dish, geometry: dish, surface: mirror, front: air, back: air}
  - {name: behind, geometry: screen, at: [0, 0, -150], surface: black, front: air, back: air}
"""
    text = scene(body, [((h, 0, -99), (0, 0, 1), 587.6) for h in heights])
    for k, h in enumerate(heights):
        steps = report("paraboloid", text, k)["steps"]
        focus, _ = crossing(steps, 0)
        checks.close(f"paraboloid h={h}", focus, -100, abs=1e-10)

    # An ellipsoid of semi-axes 5, 3, 3 is a sphere scaled; light goes from focus to focus.
    directions = [(0.3, 1, 0.2), (-1, 0.5, 0.1), (0.1, -0.4, 0.9), (0.9, 0.1, 0)]
    body = """geometries:
  ball: {type: sphere, radius: 1}
objects:
  - {name: shell, geometry: ball, scale: [5, 3, 3], surface: mirror, inside: air, outside: air}
"""
    text = scene(body + "limits: {steps: 2}\n", [((4, 0, 0), d, 587.6) for d in directions])
    for k, direction in enumerate(directions):
        steps = report("ellipsoid", text, k)["steps"]
        checks.close(f"ellipsoid {direction} meets the other focus",
                     distance_to_line((-4, 0, 0), steps[0]["position"], steps[1]["position"]), 0,
                     abs=1e-10)
        checks.close(f"ellipsoid {direction} path",
                     math.dist((4, 0, 0), steps[0]["position"]) +
                     math.dist(steps[0]["position"], (-4, 0, 0)), 10, abs=1e-10)

    # Plano-hyperbolic lens, k = -n^2: focus at R / (1 - n) behind the vertex.
    body = """geometries:
  singlet:
    type: lens
    surface: clear
    edge: black
    surfaces:
      - {radius: 0, thickness: 20, medium: glass, aperture: 25}
      - {radius: -50, conic: -2.25, medium: air, aperture: 25}
  screen: {type: disc, radius: 500}
objects:
  - {name: singlet, geometry: singlet, outside: air}
  - {name: behind, geometry: screen, at: [0, 0, 150], surface: black, front: air, back: air}
"""
    heights = (1, 10, 20)
    text = scene(body, [((h, 0, -10), (0, 0, 1), 587.6) for h in heights],
                 media="  glass: {index: 1.5}\n")
    for k, h in enumerate(heights):
        steps = report("hyperbolic", text, k)["steps"]
        focus, _ = crossing(steps, 1)
        checks.close(f"hyperbolic lens h={h}", focus - 20, 100, abs=1e-10)


def landed(name, second, media="  glass: {index: 1.5}\n"):
    """Where 400 rays along z, over a square of 34 mm, meet the plane 100 mm behind a plano lens: (from, to) in x and y."""
    body = f"""geometries:
  singlet:
    type: lens
    surface: clear
    edge: black
    surfaces:
      - {{radius: 0, thickness: 20, medium: glass, aperture: {{rectangle: [50, 50]}}}}
      - {{{second}, medium: air, aperture: {{rectangle: [50, 50]}}}}
  screen: {{type: disc, radius: 500}}
objects:
  - {{name: singlet, geometry: singlet, outside: air}}
  - {{name: behind, geometry: screen, at: [0, 0, 120], surface: black, front: air, back: air}}
"""
    side = [-17 + 34 * (k + 0.3) / 20 for k in range(20)]
    rays = [((x, y, -10), (0, 0, 1), 587.6) for x in side for y in side]
    target = trace(name, scene(body, rays, media=media), len(rays), encoding="plain")
    start, n, position = columns(target, "/ray/start", "/ray/segment_count", "/segment/position")
    checks.true(f"{name}: all rays have three legs", len(n) == len(rays) and numpy.all(n == 3))
    return start[:, :2].astype(float), position[numpy.cumsum(n) - 1].astype(float)


def check_lines_and_facets():
    """Places of 400 rays as far as a map has them, in single precision. An acylinder of k = -n^2 has one line of focus (the
    hyperbola of Descartes). Facets that send all light to one point: n (0, 1) - (-sin u, cos u) is along their normal by
    Snell's law, sin u = r / w, w = sqrt(r^2 + f^2), so that the profile's slope is -r / (n w - f)."""
    start, end = landed("acylinder", "radius: -50, conic: -2.25, toroid: inf")
    checks.close("acylinder: along the line of focus", numpy.max(abs(end[:, 0] - start[:, 0])), 0, abs=2e-6)
    checks.close("acylinder: across it", numpy.max(abs(end[:, 1])), 0, abs=2e-6)
    checks.close("acylinder: at its distance", numpy.max(abs(end[:, 2] - 120)), 0, abs=0)

    r = 25 * numpy.sin(numpy.linspace(0, math.pi / 2, 200))[1:]
    slope = -r / (1.5 * numpy.hypot(r, 100) - 100)
    powers = range(2, 25, 2)
    factor = numpy.linalg.lstsq(numpy.stack([p * (r / 25) ** (p - 1) / 25 for p in powers], 1), slope, rcond=None)[0]
    terms = ", ".join(f"{p}: {float(a) / 25.0 ** p!r}" for p, a in zip(powers, factor))
    _, end = landed("fresnel", f"asphere: {{{terms}}}, fresnel: true")
    checks.close("Fresnel lens: one focus", numpy.max(numpy.hypot(end[:, 0], end[:, 1])), 0, abs=2e-6)
    # Of a sphere: each ray by Snell's law at the plane, with the normal of the sphere.
    start, end = landed("fresnel-sphere", "radius: -50, fresnel: true")
    h = numpy.hypot(start[:, 0], start[:, 1])
    tilt = numpy.arcsin(h / 50)
    turned = numpy.arcsin(1.5 * numpy.sin(tilt)) - tilt
    want = start * (1 - 100 * numpy.tan(turned) / h)[:, None]
    checks.close("Fresnel lens of a sphere", numpy.max(abs(end[:, :2] - want)), 0, abs=1e-5)
    checks.true("its aberration is seen", numpy.max(abs(want)) > 0.1)


check_marginal_ray()
check_first_order()
check_all_zemax()
check_hubble()
check_indices()
check_stigmatic()
check_lines_and_facets()
checks.finish()
