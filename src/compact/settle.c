/* SPDX-License-Identifier: MIT
 *
 * Most rays are predicted well from beginning to end: all of a portion are traced again side by
 * side, and those with a wrong number on which later ones depend (a point, a colour) once more by
 * themselves, with the truth put in where they went wrong.
 */
#include "compact/settle.h"
#include "compact/retrace.h"

/* Numbers of a ray in each table's lanes, per row. */
struct strip {
    struct rmap_lane *lane;
    size_t width; /* numbers per row */
    const uint8_t *predicted;
    enum rmap_table span;
    bool leads; /* later predictions depend on it */
};

/* Rows [first, end) of a ray by span, a table with rows of rays, among the predictions; and where
 * its rows begin in the lanes. */
struct rows {
    size_t first[3], end[3], at[3];
};

/* Of the lanes that segments tell; those that lead stand in front. */
static int strips_of(const struct rmap_retrace *r, const struct rmap_portion *predicted,
                     struct strip strip[RMAP_LANE_COUNT])
{
    int n = 0;
    for (enum rmap_lane_role wanted = RMAP_LANE_LEADS; wanted <= RMAP_LANE_FOLLOWS; wanted++)
        for (int i = 0; i < rmap_lane_count(r->model->scene->timed); i++) {
            struct rmap_lane *lane = &r->lane[i];
            const enum rmap_table table = rmap_column_info(lane->column)->table;
            const enum rmap_lane_role role =
                lane->role == RMAP_LANE_PLACED && !r->placed ? RMAP_LANE_FOLLOWS : lane->role;
            if (role != wanted || (i == RMAP_LANE_SEGMENT_colour && !r->colour) ||
                (table == RMAP_TABLE_REGISTRATION && !r->crossing_segment))
                continue;
            strip[n++] = (struct strip){
                .lane = lane,
                .width = rmap_portion_row_nbytes(predicted, lane->column) / lane->element_nbytes,
                .predicted = rmap_portion_column(predicted, lane->column),
                .span = table,
                .leads = wanted == RMAP_LANE_LEADS,
            };
        }
    return n;
}

static void next_rows(const struct rmap_retrace *r, size_t i, struct rows *rows)
{
    rows->first[RMAP_TABLE_RAY] = i;
    rows->first[RMAP_TABLE_SEGMENT] = rows->end[RMAP_TABLE_SEGMENT];
    rows->first[RMAP_TABLE_REGISTRATION] = rows->end[RMAP_TABLE_REGISTRATION];
    rows->end[RMAP_TABLE_RAY] = i + 1;
    rows->end[RMAP_TABLE_SEGMENT] += r->segment_count[i];
    rows->end[RMAP_TABLE_REGISTRATION] += r->registration_count[i];
    memcpy(rows->at, rows->first, sizeof rows->at);
}

static void settle_ray(const struct strip *strip, int n, const struct rows *rows)
{
    for (int k = 0; k < n; k++) {
        size_t first = rows->first[strip[k].span] * strip[k].width,
               end = rows->end[strip[k].span] * strip[k].width,
               at = rows->at[strip[k].span] * strip[k].width;
        if (first < end)
            rmap_lane_settle(strip[k].lane, at, at + (end - first),
                             strip[k].predicted + first * strip[k].lane->element_nbytes);
    }
}

static bool any_careful(const struct rmap_batch *batch, size_t n_ray)
{
    return n_ray > 0 && memchr(batch->careful, 1, n_ray) != NULL;
}

/* Drops the strips in which every prediction of the portion is right; how many are left. Those
 * that lead stay in front. */
static int drop_right_ones(struct strip *strip, int n, const size_t *n_row)
{
    int left = 0;
    for (int k = 0; k < n; k++) {
        const struct rmap_lane *lane = strip[k].lane;
        size_t nbytes = n_row[strip[k].span] * strip[k].width * lane->element_nbytes;
        bool right = lane->from ? nbytes == 0 || memcmp(lane->from, strip[k].predicted, nbytes) == 0
                                : lane->next == SIZE_MAX;
        if (!right)
            strip[left++] = strip[k];
    }
    return left;
}

/* Decoding: is any number of the ray that leads others wrong? */
static bool misled(const struct strip *strip, int n, const struct rows *rows)
{
    for (int k = 0; k < n && strip[k].leads; k++)
        if (strip[k].lane->next < rows->end[strip[k].span] * strip[k].width)
            return true;
    return false;
}

/* Encoding: the same. */
static bool misleads(const struct strip *strip, int n, const struct rows *rows)
{
    for (int k = 0; k < n && strip[k].leads; k++) {
        const struct strip *s = &strip[k];
        size_t nbytes = s->width * s->lane->element_nbytes, first = rows->first[s->span] * nbytes,
               end = rows->end[s->span] * nbytes, at = rows->at[s->span] * nbytes;
        if (first < end && memcmp(s->lane->from + at, s->predicted + first, end - first) != 0)
            return true;
    }
    return false;
}

static size_t leading_patches(const struct strip *strip, int n)
{
    size_t sum = 0;
    for (int k = 0; k < n && strip[k].leads; k++)
        sum += strip[k].lane->n_patch;
    return sum;
}

