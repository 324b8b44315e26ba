# SPDX-License-Identifier: MIT
"""libraymap through ctypes (docs/library.md): columns of a map's rays, block by block, on all cores.

It is found as $RAYMAP_LIBRARY, beside the program ($RAYMAP, else on the PATH) or where that was installed, in the release build of
the source tree that this file lies in, or by the system's loader.
"""
from __future__ import annotations

import collections
import ctypes
import functools
import os
import pathlib
import queue
import shutil
import weakref
from concurrent.futures import ThreadPoolExecutor
from typing import Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

TABLES = ("ray", "segment", "registration", "curve")
_NAME = "libraymap.so.1"
_TYPES = ("u1", "<u2", "<i2", "<u4", "<i4", "<u8", "<f4", "<f8")


class MapError(Exception):
    """What cannot be read, and why."""


class _Error(ctypes.Structure):
    _fields_ = [("status", ctypes.c_int32), ("text", ctypes.c_char * 1024)]


class _Column(ctypes.Structure):
    _fields_ = [("name", ctypes.c_char_p), ("unit", ctypes.c_char_p), ("description", ctypes.c_char_p),
                ("table", ctypes.c_int32), ("type", ctypes.c_int32), ("width", ctypes.c_int32)]


class _Block(ctypes.Structure):
    _fields_ = [("first_ray", ctypes.c_uint64), ("rays", ctypes.c_uint64), ("rows", ctypes.c_uint64 * 4),
                ("space", ctypes.c_int32)]


_POINTER = ctypes.c_void_p
_FUNCTIONS = {  # result, arguments
    "open": (ctypes.c_int, [ctypes.c_char_p, ctypes.POINTER(_POINTER), ctypes.POINTER(_Error)]),
    "close": (None, [_POINTER]),
    "rows": (ctypes.c_uint64, [_POINTER, ctypes.c_int]),
    "blocks": (ctypes.c_size_t, [_POINTER]),
    "find_ray": (ctypes.c_int, [_POINTER, ctypes.c_uint64, ctypes.POINTER(ctypes.c_size_t)]),
    "wavelengths": (_POINTER, [_POINTER, ctypes.c_size_t, ctypes.POINTER(ctypes.c_size_t)]),
    "reader_create": (ctypes.c_int, [_POINTER, ctypes.c_char_p, ctypes.c_char_p, ctypes.POINTER(_POINTER),
                                     ctypes.POINTER(_Error)]),
    "reader_destroy": (None, [_POINTER]),
    "reader_column": (ctypes.c_int, [_POINTER, ctypes.c_size_t, ctypes.POINTER(_Column)]),
    "read": (ctypes.c_int, [_POINTER, ctypes.c_size_t, ctypes.POINTER(_Block), ctypes.POINTER(_Error)]),
    "data": (_POINTER, [_POINTER, ctypes.c_size_t]),
}


def _candidates() -> Iterator[str]:
    if os.environ.get("RAYMAP_LIBRARY"):
        yield os.environ["RAYMAP_LIBRARY"]
        return
    program = os.environ.get("RAYMAP") or shutil.which("raymap")
    if program:
        folder = pathlib.Path(program).resolve().parent
        yield str(folder / _NAME)
        yield from map(str, sorted(folder.parent.glob(f"lib*/{_NAME}")) + sorted(folder.parent.glob(f"lib/*/{_NAME}")))
    yield str(pathlib.Path(__file__).resolve().parents[3] / "build" / "release" / _NAME)
    yield _NAME


@functools.lru_cache(maxsize=None)
def _library() -> ctypes.CDLL:
    why = ""
    for path in _candidates():
        if "/" in path and not os.path.exists(path):
            continue
        try:
            library = ctypes.CDLL(path)
            for name, (result, arguments) in _FUNCTIONS.items():
                function = getattr(library, "raymap_" + name)
                function.restype, function.argtypes = result, arguments
            return library
        except (OSError, AttributeError) as error:  # no library, or another one
            why = f" ({error})"
    raise MapError(f"{_NAME} is not found: it is installed and built with the program raymap; name it with "
                   f"RAYMAP_LIBRARY{why}")


def _check(status: int, error: _Error) -> None:
    if status != 0:
        raise MapError(error.text.decode(errors="replace"))


class Block(NamedTuple):
    """Rows of the columns that were asked for, of the rays of one block."""
    columns: Dict[str, np.ndarray]
    space: int  # of the map's colour spaces


def _destroy(pointer: ctypes.c_void_p, _handle: "Handle") -> None:
    """Of a reader; its map is open until then, in whatever order Python gives objects up."""
    _library().raymap_reader_destroy(pointer)


