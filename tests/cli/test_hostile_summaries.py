# SPDX-License-Identifier: MIT
"""The promise: a map whose tables say what cannot be (portions that name sources, objects or
detectors beyond the scene's, sums that do not add up), with checksums and seals that hold, gets an
answer or status 4 from every command; none crashes, hangs or takes memory that the files do not
warrant."""
import os
import resource
import shutil
import subprocess
import sys

from sealed_map import edit, put

PROGRAM = os.environ["RAYMAP"]
HERE = os.path.dirname(os.path.abspath(__file__))
ALL = 2**64 - 1
# Of /portion, of all rows: what a summary says.
SUMMARIES = [
    ("sources", 1 << 40), ("sources", 1 << 63), ("sources", 0), ("sources", 1), ("sources", ALL),
    ("detectors", 1 << 50), ("detectors", 0), ("detectors", ALL),
    ("objects", ALL), ("objects", 0), ("objects", 1 << 63),
    ("events", 0), ("events", 2**32 - 1), ("stops", 0), ("stops", 2**32 - 1), ("stops", 1 << 31),
    ("box_min", float("nan")), ("box_min", float("inf")), ("box_max", -3e38),
]
OF_INDEX = [
    ("/tally/left", 0, 5e-324), ("/tally/emitted", 0, float("nan")), ("/tally/emitted", 1, 1e300),
    ("/tally/absorbed_object", None, -1e308), ("/detector/sensor/image", None, float("inf")),
    ("/run/n_ray", 0, ALL), ("/run/first_ray", 0, ALL),
]
COMMANDS = [
    ["info", "--json"],
    ["stats", "--of", "path_length"], ["stats", "--of", "segments", "--by", "source"],
    ["stats", "--of", "x(sensor)", "--by", "detector"], ["stats", "--of", "flux", "--of", "wavelength"],
    ["paths"], ["paths", "--where", 'path(".*")'], ["paths", "--matrix", "all"], ["paths", "-d", "sensor"],
    ["query", "source(lamp) and hit(lens.*, reflect)", "registered(sensor)", "--count"],
    ["query", "not source(second)", "--limit", "3"], ["query", "all", "-o", "out.vtp", "--force"],
    ["draw", "-o", "out.svg", "--force"], ["draw", "-o", "out.html", "--force", "--by", "surface"],
    ["detector", "sensor", "-o", "out.png", "--force"], ["detector", "sensor", "--tally"],
    ["detector", "sensor", "--spot"],
    ["report", "17"], ["report", "--energy"], ["report", "--html", "-o", "out.html", "--force"],
    ["verify"], ["repair", "--dry-run"],
]
# They write to the map: on copies of their own.
CHANGING = [["repair"], ["convert", "-o", "other.raymap", "--force"],
            ["trace", "--append", "-n", "100"], ["trace", "--resume", "--time-limit", "1s"]]
SLOW = int(os.environ.get("RAYMAP_TEST_SCALE", "1")) > 1
failures = []


def limit():
    if not os.environ.get("ASAN_OPTIONS"):
        resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))


def ask(command, path, what):
    name, *options = command
    operands = ["scene.yaml", "-o", path] if name == "trace" else [path]
    try:
        done = subprocess.run([PROGRAM, name, *operands, *options, "--quiet"], timeout=120,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, check=False, preexec_fn=limit)
    except subprocess.TimeoutExpired:
        failures.append(f"{what}: {command} hangs")
        return
    said = done.stderr.decode(errors="replace")
    # 2: so many rays cannot be asked for; 6: or take for ever
    if done.returncode not in ((0, 2, 4, 6) if name == "trace" else (0, 4)) or "Sanitizer" in said or \
            "runtime error" in said:
        failures.append(f"{what}: {command}: status {done.returncode}: {said[:1000]}")


def changed(whole, change):
    shutil.rmtree("bad.raymap", ignore_errors=True)
    shutil.copytree(whole, "bad.raymap")
    edit("bad.raymap/map.h5", change)
    return "bad.raymap"


