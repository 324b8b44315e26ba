/* SPDX-License-Identifier: MIT
 *
 * The values of a sweep's variants, and what they are as edits of the scene.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analysis/sweep/sweep.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "base/portable.h"
#include "base/rng.h"
#include "base/unit.h"
#include "io/scene/scene_values.h"

/* Where the scene has no such key, the nearest that it has. */
static void complain(const struct rmap_sweep_parameter *parameter, const char *key,
                     const struct rmap_yaml_node *found, const char *rest,
                     struct rmap_diagnostics *diagnostics)
{
    const char *nearest = rmap_yaml_nearest(found, rest);
    rmap_diagnostics_add(diagnostics, RMAP_SEVERITY_ERROR, parameter->node->line,
                         parameter->node->column, "'%.100s': the scene has no '%.60s'%s%s%s there",
                         key, rest, nearest ? " (did you mean '" : "", nearest ? nearest : "",
                         nearest ? "'?)" : "");
}

static void find_simulations(const struct rmap_sweep *sweep,
                             const struct rmap_sweep_parameter *parameter,
                             struct rmap_diagnostics *diagnostics)
{
    const struct rmap_yaml_node *all = rmap_yaml_get(sweep->scene, "simulations");
    for (size_t i = 0; i < parameter->n_value; i++) {
        bool known = false;
        for (size_t k = 0; all && k < all->n_item && !known; k++) {
            const struct rmap_yaml_node *name = rmap_yaml_get(all->item[k].value, "name");
            known = name && name->kind == RMAP_YAML_SCALAR &&
                    strcmp(name->text, parameter->text[i]) == 0;
        }
        const char *nearest = all ? rmap_yaml_nearest(all, parameter->text[i]) : NULL;
        if (!known)
            rmap_diagnostics_add(
                diagnostics, RMAP_SEVERITY_ERROR, parameter->node->line, parameter->node->column,
                "the scene has no simulation '%.60s'%s%s%s", parameter->text[i],
                nearest ? " (did you mean '" : "", nearest ? nearest : "", nearest ? "'?)" : "");
    }
}

/* The scene's number has a unit that the parameter's is one of, too. */
static void bring_to_unit(const struct rmap_sweep_parameter *parameter,
                          struct rmap_sweep_nominal *nominal)
{
    const struct rmap_written_unit *own = rmap_unit_named(nominal->unit, strlen(nominal->unit));
    const struct rmap_written_unit *told =
        own ? rmap_unit_of_scene(parameter->unit, own->dimension) : NULL;
    if (!told || told->flux != own->flux)
        return;
    nominal->value = rmap_unit_convert(nominal->value, own->size, told->size);
    nominal->unit = told->name;
    nominal->in_unit = true;
}

/* A key of a mapping that is there may be new; whatever is changed must have been there. */
static void find_one(struct rmap_sweep *sweep, struct rmap_sweep_parameter *parameter, size_t k,
                     struct rmap_diagnostics *diagnostics)
{
    const char *rest, *key = parameter->key[k];
    const struct rmap_yaml_node *found = rmap_yaml_find(sweep->scene, key, &rest, NULL);
    struct rmap_sweep_nominal *nominal = &parameter->nominal[k];
    const bool changes = parameter->change != RMAP_SWEEP_REPLACE;
    nominal->unit = "";
    nominal->node = rest[0] ? NULL : found;
    if (rest[0] &&
        (changes || found->kind != RMAP_YAML_MAP || strchr(rest, '.') || found == sweep->scene)) {
        complain(parameter, key, found, rest, diagnostics);
        return;
    }
    nominal->is_number = !rest[0] && found->kind == RMAP_YAML_SCALAR && !found->quoted &&
                         rmap_reader_parse_quantity(found->text, &nominal->value, &nominal->unit);
    if (nominal->is_number)
        bring_to_unit(parameter, nominal);
    else if (changes)
        rmap_diagnostics_add(diagnostics, RMAP_SEVERITY_ERROR, parameter->node->line,
                             parameter->node->column,
                             "'%.100s' is no number in the scene: 'plus' and 'times' change one; "
                             "parts of a list have numbers from 1, as in objects.lens.at.3",
                             key);
}

/* Of two values for one key the later would stand, and the table would tell both. Something may
 * have two keys, by its name and by its number. */
