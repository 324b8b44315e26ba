#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`raymap import` says nothing good of what `raymap check` refuses: numbers that no scene can have are replaced and told with line and
surface; words of every format that are no numbers; folders of another model, interrupts, full disks; rules that fit nothing."""
import json
import math
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import time

import asking
from asking import check, run
from zmx_lens import ZMX

shutil.rmtree("here", ignore_errors=True)
pathlib.Path("here").mkdir()
RAYMAP = os.environ["RAYMAP"]

SEQ = "RDM;LEN\nEPD 10\nWL 587.6\nYAN 0 3\nSO 0 1e20\nS 50 4 NBK7_SCHOTT\nSTO\nS -50 48\nSI 0 0\n"
OSLO = 'LEN NEW "A" 50 2\nEBR 5\nANG 3\nTH 1e20\nNXT\nGLA BK7\nRD 50\nTH 3\nAP 6\nAST\nNXT\nAIR\nRD -50\nTH 48\nNXT\nWV 0.58756\nEND 3\n'


def write(name, text):
    pathlib.Path("here", name).write_text(text, encoding="utf-8")
    return "here/" + name


def said_of(name, text, *more):
    """Its findings; the scene passes `check`, and has each of them as a remark."""
    told = json.loads(run("import", write(name, text), "-o", "here/out", "--force", "--json", *more))
    scene = pathlib.Path("here/out/scene.yaml").read_text(encoding="utf-8")
    done = subprocess.run([RAYMAP, "check", "here/out/scene.yaml"], text=True, capture_output=True, check=False)
    check(done.returncode == 0 and told["check"]["errors"] == 0, f"{name}: {done.stderr}")
    remarks = re.sub(r"\s+", " ", scene)
    for finding in told["findings"]:
        words = finding["text"].split(": ", 1)[1] if finding["text"].startswith("configuration_") else finding["text"]
        check(re.sub(r"\s+", " ", words) in remarks, f"{name}: '{words}' stands in the scene")
    return told["findings"]


def expect(name, text, *wanted):
    findings = said_of(name, text)
    for line, words in wanted:
        check(any(f["line"] == line and words in f["text"] for f in findings), f"{name}: line {line}: {words}: {findings}")
    return findings


def check_numbers():
    """What no scene can have; each stands at the line of its surface."""
    expect("cross.zmx", ZMX.replace("DISZ 4", "DISZ 0").replace("CURV 0.02", "CURV -0.1").replace("CURV -0.02", "CURV -0.15"),
           (9, "surface 1: with its thickness 0 it and the next surface cross"))
    expect("source.zmx", ZMX.replace("DISZ INFINITY", "DISZ -2"), (7, "no light can begin"))
    expect("conic.zmx", ZMX.replace("CURV 0.02\n", "CURV 0.02\n  CONI 1e9\n"), (9, "with its conic 1e+09 it ends at radius"))
    expect("huge.zmx", ZMX.replace("DIAM 6", "DIAM 1e30"), (9, "semi-diameter 1e+30 is no length of a lens"))
    expect("dark.zmx", ZMX.replace("0.48", "0.065"), (0, "wavelength 65 nm is left out: N-BK7 has no index there"))
    expect("back.zmx", ZMX.replace("DISZ 4", "DISZ -4"), (9, "its thickness -4 leads back through the glass: 4 stands there"))
    expect("toroid.zmx", ZMX.replace("CURV 0.02\n", "CURV 0.02\n  TYPE BICONICX\n  PARM 1 5.5\n  PARM 2 0.5\n"), (9, "surface 1: "))
    expect("grin.zmx", ZMX.replace("GLAS N-BK7 0 0 1.5 40", "TYPE GRINSUR1\n  PARM 1 1\n  PARM 2 -1.6"), (9, "its gradient's index -1.6 is none"))
    # What cannot be made good is said to be bad: media that overlap.
    text = ZMX.replace("DISZ 48", "DISZ -2\n  GLAS N-SF6\nSURF 3\n  CURV 0.02\n  DISZ 5\n  GLAS N-SF2\nSURF 4\n  CURV 0.1\n  DISZ -3\nSURF 5\n  "
                       "CURV -0.1\n  DISZ 40\n  GLAS N-BK7").replace("SURF 3\n  DISZ 0", "SURF 6\n  DISZ 0")
    done = subprocess.run([RAYMAP, "import", write("bad.zmx", text), "-o", "here/bad"], text=True, capture_output=True, check=False)
    again = subprocess.run([RAYMAP, "check", "here/bad/scene.yaml"], capture_output=True, check=False)
    check(done.returncode == again.returncode, f"import and check agree: {done.returncode} {again.returncode} {done.stderr}")
    check(done.returncode == 0 or ("`raymap check` refuses it" in done.stderr and "next:" not in done.stdout), f"{done.stderr}")


def check_words():
    config = ZMX + ('MNUM 2 1\nGLSS 1 1 "N-BK7" 0\nGLSS 1 2 "NOSUCH" 0\nTHIC 9 2 5 0\nTHIC 2 2 abc 0\nTEMP 0 2 40 0\nYFIE 7 2 1 0\n'
                    "WAVE 1 2 0 0\nPRAM 1 2 5 0\nMOFF 0 2 0 0\n")
    n = len(ZMX.splitlines()) + 1
    found = expect("config.zmx", config, (n + 2, "configuration_2: surface 1: glass 'NOSUCH' is not known"), (n + 3, "THIC 9"), (n + 4, "abc"),
                   (n + 5, "TEMP 40"), (n + 6, "YFIE 7"), (n + 7, "WAVE 1"), (n + 8, "operand PRAM"))
    check(len(found) == 7, f"each once: {found}")
    expect("nsc.zmx", "MODE NSC\n" + ZMX, (1, "MODE NSC: a non-sequential system"))
    check(said_of("seq.zmx", "MODE SEQ\n" + ZMX) == [], "a sequential one")
    expect("words.zmx", ZMX.replace("YFLN 0 5", "YFLN 0 x").replace("FTYP 0 0 2 2", "FTYP 0 0 2 2\nXFLN 0 y").replace("WAVM 2 0.65", "WAVM 2 z"),
           (5, "YFLN x is no number"), (4, "XFLN y is no number"), (7, "WAVM z is no number"))
    expect("words.seq", SEQ.replace("STO\n", "STO\nCIR abc\n").replace("YAN 0 3", "YAN 0 q"), (8, "CIR abc is no number"), (4, "YAN q is no number"))
    expect("zoom.seq", SEQ + "ZOO 2\nZOO THI S9 1 2\nGO\n", (11, "S9: the lens has no such surface"))
    expect("words.len", OSLO.replace("AP 6", "AP odd six"), (9, "AP six is no number"), (9, "AP odd is not understood"))


def check_eye():
    """Glass that goes on to the image: nothing gets in beside its surfaces, and all fields stay."""
    rows = ((7.8, 0.55, 5, 1.376), (6.5, 3.05, 5, 1.337), (0, 0.1, 1.5, 1.337), (10.2, 4, 4.5, 1.42), (-6, 16.6, 4.5, 1.336))
    text = ZMX[:ZMX.index("SURF 1")].replace("ENPD 10", "ENPD 3").replace("YFLN 0 5", "YFLN 0 10")
    for i, (radius, gap, semi, n) in enumerate(rows):
        text += f"SURF {i + 1}\n" + ("  STOP\n" if i == 2 else "") + f"  CURV {1 / radius if radius else 0}\n  DISZ {gap}\n"
        text += f"  GLAS ___BLANK 1 0 {n} 55\n  DIAM {semi} 1 0 0 1\n"
    told = said_of("eye.zmx", text + "SURF 6\n  CURV -0.083\n")
    scene = pathlib.Path("here/out/scene.yaml").read_text(encoding="utf-8")
    check(told == [] and "field_2" in scene and "no edge" not in scene, f"{told}\n{scene}")
    check("warning" not in run("check", "here/out/scene.yaml", "--json"), "no light leaves inside it")
    z, rims = 0, []
    for radius, gap, semi, _ in rows:
        if radius:
            rims.append((z + radius - math.copysign(math.sqrt(radius**2 - semi**2), radius), semi))
        z += gap
    tubes = re.findall(r"edge_\d: \{type: cone, radius: (\S+), radius2: (\S+), length: (\S+)\}", scene)
    places = re.findall(r"geometry: edge_\d, at: \[0, 0, (\S+)\]", scene)
    check(len(tubes) == len(places) == 3, scene)
    for tube, place, (z0, r0), (z1, r1) in zip(tubes, places, rims, rims[1:]):
        for got, want in zip(map(float, (*tube, place)), (r0, r1, z1 - z0, z0)):
            check(abs(got - want) < 1e-9, f"{tube} at {place}: {want}")


OBJ = "g one\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"


def files_of(folder):
    return sorted(str(p.relative_to(folder)) for p in pathlib.Path(folder).rglob("*") if p.is_file())


def check_folders():
    lens, model = write("a.zmx", ZMX), write("a.obj", OBJ)
    said = run("import", lens, "-o", lens, status=2)
    check("is a file: name a folder" in said, said)
    check("is a file" in run("import", model, "-o", lens + "/x", status=2), "nor below one")
    run("import", lens, "-o", "here/deep/er/lens")
    run("import", model, "-o", "here/deep/model/")
    check(files_of("here/deep/er/lens") == ["scene.yaml"], "folders above it are made")
    run("import", write("no.zmx", "hello"), "-o", "here/none/at/all", status=3)
    run("import", write("no.obj", "hello"), "-o", "here/none/at/all", status=3)
    check(not pathlib.Path("here/none").exists(), "none stays of what failed")
    for words, status in ((("ghosts", "here/deep/er/lens", "sensor"), 4), (("check", "here/deep/er/lens"), 3)):
        said = run(*words, status=status)
        check("did you mean here/deep/er/lens/scene.yaml" in said, said)
    # One kind over the other.
    before = {n: pathlib.Path("here/deep/model", n).read_bytes() for n in files_of("here/deep/model")}
    said = run("import", lens, "-o", "here/deep/model", status=2)
    check("holds a model" in said and "--force" in said, said)
    check(before == {n: pathlib.Path("here/deep/model", n).read_bytes() for n in files_of("here/deep/model")}, "nothing is touched")
    said = run("import", model, "-o", "here/deep/er/lens", status=2)
    check("holds the scene of a lens" in said and "--force" in said, said)
    run("import", lens, "-o", "here/deep/model", "--force")
    check(files_of("here/deep/model") == ["scene.yaml"], f"its meshes are gone: {files_of('here/deep/model')}")
    run("import", model, "-o", "here/deep/model", "--force")
    # A model over a model: the meshes of the first go.
    first = {n for n in files_of("here/deep/model") if n.endswith(".ply")}
    run("import", write("b.obj", OBJ.replace("one", "other")), "-o", "here/deep/model")
    second = {n for n in files_of("here/deep/model") if n.endswith(".ply")}
    check(len(first) == len(second) == 1 and first != second, f"{first} {second}")
    # Options of other kinds of files.
    for more, path in ((("--chord", "1"), model), (("--unit", "m"), lens), (("--glass", "x.agf"), model), (("--angle", "3"), lens)):
        check("says nothing of" in run("import", path, "-o", "here/opt", *more, status=2), f"{more} of {path}")
    said = run("import", lens, "-o", "here/a folder's")
    check("raymap ghosts 'here/a folder'\\''s/scene.yaml' sensor" in said, f"quotes of a shell: {said}")


def check_direction():
    """Marks of direction are seen, not obeyed."""
    text = ZMX.replace("SURF 2\n", "SURF 2\n  COMM abc\u202edef\n  GLAS BAD\u2066GLASS\n")
    done = subprocess.run([RAYMAP, "import", write("turn.zmx", text), "-o", "here/turn"], text=True, capture_output=True, check=False)
    scene = pathlib.Path("here/turn/scene.yaml").read_text(encoding="utf-8")
    check("abc\\u202edef" in scene and not re.search("[\u202e\u2066]", scene + done.stderr + done.stdout), scene)
    run("import", write("turn.obj", OBJ.replace("one", "a\u202eb")), "-o", "here/turnobj")
    texts = "".join(pathlib.Path("here/turnobj", n).read_text(encoding="utf-8") for n in ("parts.yaml", "scene.yaml", "attributes.yaml"))
    check("\u202e" not in texts, texts)


def check_interrupt():
    """Neither a folder of raymap-step's stays, nor the program itself."""
    pathlib.Path("here/bin").mkdir()
    shutil.copy(RAYMAP, "here/bin/raymap")
    step = pathlib.Path("here/bin/raymap-step")
    step.write_text('#!/bin/sh\nfor folder; do :; done\nmkdir "$folder"\necho $$ > here/pid\nexec sleep 60\n', encoding="utf-8")
    step.chmod(0o755)
    write("a.step", "ISO-10303-21;\n")
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
        pathlib.Path("here/pid").unlink(missing_ok=True)
        with subprocess.Popen(["here/bin/raymap", "import", "here/a.step", "-o", "here/stopped/in"], stderr=subprocess.PIPE, text=True) as program:
            for _ in range(400):
                if pathlib.Path("here/pid").exists() and pathlib.Path("here/pid").read_text(encoding="utf-8").strip():
                    break
                time.sleep(0.05)
            child = int(pathlib.Path("here/pid").read_text(encoding="utf-8"))
            program.send_signal(number)
            said = program.communicate(timeout=30)[1]
        if number == signal.SIGKILL:
            break
        check(program.returncode == 6 and number.name in said, f"{number}: {program.returncode} {said}")
        check(not pathlib.Path("here/stopped").exists(), "no folder stays")
        check(not pathlib.Path(f"/proc/{child}").exists(), "raymap-step is ended")
    for left, what in ((1, "raymap-step goes on: its folder is in use"), (0, "it is ended, too: the folder goes with the next import")):
        run("import", "here/a.obj", "-o", "here/stopped/in", "--force")
        check(len(list(pathlib.Path("here/stopped/in").glob(".raymap-*"))) == left, what)
        if left:
            os.kill(child, signal.SIGKILL)
            while pathlib.Path(f"/proc/{child}").exists() and "Z" not in pathlib.Path(f"/proc/{child}/stat").read_text(encoding="utf-8").split(") ")[1]:
                time.sleep(0.01)


