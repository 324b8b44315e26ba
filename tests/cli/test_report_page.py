#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `report MAP --html` is one well-formed page that needs nothing but itself, shows what
info and report --energy tell, and is there for every map, also an empty or unfinished one."""
import html.parser
import json
import os
import re
import shutil
import subprocess

PROGRAM = os.environ["RAYMAP"]
SOURCE = os.environ["SOURCE_DIR"]
VOID = {"meta", "br", "img", "hr", "input", "link"}
SCENE = """\
raymap: 1
units: mm
media:
  air: {index: 1}
  'glass & <b>': {glass: N-BK7}
surfaces:
  clear: {type: fresnel}
  white: {type: lambert, reflectance: 0.5}
geometries:
  globe: {type: sphere, radius: 10}
  wall: {type: rectangle, size: [60, 60]}
objects:
  - {name: '<script>alert(1)</script>', geometry: globe, at: [0, 0, 20], surface: clear, inside: 'glass & <b>', outside: air}
  - {name: screen, geometry: wall, at: [0, 0, 60], surface: white, front: air, back: air}
sources:
  - {name: 'lamp & co', type: point, at: [0, 0, 0], direction: [0, 0, 1], distribution: {cone: 30}, flux: 2 lm, medium: air}
detectors:
  - {name: 'eye <1>', type: plane, on: screen, size: [60, 60], cells: [10, 10], at: [0, 0, 60], direction: [0, 0, -1]}
  - {name: far, type: intensity, cells: [18, 36]}
