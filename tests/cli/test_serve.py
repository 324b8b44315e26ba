#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""A server: answers as the command line's, traces to the same digest, several clients, wrong input, edits and
saving, HTTP for who has the token, ranks that share the work."""
import base64
import http.client
import json
import math
import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time

RAYMAP = os.environ["RAYMAP"]
SOURCE = os.environ["SOURCE_DIR"]
sys.path.insert(0, os.path.join(SOURCE, "examples/python"))
import raymap  # noqa: E402
import raymap.serve  # noqa: E402

RAYS = 20000


def run(*args):
    done = subprocess.run([RAYMAP, *args], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout) if "--json" in args else None


def without_cost(answer):
    return {k: v for k, v in answer.items() if k not in ("seconds", "bytes_read", "portions", "map", "name", "path", "rays_asked")}


def refused(call, *args, status=None, **keys):
    try:
        call(*args, **keys)
    except raymap.serve.ServerError as error:
        assert status in (None, error.status), (error, error.status)
        return error
    raise AssertionError(f"{keys} was not refused")


def check_answers():
    run("trace", "scene.yaml", "-n", str(RAYS), "-o", "full.raymap", "--quiet")
    digest = run("info", "full.raymap", "--json")["digest"]
    with raymap.serve.start("scene.yaml") as lens:
        assert lens.query("all")["rays"]["total"] == 0
        told = []
        done = lens.trace(RAYS, told=told.append)
        assert done["state"] == "done" and done["rays"] == RAYS, done
        assert all(0 <= t["progress"] <= 1 for t in told), told
        assert lens.status()["digest"] == digest
        for criterion in ("all", "registered(sensor)", "hit(lens.*, reflect) >= 2"):
            assert without_cost(lens.query(criterion)) == \
                without_cost(run("query", "full.raymap", criterion, "--json")), criterion
        pairs = [(lens.stats(of="path_length", where="registered(sensor)"),
                  ["stats", "full.raymap", "--of", "path_length", "--where", "registered(sensor)"]),
                 (lens.detector("sensor", cells="9x6", values=True),
                  ["detector", "full.raymap", "sensor", "--cells", "9x6", "--table"]),
                 (lens.paths(top=3, no_events=True), ["paths", "full.raymap", "--top", "3", "--no-events"]),
                 (lens.report(ray=7), ["report", "full.raymap", "7"]),
                 (lens.report(energy=True), ["report", "full.raymap", "--energy"])]
        for answer, command in pairs:
            expected = run(*command, "--json")
            assert without_cost(answer) == without_cost(expected), (command, answer, expected)
        assert len(lens.sample("registered(sensor)", 3)) == 3
        drawn = lens.draw(limit=5)
        assert drawn["text"].startswith("<?xml") and "output" not in drawn, drawn.keys()
        assert lens.draw(limit=5, format="png")["base64"].startswith("iVBOR")
        names = lens.names()
        assert "sensor" in names["detectors"] and "hit" in names["words"]
        assert {"path_length", "angle", "photon_energy", "registered("} < set(names["values"]) and len(names["events"]) == 13, names
        part = lens.detector("sensor", region="-18,-3,4,5.5")
        assert part["region"]["criterion"] == "registered(sensor, rect(-18, -3, 4, 5.5))", part["region"]
        matched = lens.query(part["region"]["criterion"])["rays"]["matched"]
        assert 0.97 * part["registrations"] <= matched <= part["registrations"] and matched > 20, (part, matched)
        turned = lens.detector("sensor", region="-12,-3,4,5.5", rotate=20)
        assert "polygon(" in turned["region"]["criterion"], turned["region"]
        matched = lens.query(turned["region"]["criterion"])["rays"]["matched"]
        assert 0.97 * turned["registrations"] <= matched <= turned["registrations"] and matched > 20, (turned, matched)
        assert lens.check()["errors"] == 0
        assert "'registered' wants in brackets the name of a detector" in str(refused(lens.stats, of="registered", status=3))
        wrong = refused(lens.query, "hot(lens)", status=3)
        assert wrong.details["column"] == 1 and "did you mean" in str(wrong)
        for keys in ({"output": "x.csv"}, {"where": {"a": 1}}, {"where": [["a"]]}, {"threads": 3}, {"criteria": "f"}):
            refused(lens.ask, "stats", of="ray", status=2, **keys)
        refused(lens.query, "-o/tmp/x.csv")
        refused(lens.ask, "query", criterion="all", format="csv", status=2)
        refused(lens.ask, "trase", status=2)
        refused(lens.ask, "trace", rays=-4, status=2)
        refused(lens.ask, "trace", action="pause", status=3)
        refused(lens.ask, "load", file="nothing.yaml")
        lens.load(file="full.raymap")
        status = lens.status()
        assert status["map"] and status["digest"] == digest and status["trace"]["rays"] == RAYS
        assert lens.query("all")["rays"]["total"] == RAYS
        lens.trace(4096)  # of the scene inside the map
        assert lens.query("all")["rays"]["total"] == 4096


def check_taken_over(lens):
    """Rays that an edit does not touch are not traced again; the rays are the same as if they were."""
    before = lens.status()["digest"]
    lens.move("back_wall", 0, 0, 0.5)
    moved = lens.trace(RAYS)
    assert 0 < moved["rays_taken_over"] < RAYS and lens.status()["digest"] != before
    lens.undo()
    lens.edit(text=lens.scene()["text"] + "# the same\n")  # another version between two traces
    assert 0 < lens.trace(RAYS)["rays_taken_over"] < RAYS and lens.status()["digest"] == before
    assert lens.trace(RAYS, seed=2)["rays_taken_over"] == 0
    assert lens.trace(RAYS)["rays_taken_over"] in (0, RAYS) and lens.status()["digest"] == before
    lens.undo()
    lens.undo()
    lens.trace(4096)  # fewer than the ones before
    lens.redo()
    none = lens.status()["trace"]
    assert (none["state"], none["rays"], none["of"], none["seconds"], none["rays_taken_over"]) == ("none", 0, 0, 0, 0)
    assert lens.trace(RAYS)["rays_taken_over"] > 0 and lens.status()["digest"] == before


def check_mixed():
    """Of a map in two colour spaces new rays are in the first one, as those of `trace --from` are in the scene's; both say so."""
    run("trace", "scene.yaml", "-n", "4096", "-o", "mixed.raymap", "--quiet")
    run("trace", "scene.yaml", "-n", "2048", "-o", "mixed.raymap", "--append", "--color", "rgb", "--quiet")
    with raymap.serve.start("mixed.raymap") as lens:
        lens.move("mount", 0, 0, 1)
        traced = lens.trace(4096)
        assert traced["rays_taken_over"] > 0 and "colour spaces" in traced["remark"], traced
        lens.save("mixed.yaml")
        made = run("trace", "mixed.yaml", "-n", "4096", "-o", "made.raymap", "--from", "mixed.raymap", "--json")
        assert made["digest"] == lens.status()["digest"] and made["from"]["other_spaces"] == 2048, made
        other = run("trace", "mixed.yaml", "-n", "512", "-o", "other.raymap", "--from", "made.raymap", "--color", "rgb", "--json")["from"]
        assert (other["reused"], other["other_spaces"]) == (0, 4096) and "spectrum" in other["all_anew"], other


