/* SPDX-License-Identifier: MIT
 *
 * Rays that a map keeps by name.
 */
#include "io/map/named_rays.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "io/file/diagnostics.h"
#include "io/file/directory.h"
#include "io/file/publish.h"
#include "io/file/shell_word.h"
#include "io/hdf5/h5_inside.h"
#include "io/hdf5/h5_read.h"
#include "io/hdf5/h5_write.h"
#include "io/hdf5/table_h5.h"
#include "io/map/map_format.h"
#include "io/map/map_internal.h"
#include "io/map/provenance.h"

#define PREFIX "selection-"
static const char suffix[] = ".h5", id_path[] = "/ray/id", criterion_path[] = "/name/criterion";

/* ---- names ---- */

static bool is_name(const char *name)
{
    const size_t n = strlen(name);
    if (n == 0 || n >= RMAP_RAYS_NAME_NBYTES || isdigit((unsigned char)name[0]))
        return false;
    return strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") == n;
}

enum rmap_status rmap_rays_name_check(const char *name, struct rmap_error *err)
{
    return is_name(name)
               ? RMAP_OK
               : rmap_error_set(err, RMAP_USAGE,
                                "'%.80s' cannot name rays: letters, digits and '_', no digit "
                                "first, at most %d of them",
                                name, RMAP_RAYS_NAME_NBYTES - 1);
}

char *rmap_named_rays_path(const char *map_path, const char *name)
{
    return rmap_path_format("%s/" PREFIX "%s%s", map_path, name, suffix);
}

bool rmap_named_rays_name(const char *file, char name[RMAP_RAYS_NAME_NBYTES])
{
    const size_t n_prefix = strlen(PREFIX), n_suffix = strlen(suffix), n = strlen(file);
    if (n <= n_prefix + n_suffix || n - n_prefix - n_suffix >= RMAP_RAYS_NAME_NBYTES ||
        strncmp(file, PREFIX, n_prefix) != 0 || strcmp(file + n - n_suffix, suffix) != 0)
        return false;
    memcpy(name, file + n_prefix, n - n_prefix - n_suffix);
    name[n - n_prefix - n_suffix] = 0;
    return is_name(name);
}

void rmap_named_rays_fini(struct rmap_named_rays *rays)
{
    rmap_free(rays->criterion);
    rays->criterion = NULL;
}

/* ---- writing ---- */

static enum rmap_status put_ids(struct rmap_table_h5 *table, const struct rmap_id_set *set,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < set->n; i++)
        for (uint64_t bits = set->at[i].bits; bits && st == RMAP_OK; bits &= bits - 1) {
            const uint64_t id = 64 * set->at[i].word + (uint64_t)__builtin_ctzll(bits);
            st = rmap_table_h5_add(table, 0, &id, err);
        }
    return st;
}

enum rmap_status rmap_named_rays_write(const struct rmap_map *map, const char *name,
                                       const char *criterion, const struct rmap_id_set *set,
                                       struct rmap_error *err)
{
    static const int32_t version[2] = {RMAP_FORMAT_OLDEST, 0};
    static const struct rmap_table_h5_column column = {"ray", "id", RMAP_U64, "",
                                                       "ids of the rays that match, ascending"};
    enum rmap_status st = RMAP_OK;
    struct rmap_table_h5 *table = NULL;
    char digest[33];
    const uint64_t n = rmap_id_set_count(set);
    char *path = rmap_named_rays_path(map->path, name);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    rmap_digest_text(map->summary.digest, digest);
    RMAP_TRY(rmap_table_h5_begin(path, &column, 1, &table, err));
    struct rmap_h5 *h5 = rmap_table_h5_file(table);
    RMAP_TRY(rmap_h5_put_text(h5, "/", "filetype", RMAP_FILETYPE_NAMED_RAYS, err));
    RMAP_TRY(rmap_h5_put(h5, "/", "version", RMAP_I32, 2, version, err));
    RMAP_TRY(rmap_h5_put_text(h5, "/", "digest", digest, err));
    RMAP_TRY(rmap_h5_put(h5, "/", "rays", RMAP_U64, 1, &n, err));
    RMAP_TRY(rmap_table_h5_put_names(table, "criterion", &criterion, 1,
                                     "what they matched, as it was written", err));
    RMAP_TRY(put_ids(table, set, err));
    st = rmap_table_h5_finish(table, true, err);
out:
    rmap_table_h5_destroy(table);
    rmap_free(path);
    return st;
}

