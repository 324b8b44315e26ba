#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: maps are compact unless the command line says plain; what a map was begun in it goes
# on in; and everyone is told which it is and how to get columns.
. "$(dirname "$0")/expect.bash"
rm -rf ./*
write_scene scene.yaml

expect 0 '^small.raymap: compact, ' "$RAYMAP" trace scene.yaml -o small.raymap -n 20000
expect 0 '1 piece, compact$' "$RAYMAP" info small.raymap
expect 0 '^  compact  5 portions, rays traced again in none$' "$RAYMAP" query small.raymap 'hit(lens)' --explain
expect 0 '^  compact  5 portions, rays traced again in none$' "$RAYMAP" query small.raymap 'hit(lens where step >= 2)' --explain
expect 0 '^  compact  5 portions, rays traced again in none$' "$RAYMAP" query small.raymap 'hit(lens where x < 3 and step >= 99)' --explain
expect 0 '^  compact  5 portions, rays traced again in 5 portions$' "$RAYMAP" query small.raymap 'path_length > 1' --explain
expect 0 '"encoding": "compact"' "$RAYMAP" trace scene.yaml -o one.raymap -n 1 --json
expect 0 '' "$RAYMAP" trace scene.yaml -o columns.raymap -n 2000 --encoding plain
! grep -q compact stdout.txt || { echo "FAILED: columns are not compact"; failures=1; }
expect 0 '1 piece, plain$' "$RAYMAP" info columns.raymap
expect 6 '' "$RAYMAP" trace scene.yaml -o large.raymap -n 20M --time-limit 0.3s
expect 0 ', compact$' "$RAYMAP" info large.raymap

# What is resumed or added to stays as it is; of nothing but an index, the default says it.
expect 6 '' "$RAYMAP" trace scene.yaml -o large.raymap --resume --time-limit 0.3s
expect 0 ' pieces, compact$' "$RAYMAP" info large.raymap
expect 0 '' "$RAYMAP" trace scene.yaml -o columns.raymap -n 2000 --append
expect 0 ' pieces, plain$' "$RAYMAP" info columns.raymap
rm -rf columns.raymap/shard-*
expect 0 '' "$RAYMAP" repair columns.raymap
expect 0 'NOT complete: it holds no rays yet' "$RAYMAP" info columns.raymap
expect 0 '' "$RAYMAP" trace scene.yaml -o columns.raymap --resume
expect 0 ', compact$' "$RAYMAP" info columns.raymap
expect 6 '^large.raymap: plain and compact, ' "$RAYMAP" trace scene.yaml -o large.raymap --resume --encoding plain --time-limit 0.3s
expect 0 ', plain and compact$' "$RAYMAP" info large.raymap
rm -rf ./*.raymap
finish
