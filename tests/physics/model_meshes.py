# SPDX-License-Identifier: MIT
"""Meshes whose faces lie on true surfaces, written as PLY files: bodies of revolution, boxes, pipes."""
import math
import struct

PLANE, CYLINDER, CONE, SPHERE, TORUS = 1, 2, 3, 4, 5
KEYS = ("ox", "oy", "oz", "ax", "ay", "az", "r1", "r2")


class Model:
    def __init__(self):
        self.vertices, self.number, self.triangles, self.surfaces, self.names = [], {}, [], [], []

    def vertex(self, p):
        key = tuple(round(c, 9) + 0.0 for c in p)
        if key not in self.number:
            self.number[key] = len(self.vertices)
            self.vertices.append(p)
        return self.number[key]

    def face(self, kind, at=(0, 0, 0), axis=(0, 0, 1), r1=0.0, r2=0.0, name=""):
        self.surfaces.append((kind, *at, *axis, r1, r2))
        self.names.append(name)
        return len(self.surfaces) - 1

    def polygon(self, face, *points):
        corners = [self.vertex(p) for p in points]
        corners = [c for k, c in enumerate(corners) if c != corners[k - 1]]
        for k in range(2, len(corners)):
            self.triangles.append(((corners[0], corners[k - 1], corners[k]), face))

    def write(self, path, surfaces=True):
        head = ["ply", "format binary_little_endian 1.0", "comment unit mm"]
        head += [f"comment face {k} {n}" for k, n in enumerate(self.names) if n]
        head += [f"element vertex {len(self.vertices)}"] + [f"property double {c}" for c in "xyz"]
        head += [f"element face {len(self.triangles)}", "property list uchar int vertex_indices", "property int face"]
        if surfaces:
            head += [f"element surface {len(self.surfaces)}", "property int kind"]
            head += [f"property double {k}" for k in KEYS] + [f"property uchar {c}" for c in ("red", "green", "blue")]
        with open(path, "wb") as file:
            file.write(("\n".join(head) + "\nend_header\n").encode())
            for p in self.vertices:
                file.write(struct.pack("<3d", *p))
            for corners, face in self.triangles:
                file.write(struct.pack("<B4i", 3, *corners, face))
            for row in self.surfaces if surfaces else ():
                file.write(struct.pack("<i8d3B", *row, 255, 255, 255))
        return path


def line(a, b, kind=None):
    """A straight piece of a profile from (r, z) to (r, z)."""
    return {"a": a, "b": b, "kind": kind}


def arc(a, b, centre, radius):
    """One that bulges to the side where the shorter way from a to b runs."""
    return {"a": a, "b": b, "centre": centre, "radius": radius}


def points(piece, chord):
    if "centre" not in piece:
        return [piece["a"], piece["b"]]
    (cr, cz), radius = piece["centre"], piece["radius"]
    begin = math.atan2(piece["a"][1] - cz, piece["a"][0] - cr)
    end = math.atan2(piece["b"][1] - cz, piece["b"][0] - cr)
    turn = (end - begin + math.pi) % (2 * math.pi) - math.pi
    n = max(1, math.ceil(abs(turn) / chord - 1e-9))
    inner = [(cr + radius * math.cos(begin + turn * k / n), cz + radius * math.sin(begin + turn * k / n))
             for k in range(1, n)]
    return [piece["a"], *inner, piece["b"]]


def add_face(model, piece, name):
    (ra, za), (rb, zb) = piece["a"], piece["b"]
    if piece.get("kind") == 0:
        return model.face(0, name=name)
    if "centre" in piece:
        r, z = piece["centre"]
        if r == 0:
            return model.face(SPHERE, (0, 0, z), r1=piece["radius"], name=name)
        return model.face(TORUS, (0, 0, z), r1=r, r2=piece["radius"], name=name)
    if za == zb:
        return model.face(PLANE, (0, 0, za), name=name)
    if ra == rb:
        return model.face(CYLINDER, (0, 0, za), r1=ra, name=name)
    return model.face(CONE, (0, 0, za), r1=ra, r2=math.atan((rb - ra) / (zb - za)), name=name)


