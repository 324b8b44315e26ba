#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `trace --from OLD` makes the map that a trace of the new scene makes, bit for bit (digest, balance, images), after any
change: what moved, turned, grew, came, went or became something else; surfaces, media, detectors, a larger sphere; in either encoding,
for any number of ranks. Where nothing can be kept it says why and traces all. RAYMAP_FROM_EDITS asks for more edits."""
import copy
import json
import os
import pathlib
import random
import shutil
import subprocess
import sys

import yaml

sys.dont_write_bytecode = True
from asking import SOURCE, check, finish, run  # noqa: E402

EDITS = int(os.environ.get("RAYMAP_FROM_EDITS", "6"))
dice = random.Random(int(os.environ.get("RAYMAP_TEST_SEED", "5")))
RAYS = {"room": 9000, "double-gauss": 14000}
kept = {"some": 0, "none": 0}


class Words(yaml.SafeLoader):
    """In which `on` is a key like others."""


Words.yaml_implicit_resolvers = {first: [one for one in those if one[0] != "tag:yaml.org,2002:bool"]
                                 for first, those in yaml.SafeLoader.yaml_implicit_resolvers.items()}


def leaves(objects):
    for one in objects:
        if "objects" in one:
            yield from leaves(one["objects"])
        else:
            yield one


def holder(objects, wanted):
    """The list that an object stands in."""
    if any(one is wanted for one in objects):
        return objects
    return next(filter(None, (holder(one["objects"], wanted) for one in objects if "objects" in one)), None)


def near(place, far):
    return [round(x + dice.uniform(-far, far), 4) for x in place]


def pick(scene):
    """Mostly something small, so that rays are left."""
    every = [one for one in leaves(scene["objects"]) if "at" in one]
    small = [one for one in every if not any(word in one["name"] for word in ("wall", "floor", "ceiling", "barrel", "box", "plate"))]
    return dice.choice(small if dice.random() < 0.85 else every)


def move(scene, far):
    one = pick(scene)
    one["at"] = near(one["at"], far)


def turn(scene, far):
    one = pick(scene)
    one["rotate"] = near(one.get("rotate", [0, 0, 0]), 30)


def grow(scene, far):
    one = pick(scene)
    one["scale"] = round(dice.uniform(0.7, 1.3), 3)


def remove(scene, far):
    one = pick(scene)
    watched = [d.get("on") for d in scene.get("detectors", [])]
    if one["name"] not in watched:
        holder(scene["objects"], one).remove(one)


def add(scene, far):
    one = copy.deepcopy(pick(scene))
    where = holder(scene["objects"], pick(scene))
    one["name"] = f"added_{dice.randrange(10**6)}"
    one["at"] = near(one["at"], 2 * far)
    where.insert(dice.randrange(len(where) + 1), one)


def replace(scene, far):
    one, other = pick(scene), pick(scene)
    if set(one) & {"inside", "front"} == set(other) & {"inside", "front"}:
        one["geometry"] = other["geometry"]


def surface(scene, far):
    one = pick(scene)
    if "inside" in one and dice.random() < 0.5:
        one["surface"] = dice.choice(list(scene["surfaces"]))
    elif "white" in scene["surfaces"]:
        scene["surfaces"]["red"]["reflectance"] = {"rgb": [round(dice.uniform(0.1, 0.9), 3) for _ in range(3)]}
    else:
        scene["surfaces"]["silicon"]["reflect_specular"] = round(dice.uniform(0.05, 0.3), 4)


def medium(scene, far):
    if "glass" in scene["media"]:
        scene["media"]["glass"] = {"index": round(dice.uniform(1.4, 1.8), 4), "absorption": round(dice.uniform(0, 0.3), 4)}
    else:
        scene["media"]["n-bk7"] = {"index": round(dice.uniform(1.4, 1.8), 4)}
    scene["media"] = dict([(f"unused_{dice.randrange(10**6)}", {"index": 1.3})] + list(scene["media"].items()))


def detector(scene, far):
    watching = scene.setdefault("detectors", [])
    free = [d for d in watching if "on" not in d and d["type"] == "plane"]
    how = dice.random()
    if how < 0.3 and free:
        watching.remove(dice.choice(free))
    elif how < 0.6 and free:
        one = dice.choice(free)
        one["at"] = near(one["at"], far)
    elif how < 0.75:
        one = dice.choice(watching)
        one["cells"] = [dice.randrange(5, 60), dice.randrange(5, 60)]
    else:
        one = copy.deepcopy(pick(scene))
        watching.insert(dice.randrange(len(watching) + 1),
                        {"name": f"watch_{dice.randrange(10**6)}", "type": "plane", "at": one["at"], "size": [2 * far, 3 * far],
                         "cells": [7, 9], "direction": [0.3, 0.2, -1]})


def sphere(scene, far):
    """Beyond everything, where few rays come; or not any more."""
    beyond = [one for one in scene["objects"] if one["name"].startswith("far_")]
    if beyond and dice.random() < 0.5:
        scene["objects"].remove(dice.choice(beyond))
        return
    one = copy.deepcopy(pick(scene))
    one["name"] = f"far_{dice.randrange(10**6)}"
    one["at"] = near([40 * far, 30 * far, 20 * far], 10 * far)
    scene["objects"].append(one)


def lens(scene, far):
    if "gauss" not in scene["geometries"]:
        return move(scene, far)
    surfaces = scene["geometries"]["gauss"]["surfaces"]
    one = dice.choice([one for one in surfaces if one["curvature"] and not one.get("stop")])
    one["curvature"] *= 1 + dice.uniform(-0.02, 0.02)
    return None


def light(scene, far):
    scene["sources"][0]["flux"] = f"{dice.randrange(1, 9)} {scene['sources'][0]['flux'].split()[-1]}"


# What leaves the sphere as it is (mostly), changes it, adds or removes, is a detector's, a medium's.
KINDS = [[move, move, turn, grow, replace, surface, lens, light], [sphere], [remove, add], [detector], [medium]]
EVERY = [move, move, turn, grow, remove, add, replace, surface, medium, detector, sphere, lens, light]


def write(scene, name):
    pathlib.Path(name).write_text(json.dumps(scene, indent=0), encoding="utf-8")


def traced(*words, ranks=1):
    """What a trace says; None of a scene that is none. One with errors (bodies overlap) is as good as any other."""
    before = ["mpirun", "-np", str(ranks)] if ranks > 1 else []
    done = subprocess.run([*before, os.environ["RAYMAP"], "trace", *map(str, words), "--force", "--json"], text=True, capture_output=True, check=False)
    check(done.returncode in (0, 3, 7), f"{words}: {done.returncode}\n{done.stderr}")
    return None if done.returncode == 3 else json.loads(done.stdout[:done.stdout.rindex("}") + 1])


SAME = ("digest", "rays", "segments", "sources", "detectors", "complete")


def look_inside(what, answer):
    run("verify", "new.raymap", "--quiet")
    (new, whole) = (json.loads(run("info", name, "--json")) for name in ("new.raymap", "whole.raymap"))
    parent = new.pop("parent", None)
    check(parent == (None if answer["from"]["all_anew"] else answer["from"]["digest"]), f"{what}: parent {parent}")
    for key in (*SAME, "registrations", "objects", "spaces"):
        check(new[key] == whole[key], f"{what}: info tells other {key}")


def edits(example, far):
    if not os.path.exists("meshes"):
        os.symlink(SOURCE / "examples" / "room" / "meshes", "meshes")
    scene = yaml.load((SOURCE / "examples" / example / "scene.yaml").read_text(encoding="utf-8"), Words)
    n, bad = RAYS[example], 0
    write(scene, "old.yaml")
    traced("old.yaml", "-n", n, "-o", "old.raymap")
    done = 0
    while done < EDITS:
        kind = dice.choice(KINDS[done % len(KINDS)]) if EDITS > len(EVERY) else EVERY[(done * 5 + len(example)) % len(EVERY)]
        changed = copy.deepcopy(scene)
        kind(changed, far)
        if changed == scene:
            kind(changed, far)
        write(changed, "new.yaml")
        what = f"{example}, edit {done}: {kind.__name__}"
        encoding = dice.choice(["compact", "compact", "plain"])
        ranks = dice.choice([1, 1, 2, 3]) if EDITS > 20 else {2: 2, 4: 3}.get(done, 1)
        new = traced("new.yaml", "--encoding", encoding, "-o", "new.raymap", "--from", "old.raymap", ranks=ranks)
        if not new:
            continue
        whole = traced("new.yaml", "--encoding", encoding, "-n", n, "-o", "whole.raymap")
        others = [key for key in SAME if new[key] != whole[key]]
        check(not others, f"{what}: {others} {new['from']}")
        reused = new["from"]["reused"]
        check(reused + new["from"]["traced"] == n, f"{what}: {new['from']}")
        kept["some" if reused else "none"] += 1
        if done % 3 == 0 or EDITS > 20:
            look_inside(what, new)
        if others:
            bad += 1
            shutil.copy("old.yaml", f"bad-{example}-{bad}-old.yaml")
            shutil.copy("new.yaml", f"bad-{example}-{bad}-new.yaml")
        # now and then from what was kept, with all the changes since
        if dice.random() < 0.7:
            scene = changed
            os.replace("new.yaml", "old.yaml")
            shutil.rmtree("old.raymap")
            os.rename("new.raymap", "old.raymap")
        done += 1


def day():
    """Sky and sun through a window: their tables, made anew of what a map keeps, are the same to the last bit."""
    office, moved = SOURCE / "examples" / "office" / "scene.yaml", ["--set", "objects.desk_left.at.3=0.73"]
    traced(office, "-n", 2000, "-o", "day.raymap")
    whole = traced(office, *moved, "-n", 2000, "-o", "whole.raymap")
    for words, least in [([], 2000), (moved, 1000)]:
        new = traced(office, *words, "-o", "new.raymap", "--from", "day.raymap")
        check(new["from"]["reused"] >= least, f"sky and sun, {words}: {new['from']}")
    check(new["digest"] == whole["digest"], "sky and sun: other rays")


day()
edits("room", 0.2)
edits("double-gauss", 3.0)
check(kept["some"] > kept["none"], f"rays are kept: {kept}")
finish()
