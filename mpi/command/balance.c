/* SPDX-License-Identifier: MIT
 *
 * Where the light of each source went: emitted = absorbed by objects and in media + left + limits
 * + errors, exact in rays.
 */
#include "mpi/command/balance.h"

#include <math.h>
#include <stdlib.h>

#include "analysis/table/flux_error.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/export/json_number.h"
#include "mpi/parallel/progress.h"
#include "portion/weight.h"

enum { SHOWN_MAX = 10 };

static double sum(const double *value, size_t n)
{
    double total = 0.0;
    for (size_t i = 0; i < n; i++)
        total += value[i];
    return total;
}

static double ended_of(const struct rmap_tally *tally, size_t s)
{
    const struct rmap_scene *scene = tally->scene;
    return sum(tally->absorbed_object + s * scene->n_object, scene->n_object) +
           sum(tally->absorbed_medium + s * scene->n_medium, scene->n_medium) + tally->left[s] +
           tally->limit[s] + tally->error[s];
}

enum rmap_status rmap_balance_check(const struct rmap_tally *tally, struct rmap_error *err)
{
    const struct rmap_scene *scene = tally->scene;
    for (size_t s = 0; s < scene->n_source && !rmap_scene_changes_weights(scene); s++) {
        double ended = ended_of(tally, s);
        if (!(ended >= tally->emitted[s] && ended <= tally->emitted[s])) /* NaN, too */
            return rmap_error_set(err, RMAP_INTERNAL,
                                  "energy balance of source '%s' is broken: %.17g rays emitted, "
                                  "%.17g accounted for; please report this",
                                  scene->source[s].name, tally->emitted[s], ended);
    }
    return RMAP_OK;
}

/* What became of energy where light was given back at other wavelengths: heat, or less than none.
 */
static double converted(const struct rmap_tally *tally, size_t s)
{
    return tally->emitted[s] - ended_of(tally, s);
}

static void print_share(FILE *out, const char *what, const char *name, double n, double emitted)
{
    char count[RMAP_GROUPED_LEN];
    fprintf(out, "    %-12s %-24s %15s  %7.3f %%\n", what, name,
            rmap_grouped(rmap_weight_whole(n), count), 100.0 * n / emitted);
}

struct entry {
    double n;
    size_t index;
};

static int by_count(const void *a, const void *b)
{
    const struct entry *left = a, *right = b;
    if (left->n > right->n || left->n < right->n)
        return left->n > right->n ? -1 : 1;
    return left->index < right->index ? -1 : 1;
}

static void print_objects(const struct rmap_tally *tally, size_t source, FILE *out)
{
    const struct rmap_scene *scene = tally->scene;
    const double *absorbed = tally->absorbed_object + source * scene->n_object;
    struct entry *entry = rmap_alloc(scene->n_object, sizeof *entry);
    size_t n = 0;
    for (size_t o = 0; entry && o < scene->n_object; o++)
        if (absorbed[o] > 0)
            entry[n++] = (struct entry){absorbed[o], o};
    if (n > 0)
        qsort(entry, n, sizeof *entry, by_count);
    double rest = 0.0;
    for (size_t i = 0; i < n; i++) {
        if (i < SHOWN_MAX)
            print_share(out, "absorbed by", scene->object[entry[i].index].name, entry[i].n,
                        tally->emitted[source]);
        else
            rest += entry[i].n;
    }
    char others[48];
    (void)snprintf(others, sizeof others, "%zu other objects", n > SHOWN_MAX ? n - SHOWN_MAX : 0);
    if (n > SHOWN_MAX)
        print_share(out, "absorbed by", others, rest, tally->emitted[source]);
    rmap_free(entry);
}

/* Flux of a source's rays. */
static double flux_of(const struct rmap_tally *tally, const double *flux, size_t source)
{
    return flux ? flux[source] : tally->scene->source[source].flux;
}

void rmap_balance_print(const struct rmap_tally *tally, const double *flux, FILE *out)
{
    const struct rmap_scene *scene = tally->scene;
    for (size_t s = 0; s < scene->n_source; s++) {
        double emitted = tally->emitted[s];
        fprintf(out, "  source %s: %s for %.6g %s\n", scene->source[s].name,
                rmap_counted((uint64_t)emitted, "ray").text, flux_of(tally, flux, s),
                rmap_flux_unit_name(scene));
        if (emitted <= 0.0)
            continue;
        print_objects(tally, s, out);
        for (size_t m = 0; m < scene->n_medium; m++)
            if (tally->absorbed_medium[s * scene->n_medium + m] > 0)
                print_share(out, "absorbed in", scene->medium[m].name,
                            tally->absorbed_medium[s * scene->n_medium + m], emitted);
        print_share(out, "left", "the scene", tally->left[s], emitted);
        if (rmap_scene_changes_weights(scene))
            fprintf(out, "    %-37s %15s  %7.3f %%\n", "turned to heat by re-emission", "",
                    100.0 * converted(tally, s) / emitted);
        if (tally->limit[s] > 0)
            print_share(out, "stopped", "by a limit", tally->limit[s], emitted);
        if (tally->error[s] > 0)
            print_share(out, "stopped", "by an error", tally->error[s], emitted);
    }
}

