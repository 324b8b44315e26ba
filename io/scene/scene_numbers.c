/* SPDX-License-Identifier: MIT
 *
 * The numbers of a scene as they were when a map was written: `/model/K` of the index, K the
 * colour space.
 */
#include "io/scene/scene_numbers.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/count.h"
#include "io/hdf5/h5_read.h"
#include "io/hdf5/h5_write.h"
#include "io/scene/sag_numbers.h"

/* width 0: one number per channel. */
#define NUMBER(group, type, member, element, width, text)                                          \
    {                                                                                              \
        group "/" #member, RMAP_##element, width, offsetof(struct type, member), text              \
    }

static const struct rmap_h5_field object_field[] = {
    NUMBER("object", rmap_object, geometry, I32, 1, "row of /name/geometry"),
    NUMBER("object", rmap_object, to_world, F64, 12, "rows of the 3 x 3 matrix, then translation"),
    NUMBER("object", rmap_object, to_local, F64, 12, "inverse of to_world"),
    NUMBER("object", rmap_object, surface_front, I32, 1, "row of /name/surface"),
    NUMBER("object", rmap_object, surface_back, I32, 1, "row of /name/surface"),
    NUMBER("object", rmap_object, medium_front, I32, 1, "row of /name/medium; -1: any"),
    NUMBER("object", rmap_object, medium_back, I32, 1, "row of /name/medium; -1: any"),
};

static const struct rmap_h5_field geometry_field[] = {
    NUMBER("geometry", rmap_geometry, kind, I32, 1, "0 analytic shape, 1 mesh"),
    NUMBER("geometry", rmap_geometry, shape.type, I32, 1,
           "0 conic, 1 disc, 2 rectangle, 3 tube, 4 sphere, 5 sag, 6 wall"),
    NUMBER("geometry", rmap_geometry, shape.curvature, F64, 1, "conic: 1 / radius"),
    NUMBER("geometry", rmap_geometry, shape.conic, F64, 1, "conic: constant k"),
    NUMBER("geometry", rmap_geometry, shape.asphere, F64, RMAP_ASPHERE_MAX,
           "conic: coefficients of r^2, r^4, ..."),
    NUMBER("geometry", rmap_geometry, shape.n_asphere, I32, 1, "coefficients in use"),
    NUMBER("geometry", rmap_geometry, shape.aperture, F64, 1, "conic, disc: outer radius"),
    NUMBER("geometry", rmap_geometry, shape.inner, F64, 1, "conic, disc: radius of the hole"),
    NUMBER("geometry", rmap_geometry, shape.size, F64, 2, "rectangle: full widths"),
    NUMBER("geometry", rmap_geometry, shape.radius, F64, 1, "tube at z = 0, sphere"),
    NUMBER("geometry", rmap_geometry, shape.radius2, F64, 1, "tube at z = length"),
    NUMBER("geometry", rmap_geometry, shape.length, F64, 1, "tube"),
};

static const struct rmap_h5_field surface_field[] = {
    NUMBER("surface", rmap_surface, type, I32, 1,
           "0 fresnel, 1 mirror, 2 lambert, 3 absorber, 4 mixture, 5 scatter"),
    NUMBER("surface", rmap_surface, coat, I32, 1, "0 none, 1 reflectance, 2 ideal, 3 film"),
    NUMBER("surface", rmap_surface, is_metal, U8, 1, "1: a mirror with metal_n and metal_k"),
    NUMBER("surface", rmap_surface, reflect_specular, F64, 0, "share per channel"),
    NUMBER("surface", rmap_surface, reflect_diffuse, F64, 0, "share per channel"),
    NUMBER("surface", rmap_surface, transmit_specular, F64, 0, "share per channel"),
    NUMBER("surface", rmap_surface, transmit_diffuse, F64, 0, "share per channel"),
    NUMBER("surface", rmap_surface, metal_n, F64, 0, "index per channel"),
    NUMBER("surface", rmap_surface, metal_k, F64, 0, "index per channel"),
};

#define SHAPE(k)                                                                                   \
    {                                                                                              \
        "scatter/shape_" #k, RMAP_F64, 0, offsetof(struct rmap_scatter, shape[k]),                 \
            "parameter of its shape, per channel"                                                  \
    }
