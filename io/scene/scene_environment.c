/* SPDX-License-Identifier: MIT
 *
 * A picture of all that is around, as light.
 */
#include "io/scene/scene_environment.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/portable.h"
#include "base/search.h"
#include "formula/azimuth.h"
#include "io/picture/picture.h"
#include "optics/spectrum.h"

bool rmap_reader_background_shines(const struct rmap_reader *reader)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(reader->root, "background"),
                                *trace = rmap_yaml_get(node, "trace");
    return rmap_yaml_get(node, "file") ||
           (trace && trace->text && strcmp(trace->text, "true") == 0);
}

/* Cells of at most a degree: light through an opening is the same from all over a cell. */
static size_t pieces(uint32_t n, uint32_t least)
{
    return (least + n - 1) / n;
}

/* The centre is north, right is east, the upper row is the zenith. */
static enum rmap_status fill_latlong(const struct rmap_picture *picture, struct rmap_sky *sky,
                                     struct rmap_error *err)
{
    const size_t wide = picture->size[0],
                 fine[2] = {pieces(picture->size[0], 360), pieces(picture->size[1], 180)};
    const enum rmap_status st =
        rmap_sky_init(sky, fine[1] * picture->size[1], fine[0] * wide, true, err);
    if (st != RMAP_OK)
        return st;
    rmap_sky_even_rows(sky, 0, 0.0, sky->n_row, 180.0);
    for (size_t r = 0; r < sky->n_row; r++)
        for (size_t k = 0; k < sky->n_around; k++)
            memcpy(sky->band + 3 * (r * sky->n_around + k),
                   picture->rgb + 3 * (r / fine[1] * wide + wide - 1 - k / fine[0]),
                   3 * sizeof *sky->band);
    return RMAP_OK;
}

/* Angular maps: the centre is north, the rim south, and the distance to the centre goes by the
 * angle. In the frame of a sky x is south, y east, z up. */

struct deposit {
    double light[3], steradian;
    float least[3];
};

static size_t cell_of(const struct rmap_sky *sky, double south, double east, double up)
{
    const size_t row = rmap_first_above(sky->edge + 1, sky->n_row, 1.0 - up);
    const double half = rmap_portable_angle(south, east < 0.0 ? -east : east) / (2.0 * RMAP_PI),
                 turn = east < 0.0 ? 1.0 - half : half;
    const size_t k = (size_t)(turn * (double)sky->n_around);
    return row * sky->n_around + (k < sky->n_around ? k : sky->n_around - 1);
}

/* One pixel in parts, to the cells that they lie in. */
static void deposit_pixel(const float *rgb, const double corner[2], double step, size_t parts,
                          const struct rmap_sky *sky, struct deposit *deposit)
{
    const double fine = step / (double)parts;
    for (size_t p = 0; p < parts * parts; p++) {
        const double x = corner[0] + fine * ((double)(p % parts) + 0.5),
                     y = corner[1] - fine * ((double)(p / parts) + 0.5), r = sqrt(x * x + y * y);
        double cosine, sine;
        if (!(r <= 1.0))
            continue;
        rmap_azimuth(0.5 * r, &cosine, &sine);
        const double over = r > 0.0 ? sine / r : RMAP_PI, steradian = RMAP_PI * over * fine * fine;
        struct deposit *to = &deposit[cell_of(sky, -cosine, x * over, y * over)];
        for (int b = 0; b < 3; b++) {
            to->least[b] = to->steradian > 0.0 && to->least[b] < rgb[b] ? to->least[b] : rgb[b];
            to->light[b] += steradian * (double)rgb[b];
        }
        to->steradian += steradian;
    }
}

