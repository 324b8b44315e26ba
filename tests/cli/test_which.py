#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: a criterion selects rays, and registrations are chosen by their own conditions: what
a condition and its opposite choose adds up, and no two commands count differently."""
import json
import os
import subprocess
import sys

PROGRAM = os.environ["RAYMAP"]
SOURCE = os.environ["SOURCE_DIR"]
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from evaluator_map import PlainMap  # noqa: E402
import served  # noqa: E402

asked = {}


def call(*arguments, ranks=1, status=0, text=None):
    command = ["mpirun", "-np", str(ranks)] if ranks > 1 else []
    done = subprocess.run([*command, PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          timeout=300, check=False, input=text)
    assert done.returncode == status, (arguments, done.returncode, done.stdout, done.stderr)
    return done


def ask(command, file, *words, ranks=1):
    if ranks > 1:
        return json.loads(call(command, file, *words, "--json", "--quiet", ranks=ranks).stdout)
    return served.ask(command, file, *words)


def values(document):
    return [value or 0.0 for row in document["table"]["value"] for value in row]


def cells(file, detector, *more, ranks=1):
    """What each cell of the image has, and the document."""
    if ranks > 1:
        document = ask("detector", file, detector, *more, "--table", ranks=ranks)
    else:
        document = ask("detector", file, detector, *more, "--values")
    return values(document), document


def check_law(file, detector, conditions, criteria, ranks):
    """registered(D where E) and registered(D where not (E)) add up to the image of C; so does --which."""
    for k, criterion in enumerate(criteria):
        whole, document = cells(file, detector, "--where", criterion)
        assert document["which"] == {"text": "all", "from": "all"}
        for turn, condition in enumerate(conditions):
            halves = []
            for one in (condition, f"not ({condition})"):
                test = f"registered({detector} where {one})"
                by_where, where = cells(file, detector, "--where", f"({criterion}) and {test}", ranks=ranks)
                by_which, which = cells(file, detector, "--where", criterion, "--which", f"where {one}")
                assert by_where == by_which, (criterion, one)
                assert where["which"] == {"text": f"where {one}", "from": "where"}, where["which"]
                assert which["which"] == {"text": f"where {one}", "from": "option"}, which["which"]
                assert where["flux"] == which["flux"] and where["registrations"] == which["registrations"]
                halves.append(by_where)
                if (turn + k) % 2 == 0:
                    check_alike(file, detector, f"({criterion}) and {test}", where)
            for value, part, rest in zip(whole, *halves):
                assert abs(part + rest - value) <= 1e-12 * value, (criterion, condition)
            assert any(halves[0]) or any(halves[1]) or not any(whole)


def check_alike(file, detector, criterion, image):
    """query, stats and paths tell what the image tells, to the last bit."""
    number = f"optical_path({detector})"
    query = ask("query", file, criterion)
    assert len(query["registered"]) == 1 and query["registered"][0]["detector"] == detector
    told = query["registered"][0]
    stats = ask("stats", file, "--of", number, "--where", criterion)
    paths = ask("paths", file, "--detector", detector, "--where", criterion)
    assert told["which"] == image["which"] == stats["which"] == paths["which"]
    assert told["registrations"] == image["registrations"] == stats["values"]
    fluxes = [told["flux"], image["flux"]["total"], stats["flux"]["value"], paths["flux"]["value"]]
    assert len(set(fluxes)) == 1, (criterion, fluxes)
    errors = [told["standard_error"], image["flux"]["standard_error"], stats["flux"]["standard_error"],
              paths["flux"]["standard_error"]]
    assert max(errors) - min(errors) <= 1e-12 * max(errors), (criterion, errors)
    assert query["rays"]["matched"] == paths["rays"]["matched"]
    asked.setdefault(file, []).append((criterion, query["registered"]))


def check_sessions():
    for file, questions in asked.items():
        lines = call("session", file, "--json", "--quiet", text="".join(2 * f"{text}\n" for text, _ in questions)).stdout
        told = [json.loads(line)["registered"] for line in lines.splitlines()]
        assert told == [registered for _, registered in questions for _ in range(2)]


def check_columns(file):
    """A condition on a place, by the map's own columns."""
    m = PlainMap(file)
    seen = m.registration
    on = (seen["detector"] == m.names["detector"].index("sensor")) & (seen["registered"] == 1)
    x = (seen["relative"][:, 0] / 65535.0 - 0.5) * 36.0
    want = int((on & (x > 1.0)).sum())
    assert 0 < want < on.sum()
    assert cells(file, "sensor", "--which", "x > 1")[1]["registrations"] == want
    assert cells(file, "sensor", "--which", "rect(1, -12, 18, 12)")[1]["registrations"] == want
    # The rays with such a registration have others besides.
    assert cells(file, "sensor", "--where", "x(sensor) > 1")[1]["registrations"] > want


