#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `query --top N --of Q` lists the rays with the greatest values, as the columns have them, alike for either encoding
and any number of ranks; a ray counts by the greatest of its registrations that the criterion chooses; -o writes these rays."""
import json
import sys

import numpy as np

sys.dont_write_bytecode = True
from asking import check, finish, run, trace  # noqa: E402
import raymap  # noqa: E402 (asking knows where it is)


def greatest(ids, values, n):
    """Of each ray its greatest; the greatest first, of equal ones the smaller id."""
    best = {}
    for ray, value in zip(ids.tolist(), values.tolist()):
        if not np.isnan(value):
            best[ray] = max(value, best.get(ray, -np.inf))
    return sorted(best.items(), key=lambda one: (-one[1], one[0]))[:n]


def agrees(name, criterion, of, n, ids, values):
    told = json.loads(run("query", name, criterion, "--top", n, "--of", of, "--json"))
    wanted = greatest(ids, values, n)
    check(told["of"] == of and [one["ray"] for one in told["top"]] == [ray for ray, _ in wanted] and
          np.allclose([one["value"] for one in told["top"]], [value for _, value in wanted], rtol=1e-12),
          f"{n} greatest {of} of {criterion} in {name}: {told['top'][:3]}, {wanted[:3]}")


for encoding in ("compact", "plain"):
    name = trace("double-gauss", encoding + ".raymap", 20000, "--encoding", encoding)
    ray = raymap.records(raymap.open(name), "ray")
    agrees(name, "all", "path_length", 50, ray["id"], ray["path_length"])
    agrees(name, "all", "optical_path - path_length", 50, ray["id"], ray["optical_path"] - ray["path_length"])
    agrees(name, "source(star)", "-1 * path_length", 50, *(of[ray["source"] == 0] for of in (ray["id"], -ray["path_length"])))
    agrees(name, "segments > 9", "segments", 200, *(ray[one][ray["segment_count"] > 9] for one in ("id", "segment_count")))
    seen = raymap.table(name, "registration", where="registered(sensor)")
    kept = seen["registered"] == 1
    agrees(name, "registered(sensor)", "x(sensor)", 10 ** 6, seen["ray_id"][kept], seen["x"][kept])
    kept &= seen["y"] > 0  # of the registrations that the criterion chooses, no others
    agrees(name, "registered(sensor where y > 0)", "time(sensor)", 20, seen["ray_id"][kept], seen["time"][kept])
    agrees(name, "bounces > 1000", "path_length", 5, ray["id"][:0], ray["path_length"][:0])

words = ("query", "compact.raymap", "registered(sensor)", "--top", 30, "--of", "path_length")
check(run(*words) == run(*words, ranks=3) and run(*words).split()[:3] == ["ray", "path_length", "/"], "the same for any ranks")
run(*words, "-o", "top.csv", "--force", "--quiet")
run(*words, "-o", "top.raymap", "--force", "--quiet", ranks=2)
listed = sorted(int(line.split()[0]) for line in run(*words).splitlines()[1:])
with open("top.csv", encoding="utf-8") as file:
    check(sorted({int(line.split(",")[0]) for line in list(file)[1:]}) == listed and len(listed) == 30, "-o OUT.csv")
check(raymap.records(raymap.open("top.raymap"))["id"].tolist() == listed, "-o OUT.raymap")

for more, told in ((("--top", 3), "--of path_length"), (("--top", 0, "--of", "flux"), "at least one"), (("--of", "flux"), "--top"),
                   (("--top", 3, "--of", "flux", "--sample", 3), "give one"), (("--top", 3, "--of", "flux", "--count"), "--count")):
    error = run("query", "compact.raymap", "all", *more, status=2)
    check(told in error, f"{more}: {error}")
check("did you mean 'time'?" in run("query", "compact.raymap", "all", "--top", 3, "--of", "tme(sensor)", status=3), "unknown number")
told = json.loads(run("query", "compact.raymap", "registered(sensor)", "--top", 3, "--of", "x(sensor) - 1 mm", "--explain", "--json"))[0]
check("/segment/position" not in told["columns"] and told["compact"]["traced_again"] == 0, f"--explain: what the number needs: {told}")

finish()
