#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Light through gradient lenses and rods, from scene files, against closed forms.

Unless a case says otherwise the medium's options are the defaults (tolerance 1e-9 of the body).
"""
import math

from raymap import Checks, report, reports

checks = Checks()


def scene(medium, body, rays, within="air"):
    """One body of the medium `grin` in air; every boundary transmits all light it can."""
    listing = "".join(f"      - {{origin: {list(o)}, direction: {list(d)}, wavelength: 587.56}}\n"
                      for o, d in rays)
    return f"""raymap: 1
units: mm
spectrum: {{mode: spectral, wavelengths: [587.56]}}
media:
  air: {{index: 1}}
  grin: {{gradient: {medium}}}
surfaces:
  clear: {{type: fresnel, coat: ideal}}
{body}sources:
  - name: probe
    type: rays
    flux: 1 W
    {'medium: air' if within == 'air' else 'medium: grin'}
    rays:
{listing}"""


BALL = """geometries:
  ball: {type: sphere, radius: 1}
objects:
  - {name: ball, geometry: ball, surface: clear, inside: grin, outside: air}
"""


def rod(length, aperture, z=0.0):
    return f"""geometries:
  rod:
    type: lens
    surface: clear
    surfaces:
      - {{radius: 0, thickness: {length!r}, medium: grin, aperture: {aperture!r}}}
      - {{radius: 0, medium: air, aperture: {aperture!r}}}
objects:
  - {{name: rod, geometry: rod, at: [0, 0, {z!r}], outside: air}}
