/* SPDX-License-Identifier: MIT
 *
 * The rays with the greatest values of a quantity, as a list of both.
 */
#include "mpi/answer/query_top_out.h"

#include <inttypes.h>
#include <stdio.h>

#include "io/export/json_number.h"
#include "io/map/map_json.h"
#include "mpi/command/json_out.h"

enum { DIGITS = 9 }; /* that maps have of places */

static json_t *list(const struct rmap_sample_ray *ray, size_t n)
{
    json_t *rays = json_array();
    for (size_t i = 0; i < n; i++)
        json_array_append_new(rays,
                              json_pack("{s:I, s:o}", "ray", (json_int_t)ray[i].id, "value",
                                        rmap_json_number(rmap_sample_value_of_key(ray[i].key))));
    return rays;
}

enum rmap_status rmap_query_top_print(const struct rmap_context *context,
                                      const struct rmap_top_question *question,
                                      const struct rmap_sample_ray *ray, size_t n,
                                      struct rmap_error *err)
{
    const struct rmap_quantity *of = &question->of->of[0];
    if (context->json)
        return rmap_json_print(
            rmap_json_of_map(
                json_pack("{s:s, s:s, s:s, s:o}", "criterion",
                          question->criterion ? rmap_criterion_text(question->criterion) : "all",
                          "of", of->name, "unit", of->unit, "top", list(ray, n)),
                question->map),
            stdout, err);
    printf("%20s  %s%s%s\n", "ray", of->name, *of->unit ? " / " : "", of->unit);
    for (size_t i = 0; i < n; i++)
        printf("%20" PRIu64 "  %.*g\n", ray[i].id, DIGITS, rmap_sample_value_of_key(ray[i].key));
    return RMAP_OK;
}
