#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the room: 20 closed meshes of about 5,000 triangles each, and the scene file that places
them more than 200 times. The same files come out every time.

    python3 make_room.py [FOLDER]      default: the folder of this script

Lengths in metres; z is up. Meshes stand on z = 0 about the z axis, front sides outward.
"""
import math
import pathlib
import struct
import sys

N_AROUND, N_ALONG = 50, 52  # close to 2 * 50 * 52 = 5,200 triangles


def surface_of_revolution(profile):
    """A closed body from profile(s) = (radius, height), s in [0, 1], radius 0 at both ends."""
    rings = [profile(i / N_ALONG) for i in range(1, N_ALONG)]
    vertices = [(0.0, 0.0, profile(0.0)[1])]
    for radius, height in rings:
        for j in range(N_AROUND):
            phi = 2 * math.pi * j / N_AROUND
            vertices.append((radius * math.cos(phi), radius * math.sin(phi), height))
    vertices.append((0.0, 0.0, profile(1.0)[1]))
    last = len(vertices) - 1
    faces = []
    for j in range(N_AROUND):
        faces.append((0, 1 + (j + 1) % N_AROUND, 1 + j))
    for i in range(len(rings) - 1):
        below, above = 1 + i * N_AROUND, 1 + (i + 1) * N_AROUND
        for j in range(N_AROUND):
            k = (j + 1) % N_AROUND
            faces.append((below + j, below + k, above + k, above + j))
    top = 1 + (len(rings) - 1) * N_AROUND
    for j in range(N_AROUND):
        faces.append((last, top + j, top + (j + 1) % N_AROUND))
    return vertices, faces


def closed_tube(centre, radius):
    """A ring-shaped body: a tube of radius(s) about the closed curve centre(s), s in [0, 1)."""
    vertices, faces = [], []
    step = 1e-4
    for i in range(N_ALONG):
        s = i / N_ALONG
        p, ahead, behind = centre(s), centre(s + step), centre(s - step)
        tangent = unit([a - b for a, b in zip(ahead, behind)])
        side = unit(cross(tangent, (0.0, 0.0, 1.0)))
        up = cross(side, tangent)
        for j in range(N_AROUND):
            phi = 2 * math.pi * j / N_AROUND
            c, t = radius(s) * math.cos(phi), radius(s) * math.sin(phi)
            vertices.append(tuple(p[k] + c * side[k] + t * up[k] for k in range(3)))
    for i in range(N_ALONG):
        here, there = i * N_AROUND, ((i + 1) % N_ALONG) * N_AROUND
        for j in range(N_AROUND):
            k = (j + 1) % N_AROUND
            faces.append((here + j, there + j, there + k, here + k))
    return vertices, faces


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(sum(x * x for x in a))
    return tuple(x / length for x in a)


def power(base, exponent):
    return math.copysign(abs(base) ** exponent, base)


def superellipsoid(half, north, east):
    """A rounded box (exponents below 1) of half widths `half`, standing on z = 0 (Barr 1981)."""
    def place(i, j):
        theta = math.pi * (i / N_ALONG - 0.5)
        phi = 2 * math.pi * (j + 0.5) / N_AROUND
        c = power(math.cos(theta), north)
        return (half[0] * c * power(math.cos(phi), east), half[1] * c * power(math.sin(phi), east),
                half[2] * (1 + power(math.sin(theta), north)))
    vertices, faces = surface_of_revolution(lambda s: (1.0, 0.0))
    placed = [(0.0, 0.0, 0.0)]
    for i in range(1, N_ALONG):
        placed.extend(place(i, j) for j in range(N_AROUND))
    placed.append((0.0, 0.0, 2 * half[2]))
    assert len(placed) == len(vertices)
    return placed, faces


def lathe(points):
    """A solid of revolution through the profile's corners (radius, height), from axis to axis,
    with vertices spread evenly over the profile's length."""
    legs = [math.dist(a, b) for a, b in zip(points, points[1:])]
    total = sum(legs)

    def profile(s):
        way = s * total
        for a, b, leg in zip(points, points[1:], legs):
            if way <= leg or b is points[-1]:
                u = min(way / leg, 1.0)
                return (a[0] + u * (b[0] - a[0]), a[1] + u * (b[1] - a[1]))
            way -= leg
    return surface_of_revolution(profile)