/* All light there is in a cell, over its solid angle: but for what is the same all over it. */
static void spread(const struct rmap_sky *sky, size_t cell, const struct deposit *deposit)
{
    const size_t row = cell / sky->n_around;
    const double whole =
        2.0 * RMAP_PI / (double)sky->n_around * (sky->edge[row + 1] - sky->edge[row]);
    for (size_t b = 0; b < 3; b++) {
        const double least = (double)deposit->least[b];
        sky->band[3 * cell + b] =
            (float)(least + (deposit->light[b] - least * deposit->steradian) / whole);
    }
}

static enum rmap_status fill_angular(const struct rmap_picture *picture, struct rmap_sky *sky,
                                     struct rmap_error *err)
{
    const size_t size = picture->size[0], n_row = size > 360 ? size / 2 : 180,
                 parts = (6 * n_row + size - 1) / size;
    const double step = 2.0 / (double)size;
    const enum rmap_status st = rmap_sky_init(sky, n_row, 2 * n_row, true, err);
    struct deposit *deposit = rmap_alloc(2 * n_row * n_row, sizeof *deposit);
    if (st != RMAP_OK || !deposit) {
        rmap_free(deposit);
        return st != RMAP_OK ? st : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    }
    rmap_sky_even_rows(sky, 0, 0.0, sky->n_row, 180.0);
    for (size_t i = 0; i < size * size; i++) {
        const double corner[2] = {(double)(i % size) * step - 1.0, 1.0 - (double)(i / size) * step};
        deposit_pixel(picture->rgb + 3 * i, corner, step, parts, sky, deposit);
    }
    for (size_t i = 0; i < 2 * n_row * n_row; i++)
        spread(sky, i, &deposit[i]);
    rmap_free(deposit);
    return RMAP_OK;
}

static enum rmap_status fill(const struct rmap_picture *picture, bool angular, struct rmap_sky *sky,
                             struct rmap_error *err)
{
    if (angular && picture->size[0] != picture->size[1])
        return rmap_error_set(
            err, RMAP_INPUT,
            "an angular map is square, and this is %u x %u pixels: 'map: latlong' "
            "is twice as wide as high",
            picture->size[0], picture->size[1]);
    return angular ? fill_angular(picture, sky, err) : fill_latlong(picture, sky, err);
}

void rmap_reader_read_environment(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                  struct rmap_source *source, struct rmap_source_light *light,
                                  struct rmap_sky_plan *plan)
{
    static const struct rmap_text_kind kind = {"a picture of the surroundings", NULL, "",
                                               (size_t)256 << 20};
    static const char *const unit[] = {"cd/m2", "W/(m2 sr)", "W/m2/sr"};
    struct rmap_picture picture = {.rgb = NULL};
    struct rmap_vec3 rotate = {0, 0, 0};
    int angular = 0, word = 0;
    size_t nbytes = 0;
    const uint8_t *bytes = (const uint8_t *)rmap_reader_file(reader, node, "file", &kind, &nbytes);
    if (!bytes ||
        !rmap_reader_choice(reader, node, "map", RMAP_OPTIONAL, "latlong angular", &angular) ||
        !rmap_reader_one_of(reader, node, "unit", RMAP_OPTIONAL, unit, RMAP_COUNT(unit), &word) ||
        !rmap_reader_vec3(reader, node, "rotate", &rmap_range_angle, &rotate))
        return;
    if (rmap_yaml_get(node, "spectrum"))
        rmap_reader_error(reader, rmap_yaml_get(node, "spectrum"),
                          "the picture has colours of its own: leave 'spectrum' out");
    light->flux = plan->amount = 1;
    light->spectrum_given = true;
    light->either = rmap_yaml_get(node, "unit") == NULL;
    light->unit = !light->either && word == 0 ? RMAP_FLUX_LM : RMAP_FLUX_W;
    plan->measure = RMAP_SKY_RADIANCE;
    plan->unit = light->either ? RMAP_SKY_ANY : word == 0 ? RMAP_SKY_CD : RMAP_SKY_W;
    const struct rmap_affine turn =
        rmap_affine_placement(rmap_vec3(1, 1, 1), rotate, rmap_vec3(0, 0, 0));
    source->frame = rmap_affine_compose(&turn, &source->frame);
    enum rmap_status st = rmap_picture_read(bytes, nbytes, &picture, &reader->failure);
    if (st == RMAP_OK)
        st = fill(&picture, angular == 1, source->sky, &reader->failure);
    if (st == RMAP_INPUT)
        rmap_error_context(&reader->failure, "%.100s", rmap_yaml_get(node, "file")->text);
    (void)snprintf(source->sky->title, sizeof source->sky->title, "%u x %u pixels", picture.size[0],
                   picture.size[1]);
    rmap_picture_fini(&picture);
    rmap_reader_made(reader, rmap_yaml_get(node, "file"), st);
}

