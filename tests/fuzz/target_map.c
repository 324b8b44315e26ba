/* SPDX-License-Identifier: MIT
 *
 * A map from a stranger who knows the format: any number in it may be any other, with checksums and
 * seals that hold. Opening, reading, querying and reporting end in an answer or in RMAP_FORMAT;
 * nothing crashes, hangs or asks for memory that the files do not warrant.
 *
 * The input is a list of changes, 16 bytes each: {u8 kind, u8 small, u16 which, u32 element, u64
 * value}; see `change`. The first kind's highest two bits choose the map: in the compact encoding,
 * with curved segments.
 */
#include <stdlib.h>
#include <string.h>

#include "analysis/query/query.h"
#include "analysis/report/ray_report.h"
#include "analysis/report/ray_report_print.h"
#include "io/map/map_chunks.h"
#include "io/map/map_cursor.h"
#include "io/map/map_directory.h"
#include "io/map/map_reader.h"
#include "io/map/map_scan.h"
#include "io/write/index_writer.h"
#include "map_analysis.h"
#include "map_image.h"
#include "target.h"
#include "tests/format/map_fixture.h"

const unsigned rmap_fuzz_rounds = 60;

enum { BLOCK = 40, N_BLOCK = 2, OP = 16, N_IMAGE = 2 * RMAP_ENCODING_COUNT };
_Static_assert(N_IMAGE == 4, "two bits choose");

struct change {
    uint8_t kind, small;
    uint16_t which;
    uint32_t element;
    uint64_t value;
};
_Static_assert(sizeof(struct change) == OP, "a change is its bytes");

static struct map_image images[N_IMAGE], *image = &images[0];

static void finish(void)
{
    for (int k = 0; k < N_IMAGE; k++)
        map_image_fini(&images[k]);
}

/* A map of two shards with a piece each. */
static void make_map(enum rmap_encoding encoding, struct map_image *made)
{
    struct fixture f;
    struct rmap_error err = {0};
    fixture_init(&f);
    f.run.encoding = encoding;
    fixture_must(rmap_map_create(f.map, false, NULL, NULL, &err), &err);
    for (int k = 0; k < N_BLOCK; k++)
        fixture_must(fixture_write_shard(&f, k, (uint64_t)k, (uint64_t)k + 1, BLOCK, 0, &err),
                     &err);
    fixture_must(rmap_index_write(f.map, &f.run, f.tally, true, &err), &err);
    memcpy(made->directory, f.directory, sizeof f.directory);
    memcpy(made->path, f.map, sizeof f.map);
    map_image_load(made);
    rmap_tally_destroy(f.tally);
    rmap_scene_destroy(f.scene);
    rmap_bundle_destroy(f.bundle);
}

static void begin(void)
{
    if (images[0].n_file > 0)
        return;
    for (int k = 0; k < N_IMAGE; k++) {
        (void)setenv("FIXTURE", k < RMAP_ENCODING_COUNT ? "" : "curved", 1);
        make_map((enum rmap_encoding)(k % RMAP_ENCODING_COUNT), &images[k]);
    }
    (void)atexit(finish);
}

/* ---- what is done to the map ---- */

static void change(const struct change *op)
{
    int field = op->which % image->n_field;
    size_t element = op->element % image->field[field].n;
    uint64_t was = map_image_get(image, field, element);
    size_t chunk = op->which;
    int offsets = map_image_field(image, "chunk/offset");
    switch (op->kind % 8) {
    case 0:
    case 1:
        map_image_set(image, field, element, op->value);
        break;
    case 2:
        map_image_set(image, field, element, was + op->small - 128);
        break;
    case 3:
        map_image_set(image, field, element, was ^ (UINT64_C(1) << op->small % 64));
        break;
    case 4: /* as its neighbour */
        map_image_set(image, field, element, map_image_get(image, field, element ^ 1));
        break;
    case 5:
        map_image_poke_chunk(image, chunk % image->field[offsets].n, op->element, op->small);
        break;
    case 6:
        map_image_set_in_chunk(image, chunk % image->field[offsets].n, op->element % 1500,
                               op->value);
        break;
    default:
        map_image_cut(image, 1 + op->which % (image->n_file - 1), op->element);
        break;
    }
}

/* ---- what is done with the map ---- */

static void read_columns(const struct rmap_map *map, rmap_column_set columns)
{
    struct rmap_cursor *cursor = NULL;
    struct rmap_error err = {0};
    rmap_fuzz_demand(rmap_cursor_create(map, columns, &cursor, &err) == RMAP_OK, "a cursor");
    for (size_t i = 0; i < rmap_map_n_portion(map) && i < 16; i++) {
        const struct rmap_portion *portion = NULL;
        if (map_analysis_judge(rmap_cursor_read(cursor, i, &portion, &err), &err) != RMAP_OK)
            continue;
        if (columns == RMAP_COLUMNS_ALL) {
            struct rmap_portion_summary summary;
            rmap_portion_summarise(portion, &summary);
            (void)rmap_portion_digest(portion);
        }
    }
    rmap_cursor_destroy(cursor);
}

