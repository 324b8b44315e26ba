#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: --json prints exactly one document with the documented keys, numbers add up, and
what is undefined is null."""
import json
import os
import shutil
import subprocess

PROGRAM = os.environ["RAYMAP"]
SCENE = os.path.join(os.environ["SOURCE_DIR"], "examples", "double-gauss", "scene.yaml")


def run(*arguments, status=0):
    done = subprocess.run([PROGRAM, *arguments, "--json", "--quiet"], capture_output=True, text=True)
    assert done.returncode == status, (arguments, done.returncode, done.stderr)
    return json.loads(done.stdout)  # one document and nothing else


def same_keys(document, keys):
    assert list(document) == keys.split(), list(document)


shutil.rmtree("a.raymap", ignore_errors=True)
for name in ("rays.json", "rays.csv"):
    if os.path.exists(name):
        os.remove(name)

checked = run("check", SCENE)
assert checked["errors"] == 0 and checked["diagnostics"] == [], checked
assert "star" in checked["scene"]["sources"] and checked["scene"]["units"] == "mm"

traced = run("trace", SCENE, "-o", "a.raymap", "-n", "20001", "--seed", "12345678901234567",
             "--encoding", "plain")
assert traced["rays"] == 20001 and traced["complete"] is True
for source in traced["sources"]:
    absorbed = sum(source["absorbed"]["objects"].values()) + sum(source["absorbed"]["media"].values())
    ended = absorbed + source["left"] + source["limit"] + source["error"]
    assert source["emitted"] == ended, source
assert sum(source["emitted"] for source in traced["sources"]) == 20001

info = run("info", "a.raymap")
for key in ("rays segments registrations bytes complete seed digest sources objects detectors shards"
            " ranks versions").split():
    assert key in info, key
assert info["rays"] == 20001 and info["seed"] == 12345678901234567 and info["complete"] is True
assert info["digest"] == traced["digest"] and len(info["digest"]) == 32
assert info["segments"] == traced["segments"] and info["ranks"] == 1
assert [source["flux"] for source in info["sources"]] == [1.0, 100.0]
assert all(source["unit"] == "W" for source in info["sources"])
assert sum(shard["rays"] for shard in info["shards"]) == 20001

count = run("query", "a.raymap", "all", "--count")
same_keys(count, "version criterion rays segments flux registered portions bytes_read seconds complete rays_asked rays_traced")
same_keys(count["rays"], "total matched")
same_keys(count["segments"], "total matched")
same_keys(count["flux"], "total matched standard_error unit")
same_keys(count["portions"], "total read")
assert count["rays"] == {"total": 20001, "matched": 20001}
assert count["segments"]["matched"] == info["segments"]
assert count["flux"]["matched"] == 101.0 and count["flux"]["total"] == 101.0  # of all sources
run("trace", SCENE, "-o", "one.raymap", "-n", "1", "--force")
one = run("query", "one.raymap", "all")
assert one["flux"]["total"] == 101.0 and one["flux"]["matched"] in (1.0, 100.0), one["flux"]
assert abs(count["flux"]["standard_error"]) < 1e-9  # all rays match: nothing is left to chance

several = run("query", "a.raymap", "source(star)", "source(sun)", "hit(*) > 100000")
assert [c["criterion"] for c in several] == ["source(star)", "source(sun)", "hit(*) > 100000"]
assert several[0]["rays"]["matched"] + several[1]["rays"]["matched"] == 20001
assert several[2]["rays"]["matched"] == 0

explained = run("query", "a.raymap", "source(star)", "--explain")
assert explained[0]["columns"] == ["/ray/source"], explained

ghost = "registered(sensor) and hit('lens.*', reflect_specular) >= 2"
rays = run("query", "a.raymap", ghost, "--limit", "5")
written = run("query", "a.raymap", ghost, "-o", "rays.json")
with open("rays.json") as file:
    everything = json.load(file)
same_keys(written, "version output rays complete rays_asked rays_traced")
assert written["output"] == "rays.json" and written["rays"] == len(everything) > 5
assert rays == everything[:5]
assert [ray["ray"] for ray in everything] == sorted(ray["ray"] for ray in everything)
for ray in everything:
    for key in "ray source stop flux wavelength path_length optical_path start steps registrations".split():
        assert key in ray, key
    hits = [s for s in ray["steps"]
            if s["object"] and s["object"].startswith("lens.") and "reflect_specular" in s["events"]]
    assert len(hits) >= 2 and any(r["detector"] == "sensor" for r in ray["registrations"]), ray

run("query", "a.raymap", ghost, "-o", "rays.csv")
with open("rays.csv") as file:
    rows = file.read().splitlines()
assert len(rows) == 1 + sum(len(ray["steps"]) for ray in everything)
assert len({len(row.split(",")) for row in rows}) == 1

counted = [run("query", "a.raymap", text) for text in (ghost, "path_length > 0")]
explained = run("query", "a.raymap", ghost, "path_length > 0", "--explain")
assert explained[0]["compact"]["undecided_rays"] == explained[0]["compact"]["traced_again"] == 0, explained
assert explained[1]["columns"] == ["/ray/path_length"], explained
assert explained[1]["index"]["undecided_rays"] == 0, explained

lone = run("trace", SCENE, "--no-record", "-n", "1")
assert lone["rays"] == 1 and lone["map"] is None
shutil.rmtree("a.raymap")
print("one document each, as documented")
