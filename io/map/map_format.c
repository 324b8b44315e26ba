/* SPDX-License-Identifier: MIT
 *
 * What writer and reader of a map agree on; docs/map.md says the same in words.
 */
#include "io/map/map_format.h"

#include "base/count.h"
#include "compact/path_sum.h"

#define CHUNK(name, element, text)                                                                 \
    {                                                                                              \
        "/chunk/" #name, RMAP_##element, 1, offsetof(struct rmap_chunk_entry, name), text          \
    }

static const struct rmap_h5_field chunk_field[] = {
    CHUNK(stream, U16, "dataset, as a row of /chunk/name"),
    CHUNK(index, U32, "number of the chunk in its dataset, from 0; 65536 rows each"),
    CHUNK(offset, U64, "first byte of the stored chunk in this file"),
    CHUNK(nbytes, U32, "stored bytes: zlib stream of the shuffled rows, then fletcher32"),
    CHUNK(checksum, U64, "XXH3-64 of the stored bytes"),
    CHUNK(lead_planes, U16, "byte planes of the shuffled rows before the last ones, which are 0"),
    CHUNK(lead_nbytes, U32,
          "stored bytes in which those planes end, of pieces by earlier programs; "
          "without meaning when all planes lead"),
};

#define PORTION(name, member, element, width, text)                                                \
    {                                                                                              \
        "/portion/" name, RMAP_##element, width, offsetof(struct rmap_portion_info, member), text  \
    }

/* The three that only the index has come first. */
enum { INDEX_ONLY = 3 };

/* more: what follows /registration. */
#define PORTION_FIELDS(n_table, n_stored, more)                                                    \
    PORTION("shard", shard, I32, 1, "shard that holds the portion"),                               \
        PORTION("piece", piece, I32, 1, "row of /piece that holds the portion"),                   \
        PORTION("space", space, I32, 1, "colour space, as a row of /space"),                       \
        PORTION("first_ray", first_ray, U64, 1, "smallest ray id"),                                \
        PORTION("n_row", n_row, U64, n_table, "rows in /ray, /segment, /registration" more),       \
        PORTION("stored_first", stored_first, U64, n_stored,                                       \
                "first row in each stored table of the piece; plain: /ray, /segment, "             \
                "/registration" more),                                                             \
        PORTION("stored_rows", stored_rows, U64, n_stored,                                         \
                "rows in each stored table of the piece"),                                         \
        PORTION("digest", digest, U64, 2, "low and high word of the rays' logical digest"),        \
        PORTION("events", summary.events, U32, 1, "event bits of all segments"),                   \
        PORTION("stops", summary.stops, U32, 1, "bit 2^stop of all rays"),                         \
        PORTION("sources", summary.sources, U64, 1, "bit 2^(source mod 64) of all rays"),          \
        PORTION("detectors", summary.detectors, U64, 1,                                            \
                "bit 2^(detector mod 64) of registrations"),                                       \
        PORTION(                                                                                   \
            "objects", summary.objects, U64, 4,                                                    \
            "bit (object mod 256) of all segments: word object mod 256 / 64, bit object mod 64"),  \
        PORTION("box_min", summary.box_min, F32, 3,                                                \
                "least x, y, z of all points, in the map's length unit; +inf without any"),        \
        PORTION("box_max", summary.box_max, F32, 3,                                                \
                "greatest x, y, z of all points, in the map's length unit; -inf without any")

static const struct rmap_h5_field portion_field[] = {
    PORTION_FIELDS(RMAP_TABLE_CURVE, RMAP_STORED_TABLE_STRAIGHT, )};
static const struct rmap_h5_field curved_portion_field[] = {
    PORTION_FIELDS(RMAP_TABLE_COUNT, RMAP_STORED_TABLE_MAX, ", /curve")};

static const struct rmap_h5_field picked_field[] = {
    PORTION("last_ray", last_ray, U64, 1, "largest ray id"),
};

#define PIECE(name, member, element, width, text)                                                  \
    {                                                                                              \
        "/piece/" name, RMAP_##element, width, offsetof(struct rmap_piece_info, member), text      \
    }

