#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""raymap-step on files of known bodies: closed meshes whose vertices lie on the true surfaces, exact volumes and areas, ids
that another revision has again, shared shapes, colours, units, materials, touching faces; refusals; files of a stranger."""
import os
import pathlib
import random
import re
import shutil
import subprocess
import time
from math import hypot, pi, sqrt

from cad_tools import MAKER, SLOW, STEP, check, finish  # skips where there is no converter
import cad_mesh
import numpy as np

SOURCE = pathlib.Path(os.environ["SOURCE_DIR"])


def near(a, b, relative, what):
    check(abs(a - b) <= relative * abs(b), f"{what}: {a!r}, expected {b!r}")


def convert(path, *more, status=0):
    shutil.rmtree("out", ignore_errors=True)
    done = subprocess.run([STEP, path, "out", *more], capture_output=True, text=True, check=False, timeout=120)
    check(done.returncode == status, f"{path}: {done.returncode} {done.stderr}")
    return done.stderr if status else cad_mesh.Assembly("out")


def cap(radius, aperture):
    return radius - sqrt(radius**2 - aperture**2)


def cap_volume(radius, aperture):
    sag = cap(radius, aperture)
    return pi * sag**2 * (3 * radius - sag) / 3


def lens(front, back, a, thickness):
    """Volume and area of a biconvex lens; a flat back where it is 0."""
    s1, s2 = cap(front, a), cap(back, a) if back else 0
    volume = cap_volume(front, a) + (cap_volume(back, a) if back else 0) + pi * a**2 * (thickness - s1 - s2)
    return volume, 2 * pi * front * s1 + (2 * pi * back * s2 if back else pi * a**2) + 2 * pi * a * (thickness - s1 - s2)


BODIES = {  # volume, area, kinds of the faces, relative exactness of the integrals
    "box": (6000, 2200, "plane " * 6, 1e-12),
    "cylinder": (pi * 49 * 17, 2 * pi * 7 * 17 + 2 * pi * 49, "cylinder plane plane", 1e-12),
    "sphere": (4 / 3 * pi * 729, 4 * pi * 81, "sphere", 1e-12),
    "cone": (pi * 10 / 3 * (64 + 24 + 9), pi * (8 + 3) * hypot(10, 5) + pi * (64 + 9), "cone plane plane", 1e-12),
    "tip": (pi * 10 / 3 * 64, pi * 8 * hypot(10, 8) + pi * 64, "cone plane", 1e-12),
    "torus": (2 * pi**2 * 20 * 25, 4 * pi**2 * 100, "torus", 1e-11),
    "plano-convex": (*lens(51.68, 0, 12.7, 4), "sphere cylinder plane", 1e-11),
    "biconvex": (*lens(50, 80, 12.7, 6), "sphere cylinder sphere", 1e-11),
    # The same surfaces as rational B-splines, found again.
    "spline-lens": (*lens(50, 80, 12.7, 6), "sphere cylinder sphere", 1e-6),
    "spline-cone": (pi * 10 / 3 * (64 + 24 + 9), pi * (8 + 3) * hypot(10, 5) + pi * (64 + 9), "cone plane plane", 1e-6),
    "spline-torus": (2 * pi**2 * 20 * 25, 4 * pi**2 * 100, "torus", 1e-6),
    "inside-out": (6000, 2200, "plane " * 6, 1e-12),
    "loose": (6000, 2200, "plane " * 6, 1e-12),
}


def check_mesh(mesh, shape):
    name = shape["name"]
    check(shape["closed"] and not mesh.open_edges(), f"{name}: closed")
    check(mesh.off() <= 1e-9, f"{name}: vertices lie {mesh.off()} off the true surfaces")
    check(abs(mesh.volume() - shape["volume"]) <= shape["area"] * shape["chord"], f"{name}: volume of the mesh {mesh.volume()}")
    near(mesh.area(), shape["area"], 0.01, f"{name}: area of the mesh")
    check(np.ptp(mesh.vertices, axis=0).max() > 0 and np.allclose(
        shape["bounds"], [mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)], atol=1e-12), f"{name}: bounds")
    check([cad_mesh.KINDS[k] for k in mesh.surfaces["kind"]] == [face["surface"] for face in shape["faces"]], f"{name}: kinds")
    near(sum(face["area"] for face in shape["faces"]), shape["area"], 1e-9, f"{name}: sum of the faces")


def check_bodies():
    for name, (volume, area, kinds, exact) in BODIES.items():
        if not SLOW and name in ("cylinder", "tip", "plano-convex", "spline-cone"):  # others have their kinds of faces
            continue
        assembly = convert(f"cad/{name}.step")
        shape = assembly.data["shapes"][0]
        near(shape["volume"], volume, exact, f"{name}: volume")
        near(shape["area"], area, exact, f"{name}: area")
        check(sorted(face["surface"] for face in shape["faces"]) == sorted(kinds.split()), f"{name}: {shape['faces']}")
        check_mesh(assembly.mesh("s1"), shape)
        said = [finding["text"] for finding in assembly.data["findings"]]
        check(bool(said) == (name == "loose"), f"{name}: {said}")
        if name in ("biconvex", "spline-lens"):  # a lens in a STEP file is the lens: radius and vertex of the spherical faces
            spheres = sorted((row["r1"], row["oz"]) for row in assembly.mesh("s1").surfaces if row["kind"] == 4)
            check(np.allclose(spheres, [(50, 50), (80, -74)], atol=1e-9), f"spheres of {name} {spheres}")
    shape = convert("cad/thread.step").data["shapes"][0]
    check(shape["closed"], "a thread is closed")
    finer = convert("cad/thread.step", "--chord", "0.002", "--angle", "6")
    mesh = finer.mesh("s1")
    check(not mesh.open_edges() and mesh.off() < 1e-9 and finer.data["chord"] == 0.002, "a finer thread")
    near(mesh.volume(), finer.data["shapes"][0]["volume"], 0.03, "thread")
    sheet = convert("cad/sheet.step")
    check(not sheet.shapes["s1"]["closed"] and "no closed body" in sheet.data["findings"][0]["text"], "a sheet is told")


def check_luminaire():
    parts = {"luminaire/housing": "housing", "luminaire/optics/reflector": "reflector", "luminaire/optics/lens": "lens",
             "luminaire/bolt": "bolt left", "luminaire/bolt.2": "bolt right"}
    first, hashes = None, None
    for name, schema, unit in (("luminaire", "AP214", "millimetre"), ("luminaire-203", "AP203", "millimetre"),
                               ("luminaire-242", "AP242", "millimetre"), ("luminaire-inch", "AP214", "INCH")):
        it = convert(f"cad/{name}.step")
        check((it.data["schema"], it.data["file_unit"], it.data["unit"]) == (schema, unit, "mm"), f"{name}: schema and unit")
        leaves = it.leaves()
        check({part: row["name"] for part, row in leaves.items()} == parts, f"{name}: parts {leaves.keys()}")
        check(leaves["luminaire/bolt"]["shape"] == leaves["luminaire/bolt.2"]["shape"] and len(it.shapes) == 4,
              f"{name}: bolts share a shape")
        check(np.allclose(leaves["luminaire/housing"]["color"], [0.2, 0.2, 0.25], atol=1e-6), f"{name}: colour")
        check(leaves["luminaire/bolt.2"]["color"] == [1, 0, 0] and leaves["luminaire/bolt"]["color"] is None,
              f"{name}: colour of one use")
        check(leaves["luminaire/optics/lens"]["material"] == "N-BK7", f"{name}: material")
        check(np.allclose(leaves["luminaire/optics/lens"]["world"][:3, 3], [0, 0, 38], atol=1e-7), f"{name}: place")
        faces = it.shapes[leaves["luminaire/optics/lens"]["shape"]]["faces"]
        check([1, 0.5, 0] in [face["color"] for face in faces], f"{name}: colour of a face {faces}")
        hashes = hashes or {shape["name"]: (shape["hash"], shape["form"]) for shape in it.data["shapes"]}
        check(hashes == {shape["name"]: (shape["hash"], shape["form"]) for shape in it.data["shapes"]}, f"{name}: hashes")
        for shape in it.data["shapes"] if name == "luminaire-inch" else ():
            check_mesh(it.mesh(shape["id"]), shape)
        a, b, area = it.data["touching"][0]
        check(len(it.data["touching"]) == 1 and {a, b} == {"luminaire/housing", "luminaire/optics/lens"}, f"{name}: touching")
        if first is None:
            first = it
            near(area, pi * (2 * 90 * 8 - 64 - 34**2), 0.01, "area of the lens's flat side on the rim") \
                if area else check(False, "touching area")
    # A part moved and one renamed: its ids stay, by the product's id; the shapes, too.
    text = pathlib.Path("cad/luminaire-revised.step").read_text(encoding="utf-8")
    check("PRODUCT('lens','lens'" in text, "the maker's words")
    pathlib.Path("renamed.step").write_text(text.replace("PRODUCT('lens','lens'", "PRODUCT('lens','cover'"), encoding="utf-8")
    second = convert("renamed.step")
    check(list(second.parts) == list(first.parts), f"ids of a revision {list(second.parts)}")
    check({shape["hash"] for shape in second.data["shapes"]} == {shape["hash"] for shape in first.data["shapes"]},
          "hashes of a revision")
    moved = [part for part in first.parts if first.parts[part]["matrix"] != second.parts[part]["matrix"]]
    check(moved == ["luminaire/bolt.2"], f"what moved: {moved}")
    # Ids of uses that are no mere counts belong to the id.
    pathlib.Path("named.step").write_text(re.sub(r"OCCURRENCE\('\d+','bolt left'", "OCCURRENCE('left:1','bolt left'", text), encoding="utf-8")
    check("luminaire/bolt:left:1" in convert("named.step").parts, "ids of uses")


def check_copies():
    it = convert("cad/copies.step")
    leaves = list(it.leaves().values())
    check([part["shape"] for part in leaves] == ["s1", "s1", "s1", "s2", "s2", "s3"], "copies share")
    determinants = [round(np.linalg.det(part["world"][:3, :3]), 9) for part in leaves]
    check(determinants == [1, 1, -1, 1, 1, 1], f"mirrored {determinants}")
    # The copies as they lie: the mirrored one ends at x = -40 - 10.
    ends = [(it.mesh(part["shape"]).vertices @ part["world"][:3, :3].T + part["world"][:3, 3])[:, 0].min() for part in leaves]
    near(ends[2], -50, 1e-12, "the mirrored copy")
    check(len({shape["form"] for shape in it.data["shapes"]}) == 3, "30 and 30.001 mm are not one form")


def check_doublet():
    it = convert("cad/doublet.step", "--chord", "0.002")
    (_, _, area), = it.data["touching"]
    near(area, 2 * pi * 40 * cap(40, 12), 1e-3, "area of the cement")


def check_iges():
    for name in ("brep", "faces"):
        it = convert(f"cad/lens-{name}.igs")
        shape = it.data["shapes"][0]
        check(it.data["schema"] == "IGES" and it.data["file_unit"] == "MM", f"{name}: schema and unit")
        near(shape["volume"], lens(50, 80, 12.7, 6)[0], 1e-6, f"IGES {name}: volume")
        check(it.data["parts"][0]["color"] == [1, 0, 0], f"IGES {name}: colour {it.data['parts']}")
        check_mesh(it.mesh("s1"), shape)


def check_downloaded():
    """A file of another program, in metres; its colours are those of its text."""
    path = SOURCE.parent / "shared/validation/data/cad/cadquery_red_cube_blue_cylinder.step"
    if not path.exists():
        print("no corpus here: a file of another program not checked")
        return
    it = convert(path)
    colors = {name: [round(255 * c) for c in part["color"]] for name, part in it.leaves().items()}
    check(it.data["file_unit"] == "METRE" and colors == {"blue_cylinder": [59, 97, 180], "red_cube": [221, 82, 40]}, f"{colors}")
    near(it.data["shapes"][0]["volume"], pi * 250, 1e-12, "cylinder of 10 mm")


def check_refusals():
    pathlib.Path("text.step").write_text("no CAD\n", encoding="utf-8")
    pathlib.Path("empty.step").write_text("ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n", encoding="utf-8")
    if not pathlib.Path("pipe.step").exists():
        os.mkfifo("pipe.step")
    for name, said in (("text.step", "neither STEP"), ("pipe.step", "not a regular file"), ("none.step", "No such file"),
                       ("empty.step", "empty.step: ")):
        text = convert(name, status=3)
        check(said in text and text.count("\n") == 1, f"{name}: {text}")
    check("--chord" in convert("cad/box.step", "--chord", "-1", status=2), "a chord below 0")
    pathlib.Path("full").mkdir(exist_ok=True)
    pathlib.Path("full/mine").write_text("mine", encoding="utf-8")
    done = subprocess.run([STEP, "cad/box.step", "full"], capture_output=True, text=True, check=False)
    check(done.returncode == 2 and os.listdir("full") == ["mine"], "a folder with something in it is left")
    same = [convert("cad/doublet.step") and pathlib.Path("out/assembly.json").read_bytes() for _ in range(2)]
    check(same[0] == same[1], "the same bytes again")


def check_strangers():
    """Mutated files end, soon, in a result or one line, or the process alone dies."""
    dice = random.Random(7)
    crashed, each = 0, 12 if SLOW else 2
    for source in ("cad/biconvex.step", "cad/luminaire.step", "cad/lens-faces.igs"):
        text = pathlib.Path(source).read_bytes()
        for k in range(each):
            data = bytearray(text)
            for _ in range(dice.randint(1, 12)):
                at = dice.randrange(len(data))
                data[at:at + dice.randint(0, 3)] = dice.choice([b"", b"#1", b"$", b"1E308", b"-", b"(", b"9999", b"*", b"\0"])
            path = pathlib.Path("strange" + pathlib.Path(source).suffix)
            path.write_bytes(data)
            shutil.rmtree("out", ignore_errors=True)
            start = time.monotonic()
            done = subprocess.run([STEP, path, "out", "--quiet"], capture_output=True, check=False, timeout=100)
            check(done.returncode in (0, 3, 5) or done.returncode < 0, f"{source} {k}: {done.returncode}")
            check(done.returncode == 0 or done.stderr.startswith(b"raymap-step: strange") and done.stderr.count(b"\n") == 1,
                  f"{source} {k}: {done.returncode} {done.stderr!r}")
            check(time.monotonic() - start < 60, f"{source} {k}: {time.monotonic() - start} s")
            check(done.returncode != 0 or pathlib.Path("out/assembly.json").exists(), f"{source} {k}: nothing written")
            crashed += done.returncode < 0
    print(f"{crashed} of {3 * each} mutated files crashed OpenCASCADE, and the converter alone")


shutil.rmtree("cad", ignore_errors=True)
os.mkdir("cad")
subprocess.run([MAKER, "cad"], check=True)
for part in (check_bodies, check_luminaire, check_copies, check_doublet, check_iges, check_downloaded, check_refusals,
             check_strangers):
    part()
finish()
