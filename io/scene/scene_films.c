/* SPDX-License-Identifier: MIT
 *
 * Thin films: stacks of layers that coats of surfaces name.
 */
#include "io/scene/scene_films.h"

#include <string.h>

#include "base/alloc.h"
#include "io/scene/coat_csv.h"
#include "io/scene/scene_constants.h"
#include "io/scene/scene_keys.h"

enum { LAYER_MAX = 1000 };

const struct rmap_mapping rmap_film_keys = {
    "films", NULL, {{"a film", "reference substrate layers table"}}};
const struct rmap_mapping rmap_film_layer_keys = {
    "films", NULL, {{"a layer", "material n k table quarter thickness"}}};

/* Thickness in nm: as written, or so many quarters of the reference wavelength. */
static bool read_thickness(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           const struct rmap_constants *its, double reference_nm, double *nm_ret)
{
    const bool quarters = rmap_yaml_get(node, "quarter"), length = rmap_yaml_get(node, "thickness");
    double value = 0.0;
    if (quarters == length) {
        rmap_reader_error(reader, node,
                          "a layer has a thickness, as in 'thickness: 130 nm', or it is so many "
                          "quarters of the film's reference wavelength, as in 'quarter: 1'");
        return false;
    }
    if (length) {
        if (!rmap_reader_number(reader, node, "thickness", RMAP_REQUIRED,
                                &rmap_range_nonnegative_length, &value))
            return false;
        *nm_ret = value * reader->scene->unit_m * 1e9;
        if (*nm_ret <= 1e6)
            return true;
        rmap_reader_error(reader, rmap_yaml_get(node, "thickness"),
                          "a film of %g mm is none: write the unit of its thickness, as in 130 nm",
                          1e-6 * *nm_ret);
        return false;
    }
    if (!rmap_reader_number(reader, node, "quarter", RMAP_REQUIRED, &rmap_range_nonnegative,
                            &value))
        return false;
    if (!(reference_nm > 0.0)) {
        rmap_reader_error(reader, rmap_yaml_get(node, "quarter"),
                          "quarters of which wavelength? Say it in the film, as in 'reference: "
                          "550'");
        return false;
    }
    *nm_ret = value * reference_nm / (4.0 * rmap_constants_index(its, reference_nm));
    return true;
}

static void read_layer(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       double reference_nm, size_t k, struct rmap_thin_film *film)
{
    const struct rmap_channels at = rmap_channels_of_coats(&reader->scene->channels);
    struct rmap_constants its = {.has_glass = false};
    double nm = 0.0;
    if (!rmap_reader_known(reader, node, &rmap_film_layer_keys, 0) ||
        !rmap_reader_constants(reader, node, "film", film->name, "a layer", &its) ||
        !read_thickness(reader, node, &its, reference_nm, &nm))
        return;
    for (int i = 0; i < at.n; i++) {
        const double wavelength = at.wavelength_nm[i];
        film->layer[(size_t)i * film->n_layer + k] =
            (struct rmap_thin_film_layer){rmap_constants_index(&its, wavelength),
                                          rmap_constants_loss(&its, wavelength), nm / wavelength};
    }
}

/* table: {file: coat.csv} */
static void read_measured(struct rmap_reader *reader, const struct rmap_yaml_node *table,
                          struct rmap_thin_film *film)
{
    static const struct rmap_text_kind csv = {"a table", "text", "", (size_t)64 << 20};
    struct rmap_error why;
    size_t nbytes = 0;
    if (!rmap_reader_check_map(reader, table, "a film's table", "file"))
        return;
    const char *text = rmap_reader_file(reader, table, "file", &csv, &nbytes);
    if (!text)
        return;
    const struct rmap_channels at = rmap_channels_of_coats(&reader->scene->channels);
    const enum rmap_status st = rmap_coat_csv_read(text, nbytes, &at, film, &why);
    if (st == RMAP_SYSTEM) {
        reader->failure = why;
        rmap_reader_fail(reader, st);
    } else if (st != RMAP_OK) {
        rmap_reader_error(reader, rmap_yaml_get(table, "file"), "%.100s: %s",
                          rmap_yaml_get(table, "file")->text, why.text);
    }
}

