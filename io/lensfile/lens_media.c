/* SPDX-License-Identifier: MIT
 *
 * Materials of a prescription, found by the names that its program has for them.
 */
#include "io/lensfile/lens_media.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "base/count.h"
#include "io/lensfile/lens_text.h"
#include "optics/catalogue.h"

enum { NAME = 64 };

/* Letters and digits in capitals: CODE V writes NBK7 for N-BK7. */
static void normal(const char *name, char to[NAME])
{
    size_t n = 0;
    for (; *name && n + 1 < NAME; name++)
        if (isalnum((unsigned char)*name))
            to[n++] = (char)toupper((unsigned char)*name);
    to[n] = 0;
}

/* Lower is better; -1: not this one. `group`, where the word has one, and else those that the file
 * names come first. */
static int rank(const struct rmap_prescription *lens, const char *group, const char *of, bool exact)
{
    int place = strcmp(of, "SCHOTT") == 0 ? 100 : 200;
    if (strcmp(of, "film") == 0 || strcmp(of, "metal") == 0)
        return -1;
    if (group[0])
        return strcasecmp(group, of) == 0 ? !exact : -1;
    const char *listed = strstr(lens->catalogues, of);
    if (listed)
        place = (int)(listed - lens->catalogues) < 100 ? (int)(listed - lens->catalogues) : 99;
    return 2 * place + !exact;
}

static bool in_catalogue(const struct rmap_prescription *lens, const char *name, const char *group,
                         struct rmap_lens_medium *medium)
{
    char wanted[NAME], here[NAME], its_name[32], its_group[16];
    struct rmap_catalogue place = {0}, best = {0};
    int best_rank = -1;
    normal(name, wanted);
    while (rmap_catalogue_next(&place)) {
        rmap_catalogue_name(&place, its_name, its_group);
        normal(its_name, here);
        if (!wanted[0] || strcmp(here, wanted) != 0)
            continue;
        const int r = rank(lens, group, its_group, strcasecmp(its_name, name) == 0);
        if (r >= 0 && (best_rank < 0 || r < best_rank)) {
            best_rank = r;
            best = place;
        }
    }
    if (best_rank < 0)
        return false;
    rmap_catalogue_read(&best, &medium->glass);
    medium->kind = RMAP_LENS_CATALOGUE;
    struct rmap_glass plain;
    char choices[256];
    const bool alone =
        rmap_glass_find(medium->glass.name, &plain, choices, sizeof choices) == RMAP_GLASS_FOUND &&
        strcmp(plain.group, medium->glass.group) == 0;
    (void)snprintf(medium->name, sizeof medium->name, "%s%s%s", alone ? "" : medium->glass.group,
                   alone ? "" : " ", medium->glass.name);
    return true;
}

static const struct {
    const char *word, *name;
} other_names[] = {{"SILICA", "fused-silica"}, {"FSILICA", "fused-silica"},
                   {"SIO2", "fused-silica"},   {"ACRYLIC", "PMMA"},
                   {"POLYCARB", "PC"},         {"POLYSTYR", "PS"},
                   {"SAPPHIRE", "Al2O3"},      {"CAFL", "CaF2"},
                   {"E48R", "ZeonexE48R"},     {"GERMANIUM", "Ge"},
                   {"SILICON", "Si"},          {"C7980", "fused-silica"}, /* Corning's */
                   {"UVFS", "fused-silica"}};

static size_t glass_line(const struct rmap_lens_surface *surface)
{
    return surface->glass_line ? surface->glass_line : surface->line;
}

