#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: whatever ends a trace, what it flushed can be read, and --resume with any number of
# ranks makes the map that an undisturbed run makes: same rays, same balance, same images.
# Moments of death are random commits of a rank; RAYMAP_TEST_SEED repeats them, RAYMAP_TEST_KILLS asks
# for more. All ranks killed: faults.test_kill_matrix too.
. "$(dirname "$0")/../cli/expect.bash"
. "$(dirname "$0")/../faults/commits.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
export OMPI_MCA_orte_abort_timeout=1 OMPI_MCA_odls_base_sigkill_timeout=0
RANDOM=${RAYMAP_TEST_SEED:-7}
rm -rf ./*
write_scene scene.yaml
rays=70001
portions=1 # of a commit

balance() { # MAP: everything that is said of its light
    "$RAYMAP" info "$1" --json |
        sed -n '/^  "\(digest\|rays\|segments\|registrations\|complete\)":/p; /^  "sources":/,/^  \]/p'
}
image() { "$RAYMAP" detector "$1" sensor -o "$2" --force --quiet >/dev/null; }

same() { # MAP WHAT: compares with the undisturbed map
    balance "$1" >got.txt
    cmp -s want.txt got.txt || { echo "FAILED: another map after $2"; diff want.txt got.txt; failures=$((failures + 1)); }
    image "$1" got.csv
    cmp -s want.csv got.csv || { echo "FAILED: another image after $2"; failures=$((failures + 1)); }
}
ranks_of() { ps -o pid= --ppid "$1" | tr -d ' '; }
fail() { echo "FAILED: $*"; cat stderr.txt; failures=$((failures + 1)); }
held_by() { "$RAYMAP" info "$1" --json | sed -n 's/.*"rays": \([0-9]*\),.*/\1/p' | head -1; }
begin() { # MAP RANKS COMMIT OPTIONS...: in the background, as $job, until a rank stops at a commit
    local map=$1 ranks=$2
    set_at_commit "$3" stop
    shift 3
    mpirun -np "$ranks" "${at_commit[@]}" "$RAYMAP" trace scene.yaml -o "$map" -n $rays --quiet --threads 1 \
        --flush-portions $portions "$@" >/dev/null 2>stderr.txt </dev/null &
    job=$!
    stopped=$(until_stopped "$map")
    [ -n "$stopped" ] || fail "no rank of $map commits"
}
disturb() { # HOW MAP: to the running $job
    local pids number=0
    pids=$(ranks_of $job)
    case $1 in
    one-rank) kill -9 $(shuf -n 1 -e --random-source=<(yes $RANDOM) $pids) ;;
    all-ranks) kill -9 $pids ;;
    mpirun) kill -9 $job && kill -CONT $pids ;; # they outlive it until they notice
    SIGTERM) kill -TERM $job ;;
    SIGUSR1) kill -USR1 $job && number=10 ;;
    SIGINT-rank) kill -INT "$stopped" && number=2 ;;
    esac
    [ $number -eq 0 ] || until_signalled "$stopped" $number || fail "no signal reaches $stopped"
    [ $number -eq 0 ] || wake_while "$2" kill -0 $job 2>/dev/null
    wait $job 2>/dev/null
    status=$?
    for pid in $pids; do
        wake_while "$2" kill -0 "$pid" 2>/dev/null
    done
}

expect 0 '' "$RAYMAP" trace scene.yaml -o want.raymap -n $rays --quiet
balance want.raymap >want.txt
image want.raymap want.csv