def check_places(lens, answer):
    """A move and its undo tell where what moved is, as the model has it, and nothing of what did not."""
    now, places = lens.model(parts="scene")["scene"], answer["places"]
    assert 0 < len(places["objects"]) < len(now["objects"])
    for index, matrix in places["objects"].items():
        assert now["objects"][int(index)]["matrix"] == matrix
    assert {key: places[key] for key in ("sources", "centre", "radius")} == {key: now[key] for key in ("sources", "centre", "radius")}


def check_edits():
    with raymap.serve.start("scene.yaml") as lens:
        before = lens.scene()
        assert before["undo"] == before["redo"] == 0 and before["saved"]
        moved = lens.move("mount", 0, 0, 1.5)
        assert "{name: mount, geometry: flange, at: [0, 0, 80.5]" in moved["text"] and not moved["saved"]
        assert moved["text"].count("#") == before["text"].count("#")
        for step in [-7, 0.25, 1.5]:  # a drag is one edit, and one step of undo
            amended = lens.move("mount", 0, 0, step, amend=lens.status()["revision"], brief=True)
        assert lens.scene()["text"] == moved["text"] and (amended["undo"], amended["redo"]) == (1, 0)
        assert amended.keys() | {"text"} == moved.keys() and "text" not in amended
        refused(lens.move, "mount", 0, 0, 9, amend=moved["revision"], status=3)
        refused(lens.move, "mount", 0, 0, 9, amend="last", status=2)
        check_places(lens, amended)
        check_places(lens, lens.undo())
        again = lens.redo()
        check_places(lens, again)
        refused(lens.move, "mount", 0, 0, 9, amend=again["revision"], status=3)  # no edit led there
        lens.edit(set={"objects.mirror_box.surface": "absorber", "sources.star.flux": "2 W",
                       "limits.steps": 500})
        lens.trace(RAYS)
        lens.save("edited.yaml")
        run("trace", "edited.yaml", "-n", str(RAYS), "-o", "edited.raymap", "--quiet")
        assert lens.status()["digest"] == run("info", "edited.raymap", "--json")["digest"]
        check_taken_over(lens)
        assert "places" not in lens.edit(set={"limits.steps": 400}) and "places" not in lens.undo()
        wrong = refused(lens.edit, text="raymap: 1\nobjects: 5\n", status=3)
        assert wrong.details["diagnostics"][0]["line"] == 2 and "\nscene.yaml:2:10: error: 'objects' must be a list" in str(wrong)
        assert "\nscene.yaml: error: no sources" in str(wrong)
        refused(lens.edit, text="{")
        refused(lens.edit, set={"objects.nobody.at": [0, 0, 0]}, status=3)
        for path in ("objects.", ".objects", "objects..lens", "objects.lens."):
            assert "no path" in str(refused(lens.edit, set={path: []}, status=3)), path
        for name in ("nobody", "", ".", "..", ".mount", "a" * 9999):
            assert f"there is no '{name[:99]}" in str(refused(lens.move, name, 0, 0, 1, status=3)), name
        refused(lens.edit, status=2)
        done = subprocess.run([RAYMAP, "serve", "scene.yaml"], input='{"command": "check", "text": "objects: 5"}\n', capture_output=True, text=True, timeout=60)
        told = json.loads(done.stdout)["result"]  # there, and not beside it
        assert told["errors"] == 2 and "assumed" in told["diagnostics"][0]["text"] and done.stderr == "", (told, done.stderr)
        assert lens.undo()["text"] == moved["text"]
        assert lens.undo()["text"] == before["text"]
        refused(lens.undo, status=3)
        assert lens.redo()["text"] == moved["text"]
        lens.move("mount", 1, 0, 0)
        refused(lens.redo, status=3)
        added = lens.edit(remove=["objects.mirror_box", "objects.back_wall.at"],
                          set={"objects.plate": {"geometry": "plate", "at": [0, 0, 200], "outside": "air"}})["text"]
        assert "mirror_box" not in added and "{name: back_wall, geometry: wall, surface" in added
        assert "{name: plate, geometry: plate, at: [0, 0, 200], outside: air}" in added
        assert added.count("#") == before["text"].count("#")
        refused(lens.edit, remove=["objects.mirror_box"], status=3)
        refused(lens.edit, remove=[5], status=2)
        check_keys(lens)


def check_included():
    """Keys of included files are edited, undone and saved as the scene's own."""
    parts = {"whole.yaml": "raymap: 1\ninclude: [parts.yaml, ../beside/more.yaml]\nmedia: {air: {index: 1}}\nobjects:\n"
                           "- {name: a, geometry: ball, surface: absorber, outside: air}\n",
             "parts.yaml": "---\n# a part\ngeometries:\n  ball: {type: sphere, radius: 1} # mm\n  disc: {type: disc, radius: 2}\n",
             "../beside/more.yaml": "sources:\n- {name: s, type: point, at: [0, 0, -9], medium: air}\n"}
    os.makedirs("../beside", exist_ok=True)
    for name, text in parts.items():
        with open(name, "w") as file:
            file.write(text)
    with raymap.serve.start("whole.yaml") as whole:
        before = whole.scene()["text"]
        assert "# a part" in before and "name: s" in before
        whole.edit(set={"geometries.ball.radius": 1.5}, remove=["geometries.disc"])
        whole.trace(4096)
        digest = whole.status()["digest"]
        whole.save()
        assert open("parts.yaml").read() == "---\n# a part\ngeometries:\n  ball: {type: sphere, radius: 1.5} # mm\n"
        assert open("whole.yaml").read() == parts["whole.yaml"]
        whole.edit(set={"sources.s.at": [0, 0, -8]})
        refused(whole.save, status=2)  # a part that is not below the folder
        shutil.copy("parts.yaml", "parts.kept")
        with open("parts.yaml", "a") as file:
            file.write("# mine\n")
        assert "parts.yaml is no longer" in str(refused(whole.save, status=2))
        shutil.move("parts.kept", "parts.yaml")
        assert open("../beside/more.yaml").read() == parts["../beside/more.yaml"]
        assert whole.check(text=before.replace("radius: 1}", "radios: 1}"))["diagnostics"][0]["file"] == "parts.yaml"
        refused(whole.edit, text=before.replace("[parts.yaml, ", "["), status=3)
        whole.undo()
        assert whole.undo()["text"] == before
        whole.load(file="whole.yaml")
        whole.trace(4096)
        assert whole.status()["digest"] == digest


