#!/usr/bin/python3
# SPDX-License-Identifier: MIT
#
# The promise: receivers laid over a finished map register what the same detectors register when
# they stand in the traced scene, in the same order among the others; for any number of ranks; and
# mistakes in their file are told with their place.
import json, os, re, subprocess, sys

RAYMAP, EXAMPLES = os.environ["RAYMAP"], os.path.join(os.environ["SOURCE_DIR"], "examples")
SLOW = int(os.environ.get("RAYMAP_TEST_SCALE", "1")) > 1
failures = 0


def run(*words, status=0, says=""):
    global failures
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode != status or says not in done.stdout + done.stderr:
        failures += 1
        print("FAILED:", done.returncode, "not", status, repr(says), words, done.stdout[:500], done.stderr[:1500])
    return done.stdout


LENS = """
  - {name: sensor2, type: plane, on: sensor_surface, size: [36, 24], cells: [180, 120], at: [0, 0, 139.5658], direction: [0, 0, -1]}
  - {name: tilted, type: plane, size: [30, 30], cells: [50, 40], at: [0, 0, 120], direction: [0, 0.1, -1], max_angle: 20}
  - {name: far, type: intensity, cells: [18, 36], axis: [0, 0, 1]}
  - {name: outside, type: plane, size: [3000, 3000], cells: 10, at: [0, 0, -2000], direction: [0, 0, 1], side: both}
"""
ROOM = """
  - {name: floor2, type: plane, on: floor, size: [6.0, 4.0], cells: [120, 80], at: [0, 0, 0], direction: [0, 0, 1]}
  - {name: desk, type: plane, size: [6, 4], cells: [60, 40], at: [0, 0, 1], direction: [0, 0, 1]}
  - {name: wall, type: plane, size: [4, 2], cells: 16, at: [1, 0, 1.2], direction: [1, 0.3, 0.1], side: back}
"""
SELFOC = """
  - {name: mid, type: plane, size: [1.2, 1.2], cells: 60, at: [0, 0, 5], direction: [0, 0.2, -1], side: both}
  - {name: along, type: plane, size: [1.2, 1.2], cells: 60, at: [0, 0.1, 9], direction: [0, 1, 0.01], side: both}
  - {name: paper2, type: plane, on: paper, size: [1.2, 1.2], cells: 120, at: [0, 0, 15.499081], direction: [0, 0, -1]}
"""
# scene, receivers, rays, questions: (criterion, rays that the rounding of stored points may move)
CASES = (
    ("double-gauss", LENS, 10000,
     (("registered(sensor2)", 0), ("registered(sensor) and registered(sensor2)", 0), ("crossed(tilted)", 1),
      ("registered(tilted)", 1), ("registered(tilted, cells(20..24, 10..19))", 1), ("registered(far, cells(0..4, 0..35))", 1),
      ("registered(outside)", 1), ("angle(outside) < 20", 1), ("x(tilted) in 3..4", 1), ("time(tilted) < 0.7 ns", 1),
      ('path(".*V@tilted.*V@sensor V@sensor2.*")', 1), ("registered(outside) == 0 and hit(*, reflect) >= 2", 1))),
    ("room", ROOM, 1500,
     (("registered(floor2)", 0), ("registered(floor_map) == 2 and registered(floor2) == 2", 1), ("registered(desk) >= 3", 2),
      ("registered(desk, cells(0..29, 0..19))", 2), ("registered(wall)", 2), ("angle(wall) > 120", 2),
      ('path(".*V@desk.*V@wall.*")', 2), ('path(".*V@floor_map V@floor2.*")', 0))),
    ("selfoc", SELFOC, 10000,
     (("registered(mid)", 1), ("registered(mid, cells(24..29, 0..59))", 3), ("registered(along)", 1), ("angle(mid) < 10", 3),
      ("x(mid) > 0.1", 3), ("time(along) > 0.045 ns", 1), ("registered(paper2)", 0), ('path(".*V@mid V@along.*")', 1))),
)


def matched(text):
    answer = json.loads(text)
    return [one["rays"]["matched"] for one in (answer if isinstance(answer, list) else [answer])]


