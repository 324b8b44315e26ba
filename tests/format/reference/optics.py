# SPDX-License-Identifier: MIT
"""The scene of a ray map in numbers, and what they say of a leg whose end is known: where it starts,
where it meets the surface, where it goes on, what colour it has, where it crosses a detector. The
formulas of docs/encoding.md; rays side by side, vectors as (x, y, z) of arrays, every sum in the
order given there.
"""
import struct

import numpy as np
import yaml

f8, f4 = np.float64, np.float32
PI = 3.14159265358979323846
(REFLECT_SPECULAR, REFLECT_DIFFUSE, TRANSMIT_SPECULAR, TRANSMIT_DIFFUSE, TOTAL_REFLECTION, ABSORB,
 LEFT, LIMIT, ERROR) = (1 << k for k in (0, 1, 2, 3, 4, 5, 10, 11, 12))


# ---- numbers ----

def philox(seed, ray, step, slot):
    """Philox4x32-10 (Salmon et al. 2011): four numbers in (0, 1) per ray."""
    word = np.uint64(0xffffffff)
    c = [ray & word, ray >> np.uint64(32), np.broadcast_to(np.uint64(step), ray.shape),
         np.full(ray.shape, slot, np.uint64)]
    key = [seed & 0xffffffff, seed >> 32]
    for _ in range(10):
        a, b = c[0] * np.uint64(0xD2511F53), c[2] * np.uint64(0xCD9E8D57)
        c = [(b >> np.uint64(32)) ^ c[1] ^ np.uint64(key[0]), b & word,
             (a >> np.uint64(32)) ^ c[3] ^ np.uint64(key[1]), a & word]
        key = [(key[0] + 0x9E3779B9) & 0xffffffff, (key[1] + 0xBB67AE85) & 0xffffffff]
    return [(x.astype(f8) + 0.5) * 2.0 ** -32 for x in c]


def azimuth(turns):
    """Cosine and sine of a number of turns in [0, 1]."""
    quarter = (4.0 * turns + 0.5).astype(np.int64)
    x = 2.0 * PI * (turns - 0.25 * quarter.astype(f8))
    y = x * x
    y2 = y * y
    y4 = y2 * y2
    s = ((1.0 - y * (1.0 / 6.0)) + y2 * (1.0 / 120.0 - y * (1.0 / 5040.0))) + y4 * (
        (1.0 / 362880.0 - y * (1.0 / 39916800.0))
        + y2 * (1.0 / 6227020800.0 - y * (1.0 / 1307674368000.0)))
    c = ((1.0 - y * (1.0 / 2.0)) + y2 * (1.0 / 24.0 - y * (1.0 / 720.0))) + y4 * (
        (1.0 / 40320.0 - y * (1.0 / 3628800.0))
        + y2 * ((1.0 / 479001600.0 - y * (1.0 / 87178291200.0))
                + y2 * (1.0 / 20922789888000.0)))
    s = s * x
    odd, back = (quarter & 1) != 0, (quarter & 2) != 0
    along, across = np.where(odd, -s, c), np.where(odd, c, s)
    return np.where(back, -along, along), np.where(back, -across, across)


def portable_log(x):
    bits = x.view(np.uint64)
    exponent = (bits >> np.uint64(52)).astype(np.int64) - 1023
    x = ((bits & np.uint64(0xfffffffffffff)) | np.uint64(1023 << 52)).view(f8)
    high = x > 1.41421356237309504880
    x = np.where(high, x * 0.5, x)
    exponent = exponent + high
    s = (x - 1.0) / (x + 1.0)
    y = s * s
    total = np.zeros_like(x)
    for k in range(23, 0, -2):
        total = total * y + 1.0 / k
    return exponent.astype(f8) * 0.69314718055994530942 + 2.0 * s * total


def one_minus_exp(x):
    """1 - exp(-x), x >= 0."""
    small = x < 700.0
    x = np.where(small, x, 0.0)
    n = (x * 1.44269504088896340736 + 0.5).astype(np.int64)
    r = n.astype(f8) * 0.69314718055994530942 - x
    total = np.zeros_like(x)
    for k in range(15, 1, -1):
        total = (total + 1.0) * r / float(k)
    e = (total + 1.0) * r
    scale = np.ldexp(1.0, -n)
    return np.where(small, np.where(n == 0, -e, 1.0 - scale * (1.0 + e)), 1.0)


def portable_exp(x):
    """exp(x) for -700 < x <= 0; 0 below."""
    small = x > -700.0
    x = np.where(small, x, 0.0)
    n = np.trunc(x * 1.44269504088896340736 - 0.5)
    n = np.where(x < 0.0, n, 0.0)
    r = (x - n * 0.693147180369123816490) - n * 1.90821492927058770002e-10
    y = r * r
    even, odd = 1.0 / 87178291200.0, 1.0 / 6227020800.0
    for a, b in ((479001600.0, 39916800.0), (3628800.0, 362880.0), (40320.0, 5040.0), (720.0, 120.0), (24.0, 6.0)):
        even, odd = even * y + 1.0 / a, odd * y + 1.0 / b
    even = even * y + 0.5
    return np.where(small, np.ldexp(1.0, n.astype(np.int64)) * (1.0 + (r + y * (even + r * odd))), 0.0)


def angle(x, y):
    """Angle of (x, y) with the x axis, y >= 0."""
    a = np.where(x < 0.0, -x, x)
    low, high = np.where(a < y, a, y), np.where(a < y, y, a)
    t = np.where(high > 0.0, low / high, 0.0)
    for _ in range(4):
        t = t / (1.0 + np.sqrt(1.0 + t * t))
    square, total = t * t, np.zeros_like(t)
    for k in range(17, 0, -2):
        total = 1.0 / k - total * square
    total = 16.0 * (t * total)
    total = np.where(a < y, 1.57079632679489661923 - total, total)
    return np.where(x < 0.0, 3.14159265358979323846 - total, total)


