#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Phase functions of scattering media: moments of the angle, Mie's efficiencies, light of several channels.

A ray that is scattered once and leaves is turned by the angle between its two segments. Efficiencies
of spheres: W. J. Wiscombe, NCAR/TN-140+STR (1979), and Bohren & Huffman (1983), appendix A.
Rayleigh: means of cos^2 and cos^4 2/5 and 9/35. Of the corpus VOL-05 (Henyey and Greenstein: the mean of the Legendre polynomial
P_k is g^k), VOL-08 (Mie), VOL-14 (Rayleigh).
"""
import json
import math

import numpy

from raymap import Checks, columns, drop, many, rays, run, trace, write_scene

checks = Checks()
RAYS = many(100_000)


def scene(scattering, wavelengths="[550]", medium="index: 1", extra=""):
    return f"""raymap: 1
units: mm
spectrum: {{wavelengths: {wavelengths}}}
limits: {{steps: 2}}
media:
  fog: {{{medium}, scattering: {scattering}{extra}}}
surfaces: {{black: {{type: absorber}}}}
geometries: {{globe: {{type: sphere, radius: 1000}}}}
objects:
  - {{name: globe, geometry: globe, surface: black, front: fog, back: fog}}
sources:
  - {{name: beam, type: point, at: [0, 0, 0], direction: [0, 0, 1], distribution: {{cone: 0.000001}}, flux: 1 W,
     spectrum: equal, medium: fog}}
"""


def cosines(name, text):
    """Cosines of the angle between the first and the second segment, and the last colours."""
    target = trace(name, text, RAYS, encoding="plain")
    position, colour, event = columns(target, "segment/position", "segment/colour_spectral", "segment/event")
    position = position.reshape(-1, 2, 3).astype(float)
    way = position[:, 1] - position[:, 0]
    checks.true(f"{name}: every ray is scattered once", (event.reshape(-1, 2)[:, 0] & 64 == 64).all())
    drop(target)
    return way[:, 2] / numpy.linalg.norm(way, axis=1), colour.reshape(len(way), 2, -1)[:, 1]


def moment(name, values, want):
    checks.z(name, values.mean(), want, values.std() / math.sqrt(len(values)))


def turbid(name, text):
    return json.loads(run("check", write_scene(name, text), "--json"))["scene"]["turbid"][0]


# Henyey and Greenstein: the mean of the Legendre polynomial P_k is g^k, and 50 parts of their distribution are met alike.
for g in (-0.5, 0, 0.3, 0.75, 0.9, 0.99):
    mu, _ = cosines("hg", scene(f"{{coefficient: 1, g: {g}}}"))
    for k in (1, 2, 3):
        moment(f"g {g}: P{k}", numpy.polynomial.legendre.Legendre.basis(k)(mu), g ** k)
    part = (1 - g * g) / (2 * g) * (1 / numpy.sqrt(1 + g * g - 2 * g * mu) - 1 / (1 + g)) if g else (1 + mu) / 2
    n = numpy.histogram(part.clip(0, 1), 50, (0, 1))[0]
    chi2 = ((n - len(mu) / 50) ** 2).sum() / (len(mu) / 50)
    checks.true(f"g {g}: chi^2 of 49 {chi2}", chi2 < 94)  # p 1e-4

# Rayleigh, straight and in a medium whose index changes with place.
for word, medium in (("rayleigh", "index: 1"), ("rayleigh in a gradient", "gradient: {type: constant, index: 1.3, frame: world}")):
    mu, _ = cosines("rayleigh", scene("{coefficient: 1, phase: rayleigh}", medium=medium))
    for power, want in ((1, 0), (2, 0.4), (3, 0), (4, 9 / 35)):
        moment(f"{word}: cos^{power}", mu ** power, want)

# Coefficients by the fourth power of the wavelength.
table = turbid("blue", scene("{coefficient: 0.5, phase: rayleigh, reference: 550}", "[400, 550, 700]"))
for row in table["channels"]:
    checks.close("lambda^-4", row["scattering"], 0.5 * (550 / row["wavelength"]) ** 4, rel=1e-12)

# A table: p ~ angle from 30 to 90 degrees, by quadrature.
at = numpy.radians(numpy.linspace(30, 90, 200001))
weight = (at - at[0]) * numpy.sin(at)
mu, _ = cosines("table", scene("{coefficient: 1, phase: {angle: [30, 90], value: [0, 2]}}"))
moment("table: cos", mu, (weight * numpy.cos(at)).sum() / weight.sum())
moment("table: cos^2", mu ** 2, (weight * numpy.cos(at) ** 2).sum() / weight.sum())
checks.true("table: within its angles", mu.max() < math.cos(math.radians(29.99)) and mu.min() > -1e-4)

# A file: another table for each wavelength; a ray of both goes on with one.
with open("p.csv", "w", encoding="utf-8") as file:
    file.write("wavelength, angle, value\n500, 0, 1\n500, 90, 1\n500, 90.001, 0\n500, 180, 0\n"
               "600, 0, 0\n600, 90, 0\n600, 90.001, 1\n600, 180, 1\n")
mu, colour = cosines("file", scene("{coefficient: 1, phase: {file: p.csv}}", "[500, 600]"))
checks.true("file: forwards 500 nm, backwards 600 nm", ((mu > 0) == (colour[:, 0] == 65535))[abs(mu) > 1e-4].all()
            and (colour.max(axis=1) == 65535).all())
moment("file: half of each", (mu > 0).astype(float), 0.5)

# Mie: a sphere of index m in vacuum with the size parameter x; n - i k.
WISCOMBE = ((0.75, 0, 0.099, 7e-06, 7e-06, 0.001448), (0.75, 0, 10, 2.232265, 2.232265, 0.896473),
            (1.33, 1e-5, 1, None, 0.093923, 0.184517), (1.5, 1, 1, 2.336321, 0.6634538, 0.192136),
            (1.5, 1, 100, 2.097502, 1.283697, 0.850252), (10, 10, 1, None, 2.049405, -0.110664))
for n, k, x, qext, qsca, g in WISCOMBE:
    its = turbid("mie", scene(f"{{mie: {{diameter: {x * 550 / math.pi!r} nm, n: {n}, k: {k}, density: 1}}}}"))["channels"][0]["spheres"]
    for key, want in (("Qext", qext), ("Qsca", qsca), ("g", g)):
        if want is not None:
            checks.close(f"Mie {n} - {k} i, x {x}: {key}", its[key], want, abs=1e-6)
its = turbid("mie", scene(f"{{mie: {{diameter: {5.21282 * 550 / math.pi!r} nm, n: 1.55, density: 1}}}}"))["channels"][0]["spheres"]
for key, want in (("Qext", 3.10543), ("Qback", 2.92534), ("g", 0.63314)):
    checks.close(f"Bohren & Huffman: {key}", its[key], want, abs=1e-5)

# What is drawn has the series' mean cosine; small spheres scatter as Rayleigh has it.
for name, spheres in (("x 10", "diameter: 1.7507 um, n: 1.5"), ("absorbing", "diameter: 5 um, n: 1.5, k: 1"),
                      ("spread", "diameter: 0.4 um, sigma: 1.5, n: 1.46")):
    text = scene(f"{{mie: {{{spheres}, share: 1e-3}}}}", medium="index: 1.333")
    row = turbid("mie", text)["channels"][0]
    if row["absorption"] == 0:
        mu, _ = cosines("mie", text)
        moment(f"Mie, {name}: mean cosine", mu, row["mean_cosine"])
    spheres = row["spheres"]
    count = row["scattering"] / spheres["Qsca"]
    checks.close(f"Mie, {name}: absorption", row["absorption"], count * (spheres["Qext"] - spheres["Qsca"]), abs=1e-9 * (1 + row["absorption"]))
mu, _ = cosines("small", scene("{mie: {diameter: 1 nm, n: 1.5, density: 1e20}}"))
moment("small spheres: cos^2", mu ** 2, 0.4)

# A share of the volume: 6 share / (pi d^3) spheres of pi d^2 / 4; log-normal, of the third over the second moment.
for sigma in (1, 1.5):
    row = turbid("mie", scene(f"{{mie: {{diameter: 2 um, sigma: {sigma}, n: 1.5, share: 1e-3}}}}"))["channels"][0]
    spread = math.exp((4.5 - 2) * math.log(sigma) ** 2)
    checks.close(f"share, sigma {sigma}", row["scattering"] / row["spheres"]["Qsca"], 1.5e-3 / (2e-3 * spread), rel=1e-5)
    checks.close(f"mean area, sigma {sigma}", row["spheres"]["area"], math.pi * 1e-6 * math.exp(2 * math.log(sigma) ** 2), rel=1e-5)

# Haze of a plate: what leaves it more than 2.5 degrees off, of what passes.
for haze, g in ((0.05, 0.9), (0.2, 0.9), (0.3, 0.98)):
    target = trace("haze", f"""raymap: 1
