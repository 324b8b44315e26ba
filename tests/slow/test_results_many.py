# SPDX-License-Identifier: MIT
"""The tests of results under faults and of flipped bits with all their commands."""
import os
import subprocess
import sys

HERE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "faults")
status = 0
for name in ("flipped_bits", "results"):
    environment = dict(os.environ, RAYMAP_TEST_SCALE="10")
    script = os.path.join(HERE, f"test_{name}.py")
    status |= subprocess.run([sys.executable, script], env=environment, check=False).returncode != 0
sys.exit(status)
