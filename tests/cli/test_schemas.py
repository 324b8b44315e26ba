#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: docs/schemas describes every JSON document, key by key. Runs every command once with --json, and validates that
and whatever the tests before this one have had printed (tests/seen.c), with no key that is not described."""
import copy
import glob
import json
import os
import pathlib
import subprocess
import sys

try:
    import jsonschema
except ImportError:
    print("python3-jsonschema is missing: jobs/install-packages.sh tests installs it")
    sys.exit(77)

PROGRAM = os.environ["RAYMAP"]
EXAMPLES = pathlib.Path(os.environ["SOURCE_DIR"]) / "examples"
GAUSS = EXAMPLES / "double-gauss" / "scene.yaml"
LENSES = pathlib.Path(os.environ["SOURCE_DIR"]) / "tests" / "data" / "lenses"


def strict(schema):
    """The schema with no keys but those that it names; the public one lets documents grow."""
    if isinstance(schema, list):
        return [strict(one) for one in schema]
    if not isinstance(schema, dict):
        return schema
    schema = {key: strict(value) for key, value in schema.items()}
    if isinstance(schema.get("properties"), dict) and "type" in schema:
        schema.setdefault("additionalProperties", False)
    return schema


store = {}
for path in sorted((pathlib.Path(os.environ["SOURCE_DIR"]) / "docs" / "schemas").glob("*.json")):
    with open(path, encoding="utf-8") as file:
        schema = json.load(file)
    jsonschema.Draft7Validator.check_schema(schema)
    store[path.name] = strict(schema)
validators = {name[:-5]: jsonschema.Draft7Validator(schema, resolver=jsonschema.RefResolver(name, schema, store=store))
              for name, schema in store.items()}
validated, failures = {}, []


def shape(value):
    """Documents of one shape are validated once."""
    if isinstance(value, dict):
        return tuple((key, shape(one)) for key, one in value.items())
    if isinstance(value, list):
        return tuple(sorted({shape(one) for one in value}, key=repr))
    return value if isinstance(value, str) and len(value) < 12 else type(value).__name__


def schema_of(words):
    """Of what a command prints."""
    command = words[0]
    if command == "report":
        return "energy" if "--energy" in words else "page" if "--html" in words else "rays"
    if command == "import":
        model = any(word.lower().endswith((".step", ".stp", ".iges", ".igs", ".gltf", ".glb", ".obj", ".stl", ".ply")) for word in words)
        return "import-model" if model else "import"
    if command == "query":
        listed = "--limit" in words or "--sample" in words
        written = any(word in ("-o", "--output") or word.startswith("--output=") for word in words)
        if "--top" in words and "--explain" not in words and not written:
            return "query-top"
        return "query-explain" if "--explain" in words else "query-output" if written else "rays" if listed else "query"
    return command


def validate(name, document, what):
    whole = [document[:1]] if isinstance(document, list) else []  # may it be a list?
    for one in whole + (document if isinstance(document, list) else [document]):
        key = name, shape(one)
        if key in validated:
            continue
        validated[key] = one
        for error in validators[name].iter_errors(one):
            failures.append(f"{what}: {name}.json: {'/'.join(map(str, error.absolute_path))}: {error.message[:300]}")


def run(*words, text=None, status=0, name=None, file=None):
    words = [str(word) for word in words]
    done = subprocess.run([PROGRAM, *words, "--json"], capture_output=True, text=True, check=False, input=text)
    if done.returncode != status:
        sys.exit(f"{words}: {done.returncode} {done.stderr}")
    lines = done.stdout.splitlines() if words[0] == "session" else [done.stdout]
    documents = [json.loads(line) for line in lines]
    for document in documents:
        validate(name or schema_of(words), document, " ".join(words))
    if file:
        with open(file, encoding="utf-8") as written:
            validate(name or schema_of([words[0], *words[3:]]), json.load(written), f"{file} of {' '.join(words)}")
    return documents[0]


LONG = 300000  # lists of more rays tell nothing new
seen = sorted(glob.glob(os.path.join(os.environ["JSON_SEEN"], "*.words")))
for path in seen:
    with open(path, encoding="utf-8") as file:
        words = file.read().splitlines()
    with open(path[:-6], encoding="utf-8") as file:
        text = file.read(LONG)
    try:
        if len(text) < LONG:
            validate(schema_of(words), json.loads(text), " ".join(words))
    except ValueError:  # --html to stdout, lines of a table
        if words[0] not in ("report", "bench"):
            failures.append(f"{' '.join(words)}: no JSON: {text[:200]}")
    os.remove(path)
    os.remove(path[:-6])

run("glass", "N-BK7", "metal ag")
run("glass", "--near", "1.6,50", "--at", "500,1e5")
run("import", LENSES / "rayoptics_codev_ag_dblgauss.seq", "-o", "lens", "--force")
run("import", LENSES / "optiland_flat_transmission_grating.zmx", "-o", "lens", "--force")
with open("model.obj", "w", encoding="utf-8") as file:
    file.write("o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
run("import", "model.obj", "-o", "model", "--force")
run("update", "model", "model.obj", "--dry-run")
run("check", GAUSS)
run("check", EXAMPLES / "mirage" / "scene.yaml")
run("trace", GAUSS, "-o", "a.raymap", "-n", 3000, "--force")
run("trace", GAUSS, "-o", "b.raymap", "-n", 3000, "--first-ray", 3000, "--force")
run("info", "a.raymap")
run("convert", "a.raymap", "-o", "p.raymap", "--encoding", "plain", "--force")
run("merge", "a.raymap", "b.raymap", "-o", "m.raymap", "--force")
run("index", "p.raymap")
run("keep", "a.raymap", "--of", "path_length")
run("select", "p.raymap", "seen", "registered(sensor)")
run("info", "p.raymap")
run("verify", "p.raymap")
run("repair", "p.raymap")
one = run("query", "a.raymap", "registered(sensor)")
assert isinstance(one, dict) and one["version"] == 1
assert isinstance(run("query", "a.raymap", "all", "hit(*)"), list)
with open("names.txt", "w", encoding="utf-8") as file:
    file.write("let seen = registered(sensor)\n")
assert isinstance(run("query", "a.raymap", "--criteria", "names.txt"), list)
assert isinstance(run("query", "a.raymap", "all", "--explain"), list)
run("query", "a.raymap", "registered(sensor)", "--until", "20%")
run("query", "a.raymap", "all", "--limit", 3)
run("query", "a.raymap", "ray < 9", "-o", "rays.json", "--force")
with open("rays.json", encoding="utf-8") as file:
    validate("rays", json.load(file), "rays.json")
run("query", "a.raymap", "registered(sensor)", "-o", "x.raymap", "--force")
run("info", "x.raymap")
run("draw", "a.raymap", "-o", "a.svg", "--limit", 9, "--force")
run("detector", "a.raymap", "sensor", "--where", "source(star)", "--mtf")
run("voxels", "a.raymap", "--cells", "3")
run("irradiance", "a.raymap", "cover", "--cells", "3")
with open("rays.csv", "w", encoding="utf-8") as file:
    file.write("x,y,z,dx,dy,dz,event\n0,0,0,0,0,1,7\n0,0,0,0,0,-1,8\n")
with open("events.yaml", "w", encoding="utf-8") as file:
    file.write("raymap: 1\ntime: on\nmedia: {air: {index: 1}}\nsources: [{name: a, type: ray_file, file: rays.csv, medium: air, flux: 2 photons}]\n"
               "detectors:\n  - {name: one, type: plane, size: 1, cells: 1, at: [0, 0, 1], reading: {dark: 1 MHz, window: 99 ns}}\n"
               "  - {name: two, type: plane, size: 1, cells: 1, at: [0, 0, 2]}\n")
run("trace", "events.yaml", "-o", "e.raymap", "-n", 2, "--force")
run("events", "e.raymap", "-o", "ev.json", "--force", file="ev.json", name="events")
run("events", "e.raymap")
run("stats", "a.raymap", "--of", "bounces", "-o", "s.json", "--force", file="s.json", name="stats")
run("stats", "a.raymap", "--of", "x(sensor)", "--of", "y(sensor)", "--by", "source")
run("paths", "a.raymap", "--detector", "sensor", "--matrix", "all", "-o", "w.json", "--force", file="w.json", name="paths")
run("compare", "a.raymap", "b.raymap")
run("report", "a.raymap", 0)
run("report", GAUSS, "--rays", "0..3")
run("report", EXAMPLES / "luneburg" / "scene.yaml", "--ray", 0)
run("report", "a.raymap", "--energy", "-o", "e.json", "--force", file="e.json", name="energy")
run("report", "a.raymap", "--html", "-o", "a.html", "--force")
run("session", "a.raymap", text="all\nlist 2 all\nlet g = hit(*)\nnames\nhelp\nstatus\nhit(\n", status=3)
run("render", EXAMPLES / "mirage" / "scene.yaml", "-o", "m.png", "--size", "16x12", "--samples", 1, "--force")

# A key that is not described, one of another type and one that is missing are seen.
for change in (lambda d: d.update(surprise=1), lambda d: d.update(complete="yes"), lambda d: d.pop("version"),
               lambda d: d["flux"].update(more=0)):
    wrong = copy.deepcopy(one)
    change(wrong)
    assert list(validators["query"].iter_errors(wrong)), wrong
print(f"{len(seen)} documents of other tests, {len(validated)} shapes")
sys.exit("\n".join(failures) if failures else 0)
