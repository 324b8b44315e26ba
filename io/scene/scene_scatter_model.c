/* SPDX-License-Identifier: MIT
 *
 * A scatter model's parameters, and what they make of it.
 */
#include "io/scene/scene_scatter_model.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#include "io/scene/scene_keys.h"
#include "io/scene/scene_quantity.h"
#include "io/scene/scene_tables.h"
#include "scatter/dust.h"
#include "scene/scene.h"

/* What may stand beside `model`, on the channels. */
struct parameters {
    double tis[RMAP_CHANNEL_MAX], sigma[RMAP_CHANNEL_MAX], power[RMAP_CHANNEL_MAX];
    double a[RMAP_CHANNEL_MAX], b[RMAP_CHANNEL_MAX], g[RMAP_CHANNEL_MAX];
    double b0[RMAP_CHANNEL_MAX], l[RMAP_CHANNEL_MAX], s[RMAP_CHANNEL_MAX], r[RMAP_CHANNEL_MAX];
    double sigma_alpha[RMAP_CHANNEL_MAX], spike[RMAP_CHANNEL_MAX], lobe[RMAP_CHANNEL_MAX],
        back[RMAP_CHANNEL_MAX];
    double gaussian, pillbox;                 /* angles */
    double roughness, correlation, reference; /* lengths in the scene's unit; nm */
    bool relative;                            /* a table is of what is reflected */
    enum { VISIBLE, SOLAR } band;
    struct rmap_dust_kind dust;
};

static const struct rmap_range width = {1e-6, 10, "from 0.000001 to 10", RMAP_DIMENSION_NONE},
                               power = {0, 1e9, "from 0 to 1e9", RMAP_DIMENSION_NONE},
                               exponent = {0.1, 20, "from 0.1 to 20", RMAP_DIMENSION_NONE},
                               falling = {-20, -1e-3, "negative, down to -20", RMAP_DIMENSION_NONE},
                               cleanliness = {5, 1000, "a cleanliness level, 5 to 1000",
                                              RMAP_DIMENSION_NONE},
                               incline = {0.1, 2, "from 0.1 to 2", RMAP_DIMENSION_NONE},
                               index_of_dust = {0, 10, "from 0 to 10", RMAP_DIMENSION_NONE},
                               degrees = {1e-3, 60, "from 0.001 to 60 degrees",
                                          RMAP_DIMENSION_NONE},
                               slope = {5e-3, 10, "from 0.005 to 10 degrees (0.1 to 175 mrad)",
                                        RMAP_DIMENSION_ANGLE};

#define SPECTRUM(member) RMAP_KEY_SHARES, offsetof(struct parameters, member)
const struct rmap_mapping rmap_scatter_keys = {
    "scatter models",
    NULL,
#define ROW(number, symbol, name, keys, reciprocal) {"a " name " model", "model " keys},
    {RMAP_SCATTER_TABLE(ROW)},
#undef ROW
    {{"tis", SPECTRUM(tis), &rmap_range_share},
     {"sigma", SPECTRUM(sigma), &width, .need = RMAP_REQUIRED},
     {"r", SPECTRUM(r), &rmap_range_share, .need = RMAP_REQUIRED},
     {"power", SPECTRUM(power), &power, .need = RMAP_REQUIRED},
     {"A", SPECTRUM(a), &rmap_range_nonnegative, .need = RMAP_REQUIRED},
     {"B", SPECTRUM(b), &rmap_range_positive, .need = RMAP_REQUIRED},
     {"g", SPECTRUM(g), &exponent, .need = RMAP_REQUIRED},
     {"b0", SPECTRUM(b0), &rmap_range_nonnegative},
     {"l", SPECTRUM(l), &width},
     {"reference", RMAP_KEY_NUMBER, offsetof(struct parameters, reference), &rmap_range_wavelength},
     {"roughness", RMAP_KEY_NUMBER, offsetof(struct parameters, roughness),
      &rmap_range_nonnegative_length},
     {"correlation", RMAP_KEY_NUMBER, offsetof(struct parameters, correlation),
      &rmap_range_positive_length},
     {"sigma_alpha", SPECTRUM(sigma_alpha), &degrees},
     {"gaussian", RMAP_KEY_ANGLE, offsetof(struct parameters, gaussian), &slope},
     {"pillbox", RMAP_KEY_ANGLE, offsetof(struct parameters, pillbox), &slope},
     {"spike", SPECTRUM(spike), &rmap_range_share},
     {"lobe", SPECTRUM(lobe), &rmap_range_share},
     {"back", SPECTRUM(back), &rmap_range_share},
     {"relative", RMAP_KEY_TRUTH, offsetof(struct parameters, relative)},
     {"level", RMAP_KEY_NUMBER, offsetof(struct parameters, dust.level), &cleanliness,
      .need = RMAP_REQUIRED},
     {"slope", RMAP_KEY_NUMBER, offsetof(struct parameters, dust.slope), &incline,
      .otherwise = 0.926},
     {"n", SPECTRUM(dust.n), &index_of_dust},
     {"k", SPECTRUM(dust.k), &index_of_dust},
     {"band", RMAP_KEY_WORD, offsetof(struct parameters, band), .words = "visible solar"}}};
