/* SPDX-License-Identifier: MIT
 *
 * Gradient media: `gradient:` of a medium.
 */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "gradient/field_made.h"
#include "io/scene/scene_field.h"
#include "io/scene/scene_glass.h"
#include "io/scene/scene_media.h"
#include "io/scene/scene_placement.h"
#include "io/scene/scene_quantity.h"
#include "optics/spectrum.h"
#include "scene/bounds.h"

/* Values of the keys of gradient media: numbers on the channels, alone, in structures, in lists. */

/* A number on the channels: itself, or {wavelength: [..], value: [..]}, which in rgb mode counts
 * at the wavelength of the indices. *good: false after a complaint. */
static void reader_channel_values(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                  const char *what, const struct rmap_range *range, double *value,
                                  bool *good)
{
    const struct rmap_channels *channels = &reader->scene->channels;
    double *column[2], number = 0;
    size_t n = 0;
    if (node->kind != RMAP_YAML_MAP) {
        *good = rmap_reader_scalar(reader, node, what, range, &number);
        for (int c = 0; *good && c < channels->n; c++)
            value[c] = number;
        return;
    }
    rmap_reader_table(reader, node, "wavelength value", 2, range, &n, column);
    *good = n > 0;
    const struct rmap_table1 table = {n, column[0], column[1]};
    for (int c = 0; *good && c < channels->n; c++)
        value[c] = rmap_table1_at(&table, channels->wavelength_nm[c]);
}

void rmap_reader_parameters(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const struct rmap_field_parameter *parameter, size_t width,
                            double *value, bool *good)
{
    const int n = reader->scene->channels.n;
    *good = true;
    for (size_t k = 0; k < width; k++) {
        const struct rmap_yaml_node *at = rmap_yaml_get(node, parameter[k].name);
        double on_channel[RMAP_CHANNEL_MAX];
        char what[80];
        bool fine = true;
        (void)snprintf(what, sizeof what, "'%s'", parameter[k].name);
        for (int c = 0; c < n; c++)
            on_channel[c] = parameter[k].otherwise;
        if (at)
            reader_channel_values(reader, at, what, &rmap_range_any, on_channel, &fine);
        else if (isnan(parameter[k].otherwise)) {
            rmap_reader_error(reader, node, "'%s' is missing: add it", parameter[k].name);
            fine = false;
        }
        *good &= fine;
        for (int c = 0; fine && c < n; c++)
            value[(size_t)c * width + k] = on_channel[c];
    }
}

void rmap_reader_channel_list(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                              const char *key, size_t n_max, size_t *width_ret, double **value_ret)
{
    const struct rmap_yaml_node *list = rmap_yaml_get(map, key);
    const size_t n = (size_t)reader->scene->channels.n;
    char what[80];
    bool good = true;
    (void)snprintf(what, sizeof what, "'%s'", key);
    *value_ret = NULL;
    if (!list || list->kind != RMAP_YAML_LIST || !list->n_item || list->n_item > n_max) {
        rmap_reader_error(reader, list ? list : map, "%s must be a list of 1 to %zu numbers", what,
                          n_max);
        return;
    }
    double *value = rmap_reader_alloc(reader, list->n_item * n, sizeof *value);
    if (!value)
        return;
    for (size_t k = 0; k < list->n_item; k++) {
        double on_channel[RMAP_CHANNEL_MAX] = {0};
        bool fine = true;
        reader_channel_values(reader, list->item[k].value, what, &rmap_range_any, on_channel,
                              &fine);
        good &= fine;
        for (size_t c = 0; c < n; c++)
            value[c * list->n_item + k] = on_channel[c];
    }
    *width_ret = list->n_item;
    *value_ret = good ? value : NULL;
}

int rmap_reader_distinct(const struct rmap_reader *reader, const double *value, size_t width)
{
    const int n = reader->scene->channels.n;
    for (int c = 1; c < n; c++)
        if (memcmp(value + (size_t)c * width, value, width * sizeof *value) != 0)
            return n;
    return 1;
}

int rmap_reader_distinct_wavelengths(const struct rmap_reader *reader)
{
    return rmap_reader_distinct(reader, reader->scene->channels.wavelength_nm, 1);
}

/* `dispersion:` of a gradient medium: a model that holds at one wavelength follows a glass, a
 * formula or a table at the others. */

enum { ADDITIVE, REFRACTIVITY, MULTIPLICATIVE };

/* An index over wavelength, of one kind. */
struct dispersion {
    struct rmap_glass glass;
    struct rmap_table1 table; /* n > 0: this, else the glass */
};

