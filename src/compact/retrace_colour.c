/* SPDX-License-Identifier: MIT
 *
 * The colour along a path: shares of the channels, weighed by the probability of what happened
 * (trace/interact.c has the physics), on the channels that are still live.
 */
#include <math.h>
#include <string.h>

#include "base/portable.h"
#include "base/rng.h"
#include "compact/model.h"
#include "compact/retrace_colour.h"
#include "optics/fresnel.h"
#include "portion/event.h"
#include "portion/portion_recorder.h"
#include "trace/interact.h"
#include "trace/luminescence.h"
#include "trace/scattering.h"
#include "trace/turbid.h"

static void collapse(struct rmap_compact_light *light, int channel)
{
    for (int i = light->colour.begin; i < light->colour.end; i++)
        light->quantised[i] = 0;
    light->quantised[channel] = 65535;
    rmap_colour_collapse(&light->colour, channel);
    light->changed = false;
}

void rmap_light_begin(const struct rmap_compact_model *model, int32_t source, int channel,
                      struct rmap_compact_light *light)
{
    static const double none[RMAP_CHANNEL_MAX];
    const size_t n = (size_t)model->n_channel;
    const bool known = source >= 0 && (size_t)source < model->n_source;
    rmap_colour_set(&light->colour, known ? model->scene->source[source].colour : none,
                    model->n_channel);
    light->changed = false;
    if (known)
        memcpy(light->quantised, model->source[source].colour, n * sizeof *light->quantised);
    else
        memset(light->quantised, 0, n * sizeof *light->quantised);
    if (!known || (channel >= 0 && channel < model->n_channel))
        collapse(light, known ? channel : 0);
}

void rmap_light_set(const uint16_t *quantised, int n_channel, struct rmap_compact_light *light)
{
    double share[RMAP_CHANNEL_MAX];
    for (int i = 0; i < n_channel; i++)
        share[i] = (double)quantised[i] / 65535.0;
    memmove(light->quantised, quantised, (size_t)n_channel * sizeof *quantised);
    rmap_colour_set(&light->colour, share, n_channel);
    light->changed = false;
}

void rmap_light_quantise(int n_channel, struct rmap_compact_light *light)
{
    double sum = 0.0;
    light->changed = false;
    for (int i = 0; i < n_channel; i++)
        sum += light->colour.share[i];
    if (sum > 0.0 && sum < 1e300) /* or else it says nothing */
        rmap_colour_quantise(light->colour.share, n_channel, light->quantised);
}

static void weigh(struct rmap_compact_light *light, const double *p)
{
    light->changed |= rmap_colour_weigh(&light->colour, p);
}

static void meet_film(const struct rmap_encounter *e, struct rmap_compact_light *light)
{
    double p[RMAP_CHANNEL_MAX];
    if (!e->predicted->films)
        return;
    for (int i = light->colour.begin; i < light->colour.end; i++) {
        const struct rmap_coat_shares its =
            rmap_thin_film_coat(e->scene, &e->scene->object[e->object], e->front, i, e->near->n[i],
                                e->far->n[i], e->cosine);
        p[i] = e->event == RMAP_EVENT_TRANSMIT_SPECULAR ? its.passed : its.reflected;
    }
    weigh(light, p);
}

static void meet_fresnel(const struct rmap_encounter *e, struct rmap_compact_light *light)
{
    bool dispersive = e->near->dispersive || e->far->dispersive, all_total = true;
    const bool film = e->surface->coat == RMAP_COAT_FILM;
    double r[RMAP_CHANNEL_MAX];
    if (!dispersive && !film && e->surface->coat != RMAP_COAT_REFLECTANCE)
        return;
    if (e->event == RMAP_EVENT_TRANSMIT_SPECULAR && dispersive && e->channel >= 0) {
        collapse(light, e->channel);
        return;
    }
    if (film) {
        meet_film(e, light);
        return;
    }
    for (int i = light->colour.begin; i < light->colour.end; i++) {
        bool total;
        r[i] =
            rmap_coated_reflectance(e->surface, i, e->near->n[i], e->far->n[i], e->cosine, &total);
        all_total = all_total && (total || !(light->colour.share[i] > 0.0));
    }
    if (all_total)
        return;
    for (int i = light->colour.begin;
         i < light->colour.end && e->event != RMAP_EVENT_REFLECT_SPECULAR; i++)
        r[i] = 1.0 - r[i];
    weigh(light, r);
}