def revolved(profile, chord=math.radians(10), halves=1, names=None):
    """The body on the left of a profile in the plane (r, z). halves: faces that each piece is cut into."""
    model, n = Model(), math.ceil(2 * math.pi / chord / halves) * halves
    angle = [2 * math.pi * j / n for j in range(n)] + [0.0]

    def at(p, j):
        return (p[0] * math.cos(angle[j]), p[0] * math.sin(angle[j]), p[1])

    for k, piece in enumerate(profile):
        along = points(piece, chord)
        for half in range(halves):
            face = add_face(model, piece, names[k] if names else "")
            for p, q in zip(along, along[1:]):
                for j in range(half * n // halves, (half + 1) * n // halves):
                    model.polygon(face, at(p, j), at(p, j + 1), at(q, j + 1), at(q, j))
    return model


def sag(radius, r):
    return radius - math.copysign(math.sqrt(radius * radius - r * r), radius)


def cap(radius, vertex, semi, outward):
    """A spherical piece of a lens between the axis and its edge, in the direction given."""
    rim, middle = (semi, vertex + sag(radius, semi)), (0.0, vertex)
    ends = (middle, rim) if outward else (rim, middle)
    return arc(*ends, (0, vertex + radius), abs(radius))


def singlet(r1, r2, thickness, semi, at=0.0, chord=math.radians(10), halves=1):
    """Vertex of the first surface at z = at; light comes from below."""
    first, last = cap(r1, at, semi, True), cap(r2, at + thickness, semi, False)
    return revolved([first, line(first["b"], last["a"]), last], chord, halves, ["front", "edge", "back"])


def box(size, true=True):
    model = Model()
    half = [s / 2 for s in size]
    for axis in range(3):
        for side in (-1, 1):
            normal = [0.0, 0.0, 0.0]
            normal[axis] = float(side)
            face = model.face(PLANE if true else 0, tuple(n * h for n, h in zip(normal, half)), tuple(normal))
            u, v = (axis + 1) % 3, (axis + 2) % 3
            corners = []
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                p = [0.0, 0.0, 0.0]
                p[axis], p[u], p[v] = side * half[axis], a * half[u], b * half[v]
                corners.append(tuple(p))
            model.polygon(face, *(corners if side > 0 else corners[::-1]))
    return model


def torus(major, minor, around=24, across=16):
    """One face."""
    model = Model()
    face = model.face(TORUS, r1=major, r2=minor)

    def at(i, j):
        u, v = 2 * math.pi * (i % across) / across, 2 * math.pi * (j % around) / around
        r = major + minor * math.cos(u)
        return (r * math.cos(v), r * math.sin(v), minor * math.sin(u))

    for i in range(across):
        for j in range(around):
            model.polygon(face, at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j))
    return model


def off_surface(row, p):
    """Signed distance of a point from one of a model's surfaces, and the unit normal."""
    kind, at, a, r1, r2 = row[0], row[1:4], row[4:7], row[7], row[8]
    q = [x - y for x, y in zip(p, at)]
    z = sum(x * y for x, y in zip(q, a))
    flat = [x - z * y for x, y in zip(q, a)]
    rho = math.hypot(*flat)
    out = [x / rho if rho else 0.0 for x in flat]
    if kind == PLANE:
        return z, list(a)
    if kind == CYLINDER:
        return rho - r1, out
    if kind == CONE:
        c, s = math.cos(r2), math.sin(r2)
        return (rho - r1 - z * math.tan(r2)) * c, [c * x - s * y for x, y in zip(out, a)]
    if kind == SPHERE:
        return math.hypot(*q) - r1, [x / math.hypot(*q) for x in q]
    off = math.hypot(rho - r1, z)
    return off - r2, [((rho - r1) * x + z * y) / off for x, y in zip(out, a)]
