/* SPDX-License-Identifier: MIT
 *
 * For tests of unfinished maps: made-up blocks go in, and what stands there is read back.
 */
#ifndef RMAP_MAP_LEFTOVER_H
#define RMAP_MAP_LEFTOVER_H

#include "map_fixture.h"

#include "io/map/map_cursor.h"
#include "io/map/map_directory.h"
#include "io/map/map_reader.h"
#include "io/write/index_writer.h"
#include "io/write/shard_append.h"

enum { BLOCK = 400 };

static inline size_t n_leftover(const struct fixture *f)
{
    struct rmap_error err = {0};
    struct rmap_leftover *leftover = NULL;
    size_t n = 0;
    fixture_must(rmap_map_list_leftovers(f->map, &leftover, &n, &err), &err);
    rmap_free(leftover);
    return n;
}

/* An index of a map that holds nothing yet, as a trace writes it at its start. */
static inline void begin_map(struct fixture *f, enum rmap_encoding encoding)
{
    struct rmap_error err = {0};
    const struct rmap_index index = {.run = &f->run};
    fixture_init(f);
    f->run.encoding = encoding;
    fixture_must(rmap_map_create(f->map, false, NULL, NULL, &err), &err);
    fixture_must(rmap_index_write_content(f->map, &index, &err), &err);
}

/* Compares every row of an open map with the history that it must be. Returns its rays. */
static inline uint64_t read_map(const struct fixture *f, const struct rmap_map *map)
{
    struct rmap_error err = {0};
    struct rmap_cursor *cursor = NULL;
    uint64_t n_ray = 0;
    fixture_must(rmap_cursor_create(map, RMAP_COLUMNS_ALL, &cursor, &err), &err);
    for (size_t i = 0; i < rmap_map_n_portion(map); i++) {
        const struct rmap_portion *read = NULL;
        fixture_must(rmap_cursor_read(cursor, i, &read, &err), &err);
        struct rmap_portion *want = fixture_portion(f, read->first_ray, BLOCK, NULL);
        fixture_compare(read, want);
        n_ray += read->n_row[RMAP_TABLE_RAY];
        rmap_portion_destroy(want);
    }
    rmap_cursor_destroy(cursor);
    return n_ray;
}

/* The map as it stands. */
static inline uint64_t read_back(const struct fixture *f)
{
    struct rmap_error err = {0};
    struct rmap_map *map = NULL;
    fixture_must(rmap_map_open(f->map, &map, &err), &err);
    uint64_t n_ray = read_map(f, map);
    rmap_map_close(map);
    return n_ray;
}

static inline void append(struct fixture *f, struct rmap_shard_writer *writer, uint64_t block)
{
    struct rmap_error err = {0};
    struct rmap_portion *portion = fixture_portion(f, block * BLOCK, BLOCK, NULL);
    fixture_must(rmap_shard_writer_append(writer, portion, &err), &err);
    rmap_portion_destroy(portion);
}

#endif
