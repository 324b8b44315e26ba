#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""A session answers as `query` does, line by line: from a pipe, under mpirun, on a terminal."""
import json
import os
import pty
import re
import select
import shutil
import subprocess
import sys
import time

RAYMAP = os.environ["RAYMAP"]
SCENE = os.path.join(os.environ["SOURCE_DIR"], "examples/double-gauss/scene.yaml")
MAP = "session.raymap"
CRITERIA = ["all", "hit(barrel)", "source(star) and hit(*, reflect_specular) >= 2 and registered(sensor)",
            "angle(sensor) < 10 deg", "path(\"T@'lens*'+ .*\")", "hit(barrel)", "ray in 10..20"]


def run(*args, text=None, launch=()):
    done = subprocess.run([*launch, RAYMAP, *args], input=text, capture_output=True, text=True, timeout=300)
    return done.returncode, done.stdout, done.stderr


def lines(*args, text, status=0, launch=()):
    code, out, err = run("session", *args, "--quiet", text=text, launch=launch)
    assert code == status, (code, err)
    return [json.loads(line) for line in out.splitlines()]


def without_cost(answer):
    return {k: v for k, v in answer.items() if k not in ("seconds", "bytes_read", "portions", "name")}


def counted(criterion, *more):
    code, out, err = run("query", MAP, criterion, "--count", "--json", "--quiet", *more)
    assert code == 0, err
    return without_cost(json.loads(out))


def test_pipe():
    text = "".join(c + "\n" for c in CRITERIA)
    want = [counted(c) for c in CRITERIA]
    assert want[1]["rays"]["matched"] not in (0, want[1]["rays"]["total"])
    for options in ([], ["--memory", "0"], ["--memory", "1Mi"], ["--threads", "3"]):
        got = lines(MAP, *options, text=text)
        assert [without_cost(a) for a in got] == want, options
    got = lines(MAP, text=text[:-1])  # the last line without an end
    assert [without_cost(a) for a in got] == want
    ranks = lines(MAP, text=text, launch=("mpirun", "-np", "3"))
    assert [without_cost(a) for a in ranks] == want


ALIKE = [("hit(barrel)", "not hit(*, reflect_specular)"),
         ("angle(sensor) < 10 deg and path_length < 170 mm", "angle(sensor) > 7 deg and path_length < 150 mm"),
         ("source(star) and registered(sensor, rect(-6, -4, 6, 4))",
          "hit(barrel) and registered(sensor, rect(-3, -5, 7, 2))"),
         ("path(\"T@'lens*'+ .*\")", "path(\".* R@'lens*' .*\")"),
         ("optical_path < 200 mm", "optical_path > 150 mm")]


def test_second_reads_nothing():
    """Nothing of the map is left on disk but its index when the second question of a kind comes."""
    for name, options in (("plain", ["--encoding", "plain"]), ("compact", [])):
        path = f"hot-{name}.raymap"
        shutil.rmtree(path, ignore_errors=True)
        code, _, err = run("trace", SCENE, "-o", path, "-n", "20000", "--quiet", *options)
        assert code == 0, err
        want = [json.loads(run("query", path, second, "--count", "--json", "--quiet")[1])
                for _, second in ALIKE]
        for launch in ((), ("mpirun", "-np", "2")):
            asked_twice(path, want, launch)


def asked_twice(path, want, launch):
    session = subprocess.Popen([*launch, RAYMAP, "session", path, "--quiet"], stdin=subprocess.PIPE,
                               stdout=subprocess.PIPE, text=True)

    def ask(line):
        session.stdin.write(line + "\n")
        session.stdin.flush()
        return json.loads(session.stdout.readline())

    for first, _ in ALIKE:
        ask(first)
    before = ask("status")["memory"]
    assert 0 < before["taken"] <= before["budget"], before
    shards = [entry for entry in os.listdir(path) if entry.startswith("shard-")]
    assert shards
    for shard in shards:
        os.rename(os.path.join(path, shard), os.path.join(path, "away-" + shard))
    for (_, second), known in zip(ALIKE, want):
        got = ask(second)
        assert got.get("bytes_read") == 0, (path, launch, got)
        assert without_cost(got) == without_cost(known), (path, launch, got, known)
    after = ask("status")["memory"]  # columns may have been made of the paths that are kept
    assert after["opened"] == before["opened"] and after["columns"] >= before["columns"] > 0, (before, after)
    assert (before["opened"] > 0) == path.startswith("hot-compact") and after["indexes"] == 0, before
    for shard in shards:
        os.rename(os.path.join(path, "away-" + shard), os.path.join(path, shard))
    session.stdin.close()
    assert session.wait(timeout=60) == 0


