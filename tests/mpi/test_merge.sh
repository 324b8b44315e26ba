#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: maps of one scene with different rays become one that equals the map traced at once,
# without copying them; what does not belong together is refused, naming both.
. "$(dirname "$0")/../cli/expect.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
rm -rf ./*
write_scene scene.yaml
digest() {
    "$RAYMAP" info "$1" --json | sed -n 's/.*"digest": "\([0-9a-f]\{32\}\)".*/\1/p'
}
same() { # MAP: as all.raymap
    [ "$(digest "$1")" = "$(digest all.raymap)" ] || { echo "FAILED: another digest: $1"; failures=1; }
    "$RAYMAP" detector "$1" sensor -o image.csv --force --quiet
    cmp image.csv want.csv || { echo "FAILED: another image: $1"; failures=1; }
    expect 0 ' 0 findings' "$RAYMAP" verify "$1"
}

"$RAYMAP" trace scene.yaml -o all.raymap -n 50000 --quiet
"$RAYMAP" detector all.raymap sensor -o want.csv --quiet
"$RAYMAP" query all.raymap 'registered(sensor)' 'ended(left)' --quiet >want.txt
mpirun -np 2 "$RAYMAP" trace scene.yaml -o a.raymap -n 20480 --quiet
"$RAYMAP" trace scene.yaml -o b.raymap --first-ray 20480 -n 9520 --encoding plain --quiet --piece-size 1Mi
"$RAYMAP" trace scene.yaml -o c.raymap --first-ray 30000 -n 20000 --quiet
expect 0 '50,000 rays' "$RAYMAP" merge a.raymap b.raymap c.raymap -o merged.raymap
same merged.raymap
"$RAYMAP" query merged.raymap 'registered(sensor)' 'ended(left)' --quiet >count.txt
cmp <(grep -v read count.txt) <(grep -v read want.txt) || { echo "FAILED: another count"; failures=1; }
expect 0 '' mpirun -np 2 "$RAYMAP" merge c.raymap a.raymap -o ca.raymap --quiet
expect 0 '"complete": true' "$RAYMAP" merge ca.raymap b.raymap -o nested.raymap --json
one=$(stat -c %i a.raymap/shard-00000/piece-00000.h5)
[ "$(stat -c %i merged.raymap/shard-00000/piece-00000.h5)" = "$one" ] ||
    [ -h merged.raymap/shard-00000/piece-00000.h5 ] || { echo "FAILED: a piece was copied"; failures=1; }
rm -rf ca.raymap
same nested.raymap # hard links need nothing of what they were made from

# Another colour space of the same scene joins; its rays are not those of the first.
"$RAYMAP" trace scene.yaml -o rgb.raymap --color rgb --first-ray 60000 -n 5000 --encoding plain --quiet
expect 0 '55,000 rays' "$RAYMAP" merge all.raymap rgb.raymap -o colours.raymap
expect 0 ' 0 findings' "$RAYMAP" verify colours.raymap
expect 0 '55,000 rays' "$RAYMAP" convert colours.raymap -o again.raymap
expect 0 ' 0 findings' "$RAYMAP" verify again.raymap
[ "$(digest again.raymap)" = "$(digest colours.raymap)" ] || { echo "FAILED: colours"; failures=1; }

# Maps that were asked for some of the same rays, none of which they hold: each is traced once.
"$RAYMAP" trace scene.yaml -o front.raymap -n 30000 --quiet
"$RAYMAP" trace scene.yaml -o back.raymap --first-ray 10000 -n 40000 --quiet
for map in front back; do
    rm -r $map.raymap/shard-*
    expect 0 ' 0 rays, .* lost' "$RAYMAP" repair $map.raymap
done
expect 0 'not complete' "$RAYMAP" merge back.raymap front.raymap -o both.raymap
expect 2 'asked for 50,000 rays' "$RAYMAP" trace scene.yaml -o both.raymap --resume -n 70000
expect 0 '^50,000 rays in' "$RAYMAP" trace scene.yaml -o both.raymap --resume -n 50000
same both.raymap

# The name of the scene's file is no part of it.
cp scene.yaml renamed.yaml
"$RAYMAP" trace renamed.yaml -o d.raymap --first-ray 30000 -n 20000 --quiet
expect 0 '50,000 rays' "$RAYMAP" merge a.raymap b.raymap d.raymap -o names.raymap
same names.raymap
"$RAYMAP" trace scene.yaml -o e.raymap -n 30000 --quiet
expect 0 '^50,000 rays in|20,000 rays' "$RAYMAP" trace renamed.yaml -o e.raymap --append -n 20000
rm e.raymap/map.h5 e.raymap/map-start.h5
expect 0 '' "$RAYMAP" repair e.raymap --scene renamed.yaml
same e.raymap

# What does not belong together.
expect 3 'a.raymap and all.raymap both hold the rays 0 to 20479 \(20,480 rays\):' \
    "$RAYMAP" merge a.raymap all.raymap -o x.raymap
"$RAYMAP" trace scene.yaml -o one.raymap --first-ray 49999 -n 10 --quiet
expect 3 'one.raymap and all.raymap both hold ray 49999:' "$RAYMAP" merge one.raymap all.raymap -o x.raymap
"$RAYMAP" trace scene.yaml -o seed.raymap --seed 2 --first-ray 50000 -n 10 --quiet
expect 3 'seed.raymap cannot join.*seed' "$RAYMAP" merge a.raymap seed.raymap -o x.raymap
sed 's/N-BK7/N-SF11/' scene.yaml >other.yaml
"$RAYMAP" trace other.yaml -o other.raymap --first-ray 50000 -n 10 --quiet
expect 3 'other.raymap cannot join.*another scene' "$RAYMAP" merge a.raymap other.raymap -o x.raymap
expect 2 'exists' "$RAYMAP" merge a.raymap b.raymap -o merged.raymap
expect 2 'one of the maps' "$RAYMAP" merge a.raymap b.raymap -o b.raymap --force
expect 2 'give -o' "$RAYMAP" merge a.raymap b.raymap
expect 3 '' "$RAYMAP" merge a.raymap nothing.raymap -o x.raymap
rm b.raymap/shard-00000/piece-00000.h5
expect 4 'missing' "$RAYMAP" merge a.raymap b.raymap -o x.raymap
[ ! -e x.raymap ] || { echo "FAILED: x.raymap was made"; failures=1; }
# What fails in the middle leaves nothing behind.
expect 5 'No space' env "LD_PRELOAD=$FAULTS" "FAULTS_DIR=$PWD/half.raymap" \
    FAULTS_CALLS=mkdir FAULTS_AT=3 FAULTS_ACTION=ENOSPC "$RAYMAP" merge a.raymap c.raymap -o half.raymap
[ ! -e half.raymap ] || { echo "FAILED: half a map stays behind"; failures=1; }
finish
