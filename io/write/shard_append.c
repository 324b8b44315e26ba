/* SPDX-License-Identifier: MIT
 *
 * Traced blocks on their way into a shard's buffers.
 */
#include "io/write/shard_append.h"
#include "base/alloc.h"
#include "io/codec/shuffle.h"
#include "io/write/shard_internal.h"

static enum rmap_status begin_piece(struct rmap_shard_writer *self, struct rmap_error *err)
{
    if (self->piece)
        return RMAP_OK;
    self->piece = rmap_alloc(1, sizeof *self->piece);
    if (!self->piece)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a piece");
    enum rmap_status st = rmap_row_pool_book(self->rows, &self->piece->book, err);
    if (st == RMAP_OK)
        self->piece->number = self->next_number++;
    return st;
}

/* Shuffles a block's rows of one stream into buffers, handing them over as they fill. */
static enum rmap_status append_stream(struct rmap_shard_writer *self, int stream,
                                      const struct rmap_rows *rows, struct rmap_error *err)
{
    const struct rmap_stream_info *info = &rows->layout->stream[stream];
    size_t row = rmap_stream_row_nbytes(info, rows->n_channel), left = rows->n_row[info->table];
    const uint8_t *from = rows->data[stream];
    size_t element = rmap_element_nbytes(info->element), width = row / element;
    uint64_t at = self->piece->stored_rows[info->table];
    self->piece->raw_nbytes += left * row;
    while (left > 0) {
        struct rmap_chunk *chunk = self->open[stream];
        if (!chunk) {
            enum rmap_status st = rmap_chunk_queue_take(&self->queue, stream, &chunk, err);
            if (st != RMAP_OK)
                return st;
            chunk->piece = self->piece;
            chunk->index = (uint32_t)(at / RMAP_CHUNK_ROWS);
            self->open[stream] = chunk;
        }
        size_t n = RMAP_CHUNK_ROWS - chunk->n_row < left ? RMAP_CHUNK_ROWS - chunk->n_row : left;
        rmap_shuffle(from, n * width, element, chunk->plane + chunk->n_row * width,
                     RMAP_CHUNK_ROWS * width);
        chunk->n_row += n;
        chunk->n_row_end = at += n;
        from += n * row;
        left -= n;
        if (chunk->n_row == RMAP_CHUNK_ROWS) {
            rmap_chunk_queue_push(&self->queue, chunk);
            self->open[stream] = NULL;
        }
    }
    return RMAP_OK;
}

enum rmap_status rmap_shard_end_piece(struct rmap_shard_writer *self, struct rmap_error *err)
{
    struct rmap_chunk *sign = NULL;
    enum rmap_status st = rmap_chunk_queue_take(&self->queue, RMAP_STREAM_MAX, &sign, err);
    if (st != RMAP_OK)
        return st;
    for (int s = 0; s < RMAP_STREAM_MAX; s++) {
        struct rmap_chunk *chunk = self->open[s];
        if (!chunk)
            continue;
        rmap_chunk_queue_push(&self->queue, chunk);
        self->open[s] = NULL;
    }
    sign->sign = RMAP_SIGN_END_PIECE;
    sign->piece = self->piece;
    self->piece = NULL;
    rmap_chunk_queue_push(&self->queue, sign);
    return RMAP_OK;
}

/* Its rows come next. */
static void begin_portion(const struct rmap_shard_piece *piece, const struct rmap_layout *layout,
                          struct rmap_portion_info *info)
{
    for (int t = 0; t < layout->n_table; t++)
        if (!(layout->whole_tables & (UINT32_C(1) << t)))
            info->stored_first[t] = piece->stored_rows[t];
}

static enum rmap_status append_rows(struct rmap_shard_writer *self, const struct rmap_rows *rows,
                                    struct rmap_portion_info *info, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_shard_piece *piece = self->piece;
    for (int s = 0; s < rows->layout->n_stream; s++)
        RMAP_TRY(append_stream(self, s, rows, err));
    for (int t = 0; t < rows->layout->n_table; t++) {
        if (!(rows->layout->whole_tables & (UINT32_C(1) << t)))
            info->stored_rows[t] += rows->n_row[t];
        piece->stored_rows[t] += rows->n_row[t];
    }
out:
    return st;
}

static enum rmap_status append_locked(struct rmap_shard_writer *self, struct rmap_row_slot *slot,
                                      struct rmap_portion_info *info, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_rows rows;
    RMAP_TRY(begin_piece(self, err));
    struct rmap_shard_piece *piece = self->piece;
    st = RMAP_RESERVE(piece->portion, piece->cap_portion, piece->n_portion + 1, err);
    if (st != RMAP_OK)
        goto out;
    for (size_t i = 0; i < rmap_row_slot_count(slot); i++) {
        RMAP_TRY(rmap_row_slot_rows(slot, piece->book, i, &rows, err));
        if (i == 0)
            begin_portion(piece, rows.layout, info);
        RMAP_TRY(append_rows(self, &rows, info, err));
    }
    piece->portion[piece->n_portion++] = *info;
    if (piece->raw_nbytes >= self->options.piece_nbytes)
        RMAP_TRY(rmap_shard_end_piece(self, err));
out:
    return st;
}

