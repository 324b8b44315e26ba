/* SPDX-License-Identifier: MIT
 *
 * map.h5: everything about a map but its columns. Replaced whole by rename, so a map has an index
 * at every moment once it had one.
 */
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/file/publish.h"
#include "io/file/seal.h"
#include "io/hdf5/h5_write.h"
#include "io/map/map_format.h"
#include "io/map/map_internal.h"
#include "io/map/map_scan.h"
#include "io/map/map_tally.h"
#include "io/map/map_writer.h"
#include "io/map/portion_rows.h"
#include "io/map/provenance.h"
#include "io/scene/scene_numbers.h"
#include "io/write/index_scene.h"
#include "io/write/index_writer.h"
#include "io/write/map_view.h"

struct index {
    struct rmap_h5 h5;
    const struct rmap_run *run;
    struct rmap_run first;         /* the run as it would be in colour space 0 */
    const struct rmap_map *before; /* or NULL */
    const struct rmap_tally *tally;
    struct rmap_tally *zeros; /* owned; used where no tally was given */
    struct rmap_piece_origin origin, first_origin;
    struct rmap_map_content content;
    struct rmap_map_spaces spaces;
    struct rmap_run_row *row;
    size_t n_row;
};

static enum rmap_status put_totals(struct index *self, bool complete, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const int32_t ranks = self->run->n_rank, done = complete;
    const uint64_t digest[2] = {self->content.digest.low, self->content.digest.high};
    char text[33];
    rmap_digest_text(self->content.digest, text);
    RMAP_TRY(rmap_h5_put(&self->h5, "/", "complete", RMAP_I32, 1, &done, err));
    RMAP_TRY(rmap_h5_put(&self->h5, "/", "ranks", RMAP_I32, 1, &ranks, err));
    RMAP_TRY(rmap_h5_put_text(&self->h5, "/", "digest", text, err));
    if (self->run->parent && *self->run->parent)
        RMAP_TRY(rmap_h5_put_text(&self->h5, "/", "parent", self->run->parent, err));
    RMAP_TRY(rmap_h5_put(&self->h5, "/", "digest_words", RMAP_U64, 2, digest, err));
    RMAP_TRY(rmap_h5_put(&self->h5, "/", "rays", RMAP_U64, 1, &self->content.n_row[RMAP_TABLE_RAY],
                         err));
    RMAP_TRY(rmap_h5_put(&self->h5, "/", "segments", RMAP_U64, 1,
                         &self->content.n_row[RMAP_TABLE_SEGMENT], err));
    RMAP_TRY(rmap_h5_put(&self->h5, "/", "registrations", RMAP_U64, 1,
                         &self->content.n_row[RMAP_TABLE_REGISTRATION], err));
    if (rmap_scene_keeps_curves(self->run->scene))
        RMAP_TRY(rmap_h5_put(&self->h5, "/", "curve_points", RMAP_U64, 1,
                             &self->content.n_row[RMAP_TABLE_CURVE], err));
out:
    return st;
}

static enum rmap_status write_content(struct index *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map_content *content = &self->content;
    bool curved = rmap_scene_keeps_curves(self->run->scene);
    struct rmap_field_table pieces = rmap_piece_fields(curved), chunks = rmap_chunk_fields(),
                            portions = rmap_portion_fields_index(curved);
    RMAP_TRY(rmap_h5_group(&self->h5, "/piece", err));
    RMAP_TRY(rmap_h5_write_fields(&self->h5, pieces.field, pieces.n, content->piece,
                                  content->n_piece, sizeof *content->piece, err));
    RMAP_TRY(rmap_h5_group(&self->h5, "/portion", err));
    RMAP_TRY(rmap_portion_rows_write(&self->h5, portions, content->portion, content->n_portion,
                                     self->run->selection != NULL, err));
    RMAP_TRY(rmap_h5_group(&self->h5, "/chunk", err));
    RMAP_TRY(rmap_h5_write_fields(&self->h5, chunks.field, chunks.n, content->chunk,
                                  content->n_chunk, sizeof *content->chunk, err));
    RMAP_TRY(rmap_map_view_write(&self->h5, self->run->scene, &self->spaces, content, err));
out:
    return st;
}

/* What /chunk/stream counts, per encoding. */
static enum rmap_status write_layouts(struct index *self, struct rmap_error *err)
{
    static const char *const path[RMAP_ENCODING_COUNT] = {"/layout/plain", "/layout/compact"};
    enum rmap_status st = rmap_h5_group(&self->h5, "/layout", err);
    for (int e = 0; st == RMAP_OK && e < RMAP_ENCODING_COUNT; e++) {
        const struct rmap_layout *layout =
            rmap_layout_of((enum rmap_encoding)e, self->first.scene->channels.mode);
        const char *name[RMAP_STREAM_MAX];
        int n = rmap_layout_n_stream(layout, self->run->scene);
        for (int s = 0; s < n; s++)
            name[s] = layout->stream[s].path;
        st = rmap_h5_write_names(&self->h5, path[e], name, (size_t)n,
                                 "datasets of such pieces; /chunk/stream counts them", err);
    }
    return st;
}

