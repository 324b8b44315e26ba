/* SPDX-License-Identifier: MIT
 *
 * What a trace is to do: begin a map, complete one, or add to one.
 */
#include "mpi/trace/trace_goal.h"

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/map/map_content.h"
#include "io/map/map_rays.h"
#include "io/write/index_writer.h"
#include "mpi/parallel/progress.h"

static enum rmap_status out_of_memory(struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of rays");
}

static struct rmap_ray_range range_of_portion(const struct rmap_portion_info *portion)
{
    uint64_t room = RMAP_RAY_END - portion->first_ray, n = portion->n_row[RMAP_TABLE_RAY];
    return (struct rmap_ray_range){portion->first_ray, portion->first_ray + (n < room ? n : room)};
}

/* Rays of pieces that are finished; those of an open one its writer may still take back. */
static enum rmap_status find_covered(const struct rmap_map *map, struct rmap_ray_set *covered,
                                     struct rmap_error *err)
{
    size_t n = rmap_map_n_portion(map), kept = 0;
    struct rmap_ray_range *range = rmap_alloc(n ? n : 1, sizeof *range);
    if (!range)
        return out_of_memory(err);
    for (size_t i = 0; i < n; i++) {
        const struct rmap_portion_info *portion = rmap_map_portion(map, i);
        if (!rmap_map_piece(map, (size_t)portion->piece)->is_open)
            range[kept++] = range_of_portion(portion);
    }
    enum rmap_status st = rmap_ray_set_make(range, kept, covered, err);
    rmap_free(range);
    return st;
}

/* The rays of one request that nobody traced, which join those that are done. Requests stay apart:
 * blocks never cross from one to the next, so that whatever a dead writer of the first may still
 * leave is the same block. */
static enum rmap_status add_phase(struct rmap_trace_goal *goal, const struct rmap_run_row *row,
                                  struct rmap_ray_set *done, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_ray_set wanted = {0};
    struct rmap_trace_phase *phase = &goal->phase[goal->n_phase];
    struct rmap_ray_range range = rmap_run_rays(row);
    RMAP_TRY(rmap_ray_set_make(&range, 1, &wanted, err));
    RMAP_TRY(rmap_ray_set_minus(&wanted, done, &phase->rays, err));
    if (phase->rays.n == 0)
        goto out;
    RMAP_TRY(rmap_ray_set_join(done, &phase->rays, err));
    phase->space = row->space;
    goal->n_missing += rmap_ray_set_count(&phase->rays);
    goal->n_phase++;
out:
    rmap_ray_set_fini(&wanted);
    return st;
}

/* Requests of merged maps may overlap: rays that two of them want are the first one's. */
static enum rmap_status add_phases(struct rmap_trace_goal *goal, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_ray_set done = {0};
    size_t n_run = goal->map ? rmap_map_n_run(goal->map) : 0;
    goal->phase = rmap_alloc(n_run + 1, sizeof *goal->phase);
    if (!goal->phase)
        return out_of_memory(err);
    if (goal->map)
        RMAP_TRY(find_covered(goal->map, &done, err));
    goal->n_held = rmap_ray_set_count(&done);
    for (size_t i = 0; i < n_run; i++)
        RMAP_TRY(add_phase(goal, rmap_map_run(goal->map, i), &done, err));
    if (goal->has_row)
        RMAP_TRY(add_phase(goal, &goal->row, &done, err));
out:
    rmap_ray_set_fini(&done);
    return st;
}

static bool is_recounted(const struct rmap_map *map, size_t portion)
{
    const struct rmap_portion_info *info = rmap_map_portion(map, portion);
    return info->is_added && !rmap_map_piece(map, (size_t)info->piece)->is_open;
}

/* Piece by piece, so that few ranks open each. */
static enum rmap_status find_recount(struct rmap_trace_goal *goal, struct rmap_error *err)
{
    const size_t n = rmap_map_n_portion(goal->map), n_piece = rmap_map_n_piece(goal->map);
    size_t *first = rmap_alloc(n_piece + 1, sizeof *first); /* of a piece's in the list */
    goal->recount = rmap_alloc(n ? n : 1, sizeof *goal->recount);
    if (!first || !goal->recount) {
        rmap_free(first);
        return out_of_memory(err);
    }
    for (size_t i = 0; i < n; i++)
        first[rmap_map_portion(goal->map, i)->piece + 1] += is_recounted(goal->map, i);
    for (size_t p = 0; p < n_piece; p++)
        first[p + 1] += first[p];
    goal->n_recount = first[n_piece];
    for (size_t i = 0; i < n; i++)
        if (is_recounted(goal->map, i))
            goal->recount[first[rmap_map_portion(goal->map, i)->piece]++] = i;
    rmap_free(first);
    return RMAP_OK;
}

enum rmap_status rmap_trace_goal_begin(const struct rmap_trace_request *request,
                                       struct rmap_trace_goal *goal, struct rmap_error *err)
{
    *goal = (struct rmap_trace_goal){.has_row = true};
    goal->row = (struct rmap_run_row){
        .first_ray = request->first_ray, .n_ray = request->n_ray, .seed = request->seed};
    return add_phases(goal, err);
}

