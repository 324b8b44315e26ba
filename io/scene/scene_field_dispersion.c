/* SPDX-License-Identifier: MIT
 *
 * `dispersion:` of a gradient medium: a model that holds at one wavelength follows a glass, a
 * formula or a table at the others.
 */
#include <math.h>

#include "gradient/field_made.h"
#include "io/scene/scene_field.h"
#include "optics/dispersion.h"

enum { ADDITIVE, REFRACTIVITY, MULTIPLICATIVE };

/* An index over wavelength, of one kind. */
struct dispersion {
    struct rmap_sellmeier sellmeier;
    struct rmap_table1 table; /* n > 0: this, else the formula */
};

static double index_at(const struct dispersion *of, double nm)
{
    return of->table.n ? rmap_table1_at(&of->table, nm) : rmap_sellmeier_index(&of->sellmeier, nm);
}

static void read_index_table(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                             struct dispersion *of, bool *good)
{
    double *column[2];
    size_t n = 0;
    rmap_reader_table(reader, node, "wavelength n", 2, &rmap_range_positive, &n, column);
    of->table = (struct rmap_table1){n, column[0], column[1]};
    *good = n > 0;
}

static void read_model(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct dispersion *of, bool *good)
{
    const struct rmap_yaml_node *glass = rmap_yaml_get(node, "glass");
    const struct rmap_yaml_node *formula = rmap_yaml_get(node, "sellmeier");
    const struct rmap_yaml_node *table = rmap_yaml_get(node, "table");
    *good = false;
    if (!!glass + !!formula + !!table != 1)
        rmap_reader_error(reader, node, "dispersion needs one of glass, sellmeier, table");
    else if (table) {
        read_index_table(reader, table, of, good);
        return;
    } else if (formula)
        *good = rmap_reader_sellmeier(reader, formula, 1, &of->sellmeier);
    else {
        const struct rmap_glass *found = rmap_reader_glass(reader, node);
        *good = found != NULL;
        if (found)
            of->sellmeier = found->sellmeier;
    }
}

/* What the field's numbers become on a channel. */
static struct rmap_dispersed on_channel(int mode, double n, double n_reference)
{
    switch (mode) {
    case REFRACTIVITY:
        return (struct rmap_dispersed){(n - 1) / (n_reference - 1), 0};
    case MULTIPLICATIVE:
        return (struct rmap_dispersed){n / n_reference, n / n_reference - 1};
    default:
        return (struct rmap_dispersed){1, n - n_reference};
    }
}

void rmap_reader_disperse(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          struct rmap_field **field)
{
    const struct rmap_yaml_node *said = rmap_yaml_get(node, "dispersion");
    const struct rmap_channels *channels = &reader->scene->channels;
    struct rmap_dispersed dispersed[RMAP_CHANNEL_MAX];
    struct dispersion of = {0};
    double reference = 587.56;
    int mode = ADDITIVE;
    bool good = false;
    if (!said ||
        !rmap_reader_check_map(reader, said, "dispersion", "glass sellmeier table reference mode"))
        return;
    read_model(reader, said, &of, &good);
    good &= rmap_reader_number(reader, said, "reference", RMAP_OPTIONAL, &rmap_range_positive,
                               &reference);
    good &= rmap_reader_choice(reader, said, "mode", RMAP_OPTIONAL,
                               "additive refractivity multiplicative", &mode);
    if (!good || !*field)
        return;
    double n_reference = index_at(&of, reference);
    for (int c = 0; c < channels->n && good; c++) {
        dispersed[c] = on_channel(mode, index_at(&of, channels->wavelength_nm[c]), n_reference);
        good = isfinite(dispersed[c].scale) && isfinite(dispersed[c].offset);
    }
    if (!good) {
        rmap_reader_error(reader, said,
                          "the dispersion has no index at %g nm ('reference') or at one of the "
                          "scene's wavelengths",
                          reference);
        return;
    }
    struct rmap_field *taken = *field;
    *field = NULL;
    rmap_reader_made(reader, said,
                     rmap_field_dispersed(field, taken, rmap_reader_distinct_wavelengths(reader),
                                          dispersed, &reader->failure));
}
