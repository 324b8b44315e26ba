/* SPDX-License-Identifier: MIT
 *
 * Portions on their way to a shard: the rows of its encoding.
 */
#include "io/write/row_encoder.h"

#include <pthread.h>

#include "base/alloc.h"
#include "compact/encoder.h"
#include "compact/model.h"
#include "compact/path_book.h"
#include "io/write/row_parts.h"

struct rmap_row_slot {
    struct rmap_row_slot *next;
    struct rmap_row_pool *pool;
    const struct rmap_portion *portion;   /* plain, in one */
    struct rmap_row_parts *parts;         /* plain, in parts */
    struct rmap_compact_encoder *encoder; /* NULL: plain */
};

struct rmap_row_pool {
    enum rmap_colour_mode mode;
    uint64_t seed;
    struct rmap_compact_model *model; /* NULL: plain */
    pthread_mutex_t lock;             /* of idle */
    struct rmap_row_slot *idle;
};

enum rmap_status rmap_row_pool_create(const struct rmap_run *run, struct rmap_row_pool **pool_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!rmap_layout_of(run->encoding, run->scene->channels.mode))
        return rmap_error_set(err, RMAP_USAGE, "this program does not write the encoding '%s'",
                              rmap_encoding_name(run->encoding));
    struct rmap_row_pool *pool = rmap_alloc(1, sizeof *pool);
    if (!pool)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a shard");
    pool->mode = run->scene->channels.mode;
    pool->seed = run->seed;
    (void)pthread_mutex_init(&pool->lock, NULL);
    if (run->encoding == RMAP_ENCODING_COMPACT)
        st = rmap_compact_model_create(run->scene, &pool->model, err);
    if (st == RMAP_OK)
        *pool_ret = pool;
    else
        rmap_row_pool_destroy(pool);
    return st;
}

static void destroy_slot(struct rmap_row_slot *slot)
{
    rmap_compact_encoder_destroy(slot->encoder);
    rmap_row_parts_destroy(slot->parts);
    rmap_free(slot);
}

void rmap_row_pool_destroy(struct rmap_row_pool *pool)
{
    if (!pool)
        return;
    for (struct rmap_row_slot *slot = pool->idle, *next; slot; slot = next) {
        next = slot->next;
        destroy_slot(slot);
    }
    rmap_compact_model_destroy(pool->model);
    (void)pthread_mutex_destroy(&pool->lock);
    rmap_free(pool);
}

enum rmap_status rmap_row_pool_book(const struct rmap_row_pool *pool,
                                    struct rmap_path_book **book_ret, struct rmap_error *err)
{
    *book_ret = NULL;
    return pool->model ? rmap_path_book_create(book_ret, err) : RMAP_OK;
}

static enum rmap_status take_slot(struct rmap_row_pool *pool, struct rmap_row_slot **slot_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    (void)pthread_mutex_lock(&pool->lock);
    struct rmap_row_slot *slot = pool->idle;
    if (slot)
        pool->idle = slot->next;
    (void)pthread_mutex_unlock(&pool->lock);
    if (!slot) {
        slot = rmap_alloc(1, sizeof *slot);
        if (!slot)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for an encoder");
        slot->pool = pool;
        st = pool->model ? rmap_compact_encoder_create(pool->model, &slot->encoder, err)
                         : rmap_row_parts_create(pool->mode, &slot->parts, err);
        if (st != RMAP_OK) {
            destroy_slot(slot);
            return st;
        }
    }
    *slot_ret = slot;
    return RMAP_OK;
}

enum rmap_status rmap_row_pool_encode(struct rmap_row_pool *pool,
                                      const struct rmap_portion *portion,
                                      struct rmap_row_slot **slot_ret, struct rmap_error *err)
{
    enum rmap_status st = take_slot(pool, slot_ret, err);
    if (st != RMAP_OK)
        return st;
    struct rmap_row_slot *slot = *slot_ret;
    slot->portion = portion;
    if (slot->encoder)
        st = rmap_compact_encode(slot->encoder, pool->seed, portion, err);
    if (st != RMAP_OK) {
        rmap_row_slot_give_back(slot);
        *slot_ret = NULL;
    }
    return st;
}

bool rmap_row_pool_in_parts(const struct rmap_row_pool *pool)
{
    return !pool->model || rmap_compact_in_parts(pool->model);
}

enum rmap_status rmap_row_pool_begin(struct rmap_row_pool *pool, uint64_t first_ray,
                                     struct rmap_row_slot **slot_ret, struct rmap_error *err)
{
    enum rmap_status st = take_slot(pool, slot_ret, err);
    if (st == RMAP_OK && pool->model)
        rmap_compact_encode_begin((*slot_ret)->encoder, pool->seed, first_ray);
    return st;
}

enum rmap_status rmap_row_slot_part(struct rmap_row_slot *slot, const struct rmap_portion *part,
                                    bool *whole_ret, struct rmap_error *err)
{
    *whole_ret = false;
    return slot->encoder ? rmap_compact_encode_part(slot->encoder, part, whole_ret, err)
                         : rmap_row_parts_add(slot->parts, part, err);
}

enum rmap_status rmap_row_slot_end(struct rmap_row_slot *slot, bool *whole_ret,
                                   struct rmap_error *err)
{
    *whole_ret = false;
    return slot->encoder ? rmap_compact_encode_end(slot->encoder, whole_ret, err) : RMAP_OK;
}

size_t rmap_row_slot_count(const struct rmap_row_slot *slot)
{
    return slot->encoder || slot->portion ? 1 : rmap_row_parts_count(slot->parts);
}

enum rmap_status rmap_row_slot_rows(struct rmap_row_slot *slot, struct rmap_path_book *book,
                                    size_t i, struct rmap_rows *rows, struct rmap_error *err)
{
    if (slot->encoder)
        return rmap_compact_resolve(slot->encoder, book, rows, err);
    if (slot->portion)
        rmap_rows_of_portion(slot->portion, slot->pool->mode, rows);
    else
        rmap_row_parts_rows(slot->parts, i, rows);
    return RMAP_OK;
}

void rmap_row_slot_give_back(struct rmap_row_slot *slot)
{
    if (!slot)
        return;
    struct rmap_row_pool *pool = slot->pool;
    slot->portion = NULL;
    if (slot->parts)
        rmap_row_parts_clear(slot->parts);
    (void)pthread_mutex_lock(&pool->lock);
    slot->next = pool->idle;
    pool->idle = slot;
    (void)pthread_mutex_unlock(&pool->lock);
}
