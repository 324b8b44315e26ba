#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: a map has the rays of one revision of the tracer. Rays that are others than they were need a new one
(src/trace/tracer_revision.h) and new rows here; maps of two revisions are not mixed, and old maps are read."""
import json
import os
import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import sealed_map

PROGRAM, EXAMPLES = os.environ["RAYMAP"], pathlib.Path(os.environ["SOURCE_DIR"]) / "examples"
# (revision, scene): digest of its first 2000 rays, with the instruction set that decides ties as it is named here
ISA = "AVX-512"
GOLDEN = {
    (1, "double-gauss"): "d9cb3de018cfe8bb62fba0e622465d39",
    (1, "gradient-sphere"): "f9d1a979806eb33934ef1de19b55e231",
    (1, "luneburg"): "4ee59e1bb5a868f12fc7f0c5d539594f",
    (1, "mirage"): "6319ac54782a9a403489f2c287c5376d",
    (1, "room"): "45632c052522c38e1941ff2e62da1534",
    (1, "selfoc"): "b120c949665c7c35067cf6461fb2a2c1",
    (1, "telescope"): "689611ed38eae1a37964ec94e637f399",
    (2, "double-gauss"): "d9cb3de018cfe8bb62fba0e622465d39",
    (2, "gradient-sphere"): "f9d1a979806eb33934ef1de19b55e231",
    (2, "luneburg"): "4ee59e1bb5a868f12fc7f0c5d539594f",
    (2, "mirage"): "6319ac54782a9a403489f2c287c5376d",
    (2, "room"): "45632c052522c38e1941ff2e62da1534",
    (2, "selfoc"): "b120c949665c7c35067cf6461fb2a2c1",
    (2, "telescope"): "689611ed38eae1a37964ec94e637f399",
    (3, "double-gauss"): "d9cb3de018cfe8bb62fba0e622465d39",
    (3, "gradient-sphere"): "b15201f0f7a1868518d83ba7421dc25b",
    (3, "luneburg"): "4ee59e1bb5a868f12fc7f0c5d539594f",
    (3, "mirage"): "0cad1c8ab68fc74f09104d84e040ac3e",
    (3, "room"): "45632c052522c38e1941ff2e62da1534",
    (3, "selfoc"): "b120c949665c7c35067cf6461fb2a2c1",
    (3, "telescope"): "9c81cacfef4b6faa784fd5d379169e5b",
}


def run(*words, status=0, says=""):
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == status and says in done.stdout + done.stderr, (words, done.returncode, done.stderr)
    return done.stdout


def info(path):
    return json.loads(run("info", path, "--json"))


def as_revision(path, name, revision):
    """A copy whose files say that another revision made them (None: do not say)."""
    def change(file):
        if revision is None:
            del file.attrs["tracer_revision"]
        else:
            file.attrs.modify("tracer_revision", [revision])
    shutil.rmtree(name, ignore_errors=True)
    shutil.copytree(path, name)
    for file in pathlib.Path(name).rglob("*.h5"):
        if file.name != "map-start.h5":
            sealed_map.edit(file, change)


revision = int(next(line.split()[-1] for line in run("--version").splitlines() if line.startswith("tracer")))
same_isa = True
for scene in sorted(scene for key, scene in GOLDEN if key == revision) or sys.exit("no row for this revision"):
    run("trace", EXAMPLES / scene / "scene.yaml", "-o", "m.raymap", "-n", 2000, "--force", "--quiet")
    made = info("m.raymap")
    same_isa = made["versions"]["isa"] == ISA
    assert made["versions"]["tracer"] == revision
    assert not same_isa or made["digest"] == GOLDEN[revision, scene], \
        f"{scene}: other rays than before ({made['digest']}): raise RMAP_TRACER_REVISION, and say in docs/map.md why"

SCENE = EXAMPLES / "double-gauss" / "scene.yaml"
run("trace", SCENE, "-o", "a.raymap", "-n", 2000, "--force", "--quiet")
run("trace", SCENE, "-o", "b.raymap", "-n", 2000, "--first-ray", 2000, "--force", "--quiet")
as_revision("b.raymap", "other.raymap", revision + 6)
run("verify", "other.raymap")
for words in (("trace", SCENE, "-o", "other.raymap", "--resume"), ("trace", SCENE, "-o", "other.raymap", "-n", 100, "--append"),
              ("merge", "a.raymap", "other.raymap", "-o", "c.raymap")):
    told = (f"of tracer revision {one}, and these are of {two}" for one, two in
            ((revision + 6, revision), (revision, revision + 6))[words[0] == "merge":])
    run(*words, status=3, says=next(told))
run("trace", SCENE, "-o", "c.raymap", "--from", "other.raymap", status=3, says=f"of tracer revision {revision + 6}, and this program's are of {revision}")
assert not os.path.exists("c.raymap")
run("convert", "other.raymap", "-o", "d.raymap", "--encoding", "plain", "--force", "--quiet")
assert info("d.raymap")["versions"]["tracer"] == revision + 6
shutil.copy("b.raymap/shard-00000/piece-00000.h5", "other.raymap/shard-00000/piece-00000.h5")
run("verify", "other.raymap", status=4, says="another revision of the tracer")

# Maps from before the number are of revision 1.
as_revision("a.raymap", "old.raymap", None)
run("verify", "old.raymap")
assert info("old.raymap")["versions"]["tracer"] == 1
run("trace", SCENE, "-o", "old.raymap", "-n", 100, "--append", "--quiet", status=0 if revision == 1 else 3)
if not same_isa:
    print(f"no {ISA} here: digests were not compared")
