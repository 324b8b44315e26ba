#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: a C++ program on libraymap gets from maps of either encoding what the program answers, on any number of threads,
and every failure as a text; the library links neither MPI nor Embree, shows what it promises and nothing else, in a layout that
callers compiled earlier know, and leaves HDF5 as its host has it."""
import ctypes
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import threading
import time

import h5py
import numpy as np

sys.dont_write_bytecode = True
from asking import SOURCE, check, finish, run, trace  # noqa: E402
import raymap  # noqa: E402 (asking knows where it is)
from raymap import library  # noqa: E402

BUILD = pathlib.Path(os.environ["BUILD_DIR"])
LIBRARY = BUILD / "libraymap.so.1"

# What was released: a change here is a change of RAYMAP_ABI. Sizes, places and values on 64-bit machines.
SYMBOLS = """blocks close count_rays data find_ray flux_unit is_complete length_unit name open read reader_column reader_create
reader_destroy rows seed trouble version wavelengths""".split()
LAYOUT = {
    "raymap_error": (1028, {"status": 0, "text": 4}),
    "raymap_count": (32, {"rays": 0, "segments": 8, "flux": 16, "standard_error": 24}),
    "raymap_column": (40, {"name": 0, "unit": 8, "description": 16, "table": 24, "type": 28, "width": 32}),
    "raymap_block": (56, {"first_ray": 0, "rays": 8, "rows": 16, "space": 48}),
}
VALUES = """OK INTERNAL USAGE INPUT FORMAT SYSTEM, RAY SEGMENT REGISTRATION CURVE, U8 U16 I16 U32 I32 U64 F32 F64,
SOURCE OBJECT MEDIUM DETECTOR STOP EVENT"""


def compiled(compiler, *words):
    done = subprocess.run([compiler, *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"FAIL {compiler}: {done.stderr}")


def consumer(*words, status=0):
    done = subprocess.run(["./consumer", *map(str, words)], capture_output=True, text=True, check=False)
    check(done.returncode == status and done.stderr == "", f"consumer {words}: {done.returncode} {done.stdout} {done.stderr}")
    return done.stdout


def answers(name, criterion, column):
    told = raymap.query(name, criterion)
    run("query", name, criterion, "-o", "rows.h5", "--columns", column, "--force", "--quiet")
    with h5py.File("rows.h5") as file:
        values = file[column][:].astype(float)
    text = consumer(name, criterion, column, 1)
    check(consumer(name, criterion, column, 3) == text, f"{criterion} in {name}: any number of threads")
    said = dict(line.split(" ", 1) for line in text.splitlines())
    check(said["rays"] == f"{told['rays']['matched']} of {told['rays']['total']}", f"{criterion} in {name}: {said['rays']}")
    check(int(said["rows"]) == len(values) and np.isclose(float(said["sum"]), values.sum(), rtol=1e-12), f"{column} of {name}")
    flux, unit = said["flux"].split()
    check(np.isclose(float(flux), told["flux"]["matched"], rtol=1e-8) and unit == told["flux"]["unit"], f"flux of {criterion} in {name}: {said['flux']}")
    lens = raymap.open(name)
    check(re.findall("^object (.*)$", text, re.M) == list(lens.names["object"]), f"names in {name}")
    check(said["unit"] == f"{lens.unit} {lens.unit_m:g}", f"unit of {name}")
    check(said["refused"].startswith("criterion:1:"), f"a mistake in a criterion: {said['refused']}")


def alone(name, criterion):
    """Each column by itself is what it is among all of them."""
    handle = library.Handle(name)
    for where in (None, criterion):
        whole = [block.columns for block in handle.blocks(library.TABLES[:3], where)]
        check(sum(len(columns["ray/id"]) for columns in whole) == raymap.query(name, where or "all")["rays"]["matched"], "rays")
        for column in whole[0]:
            check(handle.whole([column], where)[column].tobytes() == b"".join(want[column].tobytes() for want in whole),
                  f"{column} of {name} alone, {where}")


def failures(lens):
    check("no-such.raymap" in consumer("no-such.raymap", "all", "ray/id", 1, status=1), "no such map")
    check("did you mean 'ray/id'" in consumer(lens, "all", "ray/ib", 1, status=1), "no such column")
    check("did you mean" in consumer(lens, "hit(lens.33)", "ray/id", 1, status=1), "no such object")


def missing_piece():
    """A map whose run has ended, and of whose files one has gone."""
    trace("double-gauss", "torn.raymap", 20000, "--piece-size", "16Ki")
    pieces = sorted(pathlib.Path("torn.raymap").glob("shard-*/piece-?????.h5"))
    told = library._library().raymap_trouble  # pylint: disable=protected-access
    told.restype, told.argtypes = ctypes.c_char_p, [ctypes.c_void_p, ctypes.c_size_t]
    whole = library.Handle("torn.raymap")
    check(len(pieces) > 1 and told(whole.pointer, 0) is None, "no trouble")
    pieces[0].unlink()
    torn = library.Handle("torn.raymap")
    said = [told(torn.pointer, i) for i in (0, 1)]
    check(pieces[0].name in (said[0] or b"").decode() and said[1] is None, f"a missing piece: {said}")


def shows_what_it_promises():
    told = subprocess.run(["nm", "-D", "--defined-only", LIBRARY], capture_output=True, text=True, check=True).stdout
    shown = set(re.findall(r" T (\S+)", told))
    check(shown == {f"raymap_{name}@@RAYMAP_1" for name in SYMBOLS}, f"symbols: {shown}")
    linked = subprocess.run(["ldd", LIBRARY], capture_output=True, text=True, check=True).stdout
    check("libhdf5" in linked and not re.search(r"libmpi|libembree", linked), f"linked: {linked}")
    lines = ["#include <raymap.h>"]
    for name, (nbytes, members) in LAYOUT.items():
        lines.append(f"_Static_assert(sizeof(struct {name}) == {nbytes}, \"{name}\");")
        lines += [f"_Static_assert(offsetof(struct {name}, {member}) == {at}, \"{name}.{member}\");" for member, at in members.items()]
    for values in VALUES.split(","):
        lines += [f"_Static_assert(RAYMAP_{word} == {k}, \"{word}\");" for k, word in enumerate(values.split())]
    pathlib.Path("layout.c").write_text("\n".join(lines) + "\n", encoding="utf-8")
    compiled("cc", "-std=c17", "-Wall", "-Werror", "-c", "-I", SOURCE / "analysis/library", "layout.c")


def example_of_the_page():
    """docs/library.md compiles without a warning, and gives the points that the program does."""
    page = (SOURCE / "docs/library.md").read_text(encoding="utf-8")
    pathlib.Path("example.c").write_text(re.search("```c\n(.*?)```", page, re.S)[1], encoding="utf-8")
    compiled("cc", "-std=c17", "-Wall", "-Wextra", "-Werror", "-I", SOURCE / "analysis/library", "example.c", "-o", "example", LIBRARY,
             f"-Wl,-rpath,{BUILD}")
    said = subprocess.run("./example", capture_output=True, text=True, check=True).stdout.split()
    told = raymap.table("lens.raymap", "registration", "x", "y", where="hit(lens.*, reflect) >= 2 and registered(sensor)")
    check(len(said) > 10 and np.allclose(np.array(said, float), np.column_stack([told["x"], told["y"]]).ravel(), rtol=1e-5), "the example")


def leaves_hdf5_alone(lens):
    """Who prints HDF5's errors, here and after a map that cannot be opened."""
    hdf5 = next(re.search(r"\S*libhdf5\S*", line)[0] for line in open("/proc/self/maps", encoding="utf-8") if "libhdf5_serial.so" in line)
    hdf5 = ctypes.CDLL(hdf5)
    printing = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int64, ctypes.c_void_p)(lambda stack, data: 0)
    def printer():
        found, data = ctypes.c_void_p(), ctypes.c_void_p()
        hdf5.H5Eget_auto2(ctypes.c_int64(0), ctypes.byref(found), ctypes.byref(data))
        return found.value
    before = printer()
    hdf5.H5Eset_auto2(ctypes.c_int64(0), printing, None)
    mine = printer()
    check(mine == ctypes.cast(printing, ctypes.c_void_p).value, "a host's printing")
    os.makedirs("bad.raymap", exist_ok=True)
    pathlib.Path("bad.raymap/map.h5").write_bytes(b"no map" * 100)
    try:
        library.Handle("bad.raymap")
        check(False, "a map of no bytes")
    except raymap.MapError as error:
        check("bad.raymap" in str(error), f"it is named: {error}")
    check(library.Handle(lens).rows("ray") == 9000 and printer() == mine, "the host's printing afterwards")
    hdf5.H5Eset_auto2(ctypes.c_int64(0), ctypes.c_void_p(before), None)


