#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`raymap import`: what is not understood is told with line and surface and stands in the scene; an edited scene is not lost; the
scene traces at once to a table of ghosts; what is no lens is refused with a sentence."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import time

import asking
import zmx_lens
from asking import check, run

LENSES = asking.SOURCE / "tests" / "data" / "lenses"
shutil.rmtree("here", ignore_errors=True)
pathlib.Path("here").mkdir()

ZMX = "VERS 1\nNAME A triplet, \u00e9tude\nNOTE 0 made for a test\n" + zmx_lens.ZMX
for old, new in (("FTYP", "GCAT SCHOTT\nFTYP"), ("YFLN", "XFLN 0 0\nYFLN"), ("SURF 0", "PWAV 1\nSURF 0"), ("STOP", "COMM front lens: # {odd}\n  STOP"),
                 ("N-BK7", "GLASS1"), ("DISZ 48", "DISZ 48\n  MAZH 0 0")):
    ZMX = ZMX.replace(old, new)


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
    check("'ABCD' is not understood" in said, said)
    check("asphere: {3: 0.0001, 4: 2e-06}" in scene(), "an odd asphere: PARM 4 is that of r^4")
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
            ("a.zar", "x", 3, "no archive of Zemax"), ("a.agf", "x", 2, "--glass"), ("a.txt", "x", 2, ".zar (Zemax)"),
            ("a.zmx", "hello\n", 3, "SURF 0"), ("a.seq", "hello\n", 3, "'SO'"), ("a.len", "LEN\n", 3, "NXT"),
            ("a.zmx", b"SURF 0\n\0", 3, "byte 0"), ("a.zmx", "SURF 0\n" * 2001, 3, "line 2001: more than 2000 surfaces"),
            ("a.seq", "SO 0 1e20\n" + "S 1 &\n" * 2000, 3, "too long")):
        check(said in bring(write(name, text), status=status), f"{name}: {said}")
    pathlib.Path("here/a.agf").unlink()
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
    check("its successor" in said, said)
    check("conic: -1, asphere: {4: 1e-07}" in scene() and "stop: true" in scene(), "its shapes")
    # A mirror turned by 45 degrees that bends the axis, with a shift: TLA is left-handed, and light goes to -y.
    fold = text.split("NXT // SRF 1")[0] + "NXT\nRFL\nAST\nAP 6\nDCX 1\nTLA 45\nBEN\nTH -30\nNXT\nGLA MOD MINE 1.6 1.62\nCVX 0.02\nRD -30\nTH -3\nNXT\n" \
        "GSP 0.001\nTH -20\nNXT\nEND 4\n"
    fold = fold.replace("UNI 1\n", "UNI 1\nWV 0.58756 0.48613\n")
    told = json.loads(bring(write("fold.len", fold), "--json"))
    check("rotate: [-45, 0, 0]" in scene() and "at: [1, -33, 0], rotate: [-90, 0, 0]" in scene(), scene()[-1500:])
    check("MINE: {table: {wavelength: [486.13, 587.56], n: [1.62, 1.6]}}" in scene() and "toroid: 50" in scene(), "a toroid of a model glass")
    check([f["text"] for f in told["findings"]] == ["surface 3: diffraction grating (GSP) is not understood: its surface stands there without it"],
          f"{told['findings']}")