for name, receivers, rays, questions in CASES:
    folder = os.path.join(EXAMPLES, name)
    scene = open(os.path.join(folder, "scene.yaml")).read()
    meshes = os.path.join(folder, "meshes")
    if os.path.isdir(meshes) and not os.path.exists("meshes"):
        os.symlink(meshes, "meshes")
    head, tail = scene.split("\ndetectors:\n", 1)
    own, rest = tail.split("\n", 1)
    open(name + ".yaml", "w").write(scene)
    open(name + "-all.yaml", "w").write(head + "\ndetectors:\n" + own + receivers + rest)
    open(name + "-receivers.yaml", "w").write("detectors:" + receivers)
    for kind in ("", "-all"):
        run(RAYMAP, "trace", f"{name}{kind}.yaml", "-o", f"{name}{kind}.raymap", "-n", str(rays), "--quiet", "--force")
    text = [question for question, _ in questions]
    over = [RAYMAP, "query", name + ".raymap", *text, "--receivers", name + "-receivers.yaml", "--json"]
    traced = matched(run(RAYMAP, "query", name + "-all.raymap", *text, "--json"))
    laid = matched(run(*over))
    for (question, slack), a, b in zip(questions, traced, laid):
        if abs(a - b) > slack or a + b == 0:
            failures += 1
            print("FAILED:", name, question, "traced", a, "laid over", b)
    plain = [RAYMAP, "query", name + ".raymap", *text, "--receivers", name + "-receivers.yaml", "--quiet"]
    once = run(*plain)
    for np in ("2", "3", "4") if SLOW else ("2",):
        if run("mpirun", "-np", np, *plain) != once:
            failures += 1
            print("FAILED:", name, "np", np, "differs")

# Numbers of the registrations: positions, angles, optical paths through dispersive glass and curves
for name, of in (("double-gauss", "x(tilted)"), ("double-gauss", "angle(tilted)"), ("double-gauss", "optical_path(outside)"),
                 ("room", "optical_path(desk)"), ("selfoc", "x(mid)"), ("selfoc", "optical_path(along)"), ("selfoc", "angle(mid)")):
    traced = json.loads(run(RAYMAP, "stats", name + "-all.raymap", "--of", of, "--json"))
    laid = json.loads(run(RAYMAP, "stats", name + ".raymap", "--of", of, "--receivers", name + "-receivers.yaml", "--json"))
    for key in ("mean", "standard_deviation"):
        a, b = traced[key]["value"], laid[key]["value"]
        if not abs(a - b) <= 2e-4 * traced["standard_deviation"]["value"] + 1e-6 * abs(a):
            failures += 1
            print("FAILED:", name, of, key, "traced", a, "laid over", b)

QUERY = (RAYMAP, "query", "double-gauss.raymap", "all", "--receivers")
for text, says in (
    ("detectors:\n  - {name: sensor, type: plane, size: 1, cells: 1, at: [0, 0, 1]}\n", "bad.yaml:2:5: error: the name 'sensor' is taken by a detector of the map's scene"),
    ("detectors:\n  - {name: a, type: plane, size: 1, cells: 100000}\n", "bad.yaml:2:44: error: 'cells' must be"),
    ("detectors:\n  - {name: a, type: plane, size: 1, cells: [60000, 60000]}\n", "cells are too many"),
    ("detectors:\n  - {name: a, type: plane, on: sensor_surfac, size: 1, cells: 1}\n", "did you mean 'sensor_surface'?"),
    ("detectors:\n  - {name: a, type: plane, size: [1, .nan], cells: 1}\n", "bad.yaml:2:"),
    ("detectors:\n  - {name: a, type: plane, size: 1, cells: 1, at: [1e300, 1e300, 0], direction: [0, 0, 1]}\n", "bad.yaml:"),
    ("detectors:\n  - {name: a, type: plain, size: 1, cells: 1}\n", "did you mean 'plane'?"),
    ("detectors:\n  - {name: a, type: plane, size: 1, cells: 1}\n  - {name: a, type: plane, size: 1, cells: 1}\n", "is taken by the detector on line 2"),
    ("objects: []\n", "unknown key in a file of receivers"),
    ("detectors: []\n", "no receivers"),
    ("[]\n", "no receivers"),
    ("- {name: a, type: plane, size: 1, cells: 100000}\n", "bad.yaml:1:42: error: 'cells' must be"),
    ("a: [", "bad.yaml:2:1: error: this is not YAML"),
    ("", "empty"),
):
    open("bad.yaml", "w").write(text)
    run(*QUERY, "bad.yaml", status=3, says=says)
run(*QUERY, "nowhere.yaml", status=3, says="nowhere.yaml")
run(*QUERY, "double-gauss-receivers.yaml", "--explain", status=2, says="leave one of them out")


# The list may stand alone
listed = open("double-gauss-receivers.yaml").read()
assert listed.startswith("detectors:"), listed
open("alone.yaml", "w").write(listed.replace("detectors:", "", 1))
told = [run(*QUERY[:3], "registered(*)", "--receivers", name, "--json", "--quiet") for name in
        ("double-gauss-receivers.yaml", "alone.yaml")]
assert len({json.dumps(json.loads(text)["flux"]) for text in told}) == 1, told


# Rays listed, sampled, written and drawn by what receivers saw: those that a run with them as detectors lists
def ids(text):
    return [ray["ray"] for ray in json.loads(text)]


def same_for_ranks(*words, files=()):
    told = []
    for start in ((), ("mpirun", "-np", "2")):
        says = run(*start, *words)
        told.append((says, [open(file, "rb").read() for file in files]))
    if any(one != told[0] for one in told):
        global failures
        failures += 1
        print("FAILED: ranks differ", words)
    return told[0][0]


