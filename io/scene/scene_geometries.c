/* SPDX-License-Identifier: MIT
 *
 * Geometries: analytic shapes and meshes. Prescriptions are scene_lens.c.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/file/input_file.h"
#include "io/mesh/mesh_origin.h"
#include "io/scene/scene_bodies.h"
#include "io/scene/scene_geometries.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_lens.h"
#include "io/scene/scene_sags.h"
#include "scene/scene_same.h"

enum kind { CONIC, RECTANGLE, DISC, CYLINDER, CONE, SPHERE, MESH, LENS, BOX, PRISM };

#define NUMBER(member) RMAP_KEY_NUMBER, offsetof(struct rmap_shape, member)
const struct rmap_mapping rmap_geometry_keys = {
    "geometries",
    "conic rectangle disc cylinder cone sphere mesh lens box prism",
    {[CONIC] = {"a conic",
                "type radius curvature conic asphere toroid zernike xy qcon qbfs fresnel "
                "aperture inner"},
     [RECTANGLE] = {"a rectangle", "type size"},
     [DISC] = {"a disc", "type radius inner"},
     [CYLINDER] = {"a cylinder", "type radius length closed"},
     [CONE] = {"a cone", "type radius radius2 length closed"},
     [SPHERE] = {"a sphere", "type radius"},
     [MESH] = {"a mesh", "type file scale exact uv"},
     [LENS] = {"a lens", "type surfaces surface edge"},
     [BOX] = {"a box", "type size"},
     [PRISM] = {"a prism", "type points sides radius length"}},
    {{"radius", NUMBER(aperture), &rmap_range_positive_length, 0, RMAP_REQUIRED, RMAP_TYPE(DISC)},
     {"radius", NUMBER(radius), &rmap_range_positive_length, 0, RMAP_REQUIRED,
      RMAP_TYPE(CYLINDER) | RMAP_TYPE(SPHERE)},
     {"radius", NUMBER(radius), &rmap_range_nonnegative_length, 0, RMAP_REQUIRED, RMAP_TYPE(CONE)},
     {"radius2", NUMBER(radius2), &rmap_range_nonnegative_length, 0, RMAP_REQUIRED},
     {"length", NUMBER(length), &rmap_range_positive_length, 0, RMAP_REQUIRED},
     {"conic", NUMBER(conic), &rmap_range_any},
     {"aperture", NUMBER(aperture), &rmap_range_positive_length, 0, RMAP_REQUIRED},
     {"inner", NUMBER(inner), &rmap_range_nonnegative_length},
     {"size", RMAP_KEY_PAIR, offsetof(struct rmap_shape, size), &rmap_range_positive_length, 0,
      RMAP_REQUIRED, RMAP_TYPE(RECTANGLE)}}};
#undef NUMBER

static struct rmap_geometry *add_geometry(struct rmap_reader *reader, const char *name,
                                          int32_t *index_ret)
{
    struct rmap_scene *scene = reader->scene;
    struct rmap_geometry *geometry =
        RMAP_READER_NEW(reader, scene->geometry, scene->n_geometry, reader->cap_geometry);
    if (!geometry)
        return NULL;
    geometry->name = rmap_reader_strdup(reader, name);
    *index_ret = (int32_t)(scene->n_geometry - 1);
    return geometry;
}

void rmap_reader_add_shape(struct rmap_reader *reader, const char *name,
                           const struct rmap_shape *shape, int32_t *index_ret)
{
    struct rmap_geometry *geometry = add_geometry(reader, name, index_ret);
    if (!geometry)
        return;
    geometry->kind = RMAP_GEOMETRY_SHAPE;
    geometry->shape = *shape;
    if (!rmap_shape_own(&geometry->shape))
        rmap_reader_no_memory(reader);
}

void rmap_reader_add_mesh(struct rmap_reader *reader, const char *name, struct rmap_mesh *mesh,
                          int32_t *index_ret)
{
    struct rmap_geometry *geometry = add_geometry(reader, name, index_ret);
    if (!geometry) {
        rmap_mesh_destroy(mesh);
        return;
    }
    geometry->kind = RMAP_GEOMETRY_MESH;
    geometry->mesh = mesh;
}

/* ---- caps ---- */

/* radius: 0, inf or absent is a plane. */
static bool read_curvature(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                           double *curvature)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(map, "radius");
    if (node && rmap_yaml_get(map, "curvature")) {
        rmap_reader_error(reader, node, "give 'radius' or 'curvature', not both");
        return false;
    }
    if (!node)
        return rmap_reader_number(reader, map, "curvature", RMAP_OPTIONAL, &rmap_range_curvature,
                                  curvature);
    return rmap_reader_radius(reader, node, "'radius'", curvature);
}

