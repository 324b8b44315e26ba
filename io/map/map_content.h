/* SPDX-License-Identifier: MIT
 *
 * What pieces hold: their portions and where their chunks lie. One form for a piece, whether it
 * comes from the sealed file, from the journal of an unfinished one, from the index, or from the
 * writer that just made it; and for all pieces of a map.
 */
#ifndef RMAP_MAP_CONTENT_H
#define RMAP_MAP_CONTENT_H

#include "io/map/map_reader.h"

/* Rows of a stored chunk, in every column. */
#define RMAP_CHUNK_ROWS 65536

/* Where a chunk's bytes lie, so that a reader needs no HDF5 for them. */
struct rmap_chunk_entry {
    uint64_t offset;      /* in the file */
    uint64_t checksum;    /* rmap_checksum of the stored bytes */
    uint32_t nbytes;      /* stored */
    uint32_t index;       /* rows [index x RMAP_CHUNK_ROWS, ...) */
    uint32_t lead_nbytes; /* with the next, of earlier programs: where planes of 0 begin */
    uint16_t lead_planes;
    uint16_t stream; /* number in the layout; row of /chunk/name */
};

/* Last rows of a stream of an unfinished piece, not yet a full chunk: known by the journal. */
struct rmap_stream_tail {
    int32_t piece;      /* as rmap_portion_info.piece */
    int32_t stream;     /* number in the layout */
    uint64_t first_row; /* multiple of RMAP_CHUNK_ROWS: where the stored chunks end */
    size_t n_row;       /* at most RMAP_CHUNK_ROWS */
    uint8_t *data;      /* [n_row][width], owned */
    size_t nbytes;      /* of data */
};

/* Pieces of one map. A piece alone is a content with n_piece = 1. Zeroed: empty. */
struct rmap_map_content {
    struct rmap_piece_info *piece;
    size_t n_piece, cap_piece;
    struct rmap_portion_info *portion;
    size_t n_portion, cap_portion;
    struct rmap_chunk_entry *chunk; /* those of a piece together; see rmap_piece_info.first_chunk */
    size_t n_chunk, cap_chunk;
    struct rmap_stream_tail *tail;
    size_t n_tail, cap_tail;
    /* Of all portions; set by rmap_map_content_check. */
    uint64_t n_row[RMAP_TABLE_COUNT];
    struct rmap_digest digest;
    /* Of processes that share them: where pieces, portions and chunks lie, in place of blocks of
     * their own. To be read and written (by this process alone), not to be added to. */
    void *mapped; /* munmap */
    size_t mapped_nbytes;
};

void rmap_map_content_fini(struct rmap_map_content *content);

/* Appends a piece with its n_portion portions and info->n_chunk chunks. What numbers rows of the
 * content is set here: portion.shard, .piece, .space, info.first_chunk, .n_row. On failure the
 * content is unchanged. */
enum rmap_status rmap_map_content_add_piece(struct rmap_map_content *content,
                                            const struct rmap_piece_info *info,
                                            const struct rmap_portion_info *portion,
                                            size_t n_portion, const struct rmap_chunk_entry *chunk,
                                            struct rmap_error *err) RMAP_MUST_USE;

/* Appends a tail of a piece that is in the content; its data are taken over, on success alone. */
enum rmap_status rmap_map_content_add_tail(struct rmap_map_content *content,
                                           const struct rmap_stream_tail *tail,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* Appends the pieces of `from` with all that is theirs; row numbers are moved, data of tails
 * copied. On failure `into` is unchanged, or has room and nothing else. */
enum rmap_status rmap_map_content_add(struct rmap_map_content *into,
                                      const struct rmap_map_content *from,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Before rows of a mapped content are added or taken away: a copy of its own. */
enum rmap_status rmap_map_content_own(struct rmap_map_content *content,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Puts pieces in the order of shard and number, chunks in that of pieces, streams and indices,
 * portions in that of their first ray, tails in that of pieces and streams. */
enum rmap_status rmap_map_content_sort(struct rmap_map_content *content,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Of a sorted content: drops portions all of whose rays another portion holds, which is what ghosts
 * and half-done salvages leave. A portion of the index stays before others, one of a sealed piece
 * before one of an open piece. n_dropped_ret: how many. */
void rmap_map_content_drop_covered(struct rmap_map_content *content, size_t *n_dropped_ret);

/* Takes open pieces out, with what is theirs: an index lists sealed ones. */
enum rmap_status rmap_map_content_drop_open(struct rmap_map_content *content,
                                            struct rmap_error *err) RMAP_MUST_USE;

/* Running sums of the portions from `first` on; of all of them set by rmap_map_content_check. */
void rmap_map_content_run_up(struct rmap_map_content *content, size_t first);

/* Where bytes for another process go: to memory or, where there is none, to a file. */
struct rmap_packing {
    uint8_t *to;
    int fd;
    bool failed; /* to write; errno says why */
};
void rmap_pack(struct rmap_packing *packing, const void *from, size_t nbytes);

/* The content as bytes for another process of this program, so many of them. */
size_t rmap_map_content_packed_nbytes(const struct rmap_map_content *content);
void rmap_map_content_pack(const struct rmap_map_content *content, struct rmap_packing *packing);

/* A content whose rows are those of the blob, which outlives it; of its own are the tails' rows
 * alone (rmap_free). Sizes are checked: RMAP_FORMAT. */
enum rmap_status rmap_map_content_view(uint8_t *blob, size_t nbytes,
                                       struct rmap_map_content *view_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Appends a copy of it to `into`. Row numbers are checked, too: RMAP_FORMAT. */
enum rmap_status rmap_map_content_unpack(uint8_t *blob, size_t nbytes,
                                         struct rmap_map_content *into,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* The tail of a piece's stream in a sorted content, or NULL. */
const struct rmap_stream_tail *rmap_map_content_tail(const struct rmap_map_content *content,
                                                     size_t piece, int stream);

/* Checks a sorted content: chunks lie in the order of pieces, portions lie in their pieces and hold
 * different rays; sums it up. Chunks are checked when a piece is first read. RMAP_FORMAT says what
 * does not fit; `path` is for the message. */
enum rmap_status rmap_map_content_check(struct rmap_map_content *content, const char *path,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* What a piece says of where it belongs: the same attributes in a sealed file, in a journal and
 * in the index. */
struct rmap_piece_origin {
    uint64_t seed;
    int32_t tracer_revision; /* 0: not known, as of a journal */
    char scene_digest[33];   /* the same in all colour spaces of a scene */
    char space_digest[33];   /* of the scene in this colour space */
    int32_t encoding;        /* enum rmap_encoding */
    int32_t mode;            /* enum rmap_colour_mode */
    int32_t n_channel;
};

/* Layout of a piece in a colour mode; NULL when this program does not know its encoding. */
const struct rmap_layout *rmap_piece_layout(const struct rmap_piece_info *piece,
                                            enum rmap_colour_mode mode);

/* How its pieces are stored: "plain", "compact", "plain and compact"; "" without pieces. Static. */
const char *rmap_map_content_encodings(const struct rmap_map_content *content);

/* The number behind those of a shard's finished pieces; 0: it has none. */
int rmap_map_content_next_number(const struct rmap_map_content *content, int shard);

/* Makes piece->name of its shard and number, both in [0, 99999]. */
void rmap_piece_name_set(struct rmap_piece_info *piece);

#endif
