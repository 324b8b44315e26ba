# SPDX-License-Identifier: MIT
"""Decodes compact pieces of a ray map with numpy (docs/encoding.md).

A compact piece says of a ray which surfaces it met and what happened there: its path. Where it met
them, its direction and its colour follow, leg by leg, from the scene's numbers and the ray's random
numbers (optics.py). What follows is a prediction for every number of every column (a lane);
the piece holds a residual where the prediction is wrong. The rays of a block are followed side by
side. All arithmetic is + - x / and square roots of doubles, in the program's order.
"""
import numpy as np

from .optics import (
    ABSORB, ERROR, LEFT, LIMIT, TRANSMIT_DIFFUSE, TRANSMIT_SPECULAR, Light, Model, axpy, columns_of,
    cross_detector, depart, distance_out, dot, f4, f8, find_facing, like, pick, quantise_cosine,
    scale, sub, take, to_float, turn)

__all__ = ["Decoder", "Lane", "Model"]

AT_END = np.array([ABSORB, LEFT, LIMIT, ERROR], np.uint32)
PREDICTED, PATCHED, RESIDUAL, VERBATIM = range(4)

# The stored tables, in the order of /portion/stored_first.
TABLES = ("ray", "own", "own_segment", "own_registration", "path", "path_segment",
          "path_registration", "triangle", "patch", "pool16", "pool32", "pool64", "curve")

# Lanes, in the order of header and pools: column, type.
LANES = (
    ("ray/id", "u8"), ("ray/weight", "f8"), ("ray/wavelength", "f8"), ("ray/path_length", "f8"),
    ("ray/optical_path", "f8"), ("ray/start", "f4"), ("ray/start_primitive", "i4"),
    ("ray/start_normal", "i2"), ("ray/end_direction", "f4"), ("segment/primitive", "i4"),
    ("segment/medium", "i2"), ("segment/position", "f4"), ("segment/normal", "i2"),
    ("segment/colour", "u2"), ("registration/cell", "u2"), ("registration/relative", "u2"),
    ("registration/direction", "f4"), ("registration/optical_path", "f8"),
)

# Columns whose rays must be traced again, which takes longest by far; PLACED, of portions before
# format 5 alone.
RETRACED = frozenset((
    "ray/path_length", "ray/optical_path", "ray/start", "ray/start_normal", "ray/end_direction",
    "segment/position", "segment/normal", "segment/colour", "registration/cell",
    "registration/relative", "registration/direction", "registration/optical_path"))
PLACED = frozenset(("registration/cell", "registration/relative"))


# ---- lanes ----

def _ordered(bits, kind, width):
    """Bits of floats so that the next float is the next integer; its own inverse."""
    if kind != "f":
        return bits
    sign = np.uint64(8 * width - 1)
    magnitude = np.uint64((1 << (8 * width - 1)) - 1)
    return np.where(bits >> sign != 0, bits ^ magnitude, bits)


class Lane:
    """A column whose numbers are predicted: [n] flat."""

    def __init__(self, dtype, n):
        self.dtype, self.n = np.dtype("<" + dtype), n
        self.mode, self.dense, self.at, self.value = PREDICTED, None, None, None
        self.out = np.zeros(n, self.dtype)

    def offer(self, index, predicted):
        """Predictions for the numbers `index` -> (the truth, whether a prediction was right).
        They are right where nothing was stored."""
        predicted = np.ascontiguousarray(predicted, self.dtype)
        truth, right = predicted, np.ones(predicted.shape, bool)
        if self.mode == VERBATIM:
            truth = self.dense[index]
        elif self.mode == RESIDUAL:
            truth = self._corrected(predicted, self.dense_bits[index])
        elif self.mode == PATCHED:
            k = np.minimum(np.searchsorted(self.at, index), len(self.at) - 1)
            hit = self.at[k] == index
            if hit.any():
                truth = predicted.copy()
                truth[hit] = self._corrected(predicted[hit], self.value[k[hit]])
        if truth is not predicted:
            right = _bits(truth) == _bits(predicted)
        self.out[index] = truth
        return truth, right

    def _corrected(self, predicted, value):
        width = self.dtype.itemsize
        mask = np.uint64((1 << (8 * width)) - 1)
        value = value & mask
        d = (value >> np.uint64(1)) ^ np.where(value & np.uint64(1) != 0, mask, np.uint64(0))
        bits = _ordered(_bits(predicted), self.dtype.kind, width)
        bits = _ordered((bits + d) & mask, self.dtype.kind, width)
        return bits.astype(f"<u{width}").view(self.dtype)


