#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: rays that share a path of a compact piece's dictionary are counted together, and what
`paths`, `query` and `report --energy` say is, to the last digit, what they say of the same rays stored as
columns: for any criterion and view, pieces of either encoding side by side, any number of ranks and
threads."""
import itertools
import json
import os
import shutil
import subprocess

import h5py
import numpy

from odd_scene import ODD
from served import ask

PROGRAM = os.environ["RAYMAP"]
EXAMPLES = os.path.join(os.environ["SOURCE_DIR"], "examples")

VIEWS = [["--no-peaks", "--top", "all"], ["--top", "5"], ["--by", "object", "--no-peaks"],
         ["--no-events", "--no-peaks", "--sort", "rays"], ["--collapse", "--no-peaks", "--top", "all"],
         ["--exact", "40", "--no-peaks"], ["--exact", "40"], ["--by", "group", "--no-peaks"]]
COUNT = itertools.count()


def run(*arguments, ranks=1):
    start = ["mpirun", "-np", str(ranks)] if ranks > 1 else []
    done = subprocess.run([*start, PROGRAM, *arguments], capture_output=True, text=True)
    assert done.returncode == 0, (arguments, done.returncode, done.stderr)
    return done.stdout


def trace(scene, name, *options, ranks=1):
    shutil.rmtree(name, ignore_errors=True)
    run("trace", scene, "-o", name, "--quiet", *options, ranks=ranks)
    return name


def shared(name):
    """Shares of a compact map's rays: with a path of the dictionary, and with one of its own."""
    own = []
    for folder, _, files in os.walk(name):
        for file in files:
            if file.startswith("piece-") and file.endswith(".h5"):
                with h5py.File(os.path.join(folder, file)) as piece:
                    own.append(piece["ray/path"][:] == 0)
    own = numpy.concatenate(own)
    return 1 - own.mean(), own.mean()


def answer(command, name, *options):
    return plainly(ask(command, name, *options))


def started(command, name, *options, ranks=1):
    return plainly(json.loads(run(command, name, *options, "--json", "--quiet", ranks=ranks)))


def plainly(said):
    for document in said if isinstance(said, list) else [said]:
        for key in ("map", "bytes_read", "seconds", "portions"):
            document.pop(key, None)
    return said


def in_turn(others, k):
    return others[k % len(others):][:1]


def check(plain, others, criteria, views):
    """Every view with the first criterion, the others with some of the views; then maps, ranks and threads
    take turns, so that all of them come to some questions of every sort."""
    for i, view in enumerate(views):
        for k, criterion in enumerate(criteria):
            if k > 0 and (i + k) % 3 > 0:
                continue
            options = [*view, "--where", criterion]
            want = answer("paths", plain, *options)
            for other in others if k == 0 else in_turn(others, i):
                turn = next(COUNT)
                assert answer("paths", other, *options) == want, (other, options)
                if turn % 5 == 0:
                    how = (["--threads", str(turn // 5 % 3 + 1)], turn // 30 % 3 + 2 if turn % 30 == 0 else 1)
                    assert started("paths", other, *options, *how[0], ranks=how[1]) == want, (other, options, how)
    for k, criterion in enumerate(criteria):
        want = answer("report", plain, "--energy", "--where", criterion)
        for other in in_turn(others, k):
            assert answer("report", other, "--energy", "--where", criterion) == want, (other, criterion)
    want = started("query", plain, *criteria)
    for other in others:
        assert started("query", other, *criteria) == want, other
    for k, (criterion, its) in enumerate(zip(criteria, want)):
        for other in in_turn(others, k + 1):
            assert answer("query", other, criterion) == its, (other, criterion)


def check_odd():
    with open("odd.yaml", "w") as file:
        file.write(ODD)
    criteria = ["all", "registered(gate)", "not hit(net)", 'path(".* S@milk .*")', "hit(*) == 1",
                "source(torch) and hit(net) >= 2", "path_length > 90", "hit(net) or path_length > 120",
                "ray < 3000", "hit(*) > 1000", "hit(net where step >= 3)", "hit(*, reflect where length < 40 and step in 1..2)"]
    views = VIEWS + [["--detector", "eye", "--no-peaks"], ["--detector", "gate", "--collapse", "--no-peaks"]]
    plain = trace("odd.yaml", "odd.plain.raymap", "-n", "9000", "--encoding", "plain")
    one = trace("odd.yaml", "odd.one.raymap", "-n", "9000", "--encoding", "compact")
    three = trace("odd.yaml", "odd.three.raymap", "-n", "9000", "--encoding", "compact",
                  "--piece-size", "64Ki", ranks=3)
    mixed = trace("odd.yaml", "odd.mixed.raymap", "-n", "4096", "--encoding", "compact")
    run("trace", "odd.yaml", "-o", mixed, "--append", "-n", "4904", "--encoding", "plain", "--quiet")
    known, own = shared(one)
    assert known > 0.3 and own > 0.02, (known, own)
    check(plain, [one, three, mixed], criteria, views)


def check_colours():
    """The same rays in two colour spaces: paths do not know of them."""
    maps = []
    for first, then in (("plain", "plain"), ("compact", "compact"), ("compact", "plain")):
        name = trace("odd.yaml", f"odd.colours.{first}.{then}.raymap", "-n", "4096", "--color", "rgb",
                     "--encoding", first)
        run("trace", "odd.yaml", "-o", name, "--append", "-n", "4096", "--color", "spectral", "--encoding",
            then, "--quiet")
        maps.append(name)
    check(maps[0], maps[1:], ["all", "not hit(net)", "hit(net) or path_length > 120"], VIEWS[:2])
    refused = subprocess.run([PROGRAM, "query", maps[1], "hit(net where wavelength > 500)"], capture_output=True, text=True)
    assert refused.returncode == 3 and "traced in other wavelengths" in refused.stderr, refused


def check_picked(plain, compact):
    """Rays picked by a query: their ids do not run."""
    for name in (plain, compact):
        picked = name.replace(".raymap", ".picked.raymap")
        shutil.rmtree(picked, ignore_errors=True)
        run("query", name, "hit(net) >= 2", "-o", picked, "--quiet")
    check("odd.plain.picked.raymap", ["odd.one.picked.raymap"], ["all", "registered(gate)"], VIEWS[:2])


def check_examples():
    for example, n, least, criteria in (
            ("double-gauss", 40000, 0.9, ["all", "not hit(cover.*)", "source(star) and registered(sensor)"]),
            ("luneburg", 3000, 0.5, ["all", "registered(focus)"]),
            ("room", 6000, 0.1, ["all", "hit(floor) >= 2"])):
        scene = os.path.join(EXAMPLES, example, "scene.yaml")
        plain, compact = (trace(scene, f"{example}.{encoding}.raymap", "-n", str(n), "--encoding", encoding)
                          for encoding in ("plain", "compact"))
        known, _ = shared(compact)
        assert known > least, (example, known)
        check(plain, [compact], criteria, VIEWS[:1] + VIEWS[5:6])


check_odd()
check_colours()
check_picked("odd.plain.raymap", "odd.one.raymap")
check_examples()
print("all as expected")
