#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The ways that light takes to a detector, and which of them is stray light.

    ghosts.py MAP DETECTOR [--top 10]

Paths are told apart by what happened until the detector. Each class of rays comes with the
criterion that selects it: `raymap draw --where` shows it.
"""
import argparse

import raymap


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map")
    parser.add_argument("detector")
    parser.add_argument("--top", type=int, default=10)
    parser.add_argument("--plot", metavar="OUT.png", help="with matplotlib")
    given = parser.parse_args()
    found = raymap.paths(given.map, detector=given.detector, top=given.top)
    unit = found["flux"].get("unit", "")
    print(f"{found['rays']['matched']} rays reach {given.detector}")
    for one in found["classes"]:
        print(f"{one['share']:8.3%}  {one['flux']:.4g} {unit} +- {one['standard_error'] or 0:.2g}  "
              f"{one['source']}: {one['sequence']}")
    rest = found["remainder"]
    print(f"{rest['share']:8.3%}  {rest['classes']} more classes")
    main_path = found["classes"][0] if found["classes"] else None
    if main_path and main_path["criterion"]:
        stray = raymap.query(
            given.map, f"registered({given.detector}) and not ({main_path['criterion']})")
        print(f"all but the strongest class: {stray['flux']['matched']:.4g} "
              f"+- {stray['flux']['standard_error']:.2g} {stray['flux']['unit']}")
    if given.plot:
        from raymap import plot
        plot.paths(found).figure.savefig(given.plot)


if __name__ == "__main__":
    main()
