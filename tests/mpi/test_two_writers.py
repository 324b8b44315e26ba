#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: one command at a time writes to a map. Of two, one waits or ends with status 2 and says who is at work;
no ray of a run that ended well is lost, and what killed writers left keeps nobody from anything."""
import json
import os
import shutil
import signal
import subprocess
import time

PROGRAM = os.environ["RAYMAP"]
HERE = os.path.dirname(os.path.abspath(__file__))
LOCK = ".map.h5.writer.part"
SLOW = int(os.environ.get("RAYMAP_TEST_SCALE", "1")) > 1
TRACE = ["trace", "scene.yaml", "--quiet", "--threads", "1"]


def faults(calls, action, **more):
    """The environment of a program that suffers this on the files of locks (tests/faults/fault_plan.h)."""
    return {**os.environ, "LD_PRELOAD": os.environ["FAULTS"], "FAULTS_DIR": os.getcwd(), "FAULTS_CALLS": calls,
            "FAULTS_PATH": f"*/{LOCK}", "FAULTS_AT": "1", "FAULTS_ACTION": action, **more}


def start(*words, env=None):
    return subprocess.Popen([PROGRAM, *words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=env)


def run(*words, status=0, env=None):
    job = start(*words, env=env)
    said = job.communicate(timeout=60)[1]
    assert job.returncode == status, (words, job.returncode, said)
    return said


def held(path):
    """What the holder of a map's lock says of itself, once it does."""
    until = time.monotonic() + 30
    while time.monotonic() < until:
        try:
            with open(f"{path}/{LOCK}", encoding="utf-8") as file:
                text = file.read()
            if text:
                return text.strip()
        except FileNotFoundError:
            pass
        time.sleep(0.01)
    raise AssertionError(f"{path} is not locked")


def rays(path):
    run("verify", path, "--quiet")
    assert LOCK not in os.listdir(path)
    return json.loads(subprocess.check_output([PROGRAM, "info", path, "--json"]))["rays"]


subprocess.run(["bash", "-c", '. "$0"; write_scene scene.yaml', f"{HERE}/../cli/expect.bash"], check=True)
for name in ("m.raymap", "old.raymap", "bare.raymap"):
    shutil.rmtree(name, ignore_errors=True)
run(*TRACE, "-o", "old.raymap", "-n", "1000")

def writers(path):
    """Every command that writes to a map that stands."""
    return ([*TRACE, "-o", path, "-n", "1000", "--append"], [*TRACE, "-o", path, "-n", "1000", "--resume"],
            [*TRACE, "-o", path, "-n", "1000", "--force"], ["convert", "old.raymap", "-o", path, "--force"],
            ["query", "old.raymap", "registered(sensor)", "-o", path, "--force"],
            ["merge", "old.raymap", "-o", path, "--force"], ["repair", path])


# Every pair of them, or each with three: each writer stops itself before it lets go, the others come by. Four maps at a
# time, for each waits.
KINDS = len(writers(""))
for i in range(KINDS):
    shutil.rmtree(f"{i}.raymap", ignore_errors=True)
    shutil.copytree("old.raymap", f"{i}.raymap")
for batch in range(0, KINDS, 4):
    some = range(batch, min(batch + 4, KINDS))
    first = {i: start(*writers(f"{i}.raymap")[i], env=faults("unlink", "stop")) for i in some}
    told = {i: held(f"{i}.raymap") for i in some}
    pairs = [(i, start(*words)) for i in some for j, words in enumerate(writers(f"{i}.raymap"))
             if SLOW or (j - i) % KINDS in (0, 1, 3)]
    for i, other in pairs:
        said = other.communicate(timeout=60)[1]
        assert other.returncode == 2 and told[i] in said, (first[i].args, other.args, other.returncode, said)
    for i, job in first.items():
        while job.poll() is None:  # one that is not yet at its end when it is told to go on stops later
            job.send_signal(signal.SIGCONT)
            time.sleep(0.02)
        assert job.returncode == 0, (job.args, job.returncode, job.stderr.read())
        rays(f"{i}.raymap")
        shutil.rmtree(f"{i}.raymap")

