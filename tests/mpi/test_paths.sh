#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: any number of ranks and threads finds the same classes of paths, byte for byte, when
# all are counted and when a sketch chooses the large ones.
. "$(dirname "$0")/../cli/expect.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
rm -rf ./*
expect 0 '' "$RAYMAP" trace "$SOURCE_DIR/examples/room/scene.yaml" -o room.raymap -n 30000 --encoding plain --quiet

answer() { # RANKS THREADS PREFIX
    by_ranks "$1"
    local run=("${start[@]}" "$RAYMAP" paths room.raymap --threads "$2" --quiet)
    expect 0 '' "${run[@]}" --json --top 50
    cp stdout.txt "$3.all"
    expect 0 '' "${run[@]}" --exact 1000 -o "$3.csv" --top all --force
    cat stdout.txt "$3.csv" >"$3.sketch"
    expect 0 '' "${run[@]}" --by group --collapse --detector floor_map --json
    cp stdout.txt "$3.group"
    rm "$3.csv"
}
answer 1 1 reference
grep -q '"exact": true' reference.all || { echo "FAILED: not exact"; failures=1; }
grep -q 'more than are counted' reference.sketch || { echo "FAILED: no sketch"; failures=1; }
[ "$(wc -l <reference.sketch)" -gt 40 ] || { echo "FAILED: few rows"; failures=1; }
for way in '3 2' ${SLOW:+'1 2' '2 1'}; do
    read -r ranks threads <<<"$way"
    answer "$ranks" "$threads" other
    for kind in all sketch group; do
        cmp "reference.$kind" "other.$kind" || { echo "FAILED: $kind, $ranks ranks, $threads threads"; failures=1; }
    done
done

# An index tells the same paths.
expect 0 '' "$RAYMAP" trace "$SOURCE_DIR/examples/double-gauss/scene.yaml" -o lens.raymap -n 20000 --encoding plain --quiet
lens() { # PREFIX COMMAND...
    local prefix=$1
    shift
    expect 0 '' "$@" --no-peaks --top all --json
    cp stdout.txt "$prefix.all"
    expect 0 '' "$@" --no-peaks --by group --collapse --where 'not hit(cover.*)' --json
    cp stdout.txt "$prefix.group"
    expect 0 '' "$@" --no-peaks --no-events --detector sensor --exact 40 --json
    cp stdout.txt "$prefix.sketch"
}
lens columns "$RAYMAP" paths lens.raymap --quiet
expect 0 '' "$RAYMAP" index lens.raymap --quiet
for ranks in 1 2; do
    by_ranks $ranks
    lens index "${start[@]}" "$RAYMAP" paths lens.raymap --threads 2 --quiet
    for kind in all group sketch; do
        cmp "columns.$kind" "index.$kind" || { echo "FAILED: indexed, $kind, $ranks ranks"; failures=1; }
    done
done
finish
