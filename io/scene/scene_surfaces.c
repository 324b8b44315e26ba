/* SPDX-License-Identifier: MIT
 *
 * Surfaces: what happens to light that meets one.
 */
#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "io/scene/scene_glass.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_quantity.h"
#include "io/scene/scene_scatter.h"
#include "io/scene/scene_surfaces.h"

extern const char rmap_finishes[]; /* finishes.yaml, with a zero behind it; cmake/materials.S.in */

static struct rmap_surface *new_surface(struct rmap_reader *reader, const char *name, int32_t line)
{
    struct rmap_scene *scene = reader->scene;
    struct rmap_surface *surface =
        RMAP_READER_NEW(reader, scene->surface, scene->n_surface, reader->cap_surface);
    if (!surface)
        return NULL;
    surface->type = RMAP_SURFACE_ABSORBER;
    surface->name = rmap_reader_strdup(reader, name);
    rmap_reader_add_name(reader, &reader->surfaces, surface->name, 0,
                         (int32_t)(scene->n_surface - 1), line);
    return surface;
}

static void read_coat(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      struct rmap_surface *surface)
{
    const struct rmap_yaml_node *coat = rmap_yaml_get(node, "coat");
    int choice = 1;
    if (!coat)
        return;
    if (coat->kind == RMAP_YAML_SCALAR && rmap_names_find(&reader->films, coat->text)) {
        rmap_reader_error(reader, coat, "a film is named so: 'coat: {film: %.60s}'", coat->text);
        return;
    }
    if (coat->kind == RMAP_YAML_SCALAR) {
        (void)rmap_reader_choice(reader, node, "coat", RMAP_OPTIONAL, "ideal none", &choice);
        surface->coat = choice == 0 ? RMAP_COAT_IDEAL : RMAP_COAT_NONE;
        return;
    }
    if (!rmap_reader_check_map(reader, coat, "a coat", "reflectance film"))
        return;
    if (rmap_yaml_get(coat, "film")) {
        const char *name = rmap_reader_text(reader, coat, "film", RMAP_REQUIRED);
        surface->coat = RMAP_COAT_FILM;
        if (rmap_yaml_get(coat, "reflectance"))
            rmap_reader_error(reader, coat, "a coat has a reflectance or is a film, not both");
        if (name)
            surface->film =
                rmap_reader_find(reader, &reader->films, "film", rmap_yaml_get(coat, "film"), name);
        return;
    }
    surface->coat = RMAP_COAT_REFLECTANCE;
    rmap_reader_quantity(reader, coat, "reflectance", RMAP_REQUIRED, &rmap_range_share,
                         surface->reflect_specular);
}

/* metal: Ag */
static void metal_of_catalogue(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                               struct rmap_surface *surface)
{
    const struct rmap_channels at = rmap_channels_of_coats(&reader->scene->channels);
    struct rmap_glass metal;
    if (!rmap_reader_material(reader, node, "metal", &metal))
        return;
    if (metal.extinction.n == 0)
        rmap_reader_error(reader, rmap_yaml_get(node, "metal"),
                          "the catalogue has no k of %s %s: a metal needs it", metal.group,
                          metal.name);
    rmap_reader_warn_outside(reader, rmap_yaml_get(node, "metal"), "metal", metal.name,
                             metal.from_nm, metal.to_nm, "its ends stand for the rest");
    for (int i = 0; i < at.n; i++) {
        surface->metal_n[i] = rmap_glass_index(&metal, at.wavelength_nm[i]);
        surface->metal_k[i] = rmap_glass_extinction(&metal, at.wavelength_nm[i]);
    }
}

