/* SPDX-License-Identifier: MIT
 *
 * The colour along a path: shares of the channels, weighed by the probability of what happened
 * (trace/interact.c has the physics), on the channels that are still live.
 */
#include <string.h>

#include "base/rng.h"
#include "compact/model.h"
#include "compact/portable.h"
#include "optics/fresnel.h"
#include "portion/event.h"
#include "portion/portion_recorder.h"

static void trim(struct rmap_compact_light *light)
{
    while (light->end - light->begin > 1 && !(light->share[light->begin] > 0.0))
        light->begin++;
    while (light->end - light->begin > 1 && !(light->share[light->end - 1] > 0.0))
        light->end--;
}

static void collapse(struct rmap_compact_light *light, int channel)
{
    for (int i = light->begin; i < light->end; i++) {
        light->share[i] = 0.0;
        light->quantised[i] = 0;
    }
    light->share[channel] = 1.0;
    light->quantised[channel] = 65535;
    light->begin = channel;
    light->end = channel + 1;
    light->changed = false;
}

void rmap_light_begin(const struct rmap_compact_model *model, int32_t source, int channel,
                      struct rmap_compact_light *light)
{
    size_t n = (size_t)model->n_channel;
    light->begin = 0;
    light->end = model->n_channel;
    light->changed = false;
    if (source < 0 || (size_t)source >= model->n_source) {
        memset(light->share, 0, n * sizeof *light->share);
        memset(light->quantised, 0, n * sizeof *light->quantised);
        collapse(light, 0);
        return;
    }
    memcpy(light->share, model->scene->source[source].colour, n * sizeof *light->share);
    memcpy(light->quantised, model->source[source].colour, n * sizeof *light->quantised);
    trim(light);
    if (channel >= 0 && channel < model->n_channel)
        collapse(light, channel);
}

void rmap_light_set(const uint16_t *quantised, int n_channel, struct rmap_compact_light *light)
{
    for (int i = 0; i < n_channel; i++)
        light->share[i] = (double)quantised[i] / 65535.0;
    memcpy(light->quantised, quantised, (size_t)n_channel * sizeof *quantised);
    light->begin = 0;
    light->end = n_channel;
    light->changed = false;
    trim(light);
}

double rmap_light_mean(const struct rmap_compact_light *light, const double *value)
{
    if (light->end - light->begin == 1)
        return value[light->begin];
    double sum = 0.0;
    for (int i = light->begin; i < light->end; i++)
        sum += light->share[i] * value[i];
    return sum;
}

void rmap_light_quantise(int n_channel, struct rmap_compact_light *light)
{
    double sum = 0.0;
    light->changed = false;
    for (int i = 0; i < n_channel; i++)
        sum += light->share[i];
    if (sum > 0.0 && sum < 1e300) /* or else it says nothing */
        rmap_colour_quantise(light->share, n_channel, light->quantised);
}

static void weigh(struct rmap_compact_light *light, const double *p)
{
    int alike = light->begin + 1;
    while (alike < light->end && p[alike] == p[light->begin])
        alike++;
    if (alike == light->end)
        return;
    double sum = rmap_light_mean(light, p);
    for (int i = light->begin; i < light->end; i++)
        light->share[i] *= p[i] / sum;
    light->changed = true;
    trim(light);
}

static double fresnel(const struct rmap_encounter *e, int channel, bool *total)
{
    struct rmap_fresnel f =
        rmap_fresnel_dielectric(e->near->n[channel], e->far->n[channel], e->cosine);
    *total = f.total;
    if (f.total)
        return 1.0;
    if (e->surface->coat == RMAP_COAT_REFLECTANCE)
        return e->surface->reflect_specular[channel];
    return e->surface->coat == RMAP_COAT_IDEAL ? 0.0 : 0.5 * (f.rs + f.rp);
}

