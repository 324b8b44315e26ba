#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `select` keeps the rays that match in the map, by a name that every command takes as a criterion, alike for any
number of ranks and either encoding; h5py reads the ids; rays of another state of the map, and damaged files, are told and never
used; verify finds damage, repair removes it, and a map that is replaced or removed takes its names along."""
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
from sealed_map import edit  # noqa: E402
import raymap  # noqa: E402 (asking knows where it is)

QUOTED = "hit('lens.3') and source('sun')"
pathlib.Path("more.txt").write_text("let 'o e' = source(sun) # its\nlet two = @few or @'o e'\n", encoding="utf-8")
TWICE = "hit(lens.*, reflect) >= 2"  # chooses no registrations
GHOSTS = "registered(sensor where ghost_order >= 1) and x(sensor) > -15"
pathlib.Path("names.txt").write_text(f"let ghosts = {GHOSTS}\nlet both = @ghosts and source(sun)\n", encoding="utf-8")


def selections(name):
    return {one["name"]: one for one in json.loads(run("info", name, "--json"))["selections"]}


def answers(name, criterion, **where):
    told = served.ask("query", name, criterion) if where.get("ranks", 1) == 1 else json.loads(run("query", name, criterion, "--json", **where))
    return [told["rays"]["matched"], told["segments"], told["flux"]]


for encoding in ("compact", "plain"):
    name = trace("double-gauss", encoding + ".raymap", 40000, "--encoding", encoding)
    check("no rays have a name" in run("select", name), "none")
    check(GHOSTS in run("select", name, "ghosts", GHOSTS, ranks=3 if encoding == "plain" else 1), "told")
    run("select", name, "kept", "@both", "--criteria", "names.txt", status=3)  # defined twice: in the file, in the map
    run("select", name, "sun", "@ghosts and source(sun)")
    ids = np.sort(raymap.records(raymap.open(name), "ray", "id", where=GHOSTS)["id"])
    with h5py.File(f"{name}/selection-ghosts.h5") as file:
        check(np.array_equal(file["ray/id"][:], ids) and len(ids) > 100, "h5py reads the ids")
        check(file["name/criterion"][0].decode() == GHOSTS, "and the criterion")
    for with_name, without, ranks in (("@ghosts", GHOSTS, 2), ("not @ghosts", f"not ({GHOSTS})", 1), ("@ghosts and ray < 500", f"{GHOSTS} and ray < 500", 1),
                                      ("@sun or ray == 7", f"({GHOSTS} and source(sun)) or ray == 7", 1)):
        check(answers(name, with_name, ranks=ranks) == answers(name, without), f"{with_name} in {name}, {ranks} ranks")
    run("select", name, "twice", TWICE, "--quiet")
    check(selections(name)["sun"]["criterion"] == f"({GHOSTS}) and source(sun)", "what a name stood for")
    for words in (("stats", "--of", "angle(sensor)", "--where"), ("detector", "sensor", "--where"), ("report", "--energy", "--where"), ("paths", "--top", 3, "--where")):
        told = [json.loads(json.dumps(served.ask(words[0], name, *words[1:], criterion)).replace("@twice", TWICE)) for criterion in ("@twice", TWICE)]
        for one in told:
            for key in ("seconds",):
                one.pop(key, None)
        check(told[0] == told[1], f"{words[0]} of @twice in {name}")
    check(np.array_equal(np.sort(raymap.records(raymap.open(name), "ray", "id", where="@ghosts")["id"]), ids), "the library")
    run("query", name, "@ghosts", "-o", "picked.raymap", "--force", "--quiet")
    check(selections("picked.raymap") == {} and json.loads(run("info", "picked.raymap", "--json"))["rays"] == len(ids), "-o")
    state = selections(name)
    check(set(state) == {"ghosts", "sun", "twice"} and all(one["state"] == "good" for one in state.values()) and
          state["ghosts"]["rays"] == len(ids), f"info: {state}")

name = "compact.raymap"
run("select", name, "few", "ray == 100 or ray == 39000")
explained = json.loads(run("query", name, "@few", "--explain", "--json"))[0]
check(explained["portions"]["read"] == 2 and explained["portions"]["skipped"] == 8, f"portions without any are not read: {explained}")

# What the name may be, and what is asked wrongly.
for words, status, told in ((("ghosts", "all"), 2, "--force"), (("2nd", "all"), 2, "letters, digits"), (("a/b", "all"), 2, "cannot name"),
                            (("new",), 2, "one criterion"), (("ghosts", "all", "--remove"), 2, "--remove"),
                            (("nobody", "--remove"), 3, "no rays are named 'nobody'"), (("new", "htt(lens.1)"), 3, "did you mean"),
                            (("new", "@gost"), 3, "raymap select"), (("new", "@gohsts"), 3, "(did you mean 'ghosts'?)"),
                            (("new", "@gohsts", "--criteria", "more.txt"), 3, "more.txt (did you mean 'ghosts'?)")):
    error = run("select", name, *words, status=status)
    check(told in error, f"{words}: {error}")
error = run("query", name, "@ghosts >= 2", status=3)
check("only a single test" in error, error)
run("select", name, "fewer", "@few and @'o e' and not @few", "--criteria", "more.txt")
check(selections(name)["fewer"]["criterion"] == "(ray == 100 or ray == 39000) and source(sun) and not (ray == 100 or ray == 39000)", "file and map")
run("select", name, "fewer", "@few and ray < 200", "--force", "--quiet")
run("select", name, "few", "ray == 3", "--force", "--quiet")
check(answers(name, "@fewer")[0] == 1 and "(ray == 100" in selections(name)["fewer"]["criterion"], "whatever becomes of the other name")
run("query", name, "@two", "-o", "two.raymap", "--criteria", "more.txt", "--quiet", "--force")
check("ray == 3 or source(sun)" in run("info", "two.raymap") and "@" not in run("info", "two.raymap"), "a map of picked rays")
run("select", name, "few", "@few and ray < 5", "--force", "--quiet")
check(selections(name)["few"]["criterion"] == "ray == 3 and ray < 5", "of itself")
run("select", name, "fewer", "--remove", "--quiet")
check(answers(name, "@few")[0] == 1, "--force")
run("select", name, "few", "--remove", "--quiet")
check("few" not in selections(name), "--remove")

# Damage is found, told and never used.
path = pathlib.Path(name) / "selection-sun.h5"
whole = path.read_bytes()
for at in (9, len(whole) - 4):
    path.write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1:])
    check("selection-sun.h5" in run("query", name, "@sun", status=4), f"byte {at} is used")
    check(selections(name)["sun"]["state"] == "damaged", f"info, byte {at}")
    check("damaged" in run("info", name), "info as text")
    check("damaged" in run("verify", name, status=4), f"verify, byte {at}")
check("selection-sun.h5: removed" in run("repair", name), "repair")
check(set(selections(name)) == {"ghosts", "twice"}, "repair leaves the good one")
path.write_bytes(whole[:100])
check(f"({path}: no seal at its end" in run("info", name), "its name once, then what is wrong")
run("select", name, "sun", "@ghosts and source(sun)", "--force")
check(path.read_bytes() != whole[:100] and answers(name, "@sun")[0] > 0, "selected again in place of a damaged one")

# What somebody else wrote and sealed is not believed.
def forge(what, change):
    run("select", name, "sun", "@ghosts and source(sun)", "--force", "--quiet")
    edit(str(path), change)
    error = run("query", name, "@sun", status=4)
    check("selection-sun.h5" in error, f"{what}: {error}")
    check("damaged" in run("verify", name, status=4), f"verify: {what}")


def replace(file, values):
    del file["ray/id"]
    file["ray/id"] = values


forge("fewer ids than it says", lambda file: replace(file, file["ray/id"][:-1]))
forge("ids that fall", lambda file: replace(file, file["ray/id"][:][::-1]))
forge("ids that repeat", lambda file: replace(file, np.full(len(file["ray/id"]), 7, dtype=np.uint64)))
forge("two dimensions", lambda file: replace(file, file["ray/id"][:][None, :]))
forge("texts", lambda file: replace(file, np.array(["a"] * len(file["ray/id"]), dtype="S3")))
forge("no ids", lambda file: file.__delitem__("ray/id"))
forge("no criterion", lambda file: file.__delitem__("name/criterion"))
forge("another kind of file", lambda file: file.attrs.__setitem__("filetype", np.bytes_("raymap piece")))
forge("endless", lambda file: (replace(file, []), file.attrs.__setitem__("rays", np.uint64(2 ** 62)), file.__delitem__("ray/id"),
                               file.create_dataset("ray/id", (2 ** 62,), dtype=np.uint64, chunks=(65536,))))

run("select", name, "sun", "--remove", "--quiet")

# Other rays: told, not used, good again once selected again.
run("select", name, "it", QUOTED, "--quiet")
run("trace", SOURCE / "examples" / "double-gauss" / "scene.yaml", "-o", name, "--append", "-n", 2000, "--quiet")
error = run("query", name, "@ghosts", status=3)
check("--force" in error and GHOSTS in error, f"stale: {error}")
error = run("query", name, "@it", status=3)
run("select", name, "again", "@it and ray < 900", status=3)
done = subprocess.run(error.split("again: ")[1].splitlines()[0].replace("raymap", '"$RAYMAP"', 1), shell=True, capture_output=True, text=True, check=False)
check(done.returncode == 0 and answers(name, "@it") == answers(name, QUOTED), f"what it says is typed: {error}{done.stderr}")
check(selections(name)["ghosts"]["state"] == "stale" and "stale" in run("select", name), "stale")
run("verify", name)
run("select", name, "ghosts", GHOSTS, "--force", "--quiet", ranks=2)
check(answers(name, "@ghosts") == answers(name, GHOSTS), "selected again")

# A session.
done = subprocess.run([os.environ["RAYMAP"], "session", name], input="@ghosts\nlet few = @ghosts and ray < 900\n@few\n", text=True,
                      capture_output=True, check=False)
lines = [json.loads(line) for line in done.stdout.splitlines()]
check([line["rays"]["matched"] for line in lines[::2]] == [answers(name, "@ghosts")[0], answers(name, f"{GHOSTS} and ray < 900")[0]],
      f"session: {lines}")

# What a killed select left goes with the next; a new map has no names; foreign files are left.
(pathlib.Path(name) / ".selection-old.h5.0123456789abcdef.part").write_bytes(b"half")
run("select", name, "ghosts", GHOSTS, "--force", "--quiet")
check(not list(pathlib.Path(name).glob(".selection-*")), "half a file is removed")
(pathlib.Path(name) / "selection-2x.h5").write_bytes(b"mine")
run("trace", SOURCE / "examples" / "double-gauss" / "scene.yaml", "-o", name, "-n", 500, "--force", "--quiet", status=2)
(pathlib.Path(name) / "selection-2x.h5").unlink()
run("trace", SOURCE / "examples" / "double-gauss" / "scene.yaml", "-o", name, "-n", 500, "--force", "--quiet")
check(selections(name) == {}, "a new map has none")
shutil.rmtree("picked.raymap")
finish()
