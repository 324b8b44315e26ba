#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: ranks on several hosts, with nothing but TCP between them and Open MPI as the
# distribution has it, give what one host gives; a host that dies costs what was not flushed; a
# network that is gone for a while costs time.
. "$(dirname "$0")/hosts.bash"
hosts_enter "$0"
. "$(dirname "$0")/../cli/expect.bash"
rm -rf ./*
hosts_up 4
write_scene scene.yaml
rays=500000
digest() { "$RAYMAP" info "$1" --json | sed -n 's/.*"digest": "\(.*\)".*/\1/p'; }
same_rays() { # MAP
    [ "$(digest "$1")" = "$(digest want.raymap)" ] ||
        { echo "FAILED: another digest of $1"; failures=$((failures + 1)); }
}

answers() { # FOLDER LAUNCHER...: everything that is asked of a map and a scene
    mkdir -p "$1"
    expect 0 '' "${@:2}" "$RAYMAP" trace scene.yaml -o "$1/m.raymap" -n 30k --threads 1 --quiet
    expect 0 '' "${@:2}" "$RAYMAP" query want.raymap 'registered(sensor) and hit(lens) >= 4' --limit 20
    cp stdout.txt "$1/query.txt"
    expect 0 '' "${@:2}" "$RAYMAP" stats want.raymap --of 'path_length' --json
    grep -v '"seconds"\|bytes_read' stdout.txt >"$1/stats.json"
    expect 0 '' "${@:2}" "$RAYMAP" render "$SOURCE_DIR/examples/gradient-sphere/scene.yaml" --samples 2 --size 60x40 -o "$1/seen.png"
    digest "$1/m.raymap" >"$1/digest"
}
expect 0 '' "$RAYMAP" trace scene.yaml -o want.raymap -n $rays --quiet
answers one
answers two "$HOSTS_FOLDER/mpirun" h1:1,h2:1
for file in query.txt stats.json seen.png digest; do
    cmp one/$file two/$file || failures=$((failures + 1))
done

# In the background, until something of it is safe.
begin() { # HOSTS MAP
    "$HOSTS_FOLDER/mpirun" "$1" "$RAYMAP" trace scene.yaml -o "$2" -n $rays --threads 1 --quiet \
        --flush-portions 1 >run.txt 2>&1 &
    run=$!
    until_traces "$2"
    sleep 0.3
}
for case in h1:1,h2:1-h2 ${SLOW:+h3:1,h4:1-h3}; do
    map=killed-${case#*-}.raymap
    begin "${case%-*}" $map
    hosts_kill "${case#*-}"
    sleep 1 # mpirun notices soon, or only when TCP gives up; then one ends it by hand
    { kill -9 $run && wait $run; } 2>/dev/null && echo "note: the trace had ended before its host died"
    pkill -9 raymap
    expect 0 '' "$RAYMAP" trace scene.yaml -o $map -n $rays --resume
    same_rays $map
done

begin h1:1,h4:1 cut.raymap
hosts_cut h4
sleep 5
hosts_heal h4
wait $run ||
    { echo "FAILED: it does not go on when the network is back"; cat run.txt; failures=$((failures + 1)); }
same_rays cut.raymap
finish
