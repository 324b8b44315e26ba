#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Pictures against closed forms: furnace, lambertian floors under each kind of source, absorption,
refraction, the index law of radiance, and the blur of a thin lens."""
import math

import numpy

from picture import luminance, render
from raymap import Checks, some

checks = Checks()

HEAD = """raymap: 1
units: {units}
spectrum: {spectrum}
media: {{air: {{index: 1}}, glass: {{index: 1.5}}, ink: {{index: 1, absorption: 0.2}}, crown: {{glass: N-BK7}},
  fog: {{index: 1, scattering: 0.8, scattering_g: 0.5}}, grin: {{gradient: {{type: luneburg, n_edge: 1.2, radius: 1, tolerance: 1e-6}}}}}}
surfaces:
  clear: {{type: fresnel}}
  white: {{type: lambert, reflectance: 1}}
  grey: {{type: lambert, reflectance: 0.4}}
  opal: {{type: mixture, reflect_diffuse: 0.3, transmit_diffuse: 0.5}}
geometries:
  ball: {{type: sphere, radius: 1}}
  plate: {{type: rectangle, size: [40, 40]}}
"""


def head(units="m", spectrum="{mode: rgb}"):
    return HEAD.format(units=units, spectrum=spectrum)


def sources(*lines):
    return "sources:\n" + "".join(f"  - {line}\n" for line in lines)


UNSEEN = sources("{name: unseen, type: rays, rays: [{origin: [0, 0, 50], direction: [0, 0, 1]}], flux: 1 lm}")
CAMERA = "cameras:\n  - {name: eye, at: [0, 0, 4], look_at: [0, 0, 0], fov: 1, resolution: [8, 8]%s}\n"
FLOOR = "objects:\n  - {name: floor, geometry: plate, surface: grey, front: air, back: air}\n"


def mean(name, scene, *options):
    """Mean luminance of the picture, and its standard error by the report."""
    image, answer = render(name, scene, *options)
    n = image.shape[0] * image.shape[1]
    return luminance(image).mean(), answer["noise"] / math.sqrt(n)


def expect(what, name, scene, want, samples=256, error=0.0):
    got, noise = mean(name, scene, "--samples", samples)
    checks.z(what, got, want, math.hypot(noise, error * want))


def check_furnace():
    """Bodies that lose nothing are as bright as what is around them, in every pixel, exactly."""
    for surface, inside, spectrum in some([("white", "air", "{mode: rgb}"), ("clear", "glass", "{mode: rgb}"),
                                           ("clear", "fog", "{mode: rgb}"), ("clear", "grin", "{mode: rgb}"),
                                           ("clear", "crown", "{mode: spectral, wavelengths: {from: 400, to: 700, step: 20}}")], 2, 3, 4):
        scene = head(spectrum=spectrum) + UNSEEN + f"""background: {{radiance: 7}}
