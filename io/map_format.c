/* SPDX-License-Identifier: MIT */
#include "io/map_format.h"

#include <stdio.h>

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

const char *const rmap_table_path[RMAP_TABLE_COUNT] = {"/ray", "/segment", "/registration"};

#define CHUNK(name, element, text)                                                                 \
    {                                                                                              \
        "/chunk/" #name, RMAP_##element, 1, offsetof(struct rmap_chunk_entry, name), text          \
    }

static const struct rmap_h5_field chunk_field[] = {
    CHUNK(column, U16, "dataset, as a row of /chunk/name"),
    CHUNK(index, U32, "number of the chunk in its dataset, from 0; 65536 rows each"),
    CHUNK(offset, U64, "first byte of the stored chunk in this file"),
    CHUNK(nbytes, U32, "stored bytes: zlib stream of the shuffled rows, then fletcher32"),
    CHUNK(checksum, U64, "XXH3-64 of the stored bytes"),
    CHUNK(lead_planes, U16, "byte planes of the shuffled rows before the last ones, which are 0"),
    CHUNK(lead_nbytes, U32,
          "stored bytes in which those planes end; without meaning when all "
          "planes lead"),
};

#define PORTION(name, member, element, width, text)                                                \
    {                                                                                              \
        "/portion/" name, RMAP_##element, width, offsetof(struct rmap_portion_info, member), text  \
    }

/* The two that only the index has come first. */
enum { INDEX_ONLY = 2 };

static const struct rmap_h5_field portion_field[] = {
    PORTION("shard", shard, I32, 1, "shard that holds the portion"),
    PORTION("piece", piece, I32, 1, "row of /piece that holds the portion"),
    PORTION("colour_space", colour_space, U8, 1, "0 spectral, 1 RGB"),
    PORTION("first_ray", first_ray, U64, 1, "smallest ray id"),
    PORTION("n_row", n_row, U64, 3, "rows in /ray, /segment, /registration"),
    PORTION("first_row", first_row, U64, 3,
            "first row in the piece's /ray, /segment, /registration"),
    PORTION("digest", digest, U64, 2, "low and high word of the rays' logical digest"),
    PORTION("events", summary.events, U32, 1, "event bits of all segments"),
    PORTION("stops", summary.stops, U32, 1, "bit 2^stop of all rays"),
    PORTION("sources", summary.sources, U64, 1, "bit 2^(source mod 64) of all rays"),
    PORTION("detectors", summary.detectors, U64, 1, "bit 2^(detector mod 64) of registrations"),
    PORTION("objects", summary.objects, U64, 4,
            "bit (object mod 256) of all segments: word object mod 256 / 64, bit object mod 64"),
    PORTION("box_min", summary.box_min, F32, 3,
            "least x, y, z of all points, in the map's length unit; +inf without any"),
    PORTION("box_max", summary.box_max, F32, 3,
            "greatest x, y, z of all points, in the map's length unit; -inf without any"),
};

#define PIECE(name, member, element, width, text)                                                  \
    {                                                                                              \
        "/piece/" name, RMAP_##element, width, offsetof(struct rmap_piece_info, member), text      \
    }

static const struct rmap_h5_field piece_field[] = {
    PIECE("shard", shard, I32, 1, "RRRRR of shard-RRRRR/piece-KKKKK.h5"),
    PIECE("number", number, I32, 1, "KKKKK of shard-RRRRR/piece-KKKKK.h5"),
    PIECE("nbytes", nbytes, U64, 1, "size of the file in bytes"),
    PIECE("n_row", n_row, U64, 3, "rows in its /ray, /segment, /registration"),
};

struct rmap_field_table rmap_chunk_fields(void)
{
    return (struct rmap_field_table){chunk_field, COUNT(chunk_field)};
}

struct rmap_field_table rmap_portion_fields_piece(void)
{
    return (struct rmap_field_table){portion_field + INDEX_ONLY, COUNT(portion_field) - INDEX_ONLY};
}

struct rmap_field_table rmap_portion_fields_index(void)
{
    return (struct rmap_field_table){portion_field, COUNT(portion_field)};
}

struct rmap_field_table rmap_piece_fields(void)
{
    return (struct rmap_field_table){piece_field, COUNT(piece_field)};
}

const char *rmap_column_path(enum rmap_column column, enum rmap_colour_mode mode)
{
    if (column == RMAP_SEGMENT_colour)
        return mode == RMAP_COLOUR_RGB ? "/segment/colour_rgb" : "/segment/colour_spectral";
    return rmap_column_info(column)->path;
}

size_t rmap_column_width(enum rmap_column column, int n_channel)
{
    return column == RMAP_SEGMENT_colour ? (size_t)n_channel
                                         : (size_t)rmap_column_info(column)->width;
}

void rmap_piece_name_set(struct rmap_piece_info *piece)
{
    (void)snprintf(piece->name, sizeof piece->name, "shard-%05d/piece-%05d.h5", (int)piece->shard,
                   (int)piece->number);
}
