#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: a detector's image from the tally, from the registrations and from CSV is one and
# the same (but for errors, as the tally does not know which rays came twice), in physical units;
# pictures are written; mistakes are told.
. "$(dirname "$0")/expect.bash"
rm -rf ./*
write_scene scene.yaml
expect 0 '' "$RAYMAP" trace scene.yaml -o a.raymap -n 20000 --encoding plain --quiet

expect 0 '^flux ' "$RAYMAP" detector a.raymap sensor -o all.csv
cp stdout.txt all.txt
expect 0 '^flux ' "$RAYMAP" detector a.raymap sensor --where all -o where.csv
cmp all.txt stdout.txt || { echo "FAILED: all rays and no criterion differ"; failures=1; }
diff <(grep -v '^# criterion' all.csv) <(grep -v '^# criterion' where.csv) >/dev/null ||
    { echo "FAILED: the images of all rays and of no criterion differ"; failures=1; }
"$RAYMAP" detector a.raymap sensor --json >all.json || failures=1
"$RAYMAP" detector a.raymap sensor --tally --json >tally.json || failures=1
"$RAYMAP" detector a.raymap sensor --where 'registered(sensor) == 1' --json >once.json || failures=1
"$RAYMAP" query a.raymap 'registered(sensor) >= 1' 'registered(sensor) == 1' --json >query.json || failures=1
cat >check.py <<'PY'
import csv, json, math
rows = list(csv.DictReader(line for line in open("all.csv") if not line.startswith("#")))
d = json.load(open("all.json"))
assert len(rows) == 400 and d["cells"] == [20, 20]
area = 4e-6 # m2
flux = math.fsum(float(r["value"]) for r in rows) * area
assert math.isclose(flux, d["flux"]["total"], rel_tol=1e-12), (flux, d["flux"])
assert sum(float(r["rays"]) for r in rows) == d["registrations"]
assert math.isclose(d["mean"]["value"], flux / 1600e-6, rel_tol=1e-12)
peak = max(rows, key=lambda r: float(r["value"]))
assert math.isclose(float(peak["value"]), d["peak"]["value"], rel_tol=1e-12)
assert [int(peak["i"]), int(peak["j"])] == d["peak"]["cell"]
assert float(rows[0]["x"]) == -19 and float(rows[0]["y"]) == -19 and float(rows[1]["x"]) == -17
# A ray that comes back to the sensor is one sample that counts twice
import h5py, numpy as np
n, N = d["registrations"], 20000
f = h5py.File("a.raymap/map.h5")
ray = np.repeat(np.arange(N), f["ray/registration_count"][:])
q = np.bincount(ray[f["registration/registered"][:] == 1], minlength=N)
assert q.sum() == n and q.max() > 1
assert math.isclose(d["flux"]["standard_error"], math.sqrt(((q * q).sum() - n * n / N) / (N * (N - 1))), rel_tol=1e-9)
# The tally takes it for two: w is 0 or 1
t = json.load(open("tally.json"))
assert math.isclose(t["flux"]["standard_error"], math.sqrt((n - n * n / N) / (N * (N - 1))), rel_tol=1e-9)
del t["flux"], t["mean"], t["peak"]["standard_error"], d["peak"]["standard_error"]
with_errors = {"least", "greatest", "uniformity", "sources"}
assert all(t[key] == d[key] for key in t.keys() - with_errors)
some, one = json.load(open("query.json")) # a ray may come back to the sensor
assert some["rays"]["matched"] < d["registrations"]
once = json.load(open("once.json"))
assert 0 < once["registrations"] == one["rays"]["matched"]
assert math.isclose(once["flux"]["total"], one["flux"]["matched"], rel_tol=1e-12)
assert math.isclose(once["flux"]["standard_error"], one["flux"]["standard_error"], rel_tol=1e-9)
PY
/usr/bin/python3 check.py || failures=1

# Where light passes more often than there are rays, a tally knows no error of the sum: not 0
cat >mirrors.yaml <<'SCENE'
raymap: 1
units: mm
spectrum: {mode: rgb}
limits: {steps: 6}
media: {air: {index: 1}}
surfaces: {mirror: {type: mirror, reflectance: 1}}
geometries: {plate: {type: rectangle, size: [10, 10]}}
objects:
  - {name: left, geometry: plate, surface: mirror, front: air, back: air}
  - {name: right, geometry: plate, at: [0, 0, 10], surface: mirror, front: air, back: air}
sources:
  - {name: beam, type: collimated, shape: {disc: 1}, at: [0, 0, 5], direction: [0, 0, 1], flux: 1 W, medium: air}
detectors:
  - {name: between, type: plane, size: [10, 10], cells: [2, 2], at: [0, 0, 7], direction: [0, 0, -1], side: both}
SCENE
expect 0 '' "$RAYMAP" trace mirrors.yaml -o mirrors.raymap -n 100 --quiet
expect 0 'flux +6 W' "$RAYMAP" detector mirrors.raymap between --tally
expect 0 'flux +6 .- 0 W' "$RAYMAP" detector mirrors.raymap between # every ray six times

expect 0 '' "$RAYMAP" detector a.raymap sensor -o a.png --log
[ "$(head -c 4 a.png | tail -c 3)" = PNG ] || { echo "FAILED: a.png is no PNG"; failures=1; }
expect 0 '' "$RAYMAP" detector a.raymap sensor -o a.svg --color true
grep -q 'true colour' a.svg || { echo "FAILED: a.svg does not say that it is in true colour"; failures=1; }
expect 0 '^registrations +0' "$RAYMAP" detector a.raymap sensor --where 'segments > 1000' -o none.png
/usr/bin/python3 -c 'import xml.dom.minidom as x; x.parse("a.svg")' || failures=1
for np in 1 3; do
    by_ranks $np
    expect 0 '' "${start[@]}" "$RAYMAP" detector a.raymap sensor --where 'hit(lens.1)' --color true -o np$np.svg
    expect 0 '' "${start[@]}" "$RAYMAP" detector a.raymap sensor --where 'hit(lens.1)' -o np$np.csv
    cmp np1.svg np$np.svg && cmp np1.csv np$np.csv || { echo "FAILED: $np ranks differ"; failures=1; }
done

# The scale is logarithmic where most of what is lit would be dark: a focus among stray light.
expect 0 '' "$RAYMAP" trace "$SOURCE_DIR/examples/double-gauss/scene.yaml" -o lens.raymap -n 50000 --quiet
expect 0 '' "$RAYMAP" detector lens.raymap sensor -o dark.svg
grep -q 'logarithmic scale' dark.svg || { echo 'FAILED: a dark image is on a linear scale'; failures=1; }
expect 0 '' "$RAYMAP" detector lens.raymap sensor -o linear.svg --linear
expect 0 '' "$RAYMAP" detector a.raymap sensor -o even.svg
grep -q 'logarithmic scale' linear.svg even.svg && { echo 'FAILED: a linear scale is not'; failures=1; }
expect 0 '' "$RAYMAP" detector a.raymap sensor -o log.svg --log
grep -q 'logarithmic scale' log.svg || { echo 'FAILED: --log does nothing'; failures=1; }
expect 2 'not both' "$RAYMAP" detector a.raymap sensor -o both.svg --log --linear

expect 2 'exists' "$RAYMAP" detector a.raymap sensor -o a.png
expect 0 '' "$RAYMAP" detector a.raymap sensor -o a.png --force
expect 2 '\.png, \.svg, \.csv' "$RAYMAP" detector a.raymap sensor -o a.jpg
expect 2 'false or true' "$RAYMAP" detector a.raymap sensor --color blue -o blue.png
expect 3 "did you mean 'sensor'" "$RAYMAP" detector a.raymap senser
expect 3 'criterion:1:5' "$RAYMAP" detector a.raymap sensor --where 'hit(lenz)'
expect 3 "there is no folder 'no/folder'" "$RAYMAP" detector a.raymap sensor -o no/folder/a.png
# Lucky rays in the tiny cells at the poles do not make all others dark; a plane's scale has its peak.
cat >far.yaml <<'YAML'
detectors:
  - {name: far, type: intensity, cells: [90, 90], axis: [0, 0, 1]}
YAML
expect 0 'peak ' "$RAYMAP" detector a.raymap far --receivers far.yaml -o far.svg
grep -q 'cells of few rays go beyond the scale' far.svg || { echo "FAILED: far.svg has the scale of its peak"; failures=1; }
expect 0 'peak ' "$RAYMAP" detector a.raymap sensor -o plane.svg
! grep -q 'beyond the scale' plane.svg || { echo "FAILED: plane.svg has another scale than that of its peak"; failures=1; }
finish
