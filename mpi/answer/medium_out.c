/* SPDX-License-Identifier: MIT
 *
 * What the media of a scene scatter, for `raymap check`.
 */
#include "mpi/answer/medium_out.h"

#include "io/export/json_number.h"

static const struct rmap_suspended *spheres_of(const struct rmap_medium *medium, int channel)
{
    if (medium->phase.kind != RMAP_PHASE_MIE)
        return NULL;
    return &medium->phase.suspended[medium->phase.n_profile > 1 ? channel : 0];
}

static double mean_cosine(const struct rmap_medium *medium, int channel)
{
    const struct rmap_suspended *spheres = spheres_of(medium, channel);
    if (spheres)
        return spheres->mie.cosine;
    return medium->phase.n_profile > 0
               ? rmap_phase_mean_cosine(rmap_phase_profile(&medium->phase, channel))
               : medium->scattering_g;
}

void rmap_turbid_print(const struct rmap_scene *scene, FILE *out)
{
    const int k = scene->channels.n / 2;
    for (size_t i = 0; i < scene->n_medium; i++) {
        const struct rmap_medium *medium = &scene->medium[i];
        const struct rmap_suspended *spheres = spheres_of(medium, k);
        if (!medium->scattering_at_all)
            continue;
        fprintf(out, "    medium %s: scatters by %s, %.6g per %s, mean cosine %.6g, at %g nm\n",
                medium->name, rmap_phase_word[medium->phase.kind], medium->scattering[k],
                scene->unit, mean_cosine(medium, k), scene->channels.wavelength_nm[k]);
        if (spheres)
            fprintf(out,
                    "      spheres: Qext %.7g, Qsca %.7g, Qback %.7g, cross-section %.4g %s^2, "
                    "%.4g per %s^3\n",
                    spheres->mie.extinct, spheres->mie.scattered, spheres->mie.back, spheres->area,
                    scene->unit, medium->scattering[k] / (spheres->area * spheres->mie.scattered),
                    scene->unit);
    }
}

json_t *rmap_turbid_json(const struct rmap_scene *scene)
{
    json_t *all = json_array();
    for (size_t i = 0; i < scene->n_medium; i++) {
        const struct rmap_medium *medium = &scene->medium[i];
        json_t *channels = json_array();
        for (int k = 0; k < scene->channels.n && medium->scattering_at_all; k++) {
            const struct rmap_suspended *spheres = spheres_of(medium, k);
            json_t *its =
                json_pack("{s:f, s:o, s:o, s:o}", "wavelength", scene->channels.wavelength_nm[k],
                          "scattering", rmap_json_number(medium->scattering[k]), "absorption",
                          rmap_json_number(medium->absorption[k]), "mean_cosine",
                          rmap_json_number(mean_cosine(medium, k)));
            if (spheres)
                (void)json_object_set_new(its, "spheres",
                                          json_pack("{s:o, s:o, s:o, s:o, s:o}", "Qext",
                                                    rmap_json_number(spheres->mie.extinct), "Qsca",
                                                    rmap_json_number(spheres->mie.scattered),
                                                    "Qback", rmap_json_number(spheres->mie.back),
                                                    "g", rmap_json_number(spheres->mie.cosine),
                                                    "area", rmap_json_number(spheres->area)));
            (void)json_array_append_new(channels, its);
        }
        if (medium->scattering_at_all)
            (void)json_array_append_new(all, json_pack("{s:s, s:s, s:o}", "medium", medium->name,
                                                       "phase", rmap_phase_word[medium->phase.kind],
                                                       "channels", channels));
        else
            json_decref(channels);
    }
    return all;
}
