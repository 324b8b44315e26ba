/* SPDX-License-Identifier: MIT
 *
 * The history index of a piece as a file beside it: shard-RRRRR/piece-KKKKK.history.h5, sealed
 * like a piece. docs/map.md has its datasets.
 */
#include "io/map/history_file.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/publish.h"
#include "io/file/read_exactly.h"
#include "io/file/seal.h"
#include "io/hdf5/h5_inside.h"
#include "io/hdf5/h5_read.h"
#include "io/hdf5/h5_write.h"
#include "io/map/map_format.h"
#include "io/map/provenance.h"

static const char head_path[] = "/history/head", body_path[] = "/history/body";

char *rmap_history_path(const char *map_path, const struct rmap_piece_info *piece)
{
    return rmap_path_format("%s/shard-%05d/piece-%05d" RMAP_HISTORY_SUFFIX, map_path,
                            (int)piece->shard, (int)piece->number);
}

/* ---- writing ---- */

static enum rmap_status write_head(struct rmap_h5 *h5, const struct rmap_history_bytes *bytes,
                                   struct rmap_error *err)
{
    const struct rmap_h5_array array = {
        .path = head_path,
        .element = RMAP_U8,
        .rank = 1,
        .dims = {bytes->head_nbytes},
        .unit = rmap_h5_unit_of(RMAP_UNIT_ONE, NULL, 1),
        .description = "classes of legs and registrations, distinct histories, and where each "
                       "portion stands in body: docs/map.md, the history index"};
    return rmap_h5_write(h5, &array, bytes->head, err);
}

/* In one piece as it is, to be read portion by portion. */
static enum rmap_status write_body(struct rmap_h5 *h5, const struct rmap_history_bytes *bytes,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    hsize_t n = bytes->body_nbytes;
    hid_t set = H5I_INVALID_HID, type = rmap_h5_type(RMAP_U8);
    hid_t space = H5Screate_simple(1, &n, NULL), create = H5Pcreate(H5P_DATASET_CREATE);
    if (space < 0 || create < 0 || H5Pset_obj_track_times(create, false) < 0 ||
        (set = H5Dcreate2(h5->file, body_path, type, space, H5P_DEFAULT, create, H5P_DEFAULT)) <
            0 ||
        H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes->body) < 0)
        st = rmap_h5_fail(h5, body_path, err);
    if (set >= 0 && !h5->failed && H5Dclose(set) < 0)
        st = rmap_h5_fail(h5, body_path, err);
    (void)H5Sclose(space);
    (void)H5Pclose(create);
    if (st != RMAP_OK)
        return st;
    return rmap_h5_describe(h5, body_path, rmap_h5_unit_of(RMAP_UNIT_ONE, NULL, 1),
                            "history of each ray, portion by portion: docs/map.md, the history "
                            "index",
                            err);
}

/* Where a dataset's bytes lie in the file. */
static enum rmap_status find_bytes(struct rmap_h5 *h5, const char *path, uint64_t *offset_ret,
                                   struct rmap_error *err)
{
    hid_t set = rmap_h5_dataset(h5->file, path);
    if (set < 0)
        return rmap_h5_fail(h5, path, err);
    haddr_t offset = H5Dget_offset(set);
    if (H5Dclose(set) < 0 || offset == HADDR_UNDEF)
        return rmap_h5_fail(h5, path, err);
    *offset_ret = offset;
    return RMAP_OK;
}

static enum rmap_status write_file(struct rmap_h5 *h5, const char *temporary,
                                   const struct rmap_piece_info *piece,
                                   const struct rmap_history_bytes *bytes, struct rmap_error *err)
{
    static const int32_t version[2] = {RMAP_FORMAT_OLDEST, 0};
    enum rmap_status st = RMAP_OK;
    struct rmap_range range = {.nbytes = bytes->body_nbytes};
    RMAP_TRY(rmap_h5_create(h5, temporary, err));
    RMAP_TRY(rmap_h5_put_text(h5, "/", "filetype", RMAP_FILETYPE_HISTORY, err));
    RMAP_TRY(rmap_h5_put(h5, "/", "version", RMAP_I32, 2, version, err));
    RMAP_TRY(rmap_h5_put_text(h5, "/", "piece", piece->name, err));
    RMAP_TRY(rmap_h5_group(h5, "/history", err));
    RMAP_TRY(write_head(h5, bytes, err));
    if (bytes->body_nbytes > 0) {
        RMAP_TRY(write_body(h5, bytes, err));
        RMAP_TRY(find_bytes(h5, body_path, &range.offset, err));
    }
    RMAP_TRY(rmap_h5_close(h5, err));
    /* Portions have checksums of their own. */
    RMAP_TRY(rmap_seal_write(temporary, &range, bytes->body_nbytes > 0, err));
out:
    return st;
}

