#!/usr/bin/python3
# SPDX-License-Identifier: MIT
#
# The promise: what `raymap detector` says of images, spots and receivers is what numpy finds in the
# columns of the map, with errors per ray; spots of known form have their known size and MTF; errors
# are those that twenty seeds show; any number of ranks gives the same bytes.
import json, math, os, subprocess, sys
import h5py
import numpy as np

RAYMAP = os.environ["RAYMAP"]
SLOW = int(os.environ.get("RAYMAP_TEST_SCALE", "1")) > 1
failures = 0


def run(*words, status=0, says=""):
    global failures
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode != status or says not in done.stdout + done.stderr:
        failures += 1
        print("FAILED:", done.returncode, "not", status, repr(says), words, done.stdout[:300], done.stderr[:1500])
    return done.stdout


def detector(map_path, name, *words):
    return json.loads(run(RAYMAP, "detector", map_path, name, "--json", *words))


def near(what, got, expected, rel=1e-9, abs_tol=0.0):
    global failures
    if not np.allclose(got, expected, rtol=rel, atol=abs_tol, equal_nan=True):
        failures += 1
        print("FAILED:", what, got, expected)


SCENE = """raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [486.13, 587.56, 656.27]}
media: {air: {index: 1}}
geometries: {wall: {type: rectangle, size: [40, 40]}}
surfaces: {half: {type: lambert, reflectance: 0.5}}
objects:
  - {name: screen, geometry: wall, at: [0, 0, 40], surface: half, front: air, back: air}
  - {name: lid, geometry: wall, at: [0, 0, -20], surface: half, front: air, back: air}
sources:
%s
detectors:
  - {name: sensor, type: plane, on: screen, size: [20, 16], cells: [20, 16], at: [0, 0, 40], direction: [0, 0, -1]}
"""
DISC = """  - {name: beam, type: collimated, shape: {disc: 2}, at: [3, 1, -10], flux: 2 W, medium: air, spectrum: {lines: {486.13: 1, 587.56: 1, 656.27: 2}}}
  - {name: lamp, type: point, at: [0, 0, 0], direction: [0, 0, 1], distribution: {cone: 25}, flux: 1 W, medium: air, rays_share: 2}
"""
open("disc.yaml", "w").write(SCENE % DISC)
run(RAYMAP, "trace", "--encoding", "plain", "disc.yaml", "-o", "disc.raymap", "-n", "20000", "--quiet", "--force")
f = h5py.File("disc.raymap/map.h5")
source, count, legs = f["ray/source"][:], f["ray/registration_count"][:], f["ray/segment_count"][:]
emitted = np.bincount(source, minlength=2)
flux = np.array([2.0, 1.0]) / emitted
ray_of = np.repeat(np.arange(len(source)), count)
taken = f["registration/registered"][:] == 1
ray = ray_of[taken]
relative = f["registration/relative"][:][taken] / 65535.0
x, y = (relative[:, 0] - 0.5) * 20, (relative[:, 1] - 0.5) * 16
leg = (np.cumsum(legs) - legs)[ray] + f["registration/segment"][:][taken]
share = f["segment/colour_spectral"][:][leg] / 65535.0
direction = f["registration/direction"][:][taken].astype(float)


def estimate(terms, rays=None, weight=1.0):
    """Sum over registrations of terms [n, k] and the Gram matrix's part of its covariance, per ray."""
    rays = ray if rays is None else rays
    terms = np.asarray(terms, float)
    if terms.ndim == 1:
        terms = terms[:, None]
    total, covariance = np.zeros(terms.shape[1]), np.zeros((terms.shape[1],) * 2)
    for s in range(2):
        mine = source[rays] == s
        q = np.zeros((len(source), terms.shape[1]))
        np.add.at(q, rays[mine], terms[mine])
        n = emitted[s]
        total += flux[s] * q.sum(0)
        covariance += flux[s] ** 2 * n / (n - 1) * (q.T @ q - np.outer(q.sum(0), q.sum(0)) / n)
    return total, covariance


