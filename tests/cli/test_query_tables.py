#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `query -o OUT.h5` has the matching rays as tables of plain columns, the same as Python reads them from the
map, byte for byte for any number of ranks; --columns chooses; what there is not is told; a failure leaves nothing."""
import filecmp
import json
import os
import sys

import h5py
import numpy as np

sys.dont_write_bytecode = True
from asking import check, finish, run, trace  # noqa: E402
import raymap  # noqa: E402 (asking knows where it is)

TABLES = ("ray", "segment", "registration")
OWN = {"segment": {"length", "angle_of_incidence", "reflectance"}}


def same(one, a, b):
    if one == "angle":  # by other formulas
        return a.shape == b.shape and np.allclose(a, b, rtol=0, atol=1e-5)
    return a.dtype == b.dtype and np.array_equal(a, b, equal_nan=a.dtype.kind == "f")


def agrees_with_records(name, criterion):
    """Every column that Python knows, of the rays that match."""
    run("query", name, criterion, "-o", "t.h5", "--force", "--quiet")
    rays = raymap.open(name)
    with h5py.File("t.h5") as file:
        picked = file["ray/id"][:]
        check(len(picked) == raymap.query(name, criterion)["rays"]["matched"], f"rays of {criterion} in {name}")
        check(file.attrs["criterion"].decode() == criterion and file.attrs["map"].decode() == name, "where it is from")
        for table in TABLES:
            told = raymap.records(rays, table)
            keep = np.isin(told["id" if table == "ray" else "ray_id"], picked)
            numbers = {one for one in told if not one.endswith("_name")}
            check(set(file[table]) == numbers | OWN.get(table, set()), f"columns of {table} in {name}: {sorted(file[table])}")
            for one in numbers & set(file[table]):
                check(same(one, file[table][one][:], told[one][keep]), f"{table}/{one} of {name}")
                check("units" in file[table][one].attrs and "description" in file[table][one].attrs, f"words of {table}/{one}")
        check([n.decode() for n in file["name/object"]] == list(rays.names["object"]), "names")
        attributes = [file.attrs[one] for one in ("digest", "seed", "complete")]
        check(attributes == [rays.digest.encode(), rays.seed, 1], f"what it is of: {attributes}")
        check("`event_bits`" in file["segment/event"].attrs["description"].decode() and "event_bits" in file.attrs, "where bits are told")
    for ranks, column in ((1, "registration/x"), (2, "registration/angle"), (1, "segment/flux"), (2, "registration/wavelength"),
                          (1, "segment/position_y"), (1, "ray/path_length")):
        run("query", name, criterion, "-o", "one.h5", "--columns", column, "--force", "--quiet", ranks=ranks)
        with h5py.File("one.h5") as one, h5py.File("t.h5") as file:
            check(np.array_equal(one[column], file[column], equal_nan=True), f"{column} alone, of {criterion} in {name}")


def says_what_report_says(name, criterion):
    """Lengths, angles and reflectances are those of `report`."""
    rows = raymap.table(name, "segment", where=criterion, limit=5)
    seen = {"length": [], "angle_of_incidence": [], "reflectance": []}
    for ray in dict.fromkeys(rows["ray_id"].tolist()):
        for step in raymap.report(name, ray)["steps"]:
            for one, values in seen.items():
                values.append(np.nan if step[one] is None else step[one])
    for one, values in seen.items():
        check(len(values) > 0 and np.allclose(rows[one], values, rtol=1e-8, atol=0, equal_nan=True), f"{one} as reported")


lens = trace("double-gauss", "lens.raymap", 20000)
plain = trace("double-gauss", "plain.raymap", 9000, "--encoding", "plain")
agrees_with_records(lens, "registered(sensor)")
agrees_with_records(lens, "registered(sensor where x > 8)")  # more rays are looked at than match
agrees_with_records(lens, "registered(sensor where angle > 20)")
agrees_with_records(plain, "all")
agrees_with_records(trace("room", "room.raymap", 600), "bounces >= 3")
agrees_with_records(trace("selfoc", "rod.raymap", 300), "all")
agrees_with_records(lens, "bounces > 1000")
says_what_report_says(lens, "hit(lens.*, reflect) >= 2")

for ranks in (2, 3):
    run("query", lens, "registered(sensor)", "-o", f"{ranks}.h5", "--force", "--quiet", ranks=ranks)
run("query", lens, "registered(sensor)", "-o", "1.h5", "--force", "--quiet")
check(filecmp.cmp("1.h5", "2.h5", shallow=False) and filecmp.cmp("1.h5", "3.h5", shallow=False), "any number of ranks")

def explained(*words):
    return json.loads(run("query", lens, "registered(sensor)", "-o", "no.h5", "--explain", "--json", *words))[0]


told = explained("--columns", "registration/x,ray/flux")
check({"/registration/relative", "/ray/weight"} < set(told["columns"]) and "/segment/position" not in told["columns"] and
      told["compact"]["traced_again"] == 0 < told["compact"]["portions"], f"--explain of places: {told}")
told = explained("--columns", "registration/time")
check("/registration/optical_path" in told["columns"] and told["compact"]["traced_again"] > 0, f"--explain of times: {told}")
check("/segment/position" in explained()["columns"], "--explain of all columns")

fibre = trace("wls-fibre", "fibre.raymap", 400)  # a thousand steps and more a ray
check(raymap.table(fibre, "ray", "id")["id"].tolist() == list(range(400)), "few columns of rays with many steps")
few = raymap.table(lens, "registration", "detector_name", "time", "x", where="registered(sensor)", sample=100, seed=3)
check(list(few) == ["detector_name", "time", "x"] and set(few["detector_name"]) == {"sensor"}, "columns by name")
check(len(few["x"]) >= 100 and np.isfinite(few["time"]).all(), "a sample")
run("query", lens, "all", "--limit", 7, "--columns", "segment, ray/flux", "-o", "few.h5", "--force", "--quiet")
with h5py.File("few.h5") as file:
    check(set(file) == {"name", "ray", "segment"} and list(file["ray"]) == ["flux"] and len(file["ray/flux"]) == 7, "--columns")
    check(file.attrs["answer"] == b"limit 7", f"of which rays: {file.attrs['answer']}")
for words, answer in (((), b"all"), (("--sample", 9, "--seed", 4), b"sample 9 seed 4"), (("--top", 2, "--of", "flux"), b"top 2 of flux")):
    run("query", lens, "all", *words, "--columns", "ray/id", "-o", "few.h5", "--force", "--quiet")
    with h5py.File("few.h5") as file:
        check(file.attrs["answer"] == answer, f"of which rays: {file.attrs['answer']}")

with open("shiny.yaml", "w", encoding="utf-8") as file:
    file.write("""raymap: 1
