/* SPDX-License-Identifier: MIT
 *
 * The promise: of a map one bit of which is not what it was, anywhere in any of its files, every
 * reader says what it says of the whole map, or tells that the map is damaged. Nothing crashes,
 * hangs, or asks for memory that a small map does not warrant. Seeded flips; with arguments K and M
 * each K-th byte of every file of map M: plain, compact.
 */
#include <fcntl.h>
#include <limits.h>
#include <malloc.h>
#include <sys/resource.h>
#include <sys/stat.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "analysis/figure/figure_draw.h"
#include "analysis/figure/figure_energy.h"
#include "analysis/paths/path_count.h"
#include "analysis/query/fold.h"
#include "analysis/query/query.h"
#include "analysis/report/ray_report.h"
#include "analysis/report/ray_report_print.h"
#include "base/rng.h"
#include "io/map/map_chunks.h"
#include "io/map/map_cursor.h"
#include "io/map/map_directory.h"
#include "io/map/map_reader.h"
#include "io/recovery/verify.h"
#include "io/recovery/verify_piece.h"
#include "io/recovery/verify_rays.h"
#include "io/write/index_writer.h"
#include "tests/format/map_fixture.h"

enum { FLIPS = 800, BLOCK = 20, N_SHARD = 2, BLOCKS = 2, FILES = 3, MAPS = RMAP_ENCODING_COUNT };

struct made {
    struct fixture fixture;
    char file[FILES][256];
    size_t nbytes[FILES];
    int n_file;
    uint64_t answer;
};

/* ---- what readers say ---- */

struct answer {
    XXH3_state_t state;
    bool damaged; /* a reader told of damage */
};

static void hear(struct answer *self, const void *data, size_t nbytes)
{
    if (nbytes > 0)
        (void)XXH3_64bits_update(&self->state, data, nbytes);
}

/* False: it told of damage. Memory that cannot be had is no such word: the maps are tiny. */
static bool good(struct answer *self, enum rmap_status st, const struct rmap_error *err)
{
    if (st != RMAP_OK && st != RMAP_FORMAT)
        fail_msg("status %d: %s", (int)st, err->text);
    self->damaged = self->damaged || st != RMAP_OK;
    return st == RMAP_OK;
}

static void read_columns(const struct rmap_map *map, struct answer *self)
{
    struct rmap_cursor *cursor = NULL;
    struct rmap_error err = {0};
    fixture_must(rmap_cursor_create(map, RMAP_COLUMNS_ALL, &cursor, &err), &err);
    for (size_t i = 0; i < rmap_map_n_portion(map); i++) {
        const struct rmap_portion *portion = NULL;
        if (!good(self, rmap_cursor_read(cursor, i, &portion, &err), &err))
            continue;
        struct rmap_digest digest = rmap_portion_digest(portion);
        hear(self, &digest, sizeof digest);
    }
    rmap_cursor_destroy(cursor);
}

static void draw(const struct rmap_map *map, const struct rmap_portion *rays, struct answer *self)
{
    const struct rmap_paint_request request = {.kind = RMAP_PAINT_PATH,
                                               .scene = rmap_map_scene(map),
                                               .rays = rays,
                                               .flux_per_weight = rmap_map_flux_per_weight(map)};
    struct rmap_ray_paint *paint = NULL;
    struct rmap_svg *svg = NULL;
    struct rmap_error err = {0};
    const char *text = NULL;
    size_t nbytes = 0;
    fixture_must(rmap_ray_paint_create(&request, &paint, &err), &err);
    const struct rmap_figure_draw given = {
        .title = "t", .kind = RMAP_VIEW_YZ, .paint = paint, .map = map};
    if (good(self, rmap_figure_draw(rmap_map_scene(map), rays, &given, &svg, &err), &err) &&
        good(self, rmap_svg_finish(svg, &text, &nbytes, &err), &err))
        hear(self, text, nbytes);
    rmap_svg_destroy(svg);
    rmap_ray_paint_destroy(paint);
}

