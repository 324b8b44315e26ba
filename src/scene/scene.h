/* SPDX-License-Identifier: MIT
 *
 * A scene as the tracer sees it: resolved, checked, plain data. Names are for people; indices
 * are for the code. Everything spectral is evaluated on the scene's channels when it is built,
 * so that the ray loop looks up numbers only.
 *
 * Units: lengths in the scene's unit, wavelengths in nm, absorption per length unit, angles in
 * radians. World frame unless said otherwise.
 */
#ifndef RMAP_SCENE_H
#define RMAP_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "base/unit.h"
#include "base/vec.h"
#include "geometry/mesh.h"
#include "geometry/shape.h"
#include "gradient/gradient.h"
#include "optics/spectrum.h"
#include "scene/file_rays.h"
#include "scene/lamp.h"
#include "scene/phase.h"
#include "scene/profile.h"
#include "scene/ray_names.h"
#include "scene/reading.h"
#include "scene/response.h"
#include "scene/sky.h"
#include "scene/species.h"
#include "scene/steps.h"
#include "scene/surface_model.h"
#include "scene/volume.h"

struct rmap_medium {
    char *name;
    double n[RMAP_CHANNEL_MAX];          /* refractive index */
    double n_group[RMAP_CHANNEL_MAX];    /* n - wavelength dn/dwavelength; in RGB as n */
    double absorption[RMAP_CHANNEL_MAX]; /* per length unit, from k and from `absorption` */
    bool dispersive;                     /* n differs between channels */
    bool absorbing;                      /* any absorption > 0 */
    char *description;                   /* "N-BK7 (Sellmeier, ...)", for reports */
    struct rmap_field *field; /* a gradient medium's index, owned; NULL: uniform. n above is then
                                 the index at the origin of its frame, for reports */
    struct rmap_field *beside[2];        /* of a timed scene, a dispersive field a little beside the
                                            channels (RMAP_GRADIENT_BESIDE), owned; or NULL */
    struct rmap_curve_options curve;     /* as the scene file says; 0: not said */
    double scattering[RMAP_CHANNEL_MAX]; /* per length unit */
    double scattering_g; /* mean cosine of the phase function, of kind HENYEY; 0: isotropic */
    struct rmap_phase phase;
    size_t n_species;
    struct rmap_species *species; /* [n_species], owned; their absorption is part of the medium's */
    bool scattering_at_all;
    struct rmap_scintillation *scintillation; /* owned; NULL: none */
};

enum rmap_geometry_kind { RMAP_GEOMETRY_SHAPE, RMAP_GEOMETRY_MESH };

/* A unique geometry, in its own frame; shared by its instances. A prescription (`lens`) has
 * become one geometry per surface and edge. */
struct rmap_geometry {
    char *name;
    enum rmap_geometry_kind kind;
    struct rmap_shape shape; /* SHAPE; its sags owned by the scene */
    struct rmap_mesh *mesh;  /* MESH; owned by the scene */
};

/* Where something stands in its group, or in the world, as it was read: for who moves it. */
struct rmap_standing {
    bool as_group; /* `placement` does not count */
    struct rmap_affine placement;
};

#define RMAP_MEDIUM_ANY (-1) /* opaque side without a stated medium: matches every medium */

/* An instance of a geometry. front: the side to which the surface's normal points (local +z of
 * a cap, outward of closed bodies); back: the other. */
struct rmap_object {
    char *name;
    uint64_t id;    /* stable, unique: from the scene file, or the hash of the name */
    int32_t parent; /* group, or -1 */
    int32_t geometry;
    struct rmap_affine to_world, to_local;
    struct rmap_standing standing;
    int32_t surface_front, surface_back;
    int32_t medium_front, medium_back;     /* or RMAP_MEDIUM_ANY */
    int32_t medium_outside;                /* what is around it, or around the lens it is of */
    int32_t gradient_front, gradient_back; /* 1 + index of the gradient medium in place on that
                                              side; 0: uniform, or any */
    int32_t line, column;                  /* in the scene file */
    bool faceted; /* a Fresnel surface: flat, with the normals of its profile */
};

struct rmap_group {
    char *name;
    uint64_t id;
    int32_t parent; /* group, or -1; parents come before children */
    struct rmap_affine to_world;
    struct rmap_standing standing;
};

