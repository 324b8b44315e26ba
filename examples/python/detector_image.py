#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A detector's image as numpy arrays: peak, profiles through it, signal over noise.

    detector_image.py MAP DETECTOR [--where CRITERION]
"""
import argparse

import numpy as np

import raymap


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map")
    parser.add_argument("detector")
    parser.add_argument("--where", help="a criterion")
    parser.add_argument("--plot", metavar="OUT.png", help="with matplotlib")
    given = parser.parse_args()
    seen = raymap.image(given.map, given.detector, where=given.where)
    rows, columns = seen.values.shape
    print(f"{seen.quantity}: {columns} x {rows} cells, {seen.rays.sum():.0f} registrations")
    row, column = divmod(int(seen.values.argmax()), columns)
    print(f"peak {seen.values[row, column]:.6g} +- {seen.standard_errors[row, column]:.2g} "
          f"in cell {column} {row}")
    light = seen.values > 0
    if light.any():
        noise = seen.standard_errors[light] / seen.values[light]
        print(f"{light.mean():.1%} of the cells have light, relative error "
              f"{np.nanmedian(noise):.2g} (median)")
    print("row through the peak:", *(f"{value:.4g}" for value in seen.values[row][:12]), "...")
    if given.plot:
        from raymap import plot
        plot.image(seen).figure.savefig(given.plot)


if __name__ == "__main__":
    main()
