# SPDX-License-Identifier: MIT
"""The promise: at whatever call SIGKILL meets one rank or all of them, before the call or in the
middle of what it writes, the map can be asked at once, tells how far it got, and `--resume` with
another number of ranks makes it the map of an undisturbed run.

Kill points are drawn by seed over encodings, ranks, phases and calls.
"""
import fnmatch
import functools
import os
import shutil

import harness

OPTIONS = ["--threads", "1", "--flush-portions", "1"]
# Name, what writes the scene, rays, sizes of pieces for two or three, kill points quick and slow.
SCENES = [
    ("curved", harness.write_curved_scene, 12000, {"plain": "4M", "compact": "500k"}, 3, 84),
    ("straight", harness.write_scene, 40000, {"plain": "8M", "compact": "150k"}, 7, 168),
]

# Which calls make a phase: patterns of the call and of the path.
PHASES = {
    "start": ("mkdir,open", "*.raymap*"),
    "first index": ("*", "*.map.h5.*.part"),
    "block": ("pwrite,write", "*.piece-*.part"),
    "flush": ("*", "*.journal"),
    "sync": ("fsync,fdatasync", "*"),
    "new piece": ("open,ftruncate,link,unlink,rename,fsync,close", "*piece-*"),
    "any": ("mkdir,open,pwrite,write,ftruncate,fsync,fdatasync,link,rename,unlink", "*"),
}


def belongs(phase, call, path):
    """Whether a call counts in a phase."""
    calls, pattern = PHASES[phase]
    return (any(fnmatch.fnmatchcase(call, name) for name in calls.split(","))
            and fnmatch.fnmatchcase(path, pattern))


def draw(counts, first, n, rng):
    """n kill points from the first on: (encoding, ranks, killed rank or '', phase, number of the call,
    how)."""
    points, encodings = [], harness.encodings(n, rng)
    for i in range(first, first + n):
        ranks = 1 + i % 3
        phase = list(PHASES)[i % len(PHASES)]
        rank = rng.choice([*range(ranks), ""]) if ranks > 1 else ""
        encoding = encodings[i - first]
        most = max(1, counts(encoding, ranks)[phase])
        # The last calls are of the index at the end: as many points as anywhere before.
        at = rng.randint(1, most) if rng.random() < 0.7 else max(1, most - rng.randint(0, 40))
        how = rng.choice(["kill", "kill", "tear", "exit"])
        points.append((encoding, ranks, rank, phase, at, how))
    return points


def ask(undisturbed, target, wrong):
    """What a killed run left must answer; returns the rays it holds."""
    if not os.path.exists(os.path.join(target, "map.h5")):
        return 0  # killed before there was a map
    status, facts = harness.info(target)
    if status != 0:
        wrong.append(f"info: status {status}: {facts.get('stderr', '')[:300]}")
        return 0
    if facts["complete"] and facts["digest"] != undisturbed.balance["digest"]:
        wrong.append("says it is complete, and is not")
    status, counted = harness.count(target)
    if status != 0:
        wrong.append(f"query: status {status}: {str(counted)[:300]}")
    elif counted["rays"]["total"] != facts["rays"]:
        wrong.append(f"query sees {counted['rays']['total']} rays, info {facts['rays']}")
    wrong += harness.verify(target)
    return facts["rays"]


def judge(undisturbed, index, case, tally):
    encoding, ranks, rank, phase, at, how = case
    calls, path = PHASES[phase]
    target = os.path.abspath(f"kill-{index}.raymap")
    shutil.rmtree(target, ignore_errors=True)
    faults = {"DIR": target, "CALLS": calls, "PATH": path, "AT": at, "ACTION": how}
    if rank != "":
        faults["RANK"] = rank
    done = undisturbed.trace(target, ranks=ranks if ranks > 1 else 0, faults=faults, timeout=60,
                             encoding=encoding)
    wrong = []
    killed = done.returncode != 0
    if killed and how != "exit" and not harness.crashed(done):
        wrong.append(f"status {done.returncode}: {done.stderr.strip()[-300:]}")
    rays = ask(undisturbed, target, wrong)
    tally.append((phase, killed, rays))
    if os.path.exists(target):
        wrong += undisturbed.resumed_differences(target, ranks=(0, 3, 2)[ranks - 1],
                                                 encoding=harness.ENCODINGS[at % 2])
    if not wrong:
        shutil.rmtree(target, ignore_errors=True)
    return wrong


def counter(undisturbed):
    """A function of encoding and ranks: phase -> calls that each rank makes at least."""
    @functools.cache
    def counts(encoding, ranks):
        counted = harness.calls_of(undisturbed, os.path.abspath("counted.raymap"), "*", encoding,
                                   ranks=ranks if ranks > 1 else 0)
        return {phase: min(sum(belongs(phase, *call) for call in calls) for calls in counted)
                for phase in PHASES}
    return counts


def main():
    cases = harness.Cases("kill matrix")
    tally, first = [], 0
    for name, write, rays, piece_size, quick, slow in SCENES:
        undisturbed = harness.Undisturbed(write(), rays, OPTIONS, piece_size)
        points = draw(counter(undisturbed), first, slow if harness.SLOW else quick, cases.rng)
        first += len(points)
        cases.all(lambda index, case: judge(undisturbed, f"{name}-{index}", case, tally), points)
    for phase in PHASES:
        of_phase = [entry for entry in tally if entry[0] == phase]
        print(f"{phase}: {len(of_phase)} points, {sum(entry[1] for entry in of_phase)} killed, "
              f"rays saved {sorted(entry[2] for entry in of_phase if entry[1])}")
    if sum(entry[1] for entry in tally) < 0.6 * len(tally):  # ranks share blocks as they come
        cases.failures.append("too few points were met")
        print("FAILED: too few points were met")
    cases.finish()


main()
