#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Units of flux: photons, photons/s, J and eV beside W and lm, told everywhere, and turned into each other where a scene has several;
photon energies where wavelengths stand, in scene files and in criteria. All numbers are worked out here from h, c and e."""
import json
import pathlib

import asking
import h5py
import numpy as np
import served
from asking import check, run

H, C, E = 6.62607015e-34, 299792458, 1.602176634e-19
SCENE = """raymap: 1
units: m
spectrum: {wavelengths: [400, 500, 600]}
media: {air: {index: 1}}
geometries: {plate: {type: rectangle, size: [2, 2]}}
objects: [{name: plate, geometry: plate, at: [0, 0, 1], surface: absorber}]
sources:
  - {name: a, type: collimated, shape: {rectangle: [1, 1]}, medium: air, A}
B
detectors:
  - {name: seen, type: plane, on: plate, size: 2, cells: 2 MORE}
  - {name: far, type: intensity, cells: [4, 4]}
"""


def scene(name, a, b="", more=""):
    other = f"  - {{name: b, type: collimated, shape: {{rectangle: [1, 1]}}, medium: air, {b}}}" if b else ""
    pathlib.Path(name).write_text(SCENE.replace("A}", a + "}").replace("B\n", other + "\n").replace("MORE", more), encoding="utf-8")
    return name


def trace(a, b="", more="", n=3000):
    run("trace", scene("a.yaml", a, b, more), "-o", "a.raymap", "-n", n, "--quiet", "--force")
    return json.loads(run("info", "a.raymap", "--json"))["sources"]


def close(what, got, want, rel=1e-12):
    check(abs(got - want) <= rel * abs(want), f"{what}: {got} not {want}")


def check_told():
    for flux, unit, value, area, way in (("1000 photons", "photons", 1000, "photons/m2", "photons m"),
                                         ("1e9 photons/s", "photons/s", 1e9, "photons/(s m2)", "photons m/s"), ("2 W", "W", 2, "W/m2", "W m"),
                                         ("5 MeV", "J", 5e6 * E, "J/m2", "J m")):
        (told,) = trace(f"flux: {flux}")
        check(told["unit"] == unit, f"{flux}: {told}")
        close(flux, told["flux"], value)
        image = served.ask("detector", "a.raymap", "seen")
        check(image["flux"]["unit"] == unit and image["unit"] == area, f"{flux}: {image['flux']} {image['unit']}")
        close(f"{flux}: mean", image["mean"]["value"], value / 4, 1e-9)
        check(served.ask("query", "a.raymap", "all")["flux"]["unit"] == unit, flux)
        check(served.ask("stats", "a.raymap", "--of", "path_length")["flux"]["unit"] == unit, flux)
        check(served.ask("report", "a.raymap", "--energy")["flux"]["unit"] == unit, flux)
        check(served.ask("paths", "a.raymap")["flux"]["unit"] == unit, flux)
        check(f" {unit}\n" in run("report", "a.raymap", 3), flux)
        check(json.loads(run("voxels", "a.raymap", "--cells", 2, "--region", "-1,-1,0,1,1,1", "--json"))["fluence_rate"]["total_unit"] == way, flux)
        run("query", "a.raymap", "all", "-o", "t.h5", "--columns", "ray/flux", "--force")
        with h5py.File("t.h5") as file, h5py.File("a.raymap/map.h5") as index:
            check(file["ray/flux"].attrs["units"] in (unit, unit.encode()), flux)
            check(index["source/flux"].attrs["units"] in (unit, unit.encode()), flux)
        run("verify", "a.raymap")
    trace("flux: 3000 photons")
    check("does not say the spectrum of source 'a'" in run("detector", "a.raymap", "seen", "--xyz", status=3), "XYZ of photons")
    for words in (["detector", "a.raymap", "seen", "--quantity", "illuminance"],
                  ["irradiance", "a.raymap", "plate", "--quantity", "illuminance"]):
        check("of light in W or lm, and this map's is in photons" in run(*words, status=2), words)
    check("TM-25 has flux in W or lm" in run("query", "a.raymap", "all", "-o", "y.tm25ray", "--at", "seen", status=3), "TM-25 of photons")
    check("V(lambda) is of light in W or lm" in run("check", scene("x.yaml", "flux: 3 photons", more=", response: V"), status=3), "V of photons")
    trace("flux: 3000 MeV")
    for what, n in (("flux > 0.9 MeV", 3000), ("flux < 0.9 MeV", 0), ("flux in 900..1100 keV", 3000), ("flux > 1 pJ", 0)):
        check(served.ask("query", "a.raymap", what)["rays"]["matched"] == n, what)
    close("--unit", served.ask("detector", "a.raymap", "seen", "--quantity", "flux", "--unit", "MeV")["mean"]["value"], 3000, 1e-9)
    check("is no unit here (J mJ uJ nJ pJ eV keV MeV GeV)" in run("query", "a.raymap", "flux > 1 W", status=3), "W of J")


def check_colour():
    """XYZ of photons and of J, of 400, 500 and 600 nm (CIE 1931, 2 degrees)."""
    nm, bar = np.array([400e-9, 500e-9, 600e-9]), np.array([[.01431, .000396, .06785], [.0049, .323, .272], [1.0622, .631, .0008]])
    share, lines = np.array([0.2, 0.3, 0.5]), "spectrum: {lines: {400: 0.2, 500: 0.3, 600: 0.5}}"
    for flux, unit, energy in ((f"1e18 photons, {lines}", "lx s", 1e18 * share * H * C / nm), (f"1e18 photons/s, {lines}", "lx", 1e18 * share * H * C / nm),
                               (f"2 J, {lines}", "lx s", 2 * share)):
        trace(f"flux: {flux}")
        colour = served.ask("detector", "a.raymap", "seen", "--xyz")["colour"]
        check(colour["unit"] == unit, f"{flux}: {colour['unit']}")
        for got, want in zip(colour["XYZ"], 683 * (energy @ bar) / 4):
            close(f"XYZ of {flux}", got, want, 2e-4)


def check_mixed():
    nm = np.array([400e-9, 500e-9, 600e-9])
    share = np.array([0.2, 0.3, 0.5])
    lines = "spectrum: {lines: {400: 0.2, 500: 0.3, 600: 0.5}}"
    energy = share * H * C / nm
    for a, b, unit, want in ((f"flux: 1e18 photons/s, {lines}", "flux: 2 W", "W", (1e18 * energy.sum(), 2)),
                             (f"flux: 1e18 photons, {lines}", "flux: 3 MeV", "J", (1e18 * energy.sum(), 3e6 * E)),
                             ("flux: 1000 photons", "flux: 5 photons", "photons", (1000, 5))):
        told = trace(a, b)
        for one, value in zip(told, want):
            check(one["unit"] == unit, f"{a} {b}: {one}")
            close(f"{a} {b}", one["flux"], value, 1e-9)
    trace(f"flux: 1e18 photons/s, {lines}", "flux: 2 W", n=60000)
    for k, of in enumerate((400, 500, 600)):
        got = served.ask("detector", "a.raymap", "seen", "--where", "source(a)", "--quantity", "spectral")["spectrum"][k]["flux"]
        close(f"{of} nm", got, 1e18 * energy[k], 1e-4)  # shares have 16 bits
    for a, b, said in (("flux: 10 photons", "flux: 1 W", "source 'a' is an amount of light, others are powers"),
                       ("flux: 1 J", "flux: 1 lm", "source 'a' is an amount of light"), ("flux: 1e9 photons/s", "flux: 1 W", "its 'spectrum' must be given"),
                       ("flux: 3 furlongs", "", "unknown unit of flux 'furlongs'"), ("flux: 0 photons", "", "'flux' must be greater than 0")):
        check(said in run("check", scene("x.yaml", a, b), status=3), f"{a} {b}: {said}")


def check_energies():
    """Rows over eV against the same over nm; a source's spectrum per eV."""
    ev = np.array([1.9, 2.2, 2.6, 3.2])
    value = np.array([0.1, 0.4, 0.2, 0.3])
    nm = (H * C / E * 1e9 / ev)[::-1]

    def flux(spectrum="", response=""):
        trace(f"flux: 1 W{spectrum}", more=response, n=3000)
        return [one["flux"] for one in served.ask("detector", "a.raymap", "seen", "--quantity", "spectral")["spectrum"]]

    rows = f"{{energy: {ev.tolist()}, value: {value.tolist()}}}", f"{{wavelength: {nm.tolist()}, value: {value[::-1].tolist()}}}"
    for got, want in zip(*(flux(response=f", response: {table}") for table in rows)):
        close("response", got, want)
    dense = f"{{wavelength: {nm.tolist()}, value: {(value[::-1] / nm**2).tolist()}}}"
    for got, want in zip(flux(f", spectrum: {{table: {rows[0]}}}"), flux(f", spectrum: {{table: {dense}}}")):
        close("spectrum", got, want, 2e-5)
    by_ev = f"lines: {{{H * C / E / 400e-9!r} eV: 1, {H * C / 500e-9!r} J: 3}}"
    for got, want in zip(flux(f", spectrum: {{{by_ev}}}"), (0.25, 0.75, 0)):
        check(abs(got - want) < 2e-5, f"lines: {got} {want}")
    said = run("check", scene("x.yaml", "flux: 1 W", more=", response: {energy: [3, 2], value: [1, 1]}"), status=3)
    check("energies must increase, but 2 follows 3" in said, said)
    trace("flux: 1 W, spectrum: {lines: {400: 1}}", "flux: 1 W, spectrum: {lines: {600: 1}}")
    for what, n in (("photon_energy > 3 eV", 1500), ("photon_energy in 2..2.1", 1500), ("photon_energy < 1e-3 keV", 0), ("photon_energy < 4e-19 J", 1500)):
        check(served.ask("query", "a.raymap", what)["rays"]["matched"] == n, what)
    told = served.ask("stats", "a.raymap", "--of", "photon_energy")
    check(told["unit"] == "eV", f"{told['unit']}")
    close("mean energy", told["mean"]["value"], H * C / E * (1 / 400e-9 + 1 / 600e-9) / 2, 1e-9)


