/* SPDX-License-Identifier: MIT
 *
 * What the measurements of `raymap bench` share. Each compares two ways of doing the same work,
 * run in turns in this process, and reports the median of the ratios with their spread.
 */
#ifndef RMAP_BENCH_H
#define RMAP_BENCH_H

#include <jansson.h>

#include "accel/accel.h"
#include "io/map/map_writer.h"
#include "io/mesh/bundle.h"
#include "mpi/command/command.h"

enum { RMAP_BENCH_REPEAT_MAX = 32 };

/* One scene, ready on this rank. */
struct rmap_bench_scene {
    const char *name;   /* "room" */
    const char *folder; /* of the example */
    const char *set;    /* KEY=VALUE for the scene; NULL: none */
    bool sizes_only;    /* takes part in bytes_per_segment alone */
    bool pictures;      /* in render_preview and render_overhead alone */
    bool timed;         /* in timed_vs_plain alone */
    struct rmap_bundle *bundle;
    struct rmap_scene *scene;
    struct rmap_accel *accel;
};

/* What `raymap bench` does. Collective. */
enum rmap_status rmap_bench_run(const struct rmap_context *context,
                                const struct rmap_arguments *given,
                                struct rmap_error *err) RMAP_MUST_USE;

/* Releases what the scene holds. */
void rmap_bench_scene_fini(struct rmap_bench_scene *scene);

struct rmap_bench {
    const struct rmap_context *context; /* of all ranks; quiet */
    struct rmap_context alone;          /* this rank by itself */
    bool quick;
    const char *only; /* name of one measurement; NULL: all */
    int n_repeat;
    char folder[512]; /* for files, removed at the end */
    json_t *results;  /* array, rank 0 */
};

/* Pairs of figures, repeat by repeat, of ours and of the reference; and the processor time that
 * the reference took over ours, which other work on the machine disturbs less. */
struct rmap_bench_series {
    int n, n_cpu;
    double ours[RMAP_BENCH_REPEAT_MAX], reference[RMAP_BENCH_REPEAT_MAX];
    double cpu_ratio[RMAP_BENCH_REPEAT_MAX];
};

/* Processor seconds of all threads of this process. */
double rmap_bench_cpu(void);

bool rmap_bench_wanted(const struct rmap_bench *bench, const char *name);
void rmap_bench_add(struct rmap_bench_series *series, double ours, double reference);
void rmap_bench_add_cpu(struct rmap_bench_series *series, double ours_s, double reference_s);

/* Of n > 0 values, at most RMAP_BENCH_REPEAT_MAX. */
double rmap_bench_median(const double *value, int n);

/* Runs over the same segments, by both clocks. */
struct rmap_bench_cost {
    double wall_s, cpu_s;
};
void rmap_bench_add_speeds(struct rmap_bench_series *series, double n_segment,
                           struct rmap_bench_cost ours, struct rmap_bench_cost reference);

/* Appends {"name", "scene", "value", "unit", "reference", "ratio", "spread", "repeats"} and,
 * where it was taken, "cpu_ratio" to the results: medians, and the least and greatest ratio. extra
 * (taken over, may be NULL): more keys. Says the same on stderr unless quiet. */
void rmap_bench_report(struct rmap_bench *bench, const char *name,
                       const struct rmap_bench_scene *scene, const struct rmap_bench_series *series,
                       const char *unit, json_t *extra);

/* The scene of a file with such KEY=VALUE; finished by the caller, on failure as well. */
enum rmap_status rmap_bench_load(struct rmap_bench *bench, const char *path, const char *const *set,
                                 size_t n_set, struct rmap_bench_scene *scene,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* The measurements. Not collective, rank 0 alone. */
enum rmap_status rmap_bench_roofline(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                     struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_bench_scatter(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                    struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_bench_record(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                   struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_bench_decode(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                   struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_bench_verify(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                   struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_bench_durability(struct rmap_bench *bench,
                                       const struct rmap_bench_scene *scene,
                                       struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_bench_resume(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                   const char *scene_path, struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_bench_render(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                   struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_bench_query(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                  struct rmap_error *err) RMAP_MUST_USE;
bool rmap_bench_wants_folds(const struct rmap_bench *bench);
enum rmap_status rmap_bench_folds(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                  struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_bench_uniform(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                    const char *path, struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_bench_timed(struct rmap_bench *bench, const struct rmap_bench_scene *plain,
                                  const char *path, struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_bench_gradient(struct rmap_bench *bench,
                                     struct rmap_error *err) RMAP_MUST_USE;
bool rmap_bench_wants_ray_file(const struct rmap_bench *bench);
enum rmap_status rmap_bench_ray_file(struct rmap_bench *bench,
                                     struct rmap_error *err) RMAP_MUST_USE;

bool rmap_bench_wants_live(const struct rmap_bench *bench);
enum rmap_status rmap_bench_live(struct rmap_bench *bench, struct rmap_error *err) RMAP_MUST_USE;

/* Two ranks x one thread against one rank x two threads. The pair: the first two ranks, or when
 * there is only one, this and one that it starts (which calls with partner true). pair->comm is
 * MPI_COMM_NULL on ranks beyond it. Collective. */
enum rmap_status rmap_bench_pair_open(const struct rmap_bench *bench, bool partner,
                                      struct rmap_context *pair,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_bench_pair_close(struct rmap_context *pair);

/* Collective on the pair. Rank 0 says what is measured (scene, path, *more true) or that it is
 * over (*more false); rank 1 calls until *more comes back false. */
enum rmap_status rmap_bench_pair_round(struct rmap_bench *bench, const struct rmap_context *pair,
                                       struct rmap_bench_scene *scene, const char *path, bool *more,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Where a traced map goes, and how. */
struct rmap_bench_store {
    const char *path; /* NULL: nothing is recorded */
    enum rmap_encoding encoding;
    uint64_t flush_portions; /* flushed after so many, whatever the clock says; 0: as usual */
    bool never_flush;
    uint64_t *n_flush; /* the flushes are added to it; or NULL */
};

/* Traces n_ray rays on the ranks of `context` (a copy of it, with n_thread threads) into a new
 * map. seconds_ret, n_segment_ret: on its rank 0. Collective on it. */
enum rmap_status rmap_bench_trace(const struct rmap_context *context, int n_thread,
                                  const struct rmap_bench_scene *scene, uint64_t n_ray,
                                  const struct rmap_bench_store *store, double *seconds_ret,
                                  double *n_segment_ret, struct rmap_error *err) RMAP_MUST_USE;

/* The encodings that a map is measured in. */
struct rmap_bench_encoding {
    enum rmap_encoding encoding;
    const char *name;
};
enum { RMAP_BENCH_ENCODINGS = 2 };
extern const struct rmap_bench_encoding rmap_bench_encoding[RMAP_BENCH_ENCODINGS];

/* {"encoding": name, ...}: for `extra` of a report. */
json_t *rmap_bench_encoding_json(size_t encoding);

#endif
