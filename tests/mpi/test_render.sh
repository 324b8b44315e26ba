#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Any number of ranks and threads renders the same picture, byte by byte.
. "$(dirname "$0")/../cli/expect.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
rm -rf ./*
scene=$SOURCE_DIR/examples/gradient-sphere/scene.yaml
render() { # name ranks threads
    by_ranks "$2"
    expect 0 '' "${start[@]}" "$RAYMAP" render "$scene" --size 150x100 -n 3 --threads "$3" \
        -o "$1.png" -o "$1.exr"
}
render one 1 1
for ranks in 1 2 3; do
    render "n$ranks" "$ranks" 2
    for suffix in png exr; do
        cmp "one.$suffix" "n$ranks.$suffix" ||
            { echo "FAILED: $ranks ranks render another $suffix"; failures=1; }
    done
done
expect 0 '' "$RAYMAP" render "$scene" --size 150x100 -n 3 --seed 2 -o other.exr
cmp -s one.exr other.exr && { echo 'FAILED: another seed renders the same'; failures=1; }
# Few paths find a small lamp over a floor that mirrors a tenth: what a clamp cuts is told, and the same on any ranks.
cat > glossy.yaml <<'END'
raymap: 1
units: m
media: {air: {index: 1}}
surfaces: {wall: {type: lambert, reflectance: 0.7}, gloss: {type: mixture, reflect_specular: 0.1, reflect_diffuse: 0.5}}
geometries: {plate: {type: rectangle, size: [4, 4]}}
objects:
  - {name: floor, geometry: plate, surface: gloss, front: air, back: air}
  - {name: wall, geometry: plate, at: [0, 2, 2], rotate: [90, 0, 0], surface: wall, front: air, back: air}
sources: [{name: lamp, type: area, shape: {disc: 0.1}, at: [0, 0, 2], direction: [0, 0, -1], flux: 3000 lm}]
cameras: [{name: eye, at: [0, -1.5, 1], look_at: [0, 2, 1]}]
END
expect 0 '' "$RAYMAP" render glossy.yaml --size 80x60 -n 64 -o dots.exr
grep -q -- '--clamp 100' stderr.txt || { echo 'FAILED: no clamp is proposed'; failures=1; }
for ranks in 1 2; do
    by_ranks $ranks
    expect 0 '' "${start[@]}" "$RAYMAP" render glossy.yaml --size 80x60 -n 64 --clamp 200 -o "clamped$ranks.exr" --json
    /usr/bin/python3 -c 'import json, sys; d = json.load(sys.stdin); assert d["noise"] < 0.2 * d["mean"] and 0 < d["clamp"]["cut"] < 0.1 * d["mean"], d' < stdout.txt || failures=1
done
cmp clamped1.exr clamped2.exr || failures=1
expect 3 'no camera named' mpirun -np 3 "$RAYMAP" render "$scene" --camera nobody -o b.png
expect 3 'cannot write' mpirun -np 3 "$RAYMAP" render "$scene" --size 15x10 -n 1 -o nowhere/b.png
finish
