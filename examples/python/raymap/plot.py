# SPDX-License-Identifier: MIT
"""Plots of what the program says, with matplotlib (which nothing else here needs). Each function
draws on `axes`, or on new ones, and returns them."""
from __future__ import annotations

from typing import Any, Mapping, Optional

import numpy as np

from .image import Image


def _axes(axes: Optional[Any]):
    if axes is not None:
        return axes
    import matplotlib.pyplot as pyplot

    return pyplot.subplots(constrained_layout=True)[1]


def histogram(stats: Mapping[str, Any], axes: Optional[Any] = None):
    """The histogram of raymap.stats: flux per bin, with standard errors."""
    axes = _axes(axes)
    bins = stats["histogram"]
    edges, flux = np.array(bins["edges"], float), np.array(bins["flux"], float)
    error = np.array([np.nan if e is None else e for e in bins["standard_error"]], float)
    axes.stairs(flux, edges)
    axes.errorbar((edges[1:] + edges[:-1]) / 2, flux, error, fmt="none", ecolor="0.5")
    unit = stats.get("unit")
    axes.set_xlabel(f"{stats['of']} [{unit}]" if unit else str(stats["of"]))
    axes.set_ylabel(f"flux per bin [{stats['flux']['unit']}]")
    return axes


def image(picture: Image, axes: Optional[Any] = None, **options: Any):
    """A detector's image; options go to pcolormesh."""
    axes = _axes(axes)
    mesh = axes.pcolormesh(picture.x, picture.y, picture.values, shading="nearest", **options)
    axes.set_aspect("equal")
    axes.figure.colorbar(mesh, ax=axes, label=picture.quantity)
    return axes


def _turns(one: Mapping[str, Any]) -> str:
    """A class by its source and what turned the light: all steps but straight passages."""
    steps = [step for step in one["sequence"].split() if not step.startswith("T@")]
    text = f"{one['source']}: {' '.join(steps)}"
    return text if len(text) <= 50 else text[:47] + "..."


def paths(classes: Mapping[str, Any], axes: Optional[Any] = None):
    """The classes of raymap.paths: share of the flux, with standard errors."""
    axes = _axes(axes)
    rows = classes["classes"]
    flux = [row["flux"] for row in rows]
    axes.barh(range(len(rows)), flux, xerr=[row["standard_error"] or 0.0 for row in rows])
    axes.set_yticks(range(len(rows)), [_turns(row) for row in rows], fontsize="small")
    axes.invert_yaxis()
    axes.set_xlabel("flux")
    return axes


def comparison(answer: Mapping[str, Any], axes: Optional[Any] = None):
    """The z of each flux that raymap.compare tested."""
    axes = _axes(axes)
    rows = [test for test in answer["tests"] if test.get("z") is not None]
    colours = ["tab:blue" if row["same"] else "tab:red" for row in rows]
    axes.barh(range(len(rows)), [row["z"] for row in rows], color=colours)
    axes.set_yticks(range(len(rows)), [f"{row['quantity']} {row['name']}" for row in rows],
                    fontsize="small")
    axes.invert_yaxis()
    axes.set_xlabel("difference / its standard error")
    return axes
