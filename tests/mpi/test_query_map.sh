#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: the map that a query writes holds just the rays of the query, whatever ranks, threads
# and encoding, and is a map like any other: asked, reported, verified, converted, merged. Fluxes
# stay those of the map that was traced. It says where it comes from, and takes no other rays.
. "$(dirname "$0")/../cli/expect.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
rm -rf ./*
write_scene scene.yaml
digest() {
    "$RAYMAP" info "$1" --json | sed -n '0,/"digest"/s/.*"digest": "\([0-9a-f]\{32\}\)".*/\1/p'
}
fail() { echo "FAILED: $*"; failures=$((failures + 1)); }
same() { cmp "$1" "$2" || fail "$3: $1 is not $2"; }
rays() { # MAP FILE: all its rays, as JSON
    "$RAYMAP" query "$1" all -o "$2" --force --quiet || fail "no rays of $1"
}

# Two colour spaces, several shards.
mpirun -np 2 "$RAYMAP" trace scene.yaml -o a.raymap -n 20001 --threads 2 --piece-size 1Mi --encoding plain --quiet
"$RAYMAP" trace scene.yaml -o a.raymap -n 6500 --color rgb --append --threads 1 --quiet
total=26501
criterion='hit(screen, reflect_diffuse) and not ray in 9000..9100'

# All of a map is the map.
for ranks in 2 ${SLOW:+1 3}; do
    by_ranks $ranks
    expect 0 '' "${start[@]}" "$RAYMAP" query a.raymap all -o all.raymap --threads 2 --quiet --force
    [ "$(digest all.raymap)" = "$(digest a.raymap)" ] || fail "other rays in all of it ($ranks ranks)"
done

# Just the rays of the query.
"$RAYMAP" query a.raymap "$criterion" -o want.json --quiet
"$RAYMAP" query a.raymap "$criterion" --json | sed -n '/"matched"/p;/standard_error/p' >want.sums
want=
for ranks in 1 2 ${SLOW:+3}; do
    by_ranks $ranks
    encoding=plain
    [ $ranks -ne 2 ] || encoding=compact
    expect 0 '' "${start[@]}" "$RAYMAP" query a.raymap "$criterion" -o q.raymap --threads $((1 + ranks % 2)) \
        --encoding $encoding --quiet --force
    [ -n "$want" ] || want=$(digest q.raymap)
    [ "$(digest q.raymap)" = "$want" ] || fail "another digest ($ranks ranks)"
    expect 0 '0 findings' "$RAYMAP" verify q.raymap
    [ $ranks -ne 1 ] || { rays q.raymap got.json && same want.json got.json 'rays of the query'; }
    "${start[@]}" "$RAYMAP" query q.raymap all --json | sed -n '/"matched"/p;/standard_error/p' >got.sums
    same want.sums got.sums "flux, $ranks ranks"
done
expect 0 '' mpirun -np 2 "$RAYMAP" query a.raymap "$criterion" -o local.raymap --local --quiet
[ "$(digest local.raymap)" = "$want" ] || fail "another digest with --local"

