#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: jobs/slurm-trace.sh carries a trace over time limits and killed ranks to the same map
# as an undisturbed run, on a real Slurm that this test brings up for itself; and it never circles
# in the queue for nothing.
. "$(dirname "$0")/../cli/expect.bash"
. "$(dirname "$0")/slurm.bash"
. "$(dirname "$0")/commits.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
missing=$(slurm_missing)
[ -z "$missing" ] || { echo "no Slurm here ($missing is missing): jobs/install-packages.sh tests installs it"; exit 77; }

rm -rf ./*
directory=$(mktemp -d "${TMPDIR:-/tmp}/raymap-slurm.XXXXXX")
trap 'slurm_down; rm -rf "$directory"' EXIT
trap 'exit 1' INT TERM
slurm_up "$directory" || {
    grep -q 'Unable to initialize cgroup plugin' "$directory/slurmd.log" && { echo "no control groups here, without which slurmd does not start"; exit 77; }
    echo "FAILED: Slurm does not come up"
    tail -n 20 "$directory"/*.log
    exit 1
}
write_scene scene.yaml
rays=500000
set_at_commit 3 stop
export RAYMAP LAUNCHER="$PWD/launch.sh"
cat >launch.sh <<SCRIPT
#!/usr/bin/env bash
# In the first two attempts ranks stop when they have committed some portions.
at_commit=()
[ "\${SLURM_RESTART_COUNT:-0}" -ge 2 ] || [[ " \$* " != *" run.raymap "* ]] ||
    at_commit=(${at_commit[*]@Q})
exec mpirun -np 2 --bind-to none "\${at_commit[@]}" "\$@"
SCRIPT
chmod +x launch.sh

field() { # JOB NAME: of scontrol show job
    [[ $(scontrol show job "$1" 2>/dev/null) =~ [[:space:]]$2=([^[:space:]]*) ]] && echo "${BASH_REMATCH[1]}"
}
fail() {
    echo "FAILED: $*"
    failures=$((failures + 1))
    tail -n 20 job-*.log 2>/dev/null
}
submit() { # MAP [options of trace]: echoes the number of the job
    sbatch --parsable --ntasks-per-node=2 -t 10 --output="$PWD/job-%j.log" "$SOURCE_DIR/jobs/slurm-trace.sh" \
        scene.yaml "$@"
}
# A requeued job waits two minutes of its own; nobody else is here who could want the node.
until_state() { # JOB RESTARTS PATTERN
    local i state
    for ((i = 0; i < 200; i++)); do
        state=$(field "$1" JobState)
        if [[ $(field "$1" Restarts) -ge $2 && $state =~ $3 ]]; then
            [ "$state" = FAILED ] || return 0
            sleep 3 # a job on its way back into the queue looks so for a moment
            [ "$(field "$1" JobState)" = FAILED ] && return 0
        fi
        if [ "$state" = PENDING ]; then
            sleep 3 # the script that asked for the requeue must have left
            scontrol update jobid="$1" StartTime=now 2>/dev/null
        fi
        sleep 0.3
    done
    fail "job $1 is $(field "$1" JobState) after $(field "$1" Restarts) restarts, not $3 after $2"
    return 1
}
runs_first() {
    [ "$(field "$job" Restarts)" = 0 ] && [ "$(field "$job" JobState)" = RUNNING ]
}
rays_of() {
    "$RAYMAP" info "$1" --json | sed -n 's/^ *"rays": *\([0-9]*\).*/\1/p' | head -1
}
digest_of() {
    "$RAYMAP" info "$1" --json | sed -n 's/.*"digest": "\([0-9a-f]\{32\}\)".*/\1/p'
}

expect 0 '' "$RAYMAP" trace scene.yaml -o whole.raymap -n $rays --quiet

# The herald of the time limit, then a rank killed from one moment to the next, then the rest.
job=$(submit run.raymap $rays --threads 1 --quiet --flush-portions 2) || exit 1
# A question that waits for the map waits for its last attempt (docs/cluster.md).
question=$(sbatch --parsable --dependency=afterok:"$job" -n 1 -o "$PWD/question.txt" --wrap "'$RAYMAP' info run.raymap --json")
rank=$(until_stopped run.raymap)
[ -n "$rank" ] || fail "no rank commits anything in the first attempt"
scancel --batch --signal=USR1 "$job"
until_signalled "$rank" 10 || fail "rank $rank gets no SIGUSR1"
wake_while run.raymap runs_first
until_state "$job" 1 'PENDING|RUNNING'
first=$(rays_of run.raymap)
[ "$first" -gt 0 ] && [ "$first" -lt $rays ] || fail "$first rays after the first attempt"
until_state "$job" 1 RUNNING
rank=$(until_stopped run.raymap)
[ -n "$rank" ] || fail "no rank commits anything in the second attempt"
second=$(rays_of run.raymap)
[ "$second" -gt "$first" ] || fail "$second rays in the second attempt, $first after the first"
kill -KILL "$rank"
until_state "$job" 2 'COMPLETED|FAILED'
[ "$(field "$job" JobState)" = COMPLETED ] || fail "the job ends as $(field "$job" JobState)"
[ "$(field "$job" Restarts)" = 2 ] || fail "$(field "$job" Restarts) restarts, not 2"
expect 0 '' "$RAYMAP" info run.raymap
[ "$(rays_of run.raymap)" = $rays ] || fail "$(rays_of run.raymap) rays in the end"
[ "$(digest_of run.raymap)" = "$(digest_of whole.raymap)" ] || fail "another digest than undisturbed"
until_state "$question" 0 'COMPLETED|FAILED'
grep -q "\"rays\": $rays" question.txt || fail "the question came too early: $(head -c 300 question.txt)"
! grep -q 'non-zero\|Forwarding' "job-$job.log" || fail "mpirun's noise about planned stops: $(cat "job-$job.log")"

# Jobs that must not go back into the queue, each with its own reason and status.
ends() { # STATUS WORDS JOB
    until_state "$3" 0 'FAILED|COMPLETED|TIMEOUT'
    [ "$(field "$3" JobState) $(field "$3" Restarts) $(field "$3" ExitCode)" = "FAILED 0 $1:0" ] ||
        fail "job $3: $(field "$3" JobState) $(field "$3" Restarts) $(field "$3" ExitCode), not $1"
    grep -q "$2" "job-$3.log" || fail "job $3 does not say '$2'"
}
ends 3 'missing.yaml' "$(sbatch --parsable -n 1 -o "$PWD/job-%j.log" "$SOURCE_DIR/jobs/slurm-trace.sh" missing.yaml x.raymap 10)"
ends 2 'usage' "$(sbatch --parsable -n 1 -o "$PWD/job-%j.log" "$SOURCE_DIR/jobs/slurm-trace.sh" scene.yaml)"
sed 's/^sources:/&\n  - {name: lost, type: collimated, at: [0, 0, 0], direction: [0, 0, 1], shape: {disc: 0.1}, flux: 1 W, rays_share: 1, medium: glass}/' \
    scene.yaml >lossy.yaml
ends 7 'left with status 7' "$(sbatch --parsable -n 1 -o "$PWD/job-%j.log" "$SOURCE_DIR/jobs/slurm-trace.sh" lossy.yaml lossy.raymap 1000 --quiet)"
export RESTARTS=0
ends 6 'after 0 restarts' "$(submit late.raymap 100M --time-limit 1s --quiet --threads 1)"
export LAUNCHER="timeout --signal=KILL 0.01 mpirun -np 1"
ends 137 'added no ray' "$(submit none.raymap 1000 --quiet)"
finish
