/* SPDX-License-Identifier: MIT
 *
 * The bytes of a history index, for the files that write and read them: docs/map.md, "The history
 * index". Numbers are little-endian, every array begins at a multiple of 8 bytes.
 */
#ifndef RMAP_HISTORY_PARTS_H
#define RMAP_HISTORY_PARTS_H

#include "history/history_index.h"

#define RMAP_HISTORY_MAGIC                                                                         \
    UINT64_C(0x31747369482e6d72) /* "rm.Hist1": its last byte counts formats */

enum {
    RMAP_HISTORY_RAY_MAX = 65535,    /* of a portion */
    RMAP_HISTORY_CLASS_MAX = 65535,  /* of a piece; kinds of rays of a portion */
    RMAP_HISTORY_PATH_MAX = 1 << 20, /* of a piece */
    RMAP_HISTORY_PATH_ROW_MAX =
        1 << 22 /* segments of all paths of a piece; registrations likewise */
};

/* The head: this, then its arrays in the order of enum rmap_history_head_part, then the XXH3-64 of
 * all before. */
struct rmap_history_head {
    uint64_t magic;
    uint64_t n_class, n_hit, n_path, n_path_segment, n_path_registration, n_portion;
    uint64_t body_nbytes;
};

enum rmap_history_head_part {
    RMAP_HEAD_CLASS,              /* struct rmap_step_class [n_class] */
    RMAP_HEAD_HIT,                /* struct rmap_history_hit [n_hit] */
    RMAP_HEAD_SOURCE,             /* i32 [n_path] */
    RMAP_HEAD_STOP,               /* u8 [n_path] */
    RMAP_HEAD_SEGMENT_COUNT,      /* u32 [n_path] */
    RMAP_HEAD_REGISTRATION_COUNT, /* u32 [n_path] */
    RMAP_HEAD_PATH_CLASS,         /* u16 [n_path_segment] */
    RMAP_HEAD_PATH_SEGMENT,       /* u32 [n_path_registration] */
    RMAP_HEAD_PATH_HIT,           /* u16 [n_path_registration] */
    RMAP_HEAD_PORTION,            /* struct rmap_history_place [n_portion] */
    RMAP_HEAD_PARTS
};

/* Where a portion's bytes stand in the body. */
struct rmap_history_place {
    uint64_t first_ray;
    uint64_t digest_low, digest_high; /* of its rays */
    uint64_t offset, checksum;        /* XXH3-64 of its bytes */
    uint32_t nbytes;
    uint32_t n_row[RMAP_TABLE_HISTORY_COUNT];
    uint8_t form, unit_weight, has_relative, zero[5];
};

/* A portion's bytes: this, then its arrays. Those that its form does not have are empty. */
struct rmap_history_shape {
    uint32_t n_path;
    uint32_t n_kind, n_local;
    uint32_t n_common;   /* of the local classes, the first ones: they have codes of their own */
    uint32_t n_rare;     /* segments of the others */
    uint32_t n_long;     /* rays of 255 segments and more */
    uint32_t n_frequent; /* local classes of 255 segments and more */
    uint32_t n_many;     /* rays of 15 registrations and more */
    uint32_t n_far;      /* registrations on segment 255 and later ones */
    uint8_t kind_nbytes; /* of a number: 0 (all the same), 1 or 2 */
    uint8_t hit_nbytes;
    uint8_t zero[2];
};

/* The codes of a byte from 255 downwards stand for the local classes behind the common ones, 256
 * each: code 255 - k for those from n_common + 256 k on, the rest of the number being in the list
 * of rare ones. So many codes do so: as few as will do. */
static inline uint32_t rmap_history_n_page(uint32_t n_local)
{
    return n_local <= 256 ? 0 : (n_local - 256 + 254) / 255;
}

enum rmap_history_part {
    RMAP_PART_PATH_ROW,    /* u32 [n_path] */
    RMAP_PART_PATH_RAYS,   /* u16 [n_path] */
    RMAP_PART_PATH,        /* u16 [n_ray] */
    RMAP_PART_KIND_SOURCE, /* i32 [n_kind] */
    RMAP_PART_KIND_STOP,   /* u8 [n_kind] */
    RMAP_PART_KIND,        /* [n_ray] */
    RMAP_PART_LOCAL_CLASS, /* u16 [n_local] */
    RMAP_PART_LOCAL_ROWS,  /* u8 [n_local], the most first; 255: the next of the frequent ones */
    RMAP_PART_FREQUENT,    /* u32 [n_frequent] */
    RMAP_PART_CODE,        /* u8 [n_segment]: of the local class, or of 256 rare ones */
    RMAP_PART_RARE,        /* u8 [n_rare]: which of them */
    RMAP_PART_COUNT,       /* u8 [n_ray]: segments; 255: the next of the long ones */
    RMAP_PART_LONG,        /* u32 [n_long] */
    RMAP_PART_HITS,        /* 4 bits [n_ray], if there are registrations, the lower half of a byte
                              first: how many; 15: the next of the many */
    RMAP_PART_MANY,        /* u32 [n_many] */
    RMAP_PART_HIT,         /* [n_registration], or [1] if all are the same */
    RMAP_PART_SEGMENT,     /* u8 [n_registration]; 255: the next of the far ones */
    RMAP_PART_FAR,         /* u32 [n_far] */
    RMAP_PART_RELATIVE,    /* u16 [n_registration][2], if it has them */
    RMAP_PART_COUNT_OF
};

/* Bytes from the start of the portion's (or of the head) to each array; the last is their end.
 * Rounded up to multiples of 8. */