/* Of what paths answer, and of what they do not. */
static void query(const struct rmap_map *map, struct answer *self)
{
    static const char *const text[] = {"registered(film) and hit(lens, reflect_specular) >= 1",
                                       "registered(film, rect(0, 0, 4, 4)) or medium(glass) > 2",
                                       "hit(*) >= 4 and source(lamp)"};
    enum { N = sizeof text / sizeof *text };
    const struct rmap_scene *scene = rmap_map_scene(map);
    struct rmap_criterion *criterion[N] = {0};
    struct rmap_count count[N] = {0};
    struct rmap_portion *rays = NULL;
    struct rmap_error err = {0};
    for (int c = 0; c < N; c++) {
        fixture_must(rmap_criterion_compile(text[c], scene, &criterion[c], &err), &err);
        fixture_must(rmap_count_init(&count[c], scene->n_source, &err), &err);
    }
    fixture_must(rmap_portion_create(64, scene->channels.n, &rays, &err), &err);
    if (good(self,
             rmap_query_scan(map, criterion, N, 0, rmap_map_n_portion(map), count, rays, 50, &err),
             &err)) {
        for (int c = 0; c < N; c++) {
            hear(self, &count[c].rays, sizeof count[c].rays);
            hear(self, count[c].source_weight, scene->n_source * sizeof(double));
        }
        struct rmap_digest digest = rmap_portion_digest(rays);
        hear(self, &digest, sizeof digest);
        draw(map, rays, self);
    }
    for (int c = 0; c < N; c++) {
        rmap_criterion_destroy(criterion[c]);
        rmap_count_fini(&count[c]);
    }
    rmap_portion_destroy(rays);
}

static void hear_json(struct answer *self, json_t *json)
{
    char *text = json_dumps(json, JSON_SORT_KEYS | JSON_REAL_PRECISION(12));
    assert_non_null(text);
    hear(self, text, strlen(text));
    free(text);
    json_decref(json);
}

static void report(const struct rmap_map *map, struct answer *self)
{
    struct rmap_ray_report *ray = NULL;
    struct rmap_error err = {0};
    if (good(self, rmap_ray_report_read(map, BLOCK + 7, &ray, &err), &err))
        hear_json(self, rmap_ray_report_json(ray));
    rmap_ray_report_destroy(ray);
}

/* All portions added to a new state of a kind; NULL where damage was told. */
static void *fold_all(const struct rmap_fold *fold, struct answer *self)
{
    struct rmap_fold_scanner *scanner = NULL;
    struct rmap_error err = {0};
    void *state = NULL;
    fixture_must(rmap_fold_scanner_create(fold, &scanner, &err), &err);
    fixture_must(fold->kind->create(fold->context, &state, &err), &err);
    enum rmap_status st =
        rmap_fold_scanner_add(scanner, state, 0, rmap_map_n_portion(fold->map), &err);
    if (!good(self, st, &err)) {
        fold->kind->destroy(state);
        state = NULL;
    }
    rmap_fold_scanner_destroy(scanner);
    return state;
}

static void balance(const struct rmap_map *map, struct answer *self)
{
    const struct rmap_energy_scope scope = {.scene = rmap_map_scene(map), .ends = true};
    const struct rmap_fold fold = {.kind = &rmap_energy_kind,
                                   .context = &scope,
                                   .map = map,
                                   .columns = rmap_energy_columns(&scope)};
    struct rmap_energy_sums *sums = fold_all(&fold, self);
    struct rmap_energy *energy = NULL;
    struct rmap_error err = {0};
    if (sums) {
        rmap_energy_sums_take_tally(sums, rmap_map_tally(map));
        if (good(self, rmap_energy_create(map, "a map", NULL, sums, &energy, &err), &err))
            hear_json(self, rmap_energy_json(energy));
    }
    rmap_energy_destroy(energy);
    rmap_energy_sums_destroy(sums);
}

