#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The room's committed meshes and scene are what its script writes."""
import os
import pathlib
import subprocess
import sys

room = pathlib.Path(os.environ["SOURCE_DIR"]) / "examples" / "room"
subprocess.run([sys.executable, "-B", room / "make_room.py", "room"], check=True)
names = sorted(p.relative_to("room") for p in pathlib.Path("room").rglob("*") if p.is_file())
wrong = [str(n) for n in names if (room / n).read_bytes() != (pathlib.Path("room") / n).read_bytes()]
print(f"{len(names)} files compared")
if len(names) < 21 or wrong:
    sys.exit("differ from what make_room.py writes: " + ", ".join(wrong))
