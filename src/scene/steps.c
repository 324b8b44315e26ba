/* SPDX-License-Identifier: MIT
 *
 * Steps of charged particles and the light that they make along them.
 */
#include "scene/steps.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/search.h"
#include "formula/emit.h"
#include "optics/cherenkov.h"
#include "optics/photon_number.h"

enum rmap_status rmap_steps_create(size_t n, struct rmap_steps **steps_ret, struct rmap_error *err)
{
    struct rmap_steps *steps = rmap_alloc(1, sizeof *steps);
    if (steps) {
        steps->n = n;
        steps->step = rmap_alloc(n, sizeof *steps->step);
        steps->photons = rmap_alloc(n, RMAP_PHOTON_KINDS * sizeof *steps->photons);
    }
    if (!steps || !steps->step || !steps->photons) {
        rmap_steps_destroy(steps);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu steps", n);
    }
    steps->range_nm[1] = HUGE_VAL;
    *steps_ret = steps;
    return RMAP_OK;
}

void rmap_steps_destroy(struct rmap_steps *steps)
{
    if (!steps)
        return;
    rmap_free(steps->step);
    rmap_free(steps->photons);
    rmap_free(steps);
}

/* ---- how many photons ---- */

#define PHOTONS_MAX 9e15 /* whole numbers that are added exactly */

/* What is wrong with a step; NULL: nothing. */
static const char *trouble_of(const struct rmap_track_step *step)
{
    const double way = rmap_dot(step->direction, step->direction);
    if (!(rmap_length(step->position) < 1e30))
        return "its place is none";
    if (!(fabs(way - 1.0) < 1e-6))
        return "its direction is none";
    if (!(step->length >= 0.0 && step->length < 1e30))
        return "its length must be 0 or greater";
    if (!(step->energy_mev >= 0.0 && step->energy_mev < 1e30))
        return "its energy must be 0 or greater";
    if (!(fabs(step->time_ns) < 1e30))
        return "its time is none";
    if (!(fabs(step->charge) < 1e3))
        return "its charge must be less than 1000";
    if (!(step->beta > 0.0 && step->beta <= 1.0))
        return "its beta must be greater than 0 and at most 1";
    return NULL;
}

struct turn {
    struct rmap_track_step step;
    size_t row;
};

static int compare_turns(const void *a, const void *b)
{
    const struct turn *x = a, *y = b;
    if (x->step.event != y->step.event)
        return x->step.event < y->step.event ? -1 : 1;
    return x->row < y->row ? -1 : x->row > y->row;
}

/* By event, those of one as they came. */
static enum rmap_status sort(struct rmap_steps *steps, struct rmap_error *err)
{
    size_t i = 1;
    while (i < steps->n && steps->step[i - 1].event <= steps->step[i].event)
        i++;
    if (i >= steps->n)
        return RMAP_OK;
    struct turn *turn = rmap_alloc(steps->n, sizeof *turn);
    if (!turn)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu steps", steps->n);
    for (i = 0; i < steps->n; i++)
        turn[i] = (struct turn){steps->step[i], i};
    qsort(turn, steps->n, sizeof *turn, compare_turns);
    for (i = 0; i < steps->n; i++)
        steps->step[i] = turn[i].step;
    rmap_free(turn);
    return RMAP_OK;
}

static enum rmap_status set_bands(struct rmap_steps *steps, const struct rmap_steps_medium *medium,
                                  struct rmap_error *err)
{
    for (int i = 0; i < medium->channels->n; i++) {
        double band[2];
        rmap_channel_band(medium->channels, i, band);
        band[0] = rmap_max(band[0], steps->range_nm[0]);
        band[1] = rmap_min(band[1], steps->range_nm[1]);
        if (!(band[0] > 0.0))
            return rmap_error_set(err, RMAP_INPUT,
                                  "the band of wavelengths about %g nm reaches down to 0, where "
                                  "Cherenkov light has no end: say from where on",
                                  medium->channels->wavelength_nm[i]);
        steps->cherenkov[i] = band[1] > band[0] ? rmap_cherenkov_band(band) * medium->unit_m : 0.0;
    }
    return RMAP_OK;
}

/* Expected photons of a step per channel, of one kind, added to sum[n_channel]; of all of them. */
static double expect(const struct rmap_steps *steps, const struct rmap_steps_medium *medium,
                     const struct rmap_track_step *step, enum rmap_photon_kind kind, double *sum)
{
    const struct rmap_scintillation *light = medium->scintillation;
    double all = 0.0;
    if (!steps->emits[kind] || (kind == RMAP_PHOTON_SCINTILLATION && !light))
        return 0.0;
    const double scintillation =
        kind == RMAP_PHOTON_SCINTILLATION
            ? rmap_scintillation_mean(light, step->energy_mev, step->length)
            : 0.0;
    for (int i = 0; i < medium->channels->n; i++) {
        const double photons =
            kind == RMAP_PHOTON_SCINTILLATION
                ? scintillation * light->share[i]
                : steps->cherenkov[i] * step->length *
                      rmap_cherenkov_strength(medium->n[i], step->beta, step->charge);
        sum[i] += photons;
        all += photons;
    }
    return all;
}

