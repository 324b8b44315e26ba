/* SPDX-License-Identifier: MIT
 *
 * The fixture's scene: written to the test's directory and read as any scene is. With
 * FIXTURE=curved in the environment its glass is a gradient medium, so that maps have /curve.
 */
#ifndef RMAP_MAP_FIXTURE_SCENE_H
#define RMAP_MAP_FIXTURE_SCENE_H

#include "io/mesh/bundle.h"

static const char fixture_scene_head[] = "raymap: 1\n"
                                         "units: mm\n"
                                         "spectrum: {mode: rgb}\n"
                                         "media:\n"
                                         "  air: {index: 1}\n";

static const char fixture_uniform[] = "  glass: {index: 1.5}\n";
static const char fixture_gradient[] =
    "  glass: {gradient: {type: parabolic, n0: 1.6, alpha: 0.01, frame: world}}\n";

static const char fixture_scene_text[] =
    "surfaces:\n"
    "  black: {type: absorber}\n"
    "geometries:\n"
    "  disc: {type: disc, radius: 10}\n"
    "objects:\n"
    "  - {name: lens, geometry: disc, surface: black, front: air, back: air}\n"
    "  - name: housing\n"
    "    objects:\n"
    "      - {name: barrel, geometry: disc, at: [0, 0, 30], surface: black, front: air, back: "
    "air}\n"
    "      - {name: film_holder, geometry: disc, at: [0, 0, 60], surface: black, front: air,"
    " back: air}\n"
    "sources:\n"
    "  - {name: beam, type: collimated, shape: {disc: 1}, at: [0, 0, -9], direction: [0, 0, 1],\n"
    "     flux: 2 W, spectrum: {rgb: [1, 1, 1]}, medium: air}\n"
    "  - {name: lamp, type: collimated, shape: {disc: 1}, at: [0, 0, -9], direction: [0, 0, 1],\n"
    "     flux: 3 W, spectrum: {rgb: [1, 1, 1]}, medium: air}\n"
    "detectors:\n"
    "  - {name: film, type: plane, size: [8, 6], cells: [16, 9], at: [0, 0, 50],"
    " direction: [0, 0, -1]}\n";

static inline bool fixture_is_curved(void)
{
    const char *kind = getenv("FIXTURE");
    return kind && strcmp(kind, "curved") == 0;
}

static inline void fixture_scene(const char *directory, struct rmap_bundle **bundle,
                                 struct rmap_scene **scene)
{
    char path[128];
    struct rmap_error err = {0};
    struct rmap_scene_options options = {0};
    struct rmap_diagnostics diagnostics;
    (void)snprintf(path, sizeof path, "%s/scene.yaml", directory);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(fixture_scene_head, file) >= 0);
    assert_true(fputs(fixture_is_curved() ? fixture_gradient : fixture_uniform, file) >= 0);
    assert_true(fputs(fixture_scene_text, file) >= 0);
    assert_int_equal(fclose(file), 0);
    rmap_diagnostics_init(&diagnostics, path);
    if (rmap_bundle_open(path, &options, bundle, &err) != RMAP_OK ||
        rmap_scene_read(*bundle, scene, &diagnostics, &err) != RMAP_OK) {
        rmap_diagnostics_print(&diagnostics, stderr);
        fail_msg("%s", err.text);
    }
    rmap_diagnostics_fini(&diagnostics);
}

#endif
