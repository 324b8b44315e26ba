#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: a ray read from the map and the same ray traced again tell the same history, the
# one with the map's digits, the other with all.
. "$(dirname "$0")/expect.bash"
rm -rf ./*
write_scene scene.yaml
sed -i '/name: sensor/a\  - {name: far, type: intensity, cells: [18, 36]}' scene.yaml
expect 0 '' "$RAYMAP" trace scene.yaml -o a.raymap -n 5000 --seed 7 --quiet

expect 0 '^source +lamp' "$RAYMAP" report a.raymap 12
expect 0 'T +lens\.1 .*transmit_specular' "$RAYMAP" report a.raymap 12
expect 0 'V +sensor .*registered: x ' "$RAYMAP" report a.raymap 12
expect 0 '^flux +1 W' "$RAYMAP" report scene.yaml --ray 12 --seed 7
expect 3 'no ray 5000' "$RAYMAP" report a.raymap 5000
expect 2 'whole number' "$RAYMAP" report a.raymap many
expect 3 "of a map: raymap report a.raymap 12" "$RAYMAP" report a.raymap --ray 12
expect 2 'SCENE and --ray' "$RAYMAP" report a.raymap
expect 2 'SCENE and --ray' "$RAYMAP" report scene.yaml 3 --ray 4
expect 3 'none.raymap' "$RAYMAP" report none.raymap 1
expect 4 '' "$RAYMAP" report scene.yaml 1

rays='0 4 12 999 4999' # ray 4 leaves, to the grid
for ray in $rays; do
    "$RAYMAP" report a.raymap $ray --json >map-$ray.json || failures=1
    "$RAYMAP" report scene.yaml --ray $ray --seed 7 --json >scene-$ray.json || failures=1
done
cat >compare.py <<'PY'
import json, math, sys
keys = {"version", "ray", "source", "stop", "flux", "wavelength", "path_length", "optical_path", "start", "steps", "registrations"}
step_keys = {"object", "face", "primitive", "events", "medium", "position", "normal", "direction", "length", "angle_of_incidence", "reflectance",
             "colour"}
registration_keys = {"detector", "step", "cell", "x", "y", "angle", "optical_path", "registered"}
def near(a, b, tolerance, what):
    if a is None or b is None:
        assert a is b, (what, a, b)
    elif isinstance(a, list):
        for x, y in zip(a, b, strict=True):
            near(x, y, tolerance, what)
    else:
        assert abs(a - b) <= tolerance * max(1, abs(b)), (what, a, b)
for ray in sys.argv[1:]:
    m, s = json.load(open(f"map-{ray}.json")), json.load(open(f"scene-{ray}.json"))
    for r in m, s:
        of_map = {"complete", "rays_asked", "rays_traced"} if r is m else set()
        assert set(r) == keys | of_map and r["ray"] == int(ray)
        assert all(set(t) == step_keys | ({"optical_path"} if r is s else set()) for t in r["steps"])
        assert all(set(t) == registration_keys for t in r["registrations"])
        # path_length leaves out a leg that leaves, whose length is 0
        near(math.fsum(t["length"] for t in r["steps"]), r["path_length"], 1e-5 if r is m else 1e-13, "length")
        at = r["start"]
        for t in r["steps"]:
            if t["length"]:
                ahead = [a + t["length"] * d for a, d in zip(at, t["direction"])]
                near(ahead, t["position"], 1e-5 if r is m else 1e-13, "position")
            at = t["position"]
    for key in ("source", "stop"):
        assert m[key] == s[key], key
    for key in ("wavelength", "path_length", "optical_path"):
        near(m[key], s[key], 0, key)
    near(m["start"], s["start"], 1e-6, "start")
    near(m["flux"], 1 / 5000, 1e-15, "flux")
    for a, b in zip(m["steps"], s["steps"], strict=True):
        for key in ("object", "face", "primitive", "events", "medium"):
            assert a[key] == b[key], (key, a, b)
        near(a["position"], b["position"], 1e-6, "position")
        near(a["normal"], b["normal"], 4e-5, "normal")
        near(a["colour"], b["colour"], 1e-4, "colour")
    for a, b in zip(m["registrations"], s["registrations"], strict=True):
        for key in ("detector", "step", "cell", "registered"):
            assert a[key] == b[key], key
        near(a["optical_path"], b["optical_path"], 0, "optical_path")
        width = 360 if a["detector"] == "far" else 40
        near([a["x"], a["y"]], [b["x"], b["y"]], width / 65535, "x, y")
        near(a["angle"], b["angle"], 1e-3, "angle")
PY
/usr/bin/python3 compare.py $rays || failures=1

# Ranks change nothing.
expect 0 '' mpirun -np 2 "$RAYMAP" report scene.yaml --ray 12 --seed 7 --json
cmp stdout.txt scene-12.json || failures=1

# Many rays in one list: each as it is alone, written by any number of ranks; in a gradient medium
# the first direction of a leg and the path at every step.
# Rows of a ray, of a map as of its scene, are those of the query's file.
"$RAYMAP" report a.raymap 12 -o ray.csv && "$RAYMAP" query a.raymap 'ray == 12' -q -o query.csv && cmp ray.csv query.csv || failures=1
"$RAYMAP" report scene.yaml --rays 12..13 --seed 7 -o rays.csv && [ "$(cut -d, -f1,6-9 rays.csv | grep ^12)" = "$(cut -d, -f1,6-9 ray.csv | grep ^12)" ] || failures=1
head -1 ray.csv | grep -q ',angle,reflectance' || failures=1
expect 2 'ends before it begins' "$RAYMAP" report scene.yaml --rays 4..3
expect 2 'range as 0..99' "$RAYMAP" report scene.yaml --rays 4
expect 2 'whole number' "$RAYMAP" report scene.yaml --rays 4..x
expect 2 '--ray or --rays' "$RAYMAP" report scene.yaml --rays 4..5 --ray 4
expect 3 "of a map: raymap report a.raymap 12" "$RAYMAP" report a.raymap --rays 12..13
expect 0 '^ray +13' "$RAYMAP" report scene.yaml --rays 12..13
sed '/name: panel/d' "$SOURCE_DIR/tests/data/curved-segments.yaml" >curved.yaml
expect 0 '^\[' "$RAYMAP" report curved.yaml --rays 5..24 --seed 3 --json
cp stdout.txt list.json
expect 0 '^\[' mpirun -np 2 "$RAYMAP" report curved.yaml --rays 5..24 --seed 3 --json
cmp stdout.txt list.json || failures=1
for ray in 5 7 24; do
    "$RAYMAP" report curved.yaml --ray $ray --seed 3 --json >scene-$ray.json || failures=1
done
cat >list.py <<'PY'
import json, math
many = json.load(open("list.json"))
assert [r["ray"] for r in many] == list(range(5, 25))
for ray in 5, 7, 24:
    assert many[ray - 5] == json.load(open(f"scene-{ray}.json")), ray
curved = 0
for r in many:
    at, path = r["start"], 0.0
    for t in r["steps"]:
        assert ("first_direction" in t) == ("curve" in t) == ("gradient" in t["events"])
        assert t["optical_path"] >= path + t["length"] * (1 - 1e-12), t
        if t.get("curve"):
            first, chord = t["first_direction"], [b - a for a, b in zip(at, t["curve"][0])]
            assert abs(math.hypot(*first) - 1) < 1e-12
            assert sum(a * b for a, b in zip(first, chord)) > 0.98 * math.hypot(*chord), t
            curved += first != t["direction"]
        at, path = t["position"], t["optical_path"]
    assert path == r["optical_path"], r
assert curved > 5, curved
PY
/usr/bin/python3 list.py || failures=1
finish