/* ", 0 lambert, 1 gaussian, ..." */
static const char models[] =
#define ROW(number, symbol, name, keys, reciprocal) ", " #number " " name
    RMAP_SCATTER_TABLE(ROW);
#undef ROW
static const struct rmap_h5_field scatter_field[] = {
    NUMBER("scatter", rmap_scatter, model, I32, 1, &models[2]),
    NUMBER("scatter", rmap_scatter, of_reflected, I32, 1,
           "row of /name/surface whose reflected light it scatters; -1: none"),
    NUMBER("scatter", rmap_scatter, of_transmitted, I32, 1,
           "row of /name/surface whose transmitted light it scatters; -1: none"),
    NUMBER("scatter", rmap_scatter, amount, F64, 0, "BSDF over shape, per channel"),
    SHAPE(0),
    SHAPE(1),
    SHAPE(2),
    SHAPE(3),
};

static const struct rmap_h5_field medium_field[] = {
    NUMBER("medium", rmap_medium, n, F64, 0, "refractive index per channel"),
    NUMBER("medium", rmap_medium, absorption, F64, 0, "per length unit and channel"),
    NUMBER("medium", rmap_medium, dispersive, U8, 1, "1: n differs between channels"),
    NUMBER("medium", rmap_medium, absorbing, U8, 1, "1: some absorption"),
};

static const struct rmap_h5_field times_field[] = {
    NUMBER("times", rmap_medium, n_group, F64, 0, "group index per channel"),
};

static const struct rmap_h5_field turbid_field[] = {
    NUMBER("turbid", rmap_medium, scattering, F64, 0, "per length unit and channel"),
    NUMBER("turbid", rmap_medium, scattering_g, F64, 1, "mean cosine (Henyey and Greenstein)"),
};

static const struct rmap_h5_field source_field[] = {
    NUMBER("source", rmap_source, type, I32, 1,
           "0 collimated, 1 point, 2 area, 3 list of rays, 4 lamp, 5 volume, 6 sky, 7 sun, "
           "8 Gaussian beam, 9 steps of particles"),
    NUMBER("source", rmap_source, shape, I32, 1,
           "0 point, 1 disc, 2 rectangle, 3 mesh, 4 lamp's opening, 5 from outside"),
    NUMBER("source", rmap_source, shape_size, F64, 2,
           "disc: radius; rectangle: full widths; from outside: radius of the sphere about the "
           "frame's origin that is lit; beam: waist, Rayleigh length"),
    NUMBER("source", rmap_source, shape_geometry, I32, 1, "mesh: row of /name/geometry"),
    NUMBER("source", rmap_source, frame, F64, 12, "rows of the 3 x 3 matrix, then translation"),
    NUMBER(
        "source", rmap_source, distribution, I32, 1,
        "0 isotropic, 1 cone, 2 cosine, 3 table, 4 lamp, 5 sky, 6 by sine, 7 steps of particles"),
    NUMBER("source", rmap_source, cone_rad, F64, 1,
           "half opening of a cone; beam: distance of its waist"),
    NUMBER("source", rmap_source, cosine_power, F64, 1, "power of the cosine"),
    NUMBER("source", rmap_source, colour, F64, 0, "share of the flux per channel"),
    NUMBER("source", rmap_source, medium, I32, 1, "row of /name/medium"),
    NUMBER("source", rmap_source, n_list, U64, 1, "rows in /list"),
};

static const struct rmap_h5_field detector_field[] = {
    NUMBER("detector", rmap_detector, type, I32, 1, "0 plane, 1 intensity"),
    NUMBER("detector", rmap_detector, origin, F64, 3, "centre"),
    NUMBER("detector", rmap_detector, x, F64, 3, "unit vector"),
    NUMBER("detector", rmap_detector, y, F64, 3, "unit vector"),
    NUMBER("detector", rmap_detector, axis, F64, 3, "unit vector towards the light"),
    NUMBER("detector", rmap_detector, size, F64, 2, "full widths"),
    NUMBER("detector", rmap_detector, cells, U32, 2, "along x, along y"),
    NUMBER("detector", rmap_detector, on_object, I32, 1, "lies on this object; -1: none"),
    NUMBER("detector", rmap_detector, on_group, I32, 1, "lies on this group; -1: none"),
};