/* ---- reading ---- */

/* So many at a time. */
enum { IDS = 65536 };

static enum rmap_status add_ids(const uint64_t *id, size_t n, uint64_t *last, bool is_first,
                                struct rmap_h5 *h5, struct rmap_id_set *set, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < n && st == RMAP_OK; i++) {
        if (!(is_first && i == 0) && id[i] <= *last)
            return rmap_error_set(err, RMAP_FORMAT, "%s: %s does not ascend", h5->path, id_path);
        *last = id[i];
        st = rmap_id_set_add(set, id[i], err);
    }
    return st;
}

/* n: that there must be. */
static enum rmap_status read_ids(struct rmap_h5 *h5, uint64_t n, struct rmap_id_set *set,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t last = 0;
    hsize_t extent = 0;
    hid_t memory = H5I_INVALID_HID, dataset = rmap_h5_dataset(h5->file, id_path);
    hid_t space = dataset < 0 ? H5I_INVALID_HID : H5Dget_space(dataset);
    uint64_t *id = rmap_alloc(IDS, sizeof *id);
    if (!id)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for ids"));
    if (space < 0 || H5Sget_simple_extent_ndims(space) != 1 ||
        H5Sget_simple_extent_dims(space, &extent, NULL) != 1 || extent != n)
        RMAP_TRY(rmap_error_set(err, RMAP_FORMAT, "%s: %s has not the %llu ids that it should",
                                h5->path, id_path, (unsigned long long)n));
    for (hsize_t at = 0; at < extent; at += IDS) {
        const hsize_t count = extent - at < IDS ? extent - at : IDS;
        memory = H5Screate_simple(1, &count, NULL);
        const bool good =
            memory >= 0 &&
            H5Sselect_hyperslab(space, H5S_SELECT_SET, &at, NULL, &count, NULL) >= 0 &&
            H5Dread(dataset, H5T_NATIVE_UINT64, memory, space, H5P_DEFAULT, id) >= 0;
        (void)H5Sclose(memory);
        if (!good)
            RMAP_TRY(rmap_h5_fail(h5, id_path, err));
        RMAP_TRY(add_ids(id, (size_t)count, &last, at == 0, h5, set, err));
    }
out:
    rmap_free(id);
    if (space >= 0)
        (void)H5Sclose(space);
    if (dataset >= 0)
        (void)H5Dclose(dataset);
    return st;
}

static enum rmap_status read_head(const struct rmap_map *map, struct rmap_h5 *h5,
                                  struct rmap_named_rays *info, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *text = NULL, digest[33];
    size_t n = 0, width = 0;
    RMAP_TRY(rmap_provenance_check(h5, RMAP_FILETYPE_NAMED_RAYS, err));
    RMAP_TRY(rmap_h5_get_text(h5, "/", "digest", info->digest, sizeof info->digest, err));
    RMAP_TRY(rmap_h5_get(h5, "/", "rays", RMAP_U64, 1, &info->n_ray, err));
    RMAP_TRY(rmap_h5_read_names(h5, criterion_path, &text, &n, &width, err));
    if (n != 1)
        RMAP_TRY(
            rmap_error_set(err, RMAP_FORMAT, "%s: %s is not one text", h5->path, criterion_path));
    rmap_digest_text(map->summary.digest, digest);
    info->is_stale = strcmp(digest, info->digest) != 0;
    info->criterion = text;
    text = NULL;
out:
    rmap_free(text);
    return st;
}

/* set: NULL, only what the file says of itself is wanted. */
static enum rmap_status read_file(const struct rmap_map *map, const char *path,
                                  struct rmap_id_set *set, struct rmap_named_rays *info,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_h5 h5 = {.file = H5I_INVALID_HID};
    struct stat file;
    if (stat(path, &file) != 0)
        return rmap_error_set(err, errno == ENOENT ? RMAP_INPUT : RMAP_SYSTEM, "%s: %s", path,
                              strerror(errno));
    info->nbytes = (uint64_t)file.st_size;
    RMAP_TRY(rmap_h5_open(&h5, path, err));
    RMAP_TRY(read_head(map, &h5, info, err));
    if (set)
        st = read_ids(&h5, info->n_ray, set, err);
out:
    rmap_h5_drop(&h5);
    return st;
}

