#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The example scenes do what they say: no ray ends in an error, the double Gauss puts the star where
its focal length says, and the room's paths are as long as promised."""
import json
import math
import os
import shutil

from raymap import Checks, count, drop, rays, run

checks = Checks()
EXAMPLES = os.path.join(os.environ["SOURCE_DIR"], "examples")


def trace_example(name, n, *more):
    target = name + ".raymap"
    shutil.rmtree(target, ignore_errors=True)
    told = json.loads(run("trace", os.path.join(EXAMPLES, name, "scene.yaml"), "-o", target, "-n", n, "--quiet", "--json", *more))
    return target, told["bytes_per_segment"]


def check_double_gauss():
    """100.0038 mm tan(2 degrees) = 3.492 mm; distortion and lateral colour stay below 1 %. All of
    the star's direct light lies in a blur of less than 0.1 mm; the sun's direct image misses."""
    target, _ = trace_example("double-gauss", 200_000)
    direct = "source(star) and registered(sensor) and hit(*, reflect) == 0"
    at = 100.0038 * math.tan(math.radians(2))
    spots = [f"({direct}) and registered(sensor, ellipse({x}, 0, 0.1, 0.1))" for x in (at, -at)]
    (wrong, limited, star, right, left, sun, ghosts), total = rays(
        target, "ended(error)", "ended(limit)", direct, *spots,
        "source(sun) and registered(sensor) and hit(*, reflect) == 0",
        "registered(sensor) and hit(*, reflect_specular) >= 2")
    checks.true(f"{wrong} rays ended in an error, {limited} at a limit", wrong == limited == 0)
    checks.true(f"{right + left} of the star's {star} direct rays in its image",
                right + left >= 0.99 * star > 10_000)
    checks.true(f"{sun} rays of the sun come straight to the sensor", sun == 0)
    checks.true(f"{ghosts} ghosts of {total}", ghosts > 100)
    drop(target)


def check_room():
    """223 instances of 20 meshes; a path of about 9 segments; the mesh bodies leak nothing."""
    target, _ = trace_example("room", 40_000)
    answer = count(target, "ended(error) or ended(limit) or ended(left)", "hit(shelves)",
                   "surface(clear)", "surface(mirror)")
    checks.true(f"{answer[0]['rays']['matched']} rays did not end absorbed",
                answer[0]["rays"]["matched"] == 0)
    mean = answer[0]["segments"]["total"] / answer[0]["rays"]["total"]
    checks.true(f"{mean:.2f} segments per ray", 8 <= mean <= 10)
    for part in answer[1:]:
        checks.true(f"{part['criterion']}: {part['rays']['matched']}", part["rays"]["matched"] > 1000)
    drop(target)


def check_milk():
    """All light comes back or gets through but for what the milk absorbs; much more comes back."""
    target, nbytes = trace_example("milk", 3000)
    checks.true(f"{nbytes} bytes a segment", nbytes <= 4)
    (back, through, absorbed), total = rays(target, "registered(glow)", "registered(through)", "ended(absorbed, milk)")
    (left,), _ = rays(target, "ended(left)")
    checks.true(f"{left} of milk's light left, {absorbed} absorbed, of {total}", left + absorbed == total and absorbed < 0.2 * total)
    checks.true(f"{back} hits above, {through} below", back > 0 and through > 0)
    drop(target)


def check_concentrator():
    """Of light that the dye takes up, more gets to the cell than the cell's own share of the faces; none of it is blue."""
    target, nbytes = trace_example("concentrator", 10_000)
    checks.true(f"{nbytes} bytes a segment", nbytes <= 4)
    (cell, taken, blue, ended), total = rays(target, "hit(cell)", "event(fluoresce)", "hit(cell) and wavelength < 560",
                                             "ended(left) or ended(absorbed)")
    checks.true(f"{cell} of {taken} at the cell", 0.08 * taken < cell < 0.7 * taken and taken > 0.3 * total)
    checks.true(f"{blue} blue ones", blue < 0.02 * cell)
    checks.true("every photon ends", ended == total)
    drop(target)


check_double_gauss()
def check_office():
    """What its README says: illuminance of a desk in the evening; no light gets lost but through the window."""
    target, nbytes = trace_example("office", 1_000_000)
    checks.true(f"{nbytes} bytes a segment of the office", nbytes <= 4.6)  # every second segment is registered
    (wrong,), _ = rays(target, "ended(error) or ended(limit)")
    checks.true(f"{wrong} rays of the office ended badly", wrong == 0)
    seen = json.loads(run("detector", target, "left_task", "--receivers", os.path.join(EXAMPLES, "office", "tasks.yaml"), "--where", "not (source(sky) or source(sun))", "--json"))
    checks.z("lx on a desk", seen["mean"]["value"], 682, math.hypot(4, seen["mean"]["standard_error"]))
    drop(target)


def check_wls_fibre():
    """Near and far end get what the fibre keeps; the way between them takes longer; what is taken up twice is redder."""
    target, nbytes = trace_example("wls-fibre", 20_000, "--time", "on")
    checks.true(f"{nbytes} bytes a segment", nbytes <= 4)
    (green, near, far, blue, wrong), _ = rays(target, "event(fluoresce)", "registered(near)", "registered(far)",
                                              "(registered(near) or registered(far)) and not event(fluoresce)", "ended(error) or ended(limit)")
    checks.true(f"{near} and {far} of {green} at the ends, {blue} of the tile's own light", 0.01 * green < far < near < 0.05 * green and blue == 0)
    checks.true(f"{wrong} rays ended badly", wrong == 0)
    ns = [json.loads(run("stats", target, "--of", f"time({end})", "--unit", "ns", "--json"))["mean"] for end in ("near", "far")]
    late = ns[1]["value"] - ns[0]["value"]
    # 500 mm further, along the axis at least, at the steepest angle that is kept (cos = 1.49 / 1.59) at most; a skew ray's is steeper still
    least, error = 500 * 1.6 / 299.79, math.hypot(ns[0]["standard_error"], ns[1]["standard_error"])
    checks.true(f"{late} ns later at the far end", least - 4 * error < late < 1.4 * least + 4 * error + 1)
    drop(target)


def check_light_guide():
    """Two thirds of the light come out in front, evenly; both halves alike."""
    target, nbytes = trace_example("light-guide", 12_000)
    checks.true(f"{nbytes} bytes a segment", nbytes <= 4)
    (wrong, south, north), total = rays(target, "ended(error) or ended(limit)", "source(leds.south) and registered(front)",
                                        "source(leds.north) and registered(front)")
    checks.true(f"{wrong} rays of the light guide ended badly", wrong == 0)
    checks.share("light of the south row", south, south + north, 0.5)
    checks.true(f"{south + north} of {total} through the front", 0.4 < (south + north) / total < 0.7)
    seen = json.loads(run("detector", target, "front", "--cells", "4x3", "--json"))
    checks.true(f"evenness {seen['uniformity']['U0']}", seen["uniformity"]["U0"]["value"] > 0.75)
    drop(target)


check_milk()
check_concentrator()
check_wls_fibre()
check_light_guide()
check_office()
check_room()
checks.finish()
