/* SPDX-License-Identifier: MIT
 *
 * The analytic models of gradient media.
 */
#include <math.h>
#include <string.h>

#include "gradient/field_polynomial.h"
#include "io/scene/scene_field.h"

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
MAKER(exponential)
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
    int choice = 0;
    bool good = rmap_reader_choice(reader, node, "of", RMAP_OPTIONAL, "n n^2", &choice);
    *of = choice ? RMAP_SERIES_OF_N_SQUARED : RMAP_SERIES_OF_N;
    return good;
}

static void read_series(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const struct rmap_field_place *place, struct rmap_field **field_ret)
{
    enum { N_MAX = 32 };
    static const struct {
        const char *type;
        enum rmap_series_variable variable;
    } known[] = {
        {"axial", RMAP_SERIES_Z}, {"radial", RMAP_SERIES_RHO2}, {"spherical", RMAP_SERIES_R2}};
    enum rmap_series_of of = RMAP_SERIES_OF_N;
    double *value = NULL;
    size_t width = 0, kind = 0;
    (void)place;
    while (strcmp(rmap_yaml_get(node, "type")->text, known[kind].type) != 0)
        kind++;
    bool good = read_series_of(reader, node, &of);
    rmap_reader_channel_list(reader, node, "coefficients", N_MAX, &width, &value);
    if (good && value)
        rmap_reader_made(reader, node,
                         rmap_field_series(field_ret, known[kind].variable, of,
                                           rmap_reader_distinct(reader, value, width), (int)width,
                                           value, &reader->failure));
}

static bool read_power(struct rmap_reader *reader, const struct rmap_yaml_node *term, int power[3])
{
    const struct rmap_range whole = {0, 64, "from 0 to 64"};
    double given[3] = {0};
    size_t n = 0;
    bool fine = rmap_reader_numbers(reader, term, "power", RMAP_REQUIRED, &whole, 3, 3, given, &n);
    for (int i = 0; fine && i < 3; i++) {
        power[i] = (int)given[i];
        if (given[i] == floor(given[i]))
            continue;
        rmap_reader_error(reader, rmap_yaml_get(term, "power"), "powers are whole numbers");
        fine = false;
    }
    return fine;
}

/* {terms: [{power: [i, j, k], value: c}, ...]} */
static void read_polynomial(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const struct rmap_field_place *place, struct rmap_field **field_ret)
{
    enum { N_MAX = 256 };
    static const struct rmap_field_parameter value_of[] = {{"value", REQUIRED}};
    enum rmap_series_of of = RMAP_SERIES_OF_N;
    const struct rmap_yaml_node *terms = rmap_yaml_get(node, "terms");
    bool good = read_series_of(reader, node, &of);
    (void)place;
    if (!terms || terms->kind != RMAP_YAML_LIST || !terms->n_item || terms->n_item > N_MAX) {
        rmap_reader_error(reader, terms ? terms : node,
                          "'terms' must be a list of 1 to %d terms {power: [i, j, k], value: c}",
                          N_MAX);
        return;
    }
    const size_t n = terms->n_item, n_channel = (size_t)reader->scene->channels.n;
    int(*power)[3] = rmap_reader_alloc(reader, n, sizeof *power);
    double *value = rmap_reader_alloc(reader, n * n_channel, sizeof *value);
    if (!power || !value)
        return;
    for (size_t t = 0; t < n; t++) {
        const struct rmap_yaml_node *term = terms->item[t].value;
        double on_channel[RMAP_CHANNEL_MAX] = {0};
        bool fine = rmap_reader_check_map(reader, term, "a term", "power value");
        if (fine)
            good &= read_power(reader, term, power[t]);
        if (fine)
            rmap_reader_parameters(reader, term, value_of, 1, on_channel, &fine);
        good &= fine;
        for (size_t c = 0; c < n_channel; c++)
            value[c * n + t] = on_channel[c];
    }
    if (good)
        rmap_reader_made(reader, node,
                         rmap_field_polynomial(field_ret, of,
                                               rmap_reader_distinct(reader, value, n), (int)n,
                                               (const int(*)[3])power, value, &reader->failure));
}

/* ---- Zemax ---- */

static bool read_zemax_parameters(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                  int number, double value[RMAP_ZEMAX_PARAMETER_MAX])
{
    const struct rmap_yaml_node *given = rmap_yaml_get(node, "parameters");
    const char *key[RMAP_ZEMAX_PARAMETER_MAX];
    size_t n = 0;
    while (n < RMAP_ZEMAX_PARAMETER_MAX && rmap_zemax_parameter(number, (int)n)) {
        key[n] = rmap_zemax_parameter(number, (int)n);
        n++;
    }
    if (!given) {
        rmap_reader_error(reader, node, "'parameters' is missing: add it");
        return false;
    }
    size_t before = reader->diagnostics->n_error;
    bool good = rmap_reader_check_keys(reader, given, "a Zemax gradient", key, n) &&
                reader->diagnostics->n_error == before;
    for (size_t i = 0; i < n; i++)
        good &=
            rmap_reader_number(reader, given, key[i], RMAP_OPTIONAL, &rmap_range_any, &value[i]);
    return good;
}