/* A map's own seed and encoding are taken over unless others were asked for. */
static void adopt(struct rmap_trace_request *request, struct rmap_run *run,
                  const struct rmap_map *map)
{
    struct rmap_map_summary summary;
    rmap_map_summarise(map, &summary);
    if (!request->has_seed)
        request->seed = summary.seed;
    if (!request->has_encoding && rmap_map_n_piece(map) > 0)
        request->encoding = (enum rmap_encoding)rmap_map_piece(map, 0)->encoding;
    run->seed = request->seed;
    run->encoding = request->encoding;
}

/* What the command line says again must be what the map was asked for. */
static enum rmap_status check_resumed(const struct rmap_trace_request *request,
                                      const struct rmap_map *map, struct rmap_error *err)
{
    struct rmap_ray_set wanted = {0};
    size_t n = rmap_map_n_run(map);
    enum rmap_status st = rmap_rays_wanted(map, &wanted, err);
    const uint64_t total = rmap_ray_set_count(&wanted);
    rmap_ray_set_fini(&wanted);
    if (st != RMAP_OK)
        return st;
    bool known = !request->has_n_ray, begins = !request->has_first_ray;
    for (size_t i = 0; i < n; i++) {
        const struct rmap_run_row *row = rmap_map_run(map, i);
        known = known || request->n_ray == row->n_ray;
        begins = begins || request->first_ray == row->first_ray;
    }
    if (!known && request->n_ray != total)
        return rmap_error_set(err, RMAP_USAGE,
                              "%s was asked for %s, and --resume completes those; --append "
                              "-n MORE adds to them",
                              request->map_path, rmap_counted(total, "ray").text);
    if (!begins)
        return rmap_error_set(err, RMAP_USAGE,
                              "%s does not begin with ray %llu; leave out --first-ray",
                              request->map_path, (unsigned long long)request->first_ray);
    return RMAP_OK;
}

/* The first id after all that the map holds or was asked for. */
static uint64_t next_ray(const struct rmap_map *map)
{
    uint64_t next = 0;
    for (size_t i = 0; i < rmap_map_n_run(map); i++) {
        uint64_t end = rmap_run_rays(rmap_map_run(map, i)).end;
        next = end > next ? end : next;
    }
    for (size_t i = 0; i < rmap_map_n_portion(map); i++) {
        uint64_t end = range_of_portion(rmap_map_portion(map, i)).end;
        next = end > next ? end : next;
    }
    return next;
}

/* The row of the rays that are to be added. */
static enum rmap_status make_row(const struct rmap_trace_request *request,
                                 struct rmap_trace_goal *goal, struct rmap_error *err)
{
    const struct rmap_map *map = goal->map;
    uint64_t first = request->has_first_ray ? request->first_ray : next_ray(map);
    const enum rmap_status st = rmap_trace_request_fits(request, first, err);
    if (st != RMAP_OK)
        return st;
    goal->row = (struct rmap_run_row){
        .first_ray = first, .n_ray = request->n_ray, .seed = request->seed, .space = goal->space};
    goal->has_row = true;
    struct rmap_ray_range mine = rmap_run_rays(&goal->row);
    for (size_t i = 0; i < rmap_map_n_run(map); i++) {
        struct rmap_ray_range theirs = rmap_run_rays(rmap_map_run(map, i));
        if (mine.first < theirs.end && theirs.first < mine.end)
            return rmap_error_set(err, RMAP_USAGE,
                                  "%s was asked for rays %llu to %llu already; --append without "
                                  "--first-ray goes on at %llu",
                                  request->map_path, (unsigned long long)theirs.first,
                                  (unsigned long long)(theirs.end - 1),
                                  (unsigned long long)next_ray(map));
    }
    return RMAP_OK;
}

enum rmap_status rmap_trace_goal_admit(struct rmap_trace_request *request, struct rmap_run *run,
                                       struct rmap_trace_goal *goal, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map *map = goal->map;
    adopt(request, run, map);
    RMAP_TRY(rmap_map_admit(map, run, &goal->space, err));
    if (request->mode == RMAP_TRACE_APPEND) {
        RMAP_TRY(make_row(request, goal, err));
    } else {
        RMAP_TRY(check_resumed(request, map, err));
        if ((size_t)goal->space >= rmap_map_n_space(map))
            st = rmap_error_set(err, RMAP_INPUT,
                                "%s has no rays in this colour space (--color, spectrum); "
                                "--append -n MORE adds some",
                                request->map_path);
        RMAP_TRY(st);
    }
out:
    return st;
}

enum rmap_status rmap_trace_goal_plan(struct rmap_trace_goal *goal, struct rmap_error *err)
{
    enum rmap_status st = add_phases(goal, err);
    return st == RMAP_OK ? find_recount(goal, err) : st;
}

void rmap_trace_goal_fini(struct rmap_trace_goal *goal)
{
    for (size_t i = 0; i < goal->n_phase; i++)
        rmap_ray_set_fini(&goal->phase[i].rays);
    rmap_free(goal->phase);
    rmap_free(goal->recount);
    rmap_map_close(goal->map);
    *goal = (struct rmap_trace_goal){0};
}

bool rmap_trace_goal_is_idle(const struct rmap_trace_goal *goal)
{
    struct rmap_map_summary summary = {0};
    if (goal->map)
        rmap_map_summarise(goal->map, &summary);
    return summary.complete && goal->n_missing == 0;
}
