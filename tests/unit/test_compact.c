/* SPDX-License-Identifier: MIT
 *
 * The compact encoding on traced rays: every bit comes back, little is stored, and portions do not
 * depend on what was encoded before.
 */
#include "compact/paths.h"
#include "compact_rig.h"

/* Detectors, one in space, one on the floor. */
#define PLANES                                                                                     \
    "  - {name: free, type: plane, size: [20, 20], cells: [100, 60], at: [0, 0, 7], "              \
    "direction: [0, 0.2, -1]}\n"                                                                   \
    "  - {name: below, type: plane, on: floor, size: [40, 40], cells: [70, 70], at: [0, -12, "     \
    "10], "                                                                                        \
    "direction: [0, 1, 0]}\n"

/* All kinds of source, detector, surface, medium and shape; a mirrored and a stretched instance. */
static const char all_kinds[] =
    "raymap: 1\n"
    "spectrum: {mode: spectral, wavelengths: [450, 500, 550, 600, 650]}\n"
    "media:\n"
    "  air: {index: 1}\n"
    "  bk7: {glass: N-BK7}\n"
    "  fog: {index: 1.33, absorption: 0.02}\n"
    "  dye: {index: 1.5, absorption: {wavelength: [450, 650], value: [0.001, 0.2]}}\n"
    "surfaces:\n"
    "  clear: {type: fresnel}\n"
    "  coated: {type: fresnel, coat: {reflectance: {wavelength: [450, 650], value: [0.1, 0.3]}}}\n"
    "  white: {type: lambert, reflectance: {wavelength: [450, 650], value: [0.9, 0.6]}}\n"
    "  half: {type: mixture, reflect_specular: 0.3, reflect_diffuse: 0.2, transmit_specular: 0.2, "
    "transmit_diffuse: 0.2}\n"
    "  mirror: {type: mirror, reflectance: 0.98}\n"
    "geometries:\n"
    "  ball: {type: sphere, radius: 3}\n"
    "  bowl: {type: conic, radius: -20, conic: -1, aperture: 9}\n"
    "  bent: {type: conic, radius: 30, conic: -0.5, asphere: {4: 1.0e-5}, aperture: 8}\n"
    "  funnel: {type: cone, radius: 6, radius2: 9, length: 10}\n"
    "  plate: {type: rectangle, size: [40, 40]}\n"
    "  ring: {type: disc, radius: 9, inner: 2}\n"
    "objects:\n"
    "  - {name: fog_ball, geometry: ball, at: [0, 0, 10], surface: clear, inside: fog, outside: "
    "air}\n"
    "  - {name: dye_ball, geometry: ball, at: [7, 1, 12], scale: [1, 2, 1.5], rotate: [10, 20, "
    "30], "
    "surface: coated, inside: dye, outside: air}\n"
    "  - {name: glass_ball, geometry: ball, at: [-7, 0, 12], scale: [-1, 1, 1], surface: clear, "
    "inside: bk7, outside: air}\n"
    "  - {name: mirror_bowl, geometry: bowl, at: [0, 0, 30], surface: mirror, front: air, back: "
    "air}\n"
    "  - {name: bend, geometry: bent, at: [0, 9, 5], surface: half, front: air, back: air}\n"
    "  - {name: tunnel, geometry: funnel, at: [0, 0, 14], surface: white, inside: air, outside: "
    "air}\n"
    "  - {name: floor, geometry: plate, at: [0, -12, 10], rotate: [90, 0, 0], surface: white, "
    "front: air, back: air}\n"
    "  - {name: pane, geometry: ring, at: [1, 1, 2], rotate: [5, 0, 0], surface: half, front: air, "
    "back: air}\n"
    "sources:\n"
    "  - {name: sun, type: collimated, shape: {disc: 9}, at: [0, 0, -5], flux: 1 W, medium: air}\n"
    "  - {name: bulb, type: point, at: [0, 5, 8], flux: 1 W, medium: air}\n"
    "  - {name: torch, type: point, at: [0, 0, -8], distribution: {cone: 40}, flux: 1 W, medium: "
    "air}\n"
    "  - {name: led, type: point, at: [1, 0, -8], distribution: {cosine_power: 3.5}, flux: 1 W, "
    "medium: air}\n"
    "  - {name: lamp, type: point, at: [1, 0, -8], flux: 1 W, medium: air, "
    "distribution: {table: {angle: [0, 20, 70], value: [1, 2, 0]}}}\n"
    "  - {name: disc, type: collimated, shape: {disc: 9}, at: [0, 0, -5], angular_diameter: 0.53, "
    "flux: 1 W, medium: air}\n"
    "  - {name: panel, type: area, shape: {rectangle: [4, 6]}, at: [0, 11, 10], "
    "direction: [0, -1, 0], flux: 1 W, medium: air}\n"
    "detectors:\n" PLANES "  - {name: sky, type: intensity, cells: [90, 180]}\n";

