#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: raymap compare says the same, byte for byte, for any number of ranks and threads.
. "$(dirname "$0")/../cli/expect.bash"
rm -rf ./*
write_scene scene.yaml
for seed in 1 2; do
    expect 0 '' "$RAYMAP" trace scene.yaml -o $seed.raymap -n 30000 --seed $seed --quiet
done
for np in 1 3; do
    by_ranks $np
    expect 0 '"tests"' "${start[@]}" "$RAYMAP" compare 1.raymap 2.raymap --json --threads $((5 - np)) --of wavelength \
        --of 'angle(sensor)' --test image,paths,object,detector -o n$np.json
    cp stdout.txt two$np.json
    expect 0 '"tests"' "${start[@]}" "$RAYMAP" compare 1.raymap --json --where 'registered(sensor where x < 1)' \
        --where 'registered(sensor where x > -1)' -o d$np.csv
    cp stdout.txt one$np.json
    cmp d1.csv d$np.csv && cmp n1.json n$np.json ||
        { echo "FAILED: files of $np ranks differ"; failures=1; }
    cmp two1.json two$np.json && cmp one1.json one$np.json ||
        { echo "FAILED: $np ranks differ"; failures=1; }
    expect 3 'criterion:1:5' "${start[@]}" "$RAYMAP" compare 1.raymap 2.raymap --where 'hit(lenz)'
done
finish
