#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: a shard's folder that is a link, into another map or this one, is neither written
# through nor cleared; commands that would have to say so, status 2, and what it leads to stays.
. "$(dirname "$0")/expect.bash"
rm -rf ./*
write_scene scene.yaml
trace() { "$RAYMAP" trace scene.yaml --quiet --encoding plain "$@" || exit 1; }

wrong() {
    echo "FAILED: $*"
    failures=$((failures + 1))
}

sums() { find "$1/" -type f | sort | xargs sha256sum; }

trace -o other.raymap -n 3000 --first-ray 1000
trace -o part.raymap -n 500
trace -o kept.raymap -n 1000
ln -s ../other.raymap/shard-00000 kept.raymap/shard-00001
others=$(sums other.raymap)
own=$(sums kept.raymap)

refused() { # COMMAND...
    expect 2 'kept.raymap/shard-00001 is a link.*take the link away' "$RAYMAP" "$@"
    [ "$(sums other.raymap)" = "$others" ] || wrong "another map was touched by: $*"
    [ "$(sums kept.raymap)" = "$own" ] || wrong "the map was touched by: $*"
    [ -L kept.raymap/shard-00001 ] || wrong "the link is gone after: $*"
}

refused trace scene.yaml -o kept.raymap -n 100 --force
refused convert part.raymap -o kept.raymap --force
refused query part.raymap 'ray < 9' -o kept.raymap --force
refused merge part.raymap -o kept.raymap --force
refused trace scene.yaml -o kept.raymap -n 100 --append
refused repair kept.raymap
expect 0 '1,000 rays' "$RAYMAP" info kept.raymap

# An unfinished map counts what lies in its own folders alone.
rm kept.raymap/shard-00001
"$RAYMAP" trace scene.yaml -o slow.raymap -n 5G --flush-portions 1 --quiet &
tracer=$!
until_traces slow.raymap
kill -9 $tracer && wait $tracer 2>/dev/null
ln -s ../other.raymap/shard-00000 slow.raymap/shard-00001
expect 0 'slow.raymap/shard-00001 is a link' "$RAYMAP" info slow.raymap
expect 2 'slow.raymap/shard-00001 is a link' "$RAYMAP" trace scene.yaml -o slow.raymap --resume
[ "$(sums other.raymap)" = "$others" ] || wrong 'another map was touched by --resume'

# A link to a folder of the same map: what it shows twice is there once.
ln -s shard-00000 kept.raymap/shard-00001
refused repair kept.raymap
expect 0 ' 0 findings' "$RAYMAP" verify kept.raymap

# Folders that somebody put elsewhere by hand are read, and not written to.
mkdir afar
mv kept.raymap/shard-00000 afar
rm kept.raymap/shard-00001
ln -s ../afar/shard-00000 kept.raymap
expect 0 '500 of 1,000|500' "$RAYMAP" query kept.raymap 'ray < 500' --count
expect 2 'kept.raymap/shard-00000 is a link' "$RAYMAP" trace scene.yaml -o kept.raymap --append -n 5
[ "$(ls -A afar/shard-00000)" = piece-00000.h5 ] || wrong 'written through a link'

# Nor does --shard-dir write through one; where it writes to folders, its maps stay as good.
mkdir disk
ln -s ../other.raymap/shard-00000 disk
expect 2 'disk/shard-00000 is a link' "$RAYMAP" trace scene.yaml -o apart.raymap -n 100 --shard-dir disk
[ "$(sums other.raymap)" = "$others" ] || wrong 'another map was touched by --shard-dir'
[ ! -e apart.raymap ] || wrong 'a map that was refused is there'
rm disk/shard-00000
trace -o apart.raymap -n 100 --shard-dir disk
once=$(sums disk)
expect 2 'disk/shard-00000 holds .piece-00000.h5. of another map' "$RAYMAP" trace scene.yaml -o apart2.raymap -n 100 --shard-dir disk
expect 2 'holds' "$RAYMAP" trace scene.yaml -o part.raymap -n 100 --shard-dir disk --force
expect 0 ' 500 rays' "$RAYMAP" info part.raymap
expect 5 'nowhere is no directory' "$RAYMAP" trace scene.yaml -o apart2.raymap -n 100 --shard-dir nowhere
[ "$(sums disk)" = "$once" ] && [ ! -e apart2.raymap ] || wrong 'two maps in one folder'
trace -o apart.raymap -n 100 --append --shard-dir disk
[ -e disk/shard-00001 ] || wrong 'no shard of its own was added'
mv disk/shard-* apart.raymap
trace -o apart.raymap -n 100 --append
expect 0 '' "$RAYMAP" verify apart.raymap
expect 0 '' "$RAYMAP" repair apart.raymap
trace -o apart.raymap -n 100 --force

# What stands in the place of the map's lock is no raymap's: told, with the remedy, and left alone.
lock=apart.raymap/.map.h5.writer.part
for make in 'ln -s ../other.raymap/map.h5' 'ln -s nowhere' mkfifo mkdir; do
    $make "$lock"
    for words in 'trace scene.yaml --append -n 5 -o' repair; do
        # shellcheck disable=SC2086 # words
        expect 5 "$lock is no regular file.*: remove it" "$RAYMAP" $words apart.raymap
    done
    rm -r "$lock"
done
[ "$(sums other.raymap)" = "$others" ] || wrong 'another map was touched by way of the lock'
finish
