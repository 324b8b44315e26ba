#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: where one ray takes a second, a trace still ends soon after it is asked to, on every
# rank, its map can be read and gone on with, and `check` is over in a while.
. "$(dirname "$0")/expect.bash"
rm -rf ./*
cat >slow.yaml <<'SCENE'
raymap: 1
units: mm
media:
  air: {index: 1}
  m: {gradient: {type: noise, mean: 1.3, amplitude: 0.01, length: 1e-9}}
geometries:
  ball: {type: sphere, radius: 1}
objects:
  - {name: body, geometry: ball, surface: fresnel, outside: air, inside: m}
sources:
  - {name: beam, type: rays, rays: [{origin: [0, 0.2, -2], direction: [0, 0, 1]}], spectrum: {lines: {587.56: 1}}}
SCENE

fail() {
    echo "FAILED: $*"
    failures=$((failures + 1))
}
said() { # KEY: the value that `info --json` gives
    grep -Eo "\"$1\": *[^,}]*" info.json | head -1
}

since() { # SECONDS of the machine's uptime: since then; the wall clock may be set meanwhile
    local up
    read -r up _ </proc/uptime
    echo $((${up%.*} - $1))
}

# The time limit ends a block after five seconds more; what it holds is the beginning of what is asked for.
"$RAYMAP" trace slow.yaml -o whole.raymap -n 4 --threads 1 --quiet >whole.txt 2>&1 &
whole=$!
begun=$(since 0)
expect 6 'time limit.*the map holds them' "$RAYMAP" trace slow.yaml -o part.raymap -n 4 --threads 1 --time-limit 1s
took=$(since "$begun")
[ "$took" -le 20 ] || fail "the time limit of 1 s took $took s"
expect 0 'NOT complete' "$RAYMAP" info part.raymap
expect 0 '' "$RAYMAP" verify part.raymap
expect 0 '' "$RAYMAP" trace slow.yaml -o part.raymap --resume --threads 1 --quiet
wait $whole || fail "undisturbed: $(cat whole.txt)"
expect 0 '' "$RAYMAP" verify part.raymap
"$RAYMAP" info whole.raymap --json >info.json
digest=$(said digest)
"$RAYMAP" info part.raymap --json >info.json
[ -n "$digest" ] && [ "$(said digest)" = "$digest" ] || fail "digest: $(said digest), not $digest"
grep -q '"complete": true' info.json || fail "not complete after --resume"

# A signal to one rank ends the others, which fetch no block for half an hour: a ray takes a third of the time. Meanwhile, a check.
sed 's/1e-9/1e-7/' slow.yaml >third.yaml
"$RAYMAP" check slow.yaml --threads 1 --json >check.json 2>check.txt &
check=$!
sleep 1
kill -STOP $check # its clock goes on, for less of the processor
stop_one() { # RAYS, and head or tail: which of two ranks gets SIGTERM
    local two rank= i begun took
    rm -rf two.raymap
    mpirun -np 2 "$RAYMAP" trace third.yaml -o two.raymap -n "$1" --threads 1 --quiet >two.txt 2>&1 &
    two=$!
    for ((i = 0; i < 600 && ${#rank} == 0; i++)); do
        sleep 0.1
        [ -e two.raymap/map.h5 ] && rank=$(pgrep -P $two -f 'raymap trace' | "$2" -1)
    done
    sleep 1 # until it watches for signals
    begun=$(since 0)
    kill -TERM "$rank"
    wait $two
    grep -q 'stopped early by SIGTERM' two.txt || fail "SIGTERM to one rank: $(cat two.txt)"
    took=$(since "$begun")
    [ "$took" -le 30 ] || fail "SIGTERM to one rank took $took s"
    expect 0 'NOT complete' "$RAYMAP" info two.raymap
    expect 0 '' "$RAYMAP" verify two.raymap
}
stop_one 8192 tail
# One block: the other rank has nothing to do, and waits when the signal reaches it.
stop_one 4096 head
[ "${RAYMAP_TEST_SCALE:-1}" -eq 1 ] || stop_one 4096 tail
kill -CONT $check
wait $check || fail "check: $(cat check.txt)"
grep -Eq 'probing was cut after 10 s: [1-9][0-9]* of 8192 rays sent' check.txt || fail "check says: $(cat check.txt)"
grep -Eq '"cut": true' check.json || fail "check --json says: $(cat check.json)"
rm -rf ./*.raymap
finish