/* {"name": rays}, those above 0. */
static json_t *named_counts(const double *value, size_t n, const struct rmap_scene *scene,
                            const char *(*name)(const struct rmap_scene *, size_t))
{
    json_t *counts = json_object();
    for (size_t i = 0; i < n; i++)
        if (value[i] > 0)
            (void)json_object_set_new(counts, name(scene, i),
                                      json_integer((json_int_t)rmap_weight_whole(value[i])));
    return counts;
}

static const char *object_name(const struct rmap_scene *scene, size_t i)
{
    return scene->object[i].name;
}

static const char *medium_name(const struct rmap_scene *scene, size_t i)
{
    return scene->medium[i].name;
}

json_t *rmap_balance_json(const struct rmap_tally *tally, const double *flux)
{
    const struct rmap_scene *scene = tally->scene;
    json_t *list = json_array();
    for (size_t s = 0; s < scene->n_source; s++) {
        json_t *objects = named_counts(tally->absorbed_object + s * scene->n_object,
                                       scene->n_object, scene, object_name);
        json_t *media = named_counts(tally->absorbed_medium + s * scene->n_medium, scene->n_medium,
                                     scene, medium_name);
        json_t *one = json_pack("{s:s, s:I, s:f, s:s, s:{s:o, s:o}, s:I, s:I, s:I}", "name",
                                scene->source[s].name, "emitted", (json_int_t)tally->emitted[s],
                                "flux", flux_of(tally, flux, s), "unit", rmap_flux_unit_name(scene),
                                "absorbed", "objects", objects, "media", media, "left",
                                (json_int_t)rmap_weight_whole(tally->left[s]), "limit",
                                (json_int_t)rmap_weight_whole(tally->limit[s]), "error",
                                (json_int_t)rmap_weight_whole(tally->error[s]));
        if (rmap_scene_changes_weights(scene))
            (void)json_object_set_new(one, "heat", rmap_json_number(converted(tally, s)));
        (void)json_array_append_new(list, one);
    }
    return list;
}

struct caught {
    double registrations, flux, error;
};

static struct caught caught_by(const struct rmap_tally *tally, size_t detector)
{
    const struct rmap_scene *scene = tally->scene;
    const uint32_t *cells = scene->detector[detector].cells;
    const size_t n_cell = (size_t)cells[0] * cells[1];
    struct caught all = {0.0, 0.0, 0.0};
    double variance = 0.0;
    for (size_t s = 0; s < scene->n_source; s++) {
        const double *image = rmap_tally_image(tally, detector, s);
        const double n = tally->emitted[s], unit = n > 0.0 ? scene->source[s].flux / n : 0.0;
        const size_t first = (size_t)(image - tally->image);
        const double w = sum(image, n_cell),
                     w2 =
                         sum(tally->image_squared + first, n_cell) +
                         (tally->image_squared_rest ? sum(tally->image_squared_rest + first, n_cell)
                                                    : 0.0);
        all.registrations += w;
        all.flux += unit * w;
        variance += rmap_flux_variance_if_rays(unit, n, w, w2);
    }
    all.error = rmap_flux_error(variance);
    return all;
}

void rmap_balance_print_detectors(const struct rmap_tally *tally, FILE *out)
{
    const struct rmap_scene *scene = tally->scene;
    char count[RMAP_GROUPED_LEN];
    if (scene->n_detector > 0)
        fputs("detectors\n", out);
    for (size_t d = 0; d < scene->n_detector; d++) {
        const struct caught caught = caught_by(tally, d);
        fprintf(out, "  %-24s %15s registrations  %.6g", scene->detector[d].name,
                rmap_grouped(rmap_weight_whole(caught.registrations), count), caught.flux);
        if (isfinite(caught.error))
            fprintf(out, " +- %.2g", caught.error);
        fprintf(out, " %s\n", rmap_flux_unit_name(scene));
    }
}

json_t *rmap_balance_detectors_json(const struct rmap_tally *tally)
{
    const struct rmap_scene *scene = tally->scene;
    json_t *list = json_array();
    for (size_t d = 0; d < scene->n_detector; d++) {
        const struct caught caught = caught_by(tally, d);
        (void)json_array_append_new(
            list, json_pack("{s:s, s:I, s:{s:o, s:o, s:s}}", "name", scene->detector[d].name,
                            "registrations", (json_int_t)rmap_weight_whole(caught.registrations),
                            "flux", "total", rmap_json_number(caught.flux), "standard_error",
                            rmap_json_number(caught.error), "unit", rmap_flux_unit_name(scene)));
    }
    return list;
}
