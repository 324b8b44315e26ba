#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
#SBATCH --job-name=raymap
#SBATCH --ntasks-per-node=1
#SBATCH --signal=B:USR1@300
#SBATCH --requeue
#SBATCH --open-mode=append
#
# Traces a scene on a Slurm cluster until the map is complete, over as many time limits as it takes:
#
#   sbatch -N 8 -c 64 -t 4:00:00 jobs/slurm-trace.sh SCENE MAP RAYS [options of raymap trace]
#
# Five minutes before the time limit Slurm sends SIGUSR1 to this script, which hands it to the ranks;
# they finish the blocks in hand, close the map in good order and leave with status 6. The job puts
# itself back into the queue and goes on with --resume. Whatever else ends the ranks (a node that
# dies, a rank that is killed) costs what was traced since the last flush, and the job goes on too.
# It does not go on when an attempt added no ray, so that it never circles in the queue for nothing,
# nor after a mistake in scene or options (2, 3), a damaged map (4), a full disk (5) or many rays that
# ended in errors (7): its exit status is then raymap's. `sbatch` again with the same arguments
# resumes whatever is there.
#
# By the environment: RAYMAP, the program (raymap); LAUNCHER, what starts the ranks
# ("mpirun --bind-to none"; "srun" where Slurm starts MPI programs itself); RESTARTS, how often the
# job may go back into the queue (100).
set -uo pipefail

say() { printf '%s raymap job %s: %s\n' "$(date '+%F %T')" "${SLURM_JOB_ID:-without Slurm}" "$*" >&2; }

if [ $# -lt 3 ]; then
    echo "usage: sbatch [options of sbatch] slurm-trace.sh SCENE MAP RAYS [options of raymap trace]" >&2
    exit 2
fi
scene=$1 map=$2 rays=$3
shift 3
raymap=${RAYMAP:-raymap}
read -ra launcher <<<"${LAUNCHER:-mpirun --bind-to none}"
export HDF5_USE_FILE_LOCKING=${HDF5_USE_FILE_LOCKING:-FALSE}

rays_in_map() {
    local n
    n=$("$raymap" info "$map" --json 2>/dev/null | sed -n 's/^ *"rays": *\([0-9]*\).*/\1/p' | head -1)
    echo "${n:-0}"
}

# SIGUSR1 is the time limit's herald. SIGTERM is a user's scancel or the limit itself: the map is
# closed as well, but the job does not come back of its own accord.
signalled=''
cancelled=''
hand_on() {
    signalled=yes
    [ -z "${ranks:-}" ] || kill -USR1 "$ranks" 2>/dev/null
}
trap hand_on USR1
trap 'cancelled=yes; hand_on' TERM

# When ranks leave with a status of their own mpirun makes paragraphs between dashes of it, and srun a line, as if
# something had broken; raymap has said in one line where it stands. All else, such as a killed rank, is told.
without_statuses() {
    local line block=''
    while IFS= read -r line; do
        if [[ -z $block && $line != -----* ]]; then
            [[ $line == srun:*'Exited with exit code 6' || $line == 'mpirun: Forwarding signal'* ]] || printf '%s\n' "$line"
            continue
        fi
        block+=$line$'\n'
        if [[ $line == -----* && $block != "$line"$'\n' ]]; then
            [[ $block == *' non-zero '* ]] || printf '%s' "$block"
            block=''
        fi
    done
    printf '%s' "$block"
}

resume=()
[ ! -e "$map" ] || resume=(--resume)
before=$(rays_in_map)
say "attempt $((${SLURM_RESTART_COUNT:-0} + 1)), $before of $rays rays are there"
"${launcher[@]}" "$raymap" trace "$scene" -o "$map" -n "$rays" ${resume[@]+"${resume[@]}"} "$@" \
    2> >(without_statuses >&2) &
ranks=$!
[ -z "$signalled" ] || kill -USR1 "$ranks" # it came before there was anyone to tell
# A trap ends the wait while the ranks still have blocks in hand.
while kill -0 "$ranks" 2>/dev/null; do
    wait "$ranks"
done
wait "$ranks"
status=$?
after=$(rays_in_map)

if [ $status -eq 0 ]; then
    say "complete: $after rays"
elif [ -n "$cancelled" ]; then
    say "cancelled with $after of $rays rays; sbatch again goes on"
elif [ $status -le 5 ] || [ $status -eq 7 ]; then
    say "raymap trace left with status $status; the job ends"
elif [ "$after" -le "$before" ]; then
    say "this attempt added no ray (status $status), so another would not either; the job ends"
elif [ "${SLURM_RESTART_COUNT:-0}" -ge "${RESTARTS:-100}" ]; then
    say "stopped with $after of $rays rays after ${RESTARTS:-100} restarts; sbatch again goes on"
elif [ -z "${SLURM_JOB_ID:-}" ] || ! scontrol requeue "$SLURM_JOB_ID"; then
    say "stopped with $after of $rays rays, and it cannot be requeued; sbatch again goes on"
else
    say "stopped (status $status) with $after of $rays rays; back into the queue"
    exit 0
fi
exit $status
