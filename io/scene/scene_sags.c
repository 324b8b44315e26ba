/* SPDX-License-Identifier: MIT
 *
 * Surfaces that are no conics with even powers.
 */
#include "io/scene/scene_sags.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "geometry/sag.h"

static bool is_list(const struct rmap_yaml_node *map, const char *key)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(map, key);
    return node && node->kind == RMAP_YAML_LIST;
}

static bool has_odd_power(const struct rmap_yaml_node *asphere)
{
    double power = 0;
    for (size_t i = 0; asphere && asphere->kind == RMAP_YAML_MAP && i < asphere->n_item; i++) {
        const char *key = asphere->item[i].key;
        if (rmap_reader_parse_number(key, strlen(key), &power) && fabs(fmod(power, 2)) == 1)
            return true;
    }
    return false;
}

bool rmap_reader_is_sag(const struct rmap_yaml_node *map)
{
    static const char *const own[] = {"toroid", "zernike", "xy", "qcon", "qbfs", "fresnel"};
    const struct rmap_yaml_node *aperture = rmap_yaml_get(map, "aperture");
    for (size_t i = 0; i < RMAP_COUNT(own); i++)
        if (rmap_yaml_get(map, own[i]))
            return true;
    return is_list(map, "radius") || is_list(map, "curvature") || is_list(map, "conic") ||
           (aperture && aperture->kind == RMAP_YAML_MAP) ||
           has_odd_power(rmap_yaml_get(map, "asphere"));
}

bool rmap_reader_radius(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const char *what, double *curvature)
{
    static const char *const infinite[] = {"inf",   "+inf",  "-inf",     ".inf",
                                           "+.inf", "-.inf", "infinity", "Infinity"};
    double radius = 0;
    for (size_t i = 0; node->kind == RMAP_YAML_SCALAR && i < RMAP_COUNT(infinite); i++)
        if (strcmp(node->text, infinite[i]) == 0)
            return true;
    if (!rmap_reader_scalar(reader, node, what, &rmap_range_length, &radius))
        return false;
    *curvature = radius != 0 ? 1.0 / radius : 0.0;
    if (isfinite(*curvature))
        return true;
    rmap_reader_error(reader, node, "%s is too small: %s", what, node->text);
    return false;
}

bool rmap_reader_powers(struct rmap_reader *reader, const struct rmap_yaml_node *node, int step,
                        int most, double *coefficient, int *n_ret)
{
    bool good = true;
    if (node->kind != RMAP_YAML_MAP) {
        rmap_reader_error(reader, node, "'asphere' must be a mapping {power: coefficient, ...}");
        return false;
    }
    for (size_t i = 0; i < node->n_item; i++) {
        const struct rmap_yaml_item *item = &node->item[i];
        const struct rmap_yaml_node place = {.line = item->line, .column = item->column};
        double power = 0, value = 0;
        bool whole = rmap_reader_parse_number(item->key, strlen(item->key), &power) &&
                     power >= step && power <= most && fmod(power, step) == 0;
        if (!whole)
            rmap_reader_error(reader, &place,
                              "a whole power from 1 to %d must stand here, not '%.40s'", most,
                              item->key);
        whole &= rmap_reader_scalar(reader, item->value, "an asphere coefficient", &rmap_range_any,
                                    &value);
        good &= whole;
        if (!whole || value == 0)
            continue;
        const int term = (int)power / step - 1;
        coefficient[term] = value;
        if (*n_ret <= term)
            *n_ret = term + 1;
    }
    return good;
}

/* ---- the base ---- */

/* One or two: `at` of each, with the key's name. */
static bool read_pair(struct rmap_reader *reader, const struct rmap_yaml_node *map, const char *key,
                      bool (*read)(struct rmap_reader *, const struct rmap_yaml_node *,
                                   const char *, double *),
                      double value[2], size_t *n_ret)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(map, key);
    char what[40];
    (void)snprintf(what, sizeof what, "'%s'", key);
    if (!node)
        return true;
    *n_ret = node->kind == RMAP_YAML_LIST ? node->n_item : 1;
    if (node->kind != RMAP_YAML_LIST) {
        bool good = read(reader, node, what, &value[0]);
        value[1] = value[0];
        return good;
    }
    if (node->n_item != 2) {
        rmap_reader_error(reader, node, "%s must be a number, or a list of two along x and y",
                          what);
        return false;
    }
    return read(reader, node->item[0].value, what, &value[0]) &
           read(reader, node->item[1].value, what, &value[1]);
}

static bool read_curvature(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           const char *what, double *value)
{
    return rmap_reader_scalar(reader, node, what, &rmap_range_curvature, value);
}