def write_mesh(height):
    corner = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, height)]
    with open("body.stl", "w") as file:
        file.write("solid s\n")
        for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
            file.write("facet normal 0 0 0\nouter loop\n" + "".join("vertex %g %g %g\n" % corner[i] for i in face) +
                       "endloop\nendfacet\n")
        file.write("endsolid s\n")


def check_meshes():
    """What an edit takes over of the scene before is what reading it anew gives, and a file that changed is read again."""
    write_mesh(1)
    with open("meshes.yaml", "w") as file:
        file.write("raymap: 1\nmedia: {air: {index: 1}, glass: {index: 1.5}}\nsurfaces: {clear: {type: fresnel}}\n"
                   "geometries: {body: {type: mesh, file: body.stl}, other: {type: mesh, file: body.stl, scale: 2}}\nobjects:\n" +
                   "".join(f"- {{name: o{i}, geometry: {'other' if i == 2 else 'body'}, at: [{i}, 0, 5], surface: clear, "
                           "outside: air, inside: glass}\n" for i in range(5)) +
                   "sources: [{name: lamp, type: point, at: [2, 0.3, 0], medium: air, cone: 40}]\n")
    changes = [{"move": "o1", "by": [0, 0.2, 1]}, {"remove": ["objects.o0"]}, {"set": {"geometries.other.scale": 1.5}},
               {"set": {"objects.o2.scale": 20}}, {"set": {"media.glass.index": 1.6}}]
    with raymap.serve.start("meshes.yaml") as scene, raymap.serve.start("meshes.yaml", before=["mpirun", "--oversubscribe", "-np", "2"]) as ranks:
        def traced(server):
            server.trace(4096)
            return server.status()["digest"]
        seen = {traced(scene)}
        for i, change in enumerate([*changes, None]):
            if change:
                scene.edit(**change)
                ranks.edit(**change)
            else:
                write_mesh(0.5)
                scene.undo()
                ranks.undo()
            digests = [traced(scene), traced(ranks)]
            scene.save(file="now.yaml", force=True)
            if i in (1, 3, 5):  # read anew
                with raymap.serve.start("now.yaml") as anew:
                    digests.append(traced(anew))
            assert len(set(digests)) == 1 and digests[0] not in seen, (change, digests)
            seen.add(digests[0])


def check_bodies_of_maps():
    """A body of a map whose numbers are edited is another one, and with the old ones it is the old one."""
    with open("block.yaml", "w") as file:
        file.write("raymap: 1\nmedia: {air: {index: 1}, glass: {index: 1.5}}\nsurfaces: {clear: {type: fresnel}}\n"
                   "geometries: {block: {type: box, size: [2, 2, 2]}}\nobjects: [{name: block, geometry: block, at: [0, 0, 5], surface: clear, outside: air, "
                   "inside: glass}]\nsources: [{name: lamp, type: point, at: [0.1, 0.2, 0], medium: air, cone: 20}]\n")
    run("trace", "block.yaml", "-n", "4096", "-o", "block.raymap", "--quiet")
    for before in ([], ["mpirun", "--oversubscribe", "-np", "2"]):
        with raymap.serve.start("block.raymap", before=before) as block, raymap.serve.start("block.yaml") as scene:
            old = block.status()["digest"]
            for size in ([2, 2, 1], [2, 2, 2]):
                for server in (block, scene):
                    server.edit(set={"geometries.block.size": size})
                    server.trace(4096)
                assert block.status()["digest"] == scene.status()["digest"]
                assert (block.status()["digest"] == old) == (size[2] == 2)


def check_axes():
    """A move along the world's axes of what stands in groups that are turned and scaled."""
    with open("turned.yaml", "w") as file:
        file.write("raymap: 1\nmedia: {air: {index: 1}}\nsurfaces: {black: {type: absorber}}\n"
                   "geometries: {wall: {type: rectangle, size: [9, 9]}}\nobjects:\n"
                   "- name: stage\n  at: [5, 0, 0]\n  rotate: [0, 0, 90]\n  scale: 2\n  objects:\n"
                   "  - {name: wall, geometry: wall, at: [0, 1, 0], surface: black, outside: air}\n"
                   "  sources: [{name: lamp, type: point, at: [0, 0, -9], medium: air}]\n"
                   "sources: [{name: free, type: point, at: [1, 2, 3], medium: air}]\n")
    with raymap.serve.start("turned.yaml") as scene:
        assert "at: [0.5, 1, 0]" in scene.move("wall", 0, 1, 0, axes="world")["text"]
        assert "at: [0, 0, -8]" in scene.move("lamp", 0, 0, 2, axes="world")["text"]
        assert "at: [0, -1, -8]" in scene.move("lamp", 2, 0, 0, axes="world")["text"]
        assert "at: [1, 3, 3]" in scene.move("free", 0, 1, 0, axes="world")["text"]
        assert "at: [6, 0, 0]" in scene.move("stage", 1, 0, 0, axes="world")["text"]
        assert "at: [0.5, 2, 0]" in scene.move("wall", 0, 1, 0, axes="own")["text"] != scene.move("wall", 0, 1, 0)["text"]
        refused(scene.move, "wall", 0, 1, 0, axes="mine", status=2)


