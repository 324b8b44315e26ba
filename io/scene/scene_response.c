/* SPDX-License-Identifier: MIT
 *
 * What a detector makes of the light that it registers: `response` and `detect`.
 */
#include "io/scene/scene_response.h"

#include <stdio.h>
#include <string.h>

#include "io/scene/scene_glass.h"
#include "io/scene/scene_quantity.h"

/* Of no angle: alike at all of them. */
static struct rmap_response *new_response(struct rmap_reader *reader, size_t n_angle)
{
    struct rmap_response *response = rmap_response_create(n_angle, reader->scene->channels.n);
    if (!response)
        rmap_reader_no_memory(reader);
    return response;
}

/* V(lambda): light in lm has it already; of light in W it takes a spectrum. */
static struct rmap_response *read_luminous(struct rmap_reader *reader,
                                           const struct rmap_yaml_node *node)
{
    const struct rmap_scene *scene = reader->scene;
    const struct rmap_channels *channels = &scene->channels;
    const bool in_watts = scene->flux_unit == RMAP_FLUX_W, rgb = channels->mode == RMAP_COLOUR_RGB;
    if (!in_watts && scene->flux_unit != RMAP_FLUX_LM) {
        rmap_reader_error(reader, node, "V(lambda) is of light in W or lm, and this is in %s",
                          rmap_flux_unit_name(scene));
        return NULL;
    }
    for (size_t s = 0; s < scene->n_source && in_watts; s++) {
        if (!rgb && rmap_source_has_spectrum(&scene->source[s]))
            continue;
        rmap_reader_error(
            reader, node,
            rgb ? "V(lambda) of light in W takes wavelengths, and red, green and blue "
                  "have none: give the flux of source '%.60s' in lm, or 'mode: "
                  "spectral'"
                : "V(lambda) of light in W takes its spectrum: give source '%.60s' a "
                  "'spectrum', or its flux in lm",
            scene->source[s].name);
        return NULL;
    }
    if (in_watts && (channels->n == 2 || channels->n == 3))
        rmap_reader_warn(reader, node,
                         "%d wavelengths do not carry V(lambda): lm are as good as these lines "
                         "stand for the light; take 'wavelengths: {from: 380, to: 780, step: 10}'",
                         channels->n);
    struct rmap_response *response = new_response(reader, 1);
    if (!response)
        return NULL;
    response->lumens = true;
    response->xyz = strcmp(node->text, "xyz") == 0;
    for (int c = 0; c < channels->n; c++) {
        double alone[RMAP_CHANNEL_MAX] = {0.0};
        alone[c] = 1.0;
        response->value[c] = in_watts ? rmap_luminous_efficacy(channels, alone) : 1.0;
    }
    return response;
}

/* A table over angle, wavelength or both: then `value` has a row for each angle. */
struct table {
    size_t n_angle, n_nm;
    double *angle_deg, *nm; /* NULL: alike at all */
    double *value;          /* [n_angle][n_nm] */
};

static bool read_rows(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      struct table *table)
{
    const struct rmap_yaml_node *rows = rmap_yaml_get(node, "value");
    bool good = rows && rows->kind == RMAP_YAML_LIST && rows->n_item == table->n_angle;
    table->value = rmap_reader_alloc(reader, table->n_angle * table->n_nm, sizeof *table->value);
    for (size_t i = 0; i < table->n_angle && good && table->value; i++) {
        const struct rmap_yaml_node *row = rows->item[i].value;
        good = row->kind == RMAP_YAML_LIST && row->n_item == table->n_nm;
        for (size_t k = 0; good && k < table->n_nm; k++)
            if (!rmap_reader_scalar(reader, row->item[k].value, "a response",
                                    &rmap_range_nonnegative, &table->value[i * table->n_nm + k]))
                return false;
    }
    if (!good)
        rmap_reader_error(reader, rows ? rows : node,
                          "'value' over angle and wavelength is a row for each of the %zu angles, "
                          "of a number for each of the %zu wavelengths",
                          table->n_angle, table->n_nm);
    return good && table->value;
}

