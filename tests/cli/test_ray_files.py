#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rays from files: the same ones in every format, each in its turn, with their colours; mistakes are told; maps need no file and are
the same on any number of ranks and in either encoding; rows are drawn by their powers; starts on a surface."""
import gzip
import json
import pathlib

import asking
import h5py
import numpy as np
import ray_files
from asking import check, run, told_of
import raymap.serve
from ray_files import NAN

SCENE = """raymap: 1
units: cm
spectrum: {wavelengths: [450, 550, 650]}
media: {air: {index: 1}}
sources: [{name: led, type: ray_file, file: FILE, medium: air, flux: 2 WMORE}]
detectors: [{name: far, type: intensity, cells: [9, 4]}]
"""
N = 1000
dice = np.random.default_rng(5)
place = dice.normal(size=(N, 3)) * [3, 2, 1]  # mm
way = dice.normal(size=(N, 3))
way /= np.linalg.norm(way, axis=1)[:, None]
nm = dice.choice([450.0, 550.0, 650.0], N)
event = np.arange(N) // 7
time = dice.uniform(0, 20, N)


def scene(file, more="", text=SCENE, name="scene.yaml"):
    pathlib.Path(name).write_text(text.replace("FILE", file).replace("MORE", more), encoding="utf-8")
    return name


def complaints(path):
    """What check says of it, which the server is asked."""
    return told_of(SERVER, pathlib.Path(path).read_text(encoding="utf-8"))


def digest(target):
    with h5py.File(target + "/map.h5") as index:
        return index.attrs["digest"].decode()


def rays(target):
    """Starts in mm, directions, wavelengths by id, and their sources."""
    run("query", target, "all", "-o", "rays.h5", "--force", "--columns", "ray,registration")
    with h5py.File("rays.h5") as file:
        ray, far = file["ray"], file["registration"]
        check(np.array_equal(ray["id"], far["ray_id"]), "each ray is registered once")
        return (10 * np.column_stack([ray[f"start_{k}"] for k in "xyz"]), np.column_stack([far[f"direction_{k}"] for k in "xyz"]),
                np.array(ray["wavelength"]), np.array(ray["source"]))


def formats():
    columns = [*place.T, *way.T]
    head = "x (mm),y [mm],z(mm),dx,dy,dz"
    yield ray_files.tm25("a.tm25ray", place, way, np.ones(N), [1, 1, 1, 1, 0, 0, 0, 0], [nm], 2), True
    yield ray_files.tm25("b.TM25", place, way, np.ones(N), [1, 1, 1, 1, 1, 1, 1, 0], [nm, *[nm] * 9, nm, nm], 2, names=("portion", "number"),
                         text=b"text" * 16), True
    yield ray_files.lighttools("c.ray", place, way, np.ones(N)), False
    yield ray_files.csv("d.csv", head + ",wavelength,time (ns),event", *columns, nm, time, event), True
    yield ray_files.csv("e.csv", head + ",energy (eV),weight", *columns, 1239.841984332 / nm, np.full(N, 3.0)), True
    yield ray_files.hdf5("f.h5", {"position": (place / 1000, "m"), "direction": (way, None), "wavelength": (nm / 1000, "um"),
                                  "event": (event, None), "time": (time, "ns")}), True
    yield ray_files.hdf5("g.h5", {**{k: (place[:, i].astype("f4"), "mm") for i, k in enumerate("xyz")},
                                  **{k: (way[:, i].astype("f4"), None) for i, k in enumerate(("dx", "dy", "dz"))},
                                  "energy": (1239.841984332e-3 / nm, "keV")}), True
    yield ray_files.mcpl("h.mcpl", place, way, nm, time), True
    yield ray_files.mcpl("i.mcpl", place, way, nm, time, np.ones(N), event, True, np.full(N, 22), True), True
    yield ray_files.mcpl("j.mcpl", place, way, nm, time, np.ones(N), event, version=2), True
    for name in "d.csv", "i.mcpl", "a.tm25ray":  # packed, by the name or not
        pathlib.Path(name + ".gz").write_bytes(gzip.compress(pathlib.Path(name).read_bytes()))
        yield name + ".gz", True
    pathlib.Path("k.mcpl").write_bytes(pathlib.Path("i.mcpl.gz").read_bytes())
    yield "k.mcpl", True


def together(paths, n, text=SCENE):
    """Starts, directions, wavelengths of n rays of each of these files, all sources of one scene."""
    its = text[text.index("{name: led"):text.index("]\ndetectors")]
    many = ", ".join(its.replace("FILE", path).replace("name: led", f"name: led{k}, rays_share: 1").replace("MORE", "") for k, path in enumerate(paths))
    run("trace", scene("", text=text.replace(its, many)), "-o", "a.raymap", "-n", n * len(paths), "--quiet", "--force")
    *columns, source = rays("a.raymap")
    return [[column[source == k] for column in columns] for k in range(len(paths))]


def check_formats():
    paths = dict(formats())
    row = np.arange(1500) % N
    for (path, coloured), (start, direction, colour) in zip(paths.items(), together(paths, 1500)):
        check(np.abs(start - place[row]).max() < 1e-5, f"{path}: starts, {np.abs(start - place[row]).max()} mm")
        check(np.abs(direction - way[row]).max() < 1e-6, f"{path}: directions")
        check(not coloured or np.array_equal(colour, nm[row]), f"{path}: wavelengths {colour[:5]} {nm[:5]}")
        if not coloured:
            check(np.isnan(colour).all(), f"{path}: the source's spectrum")


def check_maps():
    powers = np.where(np.arange(N) % 3 == 0, 0.5, 1.5)
    file = ray_files.tm25("m.tm25ray", place, way, powers, [1, 1, 1, 1, 0, 0, 0, 0], [nm], 2)
    path = scene(file, ", at: [1, 2, 3], rotate: [10, 20, 30], scale: 0.5")
    for target, ranks, encoding in (("a.raymap", 1, "compact"), ("b.raymap", 2, "compact"), ("c.raymap", 4, "plain")):
        run("trace", path, "-o", target, "-n", 20000, "--quiet", "--force", "--encoding", encoding, ranks=ranks)
    pathlib.Path(file).unlink()
    run("verify", "b.raymap")
    run("report", "c.raymap", 77)
    digests = {digest(target) for target in ("a.raymap", "b.raymap", "c.raymap")}
    check(len(digests) == 1, f"one map: {digests}")
    run("draw", "a.raymap", "--view", "xz", "--limit", 20, "-o", "a.svg", "--force")
    run("report", "a.raymap", "--html", "-o", "r.html", "--force")
    start, *_ = rays("a.raymap")
    for k in range(20):  # each N rays have every row as often as its power asks for, to one
        _, count = np.unique(start[k * N:(k + 1) * N].round(4), axis=0, return_counts=True)
        check(count.max() <= 2, f"rays {k * N}: a row {count.max()} times")
    first = start[np.arange(20000) % N == 0]
    check(len(np.unique(first, axis=0)) > 1, "where the parts begin changes")
    lengths = np.linalg.norm(start - [10, 20, 30], axis=1)
    _, index = np.unique(np.linalg.norm(place, axis=1).round(3), return_index=True)
    order = np.argsort(np.linalg.norm(place, axis=1))
    near = np.searchsorted(np.linalg.norm(place, axis=1)[order], 2 * lengths)
    low = np.clip(near - 1, 0, N - 1)
    high = np.clip(near, 0, N - 1)
    size = np.linalg.norm(place, axis=1)[order]
    of = order[np.where(np.abs(size[low] - 2 * lengths) < np.abs(size[high] - 2 * lengths), low, high)]
    count = np.bincount(of, minlength=N)
    want = 20000 * powers / powers.sum()
    check(np.abs(count - want).max() <= 3, f"rows by their powers: {np.abs(count - want).max()} off")


def check_flux():
    one = ([[0, 0, 0]], [[0, 0, 1]])
    for file, said in ((ray_files.tm25("l.tm25ray", *one, [5], [1, 1, 0, 0, 1, 0, 0, 0], flux=(7, NAN)), "source led: 7 lm"),
                       (ray_files.tm25("w.tm25ray", *one, [5], flux=(7, 3)), "source led: 3 W"),
                       (ray_files.tm25("s.tm25ray", *one, [5]), "source led: 5 W"),
                       (ray_files.tm25("n.tm25ray", *one, [NAN]), "source led: 1 W"),
                       (ray_files.lighttools("l.ray", *one, [5], data="luminous_flux", flux="12.5"), "source led: 12.5 lm")):
        told = run("check", scene(file, text=SCENE.replace(", flux: 2 W", "")))
        check(said in told, f"{file}: {said}\n{told}")
    file = ray_files.tm25("t.tm25ray", place, way, np.ones(N), [1, 1, 1, 0, 0, 0, 0, 1], [1 + np.arange(N) % 2], 4,
                          tables=[[(449, 0), (450, 1), (451, 0)], [(550, 1), (650, 1)]])
    run("trace", scene(file), "-o", "t.raymap", "-n", N, "--quiet", "--force")
    _, _, colour, _ = rays("t.raymap")
    check((colour[::2] == 450).all() and abs((colour[1::2] == 550).mean() - 0.5) < 0.01, "spectra of their own")
    file = ray_files.tm25("u.tm25ray", place, way, np.ones(N), spectrum=1, nm=550)
    run("trace", scene(file), "-o", "t.raymap", "-n", N, "--quiet", "--force")
    check((rays("t.raymap")[2] == 550).all(), "one wavelength")


def check_mistakes():
    good = pathlib.Path(ray_files.tm25("x.tm25ray", place, way, np.ones(N))).read_bytes()
    def bad(at, what):
        return good[:at] + what + good[at + len(what):]
    text = pathlib.Path(ray_files.lighttools("x.ray", place[:3], way[:3], np.ones(3))).read_text("ascii")
    photons = pathlib.Path(ray_files.mcpl("x.mcpl", place, way, nm, time)).read_bytes()
    for name, raw, said in (
            ("y.tm25ray", b"", "it ends after 0 bytes, in its head"),
            ("y.tm25ray", good[:300], "it ends after 300 bytes, in its texts"),
            ("y.tm25ray", good[:-1], "it says that it has 1000 rays of 7 numbers, and ends after 999"),
            ("y.tm25ray", bad(0, b"TM26"), "it does not begin with TM25"),
            ("y.tm25ray", bad(4, b"\0"), "its version is 1792: 2013"),
            ("y.tm25ray", bad(60, b"\7"), "its spectral data identifier is 7"),
            ("y.tm25ray", bad(80, b"\xff\xff\xff\xff"), "its number of further columns is -1"),
            ("y.tm25ray", bad(256, b"\0"), "positions or directions are not known"),
            ("y.tm25ray", bad(264, b"\2"), "a flag of what is known is 2"),
            ("y.tm25ray", bad(36288 + 28 + 12, bytes(12)), "ray 2: its direction (0, 0, 0) is none"),
            ("y.tm25ray", bad(36288 + 28 + 24, b"\0\0\x80\xbf"), "ray 2: its power is -1"),
            ("y.ray", text.replace("lt_startofdata", "lt_started"), "line 9: 'lt_started': a line of the head"),
            ("y.ray", text.replace("millimeters", "miles"), "line 6: 'miles': it is no unit of length"),
            ("y.csv", "x,y,z,dx,dy\n", "line 1: it has no column dz"),
            ("y.csv", "x,y,z,dx,dy,dz,colour\n", "line 1: it has a column 'colour'; known are x, y, z"),
            ("y.csv", "x (mm),y (cm),z,dx,dy,dz\n", "line 1: 'y (cm)': x, y and z have one unit"),
            ("y.csv", "x,y,z,dx,dy,dz\n1,2,3,0,0\n", "line 2: '': it is no number, or one is missing"),
            ("y.csv", "x,y,z,dx,dy,dz\n1,2,3,0,0,1,5\n", "line 2: ',5': there are more numbers than columns"),
            ("y.csv", "x,y,z,dx,dy,dz\n", "it has no rays"),
            ("y.csv", "x,y,z,dx,dy,dz,time (mm)\n", "'mm' is no unit of its column 'time'"),
            ("y.mcpl", b"MCPM" + bytes(60), "it does not begin with MCPL"),
            ("y.mcpl", b"\x1f\x8b" + bytes(60), "it is packed (.gz), and damaged or cut short"),
            ("y.mcpl.gz", gzip.compress(photons)[:-20], "it is packed (.gz), and damaged or cut short"),
            ("y.mcpl.gz", gzip.compress(photons[:-3]), "it says that it has 1000 particles, and ends after 999"),
            ("y.h5.gz", gzip.compress(b""), "'y.h5.gz' is no file of rays by its name"),
            ("y.mcpl", photons.replace(b"MCPL003L", b"MCPL001L"), "it is of version 001L: versions 2 and 3"),
            ("y.mcpl", photons[:-3], "it says that it has 1000 particles, and ends after 999"),
            ("y.h5", b"no HDF5", "it is no HDF5 file"),
            ("y.abc", b"", "'y.abc' is no file of rays by its name")):
        pathlib.Path(name).write_bytes(raw if isinstance(raw, bytes) else raw.encode("ascii"))
        its, told = complaints(scene(name))
        check(its["errors"] and said in told and name in told, f"{name}: {said}\n{told}")
    for datasets, said in (({"position": (place, "mm")}, "'direction' (or dx, dy, dz) is missing"),
                           ({"position": (place, "mm"), "direction": (way[:5], None)}, "'direction' has other rows than the rest"),
                           ({"position": (place.T, "mm")}, "'position' is no table of numbers, three of each ray")):
        its, told = complaints(scene(ray_files.hdf5("y.h5", datasets)))
        check(its["errors"] and said in told, f"{said}\n{told}")
    for file, more, said in (("none.tm25ray", "", "none.tm25ray: cannot be opened"), ("x.ray", ", detector: far", "'detector' is for a map, or a file .h5"),
                             ("x.ray", ", format: step", "unknown format 'step'")):
        its, told = complaints(scene(file, more))
        check(its["errors"] and said in told, f"{file}{more}: {said}\n{told}")
    told = run("check", scene("a.tm25ray", text=SCENE.replace("450, 550, 650", "540, 560")), status=3)
    check("its rays have wavelengths from 450 to 650 nm, and the scene has 540 to 560 nm" in told, told)


SURFACES = """raymap: 1
media: {air: {index: 1}, glass: {index: 1.5}}
surfaces: {black: {type: absorber}, clear: {type: fresnel, coat: {reflectance: 0}}}
geometries: {chip: {type: rectangle, size: [9, 9]}}
objects: [{name: chip, geometry: chip, at: [0, 0, 0.1], SIDES}]
sources: [{name: led, type: ray_file, file: FILE, medium: MEDIUM}]
detectors: [{name: up, type: plane, at: [0, 0, 1], direction: [0, 0, -1], size: [99, 99], cells: 1, side: both}]
"""


def check_starts():
    """0.1 is no number of float: starts lie 1.5e-9 mm before their surface, or behind it when it is turned over."""
    up = np.column_stack([dice.uniform(-1, 1, (N, 2)), np.full(N, 0.1)]), np.abs(way) + [0, 0, 0.1]
    ray_files.tm25("s.tm25ray", *up, np.ones(N))
    for sides, medium, rest in (("surface: black", "air", "not hit(chip)"),
                                ("surface: clear, front: glass, back: air", "glass", "not hit(chip)"),
                                ("surface: clear, front: glass, back: air", "air", "hit(chip)"),
                                ("rotate: [180, 0, 0], surface: clear, front: air, back: glass", "air", "hit(chip)")):
        text = SURFACES.replace("SIDES", sides).replace("MEDIUM", medium)
        SERVER.edit(text=text.replace("FILE", "s.tm25ray"))
        SERVER.trace(N)
        told = SERVER.query(f"registered(up) and {rest}")
        check(told["rays"]["matched"] == N, f"{sides} in {medium}: {rest}\n{told}")
    run("trace", scene("s.tm25ray", text=text), "-o", "s.raymap", "-n", N, "--quiet", "--force")
    run("verify", "s.raymap")
    check(digest("s.raymap") == SERVER.status()["digest"], "in memory and in a map")


LIGHT = """raymap: 1
units: cm
spectrum: {wavelengths: [450, 550, 650]}
media: {air: {index: 1}}
sources: [SOURCES]
geometries: {ball: {type: sphere, radius: 1}}
surfaces: {black: {type: absorber}}
objects: [{name: ball, geometry: ball, surface: black, at: [0, 0, 30]}]
detectors:
  - {name: mid, type: plane, at: [0, 0, 5], size: 12, cells: 1}
  - {name: far, type: plane, at: [1, 0, 20], size: [30, 20], cells: [6, 4]}
  - {name: all, type: intensity, cells: [9, 4]}