static void read_film(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      struct rmap_thin_film *film)
{
    const struct rmap_yaml_node *layers = rmap_yaml_get(node, "layers");
    double reference_nm = 0.0;
    int substrate = -1;
    if (!rmap_reader_known(reader, node, &rmap_film_keys, 0))
        return;
    (void)rmap_reader_number(reader, node, "reference", RMAP_OPTIONAL, &rmap_range_wavelength,
                             &reference_nm);
    (void)rmap_reader_choice(reader, node, "substrate", RMAP_OPTIONAL, "front back", &substrate);
    film->substrate = substrate == 0   ? RMAP_SUBSTRATE_FRONT
                      : substrate == 1 ? RMAP_SUBSTRATE_BACK
                                       : RMAP_SUBSTRATE_INSIDE;
    if (rmap_yaml_get(node, "table")) {
        if (layers || reference_nm > 0.0)
            rmap_reader_error(reader, node, "a film is measured, by its 'table', or has layers");
        read_measured(reader, rmap_yaml_get(node, "table"), film);
        return;
    }
    if (!layers) {
        rmap_reader_error(reader, node,
                          "'layers' is missing: list them from the outside on; or 'table: {file: "
                          "...}' of what was measured");
        return;
    }
    if (!rmap_reader_check_list(reader, layers, "'layers'"))
        return;
    if (layers->n_item > LAYER_MAX) {
        rmap_reader_error(reader, layers, "a film has %d layers at most", LAYER_MAX);
        return;
    }
    film->layer =
        rmap_alloc((size_t)reader->scene->channels.n * layers->n_item + 1, sizeof *film->layer);
    if (!film->layer) {
        rmap_reader_no_memory(reader);
        return;
    }
    film->n_layer = layers->n_item;
    for (size_t k = 0; k < layers->n_item; k++)
        read_layer(reader, layers->item[k].value, reference_nm, k, film);
}

static void read_named(struct rmap_reader *reader, const struct rmap_yaml_item *item)
{
    struct rmap_scene *scene = reader->scene;
    struct rmap_thin_film *film =
        RMAP_READER_NEW(reader, scene->film, scene->n_film, reader->cap_film);
    if (!film)
        return;
    *film = (struct rmap_thin_film){.name = rmap_reader_strdup(reader, item->key)};
    rmap_reader_add_name(reader, &reader->films, film->name, 0, (int32_t)(scene->n_film - 1),
                         item->line);
    read_film(reader, item->value, film);
}

void rmap_reader_read_films(struct rmap_reader *reader)
{
    rmap_reader_each_named(reader, "films", "film", &reader->films, read_named);
}

static void check_side(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                       const struct rmap_object *object, int32_t surface_index)
{
    const struct rmap_surface *surface =
        surface_index < 0 ? NULL : &reader->scene->surface[surface_index];
    if (!surface || surface->type != RMAP_SURFACE_FRESNEL || surface->coat != RMAP_COAT_FILM ||
        surface->film < 0) /* of no name: complained of */
        return;
    const struct rmap_thin_film *film = &reader->scene->film[surface->film];
    const bool front = object->medium_front == object->medium_outside,
               back = object->medium_back == object->medium_outside;
    if (film->substrate != RMAP_SUBSTRATE_INSIDE || front != back)
        return;
    rmap_reader_error(reader, at,
                      "%s of '%.60s' %s the medium around it: say in film '%.60s' on which side "
                      "its last layer lies, as in 'substrate: back'",
                      front ? "both sides" : "neither side", object->name, front ? "are" : "is",
                      film->name);
}

void rmap_reader_check_films(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                             const struct rmap_object *object)
{
    check_side(reader, at, object, object->surface_front);
    if (object->surface_back != object->surface_front)
        check_side(reader, at, object, object->surface_back);
}