def error_of(terms, gradient):
    covariance = estimate(terms)[1]
    return math.sqrt(gradient @ covariance @ gradient)


# ---- images: region, turned cells, spectrum, against numpy
words = ("--cells", "7x5", "--region=-1,-2,7,4", "--rotate", "30", "--quantity", "spectral")
d = detector("disc.raymap", "sensor", *words, "-o", "image.npz", "--force")
npz = np.load("image.npz")
c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
u, v = x * c + y * s, y * c - x * s
inside = (u >= -1) & (u <= 7) & (v >= -2) & (v <= 4)
i = np.minimum(((u + 1) / 8 * 7).astype(int), 6)
j = np.minimum(((v + 2) / 6 * 5).astype(int), 4)
area = 8 / 7 * 6 / 5 * 1e-6
for cell in range(35):
    here = inside & (i + 7 * j == cell)
    total, covariance = estimate(here[:, None] * np.column_stack([np.ones(len(x)), share]))
    near("image", npz["value"].ravel()[cell], total[0] / area)
    near("its error", npz["standard_error"].ravel()[cell], math.sqrt(covariance[0, 0]) / area, abs_tol=1e-9)
    near("spectral", npz["spectral"].reshape(3, -1)[:, cell], total[1:] / area, rel=1e-8)
    near("its error", npz["spectral_standard_error"].reshape(3, -1)[:, cell], np.sqrt(np.diag(covariance))[1:] / area, rel=1e-8, abs_tol=1e-9)
total, covariance = estimate(inside[:, None] * np.column_stack([np.ones(len(x)), share]))
near("flux", [d["flux"]["total"], d["flux"]["standard_error"]], [total[0], math.sqrt(covariance[0, 0])])
near("spectrum", [k["flux"] for k in d["spectrum"]], total[1:], rel=1e-8)
near("its error", [k["standard_error"] for k in d["spectrum"]], np.sqrt(np.diag(covariance))[1:], rel=1e-8)
near("centres", npz["x"][0, 0], (-1 + 4 / 7) * c - (-2 + 0.6) * s)

# ---- over directions: intensity and radiance
d = detector("disc.raymap", "sensor", "--quantity", "luminance", "--over", "direction", "--region", "0,0,60,360", "--cells", "6x8", "-o", "angle.npz", "--force")
theta = np.arccos(np.clip(direction[:, 2], -1, 1)) # the axis points to -z, where the light comes from
first = np.degrees(theta) <= 10
omega = math.pi * math.sin(math.radians(10)) ** 2
near("radiance", np.load("angle.npz")["value"][:, 0].mean(), estimate(first * 1.0)[0][0] / (omega * 320e-6), rel=1e-6)
near("range of theta", d["flux"]["total"], estimate((np.degrees(theta) <= 60) * 1.0)[0][0], rel=1e-6)
lum = detector("disc.raymap", "sensor", "--quantity", "radiance")
near("radiance of the whole", lum["mean"]["value"], estimate(np.ones(len(x)))[0][0] / (2 * math.pi * 320e-6)) # of both sides

# ---- spot: moments, radii, MTF, against numpy
d = detector("disc.raymap", "sensor", "--spot", "--mtf", "--frequency", "0.5", "--plot", "spot.csv", "--force")
spot, mtf = d["spot"], d["mtf"]
total, covariance = estimate(np.column_stack([np.ones(len(x)), x, y, x * x, y * y]))
T, cx, cy = total[0], total[1] / total[0], total[2] / total[0]
mx, my = total[3] / T - cx * cx, total[4] / T - cy * cy
near("centroid", [spot["centroid"][k]["value"] for k in "xy"], [cx, cy], abs_tol=1e-12)
near("RMS", [spot["rms"][k]["value"] for k in ("x", "y", "radius")], [math.sqrt(mx), math.sqrt(my), math.sqrt(mx + my)])
gx = np.array([-cx, 1, 0, 0, 0]) / T
gm = np.array([cx * cx - mx + cy * cy - my, -2 * cx, -2 * cy, 1, 1]) / T
near("error of the centroid", spot["centroid"]["x"]["standard_error"], math.sqrt(gx @ covariance @ gx), rel=1e-7)
near("error of the RMS radius", spot["rms"]["radius"]["standard_error"], math.sqrt(gm @ covariance @ gm) / (2 * math.sqrt(mx + my)), rel=1e-7)
r = np.hypot(x - cx, y - cy)
order = np.argsort(r)
energy = np.cumsum(flux[source[ray]][order]) / T
for row in spot["encircled"]:
    near("radius", row["radius"], r[order][np.searchsorted(energy, row["fraction"])], rel=1e-3)
