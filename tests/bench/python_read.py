#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How fast Python has the columns of a map, in turns with the library alone: python_read.py MAP [ROUNDS]

Both on all cores that the process may use, from the opening on. The library alone decodes the same blocks for nobody. Millions of
the map's segments a second by the clock and by processor time, and the ratio of the latter: medians. A frame needs pandas.
"""
import os
import pathlib
import statistics
import sys
import time
from concurrent.futures import ThreadPoolExecutor

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples/python"))
import raymap  # noqa: E402
from raymap import library  # noqa: E402

try:
    import pandas
except ImportError:
    pandas = None

PLACE, SEEN = ["segment/position"], ["registration"]
WAYS = (
    ('columns("segment/position")', PLACE, lambda lens: lens.columns(*PLACE)),
    ('columns("segment/object", "segment/event")', ["segment/object", "segment/event"],
     lambda lens: lens.columns("segment/object", "segment/event")),
    ('records("segment", "object_name", "flux")', ["segment/object", "segment/flux"],
     lambda lens: raymap.records(lens, "segment", "object_name", "flux")),
    ('records("registration", "x", "y", "flux")', ["registration/x", "registration/y", "registration/flux"],
     lambda lens: raymap.records(lens, "registration", "x", "y", "flux")),
    ('records("registration")', SEEN, lambda lens: raymap.records(lens, "registration")),
    ('frame("registration")', SEEN, pandas and (lambda lens: raymap.frame(lens, "registration"))),
)


def alone(lens, columns):
    n_thread = len(os.sched_getaffinity(0))

    def read(first):
        reader = library.Reader(lens.handle, columns)
        for block in range(first, lens.n_portions, n_thread):
            library._library().raymap_read(reader.pointer, block, None, None)  # pylint: disable=protected-access

    with ThreadPoolExecutor(n_thread) as threads:
        list(threads.map(read, range(n_thread)))


def taken(path, way):
    """Million segments a second: by the clock, by processor time."""
    began = time.perf_counter(), time.process_time()
    lens = raymap.open(path)
    kept = way(lens)
    ended = time.perf_counter(), time.process_time()
    del kept
    return [lens.n_segments / (end - begin) / 1e6 for begin, end in zip(began, ended)]


def main(path, rounds="5"):
    lens = raymap.open(path)
    print(f"{path}: {lens.n_segments / 1e6:.1f} million segments, {lens.n_registrations / 1e6:.1f} million registrations; "
          f"{len(os.sched_getaffinity(0))} threads\n{'':44}{'Python':>18}{'library alone':>18}{'ratio':>9}\n" + " " * 44 + 2 * f"{'clock':>9}{'proc.':>9}")
    for name, columns, way in WAYS:
        if way is None:
            continue
        seen = [taken(path, way) + taken(path, lambda lens, columns=columns: alone(lens, columns)) for _ in range(int(rounds))]
        print(f"{name:44}" + "".join(f"{statistics.median(one):9.1f}" for one in zip(*seen)) +
              f"{statistics.median(one[1] / one[3] for one in seen):9.2f}", flush=True)


main(*sys.argv[1:])