/* Encodes, checks, and returns the stored bytes per segment. */
static double check_rays(struct rig *rig, uint64_t first, size_t n)
{
    struct rmap_error err = {0};
    struct rmap_encoder *codec = NULL;
    struct rmap_portion *portion = rig_trace(rig, first, n);
    struct rmap_rows own;
    rig_encode(rig, RIG_SEED, portion, &own);
    rig_ok(rmap_encoder_create(&codec, &err), &err);
    double nbytes = compact_nbytes(codec, &own) / (double)portion->n_row[RMAP_TABLE_SEGMENT];
    rmap_encoder_destroy(codec);
    rows_free(&own);
    rig_roundtrip(rig, RIG_SEED, portion);
    rmap_portion_destroy(portion);
    return nbytes;
}

static void test_every_kind(void **state)
{
    (void)state;
    struct rig rig;
    rig_open_text(&rig, all_kinds);
    double nbytes = check_rays(&rig, 0, 4096);
    print_message("every kind: %.3f bytes per segment\n", nbytes);
    assert_true(nbytes < 4.3);
    check_rays(&rig, UINT64_C(1) << 40, 1000);
    rig_close(&rig);
}

/* The examples, against the numbers that the encoding is made for. */
static void test_examples(void **state)
{
    (void)state;
    struct rig rig;
    rig_open(&rig, RAYMAP_SOURCE_DIR "/examples/double-gauss/scene.yaml");
    double lens = check_rays(&rig, 0, 16384);
    rig_close(&rig);
    rig_open(&rig, RAYMAP_SOURCE_DIR "/examples/room/scene.yaml");
    double room = check_rays(&rig, 4096, 4096);
    rig_close(&rig);
    print_message("double-gauss %.3f, room %.3f bytes per segment\n", lens, room);
    assert_true(lens < 0.5);
    assert_true(room < 2.5);
}