/* metal: {n: 0.2, k: 3} or metal: {table: {wavelength, n, k}} */
static void read_metal(struct rmap_reader *reader, const struct rmap_yaml_node *metal,
                       struct rmap_surface *surface)
{
    const struct rmap_channels at = rmap_channels_of_coats(&reader->scene->channels);
    const struct rmap_yaml_node *table = rmap_yaml_get(metal, "table");
    if (!rmap_reader_check_map(reader, metal, "a metal", "table n k"))
        return;
    if (!table) {
        double n = 0, k = 0;
        (void)rmap_reader_number(reader, metal, "n", RMAP_REQUIRED, &rmap_range_nonnegative, &n);
        (void)rmap_reader_number(reader, metal, "k", RMAP_REQUIRED, &rmap_range_nonnegative, &k);
        for (int i = 0; i < at.n; i++) {
            surface->metal_n[i] = n;
            surface->metal_k[i] = k;
        }
        return;
    }
    double *column[3];
    size_t n = 0;
    if (rmap_yaml_get(metal, "n") || rmap_yaml_get(metal, "k"))
        rmap_reader_error(reader, metal, "a metal has a table, or n and k, not both");
    rmap_reader_table(reader, table, "wavelength n k", 3, &rmap_range_nonnegative, &n, column);
    if (!n)
        return;
    const struct rmap_table1 index = {n, column[0], column[1]}, loss = {n, column[0], column[2]};
    for (int i = 0; i < at.n; i++) {
        surface->metal_n[i] = rmap_table1_at(&index, at.wavelength_nm[i]);
        surface->metal_k[i] = rmap_table1_at(&loss, at.wavelength_nm[i]);
    }
}

static void read_mirror(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        struct rmap_surface *surface)
{
    const struct rmap_yaml_node *metal = rmap_yaml_get(node, "metal"),
                                *coat = rmap_yaml_get(node, "coat");
    if (metal && rmap_yaml_get(node, "reflectance"))
        rmap_reader_error(reader, metal, "a mirror has a reflectance or is a metal, not both");
    if (metal) {
        surface->is_metal = true;
        if (metal->kind == RMAP_YAML_SCALAR)
            metal_of_catalogue(reader, node, surface);
        else
            read_metal(reader, metal, surface);
        read_coat(reader, node, surface);
        if (surface->coat == RMAP_COAT_REFLECTANCE || surface->coat == RMAP_COAT_IDEAL)
            rmap_reader_error(reader, coat,
                              "the coat of a metal is a film, as in 'coat: {film: NAME}'");
        return;
    }
    if (coat)
        rmap_reader_error(reader, coat,
                          "the films of a mirror lie on a metal: say which, as in 'metal: Ag'");
    rmap_reader_quantity(reader, node, "reflectance", RMAP_REQUIRED, &rmap_range_share,
                         surface->reflect_specular);
}

static void check_shares(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                         const struct rmap_surface *surface)
{
    for (int i = 0; i < reader->scene->channels.n; i++) {
        double sum = surface->reflect_specular[i] + surface->reflect_diffuse[i] +
                     surface->transmit_specular[i] + surface->transmit_diffuse[i];
        if (!(sum > 1 + 1e-9))
            continue;
        rmap_reader_error(reader, node,
                          "the shares of mixture '%.60s' sum to %.9g: more than 1 is no surface",
                          surface->name, sum);
        return;
    }
}

#define SHARES(member) RMAP_KEY_SHARES, offsetof(struct rmap_surface, member), &rmap_range_share
const struct rmap_mapping rmap_surface_keys = {
#define ROW(symbol, name, phrase, keys, look, events) name " "
    "surfaces",
    RMAP_SURFACE_TABLE(ROW),
#undef ROW
#define ROW(symbol, name, phrase, keys, look, events) {phrase, "type " keys},
    {RMAP_SURFACE_TABLE(ROW)},
#undef ROW
    {{"reflectance", SHARES(reflect_diffuse), 0, RMAP_REQUIRED, RMAP_TYPE(RMAP_SURFACE_LAMBERT)},
     {"reflect_specular", SHARES(reflect_specular)},
     {"reflect_diffuse", SHARES(reflect_diffuse)},
     {"transmit_specular", SHARES(transmit_specular), .types = RMAP_TYPE(RMAP_SURFACE_MIXTURE)},
     {"transmit_diffuse", SHARES(transmit_diffuse)}}};
