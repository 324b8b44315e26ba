/* SPDX-License-Identifier: MIT
 *
 * The fixture's scene, built by hand, with a bundle that carries no more than its text: these
 * tests are about files, not about reading scenes.
 */
#ifndef RMAP_MAP_FIXTURE_SCENE_H
#define RMAP_MAP_FIXTURE_SCENE_H

#include "io/bundle.h"

static inline struct rmap_scene *fixture_scene_build(void)
{
    struct rmap_scene *s = NULL;
    assert_int_equal(rmap_scene_create(&s, NULL), RMAP_OK);
    s->channels = (struct rmap_channels){RMAP_COLOUR_RGB, 3, {587.56, 587.56, 587.56}};
    s->n_medium = 2;
    s->n_surface = 1;
    s->n_geometry = 1;
    s->n_object = 3;
    s->n_group = 1;
    s->n_source = 2;
    s->n_detector = 1;
    s->medium = rmap_alloc(2, sizeof *s->medium);
    s->surface = rmap_alloc(1, sizeof *s->surface);
    s->geometry = rmap_alloc(1, sizeof *s->geometry);
    s->object = rmap_alloc(3, sizeof *s->object);
    s->group = rmap_alloc(1, sizeof *s->group);
    s->source = rmap_alloc(2, sizeof *s->source);
    s->detector = rmap_alloc(1, sizeof *s->detector);
    s->medium[0].name = rmap_strdup("air");
    s->medium[1].name = rmap_strdup("glass");
    for (int i = 0; i < 2; i++)
        s->medium[i].n[0] = s->medium[i].n[1] = s->medium[i].n[2] = 1 + 0.5 * i;
    s->surface[0].name = rmap_strdup("black");
    s->surface[0].type = RMAP_SURFACE_ABSORBER;
    s->geometry[0].name = rmap_strdup("disc");
    s->geometry[0].shape = (struct rmap_shape){.type = RMAP_SHAPE_DISC, .aperture = 10};
    s->group[0] = (struct rmap_group){rmap_strdup("housing"), 77, -1};
    static const char *const object[] = {"lens", "barrel", "sensor"};
    for (int i = 0; i < 3; i++)
        s->object[i] = (struct rmap_object){.name = rmap_strdup(object[i]),
                                            .id = 10 + (uint64_t)i,
                                            .parent = i ? 0 : -1,
                                            .to_world = rmap_affine_identity(),
                                            .medium_front = 0,
                                            .medium_back = 0};
    for (int i = 0; i < 2; i++) {
        s->source[i].name = rmap_strdup(i ? "lamp" : "beam");
        s->source[i].frame = rmap_affine_identity();
        s->source[i].flux = 2 + i;
        s->source[i].share = 1;
        s->source[i].shape_size[0] = 1;
        s->source[i].colour[0] = s->source[i].colour[1] = s->source[i].colour[2] = 1.0 / 3;
    }
    s->detector[0] = (struct rmap_detector){.name = rmap_strdup("film"),
                                            .x = {1, 0, 0},
                                            .y = {0, 1, 0},
                                            .axis = {0, 0, 1},
                                            .size = {8, 6},
                                            .cells = {16, 9},
                                            .max_angle_rad = 1.5,
                                            .on_object = -1,
                                            .on_group = -1};
    assert_int_equal(rmap_scene_finish(s, NULL), RMAP_OK);
    return s;
}

static inline void fixture_scene(const char *directory, struct rmap_bundle **bundle,
                                 struct rmap_scene **scene)
{
    (void)directory;
    *bundle = rmap_alloc(1, sizeof **bundle);
    (*bundle)->text = rmap_strdup("raymap: 1\n");
    *scene = fixture_scene_build();
}

void rmap_bundle_destroy(struct rmap_bundle *bundle)
{
    if (bundle)
        rmap_free(bundle->text);
    rmap_free(bundle);
}

enum rmap_status rmap_bundle_pack(const struct rmap_bundle *bundle, uint8_t **blob_ret,
                                  size_t *nbytes_ret, struct rmap_error *err)
{
    *nbytes_ret = strlen(bundle->text);
    *blob_ret = (uint8_t *)rmap_strdup(bundle->text);
    return *blob_ret ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory");
}

enum rmap_status rmap_bundle_unpack(const uint8_t *blob, size_t nbytes,
                                    struct rmap_bundle **bundle_ret, struct rmap_error *err)
{
    struct rmap_bundle *bundle = rmap_alloc(1, sizeof *bundle);
    char *text = rmap_alloc(nbytes + 1, 1);
    if (!bundle || !text) {
        rmap_free(bundle);
        rmap_free(text);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    }
    memcpy(text, blob, nbytes);
    bundle->text = text;
    *bundle_ret = bundle;
    return RMAP_OK;
}

enum rmap_status rmap_scene_read(struct rmap_bundle *bundle, struct rmap_scene **scene_ret,
                                 struct rmap_diagnostics *diagnostics, struct rmap_error *err)
{
    (void)bundle;
    (void)diagnostics;
    (void)err;
    *scene_ret = fixture_scene_build();
    return RMAP_OK;
}

#endif
