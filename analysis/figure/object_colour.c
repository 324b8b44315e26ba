/* SPDX-License-Identifier: MIT
 *
 * Colours of objects where they are drawn: what their fronts throw back of white light.
 */
#include "analysis/figure/object_colour.h"

#include <math.h>
#include <stdio.h>

#include "analysis/figure/figure_rays.h"
#include "analysis/figure/figure_section.h"
#include "analysis/table/colour_map.h"
#include "base/alloc.h"
#include "scene/coat.h"
#include "trace/surface_shares.h"

/* Oklab chroma: of less is grey, of more in full colour. */
static const double GREY = 0.03, SATURATED = 0.15;

/* Oklab lightness of black bodies: lines and rays still show on them; of white ones: paper does
 * about them; and of dark ones in full colour. */
static const double DARKEST = 0.7, BRIGHTEST = 0.965, DARK_COLOUR = 0.55;

/* Linear RGB of light with so much of each channel, all channels of the same power. */
static void colour_of(const struct rmap_channels *channels, const double *part, double rgb[3])
{
    double colour[RMAP_CHANNEL_MAX][3], sum[3] = {0.0, 0.0, 0.0};
    rmap_channel_colours(channels, 0, colour);
    for (int c = 0; c < channels->n; c++)
        for (int k = 0; k < 3; k++)
            sum[k] += (part ? part[c] : 1.0) * colour[c][k];
    if (channels->mode == RMAP_COLOUR_RGB)
        for (int k = 0; k < 3; k++)
            rgb[k] = sum[k];
    else
        rmap_xyz_to_rgb(sum, rgb);
}

/* On a channel. Of facets the whole boundary's share: their quadrature takes a millisecond. */
static double thrown_back(const struct rmap_scene *scene, const struct rmap_object *object, int c)
{
    const struct rmap_surface *surface = &scene->surface[object->surface_front];
    const struct rmap_scatter *model = rmap_surface_scatter(scene, surface, false);
    if (!surface->is_metal && (!model || rmap_scatter_is_facets(model)))
        return surface->reflect_diffuse[c] + surface->reflect_specular[c];
    if (surface->is_metal && model && rmap_scatter_is_facets(model))
        return rmap_metal_coat(
            scene, surface, c,
            object->medium_front >= 0 ? scene->medium[object->medium_front].n[c] : 1.0, 1.0);
    const struct rmap_surface_shares its =
        rmap_side_shares(scene, (struct rmap_surface_side){object, true}, c, 0.0);
    return its.reflect_specular + its.reflect_diffuse;
}

static void find_colour(const struct rmap_scene *scene, const struct rmap_object *object,
                        const double white[3], double rgb[3])
{
    /* Where white light of these wavelengths has less of a primary, that says nothing. */
    const double least = 0.02 * fmax(fabs(white[0]), fmax(fabs(white[1]), fabs(white[2])));
    double part[RMAP_CHANNEL_MAX], mean = 0.0;
    for (int c = 0; c < scene->channels.n; c++) {
        part[c] = thrown_back(scene, object, c);
        part[c] = isfinite(part[c]) ? part[c] : 0.0;
        mean += part[c] / scene->channels.n;
    }
    colour_of(&scene->channels, part, rgb);
    for (int k = 0; k < 3; k++) {
        rgb[k] = fabs(white[k]) > least ? rgb[k] / white[k] : mean;
        rgb[k] = fmin(fmax(rgb[k], 0.0), 1.0);
    }
}

double (*rmap_object_colours(const struct rmap_scene *scene))[3]
{
    double white[3];
    size_t *first = rmap_alloc(scene->n_surface + 1, sizeof *first); /* 1 + object that has it */
    double(*rgb)[3] = rmap_alloc(scene->n_object + 1, sizeof *rgb);
    colour_of(&scene->channels, NULL, white);
    for (size_t o = 0; first && rgb && o < scene->n_object; o++) {
        size_t *its = &first[scene->object[o].surface_front];
        if (*its > 0) {
            for (int k = 0; k < 3; k++)
                rgb[o][k] = rgb[*its - 1][k];
            continue;
        }
        find_colour(scene, &scene->object[o], white, rgb[o]);
        *its = o + 1;
    }
    if (!first) {
        rmap_free(rgb);
        rgb = NULL;
    }
    rmap_free(first);
    return rgb;
}

bool rmap_colour_has_hue(const double linear[3])
{
    double lab[3];
    rmap_rgb_to_oklab(linear, lab);
    return hypot(lab[1], lab[2]) > GREY;
}

/* Greys are lightened more than colours, which tell themselves from lines and rays by their hue. */
static void lighten(const double linear[3], double tint[3])
{
    double lab[3], rgb[3];
    uint8_t byte[3];
    rmap_rgb_to_oklab(linear, lab);
    const double colour = fmin(hypot(lab[1], lab[2]) / SATURATED, 1.0);
    const double grey = DARKEST + (BRIGHTEST - DARKEST) * lab[0];
    lab[0] = grey + colour * (fmax(lab[0], DARK_COLOUR) - grey);
    rmap_oklab_to_rgb(lab, rgb);
    rmap_srgb_encode(rgb, byte);
    for (int k = 0; k < 3; k++)
        tint[k] = byte[k] / 255.0;
}

void rmap_object_tint(enum rmap_look look, const double linear[3], double tint[3])
{
    double its[3];
    lighten(linear, its);
    for (int k = 0; k < 3; k++) {
        tint[k] = rmap_look_style[look].tint[k];
        if (look == RMAP_LOOK_OTHER)
            tint[k] = its[k];
        else if (look == RMAP_LOOK_MIRROR && rmap_colour_has_hue(linear))
            tint[k] *= its[k];
    }
}

void rmap_object_ink(enum rmap_look look, const double linear[3], char ink[8])
{
    if (look == RMAP_LOOK_REFRACTING || !rmap_colour_has_hue(linear))
        (void)snprintf(ink, 8, "%s", rmap_look_style[look].ink);
    else
        rmap_paper_ink(linear, ink);
}
