# SPDX-License-Identifier: MIT
"""What tests of answers begin with: the Python package, checks that are counted, and the program under any number of ranks."""
import os
import pathlib
import shutil
import subprocess
import sys

SOURCE = pathlib.Path(os.environ["SOURCE_DIR"])
sys.path.insert(0, str(SOURCE / "examples" / "python"))
SLOW = int(os.environ.get("RAYMAP_TEST_SCALE", "1")) > 1  # the whole of a matrix, not the diagonal
failures = 0


def check(good, what):
    global failures
    if not good:
        failures += 1
        print("FAIL " + what, flush=True)


def run(*words, ranks=1, status=0):
    """What it says: on stdout, or of a failure that is expected on stderr."""
    before = ["mpirun", "-np", str(ranks)] if ranks > 1 else []
    done = subprocess.run([*before, os.environ["RAYMAP"], *map(str, words)], text=True, capture_output=True, check=False)
    check(done.returncode == status, f"{words}: {done.returncode}\n{done.stderr}")
    return done.stderr if status else done.stdout


def trace(example, name, n, *more):
    shutil.rmtree(name, ignore_errors=True)
    run("trace", SOURCE / "examples" / example / "scene.yaml", "-o", name, "-n", n, "--quiet", *more)
    return name


def keys_of(words):
    """What a server (raymap.serve) takes for these options of a command line."""
    words, keys = list(map(str, words)), {}
    while words:
        name = words.pop(0).lstrip("-")
        value = words.pop(0) if words and not words[0].startswith(("--", "-w")) else True
        keys.setdefault("where" if name == "w" else name, []).append(value)
    return {name: values if len(values) > 1 else values[0] for name, values in keys.items()}


def told_of(server, text, **keys):
    """What `check --json` says of a scene, asked of a server of any scene in its folder: (document, all that it complains of)."""
    its = server.check(text=text, **keys)
    return its, "\n".join(one["text"] for one in its["diagnostics"])


def finish():
    sys.exit(1 if failures else 0)