def check_places_as_written():
    """What has its place by a matrix gets another one there; what has none says what to move. The rest stays as it is written."""
    with open("placed.yaml", "w") as file:
        file.write("raymap: 1\nmedia: {air: {index: 1}, glass: {index: 1.5}}\nsurfaces: {black: {type: absorber}}\n"
                   "geometries: {wall: {type: rectangle, size: [9, 9]}, row: {type: lens, surfaces: [{radius: 50, thickness: 2, medium: glass, aperture: 5}, "
                   "{radius: -50, aperture: 5, medium: air}]}}\nobjects:\n"
                   "- {name: stage, rotate: [0, 0, 90], objects: [{name: wall, geometry: wall, matrix: [1.0, 0, 0, 2,\n"
                   "  0, 1.0, 0, 3.0, # mm\n  0, 0, 1.0, 4], surface: black, outside: air}]}\n"
                   "- {name: lens, geometry: row, at: [0.0, 1 cm, 20], outside: air}\n"
                   "sources: [{name: sun, type: collimated, fills: lens}, {name: lamp, type: point, matrix: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -9], medium: air},\n"
                   "  {name: day, type: rays, rays: [{origin: [0, 0, -9], direction: [0, 0, 1]}], medium: air}]\n")
    with raymap.serve.start("placed.yaml") as scene:
        before = scene.scene()["text"]
        moved = scene.move("wall", 0, 0.5, 0, axes="world")
        assert moved["text"] == before.replace("0, 2,\n", "0, 2.5,\n") and moved["places"]["objects"]
        assert "0, 2.5,\n  0, 1.0, 0, 4, # mm\n  0, 0, 1.0, 3]" in scene.move("wall", 0, 1, -1)["text"]
        assert "1, -8]" in scene.move("lamp", 0, 0, 1)["text"]
        assert "at: [0.0, 1 cm, 21]" in scene.move("lens", 0, 0, 1)["text"]
        assert "at: [0.0, 0.5 cm, 21]" in scene.move("lens", 0, -5, 0)["text"]
        for name, words in (("sun", "instead of 'fills'"), ("lens.edge.1", "by 'lens', of which it is a part"), ("day", "no place")):
            assert words in str(refused(scene.move, name, 0, 1, 0, status=3)), name
        scene.edit(text=before.replace("at: [0.0, 1 cm, 20], ", ""))
        assert "at: [0, 0, 3]" in scene.move("lens", 0, 0, 3)["text"]


SHARED = """raymap: 1
media: {air: {index: 1}}
surfaces: {black: {type: absorber}}
geometries: {wall: {type: rectangle, size: [9, 9]}}
objects:
- &R {name: m1, geometry: wall, at: &p [0, 0, 5], surface: black, outside: air}
- {<<: *R, name: m2}
- {name: m3, geometry: wall, at: *p, surface: black, outside: air}
sources: [{name: lamp, type: point, at: [0, 0, 0], medium: air, cone: 20}]
detectors: [{name: on_wall, type: plane, on: m1, cells: [4, 4]}, {name: facing, type: plane, on: m1, direction: [1, 0, 0], size: 1, cells: 4}]
"""


def check_first_items():
    """What a list or mapping has first, where its key is missing or has nothing behind it."""
    text = PLAIN[:PLAIN.index("detectors:")]
    with open("first.yaml", "w") as file:
        file.write(text + "cameras:   # none\nlimits:\n")
    eye, plane = {"at": [0, 0, -9], "look_at": [0, 0, 0], "fov": 60, "resolution": [32, 32]}, {"type": "plane", "at": [0, 0, 4], "size": 9, "cells": 9}
    with raymap.serve.start("first.yaml") as scene:
        scene.edit(set={"detectors.plane": plane, "cameras.eye": eye, "limits.steps": 50, "media.glass": {"index": 1.5}})
        now = scene.scene()
        assert now["detectors"] == ["plane"] and "detectors: [{name: plane, type: plane" in now["text"] and "limits: {steps: 50}" in now["text"], now
        assert "cameras: [{name: eye, at: [0, 0, -9]" in now["text"] and "# none" in now["text"]
        scene.edit(set={"detectors.2": {**plane, "name": "other"}, "objects.stand": {"objects": []}})
        scene.edit(set={"objects.stand.sources.lit": {"type": "point", "medium": "air"}})
        assert scene.scene()["detectors"] == ["plane", "other"] and "sources: [{name: lit, type: point, medium: air}]" in scene.scene()["text"]
        scene.load(file="first.yaml")
        for keys, words in (({"detectors.0": plane}, "'detectors.NAME'"), ({"objects.7": plane}, "'objects.NAME'"), ({"detectors.plane.at": [0, 0, 1]}, "set 'detectors.plane' to"),
                            ({"cameras.eye.at": [0, 0, 1]}, "set 'cameras.eye' to"), ({"cameras.eye": 5}, "set 'cameras.eye' to"), ({"objects.wal.at": [0, 0, 1]}, "no 'wal' in 'objects'")):
            assert words in str(refused(scene.edit, set=keys, status=3)), keys


def check_shared():
    """What other objects have by an alias or a merge key stays."""
    with open("shared.yaml", "w") as file:
        file.write(SHARED)
    with raymap.serve.start("shared.yaml") as scene:
        for wrong in ({"move": "m1", "by": [0, 0, 1]}, {"set": {"objects.m2.at.3": 4}}, {"set": {"objects.m3.at.3": 4}}, {"remove": ["objects.m2.at"]}):
            refused(scene.edit, **wrong, status=3)
        assert scene.scene()["text"] == SHARED
        moved = scene.move("m2", 0, 0, 1)["text"]
        assert moved == SHARED.replace("name: m2}", "name: m2, at: [0, 0, 6]}"), moved
        assert scene.move("m3", 0, 1, 0)["text"] == moved.replace("*p", "[0, 1, 5]")
        assert "at: &p [1, 0, 5]" in scene.move("m1", 1, 0, 0)["text"]  # nobody has it any more
        scene.load(file="shared.yaml")  # detectors that have the place of what they lie on
        assert "{name: on_wall, type: plane, on: m1, cells: [4, 4], at: [0, 2, 5]}" in scene.move("on_wall", 0, 2, 0)["text"]
        assert "on: m1, cells: [4, 4], at: [0, 3, 5]}" in scene.move("on_wall", 0, 3, 0, amend=scene.status()["revision"])["text"]
        refused(scene.move, "facing", 0, 0, 1, amend=scene.status()["revision"], status=3)
        assert "cells: 4, at: [0, 0, 6]}" in scene.move("facing", 0, 0, 1, axes="world")["text"]
        assert "cells: 4, at: [0, 0, 6.5]}" in scene.move("facing", 0, 0, 0.5)["text"]


def check_same():
    """What changes nothing is no edit."""
    with raymap.serve.start("shared.yaml") as scene:
        scene.edit(set={"limits.steps": 500})
        scene.trace(4096)
        before = scene.scene()
        for same in ({"set": {}}, {"remove": []}, {"move": "m1", "by": [0, 0, 0]}, {"move": "on_wall", "by": [0, 0, 0]}, {"text": before["text"]}):
            after = scene.edit(**same)
            assert all(after[key] == before[key] for key in after), (same, after)
        refused(scene.edit, set={"limits.steps": 400}, amend=before["revision"], status=3)
        assert scene.status()["trace"]["rays"] == 4096
        for steps in range(1000, 2001):
            changed = scene.edit(set={"limits.steps": steps}, brief=True)
        assert changed["undo"] == 1000, changed


