/* SPDX-License-Identifier: MIT
 *
 * The rays of a file.
 */
#include "scene/file_rays.h"

#include "base/alloc.h"
#include "base/search.h"

enum rmap_status rmap_file_rays_create(size_t n, bool wide, struct rmap_file_rays **set_ret,
                                       struct rmap_error *err)
{
    struct rmap_file_rays *set = n > 0 ? rmap_alloc(1, sizeof *set) : NULL;
    if (n == 0)
        return rmap_error_set(err, RMAP_INPUT, "it has no rays");
    if (set && wide)
        set->wide = rmap_alloc_unset(n, sizeof *set->wide);
    else if (set)
        set->narrow = rmap_alloc_unset(n, sizeof *set->narrow);
    if (!set || (!set->wide && !set->narrow)) {
        rmap_free(set);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu rays", n);
    }
    set->n = n;
    set->all_nm = set->flux = (double)NAN;
    set->n_holder = 1;
    *set_ret = set;
    return RMAP_OK;
}

struct rmap_file_rays *rmap_file_rays_hold(struct rmap_file_rays *set)
{
    set->n_holder++;
    return set;
}

void rmap_file_rays_drop(struct rmap_file_rays *set)
{
    if (!set || --set->n_holder > 0)
        return;
    rmap_free(set->narrow);
    rmap_free(set->wide);
    rmap_free(set->below);
    rmap_free(set->wavelength_nm);
    rmap_free(set->delay_ns);
    rmap_free(set->event);
    rmap_free(set->step);
    rmap_free(set);
}

enum rmap_status rmap_file_rays_weigh(struct rmap_file_rays *set, struct rmap_error *err)
{
    double sum = 0.0;
    bool alike = true;
    for (size_t i = 0; i < set->n; i++) {
        const double power = set->below[i];
        if (!(power >= 0.0 && power <= 1e300))
            return rmap_error_set(err, RMAP_INPUT, "ray %zu: its power is %g", i + 1, power);
        alike = alike && power == set->below[0];
    }
    for (size_t i = 0; i < set->n; i++)
        set->below[i] = sum += set->below[i];
    if (!(sum > 0.0 && sum <= 1e300))
        return rmap_error_set(err, RMAP_INPUT, "its rays have no power");
    set->flux = sum;
    if (alike) {
        rmap_free(set->below);
        set->below = NULL;
    }
    return RMAP_OK;
}

static bool is_within(double x, double limit)
{
    return x >= -limit && x <= limit;
}

static enum rmap_status check_row(const struct rmap_file_rays *set, size_t i,
                                  struct rmap_error *err)
{
    struct rmap_vec3 p, d;
    rmap_file_rays_get(set, i, &p, &d);
    const char *row = set->step ? "step" : "ray";
    const double square = rmap_dot(d, d);
    if (!is_within(p.x, 1e30) || !is_within(p.y, 1e30) || !is_within(p.z, 1e30))
        return rmap_error_set(err, RMAP_INPUT, "%s %zu: its start (%g, %g, %g) is no place", row,
                              i + 1, p.x, p.y, p.z);
    if (!(square > 1e-30 && square < 1e30))
        return rmap_error_set(err, RMAP_INPUT, "%s %zu: its direction (%g, %g, %g) is none", row,
                              i + 1, d.x, d.y, d.z);
    if (set->delay_ns && !is_within(set->delay_ns[i], 1e30))
        return rmap_error_set(err, RMAP_INPUT, "%s %zu: its time of %g ns is none", row, i + 1,
                              set->delay_ns[i]);
    if (set->below && !(set->below[i] >= (i ? set->below[i - 1] : 0.0)))
        return rmap_error_set(err, RMAP_INPUT, "ray %zu: its power is below 0", i + 1);
    return RMAP_OK;
}

static enum rmap_status include_nm(struct rmap_file_rays *set, size_t i, struct rmap_error *err)
{
    const double nm = rmap_file_rays_nm(set, i);
    if (isnan(nm)) {
        set->n_other++;
        return RMAP_OK;
    }
    if (!(nm > 0.0 && nm < 1e9))
        return rmap_error_set(err, RMAP_INPUT, "ray %zu: its wavelength is %g nm", i + 1, nm);
    set->least_nm = fmin(set->least_nm, nm); /* of a number and none the number */
    set->greatest_nm = fmax(set->greatest_nm, nm);
    return RMAP_OK;
}

enum rmap_status rmap_file_rays_finish(struct rmap_file_rays *set, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    set->least_nm = set->greatest_nm = (double)NAN;
    set->n_other = 0;
    bool numbered = false;
    for (size_t i = 0; i < set->n; i++) {
        RMAP_TRY(check_row(set, i, err));
        RMAP_TRY(include_nm(set, i, err));
        numbered = numbered || (set->event && set->event[i] != RMAP_NO_EVENT);
        struct rmap_vec3 p, d;
        rmap_file_rays_get(set, i, &p, &d);
        const double at[3] = {p.x, p.y, p.z};
        for (int k = 0; k < 3; k++) {
            low[k] = rmap_min(low[k], at[k]);
            high[k] = rmap_max(high[k], at[k]);
        }
    }
    if (set->below && !(set->below[set->n - 1] > 0.0 && set->below[set->n - 1] <= 1e300))
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "its rays have no power"));
    if (!numbered) {
        rmap_free(set->event);
        set->event = NULL;
    }
    set->lower = rmap_vec3(low[0], low[1], low[2]);
    set->upper = rmap_vec3(high[0], high[1], high[2]);
out:
    return st;
}

/* The bits of k + 1 behind the point, in reverse: 1/2, 1/4, 3/4, 1/8 ... (van der Corput 1935). */
static double fill_evenly(uint64_t k)
{
    double sum = 0.0, place = 0.5;
    for (k++; k > 0 && place > 1e-16; k >>= 1, place *= 0.5)
        sum += (double)(k & 1) * place;
    return sum;
}

size_t rmap_file_rays_row(const struct rmap_file_rays *set, uint64_t ordinal)
{
    const size_t k = (size_t)(ordinal % set->n);
    if (!set->below)
        return k;
    const double part = ((double)k + fill_evenly(ordinal / set->n)) / (double)set->n;
    return rmap_first_above(set->below, set->n, part * set->below[set->n - 1]);
}

void rmap_file_rays_get(const struct rmap_file_rays *set, size_t row, struct rmap_vec3 *position,
                        struct rmap_vec3 *direction)
{
    if (set->wide) {
        const double *v = set->wide[row];
        *position = rmap_vec3(v[0], v[1], v[2]);
        *direction = rmap_vec3(v[3], v[4], v[5]);
    } else {
        const float *v = set->narrow[row];
        *position = rmap_vec3((double)v[0], (double)v[1], (double)v[2]);
        *direction = rmap_vec3((double)v[3], (double)v[4], (double)v[5]);
    }
}

double rmap_file_rays_nm(const struct rmap_file_rays *set, size_t row)
{
    return set->wavelength_nm ? (double)set->wavelength_nm[row] : set->all_nm;
}
