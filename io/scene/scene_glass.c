/* SPDX-License-Identifier: MIT
 *
 * Glasses in a scene file: of the catalogue, with what is meant by a name that it does not have,
 * and by coefficients.
 */
#include "io/scene/scene_glass.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "io/scene/glass_nearest.h"

/* Glasses of that family, as a pattern: "*BK*" of N-BK8. */
static void family(const char *name, char *pattern, size_t nbytes)
{
    const char *letters = rmap_glass_stem(name);
    size_t n = 0;
    while (isalpha((unsigned char)letters[n]))
        n++;
    (void)snprintf(pattern, nbytes, n ? "*%.*s*" : "*", (int)n, letters);
}

/* Prescriptions name glasses by six digits, too: of nd - 1, and of vd (MIL-G-174). */
static bool is_code(const char *name)
{
    enum { DIGITS = 6 };
    return strlen(name) == DIGITS && strspn(name, "0123456789") == DIGITS;
}

static void unknown(struct rmap_reader *reader, const struct rmap_yaml_node *at, const char *kind,
                    const char *name)
{
    char nearest[160], pattern[40];
    if (rmap_diagnostics_full(reader->diagnostics)) {
        rmap_reader_error(reader, at, "unknown %s", kind);
        return;
    }
    if (is_code(name)) {
        rmap_reader_error(reader, at,
                          "unknown %s '%.60s' (raymap glass --near 1.%.3s,%.2s.%s lists what has "
                          "this nd and vd)",
                          kind, name, name, name + 3, name + 5);
        return;
    }
    (void)rmap_glass_nearest(name, nearest, sizeof nearest);
    family(name, pattern, sizeof pattern);
    if (*nearest)
        rmap_reader_error(reader, at,
                          "unknown %s '%.60s' (did you mean %s? raymap glass '%s' lists glasses)",
                          kind, name, nearest, pattern);
    else
        rmap_reader_error(reader, at, "unknown %s '%.60s' (raymap glass '%s' lists glasses)", kind,
                          name, pattern);
}

static bool find(struct rmap_reader *reader, const struct rmap_yaml_node *at, const char *name,
                 struct rmap_glass *glass, enum rmap_glass_found *found)
{
    char choices[200];
    *found = rmap_glass_find(name, glass, choices, sizeof choices);
    if (*found == RMAP_GLASS_SEVERAL)
        rmap_reader_error(reader, at, "several glasses are called '%.60s': write %s", name,
                          choices);
    return *found == RMAP_GLASS_FOUND;
}

bool rmap_reader_find_glass(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                            const char *name, struct rmap_glass *glass)
{
    enum rmap_glass_found found;
    if (find(reader, at, name, glass, &found) || found == RMAP_GLASS_SEVERAL)
        return found == RMAP_GLASS_FOUND;
    /* Of a mistake that is not shown, nobody wants to know what was meant. */
    const bool full = rmap_diagnostics_full(reader->diagnostics);
    size_t least = full ? 0 : rmap_glass_nearest(name, NULL, 0);
    const char *medium = NULL;
    for (size_t i = 0; i < reader->media.n && !full; i++) {
        const char *text = reader->media.name[i].text;
        size_t from = rmap_glass_difference(name, text);
        if (from < least || (from == least && !medium)) {
            medium = text;
            least = from;
        }
    }
    if (medium)
        rmap_reader_error(reader, at, "unknown medium '%.60s' (did you mean '%.60s'?)", name,
                          medium);
    else
        unknown(reader, at, "medium", name);
    return false;
}

bool rmap_reader_material(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          const char *key, struct rmap_glass *glass)
{
    const char *name = rmap_reader_text(reader, node, key, RMAP_REQUIRED);
    const struct rmap_yaml_node *at = rmap_yaml_get(node, key);
    enum rmap_glass_found found;
    if (!name || find(reader, at, name, glass, &found))
        return name != NULL;
    if (found == RMAP_GLASS_UNKNOWN)
        unknown(reader, at, key, name);
    return false;
}

void rmap_reader_warn_outside(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                              const char *kind, const char *name, double from_nm, double to_nm,
                              const char *consequence)
{
    const struct rmap_channels *channels = &reader->scene->channels;
    double first = channels->wavelength_nm[0], last = channels->wavelength_nm[channels->n - 1];
    double slack = 1e-6 * last;
    if (first < from_nm - slack || last > to_nm + slack)
        rmap_reader_warn(reader, at,
                         "%s '%.60s' is known from %g to %g nm, the scene has light from %g "
                         "to %g nm: %s",
                         kind, name, from_nm, to_nm, first, last, consequence);
}

bool rmap_reader_is_catalogue(const struct rmap_yaml_node *node)
{
    return node && node->kind == RMAP_YAML_SCALAR && strcmp(node->text, "catalogue") == 0;
}

bool rmap_reader_sellmeier(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           double unit_um, struct rmap_glass *glass)
{
    enum { TERMS_MAX = 6 };
    double b[TERMS_MAX], c[TERMS_MAX];
    size_t n_b = 0, n_c = 0;
    *glass = (struct rmap_glass){.formula = 2};
    if (!rmap_reader_check_map(reader, node, "sellmeier", "B C"))
        return false;
    bool good = rmap_reader_numbers(reader, node, "B", RMAP_REQUIRED, &rmap_range_any, 1, TERMS_MAX,
                                    b, &n_b);
    good &= rmap_reader_numbers(reader, node, "C", RMAP_REQUIRED, &rmap_range_any, 1, TERMS_MAX, c,
                                &n_c);
    if (good && n_b != n_c)
        rmap_reader_error(reader, node, "B has %zu coefficients, C has %zu", n_b, n_c);
    if (!good || n_b != n_c)
        return false;
    glass->n_coefficient = 1 + 2 * n_b;
    for (size_t i = 0; i < n_b; i++) {
        glass->coefficient[1 + 2 * i] = b[i];
        glass->coefficient[2 + 2 * i] = c[i] * (unit_um * unit_um);
    }
    return true;
}
