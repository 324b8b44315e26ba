# SPDX-License-Identifier: MIT
"""Commands that make results out of a finished map, and what is true of a result when one call of
the system, of HDF5 or for memory has failed on the way: it is there whole, or not at all.
"""
import copy
import os
import shlex
import shutil

import harness

RECEIVERS = """
detectors:
- {name: behind, type: plane, size: [12, 12], cells: [10, 10], at: [0, 0, 11], side: both}
- {name: round, type: intensity, cells: [9, 18], axis: [0, 0, 1]}
"""
# Words; OUT stands for the result with the suffix that comes first, MAP, OTHER, SCENE, RECEIVERS
# for what they name.
GHOST = "hit(*, reflect) >= 1"
COMMANDS = [
    *[(suffix, f"stats MAP --of x(paper) --by source --where '{GHOST}' -o OUT")
      for suffix in (".csv", ".json", ".h5", ".png")],
    *[(suffix, "stats MAP --of x(paper) --of y(paper) --bins 9 --range -9..9 -o OUT")
      for suffix in (".npz", ".npy", ".svg")],
    ("", "stats MAP --of path_length --memory 20000 --bins 10,20,30 --json"),
    (".csv", "stats MAP --receivers RECEIVERS --of angle(behind) -o OUT"),
    *[(suffix, "detector MAP paper -o OUT") for suffix in (".png", ".csv", ".h5", ".npy", ".exr")],
    (".npz", "detector MAP behind --receivers RECEIVERS --cells 5x7 --quantity spectral -o OUT"),
    (".svg", "detector MAP paper --spot --mtf --plot OUT"),
    (".csv", "paths MAP -o OUT"),
    (".json", "paths MAP --detector paper --by object --collapse --matrix all -o OUT"),
    ("", "paths MAP --exact 16 --receivers RECEIVERS"),
    ("", "compare MAP OTHER --of path_length --json"),
    ("", f"compare MAP --where '{GHOST}' --where 'source(beam)'"),
    *[(suffix, "report MAP --energy -o OUT") for suffix in (".csv", ".json", ".svg", ".png")],
    (".html", "report MAP --html OUT"),
    ("", "report MAP 17"),
    *[(suffix, "draw MAP --limit 40 -o OUT")
      for suffix in (".svg", ".html", ".vtp", ".glb", ".gltf")],
    (".png", "draw MAP --limit 40 --view 3d --color path -o OUT"),
    (".svg", f"draw MAP --limit 40 --view yz --color criterion --where '{GHOST}' -o OUT"),
    *[(suffix, "render SCENE --samples 1 -o OUT") for suffix in (".png", ".exr")],
    *[(suffix, f"query MAP '{GHOST}' --limit 30 -o OUT") for suffix in (".csv", ".json", ".vtp", ".h5")],
    ("", "query MAP all --top 9 --of x(paper) --json"),
    ("", "query MAP 'registered(behind)' --receivers RECEIVERS --count"),
    ("", "info MAP --json"),
]
COUNTED = "*,read:*,memory:*,H5*"
SAYS_MORE = ("render", "info")  # its speed; what of the map's files it could not look at
OLD = b"what stood there before\n"


