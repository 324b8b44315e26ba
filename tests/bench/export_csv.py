#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The columns of a plain map that questions are about, as ray.csv, segment.csv and
registration.csv in a folder:  export_csv.py MAP FOLDER"""
import os
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))
from evaluator_map import PlainMap  # noqa: E402


def write(path, **columns):
    with open(path, "w", encoding="utf-8") as file:
        file.write(",".join(columns) + "\n")
        names = list(columns)
        n = len(columns[names[0]])
        for first in range(0, n, 1 << 18):
            rows = zip(*(columns[name][first:first + (1 << 18)].tolist() for name in names))
            file.write("".join(",".join(map(str, row)) + "\n" for row in rows))


def main(target, folder):
    m = PlainMap(target)
    os.makedirs(folder, exist_ok=True)
    ray, name = m.ray["id"].astype(np.int64), {k: np.array(v + [""]) for k, v in m.names.items()}
    order = np.argsort(ray)
    write(f"{folder}/ray.csv", ray=ray[order], source=name["source"][m.ray["source"][order]],
          stop=m.ray["stop"][order], segments=m.ray["segment_count"][order],
          path_length=m.ray["path_length"][order])
    order = np.argsort(ray[m.ray_of_segment], kind="stable")
    write(f"{folder}/segment.csv", ray=ray[m.ray_of_segment[order]], leg=m.leg[order],
          object=name["object"][m.segment["object"][order]], event=m.segment["event"][order])
    order = np.argsort(ray[m.ray_of_registration], kind="stable")
    r = {k: v[order] for k, v in m.registration.items()}
    write(f"{folder}/registration.csv", ray=ray[m.ray_of_registration[order]], leg=r["segment"],
          detector=name["detector"][r["detector"]], registered=r["registered"], x=m.x[order],
          y=m.y[order], angle=m.angle[order], time=1e9 * m.time[order])


main(*sys.argv[1:3])
