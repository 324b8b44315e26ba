/* SPDX-License-Identifier: MIT
 *
 * What is there to be verified: the index if it opens, else what can be read of it and the pieces
 * on disk.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/file/directory.h"
#include "io/file/publish.h"
#include "io/hdf5/h5_read.h"
#include "io/map/map_directory.h"
#include "io/map/map_internal.h"
#include "io/map/map_run.h"
#include "io/map/map_scan.h"
#include "io/map/portion_rows.h"
#include "io/map/provenance.h"
#include "io/recovery/verify.h"
#include "io/recovery/verify_columns.h"
#include "io/recovery/verify_named.h"

static enum rmap_status verify_extra_pieces(struct rmap_verification *self,
                                            const struct rmap_piece_name *name, size_t n,
                                            struct rmap_findings *findings,
                                            struct rmap_error *err) RMAP_MUST_USE;
static enum rmap_status verify_missing_shards(struct rmap_verification *self,
                                              struct rmap_findings *findings,
                                              struct rmap_error *err) RMAP_MUST_USE;

void rmap_finding_add_piece(struct rmap_finding *finding, const struct rmap_map_content *content,
                            size_t piece)
{
    for (size_t i = 0; i < content->n_portion; i++)
        if ((size_t)content->portion[i].piece == piece)
            rmap_finding_add_portion(finding, &content->portion[i]);
}

void rmap_finding_add_portion(struct rmap_finding *finding, const struct rmap_portion_info *portion)
{
    uint64_t n = portion->n_row[RMAP_TABLE_RAY], before = finding->n_ray;
    if (n == 0)
        return;
    rmap_finding_add_rays(finding, portion->first_ray,
                          rmap_portion_end(portion) - portion->first_ray);
    finding->n_ray = before + n;
}

void rmap_verification_flag_piece(struct rmap_verification *self, size_t piece, int flag)
{
    (void)pthread_mutex_lock(&self->lock);
    self->piece_flag[piece] |= (uint8_t)flag;
    (void)pthread_mutex_unlock(&self->lock);
    for (size_t i = 0; flag == RMAP_PIECE_GONE && i < self->content->n_portion; i++)
        if ((size_t)self->content->portion[i].piece == piece)
            rmap_verification_flag_portion(self, i, RMAP_PORTION_LOST);
}

void rmap_verification_flag_portion(struct rmap_verification *self, size_t portion, int flag)
{
    (void)pthread_mutex_lock(&self->lock);
    self->portion_flag[portion] |= (uint8_t)flag;
    (void)pthread_mutex_unlock(&self->lock);
}

/* ---- without a usable index ---- */

/* Each dataset of a table for itself, so that the damaged one is named. */
static enum rmap_status read_table(struct rmap_h5 *h5, struct rmap_field_table table,
                                   size_t row_nbytes, void **row, size_t *n,
                                   struct rmap_findings *findings, struct rmap_error *err)
{
    bool good = true;
    for (size_t i = 0; i < table.n; i++) {
        struct rmap_error why = {0};
        void *one = NULL;
        size_t n_one = 0;
        enum rmap_status st =
            rmap_h5_read_fields(h5, &table.field[i], 1, row_nbytes, &one, &n_one, &why);
        rmap_free(one);
        good = good && st == RMAP_OK;
        st = rmap_findings_take(findings, "map.h5", table.field[i].path, st, &why, err);
        if (st != RMAP_OK)
            return st;
    }
    enum rmap_status st =
        good ? rmap_h5_read_fields(h5, table.field, table.n, row_nbytes, row, n, err) : RMAP_OK;
    if (st != RMAP_OK)
        *n = 0;
    return st == RMAP_SYSTEM ? st : RMAP_OK;
}