def waves(radius, height, amplitude, count, swell=0.0):
    """A vase with a wavy outline, rounded off at foot and top."""
    def profile(s):
        end = math.sqrt(max(0.0, 1 - (2 * s - 1) ** 12))
        r = radius * (1 + amplitude * math.sin(2 * math.pi * count * s) + swell * math.sin(math.pi * s))
        return (r * end if 0 < s < 1 else 0.0, height * s)
    return surface_of_revolution(profile)


def ring(major, minor, wobble=0.0, lobes=0):
    """A torus, or a lobed one: the curve's radius of curvature must stay above `minor`."""
    def centre(s):
        phi = 2 * math.pi * s
        r = major * (1 + wobble * math.cos(lobes * phi))
        return (r * math.cos(phi), r * math.sin(phi), minor * 1.02)
    return closed_tube(centre, lambda s: minor)


def bodies():
    """name -> (suffix, material, mesh). Every body fits a cylinder of radius 0.16 and height 0.36
    about the z axis, but for plinth, board and bench, which the scene scales."""
    paint, glass, mirror = "paint", "glass", "mirror"
    return {
        "plinth": ("ply", paint, superellipsoid((0.16, 0.16, 0.4), 0.15, 0.15)),
        "board": ("ply", glass, superellipsoid((0.5, 0.11, 0.015), 0.15, 0.15)),
        "bench": ("ply", glass, superellipsoid((0.6, 0.2, 0.21), 0.2, 0.2)),
        "vase": ("ply", paint, waves(0.09, 0.34, 0.25, 1.0)),
        "urn": ("ply", paint, waves(0.08, 0.30, 0.08, 3.0, 0.7)),
        "column": ("ply", mirror, waves(0.07, 0.35, 0.10, 6.0)),
        "bowl": ("ply", paint, lathe([(0, 0.01), (0.05, 0.0), (0.12, 0.05), (0.15, 0.13),
                                      (0.14, 0.135), (0.11, 0.06), (0.04, 0.02), (0, 0.02)])),
        "goblet": ("ply", glass, lathe([(0, 0), (0.06, 0.0), (0.06, 0.01), (0.012, 0.02), (0.012, 0.12),
                                        (0.06, 0.16), (0.07, 0.26), (0.06, 0.26), (0.05, 0.17),
                                        (0, 0.14)])),
        "bottle": ("ply", glass, lathe([(0, 0), (0.06, 0.0), (0.065, 0.01), (0.065, 0.2), (0.02, 0.26),
                                        (0.02, 0.34), (0.015, 0.345), (0, 0.345)])),
        "cone": ("stl", paint, lathe([(0, 0), (0.13, 0.0), (0.13, 0.02), (0.01, 0.34), (0, 0.345)])),
        "ball": ("ply", glass, surface_of_revolution(
            lambda s: (0.13 * math.sin(math.pi * s) if 0 < s < 1 else 0.0,
                       0.13 * (1 - math.cos(math.pi * s))))),
        "egg": ("ply", mirror, surface_of_revolution(
            lambda s: (0.11 * math.sin(math.pi * s) * (1.2 - 0.4 * s) if 0 < s < 1 else 0.0,
                       0.165 * (1 - math.cos(math.pi * s))))),
        "dice": ("ply", paint, superellipsoid((0.1, 0.1, 0.1), 0.3, 0.3)),
        "pillow": ("ply", paint, superellipsoid((0.14, 0.1, 0.06), 1.0, 0.4)),
        "octahedron": ("ply", glass, superellipsoid((0.13, 0.13, 0.16), 2.0, 2.0)),
        "torus": ("ply", mirror, ring(0.11, 0.04)),
        "wreath": ("ply", paint, ring(0.11, 0.03, 0.06, 5)),
        "clover": ("obj", glass, ring(0.11, 0.025, 0.15, 3)),
        "lens": ("ply", glass, superellipsoid((0.15, 0.15, 0.03), 1.0, 1.0)),
        "top": ("obj", mirror, lathe([(0, 0), (0.02, 0.03), (0.14, 0.14), (0.14, 0.16), (0.03, 0.2),
                                      (0.02, 0.3), (0, 0.31)])),
    }


