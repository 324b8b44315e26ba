#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: every line of docs/tutorials.md runs as it stands there, and the numbers that it tells are those that come; in a quick run
# with a tenth of the rays.
. "$(dirname "$0")/expect.bash"
rm -rf ./*
. "$(dirname "$0")/queue.bash"
sed -n 's/^    //p' "$SOURCE_DIR/docs/tutorials.md" >tutorials.sh
[ "${RAYMAP_TEST_SCALE:-1}" -gt 1 ] || sed -i 's/-n \([0-9]*\)0k/-n \1k/; s/200k/20k/' tutorials.sh
expect 0 '' bash -e tutorials.sh
[ ! -e failed.log ] || { echo "FAILED: $(cat failed.log job.log)"; failures=$((failures + 1)); }
for file in desks.png desks.csv one.png ghosts-0.png ghosts-1.png ghosts.csv ghosts.svg coat.svg arrival.png scratch/ghosts.json; do
    [ -s "$file" ] || { echo "FAILED: no $file"; failures=$((failures + 1)); }
done
expect 0 'EFL 100\.04[0-9]*, BFL 95\.97' "$RAYMAP" check doublet.yaml
expect 0 '^near +[0-9]{3,5} +0\.10' "$RAYMAP" detector bar.raymap end --which 'at(transmit)' --by source
finish