"""
OWN = """{name: a, type: point, distribution: cosine, flux: 3 W, spectrum: {lines: {450: 1, 550: 2}}, rays_share: 2},
  {name: b, type: area, shape: {disc: 1}, at: [3, 0, 0], flux: 1 W, spectrum: {lines: {650: 1}}}"""


def arrived(target, detector):
    return json.loads(run("detector", target, detector, "--where", "registered(mid)" if target[0] == "o" else "all", "--json"))["flux"]["total"]


def check_written():
    n = 30000
    run("trace", scene("", text=LIGHT.replace("SOURCES", OWN)), "-o", "o.raymap", "-n", n, "--quiet", "--force")
    crossed = "registered(mid) and source(a)"
    flux = arrived("o.raymap", "far")
    whole = arrived("o.raymap", "mid")
    for name in "w.tm25ray", "w.mcpl", "w.h5":  # and maps: check_from_map
        told = run("query", "o.raymap", "registered(mid)", "-o", name, "--force", *(["--at", "mid"] if name != "w.h5" else []), "--json")
        rows = json.loads(told)["rays"]
        given = f", flux: {whole} W" if name == "w.mcpl" else ""  # its weights have no unit
        more = ", detector: mid" if name == "w.h5" else ""
        source = f"{{name: led, type: ray_file, file: {name}{more}{given}}}"
        run("trace", scene("", text=LIGHT.replace("SOURCES", source)), "-o", "r.raymap", "-n", 4 * rows, "--quiet", "--force")
        again = arrived("r.raymap", "far")
        check(abs(again / flux - 1) < 2e-3, f"{name}: {again} W on far, not {flux}")
    head, names, row = ray_files.read_tm25("w.tm25ray")
    check(names == ["portion", "number"] and head["spectrum"] == 2, f"{head} {names}")
    run("query", "o.raymap", "registered(mid)", "-o", "w.h5", "--force")
    with h5py.File("w.h5") as file:
        of = file["registration"]
        mid = (np.array(of["detector"]) == 0) & (np.array(of["registered"]) == 1)
        check(np.array_equal(row[:, -2] * 4096 + row[:, -1], np.array(of["ray_id"])[mid]), "ids")
        check(np.abs(row[:, 0] / 10 - np.array(of["world_x"])[mid]).max() < 1e-5, "places in mm")
        check(np.abs(row[:, 6] - np.array(of["flux"])[mid]).max() < 1e-9, "fluxes")
        check(abs(head["W"] / np.array(of["flux"])[mid].sum() - 1) < 1e-6, "flux of all")
        blue = np.array(of["source"])[mid] == 0
        check(abs((row[blue, 7] == 450).mean() - 1 / 3) < 0.01 and (row[~blue, 7] == 650).all(), "wavelengths by their shares")
    texts = set()
    for ranks in 1, 3:
        run("query", "o.raymap", crossed, "-o", "e.tm25ray", "--force", ranks=ranks)
        head, _, row = ray_files.read_tm25("e.tm25ray")
        texts.add(row.tobytes())
    check(len(texts) == 1, "one file on any number of ranks")
    length = np.linalg.norm(row[:, 3:6], axis=1)
    check(np.abs(length - 1).max() < 1e-6, "directions")
    for arguments, said in ((("-o", "x.tm25ray", "--force", "--at", "all"), "'all' is an intensity grid"),
                            (("-o", "x.tm25ray", "--force", "--at", "midd"), "did you mean 'mid'")):
        check(said in run("query", "o.raymap", "all", *arguments, status=3), said)
    check("--at is of files of rays" in run("query", "o.raymap", "all", "--at", "mid", status=2), "--at without a file")
    run("trace", "scene.yaml", "--color", "rgb", "-o", "g.raymap", "-n", 100, "--quiet", "--force")
    check("photons of MCPL have an energy" in run("query", "g.raymap", "all", "-o", "x.mcpl", "--force", status=3), "no energy")


def check_from_map():
    """The light of a map goes on as a source: as the same rays from a file, on any number of ranks, picked by a criterion."""
    run("trace", scene("", text=LIGHT.replace("SOURCES", OWN)), "-o", "o.raymap", "-n", 30000, "--time", "on", "--quiet", "--force")
    run("trace", "scene.yaml", "-o", "o3.raymap", "-n", 30000, "--time", "on", "--quiet", "--force", "--encoding", "plain", ranks=3)
    which = "registered(mid where time > 0.2 ns) and source(a)"
    told = json.loads(run("query", "o.raymap", which, "-o", "w.tm25ray", "--at", "mid", "--force", "--json"))
    run("query", "o.raymap", which, "-o", "w.mcpl", "--at", "mid", "--force")

    def again(file, more, name, *options):
        run("trace", scene(file, more, SCENE.replace(", flux: 2 W", "")), "-o", name, "-n", told["rays"], "--quiet", "--force", "--time", "on", *options)
        return rays(name)

    for name in "o.raymap", "o3.raymap/":
        got = again(name, f", detector: mid, where: '{which}'", f"r{len(name)}.raymap")
        want = again("w.tm25ray", "", "f.raymap")
        gap = [np.abs(a - b).max() for a, b in zip(got, want)]
        check(gap[0] < 1e-4 and gap[1] < 1e-6 and gap[2] == 0, f"{name}: the rays of the file {gap}")
    digests = {digest(name) for name in ("r8.raymap", "r10.raymap")}
    check(len(digests) == 1, "a map of any number of ranks and either encoding is one source")
    before, after = (json.loads(run("stats", *words, "--where", which if words[0][0] == "o" else "all", "--json"))["mean"]["value"]
                     for words in (("o.raymap", "--of", "time(mid)"), ("r8.raymap", "--of", "time(far)")))
    check(abs(after / before - 1) < 1e-6, f"times go on: {before}, {after}")
    light = json.loads(run("query", "r8.raymap", "all", "--json"))["flux"]["matched"]
    check(abs(light / json.loads(run("query", "o.raymap", which, "--json"))["flux"]["matched"] - 1) < 1e-9, f"{light} W go on")
    text = LIGHT.replace("SOURCES", "{name: led, type: ray_file, file: FILE, medium: airMORE}")
    for file, more, said in (("o.raymap", "", "it has 2 planes that detect: name one"), ("o.raymap", ", detector: all", "no plane 'all'"),
                             ("o.raymap", ", detector: mid, where: hit(bell)", "did you mean 'ball'"),
                             ("o.raymap", ", detector: mid, where: segments > 99", "none of its rays was registered there"),
                             ("w.tm25ray", ", where: all", "'where' is for a map"), ("w.tm25ray", ", detector: mid", "'detector' is for a map"),
                             ("none.raymap", "", "cannot open the ray map")):
        its, told = complaints(scene(file, more, text))
        check(its["errors"] and said in told, f"{file} {more}: {said}\n{told}")


def check_published():
    """The same 200 rays of a cylinder as TM-25 and as LightTools text (tests/data/rays)."""
    data = asking.SOURCE / "tests" / "data" / "rays"
    text = SCENE.replace("2 W", "2 lm").replace("[450, 550, 650]", "[550]")
    names = "cylinder.tm25ray", "cylinder.ray"
    for name in names:
        (pathlib.Path(name)).write_bytes((data / name).read_bytes())
    seen = together(names, 400, text)
    gap = [np.abs(a - b).max() for a, b in zip(*seen)]
    check(gap[0] < 2e-5 and gap[1] < 2e-6 and gap[2] == 0 and len(seen[0][0]) == 400, f"one cylinder in two formats: {gap}")
    check(len(np.unique(seen[0][0].round(4), axis=0)) > 150, "many different rays")


def check_mcpl_library():
    """What MCPL's own library writes is read, and it reads what a query writes."""
    library = ray_files.mcpl_library()
    if not library:
        print("MCPL's library is not here (libmcpl1): its files are those of our writer alone")
        return
    for double in False, True:
        ray_files.mcpl_by_library(library, "l.mcpl", place, way, nm, time, np.full(N, 2.5), event, double)
        run("trace", scene("l.mcpl"), "-o", "l.raymap", "-n", N, "--quiet", "--force", "--time", "on")
        starts, directions, waves, _ = rays("l.raymap")
        slack = 1e-12 if double else 2e-6
        check(np.abs(starts - place).max() < 20 * slack + 1e-5 and np.abs(directions - way).max() < 1e-6 and np.abs(waves - nm).max() < 1e-3,
              f"particles of the library, double {double}")
        told = json.loads(run("stats", "l.raymap", "--of", "time(far)", "--json"))["mean"]["value"]
        check(abs(told * 1e9 - time.mean()) < 1e-5, f"times of the library: {told}, {time.mean()}")
    run("query", "o.raymap", "registered(mid)", "-o", "q.mcpl", "--at", "mid", "--force")
    run("query", "o.raymap", "registered(mid)", "-o", "q.tm25ray", "--at", "mid", "--force")
    at, to, wave, when, weight, flags = ray_files.mcpl_read(library, "q.mcpl")
    head, names, row = ray_files.read_tm25("q.tm25ray")
    check(len(at) == len(row) and np.abs(at - row[:, :3]).max() < 1e-3 and np.abs(to - row[:, 3:6]).max() < 1e-5, "the library reads our rays")
    check(np.abs(wave - row[:, 7]).max() < 1e-2 and (flags == row[:, -2] * 4096 + row[:, -1]).all(), "with colours and ids")
    check(np.abs(weight / weight.sum() - row[:, 6] / row[:, 6].sum()).max() < 1e-9 and (np.diff(when) != 0).any(), "weights and times")


with raymap.serve.start(scene(ray_files.lighttools("one.ray", place[:3], way[:3], np.ones(3)))) as SERVER:
    check_written()
    check_published()
    check_mcpl_library()
    check_from_map()
    check_formats()
    check_maps()
    check_flux()
    check_mistakes()
    check_starts()
asking.finish()
