# SPDX-License-Identifier: MIT
#
# Disturbs the ranks of a trace by what they have done, not by the clock: at its N-th commit a rank
# stops itself, or signals itself, and waits to be looked at. So a fast machine does not finish before
# anybody has looked, and a slow one is waited for. Traces must commit by --flush-portions.

# Sets the array at_commit: words before the program, by which its ranks suffer ACTION (fault_plan.h)
# when they are about to sync a journal in this directory for the N-th time.
set_at_commit() { # N ACTION
    at_commit=(env "LD_PRELOAD=$FAULTS" "FAULTS_DIR=$PWD" FAULTS_CALLS=fdatasync
        'FAULTS_PATH=*.journal' "FAULTS_AT=$1" "FAULTS_ACTION=$2")
}

stopped_ranks() { # MAP: process ids of the ranks in this directory that stopped themselves
    local pid
    for pid in $(pgrep -f "trace .*-o $1 "); do
        [ "/proc/$pid/cwd" -ef . ] && [[ $(<"/proc/$pid/status") =~ State:.T ]] && echo "$pid"
    done 2>/dev/null
}

until_stopped() { # MAP: echoes one of them, or nothing after two minutes
    local i rank
    for ((i = 0; i < 600; i++)); do
        rank=$(stopped_ranks "$1")
        [ -z "$rank" ] || { echo "${rank##*$'\n'}"; return; }
        sleep 0.2
    done
}

until_signalled() { # PID NUMBER: the signal waits for the stopped process; 1 if it never does
    local i pending
    for ((i = 0; i < 1200; i++)); do
        pending=$(sed -n 's/^ShdPnd:\t*//p' "/proc/$1/status")
        ((0x${pending:-0} & 1 << ($2 - 1))) && return
        sleep 0.05
    done
    return 1
}

wake_while() { # MAP CONDITION...: wakes ranks, also those that stop only now
    local map=$1 ranks
    shift
    while "$@"; do
        ranks=$(stopped_ranks "$map")
        # shellcheck disable=SC2086 # several
        [ -z "$ranks" ] || kill -CONT $ranks 2>/dev/null
        sleep 0.2
    done
}
