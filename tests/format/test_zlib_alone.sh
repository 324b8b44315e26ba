#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: a build with zlib alone (RAYMAP_ZLIB, which links it in libdeflate's place) traces maps with the same digests
# in both encodings, and each build reads the other's maps.
. "$(dirname "$0")/../cli/expect.bash"
scene=$SOURCE_DIR/examples/room/scene.yaml
ours=${RAYMAP_PROGRAM:-$RAYMAP}

digest() { # PROGRAM MAP, all of which it has read
    "$1" verify "$2" --quiet >verify.txt 2>&1 && "$1" info "$2" --json | sed -n 's/.*"digest": "\(.*\)",*/\1/p'
}

expect 0 'libdeflate not used' sh -c "'$RAYMAP_ZLIB' --version | tr -s ' '"
for encoding in compact plain; do
    expect 0 '' "$ours" trace "$scene" -o ours.raymap -n 4500 --encoding $encoding --force
    expect 0 '' "$RAYMAP_ZLIB" trace "$scene" -o zlib.raymap -n 4500 --encoding $encoding --force
    for program in "$ours" "$RAYMAP_ZLIB"; do
        for map in ours.raymap zlib.raymap; do
            found=$(digest "$program" $map)
            [ -n "$found" ] && [ "$found" = "${first:=$found}" ] || {
                echo "FAILED: $program $map, $encoding: digest '$found', not '$first'"
                failures=$((failures + 1))
            }
        done
    done
    expect 0 '' "$RAYMAP_ZLIB" convert ours.raymap -o again.raymap --encoding plain --force
    [ "$(digest "$ours" again.raymap)" = "$first" ] || { echo 'FAILED: converted'; failures=$((failures + 1)); }
done
finish