spectrum: {mode: rgb}
limits: {steps: 3}
"""


class Page(html.parser.HTMLParser):
    """Checks nesting, ids and links; keeps the text, the tables and the tags."""

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.links, self.tags = [], [], [], []
        self.text, self.rows = "", []
        self.feed(text)
        self.close()
        assert not self.open, self.open
        assert len(self.ids) == len(set(self.ids)), "an id stands twice"
        for link in self.links:
            if link.startswith("#"):
                assert link[1:] in self.ids, link
            else:
                assert link.startswith("data:image/png;base64,"), link[:80]

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        for name, value in attrs:
            if name == "id":
                self.ids.append(value)
            elif name in ("href", "src", "xlink:href"):
                self.links.append(value)
            elif value and "url(" in value:
                self.links += re.findall(r"url\(([^)]*)\)", value)
            assert not name.startswith("on"), name
        if tag not in VOID:
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.handle_endtag(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, (tag, self.getpos())

    def handle_data(self, data):
        self.text += data
        if self.open and set(self.open) & {"td", "th"}:
            self.rows[-1][-1] += data


def run(*arguments, status=0):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, timeout=300,
                          check=False)
    assert done.returncode == status, (arguments, done.returncode, done.stderr)
    return done.stdout if status == 0 else done.stderr


def page_of(path, in_every_way):
    """The page, the same in every way of asking for it."""
    told = run("report", path, "--html")
    if in_every_way:
        ask_again(path, told)
    text = told.decode()
    assert text.startswith("<!DOCTYPE html>") and "<?xml" not in text
    assert not re.search(r"<(script|link|iframe|object|embed|form)\b", text)
    assert not re.search(r"@import|https?://(?!www\.w3\.org)", text.split("<pre>")[0])
    return Page(text)


def ask_again(path, told):
    for name in ("page.html", "again.html"):
        if os.path.exists(name):
            os.remove(name)
    run("report", path, "--html", "page.html", "--quiet")
    said = json.loads(run("report", path, "--html", "-o", "again.html", "--json"))
    assert (said["output"], said["bytes"]) == ("again.html", len(told)), said
    for name in ("page.html", "again.html"):
        with open(name, "rb") as file:
            assert file.read() == told, name


def check(path, in_every_way=False):
    page = page_of(path, in_every_way)
    info = json.loads(run("info", path, "--json"))
    energy = json.loads(run("report", path, "--energy", "--json"))
    for words in (f"{info['rays']:,}", f"{info['segments']:,}", info["digest"], str(info["seed"]),
                  info["versions"]["raymap"], info["versions"]["git"], info["versions"]["embree"]):
        assert words in page.text, words
    first = next(row for row in page.rows if row[0] == "emitted")
    assert int(first[2].replace(",", "")) == energy["total"]["emitted"]
    assert abs(float(first[3]) - energy["total"]["flux"]["value"]) < 1e-5 * first_flux(energy)
    rows = {(row[0], row[1]): row for row in page.rows[page.rows.index(first) + 1:][::-1]
            if len(row) == 8}
    shown = energy["total"] if len(energy["sources"]) != 1 else energy["sources"][0]
    for word, kind in (("absorbed by", "objects"), ("absorbed in", "media")):
        for row in shown["absorbed"][kind][:20]:
            told = rows[word, row["name"]]
            assert int(told[2].replace(",", "")) == row["rays"], (told, row)
    for row in shown["detectors"]:
        told = rows["registered by", row["name"]]
        assert int(told[2].replace(",", "")) == row["registrations"]
    check_paths(path, page)
    assert page.tags.count("figure") == 2 + min(len(info["detectors"]), 12)
    return page


def check_paths(path, page, sampled=None):
    """The table of paths is the one of `raymap paths`, or of a map of the first rays."""
    told = json.loads(run("paths", path, "--json"))
    rows = [row for row in page.rows if len(row) == 9 and row[0].isdigit()]
    assert len(rows) == min(20, len(told["classes"]) if sampled is None else sampled)
    for row, wanted in zip(rows, told["classes"] if sampled is None else []):
        assert wanted["sequence"] in row[1] and wanted["criterion"] in row[1], (row, wanted)
        assert row[1].startswith(wanted["source"])
        assert int(row[2].replace(",", "")) == wanted["rays"]
        assert abs(float(row[3]) - wanted["flux"]) <= 1e-5 * wanted["flux"]
        assert int(row[-1]) == wanted["first_ray"]
    return rows


def first_flux(energy):
    return max(energy["total"]["flux"]["value"], 1.0)


for name in ("odd.raymap", "lens.raymap", "none.raymap", "part.raymap"):
    shutil.rmtree(name, ignore_errors=True)
with open("odd.yaml", "w", encoding="utf-8") as scene:
    scene.write(SCENE)
run("trace", "odd.yaml", "-o", "odd.raymap", "-n", 4000, "--quiet")
odd = check("odd.raymap", in_every_way=True)
for words in ("<script>alert(1)</script>", "lamp & co", "eye <1>", "glass & <b>", "complete",
              "stopped by a limit"):
    assert words in odd.text, words

run("trace", os.path.join(SOURCE, "examples", "double-gauss", "scene.yaml"), "-o", "lens.raymap",
    "-n", 5000, "--encoding", "plain", "--quiet")
check("lens.raymap")

# Paths from the first rays alone: each source's flux is spread over those of its rays.
first = 1000
told = json.loads(run("query", "lens.raymap", f"ray < {first}", "--limit", first, "--json"))
emitted = {}
for ray in told:
    emitted[ray["source"]] = emitted.get(ray["source"], 0) + 1
flux = {source["name"]: source["flux"] for source in json.loads(run("info", "lens.raymap", "--json"))["sources"]}
page = Page(run("report", "lens.raymap", "--html", "--sample", first).decode())
assert f"first {first:,} rays" in page.text
for row in check_paths("lens.raymap", page, 20)[:5]:
    source, rays = row[1].split(":")[0], int(row[2].replace(",", ""))
    criterion = row[1].split("criterion")[1]
    count = json.loads(run("query", "lens.raymap", f"ray < {first} and {criterion}", "--count", "--json"))
    assert count["rays"]["matched"] == rays, row
    assert abs(float(row[3]) - flux[source] * rays / emitted[source]) <= 1e-5 * float(row[3]), row

# A map without rays, and one of picked rays.
run("query", "lens.raymap", "hit(*) > 100000", "-o", "none.raymap", "--quiet")
assert "The map holds no ray" in check("none.raymap").text
run("query", "lens.raymap", "registered(sensor)", "-o", "part.raymap", "--quiet")
assert "registered(sensor)" in check("part.raymap").text

# Stray light: what matches alone, detectors' images and paths by the registrations that the criterion chooses.
where = "registered(sensor where ghost_order >= 1)"
ghosts = Page(run("report", "lens.raymap", "--html", "--where", where).decode()).text
image = json.loads(run("detector", "lens.raymap", "sensor", "--where", where, "--json"))
best = json.loads(run("paths", "lens.raymap", "--detector", "sensor", "--where", where, "--json"))["classes"][0]
assert where in ghosts and f"{image['registrations']:,}" in ghosts, ghosts[:2000]
assert best["sequence"] in ghosts and best["sequence"].endswith("V@sensor"), best
assert run("report", "lens.raymap", "--html", "--where", where) == run("report", "lens.raymap", "--html", "--where", where, "--threads", 1)

# An unfinished map says so.
run("trace", os.path.join(SOURCE, "examples", "double-gauss", "scene.yaml"), "-o", "late.raymap",
    "-n", "1G", "--time-limit", "1", "--quiet", "--force", status=6)
assert "NOT complete" in check("late.raymap").text
shutil.rmtree("late.raymap")

for arguments, status, words in (
        (["odd.raymap", "--html", "page.html"], 2, "--force"),
        (["odd.raymap", "--html", "page.pdf"], 2, ".html"),
        (["odd.raymap", "3", "--html"], 2, ".html"),
        (["odd.raymap", "--html", "a.html", "-o", "b.html"], 2, "one of them"),
        (["odd.raymap", "--html", "--energy"], 2, "--energy or --html"),
        (["odd.raymap", "3", "--where", "all"], 2, "--where"),
        (["odd.raymap", "--html", "--where", "all", "--sample", "9"], 2, "--where"),
        (["odd.raymap", "--html", "--json"], 2, "-o OUT.html"),
        (["odd.raymap", "--html", "--sample", "0"], 2, "--sample"),
        (["odd.raymap", "--html", "--sample", "1G"], 2, "--sample"),
        (["odd.raymap", "--energy", "--sample", "3"], 2, "--html"),
        (["odd.raymap", "3", "-o", "x.html"], 2, ".csv"),
        (["odd.yaml", "--html", "--ray", "3"], 2, "without a ray"),
        (["missing.raymap", "--html"], 3, "missing.raymap"),
        (["odd.yaml", "--html"], 4, ""),
        (["odd.raymap", "--html", "-o", "no/such/folder.html"], 3, "no/such")):
    assert words in run("report", *arguments, status=status).decode(), (arguments, words)
print("pages are well-formed and tell what the map holds")
