#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""tests/cli/test_trace_from.py with 100 edits of each scene."""
import os
import pathlib
import subprocess
import sys

script = pathlib.Path(os.environ["SOURCE_DIR"]) / "tests" / "cli" / "test_trace_from.py"
sys.exit(subprocess.run([sys.executable, "-B", script], check=False,
                        env=dict(os.environ, RAYMAP_FROM_EDITS="100", RAYMAP_TEST_SEED="11")).returncode)
