#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Any number of ranks and threads renders the same picture, byte by byte.
. "$(dirname "$0")/../cli/expect.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
rm -rf ./*
scene=$SOURCE_DIR/examples/gradient-sphere/scene.yaml
render() { # name ranks threads
    expect 0 '' mpirun -np "$2" "$RAYMAP" render "$scene" --size 150x100 -n 3 --threads "$3" \
        -o "$1.png" -o "$1.exr"
}
render one 1 1
for ranks in 1 2 3 4; do
    render "n$ranks" "$ranks" 2
    for suffix in png exr; do
        cmp "one.$suffix" "n$ranks.$suffix" ||
            { echo "FAILED: $ranks ranks render another $suffix"; failures=1; }
    done
done
expect 0 '' "$RAYMAP" render "$scene" --size 150x100 -n 3 --seed 2 -o other.exr
cmp -s one.exr other.exr && { echo 'FAILED: another seed renders the same'; failures=1; }
expect 3 'no camera named' mpirun -np 3 "$RAYMAP" render "$scene" --camera nobody -o b.png
expect 3 'cannot write' mpirun -np 3 "$RAYMAP" render "$scene" --size 15x10 -n 1 -o nowhere/b.png
finish