/* The index's tables, unchecked. What cannot be read stays empty. */
static enum rmap_status read_raw(struct rmap_verification *self, struct rmap_findings *findings,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_h5 h5 = {.file = H5I_INVALID_HID};
    struct rmap_map_content *raw = &self->raw;
    void *piece = NULL, *portion = NULL, *chunk = NULL;
    struct rmap_portion_info *whole = NULL;
    struct stat info;
    size_t n_whole = 0;
    char *path = rmap_path_format("%s/map.h5", self->path);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    st = rmap_path_look(path, &info, err);
    if (info.st_mode != 0)
        st = rmap_h5_open(&h5, path, err);
    if (h5.file < 0) { /* opening the map said so already */
        st = st == RMAP_SYSTEM ? st : RMAP_OK;
        goto out;
    }
    bool curved = rmap_provenance_is_curved(&h5);
    RMAP_TRY(read_table(&h5, rmap_piece_fields(curved), sizeof *raw->piece, &piece, &raw->n_piece,
                        findings, err));
    raw->piece = piece;
    RMAP_TRY(read_table(&h5, rmap_portion_fields_index(curved), sizeof *raw->portion, &portion,
                        &raw->n_portion, findings, err));
    raw->portion = portion;
    if (raw->n_portion > 0 &&
        rmap_portion_rows_read(&h5, rmap_portion_fields_index(curved), &whole, &n_whole, NULL) ==
            RMAP_OK) { /* with last ids, if it has any */
        rmap_free(raw->portion);
        raw->portion = whole;
        raw->n_portion = n_whole;
    }
    RMAP_TRY(read_table(&h5, rmap_chunk_fields(), sizeof *raw->chunk, &chunk, &raw->n_chunk,
                        findings, err));
    raw->chunk = chunk;
    for (size_t i = 0; i < raw->n_piece; i++) {
        struct rmap_piece_info *one = &raw->piece[i];
        bool named =
            one->shard >= 0 && one->shard <= 99999 && one->number >= 0 && one->number <= 99999;
        if (!named || one->first_chunk > raw->n_chunk ||
            one->n_chunk > raw->n_chunk - one->first_chunk)
            raw->n_piece = 0;
        else
            rmap_piece_name_set(one);
    }
out:
    rmap_h5_drop(&h5);
    rmap_free(path);
    return st;
}

/* All pieces that stand on disk and open. */
static enum rmap_status read_disk(struct rmap_verification *self,
                                  const struct rmap_piece_name *name, size_t n,
                                  struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    self->mode = rmap_alloc(n, 1);
    if (!self->mode)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    for (size_t i = 0; i < n && st == RMAP_OK; i++) {
        struct rmap_error why = {0};
        struct rmap_piece_origin origin = {0};
        struct rmap_piece_info info = {.shard = name[i].shard, .number = name[i].number};
        st = rmap_piece_read(self->path, name[i].shard, name[i].number, &self->disk, &origin, &why);
        if (st == RMAP_OK)
            self->mode[self->disk.n_piece - 1] = (uint8_t)origin.mode;
        rmap_piece_name_set(&info);
        st = rmap_findings_take(findings, info.name, "", st, &why, err);
    }
    return st;
}

/* ---- opening ---- */

/* Names, sums and pieces may all fit a scene that was put in the place of the one that was traced.
 */
static enum rmap_status check_scene(const struct rmap_map *map, const char *file,
                                    struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_error why = {0};
    enum rmap_status st = rmap_map_check_scene(map, &why);
    return rmap_findings_take(findings, file, "/scene/bundle", st, &why, err);
}

static enum rmap_status open_map(struct rmap_verification *self, const char *path,
                                 struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_error why = {0};
    struct rmap_finding finding;
    struct stat at_index = {0}, at_first = {0};
    enum rmap_status st = rmap_map_open_untallied(path, &self->map, &why);
    if (st == RMAP_OK) {
        self->map->takes_cut = true; /* of such pieces, chunks that are whole are used */
        return check_scene(self->map, "map.h5", findings, err);
    }
    char *index = rmap_path_format("%s/map.h5", path);
    char *first = rmap_path_format("%s/shard-00000", path);
    if (!index || !first)
        st = rmap_error_set(&why, RMAP_SYSTEM, "out of memory");
    else if (st == RMAP_FORMAT && (rmap_path_look(index, &at_index, &why) == RMAP_SYSTEM ||
                                   rmap_path_look(first, &at_first, &why) == RMAP_SYSTEM))
        st = RMAP_SYSTEM;
    if (st == RMAP_FORMAT && (at_index.st_mode != 0 || at_first.st_mode != 0)) {
        rmap_finding_set(&finding, "map.h5", "", "%s", why.text);
        st = rmap_findings_add(findings, &finding, err);
    } else if (err) {
        *err = why;
    }
    rmap_free(index);
    rmap_free(first);
    return st;
}

/* An index from before the last run, as out of a backup: it knows neither the rays that this one
 * was asked for nor their colour space. Looked at once more, as a run may begin just now. */
static enum rmap_status check_age(const struct rmap_verification *self,
                                  const struct rmap_map *start, struct rmap_findings *findings,
                                  struct rmap_error *err)
{
    struct rmap_finding finding;
    struct rmap_map *now = NULL;
    size_t n = 0;
    if (!self->map || rmap_map_n_run_after(self->map, start) == 0)
        return RMAP_OK;
    enum rmap_status st = rmap_map_open_bare(self->path, "map.h5", &now, err);
    if (st == RMAP_OK)
        n = rmap_map_n_run_after(now, start);
    if (n > 0) {
        rmap_finding_set(&finding, "map.h5", "",
                         "is older than " RMAP_INDEX_START ", which knows of %s more",
                         rmap_counted(n, "run").text);
        st = rmap_findings_add(findings, &finding, err);
    }
    rmap_map_close(now);
    return st;
}