def check_accounting():
    species = "{index: 1, ACCOUNTING species: {dye: {absorption: 1, emission: {led: {peak: 600, width: 10}}}}}"
    for accounting, flux, unit in (("accounting: photons,", "", "photons"), ("accounting: photons,", "flux: 3", "photons"),
                                   ("accounting: photons,", "flux: 3 W", "W"), ("", "flux: 3", "W")):
        path = pathlib.Path(scene("a.yaml", flux or "rays_share: 1"))
        path.write_text(path.read_text("utf-8").replace("{index: 1}", species.replace("ACCOUNTING", accounting)), "utf-8")
        run("trace", path, "-o", "a.raymap", "-n", 100, "--quiet", "--force")
        (told,) = json.loads(run("info", "a.raymap", "--json"))["sources"]
        check(told["unit"] == unit, f"{accounting} {flux}: {told}")
    path = pathlib.Path(scene("x.yaml", "flux: 100 photons"))
    path.write_text(path.read_text("utf-8").replace("{index: 1}", species.replace("ACCOUNTING", "")), "utf-8")
    check("give media 'accounting: photons'" in run("check", path, status=3), "photons weighed by energy")


def check_read_again():
    """A map, and a table that a query wrote, are sources in the unit in which their light was counted; a column says its own."""
    again = ["name: again, type: ray_file, file: %s, detector: seen", "name: again, type: ray_file, file: %s"]
    for flux, unit, value in (("500 photons", "photons", 500), ("1e9 photons/s", "photons/s", 1e9), ("2 J", "J", 2), ("3 W", "W", 3), ("70 lm", "lm", 70)):
        trace(f"flux: {flux}", n=200)
        run("query", "a.raymap", "all", "-o", "t.h5", "--columns", "registration", "--force")
        with open("t.csv", "w", encoding="utf-8") as table:
            print(f"x,y,z,dx,dy,dz,flux ({unit})\n0,0,0,0,0,1,{value / 4}\n0,0,0,0,1,0,{value * 3 / 4}", file=table)
        for source in (again[0] % "a.raymap", again[0] % "t.h5", again[1] % "t.csv"):
            other = SCENE.replace("name: a, type: collimated, shape: {rectangle: [1, 1]}", source).replace(", A}", "}").replace("B\n", "\n").replace("MORE", "")
            pathlib.Path("b.yaml").write_text(other, encoding="utf-8")
            said = run("check", "b.yaml")
            check(f"source again: {value:g} {unit}" in said, f"{source} of {flux}: {said}")
        run("trace", "b.yaml", "-o", "b.raymap", "-n", 50, "--quiet", "--force")
        (told,) = json.loads(run("info", "b.raymap", "--json"))["sources"]
        check(told["unit"] == unit and abs(told["flux"] / value - 1) < 1e-9, f"{flux}: the map says {told}")
    other = other.replace(again[1] % "t.csv", again[0] % "t.h5").replace("units: m\n", "units: mm\n")
    pathlib.Path("b.yaml").write_text(other, encoding="utf-8")
    run("trace", "b.yaml", "-o", "b.raymap", "-n", 50, "--quiet", "--force")
    run("query", "b.raymap", "all", "-o", "u.h5", "--columns", "ray/start_z", "--force")
    with h5py.File("u.h5") as file:
        check(np.abs(np.array(file["ray/start_z"]) - 1000).max() < 0.01, "the table's lengths are in its unit, not in the scene's")


check_told()
check_read_again()
check_colour()
check_mixed()
check_energies()
check_accounting()
asking.finish()