#undef SHARES

static void read_surface(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                         struct rmap_surface *surface)
{
    int type = rmap_reader_type(reader, node, &rmap_surface_keys);
    if (type < 0) {
        (void)rmap_reader_check_map(reader, node, "a surface",
#define ROW(symbol, name, phrase, keys, look, events) keys " "
                                    "type " RMAP_SURFACE_TABLE(ROW));
#undef ROW
        return;
    }
    surface->type = (enum rmap_surface_type)type;
    (void)rmap_reader_known(reader, node, &rmap_surface_keys, type);
    bool good = rmap_reader_fill(reader, node, &rmap_surface_keys, type, surface);
    if (surface->type == RMAP_SURFACE_FRESNEL)
        read_coat(reader, node, surface);
    else if (surface->type == RMAP_SURFACE_MIRROR)
        read_mirror(reader, node, surface);
    else if (good && surface->type != RMAP_SURFACE_SCATTER)
        check_shares(reader, node, surface);
    rmap_reader_read_scatter(reader, node, surface);
}

/* Complaints about a published surface stand where it is named. */
static void place_at(struct rmap_yaml_node *node, const struct rmap_yaml_node *at)
{
    node->line = at->line;
    node->column = at->column;
    for (size_t i = 0; i < node->n_item; i++) {
        node->item[i].line = at->line;
        place_at(node->item[i].value, at);
    }
}

/* In any case, as glasses. */
static const struct rmap_yaml_item *find_finish(const struct rmap_yaml_node *root, const char *name)
{
    for (size_t i = 0; root && i < root->n_item; i++)
        if (strcasecmp(root->item[i].key, name) == 0)
            return &root->item[i];
    return NULL;
}

/* "unknown surface", with what the scene and the library have. */
static void complain_of(struct rmap_reader *reader, const struct rmap_yaml_node *root,
                        const struct rmap_yaml_node *at, const char *name)
{
    const size_t n = reader->surfaces.n, n_root = root ? root->n_item : 0;
    const char **word = rmap_alloc(n + n_root, sizeof *word);
    for (size_t i = 0; word && i < n + n_root; i++)
        word[i] = i < n ? reader->surfaces.name[i].text : root->item[i - n].key;
    rmap_reader_unknown(reader, at->line, at->column, "unknown surface", name, word,
                        word ? n + n_root : 0);
    rmap_free(word);
}

/* One of the published surfaces, and the tree that it is of, to be destroyed; NULL after a
 * complaint. */
static const struct rmap_yaml_item *published(struct rmap_reader *reader,
                                              const struct rmap_yaml_node *at, const char *name,
                                              struct rmap_yaml_node **root_ret)
{
    struct rmap_diagnostics library = {0};
    if (rmap_yaml_parse(rmap_finishes, strlen(rmap_finishes), root_ret, &library,
                        &reader->failure) == RMAP_SYSTEM)
        rmap_reader_no_memory(reader);
    rmap_diagnostics_fini(&library);
    const struct rmap_yaml_item *item = find_finish(*root_ret, name);
    if (item)
        place_at(item->value, at);
    else
        complain_of(reader, *root_ret, at, name);
    return item;
}

/* mine: Acktar Metal Velvet */
static void read_alias(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                       struct rmap_surface *surface)
{
    struct rmap_yaml_node *root = NULL;
    const struct rmap_yaml_item *item = published(reader, at, at->text, &root);
    if (item)
        read_surface(reader, item->value, surface);
    rmap_yaml_destroy(root);
}

/* A surface of the published ones, read into the scene. */
static void read_finish(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                        const char *name, int32_t *surface_ret)
{
    struct rmap_yaml_node *root = NULL;
    const struct rmap_yaml_item *item = published(reader, at, name, &root);
    const struct rmap_name *known = item ? rmap_names_find(&reader->surfaces, item->key) : NULL;
    struct rmap_surface *surface = item && !known ? new_surface(reader, item->key, at->line) : NULL;
    *surface_ret = known ? known->index : surface ? (int32_t)reader->scene->n_surface - 1 : -1;
    if (surface)
        read_surface(reader, item->value, surface);
    rmap_yaml_destroy(root);
}