static void meet_shares(const struct rmap_encounter *e, struct rmap_compact_light *light)
{
    const struct rmap_surface *surface = e->surface;
    double p[RMAP_CHANNEL_MAX];
    switch (e->event) {
    case RMAP_EVENT_REFLECT_SPECULAR:
        if (surface->type != RMAP_SURFACE_MIRROR || !surface->is_metal) {
            weigh(light, surface->reflect_specular);
            return;
        }
        for (int i = light->colour.begin; i < light->colour.end; i++)
            p[i] = e->predicted->films && surface->coat == RMAP_COAT_FILM
                       ? rmap_metal_coat(e->scene, surface, i, e->near->n[i], e->cosine)
                       : rmap_fresnel_metal_portable(e->near->n[i], surface->metal_n[i],
                                                     surface->metal_k[i], e->cosine);
        weigh(light, p);
        return;
    case RMAP_EVENT_REFLECT_DIFFUSE:
        weigh(light, surface->reflect_diffuse);
        return;
    case RMAP_EVENT_TRANSMIT_DIFFUSE:
        weigh(light, surface->transmit_diffuse);
        return;
    case RMAP_EVENT_TRANSMIT_SPECULAR:
        if (e->channel >= 0 && (e->near->dispersive || e->far->dispersive))
            collapse(light, e->channel);
        else
            weigh(light, surface->transmit_specular);
        return;
    default:
        return;
    }
}

/* At the facet that was met, where there are facets. */
static double share_of(const struct rmap_scatter_side *side, struct rmap_vec3 in, bool facets,
                       bool passes, bool diffuse)
{
    if (facets) {
        const struct rmap_coat_shares smooth = rmap_smooth_shares(side, -in.z);
        return passes ? smooth.passed : smooth.reflected;
    }
    const struct rmap_surface_shares its = rmap_scatter_shares(side, in);
    if (diffuse)
        return passes ? its.transmit_diffuse : its.reflect_diffuse;
    return passes ? its.transmit_specular : its.reflect_specular;
}

/* By what the event takes of the light on each channel, where that follows from the angle. */
static void weigh_share(const struct rmap_encounter *e, bool facets,
                        struct rmap_compact_light *light)
{
    const bool diffuse = e->event & (RMAP_EVENT_REFLECT_DIFFUSE | RMAP_EVENT_TRANSMIT_DIFFUSE),
               passes = e->event & (RMAP_EVENT_TRANSMIT_SPECULAR | RMAP_EVENT_TRANSMIT_DIFFUSE);
    const struct rmap_vec3 in = {sqrt((1.0 - e->cosine) * (1.0 + e->cosine)), 0.0, -e->cosine};
    struct rmap_scatter_side side = {.scene = e->scene,
                                     .object = &e->scene->object[e->object],
                                     .front = e->front,
                                     .surface = e->surface,
                                     .portable = e->predicted->metals,
                                     .near = (int32_t)(e->near - e->scene->medium),
                                     .far = (int32_t)(e->far - e->scene->medium)};
    double p[RMAP_CHANNEL_MAX];
    if (!e->predicted->weighed || (e->surface->coat == RMAP_COAT_FILM && !e->predicted->films) ||
        !rmap_scatter_shares_follow(&side, passes))
        return;
    for (int i = light->colour.begin; i < light->colour.end; i++) {
        side.channel = i;
        side.n1 = e->near->n[i];
        side.n2 = e->far->n[i];
        p[i] = share_of(&side, in, facets, passes, diffuse);
    }
    if (rmap_colour_sum(&light->colour, p) > 0.0)
        weigh(light, p);
}

/* The tracer marks the colours of other cases. */
static void meet_model(const struct rmap_encounter *e, struct rmap_compact_light *light)
{
    const bool passes = (e->event & RMAP_EVENT_TRANSMIT_DIFFUSE) != 0,
               diffuse = passes || (e->event & RMAP_EVENT_REFLECT_DIFFUSE),
               dispersive = e->near->dispersive || e->far->dispersive;
    const struct rmap_scatter *its = rmap_surface_scatter(e->scene, e->surface, passes);
    const bool facets = its && rmap_scatter_is_facets(its);
    const struct rmap_scatter *second =
        its && its->next > 0 ? &e->scene->scatter[its->next - 1] : NULL;
    const bool drawn =
        (second && second->by_wavelength) ||
        (its && (its->by_wavelength || (rmap_scatter_uses_index(its) && dispersive)));
    if ((drawn && (diffuse || facets)) ||
        (e->event == RMAP_EVENT_TRANSMIT_SPECULAR && dispersive)) {
        if (e->channel >= 0)
            collapse(light, e->channel);
    } else if (diffuse && its && !facets && !its->by_roughness) {
        weigh(light, its->amount);
    } else if (e->event & (RMAP_EVENT_REFLECT_SPECULAR | RMAP_EVENT_REFLECT_DIFFUSE |
                           RMAP_EVENT_TRANSMIT_SPECULAR | RMAP_EVENT_TRANSMIT_DIFFUSE |
                           RMAP_EVENT_TOTAL_REFLECTION)) {
        weigh_share(e, facets, light);
    }
}

