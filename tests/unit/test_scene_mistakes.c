/* SPDX-License-Identifier: MIT
 *
 * Every mistake in a scene file is found where it stands. Each case puts one line in place of one
 * of a good scene's and names all that must be said about it.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/unit/read_text.h"

static const char *const good[] = {
    "raymap: 1",                                                                       /*  1 */
    "units: mm",                                                                       /*  2 */
    "spectrum: {mode: spectral, wavelengths: [486, 588, 656]}",                        /*  3 */
    "limits: {steps: 100, flux: 0}",                                                   /*  4 */
    "media:",                                                                          /*  5 */
    "  air: {index: 1}",                                                               /*  6 */
    "  bk7: {glass: N-BK7}",                                                           /*  7 */
    "surfaces:",                                                                       /*  8 */
    "  polished: {type: fresnel}",                                                     /*  9 */
    "  black: {type: absorber}",                                                       /* 10 */
    "geometries:",                                                                     /* 11 */
    "  cap: {type: conic, radius: 50, aperture: 10}",                                  /* 12 */
    "  ball: {type: sphere, radius: 5}",                                               /* 13 */
    "  doublet:",                                                                      /* 14 */
    "    type: lens",                                                                  /* 15 */
    "    surfaces:",                                                                   /* 16 */
    "      - {radius: 50, thickness: 5, medium: bk7, aperture: 10}",                   /* 17 */
    "      - {radius: -50, medium: air, aperture: 10}",                                /* 18 */
    "objects:",                                                                        /* 19 */
    "  - {name: window, geometry: cap, surface: polished, front: air, back: bk7}",     /* 20 */
    "  - {name: bead, geometry: ball, at: [0, 0, 50], surface: black}",                /* 21 */
    "  - {name: lens, geometry: doublet, at: [0, 0, 90], outside: air}",               /* 22 */
    "sources:",                                                                        /* 23 */
    "  - {name: beam, type: collimated, shape: {disc: 3}, at: [0, 0, -9], flux: 1 W}", /* 24 */
    "detectors:",                                                                      /* 25 */
    "  - {name: screen, type: plane, size: [9, 9], cells: [3, 3], at: [0, 0, 99]}",    /* 26 */
    "simulations:",                                                                    /* 27 */
    "  - {name: quick, rays: 10, time_limit: 60 s, without: [bead]}",                  /* 28 */
};

enum { N_LINE = sizeof good / sizeof good[0] };

struct mistake {
    int line;
    const char *text;
    const char *told; /* lines of output, each after "s:" */
};

