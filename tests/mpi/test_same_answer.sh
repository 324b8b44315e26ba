#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: any number of ranks and threads, and either encoding, gives the same rays, the same
# answers byte for byte and the same images.
. "$(dirname "$0")/../cli/expect.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
rm -rf ./*
write_scene scene.yaml
rays=30001 # several blocks, the last of them a short one
criterion='registered(sensor) and hit(*, transmit_specular) >= 2'

trace() { # RANKS THREADS MAP
    local encoding=plain
    [ $(($1 % 2)) -eq 1 ] || encoding=compact
    by_ranks "$1"
    expect 0 '' "${start[@]}" "$RAYMAP" trace scene.yaml -o "$3" -n $rays --threads "$2" --encoding $encoding --quiet
}
answer() { # RANKS THREADS MAP PREFIX: everything that can be asked, into PREFIX.*
    by_ranks "$1"
    local run=("${start[@]}" "$RAYMAP")
    expect 0 '' "${run[@]}" query "$3" "$criterion" 'ended(left)' --threads "$2" --quiet
    cp stdout.txt "$4.count"
    expect 0 '' "${run[@]}" query "$3" "$criterion" 'hit(lens)' --json --threads "$2" --quiet
    grep -Ev '"(seconds|bytes_read)"' stdout.txt >"$4.sums"
    grep '"bytes_read"' stdout.txt >"$4.bytes"
    expect 0 '' "${run[@]}" query "$3" "$criterion" --limit 17 --threads "$2" --quiet
    cp stdout.txt "$4.limit"
    expect 0 '' "${run[@]}" query "$3" 'event(reflect_diffuse) and ray < 15000' -o "$4.csv" --threads "$2" --quiet
    expect 0 '' "${run[@]}" query "$3" "$criterion and ray < 3000" -o "$4.json" --threads "$2" --quiet
    expect 0 '' "${run[@]}" detector "$3" sensor -o "$4.sensor.csv" --threads "$2" --quiet
    expect 0 '' "${run[@]}" detector "$3" sensor --where "$criterion" -o "$4.where.csv" --threads "$2" --quiet
}
digest() {
    "$RAYMAP" info "$1" --json | sed -n 's/.*"digest": "\([0-9a-f]\{32\}\)".*/\1/p'
}

expect 0 '' "$RAYMAP" trace scene.yaml -o alone.raymap -n $rays --threads 1 --encoding compact --quiet
answer 1 1 alone.raymap reference
want=$(digest alone.raymap)
[ ${#want} -eq 32 ] || { echo "FAILED: no digest"; failures=1; }
same() { # PREFIX RANKS: as the reference
    for file in reference.*; do
        [ "$1.${file#*.}" = other.bytes ] || # other ranks cut other chunks
            cmp "$file" "$1.${file#*.}" || { echo "FAILED: ${file#*.} differs ($1, $2 ranks)"; failures=1; }
    done
    rm "$1".*
}
# The map of many ranks asked by as many.
for ranks in 3 ${SLOW:+1 2 4}; do
    trace $ranks $((1 + ranks % 2)) map.raymap
    [ "$(digest map.raymap)" = "$want" ] || { echo "FAILED: another digest ($ranks ranks)"; failures=1; }
    answer $ranks 2 map.raymap other
    same other $ranks
    rm -rf map.raymap
done
# The map of one rank asked by many: paths that many rays share are read by every rank, and counted once.
for ranks in 2 ${SLOW:+1 3}; do
    answer $ranks 2 alone.raymap many
    same many $ranks
done

# Another number of rays only adds rays; another seed gives others.
expect 0 '' "$RAYMAP" trace scene.yaml -o more.raymap -n 40000 --quiet
expect 0 '' "$RAYMAP" query more.raymap "$criterion and ray < 3000" -o more.json --quiet
cmp reference.json more.json >/dev/null && { echo "FAILED: flux per ray must change with the number of rays"; failures=1; }
expect 0 '' "$RAYMAP" trace scene.yaml -o other.raymap -n $rays --seed 2 --quiet
[ "$(digest other.raymap)" != "$want" ] || { echo "FAILED: another seed, the same rays"; failures=1; }

# Weights that are parts (energy that fluorescence leaves), which no order of adding may show.
cat >dye.yaml <<'END'
raymap: 1
units: mm
spectrum: {wavelengths: [450, 540, 600]}
media:
  air: {index: 1}
  dye: {index: 1.5, absorption: 0.1, accounting: energy, species: {d: {absorption: {wavelength: [450, 500], value: [5 /cm, 0]}, emission: {led: {peak: 560, width: 60}}, yield: 0.9}}}
surfaces: {black: {type: absorber}}
geometries: {slab: {type: box, size: [20, 20, 6]}, wall: {type: rectangle, size: [50, 50]}}
objects:
  - {name: slab, geometry: slab, at: [0, 0, 20], surface: fresnel, inside: dye, outside: air}
  - {name: end, geometry: wall, at: [0, 0, 40], surface: black, outside: air}
sources: [{name: uv, type: point, at: [0, 0, 0], distribution: {cone: 40}, spectrum: {lines: {450: 1, 540: 0.2}}, flux: 1 W}]
detectors: [{name: screen, type: plane, on: end, cells: [5, 5]}]
END
for seed in 1 2; do
    expect 0 '' "$RAYMAP" trace dye.yaml -o dye$seed.raymap -n $rays --seed $seed --quiet
done
weighed() { # RANKS THREADS: sums of weights
    by_ranks "$1"
    for words in 'query dye1.raymap all registered(screen) --count' 'detector dye1.raymap screen' 'report dye1.raymap --energy' \
        'paths dye1.raymap --detector screen' 'stats dye1.raymap --of x(screen) --by source' 'compare dye1.raymap dye2.raymap'; do
        # shellcheck disable=SC2086 # words
        "${start[@]}" "$RAYMAP" $words --json --threads "$2" --quiet | grep -Ev '"(seconds|bytes_read)"'
    done
}
weighed 1 1 >alone.txt
[ "$(grep -c standard_error alone.txt)" -gt 20 ] || { echo "FAILED: no sums: $(cat alone.txt)"; failures=1; }
for run in '1 4' '1 3' '2 2'; do
    # shellcheck disable=SC2086 # ranks and threads
    weighed $run >others.txt
    diff alone.txt others.txt || { echo "FAILED: sums of weights differ ($run)"; failures=1; }
done
rm -rf ./*.raymap
finish
