#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""tests/cli/test_trace_from.py with 100 edits of each of its five kinds in each scene (RAYMAP_FROM_EDITS: of all kinds)."""
import os
import pathlib
import subprocess
import sys

script = pathlib.Path(os.environ["SOURCE_DIR"]) / "tests" / "cli" / "test_trace_from.py"
sys.exit(subprocess.run([sys.executable, "-B", script], check=False,
                        env={"RAYMAP_FROM_EDITS": "500", "RAYMAP_TEST_SEED": "11", **os.environ}).returncode)