# Vectors are tuples (x, y, z) of arrays: the order of every sum is written out.

def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def axpy(s, b, a):
    return tuple(a[k] + s * b[k] for k in range(3))


def scale(a, s):
    return tuple(x * s for x in a)


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normalize(a):
    return scale(a, 1.0 / np.sqrt(dot(a, a)))


def pick(mask, a, b):
    return tuple(np.where(mask, x, y) for x, y in zip(a, b))


def take(a, index):
    return tuple(x[index] for x in a)


def columns_of(rows):
    return tuple(np.ascontiguousarray(rows[..., k], f8) for k in range(3))


def affine_vector(m, v):
    """m: [..., 12] rows of the matrix, then the translation."""
    return tuple(m[..., 3 * i] * v[0] + m[..., 3 * i + 1] * v[1] + m[..., 3 * i + 2] * v[2]
                 for i in range(3))


def affine_point(m, p):
    v = affine_vector(m, p)
    return tuple(v[i] + m[..., 9 + i] for i in range(3))


def affine_transposed(m, v):
    return tuple(m[..., i] * v[0] + m[..., 3 + i] * v[1] + m[..., 6 + i] * v[2] for i in range(3))


def basis(n):
    sign = np.copysign(1.0, n[2])
    a = -1.0 / (sign + n[2])
    b = n[0] * n[1] * a
    return ((1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]),
            (b, sign + n[1] * n[1] * a, -n[1]))


def to_float(x):
    return x.astype(f4) + f4(0.0)


def quantise_cosine(x):
    bounded = np.where(x > -1.0, np.where(x < 1.0, x, 1.0), -1.0)
    scaled = 32767.0 * bounded
    return np.trunc(scaled + np.where(scaled < 0.0, -0.5, 0.5)).astype(np.int16)


def quantise_colour(share):
    """[n, channels] shares -> u16 that sum to 65535, by largest remainder."""
    total = np.zeros(len(share))
    for k in range(share.shape[1]):
        total = total + share[:, k]
    value = 65535.0 * np.fmax(0.0, np.fmin(1.0, share / total[:, None]))
    quantised = value.astype(np.int64)
    rest = value - quantised
    missing = 65535 - quantised.sum(axis=1)
    row = np.arange(len(share))
    while (missing > 0).any():
        up = missing > 0
        best = rest.argmax(axis=1)
        quantised[row[up], best[up]] += 1
        rest[row[up], best[up]] -= 1.0
        missing = missing - up
    while (missing < 0).any():
        down = missing < 0
        best = np.where(quantised > 0, rest, np.inf).argmin(axis=1)
        quantised[row[down], best[down]] -= 1
        rest[row[down], best[down]] += 1.0
        missing = missing + down
    return quantised.astype(np.uint16)


# ---- the scene ----

class Model:
    """The numbers of /model/SPACE, by group and name, and the meshes of /scene/bundle."""

    def __init__(self, index, space):
        group = index[f"model/{space}"]
        for name in group:
            setattr(self, name, {key: data[:] for key, data in group[name].items()})
        self.wavelengths = index["space/wavelength_nm"][space]
        self.n_channel = self.medium["n"].shape[1] if self.medium["n"].ndim > 1 else 1
        for table in (self.surface, self.medium, self.source):
            for key, value in table.items():
                if value.ndim == 1 and key in ("n", "absorption", "colour", "reflect_specular",
                                               "reflect_diffuse", "transmit_specular",
                                               "transmit_diffuse", "metal_n", "metal_k"):
                    table[key] = value[:, None]
        self.radius, self.centre = self.sphere["radius"][0], self.sphere["centre"][0]
        self.epsilon = 1e-12 * self.radius
        text, meshes = _bundle(index["scene/bundle"][:].tobytes())
        names = [name.decode() for name in index["name/geometry"][:]]
        self.mesh = [meshes.get(name) for name in names]
        if "film" in group:
            self._films(yaml.safe_load(text), [name.decode() for name in index["name/surface"][:]])
        self.source_colour = quantise_colour(self.source["colour"])
        self.quota = np.bincount(self.schedule["source"], minlength=len(self.source["type"]))
        self._shapes()
        self._expected()

    def _films(self, scene, surfaces):
        """The layers of each film, [channel][layer], from the outside on; the film of each surface."""
        names, at = list(scene["films"]), 0
        self.layers, self.on_front = [], []
        for film in scene["films"].values():
            n = len(film.get("layers", []))  # measured ones are not read here
            own = np.arange(at, at + self.n_channel * n).reshape(self.n_channel, n)
            self.layers.append([self.film[name][own] for name in ("n", "k", "thickness")])
            self.on_front.append(film.get("substrate") == "front")  # or, but for lenses, on the back
            at += own.size
        self.film_of = [names.index(coat["film"]) if isinstance(coat, dict) and "film" in coat else -1
                        for coat in (scene["surfaces"][name].get("coat") for name in surfaces)]

    def _shapes(self):
        g = {k.split(".")[-1]: v for k, v in self.geometry.items()}
        self.shape = g
        n = len(g["kind"])
        self.alpha, self.gamma, self.delta, self.eps, self.middle, self.sheet = np.zeros((6, n))
        conic, tube, ball = g["type"] == 0, g["type"] == 3, g["type"] == 4
        self.alpha[conic] = g["curvature"][conic]
        self.gamma[conic] = g["curvature"][conic] * (1 + g["conic"][conic])
        self.delta[conic] = -1
        self.sheet[conic] = (1 + g["conic"][conic]) * g["curvature"][conic]
        for k in np.flatnonzero(tube & (g["kind"] == 0)):
            m = (g["radius2"][k] - g["radius"][k]) / g["length"][k]
            self.alpha[k], self.gamma[k] = 1, -m * m
            self.delta[k], self.eps[k] = -m * g["radius"][k], -g["radius"][k] * g["radius"][k]
            self.middle[k] = 0.5 * g["length"][k]
        self.alpha[ball] = self.gamma[ball] = 1
        self.eps[ball] = -g["radius"][ball] * g["radius"][ball]
        m = self.object["to_world"]
        gram = np.stack([m[:, i] * m[:, j] + m[:, 3 + i] * m[:, 3 + j] + m[:, 6 + i] * m[:, 6 + j]
                         - (i == j) for i in range(3) for j in range(3)], axis=1)
        self.rigid = ~(np.abs(gram) > 1e-12).any(axis=1)
        self.is_mesh = self.geometry["kind"][self.object["geometry"]] == 1

    def _expected(self):
        """By 1 + object (0: none): the event expected where a leg ends on it; the medium in
        which it is expected to be met again."""
        s, usual = self.surface, []
        words = np.array([REFLECT_SPECULAR, REFLECT_DIFFUSE, TRANSMIT_SPECULAR, TRANSMIT_DIFFUSE])
        for k, kind in enumerate(s["type"]):
            p = [s[name][k, 0] for name in ("reflect_specular", "reflect_diffuse",
                                            "transmit_specular", "transmit_diffuse")]
            usual.append({0: TRANSMIT_SPECULAR, 1: REFLECT_SPECULAR, 2: REFLECT_DIFFUSE,
                          3: ABSORB}.get(int(kind), int(words[int(np.argmax(p))])))
        usual = np.array(usual, np.uint32)
        front, back = usual[self.object["surface_front"]], usual[self.object["surface_back"]]
        self.expected = np.append(np.uint32(0), np.where(front == ABSORB, back, front))
        o, kind = self.object, self.shape["type"][self.object["geometry"]]
        closed = (self.is_mesh | (kind == 4)) & (o["medium_back"] != o["medium_front"])
        nowhere = np.iinfo(np.int32).min
        self.inside = np.append(nowhere, np.where(closed, o["medium_back"], nowhere))


