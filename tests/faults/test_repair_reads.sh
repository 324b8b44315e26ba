#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: a file that cannot be read for a moment is not taken for damaged. `repair` ends with
# status 5 and loses nothing; once reading works, it saves what it would have saved.
. "$(dirname "$0")/../cli/expect.bash"
rm -rf ./*
write_scene scene.yaml
rays() { "$RAYMAP" info "$1" --json | sed -n 's/.*"rays": \([0-9]*\),/\1/p' | head -1; }

expect 0 '' "$RAYMAP" trace scene.yaml -o one.raymap -n 150000 --encoding plain --threads 1 --quiet
# One byte of a stored chunk, so that repair has a piece to replace.
piece=one.raymap/shard-00000/piece-00000.h5
printf '\377' | dd of=$piece bs=1 seek=$(($(stat -c %s $piece) / 2)) conv=notrunc status=none
cp -r one.raymap want.raymap
expect 0 'lost' "$RAYMAP" repair want.raymap
saved=$(rays want.raymap)
[ "$saved" -gt 0 ] && [ "$saved" -lt 150000 ] || { echo "FAILED: the damage saves $saved rays"; failures=1; }
for call in 'read:pread *piece-*.h5' 'read:open *piece-*.h5' 'read:open *map.h5' 'read:pread *map.h5'; do
    for at in 1 3 9 27; do
        rm -rf m.raymap && cp -r one.raymap m.raymap
        env "LD_PRELOAD=$FAULTS" "FAULTS_DIR=$PWD" "FAULTS_CALLS=${call%% *}" "FAULTS_PATH=${call#* }" \
            FAULTS_ACTION=EIO FAULTS_AT=$at "$RAYMAP" repair m.raymap >out.txt 2>&1
        status=$?
        [ $status -eq 0 ] || [ $status -eq 5 ] ||
            { echo "FAILED: ${call} no. $at: status $status"; tail -3 out.txt; failures=$((failures + 1)); }
        "$RAYMAP" repair m.raymap >out.txt 2>&1 || cat out.txt
        [ "$(rays m.raymap)" = "$saved" ] ||
            { echo "FAILED: ${call} no. $at: $(rays m.raymap) rays are saved, not $saved"; failures=$((failures + 1)); }
    done
done
finish