/* What is there for the day when the index is lost; not every file system lets it be made. */
static enum rmap_status check_start(const struct rmap_verification *self,
                                    struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_error why = {0};
    struct rmap_map *map = NULL;
    struct stat info;
    char *start = rmap_path_format("%s/" RMAP_INDEX_START, self->path);
    if (!start)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    if (stat(start, &info) == 0 || errno != ENOENT)
        st = rmap_map_open_bare(self->path, RMAP_INDEX_START, &map, &why);
    st = rmap_findings_take(findings, RMAP_INDEX_START, "", st, &why, err);
    if (st == RMAP_OK && map)
        st = check_scene(map, RMAP_INDEX_START, findings, err);
    if (st == RMAP_OK && map)
        st = check_age(self, map, findings, err);
    rmap_map_close(map);
    rmap_free(start);
    return st;
}

/* Which file of the map a trouble's text is about, if it begins with one; returns the rest. */
static const char *split_trouble(const char *text, const char *map_path, char *file, size_t cap)
{
    const size_t n_path = strlen(map_path);
    const char *name = strncmp(text, map_path, n_path) == 0 ? text + n_path : text;
    name += *name == '/';
    const size_t n = strcspn(name, ": ");
    file[0] = 0;
    if (strncmp(name, "shard-", 6) != 0 || n >= cap)
        return text;
    memcpy(file, name, n);
    file[n] = 0;
    name += n + strspn(name + n, ": ");
    return strncmp(name, "and ", 4) == 0 ? text : name; /* two pieces are told of */
}

/* Pieces and journals beside an incomplete index that cannot be used. */
static enum rmap_status add_trouble(struct rmap_verification *self, struct rmap_findings *findings,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; self->map && i < rmap_map_n_trouble(self->map) && st == RMAP_OK; i++) {
        struct rmap_finding finding;
        char file[sizeof finding.file];
        const char *text =
            split_trouble(rmap_map_trouble(self->map, i), self->path, file, sizeof file);
        rmap_finding_set(&finding, file, "", "%s", text);
        st = rmap_findings_add(findings, &finding, err);
    }
    return st;
}

static int by_first_chunk(const void *a, const void *b)
{
    const struct rmap_chunk_owner *x = a, *y = b;
    return (x->first_chunk > y->first_chunk) - (x->first_chunk < y->first_chunk);
}

/* Pieces are in the order of shards and numbers, their chunks in that of their finding. */
static enum rmap_status list_owners(struct rmap_verification *self, struct rmap_error *err)
{
    const struct rmap_map_content *content = self->content;
    self->owner = rmap_alloc(content->n_piece, sizeof *self->owner);
    if (!self->owner)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of pieces");
    for (size_t i = 0; i < content->n_piece; i++)
        if (content->piece[i].n_chunk > 0)
            self->owner[self->n_owner++] =
                (struct rmap_chunk_owner){content->piece[i].first_chunk, i};
    if (self->n_owner > 0)
        qsort(self->owner, self->n_owner, sizeof *self->owner, by_first_chunk);
    return RMAP_OK;
}

static enum rmap_status make_flags(struct rmap_verification *self, struct rmap_error *err)
{
    const struct rmap_map_content *content = self->content;
    self->piece_flag = rmap_alloc(content->n_piece, 1);
    self->portion_flag = rmap_alloc(content->n_portion, 1);
    if (!self->mode)
        self->mode = rmap_alloc(content->n_piece, 1);
    if (!self->piece_flag || !self->portion_flag || !self->mode)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of pieces");
    for (size_t i = 0; self->map && i < content->n_piece; i++)
        self->mode[i] = (uint8_t)self->map->spaces.space[content->piece[i].space].mode;
    return RMAP_OK;
}

enum rmap_status rmap_verification_open(const char *path, struct rmap_verification **self_ret,
                                        struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_piece_name *name = NULL;
    size_t n = 0;
    struct rmap_verification *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    (void)pthread_mutex_init(&self->lock, NULL);
    self->path = rmap_strdup(path);
    if (!self->path) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        goto out;
    }
    RMAP_TRY(open_map(self, path, findings, err));
    RMAP_TRY(check_start(self, findings, err));
    RMAP_TRY(rmap_map_list_pieces(path, &name, &n, err));
    if (!self->map) {
        RMAP_TRY(read_raw(self, findings, err));
        RMAP_TRY(read_disk(self, name, n, findings, err));
    }
    self->content = self->map ? &self->map->content : &self->disk;
    self->claimed = self->map ? &self->map->content : &self->raw;
    RMAP_TRY(make_flags(self, err));
    RMAP_TRY(list_owners(self, err));
    RMAP_TRY(add_trouble(self, findings, err));
    RMAP_TRY(verify_missing_shards(self, findings, err));
    RMAP_TRY(verify_extra_pieces(self, name, n, findings, err));
    RMAP_TRY(rmap_verify_stray_columns(self, name, n, findings, err));
    if (self->map)
        RMAP_TRY(rmap_verify_named_rays(self->map, findings, err));
    *self_ret = self;
    self = NULL;
