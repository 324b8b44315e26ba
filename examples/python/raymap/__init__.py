# SPDX-License-Identifier: MIT
"""Ray maps in Python: read through libraymap, asked through the program `raymap`.

    import raymap
    lens = raymap.open("lens.raymap")          # names, seed, columns, rays
    lens.columns("ray/weight", "ray/stop")     # numpy arrays of all rays
    for ray in lens.rays(): ...                # one ray after the other
    raymap.records(lens, "registration", "x", "y", where="registered(sensor)")   # flat numpy arrays
    raymap.frame(lens, "ray")                  # a pandas DataFrame, where pandas is installed

    raymap.query("lens.raymap", "hit(lens.*, reflect) >= 2")   # counts, as the program prints them
    raymap.compare("before.raymap", "after.raymap")["same"]
    raymap.image("lens.raymap", "sensor").values               # numpy [rows][columns]

What selects, sums and tests is the program: a function here starts it and hands on its JSON. It is
found as $RAYMAP, else on the PATH, or told: raymap.Program("build/release/raymap").
"""
from .program import (Program, RaymapError, compare, detector, energy, info, paths, query, report,
                      stats)
from .image import Image, image
from .plain import plain
from .reader import EVENTS, STOPS, Map, MapError, Portion, Ray, event_words
from .tables import frame, records, table

__all__ = ["EVENTS", "STOPS", "Image", "Map", "MapError", "Portion", "Program", "Ray",
           "RaymapError", "compare", "detector", "energy", "event_words", "frame", "image", "info",
           "open", "paths", "plain", "query", "records", "report", "stats", "table"]


def open(path) -> Map:  # noqa: A001 - as gzip.open and h5py.File do
    """A map's directory, in either encoding."""
    return Map(path)
