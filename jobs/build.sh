#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Configures and builds the release preset into build/release; options go to cmake. Talks only
# when something fails.
set -euo pipefail
cd "$(dirname "$0")/.."

log=build/release/build.log
# A build tree keeps the generator it was configured with, and cmake refuses one that was copied
# here with the sources from elsewhere: that one is begun anew.
how=(--fresh -G Ninja)
if grep -qxE "CMAKE_HOME_DIRECTORY:INTERNAL=($PWD|$(pwd -P))" build/release/CMakeCache.txt 2>/dev/null; then
    how=()
fi
mkdir -p build/release
if ! { cmake --preset release "${how[@]}" "$@" &&
    cmake --build --preset release --parallel "$(nproc)"; } >"$log" 2>&1; then
    cat "$log" >&2
    echo "The build failed; the full log is in $log" >&2
    exit 1
fi
