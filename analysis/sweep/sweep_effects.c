/* SPDX-License-Identifier: MIT
 *
 * Which parameters of a sweep matter: least squares of an answer on u and u^2 of every parameter, u
 * being its value less the mean over the standard deviation (a response surface without products:
 * Box and Wilson 1951, doi:10.1111/j.2517-6161.1951.tb00067.x).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/sweep/sweep_table.h"
#include "base/alloc.h"

struct fit {
    const struct rmap_sweep_table *table;
    size_t answer, n_parameter, n_term; /* terms: 1, then u and u^2 - 1 of each parameter */
    double *mean, *deviation;           /* [n_parameter] */
    double *matrix; /* [n_term][2 n_term]: normal equations, then their inverse */
    double *right, *term, *coefficient; /* [n_term] */
    double n, sum, squares;             /* of the variants with an answer */
};

static bool counts(const struct fit *fit, uint64_t variant)
{
    return fit->table->is_known[variant] &&
           isfinite(rmap_sweep_table_row(fit->table, variant)[fit->answer].value);
}

static double value_of(const struct fit *fit, uint64_t variant, size_t parameter)
{
    const char *text;
    return rmap_sweep_value(fit->table->sweep, variant, parameter, &text);
}

static void find_moments(struct fit *fit)
{
    for (uint64_t v = 1; v < fit->table->sweep->n_variant; v++) {
        if (!counts(fit, v))
            continue;
        fit->n += 1.0;
        for (size_t i = 0; i < fit->n_parameter; i++) {
            const double x = value_of(fit, v, i), step = x - fit->mean[i];
            fit->mean[i] += step / fit->n;
            fit->deviation[i] += step * (x - fit->mean[i]);
        }
    }
    for (size_t i = 0; i < fit->n_parameter; i++)
        fit->deviation[i] = sqrt(fit->deviation[i] / fit->n);
}

static void find_terms(struct fit *fit, uint64_t variant)
{
    fit->term[0] = 1.0;
    for (size_t i = 0; i < fit->n_parameter; i++) {
        const double u = (value_of(fit, variant, i) - fit->mean[i]) / fit->deviation[i];
        fit->term[1 + 2 * i] = u;
        fit->term[2 + 2 * i] = u * u - 1.0;
    }
}

static void sum_up(struct fit *fit)
{
    const size_t n = fit->n_term;
    for (size_t i = 0; i < n; i++)
        fit->matrix[2 * n * i + n + i] = 1.0;
    for (uint64_t v = 1; v < fit->table->sweep->n_variant; v++) {
        if (!counts(fit, v))
            continue;
        const double y = rmap_sweep_table_row(fit->table, v)[fit->answer].value -
                         rmap_sweep_table_row(fit->table, 1)[fit->answer].value;
        find_terms(fit, v);
        fit->sum += y;
        fit->squares += y * y;
        for (size_t i = 0; i < n; i++) {
            fit->right[i] += fit->term[i] * y;
            for (size_t k = 0; k < n; k++)
                fit->matrix[2 * n * i + k] += fit->term[i] * fit->term[k];
        }
    }
}

/* Gauss and Jordan. A term that others make up, as u^2 of two values, is left out: its pivot is 0.
 */
static void invert(struct fit *fit)
{
    const size_t n = fit->n_term;
    for (size_t p = 0; p < n; p++) {
        double *pivot = fit->matrix + 2 * n * p;
        const double by = pivot[p];
        const bool leaves_out = !(by > 1e-9 * fit->n);
        for (size_t k = 0; k < 2 * n; k++)
            pivot[k] = leaves_out ? 0.0 : pivot[k] / by;
        for (size_t i = 0; i < n; i++) {
            double *row = fit->matrix + 2 * n * i;
            const double times = i == p ? 0.0 : row[p];
            for (size_t k = 0; k < 2 * n; k++)
                row[k] -= times * pivot[k];
            if (leaves_out)
                row[p] = row[n + p] = 0.0;
        }
    }
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < n; k++)
            fit->coefficient[i] += fit->matrix[2 * n * i + n + k] * fit->right[k];
}

/* Of b u + c (u^2 - 1) over the variants, of all their variance. */
static double share_of(struct fit *fit, size_t parameter, double variance)
{
    double n = 0.0, sum = 0.0, squares = 0.0;
    for (uint64_t v = 1; v < fit->table->sweep->n_variant; v++) {
        if (!counts(fit, v))
            continue;
        find_terms(fit, v);
        const double part = fit->coefficient[1 + 2 * parameter] * fit->term[1 + 2 * parameter] +
                            fit->coefficient[2 + 2 * parameter] * fit->term[2 + 2 * parameter];
        n += 1.0;
        sum += part;
        squares += part * part;
    }
    return variance > 0.0 ? fmax(squares / n - sum * sum / (n * n), 0.0) / variance : 0.0;
}

static int compare(const void *a, const void *b)
{
    const struct rmap_sweep_effect *x = a, *y = b;
    return x->share > y->share   ? -1
           : x->share < y->share ? 1
                                 : (x->parameter > y->parameter) - (x->parameter < y->parameter);
}

static void tell(struct fit *fit, struct rmap_sweep_effect *effect, double *explained_ret)
{
    const size_t n = fit->n_term;
    const double variance = fit->squares / fit->n - fit->sum * fit->sum / (fit->n * fit->n);
    double explained = 0.0;
    for (size_t i = 0; i < n; i++)
        explained += fit->coefficient[i] * fit->right[i];
    const double rest = fmax(fit->squares - explained, 0.0);
    const double noise = fit->n > (double)n ? rest / (fit->n - (double)n) : (double)NAN;
    *explained_ret = variance > 0.0 ? 1.0 - rest / (fit->n * variance) : (double)NAN;
    for (size_t i = 0; i < fit->n_parameter; i++) {
        const size_t t = 1 + 2 * i;
        effect[i].slope = fit->coefficient[t] / fit->deviation[i];
        effect[i].slope_error = sqrt(noise * fit->matrix[2 * n * t + n + t]) / fit->deviation[i];
        effect[i].share = share_of(fit, i, variance);
    }
    qsort(effect, fit->n_parameter, sizeof *effect, compare);
}

enum rmap_status rmap_sweep_effects(const struct rmap_sweep_table *table, size_t answer,
                                    struct rmap_sweep_effect *effect, double *explained_ret,
                                    struct rmap_error *err)
{
    const size_t p = table->sweep->n_parameter, n = 1 + 2 * p;
    struct fit fit = {.table = table, .answer = answer, .n_parameter = p, .n_term = n};
    double *memory = rmap_alloc(2 * p + 2 * n * n + 3 * n, sizeof *memory);
    if (!memory)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the effects of parameters");
    fit.mean = memory;
    fit.deviation = fit.mean + p;
    fit.matrix = fit.deviation + p;
    fit.right = fit.matrix + 2 * n * n;
    fit.term = fit.right + n;
    fit.coefficient = fit.term + n;
    *explained_ret = (double)NAN;
    for (size_t i = 0; i < p; i++)
        effect[i] = (struct rmap_sweep_effect){i, (double)NAN, (double)NAN, (double)NAN};
    find_moments(&fit);
    bool varies = fit.n >= 3.0;
    for (size_t i = 0; i < p; i++)
        varies = varies && fit.deviation[i] > 0.0;
    if (varies) {
        sum_up(&fit);
        invert(&fit);
        tell(&fit, effect, explained_ret);
    }
    rmap_free(memory);
    return RMAP_OK;
}
