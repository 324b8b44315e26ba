# SPDX-License-Identifier: MIT
"""XXH3-64 of 16 bytes, seed 0, as its specification says: what --sample orders rays by."""
import struct

MASK = (1 << 64) - 1
# Bytes 24 to 55 of the algorithm's secret.
SECRET = struct.unpack("<4Q", bytes.fromhex("7240a4a4b7b3671fcb79e64eccc0e578825ad07dccff7221b8084674f743248e"))


def xxh3_64(low, high):
    low ^= SECRET[0] ^ SECRET[1]
    high ^= SECRET[2] ^ SECRET[3]
    product = low * high
    swapped = int.from_bytes(low.to_bytes(8, "little"), "big")
    h = 16 + swapped + high + ((product & MASK) ^ (product >> 64)) & MASK
    h = (h ^ (h >> 37)) * 0x165667919E3779F9 & MASK
    return h ^ (h >> 32)


def sample(ids, n, seed):
    """The n ids with the smallest hash of (seed, id), ascending."""
    return sorted(sorted(ids, key=lambda ray: xxh3_64(seed, ray))[:n])
