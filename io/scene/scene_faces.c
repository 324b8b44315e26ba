/* SPDX-License-Identifier: MIT
 *
 * Faces of a mesh, and objects whose faces differ.
 */
#include "io/scene/scene_faces.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/glob.h"
#include "geometry/mesh_part.h"
#include "io/scene/scene_attributes.h"
#include "io/scene/scene_geometries.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_objects.h"
#include "io/scene/scene_surfaces.h"

enum { NAME_NBYTES = 256, BY_FACE_MAX = 1000 };

/* ---- which ones ---- */

/* "3" or "3..5"; false: neither. */
static bool parse_range(const char *text, unsigned long *low, unsigned long *high)
{
    char *end;
    if (*text < '0' || *text > '9')
        return false;
    *low = *high = strtoul(text, &end, 10);
    if (strncmp(end, "..", 2) == 0 && end[2] >= '0' && end[2] <= '9')
        *high = strtoul(end + 2, &end, 10);
    return *end == 0;
}

static size_t mark_range(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                         const struct rmap_mesh *mesh, bool quiet, uint8_t *face)
{
    unsigned long low = 0, high = 0;
    (void)parse_range(at->text, &low, &high);
    if (low <= high && high < mesh->n_face) {
        memset(face + low, 1, high - low + 1);
        return high - low + 1;
    }
    if (low > high)
        rmap_reader_error(reader, at, "the range %.40s runs backwards", at->text);
    else if (!quiet)
        rmap_reader_error(reader, at, "there is no face %lu: the mesh has 0 to %zu", high,
                          mesh->n_face - 1);
    return 0;
}

static size_t mark_word(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                        const struct rmap_mesh *mesh, bool quiet, uint8_t *face)
{
    unsigned long low, high;
    size_t n = 0;
    if (at->kind != RMAP_YAML_SCALAR) {
        rmap_reader_error(reader, at, "a face must be a number, a range such as 0..3, or a name");
        return 0;
    }
    if (!at->quoted && parse_range(at->text, &low, &high))
        return mark_range(reader, at, mesh, quiet, face);
    for (size_t i = 0; i < mesh->n_face; i++)
        if (rmap_glob(at->text, mesh->face_name[i] ? mesh->face_name[i] : "")) {
            face[i] = 1;
            n++;
        }
    if (!n && !quiet)
        rmap_reader_error(reader, at,
                          "the mesh has no face named '%.60s': its faces are 0 to %zu, and ranges "
                          "are written 0..%zu",
                          at->text, mesh->n_face - 1, mesh->n_face - 1);
    return n;
}

size_t rmap_reader_mark_faces(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                              const struct rmap_mesh *mesh, bool quiet, uint8_t *face)
{
    size_t n = 0;
    if (at->kind != RMAP_YAML_LIST)
        return mark_word(reader, at, mesh, quiet, face);
    if (at->n_item == 0)
        rmap_reader_error(reader, at, "'faces' names none");
    for (size_t i = 0; i < at->n_item; i++)
        n += mark_word(reader, at->item[i].value, mesh, quiet, face);
    return n;
}

/* ---- objects whose faces differ ---- */

const struct rmap_mapping rmap_face_keys = {
    "faces",
    NULL,
    {{"faces of an object", "faces name surface front back inside outside color omit"}}};