def _bundle(blob):
    """Of a packed scene its text and {geometry: (vertices, triangles)}."""
    at = 8

    def number(form):
        nonlocal at
        at += struct.calcsize(form)
        return struct.unpack_from(form, blob, at - struct.calcsize(form))[0]

    def text():
        nonlocal at
        n = number("<Q")
        n = 0 if n == 2 ** 64 - 1 else n
        at += n
        return blob[at - n:at].decode()

    def array(dtype, *shape):
        nonlocal at
        data = np.frombuffer(blob, dtype, int(np.prod(shape)), at).reshape(shape)
        at += data.nbytes
        return data

    text()
    scene = text()
    for _ in range(2):  # simulation, colour
        text()
    for _ in range(3):  # only, without, set
        for _ in range(number("<Q")):
            text()
    number("<I")
    meshes = {}
    for _ in range(number("<Q")):
        name = text()
        n_vertex, n_triangle, n_face = (number("<Q") for _ in range(3))
        vertex = array("<f4", n_vertex, 3).astype(f8)
        triangle = array("<u4", n_triangle, 3)
        array("<u4", n_triangle)
        for _ in range(n_face):
            text()
        meshes[name] = (vertex, triangle)
    return scene, meshes


# ---- where a ray starts ----

def _about_z(one_minus_cos, turns):
    sine = np.sqrt(one_minus_cos * (2.0 - one_minus_cos))
    x, y = azimuth(turns)
    return (sine * x, sine * y, 1.0 - one_minus_cos)


def _corners(mesh, triangle):
    vertex, triangles = mesh
    return [columns_of(vertex[triangles[triangle, k]]) for k in range(3)]


def like(n, v):
    return tuple(np.full(n, float(x)) for x in v)