def beside_h5py(lens):
    """Others of the process have files of the map open, in any of HDF5's ways to close them, or open them meanwhile."""
    access, counted = h5py.h5p.create(h5py.h5p.FILE_ACCESS), []
    for degree in (h5py.h5f.CLOSE_DEFAULT, h5py.h5f.CLOSE_WEAK, h5py.h5f.CLOSE_SEMI, h5py.h5f.CLOSE_STRONG):
        access.set_fclose_degree(degree)
        file = h5py.h5f.open(os.path.join(lens, "map.h5").encode(), h5py.h5f.ACC_RDONLY, access)
        check(library.Handle(lens).rows("ray") == 9000, f"a map that is open otherwise: {degree}")
        file.close()

    def reads():
        for _ in range(5):
            with raymap.open(lens) as own:
                counted.append(len(raymap.records(own, "ray", "id")["id"]))

    threads = [threading.Thread(target=reads) for _ in range(4)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    check(counted == [9000] * 20, f"in threads: {counted}")


def many_blocks():
    trace("double-gauss", "part.raymap", 100000)
    whole = raymap.open("part.raymap")
    seen = np.concatenate([portion["ray/id"] for portion in whole.portions(["ray/id"])])
    check(np.array_equal(seen, np.arange(100000)), "many blocks in their order")
    few = raymap.records(whole, "ray", "flux", where="registered(sensor)")
    told = raymap.query("part.raymap", "registered(sensor)")
    check(whole.complete and np.isclose(few["flux"].sum(), told["flux"]["matched"], rtol=1e-9), "flux of those that match")
    check([whole.ray(number)["id"] for number in (99999, 0, 50000)] == [99999, 0, 50000], "rays here and there")
    find, block = library._library().raymap_find_ray, ctypes.c_size_t(2 ** 64 - 1)  # pylint: disable=protected-access
    check(find(whole.handle.pointer, 50000, block) == 1 and block.value < whole.handle.n_blocks, "from behind the last block")


def killed_run():
    """What a run has committed is read, in Python as by the program, once the run is dead."""
    shutil.rmtree("killed.raymap", ignore_errors=True)
    with subprocess.Popen([os.environ["RAYMAP"], "trace", SOURCE / "examples/double-gauss/scene.yaml", "-o", "killed.raymap", "-n", "100M",
                           "--flush", "0.2", "--threads", "1", "--piece-size", "64Gi", "--quiet"]) as writer:
        rays = 0
        for _ in range(300):
            told = subprocess.run([os.environ["RAYMAP"], "info", "killed.raymap", "--json"], capture_output=True, text=True, check=False)
            rays = json.loads(told.stdout)["rays"] if told.returncode == 0 else 0
            if rays > 0:
                break
            time.sleep(0.1)
        writer.kill()
    part, told = raymap.open("killed.raymap"), raymap.query("killed.raymap", "source(star)")
    check(0 < rays <= part.n_rays == told["rays"]["total"] and not part.complete, f"rays of a killed run: {rays}, {part.n_rays}")
    seen = raymap.records(part, "ray", "id", "source_name")
    check(len(np.unique(seen["id"])) == part.n_rays and (seen["source_name"] == "star").sum() == told["rays"]["matched"], "its columns")
    check(len(raymap.records(part, "ray", "id", where="source(star)")["id"]) == told["rays"]["matched"], "its rays that match")


compiled("g++", "-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-pthread", "-I", SOURCE / "analysis/library",
         SOURCE / "tests/cli/library_consumer.cpp", "-o", "consumer", LIBRARY, f"-Wl,-rpath,{BUILD}")
LENS = trace("double-gauss", "lens.raymap", 9000)
answers(LENS, "registered(sensor)", "registration/time")
answers(LENS, "hit(lens.*, reflect) >= 2", "segment/object")
answers(LENS, "bounces > 1000", "segment/flux")
answers(LENS, "all", "segment/length")
answers(trace("room", "room.raymap", 600, "--encoding", "plain"), "bounces >= 3", "segment/angle_of_incidence")
answers(trace("selfoc", "rod.raymap", 5000), "ended(absorbed)", "ray/path_length")
alone(LENS, "hit(lens.*, reflect) >= 2")
alone("room.raymap", "bounces >= 3")
alone("rod.raymap", "ended(absorbed)")
failures(LENS)
missing_piece()
shows_what_it_promises()
example_of_the_page()
leaves_hdf5_alone(LENS)
beside_h5py(LENS)
many_blocks()
killed_run()
finish()
