#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: maps of up to 10 million rays are columns that any HDF5 tool reads, larger ones are
# compact, unless the command line says it; what a map was begun in it goes on in.
. "$(dirname "$0")/expect.bash"
rm -rf ./*
write_scene scene.yaml

expect 0 '' "$RAYMAP" trace scene.yaml -o small.raymap -n 2000
! cat stdout.txt stderr.txt | grep -q compact || { echo "FAILED: a small map is not compact"; failures=1; }
expect 0 '1 piece, plain$' "$RAYMAP" info small.raymap

expect 0 '' "$RAYMAP" trace scene.yaml -o told.raymap -n 20000 --encoding compact
expect 0 '^  compact  5 portions, rays traced again in none$' "$RAYMAP" query told.raymap 'hit(lens)' --explain
expect 0 '^  compact  5 portions, rays traced again in 5 portions$' "$RAYMAP" query told.raymap 'path_length > 1' --explain
expect 6 'compact encoding; --encoding plain' "$RAYMAP" trace scene.yaml -o large.raymap -n 10000001 --time-limit 0.3s
expect 0 ', compact$' "$RAYMAP" info large.raymap
expect 6 'compact encoding; --encoding plain' "$RAYMAP" trace scene.yaml -o begun.raymap -n 20M --resume --time-limit 0.3s
expect 6 '"encoding": "compact"' "$RAYMAP" trace scene.yaml -o begun.raymap --resume --json --time-limit 0.3s
! grep -q 'so many rays' stderr.txt || { echo "FAILED: of a map that stands it is said again"; failures=1; }
expect 6 '' "$RAYMAP" trace scene.yaml -o most.raymap -n 10000000 --time-limit 0.3s
expect 0 ', plain$' "$RAYMAP" info most.raymap
expect 6 '' "$RAYMAP" trace scene.yaml -o said.raymap -n 20M --encoding plain --time-limit 0.3s
expect 0 ', plain$' "$RAYMAP" info said.raymap

# What is resumed or added to stays as it is; of nothing but an index, the rays asked for say it.
expect 6 '' "$RAYMAP" trace scene.yaml -o large.raymap --resume --time-limit 0.3s
expect 0 ' pieces, compact$' "$RAYMAP" info large.raymap
expect 6 '' "$RAYMAP" trace scene.yaml -o small.raymap -n 20M --append --time-limit 0.3s
expect 0 ' pieces, plain$' "$RAYMAP" info small.raymap
rm -rf large.raymap/shard-*
expect 0 '' "$RAYMAP" repair large.raymap
expect 0 'NOT complete: it holds no rays yet' "$RAYMAP" info large.raymap
expect 6 '' "$RAYMAP" trace scene.yaml -o large.raymap --resume --time-limit 0.3s
expect 0 ', compact$' "$RAYMAP" info large.raymap
expect 6 '^large.raymap: plain and compact, ' "$RAYMAP" trace scene.yaml -o large.raymap --resume --encoding plain --time-limit 0.3s
expect 0 ', plain and compact$' "$RAYMAP" info large.raymap
rm -rf ./*.raymap
finish