def depart(model, seed, ray, s):
    """Rays of source s -> position, direction, normal (0 without a surface), channel (-1: all)."""
    source, n = model.source, len(ray)
    kind, shape, frame = source["type"][s], source["shape"][s], source["frame"][s]
    no_normal, channel = like(n, (0, 0, 0)), np.full(n, -1)
    if kind == 3:
        rows, first = int(source["n_list"][s]), int(source["n_list"][:s].sum())
        turn, period = ray % np.uint64(len(model.schedule["rank"])), len(model.schedule["rank"])
        ordinal = ((ray // np.uint64(period)).astype(np.int64) * model.quota[s]
                   + model.schedule["rank"][turn.astype(np.int64)].astype(np.int64))
        row = first + ordinal % rows
        return (columns_of(model.list["origin"][row]), columns_of(model.list["direction"][row]),
                no_normal, model.list["channel"][row])
    axis = normalize(like(1, affine_vector(frame, (0.0, 0.0, 1.0))))
    normal = tuple(np.full(n, x[0]) for x in axis)
    u = philox(seed, ray, 0, 0) if shape != 0 else [np.full(n, 0.5)] * 4
    size, local = source["shape_size"][s], like(n, (0, 0, 0))
    if shape == 1:
        r = size[0] * np.sqrt(u[0])
        x, y = azimuth(u[1])
        local = (r * x, r * y, np.zeros(n))
    elif shape == 2:
        local = ((u[0] - 0.5) * size[0], (u[1] - 0.5) * size[1], np.zeros(n))
    if shape == 3:
        position, normal = _on_mesh(model, s, u)
    else:
        position = affine_point(frame, local)
    if kind == 0 and source["distribution"][s] == 0:
        return position, normal, no_normal, channel
    way = philox(seed, ray, 0, 1)
    if kind < 2:
        local = _point_direction(model, s, way)
        return position, normalize(affine_vector(frame, local)), no_normal, channel
    x, y = basis(normal if shape == 3 else tuple(np.full(n, v[0]) for v in axis))
    local = _about_z(1.0 - np.sqrt(way[0]), way[1])
    direction = normalize(axpy(local[0], x, axpy(local[1], y, scale(normal, local[2]))))
    return position, direction, normal, channel


def _point_direction(model, s, u):
    source = model.source
    how = source["distribution"][s]
    if how == 0:
        return _about_z(2.0 * u[0], u[1])
    if how == 1:
        turns = source["cone_rad"][s] / (4.0 * PI)
        _, half = azimuth(np.array([turns if 0.0 <= turns <= 1.0 else 0.0]))
        return _about_z(u[0] * (2.0 * half[0] * half[0]), u[1])
    if how == 3:
        return _about_z(_profile_draw(model.profile, s, u[0]), u[1])
    return _about_z(one_minus_exp(-portable_log(u[0]) / (source["cosine_power"][s] + 1.0)), u[1])


def _profile_draw(profile, s, u):
    own = profile["source"] == s
    x, f, below = (profile[k][own] for k in ("one_minus_cos", "intensity", "below"))
    low = np.clip(np.searchsorted(below, u, side="right") - 1, 0, len(x) - 2)
    width = x[low + 1] - x[low]
    slope, rest = (f[low + 1] - f[low]) / width, (u - below[low]) / (2.0 * PI)
    divisor = f[low] + np.sqrt(np.maximum(f[low] * f[low] + 2.0 * slope * rest, 0.0))
    t = np.where(divisor > 0.0, 2.0 * rest / np.where(divisor > 0.0, divisor, 1.0), 0.0)
    return x[low] + np.minimum(t, width)


def _on_mesh(model, s, u):
    source, geometry = model.source, model.source["shape_geometry"]
    frame = source["frame"][s]
    before = sum(len(model.mesh[geometry[k]][1]) for k in range(s) if source["shape"][k] == 3)
    n = len(model.mesh[geometry[s]][1])
    cdf = model.triangle_cdf["value"][before:before + n]
    triangle = np.minimum(np.searchsorted(cdf, u[2], side="right"), n - 1)
    corner = [affine_point(frame, c) for c in _corners(model.mesh[geometry[s]], triangle)]
    a, b = sub(corner[1], corner[0]), sub(corner[2], corner[0])
    normal = normalize(cross(a, b))
    column = [tuple(frame[3 * i + j] for i in range(3)) for j in range(3)]
    if dot(column[0], cross(column[1], column[2])) < 0.0:
        normal = scale(normal, -1.0)
    root = np.sqrt(u[0])
    return axpy(root * (1.0 - u[1]), a, axpy(root * u[1], b, corner[0])), normal


# ---- where a leg ends ----

class _Quadric:
    """alpha (x^2 + y^2) + gamma z^2 + 2 delta z + epsilon = 0 in an object's frame."""

    def __init__(self, model, g):
        self.a, self.g, self.d, self.e = (x[g] for x in (model.alpha, model.gamma, model.delta,
                                                         model.eps))
        self.middle, self.sheet = model.middle[g], model.sheet[g]
        shape = model.shape
        self.kind, self.length = shape["type"][g], shape["length"][g]
        self.outer2 = shape["aperture"][g] * shape["aperture"][g]
        self.inner2 = shape["inner"][g] * shape["inner"][g]

    def half_gradient(self, p):
        return (self.a * p[0], self.a * p[1], self.g * p[2] + self.d)

    def belongs(self, p):
        if self.kind == 3:
            return (p[2] >= 0) & (p[2] <= self.length)
        if self.kind == 4:
            return np.ones(p[2].shape, bool)
        s = p[0] * p[0] + p[1] * p[1]
        return (s <= self.outer2) & (s >= self.inner2) & (1 - self.sheet * p[2] >= -2.0 ** -50)

    def meet(self, behind, origin, d):
        """First root ahead that belongs to the surface, or else the last -> found, t, point."""
        shifted = (origin[0], origin[1], origin[2] - self.middle)
        shift = -dot(shifted, d) / dot(d, d)
        p = axpy(shift, d, origin)
        a = self.a * (d[0] * d[0] + d[1] * d[1]) + self.g * d[2] * d[2]
        b = dot(self.half_gradient(p), d)
        c = (self.a * (p[0] * p[0] + p[1] * p[1]) + (self.g * p[2] + 2 * self.d) * p[2]
             + self.e)
        disc = b * b - a * c
        real = disc >= 0
        root = np.sqrt(np.where(real, disc, 0.0))
        q = np.where(b < 0, root - b, -(b + root))
        near, far = c / q, q / a
        two = real & (q != 0) & (a != 0) & (far - far == 0)
        found = real & ((q != 0) | (a != 0))
        first = np.where(q == 0, 0.0, np.where(two & ~(near < far), far, near))
        last = np.where(near < far, far, near)
        t, point = shift + first, axpy(first, d, p)
        other = two & ~((t > behind) & self.belongs(point))
        return (found, np.where(other, shift + last, t),
                pick(other, axpy(last, d, p), point))

    def cross(self, origin, d):
        a = self.a * (d[0] * d[0] + d[1] * d[1]) + self.g * d[2] * d[2]
        t = -2 * dot(self.half_gradient(origin), d) / a
        return t, axpy(t, d, origin)

    def normal(self, p):
        g = self.half_gradient(p)
        if self.kind == 0:
            g = scale(g, -1)
        length = np.sqrt(dot(g, g))
        return pick(length > 0, scale(g, 1 / length), like(len(length), (0, 0, 1)))


def _descend_asphere(shape, g, t, origin, d):
    c, k, n = shape["curvature"][g], shape["conic"][g], int(shape["n_asphere"][g])
    for step in range(8):
        p = axpy(t, d, origin)
        s = p[0] * p[0] + p[1] * p[1]
        rest = 1 - (1 + k) * c * c * s
        root = np.sqrt(np.where(rest > 0, rest, 0))
        poly, rate = np.zeros_like(s), np.zeros_like(s)
        for i in range(n - 1, -1, -1):
            poly = (poly + shape["asphere"][g][i]) * s
            rate = rate * s + (i + 1) * shape["asphere"][g][i]
        slope = np.where(root > 0, c / (2 * root) + rate, rate)
        gap = p[2] - (c * s / (1 + root) + poly)
        gap_rate = d[2] - 2 * slope * (p[0] * d[0] + p[1] * d[1])
        last = t
        if step < 7:
            t = np.where(gap_rate != 0, t - gap / gap_rate, t)
    return last, p, normalize((-2 * slope * p[0], -2 * slope * p[1], np.ones_like(s)))


def _meet_triangle(mesh, primitive, origin, direction):
    corner = _corners(mesh, primitive)
    d, origin = np.stack(direction), np.stack(origin)
    row = np.arange(d.shape[1])
    z = np.where(np.abs(d[0]) > np.abs(d[1]), 0, 1)
    z = np.where(np.abs(d[2]) > np.abs(d[z, row]), 2, z)
    x = np.where(z == 2, 0, z + 1)
    y = np.where(x == 2, 0, x + 1)
    inverse = 1 / d[z, row]
    shear_x, shear_y = d[x, row] * inverse, d[y, row] * inverse
    p = []
    for c in corner:
        v = np.stack(c)
        height = v[z, row] - origin[z, row]
        p.append(((v[x, row] - origin[x, row]) - shear_x * height,
                  (v[y, row] - origin[y, row]) - shear_y * height, height))
    area = [p[1][0] * p[2][1] - p[1][1] * p[2][0], p[2][0] * p[0][1] - p[2][1] * p[0][0],
            p[0][0] * p[1][1] - p[0][1] * p[1][0]]
    total = area[0] + area[1] + area[2]
    w = [a / total for a in area]
    t = (w[0] * p[0][2] + w[1] * p[1][2] + w[2] * p[2][2]) * inverse
    e1, e2 = sub(corner[1], corner[0]), sub(corner[2], corner[0])
    return t, axpy(w[2], e2, axpy(w[1], e1, corner[0])), cross(e1, e2)


def face_object(model, o, primitive, own, origin, direction):
    """Legs that end on object o -> found, t, position, unit normal."""
    g, n = int(model.object["geometry"][o]), len(own)
    to_local, to_world = model.object["to_local"][o], model.object["to_world"][o]
    at, d = affine_point(to_local, origin), affine_vector(to_local, direction)
    found, kind = np.ones(n, bool), model.shape["type"][g]
    if model.is_mesh[o]:
        count = len(model.mesh[g][1])
        found = (primitive >= 0) & (primitive < count)
        t, point, normal = _meet_triangle(model.mesh[g], np.where(found, primitive, 0), at, d)
    elif kind in (1, 2):
        t = -at[2] / d[2]
        point = (at[0] + t * d[0], at[1] + t * d[1], np.zeros(n))
        normal = like(n, (0, 0, 1))
    else:
        quadric = _Quadric(model, g)
        found, t, point = quadric.meet(-model.epsilon, at, d)
        t_own, point_own = quadric.cross(at, d)
        found, t, point = found | own, np.where(own, t_own, t), pick(own, point_own, point)
        if kind == 0 and model.shape["n_asphere"][g] > 0:
            t, point, normal = _descend_asphere(model.shape, g, t, at, d)
        else:
            normal = quadric.normal(point)
    world = affine_transposed(to_local, normal)
    if not model.rigid[o] or model.is_mesh[o]:
        world = normalize(world)
    return found, np.where(t > 0, t, 0.0), affine_point(to_world, point), world


def find_facing(model, objects, primitive, from_object, origin, direction):
    n = len(objects)
    found, t = np.zeros(n, bool), np.zeros(n)
    position, normal = [np.zeros(n) for _ in range(3)], [np.zeros(n) for _ in range(3)]
    for o in np.unique(objects):
        if not 0 <= o < len(model.is_mesh):
            continue
        i = np.flatnonzero(objects == o)
        hit, distance, p, m = face_object(model, o, primitive[i], from_object[i] == o,
                                          take(origin, i), take(direction, i))
        i, hit = i[hit], hit
        found[i], t[i] = True, distance[hit]
        for k in range(3):
            position[k][i], normal[k][i] = p[k][hit], m[k][hit]
    return found, t, tuple(position), tuple(normal)


def distance_out(model, position, direction):
    off = sub(position, tuple(model.centre))
    along = dot(off, direction)
    gap = model.radius * model.radius - dot(off, off)
    root = np.sqrt(np.where(gap > 0.0, along * along + gap, 0.0))
    return np.where(gap > 0.0, np.where(along > 0.0, gap / (root + along), root - along), 0.0)


# ---- directions ----

def turn(model, seed, ray, step, event, near, far, channel, direction, normal):
    """Directions after a surface whose normal points to the light."""
    def reflected(d, m):
        return normalize(axpy(-2.0 * dot(d, m), m, d))

    diffuse = event & (REFLECT_DIFFUSE | TRANSMIT_DIFFUSE) != 0
    mirror = ~diffuse & (event & (REFLECT_SPECULAR | TOTAL_REFLECTION) != 0)
    refract = ~diffuse & ~mirror & (event & TRANSMIT_SPECULAR != 0) & (near >= 0) & (far >= 0)
    out = [x.copy() for x in direction]

    def put(index, v):
        for k in range(3):
            out[k][index] = v[k]

    i = np.flatnonzero(diffuse)
    if len(i):
        u = philox(seed, ray[i], step, 2)
        through = event[i] & TRANSMIT_DIFFUSE != 0
        m = take(normal, i)
        m = pick(through, scale(m, -1.0), m)
        x, y = basis(m)
        r = np.sqrt(u[2])
        cosine, sine = azimuth(u[3])
        plane = axpy(r * cosine, x, scale(y, r * sine))
        put(i, axpy(np.sqrt(1.0 - u[2]), m, plane))
    i = np.flatnonzero(mirror)
    if len(i):
        put(i, reflected(take(direction, i), take(normal, i)))
    i = np.flatnonzero(refract)
    if len(i):
        n1, n2 = model.medium["n"][near[i], channel[i]], model.medium["n"][far[i], channel[i]]
        d, m = take(direction, i), take(normal, i)
        cosine = dot(d, m)
        tangent = scale(axpy(-cosine, m, d), n1 / n2)
        cos2 = 1.0 - dot(tangent, tangent)
        bent = axpy(-np.sqrt(np.where(cos2 > 0.0, cos2, 0.0)), m, tangent)
        put(i, pick(n1 == n2, d, pick(cos2 <= 0.0, reflected(d, m), bent)))
    return tuple(out)


# ---- colours ----

class Light:
    """Shares of the channels of n rays; live ones are [begin, end)."""

    def __init__(self, model, source, channel):
        n, c = len(source), model.n_channel
        known = (source >= 0) & (source < len(model.source_colour))
        at = np.where(known, source, 0)
        self.model, self.share = model, model.source["colour"][at].copy()
        self.quantised = model.source_colour[at].copy()
        self.begin, self.end = np.zeros(n, np.int64), np.full(n, c)
        self.changed = np.zeros(n, bool)
        self.trim(np.arange(n))
        self.collapse(np.flatnonzero(~known), 0)
        listed = np.flatnonzero((channel >= 0) & (channel < c) & known)
        self.collapse(listed, channel[listed])

    def trim(self, i):
        channels = np.arange(self.share.shape[1])
        live = (self.share[i] > 0.0) & (channels >= self.begin[i, None]) & (
            channels < self.end[i, None])
        some = live.any(axis=1)
        first, last = live.argmax(axis=1), live.shape[1] - live[:, ::-1].argmax(axis=1)
        self.begin[i] = np.where(some, first, self.end[i] - 1)
        self.end[i] = np.where(some, last, self.end[i])

    def collapse(self, i, channel):
        self.share[i], self.quantised[i] = 0.0, 0
        self.share[i, channel], self.quantised[i, channel] = 1.0, 65535
        self.begin[i], self.end[i] = channel, np.asarray(channel) + 1
        self.changed[i] = False

    def set(self, i, quantised):
        self.share[i], self.quantised[i] = quantised.astype(f8) / 65535.0, quantised
        self.begin[i], self.end[i] = 0, self.share.shape[1]
        self.changed[i] = False
        self.trim(i)

    def single(self, i):
        return self.end[i] - self.begin[i] == 1

    def mean(self, i, value):
        total = np.zeros(len(i))
        for k in range(self.share.shape[1]):
            live = (k >= self.begin[i]) & (k < self.end[i])
            total = np.where(live, total + self.share[i, k] * value[:, k], total)
        return np.where(self.single(i), value[np.arange(len(i)), self.begin[i]], total)

    def quantise(self, i):
        i = i[self.changed[i]]
        self.changed[i] = False
        total = np.zeros(len(i))
        for k in range(self.share.shape[1]):
            total = total + self.share[i, k]
        i = i[(total > 0.0) & (total < 1e300)]
        if len(i):
            self.quantised[i] = quantise_colour(self.share[i])

    def weigh(self, i, p):
        channels = np.arange(self.share.shape[1])
        live = (channels >= self.begin[i, None]) & (channels < self.end[i, None])
        alike = ((p == p[np.arange(len(i)), self.begin[i]][:, None]) | ~live).all(axis=1)
        i, p, live = i[~alike], p[~alike], live[~alike]
        if not len(i):
            return
        total = self.mean(i, p)
        self.share[i] = np.where(live, self.share[i] * (p / total[:, None]), self.share[i])
        self.changed[i] = True
        self.trim(i)

    def meet(self, i, surface, near, far, cosine, event, channel, front, films):
        """The light of rays i from before a surface to after it. films: those are predicted."""
        go = ~self.single(i)
        i, surface, near, far, cosine, event, channel, front = (
            x[go] for x in (i, surface, near, far, cosine, event, channel, front))
        kind = self.model.surface["type"][surface]
        coated = self.model.surface["coat"][surface] == 3
        if coated.any():
            self._meet_film(*(x[coated] for x in (i, surface, near, far, cosine, event, channel, front)), films)
            kind = np.where(coated & (films | (kind == 0)), -1, kind)
        for rays, how in ((kind == 0, self._meet_fresnel), (kind > 0, self._meet_shares)):
            if rays.any():
                how(*(x[rays] for x in (i, surface, near, far, cosine, event, channel)))

    def _meet_fresnel(self, i, surface, near, far, cosine, event, channel):
        m, s = self.model.medium, self.model.surface
        coat = s["coat"][surface]
        dispersive = (m["dispersive"][near] | m["dispersive"][far]) != 0
        one = (event == TRANSMIT_SPECULAR) & dispersive & (channel >= 0)
        self.collapse(i[one], channel[one])
        go = (dispersive | (coat == 1)) & ~one
        i, surface, near, far, cosine, event, coat = (
            x[go] for x in (i, surface, near, far, cosine, event, coat))
        if not len(i):
            return
        n1, n2, cosine = m["n"][near], m["n"][far], cosine[:, None]
        eta = n1 / n2
        sin2 = eta * eta * (1.0 - cosine * cosine)
        total = (n1 != n2) & (sin2 >= 1.0)
        cos_t = np.sqrt(np.where(sin2 < 1.0, 1.0 - sin2, 0.0))
        sum_s, sum_p = n1 * cosine + n2 * cos_t, n2 * cosine + n1 * cos_t
        both = 1.0 / (sum_s * sum_p)
        rs = (n1 * cosine - n2 * cos_t) * sum_p * both
        rp = (n2 * cosine - n1 * cos_t) * sum_s * both
        r = np.where(n1 == n2, 0.5 * (0.0 + 0.0), 0.5 * (rs * rs + rp * rp))
        r = np.where((coat == 1)[:, None], s["reflect_specular"][surface],
                     np.where((coat == 2)[:, None], 0.0, r))
        r = np.where(total, 1.0, r)
        channels = np.arange(r.shape[1])
        live = (channels >= self.begin[i, None]) & (channels < self.end[i, None])
        go = ~(total | ~(self.share[i] > 0.0) | ~live).all(axis=1)
        r = np.where((event == REFLECT_SPECULAR)[:, None], r, 1.0 - r)
        self.weigh(i[go], r[go])

    def _meet_film(self, i, surface, near, far, cosine, event, channel, front, films):
        m, s = self.model.medium, self.model.surface
        metal = s["type"][surface] == 1
        one = ((event == TRANSMIT_SPECULAR) & ~metal & (channel >= 0)
               & ((m["dispersive"][near] | m["dispersive"][far]) != 0))
        self.collapse(i[one], channel[one])
        for which, side in {(which, side) for which in surface for side in (False, True)} if films else ():
            k = np.flatnonzero(~one & (surface == which) & (front == side))
            is_metal, film = s["type"][which] == 1, self.model.film_of[which]
            n2 = s["metal_n"][[which]] if is_metal else m["n"][far[k]]
            k2 = s["metal_k"][[which]] if is_metal else np.zeros((1, self.model.n_channel))
            reflected, passed = _film(self.model.layers[film], not is_metal and side == self.model.on_front[film],
                                      m["n"][near[k]], n2, k2, cosine[k][:, None])
            self.weigh(i[k], np.where((event[k] == TRANSMIT_SPECULAR)[:, None], passed, reflected))

    def _meet_shares(self, i, surface, near, far, cosine, event, channel):
        m, s = self.model.medium, self.model.surface
        for word, name in ((REFLECT_SPECULAR, "reflect_specular"),
                           (REFLECT_DIFFUSE, "reflect_diffuse"),
                           (TRANSMIT_DIFFUSE, "transmit_diffuse"),
                           (TRANSMIT_SPECULAR, "transmit_specular")):
            k = event == word
            if word == TRANSMIT_SPECULAR:
                one = k & (channel >= 0) & ((m["dispersive"][near] | m["dispersive"][far]) != 0)
                self.collapse(i[one], channel[one])
                k &= ~one
            if word == REFLECT_SPECULAR:
                metal = k & (s["type"][surface] == 1) & (s["is_metal"][surface] != 0)
                if metal.any():
                    self.weigh(i[metal], _metal(m["n"][near[metal]], s["metal_n"][surface[metal]],
                                                s["metal_k"][surface[metal]],
                                                cosine[metal][:, None]))
                k &= ~metal
            if k.any():
                self.weigh(i[k], s[name][surface[k]])

    def absorb(self, i, medium, seed, ray, step, length, absorbed):
        """Legs of rays i through absorbing media -> how far the light came."""
        mu = self.model.medium["absorption"][medium]
        single, travelled = self.single(i), length.copy()
        k = np.flatnonzero(absorbed)
        if len(k):
            u = philox(seed, ray[k], step, 3)
            channel = np.where(single[k], self.begin[i[k]], self._pick(i[k], u[0]))
            far = -portable_log(u[1]) / mu[k, channel]
            travelled[k] = np.where(far < length[k], far, length[k])
        p = (1.0 - one_minus_exp(mu * travelled[:, None])) * np.where(absorbed[:, None], mu, 1.0)
        self.weigh(i[~single], p[~single])
        return travelled

    def _pick(self, i, u):
        total, running, last = np.zeros(len(i)), np.zeros(len(i)), self.begin[i].copy()
        for k in range(self.share.shape[1]):
            live = (k >= self.begin[i]) & (k < self.end[i])
            total = np.where(live, total + self.share[i, k], total)
        done = np.zeros(len(i), bool)
        for k in range(self.share.shape[1]):
            live = (k >= self.begin[i]) & (k < self.end[i]) & (self.share[i, k] > 0.0) & ~done
            last = np.where(live, k, last)
            running = np.where(live, running + self.share[i, k], running)
            done |= live & (u * total < running)
        return last


# Complex numbers are pairs (re, im).

def _times(a, b):
    return a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]