at = np.array(spot["curve"]["radius"])
near("encircled energy", spot["curve"]["fraction"], [flux[source[ray]][r <= k].sum() / T for k in at], abs_tol=2e-3)
p = spot["curve"]["fraction"][40]
near("its error", spot["curve"]["standard_error"][40], error_of(np.column_stack([(r <= at[40]) * 1.0, np.ones(len(x))]), np.array([1, -p]) / T), rel=2e-2)
angle = math.radians(mtf["tangential_direction"])
near("tangential direction", angle, math.atan2(cy, cx) if math.hypot(cx, cy) > math.sqrt(mx + my) else math.pi / 2)
for name, a in (("tangential", angle), ("sagittal", angle + math.pi / 2)):
    place = x * math.cos(a) + y * math.sin(a)
    for k in (1, 10, 37, 50):
        phase = 2 * math.pi * mtf["frequency"][k] * (place - (cx * math.cos(a) + cy * math.sin(a)))
        sums, covariance = estimate(np.column_stack([np.cos(phase), np.sin(phase), np.ones(len(x))]))
        H = math.hypot(sums[0], sums[1])
        gradient = np.array([sums[0] / H, sums[1] / H, -H / T]) / T
        near("MTF", mtf[name][k], H / T, rel=1e-7)
        near("its error", mtf[name + "_standard_error"][k], math.sqrt(gradient @ covariance @ gradient), rel=1e-5)

# ---- receivers: legs cut by numpy
open("cut.yaml", "w").write("""detectors:
  - {name: cut, type: plane, size: [8, 6], cells: [16, 12], at: [1, 0, 25], direction: [0, 0.6, -0.8], max_angle: 50}
""")
d = detector("disc.raymap", "cut", "--receivers", "cut.yaml", "--spot", "-o", "cut.npz", "--force")
end = f["segment/position"][:].astype(float)
start = np.empty_like(end)
start[1:] = end[:-1]
start[np.cumsum(legs) - legs] = f["ray/start"][:]
axis, origin = np.array([0, 0.6, -0.8]), np.array([1.0, 0, 25])
ax, ay = np.array([1.0, 0, 0]), np.array([0, 0.8, 0.6])
a, b = (start - origin) @ axis, (end - origin) @ axis
hit = np.flatnonzero(((a > 0) & (b <= 0)) | ((a < 0) & (b >= 0)))
place = start[hit] + (a[hit] / (a[hit] - b[hit]))[:, None] * (end[hit] - start[hit])
way = end[hit] - start[hit]
cosine = -(way @ axis) / np.linalg.norm(way, axis=1)
px, py = (place - origin) @ ax, (place - origin) @ ay
good = (np.abs(px) <= 4) & (np.abs(py) <= 3) & (cosine > math.cos(math.radians(50)))
hit, px, py = hit[good], px[good], py[good]
rays = np.repeat(np.arange(len(source)), legs)[hit]
total, covariance = estimate(np.column_stack([np.ones(len(px)), px, py]), rays)
near("registrations of the receiver", d["registrations"], len(px), rel=0, abs_tol=1)
near("its flux", [d["flux"]["total"], d["flux"]["standard_error"]], [total[0], math.sqrt(covariance[0, 0])], rel=2e-3)
near("its centroid", [d["spot"]["centroid"][k]["value"] for k in "xy"], total[1:] / total[0], abs_tol=2e-3)
expected = np.zeros((12, 16))
np.add.at(expected, (np.minimum((py + 3) * 2, 11).astype(int), np.minimum((px + 4) * 2, 15).astype(int)), 1)
if np.abs(np.load("cut.npz")["rays"] - expected).sum() > 4:
    failures += 1
    print("FAILED: the receiver's cells", np.abs(np.load("cut.npz")["rays"] - expected).sum())

