/* SPDX-License-Identifier: MIT
 *
 * A scene as the predictions need it, and one ray traced again along a known path.
 */
#ifndef RMAP_COMPACT_MODEL_H
#define RMAP_COMPACT_MODEL_H

#include "compact/compact.h"
#include "compact/lane.h"
#include "formula/quadric.h"
#include "portion/event.h"
#include "trace/colour.h"

enum rmap_facing_kind {
    RMAP_FACING_FLAT,    /* z = 0 */
    RMAP_FACING_QUADRIC, /* alpha (x^2 + y^2) + gamma z^2 + 2 delta z + epsilon = 0 */
    RMAP_FACING_ASPHERE, /* that, and the polynomial of the shape on top */
    RMAP_FACING_SAG,     /* z = sag(x, y) */
    RMAP_FACING_WALL,    /* straight, over an outline */
    RMAP_FACING_MESH
};

struct rmap_compact_object {
    enum rmap_facing_kind kind;
    bool rigid; /* lengths are kept: the world normal needs no normalisation */
    struct rmap_bounded_quadric quadric; /* also of an ASPHERE */
    /* FLAT: normal in the world; 16 bits of each of its numbers as they are recorded. */
    double flat[4];
    struct rmap_affine to_local, to_world;
    const struct rmap_shape *shape;
    const struct rmap_mesh *mesh;
    const float (*corner)[16]; /* mesh: of each triangle, [3][4]; NULL: too many for memory */
    const struct rmap_surface *front, *back;
};

/* What paths need of an object, apart, so that all of them stay in the fastest cache. */
struct rmap_compact_body {
    int32_t medium_front, medium_back;
    uint32_t expected; /* event that is most likely here */
    int32_t inside;    /* medium in a closed body (mesh or sphere), if another is outside; else
                          INT32_MIN */
    bool mesh;
};

/* What batches need of it beforehand. */
#define RMAP_GUIDE_STEPS 14 /* event bits, and none of them */
struct rmap_compact_guide {
    const float *corner; /* of a triangle; of other objects, what is read first */
    size_t n_primitive;  /* of others, segments go alone */
    uint32_t grey[2];    /* events that leave any colour alone, at the back and at the front */
    uint8_t batch;       /* kind of its segments, as batch.h has them */
    bool scatters;       /* by a model, on some side */
    uint8_t stride;      /* floats from the corners of one triangle to those of the next */
    uint16_t quadric;    /* segments that start on it go so many queues farther on */
    uint16_t step[RMAP_GUIDE_STEPS]; /* of a segment with this one event: flags << 8 | queue */
};

/* The light of the ray in hand. */
struct rmap_compact_light {
    struct rmap_colour colour;
    double delay_ns;                      /* so far, where rays are followed one by one */
    bool changed;                         /* `quantised` is not up to date */
    uint16_t quantised[RMAP_CHANNEL_MAX]; /* [n_channel] */
};

struct rmap_compact_source {
    struct rmap_vec3 axis;       /* unit */
    double cone;                 /* CONE: 2 sin^2 of half the opening */
    struct rmap_vec3 tangent[2]; /* about the axis */
    uint16_t *colour;            /* [n_channel], quantised */
};

struct rmap_compact_model {
    const struct rmap_scene *scene;
    int n_channel;
    size_t n_object, n_source, n_medium, n_detector;
    struct rmap_compact_object *object; /* [n_object] */
    struct rmap_compact_body *body;     /* [n_object + 1]: the last is that of no object */
    uint32_t *listed;                   /* [n_object + 1]: all ones for a mesh, else 0 */
    struct rmap_compact_guide *guide;   /* [n_object + 1]: the last is that of no object */
    struct rmap_compact_source *source;
    uint16_t *source_colour;         /* [n_source][n_channel] */
    double epsilon;                  /* lengths below do not matter */
    bool participating;              /* some medium absorbs or scatters */
    struct rmap_predicted predicted; /* in portions that are written now */
    bool meshes;                     /* some object is one */
    bool is_complete;                /* corners, flat normals and guides are there */
    bool predicts;  /* rays that the tracer says are predicted: the last wavelength tells the
                        channel that refracts */
    double *index;  /* [n_channel][n_medium + 1]: the last is that of no medium */
    double *group;  /* the same of group indices, of a timed scene where they differ; else NULL */
    uint16_t *tint; /* [n_medium + 1]: flags << 8 of segments through it */
    float *corner;  /* of all triangles, each in a cache line of its own */
};