def _place(n, k, sine):
    """Square of the index, index times cosine."""
    re, im = (n - k) * (n + k), 2.0 * n * k
    left = re - sine * sine
    size = np.where(k == 0.0, np.abs(left), np.sqrt(left * left + im * im))
    large = np.sqrt(0.5 * (size + np.abs(left)))
    small = np.where(large > 0.0, 0.5 * im / np.where(large > 0.0, large, 1.0), 0.0)
    return (re, im), (np.where(left < 0.0, small, large), np.where(left < 0.0, large, small))


def _go_on(near, far, phase, r, t):
    echo = _times(_times(r, phase), phase)
    total, less = (tuple(x + y for x, y in zip(near, far)), tuple(x - y for x, y in zip(near, far)))
    back, on = _times(less, echo), _times(total, echo)
    under = (total[0] + back[0], total[1] + back[1])
    none = (under[0] == 0.0) & (under[1] == 0.0)
    power = np.where(none, 1.0, under[0] * under[0] + under[1] * under[1])
    inverse = (under[0] / power, -under[1] / power)
    new_t = _times(_times(_times((2.0 * near[0], 2.0 * near[1]), t), phase), inverse)
    new_r = _times((less[0] + on[0], less[1] + on[1]), inverse)
    return (tuple(np.where(none, x, y) for x, y in zip(r, new_r)),
            tuple(np.where(none, x, y) for x, y in zip(t, new_t)))


