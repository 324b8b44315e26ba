#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: whatever happened to a map, repair leaves one without findings that holds every ray
that could be read, says which are lost, and trace --resume brings back the digest, balance and
images of the map as it was; also when repair, merge or convert is killed in the middle."""
import glob
import json
import os
import random
import shutil
import signal
import subprocess
import sys

try:
    import h5py
except ImportError:
    print("no h5py here")
    sys.exit(77)
if not shutil.which("mpirun"):
    print("no mpirun here")
    sys.exit(77)

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.environ["SOURCE_DIR"], "tests", "faults"))
import harness

PROGRAM = os.environ["RAYMAP"]
FAULTS = os.environ["FAULTS"]
SCENE = os.path.join(os.environ["SOURCE_DIR"], "examples", "double-gauss", "scene.yaml")
RANDOM = random.Random(int(os.environ.get("RAYMAP_TEST_SEED", "3")))
SLOW = harness.SLOW  # RAYMAP_TEST_SCALE
RAYS = 20000  # five blocks: of two ranks one commits twice


def run(*arguments, ranks=1, status=0):
    start = ["mpirun", "-np", str(ranks)] if ranks > 1 else []
    done = subprocess.run([*start, PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          timeout=120, check=False)
    assert done.returncode == status, (arguments, ranks, done.returncode, done.stdout, done.stderr)
    return done.stdout


def info(path="b.raymap"):
    sums = harness.sums(path)
    return {**sums, "digest": sums["digest"].decode()}


def again():
    shutil.rmtree("b.raymap", ignore_errors=True)
    shutil.copytree("a.raymap", "b.raymap")


def at(name):
    return os.path.join("b.raymap", name)


def overwrite(path, where, data):
    with open(path, "r+b") as file:
        file.seek(where)
        file.write(data)


def flip(name, where):
    with open(at(name), "r+b") as file:
        file.seek(where)
        was = file.read(1)
        file.seek(where)
        file.write(bytes([was[0] ^ (1 << RANDOM.randrange(8))]))


def chunk(name, dataset):
    with h5py.File(os.path.join("a.raymap", name), "r") as file:
        place = file[dataset].id.get_chunk_info(0)
        return place.byte_offset + RANDOM.randrange(place.size)


def rays_of(name):
    with h5py.File(os.path.join("a.raymap", name), "r") as file:
        return int(file["portion/n_row"][:, 0].sum())


def rays_before(path, cut):
    """Rays of the portions all of whose chunks end before a byte of a plain piece."""
    with h5py.File(path, "r") as file:
        n_row = file["portion/n_row"][:].astype(int)
        good = [True] * len(n_row)
        for table, group in enumerate(("ray", "segment", "registration")):
            end = n_row[:, table].cumsum()
            for column in file[group].values():
                places = [column.id.get_chunk_info(k) for k in range(column.id.get_num_chunks())]
                lost = [p.chunk_offset[0] for p in places if p.byte_offset + p.size > cut]
                good = [g and (not lost or e <= min(lost) or n == 0)
                        for g, e, n in zip(good, end, n_row[:, table])]
        return int(n_row[good, 0].sum())


def heal(what, lost=None, ranks=1, arguments=()):
    """Repairs, checks what is said, resumes, and compares with the map as it was."""
    said = json.loads(run("repair", "b.raymap", "--json", *arguments, ranks=ranks))
    assert said["left"] == [] and said["complete"] is (said["missing"] == 0), (what, said)
    assert lost is None or said["lost"]["rays"] == lost, (what, said, lost)
    assert said["lost"]["rays"] == sum(b - a + 1 for a, b in said["lost"]["ray_ranges"])
    now = info()
    assert (said["rays"], said["digest"]) == (now["rays"], now["digest"]), (what, said, now)
    if not now["complete"] or SLOW:
        run("verify", "b.raymap", "--quiet")
    if not now["complete"]:
        run("trace", SCENE, "-o", "b.raymap", "--resume", "--quiet", *arguments[2:], ranks=ranks)
        now = info()
    run("verify", "b.raymap", "--quiet")
    assert now == WANT, (what, now, WANT)
    return said


for leftover in glob.glob("*.raymap"):
    shutil.rmtree(leftover)
run("trace", SCENE, "-o", "a.raymap", "-n", RAYS, "--piece-size", "1Mi",
    "--encoding", "plain", "--quiet", ranks=2)
pieces = sorted(os.path.relpath(p, "a.raymap") for p in glob.glob("a.raymap/shard-*/piece-*.h5"))
piece, other = pieces[0], pieces[-1]
WANT = info("a.raymap")
assert len(pieces) >= 3 and WANT["complete"] == 1

again()
assert heal("nothing", 0)["done"] == []
flip(piece, chunk(piece, "segment/position"))
flip(other, 90)
untouched = {p: os.stat(p).st_mtime_ns for p in glob.glob("b.raymap/*/*")}
run("repair", "b.raymap", "--dry-run", status=4)
assert {p: os.stat(p).st_mtime_ns for p in glob.glob("b.raymap/*/*")} == untouched
said = heal("a chunk and a seal", ranks=3 if SLOW else 2)
assert 0 < said["lost"]["rays"] <= rays_of(piece)
again()
os.truncate(at(piece), os.path.getsize(at(piece)) // 2)
heal("cut", rays_of(piece))
# More than a chunk of rays, segments and registrations: nearly every ray has one here.
subprocess.run(["bash", "-c", '. "$SOURCE_DIR/tests/cli/expect.bash"; write_scene long.yaml'], check=True)
run("trace", "long.yaml", "-o", "long.raymap", "-n", 80000, "--encoding", "plain", "--quiet", "--threads", 1)
shutil.rmtree("b.raymap")
os.rename("long.raymap", "b.raymap")
length = int(0.95 * os.path.getsize(at(piece)))
before = rays_before(at(piece), length)
os.truncate(at(piece), length)
said = json.loads(run("repair", "b.raymap", "--json"))
assert 60000 < before == said["rays"] and said["lost"]["rays"] == 80000 - before > 0, (before, said)
assert sum(1 for finding in said["found"] if finding["file"] == piece) == 1, said["found"]
again()
os.remove(at(piece))
assert json.loads(run("verify", "b.raymap", "--json", status=4))["complete"] is False
heal("missing", rays_of(piece), ranks=2)
again()
os.remove(at(piece))
os.mkdir(at(piece))
said = json.loads(run("repair", "b.raymap", "--json", status=4))
assert said["left"][0]["file"] == piece and said["lost"]["rays"] == rays_of(piece), said
run("trace", SCENE, "-o", "b.raymap", "--resume", "--quiet")
assert info() == WANT
os.rmdir(at(piece))
heal("a folder was in a piece's place", 0)
again()
shutil.rmtree("b.raymap/shard-00001")
heal("missing shard", sum(rays_of(p) for p in pieces if "shard-00001" in p))
again()
os.remove("b.raymap/map.h5")
assert "map-start.h5" in heal("no index", 0, ranks=2)["done"][0]["text"]
again()
shutil.copy("b.raymap/map.h5", "old.h5")
run("trace", SCENE, "-o", "b.raymap", "--append", "-n", 5000, "--color", "rgb", "--quiet")
WANT, as_made = info(), WANT
shutil.copy("old.h5", "b.raymap/map.h5")
found = json.loads(run("verify", "b.raymap", "--json", "--quiet", ranks=2, status=4))["findings"]
assert "older than map-start.h5, which knows of 1 run more" in found[0]["text"], found
done = heal("an index out of a backup", 0)["done"]
assert "map-start.h5" in done[0]["text"] and "took in 5,000 rays" in done[-1]["text"], done
WANT = as_made
again()
flip("map.h5", RANDOM.randrange(os.path.getsize("b.raymap/map.h5")))
flip(other, chunk(other, "ray/id"))
heal("index and chunk")
again()
flip("map-start.h5", 3000)
heal("spare index", 0)
assert os.path.exists("b.raymap/map-start.h5")
again()
flip("map.h5", 3000)
flip("map-start.h5", 3000)
run("repair", "b.raymap", status=3)
run("repair", "b.raymap", "--scene", SCENE, "--without", "stop", status=3)
heal("no index at all", 0, arguments=("--scene", SCENE))
run("trace", SCENE, "-o", "spaces.raymap", "-n", 3000, "--quiet")  # the last piece is in another space
run("trace", SCENE, "-o", "spaces.raymap", "--append", "-n", 2000, "--color", "rgb", "--quiet")
for index in glob.glob("spaces.raymap/*.h5"):
    os.remove(index)
run("repair", "spaces.raymap", "--scene", SCENE, "--without", "stop", status=3)
said = json.loads(run("repair", "spaces.raymap", "--scene", SCENE, "--json", "--quiet", status=4))
assert said["rays"] == 3000 and "colour space" in said["left"][0]["text"], said
again()
shutil.copy(at(piece), "b.raymap/shard-00001/piece-00900.h5")
heal("a piece twice", 0)
assert not os.path.exists("b.raymap/shard-00001/piece-00900.h5")
again()
shutil.copy(at(piece), "b.raymap/shard-00001/piece-00900.h5")
os.rename(at(piece), "swap.h5")
os.rename(at(other), at(piece))
os.rename("swap.h5", at(other))
heal("exchanged, and one of them twice", 0, ranks=2)
again()  # rays of another seed do not become the map's, and are not thrown away
run("trace", SCENE, "-o", "seed.raymap", "-n", 5000, "--seed", 9, "--quiet")
shutil.copy("seed.raymap/shard-00000/piece-00000.h5", "b.raymap/shard-00001/piece-00500.h5")
said = run("repair", "b.raymap", status=4)
assert "left  shard-00001/piece-00500.h5: belongs to another scene or seed" in said, said
assert os.path.exists("b.raymap/shard-00001/piece-00500.h5") and info() == WANT

# The other encoding: a damaged dictionary of paths costs the piece, a chunk its portions.
run("convert", "a.raymap", "-o", "c.raymap", "--encoding", "compact", "--quiet")
os.rename("a.raymap", "plain.raymap")
os.rename("c.raymap", "a.raymap")
for dataset in ("path/segment_count", "ray/channel", "own/stop") if SLOW else ("path/segment_count", "own/stop"):
    again()
    flip("shard-00000/piece-00000.h5", chunk("shard-00000/piece-00000.h5", dataset))
    said = heal("compact " + dataset)
    assert 0 < said["lost"]["rays"] <= RAYS, (dataset, said["lost"])
shutil.rmtree("a.raymap")
os.rename("plain.raymap", "a.raymap")

def under(faults, *arguments, ranks=1):
    """Status of a run that suffers a fault (tests/faults/fault_plan.h) at some call of a file here."""
    start = ["mpirun", "-np", str(ranks)] if ranks > 1 else []
    words = [f"FAULTS_{name}={value}" for name, value in {"DIR": os.getcwd(), **faults}.items()]
    return subprocess.run([*start, "env", "LD_PRELOAD=" + FAULTS, *words, PROGRAM,
                           *map(str, arguments)], stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL, timeout=120, check=False).returncode


def calls_of(*arguments):
    """How many calls that change files a run makes."""
    log = os.path.abspath("calls.log")
    assert under({"LOG": log}, *arguments) == 0, arguments
    with open(log + ".0", encoding="utf-8", errors="replace") as file:
        n = sum(1 for _ in file)
    os.remove(log + ".0")
    return n


def moments(n_call, n):
    """n calls to be killed at, spread over all of a run, each drawn in its part."""
    return [1 + RANDOM.randrange(i * n_call // n, (i + 1) * n_call // n) for i in range(n)]


def killed(at, *arguments):
    """Runs the program until its call number `at`; false when it made fewer."""
    return under({"AT": at, "ACTION": "kill"}, *arguments) == -signal.SIGKILL


# Killed traces: what they made safe is in the map, and the rest is traced again.
for ranks in (1, 2):
    shutil.rmtree("b.raymap", ignore_errors=True)
    faults = {"CALLS": "fdatasync", "PATH": "*.journal", "AT": 2, "ACTION": "kill"}
    assert under(faults, "trace", SCENE, "-o", "b.raymap", "-n", RAYS, "--flush-portions", 1, "--quiet",
                 "--piece-size", "8Mi", "--threads", 1, ranks=ranks) != 0
    journals = glob.glob("b.raymap/shard-*/.piece-*.journal")
    assert journals, "nothing is left"
    if ranks == 1:  # what another version of the program can read is not thrown away
        overwrite(journals[0], 16, b"\x63")
        run("repair", "b.raymap", status=4)
        assert os.path.exists(journals[0]), "a journal of another version is gone"
        overwrite(journals[0], 16, b"\x01")
    said = heal("killed trace", 0, ranks=3 - ranks)
    assert not glob.glob("b.raymap/shard-*/.piece-*"), "leftovers are left"

# Killed in the middle, and again, until it comes through.


def damage():
    again()
    flip(piece, chunk(piece, "segment/event"))
    flip(other, chunk(other, "registration/detector"))
    flip("map.h5", 4000)


hits, n = 0, 5 if SLOW else 2
damage()
for moment in moments(calls_of("repair", "b.raymap", "--quiet"), n):
    damage()
    hits += killed(moment, "repair", "b.raymap")
    hits += killed(RANDOM.randint(1, moment), "repair", "b.raymap")
    heal(f"repair killed at call {moment}")
assert hits >= n, hits
shutil.rmtree("b.raymap")
convert = ("convert", "a.raymap", "-o", "b.raymap", "--force", "--quiet")
for moment in moments(calls_of(*convert), 3 if SLOW else 1):
    assert killed(moment, *convert)
    if os.path.exists("b.raymap/map.h5"):
        heal(f"convert killed at call {moment}")
    run("verify", "a.raymap", "--quiet")
run("trace", SCENE, "-o", "c.raymap", "-n", 4096, "--first-ray", 49152, "--quiet")
merge = ("merge", "a.raymap", "c.raymap", "-o", "m.raymap", "--force", "--quiet")
for moment in moments(calls_of(*merge), 3 if SLOW else 1):
    assert killed(moment, *merge)
    run("verify", "a.raymap", "--quiet")
    run(*merge)
    run("verify", "m.raymap", "--quiet")
print(f"all as expected ({hits} kills of repair hit)")
