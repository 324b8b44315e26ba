# SPDX-License-Identifier: MIT
"""A map's tables, and lists of dicts from the program, as flat columns or pandas DataFrames."""
from __future__ import annotations

import os
import tempfile
from typing import Any, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

import h5py
import numpy as np

from .program import Path, Program
from .reader import STOPS, Map

_AXES = {3: "xyz", 2: "ij"}
# Names are found by numbers that stand in columns.
_CODED = {f"{word}_name": word for word in ("source", "stop", "object", "medium", "detector")}
_NAMED = {"ray": ("source_name", "stop_name"), "segment": ("source_name", "object_name", "medium_name"),
          "registration": ("source_name", "detector_name"), "curve": ()}


def _named(names: Sequence[str], index: np.ndarray) -> np.ndarray:
    """Names of numbers; None of -1."""
    return np.array([*names, None], dtype=object)[index]


def _part(column: str, columns: Sequence[str]) -> Tuple[str, Optional[int]]:
    """The column that has it, and which of its numbers: "position_x" is ("position", 0)."""
    whole, _, axis = column.rpartition("_")
    if column in columns or whole not in columns:
        return column, None
    return whole, int(axis) if axis.isdigit() else "xyzij".index(axis) % 3


def _parts(column: str, width: int) -> List[str]:
    """What its numbers are called, one by one."""
    if column == "colour":
        return [f"colour_{k}" for k in range(width)]
    return [f"{column}_{k}" for k in _AXES[width]] if width > 1 else [column]


def records(rays: Union[Map, Path], table: str = "ray", *names: str, where: Optional[str] = None) -> Dict[str, np.ndarray]:
    """Columns of /ray, /segment, /registration or /curve, each one-dimensional (position_x, position_y, ...), and what
    follows from them (docs/python.md): those that are named, else all. Less is read for fewer. where: a criterion, for the
    rays that match alone. The map is open, or opened for this by its path."""
    if not isinstance(rays, Map):
        with Map(rays) as opened:
            return records(opened, table, *names, where=where)
    tables = list(dict.fromkeys(name.split("/")[0] for name in rays.column_names))
    if table not in tables:
        raise ValueError(f"no table '{table}' in {rays.path}: {', '.join(tables)}")
    stored = {name.split("/")[1]: (dtype, width) for name, dtype, width in rays.handle.columns(table)}
    known = [part for name, (_, width) in stored.items() for part in _parts(name, width)] + list(_NAMED[table])
    for name in names:
        if name not in known:
            raise ValueError(f"no column '{name}' in table '{table}' of {rays.path}: {', '.join(known)}")
    taken = {name: _part(_CODED.get(name, name) if name in _NAMED[table] else name, list(stored)) for name in names or known}
    wanted = sorted({f"{table}/{whole}" for whole, _ in taken.values()})
    whole = rays.handle.whole(wanted, where)
    out = {}
    for name, (column, part) in taken.items():
        values = whole[f"{table}/{column}"]
        out[name] = values if part is None else values[:, part]
        if name in _NAMED[table]:
            out[name] = _named(STOPS if name == "stop_name" else rays.names[column], values)
    return out


def table(map_path: Path, name: str = "ray", *names: str, where: str = "all", program: Optional[Program] = None,
          **options: Any) -> Dict[str, np.ndarray]:
    """As records, of the rays that match, by the program: limit, sample, receivers, ... as of `query`."""
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


def frame(what: Union[Map, Path, Iterable[Mapping[str, Any]]], table: Optional[str] = None, *names: str,
          where: Optional[str] = None):
    """A pandas DataFrame of a map's table (`frame(lens, "segment")`, open or by its path, all columns or those that are named, as records
    has them) or of a list in the program's JSON (`frame(raymap.paths(path)["classes"])`). ImportError without pandas."""
    import pandas

    if isinstance(what, (str, os.PathLike)):
        return pandas.DataFrame(records(what, table or "ray", *names, where=where), copy=False)
    rows: List[Mapping[str, Any]] = list(what)
    if not all(isinstance(row, Mapping) for row in rows):
        raise TypeError("a DataFrame is made of a map, its path, or a list of dicts")
    return pandas.json_normalize(rows)