static void count_paths(const struct rmap_map *map, enum rmap_path_level level, struct answer *self)
{
    const struct rmap_path_view view = {.level = level};
    struct rmap_path_keys *keys = NULL;
    struct rmap_error err = {0};
    fixture_must(rmap_path_keys_create(rmap_map_scene(map), &view, &keys, &err), &err);
    struct rmap_path_counting counting = {
        .map = map, .keys = keys, .detector = -1, .most_classes = 1000, .most_cells = 1000};
    const struct rmap_fold fold = {.kind = &rmap_path_count_kind,
                                   .context = &counting,
                                   .map = map,
                                   .columns = rmap_path_count_columns(&counting),
                                   .deferred = 0};
    struct rmap_path_counts *counts = fold_all(&fold, self);
    if (counts) {
        struct rmap_key sum = {0}; /* in whatever order they came */
        for (size_t i = 0; i < counts->classes.n; i++) {
            sum.low += counts->classes.entry[i].key.low;
            sum.high += counts->classes.entry[i].key.high;
        }
        hear(self, &sum, sizeof sum);
        hear(self, &counts->classes.n, sizeof counts->classes.n);
        hear(self, &counts->cells.n, sizeof counts->cells.n);
        hear(self, &counts->total.rays, sizeof counts->total.rays);
    }
    rmap_path_count_kind.destroy(counts);
    rmap_path_keys_destroy(keys);
}

static bool finds(const char *path)
{
    struct rmap_verification *verification = NULL;
    struct rmap_findings findings = {0};
    struct rmap_chunk_verifier *chunks = NULL;
    struct rmap_cursor *cursor = NULL;
    struct rmap_error err = {0};
    enum rmap_status st = rmap_verification_open(path, &verification, &findings, &err);
    for (size_t i = 0; st == RMAP_OK && i < verification->claimed->n_piece; i++)
        st = rmap_verify_piece(verification, i, &findings, &err);
    if (st == RMAP_OK)
        st = rmap_chunk_verifier_create(verification, &chunks, &err);
    for (size_t i = 0; st == RMAP_OK && i < verification->content->n_chunk; i++)
        st = rmap_verify_chunk(chunks, i, &findings, &err);
    if (st == RMAP_OK && verification->map)
        st = rmap_cursor_create(verification->map, RMAP_COLUMNS_ALL, &cursor, &err);
    for (size_t i = 0; cursor && st == RMAP_OK && i < rmap_map_n_portion(verification->map); i++)
        st = rmap_verify_portion(verification, cursor, i, NULL, &findings, &err);
    if (st == RMAP_OK && verification->map)
        st = rmap_verify_sums(verification, NULL, &findings, &err);
    fixture_must(st, &err);
    bool found = findings.n > 0;
    rmap_cursor_destroy(cursor);
    rmap_chunk_verifier_destroy(chunks);
    rmap_verification_close(verification);
    rmap_findings_fini(&findings);
    return found;
}

/* Every reader of the map at a path. */
static struct answer ask(const char *path)
{
    struct answer self = {.damaged = false};
    struct rmap_map *map = NULL;
    struct rmap_map_summary summary;
    struct rmap_error err = {0};
    (void)XXH3_64bits_reset(&self.state);
    if (!good(&self, rmap_map_open(path, &map, &err), &err))
        return self;
    rmap_map_summarise(map, &summary);
    hear(&self, summary.n_row, sizeof summary.n_row);
    (void)good(&self, rmap_map_check_pieces(map, &err), &err);
    query(map, &self);
    count_paths(map, RMAP_PATH_SURFACE, &self);
    count_paths(map, RMAP_PATH_OBJECT, &self);
    balance(map, &self);
    report(map, &self);
    read_columns(map, &self);
    rmap_map_close(map);
    return self;
}

/* ---- maps and flips ---- */

static void list_files(struct made *self)
{
    static const char *const name[FILES] = {"map.h5", "shard-00000/piece-00000.h5",
                                            "shard-00001/piece-00000.h5"};
    struct stat info;
    for (int k = 0; k < FILES; k++) {
        char *path = self->file[self->n_file];
        (void)snprintf(path, sizeof self->file[0], "%s/%s", self->fixture.map, name[k]);
        if (stat(path, &info) == 0)
            self->nbytes[self->n_file++] = (size_t)info.st_size;
    }
}

/* Rays of few histories, as of a real map: compact pieces have them once each. */
static struct rmap_portion *repeating(struct fixture *f, uint64_t block, uint64_t rays)
{
    struct rmap_portion *portion = NULL;
    struct rmap_portion_recorder recorder;
    struct rmap_tally_recorder counting;
    assert_int_equal(rmap_portion_create(rays, f->scene->channels.n, &portion, NULL), RMAP_OK);
    rmap_portion_recorder_init(&recorder, portion);
    rmap_tally_recorder_init(&counting, f->tally, &recorder.base);
    for (uint64_t ray = 0; ray < rays; ray++)
        fixture_ray(&counting.base, f->scene, 2 * block + ray % 6);
    portion->first_ray = block * rays;
    for (uint64_t i = 0; i < rays; i++)
        portion->ray.id[i] = block * rays + i;
    return portion;
}

