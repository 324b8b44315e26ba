#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: a `trace --from` that is killed goes on with --resume, with --from or without, on other ranks, and ends with the map of the
whole trace; what an older map cannot give is traced; and what makes no sense is refused, with what to do instead."""
import filecmp
import glob
import json
import os
import shutil
import subprocess
import sys
import time

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.environ["SOURCE_DIR"], "tests", "cli"))
from asking import SLOW, SOURCE, check, finish, run  # noqa: E402

ROOM = SOURCE / "examples" / "room" / "scene.yaml"
MOVED = ("--set", "objects.ball_1.at=[-2.1,-1.8,0.331]")
N = 20000


def trace(scene, name, *more, ranks=1, status=0):
    told = run("trace", scene, "-o", name, "--json", *more, ranks=ranks, status=status)
    return told if status else json.loads(told)


def killed(name):
    """Once something of it is safe."""
    shutil.rmtree(name, ignore_errors=True)
    with subprocess.Popen([os.environ["RAYMAP"], "trace", ROOM, *MOVED, "-o", name, "--from", "old.raymap", "--threads", "1", "--flush-portions", "1",
                           "--quiet"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as job:
        until = time.monotonic() + 60
        while not glob.glob(f"{name}/shard-*/.piece-*.journal") and job.poll() is None and time.monotonic() < until:
            time.sleep(0.005)
        job.kill()
        job.wait(timeout=60)


trace(ROOM, "old.raymap", "-n", N, "--force")
whole = trace(ROOM, "whole.raymap", "-n", N, "--force", *MOVED)
for ranks in (1, 2, 3) if SLOW else (2,):
    new = trace(ROOM, "new.raymap", *MOVED, "--from", "old.raymap", "--force", ranks=ranks)
    check(new["digest"] == whole["digest"] and new["sources"] == whole["sources"], f"{ranks} ranks")
    check(new["from"]["reused"] > 0.9 * N and new["from"]["digest"] == json.loads(run("info", "old.raymap", "--json"))["digest"], new["from"])
for again in ((), ("--from", "old.raymap")):
    killed("new.raymap")
    new = trace(ROOM, "new.raymap", *MOVED, "--resume", *again, ranks=2)
    check(new["digest"] == whole["digest"] and new["sources"] == whole["sources"] and new["complete"], f"resumed {again}")
    check("parent" in json.loads(run("info", "new.raymap", "--json")), "the parent is named")
    run("verify", "new.raymap", "--quiet")

# Of the same scene, and by convert, the very bytes: what is written of decoded rays is what the tracer had them written as.
for example, n in (("room", 5000), ("double-gauss", 5000)):
    scene = SOURCE / "examples" / example / "scene.yaml"
    trace(scene, "first.raymap", "-n", n, "--force", "--threads", 1)
    new = trace(scene, "second.raymap", "--from", "first.raymap", "--force", "--threads", 1)
    check(new["from"]["reused"] == n, f"{example}: all are taken over")
    run("convert", "first.raymap", "-o", "third.raymap", "--encoding", "compact", "--force", "--threads", 1)
    for other in ("second", "third"):
        check(filecmp.cmp("first.raymap/shard-00000/piece-00000.h5", f"{other}.raymap/shard-00000/piece-00000.h5", shallow=False), f"{example}: bytes of {other}")

# More rays than the old map has, others than it begins with, and none of them.
more = trace(ROOM, "more.raymap", *MOVED, "-n", N, "--first-ray", 15000, "--force")
new = trace(ROOM, "new.raymap", *MOVED, "-n", N, "--first-ray", 15000, "--from", "old.raymap", "--force")
check(new["digest"] == more["digest"] and 0 < new["from"]["reused"] <= N - 15000, f"partly: {new['from']}")
run("trace", ROOM, *MOVED, "-n", 5000, "--seed", 3, "--from", "old.raymap", "-o", "new.raymap", "--force", status=2)

for words, status, says in ((("--from", "old.raymap", "--append", "-n", 9, "-o", "whole.raymap", *MOVED), 2, "leave out one of them"),
                            (("--from", "old.raymap", "--no-record"), 2, "leave out --no-record"),
                            (("--from", "old.raymap", "-o", "old.raymap", "--force"), 2, "another name"),
                            (("--from", "none.raymap", "-o", "new.raymap", "--force"), 3, "none.raymap")):
    told = run("trace", ROOM, *words, status=status)
    check(says in told, f"{words}: {told}")
run("query", "old.raymap", "hit(ball_1)", "-o", "picked.raymap", "--force", "--quiet")
check("picked" in run("trace", ROOM, "--from", "picked.raymap", "-o", "new.raymap", "--force", "-n", 100, status=3), "picked rays")

# What changes every ray is said, and all are traced.
for change, says in ((("--set", "sources.lamp.at=[0,0,2.5]"), "lamp"), (("--color", "spectral"), "spectrum"), (("--time", "on"), "times"),
                     (("--set", "limits={steps: 77}"), "limits"), (("--set", "objects.floor.at=[0,0,-0.01]"), "has changed")):
    whole = trace(ROOM, "whole.raymap", "-n", 1000, "--force", *change)
    new = trace(ROOM, "new.raymap", "-n", 1000, "--force", *change, "--from", "old.raymap")
    check(new["digest"] == whole["digest"] and new["from"]["reused"] == 0 and says in str(new["from"]["all_anew"]), f"{change}: {new['from']}")
    check("parent" not in json.loads(run("info", "new.raymap", "--json")), f"{change}: no parent")
finish()
