#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: under mpirun an error is told once, every rank leaves with it, and nothing hangs.
. "$(dirname "$0")/../cli/expect.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
rm -rf ./*
write_scene scene.yaml

once() { # STATUS WORDS ARGUMENTS...: on 3 ranks; WORDS are said exactly once
    local status=$1 words=$2
    shift 2
    expect "$status" "$words" mpirun -np 3 "$RAYMAP" "$@"
    local n
    n=$(grep -Ec -e "$words" stderr.txt)
    [ "$n" -eq 1 ] || { echo "FAILED: '$words' said $n times: $*"; failures=1; }
}
once 2 "no command 'trase'" trase
once 2 'at least one ray' trace scene.yaml -o x.raymap -n 0
once 3 'missing.yaml' trace missing.yaml -o x.raymap
once 3 'missing.raymap' query missing.raymap all
once 5 'x.raymap' trace scene.yaml -o /proc/x.raymap -n 1000
expect 0 '' mpirun -np 3 "$RAYMAP" trace scene.yaml -o a.raymap -n 100k --quiet
once 2 'a.raymap' trace scene.yaml -o a.raymap -n 1000
once 3 "no object named 'lense'|named 'lense'" query a.raymap 'hit(lense)'
once 6 'time limit' trace scene.yaml -o late.raymap -n 1G --time-limit 1s --quiet
expect 0 'NOT complete' "$RAYMAP" info late.raymap

# A damaged piece of another rank's shard: all ranks leave, with the status of damage.
mv a.raymap/shard-00001 hidden
once 4 'shard-00001' query a.raymap all
mv hidden a.raymap/shard-00001
truncate -s -2000 a.raymap/shard-00002/piece-00000.h5
once 4 'shard-00002' query a.raymap all

# SIGUSR1 given to mpirun reaches the ranks; the map can be asked.
mpirun -np 2 "$RAYMAP" trace scene.yaml -o usr1.raymap -n 1G --quiet 2>stderr.txt &
until_traces usr1.raymap
kill -USR1 $!
wait $!
status=$?
[ $status -eq 6 ] && grep -q SIGUSR1 stderr.txt || { echo "FAILED: SIGUSR1 to mpirun: $status"; cat stderr.txt; failures=1; }
expect 0 'NOT complete' mpirun -np 2 "$RAYMAP" info usr1.raymap
rm -rf ./*.raymap
finish
