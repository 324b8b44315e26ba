/* SPDX-License-Identifier: MIT
 *
 * A criterion as a typed tree: and, or, not over elementary tests. Names are resolved to sets of
 * indices, units to the map's own, and every comparison to one interval.
 */
#ifndef RMAP_CRITERION_TREE_H
#define RMAP_CRITERION_TREE_H

#include "analysis/criterion/criterion.h"
#include "analysis/criterion/ray_number.h"
#include "base/id_set.h"

/* True for v in the closed [low, high], or, when `outside`, for v beyond it. Never for NaN. */
struct rmap_interval {
    double low, high;
    bool outside;
};

static inline bool rmap_interval_holds(const struct rmap_interval *interval, double v)
{
    return interval->outside ? (v < interval->low) | (v > interval->high)
                             : (v >= interval->low) & (v <= interval->high);
}

/* Indices k with low <= k < low + span, all of them or those marked. */
struct rmap_index_set {
    int32_t low;
    uint32_t span;
    uint8_t *member; /* [span], NULL: all; of the criterion's store */
};

static inline bool rmap_index_set_has(const struct rmap_index_set *set, int32_t k)
{
    uint32_t at = (uint32_t)k - (uint32_t)set->low;
    return at < set->span && (!set->member || set->member[at]);
}

/* The same for a set with members, without a branch: which of them a row meets is random. */
static inline uint8_t rmap_index_set_member(const struct rmap_index_set *set, int32_t k)
{
    uint32_t at = (uint32_t)k - (uint32_t)set->low;
    uint32_t inside = at < set->span;
    return (uint8_t)(inside & set->member[at & (0u - inside)]);
}

enum rmap_criterion_kind {
    RMAP_CRITERION_ALL,
    RMAP_CRITERION_AND, /* of the children; so OR; NOT of the one child */
    RMAP_CRITERION_OR,
    RMAP_CRITERION_NOT,
    RMAP_CRITERION_SOURCE,        /* a count, 0 or 1 */
    RMAP_CRITERION_ENDED,         /* a count, 0 or 1 */
    RMAP_CRITERION_NUMBER,        /* of the ray */
    RMAP_CRITERION_PATH_IN,       /* its length inside media */
    RMAP_CRITERION_STEPS,         /* a count of rows of /segment; below `where` of those before the
                                     segment on which the detector was reached */
    RMAP_CRITERION_REGISTRATIONS, /* a count of rows of /registration */
    RMAP_CRITERION_PATH,          /* a count, 0 or 1: the whole history as a sequence; below
                                     `where` the history up to and with the registration */
    RMAP_CRITERION_RAYS,          /* whether the ray is of a set that the map keeps */
    RMAP_CRITERION_ITS_NUMBER,    /* of one registration; below `where` only */
    RMAP_CRITERION_SUM            /* numbers compared with each other, of the ray, or below `where`
                                     of one registration */
};

enum rmap_registration_number {
    RMAP_REGISTRATION_ANGLE, /* degrees */
    RMAP_REGISTRATION_X,     /* scene's length unit, or degrees on an intensity grid */
    RMAP_REGISTRATION_Y,
    RMAP_REGISTRATION_WORLD_X, /* the scene's length unit; of planes alone, else NaN */
    RMAP_REGISTRATION_WORLD_Y,
    RMAP_REGISTRATION_WORLD_Z,
    RMAP_REGISTRATION_TIME,         /* s, of scenes that are not timed: optical path / c */
    RMAP_REGISTRATION_ARRIVAL,      /* s, of timed ones: delay + group path / c */
    RMAP_REGISTRATION_OPTICAL_PATH, /* scene's length unit, from emission */
    RMAP_REGISTRATION_GROUP_PATH,
    RMAP_REGISTRATION_DETECTED /* 1 or 0; of criteria alone, below `where` */
};

