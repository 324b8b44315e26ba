/* SPDX-License-Identifier: MIT
 *
 * What an import found: for people, and as JSON.
 */
#include "mpi/answer/lens_out.h"

#include <math.h>

#include "io/export/json_number.h"
#include "io/file/shell_word.h"
#include "mpi/command/json_out.h"

static size_t count(const struct rmap_lens_plan *plan, bool mirrors)
{
    size_t n = 0;
    for (size_t e = 0; e < plan->n_element; e++)
        n += mirrors ? plan->lens->surface[plan->row[plan->element[e].first].surface].is_mirror &&
                           plan->element[e].kind == RMAP_ELEMENT_SURFACE
                     : plan->element[e].kind == RMAP_ELEMENT_LENS;
    return n;
}

static const char *plural(size_t n)
{
    return n == 1 ? "" : "s";
}

void rmap_lens_print(const struct rmap_lens_plan *plan, const char *scene, FILE *out)
{
    const struct rmap_prescription *lens = plan->lens;
    const struct rmap_first_order *o = &plan->order;
    const size_t n_lens = count(plan, false), n_mirror = count(plan, true);
    (void)fprintf(out, "%s\n  %s: %zu surfaces, %zu field%s, %zu wavelength%s\n", scene,
                  lens->format, lens->n_surface - 2, lens->n_field, plural(lens->n_field),
                  lens->n_wavelength, plural(lens->n_wavelength));
    (void)fprintf(out, "  %zu group%s of lenses, %zu mirror%s\n", n_lens, plural(n_lens), n_mirror,
                  plural(n_mirror));
    if (lens->n_configuration > 1)
        (void)fprintf(out, "  %d configurations, each a simulation of the scene\n",
                      lens->n_configuration);
    if (isfinite(o->focal_length))
        (void)fprintf(out, "  focal length %.7g %s, back focus %.7g %s, f/%.4g\n", o->focal_length,
                      lens->unit, o->back_focus, lens->unit, o->f_number);
    if (isfinite(o->across[0]))
        (void)fprintf(out, "  in x: focal length %.7g %s, back focus %.7g %s\n", o->across[0],
                      lens->unit, o->across[1], lens->unit);
    if (isfinite(o->object))
        (void)fprintf(out, "  object %.7g %s before surface 1, magnification %.5g\n", o->object,
                      lens->unit, o->magnification);
    static const char *const next[][2] = {
        {"draw", " -o lens.svg"}, {"ghosts", " sensor"}, {"trace", " -n 1M -o lens.raymap"}};
    (void)fputs("next:\n", out);
    for (size_t i = 0; i < sizeof next / sizeof *next; i++) {
        (void)fprintf(out, "  raymap %s", next[i][0]);
        rmap_shell_word_put(out, scene);
        (void)fprintf(out, "%s\n", next[i][1]);
    }
}

static json_t *elements(const struct rmap_lens_plan *plan)
{
    static const char *const kind[] = {
        [RMAP_ELEMENT_LENS] = "lens",     [RMAP_ELEMENT_SURFACE] = "surface",
        [RMAP_ELEMENT_PLATE] = "plate",   [RMAP_ELEMENT_OBSCURATION] = "obscuration",
        [RMAP_ELEMENT_SPIDER] = "spider", [RMAP_ELEMENT_EDGE] = "edge",
        [RMAP_ELEMENT_BORE] = "edge"};
    json_t *list = json_array();
    for (size_t e = 0; e < plan->n_element; e++) {
        const struct rmap_lens_element *element = &plan->element[e];
        json_t *rows = json_array();
        for (size_t k = 0; k < element->n; k++) {
            const size_t i = plan->row[element->first + k].surface;
            (void)json_array_append_new(rows, json_integer(plan->lens->surface[i].number));
        }
        const size_t first = plan->row[element->first].surface;
        const bool mirror =
            element->kind == RMAP_ELEMENT_SURFACE && plan->lens->surface[first].is_mirror;
        (void)json_array_append_new(list, json_pack("{s:s, s:s, s:o}", "name", element->name,
                                                    "kind", mirror ? "mirror" : kind[element->kind],
                                                    "surfaces", rows));
    }
    return list;
}

static json_t *media(const struct rmap_lens_plan *plan)
{
    static const char *const kind[] = {[RMAP_LENS_AIR] = "air",
                                       [RMAP_LENS_CATALOGUE] = "catalogue",
                                       [RMAP_LENS_AGF] = "file",
                                       [RMAP_LENS_MODEL] = "model",
                                       [RMAP_LENS_GRADIENT] = "gradient"};
    json_t *list = json_array();
    for (size_t i = 0; i < plan->media.n; i++) {
        const struct rmap_lens_medium *medium = &plan->media.medium[i];
        (void)json_array_append_new(
            list, json_pack("{s:s, s:s, s:s, s:o}", "name", medium->name, "word", medium->word,
                            "kind", kind[medium->kind], "index", rmap_json_number(medium->index)));
    }
    return list;
}

json_t *rmap_lens_json(const struct rmap_lens_plan *plan, const char *path, const char *scene)
{
    const struct rmap_prescription *lens = plan->lens;
    const struct rmap_first_order *o = &plan->order;
    json_t *document = json_pack(
        "{s:s, s:s, s:s, s:s, s:s, s:I, s:I, s:i, s:o}", "path", path, "scene", scene, "format",
        lens->format, "title", lens->title, "units", lens->unit, "surfaces",
        (json_int_t)lens->n_surface - 2, "fields", (json_int_t)lens->n_field, "configurations",
        lens->n_configuration, "wavelength", rmap_json_number(lens->wavelength_nm[lens->primary]));
    const struct {
        const char *key;
        double value;
    } numbers[] = {{"focal_length", o->focal_length},
                   {"back_focus", o->back_focus},
                   {"focal_length_x", o->across[0]},
                   {"back_focus_x", o->across[1]},
                   {"f_number", o->f_number},
                   {"entrance_pupil", o->entrance},
                   {"entrance_pupil_diameter", o->entrance_diameter},
                   {"object_distance", o->object},
                   {"magnification", isfinite(o->object) ? o->magnification : (double)NAN}};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        (void)json_object_set_new(document, numbers[i].key, rmap_json_number(numbers[i].value));
    (void)json_object_set_new(document, "elements", elements(plan));
    (void)json_object_set_new(document, "media", media(plan));
    (void)json_object_set_new(document, "understood", json_boolean(lens->findings->n == 0));
    (void)json_object_set_new(document, "findings", rmap_json_findings(lens->findings));
    return document;
}
