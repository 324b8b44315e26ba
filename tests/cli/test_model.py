#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`raymap import` and `update` of models: the tree, names, colours, units and instances of glTF, OBJ and STEP; rules outlive a
revision in which a part was moved, renamed, changed, added and taken away; edits are never lost; `faces` split a mesh without a hole."""
import json
import os
import pathlib
import re
import shutil
import subprocess

import asking
from asking import check, run
from gltf_models import TRIANGLES, box, gltf

shutil.rmtree("here", ignore_errors=True)
pathlib.Path("here").mkdir()
STEP = pathlib.Path(os.environ["BUILD_DIR"]) / "raymap-step"

MATERIALS = [
    {"name": "steel", "pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.6, 0.6, 1], "metallicFactor": 1, "roughnessFactor": 0}},
    {"name": "clear", "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.6}}},
    {"name": "red paint", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}]
HALF = 6  # triangles


def bench(name, screw_x=(0.01, 0.02, 0.03), lens_size=0.004, lens_name="Lens: a 'big' one", with_stop=True, with_cover=False):
    points, triangles = box(0.002, 0.002, 0.006)
    lens = box(lens_size, 0.004, 0.001)
    plate = box(0.05, 0.01, 0.002)
    meshes = {"screw": [(points, triangles, 0)], "lens": [(*lens, 1)],
              "plate": [(plate[0], plate[1][:HALF], 2), (plate[0], plate[1][HALF:], 0)]}
    nodes = [{"name": "bench", "children": [1, 2], "translation": [0, 0, 0.1]}, {"name": "plate", "mesh": 2},
             {"name": "optics", "children": [3], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476]},
             {"name": lens_name, "mesh": 1, "translation": [0.001, 0, 0.05]}]
    for i, x in enumerate(screw_x):
        nodes.append({"name": f"screw {i}", "mesh": 0, "translation": [x, 0, 0.004]})
        nodes[0]["children"].append(len(nodes) - 1)
    if with_stop:
        meshes["stop"] = [(*box(0.003, 0.003, 0.0005), 2)]
        nodes.append({"name": "stop", "mesh": len(meshes) - 1, "translation": [0, 0.02, 0]})
        nodes[0]["children"].append(len(nodes) - 1)
    if with_cover:
        meshes["cover"] = [(*box(0.02, 0.02, 0.001), 2)]
        nodes.append({"name": "cover", "mesh": len(meshes) - 1, "translation": [0, 0, 0.03]})
        nodes[0]["children"].append(len(nodes) - 1)
    return gltf(name, meshes, MATERIALS, nodes, [0])


def text(name):
    return pathlib.Path(name).read_text(encoding="utf-8")


def says_nothing(scene):
    done = subprocess.run([os.environ["RAYMAP"], "check", scene], text=True, capture_output=True, check=False)
    check(done.returncode == 0 and not done.stderr, f"check {scene}: {done.stderr}")
    return done.stdout


LIGHT = """sources:
  - {name: lamp, type: point, at: [2, -3, 300], direction: [0, 0, -1], distribution: {cone: 8}}
"""
RULES = """media: {schott: {glass: N-BK7}}
surfaces: {black: {type: absorber}}
attributes:
  - {match: {name: screw*}, set: {surface: black}}
  - {match: {group: optics, material: clear}, set: {inside: schott}}
  - {match: {color: '#ff0000'}, set: {surface: Acktar Metal Velvet}}
