/* SPDX-License-Identifier: MIT
 *
 * libraymap: reads ray maps. Columns of rays, segments and registrations come block by block, in
 * either encoding, of all rays or of those that match a criterion; docs/library.md has an example,
 * docs/map.md the columns, docs/criterion.md the language.
 *
 * Every function that can fail returns a status and, where it is given one, fills in an error;
 * outputs are then left as they were. Nothing is printed, no signal is handled, no exit called.
 *
 * Threads: a map may be used by any number of them at a time, a reader by one at a time. To read in
 * parallel give each thread a reader of its own and deal out the blocks.
 */
#ifndef RAYMAP_H
#define RAYMAP_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define RAYMAP_API __attribute__((visibility("default")))

/* The exit status of the program. */
enum raymap_status {
    RAYMAP_OK = 0,
    RAYMAP_INTERNAL = 1, /* a bug of ours */
    RAYMAP_USAGE = 2,    /* a call that makes no sense: a block that there is not */
    RAYMAP_INPUT = 3,    /* no such file, column, or name in a criterion */
    RAYMAP_FORMAT = 4,   /* no map, or a damaged one */
    RAYMAP_SYSTEM = 5    /* no memory, no permission */
};

/* What went wrong, in UTF-8. The caller's; need not be initialised; NULL where it is not wanted. */
struct raymap_error {
    int32_t status;
    char text[1024];
};

enum raymap_table { RAYMAP_RAY, RAYMAP_SEGMENT, RAYMAP_REGISTRATION, RAYMAP_CURVE };

enum raymap_type {
    RAYMAP_U8,
    RAYMAP_U16,
    RAYMAP_I16,
    RAYMAP_U32,
    RAYMAP_I32,
    RAYMAP_U64,
    RAYMAP_F32,
    RAYMAP_F64
};

/* What numbers in columns stand for. */
enum raymap_kind {
    RAYMAP_SOURCE,   /* ray/source */
    RAYMAP_OBJECT,   /* segment/object, ray/start_object; -1: none */
    RAYMAP_MEDIUM,   /* segment/medium */
    RAYMAP_DETECTOR, /* registration/detector */
    RAYMAP_STOP,     /* ray/stop */
    RAYMAP_EVENT     /* bit of segment/event */
};

typedef struct raymap_map raymap_map;
typedef struct raymap_reader raymap_reader;

/* "1.2.3" of the library in use. */
RAYMAP_API const char *raymap_version(void);

/* ---- maps ---- */

/* path: the map's directory. Of a map whose run has not ended, or was killed, what it has committed
 * so far. RAYMAP_INPUT, RAYMAP_FORMAT, RAYMAP_SYSTEM. */
RAYMAP_API enum raymap_status raymap_open(const char *path, raymap_map **map_ret,
                                          struct raymap_error *error);
/* After its readers. NULL is fine. */
RAYMAP_API void raymap_close(raymap_map *map);

/* Rows of a table; blocks of rays, in the order of their first ray's id. */
RAYMAP_API uint64_t raymap_rows(const raymap_map *map, enum raymap_table table);
RAYMAP_API size_t raymap_blocks(const raymap_map *map);
RAYMAP_API int raymap_is_complete(const raymap_map *map); /* 1: its run has ended */
RAYMAP_API uint64_t raymap_seed(const raymap_map *map);
RAYMAP_API const char *raymap_length_unit(const raymap_map *map, double *metres_ret); /* NULL: no */
RAYMAP_API const char *
raymap_flux_unit(const raymap_map *map); /* "W", "lm", "photons", "photons/s", "J" */

/* Name number i of a kind; NULL behind the last one. */
RAYMAP_API const char *raymap_name(const raymap_map *map, enum raymap_kind kind, size_t i);

/* Channels of a colour space (0, and of merged maps more), and their wavelengths in nm
 * [*n_ret]; NULL and 3 where they are red, green and blue, NULL and 0 behind the last space. */
RAYMAP_API const double *raymap_wavelengths(const raymap_map *map, size_t space, size_t *n_ret);

/* 1: *block_ret is a block that may hold the ray with this id; 0: there is none left. To be given
 * raymap_blocks (or more) first, then the block found last: of rays that a query picked, blocks
 * have gaps and several may be asked. */
RAYMAP_API int raymap_find_ray(const raymap_map *map, uint64_t ray, size_t *block_ret);

/* What of an unfinished or damaged map cannot be used, a line each; NULL behind the last one. */
RAYMAP_API const char *raymap_trouble(const raymap_map *map, size_t i);

struct raymap_count {
    uint64_t rays, segments;
    double flux, standard_error; /* in the map's unit; NaN of fewer than 2 rays of a source */
};

/* How many rays match a criterion (NULL: all), and their flux, by the calling thread alone.
 * RAYMAP_INPUT has the text with a caret under the mistake. */
RAYMAP_API enum raymap_status raymap_count_rays(const raymap_map *map, const char *criterion,
                                                struct raymap_count *count_ret,
                                                struct raymap_error *error);

/* ---- columns ---- */

/* Texts are the reader's. */
struct raymap_column {
    const char *name; /* without its table: "position" */
    const char *unit; /* "mm", "s", "1" */
    const char *description;
    int32_t table; /* enum raymap_table */
    int32_t type;  /* enum raymap_type */
    int32_t width; /* numbers per row; 0: as many as the block's colour space has channels */
};

/* criterion: rays to read; NULL: all. columns: "ray/id, segment/position, registration/x", a table
 * alone standing for all of its columns; NULL: all of all tables, which takes long, as lengths and
 * angles of segments are worked out. The map is borrowed. RAYMAP_INPUT. */
RAYMAP_API enum raymap_status raymap_reader_create(const raymap_map *map, const char *criterion,
                                                   const char *columns, raymap_reader **reader_ret,
                                                   struct raymap_error *error);
RAYMAP_API void raymap_reader_destroy(raymap_reader *reader); /* NULL is fine */

/* Column c, in the order of the tables and of docs/map.md, not that of the list. RAYMAP_USAGE
 * behind the last one. */
RAYMAP_API enum raymap_status raymap_reader_column(const raymap_reader *reader, size_t c,
                                                   struct raymap_column *column_ret);

struct raymap_block {
    uint64_t first_ray; /* id; of the block, whether that ray matches or not */
    uint64_t rays;      /* of the block, whether they match or not */
    uint64_t rows[4];   /* read, of each table that a column was asked of; of rays, always */
    int32_t space;      /* colour space */
};

/* Reads a block: data of all columns are those of its matching rays from then on. block_ret may be
 * NULL. RAYMAP_USAGE, RAYMAP_FORMAT, RAYMAP_SYSTEM: no column has data. */
RAYMAP_API enum raymap_status raymap_read(raymap_reader *reader, size_t block,
                                          struct raymap_block *block_ret,
                                          struct raymap_error *error);

/* Rows of column c in the block read last, side by side: [rows of its table][width] of its type.
 * NULL: none was read. Valid until the next call of raymap_read. */
RAYMAP_API const void *raymap_data(const raymap_reader *reader, size_t c);

#ifdef __cplusplus
}
#endif

#endif
