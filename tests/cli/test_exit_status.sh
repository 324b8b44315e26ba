#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: every way to end has its own exit status and one message that says what to do.
. "$(dirname "$0")/expect.bash"
rm -rf ./*
write_scene scene.yaml
i=0

# 0: done
expect 0 'usage: raymap' "$RAYMAP" --help
expect 0 '' "$RAYMAP" --version
for library in Embree MPI HDF5 libdeflate xxHash libyaml Assimp zlib jansson; do
    grep -Eq "^$library +[0-9O]" stdout.txt || { echo "FAILED: --version tells nothing of $library"; failures=1; }
done
ways=("COMMAND --help" "COMMAND one two three --help" "help COMMAND")
for command in check trace info query report detector draw verify repair convert merge bench; do
    way=${ways[++i % 3]}
    # shellcheck disable=SC2086 # words
    expect 0 "usage: raymap $command" "$RAYMAP" ${way/COMMAND/$command}
done
expect 0 'sensor' "$RAYMAP" check scene.yaml
expect 0 'energy balance' "$RAYMAP" trace scene.yaml -o a.raymap -n 10k
expect 0 '10,000 rays' "$RAYMAP" info a.raymap
expect 0 'registered' "$RAYMAP" query a.raymap 'registered(sensor)'
expect 0 'rays +0 of' "$RAYMAP" query a.raymap 'hit(lens) >= 1000'
expect 0 '' "$RAYMAP" trace -n 1000 scene.yaml --quiet -o b.raymap # options before operands
[ ! -s stdout.txt ] && [ ! -s stderr.txt ] || { echo "FAILED: --quiet talks"; failures=1; }
expect 0 '' "$RAYMAP" trace scene.yaml -o pieces.raymap -n 2000 --piece-size 256Mi
expect 0 '5,000 rays' "$RAYMAP" trace scene.yaml --simulation short --no-record
sed 's/rays: 5000/rays: 50, record: false/' scene.yaml >unrecorded.yaml
expect 0 "'short' says record: false: no map is made" "$RAYMAP" trace unrecorded.yaml --simulation short -o none.raymap
[ ! -e none.raymap ] || { echo "FAILED: record: false made a map"; failures=1; }
expect 0 '' "$RAYMAP" trace scene.yaml -o a.raymap -n 2000 --force
expect 0 '2,000 rays' "$RAYMAP" info a.raymap

# 2: wrong usage, with the remedy
expect 2 'no command given' "$RAYMAP"
expect 2 "did you mean 'trace'" "$RAYMAP" trase
expect 2 "did you mean 'trace'" "$RAYMAP" help trase
expect 2 "did you mean '--rays'" "$RAYMAP" trace scene.yaml --rayz 3 -o x.raymap
expect 2 'needs a value' "$RAYMAP" trace scene.yaml -o
# what a second value would make forgotten is refused; where several are meant, all count
expect 2 "'--output' is given twice" "$RAYMAP" paths a.raymap -o a.csv -o a.json
expect 2 "'--where' is given twice" "$RAYMAP" paths a.raymap --where all --where all
[ ! -e a.csv ] && [ ! -e a.json ] || { echo "FAILED: written nonetheless"; failures=1; }
expect 0 '' "$RAYMAP" stats a.raymap --of segments -o a.csv -o a.svg
[ -s a.csv ] && [ -s a.svg ] || { echo "FAILED: stats wrote one of two"; failures=1; }
rm -f a.csv a.svg
expect 2 'takes no value' "$RAYMAP" trace scene.yaml -o x.raymap --force=yes
expect 2 "unknown option '-x'" "$RAYMAP" trace -x scene.yaml
expect 2 'usage: raymap trace' "$RAYMAP" trace
expect 2 'KEY=VALUE' "$RAYMAP" check scene.yaml --set units
expect 2 'one word too many' "$RAYMAP" trace scene.yaml scene.yaml -o x.raymap
expect 2 'at least one ray' "$RAYMAP" trace scene.yaml -o x.raymap -n 0
expect 2 'whole number' "$RAYMAP" trace scene.yaml -o x.raymap -n many
expect 2 'whole number' "$RAYMAP" trace scene.yaml -o x.raymap -n -5
expect 2 'whole number' "$RAYMAP" trace scene.yaml -o x.raymap -n nan
expect 2 'too large' "$RAYMAP" trace scene.yaml -o x.raymap -n 99999999999999999999999
expect 2 'give -o MAP' "$RAYMAP" trace scene.yaml -n 10
expect 2 'exists' "$RAYMAP" trace scene.yaml -o a.raymap -n 10
expect 2 'too many' "$RAYMAP" trace scene.yaml -o x.raymap -n 10 --first-ray 18446744073709551606
expect 2 'whole number' "$RAYMAP" trace scene.yaml -o x.raymap -n 10 --first-ray -1
expect 2 "'plain' or 'compact'" "$RAYMAP" trace scene.yaml -o x.raymap --encoding zip
expect 2 'leave out --encoding' "$RAYMAP" trace scene.yaml --no-record --encoding plain
expect 2 'leave out --index' "$RAYMAP" trace scene.yaml --no-record --index
expect 0 'a.raymap is complete' "$RAYMAP" trace scene.yaml -o a.raymap --resume
expect 2 'was asked for 2,000 rays.*--append' "$RAYMAP" trace scene.yaml -o a.raymap --resume -n 10
expect 2 'does not begin with ray 5' "$RAYMAP" trace scene.yaml -o a.raymap --resume --first-ray 5
expect 2 'needs -n' "$RAYMAP" trace scene.yaml -o a.raymap --append
expect 2 'asked for rays 0 to 1999 already' "$RAYMAP" trace scene.yaml -o a.raymap --append -n 5 --first-ray 1999
expect 2 'leave out --resume' "$RAYMAP" trace scene.yaml -o a.raymap --append --resume -n 5
expect 2 '--force removes' "$RAYMAP" trace scene.yaml -o a.raymap --resume --force
expect 2 'leave out --no-record' "$RAYMAP" trace scene.yaml -o a.raymap --append -n 5 --no-record
expect 2 'needs -o' "$RAYMAP" trace scene.yaml --resume
expect 2 'above 0' "$RAYMAP" trace scene.yaml -o x.raymap --flush 0
expect 2 'at least 1' "$RAYMAP" trace scene.yaml -o x.raymap --flush-portions 0
expect 2 'piece-size must be at least 1' "$RAYMAP" trace scene.yaml -o x.raymap --piece-size 0
expect 2 'piece-size must be at least 1' "$RAYMAP" convert a.raymap -o x.raymap --piece-size 0
expect 2 'above 0' "$RAYMAP" trace scene.yaml -o x.raymap --time-limit soon
expect 2 'between 1 and' "$RAYMAP" trace scene.yaml -o x.raymap --threads 0
expect 2 "'rgb' or 'spectral'" "$RAYMAP" trace scene.yaml -o x.raymap --color blue
expect 2 'usage: raymap query' "$RAYMAP" query a.raymap
# the word that is missing is named; a wrong one is answered with those that there are
expect 2 'NAME is missing; usage: raymap detector' "$RAYMAP" detector a.raymap
expect 2 'MAP is missing; usage: raymap detector' "$RAYMAP" detector
expect 3 "no detector named 'film' in this map; it has 'sensor'" "$RAYMAP" detector a.raymap film
expect 3 "'screen' is an object.*--receivers FILE: .*on: 'screen'" "$RAYMAP" detector a.raymap screen
expect 3 "unknown number 'mass': say one of wavelength flux" "$RAYMAP" stats a.raymap --of mass
expect 3 "unknown number 'cel' .did you mean 'cell'" "$RAYMAP" stats a.raymap --of 'cel(sensor)'
expect 3 "of:1:16: error: expected the end .comparisons go to --where., found '>'" "$RAYMAP" stats a.raymap --of 'hit(*, absorb) > 1'
expect 3 "comparisons go to --where" "$RAYMAP" stats a.raymap --of 'registrations(sensor) == 2'
expect 0 'mean' "$RAYMAP" stats a.raymap --of 'path("T* (A|X)")'
expect 2 '^  5\.\.1$' "$RAYMAP" stats a.raymap --of path_length --range 5..1
expect 2 '^  5\.\.1 ?$' "$RAYMAP" detector a.raymap sensor --region 5,1,1,2
expect 2 'at most two --where' "$RAYMAP" compare a.raymap --where all --where all --where all
expect 2 "'size' is none: say one of flux, detector" "$RAYMAP" compare a.raymap a.raymap --test size
# a criterion of query stands by itself, or as that of other commands
expect 0 '2,000 of 2,000' "$RAYMAP" query a.raymap --where all
expect 2 'one criterion' "$RAYMAP" query a.raymap all --where all --limit 3
expect 2 '\.csv.*\.json' "$RAYMAP" query a.raymap all -o out.pdf
expect 2 'one criterion' "$RAYMAP" query a.raymap all all --limit 3
expect 2 '' "$RAYMAP" query a.raymap all --limit 0
expect 2 'empty name' "$RAYMAP" query a.raymap all -o ''
expect 2 'empty name' "$RAYMAP" trace scene.yaml -n 10 -o ''
# a folder is no file that --force replaces, and of a name like a file's no map is made
for out in folder.csv folder.json folder.png folder.h5 folder.html; do
    mkdir -p $out
    case $out in
    *.png | *.html) command="draw a.raymap" ;;
    *.h5) command="detector a.raymap sensor" ;;
    *) command="query a.raymap all" ;;
    esac
    # shellcheck disable=SC2086 # words
    expect 2 "'$out' is a directory" "$RAYMAP" $command -o $out --force
    rmdir $out || failures=1
done
expect 0 '' "$RAYMAP" query a.raymap all --limit 1 -o LOUD.CSV
expect 0 'nothing is wrong' "$RAYMAP" repair a.raymap --dry-run
touch there.csv
expect 2 'exists' "$RAYMAP" query a.raymap all -o there.csv
echo old >there.csv
"$RAYMAP" convert a.raymap -o bad.raymap --encoding plain --quiet && piece=bad.raymap/shard-00000/piece-00000.h5
for share in 2 3 4 5 6 7 8; do
    printf 'damaged' | dd of=$piece bs=1 conv=notrunc status=none \
        seek=$(($(stat -c %s $piece) * share / 10))
done
expect 4 'damaged' "$RAYMAP" query bad.raymap all -o there.csv --force
[ "$(cat there.csv)" = old ] && ! ls .there.csv* 2>/dev/null || { echo "FAILED: half an answer"; failures=1; }
expect 0 '' "$RAYMAP" query a.raymap all -o there.csv --force
grep -q old there.csv && { echo "FAILED: --force left the old file"; failures=1; }
! ls .there.csv* 2>/dev/null || { echo "FAILED: a temporary file stays"; failures=1; }
mkdir precious.raymap && touch precious.raymap/letter.txt
expect 2 '' "$RAYMAP" trace scene.yaml -o precious.raymap -n 10 --force
[ -f precious.raymap/letter.txt ] || { echo "FAILED: --force removed what is no map"; failures=1; }

# 3: wrong input
expect 3 'missing.yaml' "$RAYMAP" check missing.yaml
expect 3 'missing.yaml' "$RAYMAP" trace missing.yaml -o x.raymap
expect 3 'missing.raymap' "$RAYMAP" info missing.raymap
expect 3 'missing.raymap' "$RAYMAP" query missing.raymap all
expect 3 "no object named 'lense'.*|did you mean" "$RAYMAP" query a.raymap 'hit(lense)'
expect 3 '\^' "$RAYMAP" query a.raymap 'registered(sensor) and'
expect 3 'short' "$RAYMAP" trace scene.yaml -o x.raymap --simulation shirt
sed '/sources:/,/lamp/d' scene.yaml >dark.yaml
expect 3 'source' "$RAYMAP" trace dark.yaml -o x.raymap -n 10
sed 's/geometry: slab/geometry: slap/' scene.yaml >wrong.yaml
expect 3 "wrong.yaml:[0-9]+:[0-9]+: error: .*did you mean 'slab'" "$RAYMAP" check wrong.yaml
expect 3 "wrong.yaml:[0-9]+:[0-9]+: error: .*did you mean 'slab'" "$RAYMAP" trace wrong.yaml -o x.raymap
[ ! -e x.raymap ] || { echo "FAILED: a map was begun for a wrong scene"; failures=1; }

expect 3 'no map to add to' "$RAYMAP" trace scene.yaml -o x.raymap --append -n 10
expect 3 'seed 1, not 2' "$RAYMAP" trace scene.yaml -o a.raymap --append -n 10 --seed 2
expect 3 'first difference: --set' "$RAYMAP" trace scene.yaml -o a.raymap --resume --set limits.steps=5
expect 3 'no rays in this colour space.*--append' "$RAYMAP" trace scene.yaml -o a.raymap --resume --color rgb
mkdir there && sed 's/radius: 50,/radius: 51,/' scene.yaml >there/scene.yaml
expect 3 'first difference: line 1[0-9] of its text' "$RAYMAP" trace there/scene.yaml -o a.raymap --resume

# 4: what exists but is no map
echo "no map" >text.raymap
mkdir empty.raymap
expect 4 '' "$RAYMAP" info text.raymap
expect 4 '' "$RAYMAP" info empty.raymap
expect 4 '' "$RAYMAP" query text.raymap all
cp -r a.raymap broken.raymap
truncate -s 1000 broken.raymap/map.h5
expect 4 '' "$RAYMAP" info broken.raymap
cp -r a.raymap cut.raymap
piece=$(echo cut.raymap/shard-*/piece-*.h5)
truncate -s -2000 $piece
expect 4 'piece-00000.h5' "$RAYMAP" query cut.raymap all
expect 4 'damaged' "$RAYMAP" info cut.raymap
rm $piece
expect 4 '"complete": false' "$RAYMAP" info cut.raymap --json
mkdir -p lost.raymap && cp -r a.raymap/shard-00000 lost.raymap
expect 4 'pieces but no map.h5.*repair' "$RAYMAP" info lost.raymap
expect 4 'pieces but no map.h5.*repair' "$RAYMAP" verify lost.raymap
expect 4 'pieces but no map.h5' "$RAYMAP" trace scene.yaml -o lost.raymap --resume -n 2000

