#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Code that a scene names runs only when the user allowed it, and what is said instead works."""
import os
import pathlib
import shutil
import shlex
import subprocess
import sys

PROGRAM, SOURCE = os.environ["RAYMAP"], pathlib.Path(os.environ["SOURCE_DIR"])
PLUGINS = pathlib.Path(os.environ["PLUGIN_DIR"])
RAN = pathlib.Path("constructor-ran")
REFUSED = "it is loaded only when you allow it: "
failures = 0


def run(*words, allowed=None, ranks=0, status=0, says=""):
    """Its standard error."""
    global failures
    environment = {key: value for key, value in os.environ.items() if key != "RAYMAP_ALLOW_PLUGINS"}
    if allowed is not None:
        environment["RAYMAP_ALLOW_PLUGINS"] = allowed
    launcher = ["mpirun", "-np", str(ranks)] if ranks else []
    done = subprocess.run([*launcher, PROGRAM, *words], stdout=subprocess.PIPE, check=False,
                          stderr=subprocess.PIPE, text=True, env=environment, timeout=60)
    if done.returncode != status or says not in done.stderr:
        failures += 1
        print(f"FAIL {words} {allowed}: {done.returncode}\n{done.stderr[:800]}")
    return done.stderr


def check(what, good):
    global failures
    failures += not good
    if not good:
        print("FAIL", what)


def main():
    for left in pathlib.Path(".").glob("*.raymap"):
        shutil.rmtree(left)
    RAN.unlink(missing_ok=True)
    text = (SOURCE / "examples/plugin/scene.yaml").read_text()
    shutil.copy(PLUGINS / "rod.so", "rod.so")
    shutil.copy(PLUGINS / "constructor.so", "evil.so")
    pathlib.Path("rod.yaml").write_text(text)
    pathlib.Path("evil.yaml").write_text(text.replace("rod.so,", "evil.so,") +
                                         "cameras: [{name: eye, type: pinhole, at: [0, 0, -60], "
                                         "direction: [0, 0, 1], fov: 20, resolution: [8, 8]}]\n")

    run("trace", "rod.yaml", "-o", "rod.raymap", "-n", "500", "--quiet", "--allow-plugins")
    (pathlib.Path("rod.raymap") / "map.h5").rename("lost.h5")
    for words in (("check", "evil.yaml"), ("trace", "evil.yaml", "-o", "evil.raymap", "-n", "9"),
                  ("report", "evil.yaml", "--ray", "1"), ("render", "evil.yaml", "-o", "evil.png"),
                  ("repair", "rod.raymap", "--scene", "evil.yaml")):
        run(*words, status=3, says=REFUSED)
        check(f"{words[0]} ran the code", not RAN.exists())
    run("trace", "evil.yaml", "-o", "evil.raymap", "-n", "9", ranks=2, status=3, says=REFUSED)
    check("a rank ran the code", not RAN.exists())

    # What is printed works, in a folder with a blank in its name.
    os.makedirs("a folder", exist_ok=True)
    for name in ("rod.so", "rod.yaml"):
        shutil.copy(name, "a folder")
    said = run("check", "a folder/rod.yaml", status=3, says=REFUSED)
    line = shlex.split(said.split(REFUSED)[1].split(", or with")[0])
    check(f"{line} is no command of ours", line[0] == "raymap" and line[-1] == "--allow-plugins")
    run(*line[1:])

    # By the environment: the file, a folder above it, one of several; not a name that begins alike.
    shutil.copy("rod.so", "rod.so.d") if not os.path.exists("rod.so.d") else None
    here = os.getcwd()
    for allowed in ("rod.so", f"{here}/rod.so", here, f"/nowhere:{here}", os.path.dirname(here)):
        run("check", "rod.yaml", allowed=allowed)
    for refused in ("", ":", "/nowhere", "ro", "a folder", "rod.so.d"):
        run("check", "rod.yaml", allowed=refused, status=3, says=REFUSED)
    run("trace", "rod.yaml", "-o", "two.raymap", "-n", "500", "--quiet", ranks=2, allowed=here)

    # Nothing that is not a file is waited for.
    for kind in ("fifo", "device"):
        pathlib.Path("odd.so").unlink(missing_ok=True)
        os.mkfifo("odd.so") if kind == "fifo" else os.symlink("/dev/zero", "odd.so")
        pathlib.Path("odd.yaml").write_text(text.replace("rod.so,", "odd.so,"))
        run("check", "odd.yaml", "--allow-plugins", status=3, says="it is no regular file")
        pathlib.Path("odd.yaml").write_text(text.replace("type: plugin, file: rod.so, parameters: "
                                                         "[1.6, 0.3, 20]", "type: grid, file: odd.h5"))
        pathlib.Path("odd.h5").unlink(missing_ok=True)
        os.rename("odd.so", "odd.h5")
        run("check", "odd.yaml", status=3, says="it is no regular file")
    sys.exit(failures != 0)


main()
