# SPDX-License-Identifier: MIT
"""path("..."): every kind of step or registration that a map has becomes a character, every ray a
string, every step of the pattern a class of characters. An automaton of its own matches them;
Python's regular expressions, which may take for ever on long histories, evaluator it on short ones."""
import re

import numpy as np

from evaluator_map import glob

FIRST = 0x4E00  # character of the first kind
STEP_LETTERS = "TRIDdSFOAXKE"
NAME = re.compile(r"\s*@\s*(?:'((?:[^']|'')*)'|([A-Za-z_]\w*(?:\.\w+)*))")
TIMES = re.compile(r"\s*(\*|\+|\?|\{\s*\d+\s*(?:,\s*\d+\s*)?\})")


def as_expression(tree):
    """Of Python's re."""
    if tree[0] == "one":
        return f"[{tree[1]}]" if tree[1] else "(?!)"
    if tree[0] == "times":
        most = "" if tree[3] is None else tree[3]
        return f"(?:{as_expression(tree[1])}){{{tree[2]},{most}}}"
    parts = [as_expression(part) for part in tree[1]]
    return "".join(parts) if tree[0] == "all" else f"(?:{'|'.join(parts)})"


class Automaton:
    """Sets of states, each set made when a history first leads there."""

    def __init__(self, tree):
        self.free, self.by = [], []  # of each state: next ones without, and (characters, next)
        self.end = self._state()
        self.start = self._leading_to(tree, self.end)
        self.sets = {}
        self.first = self._closed({self.start})

    def _state(self):
        self.free.append([])
        self.by.append(None)
        return len(self.free) - 1

    def _leading_to(self, tree, end):
        """A state from which what the tree describes leads to `end`."""
        if tree[0] == "one":
            state = self._state()
            self.by[state] = (set(tree[1]), end)
            return state
        if tree[0] == "all":
            for part in reversed(tree[1]):
                end = self._leading_to(part, end)
            return end
        state = self._state()
        if tree[0] == "any":
            self.free[state] = [self._leading_to(part, end) for part in tree[1]]
            return state
        _, part, least, most = tree
        if most is None:
            self.free[state] = [end, self._leading_to(part, state)]
        else:
            next_one = end
            for _ in range(most - least):
                state = self._state()
                self.free[state] = [end, self._leading_to(part, next_one)]
                next_one = state
            state = next_one
        for _ in range(least):
            state = self._leading_to(part, state)
        return state

    def _closed(self, states):
        todo, found = list(states), set()
        while todo:
            state = todo.pop()
            if state not in found:
                found.add(state)
                todo += self.free[state]
        return frozenset(found)

    def _after(self, states, character):
        key = states, character
        if key not in self.sets:
            self.sets[key] = self._closed({self.by[s][1] for s in states
                                           if self.by[s] and character in self.by[s][0]})
        return self.sets[key]

    def fits(self, history):
        states = self.first
        for character in history:
            states = self._after(states, character)
            if not states:
                return False
        return self.end in states


