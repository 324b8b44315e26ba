/* SPDX-License-Identifier: MIT */
#include "io/piece_writer.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/codec.h"
#include "io/provenance.h"
#include "io/publish.h"
#include "io/seal.h"
#include "trace/event.h"

/* What readers are told of the stored streams; any zlib level reads alike. */
#define DECLARED_LEVEL 1

struct rmap_piece_writer {
    struct rmap_h5 h5;
    const struct rmap_run *run;
    char *directory, *temporary, *final;
    hid_t set[RMAP_COLUMN_COUNT];
    struct rmap_chunk_entry *entry;
    size_t n_entry, cap_entry;
};

/* Datasets are numbered in the order of their names' list, which the file carries. */
static enum rmap_status write_column_names(struct rmap_piece_writer *self, struct rmap_error *err)
{
    const char *name[RMAP_COLUMN_COUNT];
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        name[c] = rmap_column_path((enum rmap_column)c, self->run->scene->channels.mode);
    return rmap_h5_write_names(&self->h5, "/chunk/name", name, RMAP_COLUMN_COUNT,
                               "datasets that /chunk/column counts", err);
}

static hid_t column_properties(int rank, size_t width)
{
    const hsize_t chunk[2] = {RMAP_CHUNK_ROWS, width};
    hid_t create = H5Pcreate(H5P_DATASET_CREATE);
    if (create >= 0 &&
        (H5Pset_obj_track_times(create, false) < 0 || H5Pset_chunk(create, rank, chunk) < 0 ||
         H5Pset_fill_time(create, H5D_FILL_TIME_NEVER) < 0 || H5Pset_shuffle(create) < 0 ||
         H5Pset_deflate(create, DECLARED_LEVEL) < 0 || H5Pset_fletcher32(create) < 0)) {
        (void)H5Pclose(create);
        create = H5I_INVALID_HID;
    }
    return create;
}

static enum rmap_status create_column(struct rmap_piece_writer *self, enum rmap_column column,
                                      struct rmap_error *err)
{
    static const hsize_t unlimited[2] = {H5S_UNLIMITED, H5S_UNLIMITED};
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = self->run->scene;
    const struct rmap_column_info *info = rmap_column_info(column);
    const char *path = rmap_column_path(column, scene->channels.mode);
    size_t width = rmap_column_width(column, scene->channels.n);
    int rank = width > 1 || column == RMAP_SEGMENT_colour ? 2 : 1;
    const hsize_t dims[2] = {0, width}, most[2] = {unlimited[0], width};
    hid_t create = column_properties(rank, width), space = H5Screate_simple(rank, dims, most);
    if (create < 0 || space < 0 ||
        (self->set[column] = H5Dcreate2(self->h5.file, path, rmap_h5_type(info->element), space,
                                        H5P_DEFAULT, create, H5P_DEFAULT)) < 0)
        st = rmap_h5_fail(&self->h5, path, err);
    (void)H5Sclose(space);
    (void)H5Pclose(create);
    if (st == RMAP_OK)
        st = rmap_h5_describe(&self->h5, path,
                              rmap_h5_unit_of(info->unit, scene->unit, scene->unit_m),
                              info->description, err);
    return st;
}

static enum rmap_status describe_values(struct rmap_piece_writer *self, struct rmap_error *err)
{
    static const char bits[] =
#define BIT(symbol, bit, letter, word, meaning) word " = 2^" #bit ", "
        RMAP_EVENT_TABLE(BIT);
#undef BIT
    const struct rmap_channels *channels = &self->run->scene->channels;
    char text[sizeof bits];
    (void)snprintf(text, sizeof text, "%.*s", (int)(sizeof bits - 3), bits);
    enum rmap_status st = rmap_h5_put_text(&self->h5, "/segment/event", "bits", text, err);
    if (st == RMAP_OK)
        st = rmap_h5_put(&self->h5, rmap_column_path(RMAP_SEGMENT_colour, channels->mode),
                         "wavelength_nm", RMAP_F64, (size_t)channels->n, channels->wavelength_nm,
                         err);
    return st;
}

static enum rmap_status create_file(struct rmap_piece_writer *self, int shard, int number,
                                    const char *scene_digest, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const int32_t place[2] = {shard, number};
    RMAP_TRY(rmap_h5_create(&self->h5, self->temporary, err));
    RMAP_TRY(rmap_provenance_put(&self->h5, RMAP_FILETYPE_PIECE, self->run, scene_digest, err));
    RMAP_TRY(rmap_h5_put(&self->h5, "/", "shard", RMAP_I32, 1, &place[0], err));
    RMAP_TRY(rmap_h5_put(&self->h5, "/", "piece", RMAP_I32, 1, &place[1], err));
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        RMAP_TRY(rmap_h5_group(&self->h5, rmap_table_path[t], err));
    RMAP_TRY(rmap_h5_group(&self->h5, "/chunk", err));
    RMAP_TRY(rmap_h5_group(&self->h5, "/portion", err));
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        RMAP_TRY(create_column(self, (enum rmap_column)c, err));
    RMAP_TRY(describe_values(self, err));
    RMAP_TRY(write_column_names(self, err));
out:
    return st;
}