static void find_again(const struct rmap_sweep *sweep, size_t parameter, size_t k,
                       struct rmap_diagnostics *diagnostics)
{
    const struct rmap_sweep_parameter *p = &sweep->parameter[parameter];
    for (size_t i = 0; i <= parameter; i++) {
        const struct rmap_sweep_parameter *other = &sweep->parameter[i];
        for (size_t m = 0; m < (i < parameter ? other->n_key : k); m++)
            if (strcmp(p->key[k], other->key[m]) == 0 ||
                (p->nominal[k].node && p->nominal[k].node == other->nominal[m].node))
                rmap_diagnostics_add(diagnostics, RMAP_SEVERITY_ERROR, p->node->line,
                                     p->node->column,
                                     "'%.100s' has values of '%.60s' already (line %d): leave one",
                                     p->key[k], other->name, other->node->line);
    }
}

enum rmap_status rmap_sweep_find_nominal(struct rmap_sweep *sweep, const struct rmap_bundle *bundle,
                                         struct rmap_diagnostics *diagnostics,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_diagnostics told; /* of the scene, once more: it has been read */
    rmap_diagnostics_init(&told, bundle->path);
    RMAP_TRY(rmap_yaml_parse(bundle->text, bundle->text_nbytes, &sweep->scene, &told, err));
    for (size_t i = 0; i < bundle->options.n_set; i++)
        RMAP_TRY(rmap_yaml_edit(sweep->scene, bundle->options.set[i], -(int)(i + 1), &told, err));
    for (size_t i = 0; i < sweep->n_parameter; i++)
        for (size_t k = 0; k < sweep->parameter[i].n_key; k++) {
            if (sweep->parameter[i].of_simulation)
                find_simulations(sweep, &sweep->parameter[i], diagnostics);
            else
                find_one(sweep, &sweep->parameter[i], k, diagnostics);
            find_again(sweep, i, k, diagnostics);
        }
    if (diagnostics->n_error > 0)
        st = rmap_error_set(err, RMAP_INPUT, "%s in %s",
                            rmap_counted(diagnostics->n_error, "mistake").text, sweep->path);
out:
    rmap_diagnostics_fini(&told);
    return st;
}

/* A sample of the normal distribution by the polar method (Marsaglia and Bray 1964,
 * doi:10.1137/1006063), within the cut. */
static double draw_normal(const struct rmap_sweep *sweep, uint64_t sample, size_t parameter)
{
    const struct rmap_sweep_parameter *p = &sweep->parameter[parameter];
    for (uint32_t try = 0;; try++) {
        double u[4];
        rmap_rng(sweep->sample_seed, sample, try * 64 + (uint32_t)parameter, RMAP_RNG_PARAMETER, u);
        const double x = 2.0 * u[0] - 1.0, y = 2.0 * u[1] - 1.0, s = x * x + y * y;
        if (s >= 1.0 || s <= 0.0)
            continue;
        const double z = x * sqrt(-2.0 * rmap_portable_log(s) / s);
        if (p->cut <= 0.0 || fabs(z) <= p->cut)
            return p->mean + p->sigma * z;
    }
}

/* Which of the parameter's values a variant has. */
static size_t choose(const struct rmap_sweep *sweep, uint64_t variant, size_t parameter)
{
    const size_t n = sweep->parameter[parameter].n_value;
    uint64_t at = variant - 1;
    double u[4];
    switch (sweep->mode) {
    case RMAP_SWEEP_LIST:
        return (size_t)at;
    case RMAP_SWEEP_GRID:
        for (size_t i = sweep->n_parameter; --i > parameter;)
            at /= sweep->parameter[i].n_value;
        return (size_t)(at % n);
    case RMAP_SWEEP_RANDOM:
        break;
    }
    rmap_rng(sweep->sample_seed, variant, (uint32_t)parameter, RMAP_RNG_PARAMETER, u);
    return (size_t)(u[0] * (double)n);
}

double rmap_sweep_value(const struct rmap_sweep *sweep, uint64_t variant, size_t parameter,
                        const char **text_ret)
{
    const struct rmap_sweep_parameter *p = &sweep->parameter[parameter];
    double u[4];
    *text_ret = NULL;
    if (variant == 0 && p->of_simulation)
        *text_ret = sweep->simulation ? sweep->simulation : "";
    const struct rmap_sweep_nominal *nominal = &p->nominal[0];
    const bool has_own_unit = nominal->is_number && nominal->unit[0] && !nominal->in_unit;
    if (variant == 0 && p->change == RMAP_SWEEP_REPLACE && has_own_unit)
        *text_ret = nominal->node->text;
    if (variant == 0)
        return p->change == RMAP_SWEEP_PLUS       ? 0.0
               : p->change == RMAP_SWEEP_TIMES    ? 1.0
               : nominal->is_number && !*text_ret ? nominal->value
                                                  : (double)NAN;
    switch (p->spread) {
    case RMAP_SWEEP_NORMAL:
        return draw_normal(sweep, variant, parameter);
    case RMAP_SWEEP_UNIFORM:
        rmap_rng(sweep->sample_seed, variant, (uint32_t)parameter, RMAP_RNG_PARAMETER, u);
        return p->from + u[0] * (p->to - p->from);
    case RMAP_SWEEP_VALUES:
        break;
    }
    const size_t i = choose(sweep, variant, parameter);
    if (isnan(p->value[i]))
        *text_ret = p->text[i];
    return p->value[i];
}

