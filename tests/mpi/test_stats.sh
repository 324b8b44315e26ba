#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: raymap stats says the same, byte for byte, for any number of ranks and threads, and
# either encoding, with the values in memory and without.
. "$(dirname "$0")/../cli/expect.bash"
rm -rf ./*
write_scene scene.yaml
expect 0 '' "$RAYMAP" trace scene.yaml -o plain.raymap -n 30000 --encoding plain --quiet
expect 0 '' "$RAYMAP" convert plain.raymap -o compact.raymap --encoding compact --quiet
for np in 1 2 ${SLOW:+3}; do
    by_ranks $np
    rm -f m.raymap
    ln -s "$([ $((np % 2)) -eq 1 ] && echo plain || echo compact).raymap" m.raymap
    run=("${start[@]}" "$RAYMAP" stats m.raymap --json --threads $((5 - np)))
    expect 0 '"kurtosis"' "${run[@]}" --of path_length --by source
    cp stdout.txt path$np.json
    expect 0 '"outside"' "${run[@]}" --of 'x(sensor)' --of 'y(sensor)' --where 'x(sensor) < 1'
    cp stdout.txt spot$np.json
    expect 0 '"quantiles"' "${run[@]}" --of optical_path --memory 1000
    cp stdout.txt lean$np.json
    expect 0 '"criterion"' "${run[@]}" --of 'y(sensor)' --memory 1000 -w 'registered(sensor, rect(-1, -1, 0, 1))' -w 'segments > 2'
    cp stdout.txt apart$np.json
    expect 0 'by object' "${start[@]}" "$RAYMAP" query m.raymap 'segments > 2' --by object --quiet --threads $((5 - np))
    cp stdout.txt groups$np.json
    expect 0 '(others)' "${run[@]}" --of 'angle(sensor)' --by path --top 3
    cp stdout.txt classes$np.json
    for kind in path spot lean apart groups classes; do
        cmp ${kind}1.json $kind$np.json || { echo "FAILED: $kind: $np ranks differ"; failures=1; }
    done
    expect 3 "did you mean 'wavelength'" "${start[@]}" "$RAYMAP" stats m.raymap --of wavelengh
    expect 2 '1000000000 bins' "${start[@]}" "$RAYMAP" stats m.raymap --of flux --bins 1e9
done
finish