def test_budgets():
    text = "".join(first + "\n" + second + "\n" for first, second in ALIKE) + "status\n"
    want = [counted(c) for pair in ALIKE for c in pair]
    for memory in (0, 1, 4097, 65536, 300000, 1 << 20, 1 << 24):
        for launch in ((), ("mpirun", "-np", "2")):
            got = lines(MAP, "--memory", str(memory), text=text, launch=launch)
            assert [without_cost(a) for a in got[:-1]] == want, memory
            kept = got[-1]["memory"]
            assert kept["budget"] == memory * (2 if launch else 1)
            assert kept["taken"] <= kept["budget"], kept


def test_every_line_has_its_answer():
    got = lines(MAP, text="names\r\nhelp\n\n# a remark\nlist 0 all\nall\r\n", status=3)
    assert len(got) == 4, got
    names = got[0]["names"]
    assert "sensor" in names["detectors"] and "star" in names["sources"] and "barrel" in names["groups"], names
    assert "list N CRITERION" in got[1]["help"]
    assert got[2]["line"] == 5 and "at least one" in got[2]["error"], got[2]
    assert got[3]["criterion"] == "all", got[3]


def test_names_and_lists():
    ghost = "source(star) and hit(*, reflect_specular) >= 2"
    got = lines(MAP, text=f"let g = {ghost}\n@g\nlet g = @h\n@g\nlet h = not @g\n@h\nlist 3 @g\nquit\nall\n",
                status=3)
    assert got[0] == {"version": 1, "defined": f"let g = {ghost}"}, got[0]
    got = [answer for answer in got if "defined" not in answer]
    assert len(got) == 5, got
    want = counted(ghost)["rays"]
    assert got[0]["rays"] == want
    assert got[1]["line"] == 3 and "h" in got[1]["error"], got[1]
    assert got[2]["rays"] == want  # a mistaken definition changed nothing
    assert got[3]["rays"]["matched"] == want["total"] - want["matched"]
    code, out, _ = run("query", MAP, ghost, "--limit", "3", "--json", "--quiet")
    assert code == 0 and [{"version": 1, **ray} for ray in got[4]["rays"]] == json.loads(out)
    got = lines(MAP, text="let g = source(star)\nlet g = @g\n@g\n", status=3)
    assert "error" in got[1] and got[2]["rays"] == counted("source(star)")["rays"], got
    with open("names.txt", "w", encoding="utf-8") as f:
        f.write("let star = source(star)\nlet far = not @star\n")
    got = lines(MAP, "--criteria", "names.txt", text="@far\n")
    assert got[0]["rays"] == counted("not source(star)")["rays"]


def test_mistakes():
    text = "hit(lense)\n\n# a comment\n   \nlist x all\nlist\nlet\nquit now\n\x01\xff\n((((\n" + "(" * 5000 + "\nall\n"
    got = lines(MAP, text=text, status=3)
    assert [a["line"] for a in got[:-1]] == [1, 5, 6, 7, 8, 9, 10, 11], got
    assert "did you mean 'lens'" in got[0]["error"]
    assert got[-1]["rays"]["matched"] == got[-1]["rays"]["total"]
    assert lines(MAP, text="") == []
    assert run("session", "nowhere.raymap", text="")[0] == 3
    assert run("session", text="")[0] == 2
    assert run("session", MAP, "--memory", "lots", text="")[0] == 2
    code, out, _ = run("session", MAP, "--quiet", text="all\n\x00\nall\n")
    assert code == 3 and len(out.splitlines()) == 3, out


def test_trouble():
    """A damaged selection is a line that cannot be answered; a map that goes is told where the answer would stand, too."""
    shutil.rmtree("gone.raymap", ignore_errors=True)
    assert run("trace", SCENE, "-o", "gone.raymap", "-n", "3000", "--quiet")[0] == 0
    assert run("select", "gone.raymap", "few", "ray < 9")[0] == 0
    os.truncate("gone.raymap/selection-few.h5", 100)
    got = lines("gone.raymap", text="@few\nlet g = @few\nall\n", status=3)
    assert "seal" in got[0]["error"] and "seal" in got[1]["error"] and got[2]["criterion"] == "all", got
    shutil.rmtree("gone.raymap/shard-00000")
    session = subprocess.run([RAYMAP, "session", "gone.raymap"], input="all\n", capture_output=True, text=True, timeout=300)
    assert session.returncode == 4 and json.loads(session.stdout)["line"] == 1 and "missing" in session.stdout, session