enum rmap_status rmap_piece_writer_create(const char *shard_path, int shard, int number,
                                          const struct rmap_run *run, const char *scene_digest,
                                          struct rmap_piece_writer **writer_ret,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char name[32];
    struct rmap_piece_writer *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a piece");
    self->run = run;
    self->h5.file = H5I_INVALID_HID;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        self->set[c] = H5I_INVALID_HID;
    (void)snprintf(name, sizeof name, "piece-%05d.h5", number);
    self->directory = rmap_strdup(shard_path);
    self->final = rmap_path_format("%s/%s", shard_path, name);
    self->temporary = rmap_temporary_path(shard_path, name);
    if (!self->directory || !self->final || !self->temporary) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a piece");
        goto out;
    }
    (void)unlink(self->temporary); /* of a process of the same number that was killed */
    RMAP_TRY(create_file(self, shard, number, scene_digest, err));
    *writer_ret = self;
    self = NULL;
out:
    rmap_piece_writer_destroy(self);
    return st;
}

enum rmap_status rmap_piece_writer_put(struct rmap_piece_writer *self, enum rmap_column column,
                                       uint32_t index, uint64_t n_row, const uint8_t *stored,
                                       const struct rmap_stream_size *size, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const hsize_t extent[2] = {n_row, rmap_column_width(column, self->run->scene->channels.n)};
    const hsize_t offset[2] = {(hsize_t)index * RMAP_CHUNK_ROWS, 0};
    hsize_t found_nbytes = 0;
    haddr_t address = 0;
    unsigned mask = 0;
    void *block = self->entry;
    if (self->h5.failed)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: an earlier write failed", self->h5.path);
    st = rmap_reserve(&block, &self->cap_entry, self->n_entry + 1, sizeof *self->entry, err);
    self->entry = block;
    if (st != RMAP_OK)
        return st;
    hid_t set = self->set[column];
    if (H5Dset_extent(set, extent) < 0 ||
        H5Dwrite_chunk(set, H5P_DEFAULT, 0, offset, size->nbytes, stored) < 0 ||
        H5Dget_chunk_info_by_coord(set, offset, &mask, &address, &found_nbytes) < 0)
        return rmap_h5_fail(&self->h5, rmap_column_info(column)->path, err);
    self->entry[self->n_entry++] =
        (struct rmap_chunk_entry){.offset = address,
                                  .checksum = rmap_checksum(stored, size->nbytes),
                                  .nbytes = (uint32_t)size->nbytes,
                                  .lead_nbytes = size->lead_nbytes,
                                  .lead_planes = size->lead_planes,
                                  .index = index,
                                  .column = (uint16_t)column};
    return st;
}

static enum rmap_status seal(struct rmap_piece_writer *self, struct rmap_error *err)
{
    struct rmap_range *range = rmap_alloc(self->n_entry, sizeof *range);
    if (!range)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the seal of a piece");
    for (size_t i = 0; i < self->n_entry; i++)
        range[i] = (struct rmap_range){self->entry[i].offset, self->entry[i].nbytes};
    enum rmap_status st = rmap_seal_write(self->temporary, range, self->n_entry, err);
    rmap_free(range);
    return st;
}

enum rmap_status rmap_piece_writer_finish(struct rmap_piece_writer *self,
                                          const struct rmap_portion_info *portion, size_t n_portion,
                                          struct rmap_error *err)
{
    static const int32_t complete = 1;
    enum rmap_status st = RMAP_OK;
    struct rmap_field_table chunks = rmap_chunk_fields(), portions = rmap_portion_fields_piece();
    RMAP_TRY(rmap_h5_write_fields(&self->h5, chunks.field, chunks.n, self->entry, self->n_entry,
                                  sizeof *self->entry, err));
    RMAP_TRY(rmap_h5_write_fields(&self->h5, portions.field, portions.n, portion, n_portion,
                                  sizeof *portion, err));
    RMAP_TRY(rmap_h5_put(&self->h5, "/", "complete", RMAP_I32, 1, &complete, err));
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        if (H5Dclose(self->set[c]) < 0) {
            st = rmap_h5_fail(&self->h5, rmap_column_info((enum rmap_column)c)->path, err);
            goto out;
        }
        self->set[c] = H5I_INVALID_HID;
    }
    RMAP_TRY(rmap_h5_close(&self->h5, err));
    RMAP_TRY(seal(self, err));
    st = rmap_publish_new(self->directory, self->temporary, self->final, err);
    rmap_free(self->temporary);
    self->temporary = NULL;
out:
    return st;
}

void rmap_piece_writer_destroy(struct rmap_piece_writer *self)
{
    if (!self)
        return;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (self->set[c] >= 0 && !self->h5.failed)
            (void)H5Dclose(self->set[c]);
    rmap_h5_drop(&self->h5);
    if (self->temporary)
        (void)unlink(self->temporary);
    rmap_free(self->directory);
    rmap_free(self->temporary);
    rmap_free(self->final);
    rmap_free(self->entry);
    rmap_free(self);
}
