#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A sweep that is killed in the midst of it, twice, goes on with --resume and ends with the table of an undisturbed one, and nobody else
writes to its folder while one of its ranks lives; RAYMAP_TEST_SCALE=10: one of 200 variants."""
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.environ["SOURCE_DIR"], "tests", "cli"))
from asking import SOURCE, check, finish, run  # noqa: E402

SCALE = int(os.environ.get("RAYMAP_TEST_SCALE", "1"))
for old in ("killed", "whole", "shared-1", "shared-2"):
    shutil.rmtree(old, ignore_errors=True)
pathlib.Path("s.yaml").write_text(f"""scene: {SOURCE / "examples/double-gauss/scene.yaml"}
simulation: star_only
rays: 3000
parameters:
  defocus: {{keys: [objects.sensor_surface.at.3, detectors.sensor.at.3], plus: true, range: {{from: -0.3, to: 0.3, count: {20 * SCALE}}}}}
answers:
  spot: {{detector: sensor, of: rms_radius}}
  light: {{flux: registered(sensor)}}
""", encoding="utf-8")
rows = pathlib.Path("killed/rows-00000.jsonl")
more = []
for _ in range(2):
    before = rows.stat().st_size if rows.exists() else 0
    begun = subprocess.Popen([os.environ["RAYMAP"], "sweep", "s.yaml", "-o", "killed", "--quiet", *more])
    while begun.poll() is None and not (rows.exists() and rows.stat().st_size > before + 1500 * SCALE):
        time.sleep(0.005)
    begun.kill()
    check(begun.wait() == -signal.SIGKILL, "killed in the midst of it")
    more = ["--resume"]
check(not pathlib.Path("killed/table.csv").exists(), "no table yet")
run("sweep", "s.yaml", "-o", "killed", "--resume", "--quiet")
run("sweep", "s.yaml", "-o", "whole", "--quiet")
tables = [pathlib.Path(folder, "table.csv").read_text(encoding="utf-8") for folder in ("killed", "whole")]
check(tables[0] == tables[1] and tables[0].count("\n") > 20 * SCALE + 1, "the same table")

# One that begins anew and is killed leaves no rows of which nobody knows whose they are.
env = {**os.environ, "LD_PRELOAD": os.environ["FAULTS"], "FAULTS_DIR": os.getcwd(), "FAULTS_CALLS": "unlink", "FAULTS_PATH": "*/whole/*", "FAULTS_AT": "2",
       "FAULTS_ACTION": "kill"}
for _ in range(4):
    done = subprocess.run([os.environ["RAYMAP"], "sweep", "s.yaml", "-o", "whole", "--force", "--quiet"], env=env, check=False, capture_output=True)
    check(done.returncode in (0, -signal.SIGKILL) and pathlib.Path("whole/sweep.txt").exists(), f"killed while it removes: {done}, {os.listdir('whole')}")

# Of two at a time the second is refused: also where rank 0 is dead, and rank 1 is not yet.
for ranks in (1, 2):
    folder = f"shared-{ranks}"
    last, lock = pathlib.Path(folder, f"rows-0000{ranks - 1}.jsonl"), pathlib.Path(folder, ".map.h5.writer.part")
    before = ["mpirun", "-np", "2"] if ranks == 2 else []
    for _ in range(20):  # where it has ended before it was seen, another
        begun = subprocess.Popen([*before, os.environ["RAYMAP"], "sweep", "s.yaml", "-o", folder, "--quiet", "--force"])
        while begun.poll() is None and not (last.exists() and last.stat().st_size > 0):
            time.sleep(0.005)
        if lock.exists():
            break
    owner = lock.read_text(encoding="utf-8").strip()
    pid = int(owner.split()[3])
    os.kill(begun.pid, signal.SIGSTOP)
    children = pathlib.Path(f"/proc/{begun.pid}/task/{begun.pid}/children").read_text(encoding="utf-8").split()
    pids = [int(child) for child in children] if ranks == 2 else [begun.pid]
    check(pid in pids and len(pids) == ranks, f"{pid} of {pids}")
    for one in pids:
        os.kill(one, signal.SIGSTOP)
    if ranks == 2:
        os.kill(pid, signal.SIGKILL)
    error = run("sweep", "s.yaml", "-o", folder, ("--force", "--resume")[ranks - 1], ranks=ranks, status=2)
    told = f"raymap ({owner})" if ranks == 1 else "ranks of another raymap"
    check(f"{folder} is being written to by " in error and told in error, error)
    for one in [begun.pid, *pids]:
        os.kill(one, signal.SIGKILL)
    run("sweep", "s.yaml", "-o", folder, "--resume", "--quiet", ranks=3 - ranks)
    check(pathlib.Path(folder, "table.csv").read_text(encoding="utf-8") == tables[1], f"{ranks} ranks, then {3 - ranks}: the same table")
    check(not lock.exists(), "the lock is gone")
finish()