out:
    rmap_free(name);
    rmap_verification_close(self);
    return st;
}

void rmap_verification_close(struct rmap_verification *self)
{
    if (!self)
        return;
    (void)pthread_mutex_destroy(&self->lock);
    rmap_map_close(self->map);
    rmap_map_content_fini(&self->disk);
    rmap_map_content_fini(&self->raw);
    rmap_free(self->mode);
    rmap_free(self->piece_flag);
    rmap_free(self->portion_flag);
    rmap_free(self->owner);
    rmap_free(self->path);
    rmap_free(self);
}

/* Which files of a map are missing, or known to nobody. */

static const struct rmap_piece_info *find_piece(const struct rmap_map_content *content, int shard,
                                                int number)
{
    for (size_t i = 0; i < content->n_piece; i++)
        if (content->piece[i].shard == shard && (number < 0 || content->piece[i].number == number))
            return &content->piece[i];
    return NULL;
}

/* One finding per shard directory that is not there; one per piece on disk, of
 * which the list is all, that the index of a complete map does not know. */
static enum rmap_status verify_missing_shards(struct rmap_verification *self,
                                              struct rmap_findings *findings,
                                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map_content *claimed = self->claimed;
    for (size_t i = 0; i < claimed->n_piece && st == RMAP_OK; i++) {
        struct stat info;
        int shard = claimed->piece[i].shard;
        if (i > 0 && claimed->piece[i - 1].shard == shard)
            continue;
        char *path = rmap_path_format("%s/shard-%05d", self->path, shard);
        if (!path)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        bool gone = stat(path, &info) != 0 && errno == ENOENT; /* else its pieces tell */
        rmap_free(path);
        if (!gone)
            continue;
        struct rmap_finding finding;
        char name[32];
        size_t n = 0;
        (void)snprintf(name, sizeof name, "shard-%05d", shard);
        for (size_t k = 0; k < claimed->n_piece; k++)
            n += claimed->piece[k].shard == shard;
        rmap_finding_set(&finding, name, "", "the shard is missing, with %s of it",
                         rmap_counted(n, "piece").text);
        for (size_t k = 0; k < claimed->n_portion; k++)
            if (claimed->portion[k].shard == shard)
                rmap_finding_add_portion(&finding, &claimed->portion[k]);
        st = rmap_findings_add(findings, &finding, err);
        for (size_t k = 0; self->map && k < claimed->n_piece; k++)
            if (claimed->piece[k].shard == shard)
                rmap_verification_flag_piece(self, k, RMAP_PIECE_GONE);
    }
    return st;
}

static enum rmap_status extra_piece(const struct rmap_verification *self,
                                    const struct rmap_piece_name *name,
                                    struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_piece_info info = {.shard = name->shard, .number = name->number};
    struct rmap_map_content content = {0};
    struct rmap_piece_origin origin = {0};
    struct rmap_error why = {0};
    struct rmap_finding finding;
    rmap_piece_name_set(&info);
    const char *shard =
        find_piece(self->claimed, name->shard, -1) ? "" : ", nor any other piece of its shard";
    enum rmap_status st =
        rmap_piece_read(self->path, name->shard, name->number, &content, &origin, &why);
    if (st == RMAP_SYSTEM)
        return rmap_error_set(err, st, "%s", why.text);
    if (st != RMAP_OK)
        rmap_finding_set(&finding, info.name, "",
                         "map.h5 does not list it%s, and it is damaged: %s", shard, why.text);
    else
        rmap_finding_set(&finding, info.name, "",
                         "map.h5 does not list it%s: extra, with %s from ray %llu on", shard,
                         rmap_counted(content.piece[0].n_row[RMAP_TABLE_RAY], "ray").text,
                         content.n_portion ? (unsigned long long)content.portion[0].first_ray : 0);
    rmap_map_content_fini(&content);
    return rmap_findings_add(findings, &finding, err);
}

/* A map in the making has pieces that its index does not know yet: they are part of it. */
static enum rmap_status verify_extra_pieces(struct rmap_verification *self,
                                            const struct rmap_piece_name *name, size_t n,
                                            struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (self->map && !self->map->summary.complete)
        return RMAP_OK;
    for (size_t i = 0; i < n && st == RMAP_OK && self->claimed->n_piece > 0; i++)
        if (!find_piece(self->claimed, name[i].shard, name[i].number))
            st = extra_piece(self, &name[i], findings, err);
    return st;
}
