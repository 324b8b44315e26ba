# SPDX-License-Identifier: MIT
"""Runs the program under the preload library of faults and judges what stands afterwards.

A *case* is one disturbed trace of a small scene in a directory of its own: the judge asks whether
the map tells the truth then, and whether `--resume` makes it the map of an undisturbed run.
"""
import concurrent.futures
import json
import os
import random
import re
import shutil
import subprocess
import sys
import time

import h5py

PROGRAM = os.environ["RAYMAP"]
FAULTS = os.environ["FAULTS"]
HERE = os.path.dirname(os.path.abspath(__file__))
SLOW = int(os.environ.get("RAYMAP_TEST_SCALE", "1")) > 1
SEED = int(os.environ.get("RAYMAP_TEST_SEED", "1"))
PIECE_SIZE = {"plain": "4M", "compact": "75k"}  # two or three pieces of either, of 20,000 rays
ENCODINGS = tuple(PIECE_SIZE)
CRITERION = "registered(*) and hit(*, transmit_specular) >= 2"


def write_scene(path="scene.yaml"):
    """The scene of the tests of the command line."""
    subprocess.run(["bash", "-c", '. "$0"; write_scene "$1"',
                    os.path.join(HERE, "..", "cli", "expect.bash"), path], check=True)
    return os.path.abspath(path)


def write_curved_scene(path="curved.yaml"):
    """A scene with a gradient medium: maps of format 4.0 with points along curved segments."""
    shutil.copyfile(os.path.join(HERE, "..", "data", "curved-segments.yaml"), path)
    return os.path.abspath(path)


def run(*arguments, ranks=0, faults=None, timeout=120):
    """One run of the program; ranks 0: without mpirun. faults: variables without FAULTS_."""
    command = [PROGRAM, *map(str, arguments)]
    if ranks:
        command = ["mpirun", "--mca", "odls_base_sigkill_timeout", "0", "-np", str(ranks), *command]
    preload = []
    if faults:
        preload = ["env", "LD_PRELOAD=" + FAULTS,
                   *(f"FAULTS_{name}={value}" for name, value in faults.items())]
        at = command.index(PROGRAM)
        command[at:at] = preload
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
        try:
            said = child.communicate(timeout=timeout)
        except subprocess.TimeoutExpired as late:
            try:
                late.output = waits(child.pid)
            except OSError as gone:
                late.output = gone
            child.kill()
            raise
    return subprocess.CompletedProcess(command, child.returncode, *said)


def waits(process):
    """What each thread of a process is waiting for in the kernel."""
    tasks = f"/proc/{process}/task"
    found = []
    for task in sorted(os.listdir(tasks)):
        for name in ("wchan", "syscall"):
            with open(f"{tasks}/{task}/{name}", encoding="ascii", errors="replace") as file:
                found.append(file.read().strip())
    return found


def info(target):
    """Status and JSON of `info`; what it said instead where it gives none."""
    done = run("info", target, "--json")
    try:
        return done.returncode, json.loads(done.stdout)
    except ValueError:
        return done.returncode, {"stderr": done.stderr}


def balance(facts):
    """What must be the same in every map of the same rays."""
    return {key: facts.get(key) for key in ("rays", "segments", "registrations", "digest",
                                            "sources", "detectors", "complete")}


def sums(target):
    """What the index says of all rays: counts, digest, balance of light, bytes of the detectors' images."""
    found = {}
    try:
        with h5py.File(os.path.join(target, "map.h5"), "r") as index:
            for name in ("rays", "segments", "registrations", "digest", "complete"):
                found[name] = index.attrs.get(name)
            for group in ("source", "tally", "detector"):
                index[group].visititems(
                    lambda name, item, group=group: found.update({f"{group}/{name}": item[()].tobytes()})
                    if isinstance(item, h5py.Dataset) else None)
    except (OSError, KeyError) as error:
        found["unreadable"] = str(error)
    return found


def verify(target):
    """Complaints of `verify`."""
    done = run("verify", target)
    if done.returncode == 0:
        return []
    return [f"verify: status {done.returncode}: {(done.stdout + done.stderr).strip()[:400]}"]


def count(target):
    """Status and sums of `query --count`."""
    done = run("query", target, CRITERION, "--count", "--json")
    try:
        facts = json.loads(done.stdout)
    except ValueError:
        return done.returncode, done.stderr
    return done.returncode, {key: facts[key] for key in ("rays", "segments", "flux")}


