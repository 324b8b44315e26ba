#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Steps of charged particles: the same ones in every format; numbers and angles of Cherenkov light, quenched scintillation; photons
that are expected against photons that are counted, event by event; maps need no file and are the same on any number of ranks and in
either encoding; mistakes are told."""
import json
import math
import pathlib

import asking
import h5py
import numpy as np
import ray_files
from asking import check, run

SCENE = """raymap: 1
units: mm
spectrum: {wavelengths: {from: 305, to: 595, step: 10}}
media:
  water: {index: 1.33}
  heavy: {index: 1.47}
  bar: {index: 1.58, scintillation: {per_MeV: 2000, birks: 0.0126 cm/MeV, rise: 0.5, decay: [{time: 2.1 ns, share: 3}, {time: 14 ns}],
    spectrum: {wavelength: [400, 420, 460], value: [0, 1, 0]}RESOLUTION}}
sources: [{name: muon, type: steps, file: FILE, medium: bar MORE}]
detectors: [{name: far, type: intensity, cells: [9, 4]}]
"""
N = 60
dice = np.random.default_rng(7)
place = dice.uniform(-5, 5, (N, 3))  # mm
way = dice.normal(size=(N, 3))
way /= np.linalg.norm(way, axis=1)[:, None]
length = dice.uniform(0.1, 2, N)
deposit = dice.uniform(0.02, 1, N)  # MeV
time = dice.uniform(0, 20, N)
event = dice.permutation(np.arange(N) // 6 + 100)
beta = dice.uniform(0.5, 1, N)
HEAD = "x [mm],y [mm],z [mm],dx,dy,dz,length [mm],energy [MeV],time [ns],event,beta"
COLUMNS = [*place.T, *way.T, length, deposit, time, event, beta]


def scene(file, more="", resolution="", name="scene.yaml"):
    text = SCENE.replace("FILE", file).replace("MORE", more).replace("RESOLUTION", resolution)
    pathlib.Path(name).write_text(text, encoding="utf-8")
    return name


def photons(path):
    (told,) = json.loads(run("check", path, "--json"))["scene"]["steps"]
    return told




def rays(target, what="all"):
    run("query", target, what, "-o", "rays.h5", "--force", "--columns", "ray,registration")
    with h5py.File("rays.h5") as file:
        ray, far = file["ray"], file["registration"]
        return (np.array(ray["id"]), np.column_stack([ray[f"start_{k}"] for k in "xyz"]),
                np.column_stack([far[f"direction_{k}"] for k in "xyz"]), np.array(ray["wavelength"]))


def check_formats():
    ray_files.csv("a.csv", HEAD, *COLUMNS)
    ray_files.csv("b.csv", "x (cm);y (cm);z (cm);dx;dy;dz;length (cm);energy (keV);time (ps);event;beta;charge".replace(";", ","),
                  *place.T / 10, *way.T, length / 10, deposit * 1000, time * 1000, event, beta, -np.ones(N))
    ray_files.hdf5("c.h5", {"position": (place / 1000, "m"), "direction": (way, None), "length": (length / 1000, "m"),
                            "energy": (deposit / 1000, "GeV"), "time": (time, "ns"), "event": (event, None), "beta": (beta, None)})
    ray_files.hdf5("d.h5", {**{k: (place[:, i], "mm") for i, k in enumerate("xyz")},
                            **{k: (way[:, i], None) for i, k in enumerate(("dx", "dy", "dz"))}, "length": (length, "mm"),
                            "energy": (deposit, "MeV"), "time": (time, "ns"), "event": (event, None), "charge": (np.ones(N), None),
                            "beta": (beta, None)})
    ray_files.mcpl("e.mcpl", place, way, 1239.841984332e-6 / deposit, time, np.ones(N), event, codes=np.full(N, 13),
                   polarised=np.column_stack([length / 10, beta, np.zeros(N)]))
    first = None
    for file in ("a.csv", "b.csv", "c.h5", "d.h5", "e.mcpl"):
        path = scene(file)
        run("trace", path, "-o", "a.raymap", "-n", 2000, "--quiet", "--force")
        told = photons(path)
        check(told["steps"] == N and told["events"] == 10 and not told["counted"], f"{file}: {told}")
        _, start, direction, colour = rays("a.raymap")
        first = first or (start, direction, colour, told)
        check(np.abs(start - first[0]).max() < 1e-5 and np.abs(direction - first[1]).max() < 1e-6 and np.array_equal(colour, first[2]),
              f"{file}: other rays")
        for k in ("scintillation", "cherenkov"):
            check(math.isclose(told[k], first[3][k], rel_tol=1e-12), f"{file}: {told} {first[3]}")
    check(math.isclose(first[3]["scintillation"], (2000 * deposit / (1 + 0.126 * deposit / length)).sum(), rel_tol=1e-12), "Birks")


def check_cherenkov():
    for medium, index, number, angle in (("water", 1.33, 332.17, 41.247), ("heavy", 1.47, 410.54, 47.135)):
        file = ray_files.csv("one.csv", "x,y,z,dx,dy,dz,length,energy", *[[v] for v in (0, 0, 0, 0, 0, 1, 10, 2)])
        path = scene(file, ", emit: cherenkov")
        pathlib.Path(path).write_text(pathlib.Path(path).read_text("utf-8").replace("medium: bar", f"medium: {medium}"), "utf-8")
        told = photons(path)
        check(abs(told["cherenkov"] - number) < 0.006 and told["scintillation"] == 0, f"{index}: {told}")
        run("trace", path, "-o", "a.raymap", "-n", 50000, "--quiet", "--force")
        _, start, direction, colour = rays("a.raymap")
        check(np.abs(np.degrees(np.arccos(direction[:, 2])) - angle).max() < 2e-3, f"{index}: angle")
        check(0 < start[:, 2].min() and start[:, 2].max() < 10 and abs(start[:, 2].mean() - 5) < 4 * 10 / math.sqrt(12 * 50000), "place")
        edge = np.arange(300, 601, 10)
        seen, _ = np.histogram(colour, edge)
        want = 50000 * (1 / edge[:-1] - 1 / edge[1:]) / (1 / 300 - 1 / 600)
        chi = ((seen - want) ** 2 / want).sum()
        check(chi < 29 + 4 * math.sqrt(58), f"{index}: flat in energy, chi-square {chi} of 29")
    path = scene(file, ", emit: [cherenkov], wavelengths: [300, 400]")
    pathlib.Path(path).write_text(pathlib.Path(path).read_text("utf-8").replace("medium: bar", "medium: water"), "utf-8")
    check(abs(photons(path)["cherenkov"] - 332.168 / 2) < 0.01, "300 to 400 nm: half of it")


def check_colour():
    """XYZ of photons that are counted: h c / wavelength each, by their stored wavelengths."""
    ray_files.csv("one.csv", "x,y,z,dx,dy,dz,length,energy", *[[v] for v in (0, 0, 0, 0, 0, 1, 10, 2)])
    path = scene("one.csv")
    text = pathlib.Path(path).read_text("utf-8").replace("{from: 305, to: 595, step: 10}", "[420, 450, 500, 550, 600]")
    pathlib.Path(path).write_text(text, "utf-8")
    bar = {420: (.13438, .004, .6456), 450: (.3362, .038, 1.77211), 500: (.0049, .323, .272), 550: (.43345, .99495, .00875), 600: (1.0622, .631, .0008)}
    run("trace", path, "-o", "a.raymap", "-n", 20000, "--quiet", "--force")
    told = photons(path)
    _, _, _, colour = rays("a.raymap")
    each = (told["scintillation"] + told["cherenkov"]) / 20000
    energy = {nm: each * (colour == nm).sum() * 6.62607015e-34 * 299792458 / (nm * 1e-9) for nm in bar}
    check(sum((colour == nm).sum() for nm in bar) == 20000 and min(energy.values()) > 0, "light of every wavelength")
    found = json.loads(run("detector", "a.raymap", "far", "--quantity", "flux", "--xyz", "--json"))["colour"]
    check(found["unit"] == "lm s", found["unit"])
    for k, got in enumerate(found["XYZ"]):
        want = 683 * sum(energy[nm] * bar[nm][k] for nm in bar)
        check(math.isclose(got, want, rel_tol=2e-4), f"XYZ {k}: {got} not {want}")


def check_maps():
    file = ray_files.csv("m.csv", HEAD, *COLUMNS)
    path, digests = scene(file, ", at: [1, 2, 3], rotate: [10, 20, 30]"), set()
    for target, ranks, encoding in (("a.raymap", 1, "compact"), ("b.raymap", 2, "compact"), ("c.raymap", 3, "plain"), ("d.raymap", 4, "compact")):
        run("trace", path, "-o", target, "-n", 20000, "--quiet", "--force", "--encoding", encoding, ranks=ranks)
    pathlib.Path(file).unlink()
    for target in "abcd":
        run("verify", f"{target}.raymap")
        digests.add(json.loads(run("info", f"{target}.raymap", "--json"))["digest"])
        run("report", f"{target}.raymap", 77)
    check(len(digests) == 1, f"one map: {digests}")
    run("draw", "a.raymap", "--view", "xz", "--limit", 20, "-o", "a.svg", "--force")
    run("report", "a.raymap", "--html", "-o", "r.html", "--force")


def by_row(start):
    """Which step each start lies on: the nearest line."""
    off = start[:, None, :] - place[None]
    along = np.clip((off * way[None]).sum(2), 0, length[None])
    return np.linalg.norm(off - along[..., None] * way[None], axis=2).argmin(1)


def check_counted():
    ray_files.csv("n.csv", HEAD, *COLUMNS)
    path = scene("n.csv", ", count: counted, seed: 5")
    told = photons(path)
    number = round(told["scintillation"] + told["cherenkov"])
    expected = photons(scene("n.csv"))
    for k in ("scintillation", "cherenkov"):
        check(abs(told[k] - expected[k]) < 4 * math.sqrt(expected[k]), f"counted {told} expected {expected}")
    path = scene("n.csv", ", count: counted, seed: 5")
    run("trace", path, "-o", "n.raymap", "--quiet", "--force")
    ids, start, _, _ = rays("n.raymap")
    check(len(ids) == number, f"each photon is a ray: {len(ids)} {number}")
    of = event[by_row(start)]
    check((np.diff(of) >= 0).mean() > 0.999, "event by event")
    run("trace", scene("n.csv"), "-o", "w.raymap", "-n", 100000, "--quiet", "--force")
    _, start, _, _ = rays("w.raymap")
    share = np.bincount(event[by_row(start)], minlength=110)[100:] / 100000
    total = expected["scintillation"] + expected["cherenkov"]
    counts = np.bincount(of, minlength=110)[100:]
    z = (counts - share * total) / np.sqrt(share * total + share * total**2 / 100000)
    check(np.abs(z).max() < 4, f"weighted and counted, by event: z {z}")
    check(photons(scene("n.csv", ", count: counted, seed: 6")) != told, "another seed, other numbers")
    path = scene("n.csv", ", count: counted, seed: 5")
    said = run("trace", path, "-o", "x.raymap", "-n", number + 1, "--quiet", "--force", status=2)
    check(f"the scene has {number} photons, each of which is a ray" in said, said)
    run("trace", path, "-o", "x.raymap", "-n", 100, "--quiet", "--force")
    said = run("trace", path, "-o", "x.raymap", "-n", number - 99, "--append", "--quiet", status=2)
    check("are too many" in said, said)
    run("trace", path, "-o", "x.raymap", "-n", number - 100, "--append", "--quiet")
    check(json.loads(run("info", "x.raymap", "--json"))["digest"] == json.loads(run("info", "n.raymap", "--json"))["digest"], "in two parts")
    wide = photons(scene("n.csv", ", count: counted, emit: scintillation", ", resolution: 0"))
    check(abs(wide["scintillation"] - expected["scintillation"]) < 4 * math.sqrt(N / 4), f"resolution 0: {wide}")


def check_mistakes():
    row = "0,0,0,0,0,1,1,1"
    for text, more, said in (
            ("x,y,z,dx,dy,dz,energy\n0,0,0,0,0,1,1\n", "", "it has no column length: steps need x, y, z, dx, dy, dz, length, energy"),
            ("x,y,z,dx,dy,dz,length,energy,weight\n" + row + ",1\n", "", "it has a column 'weight'; known are x, y, z, dx, dy, dz, length"),
            ("x (mm),y (mm),z (mm),dx,dy,dz,length,energy\n" + row + "\n", "", "'length': it has the unit of x, y and z"),
            ("x,y,z,dx,dy,dz,length,energy (J)\n" + row + "\n", "", "'J' is no unit of its column 'energy'"),
            ("x,y,z,dx,dy,dz,length,energy\n0,0,0,0,0,1,-1,1\n", "", "step 1: its length must be 0 or greater"),
            ("x,y,z,dx,dy,dz,length,energy,beta\n" + row + ",1.5\n", "", "step 1: its beta must be greater than 0 and at most 1"),
            ("x,y,z,dx,dy,dz,length,energy,beta\n" + row + ",0.1\n", ", emit: cherenkov", "its steps make no light in this medium"),
            ("x,y,z,dx,dy,dz,length,energy\n" + row + "\n", ", emit: [light]", "unknown light of steps 'light'"),
            ("x,y,z,dx,dy,dz,length,energy\n" + row + "\n", ", seed: 5", "'seed' is of the numbers of photons with 'count: counted'"),
            ("x,y,z,dx,dy,dz,length,energy\n" + row + "\n", ", wavelengths: [500, 400]", "'wavelengths' are from and to"),
            ("x,y,z,dx,dy,dz,length,energy\n" + row + "\n", ", flux: 1 W", "unknown key in steps of particles: 'flux'"),
            ("x,y,z,dx,dy,dz,length,energy\n" + row + "\n", ", count: counted}, {name: b, type: steps, file: y.csv, medium: bar",
             "source 'muon' has 'count: counted'")):
        pathlib.Path("y.csv").write_text(text, encoding="ascii")
        told = run("check", scene("y.csv", more), status=3)
        check(said in told, f"{text}{more}: {said}\n{told}")
    path = scene("y.csv", ", emit: scintillation")
    pathlib.Path(path).write_text(pathlib.Path(path).read_text("utf-8").replace("medium: bar", "medium: water"), "utf-8")
    check("medium 'water' of source 'muon' does not scintillate" in run("check", path, status=3), "no scintillator")
    ray_files.mcpl("y.mcpl", place, way, 1 + time, time)
    check("it has no polarisation" in run("check", scene("y.mcpl"), status=3), "MCPL without lengths")
    check("'y.tm25ray' is no file of steps by its name" in run("check", scene("y.tm25ray"), status=3), "TM-25")
    for key, said in (("birks: 0.126 mm/MeV", None), ("birks: 0.126 MeV/mm", "'birks' must be a length per energy"), ("birks: -1", "'birks' must be"),
                      ("rise: 1 ns", "'rise' is that of light that decays"), ("decay: []", "'decay' has 1 to 8 components"),
                      ("decay: [{time: 1 mm}]", "has no unit 'mm'"), ("per_meV: 3", "unknown key in scintillation: 'per_meV'")):
        text = pathlib.Path(scene("n.csv")).read_text("utf-8")
        at = text.index("scintillation: {")
        pathlib.Path("s.yaml").write_text(text[:at] + "scintillation: {per_MeV: 100, " + key + "}}" + text[text.index("\nsources"):], "utf-8")
        told = run("check", "s.yaml", status=0 if said is None else 3)
        check(said is None or said in told, f"{key}: {said}\n{told}")


check_formats()
check_cherenkov()
check_colour()
check_maps()
check_counted()
check_mistakes()
asking.finish()