objects: [{{name: body, geometry: ball, surface: {surface}, inside: {inside}, outside: air}}]
cameras: [{{name: eye, at: [0, 0, 4], look_at: [0, 0, 0], fov: 40, resolution: [24, 24]}}]
"""
        image, _ = render("furnace", scene, "--samples", 16 if "rgb" in spectrum else 400)
        got = luminance(image)
        if "rgb" in spectrum:
            checks.close(f"furnace, {surface} {inside}: darkest", got.min(), 7, abs=7e-6)
            checks.close(f"furnace, {surface} {inside}: brightest", got.max(), 7, abs=7e-6)
        else:
            checks.close(f"furnace, {surface} {inside}: mean", got.mean(), 7, abs=0.05)


def check_floor():
    """A lambertian floor of albedo 0.4 shows L = 0.4 E / pi (Lambert 1760)."""
    law = 0.4 / math.pi
    h = 3.0
    expect("point, isotropic", "point", head() + FLOOR + CAMERA % "" + sources(
        "{name: lamp, type: point, at: [0, 0, 3], flux: 1000 lm}"), law * 1000 / (4 * math.pi) / h**2, 64, 1e-4)
    expect("point, cosine power 3", "power", head() + FLOOR + CAMERA % "" + sources(
        "{name: lamp, type: point, at: [0, 0, 3], direction: [0, 0, -1], cosine_power: 3, flux: 1000 lm}"),
           law * 1000 * 4 / (2 * math.pi) / h**2, 64, 2e-4)
    expect("point, cone", "cone", head() + FLOOR + CAMERA % "" + sources(
        "{name: lamp, type: point, at: [0, 0, 3], direction: [0, 0, -1], cone: 20, flux: 1000 lm}"),
           law * 1000 / (2 * math.pi * (1 - math.cos(math.radians(20)))) / h**2, 64, 1e-4)
    expect("point, table", "table", head() + FLOOR + CAMERA % "" + sources(
        "{name: lamp, type: point, at: [0, 0, 3], direction: [0, 0, -1], "
        "distribution: {table: {angle: [0, 20], value: [5, 5]}}, flux: 1000 lm}"),
           law * 1000 / (2 * math.pi * (1 - math.cos(math.radians(20)))) / h**2, 64, 1e-4)
    expect("sun of 0.53 degrees at 60", "sun", head() + FLOOR + CAMERA % "" + sources(
        "{name: sun, type: collimated, shape: {disc: 1}, at: [5.196152422706632, 0, 3], angular_diameter: 0.53 deg, "
        "direction: [-0.8660254037844386, 0, -0.5], flux: 1000 lm}"), law * 1000 / math.pi * 0.5, 64, 1e-3)
    expect("beam at 60 degrees", "beam", head() + FLOOR + CAMERA % "" + sources(
        "{name: beam, type: collimated, shape: {disc: 1}, at: [5.196152422706632, 0, 3], "
        "direction: [-0.8660254037844386, 0, -0.5], flux: 1000 lm}"), law * 1000 / math.pi * 0.5, 64, 1e-6)
    disc = sources("{name: lamp, type: area, shape: {disc: 2}, at: [0, 0, 3], direction: [0, 0, -1], flux: 1000 lm}")
    radiance = 1000 / (math.pi * math.pi * 4)
    want = law * math.pi * radiance * 4 / (4 + 9)
    expect("disc above its axis", "disc", head() + FLOOR + CAMERA % "" + disc, want, 256, 1e-4)
    # The same light through a pane without effect: no point can look at it through a surface, the path must meet it.
    pane = FLOOR + "  - {name: pane, geometry: plate, at: [0, 0, 2], surface: clear, front: air, back: air}\n"
    expect("disc through a pane of air", "pane", head() + pane + CAMERA % "" + disc, want, 2048, 1e-4)
    inches = head("in").replace("[40, 40]", "[400, 400]") + FLOOR + CAMERA % "" + disc
    expect("disc, in inches", "inches", inches, want / 0.0254**2, 256, 1e-4)
    many = [f"{{name: lamp{i}, type: point, at: [0, 0, 3], flux: {100 * (i + 1)} lm}}" for i in range(6)]
    expect("six lamps, four looks", "six", head() + FLOOR + CAMERA % "" + sources(*many),
           law * 2100 / (4 * math.pi) / h**2, 64, 1e-4)
    opal = FLOOR.replace("grey", "opal")
    below = "{name: lamp, type: point, at: [0, 0, -3], flux: 1000 lm}"
    expect("lamp behind an opal pane", "opal", head() + opal + CAMERA % "" + sources(below),
           0.5 / math.pi * 1000 / (4 * math.pi) / h**2, 64, 1e-4)


def check_lamps_seen():
    """An emitter's radiance is flux / (pi area), by n^2 less where it is in glass (Nicodemus 1963), and
    exp(-mu d) through an absorbing medium."""
    scene = head() + CAMERA % ", medium: ink" + sources(
        "{name: lamp, type: area, shape: {rectangle: [3, 2]}, direction: [0, 0, 1], flux: 600 lm, medium: ink}")
    expect("lamp through ink", "ink", scene, 100 / math.pi * math.exp(-0.8), 1024, 1e-4)
    floor = (FLOOR.replace("front: air, back: air", "front: ink, back: ink") + CAMERA % "" + sources(
        "{name: lamp, type: point, at: [0, 0, 3], flux: 1000 lm, medium: ink}")).replace("fov: 1", "fov: 1, medium: ink")
    expect("floor under ink", "inkfloor", head() + floor,
           0.4 / math.pi * 1000 / (4 * math.pi) / 9 * math.exp(-0.2 * (3 + 4)), 2048, 1e-4)
    sunk = head() + """objects: [{name: body, geometry: ball, surface: clear, inside: glass, outside: air}]