static double index_at(const struct dispersion *of, double nm)
{
    return of->table.n ? rmap_table1_at(&of->table, nm) : rmap_glass_index(&of->glass, nm);
}

/* A little beside a wavelength, by a share of it: of a table along its spline. */
static double index_beside(const struct dispersion *of, double nm, double share)
{
    if (of->table.n == 0)
        return index_at(of, nm * (1 + share));
    return index_at(of, nm) + rmap_table1_slope(&of->table, nm) * nm * share;
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
    else if (table)
        read_index_table(reader, table, of, good);
    else if (formula)
        *good = rmap_reader_sellmeier(reader, formula, 1, &of->glass);
    else
        *good = rmap_reader_material(reader, node, "glass", &of->glass);
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

/* `dispersion:` of a medium's gradient, put on top of its field. */
static void reader_disperse(struct rmap_reader *reader, const struct rmap_yaml_node *node,
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
    good &= rmap_reader_number(reader, said, "reference", RMAP_OPTIONAL, &rmap_range_wavelength,
                               &reference);
    good &= rmap_reader_choice(reader, said, "mode", RMAP_OPTIONAL,
                               "additive refractivity multiplicative", &mode);
    if (!good || !*field)
        return;
    double n_reference = index_at(&of, reference);
    for (int c = 0; c < channels->n && good; c++) {
        const double nm = channels->wavelength_nm[c] / (1 + reader->beside);
        dispersed[c] = on_channel(mode, index_beside(&of, nm, reader->beside), n_reference);
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

/* ---- a field of any model ---- */

enum { N_TYPE_MAX = 48, N_KEY_MAX = 48 };

static const char *const placement_key[] = {"type", "at", "rotate", "scale", "matrix"};
#define LENGTH(member)                                                                             \
    RMAP_KEY_NUMBER, offsetof(struct rmap_curve_options, member), &rmap_range_positive_length
#define SHARMA .types = RMAP_TYPE(RMAP_SCHEME_SHARMA)
static const char *const scheme_word[] = {"adaptive", "sharma", "fixed", "integrated"};
static const struct rmap_range max_steps = {1, UINT32_MAX, NULL};
#define CURVE                                                                                      \
    "frame scheme tolerance sag polyline step_min step_max step step_amplitude max_steps "         \
    "dispersion"
const struct rmap_mapping rmap_curve_keys = {
    "gradient media",
    NULL,
    {{NULL, CURVE}, {NULL, CURVE}, {NULL, CURVE}, {NULL, CURVE}},
    {{"tolerance", LENGTH(tolerance)},
     {"sag", LENGTH(sag)},
     {"polyline", LENGTH(polyline)},
     {"step_min", LENGTH(step_min), SHARMA},
     {"step_max", LENGTH(step_max), SHARMA},
     {"step_amplitude", RMAP_KEY_NUMBER, offsetof(struct rmap_curve_options, amplitude),
      &rmap_range_positive, SHARMA},
     {"step", LENGTH(step), .types = RMAP_TYPE(RMAP_SCHEME_SHARMA_FIXED)},
     {"max_steps", RMAP_KEY_WHOLE, offsetof(struct rmap_curve_options, max_steps), &max_steps}}};
#undef LENGTH
#undef SHARMA

static const struct rmap_field_model *model_at(size_t i)
{
    const struct rmap_field_model *(*const kind[])(size_t) = {
        rmap_field_model_analytic, rmap_field_model_made, rmap_field_model_from_file};
    for (size_t k = 0; k < RMAP_COUNT(kind); k++) {
        size_t n = 0;
        while (kind[k](n) && n < i)
            n++;
        if (kind[k](n))
            return kind[k](n);
        i -= n;
    }
    return NULL;
}

static const struct rmap_field_model *choose_model(struct rmap_reader *reader,
                                                   const struct rmap_yaml_node *node)
{
    const char *word[N_TYPE_MAX];
    size_t n = 0;
    int choice = 0;
    for (const struct rmap_field_model *m; n < N_TYPE_MAX && (m = model_at(n)) != NULL; n++)
        word[n] = m->type;
    if (!rmap_reader_one_of(reader, node, "type", RMAP_REQUIRED, word, n, &choice))
        return NULL;
    return model_at((size_t)choice);
}

static void check_keys(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const struct rmap_field_model *model, const struct rmap_field_place *place)
{
    const char *key[N_KEY_MAX];
    struct rmap_words whole;
    char what[80];
    size_t n = 0;
    for (size_t i = 0; i < RMAP_FIELD_KEY_MAX && model->parameter[i].name; i++)
        key[n++] = model->parameter[i].name;
    for (size_t i = 0; i < RMAP_FIELD_KEY_MAX && model->key[i]; i++)
        key[n++] = model->key[i];
    for (size_t i = 0; i < RMAP_COUNT(placement_key); i++)
        key[n++] = placement_key[i];
    rmap_words_split(CURVE, &whole);
    for (size_t i = 0; place->whole && i < whole.n; i++)
        key[n++] = whole.word[i];
    if (place->weighted)
        key[n++] = "weight";
    (void)snprintf(what, sizeof what, "a gradient of type %s", model->type);
    (void)rmap_reader_check_keys(reader, node, what, key, n);
}

static void make_of_parameters(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                               const struct rmap_field_model *model, struct rmap_field **field_ret)
{
    double value[RMAP_CHANNEL_MAX * RMAP_FIELD_KEY_MAX] = {0};
    size_t width = 0;
    bool good = true;
    while (width < RMAP_FIELD_KEY_MAX && model->parameter[width].name)
        width++;
    rmap_reader_parameters(reader, node, model->parameter, width, value, &good);
    if (good)
        rmap_reader_made(reader, node,
                         model->make(field_ret, rmap_reader_distinct(reader, value, width), value,
                                     &reader->failure));
}

/* A part of a field stands in the frame of the whole. */
static void place_part(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_field **field)
{
    struct rmap_affine placement, to_local;
    struct rmap_field *of = *field;
    bool moved = false;
    for (size_t i = 1; i < RMAP_COUNT(placement_key); i++)
        moved |= rmap_yaml_get(node, placement_key[i]) != NULL;
    if (!moved || !rmap_reader_placement(reader, node, &placement) || !of ||
        !rmap_affine_invert(&placement, &to_local))
        return;
    *field = NULL;
    rmap_reader_made(reader, node, rmap_field_placed(field, of, &to_local, &reader->failure));
}

void rmap_reader_field(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const struct rmap_field_place *place, struct rmap_field **field_ret)
{
    *field_ret = NULL;
    if (node->kind != RMAP_YAML_MAP) {
        rmap_reader_error(reader, node,
                          "a gradient must be a mapping, as in {type: luneburg, ...}");
        return;
    }
    const struct rmap_field_model *model = choose_model(reader, node);
    if (!model)
        return;
    check_keys(reader, node, model, place);
    if (model->read)
        model->read(reader, node, place, field_ret);
    else
        make_of_parameters(reader, node, model, field_ret);
    if (!place->whole)
        place_part(reader, node, field_ret);
}

/* ---- how light is traced through it ---- */

static void read_options(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                         struct rmap_curve_options *options)
{
    int choice = 0;
    (void)rmap_reader_one_of(reader, node, "scheme", RMAP_OPTIONAL, scheme_word,
                             RMAP_COUNT(scheme_word), &choice);
    options->scheme = (enum rmap_scheme)choice;
    for (size_t i = 0; i < RMAP_COUNT(rmap_curve_keys.key) && rmap_curve_keys.key[i].name; i++) {
        const struct rmap_yaml_node *at = rmap_yaml_get(node, rmap_curve_keys.key[i].name);
        const unsigned types = rmap_curve_keys.key[i].types;
        if (at && types && !(types >> choice & 1))
            rmap_reader_error(reader, at, "'%s' is for 'scheme: %s': the scheme here is %s",
                              rmap_curve_keys.key[i].name, scheme_word[__builtin_ctz(types)],
                              scheme_word[choice]);
    }
    (void)rmap_reader_fill(reader, node, &rmap_curve_keys, choice, options);
    if (options->step_min > 0 && options->step_max > 0 && options->step_min > options->step_max)
        rmap_reader_error(reader, rmap_yaml_get(node, "step_min"),
                          "'step_min' must not be above 'step_max'");
}

static void add_frame(struct rmap_reader *reader, const struct rmap_yaml_node *node, int32_t medium)
{
    struct rmap_medium_frame *frame =
        RMAP_READER_NEW(reader, reader->frame, reader->n_frame, reader->cap_frame);
    if (!frame)
        return;
    *frame = (struct rmap_medium_frame){
        .medium = medium, .node = node, .first = -1, .first_object = -1, .other_object = -1};
    (void)rmap_reader_placement(reader, node, &frame->placement);
    const char *name = rmap_reader_text(reader, node, "frame", RMAP_OPTIONAL);
    if (name && strcmp(name, "world") == 0)
        frame->kind = RMAP_FRAME_WORLD;
    else if (name && strcmp(name, "object") != 0)
        frame->kind = RMAP_FRAME_NAMED;
}

/* ---- the medium ---- */

/* Indices for reports: those at the origin of the frame, where there is one. */
static void report_index(struct rmap_reader *reader, const struct rmap_affine *placement,
                         struct rmap_medium *medium)
{
    const int n_channel = reader->scene->channels.n;
    struct rmap_affine to_field = rmap_affine_identity();
    char text[120];
    bool known = true;
    (void)rmap_affine_invert(placement, &to_field);
    for (int c = 0; c < n_channel; c++) {
        double n = 1;
        struct rmap_vec3 slope;
        known &= rmap_field_at(medium->field, c, to_field.t, &n, &slope);
        medium->n[c] = known ? n : 1;
        const struct rmap_gradient there = {.field = medium->field,
                                            .beside = medium->beside[1] ? medium->beside : NULL,
                                            .to_local = rmap_affine_identity()};
        medium->n_group[c] = rmap_gradient_group(&there, c, to_field.t, medium->n[c]);
    }
    if (known)
        (void)snprintf(text, sizeof text, "gradient %s, index %.9g at the origin of its frame",
                       medium->field->ops->model, medium->n[0]);
    else
        (void)snprintf(text, sizeof text,
                       "gradient %s, without an index at the origin of its frame",
                       medium->field->ops->model);
    rmap_free(medium->description);
    medium->description = rmap_reader_strdup(reader, text);
}

void rmap_reader_gradient(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          int32_t medium_index)
{
    if (node->kind == RMAP_YAML_MAP)
        read_options(reader, node, &reader->scene->medium[medium_index].curve);
    add_frame(reader, node, medium_index);
}

/* Diagonal of the box about the objects that the medium fills or surrounds, in its frame, about. */
static double size_of(const struct rmap_reader *reader, const struct rmap_medium_frame *frame)
{
    const struct rmap_scene *scene = reader->scene;
    struct rmap_bounds box = rmap_bounds_empty();
    for (size_t o = 0; o < scene->n_object; o++)
        if (scene->object[o].medium_front == frame->medium ||
            scene->object[o].medium_back == frame->medium)
            rmap_bounds_include_geometry(&box, &scene->geometry[scene->object[o].geometry],
                                         &scene->object[o].to_world);
    double scale = cbrt(fabs(rmap_affine_determinant(&frame->placement)));
    double size = rmap_length(rmap_sub(box.upper, box.lower)) / scale;
    return size > 0 && isfinite(size) ? size : 1 / scale;
}

/* Without a word of what the field's first reading has said. */
static void read_beside(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const struct rmap_field_place *place, double share,
                        struct rmap_field **field_ret)
{
    struct rmap_diagnostics *said = reader->diagnostics, unsaid;
    struct rmap_channels *channels = &reader->scene->channels;
    const struct rmap_channels own = *channels;
    rmap_diagnostics_init(&unsaid, NULL);
    reader->diagnostics = &unsaid;
    reader->beside = share;
    for (int c = 0; c < channels->n; c++)
        channels->wavelength_nm[c] *= 1 + share;
    rmap_reader_field(reader, node, place, field_ret);
    reader_disperse(reader, node, field_ret);
    *channels = own;
    reader->beside = 0;
    reader->diagnostics = said;
    rmap_diagnostics_fini(&unsaid);
}

/* What group indices follow from, where the field may be dispersive: one of a single channel does
 * not say. */
static void read_dispersion(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const struct rmap_field_place *place, struct rmap_medium *medium)
{
    const struct rmap_channels *channels = &reader->scene->channels;
    if (!reader->scene->timed || channels->mode == RMAP_COLOUR_RGB ||
        (channels->n > 1 && medium->field->n_channel == 1))
        return;
    for (int k = 0; k < 2; k++)
        read_beside(reader, node, place, k == 0 ? -RMAP_GRADIENT_BESIDE : RMAP_GRADIENT_BESIDE,
                    &medium->beside[k]);
}

void rmap_reader_make_gradients(struct rmap_reader *reader)
{
    for (size_t i = 0; i < reader->n_frame; i++) {
        struct rmap_medium_frame *frame = &reader->frame[i];
        struct rmap_medium *medium = &reader->scene->medium[frame->medium];
        const struct rmap_field_place place = {
            .path = medium->name, .whole = true, .size = size_of(reader, frame)};
        reader->lenient_field = false;
        rmap_reader_field(reader, frame->node, &place, &medium->field);
        frame->lenient = reader->lenient_field;
        reader_disperse(reader, frame->node, &medium->field);
        if (!medium->field)
            continue;
        medium->dispersive = medium->field->n_channel > 1;
        read_dispersion(reader, frame->node, &place, medium);
        report_index(reader, &frame->placement, medium);
    }
}
