#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: history indexes say what the columns say, whoever makes them and wherever their pieces
go; they are small; what is wrong with one is told by verify, put right by repair, and costs no
answer."""
import filecmp
import glob
import json
import os
import resource
import shutil
import subprocess
import sys

if not shutil.which("mpirun"):
    print("no mpirun here")
    sys.exit(77)

PROGRAM = os.environ["RAYMAP"]
EXAMPLES = os.path.join(os.environ["SOURCE_DIR"], "examples")
LENS, ROOM = (os.path.join(EXAMPLES, name, "scene.yaml") for name in ("double-gauss", "room"))
QUESTIONS = ["all", "hit(*) >= 3", "not hit(*, reflect_specular)", "ended(absorbed) and segments > 4",
             "registered(*)"]


def run(*arguments, ranks=1, status=0):
    start = ["mpirun", "-np", str(ranks)] if ranks > 1 else []
    done = subprocess.run([*start, PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          timeout=240, check=False)
    assert done.returncode == status, (arguments, ranks, done.returncode, done.stdout, done.stderr)
    return done.stdout, done.stderr


def told(*arguments, **how):
    return json.loads(run(*arguments, "--json", "--quiet", **how)[0])


def indexes(path):
    return sorted(os.path.relpath(name, path)
                  for name in glob.glob(os.path.join(path, "shard-*", "*.history.h5")))


def pieces(path):
    return sorted(os.path.relpath(name, path)
                  for name in glob.glob(os.path.join(path, "shard-*", "piece-?????.h5")))


def answers(path):
    return [{key: answer[key] for key in ("criterion", "rays", "segments", "flux")}
            for answer in told("query", path, *QUESTIONS, "--count")]


def again(name):
    shutil.rmtree("b.raymap", ignore_errors=True)
    shutil.copytree(name, "b.raymap")


def flip(name, at):
    with open(name, "r+b") as file:
        file.seek(at)
        was = file.read(1)
        file.seek(at)
        file.write(bytes([was[0] ^ 16]))


def test_sizes_and_same_bytes():
    for scene, name, rays in ((LENS, "lens.raymap", 60000), (ROOM, "room.raymap", 30000)):
        run("trace", scene, "-o", name, "-n", rays, "--force", "--quiet", "--piece-size", "4Mi",
            "--encoding", "plain",
            ranks=2)
        n = len(pieces(name))
        assert n > 2 and indexes(name) == []
        before = answers(name)
        made = told("index", name)
        assert (made["pieces"], made["made"]) == (n, n) and made["share"] < 0.1, made
        assert len(indexes(name)) == n
        info = told("info", name)
        assert info["index"] == {"pieces": n, "bytes": made["bytes"], "unused": 0, "why": ""}
        assert info["bytes"] == made["map_bytes"]
        assert told("index", name)["made"] == 0
        again(name)
        assert told("index", "b.raymap", "--force", ranks=3)["made"] == n
        for index in indexes(name):
            assert filecmp.cmp(os.path.join(name, index), os.path.join("b.raymap", index), False)
        assert answers(name) == before
        assert told("verify", name)["ok"]


def test_none_beyond_a_tenth():
    """Of a compact map they would be: only when asked for, with the same answers."""
    run("trace", ROOM, "-o", "c.raymap", "-n", 30000, "--encoding", "compact", "--force", "--quiet",
        "--piece-size", "200Ki")
    before, n = answers("c.raymap"), len(pieces("c.raymap"))
    assert n > 1
    for ranks in (1, 3):
        left = told("index", "c.raymap", ranks=ranks)
        assert left["pieces"] == n and left["made"] == left["bytes"] == 0, left
        assert left["left"] == n and left["left_bytes"] > 0.1 * left["map_bytes"], left
    assert indexes("c.raymap") == []
    told_so = run("index", "c.raymap")[0]
    assert f"{n} pieces are left without" in told_so and "--large" in told_so, told_so
    done = run("trace", ROOM, "-o", "d.raymap", "-n", 30000, "--encoding", "compact", "--force",
               "--index")
    assert "--large" in done[1] and indexes("d.raymap") == [], done
    made = told("index", "c.raymap", "--large", ranks=2)
    assert (made["made"], made["left"]) == (n, 0), made
    assert 0.3 < left["left_bytes"] / made["bytes"] < 3, (left, made)
    kept = told("index", "c.raymap")
    assert (kept["made"], kept["left"], kept["bytes"]) == (0, 0, made["bytes"]), kept
    assert len(indexes("c.raymap")) == n and answers("c.raymap") == before


def test_leaving_out_takes_no_work():
    """A default map: that its index is too large is seen at one portion of each piece."""
    run("trace", ROOM, "-o", "early.raymap", "-n", 200000, "--force", "--quiet")

    def seconds(*words):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = told("index", "early.raymap", *words)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return done, after.ru_utime - before.ru_utime

    left, short = seconds()
    made, long = seconds("--large")
    assert left["left"] == made["made"] == left["pieces"] > 0 == left["made"], (left, made)
    assert 0.3 < left["left_bytes"] / made["bytes"] < 3, (left, made)
    assert short < 0.8 * long, (short, long)


def test_a_trace_may_make_them():
    done = run("trace", LENS, "-o", "t.raymap", "-n", 5000, "--index", "--force",
               "--encoding", "plain")
    assert "history indexes" in done[1] and len(indexes("t.raymap")) == len(pieces("t.raymap"))
    run("trace", LENS, "-o", "t.raymap", "-n", 5000, "--append", "--index", "--quiet")
    assert len(indexes("t.raymap")) == len(pieces("t.raymap")) > 1
    assert told("verify", "t.raymap", ranks=2)["ok"]
    run("trace", LENS, "-o", "t.raymap", "-n", 100, "--force", "--quiet",
        "--encoding", "plain")
    assert indexes("t.raymap") == []


def named_once(path, index):
    remedy = f"raymap index {path} --force makes it again"
    for words, ranks in ((["query", path, *QUESTIONS, "--count"], 1), (["paths", path], 1), (["query", path, *QUESTIONS], 3)):
        said = run(*words, "--quiet", ranks=ranks)[1].splitlines()
        assert len(said) == 1 and index in said[0] and remedy in said[0], (words, ranks, said)


def test_damage_is_named_mended_and_costs_no_answer():
    before = answers("room.raymap")
    for at in (-3, 0.5, 0.2, 40):
        again("room.raymap")
        index = os.path.join("b.raymap", indexes("b.raymap")[1])
        size = os.path.getsize(index)
        flip(index, size + at if at < 0 else int(at * size) if at < 1 else at)
        found = told("verify", "b.raymap", status=4)["findings"]
        assert {one["file"] for one in found} == {indexes("b.raymap")[1]}, found
        assert answers("b.raymap") == before
        named_once("b.raymap", indexes("b.raymap")[1])
        told("repair", "b.raymap")
        assert len(indexes("b.raymap")) == len(pieces("b.raymap")) - 1
        assert told("verify", "b.raymap")["ok"] and told("info", "b.raymap")["complete"]
        assert told("index", "b.raymap")["made"] == 1
    with open(index, "r+b") as file:
        file.truncate(1000)
    assert told("verify", "b.raymap", status=4)["findings"]
    assert told("index", "b.raymap")["made"] == 1
    assert told("verify", "b.raymap")["ok"]


def test_of_other_rays():
    again("room.raymap")
    before = answers("b.raymap")
    first, second = (os.path.join("b.raymap", name) for name in indexes("b.raymap")[:2])
    shutil.copy(first, second)
    found = told("verify", "b.raymap", status=4)["findings"]
    assert len(found) == 1 and "not those of its piece" in found[0]["text"], found
    assert answers("b.raymap") == before
    assert told("index", "b.raymap")["made"] == 1 and told("verify", "b.raymap")["ok"]
    stray = os.path.join("b.raymap", "shard-00000", "piece-00077.history.h5")
    shutil.copy(first, stray)
    found = told("verify", "b.raymap", status=4)["findings"]
    assert [one["file"] for one in found] == ["shard-00000/piece-00077.history.h5"], found
    told("repair", "b.raymap")
    assert not os.path.exists(stray) and told("verify", "b.raymap")["ok"]


def unused(path, n, why):
    found = told("info", path)["index"]
    assert found["unused"] == n and why in found["why"], found
    planned = told("query", path, "all", "--explain")[0]["index"]
    assert planned["unused_pieces"] == n and why in planned["why"], planned
    for said in run("info", path)[0], run("query", path, "all", "--explain")[0]:
        assert (f"of {n} piece{'s' * (n != 1)} cannot be used" in said and why in said) == (n > 0), said


def test_one_that_is_not_used_is_told_of():
    again("room.raymap")
    before = answers("b.raymap")
    unused("b.raymap", 0, "")
    for index in indexes("b.raymap")[1:]:
        with open(os.path.join("b.raymap", index), "r+b") as file:
            file.truncate(1000)
    n = len(indexes("b.raymap")) - 1
    unused("b.raymap", n, "cut off")
    assert answers("b.raymap") == before
    assert told("index", "b.raymap")["made"] == n
    unused("b.raymap", 0, "")
    first, second = (os.path.join("b.raymap", name) for name in indexes("b.raymap")[:2])
    shutil.copy(first, second)
    unused("b.raymap", 1, "not those of its piece")


def test_convert_and_merge():
    before = answers("lens.raymap")
    told("convert", "lens.raymap", "-o", "p.raymap", "--force")
    assert len(indexes("p.raymap")) == len(pieces("p.raymap"))
    told("convert", "lens.raymap", "-o", "c.raymap", "--encoding", "compact", "--force")
    assert indexes("c.raymap") == []  # beyond a tenth
    assert told("index", "c.raymap", "--large")["made"] == len(pieces("c.raymap"))
    assert answers("c.raymap") == before and told("verify", "c.raymap")["ok"]
    for k in range(2):
        run("trace", LENS, "-o", f"m{k}.raymap", "-n", 9000, "--first-ray", 9000 * k, "--quiet",
            "--encoding", "plain",
            "--force", *(["--index"] if k == 0 else []))
    told("merge", "m0.raymap", "m1.raymap", "-o", "m.raymap", "--force")
    assert len(indexes("m.raymap")) == len(pieces("m.raymap")) - 1
    assert told("verify", "m.raymap")["ok"]
    run("trace", LENS, "-o", "whole.raymap", "-n", 18000, "--quiet", "--force",
        "--encoding", "plain")
    assert answers("m.raymap") == answers("whole.raymap")
    assert told("index", "m.raymap")["made"] == 1 and answers("m.raymap") == answers("whole.raymap")


def test_wrong_maps():
    run("index", "nowhere.raymap", status=3)
    run("index", LENS, status=4)
    run("index", status=2)
    again("lens.raymap")
    for at in range(20000, 900000, 5000):
        flip(os.path.join("b.raymap", pieces("b.raymap")[0]), at)
    said = run("index", "b.raymap", "--force", status=4)[1]
    assert pieces("b.raymap")[0] in said, said


if __name__ == "__main__":
    for name, test in list(globals().items()):
        if name.startswith("test_"):
            test()
            print(name, "ok", flush=True)
