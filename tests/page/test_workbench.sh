#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: the workbench of `raymap open` works in a real browser: light comes in while one
# looks, criteria are written, clicked and drawn, edits change the scene, and nobody else gets in.
. "$(dirname "$0")/browser.bash"

rm -rf ./*.raymap ./*.yaml ./*.txt ./*.png
write_scene scene.yaml
sed -i '/name: sensor/a\  - {name: far, type: intensity, cells: [18, 36], axis: [0, 0, 1]}' scene.yaml
"$RAYMAP" open scene.yaml --no-browser >address.txt 2>server.txt </dev/null &
server=$!
trap 'kill $server 2>/dev/null' EXIT
for ((i = 0; i < 300; i++)); do
    grep -q 'http://' address.txt && break
    kill -0 $server 2>/dev/null || { cat server.txt; exit 1; }
    sleep 0.1
done
address=$(grep -o 'http://[^ "]*' address.txt | head -1)
drive workbench_test "$address" scene.yaml || failures=1
kill -0 $server 2>/dev/null || { echo "FAILED: the server ended: $(cat server.txt)"; failures=1; }
finish
