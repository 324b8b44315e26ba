# SPDX-License-Identifier: MIT
"""Reads a ray map: what map.h5 says of it by h5py, its rays by libraymap (library.py).

    import raymap
    lens = raymap.open("lens.raymap")
    lens.n_rays, lens.names["object"], lens.complete
    for portion in lens.portions():            # blocks of rays, in the order of their ids
        portion["segment/position"]            # every column of docs/map.md, as a numpy array
        for ray in portion.rays():
            ray["id"], ray.segments["event"], ray.registrations["cell"]
            ray.curve["position"]              # points of curved legs: a map of gradient media
    lens.ray(17).segments["position"]
    lens.columns("ray/weight", "ray/source")   # of all rays

Of a stranger's map it is certain that no other file is opened; `raymap verify` compares all checksums.

As a program it prints one ray:  python3 -m raymap.reader MAP RAY
"""
import os
import sys

import h5py
import numpy as np

from .library import TABLES, Handle, MapError, Reader

# The columns, in the order of docs/map.md: name, type, numbers per row (0: one per channel).
COLUMNS = (
    ("ray/id", "<u8", 1), ("ray/source", "<i4", 1), ("ray/stop", "u1", 1), ("ray/weight", "<f8", 1),
    ("ray/segment_count", "<u4", 1), ("ray/registration_count", "<u4", 1),
    ("ray/wavelength", "<f8", 1), ("ray/path_length", "<f8", 1), ("ray/optical_path", "<f8", 1),
    ("ray/start", "<f4", 3), ("ray/start_object", "<i4", 1), ("ray/start_primitive", "<i4", 1),
    ("ray/start_normal", "<i2", 3), ("ray/end_direction", "<f4", 3),
    ("segment/object", "<i4", 1), ("segment/primitive", "<i4", 1), ("segment/event", "<u4", 1),
    ("segment/medium", "<i2", 1), ("segment/position", "<f4", 3), ("segment/normal", "<i2", 3),
    ("registration/segment", "<u4", 1), ("registration/detector", "<i4", 1),
    ("registration/cell", "<u2", 2), ("registration/relative", "<u2", 2),
    ("registration/registered", "u1", 1), ("registration/direction", "<f4", 3),
    ("registration/optical_path", "<f8", 1),
    ("segment/colour", "<u2", 0),
    # Points between the ends of curved legs; only maps whose scene has gradient media have them.
    ("curve/ray", "<u8", 1), ("curve/segment", "<u4", 1), ("curve/position", "<f4", 3),
    # Of maps that were traced with times.
    ("ray/group_path", "<f8", 1), ("ray/delay", "<f8", 1),
    ("registration/group_path", "<f8", 1), ("registration/delay", "<f8", 1),
)
TIME_NAMES = tuple(name for name, _, _ in COLUMNS if name.endswith(("/group_path", "/delay")))
COLUMN_NAMES = tuple(name for name, _, _ in COLUMNS if not name.startswith("curve/") and name not in TIME_NAMES)
CURVE_NAMES = tuple(name for name, _, _ in COLUMNS if name.startswith("curve/"))

EVENTS = ("reflect_specular", "reflect_diffuse", "transmit_specular", "transmit_diffuse",
          "total_reflection", "absorb", "scatter_volume", "fluoresce", "gradient", "element",
          "left", "limit", "error")
STOPS = ("absorbed", "left", "limit", "error")
MODES = ("spectral", "rgb")
PLAIN = 0
# What of docs/map.md, Versions, a map may ask a reader to know.
FEATURES = {"curves", "times", "gaps", "places", "classes", "codes", "lengths", "angles", "arrivals", "scatter", "metals", "films", "turbid", "surfaces", "uv"}


def event_words(bits):
    """["transmit_specular", ...] of an event's bits."""
    return [word for k, word in enumerate(EVENTS) if int(bits) >> k & 1]


class Ray:
    """One ray: its row of /ray by name; `segments` and `registrations` hold its rows of those."""

    def __init__(self, portion, row):
        self._row = {name[4:]: portion[name][row] for name in COLUMN_NAMES + TIME_NAMES
                     if name.startswith("ray/") and name in portion.columns}
        self.segments = portion.rows_of("segment", row)
        self.registrations = portion.rows_of("registration", row)
        self.curve = portion.curve_of(self._row["id"])

    def __getitem__(self, name):
        return self._row[name]

    def line(self, leg):
        """The leg as points: where it begins, its points, where it ends."""
        position = self.segments["position"]
        begin = position[leg - 1] if leg > 0 else self["start"]
        on = self.curve["segment"] == leg
        return np.concatenate([[begin], self.curve["position"][on], [position[leg]]])


