/* SPDX-License-Identifier: MIT
 *
 * What a detector makes of light that it registered.
 */
#include "analysis/criterion/registration_response.h"

#include "analysis/criterion/registration_angle.h"
#include "base/rng.h"

/* share: of light with these, NULL: with those stored. */
static double respond(const struct rmap_scene *scene, const struct rmap_portion *portion,
                      const struct rmap_registration_place *place, const uint16_t *share)
{
    const struct rmap_detector *detector =
        &scene->detector[portion->registration.detector[place->row]];
    const struct rmap_response *response = detector->response;
    const uint32_t segment = portion->registration.segment[place->row];
    if (!response)
        return 1.0;
    if (segment >= portion->ray.segment_count[place->ray] ||
        portion->n_channel != response->n_channel)
        return 0.0;
    if (!share)
        share = portion->colour + (place->first_segment + segment) * (size_t)portion->n_channel;
    const double angle =
        response->n_angle > 1
            ? rmap_registration_angle(detector, portion->registration.direction + 3 * place->row)
            : 0.0;
    return rmap_response_at(response, share, angle);
}

double rmap_registration_response(const struct rmap_scene *scene,
                                  const struct rmap_portion *portion,
                                  const struct rmap_registration_place *place)
{
    return respond(scene, portion, place, NULL);
}

double rmap_registration_response_to(const struct rmap_scene *scene,
                                     const struct rmap_portion *portion,
                                     const struct rmap_registration_place *place, int channel)
{
    uint16_t alone[RMAP_CHANNEL_MAX] = {0};
    alone[channel] = UINT16_MAX;
    return respond(scene, portion, place, alone);
}

bool rmap_registration_detected(const struct rmap_scene *scene, const struct rmap_portion *portion,
                                const struct rmap_registration_place *place)
{
    const int32_t detector = portion->registration.detector[place->row];
    double u[4];
    if (!rmap_detector_chances(&scene->detector[detector]))
        return true;
    rmap_rng(scene->seed, portion->ray.id[place->ray], portion->registration.segment[place->row],
             (enum rmap_rng_slot)(RMAP_RNG_DETECT + detector), u);
    return u[0] < rmap_registration_response(scene, portion, place);
}