units: mm
spectrum: {{wavelengths: [550]}}
media: {{opal: {{index: 1.49, scattering: {{haze: {100 * haze} %, thickness: 3 mm, g: {g}}}}}, air: {{index: 1}}}}
surfaces: {{clear: {{type: fresnel}}}}
geometries: {{face: {{type: disc, radius: 1e6}}}}
objects:
  - {{name: top, geometry: face, at: [0, 0, 0], surface: clear, front: opal, back: air}}
  - {{name: end, geometry: face, at: [0, 0, 3], surface: clear, front: air, back: opal}}
sources:
  - {{name: beam, type: collimated, shape: {{disc: 0.1}}, at: [0, 0, -1], direction: [0, 0, 1], flux: 1 W, medium: air}}
""", many(20_000), encoding="plain")
    (way,) = columns(target, "ray/end_direction")
    way = way.reshape(-1, 3)[:, 2]
    passed = way[way > 0]
    checks.close(f"haze {haze}, g {g}", (passed < math.cos(math.radians(2.5))).mean(), haze, abs=0.005 + 0.1 * haze)
    drop(target)

# Slabs thick and thin: light is neither made nor lost, whatever the phase function.
for scattering in ("{coefficient: 3, phase: rayleigh}", "{mie: {diameter: 0.5 um, n: 1.46, share: 1e-2}}"):
    target = trace("slab", f"""raymap: 1
units: mm
spectrum: {{wavelengths: [450, 650]}}
limits: {{steps: 100000}}
media: {{milk: {{index: 1.333, scattering: {scattering}}}, air: {{index: 1}}}}
surfaces: {{clear: {{type: fresnel}}}}
geometries: {{face: {{type: disc, radius: 1e6}}}}
objects:
  - {{name: top, geometry: face, at: [0, 0, 0], surface: clear, front: milk, back: air}}
  - {{name: end, geometry: face, at: [0, 0, 1], surface: clear, front: air, back: milk}}
sources:
  - {{name: beam, type: collimated, shape: {{disc: 0.1}}, at: [0, 0, -1], direction: [0, 0, 1], flux: 1 W, medium: air}}
""", many(5000))
    (left,), total = rays(target, "ended(left)")
    checks.true(f"slab {scattering}: all light leaves", left == total)
    drop(target)
checks.finish()