enum rmap_status rmap_named_rays_read(const struct rmap_map *map, const char *name,
                                      struct rmap_id_set *set, struct rmap_named_rays *info,
                                      struct rmap_error *err)
{
    struct rmap_named_rays own = {0};
    char *path = rmap_named_rays_path(map->path, name);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    (void)snprintf(own.name, sizeof own.name, "%s", name);
    enum rmap_status st = read_file(map, path, set, &own, err);
    if (st != RMAP_OK)
        rmap_id_set_fini(set);
    if (st == RMAP_OK && info)
        *info = own;
    else
        rmap_named_rays_fini(&own);
    rmap_free(path);
    return st;
}

/* ---- what there is ---- */

struct listing {
    const struct rmap_map *map;
    struct rmap_named_rays_list *list;
};

static enum rmap_status list_one(void *context, int directory, const char *file,
                                 struct rmap_error *err)
{
    (void)directory;
    const struct listing *self = context;
    struct rmap_named_rays_list *list = self->list;
    struct rmap_named_rays row = {0};
    if (!rmap_named_rays_name(file, row.name))
        return RMAP_OK;
    enum rmap_status st = RMAP_RESERVE(list->row, list->cap, list->n + 1, err);
    if (st != RMAP_OK)
        return st;
    char *path = rmap_named_rays_path(self->map->path, row.name);
    st = path ? read_file(self->map, path, NULL, &row, &row.why)
              : rmap_error_set(&row.why, RMAP_SYSTEM, "out of memory");
    rmap_free(path);
    if (st == RMAP_SYSTEM) {
        rmap_named_rays_fini(&row);
        return rmap_error_set(err, st, "%s", row.why.text);
    }
    if (st != RMAP_INPUT) /* it went while we looked */
        list->row[list->n++] = row;
    return RMAP_OK;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const struct rmap_named_rays *)a)->name,
                  ((const struct rmap_named_rays *)b)->name);
}

enum rmap_status rmap_named_rays_list(const struct rmap_map *map, struct rmap_named_rays_list *list,
                                      struct rmap_error *err)
{
    struct listing self = {map, list};
    *list = (struct rmap_named_rays_list){0};
    enum rmap_status st = rmap_directory_visit(map->path, list_one, &self, err);
    if (st != RMAP_OK)
        rmap_named_rays_list_fini(list);
    if (list->n > 0)
        qsort(list->row, list->n, sizeof *list->row, by_name);
    return st;
}

void rmap_named_rays_list_fini(struct rmap_named_rays_list *list)
{
    for (size_t i = 0; i < list->n; i++)
        rmap_named_rays_fini(&list->row[i]);
    rmap_free(list->row);
    *list = (struct rmap_named_rays_list){0};
}

/* ---- for criteria ---- */

struct kept_set {
    char name[RMAP_RAYS_NAME_NBYTES];
    char *criterion;
    struct rmap_id_set set;
};

struct rmap_kept_rays {
    struct rmap_ray_names names;
    struct rmap_map *map;
    struct kept_set **set; /* [n]: criteria borrow what they point to */
    size_t n, cap;
};

/* With the command that selects again. */
static enum rmap_status fail_stale(const struct rmap_map *map, const char *name,
                                   const char *criterion, struct rmap_error *err)
{
    char *again = NULL;
    size_t nbytes = 0;
    FILE *line = open_memstream(&again, &nbytes);
    if (line) {
        rmap_shell_word_put(line, map->path);
        rmap_shell_word_put(line, name);
        rmap_shell_word_put(line, criterion);
    }
    const bool is_written = line && fclose(line) == 0;
    const enum rmap_status st = rmap_error_set(
        err, RMAP_INPUT,
        "the map has other rays than when '%s' was selected; select them again: raymap select "
        "--force%s",
        name, is_written ? again : "");
    free(again);
    return st;
}

