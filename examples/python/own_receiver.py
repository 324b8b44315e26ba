#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A receiver of one's own, laid over a finished map: no ray is traced again.

    own_receiver.py MAP x y z width dx dy dz [--cells 64]

A square of that width at (x, y, z) looks along (dx, dy, dz) to the light. It is written as the `detectors:`
of a scene file, which `raymap detector --receivers FILE` takes.
"""
import argparse
import os
import tempfile

import raymap

RECEIVER = """detectors:
  - {{name: own, type: plane, at: [{at}], size: [{width}, {width}], cells: [{cells}, {cells}],
     direction: [{direction}], side: both}}
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map")
    parser.add_argument("at", type=float, nargs=3, metavar=("x", "y", "z"))
    parser.add_argument("width", type=float)
    parser.add_argument("direction", type=float, nargs=3, metavar=("dx", "dy", "dz"))
    parser.add_argument("--cells", type=int, default=64)
    parser.add_argument("--where", help="a criterion")
    parser.add_argument("--plot", metavar="OUT.png", help="with matplotlib")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        receivers = os.path.join(folder, "own.yaml")
        with open(receivers, "w", encoding="utf-8") as file:
            file.write(RECEIVER.format(at=", ".join(map(str, given.at)), width=given.width,
                                       cells=given.cells,
                                       direction=", ".join(map(str, given.direction))))
        sums = raymap.detector(given.map, "own", receivers=receivers, where=given.where)
        seen = raymap.image(given.map, "own", receivers=receivers, where=given.where)
    flux = sums["flux"]
    print(f"{sums['registrations']} registrations, flux {flux['total']:.6g} {flux['unit']}")
    row, column = divmod(int(seen.values.argmax()), seen.values.shape[1])
    print(f"largest {seen.values.max():.6g} ({seen.quantity}) at x {seen.x[column]:.4g}, "
          f"y {seen.y[row]:.4g}")
    if given.plot:
        from raymap import plot
        plot.image(seen).figure.savefig(given.plot)


if __name__ == "__main__":
    main()