static bool find_named(struct rmap_prescription *lens, struct rmap_lens_surface *surface,
                       struct rmap_lens_medium *medium)
{
    char name[NAME], group[NAME] = "", plain[NAME], prefixed[NAME + 2];
    rmap_lens_copy(name, sizeof name, surface->glass);
    if (in_catalogue(lens, name, "", medium))
        return true;
    char *underscore = strrchr(name, '_');
    if (underscore) {
        *underscore = 0;
        rmap_lens_copy(group, sizeof group, underscore + 1);
        if (in_catalogue(lens, name, group, medium) || in_catalogue(lens, name, "", medium))
            return true;
    }
    normal(name, plain);
    for (size_t i = 0; i < RMAP_COUNT(other_names); i++)
        if (strcmp(plain, other_names[i].word) == 0)
            return in_catalogue(lens, other_names[i].name, "", medium);
    (void)snprintf(prefixed, sizeof prefixed, "N%s", name);
    if (!in_catalogue(lens, prefixed, "", medium))
        return false;
    rmap_lens_lost(lens, glass_line(surface), surface,
                   "glass '%.40s' is not in the catalogue: %s, its successor, stands for it",
                   surface->glass, medium->name);
    return true;
}

static bool find_in_files(const struct rmap_prescription *lens, const char *word,
                          struct rmap_lens_medium *medium)
{
    for (size_t i = lens->n_glass; i-- > 0;)
        if (strcasecmp(lens->glass[i].name, word) == 0 &&
            rmap_agf_to_glass(&lens->glass[i], lens->wavelength_nm, lens->n_wavelength,
                              &medium->glass)) {
            medium->kind = RMAP_LENS_AGF;
            medium->agf = &lens->glass[i];
            return true;
        }
    return false;
}

/* A name for a medium of the scene, of letters that need no quotes. */
static void set_name(struct rmap_lens_medium *medium, const char *name)
{
    size_t n = 0;
    for (; *name && n + 1 < sizeof medium->name; name++)
        medium->name[n++] = isalnum((unsigned char)*name) || strchr("-.", *name) ? *name : '_';
    medium->name[n] = 0;
}

static void set_model(struct rmap_lens_medium *medium, double nd, double vd)
{
    char name[NAME];
    medium->kind = RMAP_LENS_MODEL;
    medium->nd = nd;
    medium->vd = vd;
    (void)snprintf(name, sizeof name, "model-%.6g-%.4g", nd, vd);
    set_name(medium, name);
}

static void find(struct rmap_prescription *lens, struct rmap_lens_surface *surface,
                 struct rmap_lens_medium *medium)
{
    const double unknown = 1.5;
    *medium = (struct rmap_lens_medium){.kind = RMAP_LENS_MODEL};
    rmap_lens_copy(medium->word, sizeof medium->word, surface->glass);
    const double n0 = surface->gradient_value[0], squared = 2; /* its model is of n^2 */
    const double n = surface->gradient == squared ? sqrt(fmax(n0, 0)) : n0;
    if (surface->gradient && !(n > 0)) {
        rmap_lens_lost(lens, surface->line, surface,
                       "its gradient's index %.6g is none: an index of %.3g stands in its place", n,
                       unknown);
        surface->gradient = 0;
        surface->is_model = true;
        surface->nd = unknown;
        surface->vd = 0;
    }
    if (surface->gradient) {
        char name[NAME];
        (void)snprintf(name, sizeof name, "grin_%d", surface->number);
        set_name(medium, name);
        medium->kind = RMAP_LENS_GRADIENT;
        medium->gradient = surface;
        (void)rmap_model_glass(n >= 1 && n < 5 ? n : unknown, 0, &medium->glass);
        return;
    }
    if (!surface->is_model && find_in_files(lens, surface->glass, medium)) {
        set_name(medium, surface->glass);
        return;
    }
    if (!surface->is_model && find_named(lens, surface, medium))
        return;
    if (surface->nd > 1 && rmap_model_glass(surface->nd, surface->vd, &medium->glass)) {
        set_model(medium, surface->nd, surface->vd);
        if (!surface->is_model)
            rmap_lens_lost(lens, glass_line(surface), surface,
                           "glass '%.40s' is not in the catalogue: a model of the file's index "
                           "%.6g and Abbe number %.4g stands for it; --glass FILE.agf gives it",
                           surface->glass, surface->nd, surface->vd);
        return;
    }
    rmap_lens_lost(lens, glass_line(surface), surface,
                   "glass '%.40s' is not known: index %.3g stands in its place; --glass FILE.agf "
                   "gives it",
                   surface->glass, unknown);
    (void)rmap_model_glass(unknown, 0, &medium->glass);
    set_model(medium, unknown, 0);
    set_name(medium, surface->glass);
    if (!isalpha((unsigned char)medium->name[0]))
        set_name(medium, "unknown");
}