# ---- known spots: a uniform disc, a Gaussian
one = detector("disc.raymap", "sensor", "--where", "source(beam) and path(\"[^V]V@sensor.*\") and registered(sensor) == 1", "--mtf", "--frequency", "1")


def sigmas(what, got, error, expected, most=4.5):
    global failures
    if not abs(got - expected) <= most * error + 2e-4:
        failures += 1
        print("FAILED:", what, got, "+-", error, "not", expected)


def bessel1(z): # its integral form
    t = np.linspace(0, math.pi, 4001)
    return np.trapz(np.cos(t - z * np.sin(t)), t) / math.pi


spot, mtf = one["spot"], one["mtf"]
sigmas("disc: RMS radius", spot["rms"]["radius"]["value"], spot["rms"]["radius"]["standard_error"], math.sqrt(2.0))
for row in spot["encircled"]:
    sigmas("disc: radius", row["radius"], row["standard_error"], 2 * math.sqrt(row["fraction"]))
for k in (5, 10, 15, 20):
    z = 2 * math.pi * 2 * mtf["frequency"][k]
    for name in ("tangential", "sagittal"):
        sigmas("disc: MTF", mtf[name][k], mtf[name + "_standard_error"][k], abs(2 * bessel1(z) / z))
random = np.random.default_rng(7)
points = random.normal(0, 0.5, (3000, 2))


def trace_points(name, points):
    """A map of light that runs along z through these places."""
    rows = "".join(f"\n      - {{origin: [{px:.9f}, {py:.9f}, -10], direction: [0, 0, 1]}}" for px, py in points)
    open(name + ".yaml", "w").write(SCENE.replace("reflectance: 0.5", "reflectance: 0") %
        ("  - name: list\n    type: rays\n    flux: 1 W\n    medium: air\n    rays:" + rows + "\n"))
    run(RAYMAP, "trace", "--encoding", "plain", name + ".yaml", "-o", name + ".raymap", "-n", str(len(points)), "--quiet", "--force")


trace_points("gauss", points)
d = detector("gauss.raymap", "sensor", "--mtf")
sigmas("Gaussian: RMS x", d["spot"]["rms"]["x"]["value"], d["spot"]["rms"]["x"]["standard_error"], 0.5)
for row in d["spot"]["encircled"]:
    sigmas("Gaussian: radius", row["radius"], row["standard_error"], 0.5 * math.sqrt(-2 * math.log(1 - row["fraction"])))
for k in (5, 15, 25):
    expected = math.exp(-2 * (math.pi * 0.5 * d["mtf"]["frequency"][k]) ** 2)
    sigmas("Gaussian: MTF", d["mtf"]["tangential"][k], d["mtf"]["tangential_standard_error"][k], expected)
half = d["mtf"]["half"]["sagittal"]
sigmas("Gaussian: MTF 50 %", half["value"], half["standard_error"], math.sqrt(math.log(2) / 2) / (math.pi * 0.5))
# One per cent of stray light makes the RMS size 50 times that of the spot, and hides nothing.
trace_points("halo", np.concatenate([0.02 * points, random.uniform(-4, 4, (30, 2))]))
d = detector("halo.raymap", "sensor", "--mtf")
assert d["spot"]["rms"]["radius"]["value"] > 0.2, d["spot"]["rms"]
half = d["mtf"]["half"]["sagittal"]
assert abs(half["value"] / (math.sqrt(math.log(2) / 2) / (math.pi * 0.01)) - 1) < 0.1, half
# Where the contrast is one half does not depend on the frequencies that are shown.
halves = [detector("disc.raymap", "sensor", "--mtf", *more)["mtf"]["half"] for more in ((), ("--frequency", "1e5"), ("--frequency", "0.3"))]
assert halves[0] == halves[1] == halves[2] and halves[0]["tangential"]["value"] > 0, halves

