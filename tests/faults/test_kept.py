# SPDX-License-Identifier: MIT
"""The promise: whichever single call of the system, of HDF5 or for memory fails while a command keeps something in a map (`keep`,
`select`), it ends with status 5 and one message, or as if nothing had been; the map is what it was, what is kept is there whole or not
at all, nothing else is left, and all memory is given back. Killed, it leaves what the next one removes.
"""
import os
import shutil

import harness
import results

COMMANDS = (("keep", "MAP", "--of", "path_length", "--of", "optical_path"), ("keep", "MAP"),
            ("select", "MAP", "bright", "path_length > 0 and segments > 1"), ("select", "MAP", "old", "all", "--force"))
LOCK = ".map.h5.writer.part"
KEPT = (os.path.join("shard-00000", "piece-00000.columns.h5"), "selection-bright.h5", "selection-old.h5")


def files(target):
    found = {}
    for folder, _, names in os.walk(target):
        for name in names:
            with open(os.path.join(folder, name), "rb") as file:
                found[os.path.relpath(os.path.join(folder, name), target)] = file.read()
    return found


class Command:
    """One of them on the map, and what stands there when nothing fails."""

    def __init__(self, words, source):
        self.words, self.source = words, source
        target = self.copy("undisturbed")
        self.before = files(target)
        done = self.run(target, {"CALLS": results.COUNTED, "LOG": target + ".log"})
        if done.returncode != 0:
            raise SystemExit(f"{words}: {done.stderr}")
        self.after = files(target)
        with open(target + ".log.0", encoding="utf-8", errors="replace") as file:
            self.calls = [line.split(" ", 2)[1] for line in file]

    def copy(self, name):
        target = os.path.abspath(f"{self.words[0]}-{len(self.words)}-{name}.raymap")
        shutil.rmtree(target, ignore_errors=True)
        shutil.copytree(self.source, target)
        return target

    def run(self, target, faults, ranks=0):
        words = [target if word == "MAP" else word for word in self.words]
        return harness.run(*words, "--threads", 1, "--quiet", ranks=ranks, faults={"DIR": target, **faults}, timeout=60)


def judge(command, case, ranks):
    at, call, action = case
    target = command.copy(f"{at}-{action}-{ranks}")
    faults = {"CALLS": results.COUNTED, "AT": at, "ACTION": action, "LEAKS": target + ".leaks"}
    done = command.run(target, {**faults, "RANK": at % ranks} if ranks else faults, ranks)
    left, wrong = files(target), []
    killed, locked = action in ("kill", "tear"), left.pop(LOCK, None) is not None  # it could not be removed: the next takes it over
    for name in set(left) | set(command.before):
        allowed = (command.before.get(name), command.after.get(name)) if name in KEPT else (command.before.get(name),)
        if left.get(name) not in allowed and not (killed and name.endswith(".part")):
            wrong.append(f"{name} is another")
    helps = call.startswith("read:") or call.startswith("H5")
    if not killed and done.returncode not in ((0, 3, 4, 5) if helps else (0, 5)):
        wrong.append(f"status {done.returncode}: {done.stderr[-600:]}")
    if not killed and done.returncode != 0 and len(harness.messages(done)) != 1:
        wrong.append(f"no single message: {done.stderr[-600:]}")
    if not killed and not ranks and os.path.exists(target + ".leaks.0"):
        with open(target + ".leaks.0", encoding="utf-8") as file:
            leaks = file.read().splitlines()
        if leaks and leaks[0] != "0":
            wrong.append("blocks not given back: " + "\n    ".join(leaks[:14]))
    if killed or locked or done.returncode != 0:
        again = command.run(target, {})
        if again.returncode == 2 and left.get("selection-bright.h5"):  # it stands there whole: the failure came later
            shutil.rmtree(target)
            return wrong
        if again.returncode != 0 or files(target) != command.after:
            wrong.append(f"asked again: {again.returncode} {again.stderr[-300:]} {sorted(files(target))}")
    shutil.rmtree(target)
    return wrong


def main():
    cases = harness.Cases("kept things under faults")
    cases.BUDGET_S = 20
    scene = harness.write_curved_scene()
    shutil.rmtree("map.raymap", ignore_errors=True)
    for words in (("trace", scene, "-o", "map.raymap", "-n", 900, "--quiet"), ("select", "map.raymap", "old", "ray < 5", "--quiet")):
        if harness.run(*words).returncode != 0:
            raise SystemExit(f"no map: {words}")
    drawn = []
    for words in COMMANDS:
        command = Command(words, "map.raymap")
        points = [(at + 1, call, cases.rng.choice(results.suffered(call))) for at, call in enumerate(command.calls)]
        of_it = harness.spread(points, 400 if harness.SLOW else 12, lambda point: point[1], cases.rng)
        print(f"{words}: {len(of_it)} of {len(points)}", flush=True)
        drawn += [(command, case, 0) for case in of_it] + [(command, case, 2) for case in of_it[-1:] if case[2] not in ("kill", "tear")]
    cases.rng.shuffle(drawn)
    cases.all(lambda index, case: [f"{case[0].words} {what}" for what in judge(*case)], drawn)
    cases.finish()


main()
