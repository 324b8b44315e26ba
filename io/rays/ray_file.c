/* SPDX-License-Identifier: MIT
 *
 * Of files of rays what does not depend on the format.
 */
#include "io/rays/ray_file.h"

#include <errno.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

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
    const size_t len = strlen(path);
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        const size_t n = strlen(known[i].end);
        if (len > n && strcasecmp(path + len - n, known[i].end) == 0) {
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

static enum rmap_status read_stream(const char *path, enum rmap_ray_format format,
                                    struct rmap_ray_wanted *wanted, struct rmap_file_rays **set_ret,
                                    struct rmap_error *err)
{
    struct stat state;
    FILE *in = fopen(path, "rb");
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
