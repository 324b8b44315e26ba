# SPDX-License-Identifier: MIT
"""path("...") by Python's own regular expressions: every kind of step or registration that a map
has becomes a character, every ray a string, every step of the pattern a class of characters."""
import re

import numpy as np

from judge_map import glob

STEP_LETTERS = "TRIDdSFOAXKE"
NAME = re.compile(r"\s*@\s*(?:'((?:[^']|'')*)'|([A-Za-z_]\w*(?:\.\w+)*))")
TIMES = re.compile(r"\s*(\*|\+|\?|\{\s*\d+\s*(?:,\s*\d+\s*)?\})")


class PathJudge:
    def __init__(self, plain_map, objects):
        self.map, self.objects = plain_map, objects
        self.kinds = None  # (letter, object, medium, detector) of each character
        self.histories = None  # distinct strings
        self.history_of_ray = None

    def _write(self):
        """The history of each ray as a string. Within a leg: what free detectors registered on the
        way, the step, what detectors lying on the object registered of what arrived."""
        m = self.map
        seen = np.flatnonzero(m.registration["registered"] == 1)
        which = m.registration["detector"][seen]
        lies_on = (m.detector["on_object"][which] >= 0) | (m.detector["on_group"][which] >= 0)
        n = len(m.leg)
        kinds = [(str(m.letter[i]), int(m.segment["object"][i]), int(m.segment["medium"][i]), -1)
                 for i in range(n)]
        kinds += [("V", -1, -1, int(d)) for d in which]
        ray = np.concatenate([m.ray_of_segment, m.ray_of_registration[seen]])
        leg = np.concatenate([m.leg, m.registration["segment"][seen]])
        phase = np.concatenate([np.ones(n, dtype=int), np.where(lies_on, 2, 0)])
        order = np.lexsort((np.arange(len(ray)), phase, leg, ray))  # the last key counts most
        number = {}
        text = "".join([chr(0x4E00 + number.setdefault(kinds[i], len(number))) for i in order])
        ends = np.cumsum(np.bincount(ray, minlength=m.n_ray))
        strings = [text[a:b] for a, b in zip(np.append(0, ends[:-1]), ends)]
        self.kinds = list(number)
        distinct = {}
        self.history_of_ray = np.array([distinct.setdefault(s, len(distinct)) for s in strings])
        self.histories = list(distinct)

    def match(self, text):
        if self.kinds is None:
            self._write()
        pattern = re.compile(self.translate(text))
        found = np.array([pattern.fullmatch(s) is not None for s in self.histories], dtype=bool)
        return found[self.history_of_ray]

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

    def _class(self, letters, name):
        fitting = [chr(0x4E00 + k) for k, kind in enumerate(self.kinds)
                   if self._fits(kind, letters, name)]
        return f"[{''.join(fitting)}]" if fitting else "(?!)"

    def translate(self, text):
        out, at = [], 0
        while at < len(text):
            c = text[at]
            at += 1
            if c.isspace():
                continue
            if c in "|)":
                out.append(c)
            elif c == "(":
                out.append("(?:")
            else:
                letters = c
                if c == ".":
                    letters = STEP_LETTERS + "V"
                elif c == "[":
                    end = text.index("]", at)
                    letters = re.sub(r"\s", "", text[at:end])
                    at = end + 1
                    if letters[0] == "^":
                        letters = "".join(set(STEP_LETTERS + "V") - set(letters))
                name = NAME.match(text, at)
                if name:
                    at = name.end()
                    quoted, bare = name.groups()
                    name = bare if quoted is None else quoted.replace("''", "'")
                out.append(self._class(letters, name or None))
            if c not in "|(":
                times = TIMES.match(text, at)
                if times:
                    at = times.end()
                    out.append(re.sub(r"\s", "", times[1]))
        return "".join(out)
