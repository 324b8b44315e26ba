# SPDX-License-Identifier: MIT
"""The program `raymap`, started once per question; its JSON as Python's lists and dicts.

Nothing here knows how a question is answered. An option of the program is a keyword: `where="..."`
is --where, `significance=0.05` is --significance, `log=True` is --log, `no_events=True` is
--no-events, and a list gives an option several times.
"""
from __future__ import annotations

import json
import os
import shutil
import subprocess
from typing import Any, Iterable, Optional, Sequence, Union

Path = Union[str, "os.PathLike[str]"]


class RaymapError(Exception):
    """The program did not do what it was asked: its exit status (docs/manual.md) and its words."""

    def __init__(self, status: int, text: str, command: Sequence[str]):
        super().__init__(text.strip() or f"status {status}: {' '.join(command)}")
        self.status = status
        self.command = list(command)


def _options(keywords: "dict[str, Any]") -> "list[str]":
    """The words that keywords stand for."""
    words = []
    for name, value in keywords.items():
        option = "--" + name.rstrip("_").replace("_", "-")
        values = value if isinstance(value, (list, tuple)) else [value]
        for one in values:
            if one is True:
                words.append(option)
            elif one is not None and one is not False:
                words += [option, str(one)]
    return words


class Program:
    """Where the program is and how it is started.

    path:   the program; None: $RAYMAP, else `raymap` on the PATH.
    before: words before it, such as ["mpirun", "-np", "4"].
    """

    def __init__(self, path: Optional[Path] = None, before: Iterable[str] = ()):
        found = os.fspath(path) if path else os.environ.get("RAYMAP") or shutil.which("raymap")
        if not found:
            raise FileNotFoundError("the program raymap is neither on the PATH nor in $RAYMAP")
        self.command = [*before, found]

    def run(self, *words: Any, **options: Any) -> str:
        """Runs a command and returns what it printed. RaymapError when it fails."""
        command = [*self.command, *(os.fspath(word) if hasattr(word, "__fspath__") else str(word)
                                    for word in words), *_options(options)]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              check=False)
        if done.returncode != 0:
            raise RaymapError(done.returncode, done.stderr, command)
        return done.stdout

    def json(self, *words: Any, **options: Any) -> Any:
        """The same with --json, decoded."""
        return json.loads(self.run(*words, "--json", "--quiet", **options))


def _ask(words: Sequence[Any], program: Optional[Program], options: "dict[str, Any]") -> Any:
    return (program or Program()).json(*words, **options)


def info(map_path: Path, *, program: Optional[Program] = None) -> dict:
    """What a map holds: rays, digest, sources, objects, detectors."""
    return _ask(["info", map_path], program, {})


def query(map_path: Path, *criteria: str, program: Optional[Program] = None,
          **options: Any) -> Any:
    """Rays, segments and flux that match: a dict, or of several criteria a list of them. limit, sample: a list of rays as
    `report` has them; top and of: rays with their values; output: a file of rays."""
    return _ask(["query", map_path, *(criteria or ("all",))], program, options)


def report(map_path: Path, ray: int, *, program: Optional[Program] = None) -> dict:
    """Everything that happened along one ray."""
    return _ask(["report", map_path, ray], program, {})


def energy(map_path: Path, *, program: Optional[Program] = None, **options: Any) -> dict:
    """Where the light of each source went. where: a criterion."""
    return _ask(["report", map_path, "--energy"], program, options)


def detector(map_path: Path, name: str, *, program: Optional[Program] = None,
             **options: Any) -> dict:
    """A detector's sums; raymap.image has its cells. where, receivers, cells, region, ..."""
    return _ask(["detector", map_path, name], program, options)


def stats(map_path: Path, of: Union[str, Sequence[str]], *, program: Optional[Program] = None,
          **options: Any) -> dict:
    """Moments, quantiles and a histogram of a number of rays or registrations ("path_length",
    "x(sensor)"). where, bins, range, log, quantiles, by, ..."""
    return _ask(["stats", map_path], program, {"of": of, **options})


def paths(map_path: Path, *, program: Optional[Program] = None, **options: Any) -> dict:
    """Classes of rays by what they met. where, by, top, sort, detector, matrix, collapse, ..."""
    return _ask(["paths", map_path], program, options)


def compare(map_path: Path, other: Optional[Path] = None, *, program: Optional[Program] = None,
            **options: Any) -> dict:
    """Whether two maps, or two criteria of one (where=[a, b]), are statistically the same."""
    words = ["compare", map_path] + ([other] if other is not None else [])
    return _ask(words, program, options)
