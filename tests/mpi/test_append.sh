#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: a map can grow, also in another colour space; its rays are those of one long trace,
# and flux stays normalised over all of them.
. "$(dirname "$0")/../cli/expect.bash"
. "$(dirname "$0")/../faults/commits.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
rm -rf ./*
write_scene scene.yaml
digest() { "$RAYMAP" info "$1" --json | sed -n 's/.*"digest": "\([0-9a-f]\{32\}\)".*/\1/p'; }
flux() { # MAP CRITERION: matched and total flux
    "$RAYMAP" query "$1" "$2" --count --json --quiet | /usr/bin/python3 -c '
import json, sys
answer = json.load(sys.stdin)
print("%.9g %.9g" % (answer["flux"]["matched"], answer["flux"]["total"]))'
}

expect 0 '' "$RAYMAP" trace scene.yaml -o whole.raymap -n 50000 --quiet
expect 0 '' "$RAYMAP" trace scene.yaml -o grown.raymap -n 15000 --quiet
expect 0 '15,000 rays that the map held already' mpirun -np 2 "$RAYMAP" trace scene.yaml -o grown.raymap --append -n 25000
expect 0 '' "$RAYMAP" trace scene.yaml -o grown.raymap --append -n 10000 --quiet --encoding compact
[ "$(digest grown.raymap)" = "$(digest whole.raymap)" ] || { echo "FAILED: a grown map holds other rays"; failures=1; }
[ "$(flux grown.raymap 'registered(sensor)')" = "$(flux whole.raymap 'registered(sensor)')" ] ||
    { echo "FAILED: a grown map has another flux"; failures=1; }
for map in whole grown; do expect 0 '' "$RAYMAP" detector $map.raymap sensor -o $map.csv --quiet; done
cmp whole.csv grown.csv || { echo "FAILED: a grown map has another image"; failures=1; }

# What was asked for first comes first; any of the numbers that were asked for may be repeated.
set_at_commit 2 SIGUSR1
expect 6 '' "${at_commit[@]}" "$RAYMAP" trace scene.yaml -o two.raymap -n 100k --quiet --flush-portions 2
expect 0 '' mpirun -np 2 "$RAYMAP" trace scene.yaml -o two.raymap --append -n 20000 --quiet
expect 0 '' "$RAYMAP" trace scene.yaml -o one.raymap -n 120k --quiet
[ "$(digest two.raymap)" = "$(digest one.raymap)" ] || { echo "FAILED: the incomplete part was not completed"; failures=1; }
expect 0 'is complete' "$RAYMAP" trace scene.yaml -o two.raymap --resume -n 120k
expect 0 'is complete' "$RAYMAP" trace scene.yaml -o two.raymap --resume -n 100k
expect 2 'asked for 120,000' "$RAYMAP" trace scene.yaml -o two.raymap --resume -n 90k

# A hole between two requests, far away: --first-ray.
expect 0 '' "$RAYMAP" trace scene.yaml -o far.raymap -n 5000 --quiet
expect 0 '' "$RAYMAP" trace scene.yaml -o far.raymap --append -n 5000 --first-ray 1099511627776 --quiet
expect 0 'rays +5,000 of' "$RAYMAP" query far.raymap 'ray >= 1099511627776'
expect 0 '' "$RAYMAP" trace scene.yaml -o far.raymap --append -n 1000 --quiet
expect 0 'rays +1,000 of' "$RAYMAP" query far.raymap 'ray >= 1099511632776'

# RGB after spectral, then other wavelengths: one map, one flux.
expect 0 '' "$RAYMAP" trace scene.yaml -o colours.raymap -n 40000 --quiet
before=$(flux colours.raymap 'registered(sensor)')
expect 0 '' mpirun -np 2 "$RAYMAP" trace scene.yaml -o colours.raymap --append -n 40000 --color rgb --quiet
expect 0 '' "$RAYMAP" trace scene.yaml -o colours.raymap --append -n 40000 --quiet \
    --set 'spectrum.wavelengths=[486.13, 500, 587.56, 656.27]'
expect 0 '120,000 rays' "$RAYMAP" info colours.raymap
/usr/bin/python3 - "$before" "$(flux colours.raymap 'registered(sensor)')" <<'PY' || { echo "FAILED: flux of three colour spaces"; failures=1; }
import sys
(matched, total), (now, now_total) = (map(float, words.split()) for words in sys.argv[1:])
print(f"{matched} of {total} W in one space, {now} of {now_total} W in three")
sys.exit(not (abs(total - 1) < 1e-9 and abs(now_total - 1) < 1e-9 and abs(matched - now) < 0.01 * matched))
PY
expect 0 '' "$RAYMAP" report colours.raymap 5
expect 0 '' "$RAYMAP" report colours.raymap 50000
expect 0 '' "$RAYMAP" report colours.raymap 90000
# The same again is found, not made again; a stop in the middle is resumed in each space.
cp -r colours.raymap ends.raymap
expect 6 '' mpirun -np 2 "${at_commit[@]}" "$RAYMAP" trace scene.yaml -o ends.raymap --append -n 60k \
    --color rgb --quiet --flush-portions 2
expect 0 '' "$RAYMAP" trace scene.yaml -o ends.raymap --resume --quiet
expect 0 '180,000 rays' "$RAYMAP" info ends.raymap
expect 0 '' "$RAYMAP" trace scene.yaml -o colours.raymap --append -n 60k --color rgb --quiet
[ "$(digest ends.raymap)" = "$(digest colours.raymap)" ] || { echo "FAILED: resumed in another colour space"; failures=1; }

# Rays with wavelengths after rays without: their numbers are those of a map of theirs alone.
mean() { "$RAYMAP" stats "$1" --of wavelength --json --quiet | /usr/bin/python3 -c '
import json, sys
print("%.9g" % json.load(sys.stdin)["mean"]["value"])'; }
expect 0 '' "$RAYMAP" trace scene.yaml -o alone.raymap -n 4000 --first-ray 3000 --quiet
for encoding in plain compact; do
    expect 0 '' "$RAYMAP" trace scene.yaml -o mixed.raymap -n 3000 --color rgb --quiet --force --encoding $encoding
    expect 0 '' "$RAYMAP" trace scene.yaml -o mixed.raymap --append -n 4000 --color spectral --quiet
    expect 3 "other wavelengths.* --where 'ray < 3000'" "$RAYMAP" detector mixed.raymap sensor --quantity spectral
    expect 0 'green' "$RAYMAP" detector mixed.raymap sensor --quantity spectral --where 'ray < 3000'
    [ "$(mean mixed.raymap)" = "$(mean alone.raymap)" ] || { echo "FAILED: wavelengths after colours, $encoding"; failures=1; }
done
rm -rf ./*.raymap
finish
