# SPDX-License-Identifier: MIT
"""Models that tests write: boxes in glTF files."""
import base64
import json
import pathlib

import numpy as np

CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
SIDES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
TRIANGLES = np.array([t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))])


def box(sx, sy, sz):
    return CORNERS * [sx, sy, sz], TRIANGLES


def gltf(name, meshes, materials, nodes, roots):
    """here/NAME; meshes: name: [(points, triangles, material)]; in m."""
    body, views, accessors, listed = b"", [], [], []
    for mesh, parts in meshes.items():
        primitives = []
        for points, triangles, material in parts:
            for data, kind, component in ((points.astype("<f4"), "VEC3", 5126), (triangles.astype("<u4").ravel(), "SCALAR", 5125)):
                views.append({"buffer": 0, "byteOffset": len(body), "byteLength": data.nbytes})
                accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(data), "type": kind})
                body += data.tobytes()
            primitives.append({"attributes": {"POSITION": len(accessors) - 2}, "indices": len(accessors) - 1, "material": material})
        listed.append({"name": mesh, "primitives": primitives})
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": roots}], "nodes": nodes, "meshes": listed,
                "materials": materials, "accessors": accessors, "bufferViews": views,
                "buffers": [{"byteLength": len(body), "uri": "data:application/octet-stream;base64," + base64.b64encode(body).decode()}]}
    pathlib.Path("here", name).write_text(json.dumps(document), encoding="utf-8")
    return "here/" + name
