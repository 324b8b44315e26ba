/* SPDX-License-Identifier: MIT
 *
 * What a part is taken to be made of.
 */
#include "io/assembly/assembly_guess.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#include "optics/catalogue.h"

/* A millimetre of it lets more than a hundredth through: k below 2e-4 at 550 nm. */
#define CLEAR_K 2e-4

static bool is_glass(const char *material, char inside[RMAP_GUESS_NBYTES])
{
    struct rmap_glass glass;
    char choices[8];
    if (!material || !material[0] || strlen(material) >= RMAP_GUESS_NBYTES ||
        rmap_glass_find(material, &glass, choices, sizeof choices) != RMAP_GLASS_FOUND ||
        strcasecmp(glass.group, "metal") == 0 || strcasecmp(glass.group, "film") == 0 ||
        rmap_glass_extinction(&glass, 550) > CLEAR_K)
        return false;
    const double index = rmap_glass_index(&glass, 550);
    (void)snprintf(inside, RMAP_GUESS_NBYTES, "%s", material);
    return isfinite(index) && index > 1;
}

void rmap_assembly_hexadecimal(const struct rmap_assembly_colour *colour, char text[8])
{
    unsigned byte[3];
    for (int k = 0; k < 3; k++)
        byte[k] = (unsigned)lround(255 * fmin(fmax(colour->rgb[k], 0), 1)) & 255;
    (void)snprintf(text, 8, "#%02x%02x%02x", byte[0], byte[1], byte[2]);
}

void rmap_assembly_guess(const struct rmap_assembly *assembly, const char *material,
                         const struct rmap_assembly_colour *colour, bool closed,
                         struct rmap_assembly_guess *guess)
{
    const struct rmap_assembly_material *its = rmap_assembly_material(assembly, material);
    char text[8] = "";
    *guess = (struct rmap_assembly_guess){0};
    if (colour->given)
        rmap_assembly_hexadecimal(colour, text);
    const bool clear = its && its->transmission >= 0.5;
    if (closed && clear)
        (void)snprintf(guess->inside, sizeof guess->inside, "index_%.4g",
                       its->index > 1 ? its->index : 1.5);
    else if (closed)
        (void)is_glass(material, guess->inside);
    if (guess->inside[0])
        (void)snprintf(guess->surface, sizeof guess->surface, "fresnel");
    else if (its && its->metalness >= 0.5 && colour->given)
        (void)snprintf(guess->surface, sizeof guess->surface, "metal_%s_rough%02ld", text + 1,
                       lround(99 * fmin(fmax(its->roughness, 0), 1)));
    else
        (void)snprintf(guess->surface, sizeof guess->surface, "paint%s%s", text[0] ? "_" : "",
                       text[0] ? text + 1 : "");
}

/* IEC 61966-2-1; no paint reflects all light. */
static double reflectance(unsigned byte)
{
    const double v = byte / 255.0, most = 0.95;
    return fmin(v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4), most);
}

void rmap_assembly_put_surface(FILE *out, const char *name)
{
    const char *colour = strchr(name, '_'), *rough = strstr(name, "_rough");
    unsigned byte[3] = {0, 0, 0}, roughness = 0;
    if (!colour || sscanf(colour + 1, "%2x%2x%2x", &byte[0], &byte[1], &byte[2]) != 3) {
        (void)fprintf(out, "  %s: {type: lambert, reflectance: 0.5}\n", name);
        return;
    }
    (void)fprintf(out, "  %s: {type: %s, reflectance: {rgb: [%.3g, %.3g, %.3g]}", name,
                  rough ? "mirror" : "lambert", reflectance(byte[0]), reflectance(byte[1]),
                  reflectance(byte[2]));
    /* glTF's roughness is the root of alpha; below, it is a mirror. */
    if (rough && sscanf(rough, "_rough%u", &roughness) == 1 && roughness > 3)
        (void)fprintf(out, ", scatter: {model: ggx, alpha: %.3g}",
                      roughness / 99.0 * (roughness / 99.0));
    (void)fputs("}\n", out);
}

bool rmap_assembly_put_medium(FILE *out, const char *name)
{
    if (strncmp(name, "index_", 6) != 0)
        return false;
    if (out)
        (void)fprintf(out, "  %s: {index: %s}\n", name, name + 6);
    return true;
}
