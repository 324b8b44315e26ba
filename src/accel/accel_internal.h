/* SPDX-License-Identifier: MIT
 *
 * What the files of the accelerator share: the built structure and the state of one query.
 */
#ifndef RMAP_ACCEL_INTERNAL_H
#define RMAP_ACCEL_INTERNAL_H

#include <embree3/rtcore.h>
#include <math.h>
#include <stdatomic.h>

#include "accel/accel.h"
#include "geometry/shape_rim.h"
#include "scene/scene.h"

/* Vectors as wide as the machine has them; what passes is decided in double all the same. */
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#define RMAP_WIDEST __attribute__((target_clones("avx2", "default")))
#else
#define RMAP_WIDEST
#endif

/* Rounding of one float operation. */
#define RMAP_FLOAT_EPS 0x1p-24

/* At grazing incidence distances along the ray blow up as 1 / cos; up to this factor only. */
#define RMAP_GRAZING_MAX 1e3

/* Needles, widened, would grow without end: at sines below this one they stay too short. */
#define RMAP_NEEDLE_SINE 1e-4

/* In units of the float error: how far behind its start a ray enters Embree, so that a surface
 * through the start is met down to grazing angles of a hundredth; and how far beyond the nearest
 * candidate others are looked for, whose own float distances are as wrong. */
#define RMAP_REACH_ERRORS 128
#define RMAP_SLACK_ERRORS 64

/* Between a ray's start at the sphere about a mesh's box and Embree's decision, in roundings of
 * the farthest coordinate, at most: 6 of the start and the direction, 12 of a triangle's edges, 8
 * of boxes. */
#define RMAP_LOCAL_ERRORS 32

/* A mesh as queries need it: the corners of each triangle side by side, to be had with one cache
 * miss, and the triangles that meet at each vertex: those of vertex v are fan[first[k]] ...
 * fan[first[k + 1] - 1] with k = same[v], the first vertex at its place. `sight`: a triangle's unit
 * normal, and the cosine of a ray to it above which Embree cannot miss it, since the float error
 * along its plane is less than its margin. */
struct rmap_cells; /* accel_cell.h */
struct rmap_facets {
    float (*corner)[9], (*sight)[4];
    uint32_t *same, *first, *fan;
    struct rmap_cells *cells; /* NULL: no face lies on a true surface */
};

/* Without the NaN rules of fmin and fmax, which make them calls. */
static inline double rmap_lesser(double a, double b)
{
    return a < b ? a : b;
}

static inline double rmap_greater(double a, double b)
{
    return a > b ? a : b;
}

/* Sine of the angle up to which normals count as parallel: float vertices turn the normals of
 * small triangles; triangles of one mesh share their vertices. */
#define RMAP_PARALLEL_OTHER 1e-4
#define RMAP_PARALLEL_OWN   1e-6

/* The rims of a shape of which some coincide with rims of other shapes. */
struct rmap_object_rims {
    struct rmap_rim rim[RMAP_RIM_MAX];
    int32_t joint[RMAP_RIM_MAX]; /* index of the joint; negative: none */
    double error[RMAP_RIM_MAX];  /* by which the rims of the joint differ, local */
    int n;
};

/* Rims that coincide, and the one of them that stands for all. */
struct rmap_joint {
    int32_t object, rim;
};

/* An object as the query needs it. Distances are in the world unless said otherwise. */
struct rmap_accel_object {
    struct rmap_affine to_local, to_world;
    const struct rmap_shape *shape; /* NULL: a mesh */
    const struct rmap_mesh *mesh;
    const struct rmap_facets *facets;
    const struct rmap_cells *cells;      /* of facets */
    const struct rmap_object_rims *rims; /* NULL: no other shape shares one */
    RTCScene bottom;
    bool ball;                     /* among the spheres: the prefilter does not hold it */
    struct rmap_vec3 lower, upper; /* local bounds */
    bool rigid;                    /* a rotation or mirror: lengths are kept */
    double tolerance;              /* surfaces this near to one another coincide */
    double exact;                  /* the same between triangles of one mesh: double rounding */
    double local_exact;            /* the same in its local frame */
    struct rmap_vec3 world_lower, world_upper; /* meshes: bounds */
    double local_error;      /* meshes: of Embree's float rays in the local frame, at most */
    struct rmap_vec3 middle; /* meshes: of the sphere about the local bounds */
    double half;             /* its radius */
    int side; /* shapes: of the clearance, 2 * axis + upper, that ends at this one; 6: none */
    int32_t medium_front, medium_back;
    const void *soon; /* what the tracer asks for first of an object that is hit */
};

/* One of the boxes that together cover an object. */
#define RMAP_PART_GONE (-1) /* in place of its number: it is among the moved ones */
struct rmap_accel_part {
    int32_t object, part;
};

/* Parts that one user geometry of Embree's is made of. */
struct rmap_accel_parts {
    const struct rmap_accel *accel;
    struct rmap_accel_part *part; /* [n], by primitive */
    size_t n;
};

