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
rm -rf ./*.raymap
finish