def check_rule(file):
    """What a criterion chooses, and what it does not."""
    x, y = "registered(sensor where x > 1)", "registered(sensor where y > 1)"
    rect = "registered(sensor, rect(-1, -1, 1, 1))"
    with open("names.txt", "w", encoding="utf-8") as names:
        names.write(f"let right = {x}\n")
    for k, (criterion, text) in enumerate((
            (x, "where x > 1"), (f"{x} >= 1", "where x > 1"), (f"{x} > 0", "where x > 1"),
            (f"hit(*) and ({x} and source(sun))", "where x > 1"), ("@right and hit(*)", "where x > 1"),
            (rect, "rect(-1, -1, 1, 1)"), ("registered(s*, rect(0, 0, 1, 1) where x > 1)", "rect(0, 0, 1, 1) where x > 1"),
            (f"{x} and {y}", "where x > 1 or where y > 1"), (f"{y} and x(sensor) > 1", "where y > 1"),
            ("registered(sensor)", None), ("not registered(sensor where x > 1)", None), (f"{x} or {y}", None),
            (f"{x} >= 2", None), (f"{x} == 1", None), ("crossed(sensor where x > 1)", None),
            ("x(sensor) > 1", None), (f"{x} in 1..9", None))):
        want = {"text": text, "from": "where"} if text else {"text": "all", "from": "all"}
        if "@" not in criterion:
            said = ask("detector", file, "sensor", "--where", criterion)["which"]
            assert said == want, (criterion, said)
            if k % 3:
                continue
        done = call("detector", file, "sensor", "--where", criterion, "--criteria", "names.txt", "--json")
        said, told = json.loads(done.stdout)["which"], done.stderr
        assert said == want, (criterion, said)
        asks_rays = "x(sensor)" in criterion or (not text and criterion != "registered(sensor)")
        assert ("chooses rays" in told) == asks_rays, (criterion, told)
    told = call("detector", file, "sensor", "--where", "x(sensor) > 1").stderr
    assert "--which 'where x > 1'" in told, told


def check_first(file, detector):
    """paths --first: every ray once, and a row's criterion has the row's flux."""
    every = ask("paths", file, "--detector", detector, "--top", "all")
    first = ask("paths", file, "--detector", detector, "--first", "--top", "5")
    arrived = ask("query", file, f"registered({detector})")
    assert first["rays"]["matched"] == arrived["rays"]["matched"] and first["flux"]["value"] == arrived["flux"]["matched"]
    assert first["flux"]["value"] < every["flux"]["value"] and len(first["classes"]) == 5
    for row in first["classes"][:2]:
        image = ask("detector", file, detector, "--where", row["criterion"])
        assert image["flux"]["total"] == row["flux"], (row, image["flux"])


def check_refused(file):
    for arguments, word in ((["detector", file, "sensor", "--which", "x > 1", "--tally"], "--which"),
                            (["paths", file, "--which", "where x > 1"], "--detector"),
                            (["stats", file, "--of", "wavelength", "--which", "x > 1"], "--detector"),
                            (["compare", file, file, "--which", "x > 1"], "--detector")):
        assert word in call(*arguments, status=2).stderr, arguments
    for text, place in (("where", "1:6"), ("rect(0, 0, 1) where x > 1", "1:1"), ("x >", "1:4"),
                        ("registered(sensor)", "1:1"), ("x > 1 y", "1:7")):
        assert f"--which:{place}: error" in call("detector", file, "sensor", "--which", text, status=3).stderr, text


def check_captions(file):
    where = "registered(sensor where ghost_order == 2)"
    assert "which          where ghost_order == 2" in call("detector", file, "sensor", "--where", where).stdout
    call("detector", file, "sensor", "--where", where, "-o", "ghosts.svg", "--force")
    with open("ghosts.svg", encoding="utf-8") as picture:
        assert "registrations: where ghost_order == 2" in picture.read()
    call("detector", file, "sensor", "--where", where, "-o", "sensor.csv", "--force")
    with open("sensor.csv", encoding="utf-8") as table:
        assert "# which: where ghost_order == 2" in table.read()