/* Where a segment ends on the surface that the path names. */
struct rmap_facing {
    double t;
    struct rmap_vec3 position, normal; /* world; unit normal, unflipped */
};

/* How a segment's event turns the ray. */
enum rmap_turn {
    RMAP_TURN_NONE,
    RMAP_TURN_REFLECT,
    RMAP_TURN_REFRACT,
    RMAP_TURN_DIFFUSE,
    RMAP_TURN_SCATTER /* as the surface's model has it */
};

struct rmap_departure {
    struct rmap_vec3 position, direction, normal;
    int32_t medium; /* of the source */
    int channel;    /* the list's ray has this one only; -1: the source's colour */
    double delay_ns;
};

/* A surface met: the light from before it to after it. */
struct rmap_encounter {
    const struct rmap_scene *scene;
    int32_t object;
    bool front;
    const struct rmap_surface *surface;
    const struct rmap_predicted *predicted;
    const struct rmap_medium *near, *far;
    double cosine; /* of incidence, in [0, 1]; at the facet, where that is predicted */
    uint32_t event;
    int channel; /* that the ray ends with; -1: several */
};

/* What a segment says of a registration on it. */
struct rmap_compact_segment {
    struct rmap_vec3 from, to, direction;
    double length, optical_from, index;
    double group_from, group_index;
    bool left; /* out of the scene */
};
struct rmap_crossing {
    uint16_t cell[2], relative[2];
    float direction[3];
    double optical_path, group_path;
};

/* How far rays are followed: whoever asks for registrations alone needs no more. */
enum rmap_reach {
    RMAP_REACH_END,
    RMAP_REACH_CROSSING, /* the end of the segment of the last registration */
    RMAP_REACH_DIRECTION /* its start, where its direction is known */
};

/* What rmap_retrace needs: columns that are known, and lanes to offer predictions to. */
struct rmap_retrace {
    const struct rmap_compact_model *model;
    uint64_t seed;
    size_t n_ray;
    const uint64_t *id;
    const int32_t *source;
    const uint8_t *stop;
    const uint32_t *segment_count, *registration_count;
    const int32_t *start_object;
    const uint8_t *channel;     /* 1 + channel at the end; 0: none */
    const uint8_t *passed_over; /* rays that are of no interest; NULL: none */
    const int32_t *object, *primitive;
    const uint32_t *event;
    const int16_t *medium;
    const uint32_t *crossing_segment; /* NULL: registrations are of no interest */
    const int32_t *crossing_detector;
    bool placed; /* places of registrations stand by themselves: nothing is predicted of them */
    struct rmap_predicted predicted; /* as the portion's header has it */
    bool colour; /* followed; or else colours and optical paths are of no interest, and no medium
                    absorbs */
    enum rmap_reach reach; /* of rays that go side by side */
    struct rmap_lane *lane;
};

/* Medium behind an object, for light that came in medium `now`, as far as the path says. Bits
 * instead of branches: whether it goes through is anybody's guess. */