enum rmap_source_type {
    RMAP_SOURCE_COLLIMATED,
    RMAP_SOURCE_POINT,
    RMAP_SOURCE_AREA,
    RMAP_SOURCE_RAYS,
    RMAP_SOURCE_LAMP,
    RMAP_SOURCE_VOLUME, /* isotropic from `volume` */
    RMAP_SOURCE_SKY,    /* this and SUN: by `sky` */
    RMAP_SOURCE_SUN,
    RMAP_SOURCE_BEAM, /* TEM00 by skew rays: shape_size is the waist's radius (1/e^2) and the
                        Rayleigh length, cone_rad the distance of the waist along z */
    RMAP_SOURCE_STEPS
};

enum rmap_emitter {
    RMAP_EMITTER_POINT,
    RMAP_EMITTER_DISC,      /* shape_size[0]: radius */
    RMAP_EMITTER_RECTANGLE, /* shape_size: full widths along the frame's x and y */
    RMAP_EMITTER_MESH,      /* every triangle, emitting from its front side; of a LAMP from both */
    RMAP_EMITTER_BODY,      /* LAMP: the luminous opening, as large as `lamp` says */
    RMAP_EMITTER_SKY        /* shape_size[0]: radius of the sphere that its light comes into */
};

enum rmap_distribution {
    RMAP_DISTRIBUTION_ISOTROPIC,
    RMAP_DISTRIBUTION_CONE,   /* uniform in solid angle within cone_rad of the axis; POINT, and
                                 COLLIMATED, whose ISOTROPIC is one direction */
    RMAP_DISTRIBUTION_COSINE, /* intensity ~ cos(theta)^power */
    RMAP_DISTRIBUTION_TABLE,  /* POINT: intensity by `profile` */
    RMAP_DISTRIBUTION_LAMP,   /* LAMP; AREA: by `lamp` about its frame */
    RMAP_DISTRIBUTION_SKY,    /* SKY, SUN */
    RMAP_DISTRIBUTION_SINE,   /* AREA: as LAMBERT within the angle whose sine is `aperture` */
    RMAP_DISTRIBUTION_STEPS   /* STEPS */
};

struct rmap_list_ray {
    struct rmap_vec3 origin, direction; /* direction: unit */
    int32_t channel;                    /* of its wavelength; -1: the source's spectrum */
    double delay_ns;                    /* of a file's ray */
};

struct rmap_source {
    char *name;
    int32_t parent; /* group, or -1 */
    enum rmap_source_type type;
    enum rmap_emitter shape;
    double shape_size[2];
    int32_t shape_geometry;   /* MESH: a mesh geometry placed by `frame` */
    double *triangle_cdf;     /* MESH: [n_triangle], cumulative world area / total */
    struct rmap_affine frame; /* local z: the axis of emission */
    enum rmap_distribution distribution;
    double cone_rad, cosine_power, aperture;
    struct rmap_profile profile; /* TABLE; of a COLLIMATED disc the irradiance over the square of
                                    the distance to its middle, in place of 1 - cos */
    struct rmap_lamp *lamp;      /* LAMP, and where the distribution is; owned */
    struct rmap_steps *steps;    /* STEPS; owned */
    struct rmap_volume *volume;  /* VOLUME; owned */
    struct rmap_sky *sky;        /* SKY, SUN; owned */
    double flux;                 /* in the scene's flux_unit; STEPS: photons */
    double colour[RMAP_CHANNEL_MAX];
    bool fills;          /* an object, at which it was aimed when it was read */
    bool spectrum_given; /* the scene says how the flux is spread over the channels */
    double share;        /* rays_share, > 0 */
    int32_t medium;
    int32_t gradient;           /* 1 + index of the gradient medium in place; 0: uniform */
    struct rmap_list_ray *list; /* RAYS */
    size_t n_list;
    struct rmap_file_rays *rays; /* RAYS of a file, in its place; held */
    int32_t line, column;        /* in the scene file */
};

enum rmap_detector_type { RMAP_DETECTOR_PLANE, RMAP_DETECTOR_INTENSITY };
enum rmap_side { RMAP_SIDE_FRONT, RMAP_SIDE_BACK, RMAP_SIDE_BOTH };

/* What a plane sees as the opening of a camera that looks along `axis`, y being upwards in the
 * picture: a disc as wide as the plane. No ray knows of it. */
struct rmap_detector_camera {
    double radius; /* 0: no camera */
    double focus;  /* distance along the axis of the plane in focus; infinity: all parallel light */
    double slope[2]; /* half the picture's width and height at distance 1 */
    uint32_t pixels[2];
};

/* PLANE: size[0] x size[1] about `origin` along unit x and y; `axis` points to the light.
 * INTENSITY: theta in [0, pi] from `axis`, phi in [0, 2 pi) from x towards y; cells (theta, phi);
 * catches what leaves the scene. */