static void read_zemax(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const struct rmap_field_place *place, struct rmap_field **field_ret)
{
    double value[RMAP_ZEMAX_PARAMETER_MAX] = {0};
    uint64_t number = 0;
    (void)place;
    if (!rmap_yaml_get(node, "gradient")) {
        rmap_reader_error(reader, node, "'gradient' is missing: its number, as in Gradient 5");
        return;
    }
    if (!rmap_reader_whole(reader, node, "gradient", 1, 12, &number))
        return;
    if (!rmap_zemax_parameter((int)number, 0)) {
        rmap_reader_error(reader, rmap_yaml_get(node, "gradient"),
                          "there is no gradient %d here: 1 to 7, 9, 10 and 12", (int)number);
        return;
    }
    if (!read_zemax_parameters(reader, node, (int)number, value))
        return;
    rmap_reader_made(
        reader, node,
        rmap_field_zemax(field_ret, (int)number, rmap_reader_distinct_wavelengths(reader),
                         reader->scene->channels.wavelength_nm, value, &reader->failure));
}

/* ---- profiles ---- */

static void read_standard_air(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                              const struct rmap_field_place *place, struct rmap_field **field_ret)
{
    double celsius = 15;
    struct rmap_standard_air air = {.metre = 1 / reader->scene->unit_m, .pressure_pa = 101325};
    (void)place;
    bool good = rmap_reader_number(reader, node, "radius", RMAP_OPTIONAL, &rmap_range_nonnegative,
                                   &air.radius);
    good &=
        rmap_reader_number(reader, node, "temperature", RMAP_OPTIONAL, &rmap_range_any, &celsius);
    good &= rmap_reader_number(reader, node, "pressure", RMAP_OPTIONAL, &rmap_range_positive,
                               &air.pressure_pa);
    air.temperature_k = celsius + 273.15;
    if (!good)
        return;
    rmap_reader_made(reader, node,
                     rmap_field_standard_air(field_ret, rmap_reader_distinct_wavelengths(reader),
                                             reader->scene->channels.wavelength_nm, &air,
                                             &reader->failure));
}

/* {along: z, coordinate: [..], n: [..], radius: R} */
static void read_profile(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                         const struct rmap_field_place *place, struct rmap_field **field_ret)
{
    enum { N_MAX = 100000 };
    double *at = NULL, *n = NULL, radius = 0;
    size_t n_at = 0, n_point = 0;
    int choice = 0;
    (void)place;
    bool good = rmap_reader_choice(reader, node, "along", RMAP_REQUIRED, "z rho r", &choice);
    good &=
        rmap_reader_number(reader, node, "radius", RMAP_OPTIONAL, &rmap_range_nonnegative, &radius);
    rmap_reader_channel_list(reader, node, "coordinate", N_MAX, &n_at, &at);
    rmap_reader_channel_list(reader, node, "n", N_MAX, &n_point, &n);
    if (!good || !at || !n)
        return;
    if (n_at != n_point) {
        rmap_reader_error(reader, rmap_yaml_get(node, "n"),
                          "'n' has %zu entries, 'coordinate' has %zu", n_point, n_at);
        return;
    }
    rmap_reader_made(reader, node,
                     rmap_field_profile(field_ret, (enum rmap_profile_variable)choice, radius,
                                        rmap_reader_distinct(reader, n, n_point), (int)n_point, at,
                                        n, &reader->failure));
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
    {"exponential",
     {{"n_far", 1}, {"refractivity", REQUIRED}, {"scale_height", REQUIRED}, {"radius", 0}},
     {NULL},
     make_exponential,
     NULL},
    {"axial", {{0}}, {"coefficients", "of"}, NULL, read_series},
    {"radial", {{0}}, {"coefficients", "of"}, NULL, read_series},
    {"spherical", {{0}}, {"coefficients", "of"}, NULL, read_series},
    {"polynomial", {{0}}, {"terms", "of"}, NULL, read_polynomial},
    {"zemax", {{0}}, {"gradient", "parameters"}, NULL, read_zemax},
    {"standard_atmosphere", {{0}}, {"radius", "temperature", "pressure"}, NULL, read_standard_air},
    {"profile", {{0}}, {"along", "coordinate", "n", "radius"}, NULL, read_profile},
};

const struct rmap_field_model *rmap_field_model_analytic(size_t i)
{
    return i < RMAP_COUNT(models) ? &models[i] : NULL;
}
