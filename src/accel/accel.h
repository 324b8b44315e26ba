/* SPDX-License-Identifier: MIT
 *
 * The two-level scene: the next surface that a ray meets. This module alone knows Embree.
 *
 * One bottom-level structure per unique mesh, shared by its instances; analytic surfaces need
 * no structure of their own and stand in the top level by their world bounds. Embree works in
 * float about the scene's centre; roots, apertures, distances and positions are decided in
 * double.
 */
#ifndef RMAP_ACCEL_H
#define RMAP_ACCEL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "base/vec.h"

struct rmap_scene;
struct rmap_accel;

/* What the last building of a structure took. */
struct rmap_accel_build {
    size_t n_built, n_kept; /* meshes */
    size_t n_object;        /* of the top level */
    size_t n_beside;        /* of these moved since that was built: looked for beside it */
    double meshes_s, top_s; /* meshes; all the rest */
};

/* Surfaces that coincide at one point, in the order in which the ray met them. A ray that turns
 * back at one of them meets the ones before it again, in reverse order, and none twice: this is
 * how touching faces are crossed exactly once each. Zero-initialised: the ray starts in space. */
#define RMAP_CONTACT_MAX 8
struct rmap_contact {
    struct {
        int32_t object, primitive;
    } surface[RMAP_CONTACT_MAX];
    int32_t n;      /* surfaces met at this point */
    int32_t passed; /* how many of them lie behind the ray's start, along the first direction */
    bool backward;  /* the ray now runs against the first direction */
};

/* The ray starts in space: none of the surfaces counts, whatever stands there. */
static inline void rmap_contact_clear(struct rmap_contact *contact)
{
    contact->n = contact->passed = 0;
    contact->backward = false;
}

struct rmap_ray {
    struct rmap_vec3 origin;
    struct rmap_vec3 direction; /* unit */
    int32_t medium;   /* that the ray is in: prefers, among coincident faces, the one whose
                         near side is this medium */
    int32_t gradient; /* 1 + index of the gradient medium in place; 0: uniform */
    struct rmap_contact contact;
};

struct rmap_hit {
    double t; /* distance, > 0; 0 for a surface that meets the ray's start */
    struct rmap_vec3 position;
    struct rmap_vec3 normal; /* unit, as the surface has it, unflipped */
    int32_t object;
    int32_t primitive; /* triangle; 0 for analytic surfaces */
    bool predicted;    /* every number is what src/compact finds from start, direction and surface,
                         by the same operations; false where that is not certain */
};

/* The scene is borrowed and must outlive the structure. n_threads: for building (0: all).
 * RMAP_SYSTEM when Embree or memory fails. */
enum rmap_status rmap_accel_create(const struct rmap_scene *scene, int n_threads,
                                   struct rmap_accel **accel_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* The same with the device of another structure, and the meshes that both scenes have: only those
 * that are new are built. The other one, whose scene may be gone, stays as it is; either may be
 * destroyed first. Not while another thread builds or destroys one of those that share. */
enum rmap_status rmap_accel_create_like(const struct rmap_accel *like,
                                        const struct rmap_scene *scene,
                                        struct rmap_accel **accel_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* The structure follows its scene, of which these objects stand elsewhere now (rmap_scene_move): as
 * if made anew. RMAP_SYSTEM: it is to be destroyed. */
enum rmap_status rmap_accel_move(struct rmap_accel *accel, const int32_t *object, size_t n_object,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Of many meshes a few that moved are looked for beside the top level, which costs rays some
 * hundredths of their time: this builds it anew, before many are traced. As rmap_accel_move. */
enum rmap_status rmap_accel_settle(struct rmap_accel *accel, struct rmap_error *err) RMAP_MUST_USE;

const struct rmap_accel_build *rmap_accel_last_build(const struct rmap_accel *accel);

void rmap_accel_destroy(struct rmap_accel *accel);

/* Instruction set that picks among triangles at an edge ("AVX2"); ranks of a run must agree. */
const char *rmap_accel_isa(const struct rmap_accel *accel);

/* The best instruction set of this machine, as a level: smaller ones it has too, so ranks agree
 * on the minimum. Negative: Embree runs on none, or has no memory. */
int rmap_accel_isa_level(void);

/* The level of an instruction set as rmap_accel_isa names it; negative: of none. */
int rmap_accel_isa_level_of(const char *name);

/* rmap_accel_create with the instruction set given; it takes the best. */
enum rmap_status rmap_accel_create_isa(const struct rmap_scene *scene, int n_threads, int level,
                                       struct rmap_accel **accel_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Version of Embree that the program was built with ("3.13.5"). */
const char *rmap_accel_embree_version(void);

/* Nearest surface along the ray; false when it meets none. Thread-safe. Call
 * rmap_contact_pass or rmap_contact_turn before the next segment. */
bool rmap_accel_next(const struct rmap_accel *accel, const struct rmap_ray *ray,
                     struct rmap_hit *hit);

/* The same as far as `length` (> 0) from the start. A surface that lies no farther beyond than its
 * own coincidence tolerance is met too, so that one at the joint of two chords is not lost. */
bool rmap_accel_next_within(const struct rmap_accel *accel, const struct rmap_ray *ray,
                            double length, struct rmap_hit *hit);

/* The same where the next surface is known, by that one alone. False: it is not met, or it takes
 * the others to tell. */
bool rmap_accel_meet(const struct rmap_accel *accel, const struct rmap_ray *ray, int32_t object,
                     int32_t primitive, struct rmap_hit *hit);

/* The ray went on through the surface of `hit` (which it reached over distance hit->t). */
void rmap_contact_pass(struct rmap_contact *contact, const struct rmap_hit *hit);

/* The ray turned back (was reflected) at the surface of `hit`. */
void rmap_contact_turn(struct rmap_contact *contact, const struct rmap_hit *hit);

/* For measurements: the same queries replayed through rtcIntersect1 alone, nothing refined
 * beyond what Embree's callbacks do. Returns how many rays hit something. rmap_accel_prepare
 * comes first: it works out what Embree's float rays need and builds a structure of all surfaces,
 * which tracing does without. */
struct rmap_replay_ray {
    struct rmap_ray ray;
    double length; /* asked for; 0: all the way */
    bool misses;   /* this and the rest is set by rmap_accel_prepare */
    float origin[3], direction[3];
    double shift;
};
enum rmap_status rmap_accel_prepare(struct rmap_accel *accel, struct rmap_replay_ray *ray,
                                    size_t n_ray, struct rmap_error *err) RMAP_MUST_USE;
size_t rmap_accel_replay(const struct rmap_accel *accel, const struct rmap_replay_ray *ray,
                         size_t n_ray);

/* For measurements on one thread: tells of every query from now on; watch NULL: no more. */
void rmap_accel_watch(struct rmap_accel *accel,
                      void (*watch)(void *context, const struct rmap_ray *ray, double length),
                      void *context);

#endif
