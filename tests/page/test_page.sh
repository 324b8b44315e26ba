#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: the page of `raymap draw -o x.html` works in a real browser: it shows the scene and
# the rays asked for, classes, reports and regions agree with the program, light moves.
. "$(dirname "$0")/browser.bash"

rm -rf ./*.raymap ./*.html ./*.yaml ./*.txt
write_scene scene.yaml
sed -i '/name: sensor/a\  - {name: far, type: intensity, cells: [18, 36], axis: [0, 0, 1]}' scene.yaml
expect 0 '' "$RAYMAP" trace scene.yaml -o a.raymap -n 5000 --quiet
expect 0 '400 of [0-9]+ matching' "$RAYMAP" draw a.raymap --limit 400 -o a.html
expect 0 'matching rays drawn' "$RAYMAP" draw a.raymap --limit 400 --where 'hit(lens.2, reflect)' --where 'segments > 4 or ray < 60' --by object -o two.html
expect 0 '5000 of 5000 matching' "$RAYMAP" draw a.raymap --limit 5000 --color order -o many.html
expect 0 '' "$RAYMAP" trace scene.yaml -o late.raymap -n 300 --first-ray 18446744073709548000 --quiet
expect 0 '300 ' "$RAYMAP" draw late.raymap -o late.html
expect 0 '0 of 0' "$RAYMAP" draw a.raymap --where 'segments > 1000' -o none.html
sed 's|name: sensor|name: "</script><b>ü \\\\u003c-->"|' scene.yaml >odd.yaml
expect 0 '' "$RAYMAP" trace odd.yaml -o "<b>\"odd'.raymap" -n 1000 --quiet
expect 0 '' "$RAYMAP" draw "<b>\"odd'.raymap" -o odd.html
expect 0 '' "$RAYMAP" trace "$SOURCE_DIR/examples/selfoc/scene.yaml" -o rod.raymap -n 400 --quiet
expect 0 '' "$RAYMAP" draw rod.raymap -o rod.html
{
    sed '/^objects:/q; s|^geometries:|&\n  ball: {type: sphere, radius: 1}|' scene.yaml
    for ((k = 0; k < 625; k++)); do
        echo "  - {name: b$k, geometry: ball, at: [$((k % 25 * 3)), $((k / 25 * 3)), 0], surface: white, outside: air, inside: glass}"
    done
    sed -n '/^sources:/,/^detectors:/p' scene.yaml | sed '$d'
} >crowd.yaml
expect 0 '' "$RAYMAP" trace crowd.yaml -o crowd.raymap -n 10 --quiet
expect 0 '' "$RAYMAP" draw crowd.raymap -o crowd.html
[ "$failures" -eq 0 ] || finish

drive page_test