void rmap_light_meet(const struct rmap_encounter *encounter, struct rmap_compact_light *light)
{
    if (rmap_colour_single(&light->colour))
        return;
    if (rmap_surface_scatters(encounter->surface))
        meet_model(encounter, light);
    else if (encounter->surface->type == RMAP_SURFACE_FRESNEL)
        meet_fresnel(encounter, light);
    else
        meet_shares(encounter, light);
}

/* Absorbed or not, where the medium also scatters. */
static void weigh_choice(const struct rmap_inside *inside, const double *mu,
                         struct rmap_compact_light *light)
{
    double p[RMAP_CHANNEL_MAX];
    if (!inside->turbid || !inside->medium->scattering_at_all || !inside->medium->absorbing)
        return;
    for (int i = light->colour.begin; i < light->colour.end; i++) {
        p[i] = mu[i] > 0.0 ? inside->medium->absorption[i] / mu[i] : 0.0;
        if (inside->event == RMAP_EVENT_SCATTER_VOLUME)
            p[i] = 1.0 - p[i];
    }
    if (rmap_colour_sum(&light->colour, p) > 0.0)
        weigh(light, p);
}

double rmap_light_travel(const struct rmap_inside *inside, struct rmap_compact_light *light)
{
    double u[4], p[RMAP_CHANNEL_MAX], mu[RMAP_CHANNEL_MAX], travelled = inside->length;
    const bool ended = inside->event != 0;
    for (int i = light->colour.begin; i < light->colour.end; i++)
        mu[i] =
            inside->medium->absorption[i] + (inside->turbid ? inside->medium->scattering[i] : 0.0);
    const bool single = rmap_colour_single(&light->colour);
    if (ended) {
        rmap_rng(inside->draw.seed, inside->draw.ray, inside->draw.step, RMAP_RNG_MEDIUM, u);
        travelled = -rmap_portable_log(u[1]) /
                    mu[single ? light->colour.begin : rmap_colour_pick(&light->colour, NULL, u[0])];
        if (!(travelled < inside->length))
            travelled = inside->length;
    }
    if (single)
        return travelled;
    int alike = light->colour.begin + 1;
    while (alike < light->colour.end && mu[alike] == mu[light->colour.begin])
        alike++;
    /* equal probabilities weigh nothing */
    for (int i = light->colour.begin; i < light->colour.end && alike < light->colour.end; i++) {
        if (i > light->colour.begin && mu[i] == mu[i - 1])
            p[i] = p[i - 1];
        else
            p[i] = (1.0 - rmap_portable_one_minus_exp(mu[i] * travelled)) * (ended ? mu[i] : 1.0);
    }
    if (alike < light->colour.end)
        weigh(light, p);
    if (ended)
        weigh_choice(inside, mu, light);
    return travelled;
}

bool rmap_light_go_on(const struct rmap_inside *inside, int n_channel,
                      struct rmap_compact_light *light, struct rmap_vec3 *direction)
{
    const bool single = rmap_colour_single(&light->colour);
    struct rmap_reemission back;
    if (inside->event == RMAP_EVENT_SCATTER_VOLUME) {
        *direction = rmap_scatter(inside->medium, &inside->draw, &light->colour, *direction);
        if (single || !rmap_colour_single(&light->colour))
            return false;
        collapse(light, light->colour.begin);
        return true;
    }
    *direction = rmap_reemit_direction(&inside->draw);
    if (!single ||
        !rmap_reemit(inside->medium, n_channel, &inside->draw, light->colour.begin, &back))
        return false;
    collapse(light, back.channel);
    light->delay_ns += back.delay_ns;
    return true;
}
