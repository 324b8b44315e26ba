# SPDX-License-Identifier: MIT
"""Random criteria over a map's names and numbers, such that most of them match some rays and not
others: places and thresholds are those of rays that are there."""
import random
import re

import numpy as np

from evaluator import LENGTH, MASK
from evaluator_map import EVENTS, STOPS
from evaluator_path import FIRST

SURFACE_NUMBERS = ("reflectance", "reflect_specular", "reflect_diffuse", "transmit_specular",
                   "transmit_diffuse", "absorb")


class Dice:
    def __init__(self, plain_map, seed):
        self.map, self.random = plain_map, random.Random(seed)
        self.lets = {}  # name: text
        self.paths = None  # of the evaluator

    # ------------------------------------------------------------------ words

    def one_of(self, *choices):
        return self.random.choice(choices)

    def chance(self, probability):
        return self.random.random() < probability

    def row(self, column):
        """A row of a column that is there, or 0."""
        return self.random.randrange(len(column)) if len(column) else 0

    def blur(self, name):
        """A pattern that the name fits."""
        if self.chance(0.5):
            return name[:self.random.randrange(len(name))] + "*"
        at = self.random.randrange(len(name))
        return name[:at] + "?" + name[at + 1:]

    def write(self, name):
        """As a criterion may write it: in quotes where it must, and sometimes where it need not."""
        if re.fullmatch(r"[A-Za-z_*?][\w*?]*(\.[\w*?]+)*", name, re.ASCII) and self.chance(0.85):
            return name
        return "'" + name + "'"

    def name(self, kind, likely=None):
        names = self.map.names[kind]
        name = names[likely] if likely is not None and likely >= 0 and self.chance(0.7) \
            else self.random.choice(names)
        if kind == "object" and self.map.names["group"] and self.chance(0.2):
            name = self.random.choice(self.map.names["group"])
        if self.chance(0.2):
            name = self.blur(name)
        return name if not self.chance(0.04) else "*"

    def object(self):
        which = self.map.segment["object"]
        return self.name("object", which[self.row(which)])

    def event(self):
        column = self.map.segment["event"]
        bits = int(column[self.row(column)])
        words = [word for word in MASK if MASK[word] & bits]
        return self.random.choice(words) if self.chance(0.9) else self.random.choice(EVENTS)

    def value(self, number):
        return f"{number:.4g}" if self.chance(0.8) else f"{number:.3e}"

    def close_to(self, column):
        """A number among those of a column, on none of them."""
        known = column[~np.isnan(column)]
        if len(known) == 0:
            return 1.0
        return float(known[self.row(known)]) * self.random.uniform(0.7, 1.3)

    def comparison(self, column, units):
        """`< 3 mm`, `in 1..2 mm`: units {word: in the column's unit}; one is written or none."""
        unit = self.one_of("", *units)
        scale = units.get(unit, 1.0)
        a, b = (self.close_to(column) / scale for _ in range(2))
        blank = " " if unit else ""
        if self.chance(0.3):
            return f"in {self.value(min(a, b))}..{self.value(max(a, b))}{blank}{unit}"
        return f"{self.one_of('<', '<=', '>', '>=', '!=')} {self.value(a)}{blank}{unit}"

    def times(self, most=4):
        n = self.random.randrange(most + 1)
        if self.chance(0.25):
            return f" in {n}..{n + self.random.randrange(3)}"
        return f" {self.one_of('==', '!=', '<', '<=', '>', '>=')} {n}"

    # ------------------------------------------------------------------ tests

    def test_source(self):
        return f"source({self.write(self.name('source'))})"

    def test_hit(self):
        m, which, extra = self.map, self.object(), ""
        if self.chance(0.25):
            met = np.flatnonzero(m.is_mesh[m.segment["object"]] & (m.segment["object"] >= 0))
            row = self.random.choice(met) if len(met) else 0
            which = m.names["object"][m.segment["object"][row]]
            first = max(0, int(m.segment["primitive"][row]))  # no mesh is met: any
            word = self.one_of("face", "triangle")
            if word == "face" and len(met):
                first = int(m.faces[m.segment["object"][row]][first])
            last = first + self.random.randrange(40)
            extra = f", {word} {first}" + (f"..{last}" if self.chance(0.6) else "")
        if self.chance(0.5):
            extra += f", {self.event()}"
        return f"hit({self.write(which)}{extra}{self.limits()})" + (self.times() if self.chance(0.4) else "")

    def limits(self):
        """Behind what else is asked of a step."""
        if self.chance(0.75):
            return ""
        known = self.map.step_numbers()
        said = []
        if self.chance(0.3):
            words = self.one_of(("length", "path_length"), ("x", "y", "z"), ("world_x", "world_z", "path_length"))
            said.append(self.sum(lambda: (word := self.one_of(*words), known[word])))
        for word in self.random.sample(sorted(known), self.one_of(1, 1, 2) - len(said)):
            units = {"angle": {"deg": 1.0, "rad": 180 / np.pi}, "step": {"": 1.0}, "wavelength": {"nm": 1.0, "um": 1000.0}}.get(word, self.lengths())
            said.append(word + " " + self.comparison(known[word][np.isfinite(known[word])], units))
        return " where " + " and ".join(said)

    def test_event(self):
        return f"event({self.event()}{self.limits()})" + (self.times() if self.chance(0.5) else "")

    def test_medium(self):
        medium = self.map.segment["medium"]
        name = self.name("medium", medium[self.row(medium)])
        return f"medium({self.write(name)}{self.limits()})" + (self.times() if self.chance(0.5) else "")

    def test_surface(self):
        if self.chance(0.6):
            what = self.write(self.name("surface"))
        else:
            what = f"{self.one_of(*SURFACE_NUMBERS)} {self.one_of('<', '>', '<=', '>=')} " \
                   f"{self.random.uniform(0, 1):.3f}"
        extra = f", {self.event()}" if self.chance(0.5) else ""
        return f"surface({what}{extra}{self.limits()})" + (self.times(3) if self.chance(0.3) else "")

    def test_scatter(self):
        model = self.one_of("lambert", "lambert", "gaussian", "abg", "ggx", "harvey", "*")
        return f"scatter({model}{self.limits()})" + (self.times(3) if self.chance(0.4) else "")

    def test_ended(self):
        m = self.map
        ray = self.row(m.ray["id"])
        stop = STOPS[m.ray["stop"][ray]]
        if self.chance(0.5):
            return f"ended({stop if self.chance(0.9) else self.random.choice(STOPS)})"
        last = m.first_segment[ray] + m.ray["segment_count"][ray] - 1
        which = m.segment["object"][last]
        if which >= 0:
            return f"ended({stop}, {self.write(self.name('object', which))})"
        return f"ended({stop}, {self.write(self.name('medium', m.segment['medium'][last]))})"

    def test_number(self):
        m = self.map
        word = self.one_of("segments", "bounces", "ghost_order", "scatter_order", "wavelength", "flux",
                           "path_length", "path_in", "optical_path", "ray")
        if word == "path_in":
            medium = self.write(self.name("medium", self.row(m.names["medium"])))
            return f"path_length({medium}) " + self.comparison(m.length, {"": 1.0})
        if word in ("segments", "bounces", "ghost_order", "scatter_order"):
            return word + self.times(9)
        if word == "ray":
            first = self.row(m.ray["id"])
            return f"ray in {first}..{first + self.row(m.ray['id'])}" if self.chance(0.6) \
                else f"ray {self.one_of('<', '==', '>=', '!=')} {first}"
        if word == "flux":
            least = self.random.choice(m.source_flux / m.source_emitted) * self.one_of(0.5, 1.5)
            unit = self.one_of("", "m", "k")
            scale = {"": 1, "m": 1e-3, "k": 1e3}[unit]
            return f"flux {self.one_of('<', '>')} {least / scale:.6g}" + \
                (f" {unit}{m.flux_unit}" if unit else "")
        if word == "wavelength":
            known = m.ray["wavelength"][~np.isnan(m.ray["wavelength"])]
            if len(known) and self.chance(0.5):  # the stored number itself
                exact = known[self.row(known)]
                return f"wavelength {self.one_of('==', '!=', '<', '<=', '>', '>=')} {exact!r}"
            return "wavelength " + self.comparison(m.ray["wavelength"], {"um": 1e3, "nm": 1.0})
        column = m.ray[word]
        if self.chance(0.2):  # the stored number itself
            return f"{word} {self.one_of('<', '<=', '>', '>=', '==')} " \
                   f"{float(column[self.row(column)])!r}"
        return f"{word} " + self.comparison(column, self.lengths())

    def lengths(self):
        return {word: LENGTH[word] / self.map.length_unit for word in ("mm", "cm", "m", "in")}

    # ------------------------------------------------------------------ registrations

    def detector(self):
        """A detector, the rows of its registrations, and the units of its places."""
        m = self.map
        which = self.random.randrange(len(m.names["detector"]))
        rows = np.flatnonzero(m.registration["detector"] == which)
        units = {"deg": 1.0, "rad": 180 / np.pi} if m.detector["type"][which] == 1 \
            else self.lengths()
        name = m.names["detector"][which]
        return self.write(name if self.chance(0.9) else name[:-1] + "?"), rows, units

    def its_number(self, rows, units, of=""):
        m, word = self.map, self.one_of("angle", "x", "y", "time", "optical_path")
        if word == "optical_path":
            column = m.registration[word][rows]
            return f"{word}{of} " + self.comparison(column, self.lengths())
        known = {"angle": {"deg": 1.0, "mrad": 0.18 / np.pi}, "time": {"ns": 1e-9, "ps": 1e-12}}
        return f"{word}{of} " + self.comparison(getattr(m, word)[rows], known.get(word, units))

    def sum(self, number):
        """Two or three numbers of the same kind compared with each other; number(): one of them, with its values."""
        left, near = number()
        right, far = number()
        factor, sign = self.random.uniform(0.5, 2), self.one_of("<", "<=", ">", ">=")
        known, other = near[~np.isnan(near)], far[~np.isnan(far)]
        value = float(known[self.row(known)]) if len(known) else 1.0
        value -= factor * (float(other[self.row(other)]) if len(other) else 1.0)
        return self.one_of(f"{left} {sign} {right}", f"{left} - {factor!r} * {right} {sign} {value:.5g}",
                           f"{left} {sign} {factor!r} * {right} + {value:.5g}", f"{factor!r} * {right} {sign} {left} - {value:.5g}")

    def test_sum(self):
        """Of lengths, of the ray and of its registrations, or of times."""
        m = self.map
        of_time = self.chance(0.2)

        def number():
            name, rows, units = self.detector()
            if of_time:
                return f"time({name})", m.time[rows]
            word = self.one_of("path_length", "optical_path", "x", "y", "optical_path(")
            if word in ("path_length", "optical_path"):
                return word, m.ray[word].astype(float)
            if word == "optical_path(" or "deg" in units or "?" in name:
                return f"optical_path({name})", m.registration["optical_path"][rows]
            return f"{word}({name})", getattr(m, word)[rows]
        return self.sum(number)

    def test_any(self):
        name, rows, units = self.detector()
        return self.its_number(rows, units, f"({name})")

    def region(self, rows, units):
        m = self.map
        shape = self.one_of("rect", "ellipse", "polygon", "cells")
        if len(rows) == 0:
            return "rect(0, 0, 1, 1)"
        if shape == "cells":
            i, j = m.registration["cell"][self.random.choice(list(rows))]
            first = max(0, int(i) - self.random.randrange(30))
            return f"cells({first}..{int(i) + self.random.randrange(40)}, " \
                   f"{max(0, int(j) - 20)}..{int(j) + self.random.randrange(40)})"
        relative = self.chance(0.4)
        x, y = (m.relative[rows, 0], m.relative[rows, 1]) if relative else (m.x[rows], m.y[rows])
        unit = "" if relative else self.one_of("", *units)
        scale, tail = units.get(unit, 1.0), ", rel" if relative else ""
        unit = " " + unit if unit else ""

        def place():
            k = self.row(x)
            return x[k] / scale + self.random.gauss(0, 0.1 * np.ptp(x) / scale), \
                y[k] / scale + self.random.gauss(0, 0.1 * np.ptp(y) / scale)

        if shape == "rect":
            numbers = [*place(), *place()]
        elif shape == "ellipse":
            numbers = [*place(), self.random.uniform(0.05, 0.6) * np.ptp(x) / scale + 1e-3,
                       self.random.uniform(0.05, 0.6) * np.ptp(y) / scale + 1e-3]
            if not relative and self.chance(0.5):
                tail = f", {self.random.uniform(-200, 200):.4g}" + self.one_of("", " deg")
        else:
            numbers = [v for _ in range(self.random.randrange(3, 7)) for v in place()]
        return f"{shape}({', '.join(f'{v:.5g}{unit}' for v in numbers)}{tail})"

    def where(self, rows, units, depth=0):
        if depth < 2 and self.chance(0.4):
            return f"({self.where(rows, units, depth + 1)} {self.one_of('and', 'or')} " \
                   f"{self.where(rows, units, depth + 1)})"
        if self.chance(0.15) and "deg" not in units:
            return self.sum(lambda: self.its_length(rows))
        text = self.its_step(rows) if self.chance(0.4) else self.its_number(rows, units)
        return ("not " if self.chance(0.2) else "") + text

    def its_length(self, rows):
        word = self.one_of("x", "y", "optical_path")
        return word, (self.map.registration[word] if word == "optical_path" else getattr(self.map, word))[rows]

    def at(self, row):
        """Of the step on which a registration lies."""
        m = self.map
        step = m.first_segment[m.ray_of_registration[row]] + m.registration["segment"][row]
        which = m.segment["object"][step]
        words = [word for word in MASK if MASK[word] & int(m.segment["event"][step])]
        asked = []
        if self.chance(0.4):
            asked.append(self.write(self.name("object", which)))
        if self.chance(0.7):
            asked.append(self.random.choice(words))
        if self.chance(0.3) and m.is_mesh[which] and (not asked or asked[0] in words):
            triangle = int(m.segment["primitive"][step])
            asked.append(self.one_of(f"triangle 0..{triangle}", f"face {m.faces[which][triangle]}"))
        limits = self.limits()
        if self.chance(0.3) or not asked and not limits:
            asked.append("side " + self.one_of("front", "back"))
        return f"at({(', '.join(asked) + limits).lstrip()})"

    def its_step(self, rows):
        """Of the steps before a registration, or its own."""
        m, roll, row = self.map, self.random.random(), rows[self.row(rows)] if len(rows) else -1
        if row >= 0 and roll < 0.15:
            return f'path("{self.path(self.paths, self.paths.upto[row])}")'
        which = m.registration["detector"][row] if row >= 0 else -1
        if row >= 0 and roll < 0.6 and max(m.detector["on_object"][which],
                                           m.detector["on_group"][which]) >= 0:
            return self.at(row)
        if roll < 0.3:
            return self.one_of("bounces", "ghost_order", "scatter_order") + self.times(3)
        if roll < 0.5:
            event = f", {self.event()}" if self.chance(0.5) else ""
            return f"after({self.write(self.object())}{event}{self.limits()})"
        return getattr(self, "test_" + self.one_of("hit", "event", "medium", "surface", "scatter"))()

    def test_registered(self):
        name, rows, units = self.detector()
        text = f"{self.one_of('registered', 'registered', 'crossed')}({name}"
        if self.chance(0.5):
            text += f", {self.region(rows, units)}"
        if self.chance(0.5):
            text += f" where {self.where(rows, units)}"
        return text + ")" + (self.times(3) if self.chance(0.3) else "")

    # ------------------------------------------------------------------ sequences

    def path_name(self, kind):
        letter, which, medium, detector = kind
        if letter == "V":
            name = self.name("detector", detector)
        elif which >= 0:
            name = self.name("object", which)
        elif letter in "AS":
            name = self.name("medium", medium)
        else:
            return ""
        if re.fullmatch(r"[A-Za-z_]\w*(\.\w+)*", name, re.ASCII) and self.chance(0.9):
            return f"@{name} "  # letters and dots behind it would belong to the name
        return f"@'{name}'"

    def path_step(self, kind):
        letter = kind[0]
        roll = self.random.random()
        others = [c for c in "TRIDdSAXKVFOE" if c != letter]
        if roll < 0.2:
            letter = "."
        elif roll < 0.35:
            letter = f"[{letter}{''.join(self.random.sample('TRDIdX', 2))}]"
            return letter  # a name would have to be one of each kind
        elif roll < 0.45:
            return f"[^{''.join(self.random.sample(others, 2))}]"
        if letter == "." and self.chance(0.7) or self.chance(0.3):
            return letter
        return letter + self.path_name(kind)

    def path(self, paths, history=None):
        """A history that is there, with steps made more general, repeated, optional or skipped."""
        if history is None:
            history = paths.histories[paths.history_of_ray[self.row(self.map.ray["id"])]]
        steps = [paths.kinds[ord(c) - FIRST] for c in history]
        out, at, vague = [], 0, 0
        while at < len(steps):
            roll = self.random.random()
            vague += roll < 0.42  # too many of these are too complex, says the program
            roll = max(roll, 0.42) if vague > 3 else roll
            n = self.random.randrange(1, 5)
            if roll < 0.25:
                out.append(self.one_of(".*", ".+", "[^E]*", ".{%d}" % n, ".{%d,%d}" % (n, n + 2)))
                at += n
            elif roll < 0.35:
                out.append(f"({self.path_step(steps[at])}|{self.path_step(steps[-1])})" +
                           self.one_of("", "+", "{1,3}"))
                at += 1
            elif roll < 0.42:
                out.append(f"({''.join(self.path_step(s) for s in steps[at:at + 2])})" +
                           self.one_of("*", "+", "{0,2}", "?"))
                at += 2
            else:
                out.append(self.path_step(steps[at]) + self.one_of("", "", "", "", "?", "+", "*"))
                at += 1
            if self.chance(0.06):
                out.append(".*")
                break
        text = self.one_of("", " ").join(out)
        if self.chance(0.5):
            text = re.sub(r"('[^']*')| (?=[*+?{|)\[(])", lambda found: found[1] or "", text)
        return text

    # ------------------------------------------------------------------ logic

    def test(self, evaluator):
        kinds = ["source", "hit", "hit", "hit", "event", "medium", "surface", "scatter", "ended", "number",
                 "number", "registered", "registered", "any", "sum", "path", "path"]
        kind = self.random.choice(kinds)
        self.paths = evaluator.paths
        if self.paths.kinds is None:
            self.paths.match(".")
        if kind == "path":
            return f'path("{self.path(evaluator.paths)}")'
        if kind in ("registered", "any", "sum") and not self.map.names["detector"]:
            kind = "hit"
        return getattr(self, "test_" + kind)()

    def criterion(self, evaluator, depth=0):
        roll = self.random.random()
        if self.lets and roll > 0.93:
            return "@" + self.random.choice(list(self.lets))
        if depth > 3 or roll < 0.3:
            return self.test(evaluator)
        if roll < 0.42:
            return self.one_of("not ", "!") + f"({self.criterion(evaluator, depth + 1)})"
        if roll < 0.5:
            return "not " + self.test(evaluator)
        sign = self.one_of("and", "and", "or", "or", "&", "|", "&&", "||")
        parts = [self.criterion(evaluator, depth + 1) for _ in range(self.one_of(2, 2, 3))]
        text = f" {sign} ".join(parts)
        return f"({text})" if depth and self.chance(0.6) else text

    def let(self, evaluator):
        """A new name for a criterion."""
        name = self.one_of("ghost", "stray", "direct", "_2nd") + str(len(self.lets))
        text = self.criterion(evaluator, depth=2)
        self.lets[name] = text
        evaluator.let(name, text)
        return f"let {name} = {text}"