/* Rooms of all surfaces and shapes whose rays are mostly predicted; in RGB, too. */
static const char colours[2][80] = {
    "spectrum: {mode: spectral, wavelengths: [450, 500, 550, 600, 650]}\n",
    "spectrum: {mode: rgb}\n",
};
static const char room_of_kinds[] =
    "surfaces:\n"
    "  clear: {type: fresnel}\n"
    "  coated: {type: fresnel, coat: {reflectance: {wavelength: [450, 650], value: [0.1, 0.3]}}}\n"
    "  white: {type: lambert, reflectance: {wavelength: [450, 650], value: [0.95, 0.9]}}\n"
    "  half: {type: mixture, reflect_specular: {wavelength: [450, 650], value: [0.4, 0.2]}, "
    "reflect_diffuse: 0.2, transmit_specular: {wavelength: [450, 650], value: [0.1, 0.3]}, "
    "transmit_diffuse: 0.2}\n"
    "  metal: {type: mirror, metal: {n: 0.2, k: 3.4}}\n"
    "  mirror: {type: mirror, reflectance: 0.98}\n"
    "geometries:\n"
    "  ball: {type: sphere, radius: 3}\n"
    "  hall: {type: sphere, radius: 40}\n"
    "  bowl: {type: conic, radius: -20, conic: -1, aperture: 9}\n"
    "  horn: {type: conic, radius: 4, conic: -3, aperture: 9, inner: 1}\n"
    "  egg: {type: conic, radius: 6, conic: 0.5, aperture: 1.5}\n"
    "  funnel: {type: cone, radius: 6, radius2: 9, length: 10}\n"
    "  pipe: {type: cylinder, radius: 2, length: 7}\n"
    "  bent: {type: conic, radius: 30, conic: -0.5, asphere: {4: 1.0e-5}, aperture: 3}\n"
    "  plate: {type: rectangle, size: [30, 30]}\n"
    "  ring: {type: disc, radius: 9, inner: 2}\n"
    "objects:\n"
    "  - {name: walls, geometry: hall, surface: white, inside: air, outside: air}\n"
    "  - {name: glass_ball, geometry: ball, at: [-7, 0, 12], scale: [-1, 1, 1], surface: clear, "
    "inside: bk7, outside: air}\n"
    "  - {name: stretched, geometry: ball, at: [7, 1, 12], scale: [1, 2, 1.5], rotate: [10, 20, "
    "30], surface: coated, inside: water, outside: air}\n"
    "  - {name: nested, geometry: ball, at: [-7, 0, 12], scale: 0.5, surface: clear, inside: "
    "water, outside: bk7}\n"
    "  - {name: bowl, geometry: bowl, at: [0, 0, 30], surface: mirror, front: air, back: air}\n"
    "  - {name: horn, geometry: horn, at: [0, 20, 0], surface: half, front: air, back: air}\n"
    "  - {name: egg, geometry: egg, at: [0, -20, 0], surface: metal, front: air, back: air}\n"
    "  - {name: tunnel, geometry: funnel, at: [0, 0, 19], surface: half, inside: air, outside: "
    "air}\n"
    "  - {name: pipe, geometry: pipe, at: [20, 0, 0], rotate: [0, 50, 0], surface: half, inside: "
    "air, outside: air}\n"
    "  - {name: bend, geometry: bent, at: [-20, 9, 25], surface: half, front: air, back: air}\n"
    "  - {name: floor, geometry: plate, at: [0, -12, 10], rotate: [90, 0, 0], surface: half, "
    "front: air, back: air}\n"
    "  - {name: stuck, geometry: plate, at: [5, -12, 15], rotate: [90, 0, 0], scale: 0.2, surface: "
    "half, "
    "front: air, back: air}\n"
    "  - {name: pane, geometry: ring, at: [1, 1, 2], rotate: [5, 0, 0], surface: half, front: air, "
    "back: air}\n"
    "sources:\n"
    "  - {name: sun, type: collimated, shape: {disc: 9}, at: [0, 0, -5], flux: 1 W, medium: air}\n"
    "  - {name: axis, type: collimated, shape: {disc: 0.1}, at: [0, 0, -5], direction: [0, 1, 0], "
    "flux: 1 W, medium: "
    "air}\n"
    "  - {name: bulb, type: point, at: [0, 5, 8], flux: 1 W, medium: air}\n"
    "  - {name: torch, type: point, at: [0, 0, -8], distribution: {cone: 40}, flux: 1 W, "
    "rays_share: 0.05, medium: air}\n"
    "  - {name: panel, type: area, shape: {rectangle: [4, 6]}, at: [0, 11, 10], "
    "direction: [0, -1, 0], flux: 1 W, medium: air}\n"
    "detectors:\n" PLANES;

/* As a new piece. */
static void encode_afresh(struct rig *rig, const struct rmap_portion *portion,
                          struct rmap_rows *own)
{
    struct rmap_error err = {0};
    rmap_path_book_destroy(rig->book);
    rig->book = NULL;
    rig_ok(rmap_path_book_create(&rig->book, &err), &err);
    rows_free(&rig->whole);
    rig->whole.layout = &rmap_compact_layout;
    rig_encode(rig, RIG_SEED, portion, own);
}

