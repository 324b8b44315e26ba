#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Lamps in scene files: what is wrong with a lamp's file is told with its line; maps keep their rays in either encoding, on any
number of ranks, and without the file; places in groups, meshes, pages and pictures know lamps."""
import json
import pathlib
import sys

import asking
from asking import check, run, told_of
import h5py
import raymap.serve

sys.path.insert(0, str(asking.SOURCE / "tests" / "physics"))
import lamp_files  # noqa: E402
from lamp_files import steps  # noqa: E402

SCENE = """raymap: 1
units: m
spectrum: {mode: rgb}
media: {air: {index: 1}}
surfaces: {grey: {type: lambert, reflectance: 0.5}}
geometries: {room: {type: box, size: [4, 3, 2.5]}, shade: {type: mesh, file: shade.obj}}
objects: [{name: room, geometry: room, surface: grey, inside: air, outside: air, at: [0, 0, 1.25]}]
sources:
  - {name: lamp, type: lamp, file: LAMP, at: [0, 0, 2.4], rotate: [180, 0, 0], medium: air, spectrum: {rgb: [1, 1, 1]}MORE}
detectors:
  - {name: floor, type: plane, at: [0, 0, 0.01], direction: [0, 0, 1], size: [4, 3], cells: [8, 6]}
"""


def scene_text(lamp, more="", text=SCENE):
    return text.replace("LAMP", lamp).replace("MORE", more)


def scene(*words, **more):
    return write("scene.yaml", scene_text(*words, **more))


def write(name, text):
    pathlib.Path(name).write_bytes(text if isinstance(text, bytes) else text.encode("latin-1"))
    return name


def light(d):
    return 100 * (1.5 + d[2] + 0.4 * d[0] - 0.3 * d[1])


IES = lamp_files.ies(light, "C", steps(0, 360, 15), steps(0, 180, 5), size=(0.3, 1.2, 0.05))
LDT = lamp_files.eulumdat(light, 0, planes=24, gammas=37, size=(1200, 300, 50, 50, 50, 50), lumens=(1000, 800))


def check_mistakes(server):
    small = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 2 1 2 0 0 0\n1 1 20\n0 45 90\n0 90\n1 2 3\n4 5 6\n"
    table = lamp_files.eulumdat(light, 0, planes=4, gammas=3).replace("\r", "").splitlines()

    def line(k, text):
        return "\n".join(table[:k - 1] + [text] + table[k:]) + "\n"

    for name, text, said in (
            ("a.ies", "", "it has no line that begins with TILT="),
            ("a.ies", "IESNA:LM-63-2002\nTILT=NONE\n", "line 3: it ends before the number of lamps"),
            ("a.ies", small.replace("4 5 6", "4 5"), "line 9: it ends before an intensity"),
            ("a.ies", small.replace("4 5 6", "4 -5 6"), "line 8: '-5': an intensity is a number from 0"),
            ("a.ies", small.replace("4 5 6", "4 nan 6"), "line 8: 'nan': an intensity"),
            ("a.ies", small.replace("4 5 6", "4 5x 6"), "line 8: '5x': an intensity"),
            ("a.ies", small.replace("0 45 90\n", "0 90 45\n"), "line 5: a vertical angle of 45 comes after 90: they ascend"),
            ("a.ies", small.replace("\n0 90\n", "\n0 70\n"), "its horizontal angles go from 0 to 70: type C has"),
            ("a.ies", small.replace("3 2 1 2", "3 2 4 2"), "line 3: '4': the photometric type is a whole number from 1 to 3"),
            ("a.ies", small.replace("3 2 1 2", "3 2.5 1 2"), "'2.5': the number of horizontal angles is a whole number"),
            ("a.ies", small.replace("3 2 1 2", "3000 2000 1 2"), "it ends before its 2000 x 3000 candelas"),
            ("a.ies", small.replace("1 2 3", "0 0 0").replace("4 5 6", "0 0 0"), "it has no light"),
            ("a.ies", small.replace("NONE", "INCLUDE\n1 2 0 90 1 0.5").replace("1 1 20", "1 1 x"), "line 5: 'x': the input watts"),
            ("a.ies", b"IESNA\0TILT=NONE\n", "holds a byte 0: it is not text"),
            ("a.ldt", "", "line 1: it ends before the symmetry"),
            ("a.ldt", line(3, "5"), "line 3: '5': the symmetry is a whole number from 0 to 4"),
            ("a.ldt", line(4, "0"), "line 4: '0': the number of planes C"),
            ("a.ldt", line(16, "-3"), "line 16: '-3': the length of the luminous area"),
            ("a.ldt", line(26, "21"), "line 26: '21': the number of sets of lamps is a whole number from 1 to 20"),
            ("a.ldt", line(29, "many"), "line 29: 'many': the lumens of a set of lamps"),
            ("a.ldt", line(44, "0"), "line 44: plane C 0 comes after 0: they ascend"),
            ("a.ldt", line(48, "0"), "line 48: gamma 0 comes after 0: they ascend"),
            ("a.ldt", line(50, "1 2"), "line 50: an intensity stands alone in its line"),
            ("a.ldt", line(46, "190"), "its planes go from C 0 to 190: without a symmetry they fill the turn"),
            ("a.txt", LDT, "'a.txt' is no lamp's file by its name: IES LM-63 ends in .ies, EULUMDAT in .ldt")):
        write(name, text)
        its, told = told_of(server, scene_text(name))
        check(its["errors"] and said in told, f"{name}: {said}\n{told}")
        check(any(one["line"] == 9 for one in its["diagnostics"]), f"the line of the scene: {its['diagnostics']}")
    write("b.ldt", LDT)
    write("b.ies", IES)
    for lamp, more, said in (("b.ldt", ", set: 3", "b.ldt: set 3 is not there: it has 2"),
                             ("b.ies", ", set: 2", "set 2 is not there: an IES file has one"),
                             ("none.ies", "", "none.ies"),
                             ("b.ies", ", emitter: {ball: 3}", "unknown key in an emitter: 'ball'"),
                             ("b.ies", ", emitter: {}", "an emitter is 'opening', 'point', {disc: radius}, {rectangle"),
                             ("b.ies", ", emitter: hole", "an emitter is 'opening', 'point', {disc: radius}, {rectangle"),
                             ("b.ies", ", distribution: cosine", "'distribution'"),
                             ("b.ies", ", spin: fast", "'spin' must be a finite number")):
        its, told = told_of(server, scene_text(lamp, more))
        check(its["errors"] and said in told, f"{lamp}{more}: {said}\n{told}")
    told = run("check", scene(write("t.ies", IES.replace("TILT=NONE", "TILT=b.tlt")), ", tilt: 20"), status=3)
    check("line 5: its factors of tilts are in 'b.tlt': put them here, behind TILT=INCLUDE" in told, told)
    check("source lamp" in run("check", scene("t.ies")), "a file of tilts is not needed by what is not tilted")


def check_maps():
    lamps = (("c.ies", IES, ""), ("c.ldt", LDT, ", set: 2"), ("c.ies", IES, ", emitter: {mesh: shade}"),
             ("c.ies", IES.replace("0.3 1.2 0.05", "-0.3 1.2 -0.05"), ", spin: 30"))
    pictures = (("draw", "--view", "xz", "-o", "a.svg"), ("draw", "--view", "xy", "-o", "a.svg"), ("draw", "-o", "a.html"),
                ("report", "--html", "-o", "r.html"))
    for k, ((name, text, more), (command, *how)) in enumerate(zip(lamps, pictures)):
        path, found = scene(write(name, text), more), set()
        for target, ranks, encoding in (("a.raymap", 1, "compact"), ("b.raymap", 2, "compact") if k % 2 else ("b.raymap", 3, "plain")):
            run("trace", path, "-o", target, "-n", 10000, "--quiet", "--force", "--encoding", encoding, ranks=ranks)
        pathlib.Path(name).unlink()
        run("verify", "b.raymap")
        for target in ("a.raymap", "b.raymap"):
            with h5py.File(target + "/map.h5") as index:
                digest = str(index.attrs["digest"])
            found.add((digest, run("query", target, "registered(floor) and path_length > 3", "--count")
                       .splitlines()[1], run("report", target, 77).split("\n\n0.")[0].rsplit("\n", 2)[0]))
        check(len(found) == 1, f"{name}{more}: one answer, not {len(found)}: {found}")
        run(command, "a.raymap", *how, "--force")


def check_told():
    told = run("check", scene(write("d.ies", IES)))
    check("source lamp: " in told and "'Example of C', from a box of 1.2 x 0.3 x 0.05 m" in told, told)
    group = SCENE.replace("  - {name: lamp", "  - {name: other, type: point, flux: 1 lm, medium: air}\n  - {name: lamp")
    told = run("check", scene("d.ies", ", flux: 500 lm", text=group))
    check("source lamp: 500 lm in 'air', 'Example of C'" in told, told)


write("shade.obj", "v 0 0 0\nv 0.3 0 0\nv 0 0.2 0\nv 0 0 -0.2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
FAR = """raymap: 1
units: m
media: {air: {index: 1}}
sources: [{name: lamp, type: point, flux: FLUX, distribution: {cone: 60}, medium: air}]
geometries: {wall: {type: rectangle, size: [9, 9]}}
detectors: [{name: far, type: intensity, cells: [18, 1]}, {name: near, type: plane, at: [0, 0, 1], size: 1, cells: 4}]
"""


def check_written():
    pathlib.Path("far.yaml").write_text(FAR.replace("FLUX", "314.15926535897931 lm"), encoding="utf-8")
    run("trace", "far.yaml", "-o", "far.raymap", "-n", 100000, "--quiet", "--force")
    texts = set()
    for ranks in 1, 3:
        run("detector", "far.raymap", "far", "-o", "far.ies", "-o", "far.ldt", "--force", ranks=ranks)
        texts.add(pathlib.Path("far.ies").read_text("ascii") + pathlib.Path("far.ldt").read_text("ascii"))
    check(len(texts) == 1, "one file on any number of ranks")
    c, gamma, (candela,) = lamp_files.read_ies("far.ies")
    check(c == [0] and gamma == steps(0, 180, 10), f"angles {c} {gamma}")
    for i, want in ((0, 100), (3, 100), (5, 100), (8, 0), (18, 0)):  # 314.16 lm over pi sr
        check(abs(candela[i] - want) < 10, f"{candela[i]} cd at {gamma[i]}, not {want}")
    lines = pathlib.Path("far.ldt").read_text("ascii").splitlines()
    check(lines[1:4] == ["1", "1", "1"] and float(lines[21]) == 100, f"EULUMDAT of one plane: {lines[:30]}")
    told = run("check", scene("far.ldt"))
    check("'Raymap far: rays: all', from a point" in told, told)
    run("detector", "far.raymap", "far", "--cells", "36x8", "-o", "far.ies", "--force")
    c, gamma, _ = lamp_files.read_ies("far.ies")
    check(c == steps(0, 360, 45) and gamma == steps(0, 180, 5), f"angles {c} {gamma}")
    run("detector", "far.raymap", "far", "--where", "source(lamp)", "-o", "far.ies", "--force")
    check("[LUMINAIRE] far: rays: source(lamp)" in pathlib.Path("far.ies").read_text("ascii"), "the criterion in the title")
    for arguments, said in ((("near", "-o", "x.ies"), "'near' is no intensity grid"),
                            (("far", "-o", "x.ies", "-o", "x.png"), "write pictures and numbers by another command"),
                            (("far", "-o", "x.ldt", "--cells", "auto"), "say how many steps of gamma and planes C"),
                            (("far", "-o", "x.ldt", "--cells", "721x1"), "at most 720 steps"),
                            (("far", "-o", "x.ldt", "--quantity", "flux"), "asked for another quantity"),
                            (("far", "-o", "x.ldt", "--region", "0,0,90,360"), "leave --region out")):
        told = run("detector", "far.raymap", *arguments, status=2)
        check(said in told, f"{arguments}: {told}")
    pathlib.Path("far.yaml").write_text(FAR.replace("FLUX", "1 W"), encoding="utf-8")
    run("trace", "far.yaml", "-o", "watt.raymap", "-n", 1000, "--quiet", "--force")
    told = run("detector", "watt.raymap", "far", "-o", "x.ies", status=3)
    check("the sources are in W: give their flux in lm" in told, told)
    check(not pathlib.Path("x.ies").exists() and not pathlib.Path("x.ldt").exists(), "nothing is left of what was refused")


check_written()
with raymap.serve.start("far.yaml") as asked:
    check_mistakes(asked)
check_maps()
check_told()
asking.finish()
