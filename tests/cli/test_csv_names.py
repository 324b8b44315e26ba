#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: names with commas come whole out of every CSV file, which has the same number of
fields in each line (RFC 4180)."""
import csv
import os
import subprocess

PROGRAM = os.environ["RAYMAP"]

SCENE = """
raymap: 1
units: mm
media:
  air: {index: 1}
  "glass, old": {index: 1.5, absorption: 0.01}
surfaces:
  bare: {type: fresnel}
geometries:
  ball: {type: sphere, radius: 8}
objects:
  - {name: "ball, red", geometry: ball, at: [0, 0, 40], surface: bare, inside: "glass, old", outside: air}
sources:
  - {name: "lamp A, left", type: point, at: [0, 0, -20], direction: [0, 0, 1], distribution: {cone: 20}, flux: 3 W, medium: air}
  - {name: lamp, type: point, at: [0, 0, -20], direction: [0, 0, 1], distribution: {cone: 20}, flux: 3 W, medium: air}
detectors:
  - {name: "gate, 1", type: plane, at: [0, 0, 20], size: [50, 50], cells: [2, 2], direction: [0, 0, -1]}
  - {name: "gate 2,", type: plane, at: [0, 0, 22], size: [50, 50], cells: [2, 2], direction: [0, 0, -1]}
"""


def run(*words):
    subprocess.run([PROGRAM, *words, "--quiet", "--force"], check=True, stdout=subprocess.DEVNULL)


def tables(path):
    """Tables of a file, each with a title; lines that begin with # are remarks."""
    with open(path, encoding="utf-8", newline="") as file:
        lines = [line for line in file if not line.startswith("#") and line.strip()]
    rows = list(csv.reader(lines, strict=True))
    assert all(len(row) == len(rows[0]) for row in rows), path
    return [dict(zip(rows[0], row)) for row in rows[1:]]


def seen(path, column):
    return {row[column] for row in tables(path)}


def main():
    with open("scene.yaml", "w", encoding="utf-8") as file:
        file.write(SCENE)
    run("trace", "scene.yaml", "-o", "m.raymap", "-n", "400")
    sources = {"lamp A, left", "lamp"}
    run("report", "m.raymap", "--energy", "-o", "energy.csv")
    assert seen("energy.csv", "source") == sources | {""}
    assert {"glass, old", "gate, 1", "gate 2,"} <= seen("energy.csv", "name")
    run("query", "m.raymap", "all", "-o", "rays.csv")
    assert seen("rays.csv", "source") == sources
    assert "ball, red" in seen("rays.csv", "object")
    assert {"air", "glass, old"} <= seen("rays.csv", "medium")
    assert any("gate, 1;gate 2," in row.values() for row in tables("rays.csv"))
    run("stats", "m.raymap", "--of", "segments", "--by", "source", "-o", "stats.csv")
    assert seen("stats.csv", "source") == sources
    run("stats", "m.raymap", "--of", "x", "--detector", "*", "--by", "detector", "-o", "stats.csv")
    assert seen("stats.csv", "detector") == {"gate, 1", "gate 2,"}
    run("paths", "m.raymap", "-o", "paths.csv")
    assert seen("paths.csv", "source") == sources
    assert any("ball, red" in row["sequence"] for row in tables("paths.csv"))
    run("detector", "m.raymap", "gate, 1", "-o", "gate.csv")
    assert len(tables("gate.csv")) == 4


if __name__ == "__main__":
    main()