# 5: the system fails us. Root may do anything, so permission is tried as somebody else.
mkdir -p sealed && chmod 555 sealed
if [ "$(id -u)" -eq 0 ]; then
    expect 5 '' "$RAYMAP" trace scene.yaml -o /proc/x.raymap -n 10
else
    expect 5 '' "$RAYMAP" trace scene.yaml -o sealed/x.raymap -n 10
fi
as_other=
[ "$(id -u)" -ne 0 ] || as_other='setpriv --reuid 65534 --regid 65534 --clear-groups'
if $as_other "$RAYMAP" info a.raymap >/dev/null 2>&1; then
    cp -r a.raymap closed.raymap
    chmod 000 closed.raymap/shard-00000/piece-00000.h5
    for command in verify repair; do
        expect 5 'Permission denied' $as_other "$RAYMAP" $command closed.raymap
    done
    expect 5 'Permission denied' $as_other "$RAYMAP" query closed.raymap all
fi
if [ -w /dev/full ]; then
    "$RAYMAP" info a.raymap >/dev/full 2>stderr.txt
    [ $? -eq 5 ] || { echo "FAILED: a full disk under stdout is not told"; failures=1; }
fi

# 6: stopped early, and what was traced can be asked
expect 6 'time limit.*the map holds them' "$RAYMAP" trace scene.yaml -o late.raymap -n 1G --time-limit 1s
expect 0 'NOT complete' "$RAYMAP" info late.raymap
expect 0 'rays' "$RAYMAP" query late.raymap all
for signal in TERM INT USR1; do
    "$RAYMAP" trace scene.yaml -o $signal.raymap -n 1G --quiet 2>stderr.txt &
    until_traces $signal.raymap
    kill -$signal $!
    wait $!
    [ $? -eq 6 ] && grep -q "SIG$signal" stderr.txt || { echo "FAILED: SIG$signal"; cat stderr.txt; failures=1; }
    expect 0 'NOT complete' "$RAYMAP" info $signal.raymap
done
rm -rf ./*.raymap
finish
