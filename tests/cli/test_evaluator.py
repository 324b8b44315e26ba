#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The query engine against an evaluator of its own (evaluator.py): random criteria over the examples
and an odd little scene must select as many rays, segments and as much flux, whatever the map's
encoding, pieces, index of histories, and however many ranks and threads ask.

RAYMAP_JUDGE says how many criteria in all (30), RAYMAP_JUDGE_SEED which (1), RAYMAP_JUDGE_RAYS
how many times as many rays (1): tests/slow asks for more.
"""
import json
import math
import os
import pathlib
import subprocess
import sys

sys.dont_write_bytecode = True

import evaluator_dice
import evaluator_sample
import evaluator_scene
from evaluator import Evaluator
from evaluator_map import PlainMap

PROGRAM, SOURCE = os.environ["RAYMAP"], pathlib.Path(os.environ["SOURCE_DIR"])
N_CRITERION = int(os.environ.get("RAYMAP_JUDGE", "30"))
SEED = int(os.environ.get("RAYMAP_JUDGE_SEED", "1"))
TIMES = int(os.environ.get("RAYMAP_JUDGE_RAYS", "1"))
EVERYTHING = N_CRITERION > 60
AT_ONCE = 40
# Of registrations on meshes and a ball; most of them dice do not come to.
AT_PLACES = ["registered(film where at(box.1, face 1, transmit) and angle < 90)",
             "registered(film where at(ball)) >= 2 and not registered(film where at(absorb))",
             "registered(film where at('box.?', side back) and not hit(ball)) == 1",
             "registered(film where path(\".* T@box.2 V@film\") and x > 2.5)"]

failures = 0


def fail(text):
    global failures
    failures += 1
    print("FAIL " + text, flush=True)


def program(*arguments, ranks=1, check=True, lines=""):
    command = [PROGRAM, *map(str, arguments)]
    if ranks > 1:
        command = ["mpirun", "-np", str(ranks), *command]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          check=False, input=lines)
    if check and done.returncode != 0:
        sys.exit(f"{' '.join(command)[:2000]}: status {done.returncode}\n{done.stderr}")
    return done


def trace(scene, name, n_ray, *options, ranks=1):
    program("trace", scene, "-o", name, "-n", n_ray, "--quiet", "--force", *options, ranks=ranks)
    return name


def standard_error(plain, found):
    """Of the flux of rays that were or were not selected, source by source."""
    variance = 0.0
    for s, n in enumerate(plain.source_emitted):
        weight = plain.ray["weight"][found & (plain.ray["source"] == s)]
        spread = (weight ** 2).sum() - weight.sum() ** 2 / n
        variance += (plain.source_flux[s] / n) ** 2 * n / (n - 1) * spread
    return math.sqrt(max(variance, 0.0))


def expected(plain, found):
    return {"rays": int(found.sum()), "segments": int(plain.ray["segment_count"][found].sum()),
            "flux": float(plain.flux[found].sum()), "standard_error": standard_error(plain, found)}


def agrees(want, answer):
    flux, error = answer["flux"]["matched"], answer["flux"]["standard_error"]
    return answer["rays"]["matched"] == want["rays"] \
        and answer["segments"]["matched"] == want["segments"] \
        and math.isclose(flux, want["flux"], rel_tol=1e-9, abs_tol=1e-12) \
        and math.isclose(error, want["standard_error"], rel_tol=1e-6, abs_tol=1e-7)


def ask(target, texts, *options, ranks=1):
    """The program's answers to many criteria, a scan for every AT_ONCE of them."""
    answers = []
    for at in range(0, len(texts), AT_ONCE):
        some = texts[at:at + AT_ONCE]
        out = program("query", target, *some, "--count", "--json", *options, ranks=ranks).stdout
        found = json.loads(out)
        answers += found if len(some) > 1 else [found]
    return answers


def check_paths(name, verdicts, n):
    """The evaluator's own automaton against Python's regular expressions."""
    for _ in range(n):
        text = verdicts.dice.path(verdicts.evaluator.paths)
        both = verdicts.evaluator.paths.match_again(text)
        if (both[:, 0] != both[:, 1]).any():
            fail(f"{name}: the evaluator disagrees with himself: path(\"{text}\")")


