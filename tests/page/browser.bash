# SPDX-License-Identifier: MIT
#
# For the scripts beside it: `drive SCRIPT WORDS...` runs SCRIPT.js, which drives Debian's chromium.
. "$(dirname "${BASH_SOURCE[0]}")/../cli/expect.bash"
tests=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
chromium=${CHROMIUM:-/usr/bin/chromium}
for program in node npm "$chromium"; do
    command -v "$program" >/dev/null || { echo "skipped: no $program here"; exit 77; }
done
mkdir -p driver
cp "$tests/package.json" "$tests/package-lock.json" driver/
if ! cmp -s driver/package-lock.json driver/installed; then
    (cd driver && npm ci --ignore-scripts --no-audit --no-fund >npm.txt 2>&1) ||
        { echo "skipped: npm cannot fetch playwright-core: $(head -3 driver/npm.txt)"; exit 77; }
    cp driver/package-lock.json driver/installed
fi

drive() {
    NODE_PATH=$PWD/driver/node_modules timeout 400 node "$tests/$1.js" "$PWD" "${@:2}"
}
