#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# raymap render: what is asked wrongly is refused with the remedy, and nothing is left behind.
. "$(dirname "$0")/expect.bash"
rm -rf ./* .[!.]*

cat >scene.yaml <<'END'
raymap: 1
units: m
spectrum: {mode: rgb}
media: {air: {index: 1}}
surfaces: {grey: {type: lambert, reflectance: 0.5}}
geometries: {plate: {type: rectangle, size: [4, 4]}}
objects: [{name: floor, geometry: plate, surface: grey, front: air, back: air}]
sources: [{name: lamp, type: point, at: [0, 0, 2], flux: 100 lm}]
cameras:
  - {name: front, at: [0, -5, 2], look_at: [0, 0, 0], resolution: [64, 48]}
  - {name: above, at: [0, 0, 5], direction: [0, 0, -1], type: thin_lens, focus: 5, aperture: 0.1}
END

# A picture, by suffix; what stands there stays.
expect 0 'camera front, 64 x 48, 2 samples' "$RAYMAP" render scene.yaml -n 2 -o a.png -o a.exr
[ "$(head -c 8 a.png | od -An -tx1)" = ' 89 50 4e 47 0d 0a 1a 0a' ] || { echo 'FAILED: no PNG'; failures=1; }
[ "$(head -c 4 a.exr | od -An -tx1)" = ' 76 2f 31 01' ] || { echo 'FAILED: no EXR'; failures=1; }
expect 2 'exists' "$RAYMAP" render scene.yaml -n 2 -o a.png
expect 0 '' "$RAYMAP" render scene.yaml -n 2 -o a.png --force --exposure 0.2 --size 20x10
expect 0 'camera above, 8 x 8, 1 sample:' "$RAYMAP" render scene.yaml --camera above --preview --size 8x8
expect 0 '"frames_per_second"' "$RAYMAP" render scene.yaml --preview --size 8x8 --json

# Asked wrongly.
expect 2 'say where to' "$RAYMAP" render scene.yaml
expect 2 'ends in .png or .exr' "$RAYMAP" render scene.yaml -o a.jpg
expect 2 'say WIDTHxHEIGHT' "$RAYMAP" render scene.yaml -o b.png --size 0x4
expect 2 'say WIDTHxHEIGHT' "$RAYMAP" render scene.yaml -o b.png --size 10
expect 2 'say WIDTHxHEIGHT' "$RAYMAP" render scene.yaml -o b.png --size 10x-3
expect 2 'at least 1' "$RAYMAP" render scene.yaml -o b.png --samples 0
expect 2 'greater than 0' "$RAYMAP" render scene.yaml -o b.png --exposure 0
expect 2 'leave out --samples' "$RAYMAP" render scene.yaml -o b.png --preview --samples 4
expect 3 "did you mean 'front'" "$RAYMAP" render scene.yaml -o b.png --camera frnt
expect 3 'nowhere/b.png' "$RAYMAP" render scene.yaml -n 1 -o nowhere/b.png
expect 3 'nowhere/b.exr' "$RAYMAP" render scene.yaml -n 1 -o nowhere/b.exr
expect 6 'time limit' "$RAYMAP" render scene.yaml -n 100000000 --time-limit 0.2s -o late.png
[ -s late.png ] || { echo 'FAILED: no picture of the passes in time'; failures=1; }
expect 0 '' "$RAYMAP" render scene.yaml --time-limit 0.2s -o intime.png

# Scenes with mistakes: each is found, with its place.
grep -v cameras scene.yaml | grep -v 'name: front' | grep -v 'name: above' >none.yaml
expect 3 'has no camera' "$RAYMAP" render none.yaml -o b.png
mistake() { # text of a camera, what is said
    { grep -v 'name: front' scene.yaml | grep -v 'name: above'; echo "  - {name: eye, $1}"; } >wrong.yaml
    expect 3 "$2" "$RAYMAP" render wrong.yaml -o b.png
}
mistake 'at: [1, 2, 3], look_at: [1, 2, 3]' "wrong.yaml:10:.*'look_at' is where camera 'eye' stands"
mistake 'at: [1, 2, 3]' "say where camera 'eye' looks"
mistake 'at: [1, 2, 3], look_at: [0, 0, 0], direction: [0, 0, 1]' 'not both'
mistake 'direction: [0, 0, 0]' "'direction'"
mistake 'direction: [0, 1, 0], up: [0, 2, 0]' "'up' is along the line of sight"
mistake 'direction: [0, 1, 0], resolution: [0, 10]' 'between 1 and 65535'
mistake 'direction: [0, 1, 0], resolution: [1.5, 10]' 'whole numbers'
mistake 'direction: [0, 1, 0], resolution: [65535, 65535]' 'too many'
mistake 'direction: [0, 1, 0], fov: 180' 'up to 179 degrees'
mistake 'direction: [0, 1, 0], fov: 30, focal_length: 50' "give 'fov', or"
mistake 'direction: [0, 1, 0], focal_length: 50' "'sensor'"
mistake 'direction: [0, 1, 0], aperture: 3' "aperture"
mistake 'direction: [0, 1, 0], type: thin_lens, aperture: 3' "'focus'"
mistake 'direction: [0, 1, 0], type: thin_lens, focus: 3' "'aperture'"
mistake 'direction: [0, 1, 0], type: thin_lens, aperture: 1, focus: 3, focal_length: 4, sensor: [4, 3]' 'cannot focus nearer'
mistake 'direction: [0, 1, 0], type: fisheye' 'pinhole'
mistake 'direction: [0, 1, 0], medium: aire' "did you mean 'air'"
mistake 'direction: [0, 1, 0], exposure: -1' 'exposure'
mistake 'direction: [0, 1, 0]}
  - {name: eye, direction: [0, 1, 0]' "the name 'eye' is taken by the camera on line 10"
sed 's/^objects/background: {radiance: -1}\nobjects/' scene.yaml >wrong.yaml
expect 3 "'radiance'" "$RAYMAP" render wrong.yaml -o b.png
[ -e b.png ] && { echo 'FAILED: b.png was made'; failures=1; }
# A luminaire in the picture does not make the room dark: its walls, of 60 to 250 cd/m2, are shown between a tenth of white and white.
cat >office.yaml <<'END'
raymap: 1
units: m
spectrum: {mode: rgb}
media: {air: {index: 1}}
surfaces: {paint: {type: lambert, reflectance: 0.6}}
geometries: {room: {type: box, size: [6, 4, 2.8]}}
objects: [{name: room, geometry: room, surface: paint, inside: air, outside: air}]
sources: [{name: panel, type: area, shape: {rectangle: 0.5}, at: [0, 0, 2.7], direction: [0, 0, -1], flux: 9000 lm}]
cameras: [{name: door, at: [-2.8, -1.8, 1.6], look_at: [1, 0.5, 2], fov: 75}]
END
"$RAYMAP" render office.yaml --samples 4 --size 64x48 -o office.png --json >office.json || failures=1
/usr/bin/python3 -c 'import json; x = json.load(open("office.json"))["exposure"]; assert 1 / 600 < x < 1 / 60, x' || failures=1
leftovers=$(find . -name '.*.part')
[ -z "$leftovers" ] || { echo "FAILED: left behind: $leftovers"; failures=1; }
finish
