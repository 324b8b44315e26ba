# SPDX-License-Identifier: MIT
"""A second implementation of the map's format, for the tests alone: h5py and numpy, nothing of the program or its library.

Plain pieces hold the columns as they are. Of compact ones compact.py and optics.py, beside this file,
make them: the formulas of docs/encoding.md, in doubles and in the order given
there, so that the same bits come out as from the program. Nothing here traces a ray to find out where it goes. No checksum
is verified and no index used beyond numpy's own.
"""
import os

import numpy as np

import raymap.reader
from raymap.reader import (COLUMN_NAMES, STOPS, TABLES, MapError, Portion, Ray, event_words,  # noqa: F401
                           open_file)

PLAIN, COMPACT = 0, 1
PIECES_OPEN = 16  # portions of a map go from piece to piece, as its ranks took turns


class Map(raymap.reader.Map):
    """The package's names and numbers of map.h5, and rays without the library."""

    def _read_index(self, index):
        super()._read_index(index)
        self._pieces = {}  # the last PIECES_OPEN that were asked for, the latest behind
        self._decoders = {}  # of those that are compact
        self.piece_table = {name: index["piece/" + name][:] for name in
                            ("shard", "number", "nbytes", "encoding", "space", "stored_rows")}
        self.portion_table = {name: index["portion/" + name][:] for name in
                              ("piece", "space", "first_ray", "n_row", "stored_first",
                               "stored_rows")}
        n_ray = self.portion_table["n_row"][:, 0]
        self.portion_table["last_ray"] = (  # picked rays have gaps
            index["portion/last_ray"][:] if "last_ray" in index["portion"] else
            self.portion_table["first_ray"] + n_ray - np.uint64(1))

    @property
    def handle(self):
        raise AssertionError("the reference does without the library")

    def _count_committed(self):
        """Nothing of it is read."""

    @property
    def n_portions(self):
        return len(self.portion_table["piece"])

    def encoding(self, portion):
        """PLAIN or COMPACT, of a portion's piece."""
        return int(self.piece_table["encoding"][self.portion_table["piece"][portion]])

    def _piece(self, piece):
        if piece in self._pieces:
            self._pieces[piece] = self._pieces.pop(piece)
        else:
            if len(self._pieces) == PIECES_OPEN:
                oldest = next(iter(self._pieces))
                self._pieces.pop(oldest).close()
                self._decoders.pop(oldest, None)
            name = "shard-%05d/piece-%05d.h5" % (self.piece_table["shard"][piece],
                                                 self.piece_table["number"][piece])
            path = os.path.join(self.path, name)
            if os.path.getsize(path) != self.piece_table["nbytes"][piece]:
                raise MapError(f"{path} has not the size that map.h5 states")
            self._pieces[piece] = open_file(path)
        return self._pieces[piece]

    def portion(self, k, names=None):
        """Block k of rays, in the order of first ray ids; `names`: the columns wanted."""
        names = names or self.column_names
        piece = int(self.portion_table["piece"][k])
        file = self._piece(piece)
        if self.encoding(k) == PLAIN:
            columns = self._plain(file, k, names)
        else:
            columns = self._compact(file, piece, k, names)
        return Portion(columns, int(self.portion_table["space"][k]))

    def _plain(self, file, k, names):
        first, rows = self.portion_table["stored_first"][k], self.portion_table["stored_rows"][k]
        space = self.spaces[int(self.portion_table["space"][k])]
        columns = {}
        for name in names:
            table = TABLES.index(name.split("/")[0])
            stored = "segment/colour_" + space["mode"] if name == "segment/colour" else name
            columns[name] = file[stored][int(first[table]):int(first[table] + rows[table])]
        return columns

    def _compact(self, file, piece, k, names):
        from . import compact
        if piece not in self._decoders:
            with open_file(os.path.join(self.path, "map.h5"), has_view=True) as index:
                model = compact.Model(index, int(self.portion_table["space"][k]))
            self._decoders[piece] = compact.Decoder(model, file)
        columns = self._decoders[piece].portion(
            self.portion_table["stored_first"][k], self.portion_table["stored_rows"][k],
            self.portion_table["n_row"][k], names)
        return {name: columns[name] for name in names}

    def portions(self, names=None):
        return (self.portion(k, names) for k in range(self.n_portions))

    def _whole(self, names):
        parts = [portion.columns for portion in self.portions(names)]
        return {name: np.concatenate([part[name] for part in parts]) for name in names}

    def ray(self, number):
        """The ray with this id."""
        first, last = self.portion_table["first_ray"], self.portion_table["last_ray"]
        wanted = np.uint64(number)
        for k in np.flatnonzero((first <= wanted) & (wanted <= last)):  # several: picked, merged
            portion = self.portion(int(k))
            row = np.flatnonzero(portion["ray/id"] == number)
            if len(row):
                return Ray(portion, int(row[0]))
        raise MapError(f"{self.path}: no ray {number}")
