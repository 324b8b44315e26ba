# SPDX-License-Identifier: MIT
"""Writers and a reader of files of rays, from the formats' descriptions alone (numpy, h5py, struct): rays are arrays of
position (mm), direction, power, wavelength (nm), time (ns), event."""
import ctypes
import os
import pathlib
import struct

import h5py
import numpy as np

NAN = float("nan")
PLAIN = [1, 1, 1, 0, 0, 0, 0, 0]


def tm25(path, position, direction, power=None, flags=None, more=(), spectrum=0, nm=NAN, tables=(), flux=(NAN, NAN), names=(), text=b""):
    """flags: position, direction, radiant, wavelength, luminous, Stokes, tristimulus, index; more: columns behind the sixth in order."""
    flags = flags or PLAIN
    columns = [*np.asarray(position).T, *np.asarray(direction).T, *([power] if power is not None else []), *more]
    rows = np.array(columns, dtype="<f4").T
    head = struct.pack("<4siiffQ28siifffiii168x", b"TM25", 2013, 0, *flux, len(rows), b"2026-11-29T07:00:00+00:00", 0, spectrum,
                       nm, NAN, NAN, len(tables), len(names), len(text))
    blocks = b"".join(word.encode("utf-32-le").ljust(4000, b"\0") for word in ("Test lamp", "", "", "", "", "", "", "", ""))
    spectra = b"".join(struct.pack("<i", len(table)) + np.array(table, dtype="<f4").tobytes() for table in tables)
    spectra += bytes(-len(spectra) % 32)
    head += struct.pack("<8i", *flags) + blocks + spectra + b"".join(word.encode("utf-32-le").ljust(512, b"\0") for word in names)
    pathlib.Path(path).write_bytes(head + text + rows.tobytes())
    return path


def read_tm25(path):
    """Head fields, names of further columns, rows."""
    raw = pathlib.Path(path).read_bytes()
    magic, version, _, lm, watt, n, date, _, spectrum, nm, _, _, tables, more, text = struct.unpack("<4siiffQ28siifffiii", raw[:88])
    assert magic == b"TM25" and version == 2013 and tables == 0
    flags = struct.unpack("<8i", raw[256:288])
    at = 288 + 36000
    names = [raw[at + 512 * k:at + 512 * (k + 1)].decode("utf-32-le").rstrip("\0") for k in range(more)]
    at += 512 * more + text
    width = 6 + flags[2] + flags[3] + flags[4] + more
    assert len(raw) == at + 4 * width * n, (len(raw), at, width, n)
    return ({"lm": lm, "W": watt, "spectrum": spectrum, "nm": nm, "flags": flags, "date": date}, names,
            np.frombuffer(raw[at:], "<f4").reshape(n, width))


def lighttools(path, position, direction, power, unit="millimeters", data="radiant_flux", flux="1"):
    lines = ["# Test", "lt_rdf_version: 2.0", f"lt_datatype: {data}", "lt_far_field_data: no", "lt_color_info: none",
             f"lt_length_units: {unit}", "lt_data_origin:  0  0  0", f"lt_radiant_flux: {flux}", "lt_startofdata"]
    lines += [" ".join(f"{x:.9e}" for x in row) for row in np.column_stack([position, direction, power])]
    pathlib.Path(path).write_text("\n".join([*lines, "lt_endofdata"]), encoding="ascii")
    return path


def csv(path, head, *columns):
    rows = "\n".join(",".join(repr(float(x)) for x in row) for row in np.column_stack(columns))
    pathlib.Path(path).write_text(f"# rays\n{head}\n{rows}\n", encoding="ascii")
    return path


def hdf5(path, datasets):
    """{name: (numbers, unit)}"""
    with h5py.File(path, "w") as file:
        for name, (numbers, unit) in datasets.items():
            file[name] = numbers
            if unit:
                file[name].attrs["units"] = unit
    return path


class Particle(ctypes.Structure):
    """mcpl_particle_t of mcpl.h, packed: MeV, cm, ms."""
    _pack_ = 1
    _fields_ = [("ekin", ctypes.c_double), ("polarisation", 3 * ctypes.c_double), ("position", 3 * ctypes.c_double),
                ("direction", 3 * ctypes.c_double), ("time", ctypes.c_double), ("weight", ctypes.c_double), ("code", ctypes.c_int32),
                ("flags", ctypes.c_uint32)]