/* The part of a mesh that an earlier object has already, or a new one: -1 when memory is short. */
static int32_t part_of(struct rmap_reader *reader, int32_t geometry, const uint8_t *face,
                       const char *name)
{
    const struct rmap_mesh *mesh = reader->scene->geometry[geometry].mesh;
    for (size_t i = 0; i < reader->n_mesh_part; i++)
        if (reader->mesh_part[i].of == geometry &&
            memcmp(reader->mesh_part[i].face, face, mesh->n_face) == 0)
            return reader->mesh_part[i].geometry;
    struct rmap_mesh *part = NULL;
    char full[2 * NAME_NBYTES];
    (void)snprintf(full, sizeof full, "%.255s.%.255s", reader->scene->geometry[geometry].name,
                   name);
    uint8_t *own = rmap_reader_alloc(reader, mesh->n_face, 1);
    struct rmap_mesh_part *made =
        own ? RMAP_READER_NEW(reader, reader->mesh_part, reader->n_mesh_part, reader->cap_mesh_part)
            : NULL;
    if (!made)
        return -1;
    memcpy(own, face, mesh->n_face);
    *made = (struct rmap_mesh_part){.of = geometry, .geometry = -1, .face = own};
    const enum rmap_status st = rmap_mesh_part(mesh, face, &part, &reader->failure);
    if (st == RMAP_OK)
        rmap_reader_add_mesh(reader, full, part, &made->geometry);
    else
        rmap_reader_fail(reader, st);
    return made->geometry;
}

static void add_part(struct rmap_reader *reader, const struct rmap_object_plan *plan, int32_t group,
                     const char *name, const uint8_t *face)
{
    struct rmap_object_plan part = *plan;
    char full[2 * NAME_NBYTES];
    part.geometry = part_of(reader, plan->geometry, face, name);
    if (part.geometry < 0)
        return;
    (void)snprintf(full, sizeof full, "%.255s.%.255s", plan->name, name);
    part.name = full;
    part.derived = true;
    part.parent = group;
    part.placement = NULL;
    rmap_reader_add_object(reader, &part);
}

/* What an item of `faces` is called: by its name, by the one face that it names, by its number. */
static const char *name_of(struct rmap_reader *reader, const struct rmap_yaml_node *item, size_t i,
                           char number[24])
{
    const struct rmap_yaml_node *faces = rmap_yaml_get(item, "faces");
    unsigned long low, high;
    if (rmap_yaml_get(item, "name"))
        return rmap_reader_name(reader, item);
    if (faces && faces->kind == RMAP_YAML_LIST && faces->n_item == 1)
        faces = faces->item[0].value;
    const bool word = faces && faces->kind == RMAP_YAML_SCALAR && faces->text[0] &&
                      !strpbrk(faces->text, "*?'\" ") && !parse_range(faces->text, &low, &high);
    (void)snprintf(number, 24, "%zu", i + 1);
    return word ? faces->text : number;
}

/* owner: [n_face] 1 + item that a face is of, the last one that names it; 0: the rest. */
static void settle_owners(struct rmap_reader *reader, const char *name,
                          const struct rmap_yaml_node *list, const struct rmap_mesh *mesh,
                          uint8_t *mark, size_t *owner)
{
    for (size_t i = 0; i < list->n_item; i++) {
        const struct rmap_yaml_node *item = list->item[i].value;
        const struct rmap_yaml_node *faces = rmap_yaml_get(item, "faces");
        struct rmap_attribute_rule *rule = rmap_reader_rule_of(reader, item);
        if (!rmap_reader_known(reader, item, &rmap_face_keys, 0))
            continue;
        if (!faces) {
            rmap_reader_error(reader, item,
                              "'faces' is missing: the numbers or names of the faces");
            continue;
        }
        memset(mark, 0, mesh->n_face);
        const size_t n = rmap_reader_mark_faces(reader, faces, mesh, rule != NULL, mark);
        if (rule) {
            rule->n_fit += n;
            rule->n_face = mesh->n_face;
            (void)snprintf(rule->body, sizeof rule->body, "%s", name);
        }
        for (size_t f = 0; f < mesh->n_face; f++)
            owner[f] = mark[f] ? i + 1 : owner[f];
    }
}

static size_t mark_of(const size_t *owner, size_t n_face, size_t i, uint8_t *mark)
{
    size_t n = 0;
    for (size_t f = 0; f < n_face; f++) {
        mark[f] = owner[f] == i;
        n += mark[f];
    }
    return n;
}

