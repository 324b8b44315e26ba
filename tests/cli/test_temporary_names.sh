#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: a result is written through no link, keeps the mode of the file that it replaces, and
# stands in place of a link that had its name.
. "$(dirname "$0")/expect.bash"
umask 022
rm -rf ./*
write_scene scene.yaml
expect 0 '' "$RAYMAP" trace scene.yaml -o map.raymap -n 500 --quiet
echo 'of somebody else' >victim

# Links at the name that earlier versions wrote to: .NAME.JOB.RESTART.HOST.PID.part.
trapped=(bash -c 'ln -s "$PWD/victim" ".$0.${SLURM_JOB_ID:-0}.${SLURM_RESTART_COUNT:-0}.$(uname -n).$$.part"
    exec "$@"')

wrong() {
    echo "FAILED: $*"
    failures=$((failures + 1))
}

result() { # OUT WORDS...
    local out=$1 mode=${mode:-600}
    shift
    expect 0 '' "${trapped[@]}" "$out" "$RAYMAP" "$@" -o "$out" --quiet
    [ "$(tr -d "\\0" <victim)" = 'of somebody else' ] || { wrong "$out was written through a link" && echo 'of somebody else' >victim; }
    rm -f ".$out."*.part
    [ "$(stat -c %F,%a "$out")" = 'regular file,644' ] || wrong "$out: $(stat -c %F,%a "$out")"
    chmod "$mode" "$out"
    expect 0 '' "$RAYMAP" "$@" -o "$out" --force --quiet
    [ "$(stat -c %a "$out")" = "$mode" ] || wrong "$out had mode $mode, has $(stat -c %a "$out")"
    [ -z "$(compgen -G ".$out.*")" ] || wrong "a temporary file of $out stays"
}

for suffix in csv json h5 png npz npy svg; do
    result stats.$suffix stats map.raymap --of path_length
done
result image.exr detector map.raymap sensor
for suffix in html vtp glb gltf; do
    result scene.$suffix draw map.raymap --limit 5
done
result rays.csv query map.raymap all --limit 5
result paths.json paths map.raymap
mode=440 result energy.csv report map.raymap --energy

# A link at the result's own name is replaced, not followed; where it leads nowhere, --force is asked for too.
ln -sf victim link.csv
ln -s nowhere dangling.csv
for link in link dangling; do
    expect 2 'exists' "$RAYMAP" stats map.raymap --of path_length -o $link.csv
    expect 0 '' "$RAYMAP" stats map.raymap --of path_length -o $link.csv --force --quiet
    [ "$(stat -c %F,%a $link.csv)" = 'regular file,644' ] || wrong "$link.csv: $(stat -c %F,%a $link.csv)"
done
[ "$(cat victim)" = 'of somebody else' ] && [ ! -e nowhere ] || wrong 'a link was followed'
finish
