/* SPDX-License-Identifier: MIT
 *
 * The catalogue of optical materials: its text, and names in it.
 */
#include "optics/catalogue.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/vec.h"

extern const char rmap_materials[]; /* ends with a zero; cmake/materials.S.in */

static const char *after(const char *line, const char *word)
{
    size_t n = strlen(word);
    return strncmp(line, word, n) == 0 ? line + n : NULL;
}

bool rmap_catalogue_next(struct rmap_catalogue *place)
{
    const char *line = rmap_materials, *text;
    if (place->line)
        line = strchr(place->line, '\n') + 1;
    for (; *line; line = strchr(line, '\n') + 1) {
        if (*line == '#')
            continue;
        if ((text = after(line, "group ")))
            *place = (struct rmap_catalogue){.group = text};
        else if ((text = after(line, "source ")))
            place->source = text;
        else if ((text = after(line, "at ")))
            place->at = text;
        else {
            place->line = line;
            return true;
        }
    }
    return false;
}

/* The next word of a line, cut where it is too long; false at the line's end. */
static bool next_word(const char **text, char *word, size_t nbytes)
{
    *text += strspn(*text, " ");
    size_t n = strcspn(*text, " \n");
    (void)snprintf(word, nbytes, "%.*s", (int)n, *text);
    *text += n;
    return n > 0;
}

/* The next number of a line; false before a word that is none. */
static bool next_number(const char **text, double *value)
{
    char *end;
    *text += strspn(*text, " ");
    if (**text == '\n' || **text == 0)
        return false;
    double parsed = strtod(*text, &end);
    if (end == *text || (*end != ' ' && *end != '\n'))
        return false;
    *value = parsed;
    *text = end;
    return true;
}

/* A number, or `-` for none. */
static double published(const char **text)
{
    double value = (double)NAN;
    char dash[2];
    if (!next_number(text, &value))
        (void)next_word(text, dash, sizeof dash);
    return value;
}

static void add_row(struct rmap_glass_table *table, double um, double value)
{
    if (table->n == RMAP_GLASS_ROWS_MAX)
        return;
    table->wavelength_nm[table->n] = um * 1e3;
    table->value[table->n++] = value;
}

static void read_model(const char **text, const char *model, struct rmap_glass *glass)
{
    double value, um, k;
    glass->formula = model[0] == 'n' ? 0 : atoi(model);
    while (glass->formula && glass->n_coefficient < RMAP_GLASS_COEFFICIENTS_MAX &&
           next_number(text, &value))
        glass->coefficient[glass->n_coefficient++] = value;
    glass->linear = strcmp(model, "nk") == 0;
    while (!glass->formula && next_number(text, &um) && next_number(text, &value)) {
        add_row(&glass->index, um, value);
        if (glass->linear && next_number(text, &k))
            add_row(&glass->extinction, um, k);
    }
}

/* k of an internal transmittance: exp(-4 pi k d / L) (Born & Wolf, 7th ed., 14.1). */
static void read_transmittances(const char *text, const char *at, struct rmap_glass *glass)
{
    double mm = 0.0, um, value;
    (void)next_number(&text, &mm);
    while (at && *text && *text != '\n' && next_number(&at, &um)) {
        value = published(&text);
        if (!isnan(value))
            add_row(&glass->extinction, um, -log(value) * um / (4e3 * RMAP_PI * mm));
    }
}

void rmap_catalogue_name(const struct rmap_catalogue *place, char name[32], char group[16])
{
    const char *text = place->line;
    (void)next_word(&text, name, 32);
    text = place->group;
    (void)next_word(&text, group, 16);
}

void rmap_catalogue_read(const struct rmap_catalogue *place, struct rmap_glass *glass)
{
    const char *text = place->line;
    char model[8], loss[8];
    double um, k;
    *glass = (struct rmap_glass){0};
    rmap_catalogue_name(place, glass->name, glass->group);
    (void)snprintf(glass->source, sizeof glass->source, "%.*s", (int)strcspn(place->source, "\n"),
                   place->source);
    text += strcspn(text, " ");
    glass->nd = published(&text);
    glass->vd = published(&text);
    glass->from_nm = 1e3 * published(&text);
    glass->to_nm = 1e3 * published(&text);
    if (next_word(&text, model, sizeof model))
        read_model(&text, model, glass);
    if (!next_word(&text, loss, sizeof loss))
        return;
    if (loss[0] == 't')
        read_transmittances(text, place->at, glass);
    else
        while (next_number(&text, &um) && next_number(&text, &k))
            add_row(&glass->extinction, um, k);
}

/* Whether a name is the material's, with its group or without. */
static bool is_called(const struct rmap_catalogue *place, const char *name, bool *grouped)
{
    const size_t n = strcspn(place->group, "\n");
    *grouped = strncasecmp(name, place->group, n) == 0 && (name[n] == ' ' || name[n] == ':');
    const char *bare = *grouped ? name + n + 1 : name;
    const size_t len = strcspn(place->line, " ");
    return strlen(bare) == len && strncasecmp(bare, place->line, len) == 0;
}

enum rmap_glass_found rmap_glass_find(const char *name, struct rmap_glass *glass, char *choices,
                                      size_t choices_nbytes)
{
    struct rmap_catalogue place = {0}, found = {0};
    char own[32], group[16];
    size_t n = 0, used = 0;
    bool grouped;
    while (rmap_catalogue_next(&place)) {
        if (!is_called(&place, name, &grouped))
            continue;
        found = place;
        rmap_catalogue_name(&place, own, group);
        if (used < choices_nbytes)
            used += (size_t)snprintf(choices + used, choices_nbytes - used, "%s%s %s",
                                     n ? ", " : "", group, own);
        n++;
        if (grouped || strcmp(group, "SCHOTT") == 0)
            break;
    }
    if (n == 1)
        rmap_catalogue_read(&found, glass);
    return n == 0 ? RMAP_GLASS_UNKNOWN : n == 1 ? RMAP_GLASS_FOUND : RMAP_GLASS_SEVERAL;
}
