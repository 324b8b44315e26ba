# SPDX-License-Identifier: MIT
"""A scene for tests of statistics: RADIUS is that of the spot, in mm."""

# A spot of 20 um, and some light all over a field of 40 mm.
SPOT = """raymap: 1
units: mm
media: {air: {index: 1}}
geometries: {wall: {type: rectangle, size: [40, 40]}}
objects: [{name: wall, geometry: wall, at: [0, 0, 10], surface: absorber, front: air, back: air}]
sources:
  - {name: narrow, type: collimated, shape: {disc: RADIUS}, direction: [0, 0, 1], flux: 1 W,
     rays_share: 99, medium: air}
  - {name: wide, type: collimated, shape: {disc: 19}, direction: [0, 0, 1], flux: 1 mW,
     rays_share: 1, medium: air}
detectors:
  - {name: sensor, type: plane, size: [40, 40], cells: [20, 20], at: [0, 0, 9],
     direction: [0, 0, -1]}
"""
