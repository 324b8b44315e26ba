/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bench.h"

bool rmap_bench_wanted(const struct rmap_bench *bench, const char *name)
{
    return !bench->only || strcmp(bench->only, name) == 0;
}

void rmap_bench_scene_fini(struct rmap_bench_scene *scene)
{
    rmap_accel_destroy(scene->accel);
    rmap_scene_destroy(scene->scene);
    rmap_bundle_destroy(scene->bundle);
    scene->accel = NULL;
    scene->scene = NULL;
    scene->bundle = NULL;
}

void rmap_bench_add(struct rmap_bench_series *series, double ours, double reference)
{
    if (series->n == RMAP_BENCH_REPEAT_MAX)
        return;
    series->ours[series->n] = ours;
    series->reference[series->n++] = reference;
}

void rmap_bench_add_cpu(struct rmap_bench_series *series, double ours_s, double reference_s)
{
    if (series->n_cpu < RMAP_BENCH_REPEAT_MAX && ours_s > 0.0)
        series->cpu_ratio[series->n_cpu++] = reference_s / ours_s;
}

void rmap_bench_add_speeds(struct rmap_bench_series *series, double n_segment,
                           struct rmap_bench_cost ours, struct rmap_bench_cost reference)
{
    rmap_bench_add(series, 1e-6 * n_segment / ours.wall_s, 1e-6 * n_segment / reference.wall_s);
    rmap_bench_add_cpu(series, ours.cpu_s, reference.cpu_s);
}

double rmap_bench_cpu(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int by_value(const void *a, const void *b)
{
    double left = *(const double *)a, right = *(const double *)b;
    return left < right ? -1 : left > right;
}

double rmap_bench_median(const double *value, int n)
{
    double sorted[RMAP_BENCH_REPEAT_MAX];
    memcpy(sorted, value, (size_t)n * sizeof *value);
    qsort(sorted, (size_t)n, sizeof *sorted, by_value);
    return 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]);
}

/* What tells rows of one name apart. */
static void print_text(const json_t *extra, const char *key)
{
    const char *text = json_string_value(json_object_get(extra, key));
    if (text)
        printf(" %-7s", text);
}

void rmap_bench_report(struct rmap_bench *bench, const char *name,
                       const struct rmap_bench_scene *scene, const struct rmap_bench_series *series,
                       const char *unit, json_t *extra)
{
    double ratio[RMAP_BENCH_REPEAT_MAX] = {0}, least = (double)INFINITY, most = 0.0;
    for (int i = 0; i < series->n; i++) {
        ratio[i] = series->ours[i] / series->reference[i];
        least = fmin(least, ratio[i]);
        most = fmax(most, ratio[i]);
    }
    double ours = rmap_bench_median(series->ours, series->n);
    double reference = rmap_bench_median(series->reference, series->n);
    double middle = rmap_bench_median(ratio, series->n);
    json_t *result =
        json_pack("{s:s, s:s, s:f, s:s, s:f, s:f, s:[f, f], s:i}", "name", name, "scene",
                  scene->name, "value", ours, "unit", unit, "reference", reference, "ratio", middle,
                  "spread", least, most, "repeats", series->n);
    double cpu_ratio =
        series->n_cpu ? rmap_bench_median(series->cpu_ratio, series->n_cpu) : (double)NAN;
    if (series->n_cpu)
        (void)json_object_set_new(result, "cpu_ratio", json_real(cpu_ratio));
    if (extra)
        (void)json_object_update(result, extra);
    (void)json_array_append_new(bench->results, result);
    if (!bench->context->json) {
        printf("%-18s %-13s", name, scene->name);
        print_text(extra, "encoding");
        print_text(extra, "class");
        print_text(extra, "against");
        print_text(extra, "after");
        printf(" %9.4g against %9.4g %s: %.3f (%.3f to %.3f)", ours, reference, unit, middle, least,
               most);
        if (series->n_cpu)
            printf(", by processor time %.3f", cpu_ratio);
        putchar('\n');
        (void)fflush(stdout);
    }
    json_decref(extra);
}
