/* SPDX-License-Identifier: MIT
 *
 * Whether history indexes are sound, and say of the rays what the columns say.
 */
#include <string.h>

#include "base/alloc.h"
#include "history/history_gather.h"
#include "history/history_view.h"
#include "io/map/history_file.h"
#include "io/map/map_directory.h"
#include "io/map/map_format.h"
#include "io/map/map_history.h"
#include "io/recovery/verify.h"
#include "io/recovery/verify_history.h"

static void name_history(const struct rmap_piece_info *piece, char name[288])
{
    size_t n = strlen(piece->name) - strlen(".h5");
    memcpy(name, piece->name, n);
    memcpy(name + n, RMAP_HISTORY_SUFFIX, sizeof RMAP_HISTORY_SUFFIX);
}

static enum rmap_status tell(const struct rmap_piece_info *piece,
                             const struct rmap_portion_info *portion, const char *text,
                             struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_finding finding;
    char name[288];
    name_history(piece, name);
    rmap_finding_set(&finding, name, "", "%s", text);
    if (portion)
        rmap_finding_add_rays(&finding, portion->first_ray, portion->n_row[RMAP_TABLE_RAY]);
    return rmap_findings_add(findings, &finding, err);
}

enum rmap_status rmap_verify_history_file(struct rmap_verification *self, size_t piece,
                                          struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_error why = {0};
    enum rmap_status st = rmap_map_history_open(self->map, piece, NULL, &why);
    if (st == RMAP_FORMAT)
        return tell(&self->content->piece[piece], NULL, why.text, findings, err);
    if (st == RMAP_SYSTEM && err)
        *err = why;
    return st == RMAP_SYSTEM ? st : RMAP_OK;
}

static bool same_column(const struct rmap_portion *a, const struct rmap_portion *b,
                        enum rmap_column column)
{
    size_t nbytes = a->n_row[rmap_column_info(column)->table] * rmap_portion_row_nbytes(a, column);
    return nbytes == 0 ||
           memcmp(rmap_portion_column(a, column), rmap_portion_column(b, column), nbytes) == 0;
}

static bool same_weights(const struct rmap_history_view *view, const struct rmap_portion *rays)
{
    size_t others = 0;
    for (size_t i = 0; i < rays->n_row[RMAP_TABLE_RAY]; i++)
        others += rays->ray.weight[i] != 1.0;
    return view->unit_weight == (others == 0);
}

/* NULL: it says the same. */
static const char *compare(const struct rmap_history_view *view, const struct rmap_portion *rays,
                           const struct rmap_portion *said)
{
    size_t n_registration = rays->n_row[RMAP_TABLE_REGISTRATION];
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (RMAP_COLUMNS_DISCRETE & RMAP_COLUMN_BIT(c) &&
            !same_column(rays, said, (enum rmap_column)c))
            return rmap_column_info((enum rmap_column)c)->path;
    if (!same_weights(view, rays))
        return rmap_column_info(RMAP_RAY_weight)->path;
    if (view->relative &&
        memcmp(view->relative, rays->registration.relative, 4 * n_registration) != 0)
        return rmap_column_info(RMAP_REGISTRATION_relative)->path;
    return NULL;
}

static enum rmap_status check(const struct rmap_history_index *index, size_t at,
                              const struct rmap_portion *rays, char *text, size_t text_len,
                              struct rmap_error *err)
{
    struct rmap_history_view view = {0};
    struct rmap_error why = {0};
    struct rmap_portion *said = rmap_alloc(1, sizeof *said);
    enum rmap_status st =
        said ? RMAP_OK : rmap_error_set(&why, RMAP_SYSTEM, "out of memory for a portion");
    if (st == RMAP_OK)
        st = rmap_history_view_open(index, at, &view, &why);
    if (st == RMAP_OK)
        st = rmap_history_unfold(&view, RMAP_COLUMNS_DISCRETE, said, &why);
    if (st == RMAP_FORMAT) {
        (void)snprintf(text, text_len, "%s", why.text);
        st = RMAP_OK;
    } else if (st == RMAP_OK) {
        const char *column = compare(&view, rays, said);
        if (column)
            (void)snprintf(text, text_len,
                           "says another thing of them than %s: make it again with raymap index "
                           "--force",
                           column);
    } else if (err) {
        *err = why;
    }
    rmap_portion_destroy(said);
    rmap_history_view_fini(&view);
    return st;
}

enum rmap_status rmap_verify_history(struct rmap_verification *self, size_t portion,
                                     const struct rmap_portion *rays,
                                     struct rmap_findings *findings, struct rmap_error *err)
{
    const struct rmap_portion_info *info = &self->content->portion[portion];
    const struct rmap_history_index *index;
    char text[RMAP_ERROR_TEXT_LEN] = "";
    enum rmap_status st = rmap_map_history(self->map, (size_t)info->piece, &index, err);
    if (st != RMAP_OK || !index)
        return st;
    size_t at = rmap_history_find(index, info->first_ray, info->n_row, info->digest);
    if (at != SIZE_MAX)
        st = check(index, at, rays, text, sizeof text, err);
    rmap_map_history_release(self->map, (size_t)info->piece);
    return st == RMAP_OK && text[0]
               ? tell(&self->content->piece[info->piece], info, text, findings, err)
               : st;
}

enum rmap_status rmap_verify_stray_histories(struct rmap_verification *self,
                                             const struct rmap_piece_name *piece, size_t n_piece,
                                             struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_piece_name *name = NULL;
    size_t n = 0, at = 0;
    enum rmap_status st = rmap_map_list_histories(self->path, &name, &n, err);
    for (size_t i = 0; i < n && st == RMAP_OK; i++) {
        struct rmap_piece_info info = {.shard = name[i].shard, .number = name[i].number};
        while (at < n_piece && (piece[at].shard < info.shard ||
                                (piece[at].shard == info.shard && piece[at].number < info.number)))
            at++;
        rmap_piece_name_set(&info);
        if (at == n_piece || piece[at].shard != info.shard || piece[at].number != info.number)
            st = tell(&info, NULL, "the piece that it belongs to is not there", findings, err);
    }
    rmap_free(name);
    return st;
}
