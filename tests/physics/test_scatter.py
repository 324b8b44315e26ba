#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Scatter models: shares in closed form counted in rays, forward tracing against rendering, and what maps of them weigh.

Harvey's law cut at the horizon scatters 2 pi b0 l^2 / (s + 2) ((1 + l^-2)^((s + 2)/2) - 1) at normal incidence; at other angles by
quadrature. A rough boundary scatters R (1 - exp(-(4 pi sigma n cos / lambda)^2)) of the reflected light (Davies 1954,
doi:10.1049/pi-3.1954.0025) and T (1 - exp(-(2 pi sigma (n1 cos1 - n2 cos2) / lambda)^2)) of the refracted.
"""
import json
import math
import os

import numpy

from picture import luminance, render
from raymap import SCALE, Checks, columns, count, drop, many, rays, run, some, trace, write_scene

checks = Checks()

BEAM = """raymap: 1
units: mm
spectrum: {{wavelengths: [{nm}]}}
media: {{air: {{index: 1}}, glass: {{index: 1.5168}}}}
surfaces: {{face: {surface}}}
geometries: {{plate: {{type: rectangle, size: [1000, 1000]}}}}
objects: [{{name: plate, geometry: plate, surface: face, front: air, back: {back}}}]
sources:
  - {{name: s, type: rays, flux: 1 W, medium: air, rays: [{{origin: [0, 0, 1], direction: [{s!r}, 0, {c!r}], wavelength: {nm}}}]}}
"""


def beam(surface, degrees=0, nm=632.8, back="air"):
    angle = math.radians(degrees)
    return BEAM.format(surface=surface, nm=nm, back=back, s=math.sin(angle), c=-math.cos(angle))


def check_harvey():
    mirror = "{type: mirror, reflectance: 1, scatter: {model: harvey, b0: 13.947, l: 0.01, s: -1.5}}"
    for degrees, want in some({0: 0.157745, 30: 0.14875, 60: 0.12188, 80: 0.09460}.items(), 0, 2):
        target = trace("harvey", beam(mirror, degrees), many(25_000))
        (scattered, specular), total = rays(target, "scatter(harvey)", "hit(plate, reflect_specular)")
        checks.share(f"Harvey at {degrees} degrees", scattered, total, want)
        checks.true("nothing is lost", scattered + specular == total)
        drop(target)


def check_rough_lens():
    """20 nm on N-BK7's index: 15 times as much of the reflected light as of the refracted."""
    lens = "{type: fresnel, scatter: {model: harvey, roughness: 20 nm, correlation: 5 um}}"
    r = ((1.5168 - 1) / (1.5168 + 1)) ** 2
    back = r * -math.expm1(-(4 * math.pi * 20 / 587.56) ** 2)
    on = (1 - r) * -math.expm1(-(2 * math.pi * 20 * 0.5168 / 587.56) ** 2)
    target = trace("lens", beam(lens, 0, 587.56, "glass"), many(60_000))
    criteria = ["hit(plate, reflect)", "hit(plate, reflect_diffuse)", "hit(plate, transmit_diffuse)", "scatter(harvey)"]
    (reflected, lobe, passed, both), total = rays(target, *criteria)
    checks.share("reflected in all", reflected, total, r)
    checks.share("scattered back", lobe, total, back)
    checks.share("scattered on", passed, total, on)
    checks.true("each scattered ray is one of them", both == lobe + passed)
    drop(target)


def check_spike():
    """A pure spike does not feel the roughness of the facets; of their lobe nothing is specular."""
    spike = "{type: scatter, reflectance: 0.7, reflect: {model: unified, sigma_alpha: 12, spike: 1}}"
    lobe = spike.replace("spike: 1", "lobe: 1")
    for name, surface, criterion in [("spike", spike, "hit(plate, reflect_specular)"), ("lobe", lobe, "scatter(unified)")]:
        target = trace(name, beam(surface, 40), many(30_000))
        (matched,), total = rays(target, criterion)
        checks.share(name, matched, total, 0.7)
        drop(target)