def check_picked(file):
    """A map of picked rays holds them whole."""
    where = "registered(sensor where ghost_order == 2)"
    call("query", file, where, "-o", "ghosts.raymap", "--quiet", "--force")
    told = call("detector", "ghosts.raymap", "sensor")
    assert f"rays picked by {where}: all their registrations" in told.stderr, told.stderr
    both = [ask("detector", path, "sensor", "--which", "ghost_order == 2") for path in (file, "ghosts.raymap")]
    assert both[0]["flux"] == both[1]["flux"]


def check_pair(file):
    """Two criteria of one map that choose differently."""
    a, b = "registered(sensor where x > 1)", "registered(sensor where x < 2)"
    document = json.loads(call("compare", file, "--where", a, "--where", b, "--json", "--quiet").stdout)
    assert [one["which"]["text"] for one in document["samples"]] == ["where x > 1", "where x < 2"]
    flux = [test["values"] for test in document["tests"] if (test["quantity"], test["name"]) == ("detector", "sensor")][0]
    for value, criterion in zip(flux, (a, b)):
        want = ask("detector", file, "sensor", "--where", criterion)["flux"]["total"]
        assert abs(value["value"] - want) <= 1e-12 * want, (value, want)


def check_receivers(file):
    """A receiver where the sensor is registers the same light: so do those that are chosen."""
    with open("again.yaml", "w", encoding="utf-8") as receivers:
        receivers.write("detectors:\n  - {name: again, type: plane, on: sensor_surface, size: [36, 24], cells: [180, 120],"
                        " at: [0, 0, 139.5658], direction: [0, 0, -1]}\n")
    for condition in ("ghost_order == 2", "x > 1 and hit(lens.*, reflect) == 0"):
        stored = cells(file, "sensor", "--where", f"registered(sensor where {condition})")[0]
        laid = json.loads(call("detector", file, "again", "--receivers", "again.yaml", "--table", "--json", "--quiet",
                               "--where", f"registered(again where {condition})").stdout)
        assert values(laid) == stored and laid["which"]["from"] == "where"


def trace(name, n, encoding, *more):
    file = f"{name}-{encoding}.raymap"
    call("trace", os.path.join(SOURCE, "examples", name, "scene.yaml"), "-o", file, "-n", n, "--encoding",
         encoding, "--quiet", "--force", *more)
    return file


def check_read_whole():
    """Times of arrival stay open by paths, so that a block is read whole after its rays were selected by angles.
    By commands: a session keeps blocks whole."""
    def told(file, *words):
        return json.loads(call("query", file, *words, "--json", "--quiet").stdout)
    plain, compact = (trace("wls-fibre", 1500, encoding, "--time", "on", "--set", "media.core.accounting=energy")
                      for encoding in ("plain", "compact"))
    for time in (1e-8, 2e-8, 5e-8):
        for angle in (145, 170):
            criterion = f"registered(far where time <= {time} and angle < {angle})"
            counted = [told(file, criterion, "--count") for file in (plain, compact)]
            assert counted[0]["rays"]["matched"] > 0, criterion
            assert counted[0]["rays"] == counted[1]["rays"] and counted[0]["registered"] == counted[1]["registered"], counted


def main():
    images = []
    for encoding in ("plain", "compact"):
        file = trace("double-gauss", 8000, encoding)
        check_law(file, "sensor", ["ghost_order == 0"], ["source(star) or bounces > 20"], 2)
        check_law(file, "sensor", ["ghost_order == 0", "angle < 12 and hit(lens.5) != 1"], ["all"], 1)
        images.append(cells(file, "sensor", "--which", "ghost_order >= 1"))
    assert images[0] == images[1]
    check_columns("double-gauss-plain.raymap")
    check_rule(file)
    check_refused(file)
    check_captions(file)
    check_picked(file)
    check_pair(file)
    check_receivers(file)
    # mirage and gradient-sphere have no detectors
    for name, detector, condition in (("telescope", "disturbed", "angle < 0.001 or x > 0"),
                                      ("luneburg", "focus", "hit(*) > 2"), ("selfoc", "image", "x > 0"),
                                      ("room", "floor_map", "hit(*, reflect_diffuse) == 0")):
        check_law(trace(name, 2000, "compact"), detector, [condition], ["all"], 1)
    check_first("room-compact.raymap", "floor_map")
    check_read_whole()
    check_sessions()


if __name__ == "__main__":
    main()