"""


def through(what, text, n_steps, ray=0):
    """The history of a ray that leaves after n_steps segments, the n_steps-th outside."""
    history = report(what, text, ray)
    steps = history["steps"]
    checks.true(f"{what}: {[s['events'] for s in steps]}",
                len(steps) == n_steps and steps[-1]["events"] == ["left"])
    return history


def curved(history, segment):
    """The curved segment of a history; its points with both ends."""
    step = history["steps"][segment]
    checks.true(f"a curved segment: {step['events']}", "gradient" in step["events"])
    start = history["steps"][segment - 1]["position"] if segment else history["start"]
    return step, [start, *step.get("curve", []), step["position"]]


def crossing(step, position, axis):
    """Where the straight segment `step` from `position` meets the axis nearest."""
    d = step["direction"]
    other = [k for k in range(3) if k != axis]
    t = -sum(position[k] * d[k] for k in other) / sum(d[k] * d[k] for k in other)
    return position[axis] + t * d[axis]


def check_fish_eye():
    """GRIN-04: Maxwell's fish-eye n = 2 / (1 + r^2) images the point (-1, 0, 0) of its rim on (1, 0, 0)
    along circles of radius 1 / sin a through both; every optical path is pi (Born & Wolf 4.2.2).
    Started 1e-9 inside."""
    medium = "{type: maxwell, radius: 1, polyline: 1e-8}"
    angles = [5, 15, 30, 45, 60, 80]
    rays = [((-1 + 1e-9, 0, 0), (math.cos(a), math.sin(a), 0)) for a in map(math.radians, angles)]
    text = scene(medium, BALL, rays, within="grin")
    for k, degrees in enumerate(angles):
        a = math.radians(degrees)
        what = f"fish-eye, {degrees} degrees"
        history = through(what, text, 2, k)
        step, points = curved(history, 0)
        checks.close(f"{what}: image", step["position"], [1, 0, 0], abs=1e-7)
        checks.close(f"{what}: direction", history["steps"][1]["direction"],
                     [math.cos(a), -math.sin(a), 0], abs=1e-7)
        outside = history["path_length"] - step["length"]
        checks.close(f"{what}: optical path", history["optical_path"] - outside, math.pi, abs=1e-7)
        checks.close(f"{what}: arc", step["length"], 2 * a / math.sin(a), abs=1e-7)
        checks.close(f"{what}: height", max(p[1] for p in points), math.tan(a / 2), abs=1e-7)


def check_eaton():
    """GRIN-07: Eaton's lens n = sqrt(2 / r - 1) sends every ray back: a Kepler ellipse with its focus in
    the centre, perihelion 1 - sqrt(1 - h^2), optical path pi + 2 sqrt(1 - h^2). The index has a pole
    there: abs 1e-5."""
    heights = [0.2, 0.5, 0.8, 0.95]
    text = scene("{type: eaton, radius: 1, polyline: 1e-6}", BALL,
                 [((-2, h, 0), (1, 0, 0)) for h in heights])
    for k, h in enumerate(heights):
        what = f"Eaton, h = {h}"
        x = math.sqrt(1 - h * h)
        history = through(what, text, 3, k)
        step, points = curved(history, 1)
        checks.close(f"{what}: entry", history["steps"][0]["position"], [-x, h, 0], abs=1e-9)
        checks.close(f"{what}: exit", step["position"], [-x, -h, 0], abs=1e-5)
        checks.close(f"{what}: direction", history["steps"][2]["direction"], [-1, 0, 0], abs=1e-5)
        outside = history["path_length"] - step["length"]
        checks.close(f"{what}: optical path", history["optical_path"] - outside,
                     math.pi + 2 * x, abs=1e-5)
        checks.close(f"{what}: perihelion", min(math.hypot(*p) for p in points), 1 - x, abs=1e-5)


def check_sech_rod():
    """GRIN-11: in n = 1.5 sech(rho / 10) every meridional ray that starts along z obeys
    sinh(x / 10) = sinh(h / 10) cos(z / 10) (Fletcher, Murphy & Young 1954): one period, 20 pi, of
    optical path 30 pi, for all heights."""
    period = 20 * math.pi
    for share in (0.25, 0.5, 1.0):
        text = scene("{type: sech, n0: 1.5, alpha: 0.1}", rod(share * period, 12.0),
                     [((h, 0, -1), (0, 0, 1)) for h in (0.5, 3, 8)])
        for k, h in enumerate((0.5, 3, 8)):
            what = f"sech rod, {share} periods, h = {h}"
            history = through(what, text, 3, k)
            step, _ = curved(history, 1)
            want = 10 * math.asinh(math.sinh(h / 10) * math.cos(2 * math.pi * share))
            checks.close(f"{what}: exit", step["position"], [want, 0, share * period], abs=1e-6)
            if share == 1.0:
                outside = history["path_length"] - step["length"]
                checks.close(f"{what}: optical path", history["optical_path"] - outside,
                             30 * math.pi, abs=1e-6)
                checks.close(f"{what}: direction", history["steps"][2]["direction"], [0, 0, 1],
                             abs=1e-6)


def check_rod_lenses():
    """GRIN-12: rod lenses n = n0 (1 - g^2 r^2 / 2). A catalogue's (Melles Griot: n0 1.608, g 0.339 / mm,
    5.37 mm long, pitch 0.29, front focal length 0.46 mm, printed to 0.01), and the cardinal points of
    two more as in pygrin (github.com/scottprahl/pygrin, MIT), from a paraxial ray at h = 1e-3."""
    g, length = 0.339, 5.37
    checks.close("catalogue: pitch", g * length / (2 * math.pi), 0.29, abs=0.01)
    n0_and_so_on = [("catalogue", 1.608, g, length, 0.0, None, None)]
    for name, n0, pitch, long, offset, principal, focus in (
            ("0.1 pitch", 1.5, 0.1, 10.0, 0.0, 6.55249494910772, 24.6038657483535),
            ("0.2 pitch", 1.6, 0.2, 8.0, 1.0, 6.10917913253663, 10.2928143940846)):
        n0_and_so_on.append((name, n0, 2 * math.pi * pitch / long, long, offset, principal, focus))
    for name, n0, gradient, long, offset, principal, focus in n0_and_so_on:
        h = 1e-3
        medium = f"{{type: selfoc, n0: {n0!r}, A: {gradient ** 2!r}}}"
        text = scene(medium, rod(long, 0.9, offset), [((h, 0, offset - 1), (0, 0, 1))])
        history = through(f"rod lens {name}", text, 3)
        exit_at, last = history["steps"][1]["position"], history["steps"][2]
        at = crossing(last, exit_at, 2)
        angle = gradient * long
        if focus is None:
            # longer than a quarter of a period: the focus lies inside, printed without its sign
            checks.close(f"{name}: focal length", at - offset - long, -0.46, abs=0.01)
            focus = offset + long + math.cos(angle) / (n0 * gradient * math.sin(angle))
            principal = focus - 1 / (n0 * gradient * math.sin(angle))
        checks.close(f"{name}: rear focal point", at, focus, rel=1e-6)
        slope = last["direction"][0] / last["direction"][2]
        checks.close(f"{name}: second principal point", at + h / slope, principal, rel=1e-6)


def check_axial():
    """GRIN-13: n^2 = 2.25 + 0.04 z is a uniform acceleration in t: x = Tx t, z = Tz t + 0.01 t^2. Runge-
    Kutta is exact here, so the error is the boundary's."""
    n0, b = 1.5, 0.02
    for z in (5.0, 20.0):
        medium = "{type: axial, of: n^2, coefficients: [2.25, 0.04], frame: world, tolerance: 1e-10}"
        angles = [10, 30, 60]
        text = scene(medium, rod(z + 1, 40.0, -1.0),
                     [((0, 0, 0), (math.sin(a), 0, math.cos(a))) for a in map(math.radians, angles)],
                     within="grin")
        for degrees, history in zip(angles, reports(f"axial-{z:g}", text, len(angles))):
            what = f"axial, z = {z}, {degrees} degrees"
            a = math.radians(degrees)
            tx, tz = n0 * math.sin(a), n0 * math.cos(a)
            end = math.sqrt(tz * tz + 2 * b * z)
            t = (end - tz) / b
            step, _ = curved(history, 0)
            checks.close(f"{what}: exit", step["position"], [tx * t, 0, z], abs=1e-8)
            # the last segment's direction outside, or inside after total reflection: tx stays
            optical = n0 * n0 * t + b * (tz * t * t + b * t ** 3 / 3)
            after = history["path_length"] - step["length"]
            n = math.sqrt(n0 * n0 + 2 * b * z)
            if tx < 1:
                checks.close(f"{what}: direction", history["steps"][1]["direction"],
                             [tx, 0, math.sqrt(1 - tx * tx)], abs=1e-8)
                checks.close(f"{what}: optical path", history["optical_path"] - after, optical,
                             abs=1e-8)
            else:
                checks.true(f"{what}: {step['events']}", "total_reflection" in step["events"])
            checks.close(f"{what}: arrival", [n * c for c in step["direction"]], [tx, 0, end],
                         abs=1e-8)


