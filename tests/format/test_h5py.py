#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""A map explains itself: h5py and h5dump read it with no code of ours, and its counts and a
detector's image come out of the columns alone."""
import os
import subprocess
import sys

try:
    import h5py
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-h5py)")
    sys.exit(77)

RAYMAP, SOURCE = os.environ["RAYMAP"], os.environ["SOURCE_DIR"]
SCENE = os.path.join(SOURCE, "examples", "double-gauss", "scene.yaml")
RAYS = 20000
failures = 0


def check(true, what):
    global failures
    if not true:
        failures += 1
        print("FAILED:", what)


def run(*command):
    result = subprocess.run(command, capture_output=True, text=True)
    if result.returncode != 0:
        print(" ".join(command), "->", result.returncode, result.stderr)
        sys.exit(1)
    return result.stdout


def datasets(file):
    found = []
    file.visititems(lambda name, item: found.append(item) if isinstance(item, h5py.Dataset) else None)
    return found


def pieces(index):
    for shard, number in zip(index["piece/shard"][:], index["piece/number"][:]):
        yield f"map.raymap/shard-{shard:05d}/piece-{number:05d}.h5"


def column(index, name):
    """A column of the whole map, piece by piece: without the virtual view."""
    return np.concatenate([h5py.File(piece, "r")[name][:] for piece in pieces(index)])


def check_described(file):
    for dataset in datasets(file):
        for attribute in ("units", "unitSI", "unitDimension", "description"):
            check(attribute in dataset.attrs, f"{file.filename}:{dataset.name} has no {attribute}")
        check(len(dataset.attrs.get("description", b"")) > 0, f"{dataset.name} says nothing")


def check_documented(file):
    with open(os.path.join(SOURCE, "docs", "map.md"), encoding="utf-8") as page:
        text = page.read()
    for dataset in datasets(file):
        check(f"`{dataset.name.split('/')[-1]}`" in text or f"{dataset.name}`" in text,
              f"docs/map.md does not speak of {dataset.name}")
    for name in file.attrs:
        check(f"`{name}`" in text, f"docs/map.md does not speak of the attribute {name}")


def check_root(file, filetype):
    check(file.attrs["filetype"] == filetype.encode(), "filetype")
    check(list(file.attrs["version"]) == [5, 0], "version")
    check(file.attrs["complete"] == 1, "complete")
    for name in ("program_version", "git_revision", "compiler", "hdf5_version", "seed",
                 "scene_digest", "length_unit", "length_unitSI", "flux_unit"):
        check(name in file.attrs, f"{file.filename} has no {name}")


def check_filters(piece):
    for table in ("ray", "segment", "registration"):
        for dataset in piece[table].values():
            check(dataset.compression == "gzip" and dataset.shuffle and dataset.fletcher32,
                  f"{dataset.name} is not declared shuffle + deflate + fletcher32")
            check(dataset.chunks[0] == 65536 and dataset.maxshape[0] is None,
                  f"{dataset.name}: {dataset.chunks} {dataset.maxshape}")


def check_counts(index):
    rays, segments = column(index, "ray/id"), column(index, "segment/event")
    check(len(rays) == RAYS == index.attrs["rays"], f"{len(rays)} rays")
    check(np.array_equal(np.sort(rays), np.arange(RAYS)), "ray ids are not 0 ... n - 1")
    check(column(index, "ray/segment_count").sum() == len(segments) == index.attrs["segments"],
          "segments")
    registrations = column(index, "registration/detector")
    check(column(index, "ray/registration_count").sum() == len(registrations)
          == index.attrs["registrations"], "registrations")
    check(index["portion/n_row"][:].sum(axis=0).tolist()
          == [RAYS, len(segments), len(registrations)], "rows of portions")
    colour = column(index, "segment/colour_spectral")
    check((colour.sum(axis=1) == 65535).all(), "colours do not sum to 65535")
    ends = np.cumsum(column(index, "ray/segment_count")) - 1
    last = segments[ends]
    ended = {0: 1 << 5, 1: 1 << 10, 2: 1 << 11, 3: 1 << 12}
    stop = column(index, "ray/stop")
    for value, bit in ended.items():
        check(((last[stop == value] & bit) != 0).all(), f"last events of rays with stop {value}")


