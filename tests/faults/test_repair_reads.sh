#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: a file that cannot be read for a moment, or memory that is short, is not taken for
# damage. A command ends with status 5 and loses nothing; once the system works again, repair saves
# what it would have saved. It does not matter whether our own reading fails or HDF5's.
. "$(dirname "$0")/../cli/expect.bash"
. "$(dirname "$0")/../faults/commits.bash"
rm -rf ./*
write_scene scene.yaml
rays() { "$RAYMAP" info "$1" --json | sed -n 's/.*"rays": \([0-9]*\),/\1/p' | head -1; }

expect 0 '' "$RAYMAP" trace scene.yaml -o one.raymap -n 60000 --encoding plain --threads 1 --quiet
# One byte of a stored chunk, so that repair has a piece to replace.
piece=one.raymap/shard-00000/piece-00000.h5
printf '\377' | dd of=$piece bs=1 seek=$(($(stat -c %s $piece) / 2)) conv=notrunc status=none
cp -r one.raymap want.raymap
expect 0 'lost' "$RAYMAP" repair want.raymap
saved=$(rays want.raymap)
[ "$saved" -gt 0 ] && [ "$saved" -lt 60000 ] || { echo "FAILED: the damage saves $saved rays"; failures=1; }
fail() { echo "FAILED: $*"; failures=$((failures + 1)); }

# Makes a command on a copy of a map suffer an error at some of its calls, from the first to the last.
suffer() { # MAP RAYS SAVED CALLS PATH ERROR POINTS COMMAND...: 0 and RAYS, or 5; then repair: SAVED at least
    local from=$1 rays=$2 saved=$3 calls=$4 path=$5 error=$6 points=$7 k at n status
    shift 7
    local faults=(env "LD_PRELOAD=$FAULTS" "FAULTS_DIR=$PWD" "FAULTS_CALLS=$calls" "FAULTS_PATH=$path")
    rm -rf m.raymap log.0 && cp -r "$from" m.raymap
    "${faults[@]}" "FAULTS_LOG=$PWD/log" "$RAYMAP" "$@" >out.txt 2>&1
    n=$(wc -l <log.0)
    [ "$n" -gt 0 ] || fail "$*: no $calls of $path"
    for ((k = 0; k < points; k++)); do
        at=$((1 + (n - 1) * k / (points - 1)))
        rm -rf m.raymap && cp -r "$from" m.raymap
        "${faults[@]}" "FAULTS_ACTION=$error" FAULTS_AT=$at "$RAYMAP" "$@" >out.txt 2>&1
        status=$?
        [ $status -eq 5 ] || [ $status -eq 0 ] ||
            { fail "$*: $calls of $path no. $at of $n: status $status"; tail -3 out.txt; }
        "$RAYMAP" repair m.raymap --json >out.txt 2>&1 || cat out.txt
        n_left=$(sed -n 's/^  "rays": \([0-9]*\),/\1/p' out.txt | head -1)
        [ "$n_left" = "$saved" ] || [ "$n_left" = "$rays" ] ||
            fail "$*: $calls of $path no. $at of $n: $n_left rays are saved, not $saved"
    done
}

for call in 'read:pread *piece-*.h5' 'read:open *map.h5' 'read:pread *map-start.h5' \
    ${SLOW:+'read:open *piece-*.h5' 'read:pread *map.h5'}; do
    suffer one.raymap "$saved" "$saved" "${call%% *}" "${call#* }" EIO 2 repair m.raymap
done
suffer one.raymap "$saved" "$saved" 'memory:*' '*' ENOMEM 2 repair m.raymap
suffer one.raymap "$saved" "$saved" 'read:pread' '*' EAGAIN 2 repair m.raymap

# What cannot be looked at just now is neither missing, nor damaged, nor under its own name: a piece that is replaced, one
# that nobody lists, one that stands under another's name, the folder that is to take the new piece.
for more in '' --append; do
    expect 0 '' "$RAYMAP" trace scene.yaml -o few.raymap -n 4000 --encoding plain --threads 1 --quiet $more
done
(
    cd few.raymap/shard-00000 || exit
    cp piece-00001.h5 piece-00007.h5
    cp piece-00000.h5 piece-00001.h5
    printf '\377' | dd of=piece-00000.h5 bs=1 seek=$(($(stat -c %s piece-00000.h5) / 2)) conv=notrunc status=none
)
for call in 'read:stat */piece-0000[07].h5' 'read:stat */shard-00001' 'read:open *piece-00001.h5'; do
    faults=(env "LD_PRELOAD=$FAULTS" "FAULTS_DIR=$PWD" "FAULTS_CALLS=${call%% *}" "FAULTS_PATH=${call#* }")
    rm -rf m.raymap log.0 && cp -r few.raymap m.raymap
    "${faults[@]}" "FAULTS_LOG=$PWD/log" "$RAYMAP" repair m.raymap --threads 1 >out.txt 2>&1
    [ -s log.0 ] || fail "no $call"
    n=$(wc -l <log.0)
    [ "${call#*shard-00001}" ] || n=1 # later ones look at what stands in it
    for ((at = 1; at <= n; at++)); do
        rm -rf m.raymap && cp -r few.raymap m.raymap
        expect 5 'Input/output error' "${faults[@]}" FAULTS_ACTION=EIO FAULTS_AT=$at "$RAYMAP" repair m.raymap --threads 1
    done
done

# The same of what a killed trace left.
set_at_commit 3 kill
"${at_commit[@]}" "$RAYMAP" trace scene.yaml -o cut.raymap -n 24000 --quiet --threads 1 --flush-portions 1 &
wait $! && fail "the trace is not killed"
saved=$(rays cut.raymap)
# What cannot be looked at just now is not missing.
for words in '*m.raymap repair m.raymap' \
    '*map.h5 trace scene.yaml -n 24000 -o m.raymap --resume --quiet'; do
    rm -rf m.raymap && cp -r cut.raymap m.raymap
    # shellcheck disable=SC2086 # words
    expect 5 'm.raymap.*: Input/output error' env "LD_PRELOAD=$FAULTS" "FAULTS_DIR=$PWD" \
        FAULTS_CALLS=read:stat "FAULTS_PATH=${words%% *}" FAULTS_AT=1 FAULTS_ACTION=EIO \
        "$RAYMAP" ${words#* }
done
turn=0 # a quick run takes every third pair: each command, each call
for words in 'repair m.raymap' 'trace scene.yaml -n 24000 -o m.raymap --resume --quiet' \
    'query m.raymap registered(sensor) --count'; do
    turn=$((turn + 1))
    for call in 'read:* *.journal' 'read:* *.part' 'read:pread *map.h5' 'memory:* *'; do
        turn=$((turn + 1))
        [ "$SLOW" ] || [ $((turn % 3)) -eq 0 ] || continue
        error=EIO
        [ "${call%%:*}" = read ] || error=ENOMEM
        # shellcheck disable=SC2086 # words
        suffer cut.raymap 24000 "$saved" "${call%% *}" "${call#* }" $error 2 $words
    done
done
finish