def triangles(faces):
    for face in faces:
        for k in range(1, len(face) - 1):
            yield face[0], face[k], face[k + 1]


def write_ply(path, vertices, faces):
    head = ("ply\nformat binary_little_endian 1.0\ncomment written by make_room.py\n"
            f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {len(faces)}\nproperty list uchar ushort vertex_indices\nend_header\n")
    body = b"".join(struct.pack("<3f", *v) for v in vertices)
    body += b"".join(struct.pack(f"<B{len(f)}H", len(f), *f) for f in faces)
    path.write_bytes(head.encode() + body)


def write_stl(path, vertices, faces):
    corners = [[vertices[i] for i in t] for t in triangles(faces)]
    body = struct.pack("<80sI", b"written by make_room.py", len(corners))
    for a, b, c in corners:
        normal = cross([q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)])
        body += struct.pack("<12fH", *unit(normal), *a, *b, *c, 0)
    path.write_bytes(body)


def write_obj(path, vertices, faces):
    half = len(faces) // 2
    lines = ["# written by make_room.py"]
    lines += ["v %.5f %.5f %.5f" % v for v in vertices]
    for name, part in (("lower", faces[:half]), ("upper", faces[half:])):
        lines.append("g " + name)
        lines += ["f " + " ".join(str(i + 1) for i in f) for f in part]
    path.write_text("\n".join(lines) + "\n")


HEAD = """\
# A gallery: 20 meshes (written by make_room.py, as is this file) in {count} instances. Mirrors on
# three walls; the other wall, floor, ceiling and paint are Lambertian with reflectance 0.7; shelves,
# benches and some bodies are of glass, some of metal. A lamp under the ceiling. A light path has
# 9 segments on average. Lengths in metres, z up.
raymap: 1
units: m
spectrum: {{mode: rgb}}
media:
  air: {{index: 1}}
  glass: {{glass: N-BK7}}
surfaces:
  white:  {{type: lambert, reflectance: 0.7}}
  red:    {{type: lambert, reflectance: {{rgb: [0.9, 0.6, 0.6]}}}}
  mirror: {{type: mirror, reflectance: 0.98}}
  clear:  {{type: fresnel}}
geometries:
  floor_plate: {{type: rectangle, size: [{x}, {y}]}}
  side_plate:  {{type: rectangle, size: [{z}, {y}]}}
  end_plate:   {{type: rectangle, size: [{x}, {z}]}}
"""

TAIL = """\
sources:
  - {{name: lamp, type: area, shape: {{rectangle: [2, 1]}}, at: [0, 0, {lamp}], direction: [0, 0, -1], flux: 6000 lm,
     spectrum: {{rgb: [1, 1, 1]}}, medium: air}}
detectors:
  - {{name: floor_map, type: plane, on: floor, size: [{x}, {y}], cells: [120, 80], at: [0, 0, 0], direction: [0, 0, 1]}}
"""

ROOM = (6.0, 4.0, 3.0)