"""


def check_tree():
    told = json.loads(run("import", bench("a.gltf"), "-o", "here/bench", "--json"))
    check((told["parts"], told["groups"], told["shapes"], told["transparent"], told["closed"]) == (6, 2, 4, 1, 6), f"counts: {told}")
    parts = text("here/bench/parts.yaml")
    check(len(list(pathlib.Path("here/bench/meshes").glob("*.ply"))) == 4, "screws share a mesh")
    for words in ("screw_0", "geometry: screw", "surface: fresnel, inside: 'index_1.6'", "material: 'red paint'",
                  "Lens:_a__big__one", "# Lens: a 'big' one", "at: [0, 0, 100]", "rotate: [0, 0, 90]", "faces: [{faces: [1], surface: metal_"):
        check(words in parts, f"'{words}' in\n{parts}")
    says_nothing("here/bench/scene.yaml")
    run("render", "here/bench/scene.yaml", "-o", "here/bench.png", "-n", 2, "--size", "40x30", "--quiet")
    check(pathlib.Path("here/bench.png").stat().st_size > 200, "a picture at once")
    refused = run("trace", "here/bench/scene.yaml", "-n", 10, "--no-record", status=3)
    check("no source takes part" in refused, f"no light: {refused}")
    scene = json.loads(run("check", "here/bench/scene.yaml", "--json"))["scene"]
    box_of = scene["box"] if "box" in scene else None
    check(box_of is None or abs(box_of[1][2] - 151) < 1e-3, f"millimetres: {box_of}")


def check_rules():
    pathlib.Path("here/bench/attributes.yaml").write_text(RULES, encoding="utf-8")
    scene = text("here/bench/scene.yaml")
    pathlib.Path("here/bench/scene.yaml").write_text(scene.replace("# Light,", LIGHT + "# Light,"), encoding="utf-8")
    run("trace", "here/bench/scene.yaml", "-n", 2000, "-o", "here/bench.raymap", "--quiet")
    objects = {o["name"]: o for o in json.loads(run("info", "here/bench.raymap", "--json"))["objects"]}
    check(objects["screw_1"]["surface_front"] == "black", "a rule by name")
    check(objects["stop"]["surface_front"] == "Acktar Metal Velvet", "a rule by colour")
    check(objects["plate.body"]["surface_front"] == "Acktar Metal Velvet" and objects["plate.1"]["surface_front"].startswith("metal_"),
          f"the face of another colour keeps its surface: {objects.keys()}")
    for wrong, words in (("{match: {nam: a}, set: {omit: true}}", "did you mean 'name'"), ("{match: {name: a}}", "'set' is missing"), ("{match: {}, set: {omit: true}}", "says of no part"),
                         ("{match: {color: red}, set: {omit: true}}", "#cc3300"), ("{match: {name: nobody}, set: {omit: true}}", "fits no object"),
                         ("{match: {name: '*', face: lid}, set: {omit: true}}", "fits no face"),
                         ("{match: {name: plate, face: 7..2}, set: {omit: true}}", "runs backwards")):
        pathlib.Path("here/bench/attributes.yaml").write_text(RULES + "  - " + wrong + "\n", encoding="utf-8")
        done = subprocess.run([os.environ["RAYMAP"], "check", "here/bench/scene.yaml"], text=True, capture_output=True, check=False)
        check(words in done.stderr and "attributes.yaml:7:" in done.stderr, f"{wrong}: {done.stderr}")
    pathlib.Path("here/bench/attributes.yaml").write_text(RULES + "  - {match: {id: %s}, set: {omit: true}}\n  - {match: {name: plate, "
                                                          "face: '*'}, set: {surface: black}}\n"
                                                          % re.search(r"name: stop, id: (\w+)", text("here/bench/parts.yaml")).group(1),
                                                          encoding="utf-8")
    run("trace", "here/bench/scene.yaml", "-n", 2000, "-o", "here/bench.raymap", "--force", "--quiet")
    objects = {o["name"]: o for o in json.loads(run("info", "here/bench.raymap", "--json"))["objects"]}
    check("stop" not in objects and all(o["surface_front"] == "black" for n, o in objects.items() if n.startswith("plate.")),
          f"left out by its id, faces by a pattern: {objects}")
    pathlib.Path("here/bench/attributes.yaml").write_text(RULES, encoding="utf-8")


def check_update():
    meshes = {f.name: (f.stat().st_mtime_ns, f.stat().st_ino) for f in pathlib.Path("here/bench/meshes").glob("*.ply")}
    before = {n: text("here/bench/" + n) for n in ("scene.yaml", "attributes.yaml", "parts.yaml")}
    revised = bench("b.gltf", (0.01, 0.021, 0.03), 0.005, "objective", with_stop=False, with_cover=True)
    told = json.loads(run("update", "here/bench", revised, "--dry-run", "--json"))
    check(told["dry_run"] and all(text("here/bench/" + n) == t for n, t in before.items()), "--dry-run writes nothing")
    told = json.loads(run("update", "here/bench", revised, "--json"))
    change = {p["name"]: p["change"] for p in told["parts"]}
    check(change == {"screw_1": ["moved"], "stop": ["gone"], "cover": ["new"]} | {n: c for n, c in change.items() if n[:4] in ("Lens", "obje")},
          f"what changed: {change}")
    check(abs([p for p in told["parts"] if p["name"] == "screw_1"][0]["moved_by"] - 1) < 1e-4, "by 1 mm")
    check(told["kept"] == 3 and told["meshes"] == {"kept": 2, "written": 2, "removed": 1}, f"meshes: {told['meshes']} {told['kept']}")
    for name in ("screw.ply", "plate.ply"):
        status = pathlib.Path("here/bench/meshes", name).stat()
        check((status.st_mtime_ns, status.st_ino) == meshes[name], f"{name} is untouched")
    check(text("here/bench/scene.yaml") == before["scene.yaml"] and text("here/bench/attributes.yaml") == RULES, "the user's files are")
    says = run("update", "here/bench", revised)
    check("6 kept, 0 moved" in says, f"the same again: {says}")
    pathlib.Path("here/bench/meshes/plate.ply").unlink()
    run("update", "here/bench", revised)
    check(pathlib.Path("here/bench/meshes/plate.ply").exists(), "a mesh that was taken away is made again")
    # A renamed part of the same shape is found by it, and keeps its name in the scene.
    renamed = bench("c.gltf", (0.01, 0.021, 0.03), 0.005, "front lens", with_stop=False, with_cover=True)
    told = json.loads(run("update", "here/bench", renamed, "--json"))
    check([(p["name"], p["in_file"], p["change"]) for p in told["parts"]] == [("objective", "front lens", ["renamed"])], f"renamed: {told}")
    check("inside: 'index_1.6'" in text("here/bench/parts.yaml"), "its guess is there")
    says_nothing("here/bench/scene.yaml")


def check_edits():
    parts = pathlib.Path("here/bench/parts.yaml")
    parts.write_text(text(parts).replace("outside: air", "outside: air ", 1), encoding="utf-8")
    mine = text(parts)
    says = run("update", "here/bench", "here/c.gltf", status=2)
    check("has edits" in says and "attributes.yaml" in says and text(parts) == mine, f"edits are refused: {says}")
    run("update", "here/bench", "here/c.gltf", "--force", "--quiet")
    check(text("here/bench/parts.yaml.bak") == mine and text(parts) != mine, "and kept with --force")
    says = run("import", "here/c.gltf", "-o", "here/bench", status=2)
    check("raymap update" in says, f"another import: {says}")
    check("no folder that `raymap import` made" in run("update", "here", "here/c.gltf", status=2), "of a folder that is none")
    run("import", "here/c.gltf", "-o", "here/new", "--quiet")
    run("import", "here/b.gltf", "-o", "here/new", "--quiet")  # nobody edited it
    check("objective" in text("here/new/parts.yaml"), "an untouched import is replaced")


def check_obj():
    points, triangles = box(1, 1, 1)
    lines = ["mtllib a.mtl"]
    for name, material, shift in (("base", "blue", 0), ("lamp_shade", "glass", 3)):
        lines += [f"o {name}", f"usemtl {material}"] + ["v %g %g %g" % tuple(p + [shift, 0, 0]) for p in points]
        lines += ["f %d %d %d" % tuple(t + 1 + (8 if shift else 0)) for t in triangles]
    pathlib.Path("here/a.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    pathlib.Path("here/a.mtl").write_text("newmtl blue\nKd 0 0 1\nnewmtl glass\nKd 1 1 1\nd 0.1\nNi 1.7\n", encoding="utf-8")
    run("import", "here/a.obj", "-o", "here/obj", "--unit", "cm", "--quiet")
    parts = text("here/obj/parts.yaml")
    for words in ("name: base", "name: lamp_shade", "inside: 'index_1.7'", "paint_0000ff", "closed, 10 x 10 x 10 mm"):
        check(words in parts, f"'{words}' in\n{parts}")
    says_nothing("here/obj/scene.yaml")
    pathlib.Path("here/a.mtl").unlink()
    run("import", "here/a.obj", "-o", "here/obj", "--strict", "--force", status=3)


def check_obj_names():
    """Whole names, parts of one first word and of one name apart, each with the materials of its own faces; groups that go on."""
    points, _ = box(1, 1, 1)
    lines, k = ["mtllib b.mtl"], 0

    def cube(name, *materials):
        nonlocal k
        lines.extend([name] + ["v %g %g %g" % tuple(p + [3 * k, 0, 0]) for p in points])
        for i, t in enumerate(TRIANGLES):
            if i * len(materials) % 12 == 0 and materials[i * len(materials) // 12]:
                lines.append("usemtl " + materials[i * len(materials) // 12])
            lines.append("f %d %d %d" % tuple(t + 1 + 8 * k))
        k += 1

    cube("o front wheel", "red paint")
    cube("o front lamp", "red glass")
    cube("o wheel", "red paint", "steel")
    cube("o wheel", "steel", "red paint")
    cube("g left side", "steel")
    cube("g right side", "red paint")
    cube("g left side", "steel")
    pathlib.Path("here/b.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    pathlib.Path("here/b.mtl").write_text("newmtl red paint\nKd 1 0 0\nnewmtl red glass\nKd 1 1 1\nd 0.1\nnewmtl steel\nKd 0 0 1\n", encoding="utf-8")
    run("import", "here/b.obj", "-o", "here/names", "--quiet")
    parts = dict(re.findall(r"  - {name: (\S+), id: \w+, (.*)}", text("here/names/parts.yaml")))
    check(list(parts) == ["front_wheel", "front_lamp", "wheel", "wheel.2", "left_side", "right_side"], f"names: {list(parts)}")
    material = {n: re.search("material: '?([a-z ]+)", p).group(1) for n, p in parts.items()}
    check(material == {"front_wheel": "red paint", "front_lamp": "red glass", "wheel": "red paint", "wheel.2": "steel", "left_side": "steel",
                       "right_side": "red paint"}, f"materials: {material}")
    check("inside: 'index_1.5'" in parts["front_lamp"] and "faces: [{faces: [1], surface: paint_0000ff" in parts["wheel"]
          and "faces: [{faces: [1], surface: paint_ff0000" in parts["wheel.2"], f"of faces: {parts}")
    written = text("here/names/parts.yaml")
    check("wheel: 2 faces, closed, 1 x 1 x 1 mm" in written and "left side: 2 faces, closed, 7 x 1 x 1 mm" in written, written)
    # Before the first name, and without any, it is the file's.
    pathlib.Path("here/c.obj").write_text("\n".join(line for line in lines if line[0] not in "og") + "\n", encoding="utf-8")
    run("import", "here/c.obj", "-o", "here/names2", "--quiet")
    check("name: c, id" in text("here/names2/parts.yaml"), "without names")


def check_shared():
    """Meshes of equal geometry are one, whatever each part looks like; blended ones are clear."""
    screw, half = box(0.002, 0.002, 0.006), MATERIALS[:1] + [
        {"name": "film", "alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [0, 1, 0, 0.4]}},
        {"name": "solid", "alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 1, 1]}},
        {"name": "plain blend", "alphaMode": "BLEND"}]
    other = (screw[0] * [1, 1, 2], screw[1])

    def model(name, first):
        order = ["screw 0", "screw 1", "screw 2", "two", "two b"][first:]
        meshes = {"m0": [(*screw, 0)], "m1": [(*screw, 1)], "m2": [(*screw, 0)], "m3": [(other[0], other[1][:6], 0), (other[0], other[1][6:], 2)],
                  "m4": [(other[0], other[1][:6], 0), (other[0], other[1][6:], 3)]}
        kept = dict(list(meshes.items())[first:])
        nodes = [{"name": n, "mesh": i, "translation": [0.01 * (i + first), 0, 0]} for i, n in enumerate(order)]
        return gltf(name, kept, half, nodes, list(range(len(nodes))))

    told = json.loads(run("import", model("s.gltf", 0), "-o", "here/shared", "--json"))
    parts = dict(re.findall(r"  - {name: (\S+), id: \w+, (.*)}", text("here/shared/parts.yaml")))
    check(told["shapes"] == 3 and [parts[f"screw_{k}"].split(",")[0] for k in range(3)] == ["geometry: m0"] * 3, f"shared: {told} {parts}")
    check("fresnel, inside: 'index_1.5'" in parts["screw_1"] and "metal_" in parts["screw_2"] and "geometry: m3" in parts["two"]
          and "geometry: m4" in parts["two_b"], f"looks are the parts' own: {parts}")
    check("paint_0000ff" in parts["two"] and "fresnel" not in parts["two"] and told["transparent"] == 1, f"alpha 1 covers: {parts['two']}")
    says_nothing("here/shared/scene.yaml")
    told = json.loads(run("update", "here/shared", model("s2.gltf", 1), "--json"))
    check({p["name"]: p["change"] for p in told["parts"]} == {"screw_0": ["gone"]} and told["meshes"]["written"] == 0, f"no mesh is swapped: {told}")
    now = dict(re.findall(r"  - {name: (\S+), id: \w+, (.*)}", text("here/shared/parts.yaml")))
    check(now == {n: p for n, p in parts.items() if n != "screw_0"}, f"{now}")


def check_no_numbers():
    """Triangles that an import leaves out are told, by their numbers."""
    points, triangles = box(0.002, 0.002, 0.006)
    points[7] *= float("nan")
    first = next(i for i, t in enumerate(triangles) if 7 in t) + 1
    path = gltf("nan.gltf", {"screw": [(points, triangles, 0)]}, MATERIALS, [{"name": "s", "mesh": 0}], [0])
    done = subprocess.run([os.environ["RAYMAP"], "import", path, "-o", "here/nan"], text=True, capture_output=True, check=False)
    check(done.returncode == 0 and f"mesh 'screw': {sum(7 in t for t in triangles)} triangles, number {first} first" in done.stderr, f"{done.stderr}")
    check("left out" in run("import", path, "-o", "here/nan", "--strict", status=3), "--strict refuses")


def check_faces():
    """Light that starts in a box whose faces are objects of their own meets one of them, and never passes between."""
    pathlib.Path("here/faces.yaml").write_text("""raymap: 1
