/* SPDX-License-Identifier: MIT
 *
 * Media that scatter by more than a coefficient and a mean cosine: phase functions, and suspended
 * spheres.
 */
#include "io/scene/scene_turbid.h"

#include <math.h>

#include "base/alloc.h"
#include "io/scene/phase_csv.h"
#include "io/scene/scene_constants.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_quantity.h"
#include "io/scene/scene_species.h"

static const struct rmap_range cosine = {-0.9999, 0.9999, "a mean cosine, -0.9999 to 0.9999"};

struct scattering {
    double coefficient[RMAP_CHANNEL_MAX];
    double g, reference, haze, thickness;
};
static const struct rmap_range hazy = {0, 0.99, "a share from 0 to 0.99", RMAP_DIMENSION_SHARE};
const struct rmap_mapping rmap_scattering_keys = {
    "media",
    NULL,
    {{"scattering", "coefficient g phase reference haze thickness mie"}},
    {{"coefficient", RMAP_KEY_SHARES, offsetof(struct scattering, coefficient),
      &rmap_range_attenuation},
     {"g", RMAP_KEY_NUMBER, offsetof(struct scattering, g), &cosine},
     {"reference", RMAP_KEY_NUMBER, offsetof(struct scattering, reference), &rmap_range_wavelength},
     {"haze", RMAP_KEY_NUMBER, offsetof(struct scattering, haze), &hazy},
     {"thickness", RMAP_KEY_NUMBER, offsetof(struct scattering, thickness), &rmap_range_size}}};

struct spheres {
    double diameter, sigma, share, density;
};
static const struct rmap_range spread = {1.0, RMAP_SUSPENSION_SIGMA_MAX,
                                         "a geometric standard deviation, from 1 to 4"},
                               crowd = {0.0, 0.6, "a share of the volume, 0 to 0.6",
                                        RMAP_DIMENSION_SHARE};
const struct rmap_mapping rmap_mie_keys = {
    "media",
    NULL,
    {{"mie", "diameter sigma material n k table share density"}},
    {{"diameter", RMAP_KEY_NUMBER, offsetof(struct spheres, diameter), &rmap_range_size,
      .need = RMAP_REQUIRED},
     {"sigma", RMAP_KEY_NUMBER, offsetof(struct spheres, sigma), &spread, 1.0},
     {"share", RMAP_KEY_NUMBER, offsetof(struct spheres, share), &crowd},
     {"density", RMAP_KEY_NUMBER, offsetof(struct spheres, density), &rmap_range_nonnegative}}};

bool rmap_reader_is_scattering(const struct rmap_yaml_node *scattering)
{
    return scattering && scattering->kind == RMAP_YAML_MAP && !rmap_yaml_get(scattering, "rgb") &&
           !rmap_yaml_get(scattering, "wavelength") && !rmap_yaml_get(scattering, "value");
}

/* To nine decimals: the C library's formulas of indices end in other bits on other machines, and
 * directions are drawn from what follows. */
static double rounded(double n)
{
    return floor(n * 1e9 + 0.5) * 1e-9;
}

