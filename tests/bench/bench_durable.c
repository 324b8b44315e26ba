/* SPDX-License-Identifier: MIT
 *
 * What it costs that a killed run loses little: flushing against never flushing, and checksums
 * against the trace that they are part of.
 */
#include "base/alloc.h"
#include "bench.h"
#include "io/codec/codec.h"
#include "io/map/map_cursor.h"
#include "io/map/map_reader.h"

/* So often that what a flush costs stands out of what else the machine does; how often it comes by
 * default is known. */
#define FLUSH_PORTIONS 2

/* Processor seconds per flush, repeat by repeat. */
struct flush_cost {
    double seconds[RMAP_BENCH_REPEAT_MAX];
    int n;
};

static enum rmap_status timed_trace(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                    uint64_t n_ray, const struct rmap_bench_store *store,
                                    struct rmap_bench_cost *sum, double *n_segment,
                                    struct rmap_error *err)
{
    double seconds, begun = rmap_bench_cpu();
    enum rmap_status st = rmap_bench_trace(&bench->alone, bench->alone.n_thread, scene, n_ray,
                                           store, &seconds, n_segment, err);
    sum->wall_s += seconds;
    sum->cpu_s += rmap_bench_cpu() - begun;
    return st;
}

/* With, without, without, with: a machine that slows down steadily slows both down. */
static enum rmap_status flush_once(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                   struct rmap_bench_store *store, struct rmap_bench_series *series,
                                   struct flush_cost *cost, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench_cost with = {0}, without = {0};
    double n_segment;
    uint64_t n_flush = 0;
    store->flush_portions = FLUSH_PORTIONS;
    store->n_flush = &n_flush;
    for (int i = 0; i < 4; i++) {
        store->never_flush = i == 1 || i == 2;
        RMAP_TRY(timed_trace(bench, scene, bench->quick ? 200000 : 500000, store,
                             store->never_flush ? &without : &with, &n_segment, err));
    }
    rmap_bench_add_speeds(series, 2.0 * n_segment, with, without);
    if (cost->n < RMAP_BENCH_REPEAT_MAX && n_flush > 0)
        cost->seconds[cost->n++] = (with.cpu_s - without.cpu_s) / (double)n_flush;
out:
    store->flush_portions = 0;
    store->n_flush = NULL;
    return st;
}

static enum rmap_status measure_flush(struct rmap_bench *bench,
                                      const struct rmap_bench_scene *scene, size_t encoding,
                                      struct rmap_bench_store *store, double *seconds_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench_series series = {0};
    struct flush_cost cost = {.n = 0};
    for (int i = 0; i < bench->n_repeat; i++)
        RMAP_TRY(flush_once(bench, scene, store, &series, &cost, err));
    if (cost.n == 0)
        RMAP_TRY(rmap_error_set(err, RMAP_INTERNAL, "%s: nothing was flushed", store->path));
    *seconds_ret = rmap_bench_median(cost.seconds, cost.n);
    json_t *extra = rmap_bench_encoding_json(encoding);
    (void)json_object_set_new(extra, "flush_portions", json_integer(FLUSH_PORTIONS));
    (void)json_object_set_new(extra, "seconds_per_flush", json_real(*seconds_ret));
    if (rmap_bench_wanted(bench, "durable_vs_not"))
        rmap_bench_report(bench, "durable_vs_not", scene, &series, "million segments/s", extra);
    else
        json_decref(extra);
out:
    return st;
}

/* Checksums of stored bytes depend on how many there are, not on which. */
static enum rmap_status sum_stored(uint64_t nbytes, double *cpu_s, struct rmap_error *err)
{
    enum { BLOCK = 1 << 18 };
    uint8_t *block = rmap_alloc(BLOCK, 1);
    volatile uint64_t sum = 0;
    if (!block)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    for (size_t i = 0; i < BLOCK; i++)
        block[i] = (uint8_t)(i * i >> 8);
    double begun = rmap_bench_cpu();
    for (uint64_t done = 0; done < nbytes; done += BLOCK)
        sum += rmap_checksum(block, BLOCK) + rmap_fletcher32(block, BLOCK);
    *cpu_s += rmap_bench_cpu() - begun;
    rmap_free(block);
    (void)sum;
    return RMAP_OK;
}

