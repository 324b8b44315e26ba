/* SPDX-License-Identifier: MIT
 *
 * Data sheets of luminaires, on a command line and in a document.
 */
#include "mpi/answer/lamp_sheet_out.h"

#include <string.h>

#include "analysis/detector/image_unit.h"
#include "analysis/photometry/ugr_table.h"
#include "base/alloc.h"
#include "io/file/diagnostics.h"
#include "mpi/answer/detector_out.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/balance.h"

enum { LIST_MOST = 721 };

enum rmap_status rmap_lamp_sheet_ask(const struct rmap_arguments *given,
                                     struct rmap_lamp_sheet_ask *ask, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *ask = (struct rmap_lamp_sheet_ask){.n_c = 0};
    RMAP_TRY(rmap_argument_numbers(given, "planes", &ask->c_deg, &ask->n_c, err));
    RMAP_TRY(rmap_argument_numbers(given, "gammas", &ask->gamma_deg, &ask->n_gamma, err));
    for (size_t i = 0; i < ask->n_gamma && st == RMAP_OK; i++)
        if (!(ask->gamma_deg[i] >= 0.0 && ask->gamma_deg[i] <= 180.0))
            st = rmap_error_set(err, RMAP_USAGE, "--gammas: %g is no angle from 0 to 180",
                                ask->gamma_deg[i]);
    if (ask->n_c > LIST_MOST || ask->n_gamma > LIST_MOST)
        st = rmap_error_set(err, RMAP_USAGE, "%d planes or gammas are the most", LIST_MOST);
out:
    return st;
}

void rmap_lamp_sheet_ask_fini(struct rmap_lamp_sheet_ask *ask)
{
    rmap_free(ask->c_deg);
    rmap_free(ask->gamma_deg);
}

enum rmap_status rmap_find_lamp(const struct rmap_scene *scene, const char *path, const char *name,
                                const struct rmap_source **source_ret, struct rmap_error *err)
{
    const struct rmap_source *named = NULL;
    size_t n = 0;
    const char **known = rmap_alloc(scene->n_source + 1, sizeof *known);
    if (!known)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the lamps' names");
    for (size_t s = 0; s < scene->n_source; s++) {
        if (strcmp(scene->source[s].name, name) == 0)
            named = &scene->source[s];
        if (scene->source[s].lamp)
            known[n++] = scene->source[s].name;
    }
    const char *nearest = rmap_nearest_word(name, known, n);
    char remedy[160];
    if (n > 0)
        (void)snprintf(remedy, sizeof remedy, "did you mean '%.60s'?",
                       nearest ? nearest : known[0]);
    else
        (void)snprintf(remedy, sizeof remedy,
                       "no source of this scene is; say {type: lamp, file: X.ies}, or .ldt");
    rmap_free(known);
    *source_ret = named;
    if (named && named->lamp)
        return RMAP_OK;
    if (named)
        return rmap_error_set(err, RMAP_INPUT,
                              "%s:%d:%d: source '%.60s' is not by a lamp maker's file (%s)", path,
                              named->line, named->column, name, remedy);
    return rmap_error_set(err, RMAP_INPUT, "%s: no lamp named '%.60s' by its maker's file (%s)",
                          path, name, remedy);
}

void rmap_lamp_sheet_of(const struct rmap_scene *scene, const struct rmap_source *source,
                        const struct rmap_lamp_sheet_ask *ask, struct rmap_lamp_sheet *sheet)
{
    *sheet = (struct rmap_lamp_sheet){
        .lamp = source->lamp,
        .flux = source->flux,
        .flux_unit = rmap_flux_unit_name(scene),
        .unit = rmap_image_unit_usual(RMAP_PER_SOLID_ANGLE, scene->flux_unit)->name};
    if (!ask)
        return;
    sheet->c_deg = ask->c_deg;
    sheet->n_c = ask->n_c;
    sheet->gamma_deg = ask->gamma_deg;
    sheet->n_gamma = ask->n_gamma;
}

/* Whether it has one. */
static bool find_table(const struct rmap_scene *scene, const struct rmap_source *source,
                       struct rmap_ugr_table *table)
{
    return scene->flux_unit == RMAP_FLUX_LM && source->type == RMAP_SOURCE_LAMP &&
           source->shape == RMAP_EMITTER_BODY &&
           rmap_ugr_table_find(source->lamp, source->flux, scene->unit_m, table);
}

enum rmap_status rmap_lamp_out_print(const struct rmap_scene *scene,
                                     const struct rmap_source *source,
                                     const struct rmap_lamp_sheet_ask *ask, FILE *out,
                                     struct rmap_error *err)
{
    struct rmap_lamp_sheet sheet;
    struct rmap_ugr_table table;
    rmap_lamp_sheet_of(scene, source, ask, &sheet);
    fprintf(out, "\n%s: %.6g %s\n", source->name, sheet.flux, sheet.flux_unit);
    const enum rmap_status st = rmap_lamp_sheet_print(&sheet, out, err);
    if (st != RMAP_OK)
        return st;
    fputc('\n', out);
    if (find_table(scene, source, &table))
        rmap_ugr_table_print(&table, out);
    else
        fprintf(out, "UGR: none, as the lamp has no luminous opening, or its flux is in W\n");
    return RMAP_OK;
}

json_t *rmap_lamp_out_json(const struct rmap_scene *scene, const struct rmap_source *source,
                           const struct rmap_lamp_sheet_ask *ask)
{
    struct rmap_lamp_sheet sheet;
    struct rmap_ugr_table table;
    rmap_lamp_sheet_of(scene, source, ask, &sheet);
    json_t *document = rmap_lamp_sheet_json(&sheet, true);
    if (document)
        (void)json_object_set_new(document, "source", json_string(source->name));
    if (document && find_table(scene, source, &table))
        (void)json_object_set_new(document, "ugr", rmap_ugr_table_json(&table));
    return document;
}

enum rmap_status rmap_photometry_out(const struct rmap_detector_image *image,
                                     const struct rmap_lamp_sheet_ask *ask, json_t *document,
                                     struct rmap_error *err)
{
    struct rmap_lamp_file file = {.n_around = 0};
    struct rmap_lamp lamp = {.n_around = 0};
    enum rmap_status st = rmap_detector_far_field(image, &file, err);
    RMAP_TRY(st);
    RMAP_TRY(rmap_lamp_init(file.around_deg, file.n_around, file.polar_deg, file.n_polar,
                            file.candela, &lamp, err));
    lamp.axis[0] = rmap_vec3(1, 0, 0);
    lamp.axis[1] = rmap_vec3(0, -1, 0);
    lamp.axis[2] = rmap_vec3(0, 0, 1);
    const struct rmap_lamp_sheet sheet = {.lamp = &lamp,
                                          .flux = lamp.flux,
                                          .flux_unit = image->flux_unit,
                                          .unit = image->unit,
                                          .c_deg = ask->c_deg,
                                          .gamma_deg = ask->gamma_deg,
                                          .n_c = ask->n_c,
                                          .n_gamma = ask->n_gamma};
    if (document) {
        (void)json_object_set_new(document, "photometry", rmap_lamp_sheet_json(&sheet, true));
    } else {
        putchar('\n');
        st = rmap_lamp_sheet_print(&sheet, stdout, err);
    }
out:
    rmap_lamp_fini(&lamp);
    rmap_lamp_file_fini(&file);
    return st;
}
