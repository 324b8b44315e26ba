#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""No mesh makes the program wait, fall over its own recursion or take memory without end: what a small file claims
is bounded, and the message names the file and the reason."""
import base64
import json
import os
import pathlib
import resource
import struct
import subprocess
import sys
import tempfile
import threading

PROGRAM = os.environ["RAYMAP"]
SCENE = """raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [587.56]}
media: {air: {index: 1}}
surfaces: {black: {type: absorber}}
geometries: {part: {type: mesh, file: FILE}}
objects: [{name: part, geometry: part, surface: black, inside: air, outside: air}]
sources: [{name: lamp, type: point, at: [0, 0, -30], direction: [0, 0, 1], distribution: {cone: 15},
           flux: 1 W, medium: air}]
simulations: [{name: short, rays: 10}]
"""
SECONDS, MIB = 60, 700  # most take 0.1 s and 60 MiB; the bounds allow 500 MiB
POINTS = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1)
CORNERS = struct.pack("<12H", 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3)
failures = 0


def check(name, *expected, status=3):
    """Of a scene with this mesh."""
    global failures
    pathlib.Path("scene.yaml").write_text(SCENE.replace("FILE", name))
    with tempfile.TemporaryFile() as out:
        child = subprocess.Popen([PROGRAM, "check", "scene.yaml"], stdout=out, stderr=out)
        timer = threading.Timer(SECONDS, child.kill)
        timer.start()
        _, waited, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(waited)
        timer.cancel()
        out.seek(0)
        said = out.read().decode(errors="replace")
    wrong = [word for word in ((name,) if status else ()) + expected if word not in said]
    if child.returncode != status or wrong or used.ru_maxrss > MIB * 1024:
        failures += 1
        print(f"FAIL {name}: {child.returncode}, not {status}; {used.ru_maxrss >> 10} MiB; lacks {wrong}\n{said[:600]}")


def gltf(name, nodes=None, **changes):
    """A tetrahedron, whose document is changed."""
    data = POINTS + CORNERS
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes or [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
        "buffers": [{"byteLength": 72, "uri": "data:;base64," + base64.b64encode(data).decode()}]}
    document.update(changes)
    text = json.dumps(document).encode()
    if name.endswith(".glb"):
        text += b" " * (-len(text) % 4)
        body = struct.pack("<II", len(data), 0x004E4942) + data
        text = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(body), len(text), 0x4E4F534A) + text + body
    pathlib.Path(name).write_bytes(text)
    return name


def special(name, kind):
    path = pathlib.Path(name)
    if path.is_dir() and not path.is_symlink():
        path.rmdir()
    path.unlink(missing_ok=True)
    if kind == "pipe":
        os.mkfifo(name)
    elif kind == "device":
        os.symlink("/dev/zero", name)
    else:
        path.mkdir()


def sparse(count, where, **more):
    """An accessor of `count` points without bytes of their own, of which one is replaced."""
    return [{"componentType": 5126, "count": count, "type": "VEC3", **more,
             "sparse": {"count": 1, "indices": {"bufferView": 2, "componentType": 5125},
                        "values": {"bufferView": 0}}},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}], [
        {"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24},
        {"buffer": 1, "byteLength": 4}], [
        {"byteLength": 72, "uri": "data:;base64," + base64.b64encode(POINTS + CORNERS).decode()},
        {"byteLength": 4, "uri": "data:;base64," + base64.b64encode(struct.pack("<I", where)).decode()}]


def gltf_sparse(name, count, where, **more):
    accessors, views, buffers = sparse(count, where, **more)
    return gltf(name, accessors=accessors, bufferViews=views, buffers=buffers)


def files():
    """Everything that a scene names must be a regular file, and is opened without waiting."""
    for kind in ("pipe", "device", "folder"):
        special("odd.bin", kind)
        check(gltf("buffer.gltf", buffers=[{"byteLength": 72, "uri": "odd.bin"}]), "odd.bin", "it is no regular file")
        for name in ("odd.stl", "odd.obj", "odd.ply", "odd.gltf", "odd.glb"):
            special(name, kind)
            check(name, "it is no regular file") if name == "odd.gltf" or kind == "pipe" else None
        special("odd.mtl", kind)
        pathlib.Path("materials.obj").write_text("mtllib odd.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                                 "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        check("materials.obj", status=0)
    pathlib.Path("a b.bin").write_bytes(POINTS + CORNERS)
    check(gltf("beside.gltf", buffers=[{"byteLength": 72, "uri": "a%20b.bin"}]), status=0)
    check(gltf("long.gltf", buffers=[{"byteLength": 73, "uri": "a%20b.bin"}]), "is cut off: 72 bytes of 73")
    with open("sparse.stl", "wb") as file:
        file.truncate(1 << 40)
    check("sparse.stl", "bytes are too many")


def nodes():
    whole = [{"mesh": 0}]
    check(gltf("whole.gltf"), status=0)
    check(gltf("whole.glb", buffers=[{"byteLength": 72}]), status=0)
    check(gltf("short.glb", buffers=[{"byteLength": 73}]), "is cut off")
    deep = [{"children": [i + 1]} for i in range(100000)] + whole
    check(gltf("deep.gltf", deep), "more than 256 deep")
    check(gltf("deep.glb", deep), "more than 256 deep")
    check(gltf("nearly.gltf", [{"children": [i + 1]} for i in range(255)] + whole), status=0)
    fan = [{"children": [i + 1] * 10} for i in range(8)] + whole  # 10^8 tetrahedra
    check(gltf("fan.gltf", fan), "stands in two places")
    check(gltf("cycle.gltf", [{"children": [1]}, {"children": [0]}]), "stands in two places")
    check(gltf("nowhere.gltf", [{"children": [7]}]), "node 7 is not there")
    pathlib.Path("brackets.gltf").write_text("[" * 1000000)
    check("brackets.gltf", "depth")
    # Many places of a mesh of many parts, with triangles, without, and with long names.
    many = [{"mesh": 0}] * 4000
    roots = [{"nodes": list(range(4000))}]
    for name, part in (("parts", {"attributes": {"POSITION": 0}, "indices": 1}), ("lines", {"mode": 1})):
        check(gltf(f"{name}.gltf", many, scenes=roots, meshes=[{"primitives": [part] * 4000}]), "it unfolds to more than")
    check(gltf("names.gltf", many, scenes=roots, meshes=[{"name": "x" * 1000, "primitives": [
        {"attributes": {"POSITION": 0}, "indices": 1}] * 400}]), "it unfolds to more than")


def places():
    """What is wrong in a mesh is named by its line, or its triangle."""
    tetrahedron = (((0, 0, 0), (0, 1, 0), (1, 0, 0)), ((0, 0, 0), (1, 0, 0), (0, 0, 1)), ((0, 0, 0), (0, 0, 1), (0, 1, 0)), ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    lines = ["solid t"]
    for t in tetrahedron:
        lines += ["facet normal 0 0 0", "outer loop"] + ["vertex %d %d %d" % v for v in t] + ["endloop", "endfacet"]
    for name, line, words, status in (("nan.stl", "vertex nan 0 1", "triangle 2 first", 0), ("word.stl", "vertex 0 abc 1", "line 12: 'vertex 0 abc 1'", 3),
                                      ("short.stl", "vertex 0 1", "line 12: 'vertex 0 1' is no point", 3)):
        pathlib.Path(name).write_text("\n".join(lines[:11] + [line] + lines[12:] + ["endsolid t"]) + "\n")
        check(name, words, status=status)
    pathlib.Path("nans.stl").write_text("\n".join(lines).replace("vertex 0", "vertex nan").replace("vertex 1", "vertex inf"))
    check("nans.stl", "none of its 4 triangles has an area", "triangle 1 first")
    points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    for name, text, words in (("index.obj", points + "f 1 3 2\nf 1 2 9\n", "line 6: face 2 has vertex 9"), ("back.obj", points + "f -1 -2 -3\r\nf 1/1 2/1 -9/1\n", "line 6: face 2 has vertex -9"),
                              ("zero.obj", points + "f 1 0 2", "line 5: face 1 has vertex 0"), ("word.obj", points.replace("v 0 1", "v x 1") + "f 1 2 4", "line 3: 'v x 1 0'")):
        pathlib.Path(name).write_text(text)
        check(name, words)
    head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\nproperty list uchar int " \
           "vertex_indices\nend_header\n" + points.replace("v ", "")
    pathlib.Path("index.ply").write_text(head + "3 0 2 1\n3 0 1 9\n")
    check("index.ply", "line 15: face 2 has a vertex that is not there: there are 0 to 3")
    pathlib.Path("word.ply").write_text(head.replace("0 1 0", "0 x 0") + "3 0 2 1\n3 0 1 2\n")
    check("word.ply", "line 12: it ends before what its header promises, or holds what is no number")
    pathlib.Path("index2.ply").write_bytes(head.replace("ascii", "binary_little_endian").partition("end_header\n")[0].encode() + b"end_header\n" + POINTS
                                           + struct.pack("<BiiiBiii", 3, 0, 2, 1, 3, 0, 1, 9))
    check("index2.ply", ": face 2 has a vertex that is not there: there are 0 to 3")
    check(gltf("index.gltf", meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}], buffers=[
        {"byteLength": 72, "uri": "data:;base64," + base64.b64encode(POINTS + CORNERS[:8] + b"\x09\0" + CORNERS[10:]).decode()}]),
        "meshes[0].primitives[0]: triangle 2 has vertex 9")


def counts():
    check(gltf_sparse("many.gltf", 10**9, 0), "it unfolds to more than")
    check(gltf_sparse("far.gltf", 4, 1 << 30), "replaces what is not there")
    check(gltf_sparse("good.gltf", 4, 3, bufferView=0), status=0)
    check(gltf("claims.gltf", accessors=[{"bufferView": 0, "componentType": 5126, "count": 10**9, "type": "VEC3"}]),
          "ends behind its buffer")
    check(gltf("view.gltf", bufferViews=[{"buffer": 0, "byteOffset": 2**53, "byteLength": 2**53}] * 2),
          "ends behind its buffer")
    check(gltf("corner.gltf", accessors=[{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                                         {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}]),
          "a vertex that is not there")
    check(gltf("packed.gltf", extensionsRequired=["KHR_draco_mesh_compression"]), "KHR_draco_mesh_compression")


def polygons():
    points = "".join(f"v {i % 7} {i // 7} {i % 3}\n" for i in range(100000))
    for name, joint in (("face.obj", " "), ("joined.obj", " \\\n"), ("returned.obj", " \\\rx\n")):
        pathlib.Path(name).write_text(points + "f " + joint.join(map(str, range(1, 100001))) + "\n")
        check(name, "a face has more than 4096 corners")
    pathlib.Path("ring.obj").write_text("".join(f"v {i} {i * i} 0\n" for i in range(3000)) +
                                        "f " + " ".join(map(str, range(1, 3001))) + "\n")
    check("ring.obj", status=0)


resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
for part in (files, nodes, places, counts, polygons):
    part()
sys.exit(failures != 0)