# Like any other map.
"$RAYMAP" query a.raymap "$criterion and medium(glass) and ray < 12000" -o want.json --force --quiet
"$RAYMAP" query q.raymap 'medium(glass) and ray < 12000' -o got.json --force --quiet
same want.json got.json 'asked again'
image() { # MAP CRITERION FILE: the numbers, without what was asked
    "$RAYMAP" detector "$1" sensor --where "$2" -o image.csv --quiet --force >/dev/null
    grep -v '^#' image.csv >"$3"
}
image a.raymap "$criterion" want.csv
image q.raymap all got.csv
same want.csv got.csv 'image of its columns'
"$RAYMAP" detector q.raymap sensor -o image.csv --quiet --force >/dev/null
grep -v '^#' image.csv >got.csv
same want.csv got.csv 'image'
id=$(sed -n 's/.*"ray":\([0-9]*\),.*/\1/p' want.json | sed -n 100p)
"$RAYMAP" report a.raymap "$id" >want.txt
"$RAYMAP" report q.raymap "$id" >got.txt
same want.txt got.txt "ray $id"
expect 3 'no ray 9050' "$RAYMAP" report q.raymap 9050
expect 0 '' "$RAYMAP" draw q.raymap -o q.svg --limit 20 --quiet
"$RAYMAP" draw a.raymap --where "$criterion" --limit 20 -o a.svg --quiet >/dev/null
[ "$(grep -c '<path' a.svg)" = "$(grep -c '<path' q.svg)" ] || fail 'another picture'
for encoding in plain ${SLOW:+compact}; do
    expect 0 '' mpirun -np 2 "$RAYMAP" convert q.raymap -o c.raymap --encoding $encoding --force --quiet
    [ "$(digest c.raymap)" = "$want" ] || fail "another digest after convert"
    expect 0 'picked from a.raymap: hit' "$RAYMAP" info c.raymap
done
expect 0 '"criterion": "hit\(screen' "$RAYMAP" info c.raymap --json

# The rest, merged with it, is the whole again, though rays of both lie between each other.
expect 0 '' mpirun -np 2 "$RAYMAP" query a.raymap "not ($criterion)" -o rest.raymap --quiet
expect 0 '' "$RAYMAP" merge q.raymap rest.raymap -o m.raymap
[ "$(digest m.raymap)" = "$(digest a.raymap)" ] || fail 'parts do not make the whole'
expect 0 '0 findings' "$RAYMAP" verify m.raymap
part='ray in 8000..11000 or ray in 19000..21000' # of both, and of both colour spaces
"$RAYMAP" query a.raymap "$part" -o want.json --force --quiet
for ranks in 2 ${SLOW:+1 3}; do
    by_ranks $ranks
    "${start[@]}" "$RAYMAP" query m.raymap "$part" -o got.json --force --quiet
    same want.json got.json "merged, $ranks ranks"
done
"$RAYMAP" report m.raymap 20001 >got.txt
"$RAYMAP" report a.raymap 20001 >want.txt
same want.txt got.txt 'ray of a merged map'
"$RAYMAP" query a.raymap "hit(lens)" --limit 3000 >want.txt
mpirun -np 2 "$RAYMAP" query m.raymap "hit(lens)" --limit 3000 >got.txt
same want.txt got.txt 'first rays of a merged map'
expect 3 'q.raymap and all.raymap both hold the rays 3?[0-9]*, [0-9 to]*, [0-9 to]* and others \([0-9,]* rays\)' "$RAYMAP" merge q.raymap all.raymap -o x.raymap
expect 3 'picked from the same map' "$RAYMAP" merge a.raymap rest.raymap -o x.raymap
[ ! -e x.raymap ] || fail 'x.raymap was made'

# First rays, samples, questions of questions.
for what in '--limit 1000' '--sample 777 --seed 5'; do
    "$RAYMAP" query a.raymap "$criterion" $what -o want.json --force --quiet
    for ranks in 2 ${SLOW:+1 3}; do
        by_ranks $ranks
        expect 0 '' "${start[@]}" "$RAYMAP" query a.raymap "$criterion" $what -o s.raymap --force --quiet
        rays s.raymap got.json
        same want.json got.json "$what, $ranks ranks"
    done
done
expect 0 'sample 777 seed 5' "$RAYMAP" info s.raymap
expect 0 '' "$RAYMAP" query s.raymap 'ray < 12000' -o t.raymap --quiet
expect 0 'and then from s.raymap: ray < 12000' "$RAYMAP" info t.raymap
expect 0 '' "$RAYMAP" query a.raymap 'hit(lens) and not hit(lens)' -o none.raymap --quiet
expect 0 '0 rays' "$RAYMAP" info none.raymap
expect 0 '0 findings' "$RAYMAP" verify none.raymap