def check_complements(target, dice, evaluator, n):
    """not (a and b) is not a or not b; a and b, a and not b, not a and b, neither add up."""
    for _ in range(n):
        a, b = (f"({dice.test(evaluator)})" for _ in range(2))
        texts = [f"not ({a} and {b})", f"not {a} or not {b}", f"{a} and {b}", f"{a} and not {b}",
                 f"not {a} and {b}", f"not ({a} or {b})", "all"]
        rays = [answer["rays"]["matched"] for answer in ask(target, texts)]
        if rays[0] != rays[1] or sum(rays[2:6]) != rays[6] or rays[0] != rays[6] - rays[2]:
            fail(f"{target}: {a} and {b}: {rays}")


def check_lists(target, verdicts, n):
    """--limit and --sample against sorting all rays that match; the same for any ranks."""
    plain = verdicts.evaluator.map
    for k, text in enumerate(verdicts.texts[:n]):
        ids = [int(ray) for ray in plain.ray["id"][verdicts.evaluator.match(text)]]
        number, seed = verdicts.dice.one_of(1, 3, 40), verdicts.dice.one_of(1, 7, 2 ** 40)
        for options, want in ((["--limit", number], sorted(ids)[:number]),
                              (["--sample", number, "--seed", seed],
                               evaluator_sample.sample(ids, number, seed))):
            given = ["query", target, text, *verdicts.options, *options, "--json", "--quiet"]
            out = program(*given).stdout
            if [ray["ray"] for ray in json.loads(out)] != want:
                fail(f"{target}: {text} {options}: not rays {want}")
            if program(*given, "--threads", "3", ranks=2 + k % 3).stdout != out:
                fail(f"{target}: {text} {options}: {2 + k % 3} ranks say something else")


def check_part(name, target, verdicts, n):
    """A map of a query holds the rays of the query and no others; false: there is no such thing."""
    evaluator, part = verdicts.evaluator, f"{name}-part.raymap"
    for k in range(n):
        text, second = verdicts.texts[k], verdicts.texts[k + 1]
        done = program("query", target, text, *verdicts.options, "-o", part, "--force", "--quiet",
                       ranks=1 + k % 3, check=False)
        if done.returncode in (2, 3):
            return False
        if done.returncode != 0:
            fail(f"{target}: {text} -o {part}: status {done.returncode}: {done.stderr}")
            continue
        found = evaluator.match(text)
        wanted = [expected(evaluator.map, found), expected(evaluator.map, found & evaluator.match(second))]
        for want, answer in zip(wanted, ask(part, ["all", second], *verdicts.options)):
            if not agrees(want, answer):
                fail(f"{part} of {text}: {answer['criterion']}\n     the evaluator: {want}\n"
                     f"     the program: {answer['rays']} {answer['segments']} {answer['flux']}")
        some = ["--sample", 10 ** 6 if EVERYTHING else 300, "--json", "--quiet"]
        listed = program("query", part, "all", *some).stdout
        if listed != program("query", target, text, *verdicts.options, *some).stdout:
            fail(f"{part} of {text}: its rays are not those of {target}")
        program("verify", part, "--quiet")
    return True