def read_until(terminal, pattern, seconds=60):
    seen = ""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if select.select([terminal], [], [], 0.2)[0]:
            try:
                seen += os.read(terminal, 4096).decode("utf-8", "replace")
            except OSError:
                break
        if re.search(pattern, seen):
            return seen
    raise AssertionError(f"the terminal never showed {pattern!r}: {seen!r}")


def test_terminal():
    state = os.path.abspath("state")
    shutil.rmtree(state, ignore_errors=True)
    environment = {**os.environ, "TERM": "vt100", "XDG_STATE_HOME": state, "HOME": state}
    shown = r"hit\(barrel\)[^>]*\n\s+rays +[0-9,]+ of"
    for typed in ("hit(barr\t)\r", "\x10\x10\r"):  # completed; called back from before `quit`
        child, terminal = pty.fork()
        if child == 0:
            os.execve(RAYMAP, [RAYMAP, "session", MAP], environment)
        read_until(terminal, "raymap> ")
        os.write(terminal, typed.encode())
        read_until(terminal, shown)
        os.write(terminal, b"quit\r")
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        os.close(terminal)
        assert status == 0, status
    with open(os.path.join(state, "raymap/history"), encoding="utf-8") as f:
        assert "barrel" in f.read()


def test_interrupts():
    """Ctrl-C clears the line or stops the question, and the session goes on; Ctrl-D ends it."""
    state = os.path.abspath("interrupts")
    environment = {**os.environ, "TERM": "vt100", "XDG_STATE_HOME": state, "HOME": state}
    child, terminal = pty.fork()
    if child == 0:
        os.execve(RAYMAP, [RAYMAP, "session", MAP, "--memory", "0"], environment)
    read_until(terminal, "raymap> ")
    os.write(terminal, b"hit(barr\x03")
    read_until(terminal, r"\^C\r\nraymap> ")
    os.write(terminal, b"hit(barrel)\r")
    read_until(terminal, r"hit\(barrel\)[^>]*\n\s+rays +[0-9,]+ of 60,000[\s\S]*raymap> ")
    os.write(terminal, b"path_length > 100 mm\r")
    read_until(terminal, "100 mm")
    os.write(terminal, b"\x03")
    read_until(terminal, r"(stopped|of 60,000|\^C)[\s\S]*raymap> ")
    os.write(terminal, b"hit(lens)\r")
    read_until(terminal, r"hit\(lens\)[^>]*\n\s+rays +[0-9,]+ of 60,000[\s\S]*raymap> ")
    os.write(terminal, b"\x04")
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    os.close(terminal)


TORN = """raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [587.56]}
media: {air: {index: 1}}
surfaces: {black: {type: absorber}}
geometries: {disc: {type: disc, radius: 10}}
objects:
  - {name: törn, geometry: disc, at: [0, 0, 10], surface: black, front: air, back: air}
sources:
  - {name: lamp, type: rays, medium: air, flux: 1 W, rays: [{origin: [0, 0, 0], direction: [0, 0, 1]}]}
"""


def test_terminal_keeps_letters():
    """Whatever the locale, as typed, completed, shown and called back from the history."""
    with open("torn.yaml", "w", encoding="utf-8") as f:
        f.write(TORN)
    code, _, err = run("trace", "torn.yaml", "-o", "torn.raymap", "-n", "3", "--quiet", "--force")
    assert code == 0, err
    state = os.path.abspath("letters")
    shutil.rmtree(state, ignore_errors=True)
    for locale in ("C", "C.UTF-8"):
        environment = {**os.environ, "TERM": "vt100", "XDG_STATE_HOME": state, "HOME": state, "LC_ALL": locale}
        for typed in ("hit(törn)\r", "hit(t\xf6\t)\r", "\x10\x10\r"):
            child, terminal = pty.fork()
            if child == 0:
                os.execve(RAYMAP, [RAYMAP, "session", "torn.raymap"], environment)
            read_until(terminal, "raymap> ")
            os.write(terminal, typed.encode())
            read_until(terminal, r"hit\(törn\)[^>]*\n\s+rays +3 of 3")
            os.write(terminal, b"quit\r")
            status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
            os.close(terminal)
            assert status == 0, (locale, typed, status)
    shutil.rmtree("torn.raymap")


def main():
    shutil.rmtree(MAP, ignore_errors=True)
    code, _, err = run("trace", SCENE, "-o", MAP, "-n", "60000", "--quiet", "--force")
    assert code == 0, err
    for test in (test_pipe, test_second_reads_nothing, test_budgets,
                 test_every_line_has_its_answer, test_names_and_lists, test_mistakes, test_trouble, test_terminal,
                 test_terminal_keeps_letters, test_interrupts):
        test()
        print(test.__name__, "passed")
    shutil.rmtree(MAP)


if __name__ == "__main__":
    sys.exit(main())