def lzw(data):
    """Welch's codes from 9 bits on, highest bit first."""
    words, out, bits, count, word = {bytes([i]): i for i in range(256)}, bytearray(), 0, 0, b""
    codes = []
    for byte in data:
        if word + bytes([byte]) in words:
            word += bytes([byte])
            continue
        codes.append(words[word])
        words[word + bytes([byte])] = len(words)
        word = bytes([byte])
    codes.append(words[word])
    known = 256
    for k, code in enumerate(codes):
        width = 9
        while 2 ** width <= known:
            width += 1
        bits, count = bits << width | code, count + width
        known += k > 0
    bits <<= -count % 8
    return bits.to_bytes((count + 7) // 8, "big")


def zar(files, new):
    data = b""
    for name, content, pack in files:
        packed, name = (lzw(content), name + ".LZW") if pack else (content, name)
        head = bytearray(0x288 if new else 0x14c)
        head[:2] = b"\xec\x03" if new else b"\xea\x00"
        if new:
            head[0x10:0x18] = len(packed).to_bytes(8, "little")
            head[0x30:0x30 + 2 * len(name)] = name.encode("utf-16-le")
        else:
            head[0x0c:0x10] = len(packed).to_bytes(4, "little")
            head[0x20:0x20 + len(name)] = name.encode()
        data += bytes(head) + packed
    return data


def check_archive():
    """The lens in an archive of either kind is that beside which its catalogue lies; damage is a sentence."""
    write("z.zmx", ZMX)
    shutil.copy(LENSES / "prysm_tiny_schott.agf", "here/z.agf")
    write("mine.agf", "NM GLASS1 2 0 1.5 60\nCD 1.03961212 0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653\nLD 0.3 2.5\n")
    bring("here/z.zmx")
    want = [line for line in scene().splitlines() if "Imported" not in line and "digest" not in line]
    agf = pathlib.Path("here/mine.agf").read_bytes()
    pathlib.Path("here/mine.agf").unlink()
    for new in (False, True):
        files = [("COATING.DAT", b"x" * 2000, True), ("LENS.ZMX", ZMX.encode("utf-16"), True), ("GLASS.AGF", agf, False)]
        packed = zar(files, new)
        bring(write("lens.zar", packed))
        check([line for line in scene().splitlines() if "Imported" not in line and "digest" not in line] == want, f"an archive, new {new}")
        check("cut off" in bring(write("cut.zar", packed[:-5]), status=3), "one that is cut off")
        damaged = bytearray(packed)
        damaged[(0x288 if new else 0x14c) + 5] ^= 0xff
        subprocess.run([os.environ["RAYMAP"], "import", write("bad.zar", bytes(damaged)), "-o", "here/out"], capture_output=True, timeout=20, check=False)
    check("no .zmx" in bring(write("none.zar", zar(files[:1], True)), status=3), "one without a lens")


ZOOM = ZMX.replace("GLASS1", "N-BK7") + """TOL TOFF 0 0 0
MNUM 3 1
LTTL 0 1 "wide" 0
LTTL 0 2 "wide" 0
LTTL 0 3 "at infinity" 0
THIC 2 1 48 0 0 0 1 1 1 0 0 "" 0
THIC 2 2 50.5 0 0 0 1 1 1 0 0 "" 0
THIC 2 3 47 0 0 0 1 1 1 0 0 "" 0
CRVT 1 1 0.02 0
CRVT 1 2 0.0205 0
CRVT 1 3 0.02 0
YFIE 2 3 3 0
GLSS 1 2 "N-SF11" 0
"""


def check_configurations():
    """Each is a simulation that sets what is other; a scene with it is as one of the file with that configuration stored."""
    lens = write("zoom.zmx", ZOOM)
    said = run("import", lens, "-o", "here/zoom")
    check("3 configurations" in said, said)
    path = "here/zoom/scene.yaml"
    text = pathlib.Path(path).read_text(encoding="utf-8")
    for words in ("name: wide\n", "name: configuration_2\n", "name: at_infinity\n", "objects.image.at"):
        check(words in text, f"{words} stands in the simulations: {said}")
    alone = ZMX.replace("GLASS1", "N-SF11").replace("CURV 0.02", "CURV 0.0205").replace("DISZ 48", "DISZ 50.5")
    run("import", write("alone.zmx", alone), "-o", "here/alone", "--force")
    seen = []
    for scene_file, more in ((path, ["--simulation", "configuration_2"]), ("here/alone/scene.yaml", [])):
        report = json.loads(run("report", scene_file, "--ray", "7", "--json", *more))
        seen.append([step["position"] for step in report["steps"]])
    check(seen[0] == seen[1], "a ray of the configuration is that of the file in which it is stored")
    check("--set objects.image.at" not in run("check", path, "--simulation", "at_infinity"), "others are read")
    digests = []
    for scene_file, more in ((path, ["--simulation", "configuration_2"]), ("here/alone/scene.yaml", [])):
        run("trace", scene_file, "-n", "3000", "-o", "here/zoom.raymap", "--force", "--quiet", *more)
        run("verify", "here/zoom.raymap")
        digests.append(json.loads(run("info", "here/zoom.raymap", "--json"))["digest"])
    check(digests[0] == digests[1], "and so are all rays of a map, which keeps the choice")
    moved = json.loads(run("report", path, "--ray", "7", "--json", "--simulation", "configuration_2", "--set", "objects.image.at=[0, 0, 60]"))
    check(moved["steps"][-1]["position"][2] == 60, "--set comes after it")
    bad = pathlib.Path(path)
    bad.write_text(text.replace("objects.image.at:", "objects.imago.at:"), encoding="utf-8")
    told = run("check", path, "--simulation", "configuration_2", status=3)
    check("scene.yaml:" in told and "set: objects.imago.at: no item named 'imago' (did you mean 'image'?)" in told, told)
    codev = """RDM;LEN
EPD 10
WL 587.6
SO 0 1e20
S 50 4 NBK7_SCHOTT
STO
S -50 48
SI 0 0
ZOO 2
ZOO TIT
TIT Z1 "near"
TIT Z2 "far"
ZOO THI S2 48 50.5
ZOO RDY S1 50 48
GO
"""
    run("import", write("zoom.seq", codev), "-o", "here/zoomseq", "--force")
    text = pathlib.Path("here/zoomseq/scene.yaml").read_text(encoding="utf-8")
    check("name: near\n" in text and "name: far\n" in text and "geometries.lens.surfaces.1.radius: 48" in text, text[-600:])


def check_openings():
    """Openings that are no circles about the vertex, plates and their holders, gradients, private glasses."""
    text = ZMX.replace("GLASS1", "N-BK7").replace("  STOP\n", "").replace("SURF 2\n", "SURF 2\n  SQAP 4 3\n  OBDC 0.5 0\n")
    text = text.replace("SURF 3\n", "SURF 3\n  STOP\n  DISZ 2\n  ELAP 5 3\nSURF 4\n  OBSC 0 1\n  SPID 0.2 3\n  DISZ 46\nSURF 5\n")
    told = json.loads(bring(write("o.zmx", text), "--json"))
    check(told["understood"] and [e["name"] for e in told["elements"]][1:] == ["stop_3", "obscuration_4", "spider_4"], f"{told['findings']} {told['elements']}")
    check("aperture: {rectangle: [8, 6], at: [0.5, 0]}" in scene() and "scale: [1, 0.6, 1]" in scene() and "spider_4_3" in scene(), "its openings")
    run("check", "here/out/scene.yaml")
    grin = ZMX.replace("GLAS GLASS1 0 0 1.5 40", "TYPE GRINSUR1\n  PARM 1 1\n  PARM 2 1.6\n  PARM 3 -1e-3")
    told = json.loads(bring(write("g.zmx", grin), "--json"))
    check(told["understood"] and "gradient: {type: zemax, gradient: 1, parameters: {n0: 1.6, nr2: -0.001}}" in scene(), f"{told['findings']}")
    run("check", "here/out/scene.yaml")
    bring(write("p.seq", "RDM;LEN\nEPD 5\nWL 587.6\nPRV\n PWL 650 587.6 480\n 'MY1' 1.51 1.52 1.53\nEND\nSO 0 1e20\nS 50 4 'MY1'\nSTO\nS -50 48\n"
                         "SI 0 0\n"))
    check("MY1: {table: {wavelength: [" in scene() and "1.52" in scene(), "a private glass of CODE V")
    said = bring(write("q.seq", "LEN\nEPD 5\nWL 587.6\nSO 0 1e20\nS 50 4 1.6:40\nSTO\nDIF DOE\nS -50 48\nSI 0 0\n"), "--json")
    check("curvatures up to 50: they are taken to be radii" in said and "diffraction (DIF DOE) is not understood" in said, said)


def check_numbers():
    """What should be a number and is none is told, and is a mistake for --strict."""
    seq = "RDM;LEN\nEPD abc\nWL 587.6\nSO 0 1e20\nS x 4 NBK7_SCHOTT\nSTO\nS -50 y\nK nan\nSI 0 0\n"
    told = json.loads(bring(write("n.seq", seq), "--json"))
    said = [f["text"] for f in told["findings"]]
    for wrong, line in (("EPD abc", 2), ("S x", 5), ("S y", 7), ("K nan", 8)):
        check(any(f["line"] == line and wrong + " is no number" in f["text"] for f in told["findings"]), f"{wrong}: {said}")
    run("import", "here/n.seq", "-o", "here/strict", "--strict", status=3)
    bad = re.sub(r"CURV \S+", "CURV abc", ZMX, count=1)
    check("CURV abc is no number" in bring(write("n.zmx", bad), "--json"), "a curvature of .zmx")


def check_ghosts():
    """From a lens file to a table of ghosts."""
    begun = time.monotonic()
    run("import", LENSES / "rayoptics_codev_ag_dblgauss.seq", "-o", "here/gauss", "--force")
    for encoding in ("compact", "plain"):
        run("trace", "here/gauss/scene.yaml", "-n", "20000", "-o", f"here/{encoding}.raymap", "--force", "--quiet", "--encoding", encoding)
    ghosts = json.loads(run("ghosts", "here/compact.raymap", "sensor", "--json"))
    check(len(ghosts["rows"]) > 5, "ghosts of the double Gauss")
    at_once = json.loads(run("ghosts", "here/gauss/scene.yaml", "sensor", "-n", "20000", "--json"))
    check(at_once["rows"] == ghosts["rows"], "ghosts of a scene are those of its map")
    drawn = json.loads(run("draw", "here/gauss/scene.yaml", "-n", "200", "-o", "here/gauss.svg", "--json"))
    check(drawn["rays"] == {"matched": 200, "drawn": 200}, "a scene is drawn with its rays")
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
check_archive()
check_configurations()
check_openings()
check_numbers()
check_ghosts()
asking.finish()