class Verdicts:
    """Random criteria for a map, and what the evaluator finds there."""

    def __init__(self, name, target, n_criterion, seed):
        self.missing = set()
        plain = PlainMap(target)
        self.evaluator = Evaluator(plain)
        self.dice = evaluator_dice.Dice(plain, seed)
        with open(name + ".criteria", "w", encoding="utf-8") as file:
            file.write("\n".join(self.dice.let(self.evaluator) for _ in range(4)) + "\n")
        self.options = ["--criteria", name + ".criteria"]
        self.texts = [self.dice.criterion(self.evaluator) for _ in range(n_criterion)]
        self.texts += AT_PLACES if name == "odd" else []
        self.wanted = [expected(plain, self.evaluator.match(text)) for text in self.texts]
        some = sum(0 < want["rays"] < plain.n_ray for want in self.wanted)
        print(f"{name}: {plain.n_ray} rays, {len(plain.leg)} segments; {some} of {len(self.texts)} "
              f"criteria select some and not all", flush=True)

    def compare(self, target, *options, ranks=1):
        answers = ask(target, self.texts, *self.options, *options, ranks=ranks)
        self._judge(f"{target}, {ranks} ranks {' '.join(options)}", answers)

    def compare_session(self, target, *options, ranks=1):
        """Each question twice: the second time of what the first one left in memory."""
        out = program("session", target, *self.options, *options, "--quiet", ranks=ranks,
                      lines="".join(text + "\n" for text in 2 * self.texts)).stdout
        answers = [json.loads(line) for line in out.splitlines()]
        for half in (answers[:len(self.texts)], answers[len(self.texts):]):
            self._judge(f"session {target}, {ranks} ranks {' '.join(options)}", half)

    def _judge(self, where, answers):
        bad = abs(len(answers) - len(self.texts))
        if bad:
            fail(f"{where}: {len(answers)} answers to {len(self.texts)} questions")
        for text, want, answer in zip(self.texts, self.wanted, answers):
            if not agrees(want, answer):
                bad += 1
                fail(f"{where}: {text}\n     the evaluator: {want}\n"
                     f"     the program: {answer['rays']} {answer['segments']} {answer['flux']}")
        print(f"{where}: {len(self.texts)} criteria, {bad} disagree", flush=True)


def judge_scene_in(name, scene, n_ray, k, options):
    """All maps of a scene against the evaluator; what the program does not know yet."""
    plain = trace(scene, f"{name}.raymap", n_ray, "--encoding", "plain", *options)
    pieces = trace(scene, f"{name}-pieces.raymap", n_ray, "--piece-size", "1Mi", "--encoding",
                   ("plain", "compact")[k % 2], *options, ranks=2 + (k + 1) % 2)
    compact = trace(scene, f"{name}-compact.raymap", n_ray, "--encoding", "compact", *options)
    verdicts = Verdicts(name, plain, N_CRITERION // 3, SEED * 1000 + k)
    check_paths(name, verdicts, N_CRITERION // 10)
    maps = ((plain, 2 + k), (compact, 1), (pieces, 3 - k))
    for number, (target, ranks) in enumerate(maps):
        if EVERYTHING or number == k:
            verdicts.compare(target, "--threads", "3")
        if target == compact:
            kept = (("path_length", "angle(*)"), ("optical_path", "wavelength"), ("path_length", "time(*)"))[k]
            program("keep", target, "--quiet", *(word for one in kept for word in ("--of", one)))
            verdicts.compare(target, "--threads", "2")
        verdicts.compare(target, ranks=ranks)
        if EVERYTHING or number != k:
            verdicts.compare_session(target, *(("--memory", "1Mi") if number == 2 else ()))
    check_lists(plain, verdicts, max(1, N_CRITERION // 60))
    if not check_part(name, (pieces, plain, compact)[k], verdicts, max(1, N_CRITERION // 60)):
        verdicts.missing.add("query -o NEW.raymap")
    check_complements(plain, verdicts.dice, verdicts.evaluator, max(2, N_CRITERION // 60))
    return verdicts.missing


def main():
    pathlib.Path("box.obj").write_text(evaluator_scene.BOX, encoding="utf-8")
    pathlib.Path("odd.yaml").write_text(evaluator_scene.SCENE, encoding="utf-8")
    examples = SOURCE / "examples"
    scenes = [("odd", "odd.yaml", 9000), ("lens", examples / "double-gauss/scene.yaml", 5000, "--time", "on"),
              ("room", examples / "room/scene.yaml", 4200)]
    if EVERYTHING:  # weights that differ
        scenes.append(("fibre", examples / "wls-fibre/scene.yaml", 3000, "--time", "on", "--set", "media.core.accounting=energy"))
    missing = set()
    for k, (name, scene, n_ray, *options) in enumerate(scenes):
        missing |= judge_scene_in(name, scene, TIMES * n_ray, k % 3, options)
    for word in sorted(missing):
        print(f"skipped: the program does not know {word} yet")
    print(f"{failures} failures")
    sys.exit(1 if failures else 0)


main()
