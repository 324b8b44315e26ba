#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the two halves of the chequered floor, dark.obj and light.obj, beside this file."""
import pathlib

TILES, SIDE = 24, 0.6  # along each edge; metres

for name, colour in (("light", 0), ("dark", 1)):
    lines, n = ["# A chequered floor: every other tile."], 0
    for i in range(TILES):
        for k in range(TILES):
            if (i + k) % 2 != colour:
                continue
            x, y = (i - TILES / 2) * SIDE, (k - TILES / 2) * SIDE
            for dx, dy in ((0, 0), (SIDE, 0), (SIDE, SIDE), (0, SIDE)):
                lines.append(f"v {x + dx:.4g} {y + dy:.4g} 0")
            lines.append(f"f {n + 1} {n + 2} {n + 3} {n + 4}")
            n += 4
    path = pathlib.Path(__file__).with_name(name + ".obj")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