static void read_mie(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                     struct rmap_medium *medium)
{
    const struct rmap_scene *scene = reader->scene;
    const size_t n = scene->channels.mode == RMAP_COLOUR_RGB ? 1 : (size_t)scene->channels.n;
    struct spheres its = {.share = 0.0};
    struct rmap_constants constants = {.has_glass = false};
    const bool share = rmap_yaml_get(node, "share"), density = rmap_yaml_get(node, "density");
    if (!rmap_reader_known(reader, node, &rmap_mie_keys, 0) ||
        !rmap_reader_fill(reader, node, &rmap_mie_keys, 0, &its) ||
        !rmap_reader_constants(reader, node, "spheres in medium", medium->name, "'mie'",
                               &constants))
        return;
    if (share == density) {
        rmap_reader_error(reader, node,
                          "how many spheres? Give 'share' of the volume, or 'density', their "
                          "number per %s^3",
                          scene->unit);
        return;
    }
    const struct rmap_suspension spheres = {its.diameter, its.sigma};
    medium->phase.kind = RMAP_PHASE_MIE;
    rmap_reader_made(reader, node, rmap_phase_make_room(&medium->phase, n, &reader->failure));
    for (size_t c = 0; c < n && reader->status == RMAP_OK; c++) {
        const double nm = scene->channels.wavelength_nm[c], around = rounded(medium->n[c]),
                     wave = nm * 1e-9 / scene->unit_m / around;
        const struct rmap_suspended *of = &medium->phase.suspended[c];
        if (!(RMAP_PI * rmap_suspension_largest(&spheres) / wave <= 1e4)) {
            rmap_reader_error(reader, rmap_yaml_get(node, "diameter"),
                              "spheres up to %g %s are more than 3000 wavelengths wide: too large "
                              "for 'mie' (is the unit right, as in 0.5 um?)",
                              rmap_suspension_largest(&spheres), scene->unit);
            return;
        }
        rmap_reader_made(reader, node,
                         rmap_phase_add_mie(&spheres, wave,
                                            rounded(rmap_constants_index(&constants, nm)) / around,
                                            rounded(rmap_constants_loss(&constants, nm)) / around,
                                            &medium->phase, &reader->failure));
        const double count = share ? its.share / of->volume : its.density, area = count * of->area,
                     loss = of->mie.extinct - of->mie.scattered;
        const size_t last = n == 1 ? (size_t)scene->channels.n : c + 1;
        for (size_t i = c; i < last; i++) {
            medium->scattering[i] = area * of->mie.scattered;
            medium->absorption[i] += rmap_constants_loss(&constants, nm) > 0.0 ? area * loss : 0.0;
        }
    }
}

/* {angle: [...], value: [...]} or {file: p.csv} */
static void read_table(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_phase *phase)
{
    static const struct rmap_text_kind csv = {"a phase function", "text", "", (size_t)64 << 20};
    const struct rmap_yaml_node *file = rmap_yaml_get(node, "file");
    struct rmap_error why;
    double *column[2];
    size_t n = 0;
    phase->kind = RMAP_PHASE_TABLE;
    if (!file) {
        rmap_reader_table(reader, node, "angle value", 2, &rmap_range_nonnegative, &n, column);
        if (n == 0)
            return;
        rmap_reader_made(reader, node, rmap_phase_make_room(phase, 1, &reader->failure));
        if (reader->status == RMAP_OK)
            rmap_reader_made(
                reader, node,
                rmap_phase_add_table(column[0], column[1], n, phase, &reader->failure));
        return;
    }
    if (!rmap_reader_check_map(reader, node, "a phase function", "file"))
        return;
    const char *text = rmap_reader_file(reader, node, "file", &csv, &n);
    if (!text)
        return;
    const enum rmap_status st = rmap_phase_csv_read(text, n, &reader->scene->channels, phase, &why);
    if (st != RMAP_OK)
        rmap_error_context(&why, "%.100s", file->text);
    reader->failure = why;
    rmap_reader_made(reader, file, st);
}

static void read_phase(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_phase *phase)
{
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "phase");
    int choice = 0;
    if (at->kind == RMAP_YAML_MAP)
        read_table(reader, at, phase);
    else if (rmap_reader_choice(reader, node, "phase", RMAP_REQUIRED, "rayleigh", &choice))
        phase->kind = RMAP_PHASE_RAYLEIGH;
}

/* Light of short waves is scattered by the fourth power more. */
static void scale(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                  struct scattering *its, enum rmap_phase_kind kind)
{
    const struct rmap_channels *channels = &reader->scene->channels;
    if (kind != RMAP_PHASE_RAYLEIGH)
        rmap_reader_error(reader, rmap_yaml_get(node, "reference"),
                          "'reference' is the wavelength of the coefficient of 'phase: rayleigh', "
                          "which goes by its fourth power");
    else if (channels->mode == RMAP_COLOUR_RGB)
        rmap_reader_error(reader, rmap_yaml_get(node, "reference"),
                          "'reference' needs wavelengths: take 'spectrum: {mode: spectral}', or "
                          "leave it out and give 'coefficient: {rgb: [...]}'");
    for (int i = 0; i < channels->n; i++) {
        const double square = its->reference / channels->wavelength_nm[i] * its->reference /
                              channels->wavelength_nm[i];
        its->coefficient[i] *= square * square;
    }
}

