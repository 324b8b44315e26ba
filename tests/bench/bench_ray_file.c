/* SPDX-License-Identifier: MIT
 *
 * Rays written to a TM-25 file and read back, against plain write() and read() of the same bytes.
 */
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <unistd.h>

#include "base/alloc.h"
#include "bench.h"
#include "io/rays/ray_file.h"
#include "io/rays/ray_write.h"
#include "mpi/parallel/progress.h"

struct files {
    char rays[600], plain[600];
    size_t n, nbytes;
    struct rmap_ray_written *ray; /* [n] */
    uint8_t *bytes;               /* [nbytes] of the file */
};

bool rmap_bench_wants_ray_file(const struct rmap_bench *bench)
{
    return rmap_bench_wanted(bench, "tm25_write_vs_plain") ||
           rmap_bench_wanted(bench, "tm25_read_vs_plain");
}

static enum rmap_status failed(struct rmap_error *err, const char *path)
{
    return rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be written or read", path);
}

static enum rmap_status make_rays(struct files *files, struct rmap_error *err)
{
    files->ray = rmap_alloc_unset(files->n, sizeof *files->ray);
    if (!files->ray)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu rays", files->n);
    for (size_t i = 0; i < files->n; i++) {
        const double u = (double)i / (double)files->n, turn = 0.618 * (double)i;
        files->ray[i] = (struct rmap_ray_written){
            .position = {1e-3 * u, -1e-3 * u, 1e-4 * turn / (double)files->n},
            .direction = {sqrt(1.0 - u * u) * cos(turn), sqrt(1.0 - u * u) * sin(turn), u},
            .flux = 1e-6 * (1.0 + u),
            .nm = 400.0 + 300.0 * u,
            .event = RMAP_NO_EVENT,
            .id = i};
    }
    return RMAP_OK;
}

static enum rmap_status write_rays(const struct files *files, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_ray_writer *writer = NULL;
    (void)unlink(files->rays);
    FILE *out = fopen(files->rays, "w+b");
    if (!out)
        return failed(err, files->rays);
    RMAP_TRY(rmap_ray_writer_begin(out, RMAP_RAYS_TM25, false, true, "rays", &writer, err));
    for (size_t i = 0; i < files->n; i++)
        rmap_ray_writer_add(writer, &files->ray[i]);
    RMAP_TRY(rmap_ray_writer_finish(writer, err));
out:
    return fclose(out) == 0 || st != RMAP_OK ? st : failed(err, files->rays);
}

static enum rmap_status write_plain(const struct files *files, struct rmap_error *err)
{
    (void)unlink(files->plain);
    const int out = open(files->plain, O_CREAT | O_WRONLY, 0600);
    bool good = out >= 0;
    for (size_t at = 0; good && at < files->nbytes;) {
        const ssize_t n = write(out, files->bytes + at, files->nbytes - at);
        good = n > 0;
        at += good ? (size_t)n : 0;
    }
    return out >= 0 && close(out) == 0 && good ? RMAP_OK : failed(err, files->plain);
}

static enum rmap_status read_plain(const struct files *files, const char *path,
                                   struct rmap_error *err)
{
    const int in = open(path, O_RDONLY);
    bool good = in >= 0;
    for (size_t at = 0; good && at < files->nbytes;) {
        const ssize_t n = read(in, files->bytes + at, files->nbytes - at);
        good = n > 0;
        at += good ? (size_t)n : 0;
    }
    if (in >= 0)
        (void)close(in);
    return good ? RMAP_OK : failed(err, path);
}

static enum rmap_status read_rays(const struct files *files, struct rmap_error *err)
{
    struct rmap_ray_wanted wanted = {0};
    struct rmap_file_rays *set = NULL;
    enum rmap_status st = rmap_ray_file_read(files->rays, RMAP_RAYS_TM25, &wanted, &set, err);
    if (st != RMAP_OK)
        return st;
    const size_t last = files->n - 1;
    if (set->n != files->n || set->narrow[last][5] != (float)files->ray[last].direction.z)
        st = rmap_error_set(err, RMAP_INTERNAL, "other rays were read than were written");
    rmap_file_rays_drop(set);
    return st;
}

/* The file, whose bytes are the reference. */
static enum rmap_status make_file(struct files *files, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(make_rays(files, err));
    RMAP_TRY(write_rays(files, err));
    FILE *in = fopen(files->rays, "rb");
    const long size = in && fseek(in, 0, SEEK_END) == 0 ? ftell(in) : -1;
    if (in)
        (void)fclose(in);
    if (size <= 0)
        RMAP_TRY(failed(err, files->rays));
    files->nbytes = (size_t)size;
    files->bytes = rmap_alloc(files->nbytes, 1);
    if (!files->bytes)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a file of rays"));
    RMAP_TRY(read_plain(files, files->rays, err));
out:
    return st;
}

static enum rmap_status measure(const struct files *files, struct rmap_bench_series *writing,
                                struct rmap_bench_series *reading, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench_cost at[5];
    for (int k = 0; k < 5; k++) {
        at[k] = (struct rmap_bench_cost){rmap_clock_seconds(), rmap_bench_cpu()};
        if (k == 0)
            RMAP_TRY(write_rays(files, err));
        if (k == 1)
            RMAP_TRY(write_plain(files, err));
        if (k == 2)
            RMAP_TRY(read_rays(files, err));
        if (k == 3)
            RMAP_TRY(read_plain(files, files->plain, err));
    }
    struct rmap_bench_cost cost[4];
    for (int k = 0; k < 4; k++)
        cost[k] = (struct rmap_bench_cost){at[k + 1].wall_s - at[k].wall_s,
                                           at[k + 1].cpu_s - at[k].cpu_s};
    rmap_bench_add_speeds(writing, (double)files->n, cost[0], cost[1]);
    rmap_bench_add_speeds(reading, (double)files->n, cost[2], cost[3]);
out:
    return st;
}

enum rmap_status rmap_bench_ray_file(struct rmap_bench *bench, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_bench_scene none = {.name = "rays"};
    struct rmap_bench_series writing = {0}, reading = {0};
    struct files files = {.n = bench->quick ? 200000 : 2000000};
    (void)snprintf(files.rays, sizeof files.rays, "%s/bench.tm25ray", bench->folder);
    (void)snprintf(files.plain, sizeof files.plain, "%s/bench.bytes", bench->folder);
    RMAP_TRY(make_file(&files, err));
    for (int i = 0; i < bench->n_repeat; i++)
        RMAP_TRY(measure(&files, &writing, &reading, err));
    if (rmap_bench_wanted(bench, "tm25_write_vs_plain"))
        rmap_bench_report(bench, "tm25_write_vs_plain", &none, &writing, "million rays/s", NULL);
    if (rmap_bench_wanted(bench, "tm25_read_vs_plain"))
        rmap_bench_report(bench, "tm25_read_vs_plain", &none, &reading, "million rays/s", NULL);
out:
    rmap_free(files.bytes);
    rmap_free(files.ray);
    return st;
}