static size_t all_patches(const struct strip *strip, int n)
{
    size_t sum = 0;
    for (int k = 0; k < n; k++)
        sum += strip[k].lane->n_patch;
    return sum;
}

enum rmap_status rmap_settle_decode(struct rmap_batch *batch, const struct rmap_retrace *r,
                                    bool one_by_one, struct rmap_portion *out,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct strip strip[RMAP_LANE_COUNT];
    struct rows rows = {.end = {0}};
    int n = strips_of(r, out, strip);
    for (int k = 0; k < n && strip[k].leads; k++)
        one_by_one = one_by_one || strip[k].lane->mode == RMAP_LANE_RESIDUAL ||
                     strip[k].lane->mode == RMAP_LANE_VERBATIM;
    if (!one_by_one)
        RMAP_TRY(rmap_batch_run(batch, r, out, err));
    if (!one_by_one)
        n = drop_right_ones(strip, n, out->n_row);
    if (!one_by_one && n == 0 && !any_careful(batch, r->n_ray))
        return RMAP_OK;
    for (size_t i = 0; i < r->n_ray; i++) {
        next_rows(r, i, &rows);
        if (one_by_one || batch->careful[i] || misled(strip, n, &rows))
            rmap_retrace(r, i, rows.first[RMAP_TABLE_SEGMENT], rows.first[RMAP_TABLE_REGISTRATION]);
        else
            settle_ray(strip, n, &rows);
    }
out:
    return st;
}

/* A ray at `rows`, ray number `ray` of r. False when the batch got it wrong and it came out right
 * by itself: a decoder could not know. */
static bool encode_ray(const struct rmap_retrace *r, size_t ray, bool careful,
                       const struct strip *strip, int n, const struct rows *rows)
{
    if (!careful && !misleads(strip, n, rows)) {
        settle_ray(strip, n, rows);
        return true;
    }
    size_t before = leading_patches(strip, n);
    rmap_retrace(r, ray, rows->at[RMAP_TABLE_SEGMENT], rows->at[RMAP_TABLE_REGISTRATION]);
    return careful || leading_patches(strip, n) > before;
}

static bool encode_side_by_side(const struct rmap_batch *batch, const struct rmap_retrace *r,
                                const struct strip *strip, int n)
{
    struct rows rows = {.end = {0}};
    for (size_t i = 0; i < r->n_ray; i++) {
        next_rows(r, i, &rows);
        if (!encode_ray(r, i, batch->careful[i], strip, n, &rows))
            return false;
    }
    return true;
}

/* What was found is forgotten, and every ray is followed by itself. */
static void encode_one_by_one(const struct rmap_retrace *r, const struct strip *strip, int n)
{
    struct rows rows = {.end = {0}};
    for (int k = 0; k < n; k++)
        strip[k].lane->n_patch = strip[k].lane->last = 0;
    for (size_t i = 0; i < r->n_ray; i++) {
        next_rows(r, i, &rows);
        rmap_retrace(r, i, rows.first[RMAP_TABLE_SEGMENT], rows.first[RMAP_TABLE_REGISTRATION]);
    }
}

enum rmap_status rmap_settle_encode(struct rmap_batch *batch, const struct rmap_retrace *r,
                                    struct rmap_portion *predicted, bool *one_by_one_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct strip strip[RMAP_LANE_COUNT];
    int n = strips_of(r, predicted, strip);
    RMAP_TRY(rmap_batch_run(batch, r, predicted, err));
    n = drop_right_ones(strip, n, predicted->n_row);
    *one_by_one_ret = false;
    if (n == 0 && !any_careful(batch, r->n_ray))
        return RMAP_OK;
    *one_by_one_ret = !encode_side_by_side(batch, r, strip, n);
    if (*one_by_one_ret)
        encode_one_by_one(r, strip, strips_of(r, predicted, strip));
out:
    return st;
}

enum rmap_status rmap_settle_encode_few(struct rmap_batch *batch, const struct rmap_retrace *r,
                                        const struct rmap_retrace *of_few,
                                        const struct rmap_few *few, struct rmap_portion *predicted,
                                        bool *one_by_one_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct strip strip[RMAP_LANE_COUNT];
    struct rows rows = {.end = {0}};
    int n = strips_of(of_few, predicted, strip);
    *one_by_one_ret = false;
    RMAP_TRY(rmap_batch_run(batch, of_few, predicted, err));
    for (size_t k = 0; k < few->n && !*one_by_one_ret; k++) {
        size_t before = all_patches(strip, n);
        next_rows(of_few, k, &rows);
        rows.at[RMAP_TABLE_RAY] = few->ray[k];
        rows.at[RMAP_TABLE_SEGMENT] = few->first_segment[k];
        rows.at[RMAP_TABLE_REGISTRATION] = few->first_registration[k];
        *one_by_one_ret = !encode_ray(r, few->ray[k], batch->careful[k], strip, n, &rows);
        if (few->sample[k] && (*one_by_one_ret || all_patches(strip, n) != before))
            return rmap_error_set(err, RMAP_INTERNAL,
                                  "ray %llu is not what its path predicts, as was promised: a "
                                  "mistake of this program; trace with --encoding plain",
                                  (unsigned long long)r->id[few->ray[k]]);
    }
    if (*one_by_one_ret)
        encode_one_by_one(r, strip, n);
out:
    return st;
}