#undef SPECTRUM

/* A lobe being read. */
struct lobe {
    struct rmap_reader *reader;
    const struct rmap_yaml_node *node;
    struct rmap_scatter *its;
    struct parameters parameters;
    int n; /* channels */
    bool passes;
};

static bool has(const struct lobe *lobe, const char *key)
{
    return rmap_yaml_get(lobe->node, key) != NULL;
}

static double nm_of(const struct lobe *lobe, double length)
{
    return length * lobe->reader->scene->unit_m * 1e9;
}

static double wavelength_of(const struct lobe *lobe, int channel)
{
    return lobe->reader->scene->channels.wavelength_nm[channel];
}

static void copy(const struct lobe *lobe, int k, const double *value, double scale)
{
    for (int i = 0; i < lobe->n; i++)
        lobe->its->shape[k][i] = scale * value[i];
}

/* A roughness, in wavelengths, and the width of its lobe: lambda / (2 pi correlation). */
static bool set_roughness(struct lobe *lobe)
{
    const double roughness = nm_of(lobe, lobe->parameters.roughness),
                 correlation = nm_of(lobe, lobe->parameters.correlation);
    lobe->its->by_roughness = true;
    if (roughness > 1e4) {
        rmap_reader_error(lobe->reader, rmap_yaml_get(lobe->node, "roughness"),
                          "a roughness of %g mm is that of no optical surface: write its unit, as "
                          "in 2 nm",
                          1e-6 * roughness);
        return false;
    }
    for (int i = 0; i < lobe->n; i++) {
        const double wavelength = wavelength_of(lobe, i);
        lobe->its->amount[i] = 1.0;
        lobe->its->shape[RMAP_SHAPE_ROUGHNESS][i] = roughness / wavelength;
        if (correlation > 0.0)
            lobe->its->shape[RMAP_SHAPE_L][i] = wavelength / (2.0 * RMAP_PI * correlation);
    }
    return true;
}

static bool read_harvey(struct lobe *lobe)
{
    const bool rough = has(lobe, "roughness"), given = has(lobe, "b0");
    const size_t before = lobe->reader->diagnostics->n_error;
    struct parameters *p = &lobe->parameters;
    if (rough == given) {
        rmap_reader_error(lobe->reader, lobe->node,
                          "a harvey model has b0, l and s, or a roughness with correlation (or l)");
        return false;
    }
    for (int i = 0; i < lobe->n && !has(lobe, "s"); i++)
        p->s[i] = -1.5;
    rmap_reader_quantity(lobe->reader, lobe->node, "s", given ? RMAP_REQUIRED : RMAP_OPTIONAL,
                         &falling, p->s);
    copy(lobe, RMAP_SHAPE_S, p->s, 1.0);
    if (has(lobe, "l") == (rough && has(lobe, "correlation"))) {
        rmap_reader_error(lobe->reader, lobe->node,
                          rough ? "a rough surface has the correlation of its roughness, as in "
                                  "'correlation: 10 um', or the width l of its lobe"
                                : "'l' is missing: the sine at which the lobe begins to fall");
        return false;
    }
    copy(lobe, RMAP_SHAPE_L, p->l, 1.0);
    for (int i = 0; i < lobe->n; i++) {
        const double ratio = p->reference > 0.0 ? wavelength_of(lobe, i) / p->reference : 1.0;
        lobe->its->shape[RMAP_SHAPE_L][i] *= ratio;
        lobe->its->amount[i] = p->b0[i] / (ratio * ratio * ratio * ratio);
    }
    return lobe->reader->diagnostics->n_error == before && (!rough || set_roughness(lobe));
}

