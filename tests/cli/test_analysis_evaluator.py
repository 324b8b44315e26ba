#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A referee: what `raymap stats`, `detector`, `report --energy` and `paths` say of random criteria over
an odd scene and the lens, against numpy from the columns of a plain map. The formulas are those of
docs/statistics.md and its neighbours, written down again; criteria are evaluated by evaluator.py.

RAYMAP_JUDGE says how many criteria per scene (4), RAYMAP_JUDGE_SEED which (1).
"""
import csv
import json
import math
import os
import pathlib
import subprocess
import sys
from collections import defaultdict

sys.dont_write_bytecode = True

import numpy as np

import evaluator_dice
import evaluator_scene
from evaluator import Evaluator
from evaluator_map import STOPS, PlainMap

PROGRAM, SOURCE = os.environ["RAYMAP"], pathlib.Path(os.environ["SOURCE_DIR"])
N_CRITERION = int(os.environ.get("RAYMAP_JUDGE", "4"))
SEED = int(os.environ.get("RAYMAP_JUDGE_SEED", "1"))
failures = 0


def fail(text):
    global failures
    failures += 1
    if failures < 40:
        print("FAIL " + text, flush=True)


def program(*arguments):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          check=False)
    if done.returncode != 0:
        sys.exit(f"{arguments}: status {done.returncode}\n{done.stderr}")
    return done.stdout


def near(got, want, tolerance=1e-9, scale=0.0):
    if got is None or want is None or not math.isfinite(want):
        return got is None and (want is None or not math.isfinite(want))
    return abs(got - want) <= tolerance * max(abs(want), scale) + 1e-300


class Referee:
    """One map; `found`: which of its rays a criterion selects."""

    def __init__(self, plain):
        self.map = plain
        self.unit = np.divide(plain.source_flux, plain.source_emitted,
                              out=np.zeros(len(plain.source_flux)), where=plain.source_emitted > 0)
        self.of_source = [np.flatnonzero(plain.ray["source"] == s)
                          for s in range(len(plain.source_flux))]

    def error(self, a):
        """Standard error of the sum of a, flux of each ray of the map, 0 for most of them."""
        variance = 0.0
        for rows, n in zip(self.of_source, self.map.source_emitted):
            some = a[rows]
            if n > 1:
                variance += n / (n - 1) * ((some ** 2).sum() - some.sum() ** 2 / n)
        return math.sqrt(max(variance, 0.0))

    def estimate(self, rows, q=1.0):
        """Flux and error of rows (of rays, with repetitions), each counted as q."""
        a = np.bincount(rows, weights=np.broadcast_to(q, len(rows)) * self.map.flux[rows],
                        minlength=self.map.n_ray)
        return a.sum(), self.error(a)

    def expect(self, what, got, rows, q=1.0):
        """A JSON pair against the estimate; an error of rounding is none."""
        flux, error = self.estimate(rows, q)
        whole = self.map.source_flux.sum()
        value = got["flux"] if "flux" in got else got["value"]
        if not near(value, flux, 1e-9, 1e-3 * whole) or \
                not near(got["standard_error"], error, 1e-6, 1e-3 * whole):
            fail(f"{what}: {value} +- {got['standard_error']}, not {flux} +- {error}")

    # -------------------------------------------------------------- statistics

    def readings(self, word, found):
        """(rows of rays, values) of a number."""
        plain = self.map
        if "(" in word:
            name, detector = word[:-1].split("(", 1)
            which = plain.names["detector"].index(detector.strip("'"))
            on = (plain.registration["detector"] == which) & \
                (plain.registration["registered"] == 1) & found[plain.ray_of_registration]
            return plain.ray_of_registration[on], getattr(plain, name)[on]
        rows = np.flatnonzero(found)
        if word == "segments":
            return rows, plain.ray["segment_count"][rows].astype(float)
        if word == "bounces":
            bounce = np.isin(plain.letter, list("OFSIRTDd"))
            count = np.bincount(plain.ray_of_segment[bounce], minlength=plain.n_ray)
            return rows, count[rows].astype(float)
        if word == "flux":
            return rows, plain.flux[rows]
        return rows, plain.ray[word][rows].astype(float)

    def summary(self, rows, x):
        """{name: (value, error)}: moments weighted by flux, errors by the delta method."""
        w = self.map.flux[rows]
        mean = (w * x).sum() / w.sum()
        d = x - mean
        m = {k: (w * d ** k).sum() / w.sum() for k in (2, 3, 4)}
        influence = {"mean": (mean, d)}
        if m[2] > 1e-24 * max(mean * mean, 1e-300):
            root, skew, kurt = math.sqrt(m[2]), m[3] / m[2] ** 1.5, m[4] / m[2] ** 2
            influence["standard_deviation"] = (root, (d ** 2 - m[2]) / (2 * root))
            influence["skewness"] = (skew, (d ** 3 - m[3] - 3 * m[2] * d) / m[2] ** 1.5
                                     - 1.5 * skew * (d ** 2 - m[2]) / m[2])
            influence["kurtosis"] = (kurt, (d ** 4 - m[4] - 4 * m[3] * d) / m[2] ** 2
                                     - 2 * kurt * (d ** 2 - m[2]) / m[2])
        return {name: (value, self.error(np.bincount(rows, weights=w * part / w.sum(),
                                                     minlength=self.map.n_ray)))
                for name, (value, part) in influence.items()}

    def stats(self, target, text, found, word, bins):
        where = f"{target}: stats --of {word} --where {text}: "
        said = json.loads(program("stats", target, "--where", text, "--of", word, "--bins", bins,
                                  "--json", "--quiet"))
        rows, x = self.readings(word, found)
        if (said["rays"]["matched"], said["values"]) != (found.sum(), len(rows)):
            fail(f"{where}{said['rays']} {said['values']}: not {found.sum()} {len(rows)}")
            return
        if len(rows) == 0:
            return
        self.expect(where + "flux", said["flux"], rows)
        for name, (value, error) in self.summary(rows, x).items():
            scale = np.abs(x).max() if name in ("mean", "standard_deviation") else 1.0
            if not near(said[name]["value"], value, 1e-7, scale) or \
                    not near(said[name]["standard_error"], error, 1e-5, 1e-6 * scale):
                fail(f"{where}{name}: {said[name]}, not {value} +- {error}")
        if not near(said["min"], x.min(), 1e-11) or not near(said["max"], x.max(), 1e-11):
            fail(f"{where}from {said['min']} to {said['max']}, not {x.min()} to {x.max()}")
        order = np.argsort(x, kind="stable")
        share = np.cumsum(self.map.flux[rows][order]) / self.map.flux[rows].sum()
        for quantile in said["quantiles"]:
            near_by = {x[order][min(np.searchsorted(share, quantile["p"] + e), len(x) - 1)]
                       for e in (-1e-12, 0, 1e-12)}  # on a step rounding decides
            if not any(near(quantile["value"], value, 1e-12) for value in near_by):
                fail(f"{where}quantile {quantile}, not one of {near_by}")
        edges = np.array(said["histogram"]["edges"])
        slack = 1e-12 * np.abs(edges).max()  # the last digit of an angle is anybody's
        for edge in edges:
            x = np.where(np.abs(x - edge) < slack, edge, x)
        cell = np.clip(np.searchsorted(edges, x, "right") - 1, 0, len(edges) - 2)
        inside = (x >= edges[0]) & (x <= edges[-1])
        for b in range(len(edges) - 1):
            some = rows[inside & (cell == b)]
            self.expect(f"{where}bin {b}", {
                "value": said["histogram"]["flux"][b],
                "standard_error": said["histogram"]["standard_error"][b]}, some)
            if said["histogram"]["rays"][b] != len(np.unique(some)):
                fail(f"{where}bin {b}: {said['histogram']['rays'][b]} rays, not {len(set(some))}")

    # ---------------------------------------------------------------- detector

    def detector(self, target, text, found, which):
        name = self.map.names["detector"][which]
        where = f"{target}: detector {name} --where {text}: "
        program("detector", target, name, "--where", text, "-o", "evaluator.csv", "--force", "--quiet")
        with open("evaluator.csv", encoding="utf-8") as file:
            said = list(csv.DictReader(line for line in file if not line.startswith("#")))
        on = (self.map.registration["detector"] == which) & \
            (self.map.registration["registered"] == 1) & found[self.map.ray_of_registration]
        rows, cell = self.map.ray_of_registration[on], self.map.registration["cell"][on].astype(int)
        nx, ny = (int(n) for n in self.map.detector["cells"][which])
        order = np.argsort(cell[:, 0] + nx * cell[:, 1], kind="stable")
        first = np.searchsorted((cell[:, 0] + nx * cell[:, 1])[order], np.arange(nx * ny + 1))
        far = self.map.detector["type"][which] == 1
        size = self.map.detector["size"][which] * self.map.length_unit
        if len(said) != nx * ny:
            fail(f"{where}{len(said)} cells")
            return
        for k in range(nx * ny):
            i = k % nx
            extent = size[0] / nx * size[1] / ny if not far else 2 * math.pi / ny * (
                math.cos(math.pi * i / nx) - math.cos(math.pi * (i + 1) / nx))
            some = rows[order[first[k]:first[k + 1]]]
            flux, error = self.estimate(some) if len(some) else (0.0, 0.0)
            got = {key: float(said[k][key] or "nan") for key in ("value", "standard_error", "rays")}
            if got["rays"] != len(some) or not near(got["value"], flux / extent, 1e-9) or \
                    not near(got["standard_error"], error / extent, 1e-6):
                fail(f"{where}cell {k}: {got}, not {flux / extent} +- {error / extent}, {len(some)}")
                return

    # ------------------------------------------------------------------ energy

    def energy(self, target, text, found):
        where = f"{target}: energy of {text}: "
        said = json.loads(program("report", target, "--energy", "--where", text, "--json",
                                  "--quiet"))
        plain = self.map
        last = plain.first_segment + plain.ray["segment_count"] - 1
        for table, source in [(said["total"], None)] + [
                (table, plain.names["source"].index(table["source"])) for table in said["sources"]]:
            mine = found if source is None else found & (plain.ray["source"] == source)
            if table["emitted"] != mine.sum():
                fail(f"{where}{table['source']}: {table['emitted']} rays, not {mine.sum()}")
            seen = 0
            for stop, word in enumerate(STOPS):
                ended = np.flatnonzero(mine & (plain.ray["stop"] == stop))
                if word != "absorbed":
                    rows = [(table[word], ended)] if table[word] else []
                else:
                    object_met = plain.segment["object"][last[ended]]
                    medium = plain.segment["medium"][last[ended]]
                    rows = [(row, ended[object_met == plain.names["object"].index(row["name"])])
                            for row in table["absorbed"]["objects"]] + \
                        [(row, ended[(object_met < 0) &
                                     (medium == plain.names["medium"].index(row["name"]))])
                         for row in table["absorbed"]["media"]]
                for row, rays in rows:
                    seen += row["rays"]
                    if row["rays"] != len(rays):
                        fail(f"{where}{row}: not {len(rays)} rays")
                    self.expect(f"{where}{word} {row.get('name')}", row, rays)
            if seen != mine.sum():
                fail(f"{where}{table['source']}: {seen} of {mine.sum()} rays are accounted for")
            for row in table["detectors"]:
                on = (plain.registration["detector"] == plain.names["detector"].index(row["name"])) \
                    & (plain.registration["registered"] == 1) & mine[plain.ray_of_registration]
                self.expect(f"{where}{row['name']}", row, plain.ray_of_registration[on])
                if row["registrations"] != on.sum():
                    fail(f"{where}{row}: not {on.sum()} registrations")

    # ------------------------------------------------------------------- paths

    def classes(self, found):
        """Rays by source, steps and registrations."""
        plain, groups = self.map, defaultdict(list)
        end = np.cumsum(plain.ray["registration_count"], dtype=int)
        for row in np.flatnonzero(found):
            first, n = plain.first_segment[row], plain.ray["segment_count"][row]
            objects = plain.segment["object"][first:first + n]
            media = np.where(objects < 0, plain.segment["medium"][first:first + n], -1)
            letters = plain.letter[first:first + n]
            media[(objects < 0) & ~np.isin(letters, ["A", "S"])] = -1
            at = slice(end[row] - plain.ray["registration_count"][row], end[row])
            on = plain.registration["registered"][at] == 1
            key = (int(plain.ray["source"][row]), tuple(objects), tuple(media), tuple(letters),
                   tuple(plain.registration["segment"][at][on]),
                   tuple(plain.registration["detector"][at][on]))
            groups[key].append(int(row))
        return groups

    def paths(self, target, text, found, evaluator):
        where = f"{target}: paths --where {text}: "
        said = json.loads(program("paths", target, "--where", text, "--top", 12, "--json",
                                  "--quiet"))
        groups, rest = self.classes(found), said["remainder"]
        if len(said["classes"]) + rest["classes"] != len(groups) or \
                said["rays"]["matched"] != found.sum():
            fail(f"{where}{len(said['classes'])} + {rest['classes']} classes of "
                 f"{said['rays']['matched']} rays, not {len(groups)} of {found.sum()}")
        by_first = {int(self.map.ray["id"][rows].min()): rows for rows in groups.values()}
        total = self.map.flux[found].sum()
        for one in said["classes"]:
            if one["first_ray"] not in by_first:
                fail(f"{where}ray {one['first_ray']} is the first of no class")
                continue
            rows = np.array(by_first[one["first_ray"]])
            if one["rays"] != len(rows) or \
                    one["segments"] != self.map.ray["segment_count"][rows].sum():
                fail(f"{where}{one}: not {len(rows)} rays")
            self.expect(where + one["sequence"], one, rows)
            if not near(one["share"], self.map.flux[rows].sum() / total, 1e-9):
                fail(f"{where}{one['sequence']}: share {one['share']}")
            if one["criterion"] and not (np.flatnonzero(evaluator.match(one["criterion"]) & found)
                                         == rows).all():
                fail(f"{where}the criterion selects others: {one['criterion']}")
        got = sum(one["flux"] for one in said["classes"]) + rest["flux"]
        if not near(got, total, 1e-9, 1e-9):
            fail(f"{where}classes and remainder add up to {got}, not {total}")
        flux = [one["flux"] for one in said["classes"]]
        if flux != sorted(flux, reverse=True):
            fail(f"{where}not in the order of flux")


def main():
    pathlib.Path("box.obj").write_text(evaluator_scene.BOX, encoding="utf-8")
    pathlib.Path("odd.yaml").write_text(evaluator_scene.SCENE, encoding="utf-8")
    known = program("--help")
    scenes = (("odd", "odd.yaml", 5000),
              ("lens", SOURCE / "examples" / "double-gauss" / "scene.yaml", 5000))
    for k, (name, scene, n_ray) in enumerate(scenes):
        target = f"{name}.raymap"
        program("trace", scene, "-o", target, "-n", n_ray, "--quiet", "--force", "--encoding",
                "plain", "--seed", SEED)
        plain = PlainMap(target)
        evaluator, dice = Evaluator(plain), evaluator_dice.Dice(plain, 1000 * SEED + k)
        referee = Referee(plain)
        compact = f"{name}-compact.raymap"
        program("convert", target, "-o", compact, "--encoding", "compact", "--quiet", "--force")
        words = ["segments", "bounces", "path_length", "optical_path", "flux"]
        detectors = [d for d in range(len(plain.names["detector"]))
                     if (plain.registration["detector"] == d).any()]
        for n in range(N_CRITERION):
            text = "all" if n == 0 else dice.criterion(evaluator)
            found = evaluator.match(text)
            which = dice.one_of(*detectors)
            its = dice.one_of("x", "y", "angle", "time") + \
                f"({dice.write(plain.names['detector'][which])})"
            asked = (target, compact)[n % 2]
            print(f"{asked}: {found.sum()} of {plain.n_ray} rays: {text}", flush=True)
            referee.stats(asked, text, found, dice.one_of(*words), dice.one_of(1, 7, 30))
            referee.stats(asked, text, found, its, 11)
            referee.detector(asked, text, found, which)
            referee.energy(asked, text, found)
            if " paths " in known:
                referee.paths(asked, text, found, evaluator)
    print(f"{failures} failures")
    sys.exit(failures > 0)


main()