static enum rmap_status append_slot(struct rmap_shard_writer *self, struct rmap_row_slot *slot,
                                    struct rmap_portion_info *info, struct rmap_error *err)
{
    enum rmap_status st = rmap_shard_enter(self, err);
    return st == RMAP_OK ? rmap_shard_leave(self, append_locked(self, slot, info, err), err) : st;
}

static enum rmap_status check(const struct rmap_shard_writer *self,
                              const struct rmap_portion *portion, struct rmap_error *err)
{
    if (portion->n_channel != self->queue.n_channel)
        return rmap_error_set(err, RMAP_INTERNAL, "a block with %d colour channels, not %d",
                              portion->n_channel, self->queue.n_channel);
    if (portion->n_row[RMAP_TABLE_CURVE] > 0 && !rmap_scene_is_curved(self->run.scene))
        return rmap_error_set(err, RMAP_INTERNAL,
                              "curved segments in a scene without gradient media");
    return RMAP_OK;
}

/* What the index says of a portion, from its first part. */
static void describe(const struct rmap_shard_writer *self, const struct rmap_portion *part,
                     struct rmap_portion_info *info)
{
    *info = (struct rmap_portion_info){
        .shard = self->shard, .space = self->run.space, .first_ray = part->first_ray};
    info->last_ray = part->ray.id[part->n_row[RMAP_TABLE_RAY] - 1];
    info->digest = rmap_portion_digest(part);
    rmap_portion_summarise(part, &info->summary);
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        info->n_row[t] = part->n_row[t];
}

enum rmap_status rmap_shard_writer_append(struct rmap_shard_writer *self,
                                          const struct rmap_portion *portion,
                                          struct rmap_error *err)
{
    struct rmap_row_slot *slot = NULL;
    struct rmap_portion_info info;
    if (portion->n_row[RMAP_TABLE_RAY] == 0)
        return RMAP_OK;
    enum rmap_status st = check(self, portion, err);
    if (st != RMAP_OK)
        return st;
    describe(self, portion, &info);
    st = rmap_row_pool_encode(self->rows, portion, &slot, err);
    if (st != RMAP_OK)
        return st;
    st = append_slot(self, slot, &info, err);
    rmap_row_slot_give_back(slot);
    return st;
}

struct rmap_shard_block {
    struct rmap_shard_writer *writer;
    struct rmap_row_slot *slot; /* NULL: empty */
    struct rmap_portion_info info;
};

enum rmap_status rmap_shard_block_create(struct rmap_shard_writer *writer,
                                         struct rmap_shard_block **block_ret,
                                         struct rmap_error *err)
{
    *block_ret = NULL;
    if (!rmap_row_pool_in_parts(writer->rows))
        return RMAP_OK;
    *block_ret = rmap_alloc(1, sizeof **block_ret);
    if (!*block_ret)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a block");
    (*block_ret)->writer = writer;
    return RMAP_OK;
}

static void empty(struct rmap_shard_block *block)
{
    rmap_row_slot_give_back(block->slot);
    block->slot = NULL;
}

void rmap_shard_block_destroy(struct rmap_shard_block *block)
{
    if (!block)
        return;
    empty(block);
    rmap_free(block);
}

static void describe_more(struct rmap_portion_info *info, const struct rmap_portion_info *part)
{
    info->last_ray = part->last_ray;
    rmap_digest_add(&info->digest, part->digest);
    rmap_portion_summary_add(&info->summary, &part->summary);
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        info->n_row[t] += part->n_row[t];
}

enum rmap_status rmap_shard_block_add(struct rmap_shard_block *block,
                                      const struct rmap_portion *part, bool *whole_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_portion_info info;
    *whole_ret = false;
    if (part->n_row[RMAP_TABLE_RAY] == 0)
        return RMAP_OK;
    RMAP_TRY(check(block->writer, part, err));
    describe(block->writer, part, &info);
    if (block->slot) {
        describe_more(&block->info, &info);
    } else {
        RMAP_TRY(rmap_row_pool_begin(block->writer->rows, part->first_ray, &block->slot, err));
        block->info = info;
    }
    RMAP_TRY(rmap_row_slot_part(block->slot, part, whole_ret, err));
out:
    if (st != RMAP_OK || *whole_ret)
        empty(block);
    return st;
}

enum rmap_status rmap_shard_block_append(struct rmap_shard_block *block, bool *whole_ret,
                                         struct rmap_error *err)
{
    *whole_ret = false;
    if (!block->slot)
        return RMAP_OK;
    enum rmap_status st = rmap_row_slot_end(block->slot, whole_ret, err);
    if (st == RMAP_OK && !*whole_ret)
        st = append_slot(block->writer, block->slot, &block->info, err);
    empty(block);
    return st;
}