def expect(holds, what):
    global failures
    if not holds:
        failures += 1
        print("FAILED:", what)


over = ("--receivers", "double-gauss-receivers.yaml")
asked = "registered(sensor2) and hit(*, reflect) >= 2"
for words in (("--sample", "9", "--seed", "3"), ("--limit", "7"), ("--limit", "1000000"))[0 if SLOW else 1:]:
    want = ids(run(RAYMAP, "query", "double-gauss-all.raymap", asked, *words, "--json"))
    expect(len(want) > 5, f"{words}: {len(want)} rays")
    expect(ids(same_for_ranks(RAYMAP, "query", "double-gauss.raymap", asked, *over, *words, "--json")) == want, f"rays of {words}")
run(RAYMAP, "query", "double-gauss.raymap", asked, *over, "-o", "picked.raymap", "--quiet", "--force")
expect(ids(run(RAYMAP, "query", "picked.raymap", "all", "--limit", "1000000", "--json")) == want, "a map of these rays")
run(RAYMAP, "query", "double-gauss.raymap", asked, *over, "-o", "picked.csv", "--quiet", "--force")
expect({int(line.split(",")[0]) for line in open("picked.csv") if line[0].isdigit()} == set(want), "a table of these rays")
expect(run(RAYMAP, "query", "double-gauss.raymap", "segments > 1000", *over, "--limit", "3", "--json").split() in (["[]"], ["[", "]"]), "no ray")

picture = (RAYMAP, "draw", "double-gauss.raymap", *over, "--where", "registered(tilted)", "--where", "registered(outside)",
           "--limit", "40", "--force", "--quiet", "-o")
run(*picture, "over.svg")
same_for_ranks(*picture, "over.vtp", files=["over.vtp"])
drawn = open("over.svg").read()
expect(all(f">{name}<" in drawn for name in ("tilted", "sensor2", "sensor")), "receivers are marked in a picture")
expect("registered(tilted)" in drawn and "ray" in drawn, "a legend of criteria")
run(*picture, "over.html")
page = open("over.html").read()
data = json.loads(page[page.index('id="data">') + 10:].split("</script>")[0])
images = {one["name"]: one["image"] for one in data["detectors"]["list"]}
for name in ("tilted", "far", "outside") if SLOW else ("far",):
    where = '(registered(tilted)) or (registered(outside))'
    told = json.loads(run(RAYMAP, "detector", "double-gauss.raymap", name, *over, "--where", where, "--json"))
    expect(images[name]["registrations"] == told["registrations"] > 0, f"the page's image of {name}")
expect(data["where"]["list"][0]["criterion"] == "registered(tilted)" and data["where"]["list"][0]["here"] > 0, "the page's criteria")
expect(any("V@tilted" in one["sequence"] for one in data["classes"]["list"]), "the page's classes")
run(RAYMAP, "query", "double-gauss.raymap", "registered(tilte)", "--receivers", "double-gauss-receivers.yaml", status=3, says="did you mean 'tilted'?")

# Rays of two colour spaces in one picture: each registered as a query says, with the index of its own space.
scene = os.path.join(EXAMPLES, "double-gauss", "scene.yaml")
run(RAYMAP, "trace", scene, "-o", "spaces.raymap", "-n", "6000", "--quiet", "--force")
run(RAYMAP, "trace", scene, "-o", "spaces.raymap", "-n", "6000", "--append", "--color", "rgb", "--quiet")
kinds = ["registered(tilted) and ray < 6000 and optical_path(tilted) < 169.8", "registered(tilted) and ray >= 6000 and optical_path(tilted) < 169.8",
         "registered(tilted) and optical_path(tilted) >= 169.8", "registered(far) and angle(far) < 160"]
where = [word for kind in kinds for word in ("--where", kind)]
run(RAYMAP, "draw", "spaces.raymap", *over, *where, "--color", "criterion", "--limit", "100000", "-o", "spaces.svg", "--force", "--quiet")
drawn, before = re.sub("</text>\n<text[^>]*>", " ", open("spaces.svg").read()), "ray < 0"  # lines of the legend joined
for kind in kinds:
    n = json.loads(run(RAYMAP, "query", "spaces.raymap", f"({kind}) and not ({before})", *over, "--json", "--quiet"))["rays"]["matched"]
    before += f" or ({kind})"
    text = kind.replace("<", "&lt;").replace(">", "&gt;")
    expect(n > 20 and re.search(f">{n:,} rays, [0-9.]+ % of flux: {re.escape(text)}[ <]", drawn), f"{n} rays of {kind}")
same_for_ranks(RAYMAP, "draw", "spaces.raymap", *over, *where, "-o", "spaces.html", "--force", "--quiet", files=["spaces.html"])
sys.exit(1 if failures else 0)