/* Of plastics by their makers' data (ASTM D1003): of the light that comes straight through a plate
 * the share that leaves it by more than 2.5 degrees off, in air. Within the medium that is an angle
 * beyond which Henyey and Greenstein scatter the share P at once; what is scattered by less twice
 * stays within it. */
static double coefficient_of_haze(const struct scattering *its, double n)
{
    const double g = its->g, sine = sin(2.5 * RMAP_PI / 180.0) / n, mu = sqrt(1.0 - sine * sine);
    const double beyond = g == 0.0 ? 0.5 * (1.0 + mu)
                                   : (1.0 - g * g) / (2.0 * g) *
                                         (1.0 / sqrt(1.0 + g * g - 2.0 * g * mu) - 1.0 / (1.0 + g));
    return -log1p(-its->haze) / (beyond * its->thickness);
}

static void read_scattering(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            struct rmap_medium *medium)
{
    struct scattering its = {.g = 0.0};
    const struct rmap_yaml_node *mie = rmap_yaml_get(node, "mie");
    if (!rmap_reader_known(reader, node, &rmap_scattering_keys, 0) ||
        !rmap_reader_fill(reader, node, &rmap_scattering_keys, 0, &its))
        return;
    const bool coefficient = rmap_yaml_get(node, "coefficient"), haze = rmap_yaml_get(node, "haze");
    if (mie ? node->n_item > 1 : coefficient == haze) {
        rmap_reader_error(reader, node,
                          "scattering has a 'coefficient' with 'g' or 'phase', or a plate's 'haze' "
                          "with 'thickness' and 'g', or 'mie' alone");
        return;
    }
    if (haze != (rmap_yaml_get(node, "thickness") != NULL) ||
        (haze && (rmap_yaml_get(node, "phase") || !rmap_yaml_get(node, "g")))) {
        rmap_reader_error(reader, node,
                          "'haze' is that of a plate of some 'thickness', by light that is turned "
                          "by a mean cosine 'g' (0.9 where nobody knows)");
        return;
    }
    if (rmap_yaml_get(node, "phase") && rmap_yaml_get(node, "g"))
        rmap_reader_error(reader, rmap_yaml_get(node, "g"),
                          "'g' is the mean cosine of Henyey and Greenstein's phase function: give "
                          "it or 'phase'");
    medium->scattering_g = its.g;
    if (mie)
        read_mie(reader, mie, medium);
    else if (rmap_yaml_get(node, "phase"))
        read_phase(reader, node, &medium->phase);
    if (rmap_yaml_get(node, "reference"))
        scale(reader, node, &its, medium->phase.kind);
    for (int i = 0; i < reader->scene->channels.n; i++) {
        if (!mie)
            medium->scattering[i] =
                haze ? coefficient_of_haze(&its, medium->n[i]) : its.coefficient[i];
        medium->scattering_at_all |= medium->scattering[i] > 0.0;
        medium->absorbing |= medium->absorption[i] > 0.0;
    }
}

void rmap_reader_read_turbid(struct rmap_reader *reader)
{
    const struct rmap_yaml_node *media = rmap_yaml_get(reader->root, "media");
    for (size_t i = 0; media && i < media->n_item; i++) {
        const struct rmap_yaml_node *scattering = rmap_yaml_get(media->item[i].value, "scattering");
        const struct rmap_name *known = rmap_names_find(&reader->media, media->item[i].key);
        if (!known || known->line != media->item[i].line)
            continue;
        struct rmap_medium *medium = &reader->scene->medium[known->index];
        if (rmap_reader_is_scattering(scattering))
            read_scattering(reader, scattering, medium);
        rmap_reader_species(reader, media->item[i].value, medium);
    }
}