/* sigma^2 is the power spectrum's integral up to one line per wavelength (Dittman 2006). */
static bool read_k_correlation(struct lobe *lobe)
{
    static const struct rmap_range rising = {1e-3, 20, "positive, up to 20", RMAP_DIMENSION_NONE};
    struct parameters *p = &lobe->parameters;
    if (!has(lobe, "roughness") || !has(lobe, "correlation")) {
        rmap_reader_error(lobe->reader, lobe->node,
                          "a k_correlation model has the roughness, its correlation and the power "
                          "s");
        return false;
    }
    const size_t before = lobe->reader->diagnostics->n_error;
    rmap_reader_quantity(lobe->reader, lobe->node, "s", RMAP_REQUIRED, &rising, p->s);
    if (lobe->reader->diagnostics->n_error != before || !set_roughness(lobe))
        return false;
    copy(lobe, RMAP_SHAPE_S, p->s, 1.0);
    for (int i = 0; i < lobe->n; i++) {
        const double wavelength = wavelength_of(lobe, i), s = p->s[i];
        const double roughness = lobe->its->shape[RMAP_SHAPE_ROUGHNESS][i],
                     correlation = nm_of(lobe, p->correlation) / wavelength;
        const double band = p->reference > 0.0 ? p->reference / wavelength : 1.0;
        const double y = 2.0 * RMAP_PI * correlation / band, grown = log1p(y * y);
        const double share =
            fabs(s - 2.0) < 1e-9 ? 2.0 / grown : (s - 2.0) / -expm1((1.0 - 0.5 * s) * grown);
        const double area = RMAP_PI * roughness * correlation;
        lobe->its->amount[i] = 32.0 * RMAP_PI * area * area * share;
    }
    return true;
}

static bool read_facets(struct lobe *lobe)
{
    static const struct rmap_range alpha = {1e-4, 2, "from 0.0001 to 2", RMAP_DIMENSION_NONE};
    const struct rmap_yaml_node *node = rmap_yaml_get(lobe->node, "alpha");
    double pair[2];
    size_t n = 0;
    const size_t before = lobe->reader->diagnostics->n_error;
    if (node && node->kind == RMAP_YAML_LIST) {
        (void)rmap_reader_numbers(lobe->reader, lobe->node, "alpha", RMAP_REQUIRED, &alpha, 2, 2,
                                  pair, &n);
        for (int i = 0; i < lobe->n && n == 2; i++)
            for (int k = 0; k < 2; k++)
                lobe->its->shape[RMAP_SHAPE_ALPHA_X + k][i] = pair[k];
    } else {
        rmap_reader_quantity(lobe->reader, lobe->node, "alpha", RMAP_REQUIRED, &alpha,
                             lobe->its->shape[RMAP_SHAPE_ALPHA_X]);
        copy(lobe, RMAP_SHAPE_ALPHA_Y, lobe->its->shape[RMAP_SHAPE_ALPHA_X], 1.0);
    }
    return lobe->reader->diagnostics->n_error == before;
}

static bool read_slope_error(struct lobe *lobe)
{
    const struct parameters *p = &lobe->parameters;
    const bool pillbox = has(lobe, "pillbox");
    if (pillbox == has(lobe, "gaussian")) {
        rmap_reader_error(lobe->reader, lobe->node,
                          "a slope error is 'gaussian: 2 mrad', its rms along each axis, or "
                          "'pillbox: 4 mrad', the most that it is");
        return false;
    }
    for (int i = 0; i < lobe->n; i++) {
        lobe->its->shape[RMAP_SHAPE_ALPHA_X][i] = pillbox ? p->pillbox : sqrt(2.0) * p->gaussian;
        lobe->its->shape[RMAP_SHAPE_ALPHA_Y][i] = lobe->its->shape[RMAP_SHAPE_ALPHA_X][i];
        lobe->its->shape[RMAP_SHAPE_PILLBOX][i] = pillbox ? 1.0 : 0.0;
    }
    return true;
}