def mcpl_library():
    """MCPL's own library (Debian: libmcpl1), or None."""
    try:
        library = ctypes.CDLL(os.environ.get("RAYMAP_TEST_MCPL", "libmcpl.so.1"))
    except OSError:
        return None
    for name in "create_outfile", "open_file", "read":
        getattr(library, "mcpl_" + name).restype = ctypes.c_void_p
    return library


def mcpl_by_library(library, path, position, direction, nm, time_ns, weight, flags, double):
    out = ctypes.c_void_p(library.mcpl_create_outfile(str(path).encode()))
    library.mcpl_enable_userflags(out)
    if double:
        library.mcpl_enable_doubleprec(out)
    for p, d, wave, t, w, f in zip(position, direction, nm, time_ns, weight, flags):
        one = Particle(1239.841984332e-6 / wave, (0, 0, 0), tuple(p / 10), tuple(d), t * 1e-6, w, 22, int(f))
        library.mcpl_add_particle(out, ctypes.byref(one))
    library.mcpl_close_outfile(out)
    return path


def mcpl_read(library, path):
    """Position (mm), direction, wavelength, time (ns), weight, flags of every photon, by MCPL's library."""
    file, rows = ctypes.c_void_p(library.mcpl_open_file(str(path).encode())), []
    while at := library.mcpl_read(file):
        one = Particle.from_address(at)
        assert one.code == 22
        rows.append([*one.position, *one.direction, one.ekin, one.time, one.weight, one.flags])
    library.mcpl_close_file(file)
    rows = np.array(rows)
    return 10 * rows[:, :3], rows[:, 3:6], 1239.841984332e-6 / rows[:, 6], 1e6 * rows[:, 7], rows[:, 8], rows[:, 9]


def mcpl(path, position, direction, nm, time_ns, weight=None, flags=None, single=False, codes=None, polarised=False, version=3):
    """polarised: a flag, or the vectors. Version 2: directions on an octahedron, of which z = 0 is told by the energy's sign. 3: directions by adaptive projection, positions in cm, energies in MeV, times in ms."""
    number = "<f4" if single else "<f8"
    d = np.asarray(direction, float)
    a, b, c = np.abs(d).T
    first = (a > b) & (a > c)
    second = ~first & (b > c)
    third = ~first & ~second
    with np.errstate(divide="ignore"):
        inverse = 1 / d[:, 2]
    packed = np.select([first, second, third], [inverse, d[:, 0], d[:, 0]]), np.select([first, second, third], [d[:, 1], inverse, d[:, 1]])
    sign = np.select([first, second, third], [d[:, 0], d[:, 1], d[:, 2]])
    energy = np.copysign(1239.841984332e-6 / np.asarray(nm, float), sign)
    if version == 2:
        x, y, z = (d / np.abs(d).sum(1)[:, None]).T
        packed = np.where(z < 0, (1 - np.abs(y)) * np.where(x < 0, -1, 1), x), np.where(z < 0, (1 - np.abs(x)) * np.where(y < 0, -1, 1), y)
        energy = np.where(z == 0, -1, 1) * np.abs(energy)
    fields = ([("p", number, 3)] if np.any(polarised) else []) + [("x", number, 3), ("u", number, 2), ("e", number), ("t", number)]
    fields += [("w", number)] if weight is not None else []
    fields += [("c", "<i4")] if codes is not None else []
    fields += [("f", "<u4")] if flags is not None else []
    rows = np.zeros(len(d), dtype=fields)
    rows["x"], rows["u"], rows["e"], rows["t"] = np.asarray(position) / 10, np.column_stack(packed), energy, np.asarray(time_ns) * 1e-6
    if np.ndim(polarised) > 0:
        rows["p"] = polarised
    if weight is not None:
        rows["w"] = weight
    if codes is not None:
        rows["c"] = codes
    if flags is not None:
        rows["f"] = flags
    head = struct.pack("<8sQ2I3IiII", b"MCPL00%dL" % version, len(d), 1, 1, flags is not None, np.any(polarised), single, 0 if codes is not None else 22,
                       rows.dtype.itemsize, weight is None)
    head += struct.pack("<d", 1.0) if weight is None else b""
    for word in (b"test", b"a remark", b"name", b"data"):
        head += struct.pack("<I", len(word)) + word
    pathlib.Path(path).write_bytes(head + rows.tobytes())
    return path
