/* SPDX-License-Identifier: MIT
 *
 * Measurements of reading: columns decoded against the reference's file inflated, and verifying
 * against decoding.
 */
#include "base/alloc.h"
#include "bench.h"
#include "bench_seed.h"
#include "io/map/map_cursor.h"
#include "io/map/map_reader.h"
#include "mpi/parallel/parts.h"
#include "mpi/parallel/progress.h"
#include "mpi/upkeep/verify_run.h"

/* All portions of a map, read by cursors of the threads. */
struct reading {
    struct rmap_cursor **cursor; /* [n_thread] */
    _Atomic uint64_t n_segment;
};

static enum rmap_status read_part(void *context, int thread, size_t first, size_t last,
                                  struct rmap_error *err)
{
    struct reading *reading = context;
    const struct rmap_portion *portion;
    for (size_t i = first; i < last; i++) {
        enum rmap_status st = rmap_cursor_read(reading->cursor[thread], i, &portion, err);
        if (st != RMAP_OK)
            return st;
        atomic_fetch_add(&reading->n_segment, portion->n_row[RMAP_TABLE_SEGMENT]);
    }
    return RMAP_OK;
}

static enum rmap_status decode(const struct rmap_bench *bench, const struct rmap_map *map,
                               rmap_column_set columns, double *seconds_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int n_thread = bench->alone.n_thread;
    struct reading reading = {.cursor = rmap_alloc((size_t)n_thread, sizeof *reading.cursor)};
    struct rmap_parts parts = {.last = rmap_map_n_portion(map),
                               .step = 1,
                               .order = RMAP_PARTS_NEAR,
                               .context = &reading,
                               .work = read_part};
    if (!reading.cursor)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    double begun = rmap_clock_seconds();
    for (int i = 0; i < n_thread; i++)
        RMAP_TRY(rmap_cursor_create(map, columns, &reading.cursor[i], err));
    RMAP_TRY(rmap_parts_run(&parts, n_thread, err));
    *seconds_ret = rmap_clock_seconds() - begun;
    if (atomic_load(&reading.n_segment) == 0)
        st = rmap_error_set(err, RMAP_INTERNAL, "nothing was decoded");
out:
    for (int i = 0; i < n_thread; i++)
        rmap_cursor_destroy(reading.cursor[i]);
    rmap_free(reading.cursor);
    return st;
}

/* What is asked of a map, in words and as columns. */
static const struct {
    const char *name;
    rmap_column_set columns;
} request[] = {
    {"all", RMAP_COLUMNS_ALL},
    {"object and event",
     RMAP_COLUMN_BIT(RMAP_SEGMENT_object) | RMAP_COLUMN_BIT(RMAP_SEGMENT_event)},
};
enum { REQUESTS = sizeof request / sizeof request[0] };

struct decoding {
    char map_path[600], seed_path[600];
    struct rmap_map *map;
    double n_segment;
};

static enum rmap_status make_map(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                 size_t encoding, struct decoding *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    double seconds;
    uint64_t n_ray = bench->quick ? 200000 : 1000000;
    (void)snprintf(self->map_path, sizeof self->map_path, "%s/decode-%s.raymap", bench->folder,
                   scene->name);
    (void)snprintf(self->seed_path, sizeof self->seed_path, "%s/decode-%s.seed", bench->folder,
                   scene->name);
    const struct rmap_bench_store store = {.path = self->map_path,
                                           .encoding = rmap_bench_encoding[encoding].encoding};
    RMAP_TRY(rmap_bench_trace(&bench->alone, bench->alone.n_thread, scene, n_ray, &store, &seconds,
                              &self->n_segment, err));
    RMAP_TRY(rmap_map_open(self->map_path, &self->map, err));
out:
    return st;
}

/* One round over both requests. */
static enum rmap_status decode_once(const struct rmap_bench *bench, const struct decoding *self,
                                    struct rmap_bench_series *series, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    double ours_s, seed_s, n = 1e-6 * self->n_segment;
    for (size_t r = 0; r < REQUESTS; r++) {
        double begun = rmap_bench_cpu();
        RMAP_TRY(decode(bench, self->map, request[r].columns, &ours_s, err));
        double between = rmap_bench_cpu();
        RMAP_TRY(rmap_seed_inflate(self->seed_path, bench->alone.n_thread, &seed_s, err));
        rmap_bench_add(&series[r], n / ours_s, n / seed_s);
        rmap_bench_add_cpu(&series[r], between - begun, rmap_bench_cpu() - between);
    }
out:
    return st;
}

static enum rmap_status decode_encoding(struct rmap_bench *bench,
                                        const struct rmap_bench_scene *scene, size_t encoding,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct decoding self = {.map = NULL};
    struct rmap_bench_series series[REQUESTS] = {0}, warming[REQUESTS] = {0};
    struct rmap_seed_result seed;
    RMAP_TRY(make_map(bench, scene, encoding, &self, err));
    RMAP_TRY(rmap_seed_record(scene->scene, scene->accel, bench->quick ? 200000 : 1000000,
                              bench->alone.n_thread, self.seed_path, &seed, err));
    RMAP_TRY(decode_once(bench, &self, warming, err));
    for (int i = 0; i < bench->n_repeat; i++)
        RMAP_TRY(decode_once(bench, &self, series, err));
    for (size_t r = 0; r < REQUESTS; r++)
        rmap_bench_report(bench, "decode_vs_seed", scene, &series[r], "million segments/s",
                          json_pack("{s:s, s:s}", "encoding", rmap_bench_encoding[encoding].name,
                                    "columns", request[r].name));
out:
    rmap_map_close(self.map);
    return st;
}

enum rmap_status rmap_bench_decode(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t e = 0; st == RMAP_OK && e < RMAP_BENCH_ENCODINGS; e++)
        st = decode_encoding(bench, scene, e, err);
    return st;
}

static enum rmap_status verify_once(const struct rmap_bench *bench, const struct decoding *self,
                                    struct rmap_bench_series *series, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_verify_result result = {0};
    double decode_s, begun = rmap_bench_cpu(), n = 1e-6 * self->n_segment;
    RMAP_TRY(rmap_verify_run(&bench->alone, self->map_path, &result, err));
    double between = rmap_bench_cpu();
    if (result.findings.n > 0)
        RMAP_TRY(rmap_error_set(err, RMAP_INTERNAL, "the map is damaged: %s",
                                result.findings.row[0].text));
    RMAP_TRY(decode(bench, self->map, RMAP_COLUMNS_ALL, &decode_s, err));
    rmap_bench_add(series, n / result.verified.seconds, n / decode_s);
    rmap_bench_add_cpu(series, between - begun, rmap_bench_cpu() - between);
out:
    rmap_verify_result_fini(&result);
    return st;
}

enum rmap_status rmap_bench_verify(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t e = 0; st == RMAP_OK && e < RMAP_BENCH_ENCODINGS; e++) {
        struct decoding self = {.map = NULL};
        struct rmap_bench_series series = {0}, warming = {0};
        st = make_map(bench, scene, e, &self, err);
        if (st == RMAP_OK)
            st = verify_once(bench, &self, &warming, err);
        for (int i = 0; st == RMAP_OK && i < bench->n_repeat; i++)
            st = verify_once(bench, &self, &series, err);
        if (st == RMAP_OK)
            rmap_bench_report(bench, "verify_vs_decode", scene, &series, "million segments/s",
                              rmap_bench_encoding_json(e));
        rmap_map_close(self.map);
    }
    return st;
}