/* The same streams with the tracer's promises and without; how many rays it promised nothing of. */
static size_t check_predicted(struct rig *rig, uint64_t first, size_t n)
{
    struct rmap_unpredicted *unpredicted = rmap_alloc(1, sizeof *unpredicted);
    struct rmap_portion *portion = rig_trace_told(rig, first, n, unpredicted);
    struct rmap_rows told, followed;
    size_t n_stray = unpredicted->n;
    encode_afresh(rig, portion, &followed);
    portion->unpredicted = unpredicted;
    encode_afresh(rig, portion, &told);
    for (int s = 0; s < rmap_compact_layout.n_stream; s++) {
        assert_int_equal(stream_nbytes(&told, s), stream_nbytes(&followed, s));
        if (told.data[s])
            assert_memory_equal(told.data[s], followed.data[s], stream_nbytes(&told, s));
    }
    rig_decode(rig, &told, portion, RMAP_COLUMNS_ALL);
    assert_columns_equal(portion, rig->decoded, RMAP_COLUMNS_ALL);
    rows_free(&told);
    rows_free(&followed);
    rmap_portion_destroy(portion);
    rmap_free(unpredicted);
    return n_stray;
}

/* What the tracer says of a ray holds for every kind of surface, shape, source and detector. */
static void test_predicted(void **state)
{
    (void)state;
    struct rig rig;
    for (int mode = 0; mode < 2; mode++) {
        char text[8192];
        (void)snprintf(
            text, sizeof text,
            "raymap: 1\n%smedia:\n  air: {index: 1}\n  water: {index: 1.33}\n  bk7: %s\n%s",
            colours[mode], mode == 0 ? "{glass: N-BK7}" : "{index: 1.52}", room_of_kinds);
        rig_open_text(&rig, text);
        for (uint64_t block = 0; block < 8; block++) {
            size_t n = check_predicted(&rig, 4096 * block, 4096);
            if (block == 0)
                print_message("mode %d: %zu unpredicted of 4096\n", mode, n);
            assert_in_range(n, 1, 1024); /* else nothing was tried here */
        }
        rig_close(&rig);
    }
    rig_open_text(&rig, all_kinds);
    check_predicted(&rig, 0, 4096);
    rig_close(&rig);
    rig_open(&rig, RAYMAP_SOURCE_DIR "/examples/double-gauss/scene.yaml");
    assert_true(check_predicted(&rig, 0, 16384) < 16);
    rig_close(&rig);
    rig_open(&rig, RAYMAP_SOURCE_DIR "/examples/room/scene.yaml");
    assert_true(check_predicted(&rig, 0, 4096) < 16);
    rig_close(&rig);
}

/* A promise that does not hold is found out. */
static void test_broken_promise(void **state)
{
    (void)state;
    struct rig rig;
    struct rmap_error err = {0};
    struct rmap_unpredicted unpredicted;
    rig_open(&rig, RAYMAP_SOURCE_DIR "/examples/double-gauss/scene.yaml");
    struct rmap_portion *portion = rig_trace_told(&rig, 0, 4096, &unpredicted);
    portion->unpredicted = &unpredicted;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_SEGMENT]; i++)
        portion->segment.position[3 * i] = nextafterf(portion->segment.position[3 * i], 1e9F);
    assert_int_equal(rmap_compact_encode(rig.encoder, RIG_SEED, portion, &err), RMAP_INTERNAL);
    assert_int_equal(rmap_compact_encode(rig.encoder, RIG_SEED + 1, portion, &err), RMAP_OK);
    portion->unpredicted = NULL;
    assert_int_equal(rmap_compact_encode(rig.encoder, RIG_SEED, portion, &err), RMAP_OK);
    rmap_portion_destroy(portion);
    rig_close(&rig);
}