class PathEvaluator:
    def __init__(self, plain_map, objects):
        self.map, self.objects = plain_map, objects
        self.kinds = None  # (letter, object, medium, detector) of each character
        self.histories = None  # distinct strings
        self.history_of_ray = None
        self.upto = None  # of each registration, the part of its ray's history

    def _write(self):
        """The history of each ray as a string. Within a leg: what free detectors registered on the
        way, the step, what detectors lying on the object registered of what arrived."""
        m = self.map
        which = m.registration["detector"]
        lies_on = (m.detector["on_object"][which] >= 0) | (m.detector["on_group"][which] >= 0)
        n, is_seen = len(m.leg), m.registration["registered"] == 1
        kinds = [(str(m.letter[i]), int(m.segment["object"][i]), int(m.segment["medium"][i]), -1)
                 for i in range(n)]
        kinds += [("V", -1, -1, int(d)) for d in which]
        ray = np.concatenate([m.ray_of_segment, m.ray_of_registration])
        leg = np.concatenate([m.leg, m.registration["segment"]])
        phase = np.concatenate([np.ones(n, dtype=int), np.where(lies_on, 2, 0)])
        order = np.lexsort((np.arange(len(ray)), phase, leg, ray))  # the last key counts most
        is_there = np.concatenate([np.ones(n, dtype=bool), is_seen])[order]
        number = {}
        text = "".join([chr(FIRST + number.setdefault(kinds[i], len(number)))
                        for i in order[is_there]])
        ends = np.cumsum(np.bincount(ray[order[is_there]], minlength=m.n_ray))
        begins = np.append(0, ends[:-1])
        strings = [text[a:b] for a, b in zip(begins, ends)]
        self.kinds = list(number)
        distinct = {}
        self.history_of_ray = np.array([distinct.setdefault(s, len(distinct)) for s in strings])
        self.histories = list(distinct)
        place = np.empty(len(order), dtype=int)
        place[order] = np.cumsum(is_there)
        self.upto = [text[begins[r]:b] for r, b in zip(m.ray_of_registration, place[n:])]

    def match_registrations(self, text):
        """Of each registration: of the history up to and with it, if it is registered."""
        if self.kinds is None:
            self._write()
        automaton, known = Automaton(self.read(text)), {}
        return np.array([known[s] if s in known else known.setdefault(s, automaton.fits(s))
                         for s in self.upto], dtype=bool)

    def match(self, text):
        if self.kinds is None:
            self._write()
        automaton = Automaton(self.read(text))
        found = np.array([automaton.fits(history) for history in self.histories], dtype=bool)
        return found[self.history_of_ray]

    def match_again(self, text, longest=12):
        """The same by Python's own regular expressions, of histories so short that these do not
        lose themselves: [whether it fits, whether match() says so]."""
        pattern, by_ray = re.compile(as_expression(self.read(text))), self.match(text)
        rays = [r for r in range(self.map.n_ray)
                if len(self.histories[self.history_of_ray[r]]) <= longest]
        return np.array([[pattern.fullmatch(self.histories[self.history_of_ray[r]]) is not None,
                          by_ray[r]] for r in rays[:500]]).reshape(-1, 2)

    def _fits(self, kind, letters, name):
        letter, which, medium, detector = kind
        if letter not in letters:
            return False
        if name is None:
            return True
        if letter == "V":
            return glob(name, self.map.names["detector"][detector])
        if which >= 0:
            return bool(self.objects(name)[which])
        return letter in "AS" and glob(name, self.map.names["medium"][medium])

    def read(self, text):
        """The pattern as a tree: ("one", characters), ("all", parts), ("any", parts) and
        ("times", part, least, most or None)."""
        tree, at = self._alternatives(text, 0)
        if at != len(text):
            raise ValueError(f"the evaluator does not understand {text[at:]!r}")
        return tree

    def _alternatives(self, text, at):
        branches = [[]]
        while at < len(text) and text[at] != ")":
            if text[at] == "|":
                branches.append([])
                at += 1
            elif text[at].isspace():
                at += 1
            else:
                part, at = self._part(text, at)
                branches[-1].append(part)
        return ("any", [("all", parts) for parts in branches]), at

    def _part(self, text, at):
        if text[at] == "(":
            part, at = self._alternatives(text, at + 1)
            at += 1
        else:
            part, at = self._step(text, at)
        times = TIMES.match(text, at)
        if not times:
            return part, at
        sign = re.sub(r"\s", "", times[1])
        if sign in "*+?":
            least, most = {"*": (0, None), "+": (1, None), "?": (0, 1)}[sign]
        else:
            numbers = [int(n) for n in sign[1:-1].split(",")]
            least, most = numbers[0], numbers[-1]
        return ("times", part, least, most), times.end()

    def _step(self, text, at):
        letters, at = text[at], at + 1
        if letters == ".":
            letters = STEP_LETTERS + "V"
        elif letters == "[":
            end = text.index("]", at)
            letters, at = re.sub(r"\s", "", text[at:end]), end + 1
            if letters[0] == "^":
                letters = "".join(set(STEP_LETTERS + "V") - set(letters))
        name = NAME.match(text, at)
        if name:
            at = name.end()
            quoted, bare = name.groups()
            name = bare if quoted is None else quoted.replace("''", "'")
        return ("one", "".join(chr(FIRST + k) for k, kind in enumerate(self.kinds)
                               if self._fits(kind, letters, name))), at