static enum rmap_status keep(struct rmap_kept_rays *self, const char *name,
                             const struct rmap_id_set **set_ret, struct rmap_error *err)
{
    struct rmap_named_rays info = {0};
    struct kept_set *kept = rmap_alloc(1, sizeof *kept);
    enum rmap_status st = RMAP_RESERVE(self->set, self->cap, self->n + 1, err);
    if (st == RMAP_OK && !kept)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for named rays");
    RMAP_TRY(st);
    (void)snprintf(kept->name, sizeof kept->name, "%s", name);
    st = rmap_named_rays_read(self->map, name, &kept->set, &info, err);
    if (st == RMAP_FORMAT && err)
        (void)strncat(err->text, "; raymap select --force selects again",
                      sizeof err->text - strlen(err->text) - 1);
    RMAP_TRY(st);
    if (info.is_stale) {
        st = fail_stale(self->map, name, info.criterion, err);
        rmap_id_set_fini(&kept->set);
        goto out;
    }
    *set_ret = &kept->set;
    kept->criterion = info.criterion;
    info.criterion = NULL;
    self->set[self->n++] = kept;
    kept = NULL;
out:
    rmap_named_rays_fini(&info);
    rmap_free(kept);
    return st;
}

static bool stands(const struct rmap_map *map, const char *name)
{
    struct stat file;
    char *path = rmap_named_rays_path(map->path, name);
    const bool is_there = !path || stat(path, &file) == 0 || errno != ENOENT;
    rmap_free(path);
    return is_there;
}

static enum rmap_status find(void *context, const char *name, const struct rmap_id_set **set_ret,
                             struct rmap_error *err)
{
    struct rmap_kept_rays *self = context;
    enum rmap_status st = RMAP_OK;
    *set_ret = NULL;
    if (!is_name(name))
        return RMAP_OK;
    (void)pthread_mutex_lock(&self->map->hdf5_lock);
    for (size_t i = 0; i < self->n; i++)
        if (strcmp(self->set[i]->name, name) == 0)
            *set_ret = &self->set[i]->set;
    if (!*set_ret && stands(self->map, name))
        st = keep(self, name, set_ret, err);
    (void)pthread_mutex_unlock(&self->map->hdf5_lock);
    return st;
}

static const char *words(void *context, const char *name)
{
    struct rmap_kept_rays *self = context;
    const char *found = NULL;
    (void)pthread_mutex_lock(&self->map->hdf5_lock);
    for (size_t i = 0; i < self->n; i++)
        if (strcmp(self->set[i]->name, name) == 0)
            found = self->set[i]->criterion;
    (void)pthread_mutex_unlock(&self->map->hdf5_lock);
    return found;
}

static char *near(void *context, const char *name)
{
    struct rmap_kept_rays *self = context;
    struct rmap_named_rays_list list;
    struct rmap_error ignored = {0};
    (void)pthread_mutex_lock(&self->map->hdf5_lock);
    const enum rmap_status st = rmap_named_rays_list(self->map, &list, &ignored);
    (void)pthread_mutex_unlock(&self->map->hdf5_lock);
    if (st != RMAP_OK)
        return NULL;
    const char **known = rmap_alloc(list.n + 1, sizeof *known);
    for (size_t i = 0; known && i < list.n; i++)
        known[i] = list.row[i].name;
    const char *found = known ? rmap_nearest_word(name, known, list.n) : NULL;
    char *own = found ? rmap_strdup(found) : NULL;
    rmap_free(known);
    rmap_named_rays_list_fini(&list);
    return own;
}

enum rmap_status rmap_map_offer_named_rays(struct rmap_map *map, struct rmap_error *err)
{
    struct rmap_kept_rays *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a map");
    self->map = map;
    self->names = (struct rmap_ray_names){self, find, words, near};
    map->kept_rays = self;
    for (size_t i = 0; i < map->spaces.n; i++) {
        map->scene[i]->ray_names = &self->names;
        map->scene[i]->seed = map->summary.seed;
        map->scene[i]->is_mixed = map->spaces.n > 1;
    }
    return RMAP_OK;
}

void rmap_kept_rays_destroy(struct rmap_kept_rays *self)
{
    if (!self)
        return;
    for (size_t i = 0; i < self->n; i++) {
        rmap_id_set_fini(&self->set[i]->set);
        rmap_free(self->set[i]->criterion);
        rmap_free(self->set[i]);
    }
    rmap_free(self->set);
    rmap_free(self);
}
