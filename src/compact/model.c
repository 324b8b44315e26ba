/* SPDX-License-Identifier: MIT
 *
 * A scene as the predictions need it, and one ray traced again along a known path.
 */
#include "compact/model.h"

#include "base/alloc.h"
#include "compact/batch_guide.h"
#include "geometry/shape_solve.h"
#include "portion/event.h"
#include "portion/portion_recorder.h"
#include "trace/source.h"
#include "trace/turbid.h"

/* A map that keeps lengths, so that normals stay unit vectors. */
static bool keeps_lengths(const struct rmap_affine *a)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double dot =
                a->m[0][i] * a->m[0][j] + a->m[1][i] * a->m[1][j] + a->m[2][i] * a->m[2][j];
            if (fabs(dot - (i == j)) > 1e-12)
                return false;
        }
    return true;
}

static void set_shape(struct rmap_compact_object *object, const struct rmap_shape *shape)
{
    struct rmap_bounded_quadric *q = &object->quadric;
    object->shape = shape;
    object->kind = RMAP_FACING_QUADRIC;
    *q = (struct rmap_bounded_quadric){.form = rmap_quadric_of(shape),
                                       .inner2 = -HUGE_VAL,
                                       .outer2 = HUGE_VAL,
                                       .low = -HUGE_VAL,
                                       .high = HUGE_VAL,
                                       .sign = 1.0,
                                       .rigid = object->rigid};
    switch (shape->type) {
    case RMAP_SHAPE_DISC:
    case RMAP_SHAPE_RECTANGLE:
        object->kind = RMAP_FACING_FLAT;
        break;
    case RMAP_SHAPE_CONIC:
        q->inner2 = shape->inner * shape->inner;
        q->outer2 = shape->aperture * shape->aperture;
        q->sheet = (1 + shape->conic) * shape->curvature;
        q->sign = -1.0;
        if (shape->n_asphere > 0)
            object->kind = RMAP_FACING_ASPHERE;
        break;
    case RMAP_SHAPE_TUBE:
        q->low = 0.0;
        q->high = shape->length;
        break;
    case RMAP_SHAPE_SPHERE:
        break;
    case RMAP_SHAPE_SAG:
        object->kind = RMAP_FACING_SAG;
        break;
    case RMAP_SHAPE_WALL:
        object->kind = RMAP_FACING_WALL;
        break;
    }
}

/* The event that this side of a surface leads to most often, ABSORB aside, which ends a ray. */
static uint32_t usual_event(const struct rmap_scene *scene, const struct rmap_surface *surface)
{
    const struct rmap_scatter *its = rmap_surface_scatter(scene, surface, false);
    double p[4] = {0, 0, 0, 0};
    static const uint32_t event[4] = {RMAP_EVENT_REFLECT_SPECULAR, RMAP_EVENT_REFLECT_DIFFUSE,
                                      RMAP_EVENT_TRANSMIT_SPECULAR, RMAP_EVENT_TRANSMIT_DIFFUSE};
    switch (surface->type) {
    case RMAP_SURFACE_FRESNEL:
        return RMAP_EVENT_TRANSMIT_SPECULAR;
    case RMAP_SURFACE_LAMBERT:
        return RMAP_EVENT_REFLECT_DIFFUSE;
    case RMAP_SURFACE_MIRROR:
        return RMAP_EVENT_REFLECT_SPECULAR;
    case RMAP_SURFACE_ABSORBER:
        return RMAP_EVENT_ABSORB;
    case RMAP_SURFACE_SCATTER:
        if (rmap_surface_scatters(surface))
            return its && its->model != RMAP_SCATTER_CONTAMINATION ? RMAP_EVENT_REFLECT_DIFFUSE
                                                                   : RMAP_EVENT_TRANSMIT_DIFFUSE;
        break;
    case RMAP_SURFACE_MIXTURE:
        break;
    }
    p[0] = surface->reflect_specular[0];
    p[1] = surface->reflect_diffuse[0];
    p[2] = surface->transmit_specular[0];
    p[3] = surface->transmit_diffuse[0];
    int best = 0;
    for (int i = 1; i < 4; i++)
        if (p[i] > p[best])
            best = i;
    return event[best];
}

static void set_object(const struct rmap_scene *scene, const struct rmap_object *from,
                       struct rmap_compact_object *object)
{
    const struct rmap_geometry *geometry = &scene->geometry[from->geometry];
    object->to_local = from->to_local;
    object->to_world = from->to_world;
    object->rigid = keeps_lengths(&from->to_world);
    object->front = &scene->surface[from->surface_front];
    object->back = &scene->surface[from->surface_back];
    if (geometry->kind == RMAP_GEOMETRY_MESH) {
        object->kind = RMAP_FACING_MESH;
        object->mesh = geometry->mesh;
    } else {
        set_shape(object, &geometry->shape);
    }
}