static bool read_unified(struct lobe *lobe)
{
    const struct parameters *p = &lobe->parameters;
    const bool smooth = !has(lobe, "sigma_alpha");
    copy(lobe, RMAP_SHAPE_SIGMA, p->sigma_alpha, RMAP_PI / 180.0);
    copy(lobe, RMAP_SHAPE_SPIKE, p->spike, 1.0);
    copy(lobe, RMAP_SHAPE_LOBE, p->lobe, 1.0);
    copy(lobe, RMAP_SHAPE_BACK, p->back, 1.0);
    for (int i = 0; i < lobe->n; i++) {
        const double sum = p->spike[i] + p->lobe[i] + p->back[i];
        if (smooth)
            lobe->its->shape[RMAP_SHAPE_SIGMA][i] = 1e-5;
        if (sum > 1.0 + 1e-9) {
            rmap_reader_error(lobe->reader, lobe->node,
                              "spike, lobe and back sum to %.9g: what is left of 1 is Lambert's",
                              sum);
            return false;
        }
        if (smooth && p->lobe[i] > 0.0) {
            rmap_reader_error(lobe->reader, lobe->node,
                              "'sigma_alpha' is missing: the spread of the facets, in degrees");
            return false;
        }
    }
    return true;
}

/* Vendors' files that are not public are refused by what they are called. */
static bool is_closed(const struct lobe *lobe, const char *name)
{
    static const char *const ending[] = {".anisotropicbsdf", ".brdf", ".scattering", ".sop",
                                         ".bsdf180"};
    const size_t len = name ? strlen(name) : 0;
    for (size_t i = 0; i < RMAP_COUNT(ending); i++) {
        const size_t n = strlen(ending[i]);
        if (len < n || strcmp(name + len - n, ending[i]) != 0)
            continue;
        rmap_reader_error(lobe->reader, rmap_yaml_get(lobe->node, "file"),
                          "'%.100s' is of a format that its vendor has not made public: export the "
                          "data as CSV (model table) or as Klems XML (model klems)",
                          name);
        return true;
    }
    return false;
}

/* WINDOW's outside is the object's front, which the file's Back is of. */
static void warn_missing(const struct lobe *lobe, const struct rmap_yaml_node *at)
{
    static const char *const block[2] = {"Front", "Back"}, *const side[2] = {"back", "front"};
    for (int s = 0; s < 2; s++)
        if (!lobe->its->table->block[s].value)
            rmap_reader_warn(lobe->reader, at,
                             "%.100s has no %s %s: light that meets the object's %s %s there",
                             at->text, lobe->passes ? "Transmission" : "Reflection", block[s],
                             side[s], lobe->passes ? "does not pass" : "is not reflected");
}