class Command:
    """One of them, and what it gives when nothing fails."""

    def __init__(self, number, suffix, words, places):
        self.name, self.suffix = f"{number}{suffix}", suffix
        self.words = [places.get(word, word) for word in shlex.split(words)]
        done, self.result, left, _ = self.run("undisturbed", {"CALLS": COUNTED, "LOG": "calls"})
        if done.returncode != 0 or left:
            raise SystemExit(f"{words}: status {done.returncode} undisturbed: {done.stderr} {left}")
        self.stdout = done.stdout
        with open(self.log, encoding="utf-8", errors="replace") as file:
            self.calls = [tuple(line.rstrip("\n").split(" ", 2)[1:]) for line in file]

    def like(self, words):
        """The same with other words."""
        other = copy.copy(self)
        other.words = words
        return other

    def __repr__(self):
        return " ".join(self.words)

    def run(self, folder, faults, ranks=0, timeout=60):
        """The process, the bytes of the result or None, what else lies there, blocks not freed."""
        folder = os.path.abspath(f"{self.name}-{folder}")
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder)
        out = os.path.join(folder, "result" + self.suffix)
        words = [out if word == "OUT" else word for word in self.words]
        if self.suffix:
            with open(out, "wb") as file:
                file.write(OLD)
            words.append("--force")
        notes = os.path.join(os.path.dirname(folder), "notes-" + os.path.basename(folder))
        faults = {"DIR": os.path.dirname(folder), "LEAKS": notes + ".leaks", **faults}
        if "LOG" in faults:
            faults["LOG"], self.log = notes + ".log", notes + ".log.0"
        for file in (notes + ".leaks.0", notes + ".leaks.1", notes + ".log.0"):
            if os.path.exists(file):
                os.remove(file)
        try:
            done = harness.run(*words, "--threads", 1, "--quiet", ranks=ranks, faults=faults,
                               timeout=timeout)
            result, leaks = None, []
            if os.path.exists(out):
                with open(out, "rb") as file:
                    result = file.read()
            if os.path.exists(notes + ".leaks.0"):
                with open(notes + ".leaks.0", encoding="utf-8") as file:
                    leaks = file.read().splitlines()
            left = [name for name in os.listdir(folder) if name != os.path.basename(out)]
            done.stdout = done.stdout.replace(folder, "")
            return done, result, left, leaks
        finally:
            shutil.rmtree(folder)


def places():
    """Makes the maps of the test: curved segments in one, both encodings."""
    with open("receivers.yaml", "w", encoding="utf-8") as file:
        file.write(RECEIVERS.lstrip())
    here = {name: os.path.abspath(path) for name, path in
            (("MAP", "one.raymap"), ("OTHER", "other.raymap"), ("RECEIVERS", "receivers.yaml"))}
    here["SCENE"] = harness.write_curved_scene()
    for target, seed, encoding in ((here["MAP"], 1, "plain"), (here["OTHER"], 2, "compact")):
        shutil.rmtree(target, ignore_errors=True)
        done = harness.run("trace", here["SCENE"], "-o", target, "-n", 600, "--seed", seed,
                           "--encoding", encoding, "--quiet")
        if done.returncode != 0:
            raise SystemExit(f"no map: {done.stderr}")
    return here


def suffered(call):
    """What a call may suffer."""
    if call.startswith("memory:"):
        return ("ENOMEM",)
    if call.startswith("H5"):
        return ("EIO",)
    if call.startswith("read:"):
        return ("EIO", "short") if call in ("read:read", "read:pread") else ("EIO",)
    return ("ENOSPC", "short", "kill", "tear") if call in ("write", "pwrite") else ("ENOSPC", "kill")


def judge(command, case, ranks=0):
    """Complaints about one disturbed run: case is the number of the call, its name, what it suffers."""
    at, call, action = case
    faults = {"CALLS": COUNTED, "AT": at, "ACTION": action}
    if ranks:
        faults["RANK"] = at % ranks
    done, result, left, leaks = command.run(f"{at}-{action}-{ranks}", faults, ranks)
    if action in ("kill", "tear"):
        return [] if result in (OLD, command.result) else ["half of a result"]
    wrong = []
    helps = call.startswith("read:") or call.startswith("H5")
    if done.returncode not in ((0, 3, 4, 5) if helps else (0, 5)):
        wrong.append(f"status {done.returncode}: {done.stderr.strip()[-600:]}")
    if done.returncode != 0 and len(harness.messages(done)) != 1:
        wrong.append(f"no single message: {done.stderr.strip()[-600:]}")
    if left:
        wrong.append(f"left behind: {left}")
    tells = helps and done.returncode == 0 and b"cannot be examined" in (result or b"")
    if command.suffix and not tells and result not in (
            (command.result,) if done.returncode == 0 else (OLD, command.result)):
        size = "none" if result is None else f"{len(result)} bytes"
        wrong.append(f"status {done.returncode}, result: {size} of {len(command.result)}")
    if (done.returncode == 0 and command.words[0] not in SAYS_MORE
            and done.stdout != command.stdout):
        wrong.append(f"says something else: {first_difference(done.stdout, command.stdout)}")
    if leaks and leaks[0] != "0":
        wrong.append("blocks not given back: " + "\n    ".join(leaks[:14]))
    return wrong


def first_difference(got, want):
    """The first lines that differ."""
    for a, b in zip(got.splitlines(), want.splitlines()):
        if a != b:
            return f"{a!r} for {b!r}"
    return f"{len(got)} bytes for {len(want)}"