static const struct rmap_h5_field sphere_field[] = {
    NUMBER("sphere", rmap_scene, centre, F64, 3, "of the scene's bounding sphere"),
    NUMBER("sphere", rmap_scene, radius, F64, 1, "of the scene's bounding sphere"),
};

static const struct rmap_h5_field list_field[] = {
    NUMBER("list", rmap_list_ray, origin, F64, 3, "rays of list sources, source after source"),
    NUMBER("list", rmap_list_ray, direction, F64, 3, "unit vector"),
    NUMBER("list", rmap_list_ray, channel, I32, 1, "of its wavelength; -1: the source's colour"),
};

struct number {
    double value;
};
static const struct rmap_h5_field cdf_field[] = {
    {"triangle_cdf/value", RMAP_F64, 1, offsetof(struct number, value),
     "mesh sources, source after source: area of the triangles up to each / all"}};

struct kept_step {
    int32_t source;
    struct rmap_track_step step;
    double photons[RMAP_PHOTON_KINDS];
};
#define STEP(member, element, width, text)                                                         \
    {                                                                                              \
        "step/" #member, RMAP_##element, width, offsetof(struct kept_step, step.member), text      \
    }
static const struct rmap_h5_field step_field[] = {
    NUMBER("step", kept_step, source, I32, 1, "row of /name/source"),
    STEP(position, F64, 3, "steps of charged particles, source after source: where each begins"),
    STEP(direction, F64, 3, "unit vector"),
    STEP(length, F64, 1, "of its path"),
    STEP(energy_mev, F64, 1, "MeV left in the medium"),
    STEP(time_ns, F64, 1, "ns, at its beginning"),
    STEP(charge, F64, 1, "in elementary charges"),
    STEP(beta, F64, 1, "speed over that of light in vacuum"),
    STEP(event, U64, 1, "number of its event"),
    NUMBER("step", kept_step, photons, F64, RMAP_PHOTON_KINDS,
           "photons up to and with its scintillation, and its Cherenkov light"),
};

struct kept_scintillation {
    int32_t medium;
    double share[RMAP_CHANNEL_MAX];
};
static const struct rmap_h5_field scintillation_field[] = {
    NUMBER("scintillation", kept_scintillation, medium, I32, 1, "row of /name/medium"),
    NUMBER("scintillation", kept_scintillation, share, F64, 0, "of its photons, per channel"),
};

struct kept_knot {
    int32_t source;
    struct rmap_profile_knot knot;
};
static const struct rmap_h5_field profile_field[] = {
    NUMBER("profile", kept_knot, source, I32, 1, "row of /name/source"),
    {"profile/one_minus_cos", RMAP_F64, 1, offsetof(struct kept_knot, knot.one_minus_cos),
     "knots of intensity tables, source after source: 1 - cos of the angle"},
    {"profile/intensity", RMAP_F64, 1, offsetof(struct kept_knot, knot.intensity),
     "of unit flux, 1/sr"},
    {"profile/below", RMAP_F64, 1, offsetof(struct kept_knot, knot.below),
     "share of the flux at smaller angles"},
};

struct kept_portal {
    int32_t source;
    struct rmap_sky_portal portal;
};
static const struct rmap_h5_field portal_field[] = {
    NUMBER("portal", kept_portal, source, I32, 1, "row of /name/source"),
    {"portal/centre", RMAP_F64, 3, offsetof(struct kept_portal, portal.centre),
     "of an opening that a sky is seen through"},
    {"portal/sides", RMAP_F64, 6, offsetof(struct kept_portal, portal.side), "its edges"},
};

static const struct rmap_h5_field film_field[] = {
    NUMBER("film", rmap_thin_film_layer, n, F64, 1,
           "index of the layers of films: film after film, channel after channel"),
    NUMBER("film", rmap_thin_film_layer, k, F64, 1, "their extinction coefficient"),
    NUMBER("film", rmap_thin_film_layer, thickness, F64, 1,
           "in wavelengths of the channel in vacuum"),
};

struct turn {
    int32_t source;
    uint64_t rank;
};
static const struct rmap_h5_field turn_field[] = {
    {"schedule/source", RMAP_I32, 1, offsetof(struct turn, source),
     "source of ray id k: row k modulo the number of rows"},
    {"schedule/rank", RMAP_U64, 1, offsetof(struct turn, rank),
     "earlier rows with the same source"}};

