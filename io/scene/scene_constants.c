/* SPDX-License-Identifier: MIT
 *
 * Optical constants of what is no medium of its own.
 */
#include "io/scene/scene_constants.h"
#include "io/scene/scene_quantity.h"

double rmap_constants_index(const struct rmap_constants *its, double wavelength_nm)
{
    return its->has_glass ? rmap_glass_index(&its->glass, wavelength_nm)
           : its->n.n > 0 ? rmap_table1_at(&its->n, wavelength_nm)
                          : its->index;
}

double rmap_constants_loss(const struct rmap_constants *its, double wavelength_nm)
{
    return its->has_glass ? rmap_glass_extinction(&its->glass, wavelength_nm)
           : its->k.n > 0 ? rmap_table1_at(&its->k, wavelength_nm)
                          : its->loss;
}

static bool read_glass(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const char *kind, const char *name, struct rmap_constants *its)
{
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "material");
    if (!rmap_reader_material(reader, node, "material", &its->glass))
        return false;
    its->has_glass = true;
    rmap_reader_warn_outside(reader, at, kind, name, its->glass.from_nm, its->glass.to_nm,
                             its->glass.formula ? "its formula is extrapolated"
                                                : "its ends stand for the rest");
    return true;
}

static bool read_table(struct rmap_reader *reader, const struct rmap_yaml_node *table,
                       const char *kind, const char *name, struct rmap_constants *its)
{
    double *column[3];
    size_t n = 0;
    rmap_reader_table(reader, table, "wavelength n k", 2, &rmap_range_nonnegative, &n, column);
    if (n == 0)
        return false;
    its->n = (struct rmap_table1){n, column[0], column[1]};
    if (column[2])
        its->k = (struct rmap_table1){n, column[0], column[2]};
    rmap_reader_warn_outside(reader, table, kind, name, column[0][0], column[0][n - 1],
                             "its ends stand for the rest");
    return true;
}

bool rmap_reader_constants(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           const char *kind, const char *name, const char *what,
                           struct rmap_constants *its)
{
    static const struct rmap_range index = {1e-3, 1e3, "a refractive index, 0.001 to 1000",
                                            RMAP_DIMENSION_NONE};
    const struct rmap_yaml_node *table = rmap_yaml_get(node, "table");
    const bool material = rmap_yaml_get(node, "material"), number = rmap_yaml_get(node, "n");
    if (material + (table != NULL) + number != 1) {
        rmap_reader_error(reader, node, "%s has one of material, n (and k), table", what);
        return false;
    }
    if (material)
        return read_glass(reader, node, kind, name, its);
    if (table)
        return read_table(reader, table, kind, name, its);
    return rmap_reader_number(reader, node, "n", RMAP_REQUIRED, &index, &its->index) &&
           rmap_reader_number(reader, node, "k", RMAP_OPTIONAL, &rmap_range_nonnegative,
                              &its->loss);
}