bool rmap_reader_conic(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                       struct rmap_shape *shape)
{
    const struct rmap_yaml_node *asphere = rmap_yaml_get(map, "asphere");
    if (rmap_reader_is_sag(map))
        return rmap_reader_sag(reader, map, shape);
    shape->type = RMAP_SHAPE_CONIC;
    bool good = read_curvature(reader, map, &shape->curvature);
    good &= rmap_reader_fill(reader, map, &rmap_geometry_keys, CONIC, shape);
    if (asphere)
        good &= rmap_reader_powers(reader, asphere, 2, 2 * RMAP_ASPHERE_MAX, shape->asphere,
                                   &shape->n_asphere);
    if (!good)
        return false;
    const char *wrong = rmap_shape_check(shape);
    if (wrong)
        rmap_reader_error(reader, map, "this is no surface: %s", wrong);
    return !wrong;
}

/* ---- the other shapes ---- */

static bool read_shape(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       enum kind kind, struct rmap_shape *shape)
{
    static const enum rmap_shape_type type[] = {[RECTANGLE] = RMAP_SHAPE_RECTANGLE,
                                                [DISC] = RMAP_SHAPE_DISC,
                                                [CYLINDER] = RMAP_SHAPE_TUBE,
                                                [CONE] = RMAP_SHAPE_TUBE,
                                                [SPHERE] = RMAP_SHAPE_SPHERE};
    shape->type = type[kind];
    bool good = rmap_reader_fill(reader, node, &rmap_geometry_keys, (int)kind, shape);
    if (kind == CYLINDER)
        shape->radius2 = shape->radius;
    const char *wrong = good ? rmap_shape_check(shape) : NULL;
    if (wrong && kind == DISC)
        wrong = "'inner' must be smaller than 'radius'";
    if (wrong)
        rmap_reader_error(reader, node, "this is no %s: %s", rmap_yaml_get(node, "type")->text,
                          wrong);
    return good && !wrong;
}

/* ---- meshes ---- */

static double mesh_scale(struct rmap_reader *reader, const struct rmap_yaml_node *node)
{
    const struct rmap_yaml_node *scale = rmap_yaml_get(node, "scale");
    double factor = 1;
    const struct rmap_written_unit *unit = NULL;
    if (scale && scale->kind == RMAP_YAML_SCALAR)
        unit = rmap_unit_of_scene(scale->text, RMAP_DIMENSION_LENGTH);
    if (unit)
        return unit->size / reader->scene->unit_m;
    if (!rmap_reader_number(reader, node, "scale", RMAP_OPTIONAL, &rmap_range_positive, &factor))
        return 0;
    return factor;
}

/* Never a bare name, which dlopen would look for elsewhere. */
char *rmap_reader_path(struct rmap_reader *reader, const char *file)
{
    const char *scene = reader->bundle->path ? reader->bundle->path : "";
    const char *slash = strrchr(scene, '/');
    const char *here = slash || file[0] == '/' || strchr(file, '/') ? "" : "./";
    int folder = slash && file[0] != '/' ? (int)(slash - scene) + 1 : 0;
    size_t nbytes = (size_t)folder + strlen(here) + strlen(file) + 1;
    char *path = rmap_reader_alloc(reader, nbytes, 1);
    if (path)
        (void)snprintf(path, nbytes, "%.*s%s%s", folder, scene, here, file);
    return path;
}

const char *rmap_reader_file(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                             const char *key, const struct rmap_text_kind *kind, size_t *nbytes_ret)
{
    struct rmap_bundle *bundle = reader->bundle;
    const char *name = rmap_reader_text(reader, map, key, RMAP_REQUIRED);
    char *text = NULL;
    if (!name)
        return NULL;
    for (size_t i = 0; i < bundle->n_file; i++)
        if (strcmp(bundle->file[i].name, name) == 0) {
            *nbytes_ret = bundle->file[i].nbytes;
            if (!kind->format || strlen(bundle->file[i].text) == *nbytes_ret)
                return bundle->file[i].text;
            rmap_reader_error(reader, rmap_yaml_get(map, key), "'%.100s' is not %s", name,
                              kind->format);
            return NULL;
        }
    if (bundle->meshes_complete) {
        rmap_reader_error(reader, rmap_yaml_get(map, key),
                          "the file '%.100s' is not stored with the scene", name);
        return NULL;
    }
    char *path = rmap_reader_path(reader, name);
    if (!path)
        return NULL;
    uint8_t *bytes = NULL;
    const char *trouble = rmap_input_file_trouble(path);
    enum rmap_status st =
        trouble
            ? rmap_error_set(&reader->failure, RMAP_INPUT, "cannot open %s: %s", path, trouble)
            : rmap_input_file_read(path, kind->nbytes_max, &bytes, nbytes_ret, &reader->failure);
    if (st == RMAP_INPUT && !trouble)
        rmap_error_context(&reader->failure, "cannot read %s", path);
    text = (char *)bytes;
    if (st == RMAP_OK && kind->format && strlen(text) != *nbytes_ret)
        st = rmap_error_set(&reader->failure, RMAP_INPUT, "%s holds a byte 0: it is not %s", path,
                            kind->format);
    if (st == RMAP_OK)
        st = rmap_bundle_add_file(bundle, name, text, *nbytes_ret, &reader->failure);
    if (st != RMAP_OK)
        rmap_free(text);
    rmap_reader_made(reader, rmap_yaml_get(map, key), st);
    return st == RMAP_OK ? text : NULL;
}

