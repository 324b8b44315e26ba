/* SPDX-License-Identifier: MIT
 *
 * What light the steps of particles make.
 */
#include "mpi/answer/steps_out.h"

#include "base/grouped.h"

/* Steps are in the order of their events. */
static size_t count_events(const struct rmap_steps *steps)
{
    size_t n = steps->n > 0;
    for (size_t i = 1; i < steps->n; i++)
        n += steps->step[i].event != steps->step[i - 1].event;
    return n;
}

static void sum_photons(const struct rmap_steps *steps, double sum[RMAP_PHOTON_KINDS])
{
    double before = 0.0;
    for (int k = 0; k < RMAP_PHOTON_KINDS; k++)
        sum[k] = 0.0;
    for (size_t i = 0; i < steps->n * RMAP_PHOTON_KINDS; i++) {
        sum[i % RMAP_PHOTON_KINDS] += steps->photons[i] - before;
        before = steps->photons[i];
    }
}

void rmap_steps_print(const struct rmap_steps *steps, FILE *out)
{
    double sum[RMAP_PHOTON_KINDS];
    sum_photons(steps, sum);
    fprintf(out, "; photons %s: %.6g by scintillation, %.6g Cherenkov, of ",
            steps->counted ? "counted" : "expected", sum[RMAP_PHOTON_SCINTILLATION],
            sum[RMAP_PHOTON_CHERENKOV]);
    fprintf(out, "%s in ", rmap_counted(steps->n, "step").text);
    fprintf(out, "%s", rmap_counted(count_events(steps), "event").text);
}

json_t *rmap_steps_json(const struct rmap_scene *scene)
{
    json_t *list = json_array();
    for (size_t s = 0; s < scene->n_source; s++) {
        const struct rmap_steps *steps = scene->source[s].steps;
        double sum[RMAP_PHOTON_KINDS];
        if (!steps)
            continue;
        sum_photons(steps, sum);
        (void)json_array_append_new(
            list,
            json_pack("{s:s, s:I, s:I, s:b, s:f, s:f}", "source", scene->source[s].name, "steps",
                      (json_int_t)steps->n, "events", (json_int_t)count_events(steps), "counted",
                      steps->counted, "scintillation", sum[RMAP_PHOTON_SCINTILLATION], "cherenkov",
                      sum[RMAP_PHOTON_CHERENKOV]));
    }
    if (json_array_size(list) == 0) {
        json_decref(list);
        return NULL;
    }
    return list;
}