def check_full():
    """A file that may not grow: the reason is the disk's, not the lens's."""
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (512, resource.RLIM_INFINITY))
    for path in ("here/a.zmx", "here/a.obj"):
        done = subprocess.run([RAYMAP, "import", path, "-o", "here/full"], text=True, stderr=subprocess.PIPE, stdout=subprocess.PIPE,
                              preexec_fn=limit, check=False)
        check(done.returncode == 5 and "File too large" in done.stderr, f"{path}: {done.returncode} {done.stderr}")
        check(not [n for n in files_of("here/full") if n.endswith(".part")] if pathlib.Path("here/full").exists() else True, "no part of a file stays")


def check_rules():
    """A wrong rule is the only thing that is told, once; one that fits nothing says why."""
    many = "".join(OBJ.replace("one", f"p{i}").replace("f ", "f ").replace("v ", "v ") if i == 0 else
                   "g p%d\n" % i + "".join("f %d %d %d\n" % tuple(4 * i + k for k in t) for t in ((1, 3, 2), (1, 2, 4), (2, 3, 4), (1, 4, 3)))
                   for i in range(3))
    points = "".join("v %g %g %g\n" % (x + 3 * i, y, z) for i in range(1, 3) for x, y, z in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)))
    run("import", write("many.obj", points and many.replace("g p1\n", points + "g p1\n", 1)), "-o", "here/rules")
    parts = pathlib.Path("here/rules/parts.yaml").read_text(encoding="utf-8")
    ids = re.findall(r"id: '?(\w+)", parts)
    attributes = pathlib.Path("here/rules/attributes.yaml")

    def told(*rules):
        attributes.write_text("attributes:\n" + "".join(f"  - {r}\n" for r in rules), encoding="utf-8")
        done = subprocess.run([RAYMAP, "check", "here/rules/scene.yaml"], text=True, capture_output=True, check=False)
        return [line for line in done.stderr.splitlines() if not line.startswith("raymap:")]

    def only(words, *rules, line):
        lines = told(*rules)
        check(len(lines) == 1 and words in lines[0] and f"here/rules/attributes.yaml:{line}:" in lines[0], f"{rules}: {lines}")

    only("unknown", "{match: {name: '*'}, set: {surface: nosuch}}", "{match: {name: nobody}, set: {omit: true}}", line=2)
    only("unknown medium 'N-BK77'", "{match: {name: '*'}, set: {surface: fresnel, inside: N-BK77}}", line=2)
    only("sets nothing", "{match: {name: '*'}, set: {}}", line=2)
    check(any("'edge' is of lenses" in line for line in told("{match: {name: '*'}, set: {edge: absorber}}")), "an edge on a mesh")
    check(any("is left out by the rule at line 2 of attributes.yaml" in line
              for line in told("{match: {name: p1}, set: {omit: true}}", "{match: {name: p1}, set: {surface: absorber}}")), "after an omit")
    check(any(f"did you mean '{ids[0]}'" in line for line in told("{match: {id: %s}, set: {omit: true}}" % (ids[0][:-1] + "z"))),
          f"a nearby id: {ids[:3]}")
    for faces in ("0..4", "1-7"):
        lines = told("{match: {name: p1, face: %s}, set: {surface: absorber}}" % faces)
        check(any("fits no face: 'p1' has the faces 0 to" in line for line in lines), f"{faces}: {lines}")