static bool read_table(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct table *table)
{
    const bool of_angle = rmap_yaml_get(node, "angle") != NULL,
               of_nm = rmap_yaml_get(node, "wavelength") != NULL;
    double *column[2];
    size_t n = 0;
    *table = (struct table){.n_angle = 1, .n_nm = 1};
    if (of_angle && of_nm) {
        if (!rmap_reader_check_map(reader, node, "a response", "wavelength angle value"))
            return false;
        rmap_reader_axis(reader, node, "angle", &table->n_angle, &table->angle_deg);
        rmap_reader_axis(reader, node, "wavelength", &table->n_nm, &table->nm);
        return table->n_angle > 0 && table->n_nm > 0 && read_rows(reader, node, table);
    }
    rmap_reader_table(reader, node, of_angle ? "angle value" : "wavelength value", 2,
                      &rmap_range_nonnegative, &n, column);
    *(of_angle ? &table->angle_deg : &table->nm) = column[0];
    *(of_angle ? &table->n_angle : &table->n_nm) = n;
    table->value = column[1];
    return n > 0;
}

static struct rmap_response *of_table(struct rmap_reader *reader, const struct rmap_yaml_node *node)
{
    const struct rmap_channels *channels = &reader->scene->channels;
    struct table table;
    if (!read_table(reader, node, &table))
        return NULL;
    if (table.n_nm > 1) /* one alone is a constant */
        rmap_reader_warn_outside(reader, node, "table of", "response", table.nm[0],
                                 table.nm[table.n_nm - 1], "its ends stand for the rest");
    struct rmap_response *response = new_response(reader, table.n_angle);
    for (size_t i = 0; response && i < table.n_angle; i++) {
        const struct rmap_spectrum row = {
            .kind = table.nm ? RMAP_SPECTRUM_TABLE : RMAP_SPECTRUM_EQUAL,
            .value = table.value[i],
            .table = {table.n_nm, table.nm, table.value + i * table.n_nm}};
        rmap_spectrum_sample(&row, channels, response->value + i * (size_t)channels->n);
        response->angle_deg[i] = table.angle_deg ? table.angle_deg[i] : 0.0;
    }
    return response;
}

/* A number stands for light of all wavelengths and angles. */
static struct rmap_response *of_number(struct rmap_reader *reader,
                                       const struct rmap_yaml_node *node)
{
    double value = 0.0;
    if (!rmap_reader_scalar(reader, node, "a response", &rmap_range_nonnegative, &value))
        return NULL;
    struct rmap_response *response = new_response(reader, 1);
    for (int c = 0; response && c < response->n_channel; c++)
        response->value[c] = value;
    return response;
}

static struct rmap_response *read_response(struct rmap_reader *reader,
                                           const struct rmap_yaml_node *node)
{
    double number;
    if (node->kind == RMAP_YAML_SCALAR &&
        (strcmp(node->text, "V") == 0 || strcmp(node->text, "xyz") == 0))
        return read_luminous(reader, node);
    if (node->kind == RMAP_YAML_SCALAR &&
        rmap_reader_parse_number(node->text, strlen(node->text), &number))
        return of_number(reader, node);
    if (node->kind == RMAP_YAML_MAP)
        return of_table(reader, node);
    rmap_reader_error(
        reader, node,
        "'response' is V, xyz, a number, or a table {wavelength: [...], value: [...]}, "
        "{angle: [...], value: [...]}");
    return NULL;
}

void rmap_reader_response(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          struct rmap_detector *detector)
{
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "response"),
                                *how = rmap_yaml_get(node, "detect");
    int detect = RMAP_DETECT_WEIGHT;
    const bool good =
        rmap_reader_choice(reader, node, "detect", RMAP_OPTIONAL, "weight chance", &detect);
    if (how && !at)
        rmap_reader_error(reader, how,
                          "'detect' says what becomes of the response: give 'response', too");
    detector->response = at ? read_response(reader, at) : NULL;
    if (!detector->response || !good)
        return;
    detector->response->detect = (enum rmap_detect)detect;
    if (detect == RMAP_DETECT_CHANCE && detector->response->lumens)
        rmap_reader_error(reader, how, "lm are no chance: 'detect: weight', or a table of shares");
    else if (detect == RMAP_DETECT_CHANCE && rmap_response_most(detector->response) > 1.0)
        rmap_reader_error(
            reader, how,
            "a chance is 1 at most, and 'response' goes up to %g: 'detect: weight', or "
            "values of at most 1",
            rmap_response_most(detector->response));
}
