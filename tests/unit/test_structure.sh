#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The walls of the house: what each layer and each room in it may include, what it may export, how the
# tree is formatted, and that no file knows the machine it was written on.
set -u
cd "${SOURCE_DIR:?}" || exit 1
failures=0

fail() {
    printf 'FAIL: %s\n%s\n\n' "$1" "$2"
    failures=$((failures + 1))
}

# forbid FOLDERS PATTERN WHY: no #include line in FOLDERS may match PATTERN.
forbid() {
    local found
    # shellcheck disable=SC2086 # a list of folders
    found=$(grep -rnE --include='*.[ch]' --include='*.[ch]pp' "^[[:space:]]*#[[:space:]]*include[[:space:]]*[<\"]($2)" $1)
    [ -z "$found" ] || fail "$3" "$found"
}

forbid src '(io|analysis|mpi)/' 'src includes nothing of io, analysis or mpi'
forbid io '(analysis|mpi)/' 'io includes nothing of analysis or mpi'
forbid analysis 'mpi/' 'analysis includes nothing of mpi'
forbid 'src analysis mpi' 'hdf5' 'hdf5.h is included under io alone'
forbid 'src io analysis' 'mpi\.h' 'mpi.h is included under mpi alone'
forbid 'io analysis mpi' 'embree' 'Embree is included under src/accel alone'
forbid 'src io analysis mpi' '\.\./' 'no include climbs out of its folder'
embree=$(grep -rlE --include='*.[ch]' 'include[[:space:]]*<embree' src | grep -v '^src/accel/')
[ -z "$embree" ] || fail 'Embree is included under src/accel alone' "$embree"

# Rooms of each layer: one includes what stands before it, so that there are no circles.
rooms_src='base formula optics scatter geometry gradient scene portion accel trace render compact'
rooms_io='cad file codec hdf5 export picture mesh lamp rays lensfile assembly scene map write recovery'
rooms_analysis='table criterion overlay query detector photometry paths stats compare energy figure sweep page report library'
rooms_mpi='parallel command scan trace upkeep answer sweep session serve cli'
for layer in src io analysis mpi; do
    rooms=rooms_$layer
    below=$([ $layer = src ] || echo "$layer/")
    later=" ${!rooms} "
    for room in ${!rooms}; do
        later=${later# "$room"}
        [ -s "$layer/$room/README.md" ] || fail 'every room says what lives there' "$layer/$room/README.md"
        # shellcheck disable=SC2086 # a list of rooms
        [ -z "${later// /}" ] ||
            forbid "$layer/$room" "$below($(echo $later | tr ' ' '|'))/" "$layer/$room includes no later room"
    done
    unknown=$(find $layer -mindepth 1 -maxdepth 1 -type d -printf '%f\n' | grep -vxE "$(echo "${!rooms}" | tr ' ' '|')")
    [ -z "$unknown" ] || fail "every room of $layer has its place in the order" "$unknown"
    lobby=$(find $layer -maxdepth 1 -name '*.c' | wc -l)
    [ "$lobby" -le 12 ] || fail 'at most 12 .c files directly in a layer' "$layer: $lobby"
done

# Every source names its licence in one line.
unlicensed=$(find src io analysis mpi tests jobs -type f \
    \( -name '*.[ch]' -o -name '*.[ch]pp' -o -name '*.sh' -o -name '*.py' \) -print0 |
    xargs -0 grep -L 'SPDX-License-Identifier: MIT')
[ -z "$unlicensed" ] || fail 'every source carries the SPDX line' "$unlicensed"

# Two files of one name make includes and test programs ambiguous.
twins=$(find src io analysis mpi \( -name '*.[ch]' -o -name '*.[ch]pp' \) -printf '%f\n' | sort | uniq -d)
[ -z "$twins" ] || fail 'file names are unique' "$twins"

build=$(dirname "${RAYMAP_PROGRAM:-${RAYMAP:?}}") # not what looks at its answers
for library in "$build"/librmap_*.a; do
    alien=$(nm --extern-only --defined-only --no-sort "$library" 2>/dev/null |
        awk 'NF == 3 && $3 !~ /^(rmap_|__(a|ub)san|__odr_asan|__gcov)/ {print $3}')
    [ -z "$alien" ] || fail "$(basename "$library") exports names without the prefix rmap_" "$alien"
done
# Two of one name link or not by the order of the libraries.
doubles=$(nm --extern-only --defined-only "$build"/librmap_*.a 2>/dev/null |
    awk 'NF == 3 && $3 ~ /^rmap_/ {print $3}' | sort | uniq -d)
[ -z "$doubles" ] || fail 'every exported name is defined once' "$doubles"
[ -e "$build/librmap_src.a" ] || fail 'the libraries are where they are looked for' "$build"

if command -v clang-format >/dev/null; then
    unformatted=$(find src io analysis mpi tests \( -name '*.[ch]' -o -name '*.[ch]pp' \) -print0 |
        xargs -0 clang-format --dry-run -Werror 2>&1 | grep -E 'error:' | cut -d: -f1 | sort -u)
    [ -z "$unformatted" ] || fail 'the tree is formatted (clang-format -i)' "$unformatted"
else
    echo 'clang-format is not here: formatting not checked'
fi

if git rev-parse --git-dir >/dev/null 2>&1; then
    # Paths that exist everywhere are fine; a developer's folders are not. The pattern is put
    # together here so that this file does not match itself.
    folders='work|home|root|farm|Users'
    paths=$(git grep -nIE "(^|[^A-Za-z0-9_.~])/($folders)/[A-Za-z]" -- .)
    [ -z "$paths" ] || fail 'no tracked file contains a path of one machine' "$paths"
    # What runs by hand leave behind is not swept in.
    strangers=$(git ls-files -- ':(glob)*' |
        grep -vxE '\.clang-format|\.gitattributes|\.dockerignore|\.gitignore|CMake(Lists\.txt|Presets\.json)|LICENSE|[A-Z]+\.md')
    [ -z "$strangers" ] || fail 'the top folder holds no file but the known ones' "$strangers"
else
    echo 'no git here: tracked paths not checked'
fi

[ "$failures" -eq 0 ] && echo 'all walls stand'
exit "$((failures > 0))"
