#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: pictures of scene and rays in every view, the same bytes for any number of ranks,
# with an empty selection too.
. "$(dirname "$0")/expect.bash"
rm -rf ./*
write_scene scene.yaml
expect 0 '' "$RAYMAP" trace scene.yaml -o a.raymap -n 20000 --quiet

for view in yz xz xy 3d; do
    expect 0 '40 of [0-9]+ matching' "$RAYMAP" draw a.raymap --where 'registered(sensor)' --limit 40 --view $view -o $view.svg
    /usr/bin/python3 -c 'import sys, xml.dom.minidom as x; x.parse(sys.argv[1])' $view.svg || failures=1
    for word in a.raymap 'registered(sensor)' lamp sensor ' mm<'; do
        grep -qF "$word" $view.svg || { echo "FAILED: $view.svg does not say $word"; failures=1; }
    done
done
lines() { grep -c '<path' "$1"; }
expect 0 '0 of 0' "$RAYMAP" draw a.raymap --where 'segments > 1000' --view yz -o none.svg
grep -q 'no ray matches' none.svg || { echo "FAILED: none.svg does not say that no ray matches"; failures=1; }
[ "$(lines yz.svg)" -ge $(($(lines none.svg) + 40)) ] || { echo "FAILED: 40 rays are not drawn"; failures=1; }
expect 0 '' "$RAYMAP" draw a.raymap --limit 10000 -o many.png
[ "$(head -c 4 many.png | tail -c 3)" = PNG ] || { echo "FAILED: many.png is no PNG"; failures=1; }
for np in 1 3; do
    by_ranks $np
    expect 0 '' "${start[@]}" "$RAYMAP" draw a.raymap --where 'hit(lens.1)' -o np$np.svg
    cmp np1.svg np$np.svg || { echo "FAILED: $np ranks differ"; failures=1; }
done

# A section beside all bodies is said to be one.
expect 0 'no object at --cut 1000' "$RAYMAP" draw a.raymap --view yz --cut 1000 -o far.svg
grep -q 'where no object is' far.svg || { echo "FAILED: far.svg does not say that no object is there"; failures=1; }
expect 0 'drawn' "$RAYMAP" draw a.raymap --view yz --cut 1 -o near.svg
! grep -q 'where no object is' near.svg || { echo "FAILED: near.svg says that no object is there"; failures=1; }

# Rays near a section's plane, and how many of how many they are, for any number of ranks.
for np in 1 3; do
    by_ranks $np
    expect 0 'of the first 20000 stay within 0.5 mm' "${start[@]}" "$RAYMAP" draw a.raymap --view yz --near 0.5 --limit 200 -o near$np.svg
done
cmp near1.svg near3.svg || { echo "FAILED: 3 ranks find other rays near the plane"; failures=1; }
grep -q 'of the first 20,000 of 20,000 rays 1,[0-9]* run within 0.5 mm of its plane' near1.svg || { echo "FAILED: near1.svg does not say how many are near"; failures=1; }
expect 0 '"near": 20000' "$RAYMAP" draw a.raymap --view yz --near 1e6 --limit 200 --json -o all.svg
expect 2 'say --view yz, xz or xy' "$RAYMAP" draw a.raymap --view 3d --near 1 -o b.svg
expect 2 'a length above 0' "$RAYMAP" draw a.raymap --near 0 -o b.svg
expect 2 'near is for sections' "$RAYMAP" draw a.raymap --near 1 -o b.vtp

# A stretched section says so and has a scale for each direction; one of a slender scene is stretched by itself.
expect 0 '' "$RAYMAP" draw a.raymap --view yz --stretch 3 -o stretched.svg
grep -q 'stretched upwards 3 times' stretched.svg || { echo "FAILED: stretched.svg does not say so"; failures=1; }
[ "$(grep -cE '>[0-9.]+ mm<' stretched.svg)" -eq 2 ] || { echo "FAILED: stretched.svg has not two scales"; failures=1; }
expect 0 '' "$RAYMAP" trace "$SOURCE_DIR/examples/mirage/scene.yaml" -o road.raymap -n 100 --quiet
expect 0 '' "$RAYMAP" draw road.raymap -o road.svg
grep -q 'stretched upwards 20 times' road.svg || { echo "FAILED: road.svg is flat"; failures=1; }
expect 2 'is for sections' "$RAYMAP" draw a.raymap --view 3d --stretch 2 -o b.svg
expect 2 'is for sections' "$RAYMAP" draw a.raymap --stretch 0 -o b.svg

expect 2 '\-o OUT.svg' "$RAYMAP" draw a.raymap
expect 2 '\.svg, \.png, \.html, \.vtp, \.glb or \.gltf' "$RAYMAP" draw a.raymap -o a.pdf
expect 2 'exists' "$RAYMAP" draw a.raymap -o yz.svg
expect 2 'yz, xz, xy or 3d' "$RAYMAP" draw a.raymap -o b.svg --view zz
expect 2 'limit' "$RAYMAP" draw a.raymap -o b.svg --limit 0
expect 3 'criterion:1:5' "$RAYMAP" draw a.raymap -o b.svg --where 'hit(lenz)'
expect 3 "there is no folder 'no/folder'" "$RAYMAP" draw a.raymap -o no/folder/b.svg
finish