def check_slope_error():
    """A mirror of slope error s rms per axis, facets of alpha = s sqrt 2, turns light by 2 s in the plane of incidence
    and by 2 s cos(theta) across; slopes within a circle of radius r have s = r / 2, and light stays in an ellipse of which it fills
    every part alike."""
    s = 0.002
    models = [f"beckmann, alpha: {s * math.sqrt(2)}", "slope_error, gaussian: 2 mrad", "slope_error, pillbox: 4 mrad"]
    cases = [(0, models[0]), *((d, m) for d in (0, 45, 70) for m in models[1:])]
    for degrees, model in some(cases, 3, 6):
        mirror = f"{{type: mirror, reflectance: 0.9, scatter: {{model: {model}}}}}"
        target = trace("slopes", beam(mirror, degrees), many(20_000), encoding="plain")
        (end,) = columns(target, "ray/end_direction")
        drop(target)
        end = end[end[:, 2] > 0].astype(float)
        angle = math.radians(degrees)
        along = end @ [math.cos(angle), 0, -math.sin(angle)]
        for what, found, want in (("along", along, 2 * s), ("across", end[:, 1], 2 * s * math.cos(angle))):
            checks.z(f"{model} at {degrees} degrees, {what}", found.std(), want,
                     want / math.sqrt(2 * len(end)) + 1e-3 * want)
        if "pillbox" in model:
            out = numpy.hypot(along / (4 * s), end[:, 1] / (4 * s * math.cos(angle)))
            checks.true(f"pillbox at {degrees} degrees: {out.max()}", 0.99 < out.max() < 1.03)
            for part in 0.3, 0.7:
                checks.share(f"pillbox at {degrees} degrees: within {part}", (out < part).sum(), len(out), part ** 2)


# ---- trace against render: a screen lit by a plate alone ----

SCREEN = """raymap: 1
units: m
spectrum: {{mode: rgb}}
media: {{air: {{index: 1}}, glass: {{index: 1.5}}}}
films: {{over: {{layers: [{{n: 1.5, thickness: 90 nm}}, {{n: 2.4, k: 0.6, thickness: 60 nm}}]}}}}
surfaces:
  face: {surface}
  grey: {{type: lambert, reflectance: 0.5}}
geometries:
  plate: {{type: rectangle, size: [6, 6]}}
  screen: {{type: rectangle, size: [1, 1]}}
  wall: {{type: rectangle, size: [20, 20]}}
objects:
  - {{name: plate, geometry: plate, surface: face, front: air, back: {back}, rotate: [0, 0, 20]}}
  - {{name: screen, geometry: screen, at: [1.5, 0, 2], rotate: [0, 216.86989764584402, 0], surface: {{front: grey, back: absorber}}, front: air, back: air}}
  - {{name: wall, geometry: wall, at: [0, 0, 10.7], rotate: [0, 90, 0], surface: absorber}}
sources: [{{name: lamp, type: area, shape: {{disc: 0.3}}, at: [-1.5, 0, {z}], direction: [0.6, 0, {dz}], flux: 1000 lm, medium: {back_or_air}}}]
detectors: [{{name: sensor, type: plane, on: screen, cells: 1}}]
cameras: [{{name: eye, at: [0.9, 0, 1.2], look_at: [1.5, 0, 2], up: [0, 1, 0], fov: 53.13010235415598, resolution: [16, 16]}}]
"""

