#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Statistics of a number of rays: from the program, with errors; and by hand, from the columns.

    number_statistics.py MAP [--of path_length] [--where CRITERION]
"""
import argparse

import numpy as np

import raymap


def by_hand(map_path):
    """Flux-weighted mean of the stored path lengths of all rays, in numpy."""
    with raymap.plain(map_path) as rays:
        columns = rays.columns("ray/source", "ray/weight", "ray/path_length")
    flux = rays.flux(columns["ray/source"], columns["ray/weight"])
    return np.average(columns["ray/path_length"], weights=flux)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map")
    parser.add_argument("--of", default="path_length", help="a number of a ray or registration")
    parser.add_argument("--where", help="a criterion")
    parser.add_argument("--bins", type=int, help="so many (default: as the program chooses)")
    parser.add_argument("--plot", metavar="OUT.png", help="with matplotlib")
    given = parser.parse_args()
    found = raymap.stats(given.map, given.of, where=given.where, bins=given.bins)
    mean = found["mean"]
    print(f"{found['of']}: mean {mean['value']:.9g} +- {mean['standard_error']:.2g} "
          f"{found['unit'] or ''}, from {found['min']:.6g} to {found['max']:.6g}")
    for quantile in found["quantiles"]:
        print(f"  {quantile['p']:6.2%}  {quantile['value']:.6g}")
    if given.of == "path_length" and not given.where:
        print(f"by hand: mean {by_hand(given.map):.9g}")
    bins = found["histogram"]
    most = max(bins["flux"]) or 1.0
    for low, flux in zip(bins["edges"], bins["flux"]):
        print(f"  {low:12.6g}  {'#' * round(50 * flux / most)}")
    if given.plot:
        from raymap import plot
        plot.histogram(found).figure.savefig(given.plot)


if __name__ == "__main__":
    main()