def check_repeated(whole):
    """What the index repeats of the scene inside, for other readers: verify compares, repair mends."""
    repeated = (("name/object", 0, b"lense"), ("name/detector", 0, b""), ("name/object_id", 1, 7), ("name/object_group", 0, 3),
                ("source/flux", 1, 3.0), ("source/emitted", 0, 1.0), ("channel/wavelength", 2, 500.0), ("portion/shard", 1, 5))
    bad = changed(whole, lambda file: [put(file[path], row, value) for path, row, value in repeated])
    for command, status in (("verify", 4), ("repair", 0), ("verify", 0)):
        done = subprocess.run([PROGRAM, command, bad, "--quiet"], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, check=False)
        unnamed = [path for path, _, _ in repeated if status == 4 and "map.h5: /" + path not in done.stdout]
        if done.returncode != status or unnamed:
            failures.append(f"{command}: status {done.returncode}, nothing of {unnamed}: {done.stdout[:1000]}")


def check_kept():
    """Rows that an index moves from one portion to the next are missed beside kept columns, too."""
    subprocess.run([PROGRAM, "trace", f"{HERE}/../../examples/room/scene.yaml", "-o", "kept.raymap", "-n", "9000", "--quiet"],
                   check=True)
    subprocess.run([PROGRAM, "keep", "kept.raymap", "--of", "path_length", "--quiet"], check=True)

    def move(file):
        rows = file["portion/n_row"]
        moved = rows[()].astype("i8")
        moved[:2, 1] += [-3000, 3000]
        put(rows, None, moved.reshape(-1).astype(rows.dtype))

    for file in ("map.h5", "shard-00000/piece-00000.h5"):
        edit("kept.raymap/" + file, move)
    for command in (["stats", "--of", "path_length", "--by", "object"], ["query", "path_length > 5 and hit(floor)", "--count"]):
        ask(command, "kept.raymap", "kept columns, rows of another portion")


def main():
    for name in os.listdir("."):
        shutil.rmtree(name) if os.path.isdir(name) else os.remove(name)
    subprocess.run(["bash", "-c", '. "$0"; write_scene scene.yaml', f"{HERE}/expect.bash"],
                   check=True)
    with open("scene.yaml", encoding="utf-8") as file:
        scene = file.read()
    lamp = next(line for line in scene.splitlines() if "name: lamp" in line)
    with open("scene.yaml", "w", encoding="utf-8") as file:
        file.write(scene.replace(lamp, lamp + "\n" + lamp.replace("lamp", "second")))
    cases = [(f"/portion/{name} {value}", f"portion/{name}", None, value)
             for name, value in SUMMARIES] + [(f"{path} {value}", path, row, value)
                                              for path, row, value in OF_INDEX]
    for k, encoding in enumerate(("plain", "compact")):
        whole = f"{encoding}.raymap"
        subprocess.run([PROGRAM, "trace", "scene.yaml", "-o", whole, "-n", "9000", "--quiet",
                        "--encoding", encoding], check=True)
        for i, (what, path, row, value) in enumerate(cases):
            if path != "portion/sources" and (i + k) % 2:
                continue  # the other encoding has it
            bad = changed(whole, lambda file: put(file[path], row, value))
            for j, command in enumerate(COMMANDS):
                if (command[0] == "stats" and path == "portion/sources" and (j + k) % 2) or \
                        (i + j + k) % (5 if SLOW else len(COMMANDS)) == 0:
                    ask(command, bad, f"{encoding}, {what}")
            if SLOW or i % 2 == 0:
                ask(CHANGING[(i // 2 + k) % len(CHANGING)], bad, f"{encoding}, {what}")
    check_repeated("plain.raymap")
    check_kept()
    for failure in failures:
        print("FAILED:", failure)
    print(f"{len(failures)} failures")
    sys.exit(1 if failures else 0)


main()
