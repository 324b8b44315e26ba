/* SPDX-License-Identifier: MIT
 *
 * A field as a formula in x, y, z, r = |p|, rho = sqrt(x^2 + y^2) and lambda (um), compiled once
 * (muparser.
 */
#include "gradient/field_formula.h"

#include <muParserDLL.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "gradient/field_internal.h"

enum { COMPILED_MAX = 256, ALIGNED = 64, MESSAGE_TEXT_MAX = 1000 };

enum { X, Y, Z, R, RHO, LAMBDA, N_VARIABLE };
static const char *const variable[N_VARIABLE] = {"x", "y", "z", "r", "rho", "lambda"};

/* A parser and its variables; one evaluation at a time. */
struct compiled {
    muParserHandle_t parser;
    double value[N_VARIABLE];
    bool failed; /* to evaluate: asking muparser takes the answer away */
    atomic_flag busy;
    char apart[ALIGNED]; /* from the next one's cache line */
};

struct formula {
    struct rmap_field field;
    char *text; /* with the slopes behind it, if any */
    bool has_slopes;
    struct compiled *compiled; /* [n_compiled] */
    int n_compiled;
    double wavelength_um[]; /* [n_channel] */
};

/* ---- evaluation ---- */

/* Threads start their search at a place of their own, by the address of their stack. */
static struct compiled *take(const struct formula *f)
{
    const char here = 0;
    uintptr_t mixed = ((uintptr_t)&here >> 12) * (uintptr_t)0x9e3779b97f4a7c15;
    unsigned start = (unsigned)((mixed >> 32) % (unsigned)f->n_compiled);
    for (unsigned i = start;; i++) {
        struct compiled *c = &f->compiled[i % (unsigned)f->n_compiled];
        if (!atomic_flag_test_and_set_explicit(&c->busy, memory_order_acquire))
            return c;
    }
}

static void give_back(struct compiled *c)
{
    atomic_flag_clear_explicit(&c->busy, memory_order_release);
}

static bool evaluate(struct compiled *c, struct rmap_vec3 p, double lambda, int n_wanted,
                     double *value)
{
    int n = 0;
    c->value[X] = p.x;
    c->value[Y] = p.y;
    c->value[Z] = p.z;
    c->value[R] = rmap_length(p);
    c->value[RHO] = sqrt(p.x * p.x + p.y * p.y);
    c->value[LAMBDA] = lambda;
    const double *result = mupEvalMulti(c->parser, &n);
    c->failed = mupError(c->parser);
    if (c->failed || !result || n != n_wanted)
        return false;
    memcpy(value, result, (size_t)n * sizeof *value);
    return true;
}

/* df = (8 (f1 - f-1) - (f2 - f-2)) / 12 h, error h^4 f(5) / 30. */
static bool differentiate(struct compiled *c, struct rmap_vec3 p, double lambda, double h,
                          double slope[3])
{
    for (int axis = 0; axis < 3; axis++) {
        double f[5];
        for (int k = -2; k <= 2; k++) {
            struct rmap_vec3 q = {p.x + (axis == 0) * k * h, p.y + (axis == 1) * k * h,
                                  p.z + (axis == 2) * k * h};
            if (k && !evaluate(c, q, lambda, 1, &f[k + 2]))
                return false;
        }
        slope[axis] = (8 * (f[3] - f[1]) - (f[4] - f[0])) / (12 * h);
    }
    return true;
}

static bool at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
               struct rmap_vec3 *gradient)
{
    const struct formula *f = (const struct formula *)field;
    double value[4], lambda = f->wavelength_um[channel];
    struct compiled *c = take(f);
    bool good = evaluate(c, p, lambda, f->has_slopes ? 4 : 1, value);
    if (good && !f->has_slopes)
        good = differentiate(c, p, lambda, field->step, value + 1);
    give_back(c);
    if (!good)
        return false;
    *n = value[0];
    *gradient = rmap_vec3(value[1], value[2], value[3]);
    return true;
}

static void destroy(struct rmap_field *field)
{
    struct formula *f = (struct formula *)field;
    for (int i = 0; f->compiled && i < f->n_compiled; i++)
        if (f->compiled[i].parser)
            mupRelease(f->compiled[i].parser);
    rmap_free(f->compiled);
    rmap_free(f->text);
    rmap_free(f);
}

static const struct rmap_field_ops ops = {.model = "formula", .at = at, .destroy = destroy};

/* ---- making ---- */

/* "n, dn/dx, dn/dy, dn/dz": values that are evaluated together. */
static char *join(const struct rmap_formula *formula)
{
    size_t nbytes = strlen(formula->text) + 16;
    for (int i = 0; formula->slope[0] && i < 3; i++)
        nbytes += strlen(formula->slope[i]) + 4;
    char *text = rmap_alloc(nbytes, 1);
    if (!text)
        return NULL;
    int used = snprintf(text, nbytes, "%s", formula->text);
    for (int i = 0; formula->slope[0] && i < 3; i++)
        used += snprintf(text + used, nbytes - (size_t)used, ",(%s)", formula->slope[i]);
    return text;
}