MODELS = {
    "lambert": "{type: scatter, reflectance: 0.8, reflect: {model: lambert}}",
    "gaussian": "{type: scatter, reflectance: 0.8, reflect: {model: gaussian, sigma: 0.3}}",
    "cosine": "{type: scatter, reflectance: 0.8, reflect: {model: cosine, power: 12}}",
    "abg": "{type: scatter, reflectance: 0.8, reflect: {model: abg, A: 0.05, B: 0.1, g: 1.7}}",
    "harvey": "{type: mirror, reflectance: 0.9, scatter: {model: harvey, b0: 0.7, l: 0.2, s: -1.5}}",
    "harvey of roughness": "{type: mirror, metal: {n: 0.7, k: 4}, scatter: {model: harvey, roughness: 40 nm, correlation: 0.5 um}}",
    "k_correlation": "{type: mirror, reflectance: 0.9, scatter: {model: k_correlation, roughness: 12 nm, correlation: 0.2 um, s: 2.5}}",
    "contamination": "{type: mirror, reflectance: 0.9, contamination: {level: 900, area: 0.01 m2}}",
    "harvey and contamination": "{type: mirror, reflectance: 0.9, scatter: {model: harvey, b0: 0.7, l: 0.2, s: -1.5}, contamination: {level: 900, area: 0.02 m2}}",
    "ggx": "{type: mirror, metal: {n: 0.7, k: 4}, scatter: {model: ggx, alpha: 0.4}}",
    "ggx, two alphas": "{type: scatter, reflectance: 0.8, reflect: {model: ggx, alpha: [0.6, 0.2]}}",
    "beckmann": "{type: scatter, reflectance: 0.8, reflect: {model: beckmann, alpha: [0.2, 0.5]}}",
    "pillbox": "{type: mirror, reflectance: 0.8, scatter: {model: slope_error, pillbox: 9}}",
    "unified": "{type: scatter, reflectance: 0.8, reflect: {model: unified, sigma_alpha: 12, spike: 0.1, lobe: 0.5, back: 0.2}}",
    "retro": "{type: scatter, reflectance: 0.8, reflect: {model: retro, sigma: 0.5}}",
    "oren_nayar": "{type: scatter, reflectance: 0.8, reflect: {model: oren_nayar, r: 0.9}}",
    "oren_nayar, passing": "{type: scatter, transmittance: 0.8, transmit: {model: oren_nayar, r: 0.9}}",
    "gaussian, passing": "{type: scatter, transmittance: 0.8, transmit: {model: gaussian, sigma: 0.3}}",
    "lambert, passing": "{type: scatter, transmittance: 0.8, transmit: {model: lambert}}",
    "ground glass": "{type: fresnel, scatter: {model: ggx, alpha: 0.3}}",
    "ground glass by beckmann": "{type: fresnel, scatter: {model: beckmann, alpha: 0.3}}",
    "ground glass by unified": "{type: fresnel, scatter: {model: unified, sigma_alpha: 15, lobe: 0.6, spike: 0.1}}",
    "dusty glass": "{type: fresnel, contamination: {level: 900, area: 0.01 m2}}",
    "rough dusty glass": "{type: fresnel, scatter: {model: harvey, roughness: 120 nm, correlation: 0.5 um}, contamination: {level: 900, area: 0.02 m2}}",
    "dusty boundary": "{type: fresnel, contamination: {level: 900, area: 0.005 m2}}",
    "dusty paint": "{type: scatter, reflectance: 0.05, reflect: {model: lambert}, contamination: {level: 900, area: 0.01 m2}}",
    "dusty sheet, passing": "{type: scatter, transmit_specular: 0.8, transmit: {model: gaussian, sigma: 0.3, tis: 0.1}, contamination: {level: 900, area: 0.01 m2}}",
    "rough glass": "{type: fresnel, scatter: {model: harvey, roughness: 120 nm, correlation: 0.5 um}}",
    "coated mirror": "{type: mirror, metal: {n: 0.7, k: 4}, coat: {film: over}, scatter: {model: ggx, alpha: 0.4}}",
    "table": "{type: scatter, reflect: {model: table, file: felt.csv}}",
    "klems": "{type: scatter, reflect: {model: klems, file: blind.xml}}",
    "klems, passing": "{type: scatter, transmit: {model: klems, file: blind.xml}}",
}
# A quick run takes each law once, and each way that two go together; which way light goes, and what stands for what, is for tests/slow.
QUICK = ("abg", "k_correlation", "harvey and contamination", "ggx, two alphas", "pillbox", "unified", "retro",
         "oren_nayar, passing", "ground glass by beckmann", "rough dusty glass", "dusty sheet, passing", "coated mirror", "table", "klems, passing")


