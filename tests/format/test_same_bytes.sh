#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: equal work by one rank with one thread gives the same files, byte by byte, in either
# encoding; no time, host or process stands in them.
set -u
: "${RAYMAP:?}" "${SOURCE_DIR:?}"
failures=0

trace() { # MAP ENCODING SCENE OPTION...
    local map=$1 encoding=$2 scene=$3
    shift 3
    "$RAYMAP" trace "$scene" -o "$map" --encoding "$encoding" --threads 1 --force --quiet "$@"
}

same() { # WHAT FOLDER FOLDER
    local found
    if ! found=$(diff -r "$2" "$3"); then
        printf 'FAIL: %s: %s\n' "$1" "$found"
        failures=$((failures + 1))
    fi
}

double_gauss=$SOURCE_DIR/examples/double-gauss/scene.yaml
room=$SOURCE_DIR/examples/room/scene.yaml
for encoding in plain compact; do
    for k in 1 2; do
        # A second later than the other.
        trace "lens-$k.raymap" "$encoding" "$double_gauss" -n 20000 || exit 1
        trace "room-$k.raymap" "$encoding" "$room" -n 5000 --seed 7 || exit 1
        sleep 1
    done
    same "$encoding, double Gauss" lens-1.raymap lens-2.raymap
    same "$encoding, room" room-1.raymap room-2.raymap
    [ "$(find lens-1.raymap -name 'piece-*.h5' | wc -l)" -ge 1 ] || failures=$((failures + 1))
    # The comparison can fail: another seed gives other bytes.
    trace other.raymap "$encoding" "$room" -n 5000 --seed 8 || exit 1
    if diff -rq room-1.raymap other.raymap >/dev/null; then
        echo "FAIL: $encoding: two seeds, one map"
        failures=$((failures + 1))
    fi
done
rm -rf lens-[12].raymap room-[12].raymap other.raymap
echo "$failures failures"
exit "$((failures > 0))"