static bool read_file(struct lobe *lobe)
{
    static const struct rmap_text_kind csv = {"a table", "text", "", (size_t)64 << 20},
                                       xml = {"a Klems matrix", "XML", "", (size_t)64 << 20};
    struct rmap_reader *reader = lobe->reader;
    const bool klems = lobe->its->model == RMAP_SCATTER_KLEMS;
    const struct rmap_bsdf_wanted wanted = {&reader->scene->channels, lobe->passes,
                                            lobe->parameters.band == SOLAR};
    const struct rmap_yaml_node *at = rmap_yaml_get(lobe->node, "file");
    struct rmap_error why;
    size_t nbytes = 0;
    double theta;
    if (at && at->kind == RMAP_YAML_SCALAR && is_closed(lobe, at->text))
        return false;
    const char *text = rmap_reader_file(reader, lobe->node, "file", klems ? &xml : &csv, &nbytes);
    if (!text)
        return false;
    const size_t len = strlen(at->text);
    const bool zemax = len > 5 && strcasecmp(at->text + len - 5, ".bsdf") == 0;
    const enum rmap_status st =
        (klems   ? rmap_bsdf_klems_read
         : zemax ? rmap_bsdf_zemax_read
                 : rmap_bsdf_csv_read)(text, nbytes, &wanted, &lobe->its->table, &why);
    if (st == RMAP_SYSTEM) {
        reader->failure = why;
        rmap_reader_fail(reader, st);
    } else if (st != RMAP_OK) {
        rmap_reader_error(reader, at, "%.100s: %s", at->text, why.text);
    }
    if (st != RMAP_OK)
        return false;
    warn_missing(lobe, at);
    lobe->its->by_wavelength = lobe->its->table->n_band > 1;
    for (int i = 0; i < lobe->n; i++)
        lobe->its->amount[i] = 1.0;
    const double most = rmap_scatter_table_finish(lobe->its->table, lobe->passes, &theta);
    if (!(most > 1.0 + 1e-3))
        return true;
    rmap_reader_error(
        reader, at,
        "%.100s scatters %.6g of the light at %g degrees: more than 1; its values are "
        "to be 1/sr (a radiance factor is pi times that)",
        at->text, most, theta);
    return false;
}

static void set_by_wavelength(struct rmap_scatter *its, int n_channel)
{
    rmap_scatter_derive(its, n_channel);
    for (int k = 0; k < RMAP_SHAPE_MAX; k++)
        for (int i = 1; i < n_channel; i++)
            its->by_wavelength = its->by_wavelength || its->shape[k][i] != its->shape[k][0];
}

void rmap_scatter_set_amount(struct rmap_scatter *its, int n_channel, const double *share)
{
    for (int i = 0; i < n_channel; i++) {
        const double sigma = its->shape[RMAP_SHAPE_SIGMA][i];
        double whole = RMAP_PI;
        if (its->model == RMAP_SCATTER_COSINE)
            whole = 2.0 * RMAP_PI / (its->shape[RMAP_SHAPE_POWER][i] + 2.0);
        else if (its->model != RMAP_SCATTER_LAMBERT)
            whole = 2.0 * RMAP_PI * sigma * sigma;
        its->amount[i] = share[i] / whole;
        if (its->model == RMAP_SCATTER_OREN_NAYAR)
            rmap_rough_diffuse(its->shape[RMAP_SHAPE_R][i], share[i], &its->amount[i],
                               &its->shape[RMAP_SHAPE_SEVERAL][i]);
    }
    set_by_wavelength(its, n_channel);
}

bool rmap_scatter_is_shape_alone(enum rmap_scatter_model model)
{
    return model == RMAP_SCATTER_LAMBERT || model == RMAP_SCATTER_GAUSSIAN ||
           model == RMAP_SCATTER_COSINE || model == RMAP_SCATTER_RETRO ||
           model == RMAP_SCATTER_OREN_NAYAR;
}

/* area: 1 ft2, or 0.1 m2 */
static bool read_area(struct lobe *lobe, double *um2)
{
    static const double square_foot = 0.09290304; /* m2 */
    const struct rmap_yaml_node *node = rmap_yaml_get(lobe->node, "area");
    const char *unit = "ft2";
    double value = 1.0;
    if (node &&
        (node->kind != RMAP_YAML_SCALAR || !rmap_reader_parse_quantity(node->text, &value, &unit) ||
         (strcmp(unit, "ft2") != 0 && strcmp(unit, "m2") != 0) ||
         !(value >= 1e-6 && value <= 1e6))) {
        rmap_reader_error(lobe->reader, node,
                          "'area' must be one that particles are counted on, as in '1 ft2' or "
                          "'0.1 m2'");
        return false;
    }
    *um2 = value * 1e12 * (strcmp(unit, "ft2") == 0 ? square_foot : 1.0);
    return true;
}