static const struct mistake mistakes[] = {
    /* the head of the file */
    {1, "raymap: 2",
     "1:9: error: version 2 of the scene format is newer than this program: it reads version 1\n"},
    {1, "raymap: one", "1:9: error: 'raymap' must be a finite number, not 'one'\n"},
    {2, "units: km", "2:8: error: unknown units 'km' (did you mean 'nm'?)\n"},
    {2, "unit: mm", "2:1: error: unknown key in a scene: 'unit' (did you mean 'units'?)\n"},
    {2, "units: [mm]", "2:8: error: 'units' must be a word\n"},
    {3, "spectrum: {mode: spektral}",
     "3:18: error: unknown mode 'spektral' (did you mean 'spectral'?)\n"},
    {3, "spectrum: {wavelengths: []}", "3:25: error: 'wavelengths' must not be empty\n"},
    {3, "spectrum: {wavelengths: [486, -5]}",
     "3:31: error: a wavelength must be greater than 0, not -5\n"},
    {3, "spectrum: {wavelengths: [486, 486]}",
     "3:25: error: a wavelength stands there twice: remove one\n"},
    {3, "spectrum: {wavelengths: {from: 400, to: 700}}",
     "3:25: error: 'step' is missing: add it\n"},
    {3, "spectrum: {wavelengths: {from: 400, to: 700, step: 1}}",
     "3:25: error: 301 wavelengths, but a scene has 128 at most: take a larger step\n"},
    {3, "spectrum: {wavelengths: {from: 700, to: 400, step: 1}}",
     "3:41: error: 'to' must not be below 'from'\n"},
    {4, "limits: {steps: 0}",
     "4:17: error: 'steps' must be a whole number from 1 to 4294967295, not 0\n"},
    {4, "limits: {steps: 1.5}",
     "4:17: error: 'steps' must be a whole number from 1 to 4294967295, not 1.5\n"},
    {4, "limits: {flux: -1}", "4:16: error: 'flux' must be 0 or greater, and below 1, not -1\n"},
    /* media */
    {6, "  air: {index: nan}", "6:16: error: 'index' must be a finite number, not 'nan'\n"},
    {6, "  air: {index: 1e999}", "6:16: error: 'index' must be a finite number, not '1e999'\n"},
    {6, "  air: {index: 0x1}", "6:16: error: 'index' must be a finite number, not '0x1'\n"},
    {6, "  air: {index: 0}",
     "6:16: error: 'index' must be a refractive index, 0.001 to 1000, not 0\n"},
    {6, "  air: {index: [1]}", "6:16: error: 'index' must be a number, not a list\n"},
    {6, "  air: {index: 1.5 mm}",
     "6:16: error: 'index' is a number without a unit: leave 'mm' out\n"},
    {12, "  cap: {type: conic, radius: 50 deg, aperture: 10}",
     "12:30: error: 'radius' has no unit 'deg'; those that fit: nm, um, mm, cm, m, in\n"},
    {12, "  cap: {type: conic, radius: 50, aperture: -1 cm}",
     "12:44: error: 'aperture' must be greater than 0, not -1 cm\n"},
    {21, "  - {name: bead, geometry: ball, surface: black, copies: {count: 3}}",
     "21:58: error: 'step' is missing: add it\n"},
    {21, "  - {name: bead, geometry: ball, surface: black, copies: {count: [3, 2], step: 4}}",
     "21:58: error: 'count' has 2 numbers, 'step' has 1: along x, y, z\n"},
    {21, "  - {name: bead, geometry: ball, surface: black, copies: {count: 2.5, step: 4}}",
     "21:58: error: 'count' must be whole numbers, for 1,000,000 copies at most\n"},
    {21, "  - {name: bead, geometry: ball, surface: blak, copies: {count: 3, step: 4}}",
     "21:43: error: unknown surface 'blak' (did you mean 'black'?)\n"},
    {21, "  - {name: bead, geometry: ball, surface: black, id: 7, copies: {count: 3, step: 4}}",
     "21:54: error: copies have ids of their own: leave 'id' out\n"},
    {21, "  - {name: bead, scale: [1, 2, 1], sources: [{name: bulb, type: point}]}",
     "21:46: error: source 'bulb' stands in a group that is stretched, and can only be made larger "
     "as a whole: give its group one number as 'scale'\n"},
    {21, "  - {name: bead, sources: [bulb]}",
     "21:28: error: a source must be a mapping, as in {name: lamp, ...}\n"},
    {13, "  ball: {type: box, size: [1, 2]}", "13:27: error: 'size' must be a list of 3 numbers\n"},
    {13, "  ball: {type: prism, sides: 2, radius: 1, length: 1}",
     "13:30: error: 'sides' must be a whole number from 3 to 1000, not 2\n"},
    {13, "  ball: {type: prism, length: 1}",
     "13:9: error: a prism has 'points', or 'sides' and 'radius' for a regular one\n"},
    {13, "  ball: {type: prism, points: [[0, 0], [4, 4], [4, 0], [0, 4]], length: 1}",
     "13:31: error: sides 1 and 3 of the polygon cross or touch: give its points in their order "
     "around it\n"},
    {13, "  ball: {type: prism, points: [[0, 0], [4, 4], [4]], length: 1}",
     "13:48: error: a point must be a list [x, y]\n"},
    {21, "  - {name: bead, geometry: ball, rotate: [0, 90 grad, 0], surface: black}",
     "21:46: error: 'rotate' has no unit 'grad'; those that fit: deg, rad, mrad\n"},
    {3, "spectrum: {wavelengths: [486, 588 THz]}",
     "3:31: error: a wavelength has no unit 'THz'; those that fit: nm, um, mm, cm, m, in\n"},
    {6, "  air: {index: 1, absorption: 3 mm}",
     "6:31: error: 'absorption' has no unit 'mm'; those that fit: /um, /mm, /cm, /m\n"},
    {10, "  black: {type: lambert, reflectance: 120 %}",
     "10:39: error: 'reflectance' must be between 0 and 1, not 120 %\n"},
    {6, "  air: 1", "6:8: error: a medium must be a mapping of keys and values\n"},
    {6, "  air: {}",
     "6:8: error: medium 'air' needs one of index, glass, sellmeier, table, gradient\n"},
    {6, "  air: {index: 1, glass: N-BK7}",
     "6:8: error: medium 'air' needs one of index, glass, sellmeier, table, gradient, not "
     "several\n"},
    {6, "  air: {index: 1, absorbtion: 1}",
     "6:19: error: unknown key in a medium: 'absorbtion' (did you mean 'absorption'?)\n"},
    {6, "  air: {index: 1, absorption: -1}",
     "6:31: error: 'absorption' must be 0 or greater, not -1\n"},
    {7, "  bk7: {glass: N-BK8}",
     "7:16: error: unknown glass 'N-BK8' (did you mean 'BK8', 'N-BK7'? raymap glass '*BK*' lists "
     "glasses)\n"},
    {7, "  bk7: {glass: E-F2}",
     "7:16: error: several glasses are called 'E-F2': write HOYA E-F2, HIKARI E-F2\n"},
    {7, "  bk7: {glass: 517642}",
     "7:16: error: unknown glass '517642' (raymap glass --near 1.517,64.2 lists what has this nd "
     "and vd)\n"},
    {7, "  bk7: {glass: LZOS K8, absorption: catalogue}",
     "7:37: error: the catalogue has no absorption of LZOS K8: give 'absorption' as numbers, or "
     "leave it out\n"},
    {7, "  bk7: {index: 1.5, absorption: catalogue}",
     "7:33: error: 'absorption: catalogue' is the absorption of a 'glass'\n"},
    {7, "  bk7: {sellmeier: {B: [1, 2], C: [1]}}", "7:20: error: B has 2 coefficients, C has 1\n"},
    {7, "  bk7: {sellmeier: {B: [-3], C: [0.01]}}",
     "7:20: error: medium 'bk7' has no real refractive index at 486 nm: check B and C (and "
     "wavelength_unit), or leave the wavelength out\n"},
    {7, "  bk7: {table: {wavelength: [500, 400], n: [1, 1]}}",
     "7:35: error: wavelengths must increase, but 400 follows 500\n"},
    {7, "  bk7: {table: {wavelength: [400, 700], n: [1.5]}}",
     "7:44: error: 'n' has 1 entries, 'wavelength' has 2\n"},
    {7, "  bk7: {table: {wavelength: [500, 600], n: [1.5, 1.4]}}",
     "7:16: warning: medium 'bk7' is known from 500 to 600 nm, the scene has light from 486 to "
     "656 nm: its ends stand for the rest\n"},
    {7, "  bk7: {glass: N-BK7}\n  bk7: {index: 1}",
     "8:3: error: duplicate key 'bk7' (first on line 7): remove or rename one\n"},
    {7, "  bk7: {<<: glass, index: 1.5}",
     "7:9: error: '<<' takes the keys of a mapping or of a list of mappings, as in <<: *base\n"},
    {7, "  bk7: {<<: {index: 1}, <<: {index: 2}}",
     "7:25: error: duplicate key '<<' (first on line 7): remove or rename one\n"
     "7:25: error: unknown key in a medium: '<<'; known: index, glass, sellmeier, table, gradient, "
     "wavelength_unit, absorption, scattering, scattering_g, species, accounting, "
     "scintillation\n"},
    {7, "  bk7: {<<: {absorbtion: 1}, index: 1.5}",
     "7:14: error: unknown key in a medium: 'absorbtion' (did you mean 'absorption'?)\n"},
    /* surfaces */
    {9, "  polished: {type: fresnell}",
     "9:20: error: unknown type 'fresnell' (did you mean 'fresnel'?)\n"},
    {9, "  polished: {coat: ideal}", "9:13: error: 'type' is missing: add it\n"},
    {9, "  polished: {type: fresnel, coat: {reflectance: 1.1}}",
     "9:49: error: 'reflectance' must be between 0 and 1, not 1.1\n"},
    {9, "  polished: {type: fresnel, reflectance: 1}",
     "9:29: error: unknown key in a fresnel surface: 'reflectance'; known: type, coat, scatter, "
     "contamination, frame\n"},
    {10, "  black: {type: lambert}", "10:10: error: 'reflectance' is missing: add it\n"},
    {10, "  black: {type: lambert, reflectance: {rgb: [1, 2, 0]}}",
     "10:49: error: 'rgb' must be between 0 and 1, not 2\n"},
    {10, "  black: {type: lambert, reflectance: {wavelength: [400], value: [0.1], x: 1}}",
     "10:73: error: unknown key in a table: 'x'; known: wavelength, value\n"},
    {10, "  black: {type: mixture, reflect_specular: 0.6, reflect_diffuse: 0.5}",
     "10:10: error: the shares of mixture 'black' sum to 1.1: more than 1 is no surface\n"},
    {10, "  black: {type: mirror, metal: CaF2}",
     "10:32: error: the catalogue has no k of crystal CaF2: a metal needs it\n"},
    {10, "  black: {type: mirror, metal: Sg}",
     "10:32: error: unknown metal 'Sg' (did you mean 'Si', 'Ag', 'Hg'? raymap glass '*Sg*' lists "
     "glasses)\n"},
    {10, "  black: {type: mirror, metal: {n: 1}}", "10:32: error: 'k' is missing: add it\n"},
    /* geometries */
    {12, "  cap: {type: conic, radius: 5, aperture: 10}", "12:8: error: this is no surface: %s\n"},
    {12, "  cap: {type: conic, radius: 50}", "12:8: error: 'aperture' is missing: add it\n"},
    {12, "  cap: {type: conic, radus: 50, aperture: 10}",
     "12:22: error: unknown key in a conic: 'radus' (did you mean 'radius'?)\n"},
    {12, "  cap: {type: conic, radius: 50, curvature: 1, aperture: 1}",
     "12:30: error: give 'radius' or 'curvature', not both\n"},
    {12, "  cap: {type: conic, asphere: {33: 1}, aperture: 1}",
     "12:32: error: a whole power from 1 to 32 must stand here, not '33'\n"},
    {12, "  cap: {type: conic, radius: 50, aperture: -1}",
     "12:44: error: 'aperture' must be greater than 0, not -1\n"},
    {13, "  ball: {type: sphere, radius: inf}",
     "13:32: error: 'radius' must be a finite number, not 'inf'\n"},
    {13, "  ball: {type: shpere, radius: 5}",
     "13:16: error: unknown type 'shpere' (did you mean 'sphere'?)\n"},
    {13, "  ball: {type: rectangle, size: [1, 2, 3]}",
     "13:33: error: 'size' must be a list of 1 to 2 numbers\n"},
    {13, "  ball: {type: mesh, file: nothing.stl}",
     "13:28: error: cannot open mesh ./nothing.stl: No such file or directory\n"},
    {13, "  ball: {type: mesh, file: nothing.doc}",
     "13:28: error: cannot read mesh ./nothing.doc: its name must end in .stl, .obj, .ply, .gltf "
     "or .glb\n"},
    {17, "      - {radius: 50, thickness: 5, medium: bk77, aperture: 10}",
     "17:44: error: unknown medium 'bk77' (did you mean 'bk7'?)\n"},
    {17, "      - {radius: 50, thickness: 5, medium: N-SK17, aperture: 10}",
     "17:44: error: unknown medium 'N-SK17' (did you mean 'N-SK10', 'N-SK11', 'N-SK14', 'N-SK15'? "
     "raymap glass '*SK*' lists glasses)\n"},
    {17, "      - {radius: 50, medium: bk7, aperture: 10}",
     "17:9: error: 'thickness' is missing: add it\n"},
    {17, "      - {radius: 50, thickness: 5, aperture: 10}",
     "17:9: error: 'medium' is missing: name the medium after the surface\n"},
    {17, "      - {radius: 50, thickness: -5, medium: bk7, aperture: 10}",
     "17:33: error: 'thickness' must be 0 or greater, not -5\n"},
    {17, "      - {radius: 50, thickness: 1, medium: bk7, aperture: 10}",
     "18:9: error: rows 1 and 2 cross at radius 10 (by 1.02041): make the thickness larger or an "
     "aperture smaller\n"},
    /* objects */
    {20, "  - {name: window, geometry: cup, surface: polished, front: air, back: bk7}",
     "20:30: error: unknown geometry 'cup' (did you mean 'cap'?)\n"},
    {20, "  - {name: window, geometry: cap, surface: polishd, front: air, back: bk7}",
     "20:44: error: unknown surface 'polishd' (did you mean 'polished'?)\n"},
    {20, "  - {name: window, geometry: cap, surface: polished, front: air}",
     "20:5: error: surface 'polished' of object 'window' lets light through: name the media on "
     "both sides, with 'inside' (or 'back')\n"},
    {20, "  - {name: window, geometry: cap, front: air, back: bk7}",
     "20:5: error: 'surface' is missing: name the surface of object 'window'\n"},
    {20, "  - {name: window, geometry: cap, surface: black, front: air, outside: air}",
     "20:72: error: give 'front' or 'outside', not both: they are the same side\n"},
    {20, "  - {geometry: cap, surface: black}", "20:5: error: 'name' is missing: add it\n"},
    {20, "  - {name: a*, geometry: cap, surface: black}",
     "20:12: error: 'a*' is no name: 1 to 200 characters, without * ? ' \" and without spaces at "
     "its ends\n"},
    {20, "  - {name: window, geometry: cap, surface: black, at: [0, 0]}",
     "20:55: error: 'at' must be a list of 3 numbers\n"},
    {20, "  - {name: window, geometry: cap, surface: black, at: [0, 0, .nan]}",
     "20:62: error: 'at' must be a finite number, not '.nan'\n"},
    {20, "  - {name: window, geometry: cap, surface: black, scale: 0}",
     "20:58: error: this transform is singular: it flattens its object; no scale may be 0\n"},
    {20, "  - {name: window, geometry: cap, surface: black, scale: 1e160}",
     "20:58: error: this transform is too small, too large or too far away to be inverted: scales "
     "must lie between 1e-100 and 1e100, positions below 1e150\n"},
    {20, "  - {name: window, geometry: cap, surface: black, scale: 1e-160}",
     "20:58: error: this transform is too small, too large or too far away to be inverted: scales "
     "must lie between 1e-100 and 1e100, positions below 1e150\n"},
    {20, "  - {name: window, geometry: cap, surface: black, scale: 1e99}",
     " error: object 'window' (line 20) reaches 1e+100 mm from the origin: all objects must fit in "
     "a "
     "sphere of 1e+15 mm; check its scale, its place and its size\n"},
    {20, "  - {name: window, geometry: cap, surface: black, matrix: [1,0,0,0,0,1,0,0,0,0,0,0]}",
     "20:59: error: this transform is singular: it flattens its object; the 3 x 3 part of the "
     "matrix must have an inverse\n"},
    {20, "  - {name: window, geometry: cap, surface: black, id: 7c1x}",
     "20:55: error: 'id' must be a whole number of 64 bits or up to 16 hexadecimal digits, not "
     "'7c1x'\n"},
    {21, "  - {name: window, geometry: ball, surface: black}",
     "21:5: error: the name 'window' is taken by the object on line 20: names are unique over "
     "objects, groups, sources and detectors\n"
     "28:57: error: unknown name in 'without': 'bead' (did you mean 'beam'?)\n"},
    {21, "  - {name: bead, objects: {name: x}}", "21:27: error: 'objects' must be a list\n"},
    {21, "  - bead",
     "21:5: error: an object must be a mapping, as in {name: lens, ...}\n"
     "28:57: error: unknown name in 'without': 'bead' (did you mean 'beam'?)\n"},
    {22, "  - {name: lens, geometry: doublet}",
     "22:5: error: 'outside' is missing: name the medium around lens 'lens'\n"},
    {22, "  - {name: lens, geometry: doublet, outside: air, inside: air}",
     "22:51: error: unknown key in an instance of a lens: 'inside' (did you mean 'outside'?)\n"},
    {22,
     "  - {name: lens, geometry: doublet, outside: air}\n"
     "  - {name: lens.2, geometry: ball, surface: black}",
     "23:5: error: the name 'lens.2' is taken by the object on line 22: names are unique over "
     "objects, groups, sources and detectors\n"},
    /* sources */
    {24, "  []", "24:3: error: no sources: a scene needs at least one\n"},
    {24, "  - {name: beam, type: colimated, shape: {disc: 3}}",
     "24:24: error: unknown type 'colimated' (did you mean 'collimated'?)\n"},
    {24, "  - {name: beam, type: collimated}",
     "24:5: error: 'shape' is missing: {disc: radius} or {rectangle: [width, height]}; or 'fills: "
     "NAME' of a lens\n"},
    {24, "  - {name: beam, type: collimated, fills: bead, at: [0, 0, 1]}",
     "24:53: error: give 'fills' or 'at', not both\n"},
    {24, "  - {name: beam, type: collimated, fills: beda}",
     "24:43: error: unknown object 'beda' (did you mean 'bead'?)\n"},
    {24, "  - {name: beam, type: collimated, shape: {disc: 3}, field: 3 deg}",
     "24:61: error: 'field' is the angle to the axis of what the source fills: give 'fills', the "
     "name of a lens or an object, too\n"},
    {24, "  - {name: beam, type: collimated, shape: {disc: 3}, flux: 1 kg}",
     "24:60: error: unknown unit of flux 'kg' (did you mean 'kW'?)\n"},
    {24, "  - {name: beam, type: collimated, shape: {disc: 3}, flux: -1 W}",
     "24:60: error: 'flux' must be greater than 0, not -1 W\n"},
    {24, "  - {name: beam, type: collimated, shape: {disc: 3}, flux: much}",
     "24:60: error: 'flux' must be a power, as in '1 W' or '800 lm', not 'much'\n"},
    {24, "  - {name: beam, type: collimated, shape: {disc: 3}, direction: [0, 0, 0]}",
     "24:65: error: 'direction' must not be zero\n"},
    {24, "  - {name: beam, type: collimated, shape: {disc: 3}, medium: are}",
     "24:62: error: unknown medium 'are' (did you mean 'air'?)\n"},
    {24, "  - {name: beam, type: collimated, shape: {disc: 3}, spectrum: {lines: {600: 1}}}",
     "24:73: warning: 600 nm is none of the scene's wavelengths: the nearest one, 588 nm, stands "
     "for it\n"},
    {24, "  - {name: beam, type: collimated, shape: {disc: 3}, spectrum: {lines: {700: 1}}}",
     "24:73: error: 700 nm lies outside the scene's wavelengths, 486 to 656 nm: add it to "
     "'wavelengths' of 'spectrum'\n"},
    {24, "  - {name: beam, type: collimated, shape: {disc: 3}, spectrum: {lines: {588: 0}}}",
     "24:64: error: source 'beam': the spectrum has no power on the scene's channels\n"},
    {24, "  - {name: beam, type: collimated, shape: {disc: 3}, spectrum: D66}",
     "24:64: error: unknown spectrum 'D66' (did you mean 'D65'?)\n"},
    {24, "  - {name: beam, type: point, distribution: {cone: 190}}",
     "24:52: error: 'cone' must be an angle greater than 0 and up to 180 degrees, not 190\n"},
    {24, "  - {name: beam, type: point, distribution: {table: {angle: [9, 5], value: [1, 2]}}}",
     "24:65: error: angles must increase, but 5 follows 9\n"},
    {24, "  - {name: beam, type: point, distribution: {table: {angle: [0, 5], value: [0, 0]}}}",
     "24:53: error: an intensity that is above 0 somewhere is wanted\n"},
    {24, "  - {name: beam, type: area, shape: {mesh: ball}}",
     "24:44: error: geometry 'ball' is no mesh: a source's shape is a disc, a rectangle or a "
     "mesh\n"},
    {24, "  - {name: beam, type: rays, rays: []}", "24:36: error: 'rays' must not be empty\n"},
    {24, "  - {name: beam, type: rays, rays: [{origin: [0, 0, 0]}]}",
     "24:37: error: 'direction' is missing: add it\n"},
    {24,
     "  - {name: beam, type: point, flux: 1 lm}\n"
     "  - {name: lamp, type: point, flux: 1 W}",
     "24:5: error: source 'beam' is given in lm, others in W: to turn lm into W its 'spectrum' "
     "must be given\n"},
    /* detectors */
    {26, "  - {name: screen, type: plane, size: [9, 0], cells: [3, 3]}",
     "26:43: error: 'size' must be greater than 0, not 0\n"},
    {26, "  - {name: screen, type: plane, cells: [3, 3]}",
     "26:5: error: 'size' is missing: add it\n"},
    {26, "  - {name: screen, type: plane, size: 9}", "26:5: error: 'cells' is missing: add it\n"},
    {26, "  - {name: screen, type: plane, size: 9, cells: [3, 70000]}",
     "26:53: error: 'cells' must be between 1 and 65535, not 70000\n"},
    {26, "  - {name: screen, type: plane, size: 9, cells: [20000, 20000]}",
     "26:49: error: 20000 x 20000 cells are too many: 67108864 at most\n"},
    {26, "  - {name: screen, type: plane, on: windo, size: 9, cells: 3}",
     "26:37: error: unknown object 'windo' (did you mean 'window'?)\n"},
    {26, "  - {name: screen, type: plane, on: beam, size: 9, cells: 3}",
     "26:37: error: 'beam' is no object or group\n"},
    {26, "  - {name: screen, type: plane, size: 9, cells: 3, side: frnt}",
     "26:58: error: unknown side 'frnt' (did you mean 'front'?)\n"},
    {26, "  - {name: screen, type: plane, size: 9, cells: 3, max_angle: 91}",
     "26:63: error: 'max_angle' must be an angle greater than 0 and up to 90 degrees, not 91\n"},
    {26, "  - {name: beam, type: intensity, cells: [3, 3]}",
     "26:5: error: the name 'beam' is taken by the source on line 24: names are unique over "
     "objects, groups, sources and detectors\n"},
    /* simulations */
    {28, "  - {name: quick, rays: 0}",
     "28:25: error: 'rays' must be a whole number from 1 to 9007199254740992, not 0\n"},
    {28, "  - {name: quick, time_limit: 60 d}",
     "28:31: error: 'time_limit' must be a time greater than 0, as in '60 s', '5 min' or '2 h', "
     "not '60 d'\n"},
    {28, "  - {name: quick, only: [lens.9]}",
     "28:26: error: unknown name in 'only': 'lens.9' (did you mean 'lens.1'?)\n"},
    {28, "  - {name: quick}\n  - {name: quick}",
     "29:12: error: the name 'quick' is taken by the simulation on line 28\n"},
    /* YAML itself */
    {28, "  - {name: quick",
     "29:1: error: this is not YAML: did not find expected ',' or '}' while parsing a flow "
     "mapping: what is opened in line 28, column 5 is not closed\n"},
    {28, "  - {name: &a quick, rays: *b}",
     "28:28: error: an alias refers to nothing that is complete before it\n"},
};