def _bits(numbers):
    return np.ascontiguousarray(numbers).view(f"<u{numbers.dtype.itemsize}").astype(np.uint64)


TABLE, PLACES, CLASSES, LENGTHS, FILMS, ANGLES, ARRIVALS = 1 << 63, 2, 4, 8, 128, 1 << 16, 1 << 17  # flags
CODES_AT, RARE = 8, 255  # and where they say how many codes of classes there are,
ARRIVALS_AT = 32  # how many rays arrive


def read_header(row):
    """The rows of pool64 -> (modes, numbers of patches, rows used, places stand by themselves)."""
    first, count = int(row[0]), len(LANES)
    if first & TABLE:
        mode = [int(x) & 0xff for x in row[4:4 + count]]
        patches = [int(x) >> 8 for x in row[4:4 + count]]
        return mode, patches, 4 + count, bool(first & PLACES)
    mode, used, patches = [first >> 2 * k & 3 for k in range(count)], 3, []
    for how in mode:
        patches.append(int(row[used]) if how == PATCHED else 0)
        used += how == PATCHED
    return mode, patches, used, False


def load_lanes(rows, n_row, n_channel):
    """The lanes of a portion out of its pools and patches -> (lanes by column, seed, first id,
    places of registrations stand by themselves)."""
    width = {"ray/start": 3, "ray/start_normal": 3, "ray/end_direction": 3, "segment/position": 3,
             "segment/normal": 3, "segment/colour": n_channel, "registration/cell": 2,
             "registration/relative": 2, "registration/direction": 3}
    count = dict(zip(("ray", "segment", "registration"), (int(n) for n in n_row)))
    pool = {2: rows["pool16/value"], 4: rows["pool32/value"], 8: rows["pool64/value"]}
    seed, first = int(pool[8][1]), int(pool[8][2])
    mode, patches, n_header, placed = read_header(pool[8])
    patch, used = 0, {2: 0, 4: 0, 8: n_header}
    lanes = {}
    for (column, dtype), how, n in zip(LANES, mode, patches):
        lane = Lane(dtype, count[column.split("/")[0]] * width.get(column, 1))
        lane.mode = how
        if how == PATCHED:
            skip = rows["patch/skip"][patch:patch + n].astype(np.int64)
            lane.at = np.cumsum(skip + 1) - 1
            lane.value = rows["patch/value"][patch:patch + n]
            patch += n
        elif how != PREDICTED:
            size = lane.dtype.itemsize
            raw = pool[size][used[size]:used[size] + lane.n]
            used[size] += lane.n
            lane.dense_bits = raw.astype(np.uint64)
            lane.dense = np.ascontiguousarray(raw).view(lane.dtype)
        lanes[column] = lane
    return lanes, seed, first, placed


# ---- portions ----

def _rows(first, count):
    """Concatenated ranges [first[k], first[k] + count[k])."""
    first, count = np.asarray(first, np.int64), np.asarray(count, np.int64)
    ends = np.cumsum(count)
    return np.repeat(first - (ends - count), count) + np.arange(int(count.sum()))


