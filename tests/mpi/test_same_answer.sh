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
    [ $((($1 + $2) % 2)) -eq 0 ] || encoding=compact
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
    if "$RAYMAP" detector --help >/dev/null 2>&1; then
        expect 0 '' "${run[@]}" detector "$3" sensor -o "$4.sensor.csv" --threads "$2" --quiet
        expect 0 '' "${run[@]}" detector "$3" sensor --where "$criterion" -o "$4.where.csv" --threads "$2" --quiet
    fi
}
digest() {
    "$RAYMAP" info "$1" --json | sed -n 's/.*"digest": "\([0-9a-f]\{32\}\)".*/\1/p'
}

expect 0 '' "$RAYMAP" trace scene.yaml -o alone.raymap -n $rays --threads 1 --quiet
answer 1 1 alone.raymap reference
want=$(digest alone.raymap)
[ ${#want} -eq 32 ] || { echo "FAILED: no digest"; failures=1; }
# Each number of ranks, of threads and each encoding with the others of its kind.
for ranks in 1 2 3 4; do
    for threads in 1 2; do
        [[ " 12 22 32 41 " == *" $ranks$threads "* ]] || continue
        map=map-$ranks-$threads.raymap
        trace $ranks $threads $map
        got=$(digest $map)
        [ "$got" = "$want" ] || { echo "FAILED: digest $got, not $want ($ranks ranks, $threads threads)"; failures=1; }
        # the map of many ranks asked by as many, and once the map of one rank asked by many
        answer $ranks $threads $map other
        [ $ranks$threads != 32 ] || answer 3 2 alone.raymap many
        for file in reference.*; do
            kind=${file#reference.}
            for prefix in other many; do
                [ $prefix = other ] || [ $ranks$threads = 32 ] || continue
                # other ranks cut other chunks
                [ $prefix-$kind != other-bytes ] || continue
                cmp "$file" "$prefix.$kind" || { echo "FAILED: $kind differs ($prefix, $ranks ranks, $threads threads)"; failures=1; }
            done
        done
        rm -rf other.* many.* $map
    done
done

# Paths that many rays of a compact map share are read by every rank, and counted once.
expect 0 '' "$RAYMAP" convert alone.raymap -o compact.raymap --encoding compact --quiet
for ranks in 1 3; do
    answer $ranks 2 compact.raymap compact-$ranks
    for file in compact-1.*; do
        cmp "$file" "compact-$ranks.${file#compact-1.}" || { echo "FAILED: compact, $ranks ranks"; failures=1; }
    done
    for kind in count sums limit csv json sensor.csv where.csv; do
        cmp "reference.$kind" "compact-$ranks.$kind" || { echo "FAILED: compact, $kind, $ranks ranks"; failures=1; }
    done
done

# Another number of rays only adds rays; another seed gives others.
expect 0 '' "$RAYMAP" trace scene.yaml -o more.raymap -n 70000 --quiet
expect 0 '' "$RAYMAP" query more.raymap "$criterion and ray < 3000" -o more.json --quiet
cmp reference.json more.json >/dev/null && { echo "FAILED: flux per ray must change with the number of rays"; failures=1; }
expect 0 '' "$RAYMAP" trace scene.yaml -o other.raymap -n $rays --seed 2 --quiet
[ "$(digest other.raymap)" != "$want" ] || { echo "FAILED: another seed, the same rays"; failures=1; }
rm -rf ./*.raymap
finish