""" + CAMERA % "" + sources(
        "{name: lamp, type: area, shape: {disc: 0.5}, direction: [0, 0, 1], flux: 100 lm, medium: glass}")
    # Normal incidence: T = 1 - ((n - 1)/(n + 1))^2 goes straight to the lamp; what the surface returns inside
    # is lost on the lamp's dark back or adds (1 - T) T of the second round through the far side.
    first = 100 / (math.pi * math.pi * 0.25) / 1.5**2 * 0.96
    got, noise = mean("sunk", sunk, "--samples", 2048)
    checks.close("lamp in glass", got, first * (1 + 0.04**2), abs=5 * noise + 2e-3 * first)


def check_dispersion():
    """One spectral picture has, per channel, what each wavelength alone would have: in the furnace all
    paths leave, so a body of dispersive glass before a line source keeps the colour of the source."""
    scene = head(spectrum="{mode: spectral, wavelengths: [450, 550, 650]}") + FLOOR.replace("grey", "white")
    lamp = "{name: lamp, type: point, at: [0, 0, 3], flux: 1000 lm, spectrum: {lines: {%s}}}"
    total = numpy.zeros(3)
    for line in (450, 550, 650):
        image, _ = render("line", scene + CAMERA % "" + sources(lamp % f"{line}: 1"), "--samples", 64)
        total += image.mean(axis=(0, 1))
    # V(lambda) of CIE 1924 at the lines makes equal lumens of them.
    both = "450: 26.3157894736842, 550: 1.0050000000000001, 650: 9.34579439252336"
    image, _ = render("lines", scene + CAMERA % "" + sources(lamp % both), "--samples", 4096)
    got = image.mean(axis=(0, 1)) * 3
    for k in range(3):
        checks.close(f"three lines, component {k}", got[k], total[k],
                     abs=0.02 * float(numpy.abs(total).max()))


def check_scattering():
    """Fog in a beam shows the light scattered once: L = E mu_s p(theta) s, p of Henyey & Greenstein (1941), of
    Rayleigh, or of a table that another wavelength does not share, theta 90 degrees, over the 2 m where the beam is;
    optically thin (mu_s s = 2e-3)."""
    g, mu = 0.5, 1e-3
    with open("phase.csv", "w", encoding="utf-8") as file:
        file.write("500 0 1\n500 90 1\n500 180 1\n600 0 1\n600 90 0.1\n600 180 0\n")
    for name, fog, p, light in some((
            ("fog in a beam", f"scattering: {mu}, scattering_g: {g}", (1 - g * g) / (4 * math.pi * (1 + g * g) ** 1.5), None),
            ("air in a beam", f"scattering: {{coefficient: {mu}, phase: rayleigh}}", 3 / (16 * math.pi), None),
            ("two phase functions", f"scattering: {{coefficient: {mu}, phase: {{file: phase.csv}}}}", 1 / (4 * math.pi), 500)), 0, 2):
        show_beam(name, fog, 100000 * mu * 2.0 * p, light)


def show_beam(name, fog, want, light):
    scene = head(spectrum="{wavelengths: [500, 600]}" if light else "{mode: rgb}").replace(
        "scattering: 0.8, scattering_g: 0.5", fog) + """objects:
  - {name: floor, geometry: plate, at: [0, 0, -1], surface: black, front: fog, back: fog}
""" + sources(
        "{name: beam, type: collimated, shape: {rectangle: [2, 2]}, at: [-5, 0, 0], direction: [1, 0, 0], flux: 400000 lm, medium: fog"
        + (f", spectrum: {{lines: {{{light}: 1}}}}}}" if light else "}")
    ) + (CAMERA % ", medium: fog")
    scene = scene.replace("  white: {type: lambert", "  black: {type: absorber}\n  white: {type: lambert")
    expect(name, "fog", scene, want, 8192, 4e-3)


def check_gradient_rod():
    """A pinhole looks through a rod n = n0 (1 - A r^2 / 2) of length t: paraxially a disc at the far end of
    the way appears under its radius / B, B of the ray matrix from pinhole to disc (Kogelnik & Li 1966,
    doi:10.1364/AO.5.001550)."""
    n0, g, t, d1, d2, s = 1.6, 0.1, 5.0, 20.0, 6.0, 0.1
    cos, sin = math.cos(g * t), math.sin(g * t)
    b = (cos - d2 * n0 * g * sin) * d1 + sin / (n0 * g) + d2 * cos
    scene = f"""raymap: 1
