# SPDX-License-Identifier: MIT
"""A plain map's columns and names, read with h5py alone, as the evaluator of criteria sees them."""
import functools
import re
import struct

import h5py
import numpy as np

EVENTS = ("reflect_specular", "reflect_diffuse", "transmit_specular", "transmit_diffuse",
          "total_reflection", "absorb", "scatter_volume", "fluoresce", "gradient", "element",
          "left", "limit", "error")
BIT = {word: 1 << k for k, word in enumerate(EVENTS)}
STOPS = ("absorbed", "left", "limit", "error")
# A step has one letter: where several bits are set, the first of these.
LETTERS = (("E", "error"), ("K", "limit"), ("O", "element"), ("F", "fluoresce"),
           ("S", "scatter_volume"), ("I", "total_reflection"), ("R", "reflect_specular"),
           ("T", "transmit_specular"), ("D", "reflect_diffuse"), ("d", "transmit_diffuse"),
           ("A", "absorb"), ("X", "left"))


@functools.lru_cache(maxsize=None)
def glob(pattern, name):
    """Whether a name is meant by a pattern of * (any characters) and ? (one)."""
    parts = {"*": ".*", "?": "."}
    return re.fullmatch("".join(parts.get(c, re.escape(c)) for c in pattern), name,
                        re.DOTALL) is not None


def _mesh_faces(blob):
    """{geometry: face of each triangle} of /scene/bundle."""
    at = 8

    def number(form="<Q"):
        nonlocal at
        at += struct.calcsize(form)
        return struct.unpack_from(form, blob, at - struct.calcsize(form))[0]

    def text():
        nonlocal at
        n = number()
        n = 0 if n == 2 ** 64 - 1 else n
        at += n
        return blob[at - n:at].decode()

    for _ in range(4):  # path, text, simulation, colour
        text()
    for _ in range(3):  # only, without, set
        for _ in range(number()):
            text()
    number("<I")
    faces = {}
    for _ in range(number()):
        name = text()
        n_vertex, n_triangle, n_face = number(), number(), number()
        at += 12 * n_vertex + 12 * n_triangle
        faces[name] = np.frombuffer(blob, "<u4", n_triangle, at).astype(int)
        at += 4 * n_triangle
        for _ in range(n_face):
            text()
    return faces


def _models(index):
    """{number: name} of the scatter models, as the map says it of itself."""
    if "model/0/scatter" not in index:
        return {}
    said = index["model/0/scatter/model"].attrs["description"].decode()
    return {int(number): name for number, name in re.findall(r"(\d+) (\w+)", said)}


