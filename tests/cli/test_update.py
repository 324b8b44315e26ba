#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`raymap update`: ids, groups and names of the scene stay with their parts when a name above changes, when the first of equal names
goes, when a part changes its group; scales and turns are told; rules by face number on another shape are warned of; damaged meshes
and texts that were taken away are made again; the unit of the import is remembered; a model of something else is refused."""
import json
import os
import pathlib
import re
import shutil
import subprocess

import asking
import numpy as np
from asking import check, run
from gltf_models import TRIANGLES, box, gltf

shutil.rmtree("here", ignore_errors=True)
pathlib.Path("here").mkdir()
GREY = [{"name": "grey", "pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.2, 0.2, 1]}}]


def text(name):
    return pathlib.Path(name).read_text(encoding="utf-8")


def model(name, tree, lens=0.004):
    """tree: [(name, mesh or list, x in m, more)]."""
    meshes = {"screw": [(*box(0.002, 0.002, 0.006), 0)], "lens": [(*box(lens, 0.004, 0.001), 0)],
              "vane": [(box(0.01, 0.001, 0.03)[0] + [0.02, 0, 0], TRIANGLES, 0)], "plate": [(*box(0.05, 0.01, 0.002), 0)]}
    nodes = []

    def add(word, of, x=0, **more):
        at = len(nodes)
        nodes.append({"name": word, "translation": [x, 0, 0]} | more)
        if isinstance(of, str):
            nodes[at]["mesh"] = list(meshes).index(of)
        else:
            nodes[at]["children"] = [add(*child) if len(child) < 4 else add(*child[:3], **child[3]) for child in of]
        return at

    roots = [add(*root) for root in tree]
    return gltf(name, meshes, GREY, nodes, roots)


def parts(folder):
    """name: (id, first of its place) of parts and groups in parts.yaml."""
    return {m.group(1): m.group(2) for m in re.finditer(r"name: (\S+?)(?:,|   #.*|)\s+id: (0x\w+)", text(f"{folder}/parts.yaml"))}


def update(folder, path):
    done = subprocess.run([os.environ["RAYMAP"], "update", folder, path, "--json"], text=True, capture_output=True, check=False)
    check(done.returncode == 0, f"update {path}: {done.stderr}")
    told = json.loads(done.stdout)
    return told, {p["name"]: p["change"] for p in told["parts"]}, done.stderr


def fresh(folder, path):
    shutil.rmtree(folder, ignore_errors=True)
    run("import", path, "-o", folder, "--quiet")
    return parts(folder)


def of_scene(folder):
    """Surfaces of objects, by their names, with the rules."""
    scene = text(f"{folder}/scene.yaml")
    if "\nsources:" not in scene:
        pathlib.Path(f"{folder}/scene.yaml").write_text(
            scene + "sources: [{name: s, type: point, at: [0, 0, 400], direction: [0, 0, -1], distribution: {cone: 20}}]\n", encoding="utf-8")
    run("trace", f"{folder}/scene.yaml", "-n", 200, "-o", "here/a.raymap", "--force", "--quiet")
    return {o["name"]: o["surface_front"] for o in json.loads(run("info", "here/a.raymap", "--json"))["objects"]}


def rules(folder, *lines):
    pathlib.Path(f"{folder}/attributes.yaml").write_text("surfaces: {black: {type: absorber}, white: {type: mirror, reflectance: 0.9}}\nattributes:\n"
                                                         + "".join(f"  - {line}\n" for line in lines), encoding="utf-8")


def check_name_above():
    inside = [("optics", [("lens", "lens", 0.01), ("screw", "screw", 0.02)]), ("plate", "plate")]
    old = fresh("here/a", model("a.gltf", [("bench", inside)]))
    rules("here/a", "{match: {id: %s}, set: {surface: black}}" % old["lens"], "{match: {group: bench, name: plate}, set: {surface: white}}")
    told, change, _ = update("here/a", model("b.gltf", [("table", inside)]))
    check(change == {"bench": ["renamed"]} and told["kept"] == 3 and told["parts"][0]["was"] == "bench", f"a renamed root: {told['parts']}")
    check(parts("here/a") == old, f"ids and names stay: {old} {parts('here/a')}")
    surfaces = of_scene("here/a")
    check(surfaces["lens"] == "black" and surfaces["plate"] == "white", f"rules by id and group hold: {surfaces}")
    # Renamed with a part in it that changed its shape, and one that went; the next revision finds the same.
    told, change, _ = update("here/a", model("c.gltf", [("rig", [("head", inside[0][1][:1]), inside[1]])], lens=0.005))
    check(change == {"bench": ["renamed"], "optics": ["renamed"], "lens": ["changed"], "screw": ["gone"]}, f"and changed: {change}")
    check({n: i for n, i in old.items() if n != "screw"} == parts("here/a"), f"ids again {parts('here/a')}")
    says = run("update", "here/a", "here/a.gltf")
    check("'rig' -> 'bench'" in says and "renamed     bench" in says and "new         screw" in says, f"and back: {says}")
    check("is 'bench' in the file" not in says and of_scene("here/a")["lens"] == "black", f"back: {says}")


def check_equal_names():
    three = [("screw", "screw", 0.01), ("screw", "screw", 0.02), ("screw", "screw", 0.03)]
    turned = [("vane", "vane", 0, {"rotation": [0, 0, np.sin(a / 2), np.cos(a / 2)]}) for a in np.radians([0.0, 120, 240])]
    arms = [("arm", [("lens", "lens"), ("screw", "screw", 0.01)], x, {"rotation": [0, 0, 1, 0]}) for x in (0.1, 0.2, 0.3)]
    old = fresh("here/e", model("a.gltf", [("top", three + turned + arms)]))
    check({"screw.2", "vane.3", "arm.2", "lens.3"} <= set(old), f"names {old}")
    rules("here/e", "{match: {name: screw.2}, set: {surface: black}}", "{match: {name: vane.3}, set: {surface: white}}",
          "{match: {group: arm.2, name: 'lens*'}, set: {surface: black}}", "{match: {id: %s}, set: {surface: white}}" % old["lens.3"])
    before = of_scene("here/e")
    told, change, _ = update("here/e", model("b.gltf", [("top", three[1:] + turned[1:] + arms[1:])]))
    check(set(change) == {"screw", "vane", "screw.4", "lens"} and all(c == ["gone"] for c in change.values()), f"the first went: {change}")
    check(all(parts("here/e")[n] == old[n] for n in ("screw.2", "screw.3", "vane.2", "vane.3", "arm.2", "lens.2", "lens.3")), "ids stay")
    now = of_scene("here/e")
    check(all(before[n] == s for n, s in now.items()) and now["vane.3"] == "white" and now["lens.2"] == "black", f"{before} {now}")
    # One in front of them is new, and has no attribute of another.
    told, change, _ = update("here/e", model("c.gltf", [("top", [("screw", "screw", 0.005)] + three[1:] + turned[1:] + arms[1:])]))
    check([c for c in change.values()] == [["new"]] and told["kept"] == 8, f"one more in front: {change}")
    check(len(set(parts("here/e").values())) == len(parts("here/e")), "ids are unique")
    now = of_scene("here/e")
    check(now["screw.2"] == "black" and all(s != "black" for n, s in now.items() if n in change), f"{now}")


def check_groups_and_scales():
    old = fresh("here/g", model("a.gltf", [("top", [("lens", "lens", 0.01), ("optics", [("screw", "screw", 0.02)]), ("plate", "plate")])]))
    rules("here/g", "{match: {id: %s}, set: {surface: black}}" % old["lens"])
    told, change, _ = update("here/g", model("b.gltf", [("top", [("optics", [("screw", "screw", 0.02), ("lens", "lens", 0.01)]), (
        "plate", "plate", 0, {"rotation": [0, 0, np.sin(np.pi / 12), np.cos(np.pi / 12)]})])]))
    check(change == {"lens": ["regrouped"], "plate": ["moved"]}, f"regrouped: {change}")
    lens, plate = (next(p for p in told["parts"] if p["name"] == n) for n in ("lens", "plate"))
    check(lens["groups"] == ["top", "optics"] and abs(plate["turned_by"] - 30) < 1e-5 and plate["moved_by"] == 0, f"{lens} {plate}")
    check(parts("here/g") == {n: old[n] for n in parts("here/g")} and of_scene("here/g")["lens"] == "black", "the rule by id holds")
    says = run("update", "here/g", model("c.gltf", [("top", [("optics", [("screw", "screw", 0.02, {"scale": [2, 2, 2]}), ("lens", "lens", 0.01)]),
                                                            ("plate", "plate")])]))
    check("scaled      screw   to 2 times its size" in says and "turned by 30 degrees" in says and "by 0 mm" not in says, f"scales: {says}")


def check_faces_by_number():
    fresh("here/f", model("a.gltf", [("lens", "lens"), ("plate", "plate", 0.01)]))
    rules("here/f", "{match: {name: plate, face: 0}, set: {surface: black}}", "{match: {name: 'le*', face: [0]}, set: {surface: white}}",
          "{match: {name: lens, face: 'lens*'}, set: {surface: white}}", "{match: {name: lens, color: '#ff0000', face: 0}, set: {surface: white}}")
    told, change, said = update("here/f", model("b.gltf", [("lens", "lens"), ("plate", "plate", 0.01)], lens=0.006))
    check(change == {"lens": ["changed"]} and said.count("attributes.yaml:") == 1 and "here/f/attributes.yaml:4:" in said, f"warned: {said}")
    check("faces by number" in said and [(f["line"], f["file"]) for f in told["findings"]] == [(4, "here/f/attributes.yaml")], f"{told['findings']}")


def check_what_was_damaged():
    path = model("a.gltf", [("lens", "lens"), ("plate", "plate", 0.01)])
    fresh("here/d", path)
    mesh = pathlib.Path("here/d/meshes/lens.ply")
    whole = mesh.read_bytes()
    mesh.write_bytes(whole[:-30] + bytes([whole[-30] ^ 1]) + whole[-29:])
    for gone in ("scene.yaml", "attributes.yaml"):
        pathlib.Path("here/d", gone).unlink()
    done = subprocess.run([os.environ["RAYMAP"], "update", "here/d", path, "--dry-run"], text=True, capture_output=True, check=False)
    check("lens.ply is not as it was written" in done.stderr and mesh.read_bytes() != whole, f"told before: {done.stderr}")
    told, change, said = update("here/d", path)
    check(mesh.read_bytes() == whole and told["meshes"] == {"kept": 1, "written": 1, "removed": 0}, f"made again: {told['meshes']}")
    check("lens.ply is not as it was written" in said and "scene.yaml is not there any more" in said and "attributes.yaml is not" in said, said)
    run("check", "here/d/scene.yaml")
    check(update("here/d", path)[2] == "", "and whole again")


def check_unit():
    points, _ = box(1, 1, 1)
    lines = ["o cube"] + ["v %g %g %g" % tuple(p) for p in points] + ["f %d %d %d" % tuple(t + 1) for t in TRIANGLES]
    pathlib.Path("here/a.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    run("import", "here/a.obj", "-o", "here/u", "--unit", "cm", "--quiet")
    told, change, _ = update("here/u", "here/a.obj")
    check(told["kept"] == 1 and not change and told["meshes"]["written"] == 0, f"the unit is remembered: {told}")
    check("10 x 10 x 10 mm" in text("here/u/parts.yaml"), "cm")
    says = run("update", "here/u", "here/a.obj", "--unit", "m")
    check("changed, scaled cube   to 100 times its size" in says, f"a scale: {says}")
    check("1000 x 1000 x 1000 mm" in text("here/u/parts.yaml") and update("here/u", "here/a.obj")[0]["kept"] == 1, "another unit is, too")


def check_another():
    """A model of something else takes no scene's place without a word."""
    model("one.gltf", [("bench", [("screw", "screw"), ("lens", "lens")])])
    model("two.gltf", [("lorry", [("wheel", "vane"), ("door", "plate")])])
    before = fresh("here/e", "here/one.gltf")
    says = run("update", "here/e", "here/two.gltf", status=2)
    check("nothing of it is found again" in says and "--force" in says and parts("here/e") == before, f"refused: {says}")
    check("2 new, 2 gone" in run("update", "here/e", "here/two.gltf", "--dry-run"), "told")
    run("update", "here/e", "here/two.gltf", "--force")
    check({"wheel", "door"} <= set(parts("here/e")), "asked for")
    # With light and a detector, the sky of the written scene is still for pictures only.
    scene = text("here/e/scene.yaml")
    pathlib.Path("here/e/scene.yaml").write_text(scene + "sources: [{name: s, type: point, at: [0, 0, 400], direction: [0, 0, -1], distribution: "
                                                 "{cone: 20}}]\ndetectors: [{name: d, type: plane, at: [0, 0, 300], size: [9, 9], cells: [9, 9]}]\n", encoding="utf-8")
    told = json.loads(run("check", "here/e/scene.yaml", "--json"))
    check(told["errors"] == 0 and not [d for d in told["diagnostics"] if "background" in d["text"]], f"{told['diagnostics']}")


check_name_above()
check_equal_names()
check_groups_and_scales()
check_faces_by_number()
check_what_was_damaged()
check_unit()
check_another()
asking.finish()
