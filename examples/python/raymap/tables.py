# SPDX-License-Identifier: MIT
"""A map's tables, and lists of dicts from the program, as flat columns or pandas DataFrames."""
from __future__ import annotations

from typing import Any, Dict, Iterable, List, Mapping, Optional, Union

import numpy as np

from .reader import Map

_AXES = {3: "xyz", 2: "ij"}


def records(rays: Map, table: str = "ray") -> Dict[str, np.ndarray]:
    """The columns of /ray, /segment, /registration or /curve, each one-dimensional: position_x,
    position_y, ... /segment and /registration get `ray_id`, the ray that a row belongs to."""
    names = [name for name in rays.column_names if name.startswith(table + "/")]
    if not names:
        known = ", ".join(dict.fromkeys(name.split("/")[0] for name in rays.column_names))
        raise ValueError(f"no table '{table}' in {rays.path}: {known}")
    counts = [f"ray/{table}_count", "ray/id"] if table in ("segment", "registration") else []
    columns = rays.columns(*names, *(name for name in counts if name not in names))
    out: Dict[str, np.ndarray] = {}
    if counts:
        out["ray_id"] = np.repeat(columns["ray/id"], columns[f"ray/{table}_count"])
    for name in names:
        column, short = columns[name], name.split("/")[1]
        if column.ndim == 1:
            out[short] = column
            continue
        for k in range(column.shape[1]):
            axis = _AXES.get(column.shape[1], "")
            out[f"{short}_{axis[k] if axis and short != 'colour' else k}"] = column[:, k]
    return out


def frame(what: Union[Map, Iterable[Mapping[str, Any]]], table: Optional[str] = None):
    """A pandas DataFrame of a map's table (`frame(lens, "segment")`) or of a list in the program's
    JSON (`frame(raymap.paths(path)["classes"])`). ImportError without pandas."""
    import pandas

    if isinstance(what, Map):
        return pandas.DataFrame(records(what, table or "ray"))
    rows: List[Mapping[str, Any]] = list(what)
    return pandas.json_normalize(rows)
