/* SPDX-License-Identifier: MIT
 *
 * The ids of all matching rays as a fold (fold.h).
 */
#include "analysis/query/id_fold.h"

#include <string.h>

#include "base/alloc.h"
#include "base/id_set.h"

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    (void)context;
    *state_ret = rmap_alloc(1, sizeof(struct rmap_id_set));
    return *state_ret ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory for ids");
}

static void destroy(void *state)
{
    if (state)
        rmap_id_set_fini(state);
    rmap_free(state);
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    const struct rmap_portion *portion = rays->portion;
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; st == RMAP_OK && i < portion->n_row[RMAP_TABLE_RAY]; i++)
        if (!rays->match || rays->match[i])
            st = rmap_id_set_add(state, portion->ray.id[i], err);
    return st;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    const struct rmap_id_set *more = from;
    return rmap_id_set_add_words(into, more->at, more->n, err);
}

static enum rmap_status pack(const void *state, uint8_t **bytes_ret, size_t *nbytes_ret,
                             struct rmap_error *err)
{
    const struct rmap_id_set *self = state;
    const size_t nbytes = self->n * sizeof *self->at;
    uint8_t *bytes = rmap_alloc(nbytes + 1, 1);
    if (!bytes)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for ids");
    if (nbytes > 0)
        memcpy(bytes, self->at, nbytes);
    *bytes_ret = bytes;
    *nbytes_ret = nbytes;
    return RMAP_OK;
}

static enum rmap_status unpack(const void *context, const uint8_t *bytes, size_t nbytes,
                               void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = create(context, state_ret, err);
    for (size_t at = 0; st == RMAP_OK && at < nbytes; at += sizeof(struct rmap_id_word)) {
        struct rmap_id_word word;
        memcpy(&word, bytes + at, sizeof word);
        st = rmap_id_set_add_words(*state_ret, &word, 1, err);
    }
    return st;
}

const struct rmap_fold_kind rmap_id_fold_kind = {.create = create,
                                                 .destroy = destroy,
                                                 .add = add,
                                                 .merge = merge,
                                                 .pack = pack,
                                                 .unpack = unpack};