static void make(struct made *self, enum rmap_encoding encoding)
{
    struct fixture *f = &self->fixture;
    struct rmap_error err = {0};
    fixture_init(f);
    f->run.encoding = encoding;
    fixture_must(rmap_map_create(f->map, false, NULL, NULL, &err), &err);
    for (uint64_t k = 0; k < N_SHARD; k++) /* of two portions each */
        fixture_must(fixture_write_blocks(f, (int)k, BLOCKS * k, BLOCKS * (k + 1), 0, repeating,
                                          BLOCK, &err),
                     &err);
    fixture_must(rmap_index_write(f->map, &f->run, f->tally, true, &err), &err);
    list_files(self);
    assert_int_equal(self->n_file, FILES);
    struct answer whole = ask(f->map), again = ask(f->map);
    assert_false(whole.damaged);
    assert_false(finds(f->map));
    self->answer = XXH3_64bits_digest(&whole.state);
    assert_true(self->answer == XXH3_64bits_digest(&again.state));
}

static void flip(const struct made *self, int file, size_t at, int bit, bool verified)
{
    uint8_t was, is;
    int64_t live = rmap_alloc_live();
    int fd = open(self->file[file], O_RDWR);
    assert_true(fd >= 0);
    assert_int_equal(pread(fd, &was, 1, (off_t)at), 1);
    is = (uint8_t)(was ^ 1u << bit);
    assert_int_equal(pwrite(fd, &is, 1, (off_t)at), 1);
    struct answer said = ask(self->fixture.map);
    if (!said.damaged && XXH3_64bits_digest(&said.state) != self->answer)
        fail_msg("%s, byte %zu, bit %d: another answer", self->file[file], at, bit);
    if (verified && !finds(self->fixture.map))
        fail_msg("%s, byte %zu, bit %d: verify finds nothing", self->file[file], at, bit);
    assert_int_equal(pwrite(fd, &was, 1, (off_t)at), 1);
    assert_int_equal(close(fd), 0);
    assert_true(rmap_alloc_live() == live);
}

/* ---- tests ---- */

static size_t every; /* 0: FLIPS seeded ones */
static int only;     /* that map */

/* Over all files alike, so that short ones are not passed over. */
static void flip_seeded(const struct made *maps)
{
    for (uint64_t k = 0; k < FLIPS; k++) {
        double u[4];
        rmap_rng(2032, k, 0, 0, u);
        const struct made *map = &maps[k % MAPS];
        int file = (int)(u[0] * map->n_file);
        flip(map, file, (size_t)(u[1] * (double)map->nbytes[file]), (int)(u[2] * 8),
             k / MAPS % 16 == 0);
    }
}

static void flip_every(const struct made *map)
{
    for (int file = 0; file < map->n_file; file++)
        for (size_t at = 0; at < map->nbytes[file]; at += every)
            flip(map, file, at, (int)(at % 8), at / every % 32 == 0);
}

static void readers_say_the_same_or_tell(void **state)
{
    static struct made maps[MAPS];
    const struct rlimit room = {UINT64_C(3) << 30, UINT64_C(3) << 30};
    (void)state;
    /* Memory given back to the system and had again costs more than all else here. */
    (void)mallopt(M_MMAP_THRESHOLD, 1 << 30);
    (void)mallopt(M_TRIM_THRESHOLD, INT_MAX);
#ifndef __SANITIZE_ADDRESS__ /* which reserves terabytes */
    assert_int_equal(setrlimit(RLIMIT_AS, &room), 0);
#endif
    for (int k = 0; k < MAPS; k++)
        make(&maps[k], (enum rmap_encoding)k);
    if (every == 0)
        flip_seeded(maps);
    else
        flip_every(&maps[only % MAPS]);
    for (int k = 0; k < MAPS; k++)
        fixture_fini(&maps[k].fixture);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(readers_say_the_same_or_tell)};
    if (argc == 3) {
        every = (size_t)strtoul(argv[1], NULL, 10);
        only = atoi(argv[2]);
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
