# SPDX-License-Identifier: MIT
#
# For the scripts beside it: runs the program, compares exit status and words.
#
#   expect STATUS WORDS COMMAND...   the command exits with STATUS and says WORDS (a grep -E
#                                    pattern) on stdout or stderr; '' asks for no words
#
# Whatever it starts beside the command costs as much as a tenth of a start of the program: it looks at files itself where it can,
# and leaves what hangs to ctest.
# SLOW is empty in a quick run: `for ranks in 2 ${SLOW:+1 3}` takes the rest of a matrix under the label slow alone.
set -u
failures=0
SLOW=
[ "${RAYMAP_TEST_SCALE:-1}" -le 1 ] || SLOW=yes

expect() {
    local status=$1 words=$2 errors
    shift 2
    "$@" >stdout.txt 2>stderr.txt </dev/null
    local got=$?
    IFS= read -r -d '' errors <stderr.txt || true
    if [ $got -ne "$status" ]; then
        printf 'FAILED: exit status %d, not %d: %s\n' $got "$status" "$*"
        sed 's/^/    /' stderr.txt | head -20
        failures=$((failures + 1))
    elif [ -n "$words" ] && [[ $errors != *"$words"* ]] && ! grep -Eq -e "$words" stdout.txt stderr.txt; then
        printf 'FAILED: "%s" is not said by: %s\n' "$words" "$*"
        cat stdout.txt stderr.txt | sed 's/^/    /' | head -20
        failures=$((failures + 1))
    fi
    if [[ $errors =~ Sanitizer|'runtime error:' ]]; then
        printf 'FAILED: a sanitizer complained: %s\n' "$*"
        sed 's/^/    /' stderr.txt | head -40
        failures=$((failures + 1))
    fi
}

by_ranks() { # N: what starts a program of N ranks, in the array start
    start=()
    [ "$1" -eq 1 ] || start=(mpirun -np "$1")
}

until_traces() { # MAP: something of it is on disk, for two minutes at most
    local i
    for ((i = 0; i < 1200; i++)); do
        ! compgen -G "$1/shard-*/.piece-*.part" >/dev/null || return 0
        sleep 0.1
    done
}

# A small scene: a lamp shines on a glass plate before a screen that a detector lies on.
write_scene() {
    cat >"$1" <<'SCENE'
raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [486.13, 587.56, 656.27]}
media:
  air: {index: 1}
  glass: {glass: N-BK7}
surfaces:
  polished: {type: fresnel}
  black: {type: absorber}
  white: {type: lambert, reflectance: 0.5}
geometries:
  slab:
    type: lens
    surface: polished
    edge: black
    surfaces:
      - {radius: 50, thickness: 5, medium: glass, aperture: 10}
      - {radius: -50, medium: air, aperture: 10}
  wall: {type: rectangle, size: [40, 40]}
objects:
  - {name: lens, geometry: slab, outside: air}
  - {name: screen, geometry: wall, at: [0, 0, 40], surface: white, front: air, back: air}
sources:
  - {name: lamp, type: point, at: [0, 0, -30], direction: [0, 0, 1], distribution: {cone: 15}, flux: 1 W, spectrum: {lines: {486.13: 1, 587.56: 1, 656.27: 1}}, medium: air}
detectors:
  - {name: sensor, type: plane, on: screen, size: [40, 40], cells: [20, 20], at: [0, 0, 40], direction: [0, 0, -1]}
simulations:
  - {name: short, rays: 5000}
SCENE
}

finish() {
    [ "$failures" -eq 0 ] || { printf '%d failures\n' "$failures"; exit 1; }
    echo "all as expected"
    exit 0
}
