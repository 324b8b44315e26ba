# SPDX-License-Identifier: MIT
"""Scenes by chance: all that docs/scene.md offers, in combinations nobody would draw up: surfaces
that touch, coincide or are met edge on, rays along axes and through corners, sources on surfaces,
maps that shear, mirror, and lie far from the origin. `scene(seed, folder)` writes one and says how
to trace it."""
import itertools
import json
import math
import os
import random

NICE = (-4, -3, -2, -1.5, -1, -0.5, 0, 0, 0, 0.5, 1, 1.5, 2, 3, 4)
ANGLES = (0, 0, 0, 90, 180, -90, 45, 30, 17.3, 270)
GLASSES = ("N-BK7", "N-SF11", "N-SF2", "N-BAK4")


def cube(half):
    """Corners and triangles of a cube, outward."""
    corners = list(itertools.product((-half, half), repeat=3))
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def octahedron(radius):
    """Two pyramids, with a vertex on each axis."""
    corners = [(radius, 0, 0), (-radius, 0, 0), (0, radius, 0), (0, -radius, 0), (0, 0, radius),
               (0, 0, -radius)]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    return corners, faces


def ball(radius, n):
    """A sphere of n stripes of latitude and 2 n of longitude."""
    corners = [(radius * math.sin(math.pi * i / n) * math.cos(math.pi * k / n),
                radius * math.sin(math.pi * i / n) * math.sin(math.pi * k / n),
                radius * math.cos(math.pi * i / n)) for i in range(n + 1) for k in range(2 * n)]
    faces = []
    for i in range(n):
        for k in range(2 * n):
            a, b = i * 2 * n + k, i * 2 * n + (k + 1) % (2 * n)
            faces += [(a, a + 2 * n, b + 2 * n), (a, b + 2 * n, b)]
    return corners, faces


def sheet(n, size, dice, rough):
    """A square of n x n cells, two triangles each, flat or rough."""
    corners = [(size * (i / n - 0.5), size * (k / n - 0.5), dice.choice((0, rough * dice.random())))
               for i in range(n + 1) for k in range(n + 1)]
    faces = []
    for i in range(n):
        for k in range(n):
            a = i * (n + 1) + k
            faces += [(a, a + n + 1, a + 1), (a + 1, a + n + 1, a + n + 2)]
    return corners, faces


