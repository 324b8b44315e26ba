/* SPDX-License-Identifier: MIT
 *
 * A foreign journal: reading it ends in what it commits or in RMAP_FORMAT. The input is a file;
 * when its first byte is odd the hashes of its commits are made right, so that what they vouch for
 * is looked at. What is committed becomes the content of a map and is checked as such.
 */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/alloc.h"
#include "io/map/journal_format.h"
#include "io/write/journal_writer.h"
#include "target.h"

const unsigned rmap_fuzz_rounds = 1500;

enum { N_CHANNEL = 3, COMMITS = 2 };

static char path[64];

static void remove_scratch(void)
{
    (void)unlink(path);
}

static void begin(void)
{
    if (path[0])
        return;
    (void)snprintf(path, sizeof path, "fuzz-journal-%ld", (long)getpid());
    (void)atexit(remove_scratch);
}

static void put_file(const uint8_t *data, size_t nbytes)
{
    int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    rmap_fuzz_demand(fd >= 0 && (nbytes == 0 || write(fd, data, nbytes) == (ssize_t)nbytes),
                     "writing the scratch file");
    (void)close(fd);
}

/* Makes the hash of every commit right, as far as the records can be followed. */
static void mend(uint8_t *data, size_t nbytes)
{
    uint64_t hash = 0;
    size_t since = 0;
    for (size_t at = 0; at + sizeof(struct rmap_journal_record_head) <= nbytes;) {
        struct rmap_journal_record_head head;
        memcpy(&head, data + at, sizeof head);
        at += sizeof head;
        if (head.nbytes > nbytes - at)
            return;
        at += head.nbytes;
        if (head.type != RMAP_JOURNAL_COMMIT || head.nbytes < sizeof hash)
            continue;
        hash = XXH3_64bits_withSeed(data + since, at - sizeof hash - since, hash);
        memcpy(data + at - sizeof hash, &hash, sizeof hash);
        since = at;
    }
}

static void use(void)
{
    struct rmap_journal journal;
    struct rmap_map_content content = {0};
    struct rmap_error err = {0};
    enum rmap_status st = rmap_journal_read(path, &journal, &err);
    rmap_fuzz_demand(st == RMAP_OK || st == RMAP_FORMAT, "status of a foreign journal");
    if (st == RMAP_OK) {
        st = rmap_journal_content(&journal, path, "shard-00000/x.part", 1 << 20, &content, &err);
        rmap_fuzz_demand(st == RMAP_OK || st == RMAP_FORMAT, "status of its content");
    }
    if (st == RMAP_OK && rmap_map_content_sort(&content, &err) == RMAP_OK)
        st = rmap_map_content_check(&content, "fuzz", &err);
    rmap_fuzz_demand(st == RMAP_OK || st == RMAP_FORMAT, "status of a content");
    rmap_map_content_fini(&content);
    rmap_journal_fini(&journal);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    begin();
    int64_t live = rmap_alloc_live();
    uint8_t flags = 0;
    rmap_fuzz_take(&data, &nbytes, &flags, 1);
    uint8_t *copy = rmap_alloc(nbytes, 1);
    rmap_fuzz_demand(copy != NULL, "memory");
    if (nbytes > 0)
        memcpy(copy, data, nbytes);
    if (flags & 1)
        mend(copy, nbytes);
    put_file(copy, nbytes);
    rmap_free(copy);
    use();
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
    return 0;
}

/* Rows [k, k + 1) x count of each stored table but whole ones. */
static void add_commit(struct rmap_journal_writer *writer, const struct rmap_layout *layout,
                       uint64_t k)
{
    static const uint64_t count[RMAP_STORED_TABLE_MAX] = {3, 7, 5, 2, 4, 6, 2, 8, 1, 2, 3, 9};
    static const uint8_t zeros[9 * 8 * N_CHANNEL];
    struct rmap_journal_batch batch = {0};
    struct rmap_portion_info portion = {.first_ray = 3 * k, .n_row = {3, 7, 2}};
    struct rmap_error err = {0};
    uint64_t n_row[RMAP_STORED_TABLE_MAX] = {0};
    enum rmap_status st = RMAP_OK;
    for (int t = 0; t < layout->n_table; t++) {
        n_row[t] = (k + 1) * count[t];
        if (layout->whole_tables >> t & 1)
            continue;
        portion.stored_first[t] = k * count[t];
        portion.stored_rows[t] = count[t];
    }
    for (int s = 0; s < layout->n_stream && st == RMAP_OK; s++) {
        uint64_t rows = count[layout->stream[s].table];
        st = rmap_journal_add_tail(&batch, s, k * rows, rows,
                                   rmap_stream_row_nbytes(&layout->stream[s], N_CHANNEL), zeros,
                                   &err);
    }
    if (st == RMAP_OK)
        st = rmap_journal_add_portions(&batch, false, &portion, 1, &err);
    if (st == RMAP_OK)
        st = rmap_journal_commit(writer, &batch, n_row, k + 1, &err);
    rmap_fuzz_demand(st == RMAP_OK, "a commit");
    rmap_journal_batch_fini(&batch);
}

/* A journal of each encoding, as it is and with its hashes mended. */
size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    struct rmap_journal_writer *writer = NULL;
    struct rmap_journal_header header = {.encoding = k / 2, .n_channel = N_CHANNEL, .seed = 1};
    struct rmap_error err = {0};
    begin();
    if (k >= 2 * RMAP_ENCODING_COUNT)
        return 0;
    header.mode = RMAP_COLOUR_RGB;
    (void)unlink(path);
    rmap_fuzz_demand(rmap_journal_create(path, &header, &writer, &err) == RMAP_OK, "a journal");
    for (uint64_t n = 0; n < COMMITS; n++)
        add_commit(writer, rmap_layout_of((enum rmap_encoding)(k / 2), RMAP_COLOUR_RGB), n);
    rmap_journal_writer_destroy(writer);
    to[0] = (uint8_t)(k % 2);
    int fd = open(path, O_RDONLY);
    ssize_t got = fd < 0 ? -1 : read(fd, to + 1, cap - 1);
    (void)close(fd);
    rmap_fuzz_demand(got > 0, "a seed is read");
    return (size_t)got + 1;
}