enum rmap_step_number {
    RMAP_STEP_ANGLE, /* of incidence, degrees */
    RMAP_STEP_X,     /* in the frame of the object met; the scene's length unit */
    RMAP_STEP_Y,
    RMAP_STEP_Z,
    RMAP_STEP_WORLD_X,
    RMAP_STEP_WORLD_Y,
    RMAP_STEP_WORLD_Z,
    RMAP_STEP_LENGTH,      /* of the leg that ends there; 0 of one that leaves */
    RMAP_STEP_PATH_LENGTH, /* from emission to there */
    RMAP_STEP_ORDER,       /* from 0 within the ray */
    RMAP_STEP_WAVELENGTH,  /* nm, of the light that comes there */
    RMAP_STEP_MODEL        /* that scattered, enum rmap_scatter_model; has no word */
};

/* `time` is the time of arrival in timed scenes. */
static inline enum rmap_registration_number rmap_time_in(const struct rmap_scene *scene,
                                                         enum rmap_registration_number number)
{
    const bool arrives = scene->timed && number == RMAP_REGISTRATION_TIME;
    return arrives ? RMAP_REGISTRATION_ARRIVAL : number;
}

/* Cosine and sine of an interval's ends, kept within 0 to 180 degrees. Not set: they tell nothing.
 * And the quarters of a degree (compact/angles.h) that lie in it whole, and those that touch it. */
struct rmap_angle_ends {
    bool is_set;
    double low[2], high[2];
    uint16_t first_inside, n_inside, first_near, n_near;
};

/* Part of an object. Ranges are closed. */
enum rmap_part { RMAP_PART_ALL, RMAP_PART_FACE, RMAP_PART_TRIANGLE };

/* Of a ray all steps, of a registration those before it; below `where` also the last one at an
 * object of these, or the step at the detector's own place. */
enum rmap_steps_of { RMAP_STEPS_ALL, RMAP_STEPS_LAST, RMAP_STEPS_OWN };

struct rmap_step_limit; /* step_number.h */

/* Which rows of /segment count. What is not given holds for every row. */
struct rmap_step_test {
    bool of_object, of_medium;
    enum rmap_steps_of of;
    struct rmap_index_set object, medium;
    uint64_t object_bits[4]; /* as in struct rmap_portion_summary */
    uint32_t events;         /* any of these bits; 0: not given */
    uint32_t events_not;     /* and none of these */
    enum rmap_part part;
    uint32_t part_low, part_high;
    uint8_t *side; /* [n_object] which sides of an object count: bit 0 front, bit 1 back; NULL: no
                      object needs the question; owned by the criterion */
    bool by_way;   /* `side`: bits 2 and 3 are the same of light that passes diffusely */
    const struct rmap_step_limit *limit; /* [n_limit] what its numbers must keep within; owned by
                                            the criterion */
    size_t n_limit;
};

struct rmap_ending_test {
    uint32_t stop;
    bool somewhere; /* last row's object in `object`, or no object and its medium in `medium` */
    struct rmap_index_set object, medium;
    uint64_t object_bits[4];
};

enum rmap_region {
    RMAP_REGION_ALL,
    RMAP_REGION_RECT,
    RMAP_REGION_ELLIPSE,
    RMAP_REGION_POLYGON,
    RMAP_REGION_CELLS
};

/* Closed ranges of the two stored 16-bit coordinates (relative, or cell); empty: low > high. */
struct rmap_box {
    uint32_t low[2], high[2];
};

/* Which rows of /registration count. */
struct rmap_registration_test {
    struct rmap_index_set detector;
    uint64_t detector_bits;
    bool crossed; /* also where it was not registered */
    enum rmap_region region;
    bool relative;        /* region in 0..1 instead of the detector's own units */
    double bound[4];      /* RECT x0 y0 x1 y1; ELLIPSE cx cy rx ry */
    double cosine, sine;  /* ELLIPSE: of the angle that it is turned by */
    struct rmap_box *box; /* RECT, CELLS, and ALL with a range of x or y: [n_detector]; owned
                             by the criterion */
    double (*corner)[2];  /* POLYGON [n_corner]; owned by the criterion */
    size_t n_corner;
    int32_t where;       /* node, or -1 */
    const char *chooses; /* "REGION where CONDITION" as it is written, NULL: neither; owned by the
                            criterion */
    bool of_number;      /* x(detector) > 1 and its like */
};