class PlainMap:
    """Rows of /ray, /segment and /registration; `ray_of_segment` and the like tie them together."""

    def __init__(self, path):
        with h5py.File(f"{path}/map.h5", "r") as index:
            for table in ("ray", "segment", "registration"):
                setattr(self, table, {name: data[:] for name, data in index[table].items()})
            self.total_reflectance = {"two ways": 0.5, "satin": 0.7}  # evaluator_scene.py
            self.names = {kind: [n.decode() for n in index[f"name/{kind}"][:]]
                          for kind in ("source", "object", "group", "surface", "medium",
                                       "detector", "geometry")}
            self.object_group = index["name/object_group"][:]
            self.group_group = index["name/group_group"][:]
            model = index["model/0"]
            self.object = {name: data[:] for name, data in model["object"].items()}
            self.surface = {name: data[:] for name, data in model["surface"].items()}
            self.scatter = {name: data[:] for name, data in model["scatter"].items()} if "scatter" in model else {}
            self.models = _models(index)
            self.detector = {name: data[:] for name, data in model["detector"].items()}
            self.is_mesh = model["geometry/kind"][:][self.object["geometry"]] == 1
            self.length_unit = float(index.attrs["length_unitSI"])
            self.flux_unit = index.attrs["flux_unit"].decode()
            self.wavelength = index["channel/wavelength"][:]  # NaN of RGB
            self.source_flux = index["source/flux"][:]
            self.source_emitted = index["source/emitted"][:]
            faces = _mesh_faces(index["scene/bundle"][:].tobytes())
        self.faces = [faces.get(self.names["geometry"][g]) for g in self.object["geometry"]]
        self.n_ray = len(self.ray["id"])
        count, seen = self.ray["segment_count"], self.ray["registration_count"]
        self.ray_of_segment = np.repeat(np.arange(self.n_ray), count)
        self.ray_of_registration = np.repeat(np.arange(self.n_ray), seen)
        self.first_segment = np.cumsum(count, dtype=int) - count
        self.leg = np.arange(len(self.ray_of_segment)) - self.first_segment[self.ray_of_segment]
        flux_per_weight = self.source_flux / self.source_emitted
        self.flux = flux_per_weight[self.ray["source"]] * self.ray["weight"]
        self._letters()
        self._registered_numbers()
        self._sides()

    def _letters(self):
        event = self.segment["event"]
        self.letter = np.full(len(event), "?")
        for letter, word in reversed(LETTERS):
            self.letter[event & BIT[word] != 0] = letter

    def _registered_numbers(self):
        """x, y, angle and time of every registration in the detector's own units, deg and s."""
        which = self.registration["detector"]
        relative = self.registration["relative"] / 65535.0
        size, far = self.detector["size"][which], self.detector["type"][which] == 1
        full = np.array([180.0, 360.0])
        place = np.where(far[:, None], relative * full, (relative - 0.5) * size)
        self.relative, self.x, self.y = relative, place[:, 0], place[:, 1]
        cosine = np.einsum("ij,ij->i", self.registration["direction"].astype(float),
                           self.detector["axis"][which])
        cosine /= np.linalg.norm(self.registration["direction"].astype(float), axis=1)
        self.angle = np.degrees(np.arccos(np.clip(np.where(far, cosine, -cosine), -1, 1)))
        timed = "group_path" in self.registration  # times of arrival
        path = self.registration["group_path" if timed else "optical_path"]
        self.time = path * self.length_unit / 299792458.0 + (1e-9 * self.registration["delay"] if timed else 0)

    def _sides(self):
        """surface_met: row of /name/surface on the side that each step came from; -1: none."""
        which, medium = self.segment["object"], self.segment["medium"]
        front, back = (self.object[f"medium_{side}"][which] for side in ("front", "back"))
        begin = np.empty_like(self.segment["position"], dtype=float)
        begin[1:] = self.segment["position"][:-1]
        first = self.leg == 0
        begin[first] = self.ray["start"][self.ray_of_segment[first]]
        self.light = self.segment["position"] - begin
        x, y, z = self.light.T
        self.length = np.sqrt(x * x + y * y + z * z)
        cosine = np.einsum("ij,ij->i", self.segment["position"] - begin,
                           self.segment["normal"].astype(float))
        told = (front >= 0) & (back >= 0) & (front != back) & ((medium == front) | (medium == back))
        in_front = np.where(told, medium == front, cosine < 0)
        met = np.where(in_front, self.object["surface_front"][which],
                       self.object["surface_back"][which])
        self.surface_met = np.where(which >= 0, met, -1)
        self.in_front = in_front & (which >= 0)

    @functools.lru_cache(maxsize=None)
    def step_numbers(self):
        """Of every step; NaN where a number is not defined."""
        place, which = self.segment["position"].astype(float), self.segment["object"]
        curved = self.segment["event"] & BIT["gradient"] != 0
        straight = np.where(curved, np.nan, np.where(self.letter == "X", 0.0, self.length))
        sums = np.array([np.sum(straight[first:first + leg + 1])
                         for first, leg in zip(self.first_segment[self.ray_of_segment], self.leg)])
        local = self.object["to_local"][which]
        own = np.einsum("ijk,ik->ij", local[:, :9].reshape(-1, 3, 3), place) + local[:, 9:]
        own[which < 0] = np.nan
        normal = self.segment["normal"].astype(float)
        with np.errstate(invalid="ignore", divide="ignore"):
            cosine = np.abs(np.einsum("ij,ij->i", self.light, normal)) / self.length / np.linalg.norm(normal, axis=1)
        angle = np.where(curved, np.nan, np.degrees(np.arccos(np.minimum(cosine, 1.0))))
        colour = next(data for name, data in self.segment.items() if name.startswith("colour"))
        wavelength = np.where(colour.max(axis=1) == 65535, self.wavelength[colour.argmax(axis=1)], np.nan)
        return {"angle": angle, "wavelength": wavelength, "length": straight, "path_length": sums, "step": self.leg.astype(float),
                **{axis: own[:, k] for k, axis in enumerate("xyz")},
                **{"world_" + axis: place[:, k] for k, axis in enumerate("xyz")}}

    def surface_number(self, word):
        """A parameter of each surface, mean over the channels; NaN where it has none."""
        s = self.surface
        share = {k: s[k].reshape(len(s["type"]), -1).mean(axis=1)
                 for k in ("reflect_specular", "reflect_diffuse", "transmit_specular",
                           "transmit_diffuse")}
        for k, kind in enumerate(s["type"]):
            if kind == 0:  # fresnel: bare, coat of a reflectance, ideal coat
                reflect = {0: np.nan, 1: share["reflect_specular"][k], 2: 0.0}[int(s["coat"][k])]
                share["reflect_specular"][k], share["transmit_specular"][k] = reflect, 1 - reflect
            elif s["is_metal"][k]:
                share["reflect_specular"][k] = np.nan
        modelled = [row for way in ("of_reflected", "of_transmitted") for row in self.scatter.get(way, []) if row >= 0]
        share["reflectance"] = share["reflect_specular"] + share["reflect_diffuse"]
        absorb = 1 - share["reflectance"] - share["transmit_specular"] - share["transmit_diffuse"]
        share["absorb"] = np.where(s["type"] == 0, 0.0, absorb)
        # What depends on the angle has no number: of a metal all but the diffuse shares.
        for k in np.flatnonzero(s["is_metal"]):
            share["transmit_specular"][k] = np.nan
        for k in modelled:
            total = self.total_reflectance.get(self.names["surface"][k], np.nan)
            for other in share:
                share[other][k] = total if other == "reflectance" else np.nan
        return share[word]

    def scatters_by(self, word):
        """Of each step: a diffuse event by such a model."""
        reflect, transmit = (np.full(len(self.surface["type"]) + 1, "", dtype=object) for _ in range(2))
        reflect[:-1][self.surface["type"] == 2] = "lambert"
        for of in (reflect, transmit):
            of[:-1][self.surface["type"] == 4] = "lambert"
        for k, model in enumerate(self.scatter.get("model", [])):
            for of, row in ((reflect, self.scatter["of_reflected"][k]), (transmit, self.scatter["of_transmitted"][k])):
                if row >= 0:
                    of[row] = self.models[model]
        event, met = self.segment["event"], self.surface_met
        hit = np.zeros(len(event), dtype=bool)
        for of, name in ((reflect, "reflect_diffuse"), (transmit, "transmit_diffuse")):
            by = of[met] != "" if word == "*" else of[met] == word
            hit |= (event & BIT[name] != 0) & by.astype(bool)
        return hit

    def makes_ghosts(self):
        """Of each surface, and of none: whether a specular reflection there is not meant to be: it
        lets light through, or is opaque and reflects less than half of it straight on."""
        s = self.surface
        by = {k: s[k].reshape(len(s["type"]), -1).max(axis=1)
              for k in ("reflect_specular", "transmit_specular", "transmit_diffuse")}
        metal = ((s["metal_n"] - 1) ** 2 + s["metal_k"] ** 2) / \
            ((s["metal_n"] + 1) ** 2 + s["metal_k"] ** 2)
        mirror = np.where(s["is_metal"].astype(bool),
                          metal.reshape(len(s["type"]), -1).max(axis=1), by["reflect_specular"])
        through = (s["type"] == 0) | (by["transmit_specular"] + by["transmit_diffuse"] > 0)
        for k, model in enumerate(self.scatter.get("model", [])):
            through[self.scatter["of_transmitted"][k]] |= self.scatter["of_transmitted"][k] >= 0
            if self.models[model] == "ggx":
                mirror[self.scatter["of_reflected"][k]] = 0
        return np.append(through | ((mirror > 0) & (mirror < 0.5)), False)

    def triangles_of_face(self, row_objects, faces):
        """For steps on these objects: the face each of their primitives belongs to."""
        found = np.zeros(len(row_objects), dtype=int)
        for o in np.unique(row_objects):
            if self.faces[o] is not None:
                rows = row_objects == o
                found[rows] = self.faces[o][faces[rows]]
        return found