static inline int32_t rmap_medium_after(const struct rmap_compact_body *body, int32_t now,
                                        uint32_t event)
{
    uint32_t from_front = (uint32_t)0 - (body->medium_front == now);
    uint32_t front = (uint32_t)body->medium_front, back = (uint32_t)body->medium_back;
    uint32_t far = front ^ ((front ^ back) & from_front);
    uint32_t through = event & (RMAP_EVENT_TRANSMIT_SPECULAR | RMAP_EVENT_TRANSMIT_DIFFUSE);
    uint32_t goes = (uint32_t)0 - ((through != 0) & (far <= INT32_MAX));
    return (int32_t)((uint32_t)now ^ (((uint32_t)now ^ far) & goes));
}

static inline int32_t rmap_next_medium(const struct rmap_compact_model *model, int32_t now,
                                       int32_t object, uint32_t event)
{
    bool known = object >= 0 && (size_t)object < model->n_object;
    return rmap_medium_after(&model->body[known ? (size_t)object : model->n_object], now, event);
}

static inline int32_t rmap_first_medium(const struct rmap_compact_model *model, int32_t source)
{
    bool known = source >= 0 && (size_t)source < model->n_source;
    return known ? model->scene->source[source].medium : 0;
}

/* 0 and the expected one change places; applied twice, nothing has happened. */
static inline uint32_t rmap_swap_expected(uint32_t object, uint32_t expected)
{
    return object == expected ? 0 : object == 0 ? expected : object;
}

/* Medium of each segment as the path says; media of a path with unknown parts are guesses too. */
void rmap_path_media(const struct rmap_compact_model *model, int32_t source, const int32_t *object,
                     const uint32_t *event, size_t n, int16_t *medium);

/* Medium beyond the side of a surface that light in medium `near` meets. */
static inline const struct rmap_medium *rmap_medium_beyond(const struct rmap_compact_model *model,
                                                           int32_t object, bool front,
                                                           const struct rmap_medium *near)
{
    const struct rmap_compact_body *body = &model->body[object];
    int32_t far = front ? body->medium_back : body->medium_front;
    return far >= 0 ? &model->scene->medium[far] : near;
}

/* What the primitive of a segment follows from. */
enum rmap_primitive_kind {
    RMAP_PRIMITIVE_NONE,  /* -1 */
    RMAP_PRIMITIVE_ZERO,  /* 0: an analytic surface, or an object that is not there */
    RMAP_PRIMITIVE_LISTED /* the next triangle */
};

static inline enum rmap_primitive_kind rmap_primitive_kind(const struct rmap_compact_model *model,
                                                           int32_t object)
{
    if (object < 0)
        return RMAP_PRIMITIVE_NONE;
    bool mesh = (size_t)object < model->n_object && model->body[object].mesh;
    return mesh ? RMAP_PRIMITIVE_LISTED : RMAP_PRIMITIVE_ZERO;
}

static inline int32_t rmap_primitive_plain(enum rmap_primitive_kind kind)
{
    return kind == RMAP_PRIMITIVE_NONE ? -1 : 0;
}

/* Of 1 + a channel; 0, or what is none of the scene: NaN. */
static inline double rmap_wavelength_of(const struct rmap_compact_model *model, uint8_t channel)
{
    bool known = channel > 0 && channel <= model->n_channel;
    return known ? model->scene->channels.wavelength_nm[channel - 1] : (double)NAN;
}

static inline uint32_t rmap_event_at_end(uint8_t stop)
{
    static const uint32_t at_end[4] = {RMAP_EVENT_ABSORB, RMAP_EVENT_LEFT, RMAP_EVENT_LIMIT,
                                       RMAP_EVENT_ERROR};
    return at_end[stop & 3];
}

/* What paths need; then, in place, what tracing needs besides (again: nothing happens), while
 * others may use it for paths. create: both. */
enum rmap_status rmap_compact_model_begin(const struct rmap_scene *scene,
                                          struct rmap_compact_model **model_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_compact_model_complete(struct rmap_compact_model *model,
                                             struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_compact_model_create(const struct rmap_scene *scene,
                                           struct rmap_compact_model **model_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;

void rmap_compact_model_destroy(struct rmap_compact_model *model);

#endif
