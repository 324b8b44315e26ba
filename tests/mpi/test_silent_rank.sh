#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: a rank that hangs is named, with its host; a trace with a time limit ends without it,
# and --resume makes the map whole; other commands go on when it does. And what crashes ends at once.
. "$(dirname "$0")/../cli/expect.bash"
. "$(dirname "$0")/../faults/commits.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
export OMPI_MCA_orte_abort_timeout=1 OMPI_MCA_odls_base_sigkill_timeout=0
export RAYMAP_TEST_PACE=0.1 # 2 s of silence, 3 s beyond the time limit
rm -rf ./*
write_scene scene.yaml
rays=500000
silent='rank 1 on [^ ]+ has not answered for [0-9]+ s'

digest() { "$RAYMAP" info "$1" --json | sed -n 's/.*"digest": "\(.*\)".*/\1/p'; }
fail() { echo "FAILED: $*"; failures=$((failures + 1)); }

# Rank 1 stops at its second commit, for good: the others' rays and its first blocks count.
expect 0 '' "$RAYMAP" trace scene.yaml -o want.raymap -n $rays --quiet
set_at_commit 2 stop
expect 6 "stopped early by the time limit: [0-9,]+ of 500,000 rays.*; rank 1 on [^ ]+ did not answer" \
    mpirun -np 3 "${at_commit[@]}" FAULTS_RANK=1 "$RAYMAP" trace scene.yaml -o m.raymap -n $rays \
    --quiet --threads 1 --flush-portions 1 --time-limit 2s
grep -Eq "$silent" stderr.txt || fail "the silent rank is not named"
for shard in 0 2; do
    [ -e m.raymap/shard-0000$shard/piece-00000.h5 ] || fail "rank $shard did not close its piece"
done
ls m.raymap/shard-00001/.*.journal >/dev/null || fail "no journal of the silent rank"
told=$(sed -n 's/.*limit: \([0-9,]*\) of.*/\1/p' stderr.txt)
# mpirun wakes the stopped rank to end it: at times it finishes the commit that it stopped at.
expect 0 '' "$RAYMAP" info m.raymap
held=$(sed -n 's/^  \([0-9,]*\) rays,.*/\1/p' stdout.txt)
((${held//,/} >= ${told//,/} && ${held//,/} <= ${told//,/} + 4096)) || fail "$told rays were told, the map has $held"
h5ls m.raymap/map.h5/piece | grep -q 'shard .*{2}' || fail "the index lists other pieces than the two"
expect 0 '0 findings' "$RAYMAP" verify m.raymap
expect 0 '' mpirun -np 2 "$RAYMAP" trace scene.yaml -o m.raymap -n $rays --resume --quiet
[ "$(digest m.raymap)" = "$(digest want.raymap)" ] || fail "another digest"
expect 0 '0 findings' "$RAYMAP" verify m.raymap

# A rank that goes on is forgiven. Open MPI's handlers are not there: a crash would end at once.
mpirun -np 3 env "LD_PRELOAD=$FAULTS" "FAULTS_DIR=$PWD" FAULTS_CALLS=read:open \
    'FAULTS_PATH=*map.h5' FAULTS_AT=1 FAULTS_ACTION=stop FAULTS_RANK=1 \
    "$RAYMAP" verify m.raymap >stdout.txt 2>stderr.txt </dev/null &
job=$!
for ((i = 0; i < 600; i++)); do
    ! grep -Eq "$silent" stderr.txt || break
    sleep 0.1
done
stopped=$(ps -o pid=,stat= --ppid $job | sed -n 's/ *\([0-9]*\) *T.*/\1/p')
[ -n "$stopped" ] || { fail "no rank of verify stops"; kill $job; finish; }
caught=$((0x$(sed -n 's/^SigCgt:\t*//p' "/proc/$stopped/status")))
for signal in 6 7 8 11; do
    (((caught & 1 << (signal - 1)) == 0)) || fail "signal $signal is caught"
done
kill -CONT "$stopped"
wait $job || fail "verify ends with $?"
grep -Eq "$silent" stderr.txt || fail "verify does not tell of the silent rank"
grep -Eq 'rank 1 on [^ ]+ answers again' stderr.txt || fail "nor that it answers again"
grep -q '0 findings' stdout.txt || fail "verify's answer"
finish