/* Into the bundle; NULL: there is none, or no memory. */
static struct rmap_mesh *keep_mesh(struct rmap_reader *reader, const char *name,
                                   struct rmap_mesh *mesh)
{
    if (mesh && rmap_bundle_add_mesh(reader->bundle, name, mesh, &reader->failure) == RMAP_OK)
        return mesh;
    if (mesh)
        rmap_reader_fail(reader, RMAP_SYSTEM);
    rmap_mesh_destroy(mesh);
    return NULL;
}

/* NULL after a complaint. */
static struct rmap_mesh *load_mesh(struct rmap_reader *reader, const char *name,
                                   const struct rmap_yaml_node *at, double scale, bool exact,
                                   bool uv)
{
    struct rmap_mesh *mesh = NULL;
    struct rmap_mesh_left_out left_out = {0};
    char *path = rmap_reader_path(reader, at->text);
    if (!path)
        return NULL;
    struct rmap_error note = {0};
    char **cache = &reader->bundle->options.cache;
    struct rmap_mesh_reading how = {scale, (uv ? RMAP_MESH_UV : 0) | (exact ? 0 : RMAP_MESH_FLAT),
                                    *cache, &note};
    for (size_t i = 0; i < reader->scene->n_surface; i++)
        how.keep |= reader->scene->surface[i].frame_uv ? RMAP_MESH_TANGENTS : 0;
    struct rmap_mesh_origin *origin = rmap_mesh_origin_create(path, &how);
    enum rmap_status st = RMAP_OK;
    mesh = rmap_mesh_again(reader->bundle->options.before, origin, &left_out);
    if (!mesh)
        st = rmap_mesh_read(path, &how, &mesh, &left_out, &reader->failure);
    if (note.status != RMAP_OK)
        rmap_reader_warn(reader, at, "%s; mesh '%.60s' is read from its own file", note.text, name);
    if (note.status != RMAP_OK && note.status != RMAP_FORMAT) { /* nor will it help the others */
        rmap_free(*cache);
        *cache = NULL;
    }
    if (st == RMAP_OK && left_out.degenerate)
        rmap_reader_warn(reader, at, "mesh '%.60s': %zu degenerate triangles left out", name,
                         left_out.degenerate);
    if (st == RMAP_OK && left_out.undefined)
        rmap_reader_warn(reader, at,
                         "mesh '%.60s': %zu triangles have corners that are no numbers (NaN or "
                         "infinite), triangle %zu first; they are left out and leave a hole",
                         name, left_out.undefined, left_out.first);
    if (left_out.untrue)
        rmap_reader_warn(reader, at,
                         "mesh '%.60s': %zu faces do not lie on the surfaces that the file gives "
                         "them; they stay triangles",
                         name, left_out.untrue);
    if (mesh && uv && !mesh->uv)
        st = rmap_error_set(&reader->failure, RMAP_INPUT,
                            "%s has no texture coordinates: leave out `uv`, or write the file with "
                            "them (.obj: vt; .ply: u v or s t; glTF: TEXCOORD_0)",
                            path);
    rmap_reader_made(reader, at, st);
    mesh = keep_mesh(reader, name, mesh);
    if (mesh && !left_out.elsewhere)
        rmap_mesh_origin_keep(reader->bundle, origin, &left_out);
    else
        rmap_mesh_origin_destroy(origin);
    return mesh;
}

static struct rmap_mesh *make_body(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                   enum kind kind)
{
    return kind == BOX ? rmap_reader_box(reader, node) : rmap_reader_prism(reader, node);
}

