#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: a page holds the columns of its rays bit for bit, the program's own counts, and
# nothing that asks a network; nothing in a scene's names breaks out of it. (What it does in a
# browser: tests/page.)
. "$(dirname "$0")/expect.bash"
rm -rf ./*
write_scene scene.yaml
sed -i 's|name: sensor|name: "</script><b>ü \\\\u003c-->"|' scene.yaml
expect 0 '' "$RAYMAP" trace scene.yaml -o a.raymap -n 5000 --encoding plain --quiet
expect 0 '2000 of 5000 matching' "$RAYMAP" draw a.raymap -o all.html
expect 0 '60 of [0-9]+ matching' "$RAYMAP" draw a.raymap --where 'hit(lens.2, reflect_specular)' --where 'segments in 4..5' --by object --limit 60 -o some.html
expect 0 '0 of 0 matching' "$RAYMAP" draw a.raymap --where 'segments > 1000' -o none.html
expect 0 '"drawn": 10' "$RAYMAP" draw a.raymap --limit 10 --view yz -o ten.html --json
expect 2 'exists' "$RAYMAP" draw a.raymap -o ten.html
expect 0 '' "$RAYMAP" draw a.raymap --limit 10 --view yz -o ten.json
expect 0 '' "$RAYMAP" draw a.raymap -o part.json --parts detectors
expect 2 'some of scene, rays and detectors' "$RAYMAP" draw a.raymap -o other.json --parts scene,ray
expect 2 'data of a page' "$RAYMAP" draw a.raymap -o other.html --parts scene
/usr/bin/python3 - <<'PYTHON' || { echo "FAILED: data of a page"; failures=$((failures + 1)); }
import json, re
page = json.loads(re.search(r'id="data">(.*?)</script>', open("ten.html").read(), re.S).group(1))
assert json.load(open("ten.json")) == page
part = json.load(open("part.json"))
assert part["detectors"] == page["detectors"] and "rays" not in part and "scene" not in part, list(part)
PYTHON
expect 2 'between 1 and 200000' "$RAYMAP" draw a.raymap --limit 200001 -o b.html
expect 3 "there is no folder 'no/folder'" "$RAYMAP" draw a.raymap -o no/folder/b.html
"$RAYMAP" query a.raymap 'hit(lens.2, reflect_specular) or segments in 4..5' --count --json --quiet >count.json
"$RAYMAP" detector a.raymap "$(printf '</script><b>\303\274 \\u003c-->')" --json --quiet >detector.json
"$RAYMAP" paths a.raymap --top 500 --json --quiet >paths.json
"$RAYMAP" paths a.raymap --where '(hit(lens.2, reflect_specular)) or (segments in 4..5)' --by object --top 500 --json --quiet >paths_some.json
many=()
for i in {1..32}; do many+=(--where "segments > $i"); done
expect 2 '31 criteria at most' "$RAYMAP" draw a.raymap "${many[@]}" -o b.html
expect 2 'surface, object or group' "$RAYMAP" draw a.raymap --by lens -o b.html
/usr/bin/python3 "$(dirname "$0")/evaluator_page.py" a.raymap all.html some.html none.html ten.html || failures=$((failures + 1))
finish