#define PIECE_FIELDS(n_table, n_stored, more)                                                      \
    PIECE("shard", shard, I32, 1, "RRRRR of shard-RRRRR/piece-KKKKK.h5"),                          \
        PIECE("number", number, I32, 1, "KKKKK of shard-RRRRR/piece-KKKKK.h5"),                    \
        PIECE("nbytes", nbytes, U64, 1, "size of the file in bytes"),                              \
        PIECE("encoding", encoding, I32, 1, "0 plain, 1 compact"),                                 \
        PIECE("space", space, I32, 1, "colour space, as a row of /space"),                         \
        PIECE("n_row", n_row, U64, n_table,                                                        \
              "rows of its columns in /ray, /segment, /registration" more),                        \
        PIECE("stored_rows", stored_rows, U64, n_stored,                                           \
              "rows in each stored table; plain: /ray, /segment, /registration" more),             \
        PIECE("first_chunk", first_chunk, U64, 1, "first of its rows in /chunk"),                  \
        PIECE("n_chunk", n_chunk, U64, 1, "number of its rows in /chunk")

static const struct rmap_h5_field piece_field[] = {
    PIECE_FIELDS(RMAP_TABLE_CURVE, RMAP_STORED_TABLE_STRAIGHT, )};
static const struct rmap_h5_field curved_piece_field[] = {
    PIECE_FIELDS(RMAP_TABLE_COUNT, RMAP_STORED_TABLE_MAX, ", /curve")};

#define RUN(name, member, element, text)                                                           \
    {                                                                                              \
        "/run/" name, RMAP_##element, 1, offsetof(struct rmap_run_row, member), text               \
    }

static const struct rmap_h5_field run_field[] = {
    RUN("first_ray", first_ray, U64, "smallest ray id that the run was asked for"),
    RUN("n_ray", n_ray, U64, "number of ray ids that the run was asked for"),
    RUN("seed", seed, U64, "seed of its rays"),
    RUN("space", space, I32, "colour space of its rays, as a row of /space"),
    RUN("ranks", n_rank, I32, "ranks that traced them"),
};

struct rmap_field_table rmap_run_fields(void)
{
    return (struct rmap_field_table){run_field, RMAP_COUNT(run_field)};
}

struct rmap_field_table rmap_chunk_fields(void)
{
    return (struct rmap_field_table){chunk_field, RMAP_COUNT(chunk_field)};
}

struct rmap_field_table rmap_portion_fields_piece(bool curved)
{
    struct rmap_field_table table = rmap_portion_fields_index(curved);
    return (struct rmap_field_table){table.field + INDEX_ONLY, table.n - INDEX_ONLY};
}

struct rmap_field_table rmap_portion_fields_index(bool curved)
{
    return (struct rmap_field_table){curved ? curved_portion_field : portion_field,
                                     RMAP_COUNT(portion_field)};
}

struct rmap_field_table rmap_portion_fields_picked(void)
{
    return (struct rmap_field_table){picked_field, RMAP_COUNT(picked_field)};
}

#define PATH_SUM(name, member, element, width, text)                                               \
    {                                                                                              \
        "/tally/" name, RMAP_##element, width, offsetof(struct rmap_path_sum, member), text        \
    }

static const struct rmap_h5_field path_sum_field[] = {
    PATH_SUM("path_rays", rays, U64, 1, "rays of the piece that have a path, a row of /path"),
    PATH_SUM(
        "path_length", path_length, F32, 2,
        "least and greatest of their /ray/path_length, in the map's length unit; NaN: not said"),
    PATH_SUM("optical_path", optical_path, F32, 2, "the same of /ray/optical_path"),
};

struct rmap_field_table rmap_path_sum_fields(void)
{
    return (struct rmap_field_table){path_sum_field, RMAP_COUNT(path_sum_field)};
}

struct rmap_field_table rmap_piece_fields(bool curved)
{
    return (struct rmap_field_table){curved ? curved_piece_field : piece_field,
                                     RMAP_COUNT(piece_field)};
}

size_t rmap_format_n_table(bool curved)
{
    return curved ? RMAP_STORED_TABLE_MAX : RMAP_STORED_TABLE_STRAIGHT;
}