static void query(const struct rmap_map *map)
{
    static const char *const text[] = {
        "registered(film) and hit(lens, reflect_specular) >= 1 and wavelength < 600 nm",
        "registered(film, rect(0, 0, 4, 4)) or medium(glass) > 2"};
    enum { N = 2 };
    const struct rmap_scene *scene = rmap_map_scene(map);
    struct rmap_criterion *criterion[N] = {0};
    struct rmap_count count[N] = {0};
    struct rmap_portion *rays = NULL;
    struct rmap_error err = {0};
    enum rmap_status st = RMAP_OK;
    for (int c = 0; c < N; c++) {
        RMAP_TRY(rmap_criterion_compile(text[c], scene, &criterion[c], &err));
        RMAP_TRY(rmap_count_init(&count[c], scene->n_source, &err));
    }
    RMAP_TRY(rmap_portion_create(64, scene->channels.n, &rays, &err));
    (void)map_analysis_judge(
        rmap_query_scan(map, criterion, N, 0, rmap_map_n_portion(map), count, rays, 50, &err),
        &err);
    double flux, sigma;
    rmap_count_flux(&count[0], map, &flux, &sigma);
out:
    for (int c = 0; c < N; c++) {
        rmap_criterion_destroy(criterion[c]);
        rmap_count_fini(&count[c]);
    }
    rmap_portion_destroy(rays);
}

static void report(const struct rmap_map *map, uint64_t ray)
{
    struct rmap_ray_report *report = NULL;
    struct rmap_error err = {0};
    if (map_analysis_judge(rmap_ray_report_read(map, ray, &report, &err), &err) == RMAP_OK)
        json_decref(rmap_ray_report_json(report));
    rmap_ray_report_destroy(report);
}

static void use(unsigned pick)
{
    struct rmap_map *map = NULL;
    struct rmap_map_summary summary;
    struct rmap_error err = {0};
    if (map_analysis_judge(rmap_map_open(image->path, &map, &err), &err) != RMAP_OK)
        return;
    rmap_map_summarise(map, &summary);
    (void)map_analysis_judge(rmap_map_check_pieces(map, &err), &err);
    for (size_t k = 0; k <= 3; k++)
        rmap_fuzz_demand(rmap_map_split(map, 3, k) <= rmap_map_n_portion(map), "parts");
    read_columns(map, RMAP_COLUMNS_ALL);
    query(map);
    report(map, BLOCK * N_BLOCK - 1);
    map_analysis(map, pick);
    rmap_map_close(map);
}

/* A piece as an index is made from: through HDF5, its tables and attributes changed. */
static void read_pieces(void)
{
    for (int k = 0; k < N_BLOCK; k++) {
        struct rmap_map_content content = {0};
        struct rmap_piece_origin origin = {0};
        struct rmap_error err = {0};
        enum rmap_status st = rmap_piece_read(image->path, k, 0, &content, &origin, &err);
        if (map_analysis_judge(st, &err) == RMAP_OK &&
            rmap_map_content_sort(&content, &err) == RMAP_OK)
            (void)map_analysis_judge(rmap_map_content_check(&content, image->path, &err), &err);
        rmap_map_content_fini(&content);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    begin();
    int64_t live = rmap_alloc_live();
    const unsigned pick = nbytes > 1 ? data[1] : 0;
    image = &images[nbytes > 0 ? data[0] / 64 : 0];
    map_image_reset(image);
    for (; nbytes >= OP; data += OP, nbytes -= OP) {
        struct change op;
        memcpy(&op, data, OP);
        change(&op);
    }
    map_image_store(image);
    use(pick);
    read_pieces();
    if (pick % 4 == 1)
        map_analysis_verify(image->path);
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
    return 0;
}

/* Every field's first or another element set to something else, field by field; then chunks. Of
 * maps with curved segments every seventh of them. */
size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    static const uint64_t value[] = {0, 1, UINT32_MAX, UINT64_MAX, UINT64_C(1) << 40, 65536};
    unsigned n_value = sizeof value / sizeof *value;
    begin();
    for (int e = 0; e < N_IMAGE; e++) {
        const struct map_image *map = &images[e];
        const unsigned each = e < RMAP_ENCODING_COUNT ? 1 : 7;
        const unsigned n_field = (unsigned)map->n_field;
        const unsigned n_chunk = (unsigned)map->field[map_image_field(map, "chunk/offset")].n;
        const unsigned at = k * each;
        struct change op = {0, (uint8_t)at, (uint16_t)at, at % 3, value[k % n_value]};
        if (at >= n_field + 2 * n_chunk) {
            k -= (n_field + 2 * n_chunk + each - 1) / each;
            continue;
        }
        if (cap < OP)
            return 0;
        if (at >= n_field) {
            op.kind = (at - n_field) < n_chunk ? 5 : 6;
            op.which = (uint16_t)(at - n_field);
            op.element = at % 40;
        }
        op.kind |= (uint8_t)(e * 64);
        memcpy(to, &op, OP);
        return OP;
    }
    return 0;
}