def write_tables():
    """A lobe about the specular direction on a pedestal, 0.77 of the light at normal incidence; and a matrix without any symmetry,
    of 0.26 to 0.75 of it."""
    with open("felt.csv", "w", encoding="utf-8") as file:
        for i in (0, 30, 60, 85):
            for s in range(0, 91, 5):
                for p in range(0, 181, 15):
                    t, u = math.radians(s), math.radians(p)
                    x, y = math.sin(t) * math.cos(u) + math.sin(math.radians(i)), math.sin(t) * math.sin(u)
                    file.write(f"0 {i} 0 {s} {p} {0.15 + 1.2 * math.exp(-(x * x + y * y) / 0.08)!r}\n")
    dice, rings = numpy.random.default_rng(4), ((0, 20, 1), (20, 45, 8), (45, 70, 12), (70, 90, 6))
    n = sum(ring[2] for ring in rings)
    basis = "".join(f"<AngleBasisBlock><Theta>{(a + b) / 2}</Theta><nPhis>{k}</nPhis><ThetaBounds><LowerTheta>{a}</LowerTheta><UpperTheta>{b}"
                    "</UpperTheta></ThetaBounds></AngleBasisBlock>" for a, b, k in rings)
    blocks = "".join('<WavelengthData><Wavelength unit="Integral">Visible</Wavelength><WavelengthDataBlock><WavelengthDataDirection>'
                     f"{way} {side}</WavelengthDataDirection><ScatteringData>{' '.join(map(str, dice.random(n * n) * 0.3))}</ScatteringData>"
                     "</WavelengthDataBlock></WavelengthData>" for way in ("Transmission", "Reflection") for side in ("Front", "Back"))
    with open("blind.xml", "w", encoding="utf-8") as file:
        file.write("<WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure>"
                   f"<AngleBasis>{basis}</AngleBasis></DataDefinition>{blocks}</Layer></Optical></WindowElement>")


def check_trace_and_render():
    for name in MODELS if SCALE > 1 else QUICK:
        surface = MODELS[name]
        through, glass = "passing" in name or "glass" in name, "fresnel" in surface
        scene = SCREEN.format(surface=surface, back="glass" if glass else "air", z=-2 if through else 2,
                              dz=0.8 if through else -0.8, back_or_air="glass" if glass and through else "air")
        traced = json.loads(run("trace", write_scene("screen", scene), "--no-record", "-n", many(20_000), "--json", "--quiet"))
        flux, error = (traced["detectors"][0]["flux"][key] for key in ("total", "standard_error"))
        image, told = render("screen", scene, "--samples", many(64))
        n = image.shape[0] * image.shape[1]
        seen, noise = luminance(image).mean() * math.pi / 0.5, told["noise"] / math.sqrt(n) * math.pi / 0.5
        checks.true(f"{name}: light on the screen", flux > 0.1)
        checks.z(f"{name}: lm on the screen", seen, flux, math.hypot(noise, error))


SLAB = """raymap: 1
units: mm
spectrum: {mode: rgb}
media: {air: {index: 1}, glass: {index: 1.5}}
surfaces:
  face: {type: fresnel, scatter: {model: unified, sigma_alpha: 20, lobe: 1}}
  paper: {type: lambert, reflectance: 0.8}
geometries:
  face: {type: disc, radius: 2.5}
  edge: {type: cylinder, radius: 2.5, length: 0.5}
  paper: {type: rectangle, size: [5, 5]}
objects:
  - {name: below, geometry: face, rotate: [180, 0, 0], surface: face, inside: glass, outside: air}
  - {name: above, geometry: face, at: [0, 0, 0.5], surface: face, inside: glass, outside: air}
  - {name: edge, geometry: edge, surface: absorber, inside: glass, outside: air}
  - {name: paper, geometry: paper, at: [0, 0, -2], surface: {front: paper, back: absorber}, front: air, back: air}
sources: [{name: lamp, type: area, shape: {disc: 0.6}, at: [0.3, 0.2, 2], direction: [0, 0, -1], flux: 1000 lm, medium: air}]
detectors: [{name: sensor, type: plane, on: paper, side: front, at: [0, 0, -2], direction: [0, 0, 1], size: 0.5289809421253949, cells: 1}]
cameras: [{name: eye, at: [0, 0, -0.5], look_at: [0, 0, -2], up: [0, 1, 0], fov: 20, resolution: [16, 16]}]
"""


