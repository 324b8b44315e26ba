/* SPDX-License-Identifier: MIT
 *
 * Paths of any words, unfolded eight legs at a time where there is room for it and leg by leg where
 * there is none: the same legs.
 */
#include "compact/model.h"
#include "compact/paths.h"
#include "compact_rig.h"

static const char nested_scene[] =
    "raymap: 1\n"
    "spectrum: {mode: rgb}\n"
    "media: {air: {index: 1}, glass: {index: 1.5}, water: {index: 1.33}}\n"
    "surfaces: {clear: {type: fresnel}, white: {type: lambert, reflectance: 0.5}}\n"
    "geometries: {ball: {type: sphere, radius: 3}, bead: {type: sphere, radius: 1}, "
    "plate: {type: rectangle, size: [40, 40]}}\n"
    "objects:\n"
    "  - {name: ball, geometry: ball, surface: clear, inside: glass, outside: air}\n"
    "  - {name: bead, geometry: bead, surface: clear, inside: water, outside: glass}\n"
    "  - {name: floor, geometry: plate, at: [0, 0, 5], surface: white, front: air}\n"
    "  - {name: pond, geometry: plate, at: [0, 0, 7], surface: clear, front: water, back: air}\n"
    "sources: [{name: bulb, type: point, at: [0, 0, -5], flux: 1 W, medium: air}]\n";

enum { LEGS = 40, ROOM = LEGS + 8 };

static uint32_t next_below(uint64_t *state, uint32_t end)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(*state >> 33) % end;
}

/* Mostly as light goes, which words of 0 stand for. */
static void make_words(uint64_t *state, uint32_t n_object, uint32_t *object, uint32_t *event)
{
    static const uint32_t flip[] = {0, 0, 0, 5, 20, 8, 36, 1};
    uint32_t odd = next_below(state, 8);
    for (size_t k = 0; k < ROOM; k++) {
        object[k] = next_below(state, 2 + odd) ? next_below(state, n_object + 1) : 0;
        event[k] = flip[next_below(state, odd ? 8 : 4)];
    }
    object[0] = 1 + next_below(state, n_object);
}

static void test_same_legs(void **state)
{
    (void)state;
    struct rig rig;
    rig_open_text(&rig, nested_scene);
    const struct rmap_compact_model *model = rig.model;
    uint32_t n_object = (uint32_t)model->n_object, object[ROOM], event[ROOM];
    uint64_t random = 20261121;
    for (int i = 0; i < 200000; i++) {
        int32_t wide_object[ROOM], object_out[LEGS];
        uint32_t wide_event[ROOM], event_out[LEGS];
        int16_t wide_medium[ROOM], medium_out[LEGS];
        size_t n = next_below(&random, LEGS + 1);
        make_words(&random, n_object, object, event);
        struct rmap_folded_path path = {.stop = (uint8_t)next_below(&random, 4),
                                        .guided = rmap_path_guided(model, object, ROOM),
                                        .n = n,
                                        .n_stored = ROOM,
                                        .object = object,
                                        .event = event};
        assert_true(path.guided);
        rmap_path_unfold(
            model, &path,
            &(struct rmap_path_columns){ROOM, wide_object, wide_event, i & 1 ? wide_medium : NULL});
        path.guided = false;
        rmap_path_unfold(model, &path,
                         &(struct rmap_path_columns){LEGS, object_out, event_out, medium_out});
        assert_memory_equal(wide_object, object_out, n * sizeof *object_out);
        assert_memory_equal(wide_event, event_out, n * sizeof *event_out);
        if (i & 1)
            assert_memory_equal(wide_medium, medium_out, n * sizeof *medium_out);
    }
    rig_close(&rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_same_legs)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