n=0
for how in one-rank mpirun SIGINT-rank SIGUSR1 ${SLOW:+all-ranks SIGTERM} $(shuf -e -n "${RAYMAP_TEST_KILLS:-0}" -r --random-source=<(yes 3) one-rank all-ranks mpirun); do
    n=$((n + 1))
    map=kill-$n.raymap
    encoding=plain # of both lives, at every third map
    [ $((n % 3)) -ne 0 ] || encoding=compact
    begin $map $((1 + n % 3)) $((2 + RANDOM % 3)) --encoding $encoding
    disturb "$how" $map
    case $how in SIGUSR1 | SIGINT-rank)
        [ $status -eq 6 ] || grep -q 'Exit code: *6' stderr.txt || fail "$how: status $status" ;;
    esac
    expect 0 '' "$RAYMAP" query $map 'registered(sensor)' --json
    held=$(held_by $map)
    # Ranks may be done before they notice that mpirun died.
    [ "$held" -gt 0 ] && { [ "$held" -lt $rays ] || [ "$how" = mpirun ]; } || fail "$how: $held rays held"
    # The second life ends as badly as the first, where enough is left for two commits of one of its ranks.
    if [ $((n % 2)) -eq 0 ] && [ $((held + 3 * 2 * portions * 4096)) -lt $rays ]; then
        begin $map $((1 + (n + 1) % 3)) $((1 + RANDOM % 2)) --resume
        disturb one-rank $map
    fi
    expect 0 '' mpirun -np $((1 + (n + 1) % 3)) "$RAYMAP" trace scene.yaml -o $map -n $rays --resume --quiet
    same $map "$how ($held rays held)"
    left=$(find $map -name '*.part' -o -name '*.journal' | wc -l)
    [ "$left" -eq 0 ] || { echo "FAILED: $how leaves files behind"; find $map -name '.*'; failures=$((failures + 1)); }
    rm -rf $map
done

# Stopped twice, with other ranks and pieces each time; then one writer for all ranks.
set_at_commit 2 SIGUSR1
stop=("${at_commit[@]}" "$RAYMAP" trace scene.yaml -n $rays --quiet --flush-portions $portions)
expect 6 'resume' mpirun -np 2 "${stop[@]}" -o time.raymap --piece-size 1Mi
expect 6 '' "${stop[@]}" -o time.raymap --resume
expect 0 'held already' mpirun -np 3 "$RAYMAP" trace scene.yaml -o time.raymap --resume -n $rays --shards-per-node 1
same time.raymap 'two stops'
expect 6 '' mpirun -np 2 "${stop[@]}" -o mixed.raymap --encoding plain
expect 0 '' "$RAYMAP" trace scene.yaml -o mixed.raymap --resume --encoding compact --quiet
same mixed.raymap 'another encoding'
expect 0 'is complete' "$RAYMAP" trace scene.yaml -o time.raymap --resume

# Damaged pieces and journals are told, left out, and their rays traced again.
begin hurt.raymap 1 4 --piece-size 2Mi --encoding plain # alone it commits more often than four times
disturb all-ranks hurt.raymap
piece=$(find hurt.raymap -name 'piece-*.h5' | sort | head -1)
journal=$(find hurt.raymap -name '*.journal' | sort | head -1)
[ -n "$piece" ] && [ -n "$journal" ] || fail "no piece or no journal in hurt.raymap"
truncate -s -1000 "$piece"
printf 'rmapjrnX' | dd of="$journal" conv=notrunc status=none
expect 0 "warning: left out: .*$(basename "$piece")" mpirun -np 2 "$RAYMAP" trace scene.yaml -o hurt.raymap --resume
same hurt.raymap 'damage'

# The index is made of what ranks say, wherever their shards are; collected, they are the map.
mkdir disk
expect 0 '' mpirun -np 2 "$RAYMAP" trace scene.yaml -o apart.raymap -n 40000 --quiet --shard-dir disk
expect 4 'missing' "$RAYMAP" info apart.raymap
expect 0 '' mpirun -np 2 "$RAYMAP" trace scene.yaml -o apart.raymap --append -n $((rays - 40000)) --quiet --shard-dir disk
mv disk/shard-* apart.raymap
same apart.raymap 'shards on other disks'

# Of a map that has lost a piece nothing is called complete: that is for repair to mend.
mv apart.raymap/shard-00001 lost
expect 4 'shard-00001/piece-00000.h5 is missing.*repair' "$RAYMAP" trace scene.yaml -o apart.raymap --resume
expect 4 'shard-00001/piece-00000.h5 is missing.*repair' mpirun -np 2 "$RAYMAP" trace scene.yaml -o apart.raymap --append -n 1
expect 0 '' "$RAYMAP" repair apart.raymap
expect 0 '' "$RAYMAP" trace scene.yaml -o apart.raymap --resume --quiet
same apart.raymap 'a lost shard'

# A job that died before it wrote anything is begun anew.
mkdir young.raymap young.raymap/shard-00000
expect 0 '' "$RAYMAP" trace scene.yaml -o young.raymap -n $rays --resume --quiet
same young.raymap 'a new map'
rm -rf ./*.raymap
finish
