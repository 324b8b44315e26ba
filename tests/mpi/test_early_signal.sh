#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: a signal that comes before the first ray is traced (the scene is read, the map begun,
# what a killed run left is taken in) ends a trace as any other does: status 6, a map that tells the
# truth, and --resume makes it whole.
. "$(dirname "$0")/../cli/expect.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
rm -rf ./*
write_scene scene.yaml
rays=50000

at_call() { # CALLS PATH ACTION [N]: sets the array `disturbed`, words before the program
    disturbed=(env "LD_PRELOAD=$FAULTS" "FAULTS_DIR=$PWD"
        "FAULTS_CALLS=$1" "FAULTS_PATH=$2" "FAULTS_ACTION=$3" "FAULTS_AT=${4:-1}")
}
digest() { "$RAYMAP" info "$1" --json | sed -n 's/.*"digest": "\(.*\)".*/\1/p'; }
trace=("$RAYMAP" trace scene.yaml -n $rays --quiet --flush-portions 1)

expect 0 '' "${trace[@]}" -o want.raymap
for ranks in 2 ${SLOW:+1}; do
    rm -rf m.raymap
    at_call read:open '*scene.yaml' SIGUSR1
    expect 6 'SIGUSR1: [0-9,]+ of 50,000 rays' mpirun -np $ranks "${disturbed[@]}" "${trace[@]}" -o m.raymap
    expect 0 'NOT complete' "$RAYMAP" info m.raymap
    at_call mkdir '*m.raymap*' SIGUSR1
    expect 6 'SIGUSR1' mpirun -np $ranks "${disturbed[@]}" "${trace[@]}" -o m.raymap --resume
    at_call fdatasync '*.journal' kill 2
    expect 137 '' mpirun -np $ranks "${disturbed[@]}" "${trace[@]}" -o m.raymap --resume
    ls m.raymap/shard-*/.*.journal >/dev/null || { echo "FAILED: no journal is left"; failures=1; }
    at_call read:open '*.journal' SIGUSR1
    expect 6 'SIGUSR1' mpirun -np $ranks "${disturbed[@]}" "${trace[@]}" -o m.raymap --resume
    expect 0 '' "$RAYMAP" verify m.raymap
    expect 0 '' "${trace[@]}" -o m.raymap --resume
    [ "$(digest m.raymap)" = "$(digest want.raymap)" ] || { echo "FAILED: another digest"; failures=1; }
done

# Nothing is left to trace: nothing is stopped.
at_call read:open '*scene.yaml' SIGUSR1
expect 0 'complete' "${disturbed[@]}" "$RAYMAP" trace scene.yaml -o m.raymap --resume
# A picture has none of its passes; questions have nothing to close: they die as ever.
sed '$a\cameras: [{name: eye, type: pinhole, at: [0, 0, -60], direction: [0, 0, 1], fov: 20, resolution: [8, 8]}]' \
    scene.yaml >seen.yaml
at_call read:open '*seen.yaml' SIGUSR1
expect 6 'SIGUSR1' "${disturbed[@]}" "$RAYMAP" render seen.yaml -o seen.png
at_call read:open '*m.raymap/map.h5' SIGUSR1
expect 138 '' "${disturbed[@]}" "$RAYMAP" info m.raymap 2>/dev/null
finish