class Portion:
    """A block of rays as columns: portion["ray/id"], portion["segment/position"], ..."""

    def __init__(self, columns, space):
        self.columns = columns
        self.space = space  # row of the map's colour spaces
        self._ends = {}

    def __getitem__(self, name):
        return self.columns[name]

    def __len__(self):
        return len(self["ray/id"])

    def rows_of(self, table, row):
        """The rows of /segment or /registration that belong to ray `row` of the portion."""
        if table not in self._ends:
            self._ends[table] = np.cumsum(self[f"ray/{table}_count"], dtype=np.int64)
        end = self._ends[table][row]
        begin = end - int(self[f"ray/{table}_count"][row])
        return {name.split("/")[1]: column[begin:end] for name, column in self.columns.items()
                if name.startswith(table + "/")}

    def curve_of(self, ray):
        """The rows of /curve of the ray with this id; none in a map without gradient media."""
        if "curve/ray" not in self.columns:
            return {"ray": np.empty(0, "<u8"), "segment": np.empty(0, "<u4"),
                    "position": np.empty((0, 3), "<f4")}
        begin, end = np.searchsorted(self["curve/ray"], [ray, ray + np.uint64(1)])
        return {name[6:]: self[name][begin:end] for name in CURVE_NAMES}

    def rays(self):
        return (Ray(self, row) for row in range(len(self)))


def open_file(path, has_view=False):
    """A file whose parts all lie in it: HDF5 would open any file that it refers to. Where it has the
    view of docs/map.md, its columns are others'; nothing here reads them."""
    if not os.path.isfile(path):
        raise MapError(f"{path}: no such file")
    file = h5py.File(path, "r")
    outside = file.id.links.visit(
        lambda name, link: None if link.type == h5py.h5l.TYPE_HARD else name.decode(), info=True)
    if outside is None:
        outside = file.visititems(lambda name, item: name if isinstance(item, h5py.Dataset) and (
            item.external or item.is_virtual and not (
                has_view and name.split("/")[0] in TABLES)) else None)
    if outside is not None:
        file.close()
        raise MapError(f"{path}: '{outside}' lies in another file, which is not opened")
    return file


class Names(list):
    """Names of a kind by number; index(name) gives the number, or an error that lists the names."""

    def __init__(self, kind, names):
        super().__init__(names)
        self.kind = kind

    def index(self, name, *span):
        try:
            return super().index(name, *span)
        except ValueError:
            known = ", ".join(self[:20]) + (", ..." if len(self) > 20 else "")
            raise ValueError(f"no {self.kind} named '{name}': {known or 'there are none'}") from None


def _list(names):
    if isinstance(names, str):
        raise TypeError(f'columns are named in a list: ["{names}"]')
    return names


