/* SPDX-License-Identifier: MIT */
#include "io/scene/sag_numbers.h"

#define FIELD(name, member, element, width, text)                                                  \
    {                                                                                              \
        "sag/" name, RMAP_##element, width, offsetof(struct rmap_kept_sag, member), text           \
    }

const struct rmap_h5_field rmap_kept_sag_field[RMAP_KEPT_SAG_FIELDS] = {
    FIELD("geometry", geometry, I32, 1, "row of /name/geometry; a wall has its bottom and its top"),
    FIELD("side", side, I32, 1, "wall, of a rectangle: 0 to 3 for +x, +y, -x, -y"),
    FIELD("rectangle", outline.rectangle, U8, 1, "the outline: 1 a rectangle, 0 an ellipse"),
    FIELD("half", outline.half, F64, 2, "the outline's half widths along x and y"),
    FIELD("at", outline.at, F64, 2, "its middle"),
    FIELD("inner", outline.inner, F64, 1, "radius of the hole about that"),
    FIELD("base", sag.base, I32, 1, "0 conic, 1 biconic, 2 toroid"),
    FIELD("curvature", sag.curvature, F64, 2, "along x and y; toroid: of its turn, of its profile"),
    FIELD("conic", sag.conic, F64, 2, "constants k along x and y"),
    FIELD("power", sag.power, F64, RMAP_SAG_POWERS, "coefficients of r, r^2, ...; toroid: of y"),
    FIELD("n_power", sag.n_power, I32, 1, "coefficients in use"),
    FIELD("xy_norm", sag.xy_norm, F64, 1, "length that x and y are divided by"),
    FIELD("xy", sag.xy, F64, RMAP_SAG_TERMS,
          "coefficients of x^i y^j at (i + j) (i + j + 1) / 2 + j"),
    FIELD("n_xy", sag.n_xy, I32, 1, "largest i + j, + 1; 0: none"),
    FIELD("zernike_norm", sag.zernike_norm, F64, 1, "length that r is divided by"),
    FIELD("zernike", sag.zernike, F64, RMAP_SAG_TERMS,
          "coefficients of Z(n, m), of peak 1, at n (n + 1) / 2 + (n + m) / 2"),
    FIELD("n_zernike", sag.n_zernike, I32, 1, "largest n, + 1; 0: none"),
    FIELD("qcon_norm", sag.qcon_norm, F64, 1, "length that r is divided by"),
    FIELD("qcon", sag.qcon, F64, RMAP_SAG_Q, "coefficients of Forbes's Q con"),
    FIELD("n_qcon", sag.n_qcon, I32, 1, "coefficients in use"),
    FIELD("qbfs_norm", sag.qbfs_norm, F64, 1, "length that r is divided by"),
    FIELD("qbfs", sag.qbfs, F64, RMAP_SAG_Q, "coefficients of Forbes's Q bfs"),
    FIELD("n_qbfs", sag.n_qbfs, I32, 1, "coefficients in use"),
    FIELD("fresnel", sag.fresnel, U8, 1, "1: flat, with the normals of its profile"),
};

_Static_assert(sizeof(enum rmap_sag_base) == 4 && sizeof(bool) == 1, "as in the file");

static size_t n_sag_of(const struct rmap_shape *shape)
{
    return (size_t)(shape->sag[0] != NULL) + (size_t)(shape->sag[1] != NULL);
}

size_t rmap_kept_sag_count(const struct rmap_scene *scene)
{
    size_t n = 0;
    for (size_t g = 0; g < scene->n_geometry; g++)
        n += n_sag_of(&scene->geometry[g].shape);
    return n;
}

void rmap_kept_sag_copy(const struct rmap_scene *scene, struct rmap_kept_sag *kept)
{
    for (size_t g = 0; g < scene->n_geometry; g++) {
        const struct rmap_shape *shape = &scene->geometry[g].shape;
        for (size_t k = 0; k < n_sag_of(shape); k++)
            *kept++ =
                (struct rmap_kept_sag){(int32_t)g, shape->side, shape->outline, *shape->sag[k]};
    }
}

const char *rmap_kept_sag_back(const struct rmap_kept_sag *kept, struct rmap_scene *scene)
{
    const char *wrong = NULL;
    for (size_t g = 0; g < scene->n_geometry && !wrong; g++) {
        struct rmap_shape *shape = &scene->geometry[g].shape;
        const size_t n = n_sag_of(shape);
        for (size_t k = 0; k < n; k++)
            *shape->sag[k] = kept[k].sag;
        if (n == 1)
            wrong = rmap_shape_of_sag(shape, shape->sag[0], &kept->outline);
        else if (n == 2)
            wrong = rmap_shape_of_wall(shape, shape->sag[0], shape->sag[1], shape->length,
                                       &kept->outline, shape->side);
        kept += n;
    }
    return wrong;
}
