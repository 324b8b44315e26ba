#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# From a bare Debian machine to the ghosts of a camera lens: installs what is missing, builds,
# traces examples/double-gauss on two MPI ranks into a ray map, asks it for its ghosts and draws
# them. Everything it makes is in out/.
set -euo pipefail
cd "$(dirname "$0")/.."

rays=2000000
scene=examples/double-gauss/scene.yaml
map=out/double-gauss.raymap
# A ghost: light of the star that arrives on the sensor mirrored by what is not meant to mirror.
ghost='source(star) and registered(sensor where ghost_order >= 1)'
# Those that the lens alone makes: two reflections between its surfaces.
lens_ghost='source(star) and registered(sensor where hit(lens, reflect_specular) == 2 and hit(*, reflect) == 2)'
# Stray light: any light of the sun, which stands outside the field, that reaches the sensor.
stray='source(sun) and registered(sensor)'

say() { printf '\n== %s\n' "$*"; }
show() {
    local word line='$'
    for word in "$@"; do
        case $word in *[!A-Za-z0-9_./=:-]*) word="'$word'" ;; esac
        line+=" $word"
    done
    printf '%s\n' "$line"
    "$@"
}

jobs/install-packages.sh build
say "Building"
jobs/build.sh -DBUILD_TESTING=OFF
. jobs/mpi-environment.sh
PATH="$PWD/build/release:$PATH"
mkdir -p out

say "Tracing $rays rays through a double Gauss lens on 2 MPI ranks"
show mpirun -np 2 raymap trace "$scene" -o "$map" -n "$rays" --force

say "What the map holds"
show raymap info "$map"

say "Ghosts and stray light on the sensor"
show mpirun -np 2 raymap query "$map" "$ghost" "$lens_ghost" "$stray" --count

say "Which pairs of surfaces make the star's ghosts"
show raymap ghosts "$map" sensor --where "source(star)"

say "One of the lens's ghost rays, segment by segment"
raymap query "$map" "$lens_ghost" --limit 1 -o out/ghost.csv --force --quiet
show raymap report "$map" "$(sed -n '2s/,.*//p' out/ghost.csv)"

say "Pictures"
show raymap draw "$map" --where "source(star)" --limit 40 -o out/lens.png --force
show raymap draw "$map" --where "$lens_ghost" --limit 40 -o out/ghosts.png --force
show raymap detector "$map" sensor --log -o out/sensor.png --force
show raymap detector "$map" sensor --where "$ghost" --log -o out/sensor-ghosts.png --force

say "Done. The pictures:"
printf '  %-28s %s\n' "the star's rays" "$PWD/out/lens.png" \
    "the lens's ghosts" "$PWD/out/ghosts.png" \
    "the sensor" "$PWD/out/sensor.png" \
    "the ghosts on the sensor" "$PWD/out/sensor-ghosts.png"