/* path("..."): an automaton over the letters and names of steps and registrations. */
struct rmap_path_test {
    rmap_column_set columns;             /* that rmap_path_mark reads */
    const struct rmap_path_table *table; /* owned by the criterion */
};

/* Numbers times factors, and a constant in their unit; all of a step, or none. */
struct rmap_sum_term {
    double factor;
    bool of_registration; /* its_number of those on `detector`, below `where` of that in hand */
    enum rmap_step_number step_number;
    enum rmap_ray_number ray_number;
    enum rmap_registration_number its_number;
    struct rmap_index_set detector;
};
struct rmap_sum {
    const struct rmap_sum_term *term; /* [n]; owned by the criterion */
    size_t n;
    double constant;
};

static inline bool rmap_sum_of_phase_time(const struct rmap_sum *sum)
{
    bool of = false;
    for (size_t k = 0; k < sum->n; k++)
        of |= sum->term[k].of_registration && sum->term[k].its_number == RMAP_REGISTRATION_TIME;
    return of;
}

/* Whether the ids of rays are among them. */
static inline bool rmap_sum_of_ids(const struct rmap_sum *sum)
{
    bool of = false;
    for (size_t k = 0; k < sum->n; k++)
        of |= !sum->term[k].of_registration && sum->term[k].ray_number == RMAP_RAY_NUMBER_ID;
    return of;
}

struct rmap_criterion_node {
    enum rmap_criterion_kind kind;
    int32_t first, next;     /* first child, next sibling; -1: none */
    size_t begin, end;       /* bytes of the text */
    rmap_column_set columns; /* that decide it; set by the plan, so that of a subtree */
    struct rmap_interval interval;
    union {
        struct {
            enum rmap_ray_number ray_number;
            uint64_t id_low, id_high; /* of ID and EVENT the interval, exactly: a double holds 2^53
                                       */
            uint64_t ray_low, ray_high; /* of EVENT: ids of rays that it may hold for */
        };
        struct {
            enum rmap_registration_number its_number;
            struct rmap_angle_ends angle; /* of ANGLE; set by the plan */
        };
        struct {
            struct rmap_index_set source;
            uint64_t source_bits;
        };
        struct rmap_index_set media;    /* PATH_IN */
        const struct rmap_id_set *rays; /* borrowed from the map */
        struct rmap_ending_test ending;
        struct rmap_step_test steps;
        struct rmap_registration_test registrations;
        struct rmap_path_test path;
        struct rmap_sum sum;
    };
};

struct rmap_path_store;

struct rmap_criterion {
    char *text;
    char *name;                     /* of the definition that it is, or NULL */
    const struct rmap_scene *scene; /* borrowed */
    struct rmap_criterion_node *node;
    size_t n_node, node_cap;
    void **block; /* arrays that nodes point to */
    size_t n_block, block_cap;
    struct rmap_path_store *paths; /* held; NULL: no path is in it */
    int32_t root;
    int n_mask; /* intermediate results that evaluation holds at once */
    rmap_column_set columns;
    bool is_mixed; /* compares numbers that are lengths on some detectors, angles on others */
};

/* Parentheses nest no deeper than this: the parser and the evaluator recurse. */
#define RMAP_CRITERION_DEPTH 2000