/* Channels of a band, added up; false where the scene has none. */
static bool mix_band(const struct rmap_channels *channels, bool luminous, int band, double *mix)
{
    struct rmap_spectrum spectrum = {.kind = RMAP_SPECTRUM_RGB};
    struct rmap_error none;
    spectrum.rgb[band] = 1.0;
    if (rmap_spectrum_shares(&spectrum, channels, luminous, mix, &none) != RMAP_OK)
        return false;
    for (int c = 1; c < channels->n; c++)
        mix[c] += mix[c - 1];
    for (int c = channels->n - 1; c < RMAP_CHANNEL_MAX; c++)
        mix[c] = 1.0;
    return true;
}

bool rmap_reader_colour_environment(struct rmap_reader *reader, const struct rmap_sky_plan *plan,
                                    struct rmap_source *source)
{
    static const double lm_per_w = 179.0; /* of white, as Radiance has it */
    struct rmap_sky *sky = source->sky;
    const bool luminous = reader->scene->flux_unit == RMAP_FLUX_LM;
    const double factor = plan->unit == RMAP_SKY_CD && !luminous ? 1.0 / lm_per_w
                          : plan->unit == RMAP_SKY_W && luminous ? lm_per_w
                                                                 : 1.0;
    double part[3];
    bool some = false;
    for (int b = 0; b < 3; b++) {
        const double rgb[3] = {b == 0, b == 1, b == 2};
        const bool has = mix_band(&reader->scene->channels, luminous, b, sky->mix[b]);
        part[b] = !has ? 0.0 : luminous ? factor * rmap_rgb_luminance(rgb) : factor;
        some = some || has;
        if (!has)
            rmap_reader_warn(reader, plan->node,
                             "the scene has no wavelength for the %s of the picture",
                             b == 0   ? "red (above 580 nm)"
                             : b == 1 ? "green (490 to 580 nm)"
                                      : "blue (below 490 nm)");
    }
    for (size_t i = 0; i < sky->n_row * sky->n_around; i++) {
        float *band = sky->band + 3 * i;
        double sum = 0.0;
        for (int b = 0; b < 3; b++)
            sum += part[b] * (double)band[b];
        sky->radiance[i] = sum;
        for (int b = 0; b < 3; b++)
            band[b] = sum > 0.0 ? (float)(part[b] * (double)band[b] / sum) : b == 0;
    }
    return some;
}

void rmap_environment_mean(struct rmap_source *source, int n_channel)
{
    const struct rmap_sky *sky = source->sky;
    double band[3] = {0, 0, 0}, before = 0.0;
    for (size_t i = 0; i < sky->n_row * sky->n_around; i++) {
        for (size_t b = 0; b < 3; b++)
            band[b] += (double)sky->band[3 * i + b] * (sky->below[i] - before);
        before = sky->below[i];
    }
    for (int c = 0; c < n_channel; c++) {
        source->colour[c] = 0.0;
        for (int b = 0; b < 3; b++)
            source->colour[c] += band[b] * (sky->mix[b][c] - (c > 0 ? sky->mix[b][c - 1] : 0.0));
    }
}
