/* SPDX-License-Identifier: MIT
 *
 * The promise: a portion that is encoded in parts becomes the rows that it becomes in one, or says
 * that it has to be encoded in one.
 */
#include "compact/encoder.h"
#include "compact/paths.h"
#include "compact_rig.h"

/* Rays are traced part by part, into the same columns. */
struct sheaf {
    struct rmap_accel *accel;
    struct rmap_portion *portion;
    struct rmap_portion_recorder recorder;
};

static void sheaf_open(struct sheaf *sheaf, const struct rig *rig)
{
    struct rmap_error err = {0};
    rig_ok(rmap_accel_create(rig->scene, 1, &sheaf->accel, &err), &err);
    rig_ok(rmap_portion_create(1, rig->scene->channels.n, &sheaf->portion, &err), &err);
    rmap_portion_recorder_init(&sheaf->recorder, sheaf->portion);
    sheaf->recorder.unpredicted.seed = RIG_SEED;
}

static void sheaf_close(struct sheaf *sheaf)
{
    rmap_portion_destroy(sheaf->portion);
    rmap_accel_destroy(sheaf->accel);
}

static void sheaf_trace(struct sheaf *sheaf, const struct rig *rig, uint64_t first, size_t n)
{
    const struct rmap_tracer tracer = {rig->scene, sheaf->accel, RIG_SEED};
    rmap_portion_recorder_restart(&sheaf->recorder, first);
    for (uint64_t ray = first; ray < first + n; ray++)
        rmap_trace_ray(&tracer, ray, &sheaf->recorder.base);
    assert_int_equal(sheaf->recorder.status, RMAP_OK);
}

/* False: it has to be encoded in one. Parts are of 1, 2, ... rays up to n_part. */
static bool encode_parts(struct rig *rig, struct sheaf *sheaf, uint64_t first, size_t n,
                         size_t n_part)
{
    struct rmap_error err = {0};
    bool whole = false;
    size_t count = 1;
    rmap_compact_encode_begin(rig->encoder, RIG_SEED, first);
    for (size_t i = 0; i < n && !whole; i += count, count = count < n_part ? count + 1 : n_part) {
        count = count < n - i ? count : n - i;
        sheaf_trace(sheaf, rig, first + i, count);
        rig_ok(rmap_compact_encode_part(rig->encoder, sheaf->portion, &whole, &err), &err);
    }
    if (!whole)
        rig_ok(rmap_compact_encode_end(rig->encoder, &whole, &err), &err);
    return !whole;
}

static void resolve_afresh(struct rig *rig, struct rmap_rows *rows)
{
    struct rmap_error err = {0};
    rmap_path_book_destroy(rig->book);
    rig->book = NULL;
    rig_ok(rmap_path_book_create(&rig->book, &err), &err);
    rig_ok(rmap_compact_resolve(rig->encoder, rig->book, rows, &err), &err);
}

/* Whether parts did for the rays; then the rows are held against those of the portion in one. */
static bool check_parts(struct rig *rig, uint64_t first, size_t n, size_t n_part)
{
    struct rmap_error err = {0};
    struct rmap_rows rows, own, entered;
    struct sheaf sheaf;
    sheaf_open(&sheaf, rig);
    bool did = encode_parts(rig, &sheaf, first, n, n_part);
    if (did) {
        resolve_afresh(rig, &rows);
        rows_copy(&rows, false, &own);
        rows_copy(&rows, true, &entered);
        sheaf_trace(&sheaf, rig, first, n);
        rig_ok(rmap_compact_encode(rig->encoder, RIG_SEED, sheaf.portion, &err), &err);
        resolve_afresh(rig, &rows);
        for (int s = 0; s < rmap_compact_layout.n_stream; s++) {
            const struct rmap_rows *parts = is_whole(s) ? &entered : &own;
            assert_int_equal(stream_nbytes(parts, s), stream_nbytes(&rows, s));
            if (stream_nbytes(&rows, s) > 0)
                assert_memory_equal(parts->data[s], rows.data[s], stream_nbytes(&rows, s));
        }
        rows_free(&own);
        rows_free(&entered);
    }
    sheaf_close(&sheaf);
    return did;
}

static void test_same_rows(void **state)
{
    (void)state;
    static const char *const scene[] = {"double-gauss", "room"};
    for (size_t i = 0; i < 2; i++) {
        struct rig rig;
        char path[1000];
        (void)snprintf(path, sizeof path, "%s/examples/%s/scene.yaml", RAYMAP_SOURCE_DIR, scene[i]);
        rig_open(&rig, path);
        assert_true(rmap_compact_in_parts(rig.model));
        assert_true(check_parts(&rig, 0, RMAP_BLOCK_RAYS, RMAP_PART_RAYS));
        assert_true(check_parts(&rig, RMAP_BLOCK_RAYS, RMAP_BLOCK_RAYS, 7));
        assert_true(check_parts(&rig, 3 * RMAP_BLOCK_RAYS - 100, 100, RMAP_PART_RAYS));
        assert_true(check_parts(&rig, UINT64_C(1) << 40, 5, 1));
        rig_close(&rig);
    }
}

