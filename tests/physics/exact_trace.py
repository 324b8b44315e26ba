# SPDX-License-Identifier: MIT
"""Sequential ray trace through conics in 50-digit decimal arithmetic: the independent reference of
the lens tests. Shares nothing with the program but the laws: the quadric of a conic, Snell's law
in vector form, and the law of reflection (Welford, Aberrations of Optical Systems, ch. 4)."""
from decimal import Decimal, getcontext

getcontext().prec = 50


def exact(value):
    """The exact value of the double that the program reads."""
    return Decimal(float(value))


class Surface:
    """Vertex at height z on the axis; curvature > 0 bends towards +z. index: of the medium that the
    ray goes on in; mirror surfaces keep the index."""

    def __init__(self, z, radius=0, curvature=None, conic=0, index=1, mirror=False):
        self.z = exact(z)
        if curvature is None:
            curvature = 0 if radius == 0 else 1 / exact(radius)
        self.c = curvature if isinstance(curvature, Decimal) else exact(curvature)
        self.k = exact(conic)
        self.index = exact(index)
        self.mirror = mirror


def dot(a, b):
    return sum((x * y for x, y in zip(a, b)), Decimal(0))


def meet(point, direction, surface):
    """Distance along the ray, and the unit normal with positive z, where it meets the sheet of the
    conic that holds the vertex."""
    # From the tangent plane of the vertex the wanted root is the small one.
    to_plane = (surface.z - point[2]) / direction[2]
    x, y = (point[i] + to_plane * direction[i] for i in (0, 1))
    c, k = surface.c, surface.k
    dx, dy, dz = direction
    a = c * (dx * dx + dy * dy + (1 + k) * dz * dz)
    b = c * (x * dx + y * dy) - dz
    g = c * (x * x + y * y)
    root = (b * b - a * g).sqrt()
    t = g / (-b + (root if -b > 0 else -root))
    hx, hy, hz = x + t * dx, y + t * dy, t * dz
    normal = (-c * hx, -c * hy, 1 - c * (1 + k) * hz)
    size = dot(normal, normal).sqrt()
    return to_plane + t, tuple(v / size for v in normal)


def trace(origin, direction, surfaces, index=1):
    """One dictionary per surface: position, direction before and after, length of the segment, optical
    path from the origin, normal."""
    point = tuple(exact(v) for v in origin)
    direction = tuple(exact(v) for v in direction)
    size = dot(direction, direction).sqrt()
    direction = tuple(v / size for v in direction)
    n, path, history = exact(index), Decimal(0), []
    for surface in surfaces:
        t, normal = meet(point, direction, surface)
        point = tuple(p + t * d for p, d in zip(point, direction))
        path += n * t
        before = direction
        cos_i = dot(direction, normal)
        if surface.mirror:
            direction = tuple(d - 2 * cos_i * m for d, m in zip(direction, normal))
        else:
            ratio = n / surface.index
            cos_t = (1 - ratio * ratio * (1 - cos_i * cos_i)).sqrt().copy_sign(cos_i)
            direction = tuple(ratio * d + (cos_t - ratio * cos_i) * m
                              for d, m in zip(direction, normal))
            n = surface.index
        history.append({"position": point, "before": before, "after": direction, "length": t,
                        "path": path, "normal": normal})
    return history
