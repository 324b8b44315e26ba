/* SPDX-License-Identifier: MIT
 *
 * Writes the head of an index: what a piece has in common, and where its portions stand.
 */
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "history/history_builder.h"

static const uint32_t *words_of(const struct rmap_word_book *book, size_t k)
{
    return book->word + book->entry[k].first;
}

static void write_paths(const struct rmap_word_book *path, const struct rmap_history_layout *layout,
                        uint8_t *bytes)
{
    const uint64_t *at = layout->at;
    int32_t *source = (int32_t *)(void *)(bytes + at[RMAP_HEAD_SOURCE]);
    uint32_t *segments = (uint32_t *)(void *)(bytes + at[RMAP_HEAD_SEGMENT_COUNT]);
    uint32_t *registrations = (uint32_t *)(void *)(bytes + at[RMAP_HEAD_REGISTRATION_COUNT]);
    uint16_t *class_of = (uint16_t *)(void *)(bytes + at[RMAP_HEAD_PATH_CLASS]);
    uint32_t *leg = (uint32_t *)(void *)(bytes + at[RMAP_HEAD_PATH_LEG]);
    uint16_t *hit = (uint16_t *)(void *)(bytes + at[RMAP_HEAD_PATH_HIT]);
    for (size_t i = 0; i < path->n; i++) {
        const uint32_t *word = words_of(path, i);
        source[i] = (int32_t)word[RMAP_HISTORY_WORD_SOURCE];
        bytes[at[RMAP_HEAD_STOP] + i] = (uint8_t)word[RMAP_HISTORY_WORD_STOP];
        segments[i] = word[RMAP_HISTORY_WORD_SEGMENTS];
        registrations[i] = word[RMAP_HISTORY_WORD_REGISTRATIONS];
        word += RMAP_HISTORY_WORD_HEAD;
        for (uint32_t k = 0; k < segments[i]; k++)
            *class_of++ = (uint16_t)*word++;
        for (uint32_t k = 0; k < registrations[i]; k++)
            *leg++ = *word++;
        for (uint32_t k = 0; k < registrations[i]; k++)
            *hit++ = (uint16_t)*word++;
    }
}

static void write_head(const struct rmap_history_builder *self,
                       const struct rmap_history_head *head,
                       const struct rmap_history_layout *layout, uint8_t *bytes)
{
    struct rmap_history_class *class_of = (void *)(bytes + layout->at[RMAP_HEAD_CLASS]);
    struct rmap_history_hit *hit = (void *)(bytes + layout->at[RMAP_HEAD_HIT]);
    memcpy(bytes, head, sizeof *head);
    for (size_t k = 0; k < self->class_of.n; k++) {
        const uint32_t *word = words_of(&self->class_of, k);
        class_of[k] = (struct rmap_history_class){(int32_t)word[0], word[1], (int32_t)word[2]};
    }
    for (size_t k = 0; k < self->hit.n; k++) {
        const uint32_t *word = words_of(&self->hit, k);
        hit[k] = (struct rmap_history_hit){(int32_t)word[0], (int32_t)word[1]};
    }
    write_paths(&self->path, layout, bytes);
    if (self->n_place > 0)
        memcpy(bytes + layout->at[RMAP_HEAD_PORTION], self->place,
               self->n_place * sizeof *self->place);
}

enum rmap_status rmap_history_builder_finish(struct rmap_history_builder *self,
                                             struct rmap_history_bytes *bytes,
                                             struct rmap_error *err)
{
    const struct rmap_history_head head = {.magic = RMAP_HISTORY_MAGIC,
                                           .n_class = self->class_of.n,
                                           .n_hit = self->hit.n,
                                           .n_path = self->path.n,
                                           .n_path_segment = self->n_path_segment,
                                           .n_path_registration = self->n_path_registration,
                                           .n_portion = self->n_place,
                                           .body_nbytes = self->body_nbytes};
    struct rmap_history_layout layout;
    rmap_history_arrange_head(&head, &layout);
    size_t nbytes = (size_t)layout.at[RMAP_HEAD_PARTS];
    uint8_t *block = rmap_alloc(nbytes + sizeof(uint64_t), 1);
    if (!block)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for an index");
    write_head(self, &head, &layout, block);
    uint64_t checksum = XXH3_64bits(block, nbytes);
    memcpy(block + nbytes, &checksum, sizeof checksum);
    *bytes = (struct rmap_history_bytes){.head = block,
                                         .head_nbytes = nbytes + sizeof checksum,
                                         .body = self->body,
                                         .body_nbytes = self->body_nbytes};
    self->body = NULL;
    self->body_nbytes = self->cap_body = self->n_place = 0;
    self->n_path_segment = self->n_path_registration = 0;
    rmap_word_book_clear(&self->class_of);
    rmap_word_book_clear(&self->hit);
    rmap_word_book_clear(&self->path);
    return RMAP_OK;
}