def check_keys(lens):
    """Keys of the server's own commands that are none, or of another type, are refused by name."""
    for command, keys, words in (("save", {"file": 5}, "'file' of 'save' is a text"), ("save", {"force": "yes"}, "'force'"),
                                 ("watch", {"on": "x"}, "'on'"), ("trace", {"rays": 9, "wait": "yes"}, "'wait'"), ("check", {"text": 5}, "'text'"),
                                 ("status", {"x": 1}, "no 'x'"), ("undo", {"n": 3}, "it takes: brief"), ("query", {"criterion": "all", "text": "x"}, "no 'text'"),
                                 ("trace", {"rays": 9, "seed": -1}, "'seed'"), ("trace", {"rays": 0}, "from 1 on"), ("trace", {"rays": -1}, "from 1 on"), ("cancel", {"of": 1, "all": True}, "no 'all'"),
                                 ("edit", {"set": {}, "text": "x"}, "one of these"), ("edit", {"move": "mount", "by": [0, 0, 1], "set": {}}, "one of these")):
        assert words in str(refused(lens.ask, command, **keys, status=2)), (command, keys)
    for value, error in ((math.nan, ValueError), (object(), TypeError)):
        try:
            lens.move("mount", 0, 0, value)
            raise AssertionError("it was sent")
        except error:
            assert not lens._waiting

    assert "wants a name" in str(refused(lens.save, r"a\u0000b\\u0000", status=2))  # which is no NUL
    for text in ("a\0b.yaml", "a\\\0b.yaml", "\ud800", "x" * (1 << 24)):  # nor may its answer never come
        try:
            lens.save(text)
            raise AssertionError("it was sent")
        except ValueError:
            assert not lens._waiting

    class Whole:
        def __index__(self):
            return 4096

    assert lens.trace(Whole())["rays"] == 4096


def check_set_as_command_line():
    """An edit of the text is what --set is, in scenes that are written in various ways."""
    equal = 0
    os.makedirs("shared", exist_ok=True)
    shutil.copy("shared.yaml", "shared/scene.yaml")
    for name, values in (("room", {"objects.floor.at": [0, 0, -0.01], "limits.steps": 7, "time": "on"}),
                         ("luneburg", {"objects.screen.at.3": 50.5, "sources.beam.shape.disc": 20, "limits.weight": 0.1}),
                         ("light-guide", {"limits.steps": 30, "media.plate.index": 1.6, "sources.2.at": [0, -100.45, 2]}),
                         ("shared", {"objects.m2.at": [0, 1, 4], "objects.m3.at": [8, 0, 4]})):
        path = os.path.join("" if name == "shared" else os.path.join(SOURCE, "examples"), name, "scene.yaml")
        sets = [f"--set={key}={json.dumps(value)}" for key, value in values.items()]
        told = subprocess.run([RAYMAP, "trace", path, "-n", "4096", "-o", name + ".raymap", "--quiet", *sets],
                              capture_output=True, text=True, timeout=120)
        with raymap.serve.start(path) as scene:
            if told.returncode == 3:  # a key that there is not is refused here as there
                assert len(refused(scene.edit, set=values, status=3).details["diagnostics"]) > 0
                continue
            assert told.returncode in (0, 7), told.stderr
            scene.edit(set=values)
            scene.trace(4096)
            assert scene.status()["digest"] == run("info", name + ".raymap", "--json")["digest"], name
            equal += 1
    assert equal >= 3, equal


def check_saving():
    os.makedirs("below", exist_ok=True)
    os.makedirs("../outside", exist_ok=True)
    for link, to in (("link", "../outside"), ("file.yaml", "../outside/x.yaml"), ("loop", "loop")):
        if not os.path.islink(link):
            os.symlink(to, link)
    with raymap.serve.start("scene.yaml") as lens:
        here = os.getcwd()
        for path in ("../x.yaml", "below/../../outside/x.yaml", "link/x.yaml", "file.yaml", "/tmp/x.yaml", "below",
                     here + "/../x.yaml", here + "x/y.yaml", "loop/x.yaml", "x.txt", "nowhere/x.yaml", ".yaml/",
                     "a" * 300 + ".yaml"):
            refused(lens.save, path)
        assert "the folder below/none is not there" in str(refused(lens.save, "below/none/x/y.yaml", status=3))
        assert not os.listdir("../outside")
        refused(lens.save, "scene.yaml/", status=2)
        lens.move("mount", 0, 0, 1)
        assert lens.save("below/new.yaml")["file"] == "below/new.yaml"  # a copy
        assert lens.status()["file"] == "scene.yaml" and not lens.status()["saved"]
        refused(lens.save, "below/new.yaml", status=2)
        lens.save("below/new.yaml", force=True)
        lens.save(here + "/below/other.yaml")
        assert open("below/other.yaml").read() == lens.scene()["text"]
        assert not [f for f in os.listdir("below") if f.startswith(".")]
    with raymap.serve.start("below/new.yaml") as lens:
        lens.move("mount", 0, 0, 1)
        lens.save()
        with open("below/new.yaml", "a") as file:  # another program
            file.write("# mine\n")
        lens.move("mount", 0, 0, 1)
        assert "'force'" in str(refused(lens.save, status=2)) and "# mine" in open("below/new.yaml").read()
        lens.save(force=True)
        lens.move("mount", 0, 0, 1)
        lens.save("./below/new.yaml")
        assert lens.status()["saved"]
        lens.save()
        assert open("below/new.yaml").read() == lens.scene()["text"]
        os.link("below/new.yaml", "below/linked.yaml")  # another file, once one of them is saved
        lens.move("mount", 0, 0, 1)
        refused(lens.save, "below/linked.yaml", status=2)
        lens.save("below/linked.yaml", force=True)
        assert not lens.status()["saved"] and open("below/new.yaml").read() != open("below/linked.yaml").read() == lens.scene()["text"]


