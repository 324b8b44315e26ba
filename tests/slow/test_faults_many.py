# SPDX-License-Identifier: MIT
"""The tests of faults with all their kill points, lost powers and failing calls, and a sweep of 200 variants."""
import os
import subprocess
import sys

HERE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "faults")
status = 0
for name in ("kill_matrix", "power_loss", "each_call", "sweep_killed", "disk_full"):
    environment = dict(os.environ, RAYMAP_TEST_SCALE="10")
    script = os.path.join(HERE, f"test_{name}.py")
    status |= subprocess.run([sys.executable, script], env=environment, check=False).returncode != 0
sys.exit(status)
