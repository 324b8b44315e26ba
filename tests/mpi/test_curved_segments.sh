#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Curved legs among meshes, analytic bodies, detectors and scattering: the same rays for any number
# of ranks and threads, in either encoding, and every ray accounted for.
. "$(dirname "$0")/../cli/expect.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
rm -rf ./*
cat >cube.obj <<'END'
v -1 -1 -1
v 1 -1 -1
v -1 1 -1
v 1 1 -1
v -1 -1 1
v 1 -1 1
v -1 1 1
v 1 1 1
f 1 3 4 2
f 5 6 8 7
f 1 2 6 5
f 3 7 8 4
f 1 5 7 3
f 2 4 8 6
END
cat >scene.yaml <<'END'
raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [450, 550, 650]}
limits: {steps: 200}
media:
  air: {index: 1}
  cloud: {gradient: {type: noise, mean: 1.4, amplitude: 0.05, length: 0.7, octaves: 2, seed: 3, frame: block}, scattering: 0.1,
    scattering_g: 0.8, absorption: {wavelength: [450, 650], value: [0.02, 0.1]}}
  lens: {gradient: {type: luneburg, radius: 2, dispersion: {glass: N-BK7, reference: 550}}}
surfaces:
  clear: {type: fresnel}
geometries:
  cube: {type: mesh, file: cube.obj, scale: 1}
  ball: {type: sphere, radius: 0.5}
objects:
  - {name: block, geometry: cube, rotate: [20, 30, 0], surface: clear, inside: cloud, outside: air}
  - {name: bead, geometry: ball, at: [0.1, 0.2, 0.1], surface: clear, inside: lens, outside: cloud}
  - {name: grain, geometry: ball, at: [-0.6, 0, 0], scale: 0.2, surface: absorber}
sources:
  - {name: lamp, type: point, at: [0, 0, -3], distribution: {cone: 20}}
  - {name: within, type: point, at: [0.3, 0.4, -0.5], medium: cloud, within: block}
detectors:
  - {name: inside, type: plane, at: [0, 0, 0.2], size: [4, 4], cells: [8, 8], direction: [0, 0.2, -1]}
END
rays=6001

trace() { # RANKS THREADS MAP [OPTIONS]
    by_ranks "$1"
    expect 0 '' "${start[@]}" "$RAYMAP" trace scene.yaml -o "$3" -n $rays --threads "$2" --json --quiet "${@:4}"
}
digest() {
    "$RAYMAP" info "$1" --json | sed -n 's/.*"digest": "\([0-9a-f]\{32\}\)".*/\1/p'
}

trace 1 1 alone.raymap --encoding plain
want=$(digest alone.raymap)
[ ${#want} -eq 32 ] || { echo "FAILED: no digest"; failures=1; }
/usr/bin/python3 - stdout.txt <<'END' || { echo "FAILED: energy balance"; failures=1; }
import json, sys
for source in json.load(open(sys.argv[1]))["sources"]:
    absorbed = [sum(v.values()) for v in source["absorbed"].values()]
    assert source["error"] == 0, source
    assert all(n > 0 for n in absorbed), source
    assert source["emitted"] == sum(absorbed) + source["left"] + source["limit"], source
END
for ranks in 3 ${SLOW:+1}; do
    trace $ranks 2 "other$ranks.raymap"
    got=$(digest "other$ranks.raymap")
    [ "$got" = "$want" ] || { echo "FAILED: $ranks ranks: digest $got, not $want"; failures=1; }
done
trace 1 2 compact.raymap --encoding compact
got=$(digest compact.raymap)
[ "$got" = "$want" ] || { echo "FAILED: compact: digest $got, not $want"; failures=1; }
expect 0 '' "$RAYMAP" verify compact.raymap
rm -rf ./*.raymap
finish
