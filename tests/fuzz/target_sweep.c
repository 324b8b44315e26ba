/* SPDX-License-Identifier: MIT
 *
 * A sweep's file from a stranger, and a journal of its rows: mistakes are told, each with a line of
 * the file; what is accepted has a value, or a text, for every parameter of every variant.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/sweep/sweep_table.h"
#include "base/alloc.h"
#include "target.h"

const unsigned rmap_fuzz_rounds = 30000;

enum { LONGEST = 8192, VARIANTS = 40 };

static void look(struct rmap_sweep *sweep, const char *row, size_t nbytes)
{
    struct rmap_sweep_table table = {.sweep = NULL};
    struct rmap_error err = {0};
    rmap_fuzz_demand(sweep->n_variant >= 1 && sweep->n_parameter >= 1 && sweep->n_answer >= 1,
                     "something to do");
    for (uint64_t v = 1; v < sweep->n_variant && v < VARIANTS; v++)
        for (size_t i = 0; i < sweep->n_parameter; i++) {
            const char *text;
            const double value = rmap_sweep_value(sweep, v, i, &text);
            rmap_fuzz_demand(text || isfinite(value), "a value");
        }
    if (sweep->n_variant > VARIANTS)
        return;
    rmap_fuzz_demand(rmap_sweep_table_init(&table, sweep, &err) == RMAP_OK, "memory");
    rmap_sweep_row_take(&table, row, nbytes);
    (void)rmap_sweep_yield_of(&table);
    rmap_sweep_table_fini(&table);
}

/* The file, a 0 byte, a row. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    struct rmap_diagnostics told;
    struct rmap_sweep *sweep = NULL;
    struct rmap_error err = {0};
    const int64_t live = rmap_alloc_live();
    char text[LONGEST + 1];
    if (nbytes > LONGEST)
        return 0;
    memcpy(text, data, nbytes);
    text[nbytes] = 0;
    const size_t len = strlen(text);
    rmap_diagnostics_init(&told, "s.yaml");
    const enum rmap_status st = rmap_sweep_read("s.yaml", text, len, &told, &sweep, &err);
    rmap_fuzz_demand(st == RMAP_OK || (st == RMAP_INPUT && told.n_error > 0),
                     "what is wrong is said");
    if (sweep)
        look(sweep, text + len + (len < nbytes), nbytes - len - (len < nbytes));
    rmap_sweep_destroy(sweep);
    rmap_diagnostics_fini(&told);
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
    return 0;
}

size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    static const char *const seed[] = {
        "scene: scene.yaml\nsimulation: a\nrays: 20\nseed: 5\nparameters:\n  b: {keys: [o.s.at.3, "
        "d.s.at.3], plus: true, values: [-0.3, 0.25]}\n  c: {key: s.b.r, values: [0.05, x]}\n"
        "answers:\n  e: {detector: s, of: rms_radius, where: all}\n  f: {flux: registered(s)}\n",
        "scene: s\nrays: 1\nsamples: 9\nsample_seed: 3\nparameters:\n  a: {key: o, times: true, "
        "distribution: {normal: {sigma: .1, mean: 1, cut: 2}}, unit: mm}\n  b: {distribution: "
        "{uniform: {from: -1, to: 3}}}\nanswers: {n: {rays: all}, m: {statistic: x, of: mean, "
        "detector: d}}\nrequire: [n > 0, m <= 2]\nkeep: maps\n",
        "scene: s\nmode: list\nparameters: {a: {range: {from: 0, to: 1, count: 3}}, b: {values: "
        "[1, 2, 3]}}\nanswers: {n: {detector: d, of: peak, unit: lx}}\nrequire: n < 1e3\n"};
    static const char row[] = "{\"variant\":0,\"answers\":[[1,2,\"mm\",0.1],[3,null,\"W\",null]],"
                              "\"parts\":[1,2,3]}";
    if (k < sizeof seed / sizeof *seed)
        return rmap_fuzz_seed_text(seed, sizeof seed / sizeof *seed, k, to, cap);
    const size_t n = strlen(seed[0]) + 1;
    if (k > sizeof seed / sizeof *seed || n + sizeof row > cap)
        return 0;
    memcpy(to, seed[0], n);
    memcpy(to + n, row, sizeof row - 1);
    return n + sizeof row - 1;
}
