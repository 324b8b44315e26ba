/* SPDX-License-Identifier: MIT
 *
 * --until: answers from the first rays of a map.
 */
#include "mpi/command/until.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST_PORTIONS = 16 };

enum rmap_status rmap_until_read(const struct rmap_arguments *given, struct rmap_until *until,
                                 struct rmap_error *err)
{
    const char *text = rmap_argument(given, "until");
    char *end = NULL;
    *until = (struct rmap_until){.part = {.relative = 0.0}};
    if (!text)
        return RMAP_OK;
    double value = strtod(text, &end);
    const bool is_number = end != text;
    end += strspn(end, " ");
    if (*end == '%') {
        value /= 100.0;
        end++;
    }
    if (!is_number || *end != 0 || !(value > 0.0 && value < 1.0))
        return rmap_error_set(err, RMAP_USAGE,
                              "--until '%.40s': a part of the answer, such as 1%% or 0.01", text);
    until->part.relative = value;
    return RMAP_OK;
}

static void take_portions(struct rmap_until *until, size_t n)
{
    const bool all = until->cut.is_in_order || n > until->cut.n_portion;
    until->n_portion = all ? until->cut.n_portion : n;
    rmap_map_cut_to(&until->cut, until->n_portion);
}

enum rmap_status rmap_until_begin(struct rmap_until *until, struct rmap_map *map, bool of_ids,
                                  struct rmap_error *err)
{
    if (!(until->part.relative > 0.0))
        return RMAP_OK;
    enum rmap_status st = rmap_map_cut_init(&until->cut, map, err);
    until->cut.is_in_order |= of_ids;
    if (st == RMAP_OK)
        take_portions(until, FIRST_PORTIONS);
    else
        rmap_error_context(err, "--until");
    return st;
}

void rmap_until_fini(struct rmap_until *until)
{
    if (until->cut.map)
        rmap_map_cut_fini(&until->cut);
}

bool rmap_until_goes_on(struct rmap_until *until, bool is_exact)
{
    if (!(until->part.relative > 0.0))
        return false;
    until->part.is_reached = is_exact;
    until->part.all_rays = until->cut.n_row[RMAP_TABLE_RAY];
    until->part.n_ray = 0;
    for (size_t i = 0; i < until->n_portion; i++)
        until->part.n_ray += rmap_map_portion(until->cut.map, i)->n_row[RMAP_TABLE_RAY];
    if (is_exact || until->n_portion == until->cut.n_portion)
        return false;
    take_portions(until, 2 * until->n_portion);
    return true;
}

bool rmap_until_suffices(const struct rmap_until *until, double value, double standard_error)
{
    return fabs(value) > 0.0 && standard_error <= until->part.relative * fabs(value);
}