/* Analytic surfaces eight at a time, as float cylinder shells in their own frames: a ray that
 * misses the shell misses the surface. Slots [0, n_row) have parallel frames and stand in a row, as
 * the surfaces of a lens do, by their lower ends; the others begin at the next group. */
#define RMAP_PREFILTER_WIDE  8
#define RMAP_PREFILTER_SLOTS 64
#define RMAP_PREFILTER_MAX   (RMAP_PREFILTER_SLOTS - RMAP_PREFILTER_WIDE + 1)
struct rmap_prefilter_group {
    float turn[3][3][RMAP_PREFILTER_WIDE];                            /* from Embree's world */
    float place_x[RMAP_PREFILTER_WIDE], place_y[RMAP_PREFILTER_WIDE]; /* of its origin */
    float low[RMAP_PREFILTER_WIDE], high[RMAP_PREFILTER_WIDE];      /* along the axis, from there */
    float inner2[RMAP_PREFILTER_WIDE], outer2[RMAP_PREFILTER_WIDE]; /* from the axis, squared */
    float half_x[RMAP_PREFILTER_WIDE], half_y[RMAP_PREFILTER_WIDE];
    float lowest, highest, highest_before; /* of a row: of this group; and of those before too */
};
struct rmap_prefilter {
    int n_row, n_slot;       /* n_slot 0: not in use */
    uint64_t row, others;    /* bits of slots in use */
    float longest, rounding; /* ray inside the scene, and the error of distances along it */
    int32_t object[RMAP_PREFILTER_SLOTS];
    bool flat[RMAP_PREFILTER_SLOTS];
    struct rmap_prefilter_group group[RMAP_PREFILTER_SLOTS / RMAP_PREFILTER_WIDE];
};

/* Spheres, about Embree's origin; squared radii. Unused ones have an outer2 below 0. */
struct rmap_spheres {
    int n; /* 0: not in use */
    float x[RMAP_PREFILTER_WIDE], y[RMAP_PREFILTER_WIDE], z[RMAP_PREFILTER_WIDE];
    float outer2[RMAP_PREFILTER_WIDE], inner2[RMAP_PREFILTER_WIDE];
    int32_t object[RMAP_PREFILTER_WIDE];
};

/* A box without shapes, about Embree's origin; and the same open to one side, for rays that start
 * there: begin[side], 2 * axis + upper, begin[6] to none. */
struct rmap_box3f {
    float lower[3], upper[3];
};
struct rmap_clearance {
    struct rmap_box3f box, begin[7];
};

struct rmap_accel_failure {
    atomic_flag taken;
    enum RTCError code;
    char text[256];
};

/* What structures share that share meshes. */
struct rmap_accel_device {
    RTCDevice embree;
    int level;
    int n_more; /* holders beside the first */
    struct rmap_accel_failure failure;
};

struct rmap_accel_box {
    struct rmap_vec3 lower, upper;
};

struct rmap_bottom; /* accel_bottom.h */

/* So many meshes of the top level may have left it before it is built anew. */
#define RMAP_MOVED_MAX 8

struct rmap_accel {
    struct rmap_accel_device *device;
    const struct rmap_scene *scene;
    RTCScene rest;                        /* what the prefilter does not hold; NULL: nothing */
    RTCScene whole;                       /* everything, for replays; NULL: not built */
    float rest_lower[3], rest_upper[3];   /* its bounds, wider than the float error */
    struct rmap_accel_parts moved;        /* meshes that have left their box in `rest` */
    float moved_lower[3][RMAP_MOVED_MAX]; /* their boxes, about Embree's origin; no number: none */
    float moved_upper[3][RMAP_MOVED_MAX];
    bool rest_apart;                 /* most of the scene is outside them */
    bool rest_inside;                /* they lie within those of the prefilter's shapes */
    struct rmap_clearance clearance; /* where they do */
    struct rmap_spheres spheres;
    struct rmap_prefilter prefilter;
    struct rmap_bottom **bottom; /* [n_bottom], by geometry; NULL for shapes */
    size_t n_bottom;
    struct rmap_accel_object *object; /* [n_object] */
    struct rmap_accel_box *box;       /* [n_object] in the world, as rmap_accel_bounds has them */
    size_t n_object;
    struct rmap_joint *joint; /* [n_joint] */
    size_t n_joint;
    struct rmap_object_rims *rims;          /* of the objects that have joints */
    struct rmap_accel_parts meshes, shapes; /* that callbacks serve */
    struct rmap_accel_box world;            /* about all objects, or more */
    struct rmap_vec3 centre;                /* origin of Embree's world */
    double radius;
    double error;  /* of float rays there */
    double reach;  /* how far behind its start a ray enters Embree */
    double behind; /* as in struct rmap_shape_query: beyond the slack that src/compact allows */
    struct rmap_accel_build build;
    void (*watch)(void *context, const struct rmap_ray *ray, double length); /* or NULL */
    void *watcher;
};

/* Which of coincident surfaces comes first, by the media of its two sides: one that changes
 * nothing goes before one that leads into another medium, or it would be met in the wrong one. */
