/* SPDX-License-Identifier: MIT
 *
 * Writes columns of a piece beside it.
 */
#include "io/write/columns_writer.h"

#include <fcntl.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/codec/codec.h"
#include "io/file/directory.h"
#include "io/file/publish.h"
#include "io/file/seal.h"
#include "io/hdf5/h5_write.h"
#include "io/map/map_chunks.h"
#include "io/map/map_format.h"
#include "io/write/stream_set.h"

struct column {
    hid_t set; /* H5I_INVALID_HID: none */
    size_t row_nbytes;
    uint8_t *waiting; /* [RMAP_CHUNK_ROWS] rows, n_waiting of them in use */
    size_t n_waiting;
    uint64_t n_row; /* stored */
};

struct rmap_columns_writer {
    const struct rmap_layout *plain;
    const struct rmap_scene *scene;
    struct rmap_h5 h5;
    char *directory, *temporary, *final;
    rmap_column_set columns;
    struct column column[RMAP_COLUMN_COUNT];
    struct rmap_chunk_entry *entry;
    size_t n_entry, cap_entry;
    struct rmap_encoder *encoder;
    uint8_t *stored;
};

static enum rmap_status create_file(struct rmap_columns_writer *self, const char *piece,
                                    const struct rmap_digest *digest, struct rmap_error *err)
{
    static const int32_t version[2] = {RMAP_FORMAT_OLDEST, 0};
    static const char *const group[] = {"/ray", "/segment", "/registration", "/chunk"};
    enum rmap_status st = RMAP_OK;
    const char *name[RMAP_COLUMN_COUNT];
    char text[33];
    size_t n = 0;
    rmap_digest_text(*digest, text);
    RMAP_TRY(rmap_h5_create(&self->h5, self->temporary, err));
    RMAP_TRY(rmap_h5_put_text(&self->h5, "/", "filetype", RMAP_FILETYPE_COLUMNS, err));
    RMAP_TRY(rmap_h5_put(&self->h5, "/", "version", RMAP_I32, 2, version, err));
    RMAP_TRY(rmap_h5_put_text(&self->h5, "/", "piece", piece, err));
    RMAP_TRY(rmap_h5_put_text(&self->h5, "/", "digest", text, err));
    for (size_t g = 0; g < sizeof group / sizeof *group; g++)
        RMAP_TRY(rmap_h5_group(&self->h5, group[g], err));
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (self->columns & RMAP_COLUMN_BIT(c)) {
            RMAP_TRY(rmap_stream_set_create(&self->h5, &self->plain->stream[c], self->scene,
                                            &self->column[c].set, err));
            name[n++] = self->plain->stream[c].path;
        }
    st = rmap_h5_write_names(&self->h5, "/chunk/name", name, n,
                             "datasets that /chunk/stream counts", err);
out:
    return st;
}

static enum rmap_status reserve(struct rmap_columns_writer *self, struct rmap_error *err)
{
    size_t most = 0;
    const int n_channel = self->scene->channels.n;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        const struct rmap_stream_info *info = &self->plain->stream[c];
        if (!(self->columns & RMAP_COLUMN_BIT(c)))
            continue;
        const size_t bound = rmap_codec_bound(RMAP_CHUNK_ROWS * rmap_stream_width(info, n_channel),
                                              rmap_element_nbytes(info->element));
        most = bound > most ? bound : most;
        self->column[c].row_nbytes = rmap_stream_row_nbytes(info, n_channel);
        self->column[c].waiting = rmap_alloc(RMAP_CHUNK_ROWS, self->column[c].row_nbytes);
        if (!self->column[c].waiting)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for kept columns");
    }
    self->stored = rmap_alloc(most + 1, 1);
    return self->stored ? rmap_encoder_create(&self->encoder, err)
                        : rmap_error_set(err, RMAP_SYSTEM, "out of memory for kept columns");
}

