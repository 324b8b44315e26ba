#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: in maps with arrival times light is where it says it is: at the end of every step (pages; with fluorescence, in
graded media), in films picture by picture, at receivers laid over the map, and in the mean time of each class of paths."""
import base64
import glob
import json
import os
import re
import struct
import shutil
import sys
import zlib

import h5py
import numpy as np

sys.dont_write_bytecode = True
from asking import check, finish, run, trace  # noqa: E402

C = 299.792458  # mm/ns
TYPES = {"f32": "<f4", "f64": "<f8", "u8": "u1", "u16": "<u2", "i32": "<i4", "u64": "<u8"}


def unpack(packed):
    values = np.frombuffer(base64.b64decode(packed["d"]), TYPES[packed["t"]])
    return values.astype(np.int64) + packed["o"] if "o" in packed else values


def page_of(name):
    """The data of a page with all rays of a map."""
    run("draw", name, "-o", "page.html", "--limit", 5000, "--force")
    with open("page.html", encoding="utf-8") as file:
        return json.loads(re.search(r'<script[^>]*id="data"[^>]*>(.*?)</script>', file.read(), re.S).group(1))


def column(name, path):
    pieces = sorted(glob.glob(f"{name}/shard-*/piece-*.h5"))
    parts = []
    for piece in pieces:
        with h5py.File(piece) as file:
            parts.append(file[path][()])
    return np.concatenate(parts)


def check_steps(example, n):
    """Sums over the steps come to the times that the tracer stored; light rests where it fluoresces alone."""
    name = trace(example, f"{example}.raymap", n, "--time", "on", "--encoding", "plain")
    page = page_of(name)
    begin, end = (unpack(page["times"][key]) for key in ("begin", "end"))
    legs = column(name, "ray/segment_count").astype(int)
    first = np.concatenate([[0], np.cumsum(legs)])
    event = unpack(page["rays"]["leg"]["event"])
    bit = {word: 1 << k for k, word in enumerate(page["rays"]["words"]["event"])}
    stored = column(name, "ray/delay") + column(name, "ray/group_path") / C
    check(len(stored) == n and len(end) == legs.sum(), f"{example}: rays of the page")
    off = np.abs(end[first[1:] - 1] - stored)
    check(off.max() < 2e-6 * stored.max(), f"{example}: rays end at their times: {off.max()} ns of {stored.max()}")
    inside = np.ones(len(end), bool)
    inside[first[1:] - 1] = False
    rest = (begin[1:] - end[:-1])[inside[:-1]]
    glows = (event[:-1] & bit["fluoresce"] != 0)[inside[:-1]]
    check((rest[~glows] == 0).all() and (rest[glows] > 0).all(), f"{example}: light rests where it fluoresces")
    leg = column(name, "registration/segment") + np.repeat(first[:-1], column(name, "ray/registration_count"))
    time = column(name, "registration/delay") + column(name, "registration/group_path") / C
    slack = 2e-6 * time.max()
    check(((time > begin[leg] - slack) & ((time < end[leg] + slack) | (event[leg] & bit["left"] != 0))).all(),
          f"{example}: what is registered is so on its way")
    return glows.sum()


def check_receivers():
    """A receiver where a detector lies registers the same times, whenever the light waited."""
    with open("receivers.yaml", "w", encoding="utf-8") as file:
        file.write("detectors:\n  - {name: again, type: plane, on: cell, size: [100, 3], cells: [50, 1], side: both}\n"
                   "  - {name: middle, type: plane, at: [0, 0, 0], size: [100, 100], cells: [1, 1], side: both}\n")
    asked = [json.loads(run("stats", "concentrator.raymap", "--of", f"time({name})", "--receivers", "receivers.yaml", "--json"))
             for name in ("electrons", "again", "middle")]
    mean = [one["mean"]["value"] for one in asked]
    check(abs(mean[0] - mean[1]) < 1e-6 * mean[0], f"means {mean} of one place")
    check(0 < mean[2] < mean[0], f"half way to the cell: {mean}")


def check_classes():
    words = ["paths", "concentrator.raymap", "--detector", "electrons", "--by", "object", "--collapse", "--top", 6]
    alone = run(*words, "--json")
    check(alone == run(*words, "--json", ranks=3), "mean times on three ranks")
    rows = json.loads(alone)["classes"]
    for row in rows[:4]:
        told = json.loads(run("stats", "concentrator.raymap", "--of", "time(electrons)", "--where", row["criterion"], "--json"))
        mean = told["mean"]["value"]
        check(abs(row["mean_time"] - 1e9 * mean) < 1e-5 * row["mean_time"], f"{row['sequence']}: {row['mean_time']} ns, by stats {mean}")
    check(len({round(row["mean_time"], 3) for row in rows}) > 3, "classes differ in time")
    check("mean ns" in run(*words), "the table has mean times")
    run(*words, "-o", "paths.csv")
    with open("paths.csv", encoding="utf-8") as file:
        table = [line.rstrip("\n") for line in file if not line.startswith("#")]
    check(table[0].endswith(",mean_time_ns") and float(table[1].rsplit(",", 1)[1]) == rows[0]["mean_time"], "CSV has mean times")
    ends = json.loads(run("paths", "concentrator.raymap", "--by", "object", "--where", "ended(absorbed)", "--top", 1, "--json"))["classes"][0]
    told = column("concentrator.raymap", "ray/delay") + column("concentrator.raymap", "ray/group_path") / C
    picked = json.loads(run("query", "concentrator.raymap", ends["criterion"], "--json", "--limit", 5000))
    mean = np.mean([told[one["ray"]] for one in picked])
    check(abs(ends["mean_time"] - mean) < 1e-5 * mean, f"without a detector the rays' ends: {ends['mean_time']}, not {mean}")


SCENE = """raymap: 1
units: mm
spectrum: {wavelengths: [500]}
media: {air: {index: 1}, glass: {index: 1.5}}
surfaces: {clear: {type: fresnel, coat: ideal}}
geometries: {face: {type: rectangle, size: [20, 20]}}
objects:
  - {name: front, geometry: face, at: [0, 0, 20], surface: clear, front: glass, back: air}
  - {name: rear, geometry: face, at: [0, 0, 50], surface: clear, front: air, back: glass}
  - {name: end, geometry: face, at: [0, 0, 80], surface: absorber, front: air, back: air}
