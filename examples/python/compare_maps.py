#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Are two maps the same light? What differs, most significant first.

    compare_maps.py MAP OTHER [--where CRITERION]
    compare_maps.py MAP --where A --where B
"""
import argparse

import raymap


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map")
    parser.add_argument("other", nargs="?")
    parser.add_argument("--where", action="append", help="a criterion; twice: one per sample")
    parser.add_argument("--plot", metavar="OUT.png", help="with matplotlib")
    given = parser.parse_args()
    answer = raymap.compare(given.map, given.other, where=given.where)
    print("same" if answer["same"] else "DIFFERENT",
          f"({answer['different']} of {answer['tested']} tests)")
    for note in answer["notes"]:
        print("note:", note)
    tested = [test for test in answer["tests"] if test["p"] is not None]
    for test in sorted(tested, key=lambda one: one["p"])[:8]:
        said = f"z = {test['z']:.2f}" if test.get("z") is not None else (
            f"chi-square = {test['chi_square']:.1f} of {test['degrees']:.0f}"
            if "chi_square" in test else "values without spread")
        print(f"  p = {test['p']:<9.3g} {test['quantity']} {test['name'] or 'in all'}: {said}")
    if given.plot:
        from raymap import plot
        plot.comparison(answer).figure.savefig(given.plot)


if __name__ == "__main__":
    main()