static bool read_conic(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const char *what, double *value)
{
    return rmap_reader_scalar(reader, node, what, &rmap_range_any, value);
}

static bool read_base(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                      struct rmap_sag *sag)
{
    const struct rmap_yaml_node *toroid = rmap_yaml_get(map, "toroid"),
                                *asphere = rmap_yaml_get(map, "asphere"),
                                *radius = rmap_yaml_get(map, "radius");
    size_t n_curvature = 0, n_conic = 0;
    if (radius && rmap_yaml_get(map, "curvature")) {
        rmap_reader_error(reader, radius, "give 'radius' or 'curvature', not both");
        return false;
    }
    bool good = read_pair(reader, map, "radius", rmap_reader_radius, sag->curvature, &n_curvature) &
                read_pair(reader, map, "curvature", read_curvature, sag->curvature, &n_curvature) &
                read_pair(reader, map, "conic", read_conic, sag->conic, &n_conic);
    if (asphere)
        good &= rmap_reader_powers(reader, asphere, 1, RMAP_SAG_POWERS, sag->power, &sag->n_power);
    if (n_curvature == 2 || n_conic == 2)
        sag->base = RMAP_SAG_BICONIC;
    if (!toroid)
        return good;
    if (sag->base == RMAP_SAG_BICONIC) {
        rmap_reader_error(reader, toroid,
                          "a toroid's 'radius' and 'conic' are those of its profile along y: one "
                          "number each");
        return false;
    }
    sag->base = RMAP_SAG_TOROID;
    sag->curvature[0] = sag->conic[0] = 0;
    return rmap_reader_radius(reader, toroid, "'toroid'", &sag->curvature[0]) && good;
}

/* ---- sums ---- */

/* The mapping of a sum, and its norm; NULL: there is none, or it is wrong. */
static const struct rmap_yaml_node *open_sum(struct rmap_reader *reader,
                                             const struct rmap_yaml_node *map, const char *key,
                                             const char *keys, double *norm, bool *good)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(map, key);
    char what[20];
    (void)snprintf(what, sizeof what, "'%s'", key);
    if (!node)
        return NULL;
    bool fine =
        rmap_reader_check_map(reader, node, what, keys) &&
        rmap_reader_number(reader, node, "norm", RMAP_REQUIRED, &rmap_range_positive_length, norm);
    if (fine && !rmap_yaml_get(node, "terms")) {
        rmap_reader_error(reader, node, "'terms' is missing: add it");
        fine = false;
    }
    *good &= fine;
    return fine ? node : NULL;
}

/* Where a term belongs, by its key; false, after what is wrong, where that names none. */
struct sum {
    const char *what;
    bool (*place)(const struct sum *sum, const char *key, int *degree, int *k, double *norm);
    enum rmap_zernike_order order;
    double *value;
    int *n;
};

static bool place_xy(const struct sum *sum, const char *key, int *degree, int *k, double *norm)
{
    int of[2] = {0, 0};
    const char *at = key;
    (void)sum;
    for (int i = 0; i < 2; i++) {
        if (*at != "xy"[i])
            continue;
        char *end = NULL;
        const long power = strtol(at + 1, &end, 10);
        if (end == at + 1 || at[1] < '0' || at[1] > '9' || power > RMAP_SAG_DEGREE)
            return false;
        of[i] = (int)power;
        at = end;
    }
    *degree = of[0] + of[1];
    *k = of[1];
    *norm = 1;
    return at != key && *at == '\0' && *degree <= RMAP_SAG_DEGREE;
}

static bool place_zernike(const struct sum *sum, const char *key, int *degree, int *k, double *norm)
{
    double number = 0;
    int m = 0;
    if (!rmap_reader_parse_number(key, strlen(key), &number) || number != floor(number) ||
        !(number >= 0 && number <= RMAP_SAG_TERMS) ||
        !rmap_zernike_term(sum->order, (int)number, degree, &m, norm))
        return false;
    *k = (*degree + m) / 2;
    return true;
}

static bool read_terms(struct rmap_reader *reader, const struct rmap_yaml_node *terms,
                       const struct sum *sum)
{
    bool good = terms->kind == RMAP_YAML_MAP;
    if (!good)
        rmap_reader_error(reader, terms, "'terms' must be a mapping {%s: coefficient, ...}",
                          sum->what);
    for (size_t i = 0; good && i < terms->n_item; i++) {
        const struct rmap_yaml_item *item = &terms->item[i];
        const struct rmap_yaml_node at = {.line = item->line, .column = item->column};
        int degree = 0, k = 0;
        double norm = 0, value = 0;
        if (!sum->place(sum, item->key, &degree, &k, &norm)) {
            rmap_reader_error(reader, &at, "%s must stand here, not '%.40s'", sum->what, item->key);
            return false;
        }
        good = rmap_reader_scalar(reader, item->value, "a coefficient", &rmap_range_length, &value);
        sum->value[rmap_sag_term(degree, k)] = norm * value;
        if (value != 0 && *sum->n <= degree)
            *sum->n = degree + 1;
    }
    return good;
}

