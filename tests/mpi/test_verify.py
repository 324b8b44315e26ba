#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: a whole map has no findings; whatever is changed in, cut from or moved about in its
files is found by name, down to the dataset, the chunk and the rays that it costs; any number of
ranks finds the same."""
import glob
import json
import os
import random
import shutil
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

PROGRAM = os.environ["RAYMAP"]
SCENE = os.path.join(os.environ["SOURCE_DIR"], "examples", "double-gauss", "scene.yaml")
RANDOM = random.Random(20260721)
SLOW = int(os.environ.get("RAYMAP_TEST_SCALE", "1")) > 1
RAYS = 30000
INDEX = "map.h5"
TABLES = {  # stored tables of a piece, in order, and how small pieces are to be here
    "plain": (["ray", "segment", "registration"], "1Mi"),
    "compact": (["ray", "own", "own_segment", "own_registration", "path", "path_segment",
                 "path_registration", "triangle", "patch", "pool16", "pool32", "pool64"], "40k")}


def run(*arguments, ranks=1, status=0):
    start = ["mpirun", "-np", str(ranks)] if ranks > 1 else []
    done = subprocess.run([*start, PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          timeout=120, check=False)
    assert done.returncode == status, (arguments, ranks, done.returncode, done.stdout, done.stderr)
    return done.stdout


def verify(path="b.raymap", ranks=1, ok=False):
    """The document, without what takes another time each time."""
    document = json.loads(run("verify", path, "--json", "--quiet", "--threads", 2, ranks=ranks,
                              status=0 if ok else 4))
    assert document["ok"] is ok and (document["findings"] == []) is ok, document
    assert document.pop("seconds") > 0
    return document


def again():
    shutil.rmtree("b.raymap", ignore_errors=True)
    shutil.copytree("a.raymap", "b.raymap")


def flip(name, at, nbytes=1):
    with open(os.path.join("b.raymap", name), "r+b") as file:
        file.seek(at)
        was = file.read(nbytes)
        file.seek(at)
        file.write(bytes(b ^ (1 << RANDOM.randrange(8)) for b in was))


def cut(name, length):
    os.truncate(os.path.join("b.raymap", name), length)


def portions(name):
    """(first ray, rays, rows of the stored tables from .. to) of a piece, by first ray."""
    with h5py.File(os.path.join("a.raymap", name), "r") as file:
        rays = file["portion/first_ray"][:], file["portion/n_row"][:, 0]
        start, rows = file["portion/stored_first"][:], file["portion/stored_rows"][:]
    return sorted((int(f), int(n), [(int(s), int(s + k)) for s, k in zip(starts, ks)])
                  for f, n, starts, ks in zip(*rays, start, rows))


def merged(intervals):
    out = []
    for first, n in sorted(intervals):
        if out and out[-1][1] + 1 == first:
            out[-1][1] = first + n - 1
        else:
            out.append([first, first + n - 1])
    return out


def stored(name):
    """Dataset -> (table, a chunk of it, where that is, its bytes), of what a piece stores."""
    found = {}
    with h5py.File(os.path.join("a.raymap", name), "r") as file:
        for table, group in enumerate(TABLES[encoding][0]):
            for column, dataset in file[group].items():
                if dataset.id.get_num_chunks() > 0:
                    place = dataset.id.get_chunk_info(RANDOM.randrange(dataset.id.get_num_chunks()))
                    found[f"/{group}/{column}"] = (table, place.chunk_offset[0] // 65536, place.byte_offset, place.size)
    return found


def in_turns(items):
    """(piece, item) until all are dealt, in rounds that harm each piece once: it is verified once a round."""
    left = list(items)
    while left:
        dealt = list(zip(pieces, left))
        again()
        yield dealt
        left = left[len(dealt):]


def each(document, dealt):
    """(finding, what was harmed): one in each of these files, in their order."""
    assert len(document["findings"]) == len(dealt), (dealt, document["findings"])
    return zip(document["findings"], dealt)


def one(document, name):
    """What is found, where that is one thing."""
    assert len(document["findings"]) == 1, document["findings"]
    return judged(document["findings"][0], name)


def judged(found, name, dataset=None, chunk=None):
    assert found["file"] == name, (found, name)
    assert dataset is None or found["dataset"] == dataset, (found, dataset)
    assert found["chunk"] == chunk, (found, chunk)
    return found


for leftover in glob.glob("*.raymap"):
    shutil.rmtree(leftover)

for encoding in TABLES:
    run("trace", SCENE, "-o", "a.raymap", "-n", RAYS, "--piece-size", TABLES[encoding][1],
        "--encoding", encoding, "--force", "--quiet", ranks=2)
    pieces = sorted(os.path.relpath(p, "a.raymap") for p in glob.glob("a.raymap/shard-*/piece-*.h5"))
    assert len(pieces) >= 4 and {p[:11] for p in pieces} == {"shard-00000", "shard-00001"}, pieces

    # Whole: nothing is found, and all of it was looked at.
    info = json.loads(run("info", "a.raymap", "--json"))
    for ranks in (1, 2, 3) if SLOW else (2,):
        whole = verify("a.raymap", ranks, ok=True)
        checked = whole["checked"]
        assert checked["rays"] == RAYS and checked["segments"] == info["segments"], checked
        assert checked["pieces"] == len(pieces) and whole["complete"] is True

    # One byte of a stored chunk, in every dataset that a piece has.
    chunks = {name: stored(name) for name in pieces}
    in_all = sorted(set.intersection(*map(set, chunks.values())))
    assert len(in_all) > 20
    for dealt in in_turns(in_all):
        for name, dataset in dealt:
            _, _, offset, size = chunks[name][dataset]
            flip(name, offset + RANDOM.randrange(size))
        for found, (name, dataset) in each(verify(), dealt):
            table, chunk, _, _ = chunks[name][dataset]
            judged(found, name, dataset, chunk)
            first, end = chunk * 65536, chunk * 65536 + 65536
            shared = dataset.startswith("/path")  # the dictionary is every ray's
            hit = [(f, n) for f, n, rows in portions(name)
                   if shared or (rows[table][0] < end and rows[table][1] > first)]
            assert found["ray_ranges"] == merged(hit), (found, hit)
            assert found["ray_count"] == sum(n for _, n in hit) and found["rows"][0] == first
            assert found["rays"] == [found["ray_ranges"][0][0], found["ray_ranges"][-1][1]]

    # A byte of a piece that is in no chunk: HDF5's own, tables, seal; and files that were cut off.
    for harm, places in ((flip, (0, 9, 100, -1, -20, -100)), (cut, (0, 1, 100, 20000, -40, -1))):
        for dealt in in_turns(places):
            for name, place in dealt:
                harm(name, place % os.path.getsize(os.path.join("a.raymap", name)))
            for found, (name, _) in each(verify(), dealt):
                judged(found, name)
                assert found["ray_ranges"] == merged((f, n) for f, n, _ in portions(name)), found
    piece, datasets = pieces[1], chunks[pieces[1]]

    # A byte of the index, and an index that was cut off.
    spots = 8 if SLOW else 1
    size = os.path.getsize(os.path.join("a.raymap", INDEX))
    for at in [0, size - 30] + [RANDOM.randrange(size) for _ in range(spots)]:
        again()
        flip(INDEX, at)
        one(verify(), INDEX)
    for length in (0, 1, 100, size // 2, size - 40, size - 1) if SLOW else (0, size - 1):
        again()
        cut(INDEX, length)
        one(verify(), INDEX)

    if encoding != "plain" and not SLOW:
        continue

    # Missing, extra, renamed, exchanged: of the files, whatever is in them.
    again()
    os.remove(os.path.join("b.raymap", piece))
    found = one(verify(), piece)
    assert "missing" in found["text"] and found["ray_ranges"] == merged((f, n) for f, n, _ in portions(piece))
    again()
    shutil.rmtree("b.raymap/shard-00001")
    found = one(verify(), "shard-00001")
    assert "missing" in found["text"]
    assert found["ray_count"] == sum(n for p in pieces if "shard-00001" in p for _, n, _ in portions(p))
    again()
    shutil.copy(os.path.join("b.raymap", piece), "b.raymap/shard-00001/piece-00777.h5")
    assert "extra" in one(verify(), "shard-00001/piece-00777.h5")["text"]
    again()
    shutil.copytree("b.raymap/shard-00001", "b.raymap/shard-00009")
    findings = verify()["findings"]
    assert [f["file"] for f in findings] == [p.replace("00001/", "00009/") for p in pieces if "00001/" in p]
    again()
    os.rename(os.path.join("b.raymap", piece), "b.raymap/shard-00000/piece-00778.h5")
    assert [f["file"] for f in verify()["findings"]] == sorted([piece, "shard-00000/piece-00778.h5"])
    for other in (pieces[0], pieces[-1]):
        again()
        a, b = os.path.join("b.raymap", piece), os.path.join("b.raymap", other)
        os.rename(a, "swap.h5")
        os.rename(b, a)
        os.rename("swap.h5", b)
        findings = verify()["findings"]
        assert [f["file"] for f in findings] == sorted([piece, other]), findings
        assert all("under another name" in f["text"] for f in findings), findings
    again()
    os.remove("b.raymap/map.h5")
    one(verify(), INDEX)

    # Much at once, whoever looks.
    again()
    many = list(datasets.items())[::3]
    for _, (_, _, offset, size) in many:
        flip(piece, offset + RANDOM.randrange(size))
    flip(pieces[0], 50)
    os.remove(os.path.join("b.raymap", pieces[-1]))
    want = verify()
    assert len(want["findings"]) == len(many) + 2
    for ranks in (2, 3) if SLOW else (3,):
        assert verify(ranks=ranks) == want
    assert many[0][0] in run("verify", "b.raymap", status=4)
    flip(INDEX, 3000)  # the index gone as well: what pieces hold is still looked at
    want = verify()
    assert len(want["findings"]) == len(many) + 2, want["findings"]
    assert verify(ranks=2) == want

# A map that was stopped early has nothing wrong with it.
run("trace", SCENE, "-o", "early.raymap", "-n", "100G", "--time-limit", "0.2s", "--quiet", status=6)
assert verify("early.raymap", ok=True)["complete"] is False

# No map at all.
run("verify", "nothing.raymap", status=3)
run("verify", ".", status=4)
run("verify", SCENE, status=4)
print("all as expected")