sources:
  - {name: s, type: rays, flux: 1 W, medium: air, rays: [{origin: [0, 1, 0], direction: [0, 0, 1], wavelength: 500}]}
detectors:
  - {name: gate, type: plane, at: [0, 0, 65], size: [20, 20], cells: [4, 4]}
"""


def drawn(path):
    """From where to where a picture's rays run, to the right in pixels; and its dots."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    inside = re.search(r"<g clip-path.*?</g>", text, re.S).group(0)
    runs = [[float(x) for x in re.findall(r"[ML](-?[\d.]+) ", d)] for d, style in re.findall(r'<path d="([^"]+)"([^>]*)>', inside)
            if 'stroke-width="0.9"' in style]
    return runs, re.findall(r"<circle", inside), re.search(r"registered by then: (\d+)", text)


def check_film():
    with open("scene.yaml", "w", encoding="utf-8") as file:
        file.write(SCENE)
    run("trace", "scene.yaml", "-o", "light.raymap", "-n", 8, "--time", "on", "--quiet")
    run("draw", "light.raymap", "--view", "yz", "--limit", 1, "-o", "whole.svg")
    whole = [x for runs in drawn("whole.svg")[0] for x in runs]
    scale = (max(whole) - min(whole)) / 80
    run("draw", "light.raymap", "--view", "yz", "--limit", 1, "--time", "0:340:20 ps", "-o", "film.svg")

    def reached(time):  # z after ns
        left, z = time * C, 0
        for length, index in ((20, 1), (30, 1.5), (30, 1)):
            part = min(left, length * index)
            z, left = z + part / index, left - part
        return z

    check(len(glob.glob("film-*.svg")) == 17, "17 pictures")
    for k in range(17):
        runs, dots, count = drawn(f"film-{k + 1:04d}.svg")
        want = [reached(0.02 * k), reached(0.02 * (k + 1))]
        got = [(x - min(whole)) / scale for r in runs for x in r]
        if want[1] - want[0] < 1e-9:
            check(not got, f"picture {k + 1}: the light has arrived")
        else:
            check(got and abs(min(got) - want[0]) < 0.02 and abs(max(got) - want[1]) < 0.02, f"picture {k + 1}: from {want}, drawn {got}")
        here = 0.02 * (k + 1) * C >= 80  # optical path up to the gate
        check(int(count.group(1)) == here and len(dots) == here, f"picture {k + 1}: registered {count.group(1)}, {len(dots)} dots")