/* Processor seconds of all checksums of a map: the digest of its rays, XXH3 and fletcher32 of what
 * is stored. */
static enum rmap_status checksum_cost(const char *path, double *cpu_s, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map *map = NULL;
    struct rmap_cursor *cursor = NULL;
    struct rmap_map_summary summary;
    struct rmap_digest sum = {0, 0};
    const struct rmap_portion *portion;
    *cpu_s = 0.0;
    RMAP_TRY(rmap_map_open(path, &map, err));
    RMAP_TRY(rmap_cursor_create(map, RMAP_COLUMNS_ALL, &cursor, err));
    for (size_t i = 0; i < rmap_map_n_portion(map); i++) {
        RMAP_TRY(rmap_cursor_read(cursor, i, &portion, err));
        double begun = rmap_bench_cpu();
        rmap_digest_add(&sum, rmap_portion_digest(portion));
        *cpu_s += rmap_bench_cpu() - begun;
    }
    rmap_map_summarise(map, &summary);
    if (sum.low != summary.digest.low || sum.high != summary.digest.high)
        RMAP_TRY(rmap_error_set(err, RMAP_INTERNAL, "%s: another digest", path));
    RMAP_TRY(sum_stored(summary.nbytes, cpu_s, err));
out:
    rmap_cursor_destroy(cursor);
    rmap_map_close(map);
    return st;
}

/* All that durability costs over the trace that it is part of: checksums, and flushes as often as
 * they come by default. */
static enum rmap_status measure_checksums(struct rmap_bench *bench,
                                          const struct rmap_bench_scene *scene, size_t encoding,
                                          struct rmap_bench_store *store, double seconds_per_flush,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench_series checksums = {0}, durability = {0};
    double n_segment, cpu_s;
    double flushing = seconds_per_flush / (RMAP_FLUSH_SECONDS * (double)bench->alone.n_thread);
    store->never_flush = false;
    for (int i = 0; i < bench->n_repeat; i++) {
        struct rmap_bench_cost trace = {0};
        RMAP_TRY(timed_trace(bench, scene, 200000, store, &trace, &n_segment, err));
        RMAP_TRY(checksum_cost(store->path, &cpu_s, err));
        rmap_bench_add(&checksums, cpu_s, trace.cpu_s);
        rmap_bench_add(&durability, cpu_s + flushing * trace.cpu_s, trace.cpu_s);
    }
    if (rmap_bench_wanted(bench, "checksums_vs_trace"))
        rmap_bench_report(bench, "checksums_vs_trace", scene, &checksums, "processor s",
                          rmap_bench_encoding_json(encoding));
    if (rmap_bench_wanted(bench, "durability_vs_trace"))
        rmap_bench_report(bench, "durability_vs_trace", scene, &durability, "processor s",
                          rmap_bench_encoding_json(encoding));
out:
    return st;
}

enum rmap_status rmap_bench_durability(struct rmap_bench *bench,
                                       const struct rmap_bench_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char path[600];
    (void)snprintf(path, sizeof path, "%s/safe-%s.raymap", bench->folder, scene->name);
    struct rmap_bench_store store = {.path = path};
    for (size_t e = 0; e < RMAP_BENCH_ENCODINGS; e++) {
        double seconds_per_flush = 0.0;
        store.encoding = rmap_bench_encoding[e].encoding;
        if (rmap_bench_wanted(bench, "durable_vs_not") ||
            rmap_bench_wanted(bench, "durability_vs_trace"))
            RMAP_TRY(measure_flush(bench, scene, e, &store, &seconds_per_flush, err));
        if (rmap_bench_wanted(bench, "checksums_vs_trace") ||
            rmap_bench_wanted(bench, "durability_vs_trace"))
            RMAP_TRY(measure_checksums(bench, scene, e, &store, seconds_per_flush, err));
    }
out:
    return st;
}
