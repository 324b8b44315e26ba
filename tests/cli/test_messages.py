#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: a mistake is told with its place and its remedy. One row per mistake: what is typed, or what is
changed in a scene, the exit status, and words that are said."""
import glob
import os
import re
import shlex
import shutil
import subprocess
import sys

sys.dont_write_bytecode = True
SOURCE, PROGRAM = os.environ["SOURCE_DIR"], os.environ["RAYMAP"]
failures = 0

# What is typed after `raymap`, the status, what is said. lens.raymap is a map of scene.yaml.
TYPED = [
    # --set says that it is at fault, and names the nearest word.
    ("trace scene.yaml --no-record --set limits.step=100", 3,
     "--set limits.step=100: unknown key in limits: 'step' (did you mean 'steps'?)"),
    ("trace scene.yaml --no-record --set include=more.yaml", 3,
     "--set include=more.yaml: files are included before anything is set: write 'include' in a scene file"),
    ("trace scene.yaml --no-record --set limit.steps=100", 3, "--set limit.steps=100: unknown key"),
    ("trace scene.yaml --no-record --set limits.steps=abc", 3,
     "--set limits.steps=abc: 'steps' must be a finite number, not 'abc'"),
    ("trace scene.yaml --no-record --set objects.len.outside=air", 3,
     "--set objects.len.outside=air: no item named 'len' (did you mean 'lens'?)"),
    ("trace scene.yaml --no-record --set sources.lamp.medium=airr", 3,
     "--set sources.lamp.medium=airr: unknown medium 'airr' (did you mean 'air'?)"),
    ("trace scene.yaml --no-record --set limits.steps", 2, "--set wants KEY=VALUE, not 'limits.steps'"),
    # Names where they may not stand.
    ("query lens.raymap sensor", 3, "'sensor' is a detector, not a test (use registered(sensor))"),
    ("query lens.raymap 'registered(sensor where sensor)'", 3,
     "1:25: error: 'sensor' is a detector, not a test of a registration"),
    ("detector lens.raymap sensor --which sensor", 3, "--which:1:1: error: 'sensor' is a detector"),
    ("detector lens.raymap Sensor", 3, "did you mean 'sensor'?"),
    ("detector lens.raymap lens", 3, "no detector named 'lens' in this map; it has 'sensor'"),
    ("query lens.raymap 'hit(screen, face top)'", 3,
     "1:18: error: expected the number of a face, 0 to 0 here (none has a name), found 'top'"),
    ("query lens.raymap 'source(z+0)'", 3, "1:8: error: a name with signs stands in single quotes: 'z+0'"),
    ("query lens.raymap 'hit(a-b)'", 3, "(a name with such signs stands in single quotes)"),
    ("query lens.raymap 'ghost_order(sensor)'", 3,
     "'ghost_order' takes no name here; at a registration it is asked for as registered(NAME where ghost_order >= 1)"),
    ("query lens.raymap 'wavelength(sensor) > 1'", 3, "'wavelength' is a number of the whole ray and takes no name"),
    ("query lens.raymap 'registered(sensor where source(lamp))'", 3,
     "'source' is of the whole ray, not of a registration: put it beside registered(...) with 'and'"),
    ("query lens.raymap 'hit(where x > 1)'", 3, "1:5: error: expected the name of an object before 'where', or * for any: 'hit(* where ...)'"),
    ("query lens.raymap 'registered(sensor where after(where x > 1))'", 3, "or * for any: 'after(* where ...)'"),
    ("query lens.raymap 'registered(sensor where @ghosts)'", 3, "1:25: error: names cannot stand inside 'where'"),
    ("query lens.raymap all --by foo", 2, "--by 'foo': say source, detector, object, ended, ghost_order, scatter_order or event\n"),
    ("stats lens.raymap --of flux --by foo", 2, "event, criterion, path, path:object or path:group\n"),
    ("query '' all", 3, "the name of the ray map is empty"),
    # Words of other languages.
    ("query lens.raymap 'NOT hit(lens)'", 3, "write 'not', in small letters"),
    ("query lens.raymap 'all AND all'", 3, "found 'AND': write 'and'"),
    ("query lens.raymap true", 3, "'true' is no test (all rays: write 'all')"),
    ("query lens.raymap false", 3, "'false' is no test (no ray: write 'not all')"),
    ("stats lens.raymap --of z", 3, "unknown number 'z': say one of wavelength"),
    # Numbers and units.
    ("query lens.raymap 'path_length > 3 furlon'", 3, "'furlon' is no unit here (pm nm um mm cm m km in)"),
    ("query lens.raymap 'path_length > 0,5 mm'", 3, "1:16: error: expected 'and', 'or' or the end, found ',': decimals have a point"),
    ("query lens.raymap 'registered(sensor, rect(0,5, 1,5, 2,5, 3,5))'", 3, "not 8 (decimals have a point)"),
    ("query lens.raymap 'hit(screen, face 0..99999999999)'", 3, "1:21: error: this number is too large: at most 2147483647"),
    ("query lens.raymap 'path_length * 2 > 150'", 3, "1:13: error: the factor stands before: '2 * path_length'"),
    ("query lens.raymap 'registered(sensor where y > x * 2)'", 3, "the factor stands before: '2 * x'"),
    ("query lens.raymap 'hit(screen where x > path_length / 2)'", 3, "unexpected character '/' (factors are written: 0.5 * path_length)"),
    ("query lens.raymap 'registered(sensor where x > 1 km)' --quiet", 0, ": 0 registrations, "),
    ("trace scene.yaml --no-record -n 1e30", 2, "--rays 1e30 is too large"),
    ("trace scene.yaml --no-record -n -1", 2, "--rays must be a whole number without a sign"),
    ("compare lens.raymap lens.raymap --significance 0", 2, "--significance must lie between 0 and 1, both excluded"),
    ("trace scene.yaml --no-record -n 0", 2, "ask for at least one ray"),
    ("draw lens.raymap -o x.svg --opacity 0", 2, "--opacity must be greater than 0 and at most 1"),
    # Options.
    ("trace scene.yaml -o x.raymap --enc plain", 2, "unknown option '--enc' (did you mean '--encoding'?)"),
    ("trace scene.yaml -o x.raymap --enc=plain", 2, "unknown option '--enc' (did you mean '--encoding'?)"),
    ("query lens.raymap all --force", 2, "option '--force' goes with --output"),
    ("trace scene.yaml --no-record --force", 2, "option '--force' goes with --output"),
    ("detector lens.raymap sensor --force", 2, "option '--force' goes with --output or --plot"),
    ("detector lens.raymap sensor --frequency 3", 2, "option '--frequency' goes with --mtf"),
    ("detector lens.raymap sensor --log", 2, "option '--log' goes with --output"),
    ("report lens.raymap 3 --seed 4", 2, "option '--seed' goes with --ray or --rays"),
    ("compare lens.raymap lens.raymap --bins 3", 2, "option '--bins' goes with --of"),
    ("repair lens.raymap --color rgb", 2, "--color goes with --scene"),
    ("draw lens.raymap -o x.svg --by group", 2, "--by tells classes of paths apart: say --color path"),
    ("query lens.raymap all --seed 3", 2, "--seed is that of --sample N"),
    # Outputs in folders that are not there: status 3, a path where nothing is.
    ("trace scene.yaml -o no/such/x.raymap", 3, "cannot write 'no/such/x.raymap': there is no folder 'no/such'"),
    ("trace scene.yaml -o no/such/x.raymap/ --resume", 3, "there is no folder 'no/such'"),
    ("query lens.raymap all -o no/such/x.csv", 3, "there is no folder 'no/such'; make it first"),
    ("query lens.raymap all -o no/such/x.raymap", 3, "there is no folder 'no/such'"),
    ("draw lens.raymap -o no/such/x.svg", 3, "there is no folder 'no/such'"),
    ("report lens.raymap --html -o no/such/x.html", 3, "there is no folder 'no/such'"),
    ("convert lens.raymap -o no/such/x.raymap", 3, "there is no folder 'no/such'"),
    ("merge lens.raymap -o no/such/x.raymap", 3, "there is no folder 'no/such'"),
    # A newer program's maps are not damaged.
    ("repair newer.raymap --dry-run", 4, "use a newer raymap; it is not damaged, and nothing was changed"),
    ("repair newer.raymap", 4, "use a newer raymap; it is not damaged, and nothing was changed"),
    ("repair piece.raymap", 4, "use a newer raymap; it is not damaged, and nothing was changed"),
    ("info feature.raymap", 4, "needs 'polarisation', which this program does not know: use a newer raymap"),
    ("query feature.raymap all", 4, "needs 'polarisation', which this program does not know"),
]

# What is replaced in the scene, by what, and what `raymap check` says, with line and column.
CHANGED = [
    ("rays: 5000", "rays: 1e30", "28:25: error: 'rays' is too large: at most"),
    ("rays: 5000", "rays: -1", "28:25: error: 'rays' must be a whole number from 1"),
    ("units: mm", "units: furlon", "2:8: error: unknown units 'furlon'; known: "),
    ("size: [40, 40], cells", "size: [0,5], cells", "26:52: error: 'size' (decimals have a point, not a comma) must be"),
    ("at: [0, 0, -30]", "at: [0,5, 0, -30]", "'at' must be a list of 3 numbers (decimals have a point, not a comma)"),
    ("cone: 15", "cone: 15,5", "error: '15,5' is no number: decimals have a point"),
    ("flux: 1 W", "flux: 1,5 W", "error: '1,5 W' is no number: decimals have a point"),
    ("  air: {index: 1}", "\tair: {index: 1}", "5:1: error: this is not YAML: .*a tab indents this line: indent with spaces"),
    ("{glass: N-BK7}", "{glass: N-BK7", "what is opened in line 6, column 10 is not closed"),
    ("587.56, 656.27]", "587.56, 656.27", "what is opened in line 3, column 41 is not closed"),
    ("N-BK7", '"N-BK7', "what is opened in line 6, column 18 is not closed"),
    ("thickness: 5", "thickness: 1e200", "17:33: error: 'thickness' is too large: at most 1e+15, not 1e200"),
    ("type: point, at: [0, 0, -30], direction: [0, 0, 1], distribution: {cone: 15}",
     "type: collimated, shape: {disc: 1e200}, at: [0, 0, -30]", "error: 'disc' is too large: at most 1e+37, not 1e200"),
    ("surface: white", "surface: {type: absorber}", "22:61: error: a surface is not described here: give it a name in 'surfaces'"),
    ("geometry: wall", "geometry: {type: disc, radius: 3}", "'geometry' must be a word: what is described here gets a name"),
]


def run(*words):
    done = subprocess.run([PROGRAM, *words], text=True, capture_output=True, check=False, timeout=120)
    return done.returncode, done.stdout + done.stderr


def check(good, what):
    global failures
    if not good:
        failures += 1
        print("FAIL " + what, flush=True)


def expect(words, status, said):
    got, text = run(*words)
    pattern = said if ".*" in said else re.escape(said)
    check(got == status and re.search(pattern, text), f"{shlex.join(words)}: status {got}\n{text}    not: {said}")


def make_newer():
    """Maps whose index, and whose pieces, say that a later program wrote them."""
    sys.path.insert(0, os.path.join(SOURCE, "tests", "cli"))
    import numpy
    import sealed_map
    for name, files in (("newer", "map*.h5"), ("piece", "shard-*/piece-?????.h5")):
        shutil.copytree("lens.raymap", name + ".raymap")
        for path in glob.glob(f"{name}.raymap/{files}"):
            sealed_map.edit(path, lambda file: file.attrs.modify("version", [9, 0]))
    shutil.copytree("lens.raymap", "feature.raymap")
    sealed_map.edit("feature.raymap/map.h5", lambda file: file.attrs.__setitem__("features", numpy.bytes_("places polarisation gaps")))


for path in glob.glob("*"):
    shutil.rmtree(path) if os.path.isdir(path) else os.remove(path)
subprocess.run(["bash", "-c", '. "$0"; write_scene scene.yaml', SOURCE + "/tests/cli/expect.bash"], check=True)
check(run("trace", "scene.yaml", "-o", "lens.raymap", "-n", "1000", "--quiet")[0] == 0, "no map")
make_newer()
for typed, status, said in TYPED:
    expect(shlex.split(typed), status, said)
with open("scene.yaml", encoding="utf-8") as file:
    scene = file.read()
for before, after, said in CHANGED:
    check(before in scene, f"the scene has no '{before}'")
    with open("changed.yaml", "w", encoding="utf-8") as file:
        file.write(scene.replace(before, after, 1))
    expect(["check", "changed.yaml"], 3, said)

# Equal mistakes are told once; of a full disk, what is safe.
lamp = next(line for line in scene.splitlines(True) if "name: lamp" in line)
with open("changed.yaml", "w", encoding="utf-8") as file:
    file.write(scene.replace(lamp, "".join(
        lamp.replace("lamp", f"lamp{i}").replace("medium: air", "medium: airr") for i in range(9))))
expect(["check", "changed.yaml"], 3, "24:170: error: unknown medium 'airr' (did you mean 'air'?) (9 times, also in line 25, 26,")
check(run("check", "changed.yaml")[1].count("airr") == 1, "nine equal mistakes are told apart")
full = subprocess.run(["bash", "-c", 'trap "" XFSZ; ulimit -f 12288; exec "$0" "$@"', PROGRAM, "trace", "scene.yaml",
                       "-o", "full.raymap", "-n", "1500k", "--encoding", "plain", "--quiet", "--flush-portions", "4"],
                      text=True, capture_output=True, check=False, timeout=120)
check(full.returncode == 5 and re.search(r"File too large\)?; [0-9,]+ of 1,500,000 rays are safe in full.raymap, and "
                                         "--resume traces the rest", full.stderr), full.stderr)

sys.path.insert(0, os.path.join(SOURCE, "examples", "python"))
import raymap  # noqa: E402
lens = raymap.open("lens.raymap")
for what, ask, said in (("a name", lambda: lens.names["object"].index("lense"), "no object named 'lense': lens.1"),
                        ("a column", lambda: lens.columns("segment/positon"), "no column 'segment/positon': ray/"),
                        ("a table", lambda: raymap.records(lens, "legs"), "no table 'legs'.*segment")):
    try:
        ask()
        check(False, f"Python: {what} that is not there")
    except (ValueError, raymap.MapError) as error:
        check(re.search(said, str(error)), f"Python: {error}")
sys.exit(failures > 0)