struct rmap_detector {
    char *name;
    enum rmap_detector_type type;
    struct rmap_vec3 origin, x, y, axis;
    double size[2]; /* INTENSITY: {pi, 2 pi} */
    uint32_t cells[2];
    enum rmap_side side;
    double max_angle_rad; /* from the normal of the side that the light meets */
    int32_t on_object;    /* object or -1; */
    int32_t on_group;     /* group or -1; both -1: free in space */
    struct rmap_detector_camera camera;
    uint8_t *face; /* [n_face] of its object's mesh: 1 where it registers; NULL: everywhere */
    struct rmap_response
        *response;               /* NULL: all that it registers counts alike; no ray knows of it */
    struct rmap_reading reading; /* of events (raymap events); no ray knows of it */
    int32_t line, column;        /* in the scene file */
};

enum rmap_camera_type { RMAP_CAMERA_PINHOLE, RMAP_CAMERA_THIN_LENS };

/* Looks from `at` along `forward`; right, up and forward are orthonormal. Light is not touched. */
struct rmap_camera {
    char *name;
    enum rmap_camera_type type;
    struct rmap_vec3 at, right, up, forward;
    double slope;           /* half the picture's height at distance 1; pixels are square */
    uint32_t resolution[2]; /* pixels to the right, and down */
    double focus;           /* THIN_LENS: distance along `forward` of the plane in focus */
    double aperture;        /* THIN_LENS: radius of the lens */
    double exposure;        /* what unit radiance is shown as, 1 being white; 0: not said */
    int32_t medium;
    int32_t gradient; /* 1 + index of the gradient medium in place; 0: uniform */
};

/* A named choice kept with the scene. Unset: rays 0, time_limit_s 0, names NULL. */
struct rmap_simulation {
    char *name;
    uint64_t rays;
    double time_limit_s;
    bool record; /* default true */
};

struct rmap_scene {
    char *unit;    /* "mm" */
    double unit_m; /* its length in metres */
    struct rmap_channels channels;
    enum rmap_flux_unit flux_unit; /* of every source's flux */
    enum rmap_accounting accounting;
    uint64_t limit_steps;
    double limit_weight;
    bool totals_on_demand; /* of scatter models: none are tabulated, since no ray is traced */
    bool timed; /* rays have group paths and delays: the run was asked for them (`time: on`) */

    size_t n_gradient;
    struct rmap_gradient *gradient; /* gradient media in place */

    size_t n_medium, n_film, n_scatter, n_surface, n_geometry, n_object, n_group, n_source,
        n_detector;
    struct rmap_medium *medium;
    struct rmap_thin_film *film;
    struct rmap_scatter *scatter;
    struct rmap_surface *surface;
    struct rmap_geometry *geometry;
    struct rmap_object *object;
    struct rmap_group *group;
    struct rmap_source *source;
    struct rmap_detector *detector;
    struct rmap_simulation simulation; /* the one chosen, or unset */

    /* For pictures alone: no ray of a map knows of them. */
    size_t n_camera;
    struct rmap_camera *camera;
    double background[RMAP_CHANNEL_MAX]; /* radiance from outside the scene: flux unit / (m2 sr) */

    const struct rmap_ray_names *ray_names; /* borrowed of the map that it comes from, or NULL */
    uint64_t seed;                          /* of that map: of draws at detectors */
    bool is_mixed;                          /* that map has other colour spaces, too */

    /* Borrowed by rmap_scene_finish, of bounds that are not worked out again; or NULL: */
    const struct rmap_scene *before; /* objects that stand there with the same mesh */
    const double *known_box; /* [n_object][6]: lower and upper, of meshes without true surfaces */

    /* Derived by rmap_scene_finish. */
    bool fluoresces; /* some medium has species: a ray has one wavelength from its beginning */
    double worth[RMAP_CHANNEL_MAX]; /* of a photon on the channel, in any unit */
    struct rmap_vec3 centre; /* of the scene's bounding sphere: objects, sources, detectors */
    double radius;
    struct rmap_bounds *object_bounds; /* [n_object] in the world */
    int32_t *schedule; /* [schedule_len]: source of ray id k is schedule[k mod schedule_len] */
    uint64_t *schedule_rank; /* [schedule_len]: how many earlier entries have the same source */
    size_t schedule_len;
    uint64_t *schedule_quota; /* [n_source]: entries of each source */
    int32_t *free_detector;   /* [n_free_detector]: planes free in space, by index */
    size_t n_free_detector;
    int32_t *far_detector; /* [n_far_detector]: intensity grids, by index */
    size_t n_far_detector;
    int32_t *on_detector; /* detectors lying on object o: [on_first[o], on_first[o+1]) */
    size_t *on_first;     /* [n_object + 1] */
};

