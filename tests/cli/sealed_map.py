# SPDX-License-Identifier: MIT
"""A map's tables changed by h5py, their checksums and seals made right again: what a stranger could
write who knows the format, or a program of somebody else's that writes maps (docs/map.md)."""
import ctypes
import ctypes.util
import struct
import sys

try:
    import h5py
    import numpy as np
    _XXH3 = ctypes.CDLL(ctypes.util.find_library("xxhash") or "libxxhash.so.0").XXH3_64bits
except (ImportError, OSError) as missing:
    print(f"{missing}: not here")
    sys.exit(77)
_XXH3.restype, _XXH3.argtypes = ctypes.c_uint64, [ctypes.c_char_p, ctypes.c_size_t]


def checksum(data):
    return _XXH3(bytes(data), len(data))


def edit(path, change):
    """change(h5py.File) on a sealed file, which is sealed again. Chunked datasets stay as they are."""
    with open(path, "rb") as file:
        data = file.read()
    assert data[-8:] == b"rmapseal", path
    (n,) = struct.unpack("<Q", data[-32:-24])
    end = len(data) - 32 - 16 * n
    ranges = data[end:-32]
    with open(path, "wb") as file:
        file.write(data[:end])
    with h5py.File(path, "r+") as file:
        change(file)
    with open(path, "rb") as file:
        data, rest, at = file.read(), b"", 0
    for offset, nbytes in struct.iter_unpack("<QQ", ranges):
        rest, at = rest + data[at:offset], offset + nbytes
    own = ranges + struct.pack("<QQ", n, checksum(rest + data[at:]))
    with open(path, "ab") as file:
        file.write(own + struct.pack("<Q", checksum(own)) + b"rmapseal")


def put(dataset, row, value):
    """One element of a dataset, counted flat, or all (row None)."""
    data = np.asarray(dataset[()]).reshape(-1).copy()
    data[slice(None) if row is None else row] = value
    dataset[...] = data.reshape(dataset.shape)
    dataset.attrs.modify("checksum", np.uint64(checksum(data.tobytes())))
