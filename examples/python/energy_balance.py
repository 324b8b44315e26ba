#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Where the light of each source went; and that nothing is lost: counted again from the columns.

    energy_balance.py MAP [--where CRITERION]
"""
import argparse

import numpy as np

import raymap


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map")
    parser.add_argument("--where", help="a criterion")
    given = parser.parse_args()
    print(raymap.Program().run("report", given.map, "--energy", where=given.where, quiet=True))
    if given.where:
        return
    rays = raymap.open(given.map)
    stop = rays.columns("ray/stop")["ray/stop"]
    counts = np.bincount(stop, minlength=len(raymap.STOPS))
    print("counted from the columns:",
          ", ".join(f"{word} {n}" for word, n in zip(raymap.STOPS, counts)))
    assert counts.sum() == rays.n_rays


if __name__ == "__main__":
    main()
