#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""tests/cli/test_evaluator.py with 510 random criteria."""
import os
import pathlib
import subprocess
import sys

script = pathlib.Path(os.environ["SOURCE_DIR"]) / "tests" / "cli" / "test_evaluator.py"
sys.exit(subprocess.run([sys.executable, "-B", script], check=False,
                        env=dict(os.environ, RAYMAP_JUDGE="510", RAYMAP_JUDGE_SEED="2")).returncode)