static void add_item(struct rmap_reader *reader, const struct rmap_yaml_node *item,
                     const struct rmap_object_plan *plan, int32_t group, size_t i,
                     const uint8_t *mark)
{
    struct rmap_object_plan part = *plan;
    char number[24];
    bool omit = false;
    const char *name = name_of(reader, item, i, number);
    (void)rmap_reader_bool(reader, item, "omit", &omit);
    if (omit)
        return;
    part.node = item;
    rmap_reader_surface_pair(reader, item, "surface", &part.surface_front, &part.surface_back);
    rmap_reader_sides(reader, item, &part);
    add_part(reader, &part, group, name, mark);
}

/* Its name in the mesh file, where no other face has it, or its number. */
static const char *face_name(const struct rmap_mesh *mesh, size_t face, char number[32])
{
    const char *name = mesh->face_name[face];
    bool own = name && name[0] && !strpbrk(name, "*?'\" ") && strcmp(name, "body") != 0;
    for (size_t f = 0; f < mesh->n_face && own; f++)
        own = f == face || !mesh->face_name[f] || strcmp(mesh->face_name[f], name) != 0;
    (void)snprintf(number, 32, "face_%zu", face);
    return own ? name : number;
}

static void add_each(struct rmap_reader *reader, const struct rmap_object_plan *plan, int32_t group,
                     const size_t *owner, uint8_t *mark)
{
    const struct rmap_mesh *mesh = reader->scene->geometry[plan->geometry].mesh;
    char number[32];
    for (size_t f = 0; f < mesh->n_face; f++) {
        if (owner[f] != 0)
            continue;
        memset(mark, 0, mesh->n_face);
        mark[f] = 1;
        add_part(reader, plan, group, face_name(mesh, f, number), mark);
    }
}

void rmap_reader_expand_faces(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                              const struct rmap_object_plan *plan)
{
    const struct rmap_yaml_node *list = rmap_yaml_get(node, "faces");
    const struct rmap_mesh *mesh = reader->scene->geometry[plan->geometry].mesh;
    int32_t group = -1;
    bool by_face = false;
    (void)rmap_reader_bool(reader, node, "by_face", &by_face);
    if (!mesh || mesh->n_face == 0 || (list && !rmap_reader_check_list(reader, list, "'faces'"))) {
        if (!mesh || mesh->n_face == 0)
            rmap_reader_error(reader, list ? list : node, "'%s' is of an object that is a mesh",
                              list ? "faces" : "by_face");
        rmap_reader_add_member(reader, plan->name, RMAP_MEMBER_OBJECT, -1, node);
        return;
    }
    uint8_t *mark = rmap_alloc(mesh->n_face, 1);
    size_t *owner = rmap_alloc(mesh->n_face, sizeof *owner);
    if (!mark || !owner) {
        rmap_reader_no_memory(reader);
    } else {
        if (list)
            settle_owners(reader, plan->name, list, mesh, mark, owner);
        by_face &= mesh->n_face > 1;
        if (by_face && mesh->n_face > BY_FACE_MAX) {
            rmap_reader_warn(reader, node, "'%.60s' has %zu faces: beyond %d they are one object",
                             plan->name, mesh->n_face, BY_FACE_MAX);
            by_face = false;
        }
        if (!by_face && mark_of(owner, mesh->n_face, 0, mark) ==
                            mesh->n_face) { /* of rules, none of which fits */
            rmap_reader_add_object(reader, plan);
        } else {
            rmap_reader_add_group(reader, plan->name, node, plan->parent, &plan->to_world,
                                  plan->placement, plan->derived, &group);
            for (size_t i = 1; list && i <= list->n_item; i++)
                if (mark_of(owner, mesh->n_face, i, mark))
                    add_item(reader, list->item[i - 1].value, plan, group, i - 1, mark);
            if (by_face)
                add_each(reader, plan, group, owner, mark);
            else if (mark_of(owner, mesh->n_face, 0, mark))
                add_part(reader, plan, group, "body", mark);
        }
    }
    rmap_free(mark);
    rmap_free(owner);
}
