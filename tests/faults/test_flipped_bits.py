# SPDX-License-Identifier: MIT
"""The promise: one bit of a map with curved segments that is not what it was, anywhere in the index or the pieces,
is found by `verify`; and what any command says of such a map is what it says of the whole one, or one
message and status 4.
"""
import os
import re
import shutil
import time

import harness
import results

COMMANDS = [
    ("", "info MAP"),
    ("", "query MAP 'event(gradient) and registered(paper where x > 1)' --count"),
    ("", "query MAP 'hit(*, reflect) >= 1' --limit 20"),
    ("", "report MAP 99"),
    ("", "report MAP --energy"),
    ("", "stats MAP --of x(paper) --of path_length --bins 7"),
    ("", "detector MAP within"),
    ("", "detector MAP behind --receivers RECEIVERS"),
    ("", "paths MAP --matrix all"),
    (".svg", "draw MAP --limit 40 -o OUT"),
    (".glb", "draw MAP --limit 40 -o OUT"),
    (".html", "report MAP --html OUT"),
]


def flip(target, rng):
    """One bit of one file, and where it was."""
    files = [os.path.join(folder, name) for folder, _, names in os.walk(target)
             for name in sorted(names)]
    path = rng.choice(sorted(files))
    with open(path, "r+b") as file:
        at = rng.randrange(os.path.getsize(path))
        file.seek(at)
        byte = file.read(1)[0] ^ 1 << rng.randrange(8)
        file.seek(at)
        file.write(bytes([byte]))
    return f"{os.path.relpath(path, target)} at {at}"


def named(said):
    """What was said, by whatever name the map has."""
    text = said.decode("latin-1") if isinstance(said, bytes) else said or ""
    return re.sub(r"(/[^ \"'<]*/)?(one|other|flipped)(?=\W|$)", "MAP", text)


def judge(command, undisturbed, where):
    """Complaints about what a command says of a damaged map."""
    done, result, left, _ = command.run("flipped", {"CALLS": "none"})
    wrong = [f"left behind: {left}"] if left else []
    if done.returncode not in (0, 4):
        wrong.append(f"status {done.returncode}: {done.stderr.strip()[-400:]}")
    if done.returncode != 0 and len(harness.messages(done)) != 1:
        wrong.append(f"no single message: {done.stderr.strip()[-400:]}")
    if done.returncode == 0 and named(done.stdout) != named(undisturbed.stdout):
        wrong.append("says: " + results.first_difference(named(done.stdout),
                                                           named(undisturbed.stdout)))
    if done.returncode == 0 and named(result) != named(undisturbed.result):
        wrong.append("another result")
    if done.returncode != 0 and command.suffix and result != results.OLD:
        wrong.append("a result in spite of it")
    return [f"{where}: {' '.join(command.words)}: {what}" for what in wrong]


def main():
    cases = harness.Cases("flipped bits")
    cases.BUDGET_S = 25
    here = results.places()
    maps = (here["MAP"], here["OTHER"])
    chosen = list(enumerate(COMMANDS)) if harness.SLOW else \
        cases.rng.sample(list(enumerate(COMMANDS)), 3)
    good = [[results.Command(100 * m + number, suffix, words, dict(here, MAP=target))
             for number, (suffix, words) in chosen] for m, target in enumerate(maps)]

    def try_one(index, case):
        target, commands = maps[case % 2], good[case % 2]
        copy = os.path.abspath("flipped.raymap")
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(target, copy)
        where = flip(copy, cases.rng)
        done = harness.run("verify", copy)
        wrong = [] if done.returncode == 4 else [f"{where}: verify: status {done.returncode}"]
        for command in commands if harness.SLOW else [cases.rng.choice(commands)]:
            of_copy = command.like([copy if word == target else word for word in command.words])
            wrong += judge(of_copy, command, where)
        return wrong

    cases.begun = time.monotonic()
    cases.all(try_one, range(200 if harness.SLOW else 6), workers=1)
    cases.finish()


main()