def check_saving_elsewhere():
    """In another folder the names of files lead where they led."""
    for folder in ("deep/er", "parts"):
        os.makedirs(folder, exist_ok=True)
    write_mesh(1)
    shutil.move("body.stl", "parts/body.stl")
    shutil.copy("parts/body.stl", "parts/other.stl")
    with open("parts/cube.yaml", "w") as file:
        file.write("geometries: {third: {type: mesh, file: other.stl}} # mine\n")
    with open("parts/named.yaml", "w") as file:
        file.write("raymap: 1\ninclude: [cube.yaml, ../plain_part.yaml]\nmedia: {air: {index: 1}}\nsurfaces: {black: {type: absorber}}\ngeometries:\n"
                   "  body: &b {type: mesh, file: &f body.stl} # here\n  again: {<<: *b, scale: 2}\n  more: {type: mesh, file: *f}\n"
                   "  other: {type: mesh, file: '../parts/other.stl'}\nobjects:\n"
                   "- {name: a, geometry: body, surface: black, outside: air}\n- {name: b, geometry: third, at: [3, 0, 0], surface: black, outside: air}\n"
                   "- {name: c, geometry: other, at: [6, 0, 0], surface: black, outside: air}\n")
    with open("around.yaml", "w") as around, open("parts/water.yaml", "w") as part:
        around.write(PLAIN + "include: [parts/water.yaml]\n")
        part.write("media: {water: {index: 1.33}}\n")
    with raymap.serve.start("around.yaml") as scene:
        assert "parts/water.yaml, which the scene includes" in str(refused(scene.save, "deep/around.yaml", status=3))
    with open("plain_part.yaml", "w") as file:
        file.write("sources: [{name: lamp, type: point, at: [0.1, 0.1, -9], medium: air, cone: 40}]\n")
    with raymap.serve.start("parts/named.yaml") as scene:
        scene.trace(4096)
        digest = scene.status()["digest"]
        scene.save("deep/er/named.yaml")
        saved = open("deep/er/named.yaml").read()
        assert 'file: &f "../../parts/body.stl"} # here' in saved and "file: *f}" in saved and 'include: [cube.yaml, "../../plain_part.yaml"]' in saved, saved
        assert open("deep/er/cube.yaml").read() == 'geometries: {third: {type: mesh, file: "../../parts/other.stl"}} # mine\n'
        scene.edit(set={"objects.a.at": [0, 0, 1]})
        scene.save("deep/er/named.yaml", force=True)
        assert open("deep/er/named.yaml").read() == saved.replace("outside: air}", "outside: air, at: [0, 0, 1]}", 1)
        scene.undo()
        scene.save("top.yaml")
        assert "file: parts/other.stl" in open("top.yaml").read() and "plain_part.yaml" in open("top.yaml").read()
        scene.edit(set={"sources.lamp.cone": 30})
        assert "in its own folder" in str(refused(scene.save, "deep/er/wide.yaml", status=2)) and not os.path.exists("deep/er/wide.yaml")
        scene.undo()
        scene.save()
    for path in ("deep/er/named.yaml", "top.yaml"):
        with raymap.serve.start(path) as scene:
            if path != "top.yaml":
                scene.edit(remove=["objects.a.at"])
            scene.trace(4096)
            assert scene.status()["digest"] == digest, path
    run("trace", "top.yaml", "-n", "4096", "-o", "top.raymap", "--quiet", "--force")
    with raymap.serve.start("top.raymap") as scene:  # a map has a file of its own once it is saved
        scene.edit(set={"objects.a.at": [0, 0, 2]})
        refused(scene.save, status=2)
        scene.save("of_map.yaml")
        assert scene.save()["file"] == "of_map.yaml" and scene.status()["file"] == "of_map.yaml"


def start(*ways, scene="scene.yaml"):
    server = subprocess.Popen([RAYMAP, "serve", scene, *ways], stdout=subprocess.PIPE, text=True,
                              stderr=subprocess.DEVNULL)
    return server, json.loads(server.stdout.readline())


def check_clients():
    server, ready = start("--socket", "s.sock")
    try:
        assert ready["socket"] == "s.sock" and os.stat("s.sock").st_mode & 0o777 == 0o600
        one = raymap.serve.connect("s.sock")
        events = []
        one.on_event = events.append
        one.watch()
        one.ask("trace", rays=50_000_000)
        answers, clients = [], [raymap.serve.connect("s.sock") for _ in range(50)]

        def ask(client):
            answers.append(client.query("all")["rays"]["matched"])

        threads = [threading.Thread(target=ask, args=(c,)) for c in clients]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(60)
        assert len(answers) == 50, len(answers)
        states = [e for e in events if e["event"] == "trace"]
        assert states and states[-1]["state"] == "running" and states[-1]["of"] == 50_000_000
        assert one.trace is not None and one.ask("trace", action="pause")["state"] == "paused"
        rays = one.status()["trace"]["rays"]
        time.sleep(0.3)
        assert one.status()["trace"]["rays"] == rays
        one.ask("trace", action="resume")
        try:  # a question that waits for the trace is cancelled, and others go on
            one.ask("trace", rays=50_000_000, wait=True, timeout=0.5)
            raise AssertionError("the trace was done")
        except TimeoutError:
            pass
        assert one.ask("trace", action="stop")["state"] == "stopped"
        assert all("event" in event for event in events), events
        replaced = []
        waits = threading.Thread(target=lambda: replaced.append(refused(one.trace, 49_000_000, status=6)))
        waits.start()
        while clients[0].status()["trace"]["of"] != 49_000_000:
            time.sleep(0.01)
        clients[0].ask("trace", rays=4096)
        waits.join(60)
        assert "another trace" in str(replaced[0])
        for i, client in enumerate(clients):  # some in the middle of a word
            if i % 2:
                client._out.write('{"id": 1, "command": "paths"}\n{"id')
                client._out.flush()
            client.close()
        fuzz("s.sock")
        assert one.query("all")["rays"]["total"] >= 0
        one.quit()
        assert server.wait(20) == 0 and not os.path.exists("s.sock")
    finally:
        server.kill()


def check_render():
    """Others are answered while a picture comes, of the scene as it was; the picture is that of the command line."""
    scene = os.path.join(SOURCE, "examples/gradient-sphere/scene.yaml")
    size, seen, count = "64x48", {}, [0]
    server, _ = start("--socket", "s.sock", "--threads", "1", scene=scene)
    try:
        one, other = raymap.serve.connect("s.sock"), raymap.serve.connect("s.sock")

        def look():
            other.edit(set={"objects.glass_ball.at": [1, 2, 3]})
            while "all" not in seen:
                other.status()
                count[0] += 1

        def note(event):
            seen[event.get("samples")] = count[0], event.get("base64")
            if event.get("samples") == 1:
                thread.start()

        def give_up(client):
            try:
                client.ask("render", samples=100000, size=size, timeout=0.5)
                raise AssertionError("so soon")
            except TimeoutError:
                client.status()

        thread = threading.Thread(target=look)
        picture = one.render(samples=65, size=size, told=note)
        seen["all"] = count[0]
        thread.join(60)
        assert seen[64][0] > seen[1][0] == 0, {key: value if key == "all" else value[0] for key, value in seen.items()}
        threads = [threading.Thread(target=give_up, args=(raymap.serve.connect("s.sock"),)) for _ in range(6)]  # more than are drawn at once
        for thread in threads:
            thread.start()
        gone = raymap.serve.connect("s.sock")
        gone._send({"command": "render", "samples": 100000})
        gone.close()
        assert one.render(samples=4, size=size)["base64"] != seen[4][1]
        for thread in threads:
            thread.join(60)
        other.quit()
        assert server.wait(20) == 0
    finally:
        server.kill()
    for samples, base64_text in ((65, picture["base64"]), (4, seen[4][1])):
        run("render", scene, "--samples", str(samples), "--size", size, "-o", "eye.png", "--force", "--quiet")
        with open("eye.png", "rb") as file:
            assert file.read() == base64.b64decode(base64_text), samples


