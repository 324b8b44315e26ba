# SPDX-License-Identifier: MIT
"""The promise: whenever the disk fills up, all ranks end with status 5 and one message that says so;
what was committed can be read; and with room again `--resume` makes the map of an undisturbed run.
Each of six fill levels is a small tmpfs of its own, mounted as root or in a user's own namespace;
every other one is filled by the compact encoding.
"""
import os
import subprocess
import sys

import harness
import power_loss

RAYS = 20000
OPTIONS = ["--threads", "1", "--flush-portions", "1"]
LEVELS = 60 if harness.SLOW else 6


def enter_namespace():
    """Runs this script again where it may mount, or skips it with the reason."""
    if "RAYMAP_TEST_MOUNTS" in os.environ:
        return
    command = ["unshare", "--mount"] + ([] if os.getuid() == 0 else ["--map-root-user"])
    probe = subprocess.run([*command, "mount", "-t", "tmpfs", "none", "/mnt"], text=True,
                           stderr=subprocess.PIPE, check=False)
    if probe.returncode != 0:
        print(f"no small file system can be mounted here: {probe.stderr.strip()}")
        sys.exit(77)
    environment = dict(os.environ, RAYMAP_TEST_MOUNTS="1", OMPI_ALLOW_RUN_AS_ROOT="1",
                       OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    os.execvpe(command[0], [*command, sys.executable, os.path.abspath(__file__)], environment)


def mount(folder, nbytes, *more):
    subprocess.run(["mount", "-t", "tmpfs", "-o", ",".join([*more, f"size={nbytes}"]), "none",
                    folder], check=True)


def room_needed(undisturbed, encoding):
    """Bytes on disk of the whole map."""
    os.makedirs("room", exist_ok=True)
    mount("room", 1 << 30)
    done = undisturbed.trace(os.path.abspath("room/a.raymap"), encoding=encoding)
    if done.returncode != 0:
        sys.exit(done.stderr)
    stat = os.statvfs("room")
    subprocess.run(["umount", "room"], check=True)
    return (stat.f_blocks - stat.f_bfree) * stat.f_frsize


def promised(target):
    """Rays that journals on disk commit."""
    rays = 0
    for folder, _, names in os.walk(target):
        for name in names:
            if name.endswith(".journal"):
                with open(os.path.join(folder, name), "rb") as file:
                    rays += power_loss.committed(file.read())
    return rays


def judge(undisturbed, index, case):
    nbytes, ranks, encoding = case
    folder = os.path.abspath(f"disk-{index}")
    target = os.path.join(folder, "a.raymap")
    os.makedirs(folder, exist_ok=True)
    mount(folder, nbytes)
    done = undisturbed.trace(target, ranks=ranks, encoding=encoding)
    wrong = []
    if done.returncode not in (0, 5):
        wrong.append(f"status {done.returncode}: {done.stderr.strip()[-300:]}")
    if done.returncode == 5:
        said = harness.messages(done)
        if len(said) != 1 or "No space left" not in said[0]:
            wrong.append(f"no single message of a full disk: {said}")
        if os.path.exists(os.path.join(target, "map.h5")):
            status, facts = harness.info(target)
            if status != 0 or facts["rays"] < promised(target) or facts["complete"]:
                wrong.append(f"info: status {status}, {promised(target)} rays promised, {facts}")
            if harness.count(target)[0] != 0:
                wrong.append(f"query: {harness.count(target)}")
    mount(folder, 1 << 30, "remount")
    wrong += undisturbed.resumed_differences(target, ranks=(2, 0, 3)[index % 3],
                                             encoding=harness.ENCODINGS[index // 2 % 2])
    subprocess.run(["umount", folder], check=True)
    return [*wrong, *([] if done.returncode == 5 or nbytes > judge.whole[encoding] else ["it fits"])]


def main():
    enter_namespace()
    undisturbed = harness.Undisturbed(harness.write_scene(), RAYS, OPTIONS)
    judge.whole = {encoding: room_needed(undisturbed, encoding) for encoding in harness.ENCODINGS}
    cases = harness.Cases("disk full")
    print(f"the whole map takes {judge.whole} bytes on disk; {LEVELS} levels below")
    levels = [(judge.whole[encoding] * (level + 1) // (LEVELS + 1) // 4096 * 4096, level % 4, encoding)
              for level, encoding in enumerate(harness.encodings(LEVELS, cases.rng))]
    cases.all(lambda index, case: judge(undisturbed, index, case), levels)
    cases.finish()


main()