def placed_bodies(material):
    """Yields (group, name, geometry, position, turn, scale) of every instance."""
    small = [name for name in material if name not in ("plinth", "board", "bench")]
    gap = 0.001  # nothing touches anything

    def pick(k):
        return small[(7 * k + k // len(small)) % len(small)]

    k = 0
    # Shelves along both long walls: 5 boards high, 5 boards along, 3 bodies on each.
    for wall, y in (("south", -ROOM[1] / 2 + 0.16), ("north", ROOM[1] / 2 - 0.16)):
        for level in range(5):
            height = 0.3 + 0.5 * level
            for column in range(5):
                x = -2.2 + 1.1 * column
                board = f"board_{wall}_{level}_{column}"
                yield "shelves", board, "board", (x, y, height), 0, 1
                for place in range(3):
                    at = (x + 0.33 * (place - 1), y, height + 0.03 + gap)
                    scale = 0.62
                    yield "shelves", f"{pick(k)}_{k}", pick(k), at, (37 * k) % 360, scale
                    k += 1
    # Plinths and benches in the middle, a body on each.
    for row in range(2):
        for column in range(5):
            x, y = -2.0 + column, -0.6 + 1.2 * row
            name = f"plinth_{row}_{column}"
            yield "floor_pieces", name, "plinth", (x, y, gap), (15 * column) % 360, 1
            yield "floor_pieces", f"{pick(k)}_{k}", pick(k), (x, y, 0.8 + 2 * gap), (53 * k) % 360, 0.9
            k += 1
    for column in range(3):
        yield "floor_pieces", f"bench_{column}", "bench", (-1.5 + 1.5 * column, 0, gap), 0, 1


def write_scene(path, material, count, bodies_placed):
    x, y, z = ROOM
    look = {"paint": "white", "glass": "clear", "mirror": "mirror"}
    lines = [HEAD.format(count=count, x=x, y=y, z=z).rstrip("\n")]
    for name, (suffix, _, _) in material.items():
        lines.append(f"  {name}: {{type: mesh, file: meshes/{name}.{suffix}}}")
    lines.append("objects:")
    walls = [("floor", "floor_plate", "white", (0, 0, 0), (0, 0, 0)),
             ("ceiling", "floor_plate", "white", (0, 0, z), (180, 0, 0)),
             ("west_wall", "side_plate", "mirror", (-x / 2, 0, z / 2), (0, 90, 0)),
             ("east_wall", "side_plate", "mirror", (x / 2, 0, z / 2), (0, -90, 0)),
             ("south_wall", "end_plate", "red", (0, -y / 2, z / 2), (-90, 0, 0)),
             ("north_wall", "end_plate", "mirror", (0, y / 2, z / 2), (90, 0, 0))]
    lines.append("  - name: walls\n    objects:")
    for name, geometry, surface, at, turn in walls:
        lines.append(f"      - {{name: {name}, geometry: {geometry}, rotate: {list(turn)}, at: {list(at)}, "
                     f"surface: {surface}, front: air, back: air}}")
    for group in ("shelves", "floor_pieces"):
        lines.append(f"  - name: {group}\n    objects:")
        for owner, name, geometry, at, turn, scale in bodies_placed:
            if owner != group:
                continue
            inside = "glass" if material[geometry][1] == "glass" else "air"
            where = ", ".join(f"{v:.4g}" for v in at)
            lines.append(f"      - {{name: {name}, geometry: {geometry}, scale: {scale}, rotate: [0, 0, {turn}], "
                         f"at: [{where}], surface: {look[material[geometry][1]]}, inside: {inside}, outside: air}}")
    lines.append(TAIL.format(x=x, y=y, lamp=z - 0.01).rstrip("\n"))
    path.write_text("\n".join(lines) + "\n")


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent)
    meshes = folder / "meshes"
    meshes.mkdir(parents=True, exist_ok=True)
    writers = {"ply": write_ply, "stl": write_stl, "obj": write_obj}
    material = bodies()
    total = 0
    for name, (suffix, _, (vertices, faces)) in material.items():
        writers[suffix](meshes / f"{name}.{suffix}", vertices, faces)
        total += sum(1 for _ in triangles(faces))
    placed = list(placed_bodies(material))
    write_scene(folder / "scene.yaml", material, len(placed), placed)
    print(f"{len(material)} meshes, {total} triangles, {len(placed)} instances")


if __name__ == "__main__":
    main()