static char *compose(const struct mistake *mistake)
{
    char *text = NULL;
    size_t nbytes = 0;
    FILE *out = open_memstream(&text, &nbytes);
    for (int i = 0; i < N_LINE; i++)
        fprintf(out, "%s\n", mistake && mistake->line == i + 1 ? mistake->text : good[i]);
    (void)fclose(out);
    return text;
}

/* `told` with "s:" before each line; a "%s" in it stands for anything up to the line's end. */
static int is_told(const char *told, const char *expected)
{
    while (*expected) {
        if (strncmp(told, "s:", 2) != 0)
            return 0;
        told += 2;
        size_t len = strcspn(expected, "\n") + 1;
        const char *gap = strstr(expected, "%s");
        size_t same = gap && gap < expected + len ? (size_t)(gap - expected) : len;
        if (strncmp(told, expected, same) != 0)
            return 0;
        told += strcspn(told, "\n") + 1;
        expected += len;
    }
    return !*told;
}

static void test_good_scene_is_good(void **state)
{
    (void)state;
    char *text = compose(NULL), *told = NULL;
    struct rmap_scene *scene = read_text(text, &told);
    assert_string_equal(told, "");
    assert_non_null(scene);
    rmap_scene_destroy(scene);
    free(text);
    free(told);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_each_mistake_is_told(void **state)
{
    (void)state;
    int failures = 0;
    for (size_t i = 0; i < sizeof mistakes / sizeof mistakes[0]; i++) {
        char *text = compose(&mistakes[i]), *told = NULL;
        struct rmap_scene *scene = read_text(text, &told);
        if (!is_told(told, mistakes[i].told)) {
            printf("line %d: %s\n expected: %s told: %s\n", mistakes[i].line, mistakes[i].text,
                   mistakes[i].told, told);
            failures++;
        }
        rmap_scene_destroy(scene);
        free(text);
        free(told);
        assert_int_equal(rmap_alloc_live(), 0);
    }
    assert_int_equal(failures, 0);
}

static void test_all_mistakes_are_told_at_once(void **state)
{
    (void)state;
    char *told = NULL;
    struct rmap_scene *scene = read_text("raymap: 1\n"
                                         "unit: m\n"
                                         "media: {air: {index: -1}}\n"
                                         "objects:\n"
                                         "  - {name: a, geometry: none, surface: absorber}\n"
                                         "  - {name: a, geometry: none, surface: absorber}\n"
                                         "sources: [{name: s, type: point, flux: 1 Q}]\n",
                                         &told);
    assert_null(scene);
    int n = 0;
    for (const char *c = told; *c; c++)
        n += *c == '\n';
    assert_int_equal(n, 6);
    assert_non_null(strstr(told, "s:2:1: error: unknown key in a scene: 'unit'"));
    assert_non_null(strstr(told, "s:5:25: error: unknown geometry 'none': there are none here"));
    assert_non_null(strstr(told, "s:6:5: error: the name 'a' is taken"));
    free(told);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_good_scene_is_good),
        cmocka_unit_test(test_each_mistake_is_told),
        cmocka_unit_test(test_all_mistakes_are_told_at_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