static void count_photons(struct rmap_steps *steps, const struct rmap_steps_medium *medium,
                          double *sum)
{
    double before = 0.0;
    for (size_t i = 0; i < steps->n; i++)
        for (int kind = 0; kind < RMAP_PHOTON_KINDS; kind++) {
            const double mean =
                expect(steps, medium, &steps->step[i], (enum rmap_photon_kind)kind, sum);
            const double resolution = kind == RMAP_PHOTON_SCINTILLATION && medium->scintillation
                                          ? medium->scintillation->resolution
                                          : 1.0;
            before += steps->counted && mean < PHOTONS_MAX
                          ? (double)rmap_photon_number(mean, resolution, steps->seed,
                                                       i * RMAP_PHOTON_KINDS + (uint64_t)kind)
                          : mean;
            steps->photons[i * RMAP_PHOTON_KINDS + (size_t)kind] = before;
        }
}

enum rmap_status rmap_steps_prepare(struct rmap_steps *steps,
                                    const struct rmap_steps_medium *medium, double *share,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    double sum[RMAP_CHANNEL_MAX] = {0}, all = 0.0;
    for (size_t i = 0; i < steps->n; i++) {
        const char *trouble = trouble_of(&steps->step[i]);
        if (trouble)
            RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "step %zu: %s", i + 1, trouble));
    }
    RMAP_TRY(sort(steps, err));
    steps->ns_per_length = medium->unit_m / 0.299792458;
    if (steps->emits[RMAP_PHOTON_CHERENKOV])
        RMAP_TRY(set_bands(steps, medium, err));
    count_photons(steps, medium, sum);
    for (int i = 0; i < medium->channels->n; i++)
        all += sum[i];
    if (!(all > 0.0) || !(rmap_steps_photons(steps) > 0.0))
        RMAP_TRY(rmap_error_set(
            err, RMAP_INPUT,
            "its steps make no light in this medium: scintillation takes a deposited "
            "energy, Cherenkov light a beta above 1 / index"));
    if (!(rmap_steps_photons(steps) < PHOTONS_MAX))
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT,
                                "its steps make %g photons: at most %g are counted",
                                rmap_steps_photons(steps), PHOTONS_MAX));
    for (int i = 0; i < medium->channels->n; i++)
        share[i] = sum[i] / all;
out:
    return st;
}

double rmap_steps_photons(const struct rmap_steps *steps)
{
    return steps->n > 0 ? steps->photons[steps->n * RMAP_PHOTON_KINDS - 1] : 0.0;
}

uint64_t rmap_steps_n_counted(const struct rmap_steps *steps)
{
    const double all = rmap_steps_photons(steps);
    return steps->counted && all >= 1.0 && all < PHOTONS_MAX ? (uint64_t)all : 0;
}

/* ---- which one a ray is ---- */

size_t rmap_steps_find(const struct rmap_steps *steps, uint64_t ordinal, double u,
                       enum rmap_photon_kind *kind_ret)
{
    const uint64_t n = rmap_steps_n_counted(steps);
    const double value = !steps->counted ? u * rmap_steps_photons(steps)
                         : n > 0         ? (double)(ordinal % n)
                                         : 0.0;
    const size_t at = rmap_first_above(steps->photons, steps->n * RMAP_PHOTON_KINDS, value);
    *kind_ret = (enum rmap_photon_kind)(at % RMAP_PHOTON_KINDS);
    return at / RMAP_PHOTON_KINDS;
}

static int pick_channel(const struct rmap_steps *steps, const struct rmap_steps_medium *medium,
                        const struct rmap_photon *photon, double u)
{
    const struct rmap_track_step *step = &steps->step[photon->step];
    double weight[RMAP_CHANNEL_MAX], below = 0.0;
    for (int i = 0; i < medium->channels->n; i++) {
        if (photon->kind == RMAP_PHOTON_CHERENKOV)
            below += steps->cherenkov[i] *
                     rmap_cherenkov_strength(medium->n[i], step->beta, step->charge);
        else if (medium->scintillation)
            below += medium->scintillation->share[i];
        weight[i] = below;
    }
    return (int)rmap_first_above(weight, (size_t)medium->channels->n, u * below);
}

void rmap_steps_draw(const struct rmap_steps *steps, const struct rmap_steps_medium *medium,
                     uint64_t ordinal, const double place[4], const double way[4],
                     struct rmap_photon *photon)
{
    photon->step = rmap_steps_find(steps, ordinal, place[0], &photon->kind);
    const struct rmap_track_step *step = &steps->step[photon->step];
    photon->channel = pick_channel(steps, medium, photon, place[1]);
    const double along = place[2] * step->length;
    photon->position = rmap_axpy(along, step->direction, step->position);
    photon->delay_ns = step->time_ns + along / step->beta * steps->ns_per_length;
    if (photon->kind == RMAP_PHOTON_SCINTILLATION) {
        photon->direction = rmap_about_z(2.0 * way[0], way[1]);
        if (medium->scintillation)
            photon->delay_ns += rmap_scintillation_delay(
                medium->scintillation, (const double[3]){place[3], way[2], way[3]});
        return;
    }
    struct rmap_vec3 x, y;
    const double cosine = 1.0 / (medium->n[photon->channel] * step->beta);
    const struct rmap_vec3 local = rmap_about_z(1.0 - rmap_min(cosine, 1.0), way[1]);
    rmap_basis(step->direction, &x, &y);
    photon->direction = rmap_in_frame(local, x, y, step->direction);
}
