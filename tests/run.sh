#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Installs what is missing, builds, and runs the tests (all but those labelled `slow`). Options go
# to ctest: `tests/run.sh -L physics`, `tests/run.sh -R fresnel`. Its exit status is ctest's.
set -euo pipefail
cd "$(dirname "$0")/.."

jobs/install-packages.sh tests
jobs/build.sh -DBUILD_TESTING=ON
# Half of their time tests wait for processes to start and files to be synchronised.
exec ctest --preset release --parallel $(($(nproc) * 3 / 2 + 1)) "$@"