/* A new node with no children; *index_ret may be kept, pointers to nodes may not. */
enum rmap_status rmap_criterion_node_add(struct rmap_criterion *criterion,
                                         const struct rmap_criterion_node *node, int32_t *index_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Zeroed memory that lives as long as the criterion. */
enum rmap_status rmap_criterion_block_add(struct rmap_criterion *criterion, size_t n, size_t size,
                                          void **block_ret, struct rmap_error *err) RMAP_MUST_USE;

struct rmap_criteria;

/* A criterion that is one test of registrations on these detectors (copied), as may stand in
 * registered(NAME, ...) behind the name. RMAP_INPUT: "--which:1:7: error: ...". */
enum rmap_status rmap_criterion_compile_which(const char *text,
                                              const struct rmap_criteria *criteria,
                                              const struct rmap_scene *scene,
                                              const struct rmap_index_set *detector,
                                              struct rmap_criterion **criterion_ret,
                                              struct rmap_error *err) RMAP_MUST_USE;

/* Parses the text into criterion->node and root. criteria: NULL, no names are defined. */
enum rmap_status rmap_criterion_parse(struct rmap_criterion *criterion,
                                      const struct rmap_criteria *criteria,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* The same of what may stand in registered(NAME, ...) behind the name, for these detectors: root is
 * that test. A condition alone may stand for `where` and it. */
enum rmap_status rmap_criterion_parse_which(struct rmap_criterion *criterion,
                                            const struct rmap_criteria *criteria,
                                            const struct rmap_index_set *detector,
                                            struct rmap_error *err) RMAP_MUST_USE;

/* False: no ray with one of the ids first ... last can match. */
bool rmap_criterion_may_hold(const struct rmap_criterion *criterion, uint64_t first, uint64_t last);

/* True when no ray of the portion can match, by its ids and its summary. */
struct rmap_portion_info; /* io/map/map_reader.h */
bool rmap_criterion_skips(const struct rmap_criterion *criterion,
                          const struct rmap_portion_info *portion);

/* True when the medium travelled tells the side of the object that light met; else geometry. */
static inline bool rmap_object_medium_tells(const struct rmap_object *object)
{
    return object->medium_front != object->medium_back && object->medium_front != RMAP_MEDIUM_ANY &&
           object->medium_back != RMAP_MEDIUM_ANY;
}

/* Columns that tell which of these sides light met. side: [n_object] as in struct rmap_step_test.
 */
static inline bool rmap_side_matters(uint8_t side)
{
    const unsigned of = side & 3U, passing = side >> 2U;
    return of == 1 || of == 2 || passing == 1 || passing == 2;
}
rmap_column_set rmap_side_columns(const struct rmap_scene *scene, const uint8_t *side);

/* Some rows of a table, and the ray that the first of them belongs to. */
struct rmap_strip {
    size_t first, n; /* rows */
    size_t ray;      /* row of /ray */
    size_t ray_row;  /* where that ray's rows begin */
};

/* Bits stay of those rows of /registration for which `where`, a node, may hold, and in `sure` for
 * which it does. columns: those that there are; without others, not all of it is known. bits, sure:
 * [words of n_row]; the latter NULL where nobody asks. */
void rmap_where_keep(const struct rmap_criterion *criterion, int32_t where, rmap_column_set columns,
                     const struct rmap_portion *portion, size_t n_row, uint64_t *bits,
                     uint64_t *sure);

/* Whether these columns of the portion tell anything of it. */
bool rmap_where_tells(const struct rmap_criterion *criterion, int32_t where,
                      const struct rmap_portion *portion, rmap_column_set columns);

/* A number of a registration (row of /registration), and the columns that it is made of. */
rmap_column_set rmap_registration_number_columns(enum rmap_registration_number number);

/* RMAP_INPUT, with the remedy, where the columns are such that only timed runs have. */
enum rmap_status rmap_check_times(const struct rmap_scene *scene, rmap_column_set columns,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* The same where they tell channels, which mean different wavelengths in parts of the map. */
enum rmap_status rmap_check_channels(const struct rmap_scene *scene, rmap_column_set columns,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
