/* SPDX-License-Identifier: MIT
 *
 * What stands behind `where`, put to one registration: its numbers, the steps before it, the step
 * at its own place, and the history up to it.
 */
#include "analysis/criterion/criterion_evaluate.h"
#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/criterion_sum.h"
#include "analysis/criterion/path_walk.h"
#include "analysis/criterion/registration_angle.h"
#include "analysis/criterion/registration_response.h"

/* Walks that go on from one registration of a ray to its next; a further path("...") of the same
 * condition may have to begin anew. */
enum { N_WALK = 4 };

/* A registration, and the segments before that on which the detector was reached. */
struct seen {
    const struct rmap_criterion *criterion;
    const struct rmap_portion *portion;
    rmap_column_set columns; /* that there are */
    size_t row;
    size_t ray_row;           /* where the rows of /registration of its ray begin */
    struct rmap_strip before; /* of one ray */
    struct rmap_path_walk walk[N_WALK];
};

/* Goes on to registration `row`, further on in the portion. */
static void see_next(struct seen *seen, size_t row)
{
    const struct rmap_ray_columns *ray = &seen->portion->ray;
    size_t at = seen->before.ray, first = seen->before.first;
    for (; row >= seen->ray_row + ray->registration_count[at]; at++) {
        seen->ray_row += ray->registration_count[at];
        first += ray->segment_count[at];
    }
    size_t segment = seen->portion->registration.segment[row];
    seen->before = (struct rmap_strip){
        .first = first,
        .n = segment < ray->segment_count[at] ? segment : ray->segment_count[at],
        .ray = at,
        .ray_row = first};
    seen->row = row;
}

/* The steps that a test asks for. */
static struct rmap_strip steps_of(const struct seen *seen, enum rmap_steps_of of)
{
    struct rmap_strip part = seen->before;
    const size_t end = part.first + part.n;
    const int32_t detector = seen->portion->registration.detector[seen->row];
    if (of == RMAP_STEPS_OWN) {
        part.n = rmap_detector_lies_on(&seen->criterion->scene->detector[detector]) &&
                 part.n < seen->portion->ray.segment_count[part.ray];
        part.first = end;
    } else if (of == RMAP_STEPS_LAST) {
        part.first = end;
        while (part.first > seen->before.first && seen->portion->segment.object[part.first - 1] < 0)
            part.first--;
        part.n = part.first > seen->before.first;
        part.first -= part.n;
    }
    return part;
}

/* By objects and events alone: a ray has fewer rows than loops over columns are worth calling for.
 */
static uint32_t count_plain(const struct rmap_segment_columns *segment,
                            const struct rmap_step_test *test, const struct rmap_strip *part)
{
    const bool of_event = (test->events | test->events_not) != 0;
    uint32_t sum = 0;
    for (size_t row = part->first; row < part->first + part->n; row++) {
        const uint32_t event = of_event ? segment->event[row] : 0;
        sum += (!test->of_object || rmap_index_set_has(&test->object, segment->object[row])) &&
               (!test->events || (event & test->events)) && !(event & test->events_not);
    }
    return sum;
}

static uint32_t count_steps(const struct seen *seen, const struct rmap_step_test *test)
{
    enum { N = 256 };
    uint8_t flag[N];
    uint32_t sum = 0;
    struct rmap_strip part = steps_of(seen, test->of);
    if (!test->of_medium && test->part == RMAP_PART_ALL && !test->side && test->n_limit == 0)
        return count_plain(&seen->portion->segment, test, &part);
    for (const size_t end = part.first + part.n; part.first < end; part.first += N) {
        part.n = end - part.first < N ? end - part.first : N;
        rmap_steps_mark(seen->criterion, test, seen->portion, &part, flag);
        for (size_t i = 0; i < part.n; i++)
            sum += flag[i];
    }
    return sum;
}

static bool path_matches(struct seen *seen, int32_t index)
{
    struct rmap_path_walk *walk = &seen->walk[index % N_WALK];
    const struct rmap_path_table *table = seen->criterion->node[index].path.table;
    if (walk->table != table || walk->ray != seen->before.ray)
        *walk = rmap_path_walk_from(table, seen->before.ray, seen->before.first, seen->ray_row);
    return rmap_path_walk_to(walk, seen->portion, seen->row);
}

static bool asks_for_angle(const struct rmap_criterion_node *node)
{
    return node->kind == RMAP_CRITERION_ITS_NUMBER && node->its_number == RMAP_REGISTRATION_ANGLE;
}

/* Whether only the quarters of a degree are there. */
static bool is_by_quarter(const struct rmap_criterion_node *node, rmap_column_set columns,
                          const struct rmap_portion *portion)
{
    return asks_for_angle(node) && (node->columns & ~columns) && portion->knows_angles;
}