class Dice:
    """One scene."""

    def __init__(self, seed, folder):
        self.dice = random.Random(seed)
        self.seed = seed
        self.folder = folder
        self.spectral = self.dice.random() < 0.7
        # Light without turbid and gradient media, metals and far detectors is what is predicted.
        self.turbid = self.dice.random() < 0.15
        self.gradient = self.dice.random() < 0.06
        self.exact = self.dice.random() < 0.5  # nice numbers: things coincide
        self.wavelengths = self.choose_wavelengths()

    def chance(self, share):
        return self.dice.random() < share

    def number(self, low, high):
        if self.exact or self.chance(0.3):
            inside = [x for x in NICE if low <= x <= high]
            if inside:
                return self.dice.choice(inside)
        return self.dice.uniform(low, high)

    def choose_wavelengths(self):
        n = self.dice.choice((1, 1, 2, 3, 3, 4, 5, 7, 33, 128))
        nm = [round(self.dice.uniform(400, 700), 2) for _ in range(n)]
        return sorted(set(nm), key=nm.index)

    def quantity(self, most=1.0, least=0.0):
        kind = self.dice.choice(("number", "number", "end", "curve", "curve", "rgb"))
        value = lambda: round(self.dice.uniform(least, most), 4)
        if kind == "number":
            return value()
        if kind == "end":
            return self.dice.choice((least, most))
        if kind == "curve":
            ends = [value(), value()] if self.chance(0.8) else [least, most]
            return {"wavelength": [420, 680], "value": ends}
        return {"rgb": [value(), value(), value()]}

    def media(self):
        found = {"air": {"index": 1} if self.chance(0.9) else {"index": 1.0003}}
        for name in ("water", "glass", "oil", "gas"):
            kind = self.dice.choice(("index", "index", "same", "glass", "sellmeier", "table"))
            if kind == "index":
                found[name] = {"index": round(self.dice.uniform(1, 2.4), 3)}
            elif kind == "same":
                found[name] = dict(found["air"])
            elif kind == "glass":
                found[name] = {"glass": self.dice.choice(GLASSES)}
            elif kind == "sellmeier":
                found[name] = {"sellmeier": {"B": [1.0, 0.3], "C": [0.006, 0.02]}}
            else:
                found[name] = {"table": {"wavelength": [400, 550, 700], "n": [1.6, 1.55, 1.5]}}
            if self.turbid and self.chance(0.5):
                found[name]["absorption"] = self.quantity(0.2)
            if self.turbid and self.chance(0.3):
                found[name]["scattering"] = self.quantity(0.3)
                found[name]["scattering_g"] = self.dice.choice((0, 0.8, -0.5))
        if self.gradient:
            found["gas"] = {"gradient": self.dice.choice((
                {"type": "luneburg", "radius": 2}, {"type": "constant", "index": 1.2},
                {"type": "axial", "coefficients": [1.5, 0.02]},
                {"type": "parabolic", "n0": 1.6, "alpha": 0.1}))}
        return found

    def surface(self):
        kind = self.dice.choice(("fresnel", "fresnel", "coat", "mirror", "mirror", "lambert",
                                 "lambert", "absorber", "mixture", "mixture", "metal", "fresnel", "mixture"))
        if kind == "fresnel":
            return {"type": "fresnel"}
        if kind == "coat":
            coat = self.dice.choice(("ideal", {"reflectance": self.quantity()}, {"reflectance": self.quantity()}, {"film": "ar"},
                                     {"film": "dark"}))
            return {"type": "fresnel", "coat": coat}
        if kind == "mirror":
            return {"type": "mirror", "reflectance": self.quantity(1, 0.5)}
        if kind == "metal":
            return {"type": "mirror", "metal": {"n": 0.2, "k": self.number(1, 4)}}
        if kind == "lambert":
            return {"type": "lambert", "reflectance": self.quantity(1, 0.5)}
        if kind == "absorber":
            return {"type": "absorber"}
        shares = ["reflect_specular", "reflect_diffuse", "transmit_specular", "transmit_diffuse"]
        self.dice.shuffle(shares)
        chosen = shares[:self.dice.randint(1, 4)]
        most = 0.999 / len(chosen)
        return {"type": "mixture", **{s: self.quantity(most, 0.7 * most) for s in chosen}}

    def write_mesh(self, name, mesh):
        corners, faces = mesh
        with open(os.path.join(self.folder, name), "w", encoding="utf-8") as file:
            for corner in corners:
                file.write("v %.9g %.9g %.9g\n" % tuple(corner))
            for n, face in enumerate(faces):
                if n in (0, len(faces) // 2):
                    file.write(f"g half{n > 0:d}\n")
                file.write("f %d %d %d\n" % tuple(k + 1 for k in face))

    def mesh(self, name):
        made = self.dice.choice((lambda: cube(1), lambda: cube(0.5), lambda: octahedron(1),
                                 lambda: ball(1, 4), lambda: ball(2, 9),
                                 lambda: sheet(3, 4, self.dice, 0),
                                 lambda: sheet(4, 3, self.dice, 0.3)))()
        if self.chance(0.15):  # a second body in the same place
            corners, faces = made
            n = len(corners)
            made = (corners * 2, faces + [tuple(n + k for k in face[::-1]) for face in faces])
        self.write_mesh(f"{name}.obj", made)
        return {"type": "mesh", "file": f"{name}.obj"}

    def conic(self):
        aperture = self.dice.choice((1, 1.5, 2, 3))
        radius = self.dice.choice((2, 3, 4, -3, -5, 10, -20, 100, 1e4, "inf", 0))
        constant = self.dice.choice((0, 0, 0, -1, -1, -2.5, 0.4, -0.5))
        if isinstance(radius, (int, float)) and radius and 1 + constant > 0:
            aperture = min(aperture, 0.95 * abs(radius) / math.sqrt(1 + constant))
            if self.chance(0.1) and constant == 0:
                aperture = abs(radius)  # a half sphere
        shape = {"type": "conic", "radius": radius, "conic": constant, "aperture": aperture}
        if self.chance(0.15):
            shape["asphere"] = {4: self.dice.choice((1e-3, -1e-4)), 6: 1e-5}
            shape["aperture"] = 0.7 * aperture
        if self.chance(0.2):
            shape["inner"] = 0.3 * shape["aperture"]
        return shape

    def lens(self):
        n = self.dice.randint(2, 6)
        rows = []
        for k in range(n):
            radius = self.dice.choice((8, -8, 12, -15, 30, -30, 60, "inf", "inf"))
            row = {"radius": radius, "aperture": self.dice.choice((1.5, 2, 2)),
                   "medium": self.dice.choice(("glass", "water", "air")) if k < n - 1 else "air"}
            if k < n - 1:
                row["thickness"] = self.dice.choice((1, 1.5, 2))
            if radius != "inf" and self.chance(0.2):
                row["conic"] = self.dice.choice((-1, 0.5))
            if radius != "inf" and self.chance(0.1):
                row["asphere"] = {4: 1e-4}
            rows.append(row)
        if self.chance(0.4):
            rows[self.dice.randrange(n)]["stop"] = True
        return {"type": "lens", "surface": self.dice.choice(self.clear),
                "edge": self.dice.choice(self.all_surfaces), "surfaces": rows}

    def geometry(self, name):
        kind = self.dice.choice(("conic", "conic", "rectangle", "disc", "cylinder", "cone",
                                 "sphere", "sphere", "mesh", "mesh", "lens"))
        if kind == "conic":
            return self.conic()
        if kind == "rectangle":
            return {"type": kind, "size": [self.dice.choice((1, 2, 4)), self.dice.choice((2, 3))]}
        if kind == "disc":
            return {"type": kind, "radius": self.dice.choice((1, 2)),
                    "inner": self.dice.choice((0, 0, 0.5))}
        if kind == "cylinder":
            return {"type": kind, "radius": self.dice.choice((0.5, 1, 2)), "length": 2}
        if kind == "cone":
            return {"type": kind, "radius": self.dice.choice((0, 1, 2)),
                    "radius2": self.dice.choice((0.5, 1, 3)), "length": self.dice.choice((1, 2))}
        if kind == "sphere":
            return {"type": kind, "radius": self.dice.choice((0.5, 1, 1, 2, 1e-3))}
        return self.mesh(name) if kind == "mesh" else self.lens()

    def place(self, item):
        if self.chance(0.12):
            shear = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
            for i, k in itertools.permutations(range(3), 2):
                shear[i][k] = self.dice.choice((0, 0, 0.5, -0.3))
            if self.chance(0.3):
                shear[2] = [-x for x in shear[2]]
            t = self.position()
            rows = [shear[i] + [t[i]] for i in range(3)]
            determinant = sum(
                shear[0][i] * (shear[1][(i + 1) % 3] * shear[2][(i + 2) % 3] -
                               shear[1][(i + 2) % 3] * shear[2][(i + 1) % 3]) for i in range(3))
            if abs(determinant) > 0.1:
                item["matrix"] = sum(rows, [])
                return
        item["at"] = self.position()
        if self.chance(0.5):
            item["rotate"] = [self.dice.choice(ANGLES) if self.exact else
                              self.dice.uniform(-180, 180) for _ in range(3)]
        if self.chance(0.4):
            item["scale"] = self.dice.choice((-1, 2, 0.5, [1, 1, -1], [1, 2, 1], [-1, 1.5, 0.7],
                                              1e-3, 30, [1, 1, 1e-3], 1.0000000000001))

    def position(self):
        return [self.number(-4, 4) for _ in range(3)]

    def instance(self, name, surfaces):
        geometry = self.dice.choice(sorted(self.geometries))
        item = {"name": name, "geometry": geometry}
        self.place(item)
        kind = self.geometries[geometry]["type"]
        if kind == "lens":
            item["outside"] = "air"
            return item
        closed = kind in ("sphere", "mesh")
        media = ["air", "water", "glass", "oil", "gas"]
        back = self.dice.choice(media) if closed or self.chance(0.1) else "air"
        front = "air" if self.chance(0.95) else self.dice.choice(media)
        item["surface"] = self.dice.choice(surfaces)
        if self.chance(0.2):
            item["surface"] = {"front": item["surface"], "back": self.dice.choice(surfaces)}
        item["front"], item["back"] = front, back
        return item

    def twin(self, item, name):
        """Where another stands: the same, inside it, or with media turned round."""
        found = json.loads(json.dumps(item))
        found["name"] = name
        if "back" in found:
            if self.chance(0.5):
                found["front"], found["back"] = found["back"], found["front"]
            else:
                found["front"] = found["back"]
                found["back"] = "water"
            found["surface"] = self.dice.choice(self.all_surfaces)
        if "at" in found and self.chance(0.5):  # it touches
            k = self.dice.randrange(3)
            found["at"][k] += self.dice.choice((-2, -1, 1, 2))
        elif "scale" not in found and "matrix" not in found and self.chance(0.5):
            found["scale"] = 0.5
        return found

    def objects(self):
        found = []
        if self.chance(0.85):
            wall = self.dice.choice(self.opaque)
            kind = self.dice.choice(("hall", "room", "hall"))
            found.append({"name": "walls", "geometry": kind, "surface": wall, "inside": "air",
                          "outside": "air"})
        for k in range(self.dice.randint(1, 10)):
            if found and self.chance(0.25):
                found.append(self.twin(self.dice.choice(found), f"twin{k}"))
            else:
                found.append(self.instance(f"body{k}", self.all_surfaces))
        if self.chance(0.3) and len(found) > 2:
            group = {"name": "group", "objects": found[-2:]}
            self.place(group)
            found = found[:-2] + [group]
        return found

    def direction(self):
        if self.exact or self.chance(0.3):
            way = [self.dice.choice((0, 0, 1, -1)) for _ in range(3)]
            if any(way):
                return way
            return [0, 0, 1]
        return [self.dice.gauss(0, 1) for _ in range(3)]

    def source(self, name, objects):
        kind = self.dice.choice(("collimated", "point", "point", "area", "area", "rays", "rays"))
        source = {"name": name, "type": kind, "flux": self.dice.choice(("1 W", "20 mW", 2)),
                  "medium": "air", "rays_share": self.dice.choice((1, 1, 0.3))}
        if self.chance(0.3):
            source["spectrum"] = self.dice.choice((
                "D65", "equal", {"rgb": [1, 0.2, 0]}, {"rgb": [0, 0, 1]}, {"blackbody": 3000},
                {"lines": {str(self.wavelengths[0]): 1}}, {"table": {"wavelength": [390, 710],
                                                                     "value": [0.01, 1]}}))
        at = self.position()
        if self.chance(0.3):  # on, or in the middle of, an object
            at = list(self.dice.choice(objects).get("at", at))
            at[self.dice.randrange(3)] += self.dice.choice((0, 1, -1, 0.5))
        if kind == "rays":
            source["rays"] = []
            for _ in range(self.dice.randint(1, 40)):
                ray = {"origin": self.position() if self.chance(0.6) else at,
                       "direction": self.direction()}
                if self.spectral and self.chance(0.3):
                    ray["wavelength"] = self.dice.choice(self.wavelengths)
                source["rays"].append(ray)
            source.pop("rays_share")
            return source
        source["at"] = at
        if self.chance(0.7):
            source["direction"] = self.direction()
        if kind == "point":
            source["distribution"] = self.dice.choice(("isotropic", "isotropic", "isotropic",
                                                       "isotropic", "cosine", {"cone": 30},
                                                       {"cosine_power": 3}))
            return source
        shapes = [{"disc": 0.5}, {"disc": 2}, {"rectangle": [1, 2]}, {"disc": 1e-9}]
        meshes = sorted(n for n, g in self.geometries.items() if g["type"] == "mesh")
        if kind == "area" and meshes:
            shapes.append({"mesh": self.dice.choice(meshes)})
        source["shape"] = self.dice.choice(shapes)
        return source

    def detectors(self, objects):
        found = []
        for k in range(self.dice.choice((0, 1, 2, 2, 5))):
            name = f"seen{k}"
            cells = self.dice.choice((10, [7, 13], 300, [1, 65535]))
            kind = self.dice.choice(("free", "free", "on", "far" if self.chance(0.2) else "free"))
            if kind == "far":
                found.append({"name": name, "type": "intensity", "cells": cells,
                              "axis": self.direction()})
                continue
            plane = {"name": name, "type": "plane", "cells": cells,
                     "side": self.dice.choice(("front", "back", "both")),
                     "max_angle": self.dice.choice((90, 90, 45))}
            if kind == "on":
                item = self.dice.choice(objects)
                plane["on"] = item["name"]
                plane["direction"] = self.direction()
                if self.chance(0.7):
                    plane.update(size=[6, 6], at=self.position())
                if self.geometries.get(item.get("geometry"), {}).get("type") == "mesh" and "size" in plane:
                    plane["on"] = {"object": item["name"], "faces": ("half0", [1])[k % 2]}
            else:
                plane.update(size=self.dice.choice((2, [8, 3], 40)), at=self.position(),
                             direction=self.direction())
            found.append(plane)
        return found

    def scene(self):
        self.surfaces = {f"face{k}": self.surface() for k in range(5)}
        self.surfaces["clear"] = {"type": "fresnel"}
        self.surfaces["white"] = {"type": "lambert", "reflectance": 0.9}
        self.all_surfaces = sorted(self.surfaces)
        self.clear = [n for n, s in sorted(self.surfaces.items()) if s["type"] == "fresnel"]
        self.opaque = [n for n, s in sorted(self.surfaces.items())
                       if s["type"] in ("lambert", "mirror")]
        self.geometries = {}
        for k in range(self.dice.randint(1, 6)):
            self.geometries[f"form{k}"] = self.geometry(f"form{k}")
        self.geometries["hall"] = {"type": "sphere", "radius": 9}
        self.write_mesh("room.obj", cube(8))
        self.geometries["room"] = {"type": "mesh", "file": "room.obj"}
        objects = self.objects()
        self.names = [item["name"] for item in objects]
        sources = [self.source(f"lamp{k}", objects) for k in range(self.dice.choice((1, 2, 3)))]
        films = {"ar": {"reference": 550, "substrate": "back", "layers": [{"n": 1.38, "quarter": 1}]},
                 "dark": {"substrate": "front", "layers": [{"n": 2.4, "k": 3.3, "thickness": "8 nm"}, {"material": "MgF2", "thickness": "90 nm"}]}}
        scene = {"raymap": 1, "units": "mm", "media": self.media(), "films": films, "surfaces": self.surfaces,
                 "geometries": self.geometries, "objects": objects, "sources": sources,
                 "detectors": self.detectors(objects),
                 "limits": {"steps": self.dice.choice((60, 200, 3)),
                            "flux": self.dice.choice((0, 0, 1e-3))}}
        scene["spectrum"] = ({"mode": "spectral", "wavelengths": self.wavelengths}
                             if self.spectral else {"mode": "rgb"})
        if self.chance(0.12):
            self.move_away(scene)
        return scene

    def move_away(self, scene):
        """Everything far from the origin."""
        far = self.dice.choice(([1e5, 0, 0], [-1e5, 3e4, 12345.678], [0, 0, 1e7]))
        scene["objects"] = [{"name": "far", "at": far, "objects": scene["objects"]}]
        for item in scene["sources"] + scene["detectors"]:
            if "at" in item or item.get("type") != "rays" and "axis" not in item:
                item["at"] = [a + b for a, b in zip(item.get("at", (0, 0, 0)), far)]
            for ray in item.get("rays", ()):
                ray["origin"] = [a + b for a, b in zip(ray["origin"], far)]

    def options(self):
        found = ["--seed", str(self.dice.choice((1, 7, 2**32 + 5, 2**63)))]
        if self.chance(0.25):
            found += ["--first-ray", str(self.dice.choice((2**40, 4096, 1000, 2**33 - 100)))]
        if self.chance(0.15):
            found += ["--color", self.dice.choice(("rgb", "spectral"))]
        if self.chance(0.1):
            found += ["--without", self.names[self.dice.randrange(len(self.names))]]
        if self.chance(0.1):
            found += ["--set", "media.air.index=1.1"]
        return found


def scene(seed, folder):
    """Writes scene.yaml and its meshes below the folder; options for `raymap trace`."""
    dice = Dice(seed, folder)
    text = json.dumps(dice.scene(), indent=1)
    with open(os.path.join(folder, "scene.yaml"), "w", encoding="utf-8") as file:
        file.write(text)
    return dice.options()
