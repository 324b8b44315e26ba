#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Configures and builds the release preset into build/release; options go to cmake. Talks only
# when something fails.
set -euo pipefail
cd "$(dirname "$0")/.."

log=build/release/build.log
generator=()
# A tree that was configured before keeps its generator; cmake refuses to change it.
[ -e build/release/CMakeCache.txt ] || generator=(-G Ninja)
mkdir -p build/release
if ! { cmake --preset release "${generator[@]}" "$@" &&
    cmake --build --preset release --parallel "$(nproc)"; } >"$log" 2>&1; then
    cat "$log" >&2
    echo "The build failed; the full log is in $log" >&2
    exit 1
fi
