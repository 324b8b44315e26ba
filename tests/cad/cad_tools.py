# SPDX-License-Identifier: MIT
"""What tests of CAD files begin with: the converter and the maker of files, without which there is nothing to test, and checks that are counted."""
import os
import pathlib
import sys

BUILD = pathlib.Path(os.environ["BUILD_DIR"])
SLOW = int(os.environ.get("RAYMAP_TEST_SCALE", "1")) > 1
STEP, MAKER = BUILD / "raymap-step", BUILD / "tests" / "make_cad_files"
if not STEP.exists():
    print("SKIP: raymap-step is not built here: jobs/install-packages.sh cad installs OpenCASCADE")
    sys.exit(77)
sys.path.insert(0, os.path.join(os.environ["SOURCE_DIR"], "tests", "cli"))
from asking import check, finish  # noqa: E402, F401