static bool read_planar(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                        struct rmap_sag *sag)
{
    bool good = true;
    const struct rmap_yaml_node *xy =
        open_sum(reader, map, "xy", "norm terms", &sag->xy_norm, &good);
    const struct rmap_yaml_node *zernike =
        open_sum(reader, map, "zernike", "norm order terms", &sag->zernike_norm, &good);
    int order = 0;
    if (xy)
        good &= read_terms(reader, rmap_yaml_get(xy, "terms"),
                           &(struct sum){.what = "x and y with their powers, up to x20y0 together",
                                         .place = place_xy,
                                         .value = sag->xy,
                                         .n = &sag->n_xy});
    if (!zernike)
        return good;
    if (!rmap_reader_choice(reader, zernike, "order", RMAP_REQUIRED, "fringe noll standard",
                            &order))
        return false;
    static const char *const what[] = {"a number from 1 to 37 of the fringe order",
                                       "a number from 1 to 231 of Noll's order",
                                       "a number from 0 to 230 of the standard order"};
    return good & read_terms(reader, rmap_yaml_get(zernike, "terms"),
                             &(struct sum){.what = what[order],
                                           .place = place_zernike,
                                           .order = (enum rmap_zernike_order)order,
                                           .value = sag->zernike,
                                           .n = &sag->n_zernike});
}

static bool read_forbes(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                        const char *key, double *norm, double *value, int *n_ret)
{
    bool good = true;
    size_t n = 0;
    const struct rmap_yaml_node *node = open_sum(reader, map, key, "norm terms", norm, &good);
    if (!node)
        return good;
    good = rmap_reader_numbers(reader, node, "terms", RMAP_REQUIRED, &rmap_range_length, 1,
                               RMAP_SAG_Q, value, &n);
    *n_ret = (int)n;
    return good;
}

/* ---- the aperture ---- */

static bool read_aperture(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                          struct rmap_aperture *aperture)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(map, "aperture");
    size_t n = 0;
    bool good = rmap_reader_number(reader, map, "inner", RMAP_OPTIONAL,
                                   &rmap_range_nonnegative_length, &aperture->inner);
    if (!node || node->kind != RMAP_YAML_MAP) {
        good &= rmap_reader_number(reader, map, "aperture", RMAP_REQUIRED,
                                   &rmap_range_positive_length, &aperture->half[0]);
        aperture->half[1] = aperture->half[0];
        return good;
    }
    if (!rmap_reader_check_map(reader, node, "an aperture", "rectangle ellipse at"))
        return false;
    aperture->rectangle = rmap_yaml_get(node, "rectangle") != NULL;
    if (aperture->rectangle == (rmap_yaml_get(node, "ellipse") != NULL)) {
        rmap_reader_error(reader, node,
                          "an aperture is a radius, {rectangle: [width, height]} or {ellipse: [a, "
                          "b]} of its semi-axes");
        return false;
    }
    good &=
        rmap_reader_numbers(reader, node, aperture->rectangle ? "rectangle" : "ellipse",
                            RMAP_REQUIRED, &rmap_range_positive_length, 2, 2, aperture->half, &n) &
        rmap_reader_numbers(reader, node, "at", RMAP_OPTIONAL, &rmap_range_length, 2, 2,
                            aperture->at, &n);
    for (int k = 0; aperture->rectangle && k < 2; k++)
        aperture->half[k] *= 0.5;
    return good;
}

bool rmap_reader_sag(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                     struct rmap_shape *shape)
{
    struct rmap_aperture aperture = {.rectangle = false};
    struct rmap_sag *sag = rmap_reader_alloc(reader, 1, sizeof *sag);
    if (!sag)
        return false;
    bool good = read_base(reader, map, sag) & read_planar(reader, map, sag) &
                read_forbes(reader, map, "qcon", &sag->qcon_norm, sag->qcon, &sag->n_qcon) &
                read_forbes(reader, map, "qbfs", &sag->qbfs_norm, sag->qbfs, &sag->n_qbfs) &
                rmap_reader_bool(reader, map, "fresnel", &sag->fresnel) &
                read_aperture(reader, map, &aperture);
    if (!good)
        return false;
    const char *wrong = rmap_shape_of_sag(shape, sag, &aperture);
    if (wrong)
        rmap_reader_error(reader, map, "this is no surface: %s", wrong);
    return !wrong;
}
