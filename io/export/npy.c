/* SPDX-License-Identifier: MIT
 *
 * Arrays of doubles for NumPy: one as .npy, several with their names as .npz (the format's version
 * 1.0, numpy.org/doc/stable/reference/generated/numpy.lib.format.html; .npz is a ZIP archive of
 * them, stored: APPNOTE.TXT 6.3.3).
 */
#include "io/export/npy.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <zlib.h>

#include "io/file/whole_file.h"

/* Magic, version, length and text of the header: a multiple of 64, data aligned behind it. */
enum { HEADER_NBYTES = 256, PREFIX_NBYTES = 10 };

static size_t count_of(const struct rmap_npy_array *array)
{
    size_t n = 1;
    for (int i = 0; i < array->rank; i++)
        n *= array->dims[i];
    return n;
}

static void make_header(const struct rmap_npy_array *array, uint8_t header[HEADER_NBYTES])
{
    char text[HEADER_NBYTES];
    int n = snprintf(text, sizeof text, "{'descr': '<f8', 'fortran_order': False, 'shape': (");
    for (int i = 0; i < array->rank && n > 0 && (size_t)n < sizeof text; i++)
        n += snprintf(text + n, sizeof text - (size_t)n, "%zu%s", array->dims[i],
                      i + 1 < array->rank ? ", "
                      : array->rank == 1  ? ","
                                          : "");
    n += snprintf(text + n, sizeof text - (size_t)n, "), }");
    memset(header, ' ', HEADER_NBYTES);
    memcpy(header, "\x93NUMPY\x01\x00", 8);
    header[8] = (HEADER_NBYTES - PREFIX_NBYTES) & 0xff;
    header[9] = (HEADER_NBYTES - PREFIX_NBYTES) >> 8;
    memcpy(header + PREFIX_NBYTES, text, (size_t)n);
    header[HEADER_NBYTES - 1] = '\n';
}

enum rmap_status rmap_npy_write(const struct rmap_npy_array *array, const char *path,
                                struct rmap_error *err)
{
    struct rmap_whole_file whole = {0};
    uint8_t header[HEADER_NBYTES];
    enum rmap_status st = rmap_whole_file_open(&whole, path, err);
    if (st == RMAP_OK) {
        make_header(array, header);
        (void)fwrite(header, 1, sizeof header, whole.file);
        (void)fwrite(array->data, sizeof *array->data, count_of(array), whole.file);
        st = rmap_whole_file_finish(&whole, err);
    }
    rmap_whole_file_fini(&whole);
    return st;
}

/* ---- archives ---- */

static uint8_t *put(uint8_t *at, uint32_t value, int nbytes)
{
    for (int i = 0; i < nbytes; i++)
        *at++ = (uint8_t)(value >> (8 * i));
    return at;
}

struct member {
    char name[80];
    uint32_t crc, nbytes, offset;
};

/* Fields that a member's own head and its entry in the directory share. */
static uint8_t *put_member(uint8_t *at, const struct member *member)
{
    at = put(at, 20, 2);   /* version needed */
    at = put(at, 0, 2);    /* flags */
    at = put(at, 0, 2);    /* stored */
    at = put(at, 0, 2);    /* time */
    at = put(at, 0x21, 2); /* 1 January 1980: the same bytes every day */
    at = put(at, member->crc, 4);
    at = put(at, member->nbytes, 4);
    at = put(at, member->nbytes, 4);
    at = put(at, (uint32_t)strlen(member->name), 2);
    return put(at, 0, 2); /* extra */
}

static void write_member(FILE *file, const struct rmap_npy_array *array, uint32_t offset,
                         struct member *member)
{
    uint8_t header[HEADER_NBYTES], head[30];
    const size_t nbytes = count_of(array) * sizeof *array->data;
    make_header(array, header);
    (void)snprintf(member->name, sizeof member->name, "%.70s.npy", array->name);
    member->crc =
        (uint32_t)crc32_z(crc32_z(0, header, sizeof header), (const void *)array->data, nbytes);
    member->nbytes = (uint32_t)(nbytes + sizeof header);
    member->offset = offset;
    (void)put_member(put(head, 0x04034b50, 4), member);
    (void)fwrite(head, 1, sizeof head, file);
    (void)fwrite(member->name, 1, strlen(member->name), file);
    (void)fwrite(header, 1, sizeof header, file);
    (void)fwrite(array->data, 1, nbytes, file);
}

static uint32_t write_entry(FILE *file, const struct member *member)
{
    uint8_t entry[46], *at = put(put(entry, 0x02014b50, 4), 20, 2);
    at = put_member(at, member);
    at = put(at, 0, 2); /* comment */
    at = put(at, 0, 2); /* disk */
    at = put(at, 0, 2); /* internal attributes */
    at = put(at, 0, 4); /* external attributes */
    (void)put(at, member->offset, 4);
    (void)fwrite(entry, 1, sizeof entry, file);
    (void)fwrite(member->name, 1, strlen(member->name), file);
    return (uint32_t)(sizeof entry + strlen(member->name));
}

enum rmap_status rmap_npz_write(const struct rmap_npy_array *array, size_t n, const char *path,
                                struct rmap_error *err)
{
    enum { MEMBERS_MAX = 32 };
    struct member member[MEMBERS_MAX];
    struct rmap_whole_file whole = {0};
    uint64_t nbytes = 0;
    uint32_t at = 0, directory = 0;
    uint8_t end[22] = {0};
    for (size_t i = 0; i < n; i++)
        nbytes += count_of(&array[i]) * sizeof *array[i].data + 1024;
    if (n > MEMBERS_MAX || nbytes > UINT32_MAX)
        return rmap_error_set(err, RMAP_USAGE,
                              "'%s': an archive holds %d arrays and 4 GB; these are %zu and %.1f",
                              path, MEMBERS_MAX, n, 1e-9 * (double)nbytes);
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_whole_file_open(&whole, path, err));
    for (size_t i = 0; i < n; i++) {
        write_member(whole.file, &array[i], at, &member[i]);
        at += 30 + (uint32_t)strlen(member[i].name) + member[i].nbytes;
    }
    for (size_t i = 0; i < n; i++)
        directory += write_entry(whole.file, &member[i]);
    uint8_t *tail = put(put(end, 0x06054b50, 4), 0, 4);
    tail = put(put(tail, (uint32_t)n, 2), (uint32_t)n, 2);
    (void)put(put(tail, directory, 4), at, 4);
    (void)fwrite(end, 1, sizeof end, whole.file);
    st = rmap_whole_file_finish(&whole, err);
out:
    rmap_whole_file_fini(&whole);
    return st;
}
