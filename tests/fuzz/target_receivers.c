/* SPDX-License-Identifier: MIT
 *
 * A file of receivers from a stranger, laid over a map with curved segments. It ends in receivers
 * that register what they register, or in mistakes with their places.
 */

#include "analysis/overlay/overlay.h"
#include "analysis/query/quantity.h"
#include "analysis/query/quantity_read.h"
#include "fuzz_map.h"

const unsigned rmap_fuzz_rounds = 4000;

enum { LONGEST = 8192 };

/* What they registered, and numbers of it. */
static void use(const struct rmap_map *map, const struct rmap_overlay *overlay)
{
    static const char *const of[2] = {"x(*)", "angle(*)"};
    const struct rmap_scene *scene = rmap_scene_with(map, overlay);
    struct rmap_overlay_view *view = NULL;
    struct rmap_quantities *quantities = NULL;
    struct rmap_readings readings = {0};
    const struct rmap_portion *rays = NULL;
    struct rmap_error err = {0};
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_overlay_view_create(overlay, &view, &err));
    RMAP_TRY(rmap_overlay_view_extend(view, fuzz_map_rays, 0, &rays, &err));
    for (size_t i = 0; i < rays->n_row[RMAP_TABLE_REGISTRATION]; i++) {
        const int32_t d = rays->registration.detector[i];
        rmap_fuzz_demand(d >= 0 && (size_t)d < scene->n_detector, "a detector of the scene");
    }
    /* An intensity grid has no x: that is said. */
    if (rmap_quantities_create_over(map, overlay, of, 2, NULL, &quantities, &err) == RMAP_OK) {
        const struct rmap_matched all = {.portion = rays, .n_match = rays->n_row[RMAP_TABLE_RAY]};
        RMAP_TRY(rmap_quantities_read(quantities, &all, &readings, &err));
    }
out:
    if (st != RMAP_OK)
        (void)fprintf(stderr, "status %d: %s\n", (int)st, err.text);
    rmap_fuzz_demand(st == RMAP_OK, "receivers that were read can be used");
    rmap_readings_fini(&readings);
    rmap_quantities_destroy(quantities);
    rmap_overlay_view_destroy(view);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    const struct rmap_map *map = fuzz_map();
    struct rmap_overlay *overlay = NULL;
    struct rmap_diagnostics diagnostics;
    struct rmap_error err = {0};
    const struct rmap_receivers receivers = {"receivers.yaml", (const char *)data, nbytes,
                                             &diagnostics};
    int64_t live = rmap_alloc_live();
    if (nbytes == 0 || nbytes > LONGEST)
        return 0;
    rmap_diagnostics_init(&diagnostics, receivers.path);
    enum rmap_status st = rmap_overlay_create(map, &receivers, &overlay, &err);
    if (st == RMAP_OK)
        use(map, overlay);
    else
        rmap_fuzz_demand(st == RMAP_INPUT && diagnostics.n_error > 0, "mistakes are told");
    rmap_overlay_destroy(overlay);
    rmap_diagnostics_fini(&diagnostics);
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
    return 0;
}

size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    static const char *const seed[] = {
        "detectors:\n"
        "  - {name: a, type: plane, size: [8, 6], cells: [16, 9], at: [0, 0, 50], direction: [0, "
        "0, "
        "-1]}\n",
        "detectors:\n"
        "  - {name: b, type: plane, on: housing.film_holder, size: 20, cells: 4, side: both, at: "
        "[0, "
        "0, 60]}\n"
        "  - {name: far, type: intensity, cells: [9, 18], axis: [0, 0, 1]}\n",
        "detectors:\n"
        "  - name: tilted\n"
        "    type: plane\n"
        "    size: [300, 1.0e-3]\n"
        "    cells: [100, 1]\n"
        "    at: [0, 0.1, 30]\n"
        "    direction: [0, 0.1, -1]\n"
        "    up: [1, 0, 0]\n"
        "    side: back\n"
        "    max_angle: 20\n",
        "detectors: [{name: f, type: intensity, cells: [1, 1], axis: [1, 1, 1], up: [0, 1, 0]}]\n",
        "- {name: g, type: plane, on: {object: housing.film_holder, faces: [0, 1..2, top]}, cells: "
        "3}\n",
        "detectors: &all\n  - &x {name: c, type: plane, size: 1, cells: 1}\n  - *x\n",
    };
    return rmap_fuzz_seed_text(seed, sizeof seed / sizeof *seed, k, to, cap);
}
