#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: a finished compact piece says how many of its rays have each path, and discrete questions read no more than the rays
with paths of their own; they have the answers of a plain map, for any ranks, also of a part of a map."""
import glob
import json
import sys

import h5py
import numpy

sys.dont_write_bytecode = True
import served  # noqa: E402
from asking import check, finish, run, trace  # noqa: E402

QUESTIONS = ("hit(lens.*, reflect) >= 2", "not hit(lens.3)", "source(sun) and ended(left)", "registered(sensor)", "all", "bounces > 3 or hit(lens.2, absorb)",
             "hit(lens.3, reflect) and path_length > 100")
OF_RAYS = ("source(sun) and ended(left)", "all")  # no step is looked at


def ask(name, *words, ranks=1):
    if ranks > 1:
        return json.loads(run("query", name, *words, "--json", ranks=ranks))
    return served.ask("query", name, *words)


def same(one, other):
    return all(one[key] == other[key] for key in ("rays", "segments", "flux"))


trace("double-gauss", "lens.raymap", 120000, "--piece-size", "200k")
trace("double-gauss", "plain.raymap", 120000, "--encoding", "plain")
pieces, stored, heads = sorted(glob.glob("lens.raymap/shard-*/piece-*.h5")), 0, 0
check(len(pieces) >= 4, f"{len(pieces)} pieces")
for name in pieces:
    with h5py.File(name) as piece:
        counts = numpy.bincount(piece["ray/path"][:], minlength=len(piece["path/source"]) + 1)
        check((piece["tally/path_rays"][:] == counts[1:]).all() and counts[1:].sum() > 0.9 * counts.sum(), name)
        for table in ("own", "own_segment", "own_registration", "path", "path_segment", "path_registration", "pool64"):
            nbytes = sum(one.id.get_storage_size() for one in piece[table].values())
            stored += nbytes
            heads += nbytes if table in ("own", "path", "pool64") else 0

for question in QUESTIONS:
    told = ask("lens.raymap", question)
    check(same(told, ask("plain.raymap", question)), f"{question}: as of a plain map")
    for ranks in (2, 3)[:1 + (question == QUESTIONS[0])]:
        again = ask("lens.raymap", question, ranks=ranks)
        check(same(told, again) and told["bytes_read"] == again["bytes_read"] and told["portions"] == again["portions"], f"{question}: {ranks} ranks")
    check((told["bytes_read"] <= stored) == ("path_length" not in question), f"{question}: {told['bytes_read']} bytes of {stored}")
    check((told["bytes_read"] <= heads) == (question in OF_RAYS), f"{question}: {told['bytes_read']} bytes of {heads}")

# Bounds of lengths are those of the rays: thresholds at, and next to, the numbers themselves.
with h5py.File("plain.raymap/map.h5") as index:
    lengths = {name: index["ray/" + name][:] for name in ("path_length", "optical_path")}
for name, length in lengths.items():
    for value in (length.min(), numpy.quantile(length, 0.5, method="nearest")):
        for at in (value, numpy.nextafter(value, 0), numpy.nextafter(value, 1e9)):
            for sign, holds in ((">", length > at), ("==", length == at)):
                told = ask("lens.raymap", f"{name} {sign} {at!r}")
                check(told["rays"]["matched"] == int(holds.sum()), f"{name} {sign} {at!r}: {told['rays']}, {holds.sum()}")
middle = float(numpy.quantile(lengths["path_length"], 0.5))
for question in (f"path_length > {middle!r}", f"2 * path_length > {2 * middle!r}", "optical_path - path_length > 40", f"not (path_length - optical_path > -{middle / 2!r})"):
    check(same(*(ask(name, question) for name in ("lens.raymap", "plain.raymap"))), question)
    undecided = json.loads(run("query", "lens.raymap", question, "--explain", "--json"))[0]["compact"]
    check(0 < undecided["undecided_rays"] < 0.4 * undecided["rays"], f"{question}: {undecided}")

# Angles are known to a quarter of a degree: at its ends, at angles that there are, and next to them.
angles = [one["value"] for one in served.ask("stats", "plain.raymap", "--of", "angle(sensor)")["quantiles"]]
for value in (*angles, 12.25, 12.5):
    for at in (value, numpy.nextafter(value, 0), numpy.nextafter(value, 90)):
        for question in (f"registered(sensor where angle > {at!r})", f"registered(sensor where not (angle == {at!r} or x > 2)) == 1"):
            told, true = (ask(name, question) for name in ("lens.raymap", "plain.raymap"))
            check(same(told, true) and told["registered"] == true["registered"], question)
explained = run("query", "lens.raymap", f"registered(sensor where angle > {angles[2]!r})", "--explain", "--json")
undecided = json.loads(explained)[0]["compact"]
check(0 < undecided["undecided_beside_paths"] < undecided["undecided_rays"] / 20, f"{undecided}")
together = json.loads(run("query", "lens.raymap", *QUESTIONS, "--json", ranks=2))
check(all(same(one, ask("plain.raymap", question)) for one, question in zip(together, QUESTIONS)), "all at once")
part = [ask(name, QUESTIONS[0], "--until", "20%") for name in ("lens.raymap", "plain.raymap")]
check(same(*part) and part[0]["until"]["rays"] < 120000, "of a part of the map")


with h5py.File("plain.raymap/map.h5") as index:
    check("tally/path_rays" not in index, "no piece, no paths")
verified = json.loads(run("verify", "lens.raymap", "--json"))
check(verified["ok"], "sound")
finish()
