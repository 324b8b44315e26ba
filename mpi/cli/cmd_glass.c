/* SPDX-License-Identifier: MIT
 *
 * raymap glass: the catalogue of materials.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "analysis/figure/figure_detector.h"
#include "analysis/figure/figure_glass.h"
#include "base/alloc.h"
#include "io/export/raster.h"
#include "mpi/answer/glass_list.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/command.h"
#include "mpi/command/json_out.h"
#include "mpi/command/output.h"
#include "mpi/parallel/agree.h"

enum { OPERANDS_MAX = 1000, TOP_DEFAULT = 10 };

static const struct rmap_option options[] = {
    {"at", 0, "NM,NM", "indices at these wavelengths, such as 486.1,587.6,656.3"},
    {"near", 0, "ND,VD", "the nearest to this index and Abbe number first, such as 1.5168,64.2"},
    {"top", 0, "N", "so many of these (default 10)"},
    {"output", 'o', "OUT", "OUT.svg or OUT.png: index and transmittance over wavelength"},
    {"force", 'f', NULL, "replace OUT"},
    {NULL}};

static const char *const suffixes[] = {".svg", ".png", NULL};

/* Numbers of an option, so many at most. */
static enum rmap_status read_numbers(const struct rmap_arguments *given, const char *option,
                                     size_t most, double *value, size_t *n_ret,
                                     struct rmap_error *err)
{
    char **list = NULL;
    size_t n = 0;
    enum rmap_status st = rmap_argument_list(given, option, &list, &n, err);
    if (st == RMAP_OK && n > most)
        st = rmap_error_set(err, RMAP_USAGE, "--%s takes %zu numbers at most, not %zu", option,
                            most, n);
    for (size_t i = 0; i < n; i++) {
        char *end = NULL;
        double number = strtod(list[i], &end);
        if (st == RMAP_OK && (end == list[i] || *end || !(number > 0.0) || !isfinite(number)))
            st = rmap_error_set(err, RMAP_USAGE, "--%s: '%s' is no positive number", option,
                                list[i]);
        if (st == RMAP_OK)
            value[i] = number;
        rmap_free(list[i]);
    }
    rmap_free(list);
    *n_ret = n;
    return st;
}

static enum rmap_status read_request(const struct rmap_arguments *given,
                                     struct rmap_glass_request *request, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *path = rmap_argument(given, "output");
    double near[2] = {0.0, 0.0};
    size_t n_near = 0;
    uint64_t most = TOP_DEFAULT;
    *request = (struct rmap_glass_request){.pattern = given->operand,
                                           .n_pattern = (size_t)given->n_operand};
    RMAP_TRY(read_numbers(given, "at", RMAP_GLASS_AT_MAX, request->at_nm, &request->n_at, err));
    RMAP_TRY(read_numbers(given, "near", 2, near, &n_near, err));
    RMAP_TRY(rmap_argument_count(given, "top", &most, err));
    request->is_near = n_near > 0;
    request->near_nd = near[0];
    request->near_vd = near[1];
    request->most = (size_t)most;
    if (n_near == 1)
        return rmap_error_set(err, RMAP_USAGE, "--near takes nd and vd, such as 1.5168,64.2");
    if (rmap_argument(given, "top") && (!request->is_near || most == 0))
        return rmap_error_set(err, RMAP_USAGE, "--top says how many of --near ND,VD: 1 or more");
    if (path)
        st = rmap_output_check(path, suffixes, rmap_argument(given, "force") != NULL, err);
out:
    return st;
}

static enum rmap_status draw(const struct rmap_glass_list *list, const char *path,
                             struct rmap_error *err)
{
    struct rmap_svg *svg = NULL;
    if (list->n == 0 || list->n > RMAP_FIGURE_GLASSES_MAX)
        return rmap_error_set(err, RMAP_INPUT,
                              "a picture is of 1 to %d materials, and these are %zu",
                              RMAP_FIGURE_GLASSES_MAX, list->n);
    struct rmap_glass *glass = rmap_alloc(list->n, sizeof *glass);
    if (!glass)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    for (size_t i = 0; i < list->n; i++)
        rmap_catalogue_read(&list->place[i], &glass[i]);
    enum rmap_status st = rmap_figure_glass(glass, list->n, &svg, err);
    if (st == RMAP_OK)
        st = rmap_picture_write(svg, path, RMAP_FIGURE_SCALE, err);
    rmap_svg_destroy(svg);
    rmap_free(glass);
    return st;
}

/* On rank 0. */
static enum rmap_status answer(const struct rmap_context *context,
                               const struct rmap_arguments *given, struct rmap_error *err)
{
    struct rmap_glass_request request;
    struct rmap_glass_list list = {0};
    const char *path = rmap_argument(given, "output");
    enum rmap_status st = read_request(given, &request, err);
    if (st == RMAP_OK)
        st = rmap_glass_list_make(&request, &list, err);
    if (st == RMAP_OK && path)
        st = draw(&list, path, err);
    if (st == RMAP_OK && context->json)
        st = rmap_json_print(rmap_glass_list_json(&request, &list), stdout, err);
    else if (st == RMAP_OK)
        rmap_glass_list_print(&request, &list, stdout);
    if (st == RMAP_OK && list.n == 0 && !context->quiet)
        fputs("raymap: no material matches\n", stderr);
    rmap_glass_list_fini(&list);
    return st;
}

static enum rmap_status run_glass(const struct rmap_context *context,
                                  const struct rmap_arguments *given, struct rmap_error *err)
{
    return rmap_agree(context, context->rank == 0 ? answer(context, given, err) : RMAP_OK, err);
}

const struct rmap_command rmap_command_glass = {
    .name = "glass",
    .summary = "list the glasses and other materials that scenes can name",
    .operands = "[PATTERN...]",
    .help =
        "Materials whose names match a pattern, in any case, with their group or without: nd and\n"
        "vd, the range of their data, and the internal transmittance of 10 mm at 400 and 550 nm.\n"
        "Of a single one also its source, formula, and a table over wavelength:\n\n"
        "  raymap glass 'N-LAK*'\n"
        "  raymap glass ohara:S-LAH55 -o index.svg\n"
        "  raymap glass 'metal *' --at 450,550,650\n"
        "  raymap glass 'H-*' --near 1.5168,64.2\n\n"
        "Distances of --near are in 0.001 of nd and 1 % of vd. nd and vd are as published or,\n"
        "where they are not, of the formula.",
    .options = options,
    .min_operands = 0,
    .max_operands = OPERANDS_MAX,
    .run = run_glass,
};