_Static_assert(sizeof(enum rmap_surface_type) == 4 && sizeof(bool) == 1, "as in the file");
_Static_assert(sizeof(struct rmap_affine) == 12 * sizeof(double), "matrix, then translation");

/* One group of /model/K: an array of structs of the scene, or of copies. */
struct table {
    const char *name;
    const struct rmap_h5_field *field;
    size_t n_field;
    void *row;
    size_t n, row_nbytes;
    bool optional; /* not in maps where it has no rows */
    bool late;     /* nor in those of earlier programs, which are read with the scene's own */
};

enum { N_TABLE = 19, FIELD_MAX = RMAP_KEPT_SAG_FIELDS, PATH_NBYTES = 64 };

/* Lists of all sources one after the other. */
struct copies {
    struct rmap_list_ray *list;
    struct number *cdf;
    struct kept_knot *knot;
    struct turn *turn;
    struct rmap_thin_film_layer *layer;
    struct kept_step *step;
    struct kept_scintillation *scintillation;
    size_t n_list, n_cdf, n_knot, n_layer, n_step, n_scintillation, n_portal, n_sag;
    struct kept_portal *portal;
    struct rmap_kept_sag *sag;
};

static size_t n_triangle_of(const struct rmap_scene *scene, const struct rmap_source *source)
{
    return source->triangle_cdf ? scene->geometry[source->shape_geometry].mesh->n_triangle : 0;
}

static size_t n_step_of(const struct rmap_source *source)
{
    return source->steps ? source->steps->n : 0;
}

static size_t n_layer_of(const struct rmap_scene *scene, const struct rmap_thin_film *film)
{
    return (size_t)scene->channels.n * film->n_layer;
}

static void copies_fini(struct copies *copies)
{
    rmap_free(copies->list);
    rmap_free(copies->cdf);
    rmap_free(copies->knot);
    rmap_free(copies->turn);
    rmap_free(copies->layer);
    rmap_free(copies->step);
    rmap_free(copies->scintillation);
    rmap_free(copies->portal);
    rmap_free(copies->sag);
}

/* Into the copies, or back into the scene. */
static void copy_steps(struct rmap_scene *scene, const struct copies *copies, bool back)
{
    size_t row = 0;
    for (size_t s = 0; s < scene->n_source; s++)
        for (size_t k = 0; k < n_step_of(&scene->source[s]); k++) {
            struct rmap_steps *steps = scene->source[s].steps;
            struct kept_step *kept = &copies->step[row++];
            double *photons = &steps->photons[k * RMAP_PHOTON_KINDS];
            if (back) {
                steps->step[k] = kept->step;
                memcpy(photons, kept->photons, sizeof kept->photons);
            } else {
                kept->source = (int32_t)s;
                kept->step = steps->step[k];
                memcpy(kept->photons, photons, sizeof kept->photons);
            }
        }
    row = 0;
    for (size_t m = 0; m < scene->n_medium; m++) {
        struct rmap_scintillation *light = scene->medium[m].scintillation;
        struct kept_scintillation *kept = &copies->scintillation[row];
        if (!light)
            continue;
        row++;
        if (back) {
            memcpy(light->share, kept->share, sizeof kept->share);
        } else {
            kept->medium = (int32_t)m;
            memcpy(kept->share, light->share, sizeof kept->share);
        }
    }
}