enum rmap_rank {
    RMAP_RANK_WITHIN, /* the ray's medium on both sides */
    RMAP_RANK_NEAR,   /* the near side is the ray's medium */
    RMAP_RANK_ANY,    /* the near side fits every medium */
    RMAP_RANK_OTHER   /* the near side is another medium */
};

/* A surface that may be the next one. Those within float error of one another are all kept. */
#define RMAP_CANDIDATE_MAX 8
struct rmap_candidate {
    double t, tolerance;     /* along the ray, from the point inside if there is one */
    double from_start;       /* on_true: from the ray's start */
    double cosine;           /* of the ray to the normal, >= 0 */
    struct rmap_vec3 point;  /* shapes: local; triangles: weights of the corners */
    struct rmap_vec3 normal; /* shapes: local, unit; triangles: world, `length` long */
    double length;
    int32_t object, primitive;
    int32_t listed; /* triangle that the contact list has for this face */
    bool touches;   /* the start */
    bool predicted; /* as in struct rmap_hit */
    bool on_true;   /* surface of a triangle: the point is local */
    enum rmap_rank rank;
};

/* The surface that the ray starts from. */
struct rmap_start {
    int32_t object, primitive; /* -1: it starts in space */
    int32_t surface;           /* of a mesh's cells; -1: of none */
    double tolerance;
    bool at_edge;            /* to float error: neighbours are looked at without Embree */
    bool nudged;             /* at an edge: topology is decided from a point inside */
    struct rmap_vec3 inside; /* that point, in the world */
    struct rmap_vec3 inside_local;
    struct rmap_vec3 normal, middle; /* world: unit normal, and a mesh triangle's centroid */
    bool has_normal;
};

/* The ray in an object's frame; for meshes also sheared so that it runs along one axis: the
 * corners of triangles become points of a plane, in which it is the origin. */
struct rmap_local_ray {
    int32_t object; /* -1: none yet */
    struct rmap_vec3 origin, direction;
    double line[3]; /* start of the line that decides topology: the origin or the point inside */
    double ahead;   /* of the origin against it, along the ray */
    int axis[3];    /* the last one is the direction's largest component */
    double shear[3];
};

#define RMAP_DONE_SLOTS 8
#define RMAP_MET_SLOTS  4
struct rmap_query {
    const struct rmap_accel *accel;
    const struct rmap_ray *ray;
    struct rmap_start start;
    double limit; /* nothing that begins beyond can be the next surface */
    int n_candidate;
    struct rmap_candidate candidate[RMAP_CANDIDATE_MAX];
    struct rmap_local_ray local;
    int32_t done[RMAP_DONE_SLOTS]; /* shapes in parts that need no second look */
    struct {                       /* of the true surfaces that were asked for last */
        int32_t object, surface;
        struct rmap_true_meeting at;
    } met[RMAP_MET_SLOTS];
};

/* One call of rtcIntersect1: Embree's t is (t - shift) rate. The context comes first: callbacks
 * get no more than its address. */
struct rmap_traversal {
    struct RTCIntersectContext context;
    struct rmap_query *query;
    double shift, rate;
    float t_far;
    int32_t object; /* whose mesh is searched; -1: the top level */
};

static inline void rmap_facets_corners(const struct rmap_facets *facets, int32_t primitive,
                                       struct rmap_vec3 corner[3])
{
    const float *p = facets->corner[primitive];
    for (int k = 0; k < 3; k++)
        corner[k] = rmap_vec3((double)p[3 * k], (double)p[3 * k + 1], (double)p[3 * k + 2]);
}

enum rmap_status rmap_accel_failed(struct rmap_accel *accel, const char *doing,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Are vectors of eight floats to be had, without which the prefilter is slower than Embree? */
bool rmap_accel_is_wide(const struct rmap_accel *accel);

/* Callbacks of the structure. */
void rmap_accel_triangle(const struct RTCFilterFunctionNArguments *args);
void rmap_accel_callback(const struct RTCIntersectFunctionNArguments *args);
void rmap_accel_cell(const struct RTCIntersectFunctionNArguments *args);

/* Where the float ray, in its own distances, needs no further look. */
static inline float rmap_far_end(const struct rmap_query *query, double shift)
{
    return (float)(query->limit + RMAP_SLACK_ERRORS * query->accel->error - shift);
}

/* Distance along a ray that crosses a layer of this thickness. */
static inline double rmap_along(double thickness, double cosine)
{
    return cosine * RMAP_GRAZING_MAX > 1 ? thickness / cosine : thickness * RMAP_GRAZING_MAX;
}

/* A surface within tolerance of the point where the ray starts. rmap_start_meets puts the
 * triangle that is listed for its face in place of the primitive. */
struct rmap_touch {
    int32_t object, primitive;
    enum rmap_rank rank;
    double t;                /* of the hit; its sign is good to rounding only */
    double facing;           /* d . normal: from which side the surface would be met */
    struct rmap_vec3 normal; /* unit, world */
    struct rmap_vec3 point;  /* of the surface, world */
};

/* What rmap_joints_decide asks about: a shape's roots. */
struct rmap_joints {
    const struct rmap_query *query;
    int32_t object;
    bool overruled; /* the shape's own numbers, at one root at least */
};

#endif
