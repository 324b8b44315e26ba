#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`raymap import`: what is not understood is told with line and surface and stands in the scene; an edited scene is not lost; the
scene traces at once to a table of ghosts; what is no lens is refused with a sentence."""
import json
import pathlib
import shutil
import time

import asking
from asking import check, run

LENSES = asking.SOURCE / "tests" / "data" / "lenses"
shutil.rmtree("here", ignore_errors=True)
pathlib.Path("here").mkdir()

ZMX = """VERS 1
NAME A triplet, \u00e9tude
NOTE 0 made for a test
UNIT MM X W X CM MR CPMM
ENPD 10
GCAT SCHOTT
FTYP 0 0 2 2
XFLN 0 0
YFLN 0 5
WAVM 1 0.48 1
WAVM 2 0.65 2
PWAV 1
SURF 0
  DISZ INFINITY
SURF 1
  COMM front lens: # {odd}
  STOP
  CURV 0.02
  DISZ 4
  GLAS GLASS1 0 0 1.5 40
  DIAM 6 1 0 0 1 ""
SURF 2
  CURV -0.02
  DISZ 48
  MAZH 0 0
SURF 3
  DISZ 0
"""


def write(name, text, encoding="latin-1"):
    pathlib.Path("here", name).write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
    return "here/" + name


def bring(path, *more, status=0):
    return run("import", path, "-o", "here/out", "--force", *more, status=status)


def scene():
    return pathlib.Path("here/out/scene.yaml").read_text(encoding="utf-8")


def check_encodings():
    texts = []
    for encoding in ("latin-1", "utf-16", "utf-16-be", "utf-8"):
        data = ZMX.encode(encoding)
        bring(write("a.zmx", b"\xfe\xff" + data if encoding == "utf-16-be" else data))
        texts.append(scene())
    check(len(set(texts)) == 1, "UTF-16 of either order, UTF-8 and Latin-1 are the same scene")
    for words in ("A triplet, \u00e9tude", "made for a test", "front lens: # {odd}", "thickness by a solve", "air: {index: 1}"):
        check(words in texts[0], f"'{words}' stands in the scene")


def check_glass():
    lens = write("a.zmx", ZMX)
    told = json.loads(bring(lens, "--json"))
    check(not told["understood"] and told["findings"][0]["line"] == 15 and "GLASS1" in told["findings"][0]["text"],
          f"an unknown glass: {told['findings']}")
    check("line 15: surface 1: glass 'GLASS1' is not known" in scene(), "and in the scene")
    shutil.copy(LENSES / "prysm_tiny_schott.agf", "here/tiny.agf")
    write("mine.agf", "NM GLASS1 2 0 1.5 60\nGC of mine\nCD 1.03961212 0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653\n"
          "LD 0.3 2.5\nNM GLASS2 5 0 1.5 60\nCD 1.5 0.01 0.001\n")
    told = json.loads(bring(lens, "--json"))  # beside the file
    glass = [m for m in told["media"] if m["word"] == "GLASS1"][0]
    check(told["understood"] and glass["kind"] == "file" and abs(glass["index"] - 1.522829) < 5e-7, f"from a file beside: {glass}")
    check("formula 2 of the catalogue file, line 1: of mine" in scene(), "which says where it is from")
    bk7 = json.loads(run("glass", "N-BK7", "--at", "480", "--json"))["glasses"][0]["at"][0]["n"]
    check(abs(glass["index"] - bk7) < 1e-12, "the index is that of the same coefficients in the catalogue")
    told = json.loads(bring(write("b.zmx", ZMX.replace("GLASS1", "GLASS2")), "--json"))
    want = 1.5 + 0.01 / 0.48 + 0.001 / 0.48 ** 3.5
    check(abs([m["index"] for m in told["media"] if m["word"] == "GLASS2"][0] - want) < 1e-12 and "table: {wavelength" in scene(),
          "Conrady's formula as a table")
    pathlib.Path("here/mine.agf").unlink()
    write("elsewhere.cat", "NM GLASS1 9 0 1.5 60\nCD 2.2 0.01 0.01\n")
    told = json.loads(bring(lens, "--glass", "here/elsewhere.cat", "--json"))
    check(told["understood"], f"--glass: {told['findings']}")
    write("bad.agf", "NM X 99 0\n")
    told = json.loads(bring(lens, "--glass", "here/elsewhere.cat", "--json"))
    check("line 1" in told["findings"][0]["text"] and "bad.agf" in told["findings"][0]["text"], "a bad catalogue beside is told")
    pathlib.Path("here/bad.agf").unlink()
    check("line 1" in bring(lens, "--glass", write("worse.cat", "NM X 99 0\n"), status=3), "one that was asked for is a mistake")
    # Old names, makers behind an underscore, aliases.
    for name, want in (("BK7", "N-BK7"), ("NBK7_SCHOTT", "N-BK7"), ("SILICA", "fused-silica"), ("S-LAH55", "S-LAH55")):
        bring(write("c.zmx", ZMX.replace("GLASS1", name)))
        check(f"medium: {want}," in scene(), f"{name} is {want}")
    bring(write("c.zmx", ZMX.replace("GLASS1 0 0 1.5 40", "MYGLASS 0 0 1.6 50")))
    check("medium: model-1.6-50" in scene() and "a model of the file's index 1.6" in scene(), "nd and Vd of the file")


def check_not_understood():
    told = json.loads(bring(LENSES / "optiland_flat_transmission_grating.zmx", "--json"))
    check(not told["understood"] and told["findings"] ==
          [{"line": 99, "text": "surface 3: diffraction grating DGRATING is not understood: a conic of its curvature stands in its place"}],
          f"a grating: {told['findings']}")
    check("DGRATING" in scene().split("geometries:")[1], "it is left visible where it stands")
    bring(LENSES / "optiland_flat_transmission_grating.zmx", "--strict", status=3)
    odd = ZMX.replace("SURF 2\n", "SURF 2\n  TYPE ODDASPHE\n  PARM 3 1e-4\n  PARM 4 2e-6\n  ABCD 1\n")
    told = json.loads(bring(write("d.zmx", odd.replace("GLASS1", "N-BK7")), "--json"))
    said = " ".join(f["text"] for f in told["findings"])
    check("surface 2: odd powers" in said and "'ABCD' is not understood" in said, said)
    check("asphere: {4: 2e-06}" in scene(), "even powers of an odd asphere are there: PARM 4 is that of r^4")
    run("check", "here/out/scene.yaml")
    bring(write("e.zmx", ZMX.replace("GLASS1", "N-BK7").replace("SURF 2\n", "SURF 2\n  TYPE XASPHERE\n  XDAT 1 2\n  XDAT 2 10\n"
                                                              "  XDAT 3 0.1\n  XDAT 4 0.2\n")))
    check("asphere: {2: 0.001, 4: 2e-05}" in scene(), "an extended asphere is of r^2 over its norm")


def check_sizes():
    """Rows do not cross, and no sphere ends before its rim, whatever the file says."""
    thin = ZMX.replace("GLASS1", "N-BK7").replace("DISZ 4", "DISZ 0.5").replace("CURV 0.02", "CURV 0.15")
    told = json.loads(bring(write("f.zmx", thin), "--json"))
    check("more than the next surface allows" in told["findings"][0]["text"], f"{told['findings']}")
    run("check", "here/out/scene.yaml")


def check_edits():
    lens = write("g.zmx", ZMX.replace("GLASS1", "N-BK7"))
    shutil.rmtree("here/new", ignore_errors=True)
    run("import", lens, "-o", "here/new")
    path = pathlib.Path("here/new/scene.yaml")
    as_written = path.read_text(encoding="utf-8")
    run("import", lens, "-o", "here/new")
    check(path.read_text(encoding="utf-8") == as_written and not path.with_suffix(".yaml.bak").exists(), "an unedited scene is written again")
    for n, edited in enumerate((as_written + "# mine\n", as_written.replace("radius: 50", "radius: 51"), as_written[:-1])):
        path.write_text(edited, encoding="utf-8")
        said = run("import", lens, "-o", "here/new", status=2)
        check("--force" in said and "scene.yaml.bak" in said and path.read_text(encoding="utf-8") == edited, f"an edited scene stands: {said}")
        run("import", lens, "-o", "here/new/", "--force")
        backup = pathlib.Path("here/new/scene.yaml.bak" + (f".{n + 1}" if n else ""))
        check(path.read_text(encoding="utf-8") == as_written and backup.read_text(encoding="utf-8") == edited, "--force keeps the edited one beside it")
    run("import", write("h.zmx", "SURF 0\n"), "-o", "here/never", status=3)
    check(not pathlib.Path("here/never").exists(), "what fails leaves no folder")


def check_refusals():
    for name, text, status, said in (
            ("a.zar", "x", 3, "save it as .zmx"), ("a.agf", "x", 2, "--glass"), ("a.txt", "x", 2, ".zmx (Zemax)"),
            ("a.zmx", "hello\n", 3, "SURF 0"), ("a.seq", "hello\n", 3, "'SO'"), ("a.len", "LEN\n", 3, "NXT"),
            ("a.zmx", b"SURF 0\n\0", 3, "byte 0"), ("a.zmx", "SURF 0\n" * 2001, 3, "line 2001: more than 2000 surfaces"),
            ("a.seq", "SO 0 1e20\n" + "S 1 &\n" * 2000, 3, "too long")):
        check(said in bring(write(name, text), status=status), f"{name}: {said}")
    bring("here/none.zmx", status=3)
    check("-o FOLDER" in run("import", "here/a.zmx", status=2), "without -o")


def check_oslo():
    text = """// OSLO 6
