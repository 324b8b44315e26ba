#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: what stands beside a picture says what it shows: units, turned axes, light outside of
# it; nothing is said twice in one place, and an empty picture says that it is empty.
. "$(dirname "$0")/expect.bash"

# has PICTURE WORDS: they stand somewhere in it. lacks: nowhere.
has() {
    grep -Eq -e "$2" "$1" || { printf 'FAILED: "%s" is not in %s\n' "$2" "$1"; failures=$((failures + 1)); }
}
lacks() {
    ! grep -Eq -e "$2" "$1" || { printf 'FAILED: "%s" is in %s\n' "$2" "$1"; failures=$((failures + 1)); }
}

rm -rf ./*.raymap ./*.svg ./*.vtp ./*.html
write_scene scene.yaml
expect 0 '' "$RAYMAP" trace scene.yaml -o a.raymap -n 5000 --quiet

# units and axes
expect 0 '' "$RAYMAP" detector a.raymap sensor --quantity luminance -o radiance.svg
has radiance.svg '>radiance, W/\(m² sr\)<'
expect 0 '' "$RAYMAP" detector a.raymap sensor --color true -o true.svg
has true.svg 'white at [0-9.e+]+ W/m²'
expect 0 '' "$RAYMAP" detector a.raymap sensor --rotate=-30 -o turned.svg
expect 0 '"rotate": 30.0' "$RAYMAP" detector a.raymap sensor --rotate=30 --json
has turned.svg 'axes turned by −30°'
lacks true.svg 'turned'

# a picture of a spectrum has a panel for each channel, of very many for nine; --log and nothing to show are no trouble
expect 0 '' "$RAYMAP" detector a.raymap sensor --quantity spectral -o spectrum.svg
for channel in 486.13 587.56 656.27; do has spectrum.svg ">$channel nm<"; done
has spectrum.svg 'W; part of each channel<|; part of each channel<'
[ "$(grep -c '<image' spectrum.svg)" -eq 4 ] || { echo "FAILED: not three panels and a scale"; failures=$((failures + 1)); }
expect 0 '' "$RAYMAP" trace scene.yaml -o many.raymap -n 2000 --quiet --set spectrum.wavelengths='{from: 450, to: 700, step: 10}'
expect 0 '' "$RAYMAP" detector many.raymap sensor --quantity spectral --log -o nine.svg
has nine.svg '>450 nm<'
has nine.svg '>700 nm<'
has nine.svg '9 of 26 channels'
expect 0 '' "$RAYMAP" detector many.raymap sensor --quantity spectral --log --where 'ray > 1000000' -o dark.svg
has dark.svg 'nothing was registered'
lacks dark.svg 'nan|inf'

# names that find no room beside their places have a line to them, and keep off the axes' arrows
expect 0 '' "$RAYMAP" trace "$SOURCE_DIR/examples/selfoc/scene.yaml" -o rod.raymap -n 400 --quiet
expect 0 '' "$RAYMAP" draw rod.raymap -o rod.svg
has rod.svg '<line [^>]*stroke="#c2410c" stroke-width="0.6"'

# a legend has all of a criterion, however long; its groups take the whole width
long='registered(sensor) and path_length > 1 and path_length < 1000 and segments < 500 and bounces < 500'
expect 0 '' "$RAYMAP" draw a.raymap --where "$long and ray < 4000" --where 'ray >= 4000' --color criterion -o legend.svg
tr '\n' ' ' <legend.svg | sed 's|</text> <text[^>]*>| |g' >joined.svg
has joined.svg "rays: registered\(sensor\) and .* and bounces &lt; 500 and ray &lt; 4000"

# an ink that returns is dashed, in the picture and in the legend
eight=()
for k in 1 2 3 4 5 6 7 8; do eight+=(--where "segments == $k"); done
expect 0 '' "$RAYMAP" draw a.raymap "${eight[@]}" -o eight.svg
has eight.svg 'stroke="#0072b2" stroke-width="2.4"/>'
has eight.svg 'stroke="#0072b2" stroke-width="2.4" stroke-dasharray='
has eight.svg '<path .*stroke="#0072b2" .*stroke-dasharray='

# so has a caption; the picture grows upwards by its rows
expect 0 '' "$RAYMAP" stats a.raymap --of path_length --detector sensor --where "$long and ray < 4000" -o caption.svg
has caption.svg 'viewBox="0 -[1-9]'
has caption.svg '>path_length at sensor<'
tr '\n' ' ' <caption.svg | sed 's|</text> <text[^>]*>| |g' >joined.svg
has joined.svg "rays: registered\(sensor\) and .* and bounces &lt; 500 and ray &lt; 4000"
lacks caption.svg '…'

# counts, and what the bins leave out
expect 0 'values +[0-9],[0-9]{3} of [0-9],[0-9]{3} rays' "$RAYMAP" stats a.raymap --of segments --range 0..3 -o outside.svg
has outside.svg '>[0-9],[0-9]{3} values, .*, standard deviation [^,]* W outside the picture<'
lacks outside.svg ' ,'
expect 0 '' "$RAYMAP" stats a.raymap --of path_length --range 0..1e6 -o inside.svg
lacks inside.svg 'outside'

# z of hundreds: its marks at 1 and 3 would lie upon each other
expect 0 '' "$RAYMAP" trace scene.yaml -o b.raymap -n 50000 --seed 2 --quiet --set sources.lamp.distribution='{cone: 2}'
expect 0 '' "$RAYMAP" trace scene.yaml -o c.raymap -n 50000 --quiet
expect 0 DIFFERENT "$RAYMAP" compare c.raymap b.raymap --of path_length -o far.svg
has far.svg 'z of A - B'
lacks far.svg '>(\+|−)[13]<'
expect 0 '' "$RAYMAP" compare a.raymap --where 'ray < 2500' --where 'ray >= 2500' --of path_length -o near.svg
has near.svg '>\+3<'

# light that goes to and fro for thousands of segments: so many rays as can be told apart, unless asked
cat >trap.yaml <<'SCENE'
raymap: 1
units: mm
limits: {steps: 3000}
media: {air: {index: 1}}
surfaces: {silver: {type: mirror, reflectance: 1}}
geometries: {ball: {type: sphere, radius: 20}}
objects: [{name: wall, geometry: ball, surface: silver, front: air, back: air}]
sources: [{name: lamp, type: point, at: [0, -10, 5], distribution: isotropic, flux: 1 W, medium: air}]
SCENE
expect 0 '' "$RAYMAP" trace trap.yaml -o trap.raymap -n 40 --quiet
expect 0 ': 6 of 40 matching rays drawn' "$RAYMAP" draw trap.raymap -o trap.svg
grep -q 'make up 20000, or by --limit N more' stderr.txt || { echo "FAILED: no note"; failures=$((failures + 1)); }
has trap.svg '>6 of 40 rays drawn'
expect 0 ': 9 of 40 matching rays drawn' "$RAYMAP" draw trap.raymap --limit 9 -o more.svg
expect 0 ': 40 of 40 matching' "$RAYMAP" draw trap.raymap -o all.vtp
expect 0 '' "$RAYMAP" report trap.raymap --html trap.html
has trap.html '>6 of 40 rays drawn'

# nothing at all
none='ray > 1000000'
expect 0 '' "$RAYMAP" report a.raymap --energy --where "$none" -o energy.svg
has energy.svg 'no ray matches'
lacks energy.svg 'nan'
expect 0 '' "$RAYMAP" compare a.raymap --where "$none" --where "$none or $none" --test image --detector sensor -o difference.svg
has difference.svg 'nothing to compare'
for kind in 'detector a.raymap sensor' 'stats a.raymap --of path_length' 'draw a.raymap'; do
    # shellcheck disable=SC2086 # words
    expect 0 '' "$RAYMAP" $kind --where "$none" -o empty.svg --force
    has empty.svg 'nothing was registered|no ray has a value|no ray matches'
    lacks empty.svg 'nan'
done
finish
