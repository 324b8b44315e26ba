# SPDX-License-Identifier: MIT
"""The promise: what a journal has committed, or a piece that was published holds, survives the loss
of power at any later moment, and `--resume` makes the map whole. The power is simulated: a real run
records its writes, syncs and names, and any prefix of them is replayed onto a disk that loses,
reorders and tears what was not synced.
"""
import os
import shutil

import h5py

import harness
import power_loss

RAYS = 20000
OPTIONS = ["--threads", "1", "--flush-portions", "1"]


def record(undisturbed, ranks, encoding):
    """The operations of one run of all ranks, in order, and the rays of each piece."""
    root = os.path.abspath(f"recorded-{ranks}-{encoding}")
    shutil.rmtree(root, ignore_errors=True)
    os.mkdir(root)
    log, target = os.path.abspath("record"), os.path.join(root, "a.raymap")
    done = undisturbed.trace(target, ranks=ranks if ranks > 1 else 0, encoding=encoding,
                             faults={"DIR": root, "RECORD": log})
    if done.returncode != 0:
        raise SystemExit(f"the recorded run failed: {done.stderr}")
    operations = []
    for rank in range(ranks):
        operations += power_loss.read_record(f"{log}.{rank}")
        os.remove(f"{log}.{rank}")
    pieces = {}
    for folder, _, names in os.walk(target):
        for name in names:
            if name.startswith("piece-"):
                with h5py.File(os.path.join(folder, name), "r") as piece:
                    pieces[os.path.join(folder, name)] = int(piece["portion/n_row"][:, 0].sum())
    shutil.rmtree(root)
    return root, sorted(operations, key=lambda operation: operation[0]), pieces


def cuts(operations, n, rng):
    """Moments to lose the power: after syncs and changes of names more often than elsewhere."""
    heavy = (power_loss.SYNC, power_loss.LINK, power_loss.RENAME, power_loss.UNLINK,
             power_loss.MKDIR, power_loss.CREATE)
    weights = [5 if operation[1] in heavy else 1 for operation in operations]
    return sorted(rng.choices(range(1, len(operations) + 1), weights, k=n))


def states(recorded, n, rng):
    """Yields (name, directory, promised rays): what is found after a loss, already on disk."""
    root, operations, pieces = recorded
    disk, journals, published, promised_pieces = power_loss.Disk(root), power_loss.Journals(), {}, {}
    moments, done = cuts(operations, n, rng), 0
    for i, moment in enumerate(moments):
        for _, operation, path, other, offset, data in operations[done:moment]:
            disk.replay(operation, path, other, offset, data)
            journals.replay(operation, path, offset, data)
            if operation in (power_loss.LINK, power_loss.RENAME) and other in pieces:
                published[other] = pieces[other]
            if operation == power_loss.SYNC:  # of the directory: its pieces are safe
                promised_pieces.update((name, rays) for name, rays in published.items()
                                       if os.path.dirname(name) == path)
        done = moment
        how = ("none", "some", "zeros", "some", "all")[i % 5]
        target = os.path.abspath(f"lost-{os.path.basename(root)}-{i}")
        shutil.rmtree(target, ignore_errors=True)
        disk.lose(how, rng, target)
        # those of a piece that is safe are the piece's, and counted once
        in_journals = sum(rays for path, rays in journals.promised.items()
                          if piece_of(path) not in promised_pieces)
        yield (f"{moment} of {len(operations)} operations, {how} of the unsynced kept", target,
               in_journals + sum(promised_pieces.values()))


def piece_of(journal):
    """piece-KKKKK.h5 that a journal will have become."""
    folder, name = os.path.split(journal)
    return os.path.join(folder, name[1:].split(".h5.")[0] + ".h5")


def judge(undisturbed, index, case):
    name, directory, promised = case
    target = os.path.join(directory, "a.raymap")
    wrong = []
    if promised > 0 or os.path.exists(os.path.join(target, "map.h5")):
        status, facts = harness.info(target)
        if status != 0:
            wrong.append(f"info: status {status}: {facts.get('stderr', '')[:300]}")
        elif facts["rays"] < promised:
            wrong.append(f"{facts['rays']} rays, {promised} were promised")
        elif facts["complete"] and facts["digest"] != undisturbed.balance["digest"]:
            wrong.append("says it is complete, and is not")
        else:
            wrong += harness.verify(target)
    wrong += undisturbed.resumed_differences(target, ranks=(0, 0, 0, 2)[index % 4],
                                             encoding=harness.ENCODINGS[index % 2])
    if not wrong:
        shutil.rmtree(directory)
    return wrong


def main():
    scene = harness.write_scene()
    undisturbed = harness.Undisturbed(scene, RAYS, OPTIONS)
    cases = harness.Cases("power loss")
    many = 18 if harness.SLOW else 1
    for ranks, encoding, n in ((1, "plain", 5 * many), (1, "compact", 5 * many),
                               (2, "plain", 4 * many), (2, "compact", 4 * many)):
        recorded = record(undisturbed, ranks, encoding)
        found = list(states(recorded, n, cases.rng))
        print(f"{ranks} ranks, {encoding}: {len(recorded[1])} operations, {n} states, rays promised: "
              f"{sorted({case[2] for case in found})}")
        cases.all(lambda index, case: judge(undisturbed, index, case), found)
    cases.finish()


main()
