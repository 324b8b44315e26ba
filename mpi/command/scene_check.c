/* SPDX-License-Identifier: MIT
 *
 * Everything that is wrong with a scene.
 */
#include "mpi/command/scene_check.h"

#include "base/clock.h"
#include "mpi/command/body_check.h"

/* Rays that look for media that do not match; enough to meet every surface that light meets
 * often, few enough to be over in a moment. */
enum { PROBE_RAYS = 8192 };

/* Rays of some media take seconds each: then fewer must do. */
static const double probe_s = 10.0;

/* Sends some rays through the scene: what is written may be right line by line, and yet the
 * media of two touching surfaces may not match. */
static enum rmap_status probe(struct rmap_scene_checked *checked, int n_thread, uint64_t seed,
                              struct rmap_diagnostics *diagnostics, struct rmap_error *err)
{
    struct rmap_accel *accel = NULL;
    enum rmap_status st = rmap_accel_create(checked->scene, n_thread, &accel, err);
    struct rmap_tracer tracer = {.scene = checked->scene, .accel = accel, .seed = seed};
    checked->effort = (struct rmap_mismatch_effort){.n_ray = PROBE_RAYS, .seconds = probe_s};
    if (st == RMAP_OK)
        checked->build = *rmap_accel_last_build(accel);
    if (st == RMAP_OK)
        st = rmap_mismatch_probe(&tracer, &checked->effort, diagnostics, err);
    if (st == RMAP_OK && checked->effort.cut)
        rmap_diagnostics_add(diagnostics, RMAP_SEVERITY_WARNING, 0, 0,
                             "probing was cut after %.0f s: %llu of %llu rays sent; the light is "
                             "slow to trace here, and media may not match where no ray came",
                             probe_s, (unsigned long long)checked->effort.n_sent,
                             (unsigned long long)checked->effort.n_ray);
    rmap_accel_destroy(accel);
    return st;
}

enum rmap_status rmap_scene_check(struct rmap_bundle *bundle, int n_thread, uint64_t seed,
                                  struct rmap_diagnostics *diagnostics,
                                  struct rmap_scene_checked *checked, struct rmap_error *err)
{
    const double begun = rmap_clock_seconds();
    enum rmap_status st = rmap_scene_read(bundle, &checked->scene, diagnostics, err);
    checked->read_s += rmap_clock_seconds() - begun;
    checked->n_read = diagnostics->n + diagnostics->n_dropped;
    if (st == RMAP_OK)
        st = rmap_bodies_check(checked->scene, diagnostics, err);
    if (st == RMAP_OK && checked->scene->n_source > 0)
        st = probe(checked, n_thread, seed, diagnostics, err);
    return st;
}

void rmap_scene_checked_fini(struct rmap_scene_checked *checked)
{
    rmap_scene_destroy(checked->scene);
    *checked = (struct rmap_scene_checked){0};
}