# All light in one place: no frequency finer than the stored steps; of a single ray no errors.
trace_points("place", np.array([[1.0, 2.0]] * 9))
d = detector("place.raymap", "sensor", "--mtf")
assert d["mtf"]["frequency"][-1] <= 65535 / 4 / 16 and min(d["mtf"]["tangential"]) > 0.99999, d["mtf"]["frequency"][-1]
trace_points("ray", np.array([[1.0, 2.0]]))
one = detector("ray.raymap", "sensor", "--spot")["spot"]
assert one["centroid"]["x"]["standard_error"] is None and one["centroid"]["x"]["value"] is not None, one["centroid"]

# ---- errors against twenty seeds
seen = []
for seed in range(1, 21):
    run(RAYMAP, "trace", "--encoding", "plain", "disc.yaml", "-o", "seed.raymap", "-n", "2000", "--seed", str(seed), "--quiet", "--force")
    d = detector("seed.raymap", "sensor", "--mtf", "--frequency", "0.5", "--quantity", "spectral", "--cells", "4x4")
    spot, mtf = d["spot"], d["mtf"]
    radius = [(row["radius"], row["standard_error"]) for row in spot["encircled"]]
    seen.append([(d["flux"]["total"], d["flux"]["standard_error"]), (d["spectrum"][2]["flux"], d["spectrum"][2]["standard_error"]),
                 *[(e["value"], e["standard_error"]) for e in (spot["centroid"]["x"], spot["rms"]["x"], spot["rms"]["radius"], mtf["half"]["tangential"])], *radius,
                 *[(mtf[k][n], mtf[k + "_standard_error"][n]) for k, n in (("tangential", 5), ("sagittal", 10))]])
seen = np.array(seen)
for k in range(seen.shape[1]):
    ratio = seen[:, k, 0].var(ddof=1) / (seen[:, k, 1] ** 2).mean()
    if not 0.4 <= ratio <= 2.3:
        failures += 1
        print("FAILED: over seeds, number", k, "varies", ratio, "times as much as it says")

# ---- any number of ranks; nothing there; nonsense
command = (RAYMAP, "detector", "disc.raymap", "cut", "--receivers", "cut.yaml", "--mtf", "--quantity", "spectral", "--color", "true", "--json", "--force", "--where", "registered(cut)", "-o")
once = run(*command, "once.csv")
for np_ in ("2", "3") if SLOW else ("2",):
    if run("mpirun", "-np", np_, *command, "again.csv") != once or open("again.csv").read() != open("once.csv").read():
        failures += 1
        print("FAILED:", np_, "ranks differ")
d = detector("disc.raymap", "sensor", "--where", "segments > 100000", "--mtf", "-o", "none.png", "--plot", "none.svg", "--force")
if d["registrations"] != 0 or d["spot"]["rms"]["radius"]["value"] is not None or "note" not in d:
    failures += 1
    print("FAILED: an empty spot", d["spot"])
for words, says in ((("--cells", "1000000000"), "cells are the most"), (("--cells", "8192x8192", "--quantity", "spectral"), "fewer cells"),
                    (("--cells", "-3"), "400x300"), (("--region", "0,0,1"), "four numbers"), (("--region", "1,0,0,1"), "backwards"),
                    (("--region", "0,0,1 kg,1"), "kg"), (("--region", "nan,0,1,1"), "--region"), (("--rotate", "nan"), "no angle"),
                    (("--quantity", "brightness"), "luminance"), (("--over", "time"), "direction"), (("--mtf", "--frequency", "0"), "greater than 0"),
                    (("--tally", "--spot"), "--tally"), (("--tally", "--cells", "3"), "--tally"), (("--plot", "x.png"), "--spot")):
    run(RAYMAP, "detector", "disc.raymap", "sensor", *words, status=2, says=says)
run(RAYMAP, "detector", "disc.raymap", "cu", "--receivers", "cut.yaml", status=3, says="did you mean 'cut'?")
sys.exit(1 if failures else 0)