class Map:
    """A map's directory. What is in map.h5 is read at once, rays when they are asked for. `with` closes it, and it goes
    wherever its path does."""

    def __init__(self, path):
        self.path = os.fspath(path)
        self._handle, self._is_closed = None, False  # of the library
        self._names, self._reader = (), None  # of the portions that were asked for last
        with open_file(os.path.join(path, "map.h5"), has_view=True) as index:
            self._read_index(index)
        if not self.complete:
            self._count_committed()

    def _count_committed(self):
        """What the map's run has committed since the index was written."""
        self.n_rays, self.n_segments, self.n_registrations, self.n_curve_points = (
            self.handle.rows(table) for table in TABLES)

    def __fspath__(self):
        return self.path

    def __enter__(self):
        return self

    def __exit__(self, *failure):
        self.close()

    def close(self):
        """Lets go of the rays' files; names and numbers stay."""
        self._handle, self._is_closed, self._names, self._reader = None, True, (), None

    @property
    def handle(self):
        if self._is_closed:
            raise MapError(f"{self.path} is closed")
        if self._handle is None:
            self._handle = Handle(self.path)
        return self._handle

    def _read_index(self, index):
        if index.attrs["filetype"] != b"raymap map" and index.attrs["filetype"] != "raymap map":
            raise MapError(f"{self.path}: no index of a ray map")
        major, minor = index.attrs["version"]
        if major not in (2, 3, 4, 5):
            raise MapError(f"{self.path}: format {major}.{minor}; this reads 2.x to 5.x")
        features = _text(index.attrs["features"]).split() if major == 5 else []
        unknown = set(features) - FEATURES
        if unknown:
            raise MapError(f"{self.path} needs {', '.join(sorted(unknown))}, which this does not know")
        counts_curves = major == 4 or "curves" in features
        self.n_curve_points = int(index.attrs["curve_points"]) if counts_curves else 0
        self.is_timed = "times" in features  # whose maps count points of curves, too, where no medium has a gradient
        self.is_curved = counts_curves and (self.n_curve_points > 0 or not self.is_timed)
        self.column_names = COLUMN_NAMES + (CURVE_NAMES if self.is_curved else ()) + (TIME_NAMES if self.is_timed else ())
        self.n_rays, self.n_segments, self.n_registrations = (
            int(index.attrs[name]) for name in ("rays", "segments", "registrations"))
        self.complete = bool(index.attrs["complete"])
        self.seed = int(index.attrs["seed"])
        self.digest = _text(index.attrs["digest"])
        self.unit = _text(index.attrs["length_unit"])
        self.unit_m = float(index.attrs["length_unitSI"])
        self.names = {kind: Names(kind, (_text(name) for name in index["name/" + kind][:]))
                      for kind in ("source", "object", "surface", "medium", "detector", "geometry")}
        self.source_flux = index["source/flux"][:]
        self.source_emitted = index["source/emitted"][:]
        self.spaces = [
            {"mode": MODES[mode], "wavelengths": wavelengths[:channels]} for mode, channels,
            wavelengths in zip(index["space/mode"][:], index["space/channels"][:],
                               index["space/wavelength_nm"][:])]
        self.is_plain = bool((index["piece/encoding"][:] == PLAIN).all())
        self.detectors = [_detector(index, k, name) for k, name in enumerate(self.names["detector"])]

    @property
    def n_portions(self):
        return self.handle.n_blocks

    def flux(self, source, weight):
        """Flux of a ray of that source and weight (ray/source, ray/weight)."""
        return weight * (self.source_flux[source] / self.source_emitted[source])

    def portion(self, k, names=None):
        """Block k of rays, in the order of first ray ids; `names`: the columns wanted."""
        names = tuple(_list(names) or self.column_names)
        if self._names != names:
            self._names, self._reader = names, Reader(self.handle, names)
        return Portion(*self._reader.read(k))

    def portions(self, names=None, where=None):
        """All of them, on all cores; where: a criterion, for the rays that match alone."""
        return (Portion(*block) for block in self.handle.blocks(_list(names) or self.column_names, where))

    def rays(self):
        return (ray for portion in self.portions() for ray in portion.rays())

    def ray(self, number):
        """The ray with this id."""
        for k in self.handle.blocks_of(number):
            portion = self.portion(k)
            row = np.flatnonzero(portion["ray/id"] == number)
            if len(row):
                return Ray(portion, int(row[0]))
        raise MapError(f"{self.path}: no ray {number}")

    def columns(self, *names):
        """Whole columns, portions in the order of their first ray ids."""
        wanted = names or self.column_names
        for name in wanted:
            if name not in self.column_names:
                raise MapError(f"{self.path}: no column '{name}': {', '.join(self.column_names)}")
        if "segment/colour" in wanted and len({len(s["wavelengths"]) for s in self.spaces}) > 1:
            raise MapError(f"{self.path}: segment/colour has other channels in each of its colour "
                           "spaces: take it portion by portion")
        whole = self._whole(wanted)
        return {name: whole[name] for name in wanted}

    def _whole(self, names):
        return self.handle.whole(names)


def _text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def _detector(index, k, name):
    group = index["detector"][str(k) if name in ("", ".") or "/" in name else name]
    return {"name": name, "type": _text(group.attrs["type"]),
            **{key: group.attrs[key] for key in ("size", "cells", "origin", "x", "y", "axis")}}


def print_ray(lens, number):
    ray = lens.ray(number)
    print(f"ray {ray['id']} of {lens.names['source'][ray['source']]}, {STOPS[ray['stop']]}, "
          f"flux {lens.flux(ray['source'], ray['weight']):.9g}")
    print("start", *ray["start"])
    s = ray.segments
    for k in range(len(s["event"])):
        met = lens.names["object"][s["object"][k]] if s["object"][k] >= 0 else "-"
        print(f"{k:4d}  {met:24s} {','.join(event_words(s['event'][k])):32s}",
              *(f"{x:.9g}" for x in s["position"][k]), s["colour"][k])
    if len(ray.curve["segment"]):
        print(f"{len(ray.curve['segment'])} points of curved legs")
    r = ray.registrations
    for k in range(len(r["cell"])):
        print(f"leg {r['segment'][k]} on {lens.names['detector'][r['detector'][k]]}: "
              f"cell {tuple(int(c) for c in r['cell'][k])}")


def main(arguments):
    if len(arguments) != 2:
        return __doc__
    print_ray(Map(arguments[0]), int(arguments[1]))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
