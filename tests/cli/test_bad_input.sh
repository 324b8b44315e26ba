#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: whatever stands in a scene file, the program says so and exits with 3; it neither
# crashes nor begins a map.
. "$(dirname "$0")/expect.bash"
rm -rf ./*
write_scene scene.yaml

refuse() { # NAME PATTERN: the scene NAME is wrong, and the message says PATTERN
    expect 3 "$2" "$RAYMAP" check "$1"
    expect 3 "$2" "$RAYMAP" trace "$1" -o x.raymap -n 100
    [ ! -e x.raymap ] || { echo "FAILED: a map was begun for $1"; failures=1; rm -rf x.raymap; }
}
change() { # NAME SED-SCRIPT
    sed "$2" scene.yaml >"$1"
    ! cmp -s scene.yaml "$1" || { echo "FAILED: nothing changed in $1"; failures=1; }
}

: >empty.yaml;                                     refuse empty.yaml 'empty'
mkdir folder.yaml;                                 refuse folder.yaml 'directory'
head -c 4000 /dev/urandom >binary.yaml;            refuse binary.yaml ''
head -c 700 scene.yaml >cut.yaml;                  refuse cut.yaml ''
echo '{' >brace.yaml;                              refuse brace.yaml 'brace.yaml'
echo '[1, 2]' >list.yaml;                          refuse list.yaml ''
echo 'raymap: 99' >version.yaml;                   refuse version.yaml ''
/usr/bin/python3 -c 'print("a: " + "[" * 20000)' >deep.yaml; refuse deep.yaml ''
/usr/bin/python3 -c 'print("a: " + "{b: " * 3000 + "1" + "}" * 3000)' >nested.yaml; refuse nested.yaml ''
printf 'raymap: 1\na: &a [x, x]\nb: &b [*a, *a]\nc: &c [*b, *b]\n' >alias.yaml; refuse alias.yaml ''
head -c 70000000 /dev/zero | tr '\0' '#' >huge.yaml; refuse huge.yaml ''
rm -f huge.yaml

change nan.yaml 's/size: \[40, 40\]}$/size: [.nan, 40]}/';       refuse nan.yaml 'nan.yaml:[0-9]+'
change inf.yaml 's/radius: 50/radius: 1e999/';                   expect 3 '' "$RAYMAP" check inf.yaml || true
change negative.yaml 's/aperture: 10/aperture: -10/';            refuse negative.yaml 'negative.yaml:[0-9]+'
change zero.yaml 's/thickness: 5/thickness: nothing/';           refuse zero.yaml 'zero.yaml:[0-9]+'
change key.yaml 's/reflectance: 0.5/reflectence: 0.5/';          refuse key.yaml "did you mean 'reflectance'"
change range.yaml 's/reflectance: 0.5/reflectance: 1.5/';        refuse range.yaml 'range.yaml:[0-9]+'
change unit.yaml 's/flux: 1 W/flux: 1 kg/';                      refuse unit.yaml 'unit.yaml:[0-9]+'
change name.yaml 's/name: screen/name: lens/';                   refuse name.yaml "lens"
change cells.yaml 's/cells: \[20, 20\]/cells: [0, 20]/';         refuse cells.yaml 'cells.yaml:[0-9]+'
change dark.yaml '/name: lamp/d';                                refuse dark.yaml 'source'
change glass.yaml 's/N-BK7/N-BK77/';                             refuse glass.yaml 'N-BK7'
change direction.yaml 's/direction: \[0, 0, 1\]/direction: [0, 0, 0]/'; refuse direction.yaml ''

# meshes
change mesh.yaml 's/wall: .*/wall: {type: mesh, file: wall.stl}/'
sed -i 's/front: air, back: air/inside: air, outside: air/' mesh.yaml
refuse mesh.yaml 'wall.stl'
echo 'this is no mesh' >wall.stl;                  refuse mesh.yaml 'wall.stl'
printf 'solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nendloop\nendfacet\nendsolid a\n' >wall.stl
refuse mesh.yaml 'wall.stl'

# media that do not match across touching surfaces
change media.yaml 's/name: screen\(.*\)front: air, back: air/name: screen\1front: glass, back: glass/'
expect 3 "leaves 'lens.2' in 'air' but meets 'screen'" "$RAYMAP" check media.yaml

# ... and the first mistake does not hide the ones behind it
sed -i -e 's/surface: white, front: glass/surface: polished, front: air/' \
    -e '/name: screen/a\  - {name: behind, geometry: wall, at: [0, 0, 50], surface: black, front: glass, back: glass}' media.yaml
expect 3 "media.yaml:22:5: .* leaves 'lens.2' in 'air' but meets 'screen'" "$RAYMAP" check media.yaml
expect 3 "media.yaml:23:5: .* leaves 'screen' in 'air' but meets 'behind'" "$RAYMAP" check media.yaml
finish