/* A body that the bundle has, as its node is now: of a scene at hand it may have been edited. */
static struct rmap_mesh *make_again(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                    enum kind kind, struct rmap_mesh **bundled)
{
    struct rmap_mesh *mesh = make_body(reader, node, kind);
    if (mesh && rmap_same_mesh(mesh, *bundled)) {
        rmap_mesh_destroy(mesh);
        return *bundled;
    }
    if (mesh) {
        rmap_mesh_destroy(*bundled);
        *bundled = mesh;
    }
    return mesh;
}

static void read_mesh(struct rmap_reader *reader, const char *name,
                      const struct rmap_yaml_node *node, enum kind kind,
                      struct rmap_geometry_entry *entry)
{
    const struct rmap_name *bundled = rmap_names_find(&reader->meshes, name);
    struct rmap_mesh *mesh = bundled ? reader->bundle->mesh[bundled->index].mesh : NULL;
    const struct rmap_yaml_node *at = kind == MESH ? rmap_yaml_get(node, "file") : node;
    double scale = 1;
    bool exact = true, uv = false;
    if (kind == MESH && !rmap_reader_text(reader, node, "file", RMAP_REQUIRED))
        at = NULL;
    if (kind == MESH)
        scale = mesh_scale(reader, node);
    if (kind == MESH && (!rmap_reader_bool(reader, node, "exact", &exact) ||
                         !rmap_reader_bool(reader, node, "uv", &uv)))
        return;
    if (!at || !(scale > 0))
        return;
    if (mesh && kind != MESH && reader->bundle->options.before_scene) {
        mesh = make_again(reader, node, kind, &reader->bundle->mesh[bundled->index].mesh);
        if (!mesh)
            return;
    }
    if (!mesh && reader->bundle->meshes_complete) {
        rmap_reader_error(reader, at, "the mesh of geometry '%.60s' is not stored with the scene",
                          name);
        return;
    }
    /* Made meshes are kept as read ones are: a sine may differ where the map is opened. */
    if (!mesh)
        mesh = kind == MESH ? load_mesh(reader, name, at, scale, exact, uv)
                            : keep_mesh(reader, name, make_body(reader, node, kind));
    struct rmap_geometry *geometry = mesh ? add_geometry(reader, name, &entry->geometry) : NULL;
    if (!geometry)
        return;
    geometry->kind = RMAP_GEOMETRY_MESH;
    geometry->mesh = rmap_mesh_hold(mesh);
    entry->broken = false;
}

/* ---- the section ---- */

static void read_geometry(struct rmap_reader *reader, const char *name,
                          const struct rmap_yaml_node *node, struct rmap_geometry_entry *entry)
{
    int choice = rmap_reader_type(reader, node, &rmap_geometry_keys);
    struct rmap_shape shape = {0};
    if (choice < 0)
        return;
    enum kind kind = (enum kind)choice;
    (void)rmap_reader_known(reader, node, &rmap_geometry_keys, choice);
    if (kind == MESH || kind == BOX || kind == PRISM) {
        read_mesh(reader, name, node, kind, entry);
        return;
    }
    if (kind == LENS) {
        rmap_reader_read_lens(reader, node, entry);
        return;
    }
    entry->broken = kind == CONIC ? !rmap_reader_conic(reader, node, &shape)
                                  : !read_shape(reader, node, kind, &shape);
    if (entry->broken)
        return;
    rmap_reader_add_shape(reader, name, &shape, &entry->geometry);
    bool closed = false;
    if ((kind == CYLINDER || kind == CONE) && rmap_reader_bool(reader, node, "closed", &closed) &&
        closed)
        rmap_reader_add_caps(reader, &shape, entry);
}

static void read_named(struct rmap_reader *reader, const struct rmap_yaml_item *item)
{
    const struct rmap_yaml_node place = {.line = item->line, .column = item->column};
    struct rmap_geometry_entry *entry =
        RMAP_READER_NEW(reader, reader->entry, reader->n_entry, reader->cap_entry);
    if (!entry)
        return;
    *entry = (struct rmap_geometry_entry){.name = item->key, .broken = true, .geometry = -1};
    rmap_reader_add_name(reader, &reader->geometries, item->key, 0, (int32_t)(reader->n_entry - 1),
                         item->line);
    if (item->value->kind == RMAP_YAML_MAP)
        read_geometry(reader, item->key, item->value, entry);
    else
        rmap_reader_error(reader, &place, "geometry '%.60s' must be a mapping", item->key);
}

void rmap_reader_read_geometries(struct rmap_reader *reader)
{
    rmap_reader_each_named(reader, "geometries", "geometry", &reader->geometries, read_named);
}