def fuzz(path):
    """Lines that are wrong in all ways: each complete one has an answer, none ends the server."""
    dice = random.Random(31)
    words = ["status", "edit", "query", "check", "trace", "draw", "cancel", "save", "load", "undo", "watch", "report"]
    values = [None, True, -1, 1e300, "", "all", "../x", "\0", "\ud800", [], {}, [[]], "hit(", "a" * 5000, 2 ** 62]
    keys = ["criterion", "where", "of", "text", "set", "move", "by", "rays", "action", "file", "id", "ray", "command"]
    connection = socket.socket(socket.AF_UNIX)
    connection.connect(path)
    stream = connection.makefile("rwb")
    sent = 0
    for _ in range(100):
        request = {"id": sent, "command": dice.choice(words)}
        for _ in range(dice.randrange(4)):
            request[dice.choice(keys)] = dice.choice(values)
        line = bytearray(json.dumps(request).encode())
        for _ in range(dice.choice((0, 0, 0, 1, 5))):
            line[dice.randrange(len(line))] = dice.randrange(256)
        line = bytes(line).replace(b"\n", b"?").replace(b"\r", b"?")
        stream.write(line + b"\n")
        stream.flush()
        sent += 1
        while b'"ok":' not in stream.readline():
            pass
    for line in (b"[" * 100000, b'{"command":"edit","set":{"limits.a' + b".a" * 200000 + b'":5}}'):
        stream.write(line + b"\n")
        stream.flush()
        assert b'"ok":false' in stream.readline(), line[:40]
    connection.close()


def check_http():
    server, ready = start("--http")
    host = ready["address"][7:]

    def ask(method="POST", path="/api", body='{"id": 1, "command": "status"}', **headers):
        connection = http.client.HTTPConnection(host, timeout=30)
        connection.putrequest(method, path, skip_host=True)
        given = {"Host": host, "Content_Type": "application/json", **headers, "Content_Length": str(len(body))}
        for name, value in given.items():
            if value is not None:
                connection.putheader(name.replace("_", "-"), value)
        connection.endheaders(body.encode())
        answer = connection.getresponse()
        return answer.status, answer.read(), answer

    try:
        token = "Bearer " + ready["token"]
        status, body, _ = ask(Authorization=token)
        assert status == 200 and json.loads(body)["result"]["file"] == "scene.yaml"
        for keys, code in (({}, 401), ({"Authorization": "Bearer " + "0" * 32}, 401), ({"Authorization": token[:-1]}, 401),
                           ({"Authorization": token, "Host": "evil.example:80"}, 403),
                           ({"Authorization": token, "Host": None}, 403),
                           ({"Authorization": token, "Origin": "http://evil.example"}, 403),
                           ({"Authorization": token, "Origin": "null"}, 403),
                           ({"Authorization": token, "Content_Type": "text/plain"}, 415)):
            for method, path in (("POST", "/api"), ("GET", "/"), ("GET", "/events")):
                if code == 415 and method == "GET":
                    continue
                status, body, _ = ask(method, path, **keys)
                assert status == code and body == b"", (keys, method, path, status, body)
        assert ask(Authorization=token, Origin="http://" + host)[0] == 200
        assert ask(Authorization=token, Host="localhost:" + host.split(":")[1])[0] == 200
        assert ask("GET", "/no/../../etc/passwd", Authorization=token)[0] == 404
        assert ask("PUT", Authorization=token)[0] == 405
        status, _, answer = ask("GET", "/?token=" + ready["token"], "")
        cookie = answer.getheader("Set-Cookie")
        assert status == 302 and "HttpOnly" in cookie and "SameSite=Strict" in cookie
        status, body, answer = ask("GET", "/", "", Cookie=cookie.split(";")[0])
        assert status == 200 and b"<" in body and "script-src 'self'" in answer.getheader("Content-Security-Policy")
        events = http.client.HTTPConnection(host, timeout=30)
        events.request("GET", "/events?token=" + ready["token"])
        stream = events.getresponse()
        assert stream.getheader("Content-Type") == "text/event-stream"
        ask(body='{"command": "trace", "rays": 20000}', Authorization=token)
        seen = []
        while not seen or seen[-1]["state"] != "done":
            line = stream.readline()
            seen += [json.loads(line[6:])] if line.startswith(b"data: ") else []
        assert seen[-1]["rays"] == 20000, seen[-1]
        vanishing = socket.create_connection(host.split(":"))
        vanishing.sendall(f"POST /api HTTP/1.1\r\nHost: {host}\r\nContent-Length: 1000\r\n\r\n{{".encode())
        vanishing.close()
        status, body, _ = ask(body='{"id": 9, "command": "quit"}', Authorization=token)
        assert status == 200 and json.loads(body)["ok"]
        assert server.wait(20) == 0
    finally:
        server.kill()