static enum rmap_status copies_init(const struct rmap_scene *scene, struct copies *copies,
                                    struct rmap_error *err)
{
    *copies = (struct copies){0};
    for (size_t s = 0; s < scene->n_source; s++) {
        copies->n_list += scene->source[s].n_list;
        copies->n_cdf += n_triangle_of(scene, &scene->source[s]);
        copies->n_knot += scene->source[s].profile.n;
        copies->n_step += n_step_of(&scene->source[s]);
        copies->n_portal += scene->source[s].sky ? scene->source[s].sky->n_portal : 0;
    }
    for (size_t m = 0; m < scene->n_medium; m++)
        copies->n_scintillation += scene->medium[m].scintillation != NULL;
    for (size_t f = 0; f < scene->n_film; f++)
        copies->n_layer += n_layer_of(scene, &scene->film[f]);
    copies->n_sag = rmap_kept_sag_count(scene);
    copies->sag = rmap_alloc(copies->n_sag, sizeof *copies->sag);
    copies->layer = rmap_alloc(copies->n_layer, sizeof *copies->layer);
    copies->portal = rmap_alloc(copies->n_portal, sizeof *copies->portal);
    copies->list = rmap_alloc(copies->n_list, sizeof *copies->list);
    copies->cdf = rmap_alloc(copies->n_cdf, sizeof *copies->cdf);
    copies->knot = rmap_alloc(copies->n_knot, sizeof *copies->knot);
    copies->step = rmap_alloc(copies->n_step, sizeof *copies->step);
    copies->scintillation = rmap_alloc(copies->n_scintillation, sizeof *copies->scintillation);
    copies->turn = rmap_alloc(scene->schedule_len, sizeof *copies->turn);
    if (!copies->list || !copies->cdf || !copies->knot || !copies->turn || !copies->layer ||
        !copies->step || !copies->scintillation || !copies->portal || !copies->sag) {
        copies_fini(copies);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the scene's numbers");
    }
    copy_steps((struct rmap_scene *)(uintptr_t)scene, copies, false);
    rmap_kept_sag_copy(scene, copies->sag);
    size_t list = 0, cdf = 0, knot = 0, layer = 0, portal = 0;
    for (size_t f = 0; f < scene->n_film; f++) {
        const size_t n = n_layer_of(scene, &scene->film[f]);
        if (n > 0)
            memcpy(copies->layer + layer, scene->film[f].layer, n * sizeof *copies->layer);
        layer += n;
    }
    for (size_t s = 0; s < scene->n_source; s++) {
        const struct rmap_source *source = &scene->source[s];
        size_t n_triangle = n_triangle_of(scene, source);
        if (source->n_list > 0)
            memcpy(copies->list + list, source->list, source->n_list * sizeof *source->list);
        if (n_triangle > 0)
            memcpy(copies->cdf + cdf, source->triangle_cdf, n_triangle * sizeof *copies->cdf);
        for (size_t k = 0; k < source->profile.n; k++)
            copies->knot[knot++] = (struct kept_knot){(int32_t)s, source->profile.knot[k]};
        for (size_t k = 0; source->sky && k < source->sky->n_portal; k++)
            copies->portal[portal++] = (struct kept_portal){(int32_t)s, source->sky->portal[k]};
        list += source->n_list;
        cdf += n_triangle;
    }
    for (size_t k = 0; k < scene->schedule_len; k++)
        copies->turn[k] = (struct turn){scene->schedule[k], scene->schedule_rank[k]};
    return RMAP_OK;
}

static void copies_back(const struct copies *copies, struct rmap_scene *scene)
{
    copy_steps(scene, copies, true);
    size_t list = 0, cdf = 0, knot = 0, layer = 0, portal = 0;
    for (size_t f = 0; f < scene->n_film; f++) {
        const size_t n = n_layer_of(scene, &scene->film[f]);
        if (n > 0)
            memcpy(scene->film[f].layer, copies->layer + layer, n * sizeof *copies->layer);
        layer += n;
    }
    for (size_t s = 0; s < scene->n_source; s++) {
        struct rmap_source *source = &scene->source[s];
        size_t n_triangle = n_triangle_of(scene, source);
        if (source->n_list > 0)
            memcpy(source->list, copies->list + list, source->n_list * sizeof *source->list);
        if (n_triangle > 0)
            memcpy(source->triangle_cdf, copies->cdf + cdf, n_triangle * sizeof *copies->cdf);
        for (size_t k = 0; k < source->profile.n; k++)
            source->profile.knot[k] = copies->knot[knot++].knot;
        for (size_t k = 0; source->sky && k < source->sky->n_portal; k++)
            source->sky->portal[k] = copies->portal[portal++].portal;
        if (source->sky)
            (void)rmap_sky_gather(source);
        list += source->n_list;
        cdf += n_triangle;
    }
    for (size_t k = 0; k < scene->n_scatter; k++)
        rmap_scatter_derive(&scene->scatter[k], scene->channels.n);
}

