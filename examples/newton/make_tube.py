#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes tube.obj: a tube along z with a round hole in its wall, towards +y, for the focuser."""
import math

RADIUS, FRONT, REAR = 125, -1150, 20  # mm
HOLE, AT = 25, -800                   # radius of the hole, and where on z it lies
COLUMNS, SIDE = 60, 6                 # facets around the tube; of these, and of rows, about the hole

step = 360 / COLUMNS
half = RADIUS * math.radians(SIDE * step / 2)
rows = [FRONT] + [AT - half + 2 * half * k / SIDE for k in range(SIDE + 1)] + [REAR]
vertices, faces = [], []


def on_tube(degrees, z):
    """Degrees from +y towards +x."""
    angle = math.radians(degrees)
    vertices.append((RADIUS * math.sin(angle), RADIUS * math.cos(angle), z))
    return len(vertices)


grid = [[on_tube((i - SIDE / 2) * step, z) for i in range(COLUMNS)] for z in rows]
for j in range(len(rows) - 1):
    for i in range(COLUMNS):
        if i < SIDE and 1 <= j <= SIDE:
            continue  # the square about the hole
        k = (i + 1) % COLUMNS
        faces.append((grid[j][i], grid[j + 1][i], grid[j + 1][k], grid[j][k]))

# around the square, and the points of the hole that face its corners and sides
square = [(i, 0) for i in range(SIDE)] + [(SIDE, j) for j in range(SIDE)]
square += [(SIDE - i, SIDE) for i in range(SIDE)] + [(0, SIDE - j) for j in range(SIDE)]
rim = []
for i, j in square:
    angle = math.atan2(j - SIDE / 2, i - SIDE / 2)
    degrees = math.degrees(math.asin(HOLE * math.cos(angle) / RADIUS))
    rim.append(on_tube(degrees, AT + HOLE * math.sin(angle)))
for n, (i, j) in enumerate(square):
    m = (n + 1) % len(square)
    faces.append((grid[j + 1][i], rim[n], rim[m], grid[square[m][1] + 1][square[m][0]]))

with open("tube.obj", "w", encoding="ascii") as out:
    out.write("# made by make_tube.py, in mm\n")
    out.writelines("v %.5g %.5g %.5g\n" % v for v in vertices)
    out.writelines("f %d %d %d %d\n" % f for f in faces)