static enum rmap_status write_runs(struct index *self, struct rmap_error *err)
{
    struct rmap_field_table runs = rmap_run_fields();
    enum rmap_status st = rmap_h5_group(&self->h5, "/run", err);
    return st != RMAP_OK ? st
                         : rmap_h5_write_fields(&self->h5, runs.field, runs.n, self->row,
                                                self->n_row, sizeof *self->row, err);
}

/* A space that the map had keeps the numbers that its pieces were written with. */
static enum rmap_status write_models(struct index *self, struct rmap_error *err)
{
    enum rmap_status st = rmap_h5_group(&self->h5, "/model", err);
    for (size_t k = 0; st == RMAP_OK && k < self->spaces.n; k++) {
        bool old = self->before && k < self->before->spaces.n;
        if (old || strcmp(self->spaces.space[k].digest, self->origin.space_digest) == 0)
            st = rmap_scene_numbers_write(&self->h5,
                                          old ? self->before->scene[k] : self->run->scene, k, err);
    }
    return st;
}

static enum rmap_status write_file(struct index *self, const char *temporary, bool complete,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_h5_create(&self->h5, temporary, err));
    RMAP_TRY(
        rmap_provenance_put(&self->h5, RMAP_FILETYPE_MAP, &self->first, &self->first_origin, err));
    RMAP_TRY(put_totals(self, complete, err));
    RMAP_TRY(rmap_index_scene_write(
        &self->h5, &self->first,
        self->run->selection ? self->run->selection->emitted : self->tally->emitted, err));
    RMAP_TRY(rmap_map_spaces_write(&self->h5, &self->spaces, err));
    RMAP_TRY(write_models(self, err));
    RMAP_TRY(write_runs(self, err));
    RMAP_TRY(write_layouts(self, err));
    RMAP_TRY(write_content(self, err));
    if (self->run->selection)
        RMAP_TRY(rmap_selection_write(&self->h5, self->run->selection, err));
    RMAP_TRY(rmap_map_tally_write(&self->h5, self->tally, err));
    RMAP_TRY(rmap_h5_close(&self->h5, err));
    RMAP_TRY(rmap_seal_write(temporary, NULL, 0, err));
out:
    return st;
}

/* What the index says once of the scene's light is said of colour space 0, whichever came last. */
static void take_first_space(struct index *self)
{
    self->first = *self->run;
    self->first_origin = self->origin;
    if (!self->before || self->before->spaces.n == 0)
        return;
    self->first.scene = self->before->scene[0];
    memcpy(self->first_origin.space_digest, self->spaces.space[0].digest,
           sizeof self->first_origin.space_digest);
}

/* The spaces and runs of the map as it was, and this run's. */
static enum rmap_status gather_history(struct index *self, const struct rmap_index *given,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map *before = self->before = given->before;
    size_t n = before ? before->n_run : 0;
    RMAP_TRY(rmap_piece_origin_of(given->run, &self->origin, err));
    if (before)
        RMAP_TRY(rmap_map_spaces_copy(&self->spaces, &before->spaces, err));
    if (rmap_map_spaces_find(&self->spaces, self->origin.space_digest) < 0)
        RMAP_TRY(rmap_map_spaces_add(&self->spaces, given->run->bundle, given->run->scene,
                                     self->origin.space_digest, err));
    take_first_space(self);
    self->row = rmap_alloc(n + 1, sizeof *self->row);
    if (!self->row) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the index");
        goto out;
    }
    if (n > 0)
        memcpy(self->row, before->run, n * sizeof *self->row);
    if (given->row)
        self->row[n++] = *given->row;
    self->n_row = n;
out:
    return st;
}

static enum rmap_status gather_content(struct index *self, const char *map_path,
                                       const struct rmap_index *given, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (given->content)
        RMAP_TRY(rmap_map_content_add(&self->content, given->content, err));
    RMAP_TRY(rmap_map_content_drop_open(&self->content, err));
    RMAP_TRY(rmap_map_content_sort(&self->content, err));
    RMAP_TRY(rmap_map_content_check(&self->content, map_path, err));
    self->tally = given->tally;
    if (!self->tally) {
        RMAP_TRY(rmap_tally_create(given->run->scene, &self->zeros, err));
        self->tally = self->zeros;
    }
out:
    return st;
}