def check_image(index):
    """The image of every detector from /registration and /ray, per source."""
    source, weight = column(index, "ray/source"), column(index, "ray/weight")
    count = column(index, "ray/registration_count")
    ray = np.repeat(np.arange(len(count)), count)
    number, cell = column(index, "registration/detector"), column(index, "registration/cell")
    registered = column(index, "registration/registered") == 1
    total = 0
    for group in index["detector"].values():
        image = np.zeros(group["image"].shape)
        mine = registered & (number == group.attrs["index"])
        np.add.at(image, (source[ray[mine]], cell[mine, 1], cell[mine, 0]), weight[ray[mine]])
        check(np.array_equal(image, group["image"][:]), f"image of {group.name}")
        check(tuple(group.attrs["cells"]) == group["image"].shape[:0:-1], f"cells of {group.name}")
        total += image.sum()
    check(total > 0, "no detector caught any light: the test shows nothing")


def check_balance(index):
    tally = index["tally"]
    emitted = tally["emitted"][:]
    ends = (tally["absorbed_object"][:].sum(axis=1) + tally["absorbed_medium"][:].sum(axis=1)
            + tally["left"][:] + tally["limit"][:] + tally["error"][:])
    check(np.array_equal(emitted, ends), f"emitted {emitted} != ended {ends}")
    check(np.array_equal(emitted, np.bincount(column(index, "ray/source"), minlength=len(emitted))),
          "emitted rays per source")


def check_view(index):
    for table in ("ray", "segment", "registration"):
        for name, dataset in index[table].items():
            check(np.array_equal(dataset[:], column(index, f"{table}/{name}"),
                                 equal_nan=dataset.dtype.kind == "f"), f"view of {dataset.name}")


def check_chunks(path):
    """Our own chunk table points at the very bytes that HDF5 stores."""
    with h5py.File(path, "r") as piece:
        names = [name.decode() for name in piece["chunk/name"][:]]
        rows = zip(*(piece["chunk/" + k][:] for k in ("stream", "index", "offset", "nbytes")))
        for number, index, offset, nbytes in rows:
            dataset = piece[names[number]]
            place = (int(index) * 65536,) + (0,) * (dataset.ndim - 1)
            info = dataset.id.get_chunk_info_by_coord(place)
            check((info.byte_offset, info.size) == (offset, nbytes), f"chunk of {dataset.name}")


run(RAYMAP, "trace", SCENE, "-o", "map.raymap", "-n", str(RAYS), "--encoding", "plain", "--force",
    "--quiet")
with h5py.File("map.raymap/map.h5", "r") as index_file:
    check_root(index_file, "raymap map")
    check_described(index_file)
    check_documented(index_file)
    check_counts(index_file)
    check_image(index_file)
    check_balance(index_file)
    check_view(index_file)
    check(b"raymap: 1" in index_file["scene/text"][0], "the scene's text")
    check(len(index_file["name/object_id"]) == len(index_file["name/object"]), "object ids")
    paths = list(pieces(index_file))
for piece_path in paths:
    with h5py.File(piece_path, "r") as piece_file:
        check_root(piece_file, "raymap piece")
        check_described(piece_file)
        check_documented(piece_file)
        check_filters(piece_file)
    check_chunks(piece_path)
    text = run("h5dump", "-d", "/segment/event", "-c", "5", piece_path)
    check("DATASET" in text and "(0)" in text, "h5dump of a piece")
check("DATASET" in run("h5dump", "-d", "/ray/stop", "-c", "5", "map.raymap/map.h5"), "h5dump")
run(RAYMAP, "trace", SCENE, "-o", "few.raymap", "-n", "500", "--force", "--quiet")
with h5py.File("few.raymap/map.h5", "r") as index_file:
    view = index_file.attrs["view"].decode()
    check(view.startswith("none: ") and "raymap convert MAP -o MAP2 --encoding plain" in view,
          f"no remedy for who looks for columns in a compact map: {view}")
    check("segment" not in index_file, "columns of a compact map")
print(f"{failures} failures")
sys.exit(failures > 0)