def check_f_numbers():
    """Of a near object the F/# of parallel light (0) and the working one at the image (1) are two; OBNA may be an angle."""
    lens = ZMX.replace("FTYP 0", "FTYP 1").replace("DISZ INFINITY", "DISZ 100")

    def pupil(words):
        return json.loads(run("import", write("near.zmx", lens.replace("ENPD 10", words)), "-o", "here/near", "--force", "--json"))

    parallel, working = pupil("FNUM 4 0"), pupil("FNUM 4 1")
    check(abs(parallel["f_number"] - 4) < 1e-9, f"F/4 of parallel light: {parallel}")
    magnified = working["entrance_pupil_diameter"] / parallel["entrance_pupil_diameter"]
    check(1.2 < magnified < 10, f"F/4 at the image: {magnified}")
    by_angle, by_aperture = pupil("OBNA 3 1"), pupil(f"OBNA {math.sin(math.radians(3))!r} 0")
    for one in (by_angle, by_aperture):
        check(abs(one["entrance_pupil_diameter"] - 200 * math.tan(math.radians(3))) < 1e-6, f"3 degrees of the object: {one}")


check_numbers()
check_words()
check_f_numbers()
check_eye()
check_folders()
check_direction()
check_interrupt()
check_full()
check_rules()
asking.finish()
