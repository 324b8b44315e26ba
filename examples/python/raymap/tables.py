# SPDX-License-Identifier: MIT
"""A map's tables, and lists of dicts from the program, as flat columns or pandas DataFrames."""
from __future__ import annotations

import os
import tempfile
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

import h5py
import numpy as np

from .program import Path, Program
from .reader import STOPS, Map, Portion

_AXES = {3: "xyz", 2: "ij"}
_LIGHT_SPEED = 299792458.0  # m/s
_COUNTED = ("segment", "registration")  # each of their rows belongs to a ray


class _Rows:
    """A portion's rows of one table, and what of rays and segments belongs to each of them."""

    def __init__(self, rays: Map, portion: Portion, table: str):
        self.rays, self.portion, self.table = rays, portion, table
        counts = portion[f"ray/{table}_count"] if table in _COUNTED else 1
        self._ray = np.repeat(np.arange(len(portion)), counts)

    def own(self, name: str) -> np.ndarray:
        return self.portion[f"{self.table}/{name}"]

    def of_ray(self, name: str) -> np.ndarray:
        return self.portion["ray/" + name][self._ray]

    def of_segment(self, name: str) -> np.ndarray:
        if self.table == "segment":
            return self.own(name)
        n = self.portion["ray/segment_count"].astype(np.int64)
        return self.portion["segment/" + name][(np.cumsum(n) - n)[self._ray] + self.own("segment")]

    def of_detector(self, key: str) -> np.ndarray:
        shape = {"is_grid": (0,), "size": (0, 2)}.get(key, (0, 3))
        values = [d["type"] == "intensity" if key == "is_grid" else d[key] for d in self.rays.detectors]
        return np.array(values or np.empty(shape))[self.own("detector")]


def _named(names: Sequence[str], index: np.ndarray) -> np.ndarray:
    """Names of numbers; None of -1."""
    return np.array([*names, None], dtype=object)[index]


def _wavelength(at: _Rows) -> np.ndarray:
    """At the end of the row's segment; NaN where several are left."""
    share = at.of_segment("colour") > 0
    wavelengths = at.rays.spaces[at.portion.space]["wavelengths"]
    return np.where(share.sum(axis=1) == 1, wavelengths[share.argmax(axis=1)], np.nan)


def _coordinate(at: _Rows, axis: int) -> np.ndarray:
    """On the detector, in the map's length; of an intensity detector theta and phi in degrees."""
    relative = at.own("relative")[:, axis] / 65535.0
    flat = (relative - 0.5) * at.of_detector("size")[:, axis]
    return np.where(at.of_detector("is_grid"), relative * (180.0, 360.0)[axis], flat)


def _world(at: _Rows, axis: int) -> np.ndarray:
    y = _coordinate(at, 1) * at.of_detector("y")[:, axis] + at.of_detector("origin")[:, axis]
    return np.where(at.of_detector("is_grid"), np.nan,
                    _coordinate(at, 0) * at.of_detector("x")[:, axis] + y)


def _angle(at: _Rows) -> np.ndarray:
    """Degrees between the axis and the reversed light, or of an intensity detector the light."""
    sign = np.where(at.of_detector("is_grid"), 1.0, -1.0)[:, None]
    light, axis = sign * at.own("direction"), at.of_detector("axis")
    across = np.sqrt((np.cross(light, axis) ** 2).sum(axis=1))
    return np.degrees(np.arctan2(across, (light * axis).sum(axis=1)))


# What follows from the columns: the columns, and how.
_Quantity = Tuple[Tuple[str, ...], Callable[[_Rows], np.ndarray]]
_PLACE = ("registration/detector", "registration/relative")
_COLOUR = ("segment/colour", "ray/segment_count")
_OF_ALL: Dict[str, _Quantity] = {
    "source_name": (("ray/source",), lambda at: _named(at.rays.names["source"], at.of_ray("source"))),
    "flux": (("ray/source", "ray/weight"),
             lambda at: at.rays.flux(at.of_ray("source"), at.of_ray("weight"))),
}
_OF_COUNTED: Dict[str, _Quantity] = {
    "ray_id": (("ray/id",), lambda at: at.of_ray("id")),
    "source": (("ray/source",), lambda at: at.of_ray("source")),
    **_OF_ALL,
}
QUANTITIES: Dict[str, Dict[str, _Quantity]] = {
    "ray": {
        **_OF_ALL,
        "stop_name": (("ray/stop",), lambda at: _named(STOPS, at.own("stop"))),
    },
    "segment": {
        **_OF_COUNTED,
        "wavelength": (_COLOUR, _wavelength),
        "object_name": (("segment/object",),
                        lambda at: _named(at.rays.names["object"], at.own("object"))),
        "medium_name": (("segment/medium",),
                        lambda at: _named(at.rays.names["medium"], at.own("medium"))),
    },
    "registration": {
        **_OF_COUNTED,
        "wavelength": (("registration/segment", *_COLOUR), _wavelength),
        "detector_name": (("registration/detector",),
                          lambda at: _named(at.rays.names["detector"], at.own("detector"))),
        "x": (_PLACE, lambda at: _coordinate(at, 0)),
        "y": (_PLACE, lambda at: _coordinate(at, 1)),
        "world_x": (_PLACE, lambda at: _world(at, 0)),
        "world_y": (_PLACE, lambda at: _world(at, 1)),
        "world_z": (_PLACE, lambda at: _world(at, 2)),
        "angle": (("registration/detector", "registration/direction"), _angle),
        "time": (("registration/optical_path",),
                 lambda at: at.own("optical_path") * at.rays.unit_m / _LIGHT_SPEED),
    },
    "curve": {},
}


