# SPDX-License-Identifier: MIT
"""An evaluator of criteria for tests alone: straight from the definition of the language, row by
row over the columns of a plain map. It shares nothing with the program but the text.

    evaluator = Evaluator(PlainMap("lens.raymap"))
    evaluator.match("hit(lens) >= 2")       # a bool per ray, in the order of the map's view
"""
import functools
import operator
import re

import numpy as np

from evaluator_map import BIT, STOPS, glob
from evaluator_path import PathEvaluator

UNIONS = {
    "reflect": ("reflect_specular", "reflect_diffuse", "total_reflection"),
    "transmit": ("transmit_specular", "transmit_diffuse"),
    "specular": ("reflect_specular", "transmit_specular", "total_reflection"),
    "diffuse": ("reflect_diffuse", "transmit_diffuse"),
    "scatter": ("reflect_diffuse", "transmit_diffuse", "scatter_volume"),
}
MASK = dict(BIT, **{word: sum(BIT[m] for m in members) for word, members in UNIONS.items()})
LENGTH = {"pm": 1e-12, "nm": 1e-9, "um": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0, "km": 1e3,
          "in": 0.0254}
UNITS = {
    "angle": {"deg": 1.0, "rad": 180 / np.pi, "mrad": 0.18 / np.pi},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "ps": 1e-12, "fs": 1e-15},
    "W": {"kW": 1e3, "W": 1.0, "mW": 1e-3, "uW": 1e-6},
    "lm": {"klm": 1e3, "lm": 1.0, "mlm": 1e-3},
    "wavelength": {word: value / 1e-9 for word, value in LENGTH.items()},
    "photon_energy": {"eV": 1.0, "keV": 1e3, "MeV": 1e6, "GeV": 1e9, "J": 1 / 1.602176634e-19, "mJ": 1e-3 / 1.602176634e-19},
}
RELATIONS = {"==": operator.eq, "!=": operator.ne, "<": operator.lt, "<=": operator.le,
             ">": operator.gt, ">=": operator.ge}
TOKEN = re.compile(r"""\s*(?:
    (?P<number>[-+]?(?:\d+(?:\.(?!\.)\d*)?|\.\d+)(?:[eE][-+]?\d+)?) | (?P<quoted>'(?:[^']|'')*') |
    (?P<string>"[^"]*") | (?P<word>[A-Za-z_*?](?:[\w*?]|\.(?!\.))*) |
    (?P<sign>==|!=|<=|>=|&&|\|\||\.\.|[<>!&|(),@+-]) | (?P<end>$))""", re.VERBOSE)
OF_RAY = ("segments", "ray", "wavelength", "photon_energy", "flux", "path_length", "optical_path")
OF_REGISTRATION = ("angle", "x", "y", "time", "optical_path")


def tokens_of(text):
    at, found = 0, []
    while not found or found[-1][0] != "end":
        token = TOKEN.match(text, at)
        if not token:
            raise ValueError(f"the evaluator does not understand {text[at:]!r}")
        at = token.end()
        value = token.group(token.lastgroup)
        if token.lastgroup in ("quoted", "string"):
            value = value[1:-1].replace("''", "'") if token.lastgroup == "quoted" else value[1:-1]
        found.append((token.lastgroup, value))
    return found


def in_polygon(x, y, corners):
    """Even-odd rule."""
    inside = np.zeros(len(x), dtype=bool)
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1]):
        if y0 != y1:
            crosses = (y0 > y) != (y1 > y)
            inside ^= crosses & (x < x0 + (x1 - x0) * (y - y0) / (y1 - y0))
    return inside