static enum rmap_status complain(struct compiled *c, const char *text, struct rmap_error *err)
{
    /* muparser writes its message, with the word it stumbled over, into a buffer of its own. */
    bool fits = strlen(text) <= MESSAGE_TEXT_MAX;
    const char *message = fits ? mupGetErrorMsg(c->parser) : "too long to say where";
    return rmap_error_set(err, RMAP_INPUT, "the formula is wrong: %s",
                          message ? message : "not understood");
}

static void ignore(muParserHandle_t parser)
{
    (void)parser; /* mupError tells */
}

static enum rmap_status compile(const struct rmap_formula *formula, const char *text,
                                struct compiled *c, struct rmap_error *err)
{
    c->parser = mupCreate(muBASETYPE_FLOAT);
    if (!c->parser)
        return rmap_error_set(err, RMAP_SYSTEM, "muparser gives no parser");
    mupSetErrorHandler(c->parser, ignore);
    for (int i = 0; i < N_VARIABLE; i++)
        mupDefineVar(c->parser, variable[i], &c->value[i]);
    for (size_t i = 0; i < formula->n_constant; i++) {
        for (int k = 0; k < N_VARIABLE; k++)
            if (strcmp(formula->constant[i], variable[k]) == 0)
                return rmap_error_set(err, RMAP_INPUT,
                                      "the formula is wrong: a constant has the name of the "
                                      "variable '%s'",
                                      variable[k]);
        mupDefineConst(c->parser, formula->constant[i], formula->constant_value[i]);
        if (mupError(c->parser))
            return complain(c, formula->constant[i], err);
    }
    mupSetExpr(c->parser, text);
    return mupError(c->parser) ? complain(c, text, err) : RMAP_OK;
}

/* Compiles where it is evaluated first. */
static enum rmap_status try_out(const struct formula *f, struct compiled *c, struct rmap_error *err)
{
    double value[4];
    int n = f->has_slopes ? 4 : 1;
    if (evaluate(c, rmap_vec3(0.1, 0.2, 0.3), f->wavelength_um[0], n, value))
        return RMAP_OK;
    if (c->failed)
        return complain(c, f->text, err);
    return rmap_error_set(err, RMAP_INPUT,
                          "the formula is wrong: a comma stands outside of a function's brackets");
}

static bool uses_lambda(struct compiled *c)
{
    int n = mupGetExprVarNum(c->parser);
    for (int i = 0; i < n; i++) {
        const muChar_t *name = NULL;
        muFloat_t *value = NULL;
        mupGetExprVar(c->parser, (unsigned)i, &name, &value);
        if (value == &c->value[LAMBDA])
            return true;
    }
    return false;
}

static enum rmap_status compile_all(struct formula *f, const struct rmap_formula *formula,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    long online = sysconf(_SC_NPROCESSORS_ONLN);
    f->n_compiled = online < 1 ? 4 : online > COMPILED_MAX / 2 ? COMPILED_MAX : 2 * (int)online;
    f->compiled = rmap_alloc((size_t)f->n_compiled, sizeof *f->compiled);
    if (!f->compiled)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a formula");
    for (int i = 0; i < f->n_compiled; i++) {
        f->compiled[i].busy = (atomic_flag)ATOMIC_FLAG_INIT;
        RMAP_TRY(compile(formula, f->text, &f->compiled[i], err));
        RMAP_TRY(try_out(f, &f->compiled[i], err));
    }
    if (!uses_lambda(&f->compiled[0]))
        f->field.n_channel = 1;
out:
    return st;
}

enum rmap_status rmap_field_formula(struct rmap_field **field_ret, int n_channel,
                                    const double *wavelength_nm, const struct rmap_formula *formula,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t nbytes = sizeof(struct formula) + (size_t)n_channel * sizeof(double);
    struct formula *f = (struct formula *)rmap_field_new(nbytes, &ops, n_channel, err);
    if (!f)
        return RMAP_SYSTEM;
    f->text = join(formula);
    f->has_slopes = formula->slope[0] != NULL;
    f->field.step = formula->difference > 0 ? formula->difference : 2e-5 * formula->size;
    f->field.may_be_missing = true;
    if (!f->text) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a formula");
        goto out;
    }
    for (int c = 0; c < n_channel; c++)
        f->wavelength_um[c] = 1e-3 * wavelength_nm[c];
    RMAP_TRY(compile_all(f, formula, err));
    *field_ret = &f->field;
    f = NULL;
out:
    if (f)
        destroy(&f->field);
    return st;
}