enum rmap_status rmap_history_file_write(const char *map_path, const struct rmap_piece_info *piece,
                                         const struct rmap_history_bytes *bytes,
                                         uint64_t *nbytes_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_h5 h5 = {.file = H5I_INVALID_HID};
    struct stat file;
    int folder = -1;
    char *final = rmap_history_path(map_path, piece);
    char *directory = rmap_path_format("%s/shard-%05d", map_path, (int)piece->shard);
    char *temporary =
        final && directory ? rmap_temporary_path(directory, strrchr(final, '/') + 1) : NULL;
    if (!temporary) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a history index");
        goto out;
    }
    RMAP_TRY(rmap_shard_open(AT_FDCWD, directory, &folder, err));
    (void)unlinkat(folder, strrchr(temporary, '/') + 1, 0); /* its process had our number */
    RMAP_TRY(write_file(&h5, temporary, piece, bytes, err));
    if (stat(temporary, &file) != 0) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: %s", temporary, strerror(errno));
        goto out;
    }
    *nbytes_ret = (uint64_t)file.st_size;
    RMAP_TRY(rmap_publish_over(directory, temporary, final, err));
out:
    if (folder >= 0) {
        if (st != RMAP_OK)
            (void)unlinkat(folder, strrchr(temporary, '/') + 1, 0);
        (void)close(folder);
    }
    rmap_h5_drop(&h5);
    rmap_free(temporary);
    rmap_free(directory);
    rmap_free(final);
    return st;
}

/* ---- reading ---- */

/* The body of an open index. */
struct body {
    char *path; /* for messages */
    int fd;
    uint64_t offset; /* of the body in the file */
};

static void release_body(void *context)
{
    struct body *self = context;
    if (self->fd >= 0)
        (void)close(self->fd);
    rmap_free(self->path);
    rmap_free(self);
}

static enum rmap_status read_body(void *context, uint64_t offset, size_t nbytes, void *to,
                                  struct rmap_error *err)
{
    const struct body *self = context;
    enum rmap_status st = rmap_read_exactly(self->fd, to, nbytes, self->offset + offset, err);
    if (st != RMAP_OK)
        rmap_error_context(err, "%s", self->path);
    return st;
}

/* Where it lies; its portions have checksums of their own. */
static enum rmap_status find_body(struct rmap_h5 *h5, struct body *body, uint64_t *nbytes_ret,
                                  struct rmap_error *err)
{
    struct stat file;
    hsize_t n = 0;
    *nbytes_ret = 0;
    if (!rmap_h5_has(h5, body_path))
        return RMAP_OK;
    enum rmap_status st = find_bytes(h5, body_path, &body->offset, err);
    if (st != RMAP_OK)
        return st;
    hid_t set = rmap_h5_dataset(h5->file, body_path);
    hid_t space = set < 0 ? H5I_INVALID_HID : H5Dget_space(set);
    bool good = space >= 0 && H5Sget_simple_extent_ndims(space) == 1 &&
                H5Sget_simple_extent_dims(space, &n, NULL) == 1;
    if (space >= 0)
        (void)H5Sclose(space);
    if (set >= 0)
        (void)H5Dclose(set);
    good = good && fstat(body->fd, &file) == 0 && body->offset <= (uint64_t)file.st_size &&
           n <= (uint64_t)file.st_size - body->offset;
    *nbytes_ret = n;
    return good ? RMAP_OK
                : rmap_error_set(err, RMAP_FORMAT, "%s: %s lies outside the file", h5->path,
                                 body_path);
}

static enum rmap_status open_body(struct rmap_h5 *h5, struct rmap_history_body *body,
                                  struct rmap_error *err)
{
    struct body *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a history index");
    self->fd = -1;
    *body = (struct rmap_history_body){.context = self, .read = read_body, .release = release_body};
    self->path = rmap_strdup(h5->path);
    if (!self->path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a history index");
    self->fd = open(h5->path, O_RDONLY | O_CLOEXEC);
    if (self->fd < 0)
        return rmap_error_set(err, RMAP_SYSTEM, "%s cannot be opened: %s", h5->path,
                              strerror(errno));
    return find_body(h5, self, &body->nbytes, err);
}

enum rmap_status rmap_history_file_open(const char *path, const struct rmap_history_limits *limits,
                                        struct rmap_history_index **index_ret,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_h5 h5 = {.file = H5I_INVALID_HID};
    struct rmap_history_body body = {0};
    struct stat file;
    void *head = NULL;
    hsize_t head_nbytes = 0;
    if (stat(path, &file) != 0)
        return rmap_error_set(err, errno == ENOENT ? RMAP_INPUT : RMAP_SYSTEM, "%s: %s", path,
                              strerror(errno));
    RMAP_TRY(rmap_h5_open(&h5, path, err));
    RMAP_TRY(rmap_provenance_check(&h5, RMAP_FILETYPE_HISTORY, err));
    RMAP_TRY(rmap_h5_read(&h5, head_path, RMAP_U8, 1, &head_nbytes, &head, err));
    RMAP_TRY(open_body(&h5, &body, err));
    st = rmap_history_open(head, (size_t)head_nbytes, &body, limits, index_ret, err);
    if (st != RMAP_OK)
        rmap_error_context(err, "%s", path);
    else
        body.release = NULL; /* the index's now */
out:
    if (body.release)
        body.release(body.context);
    rmap_free(head);
    rmap_h5_drop(&h5);
    return st;
}