class Evaluator:
    def __init__(self, plain_map):
        self.map = plain_map
        self.paths = PathEvaluator(plain_map, self.objects)
        self.names = {}  # let
        self.before = False  # reading what is behind a `where`
        self.tokens, self.at = [], 0

    def let(self, name, text):
        self.names[name] = self.match(text)

    def match(self, text):
        kept = self.tokens, self.at
        self.tokens, self.at = tokens_of(text), 0
        found = self._logic(self._test)
        if self._kind() != "end":
            raise ValueError(f"the evaluator does not understand the rest of {text!r}")
        self.tokens, self.at = kept
        return found

    # ------------------------------------------------------------------ reading

    def _kind(self):
        return self.tokens[self.at][0]

    def _is(self, *texts):
        return self._kind() in ("word", "sign") and self.tokens[self.at][1] in texts

    def _next(self):
        self.at += 1
        return self.tokens[self.at - 1][1]

    def _accept(self, *texts):
        if self._is(*texts):
            return self._next()
        return None

    def _expect(self, text):
        if not self._is(text):
            raise ValueError(f"the evaluator expects {text!r}, finds {self.tokens[self.at]}")
        self.at += 1

    def _logic(self, test):
        found = self._and(test)
        while self._accept("or", "||", "|"):
            found = self._and(test) | found
        return found

    def _and(self, test):
        found = self._not(test)
        while self._accept("and", "&&", "&"):
            found = self._not(test) & found
        return found

    def _not(self, test):
        if self._accept("not", "!"):
            return ~self._not(test)
        if self._accept("("):
            found = self._logic(test)
            self._expect(")")
            return found
        return test()

    def _number(self, units=None):
        """A number with its unit, if any: (value, factor or None)."""
        value = float(self._next())
        if units and self._is(*units) and not self._is("in") or units and self._inch(units):
            return value, units[self._next()]
        return value, None

    def _inch(self, units):
        """`in` behind a number is an inch unless a range follows."""
        return "in" in units and self._is("in") and self.tokens[self.at + 1][0] != "number"

    def _relation(self, units=None):
        """The comparison that stands here as a function of an array, or None."""
        word = self._accept("in", *RELATIONS)
        if word is None:
            return None
        value, unit = self._number(units)
        if word != "in":
            bound = value * (unit or 1.0)
            return lambda x: ~np.isnan(x) & RELATIONS[word](x, bound)
        self._expect("..")
        last, last_unit = self._number(units)
        least, most = value * (unit or last_unit or 1.0), last * (last_unit or 1.0)
        return lambda x: (x >= least) & (x <= most)

    # ------------------------------------------------------------------ names

    @functools.lru_cache(maxsize=None)
    def objects(self, pattern):
        """Objects meant by a name: themselves, or all below a group."""
        m = self.map
        group = [glob(pattern, name) for name in m.names["group"]]
        found = [glob(pattern, name) for name in m.names["object"]]
        for o, parent in enumerate(m.object_group):
            while parent >= 0:
                found[o] |= group[parent]
                parent = m.group_group[parent]
        return np.array(found + [False])  # the last: of row -1

    def _steps(self, word):
        """The steps that these numbers count."""
        m = self.map
        if word == "ghost_order":
            ghosts = m.makes_ghosts()[m.surface_met]
            return ghosts & (m.segment["event"] & MASK["reflect_specular"] != 0)
        if word == "scatter_order":
            return m.segment["event"] & MASK["scatter"] != 0
        return np.isin(m.letter, list("OFSIRTDd"))

    def _named(self, kind, pattern):
        return np.array([glob(pattern, name) for name in self.map.names[kind]] + [False])

    def _length(self):
        return {word: value / self.map.length_unit for word, value in LENGTH.items()}

    # ------------------------------------------------------------------ tests

    def _test(self):
        m = self.map
        if self._accept("@"):
            return self.names[self._next()].copy()
        if self._at_sum():
            return self._sum(self._of_ray)
        word = self._next()
        numbers = self._ray_numbers()
        if word in ("bounces", "ghost_order", "scatter_order"):
            return self._relation()(self._count(self._steps(word)).astype(float))
        if word == "path_length" and self._accept("("):
            media = self._named("medium", self._next())
            self._expect(")")
            return self._relation(self._length())(self._path_in(media))
        if word in numbers and not (word == "optical_path" and self._is("(")):
            return self._relation(self._ray_units(word))(numbers[word].astype(float))
        if word == "all":
            return self._counted(np.ones(m.n_ray, dtype=int))
        self._expect("(")
        found = getattr(self, "_test_" + word)()
        if found.dtype == bool:
            return found
        return self._counted(found)

    def _ray_numbers(self):
        m = self.map
        return {"segments": m.ray["segment_count"], "ray": m.ray["id"], "wavelength": m.ray["wavelength"],
                "photon_energy": 6.62607015e-34 * 299792458 / 1.602176634e-19 * 1e9 / m.ray["wavelength"], "flux": m.flux,
                "path_length": m.ray["path_length"], "optical_path": m.ray["optical_path"]}

    def _ray_units(self, word):
        return {"wavelength": UNITS["wavelength"], "photon_energy": UNITS["photon_energy"], "flux": UNITS[self.map.flux_unit],
                "path_length": self._length(), "optical_path": self._length()}.get(word)

    # ------------------------------------------------------------------ numbers compared with each other

    def _at_sum(self, words=(*OF_RAY, *OF_REGISTRATION)):
        """Whether the comparison here has more than one number in it, or a factor."""
        depth, shown = 0, []
        for kind, text in self.tokens[self.at:]:
            ends = kind == "end" or kind in ("word", "sign") and text in (")", "and", "or", "&&", "||", "&", "|")
            if depth == 0 and ends:
                break
            depth += (kind == "sign" and text == "(") - (kind == "sign" and text == ")")
            if depth == 0:
                shown.append((kind, text))
        if not shown or shown[0][1] not in words and shown[0][0] != "number":
            return False
        numbers = [text for kind, text in shown if kind == "word" and text in words]
        return len(numbers) > 1 or any(text in ("+", "-", "*") for kind, text in shown if kind != "quoted")

    def _sum(self, number):
        """number(): what stands here, as (least, greatest, units), an array each."""
        low, high, side, units, relation = 0.0, 0.0, 1.0, None, None
        sign = 1.0
        while True:
            factor = sign * side
            if self._kind() == "number" and self.tokens[self.at + 1][1] == "*":
                factor *= float(self._next())
                self._next()
            if self._kind() == "number":
                value, unit = self._number(units)
                low, high = (bound + factor * value * (unit or 1.0) for bound in (low, high))
            else:
                least, most, units = number()
                low = low + np.minimum(factor * least, factor * most)
                high = high + np.maximum(factor * least, factor * most)
            word = self._accept("+", "-")
            if word is None and self._kind() == "number":
                word = "+"  # it has a sign of its own
            sign = -1.0 if word == "-" else 1.0
            if word is None and relation is None:
                relation, side = self._next(), -1.0
            elif word is None:
                break
        return {"<": low < 0, "<=": low <= 0, ">": high > 0, ">=": high >= 0}[relation]

    def _of_ray(self):
        """A number of the ray, or those of its registrations on a detector."""
        m, word = self.map, self._next()
        if not self._accept("("):
            value = self._ray_numbers()[word].astype(float)
            return value, value, self._ray_units(word)
        pattern = self._next()
        self._expect(")")
        rows = self._named("detector", pattern)[m.registration["detector"]] & (m.registration["registered"] == 1)
        value, units = self._its_value(word, pattern)
        rows = rows & ~np.isnan(value)
        least, most = np.full(m.n_ray, np.inf), np.full(m.n_ray, -np.inf)
        np.minimum.at(least, m.ray_of_registration[rows], value[rows])
        np.maximum.at(most, m.ray_of_registration[rows], value[rows])
        none = least > most
        return np.where(none, np.nan, least), np.where(none, np.nan, most), units

    def _its_value(self, word, pattern):
        if word == "optical_path":
            return self.map.registration[word], self._length()
        return getattr(self.map, word), UNITS.get(word) or self._place_units(pattern)

    def _counted(self, count):
        relation = self._relation()
        return relation(count.astype(float)) if relation else count >= 1

    def _count(self, rows):
        """Of each ray; inside `where` of each registration: of the segments before its own."""
        if not self.before:
            return np.bincount(self.map.ray_of_segment[rows], minlength=self.map.n_ray)
        m, upto = self.map, np.append(0, np.cumsum(rows))
        first = m.first_segment[m.ray_of_registration]
        return upto[first + m.registration["segment"]] - upto[first]

    def _path_in(self, media):
        """Of each ray the length in the media, of curved segments what is left of its whole length."""
        m = self.map
        last = m.first_segment + m.ray["segment_count"] - 1
        counts = np.ones(len(m.segment["medium"]), dtype=bool)
        counts[last[m.ray["stop"] == STOPS.index("left")]] = False
        inside, curved = media[m.segment["medium"]], m.segment["event"] & BIT["gradient"] != 0

        def total(rows, weights=None):
            return np.bincount(m.ray_of_segment[rows], weights=None if weights is None else weights[rows], minlength=m.n_ray)
        straight = [total(counts & ~curved & (inside == side), m.length) for side in (False, True)]
        bent = [total(counts & curved & (inside == side)) for side in (False, True)]
        rest = np.where(bent[0] > 0, np.nan, m.ray["path_length"] - straight[0])
        return np.where(bent[1] > 0, rest, straight[1])

    def _test_source(self):
        wanted = self._named("source", self._next())
        self._expect(")")
        return wanted[self.map.ray["source"]].astype(int)

    def _event(self):
        return self.map.segment["event"] & MASK[self._next()] != 0

    def _more_events(self, rows):
        while self._accept(","):
            rows = rows & self._event()
        return self._count(self._step_end(rows))

    def _step_end(self, rows):
        """Those of the steps that keep within `where NUMBER COMPARISON and ...`, and the parenthesis."""
        if self._accept("where"):
            rows = rows & self._limit()
            while self._accept("and", "&&", "&"):
                rows = rows & self._limit()
        self._expect(")")
        return rows

    def _limit(self):
        known = self.map.step_numbers()

        def number():
            word = self._next()
            units = {"angle": UNITS["angle"], "step": None, "wavelength": UNITS["wavelength"]}.get(word, self._length())
            return known[word], known[word], units
        if self._at_sum(known):
            return self._sum(number)
        value, _, units = number()
        return self._relation(units)(value)

    def _whole_range(self):
        first = last = int(self._next())
        if self._accept(".."):
            last = int(self._next())
        return first, last

    def _test_hit(self):
        return self._count(self._hit_rows())

    def _asked(self):
        """Of each step: what may stand behind an object's name."""
        m, which = self.map, self.map.segment["object"]
        if self._accept("side"):
            return m.in_front if self._next() == "front" else ~m.in_front
        if not self._is("face", "triangle"):
            return self._event()
        word = self._next()
        first, last = self._whole_range()
        part = m.segment["primitive"].copy()
        if word == "face":
            part[which >= 0] = m.triangles_of_face(which[which >= 0], part[which >= 0])
        return (part >= first) & (part <= last)

    def _hit_rows(self):
        rows = self.objects(self._next())[self.map.segment["object"]]
        while self._accept(","):
            rows = rows & self._asked()
        return self._step_end(rows)

    def _test_event(self):
        return self._count(self._step_end(self._event()))

    def _test_medium(self):
        wanted = self._named("medium", self._next())
        return self._count(self._step_end(wanted[self.map.segment["medium"]]))

    def _test_surface(self):
        m, word = self.map, self._next()
        relation = self._relation()
        if relation:
            wanted = np.append(relation(m.surface_number(word)), False)
        else:
            wanted = self._named("surface", word)
        return self._more_events(wanted[m.surface_met])

    def _test_scatter(self):
        return self._count(self._step_end(self.map.scatters_by(self._next())))

    def _test_ended(self):
        m, stop = self.map, STOPS.index(self._next())
        found = m.ray["stop"] == stop
        if self._accept(","):
            place = self._next()
            last = m.first_segment + m.ray["segment_count"] - 1
            has_leg = m.ray["segment_count"] > 0
            last = np.where(has_leg, last, 0)
            which, medium = m.segment["object"][last], m.segment["medium"][last]
            inside = (which < 0) & self._named("medium", place)[medium]
            found = found & has_leg & (self.objects(place)[which] | inside)
        self._expect(")")
        return found.astype(int)

    def _test_path(self):
        found = self.paths.match(self._next())
        self._expect(")")
        return self._counted(found.astype(int))

    # ------------------------------------------------------------------ registrations

    def _test_registered(self, crossed=False):
        m, pattern = self.map, self._next()
        rows = self._named("detector", pattern)[m.registration["detector"]]
        if not crossed:
            rows = rows & (m.registration["registered"] == 1)
        while self._accept(","):
            rows = rows & self._region(pattern)
        if self._accept("where"):
            self.before = True
            rows = rows & self._logic(lambda: self._its_test(pattern))
            self.before = False
        self._expect(")")
        return np.bincount(m.ray_of_registration[rows], minlength=m.n_ray)

    def _test_crossed(self):
        return self._test_registered(crossed=True)

    def _place_units(self, pattern):
        which = np.flatnonzero(self._named("detector", pattern)[:-1])
        far = self.map.detector["type"][which] == 1
        return UNITS["angle"] if far.all() else self._length()

    def _its_number(self, word, pattern):
        value, units = self._its_value(word, pattern)
        return self._relation(units)(value)

    def _its_test(self, pattern):
        """Of one registration: its numbers, and tests of the steps before."""
        if self._at_sum():
            def its():
                value, units = self._its_value(self._next(), pattern)
                return value, value, units
            return self._sum(its)
        if self._is("bounces", "ghost_order", "scatter_order"):
            rows = self._steps(self._next())
            return self._relation()(self._count(rows).astype(float))
        if self._accept("after"):
            return self._after()
        if self._accept("at"):
            return self._at()
        if self._accept("path"):
            self._expect("(")
            found = self.paths.match_registrations(self._next())
            self._expect(")")
            return self._counted(found.astype(int))
        word = self._next()
        if word not in ("hit", "surface", "scatter", "event", "medium"):
            return self._its_number(word, pattern)
        self._expect("(")
        return self._counted(getattr(self, "_test_" + word)())

    def _after(self):
        """Whether hit(...) holds of the last object met before a registration."""
        m, which = self.map, self.map.segment["object"]
        self._expect("(")
        here = np.append(self._hit_rows(), False)
        met = np.maximum.accumulate(np.where(which >= 0, np.arange(len(which)), -1))
        first = m.first_segment[m.ray_of_registration]
        last = np.append(-1, met)[first + m.registration["segment"]]
        return self._counted(np.where(last >= first, here[last], False).astype(int))

    def _at(self):
        """Whether the step on which a registration lies is such a one."""
        m = self.map
        self._expect("(")
        if self._is("side", "face", "triangle", *MASK):
            rows = m.segment["object"] >= 0
            rows = rows & self._asked()
            while self._accept(","):
                rows = rows & self._asked()
            rows = self._step_end(rows)
        elif self._is("where"):
            rows = self._step_end(m.segment["object"] >= 0)
        else:
            rows = self._hit_rows()
        own = m.first_segment[m.ray_of_registration] + m.registration["segment"]
        which = m.registration["detector"]
        lies_on = (m.detector["on_object"][which] >= 0) | (m.detector["on_group"][which] >= 0)
        return self._counted((lies_on & np.append(rows, False)[own]).astype(int))

    def _any_registration(self, word):
        pattern = self._next()
        self._expect(")")
        m = self.map
        rows = self._named("detector", pattern)[m.registration["detector"]]
        rows = rows & (m.registration["registered"] == 1) & self._its_number(word, pattern)
        return np.bincount(m.ray_of_registration[rows], minlength=m.n_ray) > 0

    def _test_angle(self):
        return self._any_registration("angle")

    def _test_x(self):
        return self._any_registration("x")

    def _test_y(self):
        return self._any_registration("y")

    def _test_time(self):
        return self._any_registration("time")

    def _test_optical_path(self):
        return self._any_registration("optical_path")

    def _from_world(self, pattern, shape, values):
        """Places in the world in the frame of the one plane that is named; half-axes stay."""
        d, = np.flatnonzero(self._named("detector", pattern)[:-1])
        n_place = 2 if shape == "ellipse" else len(values)
        for i in range(n_place):
            axis = self.map.detector["xy"[i % 2]][d]
            along = np.abs(axis).argmax()
            values[i] = (values[i] - self.map.detector["origin"][d][along]) * axis[along]
        return values

    def _region(self, pattern):
        m, shape = self.map, self._next()
        self._expect("(")
        if shape == "cells":
            ranges = [self._whole_range()]
            self._expect(",")
            ranges.append(self._whole_range())
            self._expect(")")
            cell = m.registration["cell"]
            return np.logical_and.reduce([(cell[:, k] >= first) & (cell[:, k] <= last)
                                          for k, (first, last) in enumerate(ranges)])
        units, values, relative = self._place_units(pattern), [], False
        while not relative and self._kind() == "number":
            value, unit = self._number(UNITS["angle"] if shape == "ellipse" and len(values) == 4 else units)
            values.append(value * (unit or 1.0))
            if self._accept(","):
                relative = self._accept("rel") is not None
                world = not relative and self._accept("world") is not None
                if world:
                    values = self._from_world(pattern, shape, values)
                    break
        self._expect(")")
        x, y = (m.relative[:, 0], m.relative[:, 1]) if relative else (m.x, m.y)
        if shape == "rect":
            (x0, x1), (y0, y1) = sorted(values[0::2]), sorted(values[1::2])
            return (x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)
        if shape == "ellipse":
            cx, cy, rx, ry, *turn = values
            c, s = np.cos(np.radians(sum(turn))), np.sin(np.radians(sum(turn)))
            return (((x - cx) * c + (y - cy) * s) / rx) ** 2 + (((y - cy) * c - (x - cx) * s) / ry) ** 2 <= 1
        return in_polygon(x, y, list(zip(values[0::2], values[1::2])))