def _film(layers, backwards, n1, n2, k2, cosine):
    """Shares, [rays, channels], that a film reflects and lets pass."""
    zero, one = np.zeros_like(n1), np.ones_like(n1)
    sine = n1 * np.sqrt(1.0 - cosine * cosine)
    total = (k2 == 0.0) & (sine >= n2) & (n1 != n2)
    first = ((n1 * n1, zero), (n1 * cosine, zero))
    last = behind = _place(n2, k2, sine)
    phase = (one, zero)
    across, within = ((zero, zero), (one, zero)), ((zero, zero), (one, zero))
    order = range(layers[0].shape[1]) if backwards else reversed(range(layers[0].shape[1]))
    for k in [*order, None]:
        here = first if k is None else _place(layers[0][:, k], layers[1][:, k], sine)
        across = _go_on(here[1], behind[1], phase, *across)
        within = _go_on(_times(behind[0], here[1]), _times(here[0], behind[1]), phase, *within)
        if k is not None:
            turns, lost = layers[2][:, k] * here[1][0], layers[2][:, k] * here[1][1]
            decay = np.where(lost > 0.0, portable_exp(-2.0 * PI * lost), 1.0)
            x, y = azimuth(turns - np.floor(turns))
            phase = (decay * x, decay * y)
        behind = here
    (rs, ts), (rp, tp) = ((tuple(x[0] * x[0] + x[1] * x[1] for x in both)) for both in (across, within))
    square, along = last
    ts = ts * along[0] / (n1 * cosine)
    tp = (tp * (along[0] * square[0] + along[1] * square[1]) * n1
          / ((square[0] * square[0] + square[1] * square[1]) * cosine))
    grazing = cosine <= 0.0
    return np.where(grazing, 1.0, 0.5 * (rs + rp)), np.where(grazing | total, 0.0, 0.5 * (ts + tp))


