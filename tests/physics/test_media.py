#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Beer-Lambert: in a medium of absorption mu light travels an exponentially distributed distance.

mu = 2.5 per length unit: transmittance exp(-mu L) of three thicknesses (binomial z <= 4), and of
the free paths the mean 1 / mu, the variance 1 / mu^2 and the whole distribution
(Kolmogorov-Smirnov: sqrt(n) D <= 2.23 in 9,999 of 10,000 samples). VOL-04 of the corpus.
"""
import math

import numpy

from raymap import Checks, columns, drop, many, rays, trace

checks = Checks()
RAYS = many(400_000)
MU = 2.5


def scene(thickness):
    return f"""raymap: 1
units: mm
spectrum: {{mode: spectral, wavelengths: [550]}}
media:
  ink: {{index: 1, absorption: {MU}}}
  air: {{index: 1}}
surfaces: {{clear: {{type: fresnel}}, black: {{type: absorber}}}}
geometries: {{face: {{type: disc, radius: 1}}}}
objects:
  - {{name: end, geometry: face, at: [0, 0, {thickness}], surface: clear, front: air, back: ink}}
sources:
  - {{name: beam, type: collimated, shape: {{disc: 0.5}}, at: [0, 0, 0], direction: [0, 0, 1], flux: 1 W,
     spectrum: {{lines: {{550: 1}}}}, medium: ink}}
"""


for length, want in ((0.1, 0.778800783071405), (1.0, 0.0820849986238988), (3.0, 0.000553084370147834)):
    target = trace("beer", scene(length), RAYS)
    (passed, absorbed), total = rays(target, "hit(end, transmit_specular)", "ended(absorbed, ink)")
    checks.share(f"transmittance of {length}", passed, total, want)
    checks.true("absorbed or passed", passed + absorbed == total == RAYS)
    drop(target)

# 40 mean free paths: exp(-100) of the light gets to the end.
target = trace("free-path", scene(40), RAYS, encoding="plain")
(path,) = columns(target, "ray/path_length")
n = len(path)
checks.true("every ray is there", n == RAYS)
checks.z("mean free path", path.mean(), 1 / MU, 1 / MU / math.sqrt(n))
# Var of the sample variance of an exponential: (mu4 - sigma^4) / n = 8 sigma^4 / n.
checks.z("variance", path.var(ddof=1), 1 / MU ** 2, math.sqrt(8 / n) / MU ** 2)
ordered = 1 - numpy.exp(-MU * numpy.sort(path))
steps = numpy.arange(n + 1) / n
ks = max((steps[1:] - ordered).max(), (ordered - steps[:-1]).max())
checks.true(f"Kolmogorov-Smirnov: sqrt(n) D = {math.sqrt(n) * ks:.3f}", math.sqrt(n) * ks <= 2.23)
drop(target)
checks.finish()