/* A wrong seed predicts nothing, and still every bit comes back, in no more bytes than plain. */
static void test_wrong_seed(void **state)
{
    (void)state;
    struct rig rig;
    struct rmap_error err = {0};
    struct rmap_encoder *codec = NULL;
    struct rmap_rows own;
    rig_open(&rig, RAYMAP_SOURCE_DIR "/examples/double-gauss/scene.yaml");
    struct rmap_portion *portion = rig_trace(&rig, 0, 4096);
    rig_roundtrip(&rig, RIG_SEED + 1, portion);
    rig_encode(&rig, RIG_SEED + 1, portion, &own);
    rig_ok(rmap_encoder_create(&codec, &err), &err);
    assert_true(compact_nbytes(codec, &own) < plain_nbytes(codec, portion));
    rmap_encoder_destroy(codec);
    rows_free(&own);
    rmap_portion_destroy(portion);
    rig_close(&rig);
}

/* Rays with gaps between their ids, as a selection has them, in any order. */
static void test_selection(void **state)
{
    (void)state;
    struct rig rig;
    struct rmap_error err = {0};
    rig_open_text(&rig, all_kinds);
    struct rmap_portion *all = rig_trace(&rig, 100, 500), *some = NULL;
    rig_ok(rmap_portion_create(1, all->n_channel, &some, &err), &err);
    size_t segment = 0, registration = 0;
    for (size_t i = 0; i < all->n_row[RMAP_TABLE_RAY]; i++) {
        if (i % 7 == 0 || i % 5 == 1)
            rig_ok(rmap_portion_append_ray(some, all, i, segment, registration, &err), &err);
        segment += all->ray.segment_count[i];
        registration += all->ray.registration_count[i];
    }
    rig_roundtrip(&rig, RIG_SEED, some);
    some->first_ray = 3;
    rig_roundtrip(&rig, RIG_SEED, some);
    rmap_portion_clear(some);
    rig_roundtrip(&rig, RIG_SEED, some); /* none at all */
    rmap_portion_destroy(some);
    rmap_portion_destroy(all);
    rig_close(&rig);
}

/* Equal portions and an equal history of the piece give equal bytes, whatever the encoder did
 * before. */
static void test_same_bytes(void **state)
{
    (void)state;
    struct rig a, b;
    struct rmap_rows first, second, other;
    rig_open_text(&a, all_kinds);
    rig_open_text(&b, all_kinds);
    struct rmap_portion *portion = rig_trace(&a, 0, 700), *before = rig_trace(&a, 5000, 900);
    struct rmap_error err = {0};
    rig_ok(rmap_compact_encode(b.encoder, 5, before, &err), &err);
    rig_encode(&a, RIG_SEED, portion, &first);
    rig_encode(&b, RIG_SEED, portion, &second);
    for (int s = 0; s < rmap_compact_layout.n_stream; s++) {
        assert_int_equal(stream_nbytes(&first, s), stream_nbytes(&second, s));
        if (first.data[s])
            assert_memory_equal(first.data[s], second.data[s], stream_nbytes(&first, s));
    }
    rig_encode(&a, RIG_SEED, portion, &other); /* now its paths are known */
    assert_true(other.n_row[RMAP_COMPACT_OWN] < first.n_row[RMAP_COMPACT_OWN]);
    rig_decode(&a, &other, portion, RMAP_COLUMNS_ALL);
    assert_columns_equal(portion, a.decoded, RMAP_COLUMNS_ALL);
    rows_free(&first);
    rows_free(&second);
    rows_free(&other);
    rmap_portion_destroy(portion);
    rmap_portion_destroy(before);
    rig_close(&a);
    rig_close(&b);
}

/* A number off here and there is stored as a patch, and spoils nothing around it. */
static void test_patches(void **state)
{
    (void)state;
    struct rig rig;
    struct rmap_rows own;
    rig_open(&rig, RAYMAP_SOURCE_DIR "/examples/double-gauss/scene.yaml");
    struct rmap_portion *portion = rig_trace(&rig, 0, 2000);
    size_t n = portion->n_row[RMAP_TABLE_SEGMENT];
    portion->segment.position[3 * (n / 2)] = nextafterf(portion->segment.position[3 * (n / 2)], 0);
    portion->segment.position[3 * (n / 3) + 1] += 5.0f;
    portion->segment.normal[3 * (n / 4)] ^= 1;
    portion->segment.medium[n / 5] ^= 1;
    portion->ray.path_length[17] *= 1.0 + 1e-15;
    portion->ray.wavelength[18] = 555.5;
    portion->ray.weight[19] = 0.25;
    portion->colour[n / 6] ^= 3;
    rig_roundtrip(&rig, RIG_SEED, portion);
    rig_encode(&rig, RIG_SEED, portion, &own);
    assert_in_range(own.n_row[RMAP_COMPACT_PATCH], 7, 80);
    rows_free(&own);
    rmap_portion_destroy(portion);
    rig_close(&rig);
}