def chunks(path):
    with open(path, "rb") as file:
        data = file.read()
    check(data[:8] == b"\x89PNG\r\n\x1a\n", f"{path} is PNG")
    at, found = 8, []
    while at < len(data):
        n, name = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + n]
        check(struct.unpack(">I", data[at + 8 + n:at + 12 + n])[0] == zlib.crc32(name + body), f"{path}: checksum of {name}")
        found.append((name, body))
        at += 12 + n
    return found


def check_animation():
    words = ["draw", "light.raymap", "--view", "yz", "--limit", 1, "--time", "0:0.06:0.02"]
    run(*words, "-o", "film.apng")
    run(*words, "-o", "still.png")
    film = chunks("film.apng")
    check([name for name, _ in film[:3]] == [b"IHDR", b"acTL", b"fcTL"] and film[-1] == (b"IEND", b""), f"{[n for n, _ in film]}")
    check(struct.unpack(">II", film[1][1]) == (3, 0), "three pictures, played for ever")
    numbers = [struct.unpack(">I", body[:4])[0] for name, body in film if name in (b"fcTL", b"fdAT")]
    check(numbers == list(range(len(numbers))), f"numbers {numbers}")
    pictures = []
    for name, body in film:
        if name == b"fcTL":
            check(body[4:12] == film[0][1][:8] and struct.unpack(">HH", body[20:24]) == (1, 12), "each is the whole picture, 12 a second")
            pictures.append(b"")
        elif name in (b"IDAT", b"fdAT"):
            pictures[-1] += body[4 * (name == b"fdAT"):]
    for k, picture in enumerate(pictures):
        still = b"".join(body for name, body in chunks(f"still-{k + 1:04d}.png") if name == b"IDAT")
        check(zlib.decompress(picture) == zlib.decompress(still), f"picture {k + 1} is that of its own file")
    check("exists" in run(*words, "-o", "still.png", status=2), "numbered pictures are not overwritten")
    told = json.loads(run(*words, "-o", "still.png", "--force", "--json"))
    check(told["pictures"] == 3, f"{told}")
    for time in ("1:1:1", "0:1", "0:1:0", "a:1:2", "0:1:0.1 W"):
        check("FROM:TO:STEP" in run(*words[:-1], time, "-o", "x.png", status=2), time)
    check("at most 9999" in run(*words[:-1], "0:1:1e-6", "-o", "x.png", status=2), "too many pictures")
    run(*words, "-o", "x.html", status=2)
    run("trace", "scene.yaml", "-o", "untimed.raymap", "-n", 8, "--quiet")
    check("time: on" in run("draw", "untimed.raymap", *words[2:], "-o", "x.png", status=2), "no times, no film")


for left in glob.glob("*"):
    (shutil.rmtree if os.path.isdir(left) else os.remove)(left)
check(check_steps("concentrator", 3000) > 300, "rays that fluoresce")
check_steps("selfoc", 800)
check_receivers()
check_classes()
check_film()
check_animation()
gated = [json.loads(run("detector", "concentrator.raymap", "electrons", "--where", f"registered(electrons where time in {gate})", "--json"))["registrations"]
         for gate in ("0..5 ns", "5..10 ns", "10..1000 ns")]
check(sum(gated) == json.loads(run("detector", "concentrator.raymap", "electrons", "--json"))["registrations"] and min(gated) > 10, f"gates {gated}")
finish()
