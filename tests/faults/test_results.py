# SPDX-License-Identifier: MIT
"""The promise: whichever single call of the system, of HDF5 or for memory fails while a command
makes a result out of a map, it ends with status 5 and one message, or as if nothing had been. What
stood under the result's name stands there, or the whole new result does; nothing else is left, and
all memory is given back. It never crashes and never hangs, under mpirun neither.
"""
import time

import harness
import results

WRITING = ("H5Fcreate", "H5Dcreate2", "H5Dwrite", "H5Acreate_by_name", "H5Awrite", "H5Fflush")


def draw(command, n, rng):
    """n cases: of each call and sort of file something, then any; most of them after the map has
    been opened, which other tests disturb enough."""
    points = [(at + 1, call, harness.kind(path)) for at, (call, path) in enumerate(command.calls)]
    opened = max([at for at, call, _ in points if call.startswith("H5Fclose")][:1] or [0])
    late = [point for point in points if point[0] > opened and not point[1].startswith("H5")
            or point[1] in WRITING]
    chosen = set(harness.spread(points, n // 4, lambda point: point[1:], rng))
    groups = {}
    for point in late:
        groups.setdefault(point[1].split(":")[0] if ":" in point[1] else "writes", []).append(point)
    for group in groups.values():  # memory, JSON, reading, writing alike
        chosen |= set(harness.spread(group, 3 * n // 4 // len(groups), lambda point: point[1], rng))
    drawn = [(at, call, rng.choice(results.suffered(call))) for at, call, _ in sorted(chosen)]
    written = [(at, call, "kill") for at, call, _ in late if call in ("write", "pwrite")]
    full = [(at, call, "ENOSPC") for at, call, _ in late if call in ("write", "pwrite")]
    synced = [(at, call, "EIO") for at, call, _ in late if call == "fsync"]
    # no room at all; most is on disk; the name is given, not yet for good
    return list(dict.fromkeys(drawn + full[:1] + written[-1:] + synced[1:2]))


def main():
    cases = harness.Cases("results under faults")
    cases.BUDGET_S = 20
    here = results.places()
    numbered = list(enumerate(results.COMMANDS))
    if not harness.SLOW:  # another seed takes others; one library that writes files itself always
        rendered = [one for one in numbered if one[1] == (".exr", "render SCENE --samples 1 -o OUT")]
        numbered = rendered + cases.rng.sample(numbered, 4)
        assert rendered
    drawn = []
    for number, (suffix, words) in numbered:
        command = results.Command(number, suffix, words, here)
        of_it = draw(command, 100 if harness.SLOW else 6, cases.rng)
        print(f"{words} {suffix}: {len(of_it)} of {len(command.calls)}", flush=True)
        drawn += [(command, case, 0) for case in of_it]
        of_ranks = draw(command, 12, cases.rng) if harness.SLOW else of_it[-1:]
        drawn += [(command, case, 2) for case in of_ranks if case[2] not in ("kill", "tear")]
    cases.rng.shuffle(drawn)
    cases.begun = time.monotonic()
    cases.all(lambda index, case: [f"{case[0].words} {what}" for what in results.judge(*case)],
              drawn)
    cases.finish()


main()
