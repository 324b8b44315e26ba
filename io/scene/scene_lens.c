/* SPDX-License-Identifier: MIT
 *
 * `lens`: the table of a prescription.
 */
#include <math.h>

#include "io/scene/scene_keys.h"

const struct rmap_mapping rmap_lens_row_keys = {
    "lens",
    NULL,
    {{"a row of a lens", "radius curvature thickness medium aperture conic asphere stop"}}};

static void read_row(struct rmap_reader *reader, const struct rmap_yaml_node *node, bool last,
                     double *thickness, struct rmap_lens_row *row, bool *good)
{
    row->node = node;
    row->geometry = row->edge_geometry = row->stop_geometry = -1;
    row->medium = -1;
    *good = rmap_reader_known(reader, node, &rmap_lens_row_keys, 0);
    if (!*good)
        return;
    *good = rmap_reader_conic(reader, node, &row->shape);
    *good &= rmap_reader_number(reader, node, "thickness", last ? RMAP_OPTIONAL : RMAP_REQUIRED,
                                &rmap_range_nonnegative, thickness);
    *good &= rmap_reader_bool(reader, node, "stop", &row->stop);
    if (!rmap_yaml_get(node, "medium"))
        rmap_reader_error(reader, node, "'medium' is missing: name the medium after the surface");
    rmap_reader_medium(reader, node, "medium", &row->medium);
    *good &= row->medium >= 0;
}

static bool flat(const struct rmap_shape *shape)
{
    return shape->curvature == 0 && shape->n_asphere == 0;
}

/* Where both surfaces stand, the second must not lie before the first: rays would meet them in
 * the wrong order. */
static void check_order(struct rmap_reader *reader, const struct rmap_lens *lens, size_t k)
{
    const struct rmap_lens_row *a = &lens->row[k], *b = &lens->row[k + 1];
    double r = fmin(a->shape.aperture, b->shape.aperture);
    double za = a->z + rmap_shape_sag(&a->shape, r), zb = b->z + rmap_shape_sag(&b->shape, r);
    double slack = 1e-9 * (fabs(za) + fabs(zb) + r);
    if (!(za > zb + slack))
        return;
    bool plate = (a->stop && flat(&a->shape)) || (b->stop && flat(&b->shape));
    if (plate)
        rmap_reader_warn(reader, b->node,
                         "rows %zu and %zu cross at radius %g: the plate of the stop cuts the "
                         "surface beside it",
                         k + 1, k + 2, r);
    else
        rmap_reader_error(reader, b->node,
                          "rows %zu and %zu cross at radius %g (by %g): make the thickness "
                          "larger or an aperture smaller",
                          k + 1, k + 2, r, za - zb);
}

static void read_rows(struct rmap_reader *reader, const struct rmap_yaml_node *rows,
                      struct rmap_lens *lens, bool *good)
{
    double z = 0;
    lens->row = rmap_reader_alloc(reader, rows->n_item, sizeof *lens->row);
    if (!lens->row)
        return;
    lens->n_row = rows->n_item;
    for (size_t k = 0; k < lens->n_row; k++) {
        struct rmap_lens_row *row = &lens->row[k];
        double thickness = 0;
        bool row_good = false;
        read_row(reader, rows->item[k].value, k + 1 == lens->n_row, &thickness, row, &row_good);
        *good &= row_good;
        if (!row_good)
            continue;
        row->z = z;
        row->rim_z = z + rmap_shape_sag(&row->shape, row->shape.aperture);
        lens->widest = fmax(lens->widest, row->shape.aperture);
        z += thickness;
    }
    for (size_t k = 0; *good && k + 1 < lens->n_row; k++)
        check_order(reader, lens, k);
}

void rmap_reader_read_lens(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           struct rmap_geometry_entry *entry)
{
    bool good = true;
    const struct rmap_yaml_node *rows = rmap_yaml_get(node, "surfaces");
    struct rmap_lens *lens = rmap_reader_alloc(reader, 1, sizeof *lens);
    if (!lens)
        return;
    lens->surface_front = lens->surface_back = lens->edge_front = lens->edge_back = -1;
    rmap_reader_surface_pair(reader, node, "surface", &lens->surface_front, &lens->surface_back);
    rmap_reader_surface_pair(reader, node, "edge", &lens->edge_front, &lens->edge_back);
    if (lens->surface_front < 0 || lens->surface_back < 0) {
        rmap_reader_builtin_surface(reader, RMAP_SURFACE_FRESNEL, &lens->surface_front);
        lens->surface_back = lens->surface_front;
    }
    if (lens->edge_front < 0 || lens->edge_back < 0) {
        rmap_reader_builtin_surface(reader, RMAP_SURFACE_ABSORBER, &lens->edge_front);
        lens->edge_back = lens->edge_front;
    }
    if (!rows)
        rmap_reader_error(reader, node, "'surfaces' is missing: list the rows of the table");
    else if (rmap_reader_check_list(reader, rows, "'surfaces'") && !rows->n_item)
        rmap_reader_error(reader, rows, "'surfaces' is empty: list the rows of the table");
    else if (rows->kind == RMAP_YAML_LIST) {
        read_rows(reader, rows, lens, &good);
        entry->lens = lens;
        entry->broken = !good;
    }
}