def check_two_ground_faces():
    """Facets of unified send light where they let none of it back from: a path from the eye meets such ways too."""
    target = trace("slab", SLAB, many(50_000))
    (answer,) = count(target, "registered(sensor)")
    flux, error = answer["registered"][0]["flux"], answer["registered"][0]["standard_error"]
    drop(target)
    image, told = render("slab", SLAB, "--samples", many(150))
    n, area = image.shape[0] * image.shape[1], (0.5289809421253949e-3) ** 2
    seen = luminance(image).mean() * math.pi / 0.8 * area
    noise = told["noise"] / math.sqrt(n) * math.pi / 0.8 * area
    print(f"two ground faces: {seen / flux:.4f} of what was traced, +- {math.hypot(noise, error) / flux:.4f}")
    checks.z("lm behind two ground faces", seen, flux, math.hypot(noise, error))


def check_bytes():
    """Directions are drawn again by the decoder: a map with a model weighs what one of Lambert's law does."""
    box = """raymap: 1
units: mm
spectrum: {wavelengths: [550]}
media: {air: {index: 1}, glass: {index: 1.52}}
films:
  ar: {reference: 550, layers: [{n: 1.38, quarter: 1}]}
  five: {reference: 550, layers: [{n: 1.38, quarter: 1}, {n: 2.3, quarter: 1}, {n: 1.46, quarter: 1.5}, {n: 2.1, quarter: 1}, {n: 1.7, quarter: 1}]}
  dark: {layers: [{n: 2.4, k: 3.3, thickness: 8 nm}, {n: 1.46, thickness: 85 nm}]}
surfaces:
  face: %s
  wall: WALL
geometries: {ball: {type: sphere, radius: 20}, wall: {type: mesh, file: cube.obj}}
objects:
  - {name: ball, geometry: ball, surface: face, inside: INSIDE, outside: air}
  - {name: cube, geometry: wall, surface: wall, inside: air, outside: air}
sources: [{name: s, type: point, at: [40, 0, 0], flux: 1 W}]
"""
    with open("cube.obj", "w", encoding="utf-8") as file:
        file.write("".join(f"v {x} {y} {z}\n" for x in (-60, 60) for y in (-60, 60) for z in (-60, 60)))
        file.write("f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n")

    def nbytes_of(surface, wavelengths="[550]", wall=None, inside="air"):
        scene = (box % surface).replace("[550]", wavelengths).replace("WALL", wall or surface).replace("INSIDE", inside)
        run("trace", write_scene("bytes", scene), "-o", "bytes.raymap", "-n", 8000, "--quiet", "--force")
        if "type: lambert" not in surface:
            run("verify", "bytes.raymap")
        return sum(os.path.getsize(os.path.join(folder, file)) for folder, _, files in os.walk("bytes.raymap")
                   for file in files if file.startswith("piece"))

    lambert = {r: nbytes_of(f"{{type: lambert, reflectance: {r}}}") for r in (0.8, 0.85, 0.9)}
    found = []
    for name in MODELS if SCALE > 1 else ("gaussian", "harvey and contamination", "ggx, two alphas", "unified", "table"):
        surface = MODELS[name]
        if "transmit" in surface or "fresnel" in surface or "film" in surface:
            continue
        nbytes, plain = nbytes_of(surface), lambert[0.9 if "0.9" in surface else 0.85 if "metal" in surface else 0.8]
        checks.true(f"{name}: {nbytes} bytes, of Lambert's law {plain}", nbytes < 1.3 * plain)
        found.append(f"{name} {nbytes / plain:.2f}")
    # Of several wavelengths, what a model leaves differs between them.
    several, colour = "[400, 450, 500, 550, 600, 650, 700]", "{wavelength: [400, 700], value: [0.6, 0.9]}"
    plain = nbytes_of(f"{{type: lambert, reflectance: {colour}}}", several)
    for surface in some((f"{{type: mirror, reflectance: {colour}, scatter: {{model: k_correlation, roughness: 10 nm, correlation: 10 um, s: 2}}}}",
                         f"{{type: scatter, reflectance: {colour}, reflect: {{model: gaussian, sigma: 0.1, tis: 0.3}}}}",
                         f"{{type: scatter, reflectance: {colour}, reflect: {{model: unified, sigma_alpha: 12, spike: 0.2, lobe: 0.7, back: 0.1}}}}",
                         f"{{type: mirror, reflectance: {colour}, contamination: {{level: 800, slope: 0.926, area: 1 ft2, n: 1.53, k: 1e-3}}}}"), -1):
        nbytes = nbytes_of(surface, several)
        checks.true(f"seven wavelengths, {surface}: {nbytes} bytes, of Lambert's law {plain}", nbytes < 1.3 * plain)
        found.append(f"coloured {nbytes / plain:.2f}")
    # What a metal reflects is of its own colour, at facets by the angle there.
    gold = "{wavelength: [400, 450, 500, 550, 600, 650, 700], value: [0.39, 0.39, 0.5, 0.82, 0.93, 0.96, 0.97]}"
    plain = nbytes_of(f"{{type: lambert, reflectance: {gold}}}", several)
    for kind in some(("type: mirror, metal: Au, scatter: {model: ggx, alpha: 0.2}",
                      "type: mirror, metal: Au, scatter: {model: unified, sigma_alpha: 12, spike: 0.2, lobe: 0.7, back: 0.1}",
                      "type: mirror, metal: Au, scatter: {model: harvey, roughness: 20 nm, correlation: 10 um}",
                      "type: mirror, metal: Au, scatter: {model: harvey, b0: 0.1, l: 0.01, s: -1.5}",
                      "type: mirror, metal: Au, contamination: {level: 800, slope: 0.926, area: 1 ft2, n: 1.53, k: 1e-3}",
                      f"type: fresnel, coat: {{reflectance: {gold}}}, scatter: {{model: ggx, alpha: 0.2}}"), -1):
        nbytes = nbytes_of(f"{{{kind}}}", several)
        checks.true(f"seven wavelengths, {kind}: {nbytes} bytes, of Lambert's law {plain}", nbytes < 1.1 * plain)
        found.append(f"gold {nbytes / plain:.2f}")
    # So is what films reflect, and let pass.
    white = f"{{type: lambert, reflectance: {colour}}}"
    plain = nbytes_of(white, several)
    for kind, inside in some((("type: fresnel, coat: {film: ar}", "glass"), ("type: fresnel, coat: {film: five}", "glass"),
                              ("type: fresnel, coat: {film: dark}", "glass"), ("type: mirror, metal: Al, coat: {film: five}", "air"),
                              ("type: fresnel, coat: {film: five}, scatter: {model: ggx, alpha: 0.2}", "glass")), -1):
        nbytes = nbytes_of(f"{{{kind}}}", several, white, inside)
        checks.true(f"seven wavelengths, {kind}: {nbytes} bytes, of Lambert's law {plain}", nbytes < 1.1 * plain)
        found.append(f"film {nbytes / plain:.2f}")
    drop("bytes.raymap")
    print("bytes over those of Lambert's law of the same reflectance:", ", ".join(found))


write_tables()
check_harvey()
check_rough_lens()
check_spike()
check_slope_error()
check_trace_and_render()
check_two_ground_faces()
check_bytes()
checks.finish()
