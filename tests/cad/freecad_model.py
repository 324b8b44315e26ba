# SPDX-License-Identifier: MIT
"""For freecadcmd: lamp.step and lamp-b.step, where the second bolt went 5 mm, the first one is gone and the lens has another name."""
import FreeCAD
import Import
import Part
from FreeCAD import Placement, Rotation, Vector


def lens():
    return Part.makeSphere(51.68, Vector(0, 0, 51.68)).common(Part.makeCylinder(12.7, 10, Vector(0, 0, -1)).common(
        Part.makeBox(60, 60, 6, Vector(-30, -30, -2))))


def write(path, revised):
    document = FreeCAD.newDocument("lamp")
    lamp, optics = (document.addObject("App::Part", name) for name in ("lamp", "optics"))
    lamp.addObject(optics)

    def add(group, name, shape, place):
        thing = document.addObject("Part::Feature", name)
        thing.Shape, thing.Placement = shape, place
        group.addObject(thing)
        return thing

    glass = add(optics, "cover" if revised else "front_lens", lens(), Placement(Vector(0, 0, 40), Rotation(Vector(1, 0, 0), 180)))
    glass.Label = "cover" if revised else "front lens"
    add(lamp, "housing", Part.makeCylinder(30, 60).cut(Part.makeCylinder(28, 60, Vector(0, 0, 2))), Placement())
    for k in range(1 if revised else 0, 3):
        move = 5 if revised and k == 1 else 0
        add(lamp, f"bolt{k}", Part.makeCylinder(2, 8), Placement(Vector(35 + 10 * k, move, 25.4 / 2), Rotation(Vector(0, 1, 0), 30 * k)))
    document.recompute()
    Import.export([lamp], path)
    FreeCAD.closeDocument("lamp")


write("lamp.step", False)
write("lamp-b.step", True)
