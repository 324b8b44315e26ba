/* SPDX-License-Identifier: MIT
 *
 * Multi-configuration operands of Zemax, by their names in the OpticStudio user's guide.
 */
#include "io/lensfile/lens_zmx_config.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/count.h"
#include "io/lensfile/lens_text.h"

static bool is_one_of(const char *key, const char *list)
{
    char spaced[8];
    (void)snprintf(spaced, sizeof spaced, " %.4s ", key);
    return strstr(list, spaced) != NULL;
}

static const char of_surface[] = " THIC CRVT CONN GLSS SDIA ";
static const char of_lens[] = " APER XFIE YFIE FLWT WAVE WLWT FVDX FVDY FVCX FVCY TEMP PRES LTTL ";
/* Of no configuration's light: an operand that is off, comments, what tolerances and merit
 * functions say. */
static const char harmless[] = " MOFF MCOM TOFF BLNK DMFS OPDX ";

/* Each word once. */
static void tell_unknown(struct rmap_prescription *lens, struct rmap_zmx_changes *changes,
                         const char *key, size_t line)
{
    for (size_t i = 0; i < changes->n_seen; i++)
        if (strncmp(changes->seen[i], key, 4) == 0)
            return;
    if (changes->n_seen >= RMAP_COUNT(changes->seen))
        return;
    rmap_lens_copy(changes->seen[changes->n_seen++], sizeof changes->seen[0], key);
    rmap_lens_lost(lens, line, NULL, "operand %.4s of its configurations is not understood", key);
}

static enum rmap_status add(struct rmap_prescription *lens, struct rmap_zmx_changes *changes,
                            const char *key, size_t line, char *const *word, size_t n,
                            struct rmap_error *err)
{
    const double index = rmap_lens_value(word, n, 1, -1);
    const bool is_text = strcmp(key, "GLSS") == 0 || strcmp(key, "LTTL") == 0;
    double value = 0;
    if (!is_one_of(key, of_surface) && !is_one_of(key, of_lens)) {
        tell_unknown(lens, changes, key, line);
        return RMAP_OK;
    }
    if (!(index >= 0 && index < RMAP_PRESCRIPTION_SURFACES_MAX)) {
        rmap_lens_lost(lens, line, NULL, "%.4s %.20s of its configurations names nothing", key,
                       word[1]);
        return RMAP_OK;
    }
    if (!is_text && !rmap_lens_number(word[3], &value)) {
        rmap_lens_lost(lens, line, NULL,
                       "%.4s %.20s of its configurations is set to %.40s, which is no number, and "
                       "is left out",
                       key, word[1], word[3]);
        return RMAP_OK;
    }
    if (RMAP_RESERVE(changes->change, changes->cap, changes->n + 1, err) != RMAP_OK)
        return RMAP_SYSTEM;
    struct rmap_zmx_change *change = &changes->change[changes->n++];
    *change = (struct rmap_zmx_change){.index = (size_t)index, .line = line, .value = value};
    rmap_lens_copy(change->key, sizeof change->key, key);
    rmap_lens_copy(change->text, sizeof change->text, word[3]);
    if (strcmp(key, "LTTL") == 0)
        rmap_lens_copy(lens->configuration_name, sizeof lens->configuration_name, change->text);
    return RMAP_OK;
}

static bool begins(const char *line)
{
    return strncmp(line, "MNUM", 4) == 0;
}

enum rmap_status rmap_zmx_read_changes(const char *text, struct rmap_prescription *lens,
                                       struct rmap_zmx_changes *changes, struct rmap_error *err)
{
    char *copy = rmap_strdup(text), *word[RMAP_LENS_WORDS_MAX];
    struct rmap_lens_lines lines = {.at = copy};
    enum rmap_status st = RMAP_OK;
    bool behind = false;
    if (!copy)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a text");
    while (st == RMAP_OK && rmap_lens_next_line(&lines)) {
        const bool head = begins(lines.line);
        if (!behind && !head)
            continue;
        const size_t n = rmap_lens_words(lines.line, "", word);
        if (head) {
            const double count = rmap_lens_value(word, n, 1, 1),
                         now = rmap_lens_value(word, n, 2, 1);
            behind = true;
            lens->n_configuration = count >= 1 && count < 1e6 ? (int)count : 1;
            lens->stored = now >= 1 && now <= lens->n_configuration ? (int)now : 1;
            continue;
        }
        const int wanted = lens->configuration > 0 ? lens->configuration : lens->stored;
        if (n >= 4 && strlen(word[0]) == 4 && !is_one_of(word[0], harmless) &&
            rmap_lens_value(word, n, 2, 0) == wanted)
            st = add(lens, changes, word[0], lines.number, word, n, err);
    }
    rmap_free(copy);
    return st;
}

void rmap_zmx_changes_fini(struct rmap_zmx_changes *changes)
{
    rmap_free(changes->change);
    *changes = (struct rmap_zmx_changes){0};
}