media: {air: {index: 1}}
geometries: {b: {type: box, size: [10, 10, 10]}}
objects:
  - {name: b, geometry: b, surface: absorber, inside: air, outside: air, rotate: [31, 17, 5], faces: [{faces: top, surface: fresnel,
     inside: air}, {name: x, faces: ['?x'], surface: absorber}, {faces: bottom, surface: absorber}, {faces: 2, surface: absorber}]}
sources: [{name: s, type: volume, in: b}]
""", encoding="utf-8")
    says = run("trace", "here/faces.yaml", "-n", 60000, "--no-record")
    share = {m.group(1): int(m.group(2).replace(",", "")) for m in re.finditer(r"absorbed by +(\S+) +([\d,]+)", says)}
    left = int(re.search(r"left +the scene +([\d,]+)", says).group(1).replace(",", ""))
    check(set(share) == {"b.x", "b.bottom", "b.4", "b.body"}, f"parts: {share}")
    check(abs(left / 60000 - 1 / 6) < 0.008 and sum(share.values()) + left == 60000, f"a sixth leaves by the open top: {left} {share}")


def check_step():
    made = pathlib.Path(os.environ["BUILD_DIR"]) / "tests" / "make_cad_files"
    if not STEP.exists() or not made.exists():
        lone = pathlib.Path("here/alone")
        lone.mkdir()
        pathlib.Path("here/a.step").write_text("ISO-10303-21;\n", encoding="utf-8")
        says = run("import", "here/a.step", "-o", "here/none", status=5)
        check("OpenCASCADE" in says and not pathlib.Path("here/none").exists(), f"what is missing: {says}")
        return
    subprocess.run([made, "here"], check=True, stdout=subprocess.DEVNULL)
    run("import", "here/luminaire.step", "-o", "here/lamp", "--quiet")
    says_nothing("here/lamp/scene.yaml")
    parts = text("here/lamp/parts.yaml")
    for words in ("name: optics", "inside: 'N-BK7'", "geometry: bolt_left", "# bolt right"):
        check(words in parts, f"'{words}' in\n{parts}")
    rule = "attributes:\n  - {match: {name: lens}, set: {surface: fresnel, inside: {0}}}\n".replace("{0}", "N-SF5")
    pathlib.Path("here/lamp/attributes.yaml").write_text(rule, encoding="utf-8")
    told = json.loads(run("update", "here/lamp", "here/luminaire-revised.step", "--json"))
    check({p["name"]: p["change"] for p in told["parts"]} == {"lens": ["renamed"], "bolt_right": ["moved"]}, f"revised: {told}")
    check(told["meshes"]["written"] == 0 and text("here/lamp/attributes.yaml") == rule, "no mesh is written, the rule stands")
    check("N-SF5" in says_nothing("here/lamp/scene.yaml"), "and fits the lens that was renamed")
    check("4 " in run("import", "here/luminaire.step", "-o", "here/coarse", "--chord", 1, "--angle", 40), "coarse")
    pathlib.Path("here/bad.step").write_bytes(pathlib.Path("here/luminaire.step").read_bytes()[:3000])
    says = run("import", "here/bad.step", "-o", "here/bad", status=3)
    check("bad.step" in says and not pathlib.Path("here/bad").exists(), f"a file that is cut off: {says}")


def check_exact_faces():
    """A lens of true surfaces whose rim is another object: no ray is lost at their common edges."""
    if not STEP.exists() or not pathlib.Path("here/biconvex.step").exists():
        return
    run("import", "here/biconvex.step", "-o", "here/lens", "--quiet")
    pathlib.Path("here/lens/attributes.yaml").write_text("attributes:\n  - {match: {name: '*'}, set: {surface: fresnel, inside: N-BK7}}\n"
                                                         "  - {match: {name: '*', face: 2}, set: {surface: absorber}}\n", encoding="utf-8")
    scene = text("here/lens/scene.yaml")
    pathlib.Path("here/lens/scene.yaml").write_text(scene.replace("# Light,", "sources: [{name: s, type: volume, in: biconvex, "
                                                                  "medium: N-BK7}]\n# Light,"), encoding="utf-8")
    says = run("trace", "here/lens/scene.yaml", "-n", 60000, "--no-record")
    check("error" not in says and "absorbed by  biconvex.1" in says, f"no ray is lost: {says}")
    # Ghosts are told by faces, the same light as of the body as one.
    pathlib.Path("here/lens/scene.yaml").write_text(scene.replace("# Light,", """sources: [{name: s, type: collimated, at: [0, 0, -20], direction: [0, 0, 1], shape: {disc: 8}}]