static void read_named(struct rmap_reader *reader, const struct rmap_yaml_item *item)
{
    const struct rmap_yaml_node place = {.line = item->line, .column = item->column};
    struct rmap_surface *surface = new_surface(reader, item->key, item->line);
    if (surface && item->value->kind == RMAP_YAML_MAP)
        read_surface(reader, item->value, surface);
    else if (surface && item->value->kind == RMAP_YAML_SCALAR)
        read_alias(reader, item->value, surface);
    else if (surface)
        rmap_reader_error(reader, &place, "surface '%.60s' must be a mapping, as in {type: %s}",
                          item->key, rmap_surface_model[0].name);
}

void rmap_reader_read_surfaces(struct rmap_reader *reader)
{
    rmap_reader_each_named(reader, "surfaces", "surface", &reader->surfaces, read_named);
}

void rmap_reader_builtin_surface(struct rmap_reader *reader, enum rmap_surface_type type,
                                 int32_t *surface_ret)
{
    const struct rmap_name *known =
        rmap_names_find(&reader->surfaces, rmap_surface_model[type].name);
    if (known) {
        *surface_ret = known->index;
        return;
    }
    struct rmap_surface *surface = new_surface(reader, rmap_surface_model[type].name, 0);
    if (!surface)
        return;
    surface->type = type;
    *surface_ret = (int32_t)(reader->scene->n_surface - 1);
}

/* `fresnel` (bare), `absorber` and the published surfaces exist without being defined. */
static void find_surface(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                         const char *key, enum rmap_need need, int32_t *surface_ret)
{
    const char *name = rmap_reader_text(reader, map, key, need);
    if (!name)
        return;
    if (!surface_ret) {
        struct rmap_yaml_node *root = NULL;
        if (strcmp(name, rmap_surface_model[RMAP_SURFACE_FRESNEL].name) != 0 &&
            strcmp(name, rmap_surface_model[RMAP_SURFACE_ABSORBER].name) != 0 &&
            !rmap_names_find(&reader->surfaces, name))
            (void)published(reader, rmap_yaml_get(map, key), name, &root);
        rmap_yaml_destroy(root);
        return;
    }
    if (strcmp(name, rmap_surface_model[RMAP_SURFACE_FRESNEL].name) == 0) {
        rmap_reader_builtin_surface(reader, RMAP_SURFACE_FRESNEL, surface_ret);
        return;
    }
    if (strcmp(name, rmap_surface_model[RMAP_SURFACE_ABSORBER].name) == 0) {
        rmap_reader_builtin_surface(reader, RMAP_SURFACE_ABSORBER, surface_ret);
        return;
    }
    const struct rmap_name *known = rmap_names_find(&reader->surfaces, name);
    if (known)
        *surface_ret = known->index;
    else
        read_finish(reader, rmap_yaml_get(map, key), name, surface_ret);
}

void rmap_reader_surface_pair(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                              const char *key, int32_t *front_ret, int32_t *back_ret)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(map, key);
    if (!node)
        return;
    if (node->kind != RMAP_YAML_MAP) {
        find_surface(reader, map, key, RMAP_REQUIRED, front_ret);
        if (front_ret)
            *back_ret = *front_ret;
        return;
    }
    if (rmap_yaml_get(node, "type")) {
        rmap_reader_error(reader, node,
                          "a surface is not described here: give it a name in 'surfaces', as in "
                          "'surfaces: {mine: {type: ...}}', and write '%s: mine'",
                          key);
        return;
    }
    (void)rmap_reader_check_map(reader, node, "a surface pair", "front back");
    find_surface(reader, node, "front", RMAP_REQUIRED, front_ret);
    find_surface(reader, node, "back", RMAP_REQUIRED, back_ret);
}