struct rmap_history_layout {
    uint64_t at[RMAP_PART_COUNT_OF + 1];
};
void rmap_history_arrange(const struct rmap_history_place *place,
                          const struct rmap_history_shape *shape,
                          struct rmap_history_layout *layout);
void rmap_history_arrange_head(const struct rmap_history_head *head,
                               struct rmap_history_layout *layout);

struct rmap_history_index {
    size_t n_class, n_hit, n_portion, n_source; /* n_source: of the scene */
    struct rmap_step_class *class_of;           /* [n_class] */
    struct rmap_history_hit *hit;               /* [n_hit] */
    struct rmap_portion *paths;
    uint32_t *path_segment, *path_registration; /* first rows of each path */
    struct rmap_history_place *place;           /* [n_portion], by first ray */
    struct rmap_history_body body;
};

/* Sets of classes that were asked for in the portion in hand, and their segments. */
enum { RMAP_HISTORY_SET_MAX = 16 };
struct rmap_history_sets {
    size_t n; /* asked for so far; set k is in place k % RMAP_HISTORY_SET_MAX */
    size_t n_class;
    bool any[RMAP_HISTORY_SET_MAX]; /* there are such segments */
    uint8_t *wanted;                /* [places][n_class] */
    uint64_t *mark;                 /* [places][rmap_history_mark_words] */
    size_t cap_wanted, cap_mark;
};

/* A portion was opened: room for its segments. RMAP_SYSTEM. */
enum rmap_status rmap_history_sets_enter(struct rmap_history_view *view,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_history_sets_fini(struct rmap_history_sets *sets);

/* What a view of the form ROWS has beside what it shows. */
struct rmap_history_rows {
    struct rmap_history_made *made; /* of the portion in hand: own, or borrowed */
    struct rmap_history_made *own;
    size_t cap_own; /* bytes */
    /* In what was made: */
    uint32_t *segment_count, *registration_count; /* widened */
    uint16_t *kind;
    uint32_t *local_rows;
    /* As stored: */
    const uint8_t *code;
    const uint8_t *rare;
    const uint8_t *hit; /* numbers of as many bytes as the shape says */
    const uint8_t *segment;
    const uint32_t *far;
    struct rmap_history_shape shape;
    /* For counting: */
    struct rmap_history_sets sets;
    uint64_t *mark_hit; /* [rmap_history_hit_words], a bit per registration */
    size_t cap_mark_hit;
    /* In what was made, once it is there: */
    uint64_t *rare_mark; /* [rmap_history_mark_words], a bit per rare segment */
    uint32_t *rank;      /* [the same] rare segments before each word of these */
};

/* The arrays of struct rmap_history_made. */
enum rmap_history_made_part {
    RMAP_MADE_BYTES, /* the portion's, if they were read */
    RMAP_MADE_SEGMENT_COUNT,
    RMAP_MADE_REGISTRATION_COUNT,
    RMAP_MADE_KIND,
    RMAP_MADE_LOCAL_ROWS,
    RMAP_MADE_RARE_MARK, /* if it has rare ones */
    RMAP_MADE_RANK,      /* if it is ranked */
    RMAP_MADE_PARTS
};

/* Bytes from the start of the block to each array. */
void rmap_history_arrange_made(const struct rmap_history_place *place,
                               const struct rmap_history_shape *shape, uint64_t nbytes_read,
                               struct rmap_history_layout *layout);

/* Words of a bit per segment, and one more, so that eight bytes may be read at any of them. */
static inline size_t rmap_history_mark_words(const struct rmap_history_view *view)
{
    return view->n_row[RMAP_TABLE_SEGMENT] / 64 + 2;
}

static inline size_t rmap_history_hit_words(const struct rmap_history_view *view)
{
    return view->n_row[RMAP_TABLE_REGISTRATION] / 64 + 2;
}

/* Segments whose class is in the list of rare ones: a bit for each, found when first asked for.
 * NULL: there are none. */
const uint64_t *rmap_history_rare_segments(const struct rmap_history_view *view);

/* Local class of a segment with this code, for which the list of rare ones says `rare`. n_local:
 * there is no such class. */
static inline uint32_t rmap_history_rare_class(const struct rmap_history_shape *shape, uint8_t code,
                                               uint8_t rare)
{
    uint32_t k = shape->n_common + (255u - code) * 256 + rare;
    return k < shape->n_local ? k : shape->n_local;
}

/* Local class of a segment whose code is one of the rare ones'; rare: rmap_history_rare_segments.
 * Damage that a checksum hides may name classes that are not there. */
static inline uint32_t rmap_history_rare_at(const struct rmap_history_view *view,
                                            const uint64_t *rare, size_t segment)
{
    const struct rmap_history_rows *rows = view->rows;
    uint64_t below = rare[segment / 64] & ((UINT64_C(1) << segment % 64) - 1);
    uint32_t at = rows->rank[segment / 64] + (uint32_t)__builtin_popcountll(below);
    uint32_t k = at < rows->shape.n_rare
                     ? rmap_history_rare_class(&rows->shape, rows->code[segment], rows->rare[at])
                     : 0;
    return k < rows->shape.n_local ? k : 0;
}

/* Counts of a byte as 32 bits; 255 stands for the next of the longer ones. False when these are not
 * as many as they should be. */
bool rmap_history_widen(const uint8_t *byte, size_t n, const uint32_t *longer, uint32_t n_longer,
                        uint32_t *count);

/* Number k of an array of numbers of nbytes bytes; nbytes 0: the same for all, in two bytes. */
static inline uint32_t rmap_history_number(const uint8_t *array, unsigned nbytes, size_t k)
{
    const uint16_t *two = (const uint16_t *)(const void *)array;
    return nbytes == 1 ? array[k] : two[nbytes == 2 ? k : 0];
}

#endif
