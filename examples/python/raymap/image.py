# SPDX-License-Identifier: MIT
"""A detector's image as numpy arrays, from the table that `raymap detector -o OUT.csv` writes."""
from __future__ import annotations

import csv
import os
import tempfile
from dataclasses import dataclass, field
from typing import Any, Dict, Optional

import numpy as np

from .program import Path, Program


@dataclass
class Image:
    """Cells of a detector; row 0 has the least y (or phi), column 0 the least x (or theta)."""

    values: np.ndarray  # [rows][columns], in `unit`
    standard_errors: np.ndarray
    rays: np.ndarray  # registrations
    x: np.ndarray  # [columns] centres of cells
    y: np.ndarray  # [rows]
    quantity: str  # "irradiance, W/m2"
    about: Dict[str, str] = field(default_factory=dict)  # the table's "# key: value" lines


def _numbers(rows: list, key: str, shape: tuple) -> np.ndarray:
    out = np.full(shape, np.nan)
    for row in rows:
        if row[key]:
            out[int(row["j"]), int(row["i"])] = float(row[key])
    return out


def read_image(path: Path) -> Image:
    """The image that OUT.csv holds."""
    with open(path, encoding="utf-8", newline="") as file:
        lines = file.read().splitlines()
    about = dict(line[2:].split(": ", 1) for line in lines
                 if line.startswith("# ") and ": " in line)
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    shape = (1 + max(int(row["j"]) for row in rows), 1 + max(int(row["i"]) for row in rows))
    one, other = list(rows[0])[2:4]  # x, y or theta, phi
    return Image(values=_numbers(rows, "value", shape),
                 standard_errors=_numbers(rows, "standard_error", shape),
                 rays=_numbers(rows, "rays", shape), x=_numbers(rows, one, shape)[0],
                 y=_numbers(rows, other, shape)[:, 0], quantity=about.get("quantity", ""),
                 about=about)


def image(map_path: Path, name: str, *, program: Optional[Program] = None,
          **options: Any) -> Image:
    """What a detector saw, cell by cell. Options are those of `raymap detector`: where, which, ..."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "image.csv")
        (program or Program()).run("detector", map_path, name, output=out, quiet=True, **options)
        return read_image(out)