class Reader:
    """Columns of one map. One thread at a time; what it has decoded last, it has at hand."""

    def __init__(self, handle: "Handle", columns: Sequence[str], where: Optional[str] = None):
        self.handle = handle
        library, pointer, error = _library(), _POINTER(), _Error()
        _check(library.raymap_reader_create(handle.pointer, None if where is None else where.encode(),
                                            ",".join(columns).encode(), pointer, error), error)
        self.pointer = pointer
        weakref.finalize(self, _destroy, pointer, handle)
        self.columns: List[Tuple[str, int, str, int]] = []
        column = _Column()
        while library.raymap_reader_column(pointer, len(self.columns), column) == 0:
            name = f"{TABLES[column.table]}/{column.name.decode()}"
            self.columns.append((name, column.table, _TYPES[column.type], column.width))

    def room(self, rows: Sequence[int], space: int = 0) -> Dict[str, np.ndarray]:
        """Columns of so many rows of each table, whose values are to come."""
        out = {}
        for name, table, dtype, width in self.columns:
            is_vector = width != 1 or name.endswith("/colour")
            out[name] = np.empty((rows[table], width or self.handle.channels(space)) if is_vector else rows[table], dtype)
        return out

    def read(self, block: int) -> Block:
        library, info, error = _library(), _Block(), _Error()
        _check(library.raymap_read(self.pointer, block, info, error), error)
        out = self.room(info.rows, info.space)
        for c, column in enumerate(out.values()):
            ctypes.memmove(column.ctypes.data, library.raymap_data(self.pointer, c), column.nbytes)
        return Block(out, info.space)


class Handle:
    """An open map."""

    def __init__(self, path: "os.PathLike[str] | str"):
        pointer, error = _POINTER(), _Error()
        _check(_library().raymap_open(os.fsencode(path), pointer, error), error)
        self.pointer = pointer
        weakref.finalize(self, _library().raymap_close, pointer)
        self.n_blocks = _library().raymap_blocks(pointer)

    def rows(self, table: str) -> int:
        return _library().raymap_rows(self.pointer, TABLES.index(table))

    def columns(self, table: str) -> List[Tuple[str, str, int]]:
        """Name, type and width of all that a table has; width 0: one number per channel, as the block's space has."""
        return [(name, dtype, width) for name, _, dtype, width in Reader(self, [table]).columns]

    def channels(self, space: int) -> int:
        n = ctypes.c_size_t()
        _library().raymap_wavelengths(self.pointer, space, n)
        return n.value

    def blocks_of(self, ray: int) -> Iterator[int]:
        """Those that may hold the ray with this id."""
        block = ctypes.c_size_t(self.n_blocks)
        while _library().raymap_find_ray(self.pointer, ray, block):
            yield block.value

    def blocks(self, columns: Sequence[str], where: Optional[str] = None) -> Iterator[Block]:
        """All of them in order, read ahead by as many threads as there are cores; memory of a few blocks."""
        n_thread = max(1, min(len(os.sched_getaffinity(0)), self.n_blocks))
        readers: "queue.SimpleQueue[Reader]" = queue.SimpleQueue()
        for _ in range(n_thread):
            readers.put(Reader(self, columns, where))

        def read(block: int) -> Block:
            reader = readers.get()
            try:
                return reader.read(block)
            finally:
                readers.put(reader)

        with ThreadPoolExecutor(n_thread) as threads:
            waiting = collections.deque()
            try:
                for block in range(self.n_blocks):
                    waiting.append(threads.submit(read, block))
                    if len(waiting) > 4 * n_thread:
                        yield waiting.popleft().result()
                while waiting:
                    yield waiting.popleft().result()
            finally:
                for one in waiting:
                    one.cancel()

    def whole(self, columns: Sequence[str], where: Optional[str] = None) -> Dict[str, np.ndarray]:
        """All rows of each column. Blocks go into the arrays as they come, so that memory for them is touched once."""
        out = Reader(self, columns, where).room([self.rows(table) if where is None else 0 for table in TABLES])
        rows = collections.Counter()
        for block in self.blocks(columns, where):
            for name, part in block.columns.items():
                begin, rows[name] = rows[name], rows[name] + len(part)
                if rows[name] > len(out[name]):
                    out[name].resize((2 * rows[name], *part.shape[1:]), refcheck=False)
                out[name][begin:rows[name]] = part
        for name, column in out.items():
            column.resize((rows[name], *column.shape[1:]), refcheck=False)
        return out