/* What a source owns. */
void rmap_source_fini(struct rmap_source *source);

/* An empty scene with defaults (mm, limits 10,000 steps, no channels). */
enum rmap_status rmap_scene_create(struct rmap_scene **scene_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;
void rmap_scene_destroy(struct rmap_scene *scene); /* owns all it points to; NULL is fine */

/* Half the diagonal of the box about all objects, at most: Embree's boxes are float, and areas are
 * products of their sides. Sources and detectors may lie as far away as stored positions go. */
#define RMAP_OBJECTS_RADIUS_MAX 1e15
#define RMAP_SCENE_REACH_MAX    1e37

/* Fills the derived part once everything else stands: inverse transforms, bounding sphere,
 * schedule, lists of detectors, area tables, photons of steps, parts of bodies. RMAP_INPUT for a
 * singular transform, a scene that reaches to infinity or too far to be traced or stored, steps
 * that make no light, a body that is not there; RMAP_SYSTEM when memory is short.
 *
 * A finished scene may be edited and finished again: places, surfaces and media of objects, shapes,
 * surfaces, sources, detectors, and how many there are. Where a gradient medium lives is not told
 * by an object that moves: its `to_world` is to be moved with it; nor what a sky is about: its
 * sphere, and rmap_sky_gather. */
enum rmap_status rmap_scene_finish(struct rmap_scene *scene, struct rmap_error *err) RMAP_MUST_USE;

/* Rays' weights change on their way: light is given back at other wavelengths, and its energy is
 * counted. */
static inline bool rmap_scene_changes_weights(const struct rmap_scene *scene)
{
    return scene->fluoresces && scene->accounting == RMAP_ACCOUNTING_ENERGY;
}

/* A ray of several channels has one from its beginning: where light is given back at other
 * wavelengths, or its time of arrival is asked for. */
static inline bool rmap_scene_draws_wavelength(const struct rmap_scene *scene)
{
    return scene->fluoresces || (scene->timed && scene->channels.mode == RMAP_COLOUR_SPECTRAL);
}

/* Some medium scatters, or gives light back. */
bool rmap_scene_is_turbid(const struct rmap_scene *scene);

/* Do faces of its meshes lie on surfaces? */
bool rmap_scene_has_surfaces(const struct rmap_scene *scene);

/* Meshes with texture coordinates. */
bool rmap_scene_has_uv(const struct rmap_scene *scene);

/* Has gradient media: its rays may be curved. */
bool rmap_scene_is_curved(const struct rmap_scene *scene);

/* Its maps have /curve: it is curved, or timed, as time's columns come behind those of curves. */
bool rmap_scene_keeps_curves(const struct rmap_scene *scene);

/* Widens the bounding sphere of a finished scene to hold a camera and its lens: light that starts
 * there is inside the scene. Before the scene's rmap_accel is made. */
void rmap_scene_include(struct rmap_scene *scene, const struct rmap_camera *camera);

/* How an object's front is drawn. */
static inline enum rmap_look rmap_object_look(const struct rmap_scene *scene, size_t object)
{
    return rmap_surface_look(&scene->surface[scene->object[object].surface_front]);
}

/* The scatter model of reflected or of transmitted light; NULL: none. */
static inline const struct rmap_scatter *rmap_surface_scatter(const struct rmap_scene *scene,
                                                              const struct rmap_surface *surface,
                                                              bool passes)
{
    const int32_t row = passes ? surface->scatter_transmit : surface->scatter_reflect;
    return row > 0 ? &scene->scatter[row - 1] : NULL;
}

static inline bool rmap_surface_scatters(const struct rmap_surface *surface)
{
    return (surface->scatter_reflect | surface->scatter_transmit) > 0;
}

/* Are there metals, or boundaries, with scatter models, that several channels meet? Their shares
 * depend on the angle, maybe at a facet. */
bool rmap_scene_has_rough_metals(const struct rmap_scene *scene);

/* Are there films that several channels meet? */
bool rmap_scene_has_tinting_films(const struct rmap_scene *scene);

/* Sends rays that are somebody's, one by one, from no lamp. */
static inline bool rmap_source_is_of_rays(const struct rmap_source *source)
{
    return source->type == RMAP_SOURCE_RAYS || source->type == RMAP_SOURCE_STEPS ||
           source->type == RMAP_SOURCE_VOLUME;
}

/* An area whose light is not Lambert's. */
static inline bool rmap_source_is_directed(const struct rmap_source *source)
{
    return source->type == RMAP_SOURCE_AREA &&
           source->distribution != RMAP_DISTRIBUTION_ISOTROPIC &&
           (source->distribution != RMAP_DISTRIBUTION_COSINE || source->cosine_power != 1.0);
}

/* A collimated disc that is not as bright all over. */
static inline bool rmap_source_is_apodised(const struct rmap_source *source)
{
    return source->type == RMAP_SOURCE_COLLIMATED && source->profile.n > 0;
}

/* A point, disc or rectangle that shines in one direction, in all, evenly within a cone or by
 * Lambert's law. */
static inline bool rmap_source_is_simple(const struct rmap_source *source)
{
    if (source->shape == RMAP_EMITTER_MESH)
        return false;
    if (source->type == RMAP_SOURCE_AREA)
        return !rmap_source_is_directed(source);
    return (source->type == RMAP_SOURCE_COLLIMATED || source->type == RMAP_SOURCE_POINT) &&
           !rmap_source_is_apodised(source) &&
           (source->distribution == RMAP_DISTRIBUTION_ISOTROPIC ||
            source->distribution == RMAP_DISTRIBUTION_CONE);
}

/* Pictures do not know its light. */
static inline bool rmap_source_is_unseen(const struct rmap_source *source)
{
    return rmap_source_is_of_rays(source) || source->type == RMAP_SOURCE_BEAM ||
           rmap_source_is_directed(source) || rmap_source_is_apodised(source);
}

/* Where a source is named in pictures: its origin, its first ray, the middle of its body. */
struct rmap_vec3 rmap_source_place(const struct rmap_scene *scene,
                                   const struct rmap_source *source);

/* Of what sends light, about the origin of its frame; 0: a point, or a mesh. */
struct rmap_vec3 rmap_source_half_size(const struct rmap_source *source);

/* The scene says of which wavelengths its light is: its `spectrum`, or that of each listed ray. */
bool rmap_source_has_spectrum(const struct rmap_source *source);

/* A surface that may let light through, at some wavelength; false for -1. */
bool rmap_scene_transmits(const struct rmap_scene *scene, int32_t surface_index);

/* Axis-aligned bounds of a geometry in its own frame. */
void rmap_geometry_bounds(const struct rmap_geometry *geometry, struct rmap_vec3 *lower,
                          struct rmap_vec3 *upper);

/* True when a group (-1: none) is `outer` or lies below it in the tree. */
bool rmap_scene_group_within(const struct rmap_scene *scene, int32_t group, int32_t outer);

/* True when object `object` is `group` or lies below it in the tree. */
bool rmap_scene_in_group(const struct rmap_scene *scene, int32_t object, int32_t group);

/* True when a detector lies on something, and on this object: it then registers what arrives. */
static inline bool rmap_detector_lies_on(const struct rmap_detector *detector)
{
    return detector->on_object >= 0 || detector->on_group >= 0;
}
bool rmap_detector_lies_at(const struct rmap_scene *scene, const struct rmap_detector *detector,
                           size_t object);

/* What fills the space about the bodies, where a scene does not say: the medium 'air', else
 * 'vacuum', else that in front of most objects; -1: there is none. */
int32_t rmap_scene_surrounding_medium(const struct rmap_scene *scene);

/* The axis of the world (0 x, 1 y, 2 z) along which the x (axis 0) or y (1) of a plane lies; -1:
 * none. */
int rmap_detector_along(const struct rmap_detector *detector, int axis);
/* The detector's coordinate of one in the world along there. */
double rmap_detector_from_world(const struct rmap_detector *detector, int axis, double value);

/* "W", "lm", "photons/s", "photons", "J". */
const char *rmap_flux_unit_name(const struct rmap_scene *scene);

/* Source of a ray id, and its running number among that source's rays. */
int32_t rmap_scene_source_of(const struct rmap_scene *scene, uint64_t ray, uint64_t *ordinal_ret);

/* How many rays there are, of a scene whose rays are counted photons; 0: as many as are asked for.
 */
uint64_t rmap_scene_n_photon(const struct rmap_scene *scene);

/* What the light of a STEPS source is made in. */
struct rmap_steps_medium rmap_source_steps_medium(const struct rmap_scene *scene,
                                                  const struct rmap_source *source);

/* The step, and with it the event, that a ray of a STEPS source is of; NULL: of another source. */
const struct rmap_track_step *rmap_scene_track_step(const struct rmap_scene *scene, uint64_t seed,
                                                    uint64_t ray);

#endif