def check_wood():
    """GRIN-16: Wood's lens (1905), n^2 = 2.25 (1 - (0.05 rho)^2), 10 mm between plane faces: real rays
    with the refraction at the exit; x swings with n0 alpha z / Tz, Tz the index at the entry."""
    n0, alpha, length = 1.5, 0.05, 10.0
    heights = [0.001, 0.5, 1.0, 2.0, 4.0]
    text = scene(f"{{type: parabolic, n0: {n0}, alpha: {alpha}}}",
                 rod(length, 6.0), [((h, 0, -1), (0, 0, 1)) for h in heights])
    for k, h in enumerate(heights):
        what = f"Wood's lens, h = {h}"
        tz = n0 * math.sqrt(1 - (alpha * h) ** 2)
        phase = n0 * alpha * length / tz
        x, sine = h * math.cos(phase), h * n0 * alpha * math.sin(phase)
        history = through(what, text, 3, k)
        step, _ = curved(history, 1)
        last = history["steps"][2]
        checks.close(f"{what}: exit", step["position"], [x, 0, length], abs=1e-10)
        checks.close(f"{what}: sine", -last["direction"][0], sine, abs=1e-10)
        checks.close(f"{what}: focus", crossing(last, step["position"], 2) - length,
                     x * math.sqrt(1 - sine * sine) / sine, abs=1e-7)
    focus = 1 / (n0 * alpha * math.tan(alpha * length))
    checks.close("Wood's lens: paraxial focus as in the listing", focus, 24.406502956166, abs=1e-12)


def check_constant():
    """GRIN-25: a ball lens of n = 1.5 entered as a gradient without slope refracts by Snell's law alone;
    paraxial focus 1.5 from the centre."""
    heights = [(0.001, 1.49999958333327), (0.3, 1.46197843695743), (0.7, 1.277787023381)]
    text = scene("{type: spherical, coefficients: [1.5, 0]}", BALL,
                 [((-2, h, 0), (1, 0, 0)) for h, _ in heights])
    for k, (h, want) in enumerate(heights):
        history = through(f"ball lens, h = {h}", text, 3, k)
        step, _ = curved(history, 1)
        checks.close(f"ball lens, h = {h}", crossing(history["steps"][2], step["position"], 0), want,
                     abs=1e-9)
        a = math.asin(h)
        b = math.asin(h / 1.5)
        checks.close(f"ball lens, h = {h}: chord", step["length"], 2 * math.cos(b), abs=1e-12)
        checks.close(f"ball lens, h = {h}: direction", history["steps"][2]["direction"][1],
                     -math.sin(2 * (a - b)), abs=1e-12)


check_fish_eye()
check_eaton()
check_sech_rod()
check_rod_lenses()
check_axial()
check_wood()
check_constant()
checks.finish()
