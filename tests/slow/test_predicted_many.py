#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""tests/format/test_predicted.py with 600 other scenes."""
import os
import pathlib
import subprocess
import sys

script = pathlib.Path(os.environ["SOURCE_DIR"]) / "tests" / "format" / "test_predicted.py"
sys.exit(subprocess.run([sys.executable, "-B", script], check=False,
                        env=dict(os.environ, RAYMAP_FORETOLD="600",
                                 RAYMAP_FORETOLD_SEED="1000")).returncode)