detectors: [{name: sensor, type: plane, at: [0, 0, 60], size: [18, 18], cells: 9}]\n# Light,"""), encoding="utf-8")
    rule = "attributes: [{match: {name: '*'}, set: {surface: fresnel, inside: N-BK7%s}}]\n"
    seen = {}
    for more in ("", ", by_face: true"):
        pathlib.Path("here/lens/attributes.yaml").write_text(rule % more, encoding="utf-8")
        done = subprocess.run([os.environ["RAYMAP"], "ghosts", "here/lens/scene.yaml", "sensor", "-n", "100k", "--json"], text=True, capture_output=True, check=False)
        rows = json.loads(done.stdout)["rows"]
        seen[more] = {row["surfaces"]: row["registrations"] for row in rows if row["order"] == 2}
        check(("biconvex is one object: 'by_face: true'" in done.stderr) == (not more), f"what tells them apart: {done.stderr}")
    body, faces = seen.values()
    check(set(body) == {"biconvex then biconvex"} and set(faces) == {"biconvex.face_2 then biconvex.face_0"} and
          list(body.values()) == list(faces.values()), f"{seen}")
    check("biconvex.face_1" in says_nothing("here/lens/scene.yaml"), "the rim, too")


check_tree()
check_rules()
check_update()
check_edits()
check_obj()
check_obj_names()
check_shared()
check_no_numbers()
check_faces()
check_step()
check_exact_faces()
asking.finish()
