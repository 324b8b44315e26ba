#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: what the program answers over the examples stays what it was (tests/golden). Where an answer is to be another,
# `tests/compare_builds.sh --write BUILD` writes it down, and the change of tests/golden says what changed.
. "$(dirname "$0")/expect.bash"
program=${RAYMAP_PROGRAM:-$RAYMAP}
isa=$("$program" trace "$SOURCE_DIR/examples/luneburg/scene.yaml" -o isa.raymap -n 1 --force --quiet &&
    "$program" info isa.raymap --json | sed -n 's/.*"isa": "\(.*\)",.*/\1/p')
[ "$isa" = AVX-512 ] || { echo "the golden answers are of AVX-512, which decides ties of triangles; here is $isa"; exit 77; }
whole=(double-gauss room)
[ -z "$SLOW" ] || whole=()
expect 0 'all the same' "$SOURCE_DIR/tests/compare_builds.sh" --check "$program" "${whole[@]}"
[ $failures -eq 0 ] || cat stdout.txt
finish