/* The scene is changed through the tables by rmap_scene_numbers_read alone, whose own it is. */
static void list_tables(struct rmap_scene *scene, const struct copies *copies,
                        struct table table[N_TABLE])
{
#define ROWS(name, row, n)                                                                         \
    {                                                                                              \
#name, name##_field, RMAP_COUNT(name##_field), row, n, sizeof *(row)                       \
    }
    const struct table all[N_TABLE] = {
        ROWS(object, scene->object, scene->n_object),
        ROWS(geometry, scene->geometry, scene->n_geometry),
        ROWS(surface, scene->surface, scene->n_surface),
        ROWS(medium, scene->medium, scene->n_medium),
        ROWS(source, scene->source, scene->n_source),
        ROWS(detector, scene->detector, scene->n_detector),
        ROWS(sphere, scene, 1),
        ROWS(list, copies->list, copies->n_list),
        {"triangle_cdf", cdf_field, 1, copies->cdf, copies->n_cdf, sizeof *copies->cdf},
        {"schedule", turn_field, 2, copies->turn, scene->schedule_len, sizeof *copies->turn},
        {"profile", profile_field, RMAP_COUNT(profile_field), copies->knot, copies->n_knot,
         sizeof *copies->knot, .optional = true},
        {"times", times_field, RMAP_COUNT(times_field), scene->medium,
         scene->timed ? scene->n_medium : 0, sizeof *scene->medium, .optional = true, .late = true},
        {"turbid", turbid_field, RMAP_COUNT(turbid_field), scene->medium,
         rmap_scene_is_turbid(scene) ? scene->n_medium : 0, sizeof *scene->medium, .optional = true,
         .late = true},
        {"film", film_field, RMAP_COUNT(film_field), copies->layer, copies->n_layer,
         sizeof *copies->layer, .optional = true},
        {"scatter", scatter_field, RMAP_COUNT(scatter_field), scene->scatter, scene->n_scatter,
         sizeof *scene->scatter, .optional = true},
        {"step", step_field, RMAP_COUNT(step_field), copies->step, copies->n_step,
         sizeof *copies->step, .optional = true},
        {"scintillation", scintillation_field, RMAP_COUNT(scintillation_field),
         copies->scintillation, copies->n_scintillation, sizeof *copies->scintillation,
         .optional = true},
        {"portal", portal_field, RMAP_COUNT(portal_field), copies->portal, copies->n_portal,
         sizeof *copies->portal, .optional = true},
        {"sag", rmap_kept_sag_field, RMAP_KEPT_SAG_FIELDS, copies->sag, copies->n_sag,
         sizeof *copies->sag, .optional = true, .late = true},
    };
#undef ROWS
    memcpy(table, all, sizeof all);
}

/* Paths and widths of a table's fields in this map. */
struct fields {
    struct rmap_h5_field field[FIELD_MAX];
    char path[FIELD_MAX][PATH_NBYTES];
    char group[PATH_NBYTES];
};

static void name_fields(const struct table *table, size_t space, int n_channel,
                        struct fields *fields)
{
    (void)snprintf(fields->group, PATH_NBYTES, "/model/%zu/%s", space, table->name);
    for (size_t f = 0; f < table->n_field; f++) {
        fields->field[f] = table->field[f];
        (void)snprintf(fields->path[f], PATH_NBYTES, "/model/%zu/%s", space, table->field[f].path);
        fields->field[f].path = fields->path[f];
        if (fields->field[f].width == 0)
            fields->field[f].width = (size_t)n_channel;
    }
}

enum rmap_status rmap_scene_numbers_write(struct rmap_h5 *h5, const struct rmap_scene *scene,
                                          size_t space, struct rmap_error *err)
{
    struct table table[N_TABLE];
    struct copies copies;
    struct fields fields;
    enum rmap_status st = copies_init(scene, &copies, err);
    if (st != RMAP_OK)
        return st;
    list_tables((struct rmap_scene *)(uintptr_t)scene, &copies, table);
    (void)snprintf(fields.group, PATH_NBYTES, "/model/%zu", space);
    RMAP_TRY(rmap_h5_group(h5, fields.group, err));
    for (size_t k = 0; k < N_TABLE; k++) {
        if (table[k].optional && table[k].n == 0)
            continue;
        name_fields(&table[k], space, scene->channels.n, &fields);
        RMAP_TRY(rmap_h5_group(h5, fields.group, err));
        RMAP_TRY(rmap_h5_write_fields(h5, fields.field, table[k].n_field, table[k].row, table[k].n,
                                      table[k].row_nbytes, err));
    }
out:
    copies_fini(&copies);
    return st;
}

