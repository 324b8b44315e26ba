# SPDX-License-Identifier: MIT
"""All columns of millions of rays, whichever encoding the map is in."""
from __future__ import annotations

import os
import tempfile
from contextlib import contextmanager
from typing import Iterator, Optional

from .program import Path, Program
from .reader import Map


@contextmanager
def plain(map_path: Path, *, program: Optional[Program] = None) -> Iterator[Map]:
    """The map as one whose columns are stored: itself, or a copy that the program converts into a
    temporary folder ($TMPDIR; some 20 bytes a segment) and that is gone after the block.

        with raymap.plain("lens.raymap") as lens:
            lens.columns("ray/path_length")
    """
    opened = Map(map_path)
    if opened.is_plain:
        yield opened
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = os.path.join(folder, "plain.raymap")
        (program or Program()).run("convert", map_path, "-o", copy, encoding="plain", quiet=True)
        yield Map(copy)
