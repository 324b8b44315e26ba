#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# From a bare Debian machine to the ghosts of a camera lens: installs what is missing, builds,
# traces examples/double-gauss on two MPI ranks into a ray map, asks it for its ghosts and draws
# them. Everything it makes is in out/.
set -euo pipefail
cd "$(dirname "$0")/.."

rays=1000000
scene=examples/double-gauss/scene.yaml
map=out/double-gauss.raymap
# A ghost: light that reached the sensor after at least two mirror-like reflections.
ghost='registered(sensor) and hit(*, reflect_specular) >= 2'
# Stray light: any light of the sun, which stands outside the field, that reached the sensor.
stray='registered(sensor) and source(sun)'

say() { printf '\n== %s\n' "$*"; }
show() {
    printf '$'
    printf " %q" "$@"
    printf '\n'
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
show mpirun -np 2 raymap query "$map" "$ghost" "$stray" --count

say "One ghost ray, leg by leg"
first=$(raymap query "$map" "$ghost and source(star)" --limit 1 -o out/ghost.csv >/dev/null &&
    sed -n '2s/,.*//p' out/ghost.csv)
[ -z "$first" ] || show raymap report "$map" "$first"

say "Pictures"
show raymap draw "$map" --where "$ghost and source(star)" --limit 60 -o out/ghosts.png
show raymap draw "$map" --where "source(star)" --limit 60 -o out/lens.png
show raymap detector "$map" sensor -o out/sensor.png
show raymap detector "$map" sensor --where "$ghost" -o out/sensor-ghosts.png

say "Done. The pictures:"
printf '  %s\n' "the star's rays      $PWD/out/lens.png" \
    "its ghosts           $PWD/out/ghosts.png" \
    "the sensor           $PWD/out/sensor.png" \
    "ghosts on the sensor $PWD/out/sensor-ghosts.png"