static bool is_taken(const struct rmap_lens_media *media, const char *name)
{
    for (size_t i = 0; i < media->n; i++)
        if (strcasecmp(media->medium[i].name, name) == 0)
            return true;
    return false;
}

/* A name that no medium before it has. */
static void make_unique(const struct rmap_lens_media *media, struct rmap_lens_medium *medium)
{
    char name[sizeof medium->name];
    const int room = sizeof name - 8;
    memcpy(name, medium->name, sizeof name);
    for (unsigned k = 2; is_taken(media, medium->name); k++)
        (void)snprintf(medium->name, sizeof medium->name, "%.*s-%u", room, name, k % 100000);
}

static bool is_air(const char *word)
{
    return !word[0] || rmap_lens_is(word, "AIR") || rmap_lens_is(word, "VACUUM");
}

/* Equal words with equal numbers are one medium. */
static enum rmap_status behind(struct rmap_prescription *lens, struct rmap_lens_surface *surface,
                               struct rmap_lens_media *media, size_t *at, struct rmap_error *err)
{
    for (size_t i = 1; i < media->n; i++) {
        const struct rmap_lens_medium *m = &media->medium[i];
        if (!surface->gradient && strcmp(m->word, surface->glass) == 0 &&
            (!surface->is_model || (m->nd == surface->nd && m->vd == surface->vd))) {
            *at = i;
            return RMAP_OK;
        }
    }
    if (RMAP_RESERVE(media->medium, media->cap, media->n + 1, err) != RMAP_OK)
        return RMAP_SYSTEM;
    struct rmap_lens_medium *medium = &media->medium[media->n];
    find(lens, surface, medium);
    if (medium->kind != RMAP_LENS_CATALOGUE)
        make_unique(media, medium);
    *at = media->n++;
    const double nm = lens->wavelength_nm[lens->primary];
    const double index = rmap_glass_index(&medium->glass, nm);
    medium->index = index > 0 && isfinite(index) ? index : 1.5;
    if (!(nm >= medium->glass.from_nm && nm <= medium->glass.to_nm) &&
        medium->kind != RMAP_LENS_MODEL && medium->kind != RMAP_LENS_GRADIENT)
        rmap_lens_remark(surface, "%g nm is outside the data of %s", nm, medium->name);
    return RMAP_OK;
}

enum rmap_status rmap_lens_media_make(struct rmap_prescription *lens, struct rmap_lens_media *media,
                                      struct rmap_error *err)
{
    *media = (struct rmap_lens_media){0};
    media->behind = rmap_alloc(lens->n_surface, sizeof *media->behind);
    if (!media->behind || RMAP_RESERVE(media->medium, media->cap, 1, err) != RMAP_OK)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the media of a lens");
    media->medium[0] = (struct rmap_lens_medium){.name = "air", .kind = RMAP_LENS_AIR, .index = 1};
    media->n = 1;
    for (size_t i = 0; i < lens->n_surface; i++) {
        struct rmap_lens_surface *surface = &lens->surface[i];
        enum rmap_status st = RMAP_OK;
        if (surface->is_break || surface->is_mirror)
            media->behind[i] = i ? media->behind[i - 1] : 0;
        else if (is_air(surface->glass) && !surface->gradient)
            media->behind[i] = 0;
        else
            st = behind(lens, surface, media, &media->behind[i], err);
        if (st != RMAP_OK)
            return st;
    }
    return RMAP_OK;
}

void rmap_lens_media_fini(struct rmap_lens_media *media)
{
    rmap_free(media->medium);
    rmap_free(media->behind);
    *media = (struct rmap_lens_media){0};
}
