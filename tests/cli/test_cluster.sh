#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: recipes of docs/cluster.md run as they stand there, with a tenth of the rays (a queue's commands are played by small ones that
# run at once what they are given), threads follow the batch system, times are taken as they are written on clusters, and
# logs get lines with the clock.
. "$(dirname "$0")/expect.bash"
rm -rf ./*
write_scene scene.yaml
fail() {
    printf 'FAILED: %s\n' "$*"
    failures=$((failures + 1))
}

for time in 3h50min '1.5 min' 90 1:30:00 1-12; do
    expect 0 '' "$RAYMAP" trace scene.yaml --no-record -n 10 --quiet --time-limit "$time"
done
for time in 50min3h 3h50 1: 1- -1 1:2:3:4 0:00:00 1e999 ''; do
    expect 2 "must be a time above 0 .*3h50min, 1:30:00, 1-00:00:00.*not '$time'" \
        "$RAYMAP" trace scene.yaml --no-record -n 10 --time-limit "$time"
done

threads() { # VARIABLES...: how many the program starts with
    env "$@" "$RAYMAP" trace scene.yaml --no-record -n 10 --quiet --json | sed -n 's/^ *"threads": *\([0-9]*\).*/\1/p'
}
cores=$(nproc)
[ "$(threads SLURM_JOB_ID=1 SLURM_CPUS_PER_TASK=1000)" = "$cores" ] || fail "more threads than cores"
[ "$(threads SLURM_CPUS_PER_TASK=1)" = "$cores" ] || fail "a Slurm variable counts outside of a job"
if [ "$(getconf _NPROCESSORS_ONLN)" = "$cores" ]; then
    [ "$(threads SLURM_JOB_ID=1 SLURM_CPUS_PER_TASK=1)" = 1 ] || fail "SLURM_CPUS_PER_TASK is not heeded"
    [ "$(threads PBS_JOBID=1 NCPUS=1)" = 1 ] || fail "NCPUS is not heeded"
    [ "$(threads LSB_JOBID=1 LSB_DJOB_NUMPROC=1)" = 1 ] || fail "LSB_DJOB_NUMPROC is not heeded"
    [ "$(threads JOB_ID=1 NSLOTS=1)" = 1 ] || fail "NSLOTS is not heeded"
fi

# A line with the clock comes every ten seconds, eight of which it is held.
held() {
    "$@" &
    sleep 2
    kill -STOP $!
    sleep 8
    kill -CONT $!
    wait $!
}
expect 6 'stopped early by the time limit: [0-9,]+ of 1,000,000,000 rays traced; the map holds them, and --resume' \
    held "$RAYMAP" trace scene.yaml -o long.raymap -n 1G --time-limit 0:12 --threads 1
grep -Eq '^20[0-9]{2}-[0-9]{2}-[0-9]{2} [0-9]{2}:[0-9]{2}:[0-9]{2} [0-9,]+ of 1,000,000,000 rays \([0-9]+ %\), [0-9,]+/s, [0-9:]+ left$' stderr.txt ||
    fail "no line with the clock: $(cat stderr.txt)"
[ "$(wc -l <stderr.txt)" = 2 ] || fail "more than a line of progress and one of the end: $(cat stderr.txt)"

. "$(dirname "$0")/queue.bash"
sed -n '/^## Recipes/,$p' "$SOURCE_DIR/docs/cluster.md" | sed '1d; /^## /,$d' | sed -n 's/^    //p' | sed 's/200k/20k/; s/n=50000/n=5000/' >recipes.sh
expect 0 '' bash -e recipes.sh
[ ! -e failed.log ] || fail "$(cat failed.log job.log)"
grep -q '"rays_matched"\|"rays"' scratch/seen.json || fail "the chained question has no answer"
for map in run all local pmix; do
    "$RAYMAP" info "scratch/$map.raymap" >"$map.txt" || fail "no map $map"
done
digests=$(sed -n 's/.*digest *\([0-9a-f]\{32\}\).*/\1/p' run.txt all.txt local.txt pmix.txt | sort -u)
[ "$(wc -w <<<"$digests")" = 1 ] || fail "the recipes' maps of the same rays differ: $digests"
grep -q 20,000 mail.txt || fail "the mail says $(cat mail.txt)"

# What mpirun makes of status 6 stays out of the job's log.
LAUNCHER='mpirun -np 2' RAYMAP=$RAYMAP expect 6 'stopped early by the time limit.*--resume traces the rest' \
    bash "$SOURCE_DIR/jobs/slurm-trace.sh" scene.yaml stopped.raymap 1G --time-limit 1s --quiet
! grep -q 'non-zero' stderr.txt || fail "mpirun's noise: $(cat stderr.txt)"

finish
