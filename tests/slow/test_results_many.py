# SPDX-License-Identifier: MIT
"""The test of results under faults with all its commands and some thousand failing calls."""
import os
import subprocess
import sys

HERE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "faults")
environment = dict(os.environ, RAYMAP_TEST_SCALE="10")
sys.exit(subprocess.run([sys.executable, os.path.join(HERE, "test_results.py")], env=environment,
                        check=False).returncode)