def check_ranks():
    with raymap.serve.start("scene.yaml", before=["mpirun", "--oversubscribe", "-np", "3"]) as lens:
        lens.trace(RAYS)
        assert lens.status()["ranks"] == 3
        assert lens.status()["digest"] == run("info", "full.raymap", "--json")["digest"]
        assert without_cost(lens.query("registered(sensor)")) == \
            without_cost(run("query", "full.raymap", "registered(sensor)", "--json"))
        refused(lens.query, "hot(x)", status=3)
        refused(lens.edit, text="objects: 5", status=3)
        run("trace", "scene.yaml", "--set", "objects.mount.at=[0, 0, 80]", "-n", str(RAYS), "-o", "moved.raymap", "--quiet", "--force")
        lens.move("mount", 0, 0, 1)
        assert lens.trace(RAYS)["rays_taken_over"] > 0
        assert lens.status()["digest"] == run("info", "moved.raymap", "--json")["digest"]
        with raymap.serve.start("moved.raymap") as moved:  # what a map was traced with stays in force
            moved.edit(set={"limits.steps": 5000})
            moved.trace(RAYS)
            assert moved.status()["digest"] == lens.status()["digest"]
        with raymap.serve.start("full.raymap") as one:  # rays of a map on disk are taken over, those of the seed asked last stay
            one.move("mount", 0, 0, 1)
            assert one.trace(RAYS)["rays_taken_over"] > 0 and one.status()["digest"] == lens.status()["digest"]
            for command, keys in (("report", {"ray": RAYS - 1}), ("paths", {"top": "all"})):  # of rays in other ranks' memory
                assert without_cost(lens.ask(command, **keys)) == without_cost(one.ask(command, **keys)), command
            assert lens.ask("model") and lens.ask("query", criterion="path_length > 9", explain=True)
            one.trace(RAYS // 2, seed=2)
            one.move("mount", 0, 0, 1)
            assert one.trace(RAYS // 2, seed=2)["rays_taken_over"] > 0
        with raymap.serve.start("full.raymap") as one:  # rays that are of no use for long give way to fewer that are
            one.edit(set={"limits.steps": 300})
            for wanted in (0, 0, 1):
                assert (one.trace(RAYS // 2)["rays_taken_over"] > 0) == wanted
                one.move("mount", 0, 0, 1)
        shutil.copytree("full.raymap", "gone.raymap", dirs_exist_ok=True)
        with raymap.serve.start("gone.raymap") as one:
            one.move("mount", 0, 0, 1)
            shutil.rmtree("gone.raymap")
            assert one.trace(RAYS)["state"] == "done" and one.status()["digest"] == lens.status()["digest"]
        assert lens.query("all")["rays"]["total"] == RAYS
        check_cancel(lens, ranks_of(lens._process))


PLAIN = """raymap: 1
media: {air: {index: 1}}
surfaces: {black: {type: absorber}}
geometries: {wall: {type: rectangle, size: [9, 9]}}
objects: [{name: wall, geometry: wall, at: [0, 0, 5], surface: black, outside: air}]
sources: [{name: lamp, type: point, at: [0, 0, 0], medium: air, cone: 20}]
detectors: [{name: plane, type: plane, at: [0, 0, 4], size: [9, 9], cells: [9, 9]}]
cameras: [{name: eye, at: [0, 0, -9], look_at: [0, 0, 0], fov: 60, resolution: [32, 32], medium: air}]
"""


def check_cancel(server, ranks):
    """What takes seconds stops on all ranks as soon as on the first."""
    with open("plain.yaml", "w") as file:
        file.write(PLAIN)
    server.load(file="plain.yaml")
    server.trace(131072)
    turn = [2 * math.pi * k / 100000 for k in range(100000)]
    ring = ", ".join(f"{1.2 * math.cos(a):.5f}, {1.2 * math.sin(a):.5f}" for a in turn)
    before = processor_seconds(ranks)
    try:
        server.query(f"registered(plane, polygon({ring}))", timeout=0.2)
        raise AssertionError("so soon")
    except TimeoutError:
        server.status()
    spent = [now - b for now, b in zip(processor_seconds(ranks), before)]
    assert max(spent) < 2 * spent[0] + 0.5, spent
    before, until = sum(processor_seconds(ranks)), []

    def cancel(event):
        if event.get("samples") == 256:
            until.append(sum(processor_seconds(ranks)) - before)
            server._send({"command": "cancel", "of": event["id"]})  # of this thread ask() would wait for itself

    refused(server.render, camera="eye", samples=100000, told=cancel, status=6)
    spent = sum(processor_seconds(ranks)) - before
    assert spent < 2 * until[0] + 0.1, (spent, until)  # four times as much without


def processor_seconds(processes):
    spent = []
    for process in processes:
        with open(f"/proc/{process}/stat") as file:
            spent.append(sum(map(int, file.read().rsplit(")", 1)[1].split()[11:13])) / os.sysconf("SC_CLK_TCK"))
    return spent


def ranks_of(mpirun):
    ranks = subprocess.run(["pgrep", "-P", str(mpirun.pid), "raymap"], capture_output=True, text=True)
    return ranks.stdout.split()


def check_one_core():
    """Ranks that wait leave a core that they share to the one that works: fifty times as much without."""
    core = str(min(os.sched_getaffinity(0)))
    with raymap.serve.start("plain.yaml", before=["mpirun", "--oversubscribe", "-np", "2", "taskset", "-c", core]) as server:
        ranks = ranks_of(server._process)
        before = sum(processor_seconds(ranks))
        server.render(samples=4, size="80x60")
        spent = sum(processor_seconds(ranks)) - before
        assert spent < 1, spent


def check_lost_rank():
    """One that is killed ends the server; who asked is told so, and does not wait."""
    server = subprocess.Popen(["mpirun", "--oversubscribe", "-np", "2", RAYMAP, "serve", "scene.yaml", "--stdin"],
                              stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    lens = raymap.serve.Server(server.stdout, server.stdin, server)
    assert lens.status()["ranks"] == 2
    ranks = ranks_of(server)
    assert len(ranks) == 2, ranks
    os.kill(int(ranks[1]), signal.SIGKILL)
    try:
        for _ in range(100):
            lens.query("all")
            time.sleep(0.1)
        raise AssertionError("it goes on")
    except ConnectionError:
        pass
    assert "Killed" in server.stderr.read()
    assert server.wait(20) != 0


def check_notebook():
    """The code of examples/python/serve.ipynb, cell by cell, with what its last lines show."""
    folder = os.path.join(SOURCE, "examples/python")
    with open(os.path.join(folder, "serve.ipynb")) as file:
        cells = [c for c in json.load(file)["cells"] if c["cell_type"] == "code"]
    here, names = os.getcwd(), {}
    os.chdir(folder)
    try:
        for cell in cells:
            exec("".join(cell["source"]), names)  # pylint: disable=exec-used
    finally:
        os.chdir(here)
    radius = names["radius"]
    assert len(radius) == 4 and sorted(radius) == radius and 0.01 < radius[0] < 0.8 * radius[3], radius


def main():
    shutil.rmtree("served", ignore_errors=True)
    os.makedirs("served/start")
    os.chdir("served/start")
    shutil.copy(os.path.join(SOURCE, "examples/double-gauss/scene.yaml"), "scene.yaml")
    for check in (check_answers, check_edits, check_mixed, check_included, check_meshes, check_bodies_of_maps, check_axes, check_places_as_written, check_first_items, check_shared, check_same, check_set_as_command_line, check_saving, check_saving_elsewhere, check_clients, check_render, check_http, check_ranks,
                  check_one_core, check_lost_rank, check_notebook):
        begun = time.monotonic()
        check()
        print(f"{check.__name__}: {time.monotonic() - begun:.1f} s", flush=True)
    os.chdir("../..")
    shutil.rmtree("served")


main()
