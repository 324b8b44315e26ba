# SPDX-License-Identifier: MIT
"""The promise: whichever single call of the system, of HDF5 or for memory fails during a trace, the
program ends with status 5 and one message, or the failure was harmless and the map is whole. It
never crashes, never hangs, and no map says it is complete with anything else in it.
"""
import os
import re
import shutil
import subprocess

import harness

OPTIONS = ["--threads", "1", "--flush-portions", "1"]
# Patterns of calls, what they suffer, whether from then on, and how many of them are tried in a
# quick run and in a slow one (of each call and sort of file at least the first and the last).
SORTS = [
    ("*", "ENOSPC", 0, 4, 1000),
    ("*", "ENOSPC", 1, 2, 300),
    ("*", "EIO", 0, 2, 300),
    ("write,pwrite", "short", 0, 1, 200),
    ("read:*", "EIO", 0, 2, 400),
    ("read:pread,read:read", "short", 0, 1, 200),
    ("memory:*", "ENOMEM", 0, 3, 500),
    ("H5*", "EIO", 0, 4, 800),
    ("H5*", "EIO", 1, 2, 400),
    ("H5Tget_size", "EIO", 0, 1, 40),  # 0, not negative, says that it failed
]

READS = ("read:|H5(Fopen|Aopen_by_name|Aread|Dopen2|Dread|Dread_chunk|Lexists|Oexists_by_name"
         "|[ADFPST]get_.*|Tequal|Tis_variable_str)$")
# These serve reading and writing alike.
HELPS = r"H5P(create|close|set_fclose_degree)$|H5T(copy|close|set_size|set_cset|set_strpad)$|H5S"


def all_hdf5_calls_are_covered():
    """The library must know every function of HDF5 that the program writes with."""
    def names(*arguments):
        text = subprocess.run(["nm", "-D", *arguments], stdout=subprocess.PIPE, text=True,
                              check=True).stdout
        return {line.split()[-1].split("@")[0] for line in text.splitlines()}
    # Those that cannot fail in a way that matters, or tell of failures.
    harmless = {"H5Eclear2", "H5Eget_auto2", "H5Eset_auto2", "H5Ewalk2", "H5check_version",
                "H5dont_atexit", "H5free_memory", "H5get_libversion", "H5open"}
    used = {name for name in names("--undefined-only", harness.PROGRAM) if name.startswith("H5")
            and name[2].isalpha() and not name.endswith("_g")}
    missing = used - names("--defined-only", harness.FAULTS.split(":")[-1]) - harmless
    missing = {name for name in missing if not re.match(READS, name)}
    return [f"tests/faults/fault_hdf5.c lacks {name}" for name in sorted(missing)]


def judge(undisturbed, index, case):
    at, call, _, calls, action, sticky, encoding = case
    target = os.path.abspath(f"case-{calls[:4].strip('*:')}-{action}{sticky}-{index}.raymap")
    faults = {"DIR": target, "CALLS": calls, "AT": at, "ACTION": action, "STICKY": sticky}
    shutil.rmtree(target, ignore_errors=True)
    done = undisturbed.trace(target, faults=faults, timeout=60, encoding=encoding)
    wrong = []
    # What cannot be read looks damaged. A reader's close that fails does no harm, what it reads next does.
    reads = re.match(READS, call) or re.match(HELPS, call) or (sticky and call == "H5Aclose")
    allowed = (0, 4, 5) if reads else (0, 5)
    if done.returncode not in allowed:
        wrong.append(f"status {done.returncode}: {done.stderr.strip()[-300:]}")
    if done.returncode in (4, 5) and len(harness.messages(done)) != 1:
        wrong.append(f"no single message: {done.stderr.strip()[-300:]}")
    if done.returncode == 0:
        wrong += undisturbed.differences(target)
    elif os.path.exists(target):
        status, facts = harness.info(target)
        if harness.crashed(subprocess.CompletedProcess((), status)):
            wrong.append(f"info afterwards: status {status}")
        if facts.get("complete") and facts.get("digest") != undisturbed.balance["digest"]:
            wrong.append("says it is complete, and is not")
        if not wrong:
            wrong += undisturbed.resumed_differences(target)
    shutil.rmtree(target, ignore_errors=True)
    return wrong


def main():
    scene = harness.write_scene()
    undisturbed = harness.Undisturbed(scene, 10000, OPTIONS)
    cases = harness.Cases("each call fails once")
    cases.all(lambda index, case: all_hdf5_calls_are_covered(), ["list of HDF5's functions"])
    drawn = []
    for i, (calls, action, sticky, quick, slow) in enumerate(SORTS):
        # A quick run takes one encoding for each sort, another seed the other.
        chosen = harness.ENCODINGS if harness.SLOW else [harness.ENCODINGS[(i + harness.SEED) % 2]]
        for encoding in chosen:
            found = harness.calls_of(undisturbed, os.path.abspath("counted.raymap"), calls, encoding)[0]
            points = [(at + 1, call, harness.kind(path)) for at, (call, path) in enumerate(found)]
            points = harness.spread(points, slow // 2 if harness.SLOW else quick,
                                    lambda point: point[1:], cases.rng)
            drawn += [(*point, calls, action, sticky, encoding) for point in points]
            print(f"{calls} {action}{' for good' if sticky else ''}, {encoding}: {len(points)} of "
                  f"{len(found)}", flush=True)
    cases.rng.shuffle(drawn)
    cases.all(lambda index, case: judge(undisturbed, index, case), drawn)
    cases.finish()


main()