class Decoder:
    """Of one piece: an open h5py.File, whose paths are read at once."""

    def __init__(self, model, file):
        self.model, self.file = model, file
        self.paths = {f"{table}/{name}": data[:] for table in
                      ("path", "path_segment", "path_registration")
                      for name, data in file[table].items()}
        self._known, self._classes = None, None

    def _unfold_dictionary(self):
        """Segments of the paths as columns, and the classes of these in the order in which they
        first appear."""
        if self._known is None:
            columns = {"ray/" + name: self.paths["path/" + name]
                       for name in ("source", "stop", "segment_count", "start_object")}
            columns.update({"segment/" + name: self.paths["path_segment/" + name].copy()
                            for name in ("object", "event")})
            self._expect(columns)
            self._known = {name: columns[name] for name in
                           ("segment/object", "segment/event", "segment/medium")}
            rows = np.stack([column.astype(np.int64) for column in self._known.values()], axis=1)
            first = np.sort(np.unique(rows, axis=0, return_index=True)[1])
            self._classes = {name: column[first] for name, column in self._known.items()}
        return self._known, self._classes

    @staticmethod
    def _classes_of_codes(word, n_code, n):
        """Classes of n segments of own paths, which have a code of a byte each."""
        n_word = -(-n // 4)
        code = word[n_code:n_code + n_word].astype("<u4").view(np.uint8)[:n]
        rare = word[n_code + n_word:].astype("<u4").view("<u2")
        class_of = np.concatenate([word[:n_code], np.zeros(256 - n_code, word.dtype)])
        classes = class_of[code]
        classes[code == RARE] = rare[:np.count_nonzero(code == RARE)]
        return classes

    @staticmethod
    def _check_own_lengths(pool, own, length):
        """What stands behind the lanes of pool16 of the rays with paths of their own says about how long they are."""
        least, most, shift = int(pool[0]) | int(pool[1]) << 16, 0x7f800000, int(pool[2])
        code = pool[3:].astype("<u2").view(np.uint8)[:len(own)].astype(np.uint64)
        edges = [np.minimum(least + (k << shift), most).astype("<u4").view("<f4").astype(np.float64)
                 for k in (code, code + np.uint64(1))]
        if np.any(edges[0] > length[own]) or np.any(edges[1] < length[own]):
            raise ValueError("lengths of own paths are beyond what the portion says of them")

    def _check_angles(self, degrees, parts, columns):
        """What stands behind the lanes of pool32 and pool16 says of each registration about under which angle it was."""
        n = len(columns["registration/detector"])
        degrees = degrees.astype("<u4").view(np.uint8)[:n].astype(int)
        parts = (parts.astype(int)[:, None] >> 2 * np.arange(8) & 3).ravel()[:n]
        detector, its = self.model.detector, columns["registration/detector"]
        sign = np.where(detector["type"] == 0, -1.0, 1.0)[its]  # of a plane the reversed ray's
        axis, d = detector["axis"][its], columns["registration/direction"].astype(float) * sign[:, None]
        angle = np.degrees(np.arctan2(np.linalg.norm(np.cross(d, axis), axis=1), np.sum(d * axis, axis=1)))
        low = degrees + parts / 4
        if np.any((low <= 180) & ((angle < low - 1e-9) | (angle > low + 0.25 + 1e-9))):
            raise ValueError("angles of registrations are beyond what the portion says of them")

    def _check_arrivals(self, arriving, path):
        """What stands behind the lanes of pool16 are the references of the rays that may arrive at a detector, in order."""
        arrives = np.concatenate([[True], self.paths["path/registration_count"] > 0])
        if not np.array_equal(arriving, path[arrives[path]]):
            raise ValueError("other rays arrive than the portion says")

    def portion(self, stored_first, stored_rows, n_row, names):
        """The columns of a portion, by name: `names`, and others that need no ray traced again."""
        rows = {}
        for k, table in enumerate(TABLES[:len(stored_first)]):  # /curve is there or not
            if not table.startswith("path"):
                begin, end = int(stored_first[k]), int(stored_first[k] + stored_rows[k])
                for name, data in self.file[table].items():
                    if (table, name) in (("ray", "path"), ("ray", "channel")) or table != "ray":
                        rows[f"{table}/{name}"] = data[begin:end]
        flags = int(rows["pool64/value"][0])
        classed = flags & TABLE != 0 and flags & CLASSES != 0
        if classed and flags >> CODES_AT & 255:
            rows["own_segment/object"] = self._classes_of_codes(
                rows["own_segment/object"], flags >> CODES_AT & 255,
                int(rows["own/segment_count"].sum()))
        columns = self._columns_of_paths(rows, classed)
        lanes, seed, first, placed = load_lanes(rows, n_row, self.model.n_channel)
        retraced = RETRACED - PLACED if placed else RETRACED
        again = not retraced.isdisjoint(names)
        with np.errstate(all="ignore"):
            self._simple(rows, lanes, first, columns)
            if placed:
                self._places(lanes, columns)
            if again:
                _Retrace(self.model, rows, lanes, seed, columns, placed).run()
        for name, lane in lanes.items():
            if name in retraced and not again:
                continue
            width = lane.n // max(1, len(columns["ray/source"] if name.startswith("ray/") else
                                     columns["segment/object"] if name.startswith("segment/")
                                     else columns["registration/detector"]))
            wide = name in ("ray/start", "ray/start_normal", "ray/end_direction",
                            "segment/position", "segment/normal", "segment/colour",
                            "registration/cell", "registration/relative", "registration/direction")
            if wide:
                width = {"registration/cell": 2, "registration/relative": 2,
                         "segment/colour": self.model.n_channel}.get(name, 3)
            columns[name] = lane.out.reshape(-1, width) if wide else lane.out
        if flags & TABLE and flags & LENGTHS and again:
            own = np.flatnonzero(rows["ray/path"] == 0)
            self._check_own_lengths(rows["pool16/value"][-(3 + (len(own) + 1) // 2):], own, columns["ray/path_length"])
        behind = 3 + (np.count_nonzero(rows["ray/path"] == 0) + 1) // 2 if flags & TABLE and flags & LENGTHS else 0
        if flags & TABLE and flags & ARRIVALS:
            end, n_arrival = len(rows["pool16/value"]) - behind, flags >> ARRIVALS_AT & 0xffff
            self._check_arrivals(rows["pool16/value"][end - n_arrival:end], rows["ray/path"])
            behind += n_arrival
        if flags & TABLE and flags & ANGLES and again:
            n = len(columns["registration/detector"])
            begin = len(rows["pool16/value"]) - behind - (n + 7) // 8
            self._check_angles(rows["pool32/value"][len(rows["pool32/value"]) - (n + 3) // 4:],
                               rows["pool16/value"][begin:begin + (n + 7) // 8], columns)
        columns.update((name, rows[name]) for name in rows if name.startswith("curve/"))
        return columns

    def _columns_of_paths(self, rows, classed):
        """What paths say: the rare ones stand with their rays, in /own."""
        path = rows["ray/path"].astype(np.int64)
        known, own = path > 0, np.flatnonzero(path == 0)
        columns = {}
        for name in ("source", "stop", "start_object", "segment_count", "registration_count"):
            column = np.zeros(len(path), rows["own/" + name].dtype)
            column[known] = self.paths["path/" + name][path[known] - 1]
            column[own] = rows["own/" + name]
            columns["ray/" + name] = column
        columns["ray/start_object"] = (columns["ray/start_object"] - np.uint32(1)).view(np.int32)
        for table, names in (("segment", ("object", "event")),
                             ("registration", ("segment", "detector", "registered"))):
            count = columns[f"ray/{table}_count"].astype(np.int64)
            starts = np.cumsum(self.paths[f"path/{table}_count"].astype(np.int64))
            starts = starts - self.paths[f"path/{table}_count"]
            from_path = _rows(starts[path[known] - 1], count[known])
            begin = np.cumsum(count) - count
            to_known, to_own = _rows(begin[known], count[known]), _rows(begin[own], count[own])
            for name in names:
                if table == "segment" and classed:
                    continue
                column = np.zeros(int(count.sum()), rows[f"own_{table}/{name}"].dtype)
                column[to_known] = self.paths[f"path_{table}/{name}"][from_path]
                column[to_own] = rows[f"own_{table}/{name}"]
                columns[f"{table}/{name}"] = column
            if table == "segment" and classed:
                known_rows, classes = self._unfold_dictionary()
                for name, column in known_rows.items():
                    columns[name] = np.zeros(int(count.sum()), column.dtype)
                    columns[name][to_known] = column[from_path]
                    columns[name][to_own] = classes[name][rows["own_segment/object"]]
        if not classed:
            self._expect(columns)
        return columns

    def _expect(self, columns):
        """Objects, events and media from what paths store of them, leg by leg."""
        model, source = self.model, columns["ray/source"]
        n_object = len(model.is_mesh)
        count = columns["ray/segment_count"].astype(np.int64)
        begin = np.cumsum(count) - count
        fine = (source >= 0) & (source < len(model.source["medium"]))
        medium = np.where(fine, model.source["medium"][np.where(fine, source, 0)], 0)
        before = np.zeros(len(count), np.int64)  # 1 + object of the leg before
        stored, event = columns["segment/object"].astype(np.int64), columns["segment/event"]
        columns["segment/medium"] = np.zeros(len(stored), np.int16)
        for k in range(int(count.max(initial=0))):
            ray = np.flatnonzero(count > k)
            row = begin[ray] + k
            columns["segment/medium"][row] = medium[ray]
            was, now = before[ray], stored[row]
            swap = (model.inside[was] == medium[ray]) & ((now == 0) | (now == was))
            now = np.where(swap, was - now, now)
            known = np.where(now <= n_object, now, 0)
            last = k + 1 == count[ray]
            event[row] ^= np.where(last, AT_END[columns["ray/stop"][ray] & 3],
                                   model.expected[known])
            stored[row], before[ray] = now, known
            i = np.flatnonzero((event[row] & (TRANSMIT_SPECULAR | TRANSMIT_DIFFUSE) != 0)
                               & (known > 0))
            met, at = known[i] - 1, medium[ray[i]]
            front, back = model.object["medium_front"][met], model.object["medium_back"][met]
            far = np.where(front == at, back, front)
            medium[ray[i]] = np.where(far >= 0, far, at)
        columns["segment/object"] = (stored - 1).astype(np.uint32).view(np.int32)

    def _simple(self, rows, lanes, first, columns):
        """Lanes that need no leg."""
        model, n = self.model, len(columns["ray/source"])
        if lanes["ray/id"].mode == PREDICTED:
            lanes["ray/id"].offer(np.arange(n), np.uint64(first) + np.arange(n, dtype=np.uint64))
        else:
            following = np.array([first], np.uint64)
            for k in range(n):
                following = lanes["ray/id"].offer(np.array([k]), following)[0] + np.uint64(1)
        lanes["ray/weight"].offer(np.arange(n), np.ones(n))
        channel = rows["ray/channel"].astype(np.int64)
        fine = (channel > 0) & (channel <= model.n_channel)
        lanes["ray/wavelength"].offer(np.arange(n), np.where(
            fine, model.wavelengths[np.where(fine, channel - 1, 0)], np.nan))
        lanes["ray/start_primitive"].offer(np.arange(n), np.full(n, -1))
        self._primitives(rows, lanes, columns)
        columns["segment/medium"], _ = lanes["segment/medium"].offer(
            np.arange(len(columns["segment/medium"])), columns["segment/medium"])

    def _places(self, lanes, columns):
        """Places of registrations stand as they are; the cells that they most likely are in."""
        relative, _ = lanes["registration/relative"].offer(
            np.arange(lanes["registration/relative"].n), np.zeros(lanes["registration/relative"].n))
        detector, known = columns["registration/detector"], self.model.detector["cells"]
        fine = (detector >= 0) & (detector < len(known))
        cells = np.ones((len(detector), 2), np.uint64)
        cells[fine] = known[detector[fine]]
        cell = np.minimum(relative.reshape(-1, 2) * cells // np.uint64(65535), cells - np.uint64(1))
        lanes["registration/cell"].offer(np.arange(cell.size), cell.ravel())

    def _primitives(self, rows, lanes, columns):
        model, objects = self.model, columns["segment/object"]
        primitive = np.where(objects < 0, -1, 0).astype(np.int32)
        known = (objects >= 0) & (objects < len(model.is_mesh))
        listed = known & np.append(model.is_mesh, False)[np.where(known, objects, 0)]
        if len(rows["triangle/primitive"]):
            primitive[listed] = rows["triangle/primitive"].view(np.int32)
        lanes["segment/primitive"].offer(np.arange(len(objects)), primitive)


def _between(x, f):
    """The doubles nearest to x that round to the floats f."""
    right = (to_float(x) == f) | (f == 0)
    towards = np.where((x > f.astype(f8)) == (f > 0), np.uint32(1), np.uint32(0xffffffff))
    beside = (f.view(np.uint32) + towards).view(f4)
    return np.where(right, np.where(f == 0, 0.0, x), 0.5 * (f.astype(f8) + beside.astype(f8)))


class _Retrace:
    """The rays of a portion followed leg by leg."""

    def __init__(self, model, rows, lanes, seed, columns, placed):
        self.model, self.lanes, self.seed, self.columns = model, lanes, seed, columns
        self.placed = placed
        flags = int(rows["pool64/value"][0])
        self.films = flags & TABLE != 0 and flags & FILMS != 0
        self.id = lanes["ray/id"].out
        self.count = columns["ray/segment_count"].astype(np.int64)
        self.begin = np.cumsum(self.count) - self.count
        n_hit = columns["ray/registration_count"].astype(np.int64)
        self.hit_ray = np.repeat(np.arange(len(n_hit)), n_hit)
        leg = columns["registration/segment"].astype(np.int64)
        first = np.cumsum(n_hit) - n_hit
        for k in range(1, int(n_hit.max(initial=0))):  # a leg is passed once
            row = first[n_hit > k] + k
            leg[row] = np.maximum(leg[row], leg[row - 1])
        self.hit_leg = np.minimum(leg, self.count[self.hit_ray])
        channel = rows["ray/channel"].astype(np.int64) - 1
        self.channel = np.where(channel < model.n_channel, channel, -1)

    def _offer_point(self, name, row, point):
        """-> the truth as doubles, as near the prediction as the floats allow; how far off."""
        index = (3 * row[:, None] + np.arange(3)).ravel()
        value, right = self.lanes[name].offer(index, to_float(np.stack(point, axis=1)).ravel())
        value, right = value.reshape(-1, 3), right.reshape(-1, 3).all(axis=1)
        truth = columns_of(value)
        off, size = sub(truth, point), dot(truth, truth)
        limit = 1e-6 * self.model.radius
        sane = ~right & (size - size == 0.0)
        wrong = sane & ~(dot(off, off) <= limit * limit)
        near = tuple(_between(point[k], np.ascontiguousarray(value[:, k])) for k in range(3))
        return pick(wrong, truth, pick(sane & ~wrong, near, point)), wrong

    def _offer_normal(self, name, row, normal):
        index = (3 * row[:, None] + np.arange(3)).ravel()
        self.lanes[name].offer(index, np.stack([quantise_cosine(x) for x in normal],
                                               axis=1).ravel())

    def _start(self):
        n, source = len(self.id), self.columns["ray/source"]
        self.position, self.direction = like(n, (0, 0, 0)), like(n, (0, 0, 1))
        normal, listed = like(n, (0, 0, 0)), np.full(n, -1)
        for s in np.unique(source):
            if not 0 <= s < len(self.model.source["type"]):
                continue
            i = np.flatnonzero(source == s)
            position, direction, m, channel = depart(self.model, self.seed, self.id[i], s)
            for k in range(3):
                self.position[k][i], self.direction[k][i] = position[k], direction[k]
                normal[k][i] = m[k]
            listed[i] = channel
        self.position, _ = self._offer_point("ray/start", np.arange(n), self.position)
        self._offer_normal("ray/start_normal", np.arange(n), normal)
        self.on = self.columns["ray/start_object"].copy()
        self.light = Light(self.model, source, listed)
        self.path_length, self.optical = np.zeros(n), np.zeros(n)

    def run(self):
        self._start()
        for k in range(int(self.count.max(initial=0))):
            self._advance(k, np.flatnonzero(self.count > k))
        late = np.flatnonzero(self.hit_leg == self.count[self.hit_ray])
        if len(late):
            zero = like(len(late), (0, 0, 0))
            self._cross(late, zero, zero, zero, *np.zeros((2, len(late))), np.ones(len(late)))
        every = np.arange(len(self.id))
        self.lanes["ray/path_length"].offer(every, self.path_length + 0.0)
        self.lanes["ray/optical_path"].offer(every, self.optical + 0.0)
        left = self.columns["ray/stop"] == 1
        way = np.stack([np.where(left, x, 0.0) for x in self.direction], axis=1)
        self.lanes["ray/end_direction"].offer(np.arange(3 * len(every)), to_float(way).ravel())

    def _advance(self, k, ray):
        """Leg k of these rays."""
        model, light, row = self.model, self.light, self.begin[ray] + k
        event, objects = self.columns["segment/event"][row], self.columns["segment/object"][row]
        medium = self.columns["segment/medium"][row].astype(np.int64)
        known = (medium >= 0) & (medium < len(model.medium["dispersive"]))
        start, direction = take(self.position, ray), take(self.direction, ray)
        met, length, point, normal = find_facing(
            model, objects, self.lanes["segment/primitive"].out[row], self.on[ray], start,
            direction)
        left, absorbed = event & LEFT != 0, ~met & (event & ABSORB != 0)
        length = np.where(met, length, distance_out(model, start, direction))
        at = np.where(known, medium, 0)
        index = np.where(known, np.where(
            model.medium["dispersive"][at] != 0, light.mean(ray, model.medium["n"][at]),
            model.medium["n"][at, light.begin[ray]]), 1.0)
        weak = np.flatnonzero(known & (model.medium["absorbing"][at] != 0) & (length > 0.0)
                              & (absorbed | ~light.single(ray)))
        if len(weak):
            far = light.absorb(ray[weak], at[weak], self.seed, self.id[ray[weak]], k + 1,
                               length[weak], absorbed[weak])
            length[weak] = np.where(absorbed[weak], far, length[weak])
        point = pick(met, point, axpy(length, direction, start))
        point, wrong = self._offer_point("segment/position", row, point)
        way = sub(point, start)
        straight = np.sqrt(dot(way, way))
        length = np.where(wrong, straight, length)
        direction = pick(wrong & (straight > 0.0), scale(way, 1.0 / straight), direction)
        self._offer_normal("segment/normal", row, normal)
        self._offer_colour(ray, row)
        hit = np.flatnonzero(self.hit_leg[self._hits_of(ray)] == k)
        if len(hit):
            hit = self._hits_of(ray)[hit]
            leg = np.searchsorted(ray, self.hit_ray[hit])
            self._cross(hit, take(start, leg), take(point, leg), take(direction, leg),
                        length[leg], self.optical[ray[leg]], index[leg])
        self.path_length[ray] += np.where(left, 0.0, length)
        self.optical[ray] += np.where(left, 0.0, index * length)
        for j in range(3):
            self.direction[j][ray], self.position[j][ray] = direction[j], point[j]
        self.on[ray] = np.where(met, objects, -1)
        go = np.flatnonzero(met & (k + 1 < self.count[ray]))
        if len(go):
            self._meet(k, ray[go], row[go], take(direction, go), take(normal, go))

    def _hits_of(self, ray):
        return np.flatnonzero(np.isin(self.hit_ray, ray, assume_unique=False))

    def _offer_colour(self, ray, row):
        n = self.model.n_channel
        self.light.quantise(ray)
        index = (n * row[:, None] + np.arange(n)).ravel()
        value, right = self.lanes["segment/colour"].offer(index, self.light.quantised[ray].ravel())
        bad = ~right.reshape(-1, n).all(axis=1)
        if bad.any():
            self.light.set(ray[bad], value.reshape(-1, n)[bad])

    def _cross(self, hit, start, end, direction, length, optical, index):
        """Registrations `hit` on the legs given."""
        detector = self.columns["registration/detector"][hit]
        cell, relative = np.zeros((2, len(hit), 2), np.uint16)
        path = np.zeros(len(hit))
        for d in np.unique(detector):
            if not 0 <= d < len(self.model.detector["type"]):
                continue
            i = np.flatnonzero(detector == d)
            cell[i], relative[i], distance = cross_detector(
                self.model, d, take(start, i), take(end, i), take(direction, i), length[i])
            path[i] = optical[i] + index[i] * distance
        pair = (2 * hit[:, None] + np.arange(2)).ravel()
        triple = (3 * hit[:, None] + np.arange(3)).ravel()
        if not self.placed:
            self.lanes["registration/cell"].offer(pair, cell.ravel())
            self.lanes["registration/relative"].offer(pair, relative.ravel())
        self.lanes["registration/direction"].offer(
            triple, to_float(np.stack(direction, axis=1)).ravel())
        self.lanes["registration/optical_path"].offer(hit, path + 0.0)

    def _meet(self, k, ray, row, direction, normal):
        """Direction and colour behind the surface."""
        model, columns = self.model, self.columns
        n_medium = len(model.medium["dispersive"])
        near = columns["segment/medium"][row].astype(np.int64)
        beyond = columns["segment/medium"][row + 1].astype(np.int64)
        near, beyond = (np.where((m >= 0) & (m < n_medium), m, -1) for m in (near, beyond))
        event, objects = columns["segment/event"][row], columns["segment/object"][row]
        cosine = dot(direction, normal)
        front = cosine < 0.0
        normal = pick(front, normal, scale(normal, -1.0))
        channel = self.channel[ray]
        turned = turn(model, self.seed, self.id[ray], k + 1, event, near, beyond,
                      np.maximum(channel, 0), direction, normal)
        for j in range(3):
            self.direction[j][ray] = turned[j]
        go = np.flatnonzero((near >= 0) & (cosine == cosine))
        o = model.object
        surface = np.where(front, o["surface_front"][objects], o["surface_back"][objects])
        far = np.where(front, o["medium_back"][objects], o["medium_front"][objects])
        far = np.where(far >= 0, far, near)
        size = np.minimum(np.where(cosine < 0.0, -cosine, cosine), 1.0)
        self.light.meet(ray[go], surface[go], near[go], far[go], size[go], event[go], channel[go], front[go],
                        self.films)