LEN NEW "A singlet" 50 2
EBR 5
ANG 3
DES "x"
UNI 1
// SRF 0
AIR
TH 1e20
NXT // SRF 1
GLA BK7
RD 50
TH 3
AP 6
AST
NXT
AIR
RD -50
TH 48
CC -1
AD 1e-7
TLA 3
NXT
AIR
WV 0.58756 0.48613
END 3
"""
    told = json.loads(bring(write("a.len", text), "--json"))
    n = [m["index"] for m in told["media"] if m["name"] == "N-BK7"][0]
    power = (n - 1) * (2 / 50 - (n - 1) * 3 / (n * 2500))
    check(told["title"] == "A singlet" and abs(told["focal_length"] * power - 1) < 1e-12, f"OSLO: {told['focal_length']}, {1 / power}")
    said = " ".join(f["text"] for f in told["findings"])
    check("surface 2: TLA" in said and "its successor" in said, said)
    check("conic: -1, asphere: {4: 1e-07}" in scene() and "stop: true" in scene(), "its shapes")


def check_ghosts():
    """From a lens file to a table of ghosts."""
    begun = time.monotonic()
    run("import", LENSES / "rayoptics_codev_ag_dblgauss.seq", "-o", "here/gauss", "--force")
    for encoding in ("compact", "plain"):
        run("trace", "here/gauss/scene.yaml", "-n", "20000", "-o", f"here/{encoding}.raymap", "--force", "--quiet", "--encoding", encoding)
    ghosts = json.loads(run("ghosts", "here/compact.raymap", "sensor", "--json"))
    check(len(ghosts["rows"]) > 5, "ghosts of the double Gauss")
    check(time.monotonic() - begun < 60, "in less than a minute")
    run("verify", "here/compact.raymap")
    digests = [json.loads(run("info", f"here/{encoding}.raymap", "--json"))["digest"] for encoding in ("compact", "plain")]
    check(digests[0] == digests[1], "both encodings hold the same rays")


check_encodings()
check_glass()
check_not_understood()
check_sizes()
check_edits()
check_refusals()
check_oslo()
check_ghosts()
asking.finish()
