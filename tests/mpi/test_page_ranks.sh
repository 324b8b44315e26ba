#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: a page is the same, byte for byte, for any number of ranks, with images of all rays
# and of those that match.
. "$(dirname "$0")/../cli/expect.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
rm -rf ./*
write_scene scene.yaml
expect 0 '' mpirun -np 2 "$RAYMAP" trace scene.yaml -o a.raymap -n 30000 --quiet
for np in 1 3; do
    by_ranks $np
    expect 0 '' "${start[@]}" "$RAYMAP" draw a.raymap -o all$np.html --quiet
    expect 0 '' "${start[@]}" "$RAYMAP" draw a.raymap --where 'hit(lens.2, reflect)' --limit 700 -o some$np.html --quiet
    for kind in all some; do
        cmp ${kind}1.html $kind$np.html || { echo "FAILED: $np ranks write another page"; failures=$((failures + 1)); }
    done
done
finish