surfaces: {satin: {type: mirror, reflectance: 0.9, scatter: {model: unified, sigma_alpha: 5, spike: 0.3, lobe: 0.5}}}
geometries: {ball: {type: sphere, radius: 10}}
objects: [{name: ball, geometry: ball, surface: satin}]
sources: [{name: lamp, type: point, flux: 1 W}]
limits: {steps: 30}
""")
run("trace", "shiny.yaml", "-o", "shiny.raymap", "-n", 100, "--quiet", "--force")
run("query", "shiny.raymap", "all", "-o", "few.h5", "--columns", "segment/reflectance", "--force", "--quiet")  # no quadrature over facets
with h5py.File("few.h5") as file:
    check(np.allclose(file["segment/reflectance"][:], 0.27, rtol=1e-12), "of a spike")

for words, status, told in ((("--columns", "registration/tme", "-o", "no.h5"), 3, "did you mean 'registration/time'?"),
                            (("--columns", "ray/foo", "-o", "no.h5"), 3, "no column 'ray/foo': there are"),
                            (("--columns", "ray,,segment", "-o", "no.h5"), 3, "names no column: 'ray,,segment'"),
                            (("--columns", "ray, ", "-o", "no.h5"), 3, "names no column"), (("--columns", " , ", "-o", "no.h5"), 3, "names no column"),
                            (("--columns", "ray", "-o", "no.csv"), 2, "-o OUT.h5"), (("--columns", "ray"), 2, "-o OUT.h5"),
                            (("-o", "few.h5"), 2, "--force"), (("-o", "nowhere/no.h5"), 3, "nowhere")):
    error = run("query", lens, "all", *words, status=status)
    check(told in error, f"{words}: {error}")
check(not [name for name in os.listdir(".") if "no.h5" in name or ".part" in name], f"nothing is left: {os.listdir('.')}")
finish()
