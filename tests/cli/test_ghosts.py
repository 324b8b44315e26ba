#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `ghosts` lists the pairs of surfaces that make ghosts; each row's criterion gives its numbers in `detector`, rows add up to
what was registered without scattering, and the answer is the same on two ranks. Pictures and table are written."""
import csv
import json
import math
import os
import re
import subprocess
import sys
import tempfile

GAUSS = os.path.join(os.environ["SOURCE_DIR"], "examples", "double-gauss", "scene.yaml")
failures = []
os.chdir(tempfile.mkdtemp(dir="."))


def check(holds, what):
    if not holds:
        failures.append(what)


def run(*words, status=0, ranks=0):
    launcher = ["mpirun", "--oversubscribe", "-np", str(ranks)] if ranks else []
    done = subprocess.run([*launcher, os.environ["RAYMAP"], *map(str, words)], capture_output=True, text=True, check=False)
    check(done.returncode == status, f"{words}: status {done.returncode}, not {status}: {done.stderr}")
    return done.stdout


run("trace", GAUSS, "-n", "100000", "-o", "lens.raymap", "-q")
document = json.loads(run("ghosts", "lens.raymap", "sensor", "--top", "1000", "--json"))
rows = document["rows"]
check(document["rest"]["pairs"] == 0 and len(rows) > 30 and rows[0]["order"] == 0, f"{len(rows)} rows, {document['rest']}")
pairs = [row for row in rows if row["order"] == 2]
check([row["flux"]["value"] for row in pairs] == sorted((row["flux"]["value"] for row in pairs), reverse=True), "sorted by flux")
unscattered = json.loads(run("detector", "lens.raymap", "sensor", "--where", "registered(sensor where scatter_order == 0)", "--json"))
check(math.isclose(math.fsum(row["flux"]["value"] for row in rows), unscattered["flux"]["total"], rel_tol=1e-12), "rows add up")
check(sum(row["registrations"] for row in rows) == unscattered["registrations"], "registrations add up")
for row in rows[:6] + rows[-2:]:
    image = json.loads(run("detector", "lens.raymap", "sensor", "--where", row["criterion"], "--json"))
    check(image["flux"]["total"] == row["flux"]["value"] and image["registrations"] == row["registrations"], f"{row}")
    check(image["peak"]["value"] == row["peak"]["value"] and image["peak"]["x"] == row["peak"]["x"], f"{row} {image['peak']}")
    check(math.isclose(row["ratio"], row["flux"]["value"] / rows[0]["flux"]["value"]), f"ratio {row}")
check(json.loads(run("ghosts", "lens.raymap", "sensor", "--top", "1000", "--json", ranks=2)) == document, "two ranks")

text = run("ghosts", "lens.raymap", "sensor", "--where", "source(sun)", "--cells", "18x12", "--top", "2", "-o", "g.png", "-o", "g.csv")
check("pairs more" in text and "(source(sun)) and registered(sensor" in text, text)
check(sorted(name for name in os.listdir() if name.endswith(".png"))[:3] == ["g-0.png", "g-1.png", "g-2.png"], str(os.listdir()))
with open("g.csv", encoding="utf-8") as file:
    table = list(csv.DictReader(line for line in file if not line.startswith("#")))
check([row["number"] for row in table[:3]] == ["0", "1", "2"] and table[1]["order"] == "2", str(table[:2]))
run("ghosts", "lens.raymap", "sensor", "-o", "g.png", status=2)
run("draw", "lens.raymap", "--where", "registered(sensor where ghost_order == 2)", "--color", "order", "-o", "order.svg")
with open("order.svg", encoding="utf-8") as file:
    orders = set(re.findall("ghost order [0-9]", file.read()))
check(orders == {"ghost order 2"}, f"orders are those at the detector: {orders}")
check("did you mean 'sensor'" in subprocess.run([os.environ["RAYMAP"], "ghosts", "lens.raymap", "senor"], capture_output=True,
                                                text=True, check=False).stderr, "nearest name")
print("\n".join(failures) or "as promised")
sys.exit(bool(failures))
