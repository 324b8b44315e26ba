#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`raymap index` has nothing to do: it is accepted, as is `trace --index`; indexes that earlier versions left beside
pieces are not read, `info` names them, `repair` removes them, and no command takes them along."""
import json
import os
import pathlib
import shutil
import subprocess

PROGRAM = os.environ["RAYMAP"]
SCENE = os.path.join(os.environ["SOURCE_DIR"], "examples/double-gauss/scene.yaml")
OLD = "shard-00000/piece-00000.history.h5"


def run(*arguments, status=0):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False)
    assert done.returncode == status, (arguments, done.returncode, done.stderr)
    return done.stdout, done.stderr


def told(*arguments, **how):
    return json.loads(run(*arguments, "--json", "--quiet", **how)[0])


def files(path):
    return sorted(str(file.relative_to(path)) for file in pathlib.Path(path).rglob("*") if file.is_file())


for name in pathlib.Path(".").glob("*.raymap"):
    shutil.rmtree(name)
said = run("trace", SCENE, "-o", "m.raymap", "-n", 5000, "--index")[1]
assert "--index: nothing to do" in said, said
assert "nothing to do" not in run("trace", SCENE, "-o", "q.raymap", "-n", 10, "--index", "--quiet")[1]
before = files("m.raymap")
for options in ((), ("--large",), ("--force", "--large")):
    out, err = run("index", "m.raymap", *options)
    assert out == "m.raymap: nothing to do: maps need no index\n" and err == "", (out, err)
answer = told("index", "m.raymap")
assert answer["pieces"] == 1 and answer["made"] == answer["left"] == answer["bytes"] == answer["share"] == 0, answer
assert answer["map_bytes"] == told("info", "m.raymap")["bytes"] and files("m.raymap") == before
run("index", "nowhere.raymap", status=3)
run("index", SCENE, status=4)
run("index", status=2)

assert told("info", "m.raymap")["index"] == {"pieces": 0, "bytes": 0, "unused": 0, "why": ""}
counted = told("query", "m.raymap", "hit(lens.3)")["rays"]
old = pathlib.Path("m.raymap", OLD)
old.write_bytes(b"not an index" * 100)
named = told("info", "m.raymap")["index"]
assert named["pieces"] == named["unused"] == 1 and named["bytes"] == 1200 and "no longer used" in named["why"], named
assert "history indexes of 1 piece, 0.0 MB beside that, are no longer used: raymap repair removes them" in \
    run("info", "m.raymap")[0]
assert told("query", "m.raymap", "all", "--explain")[0]["index"]["unused_pieces"] == 1
assert told("query", "m.raymap", "hit(lens.3)")["rays"] == counted
assert told("verify", "m.raymap")["ok"]
run("trace", SCENE, "-o", "m.raymap", "-n", 100, "--append", "--quiet")
told("merge", "m.raymap", "-o", "merged.raymap")
told("convert", "m.raymap", "-o", "other.raymap")
assert not [file for path in ("merged.raymap", "other.raymap") for file in files(path) if "history" in file]
run("repair", "m.raymap", "--dry-run")
assert old.exists()
done = told("repair", "m.raymap")["done"]
assert [one["file"] for one in done] == [OLD] and not old.exists(), done
assert told("repair", "m.raymap")["done"] == [] and told("verify", "m.raymap")["ok"]
run("trace", SCENE, "-o", "m.raymap", "-n", 100, "--quiet", "--force")
old.write_bytes(b"old")
run("trace", SCENE, "-o", "m.raymap", "-n", 100, "--quiet", "--force")
assert not old.exists()  # a map that is replaced goes whole