/* Not every file system has hard links, and a map is none the worse without this one. */
static void keep_start(const char *map_path, const char *index)
{
    char *start = rmap_path_format("%s/" RMAP_INDEX_START, map_path);
    char *temporary = rmap_temporary_path(map_path, "map.h5");
    if (start && temporary && link(index, temporary) == 0 && rename(temporary, start) != 0)
        (void)unlink(temporary);
    rmap_free(start);
    rmap_free(temporary);
}

static enum rmap_status publish(struct index *self, const char *map_path, bool complete,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *final = rmap_path_format("%s/map.h5", map_path);
    char *temporary = rmap_temporary_path(map_path, "map.h5");
    if (!final || !temporary) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the index");
        goto out;
    }
    st = write_file(self, temporary, complete, err);
    if (st == RMAP_OK)
        st = rmap_publish_over(map_path, temporary, final, err);
    else
        (void)unlink(temporary);
    if (st == RMAP_OK && !complete)
        keep_start(map_path, final);
out:
    rmap_free(temporary);
    rmap_free(final);
    return st;
}

static void index_fini(struct index *self)
{
    rmap_h5_drop(&self->h5);
    rmap_map_content_fini(&self->content);
    rmap_map_spaces_fini(&self->spaces);
    rmap_tally_destroy(self->zeros);
    rmap_free(self->row);
}

enum rmap_status rmap_index_write_content(const char *map_path, const struct rmap_index *given,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct index self = {.h5 = {.file = H5I_INVALID_HID}, .run = given->run};
    RMAP_TRY(gather_history(&self, given, err));
    RMAP_TRY(gather_content(&self, map_path, given, err));
    RMAP_TRY(publish(&self, map_path, given->complete, err));
out:
    index_fini(&self);
    return st;
}

enum rmap_status rmap_index_write(const char *map_path, const struct rmap_run *run,
                                  const struct rmap_tally *tally, bool complete,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct index self = {.h5 = {.file = H5I_INVALID_HID}, .run = run, .tally = tally};
    struct rmap_run_row row = {.seed = run->seed, .n_rank = run->n_rank};
    struct rmap_index given = {.run = run, .row = &row};
    RMAP_TRY(gather_history(&self, &given, err));
    RMAP_TRY(rmap_map_scan(map_path, self.origin.seed, self.origin.tracer_revision,
                           self.origin.scene_digest, &self.spaces, &self.content, err));
    if (self.content.n_portion > 0)
        self.row->first_ray = self.content.portion[0].first_ray;
    self.row->n_ray = self.content.n_row[RMAP_TABLE_RAY];
    RMAP_TRY(publish(&self, map_path, complete, err));
out:
    index_fini(&self);
    return st;
}

enum rmap_status rmap_map_admit(const struct rmap_map *map, const struct rmap_run *run,
                                int32_t *space_ret, struct rmap_error *err)
{
    struct rmap_piece_origin origin;
    enum rmap_status st = rmap_piece_origin_of(run, &origin, err);
    if (st != RMAP_OK)
        return st;
    if (strcmp(origin.scene_digest, map->scene_digest) != 0)
        return rmap_error_set(err, RMAP_INPUT,
                              "%s holds rays of another scene: its text, its meshes or what was "
                              "chosen of it differ (only the colour space may)",
                              map->path);
    if (run->seed != map->summary.seed)
        return rmap_error_set(err, RMAP_INPUT, "%s was traced with seed %llu, not %llu", map->path,
                              (unsigned long long)map->summary.seed, (unsigned long long)run->seed);
    if (origin.tracer_revision != map->summary.tracer_revision)
        return rmap_error_set(err, RMAP_INPUT,
                              "%s has rays of tracer revision %d, and these are of %d, which makes "
                              "others of the same scene and seed: they do not go into one map",
                              map->path, (int)map->summary.tracer_revision,
                              (int)origin.tracer_revision);
    if (run->isa && strcmp(run->isa, map->summary.isa) != 0)
        return rmap_error_set(err, RMAP_INPUT,
                              "%s was traced with the instruction set %s, of which %s is the most "
                              "that can be had here: rays are the same only with one, so go on "
                              "where there is %s",
                              map->path, map->summary.isa, run->isa, map->summary.isa);
    int32_t space = rmap_map_spaces_find(&map->spaces, origin.space_digest);
    *space_ret = space >= 0 ? space : (int32_t)map->spaces.n;
    bool same = true;
    if (space >= 0)
        st = rmap_scene_numbers_same(run->scene, map->scene[space], &same, err);
    if (st == RMAP_OK && !same)
        st = rmap_error_set(err, RMAP_INPUT,
                            "%s was traced on a machine, or with a version, that computes other "
                            "numbers from the scene (sines, powers): rays would differ",
                            map->path);
    return st;
}