enum rmap_status rmap_columns_writer_create(const struct rmap_map *map, size_t piece,
                                            rmap_column_set columns,
                                            struct rmap_columns_writer **writer_ret,
                                            struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_piece_info *info = &map->content.piece[piece];
    const struct rmap_digest *digest = rmap_map_piece_digest(map, piece);
    int folder = -1;
    struct rmap_columns_writer *self = rmap_alloc(1, sizeof *self);
    if (!self || !digest) {
        rmap_free(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for kept columns");
    }
    self->h5.file = H5I_INVALID_HID;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        self->column[c].set = H5I_INVALID_HID;
    self->columns = columns;
    self->scene = map->scene[info->space];
    self->plain = rmap_layout_of(RMAP_ENCODING_PLAIN, map->spaces.space[info->space].mode);
    self->directory = rmap_path_format("%s/shard-%05d", map->path, (int)info->shard);
    self->final = rmap_piece_columns_path(map->path, info);
    self->temporary = self->directory && self->final
                          ? rmap_temporary_path(self->directory, strrchr(self->final, '/') + 1)
                          : NULL;
    if (!self->temporary)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for kept columns"));
    RMAP_TRY(rmap_shard_open(AT_FDCWD, self->directory, &folder, err)); /* no link */
    (void)unlink(self->temporary); /* its process had our number */
    RMAP_TRY(reserve(self, err));
    RMAP_TRY(create_file(self, info->name, digest, err));
    *writer_ret = self;
    self = NULL;
out:
    if (folder >= 0)
        (void)close(folder);
    rmap_columns_writer_destroy(self);
    return st;
}

static enum rmap_status store(struct rmap_columns_writer *self, int c, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct column *column = &self->column[c];
    const struct rmap_stream_info *info = &self->plain->stream[c];
    const int n_channel = self->scene->channels.n;
    const size_t width = rmap_stream_width(info, n_channel);
    const uint64_t index = column->n_row / RMAP_CHUNK_ROWS;
    int number = 0;
    size_t nbytes = 0;
    for (int before = 0; before < c; before++)
        number += (self->columns >> before & 1) != 0;
    RMAP_TRY(RMAP_RESERVE(self->entry, self->cap_entry, self->n_entry + 1, err));
    RMAP_TRY(rmap_encoder_encode(self->encoder, column->waiting, column->n_waiting * width,
                                 RMAP_CHUNK_ROWS * width, rmap_element_nbytes(info->element),
                                 self->stored, &nbytes, err));
    RMAP_TRY(rmap_stream_set_put(&self->h5, column->set, info, n_channel, number, (uint32_t)index,
                                 column->n_row + column->n_waiting, self->stored, nbytes,
                                 &self->entry[self->n_entry], err));
    self->n_entry++;
    column->n_row += column->n_waiting;
    column->n_waiting = 0;
out:
    return st;
}

enum rmap_status rmap_columns_writer_put(struct rmap_columns_writer *self,
                                         const struct rmap_portion *rows, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        struct column *column = &self->column[c];
        const uint8_t *from = rmap_portion_column(rows, (enum rmap_column)c);
        size_t n = rows->n_row[rmap_column_info((enum rmap_column)c)->table];
        while (self->columns & RMAP_COLUMN_BIT(c) && n > 0) {
            const size_t room = RMAP_CHUNK_ROWS - column->n_waiting, some = n < room ? n : room;
            memcpy(column->waiting + column->n_waiting * column->row_nbytes, from,
                   some * column->row_nbytes);
            column->n_waiting += some;
            from += some * column->row_nbytes;
            n -= some;
            if (column->n_waiting == RMAP_CHUNK_ROWS)
                RMAP_TRY(store(self, c, err));
        }
    }
out:
    return st;
}

static enum rmap_status seal(struct rmap_columns_writer *self, struct rmap_error *err)
{
    struct rmap_range *range = rmap_alloc(self->n_entry + 1, sizeof *range);
    if (!range)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the seal of kept columns");
    for (size_t i = 0; i < self->n_entry; i++)
        range[i] = (struct rmap_range){self->entry[i].offset, self->entry[i].nbytes};
    const enum rmap_status st = rmap_seal_write(self->temporary, range, self->n_entry, err);
    rmap_free(range);
    return st;
}

enum rmap_status rmap_columns_writer_finish(struct rmap_columns_writer *self,
                                            struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_field_table fields = rmap_chunk_fields();
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        if (self->column[c].n_waiting > 0)
            RMAP_TRY(store(self, c, err));
        if (self->column[c].set >= 0 && H5Dclose(self->column[c].set) < 0)
            RMAP_TRY(rmap_h5_fail(&self->h5, self->plain->stream[c].path, err));
        self->column[c].set = H5I_INVALID_HID;
    }
    RMAP_TRY(rmap_h5_write_fields(&self->h5, fields.field, fields.n, self->entry, self->n_entry,
                                  sizeof *self->entry, err));
    RMAP_TRY(rmap_h5_close(&self->h5, err));
    RMAP_TRY(seal(self, err));
    st = rmap_publish_over(self->directory, self->temporary, self->final, err);
    rmap_free(self->temporary);
    self->temporary = NULL;
out:
    return st;
}

void rmap_columns_writer_destroy(struct rmap_columns_writer *self)
{
    if (!self)
        return;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        if (self->column[c].set >= 0 && !self->h5.failed)
            (void)H5Dclose(self->column[c].set);
        rmap_free(self->column[c].waiting);
    }
    if (self->temporary)
        (void)unlink(self->temporary);
    rmap_h5_drop(&self->h5);
    rmap_encoder_destroy(self->encoder);
    rmap_free(self->stored);
    rmap_free(self->entry);
    rmap_free(self->temporary);
    rmap_free(self->directory);
    rmap_free(self->final);
    rmap_free(self);
}