def _known(rays: Map, table: str) -> Dict[str, _Quantity]:
    """All that a table has, by name. Colours only where a map's colour spaces have as many channels."""
    out = {"ray_id": QUANTITIES[table]["ray_id"]} if table in _COUNTED else {}
    has_colour = table in _COUNTED and len({len(space["wavelengths"]) for space in rays.spaces}) == 1
    for column, rows in rays.no_rows().items():
        if column not in rays.column_names or not column.startswith(table + "/"):
            continue
        short = column.split("/")[1]
        if rows.ndim == 1:
            out[short] = ((column,), lambda at, short=short: at.own(short))
        elif short != "colour":
            for k, axis in enumerate(_AXES[rows.shape[1]]):
                out[f"{short}_{axis}"] = ((column,), lambda at, short=short, k=k: at.own(short)[:, k])
    if has_colour:
        for k in range(len(rays.spaces[0]["wavelengths"])):
            out[f"colour_{k}"] = (QUANTITIES[table]["wavelength"][0],
                                  lambda at, k=k: at.of_segment("colour")[:, k])
    return {**out, **QUANTITIES[table]}


def records(rays: Map, table: str = "ray", *names: str) -> Dict[str, np.ndarray]:
    """Columns of /ray, /segment, /registration or /curve, each one-dimensional (position_x, position_y, ...), and what
    follows from them (QUANTITIES; docs/python.md): those that are named, else all. Less is read for fewer."""
    tables = list(dict.fromkeys(name.split("/")[0] for name in rays.column_names))
    if table not in tables:
        raise ValueError(f"no table '{table}' in {rays.path}: {', '.join(tables)}")
    known = _known(rays, table)
    for name in names:
        if name not in known:
            raise ValueError(f"no column '{name}' in table '{table}' of {rays.path}: {', '.join(known)}")
    wanted = {name: known[name] for name in names or known}
    columns = {"ray/id", *(column for needs, _ in wanted.values() for column in needs)}
    if table in _COUNTED:
        columns.add(f"ray/{table}_count")
    rows = (_Rows(rays, portion, table) for portion in rays.portions(sorted(columns)))
    parts = [{name: read(at) for name, (_, read) in wanted.items()} for at in rows]
    if not parts:
        nothing = _Rows(rays, Portion(rays.no_rows(), 0), table)
        parts = [{name: read(nothing) for name, (_, read) in wanted.items()}]
    return {name: np.concatenate([part[name] for part in parts]) for name in wanted}


# Names stand in a file of the program's once, and numbers of them in its columns.
_CODED = {f"{word}_name": word for word in ("source", "stop", "object", "medium", "detector")}


def table(map_path: Path, name: str = "ray", *names: str, where: str = "all", program: Optional[Program] = None,
          **options: Any) -> Dict[str, np.ndarray]:
    """As records, of the rays that match, by the program: many times faster of a compact map, and no larger than the
    answer. Segments also have length, angle_of_incidence and reflectance. limit, sample, receivers, ... as of `query`."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "rows.h5")
        columns = ",".join(f"{name}/{_CODED.get(one, one)}" for one in names) or name
        (program or Program()).run("query", map_path, where, "-o", out, "--quiet", columns=columns, **options)
        with h5py.File(out, "r") as file:
            rows = {one: column[:] for one, column in file[name].items()}
            texts = {word: file["name"][word][:].astype(object) for word in _CODED.values()}
    for one, word in _CODED.items():
        if word in rows:
            rows[one] = _named([text.decode() for text in texts[word]], rows[word].astype(np.int64))
    return {one: rows[one] for one in names or rows}


def frame(what: Union[Map, Iterable[Mapping[str, Any]]], table: Optional[str] = None, *names: str):
    """A pandas DataFrame of a map's table (`frame(lens, "segment")`, all columns or those that are named, as records
    has them) or of a list in the program's JSON (`frame(raymap.paths(path)["classes"])`). ImportError without pandas."""
    import pandas

    if isinstance(what, Map):
        return pandas.DataFrame(records(what, table or "ray", *names))
    rows: List[Mapping[str, Any]] = list(what)
    return pandas.json_normalize(rows)