/* Appends rays of a portion as if medium `bent` were a gradient medium: its segments end elsewhere,
 * and have points. */
static struct rmap_portion *bend_rays(struct rmap_portion *all, int16_t bent)
{
    struct rmap_error err = {0};
    size_t first = 0;
    for (size_t i = 0; i < all->n_row[RMAP_TABLE_RAY]; i++) {
        for (uint32_t segment = 0; segment < all->ray.segment_count[i]; segment++) {
            float *end = all->segment.position + 3 * (first + segment);
            if (all->segment.medium[first + segment] != bent)
                continue;
            all->segment.event[first + segment] |= RMAP_EVENT_GRADIENT;
            for (size_t k = 0; k < 3; k++)
                end[k] += 0.1f * sinf((float)(7 * i + segment + k));
            for (size_t k = 0; k < 2 + i % 4; k++) {
                rig_ok(rmap_portion_reserve(all, RMAP_TABLE_CURVE, 1, RMAP_COLUMNS_ALL, &err),
                       &err);
                size_t row = all->n_row[RMAP_TABLE_CURVE]++;
                all->curve.ray[row] = all->ray.id[i];
                all->curve.segment[row] = segment;
                for (size_t c = 0; c < 3; c++)
                    all->curve.position[3 * row + c] = end[c] - 0.3f * (float)(k + c);
            }
        }
        first += all->ray.segment_count[i];
    }
    return all;
}

/* Points of curved segments come back, alone or with the rest, and what they cost is what they cost
 * in plain pieces; rays without them are stored as ever. */
static void test_curved(void **state)
{
    (void)state;
    struct rig rig;
    struct rmap_error err = {0};
    struct rmap_encoder *codec = NULL;
    struct rmap_rows own;
    rig_open_text(&rig, all_kinds);
    struct rmap_portion *all = bend_rays(rig_trace(&rig, 0, 4096), 2); /* fog */
    assert_true(all->n_row[RMAP_TABLE_CURVE] > 1000);
    rig_roundtrip(&rig, RIG_SEED, all);
    rig_encode(&rig, RIG_SEED, all, &own);
    assert_int_equal(own.n_row[RMAP_COMPACT_CURVE], all->n_row[RMAP_TABLE_CURVE]);
    rig_ok(rmap_encoder_create(&codec, &err), &err);
    double compact = compact_nbytes(codec, &own), plain = plain_nbytes(codec, all);
    print_message("curved: %.0f bytes, plain %.0f\n", compact, plain);
    assert_true(compact < 1.01 * plain);
    own.n_row[RMAP_COMPACT_CURVE]--;
    struct rmap_path_table *table = NULL;
    rig_ok(rmap_path_table_create(rig.model, &rig.whole, &table, &err), &err);
    assert_int_equal(rmap_compact_decode(rig.decoder, table, &own, all->n_row, RMAP_COLUMNS_ALL, 0,
                                         rig.decoded, &err),
                     RMAP_FORMAT);
    rmap_path_table_destroy(table);
    rmap_encoder_destroy(codec);
    rows_free(&own);
    rmap_portion_destroy(all);
    rig_close(&rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_kind), cmocka_unit_test(test_examples),
        cmocka_unit_test(test_predicted),  cmocka_unit_test(test_broken_promise),
        cmocka_unit_test(test_wrong_seed), cmocka_unit_test(test_selection),
        cmocka_unit_test(test_same_bytes), cmocka_unit_test(test_patches),
        cmocka_unit_test(test_curved),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
