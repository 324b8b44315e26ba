# SPDX-License-Identifier: MIT
#
# evaluator_page.py MAP ALL SOME NONE TEN: reads the data out of pages and compares them with the
# map's columns.
import base64
import html.parser
import json
import os
import re
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.environ["SOURCE_DIR"], "examples", "python"))
import h5py  # noqa: E402

failures = 0


def check(holds, what):
    global failures
    if not holds:
        print("FAILED:", what)
        failures += 1


class Page(html.parser.HTMLParser):
    """What a browser's parser makes of the page: its tags, and the text of its scripts."""

    def __init__(self, path):
        super().__init__()
        self.tags, self.scripts, self.inside = [], [], False
        with open(path, encoding="utf-8") as file:
            self.text = file.read()
        self.feed(self.text)
        self.data = json.loads(self.scripts[0])

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        self.inside = tag == "script"
        if self.inside:
            self.scripts.append("")

    def handle_endtag(self, tag):
        self.inside = False

    def handle_data(self, text):
        if self.inside:
            self.scripts[-1] += text


TYPES = {"f32": "<f4", "f64": "<f8", "u8": "u1", "u16": "<u2", "i32": "<i4", "u64": "<u8"}


def unpack(column):
    values = np.frombuffer(base64.b64decode(column["d"], validate=True), TYPES[column["t"]])
    return values.astype(np.int64) + column["o"] if "o" in column else values


def stored(name, width=1):
    """A column of the whole map, in the order of its pieces."""
    parts = []
    for folder, _, files in sorted(os.walk(sys.argv[1])):
        for file in sorted(files):
            if file.startswith("piece-"):
                with h5py.File(os.path.join(folder, file), "r") as piece:
                    parts.append(piece[name][:].reshape(-1, width))
    return np.concatenate(parts)


everything, some, none, ten = (Page(path) for path in sys.argv[2:6])

# Every ray has its own columns, bit for bit.
ray, leg = everything.data["rays"]["ray"], everything.data["rays"]["leg"]
order = np.argsort(stored("ray/id")[:, 0])[:2000]
counts = stored("ray/segment_count")[:, 0].astype(np.int64)
first = np.concatenate([[0], np.cumsum(counts)])
rows = np.concatenate([np.arange(first[r], first[r + 1]) for r in order])
check(np.array_equal(unpack(ray["id"]), np.arange(2000)), "ids are the smallest")
for name, of in (("legs", "segment_count"), ("source", "source"), ("stop", "stop"), ("registrations", "registration_count")):
    check(np.array_equal(unpack(ray[name]), stored("ray/" + of)[order, 0]), f"/ray/{of} comes back")
for name in ("path_length", "optical_path", "wavelength"):
    check(np.array_equal(unpack(ray[name]), stored("ray/" + name)[order, 0], equal_nan=True), f"/ray/{name} comes back")
for name in ("object", "event", "medium", "primitive"):
    check(np.array_equal(unpack(leg[name]), stored("segment/" + name)[rows, 0]), f"/segment/{name} comes back")
check(np.array_equal(unpack(leg["position"]), stored("segment/position", 3)[rows].ravel()), "positions come back")

# Classes: those of `paths`, with the rays of the page that are theirs.
def check_classes(page, told, level):
    classes = page.data["classes"]
    with open(told, encoding="utf-8") as file:
        want = json.load(file)
    check(classes["by"] == level and classes["count"] == len(want["classes"]) + want["remainder"]["classes"], "all classes are counted")
    check(len(classes["list"]) == len(want["classes"]) > 5, f"{len(classes['list'])} classes")
    for one, row in zip(classes["list"], want["classes"]):
        for name in ("criterion", "rays", "flux", "share", "standard_error", "first_ray"):
            check(one[name] == row[name], f"{name} of {one['sequence']}: {one[name]}, paths says {row[name]}")
    of = unpack(classes["of"]).astype(int)
    check(np.array_equal(np.bincount(of[of >= 0], minlength=len(classes["list"])), [one["here"] for one in classes["list"]]), "rays of classes")
    ids = unpack(page.data["rays"]["ray"]["id"])
    for k in np.unique(of[of >= 0]):
        first = classes["list"][k]["first_ray"]
        check(first == ids[of == k].min() or first < ids.min(), f"the first ray of class {k} is of it")


check_classes(everything, "paths.json", "surface")
check_classes(some, "paths_some.json", "object")

# Criteria: what each ray of the page matches.
where = some.data["where"]
check(some.data["color"] == "criterion" and everything.data["color"] == "natural", "first colours")
check([one["criterion"] for one in where["list"]] == ["hit(lens.2, reflect_specular)", "segments in 4..5"], "criteria of the page")
bits, legs = unpack(where["match"]).astype(int), unpack(some.data["rays"]["ray"]["legs"])
check(np.array_equal(bits & 2, np.where((legs >= 4) & (legs <= 5), 2, 0)) and np.all(bits > 0) and np.any(bits == 3), "which rays match what")
check(where["list"][1]["here"] == ((legs >= 4) & (legs <= 5)).sum(), "rays that match a criterion")
check(everything.data["where"]["list"] == [], "no criteria, no switches")

# What matches, and the detector's image of all that does.
with open("count.json", encoding="utf-8") as file:
    count = json.load(file)
check(some.data["matched"] == count["rays"]["matched"], "the number of matching rays")
check(abs(some.data["flux_matched"] / count["flux"]["matched"] - 1) < 1e-12, "the flux of matching rays")
image = everything.data["detectors"]["list"][0]["image"]
check(image["registrations"] == int(stored("registration/registered").sum()), "registrations of the detector")
with open("detector.json", encoding="utf-8") as file:
    told = json.load(file)
check(image["flux"] == told["flux"]["total"] and image["flux_error"] == told["flux"]["standard_error"] > 0,
      f"flux of the detector: {image['flux']} +- {image['flux_error']}, not {told['flux']}")
value = unpack(image["value"])
check(value.max() == np.float32(image["most"]) and len(value) == image["n"][0] * image["n"][1], "values of the image")
check(len(unpack(none.data["rays"]["ray"]["id"])) == 0 and none.data["classes"]["list"] == [], "an empty page")
check(ten.data["view"]["toward"] == [-1, 0, 0], "--view yz")

for page in (everything, some, none, ten):
    check(page.data["detectors"]["list"][0]["name"] == "</script><b>\u00fc \\u003c-->", "an odd name")
    check(all(tag != "b" for tag, _ in page.tags) and len(page.scripts) == 3, "names make no tags")
    outside = [a for _, a in page.tags if re.match(r"(https?:)?//", a.get("src") or a.get("href") or "")]
    check(not outside and not any(tag in ("link", "img", "iframe") for tag, _ in page.tags), f"asks for {outside}")
    check("Permission is hereby granted, free of charge" in page.text, "three.js's licence is in the page")
check(os.path.getsize(sys.argv[3]) < 1.5e6, "a small page is small")
sys.exit(1 if failures else 0)
