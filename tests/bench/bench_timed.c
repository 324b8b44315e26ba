/* SPDX-License-Identifier: MIT
 *
 * Measurement of what times of arrival and spectra cost: maps of an example with both, against the
 * same scene with one wavelength and no times.
 */
#include "bench.h"

enum { PLAIN, TIMED, WAYS };

enum rmap_status rmap_bench_timed(struct rmap_bench *bench, const struct rmap_bench_scene *plain,
                                  const char *path, struct rmap_error *err)
{
    static const char *const set[] = {"time=on"};
    enum rmap_status st = RMAP_OK;
    struct rmap_bench_scene timed = {.name = plain->name};
    struct rmap_bench_series series = {0};
    const struct rmap_bench_scene *const scene[WAYS] = {plain, &timed};
    char map_path[600];
    (void)snprintf(map_path, sizeof map_path, "%s/%s.raymap", bench->folder, plain->name);
    const struct rmap_bench_store store = {.path = map_path, .encoding = RMAP_ENCODING_COMPACT};
    const uint64_t n_ray = bench->quick ? 20000 : 100000;
    RMAP_TRY(rmap_bench_load(bench, path, set, 1, &timed, err));
    for (int i = 0; i < bench->n_repeat; i++) {
        double wall_s[WAYS], cpu_s[WAYS], n_segment[WAYS];
        for (int k = 0; k < WAYS; k++) { /* in turns, either first */
            const int w = (i + k) % WAYS;
            const double begun = rmap_bench_cpu();
            RMAP_TRY(rmap_bench_trace(&bench->alone, bench->alone.n_thread, scene[w], n_ray, &store,
                                      &wall_s[w], &n_segment[w], err));
            cpu_s[w] = rmap_bench_cpu() - begun;
        }
        rmap_bench_add(&series, 1e-6 * n_segment[TIMED] / wall_s[TIMED],
                       1e-6 * n_segment[PLAIN] / wall_s[PLAIN]);
        rmap_bench_add_cpu(&series, cpu_s[TIMED] / n_segment[TIMED],
                           cpu_s[PLAIN] / n_segment[PLAIN]);
    }
    rmap_bench_report(bench, "timed_vs_plain", plain, &series, "million segments/s", NULL);
out:
    rmap_bench_scene_fini(&timed);
    return st;
}