static void change_surface(const struct rmap_zmx_change *change, struct rmap_lens_surface *surface)
{
    if (strcmp(change->key, "THIC") == 0)
        surface->thickness = fabs(change->value) >= 1e10 ? HUGE_VAL : change->value;
    else if (strcmp(change->key, "CRVT") == 0)
        surface->curvature = change->value;
    else if (strcmp(change->key, "CONN") == 0)
        surface->conic = change->value;
    else if (strcmp(change->key, "SDIA") == 0)
        surface->semi = fabs(change->value);
    else if (strcmp(change->key, "GLSS") == 0) {
        surface->is_mirror = rmap_lens_is(change->text, "MIRROR");
        surface->is_model = false;
        surface->nd = surface->vd = 0; /* were of the glass before it */
        surface->glass_line = change->line;
        rmap_lens_copy(surface->glass, sizeof surface->glass,
                       surface->is_mirror ? "" : change->text);
    }
}

void rmap_zmx_change_surface(const struct rmap_zmx_changes *changes, struct rmap_prescription *lens,
                             struct rmap_lens_surface *surface)
{
    for (size_t i = 0; lens->configuration > 0 && i < changes->n; i++)
        if (changes->change[i].index == (size_t)surface->number &&
            is_one_of(changes->change[i].key, of_surface))
            change_surface(&changes->change[i], surface);
}

static void change_field(const struct rmap_zmx_change *change, struct rmap_lens_field *field)
{
    if (strcmp(change->key, "XFIE") == 0)
        field->x = change->value;
    else if (strcmp(change->key, "YFIE") == 0)
        field->y = change->value;
    else if (strcmp(change->key, "FLWT") == 0)
        field->weight = change->value;
    else if (change->key[0] == 'F' && change->key[1] == 'V')
        (change->key[3] == 'X' ? field->vx : field->vy)[change->key[2] == 'C'] = change->value;
}

void rmap_zmx_add_sum(struct rmap_zmx_changes *changes, struct rmap_zmx_sum sum)
{
    if (changes->n_total < RMAP_COUNT(changes->total))
        changes->total[changes->n_total++] = sum;
}

static void solve_sums(const struct rmap_zmx_changes *changes, struct rmap_prescription *lens)
{
    for (size_t k = 0; k < changes->n_total; k++) {
        const struct rmap_zmx_sum *sum = &changes->total[k];
        double rest = sum->sum;
        for (size_t i = sum->from; i < sum->surface && i < lens->n_surface; i++)
            if (i == sum->from || !sum->of_two)
                rest -= lens->surface[i].thickness;
        if (sum->from < sum->surface && sum->surface < lens->n_surface && isfinite(rest))
            lens->surface[sum->surface].thickness = rest;
    }
}

static const char of_field[] = " XFIE YFIE FLWT FVDX FVDY FVCX FVCY ", of_wave[] = " WAVE WLWT ",
                  of_air[] = " TEMP PRES ";

/* Of what the lens has not, and what a scene does not follow. */
static void tell_missing(const struct rmap_zmx_change *change, struct rmap_prescription *lens)
{
    const char *key = change->key;
    const size_t i = change->index;
    const bool surface = is_one_of(key, of_surface), field = is_one_of(key, of_field),
               wave = is_one_of(key, of_wave);
    const size_t n = surface ? lens->n_surface : 1 + (field ? lens->n_field : lens->n_wavelength);
    if ((surface || field || wave) && (i >= n || (!surface && i == 0)))
        rmap_lens_lost(lens, change->line, NULL,
                       "%.4s %zu of its configurations: the lens has no such %s", key, i,
                       surface ? "surface"
                       : field ? "field"
                               : "wavelength");
    if (strcmp(key, "WAVE") == 0 && !(change->value > 0))
        rmap_lens_lost(lens, change->line, NULL,
                       "WAVE %zu of its configurations is set to %.6g, which is no wavelength", i,
                       change->value);
    const double now = strcmp(key, "TEMP") == 0 ? lens->temperature_c : lens->pressure_atm;
    if (is_one_of(key, of_air) && change->value != now)
        rmap_lens_lost(lens, change->line, NULL,
                       "%.4s %.6g of its configurations: indices and lengths stay those of the "
                       "file's surroundings",
                       key, change->value);
}

void rmap_zmx_change_lens(const struct rmap_zmx_changes *changes, struct rmap_prescription *lens)
{
    for (size_t i = 0; i < changes->n; i++)
        tell_missing(&changes->change[i], lens);
    for (size_t i = 0; lens->configuration > 0 && i < changes->n; i++) {
        const struct rmap_zmx_change *change = &changes->change[i];
        const size_t at = change->index - 1; /* fields and wavelengths are numbered from 1 */
        if (strcmp(change->key, "APER") == 0)
            lens->pupil_value = fabs(change->value);
        else if (strcmp(change->key, "TEMP") == 0)
            lens->temperature_c = change->value;
        else if (strcmp(change->key, "PRES") == 0)
            lens->pressure_atm = change->value;
        else if (strcmp(change->key, "WAVE") == 0 && at < lens->n_wavelength && change->value > 0)
            lens->wavelength_nm[at] = rmap_lens_nm(change->value);
        else if (strcmp(change->key, "WLWT") == 0 && at < lens->n_wavelength)
            lens->wavelength_weight[at] = change->value;
        else if (is_one_of(change->key, of_field) && at < lens->n_field)
            change_field(change, &lens->field[at]);
    }
    if (lens->configuration > 0)
        solve_sums(changes, lens);
}
