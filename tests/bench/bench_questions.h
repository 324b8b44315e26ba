/* SPDX-License-Identifier: MIT
 *
 * The questions that `raymap bench` puts to maps and to the reference: one of every class of
 * criteria, for each example scene.
 */
#ifndef RMAP_BENCH_QUESTIONS_H
#define RMAP_BENCH_QUESTIONS_H

#include "bench.h"
#include "bench_seed.h"

/* A criterion, and the same in the reference's terms (there for those with a class). Names of
 * objects have wildcards; NULL: whatever. */
struct rmap_bench_question {
    const char *scene;
    const char *class; /* NULL: asked together with the others alone */
    const char *text;
    const char *like; /* of the same kind, with other names and numbers; NULL without a class */
    const char *source, *objects, *detector;
    uint32_t events;       /* at the objects */
    int at_least, at_most; /* times */
    double half_size[2];   /* of a rectangle about the detector's centre; 0: all of it */
    double within_deg;     /* of the detector's normal; 0: whatever */
    double longest;        /* path; 0: whatever */
    struct {
        uint32_t events; /* 0: registered on the detector */
        const char *name;
    } element[RMAP_SEED_ELEMENT_MAX]; /* in this order, whatever between them; the first: first */
    int n_element;
    double tolerance; /* share of the rays by which the reference's coarser numbers may differ */
};

/* Those of a scene, by name; the number of them. */
size_t rmap_bench_questions(const char *scene, const struct rmap_bench_question **first_ret);

/* In the reference's terms. *in_set_ret: rmap_free after the last use of *asked. RMAP_INPUT: the
 * scene lacks a name. */
enum rmap_status rmap_bench_question_pose(const struct rmap_bench_question *question,
                                          const struct rmap_scene *scene,
                                          struct rmap_seed_question *asked, bool **in_set_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;

#endif
