# SPDX-License-Identifier: MIT
"""Reads what raymap-step writes, by the words of io/cad/README.md alone, and measures it."""
import json
import pathlib

import numpy as np

KINDS = ("none", "plane", "cylinder", "cone", "sphere", "torus")
TYPES = {"double": "<f8", "int": "<i4", "uchar": "u1"}


class Mesh:
    """vertices (n, 3), triangles (m, 3), face (m), surfaces: rows with kind, o, a, r1, r2, colour; names: {face: name}."""

    def __init__(self, path):
        data = pathlib.Path(path).read_bytes()
        head, _, body = data.partition(b"end_header\n")
        self.names, elements = {}, []
        for line in head.decode().splitlines():
            words = line.split(" ")
            if words[:2] == ["comment", "face"]:
                self.names[int(words[2])] = " ".join(words[3:])
            elif words[0] == "element":
                elements.append((words[1], int(words[2]), []))
            elif words[0] == "property":
                elements[-1][2].append(words[1:])
        tables = {}
        for name, count, fields in elements:
            dtype = []
            for field in fields:
                if field[0] == "list":
                    dtype += [("corners", TYPES[field[1]]), (field[3], TYPES[field[2]], 3)]
                else:
                    dtype.append((field[1], TYPES[field[0]]))
            dtype = np.dtype(dtype)
            tables[name] = np.frombuffer(body, dtype, count)
            body = body[count * dtype.itemsize:]
        assert not body
        self.vertices = np.stack([tables["vertex"][k] for k in "xyz"], 1)
        self.triangles, self.face = tables["face"]["vertex_indices"], tables["face"]["face"]
        assert (tables["face"]["corners"] == 3).all()
        self.surfaces = tables["surface"]

    def open_edges(self):
        """Edges that are not there once in either direction."""
        a, b = (np.roll(self.triangles, k, axis=1).ravel().astype(np.int64) for k in (0, -1))
        edges, n = np.unique(a * len(self.vertices) + b, return_counts=True)
        return np.union1d(edges[n != 1], np.setdiff1d(edges, b * len(self.vertices) + a)).tolist()

    def volume(self):
        a, b, c = (self.vertices[self.triangles[:, k]] for k in range(3))
        return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6

    def area(self):
        a, b, c = (self.vertices[self.triangles[:, k]] for k in range(3))
        return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2

    def distances(self, face):
        """Of the vertices of a face from its true surface."""
        row = self.surfaces[face]
        at = self.vertices[np.unique(self.triangles[self.face == face])] - [row["ox"], row["oy"], row["oz"]]
        axis = np.array([row["ax"], row["ay"], row["az"]])
        assert abs(np.linalg.norm(axis) - 1) < 1e-12
        z = at @ axis
        rho = np.linalg.norm(at - np.outer(z, axis), axis=1)
        r1, r2 = row["r1"], row["r2"]
        return {"plane": lambda: z, "cylinder": lambda: rho - r1, "sphere": lambda: np.linalg.norm(at, axis=1) - r1,
                "cone": lambda: (rho - r1 - z * np.tan(r2)) * np.cos(r2),
                "torus": lambda: np.hypot(rho - r1, z) - r2}[KINDS[row["kind"]]]()

    def off(self):
        """The farthest that a vertex lies from a true surface of its own."""
        return max((np.abs(self.distances(f)).max() for f, row in enumerate(self.surfaces) if row["kind"]), default=0)


class Assembly:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.data = json.loads((self.folder / "assembly.json").read_text(encoding="utf-8"))
        self.shapes = {shape["id"]: shape for shape in self.data["shapes"]}
        self.parts = {}
        self._walk(self.data["parts"], np.eye(4))

    def _walk(self, parts, above):
        for part in parts:
            world = above @ np.vstack([np.reshape(part["matrix"], (3, 4)), [0, 0, 0, 1]])
            assert part["id"] not in self.parts
            self.parts[part["id"]] = dict(part, world=world)
            self._walk(part.get("parts", []), world)

    def mesh(self, shape):
        return Mesh(self.folder / self.shapes[shape]["file"])

    def leaves(self):
        return {name: part for name, part in self.parts.items() if "shape" in part}
