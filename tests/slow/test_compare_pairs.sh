#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise of tests/cli/test_compare.py with 40 pairs of seeds.
RAYMAP_COMPARE_PAIRS=40 exec /usr/bin/python3 "$SOURCE_DIR/tests/cli/test_compare.py"
