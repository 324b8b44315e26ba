/* SPDX-License-Identifier: MIT */
#ifdef RAYMAP_HAVE_ISAL

#define _DEFAULT_SOURCE /* MAP_ANONYMOUS */
#include "io/codec/igzip_stream.h"

#include <isa-l/igzip_lib.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/mman.h>

/* The hash is the CRC-32C instruction's, of which level 1 keeps the lowest 13 bits. */
#define HASH_MASK (IGZIP_LVL1_HASH_SIZE - 1)

/* Addresses in units of 64 KiB, in a part of the address space that neither programs, libraries,
 * stacks nor heaps are given: 35 to 44 TB. */
#define UNIT_SHIFT      16
#define UNIT_COUNT_BITS 27
#define FIRST_UNIT      UINT32_C(0x20000000)
#define UNITS           (UINT32_C(1) << UNIT_COUNT_BITS)

#define TRIES 64

static uint32_t crc32c(uint32_t value)
{
    for (int bit = 0; bit < 32; bit++)
        value = value >> 1 ^ (value & 1 ? UINT32_C(0x82F63B78) : 0);
    return value;
}

static void *map_at(uintptr_t wanted)
{
    void *block = mmap((void *)wanted, sizeof(struct isal_zstream), PROT_READ | PROT_WRITE,
                       MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return block != MAP_FAILED ? block : NULL;
}

/* Who asks from different places looks in different places first. */
static uint32_t first_guess(const void *owner)
{
    uint64_t mixed = (uint64_t)(uintptr_t)owner * UINT64_C(0x9E3779B97F4A7C15);
    return (uint32_t)(mixed >> 32) % UNITS;
}

/* The CRC is linear: another bit of the address changes it by that bit's own CRC. So units are
 * looked at in the order of a Gray code, one change each. */
struct isal_zstream *rmap_igzip_stream_create(const void *owner)
{
    uint32_t unit = FIRST_UNIT + first_guess(owner);
    uint32_t hash = crc32c(unit), change[UNIT_COUNT_BITS];
    for (int bit = 0; bit < UNIT_COUNT_BITS; bit++)
        change[bit] = crc32c(UINT32_C(1) << bit);
    for (uint32_t step = 1, tried = 0; step < UNITS && tried < TRIES; step++) {
        int bit = 0;
        while ((step >> bit & 1) == 0)
            bit++;
        unit ^= UINT32_C(1) << bit;
        hash ^= change[bit];
        if (hash & HASH_MASK)
            continue;
        uintptr_t wanted = (uintptr_t)unit << UNIT_SHIFT;
        void *block = map_at(wanted);
        if (!block || (uintptr_t)block == wanted)
            return block;
        (void)munmap(block, sizeof(struct isal_zstream)); /* taken */
        tried++;
    }
    return map_at(0);
}

void rmap_igzip_stream_destroy(struct isal_zstream *stream)
{
    if (stream)
        (void)munmap(stream, sizeof *stream);
}

#else
typedef int rmap_igzip_stream_is_absent; /* a file must hold something */
#endif