units: mm
spectrum: {{mode: rgb}}
media: {{air: {{index: 1}}, rod: {{gradient: {{type: selfoc, n0: {n0}, A: {g * g}}}}}}}
surfaces: {{ideal: {{type: fresnel, coat: ideal}}, black: {{type: absorber}}}}
geometries:
  rod: {{type: lens, surface: ideal, edge: black, surfaces: [{{radius: inf, thickness: {t}, medium: rod, aperture: 3}}, {{radius: inf, medium: air, aperture: 3}}]}}
objects: [{{name: rod, geometry: rod, outside: air}}]
cameras: [{{name: eye, at: [0, 0, {-d1}], direction: [0, 0, 1], fov: 1.5, resolution: [100, 100]}}]
""" + sources(f"{{name: dot, type: area, shape: {{disc: {s}}}, at: [0, 0, {t + d2}], direction: [0, 0, -1], flux: 1 lm}}")
    image, answer = render("rod", scene, "--samples", 32)
    checks.close("errors in the rod", answer["errors"], 0)
    light = luminance(image) / (1 / (math.pi * math.pi * s * s * 1e-6))
    checks.close("radiance through the rod", light.max(), 1, abs=1e-5)
    pixel = 2 * math.tan(math.radians(0.75)) / 100
    checks.close("apparent area through the rod", light.sum() * pixel**2, math.pi * (s / b)**2, rel=0.01)


def check_thin_lens():
    """A point off the plane in focus becomes a disc of radius R |f - d| / d in that plane, R the lens
    (Potmesil & Chakravarty 1981): variance of a uniform disc, radius^2 / 4 along each axis."""
    radius, size = 0.25, 0.02
    for focus, distance in ((4.0, 4.0), (3.0, 4.0), (6.0, 4.0)):
        scene = head() + sources(
            f"{{name: dot, type: area, shape: {{disc: {size}}}, at: [0, 0, {4 - distance}], direction: [0, 0, 1], flux: 1 lm}}"
        ) + f"""cameras:
  - {{name: eye, type: thin_lens, at: [0, 0, 4], direction: [0, 0, -1], fov: 20, resolution: [80, 80], focus: {focus}, aperture: {radius}}}
"""
        image, _ = render("lens", scene, "--samples", 128)
        light = luminance(image)
        pixel = 2 * math.tan(math.radians(10)) * focus / 80
        place = (numpy.arange(80) - 39.5) * pixel
        x = (light.sum(axis=0) * place**2).sum() / light.sum()
        y = (light.sum(axis=1) * place**2).sum() / light.sum()
        blur = radius * abs(focus - distance) / distance
        want = blur**2 / 4 + (size * focus / distance)**2 / 4 + pixel**2 / 12
        checks.close(f"blur in x, focus {focus} of {distance}", x, want, abs=0.03 * want + 0.1 * pixel**2)
        checks.close(f"blur in y, focus {focus} of {distance}", y, want, abs=0.03 * want + 0.1 * pixel**2)


def check_perspective():
    """A square of half width s at distance d covers s / (d tan(fov/2)) of the half height."""
    scene = head() + sources(
        "{name: lamp, type: area, shape: {rectangle: [1, 0.5]}, at: [0.4, 0.3, 0], direction: [0, 0, 1], flux: 1 lm}"
    ) + """cameras:
  - {name: eye, at: [0, 0, 4], look_at: [0, 0, 0], up: [0, 1, 0], fov: 40, resolution: [80, 60]}
"""
    image, _ = render("square", scene, "--samples", 64)
    light = luminance(image)
    pixel = 2 * 4 * math.tan(math.radians(20)) / 60
    x, y = (numpy.arange(80) - 39.5) * pixel, (29.5 - numpy.arange(60)) * pixel
    full = 1 / (math.pi * 0.5)
    checks.close("centre to the right", (light.sum(axis=0) * x).sum() / light.sum(), 0.4, abs=0.1 * pixel)
    checks.close("centre upwards", (light.sum(axis=1) * y).sum() / light.sum(), 0.3, abs=0.1 * pixel)
    checks.close("area", light.sum() / full * pixel**2, 0.5, abs=0.005)
    checks.close("radiance", light.max(), full, abs=1e-5 * full)


check_furnace()
check_floor()
check_lamps_seen()
check_dispersion()
check_scattering()
check_gradient_rod()
check_thin_lens()
check_perspective()
checks.finish()
