#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Lambert's law: a surface of reflectance 0.7 sends back 0.7 of the light, with density
cos(theta) / pi over solid angle whatever the incidence: mean cos = 2/3, mean cos^2 = 1/2, a
quarter of it within 30 degrees, and cos^2 and phi uniform and independent (chi-square). Transmission
by a mixture follows the same law on the other side.
"""
import math

import numpy

from raymap import Checks, columns, drop, many, trace

checks = Checks()
RAYS = many(400_000)


def chi_square(what, counts, expected):
    """The Wilson-Hilferty cube root turns chi^2 / k into a normal z; p between 1e-4 and 1 - 1e-4 is
    |z| <= 3.72. Too good a fit is as suspicious as a bad one."""
    k = len(counts) - 1
    value = ((counts - expected) ** 2 / expected).sum()
    z = ((value / k) ** (1 / 3) - (1 - 2 / (9 * k))) / math.sqrt(2 / (9 * k))
    checks.z(f"{what}: chi^2 = {value:.1f} of {k}", z, 0, 1, limit=3.72)


def leaving(name, surface, direction):
    text = f"""raymap: 1
units: mm
spectrum: {{mode: spectral, wavelengths: [550]}}
media: {{air: {{index: 1}}}}
surfaces: {{paint: {surface}}}
geometries: {{sheet: {{type: disc, radius: 1}}}}
objects:
  - {{name: sheet, geometry: sheet, surface: paint, front: air, back: air}}
sources:
  - {{name: pencil, type: rays, flux: 1 W, medium: air, rays: [{{origin: {[-d for d in direction]}, direction: {direction}, wavelength: 550}}]}}
"""
    target = trace(name, text, RAYS, encoding="plain")
    stop, end = columns(target, "ray/stop", "ray/end_direction")
    drop(target)
    return end[stop == 1].astype(float), len(stop)


def check_law(what, cos, azimuth):
    n = len(cos)
    checks.z(f"{what} mean cos", cos.mean(), 2 / 3, math.sqrt(1 / 18 / n))
    checks.z(f"{what} mean cos^2", (cos ** 2).mean(), 1 / 2, math.sqrt(1 / 12 / n))
    checks.share(f"{what} within 30 degrees", int((cos > math.cos(math.pi / 6)).sum()), n, 0.25)
    # Radiant intensity at 60 degrees to that on the axis: 2 cos d(cos) over thin rings.
    ring = int((abs(cos - 0.5) < 0.02).sum())
    cap = int((cos > 0.96).sum())
    ratio = (ring / 0.5) / (cap / 0.98) * 0.5
    checks.z(f"{what} intensity at 60 degrees", ratio, 0.5, 0.5 * math.sqrt(1 / ring + 1 / cap))
    counts, _, _ = numpy.histogram2d(cos ** 2, azimuth, bins=(20, 36),
                                     range=((0, 1), (-math.pi, math.pi)))
    chi_square(f"{what} histogram", counts.ravel(), n / counts.size)


for direction in ([0, 0, -1], [0.9, 0.1, -0.4]):
    out, n = leaving("lambert", "{type: lambert, reflectance: 0.7}", direction)
    checks.share(f"reflected, light along {direction}", len(out), n, 0.7)
    checks.true("all of it to the side of incidence", (out[:, 2] > 0).all())
    check_law(f"light along {direction}", out[:, 2], numpy.arctan2(out[:, 1], out[:, 0]))

out, n = leaving("mixture", "{type: mixture, reflect_specular: 0.1, reflect_diffuse: 0.2, "
                            "transmit_specular: 0.05, transmit_diffuse: 0.4}", [0.6, 0, -0.8])
up = out[out[:, 2] > 0]
down = out[out[:, 2] < 0]
mirrored = (numpy.abs(up - [0.6, 0, 0.8]).max(axis=1) < 1e-6).sum()
straight = (numpy.abs(down - [0.6, 0, -0.8]).max(axis=1) < 1e-6).sum()
checks.share("mixture, mirrored", int(mirrored), n, 0.1)
checks.share("mixture, straight on", int(straight), n, 0.05)
checks.share("mixture, diffusely back", len(up) - int(mirrored), n, 0.2)
checks.share("mixture, diffusely through", len(down) - int(straight), n, 0.4)
through = down[numpy.abs(down - [0.6, 0, -0.8]).max(axis=1) >= 1e-6]
check_law("diffuse transmission", -through[:, 2], numpy.arctan2(through[:, 1], through[:, 0]))
checks.finish()