/* A test whose columns are there. */
static bool test_holds(struct seen *seen, int32_t index)
{
    const struct rmap_criterion *criterion = seen->criterion;
    const struct rmap_criterion_node *node = &criterion->node[index];
    const struct rmap_registration_columns *its = &seen->portion->registration;
    if (asks_for_angle(node))
        return rmap_angle_holds(&criterion->scene->detector[its->detector[seen->row]],
                                its->direction + 3 * seen->row, &node->interval, &node->angle);
    if (node->kind == RMAP_CRITERION_ITS_NUMBER && node->its_number == RMAP_REGISTRATION_DETECTED)
        return rmap_registration_detected(
            criterion->scene, seen->portion,
            &(struct rmap_registration_place){seen->row, seen->before.ray, seen->before.first});
    if (node->kind == RMAP_CRITERION_ITS_NUMBER)
        return rmap_interval_holds(
            &node->interval,
            rmap_registration_number(criterion->scene, seen->portion, seen->row, node->its_number));
    if (node->kind == RMAP_CRITERION_SUM)
        return rmap_sum_holds_for_registration(criterion, node, seen->portion, seen->row);
    if (node->kind == RMAP_CRITERION_STEPS)
        return rmap_interval_holds(&node->interval, count_steps(seen, &node->steps));
    return rmap_interval_holds(&node->interval, path_matches(seen, index));
}

/* enum rmap_outcome, open where not all columns are there. */
static uint8_t where_outcome(struct seen *seen, int32_t index)
{
    const struct rmap_criterion *criterion = seen->criterion;
    const struct rmap_criterion_node *node = &criterion->node[index];
    const bool is_and = node->kind == RMAP_CRITERION_AND;
    if (node->kind == RMAP_CRITERION_NOT)
        return rmap_outcome_not(where_outcome(seen, node->first));
    if (is_and || node->kind == RMAP_CRITERION_OR) {
        const uint8_t last_word = is_and ? RMAP_OUTCOME_NO : RMAP_OUTCOME_YES;
        uint8_t own = rmap_outcome_not(last_word);
        for (int32_t child = node->first; child >= 0 && own != last_word;
             child = criterion->node[child].next) {
            const uint8_t its = where_outcome(seen, child);
            own = is_and ? own & its : own | its;
        }
        return own;
    }
    if (!(node->columns & ~seen->columns))
        return test_holds(seen, index) ? RMAP_OUTCOME_YES : RMAP_OUTCOME_NO;
    return is_by_quarter(node, seen->columns, seen->portion)
               ? rmap_angle_outcome(seen->portion->angle[seen->row], &node->interval, &node->angle)
               : RMAP_OUTCOME_OPEN;
}

bool rmap_where_tells(const struct rmap_criterion *criterion, int32_t where,
                      const struct rmap_portion *portion, rmap_column_set columns)
{
    const struct rmap_criterion_node *node = &criterion->node[where];
    bool any = !(node->columns & ~columns) || (asks_for_angle(node) && portion->knows_angles);
    for (int32_t child = node->first; child >= 0 && !any; child = criterion->node[child].next)
        any = rmap_where_tells(criterion, child, portion, columns);
    return any;
}

/* rmap_where_keep of an angle alone: what most ask. */
static void keep_quarters(const struct rmap_criterion_node *node, const uint16_t *quarter,
                          size_t n_row, uint64_t *bits, uint64_t *sure)
{
    for (size_t first = 0; first < n_row; first += 64) {
        const size_t n = n_row - first < 64 ? n_row - first : 64;
        uint64_t may = 0, surely = 0;
        for (size_t i = 0; i < n; i++) {
            const uint8_t its =
                rmap_angle_outcome(quarter[first + i], &node->interval, &node->angle);
            may |= (uint64_t)(its != RMAP_OUTCOME_NO) << i;
            surely |= (uint64_t)(its == RMAP_OUTCOME_YES) << i;
        }
        bits[first / 64] &= may;
        if (sure)
            sure[first / 64] = bits[first / 64] & surely;
    }
}

void rmap_where_keep(const struct rmap_criterion *criterion, int32_t where, rmap_column_set columns,
                     const struct rmap_portion *portion, size_t n_row, uint64_t *bits,
                     uint64_t *sure)
{
    const bool of_steps =
        (criterion->node[where].columns & columns & RMAP_COLUMN_BIT(RMAP_RAY_segment_count)) != 0;
    struct seen seen = {.criterion = criterion, .portion = portion, .columns = columns};
    if (is_by_quarter(&criterion->node[where], columns, portion)) {
        keep_quarters(&criterion->node[where], portion->angle, n_row, bits, sure);
        return;
    }
    for (size_t first = 0; first < n_row; first += 64) {
        uint64_t kept = n_row - first < 64 ? (UINT64_C(1) << (n_row - first)) - 1 : UINT64_MAX;
        uint64_t surely = 0;
        kept &= bits[first / 64];
        for (uint64_t left = kept; left != 0; left &= left - 1) {
            seen.row = first + (size_t)__builtin_ctzll(left);
            if (of_steps)
                see_next(&seen, seen.row);
            const uint8_t outcome = where_outcome(&seen, where);
            kept ^= (left & (0 - left)) * (outcome == RMAP_OUTCOME_NO);
            surely |= (left & (0 - left)) * (outcome == RMAP_OUTCOME_YES);
        }
        bits[first / 64] = kept;
        if (sure)
            sure[first / 64] = surely;
    }
}