/* Most rays go past the ball, whose medium absorbs: some unpredicted are no trouble. */
static const char some_strays[] = "raymap: 1\n"
                                  "media: {air: {index: 1}, fog: {index: 1, absorption: %s}}\n"
                                  "surfaces:\n"
                                  "  white: {type: lambert, reflectance: 0.9}\n"
                                  "  clear: {type: fresnel}\n"
                                  "geometries:\n"
                                  "  plate: {type: rectangle, size: [90, 90]}\n"
                                  "  ball: {type: sphere, radius: %s}\n"
                                  "objects:\n"
                                  "  - {name: floor, geometry: plate, at: [0, 0, -9], surface: "
                                  "white, front: air, back: air}\n"
                                  "  - {name: ball, geometry: ball, at: [5, 0, 0], surface: clear, "
                                  "inside: fog, outside: air}\n"
                                  "sources:\n"
                                  "  - {name: bulb, type: point, flux: 1 W, medium: air}\n";

static size_t strays_in(const struct rig *rig, size_t n)
{
    struct rmap_unpredicted unpredicted;
    rmap_portion_destroy(rig_trace_told(rig, 0, n, &unpredicted));
    return unpredicted.n;
}

static void test_strays(void **state)
{
    (void)state;
    static const struct {
        const char *absorption, *radius;
        bool did;
    } ball[] = {{"0.01", "0.7", true}, {"0.05", "4", false}, {"0", "4", true}};
    for (size_t i = 0; i < sizeof ball / sizeof *ball; i++) {
        struct rig rig;
        char text[2000];
        (void)snprintf(text, sizeof text, some_strays, ball[i].absorption, ball[i].radius);
        rig_open_text(&rig, text);
        size_t n_stray = strays_in(&rig, RMAP_BLOCK_RAYS);
        print_message("ball of %s: %zu unpredicted of %d\n", ball[i].radius, n_stray,
                      RMAP_BLOCK_RAYS);
        assert_int_equal(n_stray > 0, i < 2);
        assert_int_equal(check_parts(&rig, 0, RMAP_BLOCK_RAYS, RMAP_PART_RAYS), ball[i].did);
        rig_close(&rig);
    }
}

/* Parts that hold a curve would be given up and traced again: such scenes do without. */
static void test_curved(void **state)
{
    (void)state;
    struct rmap_error err = {0};
    struct rig rig;
    struct sheaf sheaf;
    bool whole = false;
    rig_open(&rig, RAYMAP_SOURCE_DIR "/examples/selfoc/scene.yaml");
    assert_false(rmap_compact_in_parts(rig.model));
    sheaf_open(&sheaf, &rig);
    sheaf_trace(&sheaf, &rig, 0, 100);
    assert_true(sheaf.portion->n_row[RMAP_TABLE_CURVE] > 0);
    rmap_compact_encode_begin(rig.encoder, RIG_SEED, 0);
    rig_ok(rmap_compact_encode_part(rig.encoder, sheaf.portion, &whole, &err), &err);
    assert_true(whole);
    sheaf_close(&sheaf);
    rig_close(&rig);
}

/* Who says nothing of unpredicted, or of those of another seed, has his portion encoded in one. */
static void test_unknown_strays(void **state)
{
    (void)state;
    struct rmap_error err = {0};
    struct rig rig;
    struct sheaf sheaf;
    bool whole = false;
    rig_open(&rig, RAYMAP_SOURCE_DIR "/examples/double-gauss/scene.yaml");
    sheaf_open(&sheaf, &rig);
    sheaf_trace(&sheaf, &rig, 0, 10);
    rmap_compact_encode_begin(rig.encoder, RIG_SEED + 1, 0);
    rig_ok(rmap_compact_encode_part(rig.encoder, sheaf.portion, &whole, &err), &err);
    assert_true(whole);
    sheaf.portion->unpredicted = NULL;
    rmap_compact_encode_begin(rig.encoder, RIG_SEED, 0);
    rig_ok(rmap_compact_encode_part(rig.encoder, sheaf.portion, &whole, &err), &err);
    assert_true(whole);
    sheaf_close(&sheaf);
    rig_close(&rig);
}

/* A promise that does not hold is found out in one part of a block or another. */
static void test_broken_promise(void **state)
{
    (void)state;
    struct rmap_error err = {0};
    struct rig rig;
    struct sheaf sheaf;
    enum rmap_status st = RMAP_OK;
    rig_open(&rig, RAYMAP_SOURCE_DIR "/examples/double-gauss/scene.yaml");
    sheaf_open(&sheaf, &rig);
    rmap_compact_encode_begin(rig.encoder, RIG_SEED, 0);
    for (size_t i = 0; i < RMAP_BLOCK_RAYS && st == RMAP_OK; i += RMAP_PART_RAYS) {
        bool whole = false;
        sheaf_trace(&sheaf, &rig, i, RMAP_PART_RAYS);
        for (size_t k = 0; k < sheaf.portion->n_row[RMAP_TABLE_SEGMENT]; k++)
            sheaf.portion->segment.position[3 * k] =
                nextafterf(sheaf.portion->segment.position[3 * k], 1e9F);
        st = rmap_compact_encode_part(rig.encoder, sheaf.portion, &whole, &err);
        assert_false(whole);
    }
    assert_int_equal(st, RMAP_INTERNAL);
    sheaf_close(&sheaf);
    rig_close(&rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_same_rows),
                                       cmocka_unit_test(test_strays), cmocka_unit_test(test_curved),
                                       cmocka_unit_test(test_unknown_strays),
                                       cmocka_unit_test(test_broken_promise)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
