#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: `report MAP --energy` and the page of --html say the same, byte for byte, on any number
# of ranks, in every form.
. "$SOURCE_DIR/tests/cli/expect.bash"
rm -rf ./*
write_scene scene.yaml
expect 0 '' "$RAYMAP" trace scene.yaml -o a.raymap -n 30000 --quiet
for ranks in 1 3; do
    by_ranks $ranks
    mkdir $ranks
    for where in all 'registered(sensor)' 'hit(*) > 1000'; do
        expect 0 '' "${start[@]}" "$RAYMAP" report a.raymap --energy --where "$where" --json
        cat stdout.txt >>$ranks/json.txt
    done
    for form in csv png svg; do
        expect 0 '' "${start[@]}" "$RAYMAP" report a.raymap --energy -o $ranks/all.$form
        cp stdout.txt $ranks/table.txt
    done
    expect 0 '' "${start[@]}" "$RAYMAP" report a.raymap --html $ranks/page.html --quiet
    diff -r 1 $ranks || failures=$((failures + 1))
done
finish
