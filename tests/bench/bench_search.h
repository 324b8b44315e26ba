/* SPDX-License-Identifier: MIT
 *
 * What the measurements of questions share: the same rays in maps of every encoding, and in the
 * reference's file.
 */
#ifndef RMAP_BENCH_SEARCH_H
#define RMAP_BENCH_SEARCH_H

#include "bench.h"
#include "bench_questions.h"

struct rmap_bench_search {
    struct rmap_bench *bench;
    const struct rmap_bench_scene *scene;
    const struct rmap_bench_question *question;
    size_t n_question;
    char map[RMAP_BENCH_ENCODINGS][600], seed[600]; /* as rmap_bench_encoding */
    double n_segment;                               /* millions */
};

/* What an answer took, and how many rays it found for the first criterion. */
struct rmap_bench_answer {
    double seconds, cpu;
    uint64_t n_ray;
};

/* With what tells the maps apart; extra is taken over. */
void rmap_bench_search_report(const struct rmap_bench_search *search, size_t encoding,
                              const char *name, const struct rmap_bench_series *series,
                              const char *unit, json_t *extra);

/* A session's second question against its first, of the class of this one. */
enum rmap_status rmap_bench_session(const struct rmap_bench_search *search, size_t encoding,
                                    const struct rmap_bench_question *question,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
