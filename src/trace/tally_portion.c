/* SPDX-License-Identifier: MIT */
#include "portion/event.h"
#include "trace/tally.h"

/* A ray's rows in the other tables. */
struct ray_rows {
    size_t row, first_segment, n_segment, first_registration, n_registration;
};

static enum rmap_status complain(struct rmap_error *err, const struct rmap_portion *portion,
                                 size_t row, const char *what)
{
    return rmap_error_set(err, RMAP_FORMAT, "ray %llu: %s",
                          (unsigned long long)portion->ray.id[row], what);
}

static bool below(int64_t index, size_t n)
{
    return index >= 0 && (uint64_t)index < n;
}

static enum rmap_status check_registrations(const struct rmap_scene *scene,
                                            const struct rmap_portion *portion,
                                            const struct ray_rows *rows, struct rmap_error *err)
{
    const struct rmap_registration_columns *columns = &portion->registration;
    for (size_t i = 0; i < rows->n_registration; i++) {
        size_t at = rows->first_registration + i;
        if (!below(columns->detector[at], scene->n_detector))
            return complain(err, portion, rows->row, "a detector that the scene has not");
        const uint32_t *cells = scene->detector[columns->detector[at]].cells;
        if (columns->registered[at] &&
            (columns->cell[2 * at] >= cells[0] || columns->cell[2 * at + 1] >= cells[1]))
            return complain(err, portion, rows->row, "a cell that the detector has not");
    }
    return RMAP_OK;
}

static enum rmap_status check_ray(const struct rmap_scene *scene,
                                  const struct rmap_portion *portion, const struct ray_rows *rows,
                                  struct rmap_error *err)
{
    if (!below(portion->ray.source[rows->row], scene->n_source))
        return complain(err, portion, rows->row, "a source that the scene has not");
    if (portion->ray.stop[rows->row] >= RMAP_STOP_COUNT)
        return complain(err, portion, rows->row, "ended in a way that there is not");
    if (rows->n_segment > 0) {
        size_t last = rows->first_segment + rows->n_segment - 1;
        int32_t object = portion->segment.object[last];
        if (object != -1 && !below(object, scene->n_object))
            return complain(err, portion, rows->row, "an object that the scene has not");
        if (!below(portion->segment.medium[last], scene->n_medium))
            return complain(err, portion, rows->row, "a medium that the scene has not");
    }
    return check_registrations(scene, portion, rows, err);
}

static void add_registrations(struct rmap_tally *tally, const struct rmap_portion *portion,
                              const struct ray_rows *rows)
{
    const struct rmap_registration_columns *columns = &portion->registration;
    size_t source = (size_t)portion->ray.source[rows->row];
    for (size_t i = 0; i < rows->n_registration; i++) {
        size_t at = rows->first_registration + i;
        if (!columns->registered[at])
            continue;
        size_t detector = (size_t)columns->detector[at];
        rmap_tally_add_hit(tally, detector, source, columns->cell[2 * at],
                           columns->cell[2 * at + 1]);
    }
}

static void add_ray(struct rmap_tally *tally, const struct rmap_portion *portion,
                    const struct ray_rows *rows)
{
    int32_t source = portion->ray.source[rows->row];
    struct rmap_tally_ending ending = {.ray = portion->ray.id[rows->row],
                                       .source = source,
                                       .object = -1,
                                       .medium = tally->scene->source[source].medium,
                                       .stop = (enum rmap_stop)portion->ray.stop[rows->row],
                                       .weight = portion->ray.weight[rows->row]};
    if (rows->n_segment > 0) {
        size_t last = rows->first_segment + rows->n_segment - 1;
        ending.object = portion->segment.object[last];
        ending.medium = portion->segment.medium[last];
    }
    tally->emitted[source] += 1.0;
    tally->segments[0] += (double)rows->n_segment;
    add_registrations(tally, portion, rows);
    rmap_tally_add_ending(tally, &ending);
}

/* The next ray's rows; false when there are not that many. */
static bool advance(const struct rmap_portion *portion, struct ray_rows *rows, size_t row)
{
    rows->row = row;
    rows->first_segment += rows->n_segment;
    rows->first_registration += rows->n_registration;
    rows->n_segment = portion->ray.segment_count[row];
    rows->n_registration = portion->ray.registration_count[row];
    return rows->n_segment <= portion->n_row[RMAP_TABLE_SEGMENT] - rows->first_segment &&
           rows->n_registration <=
               portion->n_row[RMAP_TABLE_REGISTRATION] - rows->first_registration;
}

enum rmap_status rmap_tally_add_portion(struct rmap_tally *tally,
                                        const struct rmap_portion *portion, struct rmap_error *err)
{
    const size_t n = portion->n_row[RMAP_TABLE_RAY];
    struct ray_rows rows = {0};
    for (size_t i = 0; i < n; i++) {
        if (!advance(portion, &rows, i))
            return complain(err, portion, i, "counts more legs or registrations than there are");
        enum rmap_status st = check_ray(tally->scene, portion, &rows, err);
        if (st != RMAP_OK)
            return st;
    }
    if (rows.first_segment + rows.n_segment != portion->n_row[RMAP_TABLE_SEGMENT] ||
        rows.first_registration + rows.n_registration != portion->n_row[RMAP_TABLE_REGISTRATION])
        return rmap_error_set(err, RMAP_FORMAT, "legs or registrations that belong to no ray");
    rows = (struct ray_rows){0};
    for (size_t i = 0; i < n && advance(portion, &rows, i); i++)
        add_ray(tally, portion, &rows);
    return RMAP_OK;
}
