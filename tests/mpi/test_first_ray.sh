#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: ray ids may begin anywhere, far beyond 32 bits, up to the largest there is; a ray is
# the same whichever map it stands in.
. "$(dirname "$0")/../cli/expect.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
rm -rf ./*
write_scene scene.yaml
far=1099511627776 # 2^40
last=18446744073709551614

expect 0 '' "$RAYMAP" trace scene.yaml -o far.raymap -n 20000 --first-ray $((far + 5)) --quiet
expect 0 '20,000 rays' "$RAYMAP" info far.raymap
expect 0 'rays +20,000 of' "$RAYMAP" query far.raymap "ray >= $((far + 5)) and ray < $((far + 20005))"
expect 0 "$((far + 12345))" "$RAYMAP" report far.raymap $((far + 12345))
expect 0 '' mpirun -np 2 "$RAYMAP" trace scene.yaml -o same.raymap -n 20000 --first-ray $((far + 5)) --quiet
digest() { "$RAYMAP" info "$1" --json | sed -n 's/.*"digest": "\([0-9a-f]\{32\}\)".*/\1/p'; }
[ "$(digest far.raymap)" = "$(digest same.raymap)" ] || { echo "FAILED: ranks change rays at 2^40"; failures=1; }

# The digest adds up over rays: two parts are the whole.
expect 0 '' "$RAYMAP" trace scene.yaml -o low.raymap -n 7000 --first-ray $((far + 5)) --quiet
expect 0 '' "$RAYMAP" trace scene.yaml -o high.raymap -n 13000 --first-ray $((far + 7005)) --quiet
/usr/bin/python3 - "$(digest low.raymap)" "$(digest high.raymap)" "$(digest far.raymap)" <<'PY' || { echo "FAILED: parts are not the whole"; failures=1; }
import sys
low, high, whole = (int(word, 16) for word in sys.argv[1:])
sys.exit((low + high) % 2**128 != whole)
PY

expect 0 '' "$RAYMAP" trace scene.yaml -o end.raymap -n 5000 --first-ray 18446744073709546615 --quiet
expect 0 "$last" "$RAYMAP" report end.raymap $last
# Ids are compared exactly: no double tells these from their neighbours.
expect 0 'rays +1 of' "$RAYMAP" query end.raymap "ray == $last"
expect 0 'rays +4,999 of' "$RAYMAP" query end.raymap "ray != $last"
expect 0 'rays +4,999 of' "$RAYMAP" query end.raymap "ray < $last"
expect 0 'rays +3 of' "$RAYMAP" query end.raymap "ray in 18446744073709551612..$last"
expect 0 'rays +2 of' "$RAYMAP" query end.raymap "ray > 18446744073709551612"
expect 0 'rays +0 of' "$RAYMAP" query end.raymap "ray == 18446744073709551615 or ray == 1.5"
expect 0 'rays +5,000 of' "$RAYMAP" query end.raymap 'ray >= -1 and ray < 1e30'
"$RAYMAP" query end.raymap "ray == $last" "ray == 18446744073709551613" --count --json --quiet >two.json
/usr/bin/python3 -c 'import json; assert [a["rays"]["matched"] for a in json.load(open("two.json"))] == [1, 1]' ||
    { echo "FAILED: two ids in one call"; failures=1; }
expect 0 "^$last " "$RAYMAP" query end.raymap "ray >= $last" --limit 2
rm -rf ./*.raymap
finish