static void meet_fresnel(const struct rmap_encounter *e, struct rmap_compact_light *light)
{
    bool dispersive = e->near->dispersive || e->far->dispersive, all_total = true;
    double r[RMAP_CHANNEL_MAX];
    if (!dispersive && e->surface->coat != RMAP_COAT_REFLECTANCE)
        return;
    if (e->event == RMAP_EVENT_TRANSMIT_SPECULAR && dispersive && e->channel >= 0) {
        collapse(light, e->channel);
        return;
    }
    for (int i = light->begin; i < light->end; i++) {
        bool total;
        r[i] = fresnel(e, i, &total);
        all_total = all_total && (total || !(light->share[i] > 0.0));
    }
    if (all_total)
        return;
    for (int i = light->begin; i < light->end && e->event != RMAP_EVENT_REFLECT_SPECULAR; i++)
        r[i] = 1.0 - r[i];
    weigh(light, r);
}

/* Born & Wolf 14.2, eqs. 5 to 8, as optics/fresnel.c has them. */
static double metal(double n1, double n, double k, double cos_i)
{
    double m_n = n / n1, m_k = k / n1, sin2 = 1.0 - cos_i * cos_i;
    double real = m_n * m_n - m_k * m_k - sin2, imaginary = 2.0 * m_n * m_k;
    double ab2 = sqrt(real * real + imaginary * imaginary), half = 0.5 * (ab2 + real);
    double a = sqrt(half > 0.0 ? half : 0.0);
    double s_sum = ab2 + cos_i * cos_i, s_mix = 2.0 * a * cos_i;
    double p_sum = ab2 * cos_i * cos_i + sin2 * sin2, p_mix = s_mix * sin2;
    if (s_sum + s_mix <= 0.0 || p_sum + p_mix <= 0.0)
        return 1.0;
    double rs = (s_sum - s_mix) / (s_sum + s_mix);
    return 0.5 * rs * (1.0 + (p_sum - p_mix) / (p_sum + p_mix));
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
        for (int i = light->begin; i < light->end; i++)
            p[i] = metal(e->near->n[i], surface->metal_n[i], surface->metal_k[i], e->cosine);
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

void rmap_light_meet(const struct rmap_encounter *encounter, struct rmap_compact_light *light)
{
    if (light->end - light->begin == 1)
        return;
    if (encounter->surface->type == RMAP_SURFACE_FRESNEL)
        meet_fresnel(encounter, light);
    else
        meet_shares(encounter, light);
}

static int pick(const struct rmap_compact_light *light, double u)
{
    double total = 0.0, sum = 0.0;
    int last = light->begin;
    for (int i = light->begin; i < light->end; i++)
        total += light->share[i];
    for (int i = light->begin; i < light->end; i++) {
        if (!(light->share[i] > 0.0))
            continue;
        last = i;
        sum += light->share[i];
        if (u * total < sum)
            break;
    }
    return last;
}

double rmap_light_absorb(const struct rmap_medium *medium, uint64_t seed, uint64_t ray,
                         uint32_t step, double length, bool absorbed,
                         struct rmap_compact_light *light)
{
    double u[4], p[RMAP_CHANNEL_MAX], travelled = length;
    bool single = light->end - light->begin == 1;
    if (absorbed) {
        rmap_rng(seed, ray, step, RMAP_RNG_MEDIUM, u);
        double mu = medium->absorption[single ? light->begin : pick(light, u[0])];
        travelled = -rmap_portable_log(u[1]) / mu;
        if (!(travelled < length))
            travelled = length;
    }
    if (single)
        return travelled;
    int alike = light->begin + 1;
    while (alike < light->end && medium->absorption[alike] == medium->absorption[light->begin])
        alike++;
    if (alike == light->end)
        return travelled; /* equal probabilities weigh nothing */
    for (int i = light->begin; i < light->end; i++) {
        double mu_i = medium->absorption[i];
        if (i > light->begin && mu_i == medium->absorption[i - 1])
            p[i] = p[i - 1];
        else
            p[i] = (1.0 - rmap_portable_one_minus_exp(mu_i * travelled)) * (absorbed ? mu_i : 1.0);
    }
    weigh(light, p);
    return travelled;
}
