# SPDX-License-Identifier: MIT
"""A small scene in which everything that a criterion can name is odd: groups in groups, names
with blanks, signs and other letters, an object that is called like a medium, surfaces that differ
from side to side, meshes with faces, detectors of every kind, rays that are limited."""

# A box from -1 to 1 of three faces (groups): its bottom, its top, the sides.
BOX = """v -1 -1 -1
v 1 -1 -1
v 1 1 -1
v -1 1 -1
v -1 -1 1
v 1 -1 1
v 1 1 1
v -1 1 1
g bottom
f 1 4 3 2
g top
f 5 6 7 8
g sides
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
"""

SCENE = """raymap: 1
units: cm
spectrum: {mode: spectral, wavelengths: [450, 550, 650]}
limits: {steps: 9}
media:
  air: {index: 1}
  glass: {glass: N-BK7}
  ink: {index: 1.3, absorption: 0.3}
  'dark ink 2': {index: 1.3, absorption: 3}
surfaces:
  clear: {type: fresnel}
  coated: {type: fresnel, coat: {reflectance: {wavelength: [450, 650], value: [0.2, 0.4]}}}
  perfect: {type: fresnel, coat: ideal}
  shiny: {type: mirror, reflectance: 0.9}
  gold: {type: mirror, metal: {n: 0.2, k: 3}}
  white: {type: lambert, reflectance: 0.8}
  'black paint': {type: lambert, reflectance: 0.05}
  two ways: {type: scatter, reflectance: 0.5, reflect: {model: abg, A: 0.02, B: 0.1, g: 2}, transmittance: 0.3, transmit: {model: gaussian, sigma: 0.2}}
  satin: {type: mirror, reflectance: 0.7, scatter: {model: ggx, alpha: 0.4}}
  mixed: {type: mixture, reflect_specular: 0.2, reflect_diffuse: 0.15, transmit_specular: 0.25, transmit_diffuse: 0.3}
geometries:
  box: {type: mesh, file: box.obj}
  ball: {type: sphere, radius: 1.2}
  plate: {type: rectangle, size: [6, 6]}
  sheet: {type: disc, radius: 3}
  tube: {type: cylinder, radius: 4, length: 5}
  singlet:
    type: lens
    surface: perfect
    surfaces:
      - {radius: 6, thickness: 0.8, medium: glass, aperture: 2}
      - {radius: -6, medium: air, aperture: 2}
objects:
  - name: housing
    objects:
      - name: upper shelf
        objects:
          - {name: box.1, geometry: box, at: [0, 0, 4], rotate: [10, 20, 30], surface: clear, inside: glass, outside: air}
          - {name: box.2, geometry: box, at: [3, 0, 4], scale: [1, 0.5, -1], surface: mixed, inside: ink, outside: air}
          - {name: ball, geometry: ball, at: [-3, 0, 4], surface: coated, inside: 'dark ink 2', outside: air}
      - {name: "wänd-1", geometry: plate, at: [0, 0, -4], surface: {front: white, back: black paint}, front: air, back: air}
      - {name: barrel, geometry: tube, at: [0, 0, -3], surface: {front: black paint, back: satin}, front: air, back: air}
  - {name: obj, geometry: singlet, at: [0, 0, 1], outside: air}
  - {name: ink, geometry: sheet, at: [0, 0, 8], surface: shiny}
  - {name: "7th sheet", geometry: sheet, at: [5, 0, 0], rotate: [0, -90, 0], surface: {front: gold, back: two ways}, front: air, back: air}
  - {name: veil, geometry: sheet, at: [-5, 0, 0], rotate: [0, 90, 0], surface: {front: coated, back: clear}, front: air, back: air}
sources:
  - {name: lamp, type: point, at: [0, 0, 0], flux: 2 W, medium: air}
  - {name: star 1, type: collimated, shape: {disc: 2}, at: [0, 0, -2], flux: 3 W, rays_share: 2, medium: air}
  - name: list
    type: rays
    medium: air
    flux: 5 mW
    rays:
      - {origin: [0, 0.1, -1], direction: [0, 0, 1], wavelength: 550}
      - {origin: [0, 0.3, -1], direction: [0.1, 0, 1], wavelength: 450}
      - {origin: [-3, 0.2, 1], direction: [0, 0.05, 1]}
detectors:
  - {name: gate, type: plane, at: [0, 0, 2.5], size: [8, 8], cells: [16, 16], side: both}
  - {name: gate.twin, type: plane, at: [0, 0, 2.5], size: [8, 8], cells: [40, 20], side: front, max_angle: 20, direction: [0, 0, -1]}
  - {name: "gate behind", type: plane, at: [0.3, 0.2, 6], size: [5, 7], cells: [9, 7], side: back, direction: [0.1, 0, 1]}
  - {name: film, type: plane, on: upper shelf, at: [0, 0, 4], size: [9, 3], cells: [90, 30]}
  - {name: far, type: intensity, cells: [18, 36]}
  - {name: unlit, type: plane, at: [0, 0, 100], size: 1, cells: 3}
"""