# While a run goes on, before any piece of it may be locked; readers are not refused.
first = start(*TRACE, "-o", "m.raymap", "-n", "1G", "--flush", "1h")
told = held("m.raymap")
assert str(first.pid) in told and os.uname().nodename in told and "raymap trace" in told, told
first.send_signal(signal.SIGSTOP)
assert told in run("repair", "m.raymap", status=2)
first.send_signal(signal.SIGCONT)
first.send_signal(signal.SIGKILL)
first.communicate()

# The lock of one that was killed is gone with it; so is half an index, with the next writer.
for words in ([*TRACE, "-o", "m.raymap", "--resume", "--time-limit", "0.2s"], ["repair", "m.raymap"]):
    open("m.raymap/.map.h5.0.0.host.1.part", "wb").close()
    run(*words, status=6 if "--resume" in words else 0)
    assert not [name for name in os.listdir("m.raymap") if name.startswith(".map.h5")], words

# Where the file system keeps no locks, what a killed writer left is removed by an explicit option alone.
env = faults("lock:flock", "ENOLCK", FAULTS_STICKY="1")
shutil.copytree("old.raymap", "bare.raymap")
first = start(*TRACE, "-o", "bare.raymap", "-n", "1G", "--flush", "1h", "--append", env=env)
told = held("bare.raymap")
first.kill()
first.communicate()
for words in ([*TRACE, "-o", "bare.raymap", "--resume"], ["repair", "bare.raymap"]):
    said = run(*words, status=2, env=env)
    assert told in said and "raymap repair bare.raymap --break-lock" in said, said
run("repair", "bare.raymap", "--break-lock", env=env)
run("repair", "bare.raymap", env=env)
rays("bare.raymap")
shutil.rmtree("bare.raymap")

# One that made the folder and was overtaken before it locked it: what the other one traced is not mixed with its own.
for mode, status, n in (([], 2, 1000), (["--force"], 0, 3000)):
    slow = start(*TRACE, "-o", "late.raymap", "-n", "3000", *mode, env=faults("open", "stop"))
    os.waitid(os.P_PID, slow.pid, os.WSTOPPED | os.WNOWAIT)
    assert os.listdir("late.raymap") == []
    run(*TRACE, "-o", "late.raymap", "-n", "1000", "--resume")
    slow.send_signal(signal.SIGCONT)
    said = slow.communicate(timeout=60)[1]
    assert slow.returncode == status and ("exists already" in said) == (status == 2), (slow.returncode, said)
    assert rays("late.raymap") == n
    shutil.rmtree("late.raymap")

# Started at one moment, to a map that stands and to one that does not.
for _ in range(3 if SLOW else 1):
    n = rays("old.raymap")
    pair = [start(*TRACE, "-o", "old.raymap", "-n", "3000", "--append") for _ in range(2)]
    said = [job.communicate(timeout=60)[1] for job in pair]
    wins = [job.returncode for job in pair].count(0)
    assert wins >= 1 and all(job.returncode in (0, 2) for job in pair), said
    assert rays("old.raymap") == n + 3000 * wins, said
    shutil.rmtree("m.raymap")
    pair = [start(*TRACE, "-o", "m.raymap", "-n", "3000", mode) for mode in ("--resume", "--force")]
    said = [job.communicate(timeout=60)[1] for job in pair]
    assert 0 in [job.returncode for job in pair] and all(job.returncode in (0, 2) for job in pair), said
    assert rays("m.raymap") == 3000, said

# A run that cannot begin makes no map and takes none away.
before = rays("old.raymap")
os.makedirs("closed", exist_ok=True)
full = {**faults("mkdir", "ENOSPC"), "FAULTS_PATH": "*closed/shard-*"}
for words in (["-o", "none.raymap"], ["-o", "old.raymap", "--force"], ["-o", "old.raymap", "--append"]):
    for place, env in (("nowhere", None), ("closed", full)):
        said = run(*TRACE, *words, "-n", "10", "--shard-dir", place, status=5, env=env)
        assert place in said, said
assert not os.path.exists("none.raymap") and rays("old.raymap") == before
