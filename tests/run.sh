#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Installs what is missing, builds, and runs the tests (all but those labelled `slow`). Options go
# to ctest: `tests/run.sh -L physics`, `tests/run.sh -R fresnel`. Its exit status is ctest's.
set -euo pipefail
cd "$(dirname "$0")/.."

jobs/install-packages.sh tests
# A newer compiler's warnings stop who works on the program, and nobody who uses it.
jobs/build.sh -DBUILD_TESTING=ON -DRAYMAP_WERROR="$([ -n "${CI:-}" ] && echo ON || echo OFF)"
# Half of their time tests wait for processes to start and files to be synchronised.
exec ctest --preset release --parallel $(($(nproc) * 3 / 2 + 1)) "$@"