/* Doubles are taken over; everything else must be what the scene has. */
static bool take_field(const struct rmap_h5_field *field, const char *from, char *to)
{
    size_t nbytes = field->width * rmap_element_nbytes(field->element);
    if (field->element != RMAP_F64)
        return memcmp(from + field->offset, to + field->offset, nbytes) == 0;
    for (size_t i = 0; i < field->width; i++) {
        double value;
        memcpy(&value, from + field->offset + i * sizeof value, sizeof value);
        if (!isfinite(value))
            return false;
    }
    memcpy(to + field->offset, from + field->offset, nbytes);
    return true;
}

static enum rmap_status read_table(struct rmap_h5 *h5, const struct table *table,
                                   const struct fields *fields, struct rmap_error *err)
{
    void *row = NULL;
    size_t n = 0;
    enum rmap_status st =
        rmap_h5_read_fields(h5, fields->field, table->n_field, table->row_nbytes, &row, &n, err);
    if (st != RMAP_OK)
        return st;
    bool fits = n == table->n;
    for (size_t i = 0; fits && i < n; i++)
        for (size_t f = 0; fits && f < table->n_field; f++)
            fits = take_field(&fields->field[f], (char *)row + i * table->row_nbytes,
                              (char *)table->row + i * table->row_nbytes);
    rmap_free(row);
    return fits ? RMAP_OK
                : rmap_error_set(err, RMAP_FORMAT, "%s: %s does not fit the scene inside", h5->path,
                                 fields->group);
}

enum rmap_status rmap_scene_numbers_read(struct rmap_h5 *h5, struct rmap_scene *scene, size_t space,
                                         struct rmap_error *err)
{
    struct table table[N_TABLE];
    struct copies copies;
    struct fields fields;
    enum rmap_status st = copies_init(scene, &copies, err);
    if (st != RMAP_OK)
        return st;
    list_tables(scene, &copies, table);
    for (size_t k = 0; k < N_TABLE; k++) {
        if (table[k].optional && table[k].n == 0)
            continue;
        name_fields(&table[k], space, scene->channels.n, &fields);
        if (table[k].late && !rmap_h5_has(h5, fields.group))
            continue;
        RMAP_TRY(read_table(h5, &table[k], &fields, err));
    }
    copies_back(&copies, scene);
    const char *wrong = rmap_kept_sag_back(copies.sag, scene);
    if (wrong)
        st = rmap_error_set(err, RMAP_FORMAT, "%s: /model/%zu/sag: %s", h5->path, space, wrong);
out:
    copies_fini(&copies);
    return st;
}

static bool same_table(const struct table *a, const struct table *b, int n_channel)
{
    bool same = a->n == b->n;
    for (size_t f = 0; same && f < a->n_field; f++) {
        const struct rmap_h5_field *field = &a->field[f];
        size_t width = field->width ? field->width : (size_t)n_channel;
        for (size_t i = 0; same && i < a->n; i++)
            same = memcmp((const char *)a->row + i * a->row_nbytes + field->offset,
                          (const char *)b->row + i * b->row_nbytes + field->offset,
                          width * rmap_element_nbytes(field->element)) == 0;
    }
    return same;
}

enum rmap_status rmap_scene_numbers_same(const struct rmap_scene *a, const struct rmap_scene *b,
                                         bool *same_ret, struct rmap_error *err)
{
    struct table table_a[N_TABLE], table_b[N_TABLE];
    struct copies of_a, of_b;
    enum rmap_status st = copies_init(a, &of_a, err);
    if (st != RMAP_OK)
        return st;
    st = copies_init(b, &of_b, err);
    if (st != RMAP_OK)
        goto out;
    list_tables((struct rmap_scene *)(uintptr_t)a, &of_a, table_a);
    list_tables((struct rmap_scene *)(uintptr_t)b, &of_b, table_b);
    *same_ret = a->channels.n == b->channels.n;
    for (size_t k = 0; k < N_TABLE; k++)
        *same_ret = *same_ret && same_table(&table_a[k], &table_b[k], a->channels.n);
    copies_fini(&of_b);
out:
    copies_fini(&of_a);
    return st;
}