static bool read_dust(struct lobe *lobe)
{
    struct rmap_dust_kind *kind = &lobe->parameters.dust;
    struct rmap_reader *reader = lobe->reader;
    if (!read_area(lobe, &kind->area_um2))
        return false;
    if (rmap_scatter_set_dust(lobe->its, kind, &reader->scene->channels, reader->scene->scatter,
                              reader->scene->n_scatter - 1, &reader->failure) == RMAP_OK)
        return true;
    rmap_reader_fail(reader, RMAP_SYSTEM);
    return false;
}

static bool read_model(struct lobe *lobe)
{
    const struct parameters *p = &lobe->parameters;
    switch (lobe->its->model) {
    case RMAP_SCATTER_LAMBERT:
        break;
    case RMAP_SCATTER_GAUSSIAN:
    case RMAP_SCATTER_RETRO:
        copy(lobe, RMAP_SHAPE_SIGMA, p->sigma, 1.0);
        break;
    case RMAP_SCATTER_COSINE:
        copy(lobe, RMAP_SHAPE_POWER, p->power, 1.0);
        break;
    case RMAP_SCATTER_OREN_NAYAR:
        copy(lobe, RMAP_SHAPE_R, p->r, 1.0);
        break;
    case RMAP_SCATTER_ABG:
        copy(lobe, RMAP_SHAPE_B, p->b, 1.0);
        copy(lobe, RMAP_SHAPE_G, p->g, 1.0);
        memcpy(lobe->its->amount, p->a, sizeof p->a);
        break;
    case RMAP_SCATTER_HARVEY:
        return read_harvey(lobe);
    case RMAP_SCATTER_K_CORRELATION:
        return read_k_correlation(lobe);
    case RMAP_SCATTER_GGX:
    case RMAP_SCATTER_BECKMANN:
        return read_facets(lobe);
    case RMAP_SCATTER_SLOPE_ERROR:
        return read_slope_error(lobe);
    case RMAP_SCATTER_UNIFIED:
        return read_unified(lobe);
    case RMAP_SCATTER_TABLE:
    case RMAP_SCATTER_KLEMS:
        return read_file(lobe);
    case RMAP_SCATTER_CONTAMINATION:
        return read_dust(lobe);
    case RMAP_SCATTER_COUNT:
        break;
    }
    if (rmap_scatter_is_shape_alone(lobe->its->model))
        rmap_scatter_set_amount(lobe->its, lobe->n, p->tis);
    return true;
}

bool rmap_reader_read_model(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const char *key, bool passes, struct rmap_model_read *read)
{
    static const char names[] =
#define ROW(number, symbol, name, keys, reciprocal) name " "
        RMAP_SCATTER_TABLE(ROW);
#undef ROW
    const struct rmap_yaml_node *at = rmap_yaml_get(node, key);
    struct rmap_scene *scene = reader->scene;
    int model = -1;
    struct lobe lobe = {.reader = reader, .node = at, .n = scene->channels.n, .passes = passes};
    if (at->kind != RMAP_YAML_MAP) {
        rmap_reader_error(reader, at, "'%s' must be a mapping, as in {model: lambert}", key);
        return false;
    }
    if (strcmp(key, rmap_scatter_name[RMAP_SCATTER_CONTAMINATION].name) == 0)
        model = RMAP_SCATTER_CONTAMINATION;
    else if (!rmap_reader_choice(reader, at, "model", RMAP_REQUIRED, names, &model))
        return false;
    for (int i = 0; i < lobe.n; i++) {
        lobe.parameters.dust.n[i] = 1.53;
        lobe.parameters.dust.k[i] = 1e-3;
    }
    if (model < 0 || !rmap_reader_known(reader, at, &rmap_scatter_keys, model) ||
        !rmap_reader_fill(reader, at, &rmap_scatter_keys, model, &lobe.parameters))
        return false;
    lobe.its = RMAP_READER_NEW(reader, scene->scatter, scene->n_scatter, reader->cap_scatter);
    if (!lobe.its)
        return false;
    lobe.its->model = (enum rmap_scatter_model)model;
    if (!read_model(&lobe))
        return false;
    set_by_wavelength(lobe.its, lobe.n);
    *read = (struct rmap_model_read){at, lobe.its, lobe.parameters.relative, has(&lobe, "tis")};
    return true;
}