class Undisturbed:
    """The map that every disturbed run must end as."""

    def __init__(self, scene, rays, options=(), piece_size=None):
        self.scene, self.rays, self.options = scene, rays, list(options)
        self.piece_size = piece_size or PIECE_SIZE
        target = os.path.abspath("undisturbed.raymap")
        shutil.rmtree(target, ignore_errors=True)
        done = self.trace(target)
        if done.returncode != 0:
            sys.exit(f"the undisturbed run failed: {done.stderr}")
        self.balance, self.sums = balance(info(target)[1]), sums(target)
        shutil.rmtree(target)

    def trace(self, target, *more, encoding="plain", **how):
        return run("trace", self.scene, "-o", target, "-n", self.rays, "--quiet", *self.options,
                   "--encoding", encoding, "--piece-size", self.piece_size[encoding], *more, **how)

    def differences(self, target):
        """What of a map that says it is complete is not as undisturbed."""
        have = sums(target)
        wrong = [f"{key}: {str(have.get(key))[:40]}, not {str(self.sums.get(key))[:40]}"
                 for key in sorted({*have, *self.sums}) if have.get(key) != self.sums.get(key)]
        return wrong + verify(target)

    def resumed_differences(self, target, ranks=0, encoding="plain"):
        """The same after --resume."""
        done = self.trace(target, "--resume", ranks=ranks, encoding=encoding)
        if done.returncode != 0:
            return [f"--resume: status {done.returncode}: {done.stderr.strip()[:600]}"]
        leftover = [os.path.join(folder, name) for folder, _, names in os.walk(target)
                    for name in names if name.startswith(".")]
        return self.differences(target) + [f"left behind: {path}" for path in leftover]


def crashed(done):
    """Whether a process ended by a signal that nobody sent."""
    return done.returncode < 0 or done.returncode >= 128


def messages(done):
    """Lines in which the program itself talks."""
    return re.findall(r"^raymap: .*", done.stderr, flags=re.M)


def encodings(n, rng):
    """Encodings of n cases: both alike often, in an order that the seed draws."""
    drawn = [ENCODINGS[i % 2] for i in range(n)]
    rng.shuffle(drawn)
    return drawn


def calls_of(undisturbed, target, calls, encoding, ranks=0, path="*"):
    """[rank] -> [(call, path)] that a whole run makes under the patterns `calls`."""
    log = os.path.abspath("calls.log")
    shutil.rmtree(target, ignore_errors=True)
    faults = {"DIR": target, "CALLS": calls, "PATH": path, "LOG": log}
    done = undisturbed.trace(target, ranks=ranks, faults=faults, encoding=encoding)
    if done.returncode != 0:
        sys.exit(f"the counted run failed: {done.stderr}")
    shutil.rmtree(target)
    found = []
    for rank in range(max(ranks, 1)):
        with open(f"{log}.{rank}", encoding="utf-8", errors="replace") as file:
            found.append([tuple(line.rstrip("\n").split(" ", 2)[1:]) for line in file])
        os.remove(f"{log}.{rank}")
    return found


def kind(path):
    """What sort of file of a map it is, without numbers, hosts and process ids."""
    name = os.path.basename(path)
    name = re.sub(r"^\.(piece-\d+|map)\.h5\..*\.(part|journal)$", r".\1.\2", name)
    return re.sub(r"\d+", "N", name)


def spread(items, n, key, rng):
    """n of the items: of each kind the first, then the last, then any, as far as n goes."""
    groups = {}
    for item in items:
        groups.setdefault(key(item), []).append(item)
    first, last = [group[0] for group in groups.values()], [group[-1] for group in groups.values()]
    rest = list(items)
    for part in (first, last, rest):
        rng.shuffle(part)
    return sorted(list(dict.fromkeys(first + last + rest))[:n])


class Cases:
    """Runs cases two at a time and collects what is wrong. A quick run begins no more of them after
    five minutes, so that a busy machine takes fewer cases rather than too long."""

    BUDGET_S = 300

    def __init__(self, name):
        self.name, self.n, self.passed_over, self.failures = name, 0, 0, []
        self.rng, self.begun = random.Random(SEED), time.monotonic()

    def _in_time(self, judge, index, case):
        if not SLOW and time.monotonic() - self.begun > self.BUDGET_S:
            return None
        return judge(index, case)

    def all(self, judge, cases, workers=2):
        """judge(index, case) -> list of complaints."""
        with concurrent.futures.ThreadPoolExecutor(workers) as pool:
            work = {pool.submit(self._in_time, judge, i, case): case
                    for i, case in enumerate(cases)}
            for future in concurrent.futures.as_completed(work):
                try:
                    complaints = future.result()
                except subprocess.TimeoutExpired as late:
                    complaints = [f"it hangs: {late.output}"]
                self.n += complaints is not None
                self.passed_over += complaints is None
                for complaint in complaints or []:
                    self.failures.append(work[future])
                    print(f"FAILED: {work[future]}: {complaint}", flush=True)

    def finish(self):
        late = f" ({self.passed_over} more were passed over: no time)" if self.passed_over else ""
        print(f"{self.name}: {self.n} cases{late}, {len(self.failures)} complaints, seed {SEED}")
        sys.exit(1 if self.failures or self.n == 0 else 0)
