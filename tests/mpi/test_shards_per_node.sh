#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: the ranks of a node may share writers, and the map holds the same rays; a writer
# that fails ends all ranks.
. "$(dirname "$0")/../cli/expect.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
rm -rf ./*
write_scene scene.yaml
digest() { "$RAYMAP" info "$1" --json | sed -n 's/.*"digest": "\([0-9a-f]\{32\}\)".*/\1/p'; }
shards() { find "$1" -name 'shard-*' | wc -l; }

expect 0 '' "$RAYMAP" trace scene.yaml -o alone.raymap -n 50001 --quiet
expect 0 '' "$RAYMAP" detector alone.raymap sensor -o alone.csv --quiet
want=$(digest alone.raymap)
for per_node in 2 100 ${SLOW:+1 3}; do
    map=shared-$per_node.raymap
    expect 0 '' mpirun -np 3 "$RAYMAP" trace scene.yaml -o $map -n 50001 --threads 2 \
        --shards-per-node $per_node --quiet
    [ "$(digest $map)" = "$want" ] || { echo "FAILED: other rays with $per_node writers"; failures=1; }
    n=$((per_node < 3 ? per_node : 3))
    [ "$(shards $map)" -eq $n ] || { echo "FAILED: $(shards $map) shards, not $n"; failures=1; }
    expect 0 '' "$RAYMAP" detector $map sensor -o $map.csv --quiet
    cmp alone.csv $map.csv || { echo "FAILED: another image with $per_node writers"; failures=1; }
done
expect 6 'time limit' mpirun -np 2 "$RAYMAP" trace scene.yaml -o late.raymap -n 1G --quiet \
    --shards-per-node 1 --time-limit 0.3s
expect 0 'NOT complete' "$RAYMAP" info late.raymap
expect 2 'at least 1' "$RAYMAP" trace scene.yaml -o x.raymap --shards-per-node 0

# The one writer's disk fills up (a limit on the size of files stands in for it).
cat >small-disk.sh <<'SCRIPT'
#!/usr/bin/env bash
trap '' XFSZ
ulimit -f 12288
exec "$@"
SCRIPT
chmod +x small-disk.sh
full=("$RAYMAP" trace scene.yaml -o full.raymap -n 1M --encoding plain --quiet --shards-per-node 1)
expect 5 'File too large' mpirun -np 1 ./small-disk.sh "${full[@]}" : -np 2 "${full[@]}"

# Memory that the one writer runs out of at any moment ends all ranks, and none waits for ever.
memory=(env "LD_PRELOAD=$FAULTS" "FAULTS_DIR=$PWD/short.raymap"
    'FAULTS_CALLS=memory:*')
short=("$RAYMAP" trace scene.yaml -o short.raymap -n 60k --quiet --shards-per-node 1 --threads 1)
expect 0 '' mpirun -np 1 "${memory[@]}" "FAULTS_LOG=$PWD/calls.log" "${short[@]}" : -np 2 "${short[@]}"
n_call=$(wc -l <calls.log.0)
# How many calls the writer makes depends on the blocks that fall to its rank: a run that ended
# before the call in question is another run's to show.
n_reached=0
for percent in 40 60 80 ${SLOW:+70 90 95}; do
    rm -rf short.raymap ./*.log.0
    at=$((n_call * percent / 100))
    try=(mpirun -np 1 "${memory[@]}" "FAULTS_LOG=$PWD/calls.log" FAULTS_AT=$at FAULTS_ACTION=ENOMEM
        FAULTS_STICKY=1 "${short[@]}" : -np 2 "${short[@]}")
    timeout 120 "${try[@]}" >stdout.txt 2>stderr.txt </dev/null
    status=$?
    n=$(wc -l <calls.log.0)
    if [ $status -eq 0 ] && [ "$n" -lt $at ]; then
        continue
    fi
    n_reached=$((n_reached + 1))
    if [ $status -ne 5 ] || ! grep -q 'out of memory' stderr.txt; then
        echo "FAILED: exit status $status, not 5 for want of memory at call $at of $n"
        sed 's/^/    /' stderr.txt | head -20
        failures=$((failures + 1))
    fi
done
[ $n_reached -ge 2 ] || { echo "FAILED: only $n_reached runs came to where memory ends"; failures=1; }
rm -rf ./*.raymap
finish
