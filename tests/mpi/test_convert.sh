#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: convert gives the same rays, balance and images in another form, with any number of
# ranks and threads; one rank with one thread gives the same bytes each time; nothing is lost when
# it cannot be done.
. "$(dirname "$0")/../cli/expect.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
rm -rf ./*
write_scene scene.yaml
digest() {
    "$RAYMAP" info "$1" --json | sed -n 's/.*"digest": "\([0-9a-f]\{32\}\)".*/\1/p'
}
same() { # MAP: as a.raymap
    [ "$(digest "$1")" = "$want" ] || { echo "FAILED: another digest: $1"; failures=1; }
    "$RAYMAP" info "$1" | sed -n '/  detector/,$p' >balance.txt
    cmp balance.txt want.balance || { echo "FAILED: another balance: $1"; failures=1; }
    "$RAYMAP" detector "$1" sensor -o image.csv --force --quiet
    cmp image.csv want.csv || { echo "FAILED: another image: $1"; failures=1; }
    "$RAYMAP" report "$1" 12345 >ray.txt
    cmp ray.txt want.ray || { echo "FAILED: another ray: $1"; failures=1; }
}

mpirun -np 2 "$RAYMAP" trace scene.yaml -o a.raymap -n 30001 --threads 2 --piece-size 1Mi --encoding plain --quiet
want=$(digest a.raymap)
"$RAYMAP" info a.raymap | sed -n '/  detector/,$p' >want.balance
"$RAYMAP" detector a.raymap sensor -o want.csv --quiet
"$RAYMAP" report a.raymap 12345 >want.ray
[ ${#want} -eq 32 ] || { echo "FAILED: no digest"; failures=1; }

for encoding in plain compact; do
    for ranks in 1 2 ${SLOW:+3}; do
        by_ranks $ranks
        expect 0 '' "${start[@]}" "$RAYMAP" convert a.raymap -o $encoding-$ranks.raymap \
            --encoding $encoding --threads $((4 - ranks)) --piece-size 2Mi --quiet
        same $encoding-$ranks.raymap
    done
    "$RAYMAP" convert $encoding-2.raymap -o one.raymap --encoding $encoding --threads 1 --quiet
    "$RAYMAP" convert $encoding-1.raymap -o two.raymap --encoding $encoding --threads 1 --quiet
    for file in shard-00000/piece-00000.h5; do
        cmp one.raymap/$file two.raymap/$file || { echo "FAILED: $encoding: other bytes in $file"; failures=1; }
    done
    rm -rf one.raymap two.raymap
done
"$RAYMAP" convert plain-2.raymap -o json.raymap --json >out.json
/usr/bin/python3 - "$want" <<'PYTHON' || failures=1
import json, sys
out = json.load(open("out.json"))
assert out["digest"] == sys.argv[1] and out["complete"] is True and out["rays"] == 30001, out
assert out["encoding"] == "plain" and out["bytes"] > 0 and out["bytes_before"] > 0, out
PYTHON

# A map that was stopped early stays one that was.
"$RAYMAP" trace scene.yaml -o early.raymap -n 100G --time-limit 0.2s --quiet 2>/dev/null
[ $? -eq 6 ] || { echo "FAILED: not stopped"; failures=1; }
expect 0 '"complete": false' "$RAYMAP" convert early.raymap -o early2.raymap --json

# What cannot be: nothing is made or lost.
expect 2 'own place' "$RAYMAP" convert a.raymap -o ./a.raymap/ --force
expect 2 'exists' "$RAYMAP" convert a.raymap -o plain-1.raymap
expect 2 'give -o' "$RAYMAP" convert a.raymap
expect 2 "plain" "$RAYMAP" convert a.raymap -o x.raymap --encoding zip
expect 3 'cannot open' "$RAYMAP" convert nothing.raymap -o x.raymap
[ ! -e x.raymap ] || { echo "FAILED: x.raymap was made"; failures=1; }
same a.raymap
expect 0 '' "$RAYMAP" convert a.raymap -o plain-1.raymap --force --quiet
same plain-1.raymap
piece=$(ls a.raymap/shard-*/piece-*.h5 | tail -n 1)
/usr/bin/python3 - "$piece" <<'PYTHON'
import sys
import h5py
with h5py.File(sys.argv[1]) as f:
    at = int(f["chunk/offset"][0]) + int(f["chunk/nbytes"][0]) // 2
with open(sys.argv[1], "r+b") as f:
    f.seek(at); byte = f.read(1); f.seek(at); f.write(bytes([byte[0] ^ 255]))
PYTHON
expect 4 'piece-' mpirun -np 2 "$RAYMAP" convert a.raymap -o damaged.raymap
[ ! -e damaged.raymap ] || { echo "FAILED: half a map stays behind"; failures=1; }
finish
