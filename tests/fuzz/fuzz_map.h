/* SPDX-License-Identifier: MIT
 *
 * A small whole map with curved segments, for targets whose input is asked of a map.
 */
#ifndef RMAP_FUZZ_MAP_H
#define RMAP_FUZZ_MAP_H

#include "io/map/map_cursor.h"
#include "io/map/map_directory.h"
#include "io/map/map_reader.h"
#include "io/write/index_writer.h"
#include "target.h"
#include "tests/format/map_fixture.h"

static struct fixture fuzz_map_files;
static struct rmap_map *fuzz_map_open;
static const struct rmap_portion *fuzz_map_rays; /* all columns of its portion */
static struct rmap_cursor *fuzz_map_cursor;

static void fuzz_map_end(void)
{
    rmap_cursor_destroy(fuzz_map_cursor);
    rmap_map_close(fuzz_map_open);
    fixture_fini(&fuzz_map_files);
}

/* Made when it is first asked for. */
static inline const struct rmap_map *fuzz_map(void)
{
    struct rmap_error err = {0};
    struct fixture *f = &fuzz_map_files;
    if (fuzz_map_open)
        return fuzz_map_open;
    (void)setenv("FIXTURE", "curved", 1);
    fixture_init(f);
    fixture_must(rmap_map_create(f->map, false, NULL, NULL, &err), &err);
    fixture_must(fixture_write_shard(f, 0, 0, 1, 40, 0, &err), &err);
    fixture_must(rmap_index_write(f->map, &f->run, f->tally, true, &err), &err);
    fixture_must(rmap_map_open(f->map, &fuzz_map_open, &err), &err);
    fixture_must(rmap_cursor_create(fuzz_map_open, RMAP_COLUMNS_ALL, &fuzz_map_cursor, &err), &err);
    fixture_must(rmap_cursor_read(fuzz_map_cursor, 0, &fuzz_map_rays, &err), &err);
    (void)atexit(fuzz_map_end);
    return fuzz_map_open;
}

#endif
