#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: the page of `report --html` opens in a browser from a file, without a word on its
console, and shows its pictures."""
import os
import re
import shutil
import subprocess
import sys
import tempfile

PROGRAM = os.environ["RAYMAP"]
SCENE = os.path.join(os.environ["SOURCE_DIR"], "examples", "double-gauss", "scene.yaml")

browser = shutil.which("chromium")
if not browser:
    print("skipped: there is no chromium here")
    sys.exit(77)


def run(*arguments):
    subprocess.run([PROGRAM, *arguments, "--quiet"], check=True, timeout=300)


shutil.rmtree("lens.raymap", ignore_errors=True)
run("trace", SCENE, "-o", "lens.raymap", "-n", "5000")
run("report", "lens.raymap", "--html", "lens.html", "--force")
with tempfile.TemporaryDirectory() as profile:
    command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
               f"--user-data-dir={profile}", "--enable-logging=stderr", "--dump-dom",
               "--window-size=1200,2000", "file://" + os.path.abspath("lens.html")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
assert done.returncode == 0, done.stderr[-2000:]
assert not re.search("CONSOLE", done.stderr), done.stderr[-2000:]
with open("lens.html", encoding="utf-8") as file:
    page = file.read()
for tag in ("svg", "table", "tr", "image", "section", "figure"):
    wanted = len(re.findall(f"<{tag}\\b", page))
    assert len(re.findall(f"<{tag}\\b", done.stdout)) == wanted > 0, tag
print("the page opens")