# The sample is the one that sorting all hashes gives: with a map of all rays, by its definition.
"$RAYMAP" query a.raymap all --sample 26501 >got.txt
[ "$(wc -l <got.txt)" -eq $total ] || fail 'a sample of all is not all'

# No other rays, no harm.
expect 3 'a query picked' "$RAYMAP" trace scene.yaml -o q.raymap --resume
expect 3 'a query picked' mpirun -np 2 "$RAYMAP" trace scene.yaml -o q.raymap --append -n 100
expect 2 'exists' "$RAYMAP" query a.raymap all -o q.raymap
expect 2 'take the place' "$RAYMAP" query a.raymap all -o ./a.raymap/ --force
expect 2 'plain' "$RAYMAP" query a.raymap all -o x.raymap --encoding zip
expect 2 'encoding' "$RAYMAP" query a.raymap all -o x.csv --encoding plain
expect 2 'give one' "$RAYMAP" query a.raymap all --limit 3 --sample 3
expect 2 'at least one' "$RAYMAP" query a.raymap all --sample 0
expect 2 'seed' "$RAYMAP" query a.raymap all --seed 4
[ "$(digest q.raymap)" = "$want" ] || fail 'q.raymap is another'
expect 0 '' "$RAYMAP" query a.raymap all -o q.raymap --force --quiet
[ "$(digest q.raymap)" = "$(digest a.raymap)" ] || fail 'not replaced'

# What is damaged is told, and repaired as far as it goes.
expect 0 '' "$RAYMAP" query a.raymap "$criterion" -o d.raymap --force --quiet --encoding plain
piece=$(ls d.raymap/shard-*/piece-*.h5 | head -n 1)
/usr/bin/python3 - "$piece" <<'PYTHON'
import sys
import h5py
with h5py.File(sys.argv[1]) as f:
    assert f.attrs["version"][0] == 5 and b"gaps" in f.attrs["features"].split() and (f["portion/last_ray"][:] > f["portion/first_ray"][:]).all()
    at = int(f["chunk/offset"][0]) + int(f["chunk/nbytes"][0]) // 2
with open(sys.argv[1], "r+b") as f:
    f.seek(at); byte = f.read(1); f.seek(at); f.write(bytes([byte[0] ^ 255]))
PYTHON
expect 4 'checksum' "$RAYMAP" verify d.raymap
expect 4 'checksum' mpirun -np 2 "$RAYMAP" query d.raymap all -o x.json
[ ! -e x.json ] || fail 'half an answer was left'
expect 0 'not complete; the query that picked' "$RAYMAP" repair d.raymap
expect 0 '0 findings' "$RAYMAP" verify d.raymap
expect 0 'NOT complete: rays that the query picked' "$RAYMAP" info d.raymap

# Any HDF5 tool: flux per weight stays that of the traced map.
/usr/bin/python3 - <<'PYTHON' || failures=$((failures + 1))
import json, subprocess, os
import h5py
raymap = os.environ["RAYMAP"]
f = h5py.File("s.raymap/map.h5")
g = h5py.File("a.raymap/map.h5")
assert (f["source/emitted"][:] == g["source/emitted"][:]).all()
assert f.attrs["rays"] == 777 and f["tally/emitted"][:].sum() == 777
assert f["selection"].attrs["rays"] == 26501 and f["selection/criterion"][0].startswith(b"hit(screen")
flux = f["ray/weight"][:] * (f["source/flux"][:] / f["source/emitted"][:])[f["ray/source"][:]]
out = json.loads(subprocess.run([raymap, "query", "s.raymap", "all", "--json"], capture_output=True, check=True).stdout)
assert abs(flux.sum() - out["flux"]["matched"]) < 1e-12, (flux.sum(), out)
asked = json.loads(subprocess.run([raymap, "query", "a.raymap", "all", "--json"], capture_output=True, check=True).stdout)
assert out["flux"]["total"] == asked["flux"]["total"] == g["source/flux"][:].sum()
assert sorted(f["ray/id"][:])[0] >= 0 and len(set(f["ray/id"][:])) == 777
PYTHON
finish
