# SPDX-License-Identifier: MIT
"""A scene for tests of paths, in which rays come to many."""

# Scattering and absorption inside media, which a path tells by the medium; two sources; surfaces
# that do many things; detectors free in space and on an object.
ODD = """
raymap: 1
units: mm
limits: {steps: 14}
media:
  air: {index: 1}
  milk: {index: 1.3, scattering: 0.05, absorption: 0.01}
  smoke: {index: 1.3, scattering: 0.03}
surfaces:
  bare: {type: fresnel}
  white: {type: lambert, reflectance: 0.7}
  gauze: {type: mixture, reflect_specular: 0.3, transmit_specular: 0.3, transmit_diffuse: 0.2}
geometries:
  ball: {type: sphere, radius: 8}
  plate: {type: rectangle, size: [60, 60]}
objects:
  - {name: glass, geometry: ball, at: [0, 0, 40], surface: bare, inside: milk, outside: air}
  - {name: bubble, geometry: ball, at: [18, 0, 40], surface: bare, inside: smoke, outside: air}
  - name: end
    objects:
      - {name: wall, geometry: plate, at: [0, 0, 70], surface: white, front: air, back: air}
      - {name: net, geometry: plate, at: [0, 0, 60], surface: gauze, front: air, back: air}
sources:
  - {name: lamp, type: point, at: [0, 0, -20], direction: [0, 0, 1], distribution: {cone: 30}, flux: 3 W, medium: air}
  - {name: torch, type: point, at: [5, 0, -20], direction: [0, 0, 1], distribution: {cone: 40}, flux: 1 W, rays_share: 2, medium: air}
detectors:
  - {name: gate, type: plane, at: [0, 0, 25], size: [50, 50], cells: [5, 4], direction: [0, 0, -1]}
  - {name: eye, type: plane, on: wall, size: [60, 60], cells: [6, 6], at: [0, 0, 70], direction: [0, 0, -1]}
"""
