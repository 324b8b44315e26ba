/* SPDX-License-Identifier: MIT
 *
 * Of files of rays what does not depend on the format.
 */
#include "io/rays/ray_file.h"

#include <errno.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <zlib.h>

#include "base/alloc.h"
#include "io/file/input_file.h"
#include "io/rays/ray_reader.h"

bool rmap_ray_format_of(const char *path, enum rmap_ray_format *format_ret)
{
    static const struct {
        const char *end;
        enum rmap_ray_format format;
    } known[] = {{".tm25ray", RMAP_RAYS_TM25},   {".tm25", RMAP_RAYS_TM25},
                 {".ray", RMAP_RAYS_LIGHTTOOLS}, {".csv", RMAP_RAYS_CSV},
                 {".txt", RMAP_RAYS_CSV},        {".h5", RMAP_RAYS_HDF5},
                 {".hdf5", RMAP_RAYS_HDF5},      {".mcpl", RMAP_RAYS_MCPL}};
    size_t len = strlen(path);
    const bool packed = len > 3 && strcasecmp(path + len - 3, ".gz") == 0;
    len -= packed ? 3 : 0;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        const size_t n = strlen(known[i].end);
        if (len > n && strncasecmp(path + len - n, known[i].end, n) == 0 &&
            !(packed && known[i].format == RMAP_RAYS_HDF5)) {
            *format_ret = known[i].format;
            return true;
        }
    }
    return false;
}

/* ---- bytes ---- */

static enum rmap_status ends_early(struct rmap_ray_bytes *bytes, const char *what)
{
    if (ferror(bytes->in))
        return rmap_error_set(bytes->err, RMAP_SYSTEM, "cannot be read: %s", strerror(errno));
    return rmap_error_set(bytes->err, RMAP_INPUT, "it ends after %llu bytes, in %s",
                          (unsigned long long)bytes->nbytes, what);
}

enum rmap_status rmap_ray_take(struct rmap_ray_bytes *bytes, void *to, size_t n, const char *what)
{
    if (n > bytes->nbytes - bytes->at || fread(to, 1, n, bytes->in) != n)
        return ends_early(bytes, what);
    bytes->at += n;
    return RMAP_OK;
}

enum rmap_status rmap_ray_skip(struct rmap_ray_bytes *bytes, uint64_t n, const char *what)
{
    if (n > bytes->nbytes - bytes->at || fseeko(bytes->in, (off_t)n, SEEK_CUR) != 0)
        return ends_early(bytes, what);
    bytes->at += n;
    return RMAP_OK;
}

/* ---- files ---- */

enum rmap_status rmap_ray_stream_read(FILE *in, uint64_t nbytes, enum rmap_ray_format format,
                                      struct rmap_ray_wanted *wanted,
                                      struct rmap_file_rays **set_ret, struct rmap_error *err)
{
    struct rmap_ray_bytes bytes = {.in = in, .nbytes = nbytes, .err = err};
    switch (format) {
    case RMAP_RAYS_TM25:
        return rmap_tm25_read(&bytes, set_ret, err);
    case RMAP_RAYS_LIGHTTOOLS:
        return rmap_lighttools_read(in, set_ret, err);
    case RMAP_RAYS_CSV:
        return rmap_ray_csv_read(in, wanted->steps, set_ret, err);
    case RMAP_RAYS_MCPL:
        return rmap_mcpl_read(&bytes, wanted, set_ret, err);
    case RMAP_RAYS_HDF5:
        break;
    }
    return rmap_error_set(err, RMAP_INTERNAL, "an HDF5 file is no stream");
}

/* The bytes of a .gz file, in a temporary one. */
static enum rmap_status unpack(const char *path, FILE **out_ret, struct rmap_error *err)
{
    enum { BLOCK = 1 << 18 };
    enum rmap_status st = RMAP_OK;
    uint8_t *block = rmap_alloc_unset(BLOCK, 1);
    gzFile in = gzopen(path, "rb");
    FILE *out = tmpfile();
    int n = 0, why = 0;
    if (!block || !in || !out)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "cannot be unpacked: %s",
                                !block || !in ? "no memory" : strerror(errno)));
    while ((n = gzread(in, block, BLOCK)) > 0)
        if (fwrite(block, 1, (size_t)n, out) != (size_t)n)
            RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "its unpacked bytes cannot be kept: %s",
                                    strerror(errno)));
    (void)gzerror(in, &why);
    if (n < 0 || why != Z_OK)
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "it is packed (.gz), and damaged or cut short"));
    rewind(out);
    *out_ret = out;
    out = NULL;
out:
    if (in)
        (void)gzclose(in);
    if (out)
        (void)fclose(out);
    rmap_free(block);
    return st;
}

/* By its first bytes, whatever it is called. */
static bool is_packed(FILE *in)
{
    uint8_t first[2] = {0, 0};
    const bool packed = fread(first, 1, 2, in) == 2 && first[0] == 0x1f && first[1] == 0x8b;
    rewind(in);
    return packed;
}

static enum rmap_status read_stream(const char *path, enum rmap_ray_format format,
                                    struct rmap_ray_wanted *wanted, struct rmap_file_rays **set_ret,
                                    struct rmap_error *err)
{
    struct stat state;
    FILE *in = fopen(path, "rb"), *unpacked = NULL;
    if (in && is_packed(in)) {
        const enum rmap_status st = unpack(path, &unpacked, err);
        (void)fclose(in);
        if (st != RMAP_OK)
            return st;
        in = unpacked;
    }
    if (!in || fstat(fileno(in), &state) != 0) {
        const int why = errno;
        if (in)
            (void)fclose(in);
        return rmap_error_set(err, RMAP_SYSTEM, "cannot be opened: %s", strerror(why));
    }
    const enum rmap_status st =
        rmap_ray_stream_read(in, (uint64_t)state.st_size, format, wanted, set_ret, err);
    (void)fclose(in);
    return st;
}

enum rmap_status rmap_ray_file_read(const char *path, enum rmap_ray_format format,
                                    struct rmap_ray_wanted *wanted, struct rmap_file_rays **set_ret,
                                    struct rmap_error *err)
{
    struct rmap_file_rays *set = NULL;
    const char *trouble = rmap_input_file_trouble(path);
    enum rmap_status st = trouble ? rmap_error_set(err, RMAP_INPUT, "cannot be opened: %s", trouble)
                          : format == RMAP_RAYS_HDF5 ? rmap_ray_hdf5_read(path, wanted, &set, err)
                                                     : read_stream(path, format, wanted, &set, err);
    if (st == RMAP_OK)
        st = rmap_file_rays_finish(set, err);
    if (st == RMAP_OK) {
        *set_ret = set;
        return RMAP_OK;
    }
    rmap_file_rays_drop(set);
    rmap_error_context(err, "%s", path);
    return st;
}