/* Triangles take so many bytes at most; those of larger scenes are followed one by one. */
#define CORNERS_NBYTES ((size_t)512 << 20)
#define LINE           16 /* floats */

/* Copies the corners of a geometry's triangles to `to`; how many there are. */
static size_t lay_out(const struct rmap_mesh *mesh, float *to)
{
    for (size_t i = 0; i < mesh->n_triangle; i++, to += LINE)
        for (size_t k = 0; k < 3; k++)
            memcpy(to + 4 * k, mesh->vertex[mesh->triangle[i][k]], 3 * sizeof *to);
    return mesh->n_triangle;
}

/* Corners of all triangles, so that each is one read. */
static enum rmap_status set_corners(struct rmap_compact_model *model, struct rmap_error *err)
{
    const struct rmap_scene *scene = model->scene;
    size_t n = 0;
    for (size_t g = 0; g < scene->n_geometry; g++)
        if (scene->geometry[g].kind == RMAP_GEOMETRY_MESH)
            n += scene->geometry[g].mesh->n_triangle;
    if (n == 0 || n > CORNERS_NBYTES / (LINE * sizeof(float)))
        return RMAP_OK;
    model->corner = rmap_alloc((n + 1) * LINE, sizeof(float));
    if (!model->corner)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the triangles of a scene");
    size_t skip = (size_t)(-(uintptr_t)model->corner % (LINE * sizeof(float))) / sizeof(float);
    float *next = model->corner + skip;
    for (size_t g = 0; g < scene->n_geometry; g++) {
        if (scene->geometry[g].kind != RMAP_GEOMETRY_MESH)
            continue;
        for (size_t i = 0; i < scene->n_object; i++)
            if (scene->object[i].geometry == (int32_t)g)
                model->object[i].corner = (const float(*)[LINE])next;
        next += LINE * lay_out(scene->geometry[g].mesh, next);
    }
    return RMAP_OK;
}

static void set_body(const struct rmap_scene *scene, const struct rmap_object *from,
                     struct rmap_compact_body *body)
{
    const struct rmap_geometry *geometry = &scene->geometry[from->geometry];
    body->medium_front = from->medium_front;
    body->medium_back = from->medium_back;
    body->expected = usual_event(scene, &scene->surface[from->surface_front]);
    if (body->expected == RMAP_EVENT_ABSORB)
        body->expected = usual_event(scene, &scene->surface[from->surface_back]);
    body->mesh = geometry->kind == RMAP_GEOMETRY_MESH;
    bool closed = body->mesh || rmap_shape_model[geometry->shape.type].closed;
    body->inside =
        closed && body->medium_back != body->medium_front ? body->medium_back : INT32_MIN;
}

static void set_source(const struct rmap_compact_model *model, const struct rmap_source *from,
                       struct rmap_compact_source *source)
{
    source->axis = rmap_normalize(rmap_affine_vector(&from->frame, rmap_vec3(0.0, 0.0, 1.0)));
    rmap_basis(source->axis, &source->tangent[0], &source->tangent[1]);
    source->cone = rmap_source_cone(from);
    rmap_colour_quantise(from->colour, model->n_channel, source->colour);
}

static void set_media(struct rmap_compact_model *model)
{
    double *index = model->index;
    const struct rmap_medium *medium = model->scene->medium;
    for (int c = 0; c < model->n_channel; c++) {
        for (size_t i = 0; i < model->n_medium; i++)
            *index++ = medium[i].n[c];
        *index++ = 1.0;
    }
    double *group = model->group;
    bool alike = true;
    for (int c = 0; c < model->n_channel && group; c++) {
        for (size_t i = 0; i < model->n_medium; i++) {
            alike = alike && medium[i].n_group[c] == medium[i].n[c];
            *group++ = medium[i].n_group[c];
        }
        *group++ = 1.0;
    }
    if (alike) { /* as in RGB */
        rmap_free(model->group);
        model->group = NULL;
    }
    for (size_t i = 0; i < model->n_medium; i++)
        model->tint[i] = medium[i].dispersive || rmap_medium_participates(&medium[i])
                             ? RMAP_BATCH_TINTS << 8
                             : 0;
}

/* Is the channel that refracts known, wherever it matters? */
static bool names_channels(const struct rmap_scene *scene)
{
    const struct rmap_channels *channels = &scene->channels;
    bool dispersive = false;
    for (size_t i = 0; i < scene->n_medium; i++)
        dispersive = dispersive || scene->medium[i].dispersive;
    for (size_t i = 0; i < scene->n_scatter; i++) /* its channel is drawn, too */
        dispersive = dispersive || scene->scatter[i].by_wavelength;
    for (int i = 0; i < channels->n && dispersive; i++)
        for (int k = 0; k < i; k++)
            if (channels->wavelength_nm[k] == channels->wavelength_nm[i])
                return false;
    return !dispersive || channels->mode == RMAP_COLOUR_SPECTRAL;
}

