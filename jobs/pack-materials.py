#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Packs optical materials of the refractiveindex.info database into one text file.

    jobs/pack-materials.py DATABASE.tar.gz > src/optics/materials.txt

The database: refractiveindex.info (M. N. Polyanskiy, Scientific Data 11, 94 (2024), doi:10.1038/s41597-023-02898-2),
CC0 1.0. Taken from it are all optical glasses of the makers below, with their internal absorption, and one
measurement each of common crystals, films, metals and plastics. Numbers stay as published. Makers publish internal transmittance to three decimals or so, of which
the database has made k; k is turned back into the shortest number that gives it again. Tables of more than 60 rows
keep those rows from which linear interpolation gives all others within THIN.
"""
import io
import math
import re
import sys
import tarfile
import unicodedata

# Maker, folders of its glasses. Their order is that of the file.
MAKERS = [
    ('SCHOTT', 'specs/schott/optical', 'specs/schott/obsolete', 'specs/schott/infrared', 'specs/schott/misc'),
    ('OHARA', 'specs/ohara/optical'),
    ('HOYA', 'specs/hoya/optical'),
    ('HIKARI', 'specs/hikari/optical', 'specs/hikari/CaF', 'specs/hikari/SiO2', 'specs/hikari/i-line'),
    ('CDGM', 'specs/cdgm/optical'),
    ('SUMITA', 'specs/sumita/optical'),
    ('LZOS', 'specs/lzos/optical'),
    ('VITRON', 'specs/vitron/infrared'),
]
LEFT_OUT = {'specs/schott/misc/DURAN'}  # one index, which is not its nd
SCHOTT = 'SCHOTT optical glass catalogue 2017, relative to air at 20 C, from refractiveindex.info (CC0)'
SILICA = 'Malitson 1965, doi:10.1364/JOSA.55.001205, fused silica, 20 C'

# Group, name, file, and what its source is called where the reference of the file is not to be it.
OTHERS = [
    ('crystal', 'Al2O3', 'main/Al2O3/nk/Malitson-o',
     'Malitson & Dodge 1972, synthetic sapphire, ordinary ray, 20 C, from refractiveindex.info (CC0)'),
    ('crystal', 'CaF2', 'main/CaF2/nk/Malitson', 'Malitson 1963, doi:10.1364/AO.2.001103, 24 C'),
    ('crystal', 'MgF2', 'main/MgF2/nk/Dodge-o', 'Dodge 1984, doi:10.1364/AO.23.001980, ordinary ray, 19 C'),
    ('crystal', 'SiO2', 'main/SiO2/nk/Malitson', SILICA),
    ('crystal', 'fused-silica', 'main/SiO2/nk/Malitson', SILICA),
    ('crystal', 'AgCl', 'main/AgCl/nk/Tilton'),
    ('crystal', 'BaF2', 'main/BaF2/nk/Malitson'),
    ('crystal', 'BBO', 'main/BaB2O4/nk/Eimerl-o'),
    ('crystal', 'calcite', 'main/CaCO3/nk/Ghosh-o'),
    ('crystal', 'CdTe', 'main/CdTe/nk/Marple'),
    ('crystal', 'CsBr', 'main/CsBr/nk/Li'),
    ('crystal', 'CsI', 'main/CsI/nk/Li'),
    ('crystal', 'diamond', 'main/C/nk/Peter'),
    ('crystal', 'GaAs', 'main/GaAs/nk/Skauli'),
    ('crystal', 'GaP', 'main/GaP/nk/Bond'),
    ('crystal', 'Ge', 'main/Ge/nk/Burnett'),
    ('crystal', 'ice', 'main/H2O/nk/Warren-2008'),
    ('crystal', 'KBr', 'main/KBr/nk/Li'),
    ('crystal', 'KCl', 'main/KCl/nk/Li'),
    ('crystal', 'KDP', 'main/KH2PO4/nk/Zernike-o'),
    ('crystal', 'LaF3', 'main/LaF3/nk/Laihoa-o'),
    ('crystal', 'LiF', 'main/LiF/nk/Li'),
    ('crystal', 'LiNbO3', 'main/LiNbO3/nk/Zelmon-o'),
    ('crystal', 'MgO', 'main/MgO/nk/Stephens'),
    ('crystal', 'NaCl', 'main/NaCl/nk/Li'),
    ('crystal', 'NaF', 'main/NaF/nk/Li'),
    ('crystal', 'quartz', 'main/SiO2/nk/Ghosh-o'),
    ('crystal', 'Si', 'main/Si/nk/Salzberg'),
    ('crystal', 'spinel', 'main/MgAl2O4/nk/Tropf'),
    ('crystal', 'SrF2', 'main/SrF2/nk/Li'),
    ('crystal', 'SrTiO3', 'main/SrTiO3/nk/Bond'),
    ('crystal', 'TeO2', 'main/TeO2/nk/Uchida-o'),
    ('crystal', 'YAG', 'main/Y3Al5O12/nk/Zelmon'),
    ('crystal', 'YVO4', 'main/YVO4/nk/Shi-o-20C'),
    ('crystal', 'ZnS', 'main/ZnS/nk/Debenham'),
    ('crystal', 'ZnSe', 'main/ZnSe/nk/Connolly'),
    ('other', 'soda-lime', 'glass/misc/soda-lime/nk/Rubin-clear'),
    ('other', 'water', 'main/H2O/nk/Daimon-20.0C'),
    ('other', 'ZBLAN', 'glass/misc/ZBLAN/nk/Gan'),
    ('plastic', 'NAS-21', 'other/commercial polymers/NAS-21/nk/Sultanova'),
    ('plastic', 'Optorez1330', 'other/commercial polymers/Optorez1330/nk/Sultanova'),
    ('plastic', 'PC', 'organic/(C16H14O3)n - polycarbonate/nk/Sultanova'),
    ('plastic', 'PMMA', 'organic/(C5H8O2)n - poly(methyl methacrylate)/nk/Sultanova'),
    ('plastic', 'PS', 'organic/(C8H8)n - polystyrene/nk/Sultanova'),
    ('plastic', 'ZeonexE48R', 'other/commercial polymers/ZeonexE48R/nk/Sultanova'),
    ('film', 'AlN', 'main/AlN/nk/Pastrnak-o'),
    ('film', 'HfO2', 'main/HfO2/nk/Al-Kuhaili'),
    ('film', 'Nb2O5', 'main/Nb2O5/nk/Lemarchand'),
    ('film', 'Sc2O3', 'main/Sc2O3/nk/Belosludtsev'),
    ('film', 'Si3N4', 'main/Si3N4/nk/Luke'),
    ('film', 'SiO', 'main/SiO/nk/Hass'),
    ('film', 'Ta2O5', 'main/Ta2O5/nk/Gao'),
    ('film', 'TiO2', 'main/TiO2/nk/Siefke'),
    ('film', 'Y2O3', 'main/Y2O3/nk/Nigara'),
    ('film', 'ZnO', 'main/ZnO/nk/Bond-o'),
    ('metal', 'Ag', 'main/Ag/nk/Johnson'),
    ('metal', 'Al', 'main/Al/nk/Rakic'),
    ('metal', 'Au', 'main/Au/nk/Johnson'),
    ('metal', 'Be', 'main/Be/nk/Rakic-BB'),
    ('metal', 'Co', 'main/Co/nk/Johnson'),
    ('metal', 'Cr', 'main/Cr/nk/Johnson'),
    ('metal', 'Cu', 'main/Cu/nk/Johnson'),
    ('metal', 'Fe', 'main/Fe/nk/Johnson'),
    ('metal', 'Hg', 'main/Hg/nk/Inagaki'),
    ('metal', 'Mn', 'main/Mn/nk/Johnson'),
    ('metal', 'Mo', 'main/Mo/nk/Werner'),
    ('metal', 'Ni', 'main/Ni/nk/Johnson'),
    ('metal', 'Pd', 'main/Pd/nk/Johnson'),
    ('metal', 'Pt', 'main/Pt/nk/Werner'),
    ('metal', 'Rh', 'main/Rh/nk/Weaver'),
    ('metal', 'Ta', 'main/Ta/nk/Werner'),
    ('metal', 'Ti', 'main/Ti/nk/Johnson'),
    ('metal', 'V', 'main/V/nk/Johnson'),
    ('metal', 'W', 'main/W/nk/Werner'),
    ('metal', 'Zn', 'main/Zn/nk/Werner'),
]

PLAIN = {0x2013: '-', 0xb5: 'u', 0x3bc: 'u'}  # dash, micro, mu
WINDOW_UM = 0.15, 30.0   # of tables that are thinned
THIN_N, THIN_K = 5e-4, 2e-2  # relative
NO_K = {2: 3e-9, 3: 1e-6}    # too little to matter, of transparent materials and of films and metals

HEAD = """\
# Optical materials, packed by jobs/pack-materials.py from the refractiveindex.info database (M. N. Polyanskiy,
# Scientific Data 11, 94 (2024), doi:10.1038/s41597-023-02898-2; CC0 1.0). Numbers are as published.
#
#   group NAME       of the materials that follow: a maker, or a kind of material
#   source TEXT      of the materials that follow
#   at L ...         wavelengths (um) of the internal transmittances that follow
#   NAME nd vd from to FORMULA c ... [t MM T ...] [k L k ...]
#
# nd, vd: as published (- where they are not); from, to: um. FORMULA: 1 to 5, the database's numbers (src/optics/glass.h
# has the equations) with their coefficients, L in um; n: a table L n ...; nk: a table L n k ...
# t: internal transmittance of MM millimetres at the wavelengths of `at` (- where it is not published); k: extinction.
"""


def read(text):
    """{'formula': (number, range, coefficients), 'n', 'k', 'nk': rows of words}"""
    out = {}
    for block in re.split(r'^  - type: ', text[text.index('\nDATA:'):], flags=re.M)[1:]:
        kind = block.split('\n')[0].split()
        if kind[0] == 'formula' and kind[1].isdigit():
            out['formula'] = (kind[1], re.search(r'wavelength_range: (.*)', block)[1].split(),
                              re.search(r'coefficients: (.*)', block)[1].split())
        elif kind[0] == 'tabulated':
            rows = re.search(r'data: \|\n((?:        .*\n?)*)', block)[1]
            out[kind[1]] = sorted((row.split() for row in rows.splitlines()), key=lambda row: float(row[0]))
    return out


def reference(text):
    lines = re.search(r'^REFERENCES: (?:\|\n)?(.*?)(?=^[A-Z]+:)', text, flags=re.M | re.S)[1]
    doi = re.search(r'doi\.org/([^"\s]+)"', lines)
    line = re.split(r'<br>|\n\s*\n', lines.strip())[0]
    line = ' '.join(re.sub(r'<[^>]+>', '', re.sub(r'<su[bp]>', '', line)).split())
    line = re.sub(r'^1\) ?|\(obtained from.*|Data kindly provided by ', '', line).strip(' .')
    line = ''.join(c for c in unicodedata.normalize('NFKD', line.translate(PLAIN)) if ord(c) < 128)
    return line + (', doi:' + doi[1] if doi else '')


def number(word):
    """The same number in as few characters as it needs."""
    short = re.sub(r'e([-+])0*', r'e\1', repr(float(word))).replace('e+', 'e')
    return re.sub(r'^(-?)0\.', r'\1.', re.sub(r'\.0(?=$|e)', '', short)) if float(word) else '0'


def transmittances(rows, thickness_mm):
    """Shortest words that give k again to its printed digits; None where there are none."""
    words = []
    for um, k in rows:
        exact = math.exp(-4 * math.pi * float(k) * thickness_mm * 1e3 / float(um))
        if float(k) <= 0:  # catalogues for Zemax have 1 where nothing was measured; more is a misprint
            words.append('-')
            continue
        for digits in range(1, 9):
            word = '%.*f' % (digits, exact) if exact > 1e-3 else '%.*e' % (digits - 1, exact)
            if 0 < float(word) < 1 and '%.4E' % (-math.log(float(word)) * float(um) / (4e3 * math.pi * thickness_mm)) == k:
                words.append(number(word))
                break
        else:
            return None
    return words


def thin(rows):
    """The rows that linear interpolation needs."""
    value = [[float(word) for word in row] for row in rows]
    kept = [i for i, row in enumerate(value) if WINDOW_UM[0] <= row[0] <= WINDOW_UM[1]]
    if len(rows) <= 60:
        return rows

    def worst(first, last):
        a, b, at, most = value[first], value[last], None, 1.0
        for i in range(first + 1, last):
            t = (value[i][0] - a[0]) / (b[0] - a[0])
            off = [abs(a[c] + t * (b[c] - a[c]) - value[i][c]) for c in range(1, len(a))]
            k = value[i][-1]
            error = off[-1] / (THIN_K * k + NO_K[len(a)])
            if len(a) == 3:
                error = max(off[0] / (THIN_N * math.hypot(value[i][1], k)),
                            off[1] / (max(THIN_K * k, THIN_N * value[i][1] * (k > 1)) + NO_K[3]))
            if error > most:
                at, most = i, error
        return at

    chosen, todo = {kept[0], kept[-1]}, [(kept[0], kept[-1])]
    while todo:
        first, last = todo.pop()
        at = worst(first, last)
        if at is not None:
            chosen.add(at)
            todo += [(first, at), (at, last)]
    return [rows[i] for i in sorted(chosen)]


def published(text, key):
    found = re.search(r'^    %s: (\S+)' % key, text, flags=re.M)
    return number(found[1]) if found else '-'


def line(name, text, grid):
    data = read(text)
    if 'formula' in data:
        formula, span, coefficients = data['formula']
        words = [formula] + [number(c) for c in coefficients]
    else:
        kind = 'nk' if 'nk' in data else 'n'
        rows = thin(data[kind]) if kind == 'nk' else data[kind]
        span = rows[0][0], rows[-1][0]
        words = [kind] + [number(word) for row in rows for word in row]
    words = [name, published(text, 'nd'), published(text, 'Vd'), number(span[0]), number(span[1])] + words
    if not any(float(k) > 0 for _, k in data.get('k', [])):
        return ' '.join(words)
    tries = [(thickness, transmittances(data['k'], thickness)) for thickness in (10, 25, 5, 1)] if grid else []
    tries = [(sum(map(len, found)), thickness, found) for thickness, found in tries
             if found and sum(map(len, found)) < 5 * len(found)]
    if tries:
        _, thickness, found = min(tries)
        at = {number(row[0]): word for row, word in zip(data['k'], found)}
        column = [at.get(um, '-') for um in grid]
        while column[-1] == '-':
            column.pop()
        words += ['t', '%d' % thickness] + column
    else:
        words += ['k'] + [number(word) for row in thin(data['k']) for word in row]
    return ' '.join(words)


def source_of(text, folder):
    celsius = re.search(r'^    temperature: (\d+)$', text, flags=re.M)
    if folder == 'specs/schott/optical':
        return SCHOTT
    air = ', relative to air at %d C' % (int(celsius[1]) - 273) if celsius else ''
    return reference(text).replace('catalog ', 'catalogue ') + air + ', from refractiveindex.info (CC0)'


def main(path):
    with tarfile.open(path) as tar:
        files = {member.name[len('database/data/'):-len('.yml')]: tar.extractfile(member).read().decode()
                 for member in tar if member.name.startswith('database/data/') and member.name.endswith('.yml')}
    out = io.StringIO()
    out.write(HEAD)
    for maker, *folders in MAKERS:
        texts = {}
        for folder in folders:
            for name in files:
                if name.rpartition('/')[0] == folder and name not in LEFT_OUT:
                    texts[name] = source_of(files[name], folder)
        grid = sorted({number(row[0]) for name in texts for row in read(files[name]).get('k', [])
                       if not name.startswith('specs/schott/misc')}, key=float)
        out.write('group %s\n' % maker)
        if grid:
            out.write('at %s\n' % ' '.join(grid))
        last = None
        for name in sorted(texts, key=lambda name: (texts[name] != SCHOTT, texts[name], name)):
            if texts[name] != last:
                last = texts[name]
                out.write('source %s\n' % last)
            in_grid = not name.startswith('specs/schott/misc')
            out.write(line(name.rpartition('/')[2].replace(' ', '-'), files[name], grid if in_grid else None) + '\n')
    last = last_source = None
    for group, name, file, *source in OTHERS:
        if group != last:
            last = group
            out.write('group %s\n' % group)
        said = source[0] if source else reference(files[file]) + ', from refractiveindex.info (CC0)'
        if said != last_source:
            last_source = said
            out.write('source %s\n' % said)
        out.write(line(name, files[file], None) + '\n')
    sys.stdout.write(out.getvalue())


if __name__ == '__main__':
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
