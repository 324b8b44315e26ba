/* SPDX-License-Identifier: MIT
 *
 * The analytic models of gradient media.
 */
#include <math.h>
#include <string.h>

#include "io/scene_field.h"

#define REQUIRED ((double)NAN)

/* A maker that takes its structure as the doubles that it is. */
#define MAKER(model)                                                                               \
    static enum rmap_status make_##model(struct rmap_field **field_ret, int n_channel,             \
                                         const double *parameter, struct rmap_error *err)          \
    {                                                                                              \
        struct rmap_##model list[RMAP_CHANNEL_MAX];                                                \
        memcpy(list, parameter, (size_t)n_channel * sizeof *list);                                 \
        return rmap_field_##model(field_ret, n_channel, list, err);                                \
    }
MAKER(luneburg)
MAKER(maxwell)
MAKER(eaton)
MAKER(gutman)
MAKER(parabolic)
MAKER(selfoc)
MAKER(sech)
#undef MAKER

/* ---- series ---- */

static enum rmap_status make_constant(struct rmap_field **field_ret, int n_channel,
                                      const double *parameter, struct rmap_error *err)
{
    return rmap_field_series(field_ret, RMAP_SERIES_Z, RMAP_SERIES_OF_N, n_channel, 1, parameter,
                             err);
}

static bool read_series_of(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           enum rmap_series_of *of)
{
    static const char *const word[] = {"n", "n^2"};
    int choice = 0;
    bool good = rmap_reader_choice(reader, node, "of", RMAP_OPTIONAL, word, 2, &choice);
    *of = choice ? RMAP_SERIES_OF_N_SQUARED : RMAP_SERIES_OF_N;
    return good;
}

static enum rmap_status read_series(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                    const struct rmap_field_place *place,
                                    struct rmap_field **field_ret)
{
    enum { N_MAX = 32 };
    static const struct {
        const char *type;
        enum rmap_series_variable variable;
    } known[] = {
        {"axial", RMAP_SERIES_Z}, {"radial", RMAP_SERIES_RHO2}, {"spherical", RMAP_SERIES_R2}};
    enum rmap_status st = RMAP_OK;
    enum rmap_series_of of = RMAP_SERIES_OF_N;
    struct rmap_error failure = {0};
    double *value = NULL;
    size_t width = 0, kind = 0;
    (void)place;
    while (strcmp(rmap_yaml_get(node, "type")->text, known[kind].type) != 0)
        kind++;
    bool good = read_series_of(reader, node, &of);
    RMAP_TRY(rmap_reader_channel_list(reader, node, "coefficients", N_MAX, &width, &value));
    if (good && value)
        st = rmap_reader_made(reader, node,
                              rmap_field_series(field_ret, known[kind].variable, of,
                                                rmap_reader_distinct(reader, value, width),
                                                (int)width, value, &failure),
                              &failure);
out:
    return st;
}

/* ---- the table ---- */

static const struct rmap_field_model models[] = {
    {"constant", {{"index", REQUIRED}}, {NULL}, make_constant, NULL},
    {"luneburg", {{"n_edge", 1}, {"radius", REQUIRED}}, {NULL}, make_luneburg, NULL},
    {"maxwell", {{"n_centre", 2}, {"radius", REQUIRED}}, {NULL}, make_maxwell, NULL},
    {"eaton", {{"n_edge", 1}, {"radius", REQUIRED}}, {NULL}, make_eaton, NULL},
    {"gutman",
     {{"n_edge", 1}, {"radius", REQUIRED}, {"focus", REQUIRED}},
     {NULL},
     make_gutman,
     NULL},
    {"parabolic", {{"n0", REQUIRED}, {"alpha", REQUIRED}}, {NULL}, make_parabolic, NULL},
    {"selfoc", {{"n0", REQUIRED}, {"A", REQUIRED}}, {NULL}, make_selfoc, NULL},
    {"sech", {{"n0", REQUIRED}, {"alpha", REQUIRED}}, {NULL}, make_sech, NULL},
    {"axial", {{0}}, {"coefficients", "of"}, NULL, read_series},
    {"radial", {{0}}, {"coefficients", "of"}, NULL, read_series},
    {"spherical", {{0}}, {"coefficients", "of"}, NULL, read_series},
};

const struct rmap_field_model *rmap_field_model_analytic(size_t i)
{
    return i < RMAP_COUNT(models) ? &models[i] : NULL;
}
