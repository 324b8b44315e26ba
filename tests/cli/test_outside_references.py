#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""HDF5 files may refer to other files: by external and soft links, external storage, virtual datasets. None is
opened because a map names it; here each is a pipe that nobody writes to, so that opening it would not end."""
import os
import pathlib
import shutil
import signal
import subprocess
import sys

from asking import SOURCE # which knows where the package is
import h5py
import raymap
import sealed_map

PROGRAM = os.environ["RAYMAP"]
TIMES = 4 if int(os.environ.get("RAYMAP_TEST_SCALE", "1")) > 1 else 1
failures = refused = 0


def expect(what, status, *words):
    """Either of several statuses, where what refers to others may be nothing that the program reads."""
    global failures, refused
    try:
        done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=30,
                              check=False)
        code, said = done.returncode, done.stdout.decode()[-600:]
    except subprocess.TimeoutExpired:
        code, said = None, "it waits for the pipe"
    refused += code == 4
    if code not in status:
        failures += 1
        print(f"FAIL {what}: {words[0]} {words[1]}: {code}, not of {status}\n{said}")


def read(what, status):
    """The same of the Python package, in a process that an alarm would end."""
    global failures
    child = os.fork()
    if child == 0:
        signal.alarm(30)
        try:
            for portion in raymap.open("m.raymap").portions():
                _ = portion["segment/position"]
        except Exception: # whatever it says
            os._exit(1)
        os._exit(0)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if code not in status:
        failures += 1
        print(f"FAIL {what}: the package: {code}, not of {status}")


def forge(path, name, kind):
    def change(file):
        if kind in ("external", "soft"):
            del file[name]
            file[name] = h5py.ExternalLink("pipe", name) if kind == "external" else h5py.SoftLink("/elsewhere")
            return
        old = file[name]
        attributes, shape, dtype = dict(old.attrs), old.shape, old.dtype
        del file[name]
        if kind == "storage":
            new = file.create_dataset(name, shape, dtype, external=[("pipe", 0, h5py.h5f.UNLIMITED)])
        else:
            layout = h5py.VirtualLayout(shape, dtype)
            layout[...] = h5py.VirtualSource("pipe", name, shape)
            new = file.create_virtual_dataset(name, layout)
        for key, value in attributes.items():
            new.attrs[key] = value
    sealed_map.edit(path, change)


def places(path):
    """Datasets that a program reads: those that carry a checksum; and groups."""
    found = []
    with h5py.File(path, "r") as file:
        file.visititems(lambda name, item: found.append((name, isinstance(item, h5py.Dataset)))
                        if isinstance(item, h5py.Group) or ("checksum" in item.attrs and item.size) else None)
    return found


def fresh():
    shutil.rmtree("m.raymap", ignore_errors=True)
    shutil.copytree("whole.raymap", "m.raymap")


def main():
    shutil.rmtree("whole.raymap", ignore_errors=True)
    for pipe in ("pipe", "pipe.h5"):
        pathlib.Path(pipe).unlink(missing_ok=True)
    subprocess.run([PROGRAM, "trace", SOURCE / "examples/double-gauss/scene.yaml", "-o", "whole.raymap", "-n", "300",
                    "--encoding", "plain", "--quiet"], check=True)
    fresh()
    read("nothing elsewhere", (0,))
    os.mkfifo("pipe")
    index, piece = "m.raymap/map.h5", "m.raymap/shard-00000/piece-00000.h5"
    found = places("whole.raymap/map.h5")
    if len(found) < 30:
        sys.exit(f"FAIL: only {len(found)} places in map.h5")
    for at, (name, is_dataset) in enumerate(found):
        for kind in ("external", "soft", "storage", "virtual") if is_dataset else ("external", "soft"):
            if at % ({"external": 8, "storage": 16, "soft": 32, "virtual": 32}[kind] // TIMES):
                continue
            fresh()
            os.symlink("../pipe", "m.raymap/pipe")
            forge(index, name, kind)
            expect(f"{kind} {name}", (4,) if kind in ("external", "soft") else (0, 4), PROGRAM, "info",
                   "m.raymap")
            if at % 32 == 0:
                read(f"{kind} {name}", (1,))
    for kind in ("external", "storage", "virtual"):
        fresh()
        os.symlink("../../pipe", "m.raymap/shard-00000/pipe")
        forge(piece, "segment/position", kind)
        expect(f"{kind} in a piece", (4,), PROGRAM, "verify", "m.raymap")
        read(f"{kind} in a piece", (0, 1))  # the library finds rows by their places in the file
    if refused < TIMES * len(found) // 8 + 5:
        sys.exit(f"FAIL: only {refused} of {len(found)} places and more were refused")
    sys.exit(failures != 0)


main()