def _metal(n1, n, k, c):
    m_n, m_k, sin2 = n / n1, k / n1, 1.0 - c * c
    real, imaginary = m_n * m_n - m_k * m_k - sin2, 2.0 * m_n * m_k
    ab2 = np.sqrt(real * real + imaginary * imaginary)
    half = 0.5 * (ab2 + real)
    a = np.sqrt(np.where(half > 0.0, half, 0.0))
    s_sum, s_mix = ab2 + c * c, 2.0 * a * c
    p_sum, p_mix = ab2 * c * c + sin2 * sin2, s_mix * sin2
    rs = (s_sum - s_mix) / (s_sum + s_mix)
    r = 0.5 * rs * (1.0 + (p_sum - p_mix) / (p_sum + p_mix))
    return np.where((s_sum + s_mix <= 0.0) | (p_sum + p_mix <= 0.0), 1.0, r)


# ---- detectors ----

def cross_detector(model, d, start, end, direction, length):
    """Legs across detector d -> cell, relative, distance along the leg."""
    det, n = model.detector, len(length)
    frame = [tuple(float(v) for v in det[key][d]) for key in ("origin", "x", "y", "axis")]
    origin, x, y, axis = frame
    distance = np.zeros(n)
    if det["type"][d] == 0:
        point, distance = end, length
        if det["on_object"][d] < 0 and det["on_group"][d] < 0:
            before, after = dot(sub(start, origin), axis), dot(sub(end, origin), axis)
            distance = length * (before / (before - after))
            point = axpy(distance, direction, start)
        off = sub(point, origin)
        relative = [dot(off, x) / det["size"][d][0] + 0.5, dot(off, y) / det["size"][d][1] + 0.5]
    else:
        c = dot(direction, axis)
        c = np.where(c > -1.0, np.where(c < 1.0, c, 1.0), -1.0)
        a, b = dot(direction, x), dot(direction, y)
        phi = angle(a, np.where(b < 0.0, -b, b))
        phi = np.where(b < 0.0, 2.0 * PI - phi, phi)
        relative = [angle(c, np.sqrt((1.0 - c) * (1.0 + c))) / PI, phi / (2.0 * PI)]
    cells = []
    for k in range(2):
        count = int(det["cells"][d][k])
        cell = relative[k] * float(count)
        inside = (cell > 0.0) & (cell < float(count))
        cells.append(np.where(inside, np.where(inside, cell, 0.0).astype(np.int64),
                              np.where(cell > 0.0, count - 1, 0)).astype(np.uint16))
    bounded = [np.where(r > 0.0, np.where(r < 1.0, r, 1.0), 0.0) for r in relative]
    quantised = [(65535.0 * b + 0.5).astype(np.uint16) for b in bounded]
    return np.stack(cells, axis=1), np.stack(quantised, axis=1), distance
