#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `keep` writes the columns that numbers are made of beside the pieces of a compact map, alike for any number of
ranks and threads; h5py reads them; every answer is the same with them as without, and rays are not traced again for them. Damage is
told and never read past, verify finds it, repair removes it; pieces of other rays are not taken for them."""
import json
import os
import pathlib
import shutil
import subprocess
import sys

import h5py
import numpy as np

sys.dont_write_bytecode = True
import served  # noqa: E402
from asking import SOURCE, check, finish, run, trace  # noqa: E402
from sealed_map import checksum, edit  # noqa: E402
import raymap  # noqa: E402 (asking knows where it is)

SCENE = SOURCE / "examples" / "double-gauss" / "scene.yaml"
QUESTIONS = (
    ("query", "path_length > 150", "registered(sensor where angle > 12)", "not path_length in 100..160 and hit(lens.3, reflect)",
     "x(sensor) > 2 * y(sensor) and path_length > 140", "hit(lens.3 where angle > 20) and path_length < 170", "--count"),
    ("stats", "--of", "path_length"), ("stats", "--of", "angle(sensor)", "--where", "path_length < 160"),
    ("stats", "--of", "optical_path - 1.5 * path_length", "--by", "source"),
    ("stats", "--of", "path_length", "--detector", "sensor", "--where", "source(star) and hit(*, reflect) >= 2", "--which", "angle > 10"),
    ("detector", "sensor", "--where", "path_length > 145"),
    ("query", "all", "--top", 5, "--of", "path_length"))


def kept(name):
    return json.loads(run("info", name, "--json"))["kept"]


def answers(name, **where):
    told = []
    for command, *words in QUESTIONS:
        if where or "--top" in words or "--count" in words:
            answer = json.loads(run(command, name, *words, "--json", **where))
        else:
            answer = served.ask(command, name, *words)
        for one in answer if isinstance(answer, list) else [answer]:
            for key in ("seconds", "map", "bytes_read", "portions"):
                one.pop(key, None)
            told.append(one)
    return told


def verify_text(name):
    return subprocess.run([os.environ["RAYMAP"], "verify", name], text=True, capture_output=True, check=False).stdout


def columns_file(name, piece=0, shard=0):
    return pathlib.Path(name) / f"shard-{shard:05d}" / f"piece-{piece:05d}.columns.h5"


lens = trace("double-gauss", "lens.raymap", 40000)
without = answers(lens)
check("nothing is kept" in run("keep", lens) and kept(lens)["pieces"] == 0, "nothing at first")
numbers = ("--of", "path_length", "--of", "angle(sensor)")
check("/ray/path_length /registration/direction" in run("keep", lens, *numbers, "--threads", 2), "told")
first = columns_file(lens).read_bytes()
check(kept(lens)["columns"] == ["/ray/path_length", "/registration/direction"] and kept(lens)["bytes"] == len(first), f"info: {kept(lens)}")
check(answers(lens) == without and answers(lens, ranks=2) == without, "the same answers")
plain = trace("double-gauss", "plain.raymap", 40000, "--encoding", "plain")
with h5py.File(columns_file(lens)) as file:
    ray = raymap.records(raymap.open(plain), "ray", "id", "path_length")
    check(np.array_equal(file["ray/path_length"][:], ray["path_length"][np.argsort(ray["id"])]), "h5py reads the column")
    check(file["ray/path_length"].attrs["units"] in ("mm", b"mm"), "its unit")
explained = json.loads(run("query", lens, "path_length > 150 and registered(sensor where angle > 12)", "--explain", "--json"))[0]
check(explained["compact"]["traced_again"] == 0 and explained["compact"]["portions"] > 0, f"explain: {explained['compact']}")
explained = json.loads(run("query", lens, "optical_path > 150", "--explain", "--json"))[0]
check(explained["compact"]["traced_again"] > 0, "what is not kept is traced again")
reader = raymap.records(raymap.open(lens), "ray", "path_length", where="path_length > 150")
check(len(reader["path_length"]) == without[0]["rays"]["matched"], "the library")
run("verify", lens)

# Any number of ranks and threads writes the same; what is there is passed over, more is added.
for ranks, threads in ((3, 2),):
    columns_file(lens).unlink()
    run("keep", lens, *numbers, "--threads", threads, "--quiet", ranks=ranks)
    check(columns_file(lens).read_bytes() == first, f"{ranks} ranks, {threads} threads")
check(json.loads(run("keep", lens, "--of", "path_length", "--json"))["made"] == 0, "passed over")
check(json.loads(run("keep", lens, "--of", "path_length", "--force", "--json"))["made"] == 1 and
      columns_file(lens).read_bytes() == first, "--force")
error = run("keep", lens, "--of", "x(sensor)", "--of", "segments")
check("nothing to keep" not in error and kept(lens)["columns"] == ["/ray/path_length", "/registration/direction"], "stands as it is")
run("keep", lens, "--of", "optical_path", "--quiet", ranks=2)
check(len(kept(lens)["columns"]) == 3 and answers(lens) == without, "one more")
run("verify", lens)
check("columns of plain pieces" in run("keep", plain, "--of", "path_length"), "a plain map")

# Several pieces and shards; more rays; merging; another map in its place.
run("trace", SCENE, "-o", "parts.raymap", "-n", 40000, "--piece-size", "1Mi", "--quiet", "--force", ranks=2)
run("keep", "parts.raymap", *numbers, "--quiet", ranks=3)
told = kept("parts.raymap")
check(told["pieces"] == told["of_pieces"] > 1 and answers("parts.raymap") == without, f"parts: {told}")
run("trace", SCENE, "-o", "parts.raymap", "--append", "-n", 5000, "--quiet")
told = kept("parts.raymap")
check(told["pieces"] == told["of_pieces"] - 1, "appended rays have none")
grown = answers("parts.raymap")
check(json.loads(run("keep", "parts.raymap", *numbers, "--json"))["made"] == 1, "the new piece alone")
check(answers("parts.raymap") == grown, "the same answers of more rays")
run("trace", SCENE, "-o", "other.raymap", "-n", 3000, "--first-ray", 100000, "--quiet", "--force")
run("merge", "parts.raymap", "other.raymap", "-o", "merged.raymap", "--quiet", "--force")
check(kept("merged.raymap")["pieces"] == kept("parts.raymap")["pieces"], "merge takes them along")
run("verify", "merged.raymap")
shutil.copy(columns_file("parts.raymap"), columns_file("other.raymap"))
told = kept("other.raymap")
check(told["pieces"] == 0 and told["unused"] == 1 and "other rays" in told["why"], f"of other rays: {told}")
check(json.loads(run("query", "other.raymap", "path_length > 150", "--json"))["rays"]["total"] == 3000, "not used")
check("damaged in 1 place" in run("verify", "other.raymap", status=4), "verify")
check("columns.h5: removed" in run("repair", "other.raymap"), "repair")
run("verify", "other.raymap")

# Damage.
path = columns_file(lens)
for at in (len(first) // 2, 40):
    run("keep", lens, "--remove", "--quiet")
    check(not path.exists() and answers(lens) == without, "--remove")
    run("keep", lens, *numbers, "--quiet")
    path.write_bytes(first[:at] + bytes([first[at] ^ 4]) + first[at + 1:])
    error = run("stats", lens, "--of", "path_length", status=4)
    check("keep" in error and "--force" in error, f"byte {at}: {error}")
    check("damaged in 1 place" in run("verify", lens, status=4), f"verify, byte {at}")
    run("keep", lens, *numbers, "--force", "--quiet")
    check(path.read_bytes() == first, f"--force mends byte {at}")
half = path.with_name(".piece-00000.columns.h5.0.0.host.1.part")
half.write_bytes(b"half")
names = path.with_name("..").resolve() / ".selection-old.h5.0123456789abcdef.part"
names.write_bytes(b"half")
for command in ("info", "verify"):
    told = run(command, lens)
    check(f"unfinished shard-00000/{half.name}: 4 bytes that a killed command left; raymap repair removes it" in told and
          f"unfinished {names.name}: " in told and "1 finding" not in told, f"{command} names it: {told}")
    check([one["file"] for one in json.loads(run(command, lens, "--json"))["unfinished"]] == [names.name, "shard-00000/" + half.name], "as JSON")
told = run("repair", lens)
check(told.count(": removed: nothing of it was finished") == 2 and not half.exists() and not names.exists(), f"repair: {told}")
check(json.loads(run("verify", lens, "--json"))["unfinished"] == [], "and is gone")
half.write_bytes(b"half")
run("keep", lens, "--of", "path_length", "--quiet")
check(not half.exists(), "what a killed run left goes")
path.write_bytes(first[:1000])
check("removed: it was damaged" in run("repair", lens) and not path.exists(), "repair")
run("verify", lens)


def forge(what, change):
    """What somebody else wrote and sealed is not believed, or found to say another thing."""
    path.write_bytes(first)
    edit(str(path), change)
    told = run("verify", lens, status=4)
    check("damaged in 1 place" in told, f"{what}: {told}")
    check("--force" in run("query", lens, "path_length > 150", status=4), what)


def put(dataset, value):
    data = dataset[:]
    data[-1] = value
    dataset[...] = data
    dataset.attrs.modify("checksum", np.uint64(checksum(data.tobytes())))


forge("a chunk outside", lambda file: put(file["chunk/offset"], 2 ** 40))
forge("a chunk too many", lambda file: put(file["chunk/index"], 7))
forge("a dataset that is not there", lambda file: put(file["chunk/stream"], 60000))
forge("no list of chunks", lambda file: file.__delitem__("chunk"))
forge("another kind of file", lambda file: file.attrs.__setitem__("filetype", np.bytes_("raymap piece")))

# Columns of other rays that say they are of these: verify compares values.
path.unlink()
run("keep", lens, "--of", "path_length", "--quiet")
with h5py.File(path) as file:
    digest = file.attrs["digest"]
run("trace", SCENE, "-o", "seed.raymap", "-n", 40000, "--seed", 2, "--quiet", "--force")
run("keep", "seed.raymap", "--of", "path_length", "--quiet")
shutil.copy(columns_file("seed.raymap"), path)
edit(str(path), lambda file: file.attrs.__setitem__("digest", digest))
check("another thing than its piece" in verify_text(lens), "values are compared")
shutil.rmtree(lens)
finish()
