#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: with everything on at once (a lamp's file, sky, sun, rays of a file, scintillation and Cherenkov light of steps, species,
a phase function, Mie's spheres, haze, a gradient medium, rough surfaces, times, a response by chance) rays are the same on 1 to 4 ranks
and in either encoding, and so are the answers about them."""
import json
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))
from asking import SLOW, check, finish, run  # noqa: E402

LAMP = """IESNA:LM-63-2002
[TEST] everything
[MANUFAC] nobody
TILT=NONE
1 1000 1 5 2 1 2 0.1 0.1 0
1 1 20
0 30 60 75 90
0 180
300 250 120 40 0
300 220 100 20 0
"""
STEPS = """x (mm),y (mm),z (mm),dx,dy,dz,length (mm),energy (MeV),time (ns),event
-8,0,0,1,0,0,6,1.2,0.5,1
-2,0,0,1,0,0,5,0.9,0.52,1
3,1,1,0.8,0.6,0,5,1.1,4,2
"""
RAYS = """x (mm),y (mm),z (mm),dx,dy,dz,wavelength (nm),time (ns),weight
0,0,60,0,0,-1,450,0.1,1
5,5,60,0.1,0,-0.99,500,0.2,2
-5,3,60,0,-0.2,-0.97,450,0.3,1
"""
TABLE = "wavelength: [400, 700], value:"
SCENE = f"""raymap: 1
units: mm
spectrum: {{wavelengths: {{from: 400, to: 700, step: 25}}}}
limits: {{steps: 3000}}
media:
  air: {{index: 1.0003, scattering: {{coefficient: 1e-4, phase: rayleigh, reference: 550}}}}
  bar: {{index: 1.58, absorption: 0.002, accounting: photons,
        species: {{dye: {{absorption: {{wavelength: [400, 450, 500, 700], value: [0.4, 0.3, 0, 0]}},
                        emission: {{led: {{peak: 520, width: 40}}}}, yield: 0.8, lifetime: [3 ns]}}}},
        scintillation: {{per_MeV: 5000, birks: 0.126 mm/MeV, rise: 0.4 ns, decay: [{{time: 2.1 ns, share: 1}}, {{time: 9 ns, share: 0.2}}]}}}}
  milk: {{index: 1.34, scattering: {{mie: {{diameter: 0.8 um, sigma: 1, n: 1.46, share: 0.0005}}}}}}
  opal: {{index: 1.49, absorption: 0.001, scattering: {{haze: 30 %, thickness: 3 mm, g: 0.9}}}}
  fog: {{index: 1.0003, scattering: {{coefficient: 0.01, phase: {{angle: [0, 10, 60, 180], value: [30, 5, 0.4, 0.1]}}}}}}
  rod: {{gradient: {{type: selfoc, n0: 1.6, A: 0.002}}}}
films:
  ar: {{reference: 550, layers: [{{material: MgF2, quarter: 1}}]}}
surfaces:
  clear: {{type: fresnel}}
  coated: {{type: fresnel, coat: {{film: ar}}}}
  rough: {{type: mirror, reflectance: 0.9, scatter: {{model: harvey, b0: 1, l: 0.01, s: -1.5}}}}
  wrap: {{type: scatter, reflectance: 0.5, reflect: {{model: abg, A: 2e-3, B: 1e-3, g: 1.8}}}}
  floor: {{type: lambert, reflectance: 0.4}}
  black: {{type: absorber}}
geometries:
  bar: {{type: box, size: [30, 10, 10]}}
  plate: {{type: box, size: [30, 30, 3]}}
  drop: {{type: sphere, radius: 4}}
  rod: {{type: cylinder, radius: 3, length: 20, closed: true}}
  ground: {{type: rectangle, size: [200, 200]}}
  strip: {{type: rectangle, size: [40, 40]}}
objects:
  - {{name: bar, geometry: bar, at: [0, 0, -5], surface: coated, inside: bar, outside: air}}
  - {{name: wrap, geometry: strip, at: [0, 0, -8], surface: wrap, front: air}}
  - {{name: plate, geometry: plate, at: [0, 0, 20], surface: clear, inside: opal, outside: air}}
  - {{name: drop, geometry: drop, at: [25, 0, 8], surface: clear, inside: milk, outside: air}}
  - {{name: puff, geometry: drop, at: [25, 20, 8], surface: clear, inside: fog, outside: air}}
  - {{name: rod, geometry: rod, at: [-45, 0, 0], rotate: [0, 90, 0], surface: clear, inside: rod, outside: air}}
  - {{name: mirror, geometry: strip, at: [0, 40, 10], rotate: [90, 0, 0], surface: rough, front: air}}
  - {{name: ground, geometry: ground, at: [0, 0, -20], surface: {{front: floor, back: black}}, front: air}}