enum rmap_status rmap_compact_model_begin(const struct rmap_scene *scene,
                                          struct rmap_compact_model **model_ret,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_compact_model *model = rmap_alloc(1, sizeof *model);
    if (!model)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    model->scene = scene;
    model->n_channel = scene->channels.n;
    model->n_object = scene->n_object;
    model->n_source = scene->n_source;
    model->n_medium = scene->n_medium;
    model->n_detector = scene->n_detector;
    model->epsilon = 1e-12 * scene->radius;
    model->predicts = names_channels(scene);
    model->predicted = (struct rmap_predicted){.weighed = scene->n_scatter > 0,
                                               .metals = rmap_scene_has_rough_metals(scene),
                                               .films = rmap_scene_has_tinting_films(scene),
                                               .turbid = rmap_scene_is_turbid(scene)};
    for (size_t i = 0; i < scene->n_medium; i++)
        model->participating = model->participating || rmap_medium_participates(&scene->medium[i]);
    model->object = rmap_alloc(scene->n_object + 1, sizeof *model->object);
    model->body = rmap_alloc(scene->n_object + 1, sizeof *model->body);
    model->listed = rmap_alloc(scene->n_object + 1, sizeof *model->listed);
    model->guide = rmap_alloc(scene->n_object + 1, sizeof *model->guide);
    model->source = rmap_alloc(scene->n_source + 1, sizeof *model->source);
    model->source_colour =
        rmap_alloc((scene->n_source + 1) * (size_t)model->n_channel, sizeof *model->source_colour);
    model->index =
        rmap_alloc((scene->n_medium + 1) * (size_t)model->n_channel, sizeof *model->index);
    if (scene->timed)
        model->group =
            rmap_alloc((scene->n_medium + 1) * (size_t)model->n_channel, sizeof *model->group);
    model->tint = rmap_alloc(scene->n_medium + 1, sizeof *model->tint);
    if (!model->object || !model->body || !model->listed || !model->guide || !model->source ||
        !model->source_colour || !model->index || !model->tint || (scene->timed && !model->group))
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene"));
    set_media(model);
    for (size_t i = 0; i < scene->n_object; i++) {
        set_object(scene, &scene->object[i], &model->object[i]);
        set_body(scene, &scene->object[i], &model->body[i]);
        model->meshes = model->meshes || model->body[i].mesh;
        model->listed[i] = model->body[i].mesh ? UINT32_MAX : 0;
    }
    model->body[scene->n_object] = (struct rmap_compact_body){-1, -1, 0, INT32_MIN, false};
    for (size_t i = 0; i < scene->n_source; i++) {
        model->source[i].colour = model->source_colour + i * (size_t)model->n_channel;
        set_source(model, &scene->source[i], &model->source[i]);
    }
    *model_ret = model;
    model = NULL;
out:
    rmap_compact_model_destroy(model);
    return st;
}

enum rmap_status rmap_compact_model_complete(struct rmap_compact_model *model,
                                             struct rmap_error *err)
{
    const struct rmap_scene *scene = model->scene;
    if (model->is_complete)
        return RMAP_OK;
    const enum rmap_status st = set_corners(model, err);
    if (st != RMAP_OK)
        return st;
    for (size_t i = 0; i < scene->n_object; i++) {
        rmap_batch_set_flat(&model->object[i]);
        rmap_batch_guide(scene, &model->object[i], &model->guide[i]);
    }
    rmap_batch_guide_out(model, &model->guide[scene->n_object]);
    model->is_complete = true;
    return RMAP_OK;
}

enum rmap_status rmap_compact_model_create(const struct rmap_scene *scene,
                                           struct rmap_compact_model **model_ret,
                                           struct rmap_error *err)
{
    struct rmap_compact_model *model = NULL;
    enum rmap_status st = rmap_compact_model_begin(scene, &model, err);
    if (st == RMAP_OK)
        st = rmap_compact_model_complete(model, err);
    if (st == RMAP_OK)
        *model_ret = model;
    else
        rmap_compact_model_destroy(model);
    return st;
}

void rmap_compact_model_destroy(struct rmap_compact_model *model)
{
    if (!model)
        return;
    rmap_free(model->object);
    rmap_free(model->body);
    rmap_free(model->listed);
    rmap_free(model->guide);
    rmap_free(model->source);
    rmap_free(model->source_colour);
    rmap_free(model->index);
    rmap_free(model->group);
    rmap_free(model->tint);
    rmap_free(model->corner);
    rmap_free(model);
}

void rmap_path_media(const struct rmap_compact_model *model, int32_t source, const int32_t *object,
                     const uint32_t *event, size_t n, int16_t *medium)
{
    int32_t now = rmap_first_medium(model, source);
    for (size_t i = 0; i < n; i++) {
        medium[i] = (int16_t)now;
        now = rmap_next_medium(model, now, object[i], event[i]);
    }
}