const char *rmap_sweep_simulation(const struct rmap_sweep *sweep, uint64_t variant)
{
    const char *text = sweep->simulation;
    for (size_t i = 0; variant > 0 && i < sweep->n_parameter; i++)
        if (sweep->parameter[i].of_simulation)
            (void)rmap_sweep_value(sweep, variant, i, &text);
    return text;
}

/* "key=value" */
static char *setting(const struct rmap_sweep_parameter *p, size_t k, double value, const char *text)
{
    const struct rmap_sweep_nominal *nominal = &p->nominal[k];
    const size_t nbytes =
        strlen(p->key[k]) + (text ? strlen(text) : 40 + strlen(nominal->unit)) + 4;
    char *set = rmap_alloc(nbytes, 1);
    if (!set)
        return NULL;
    if (text) {
        (void)snprintf(set, nbytes, "%s=%s", p->key[k], text);
        return set;
    }
    if (p->change == RMAP_SWEEP_PLUS)
        value = nominal->value + value;
    if (p->change == RMAP_SWEEP_TIMES)
        value = nominal->value * value;
    const bool has_unit = nominal->in_unit || (p->change != RMAP_SWEEP_REPLACE && nominal->unit[0]);
    (void)snprintf(set, nbytes, "%s=%.17g%s%s", p->key[k], value, has_unit ? " " : "",
                   has_unit ? nominal->unit : "");
    return set;
}

enum rmap_status rmap_sweep_settings(const struct rmap_sweep *sweep, uint64_t variant,
                                     char ***set_ret, size_t *n_ret, struct rmap_error *err)
{
    size_t n = 0, cap = 0;
    for (size_t i = 0; variant > 0 && i < sweep->n_parameter; i++)
        cap += sweep->parameter[i].n_key;
    char **set = rmap_alloc(cap + 1, sizeof *set);
    bool failed = !set;
    for (size_t i = 0; set && cap > 0 && i < sweep->n_parameter; i++) {
        const char *text;
        const double value = rmap_sweep_value(sweep, variant, i, &text);
        for (size_t k = 0; k < sweep->parameter[i].n_key && !sweep->parameter[i].of_simulation;
             k++) {
            set[n] = setting(&sweep->parameter[i], k, value, text);
            failed |= !set[n++];
        }
    }
    if (failed) {
        rmap_sweep_settings_free(set, n);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a variant");
    }
    *set_ret = set;
    *n_ret = n;
    return RMAP_OK;
}

void rmap_sweep_settings_free(char **set, size_t n)
{
    for (size_t i = 0; set && i < n; i++)
        rmap_free(set[i]);
    rmap_free(set);
}

/* The key leads into the item of that name, or is all of it. */
static bool leads_into(const char *key, const char *section, const char *name)
{
    const size_t len = strlen(section), n = strlen(name);
    if (strncmp(key, section, len) != 0)
        return false;
    return !key[len] || strncmp(key + len + 1, name, n) == 0;
}

bool rmap_sweep_shares_files(const struct rmap_sweep *sweep, const struct rmap_bundle *bundle)
{
    for (size_t i = 0; i < sweep->n_parameter; i++) {
        const struct rmap_sweep_parameter *p = &sweep->parameter[i];
        for (size_t v = 0; v < p->n_value; v++)
            if (isnan(p->value[v])) /* a word may be the name of a file */
                return false;
        for (size_t k = 0; k < p->n_key; k++) {
            const char *key = p->key[k];
            bool reads =
                leads_into(key, "units", "") || leads_into(key, "spectrum", "") ||
                (bundle->n_ray_set > 0 && leads_into(key, "sources", "")) ||
                ((bundle->n_grid > 0 || bundle->n_plugin > 0) && leads_into(key, "media", ""));
            for (size_t m = 0; m < bundle->n_mesh && !reads; m++)
                reads = leads_into(key, "geometries", bundle->mesh[m].geometry);
            if (reads)
                return false;
        }
    }
    return true;
}