sources:
  - {{name: lamp, type: lamp, file: lamp.ies, at: [0, 0, 50], rotate: [180, 0, 0], flux: 1 W, spectrum: D65, medium: air}}
  - {{name: sky, type: sky, model: cie, kind: 12, horizontal: 100 W/m2, place: [52.5, 13.4], time: "2026-06-21T12:00+02:00", toward: [window], spectrum: D65, medium: air}}
  - {{name: sun, type: sun, irradiance: 800 W/m2, place: [52.5, 13.4], time: "2026-06-21T12:00+02:00", shape: {{buie: 0.02}}, toward: [window], spectrum: D65, medium: air}}
  - {{name: file, type: ray_file, file: rays.csv, medium: air, flux: 1 W}}
  - {{name: muon, type: steps, file: steps.csv, medium: bar, emit: [scintillation, cherenkov]}}
  - {{name: led, type: area, shape: {{disc: 2}}, at: [-12, 0, 40], direction: [0, 0, -1], medium: air, flux: 1 W, spectrum: {{led: {{peak: 450, width: 20}}}}}}
  - {{name: glow, type: volume, in: drop, flux: 0.1 W}}
detectors:
  - {{name: window, type: plane, at: [0, 0, 55], direction: [0, 0, 1], size: [100, 100], cells: [10, 10], side: both}}
  - {{name: pmt, type: plane, at: [15.5, 0, 0], direction: [1, 0, 0], size: [10, 10], cells: [5, 5], side: both,
     response: {{{TABLE} [0.3, 0.1]}}, detect: chance}}
  - {{name: low, type: plane, on: ground, at: [0, 0, -20], size: [200, 200], cells: [20, 20], response: {{angle: [0, 60, 90], value: [1, 0.7, 0]}}}}
  - {{name: all, type: intensity, cells: [18, 36]}}
simulations: [{{name: timed, rays: 10000, time: on}}]
"""
for name, text in (("lamp.ies", LAMP), ("steps.csv", STEPS), ("rays.csv", RAYS), ("scene.yaml", SCENE)):
    pathlib.Path(name).write_text(text, encoding="utf-8")
N = 10000
questions = [
    ("query", "MAP", "event(fluoresce)", "event(scatter_volume)", "registered(pmt where time in 1..9 ns)", "detected(pmt)", "source(muon) and registered(low)",
     "event(gradient)", "scatter(harvey)", "--json"),
    ("paths", "MAP", "--detector", "pmt", "--by", "object", "--collapse", "--top", "5", "--json"),
    ("stats", "MAP", "--of", "time(low)", "--json"),
    ("detector", "MAP", "pmt", "--json"),
]
digests, answers, counts = {}, {}, None
RANKS = {1: "compact", 3: "plain", **({2: "plain", 4: "compact"} if SLOW else {})}
for ranks, encoding in RANKS.items():
    name = f"map-{ranks}.raymap"
    run("trace", "scene.yaml", "--simulation", "timed", "-o", name, "--encoding", encoding, "--quiet", "--force", ranks=ranks)
    told = json.loads(run("info", name, "--json"))
    digests[ranks] = told["digest"]
    check(told["rays_traced"] == N, f"{told}")
    said = []
    for question in questions:
        answer = json.loads(run(*[name if word == "MAP" else word for word in question], ranks=ranks))
        for one in answer if isinstance(answer, list) else [answer]:
            for key in "map", "bytes_read", "seconds":
                one.pop(key, None)
        said.append(answer)
    answers[ranks] = said
    counts = [one["rays"]["matched"] for one in said[0]]
check(len(set(digests.values())) == 1, f"digests {digests}")
check(all(n > 5 for n in counts), f"everything happens: {counts}")
for ranks in RANKS:
    for question, one, other in zip(questions, answers[1], answers[ranks]):
        check(one == other, f"{question[0]} on {ranks} ranks:\n{json.dumps(one)[:600]}\n{json.dumps(other)[:600]}")
run("verify", "map-3.raymap")
finish()
