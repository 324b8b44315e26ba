/* SPDX-License-Identifier: MIT
 *
 * Numbers, places, media and sources in the text of a scene.
 */
#include "io/lensfile/lens_write.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "gradient/field_polynomial.h"
#include "io/lensfile/lens_scene.h"
#include "io/lensfile/lens_text.h"

enum { DIGITS_LEAST = 6, DIGITS_MOST = 17 };

void rmap_lens_put_number(FILE *out, double value)
{
    char text[40] = "0";
    for (int digits = DIGITS_LEAST; digits <= DIGITS_MOST && value != 0; digits++) {
        (void)snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    (void)fputs(text, out);
}

static void put_radius(FILE *out, double curvature)
{
    char text[40] = "inf";
    const double last_bits = 2.3e-16;
    for (int digits = DIGITS_LEAST; digits <= DIGITS_MOST && curvature != 0; digits++) {
        (void)snprintf(text, sizeof text, "%.*g", digits, 1 / curvature);
        if (fabs(strtod(text, NULL) * curvature - 1) <= last_bits)
            break;
    }
    (void)fputs(text, out);
}

/* A number, or the two of x and y. */
static void put_pair(FILE *out, const char *key, bool is_pair, double x, double y,
                     void (*put)(FILE *out, double value))
{
    (void)fputs(key, out);
    if (is_pair) {
        (void)fputc('[', out);
        put(out, x);
        (void)fputs(", ", out);
    }
    put(out, y);
    if (is_pair)
        (void)fputc(']', out);
}

static void put_terms(FILE *out, const struct rmap_lens_figure *figure)
{
    static const char *const key[] = {
        [RMAP_TERMS_NONE] = "", [RMAP_TERMS_FRINGE] = "zernike", [RMAP_TERMS_NOLL] = "zernike",
        [RMAP_TERMS_XY] = "xy", [RMAP_TERMS_QCON] = "qcon",      [RMAP_TERMS_QBFS] = "qbfs"};
    const bool is_list = figure->terms == RMAP_TERMS_QCON || figure->terms == RMAP_TERMS_QBFS;
    if (figure->n_term == 0)
        return;
    (void)fprintf(out, ", %s: {norm: ", key[figure->terms]);
    rmap_lens_put_number(out, figure->norm);
    if (figure->terms == RMAP_TERMS_FRINGE || figure->terms == RMAP_TERMS_NOLL)
        (void)fprintf(out, ", order: %s", figure->terms == RMAP_TERMS_NOLL ? "noll" : "fringe");
    (void)fputs(is_list ? ", terms: [" : ", terms: {", out);
    for (int k = 0, at = 0; k < figure->n_term; k++) {
        const struct rmap_lens_term *term = &figure->term[k];
        for (; is_list && at < term->i; at++) /* those that are 0 */
            (void)fputs(at ? ", 0" : "0", out);
        (void)fputs((is_list ? at++ : k) ? ", " : "", out);
        if (figure->terms == RMAP_TERMS_XY)
            (void)fprintf(out, "x%dy%d: ", term->i, term->j);
        else if (!is_list)
            (void)fprintf(out, "%d: ", term->i);
        rmap_lens_put_number(out, term->value);
    }
    (void)fputs(is_list ? "]}" : "}}", out);
}

static void put_asphere(FILE *out, const struct rmap_lens_surface *surface)
{
    const char *before = ", asphere: {";
    for (int i = 1; i <= surface->n_asphere; i++)
        if (surface->asphere[i] != 0) {
            (void)fprintf(out, "%s%d: ", before, i);
            rmap_lens_put_number(out, surface->asphere[i]);
            before = ", ";
        }
    if (surface->n_asphere > 0)
        (void)fputc('}', out);
}

void rmap_lens_put_shape(FILE *out, const struct rmap_lens_surface *surface)
{
    const struct rmap_lens_figure *figure = &surface->figure;
    put_pair(out, "radius: ", figure->is_biconic, figure->curvature_x, surface->curvature,
             put_radius);
    if (surface->conic != 0 || (figure->is_biconic && figure->conic_x != 0))
        put_pair(out, ", conic: ", figure->is_biconic, figure->conic_x, surface->conic,
                 rmap_lens_put_number);
    put_asphere(out, surface);
    if (figure->is_toroid) {
        (void)fputs(", toroid: ", out);
        put_radius(out, isfinite(figure->turn) ? 1 / figure->turn : 0);
    }
    put_terms(out, figure);
    if (figure->is_fresnel)
        (void)fputs(", fresnel: true", out);
}

void rmap_lens_put_outline(FILE *out, const struct rmap_lens_opening *opening)
{
    const bool rectangle = opening->shape == RMAP_OPENING_RECTANGLE;
    const double times = rectangle ? 2 : 1;
    (void)fprintf(out, "{%s: [%.15g, %.15g]", rectangle ? "rectangle" : "ellipse",
                  times * opening->half[0], times * opening->half[1]);
    if (opening->centre[0] != 0 || opening->centre[1] != 0)
        (void)fprintf(out, ", at: [%.15g, %.15g]", opening->centre[0], opening->centre[1]);
    (void)fputc('}', out);
}

/* To 14 digits of the largest: what products of turns leave beyond is no number of the file. */
static void put_three(FILE *out, const char *key, const double value[3])
{
    const double largest = fmax(fabs(value[0]), fmax(fabs(value[1]), fabs(value[2])));
    if (!(largest > 1e-13))
        return;
    (void)fprintf(out, ", %s: [", key);
    for (int k = 0; k < 3; k++)
        (void)fprintf(out, "%s%.14g", k ? ", " : "",
                      fabs(value[k]) < 1e-13 * largest ? 0.0 : value[k]);
    (void)fputc(']', out);
}

void rmap_lens_put_place(FILE *out, const struct rmap_affine *a)
{
    const double degrees = 180 / RMAP_PI;
    const double at[3] = {a->t.x, a->t.y, a->t.z};
    /* About the world's x, then y, then z. */
    const double rotate[3] = {degrees * atan2(a->m[2][1], a->m[2][2]),
                              degrees * atan2(-a->m[2][0], hypot(a->m[2][1], a->m[2][2])),
                              degrees * atan2(a->m[1][0], a->m[0][0])};
    put_three(out, "at", at);
    put_three(out, "rotate", rotate);
}

void rmap_lens_put_words(FILE *out, const char *text)
{
    char words[512];
    rmap_lens_copy(words, sizeof words, text);
    (void)fputs(words, out);
}

/* ---- media ---- */

static void put_sellmeier(FILE *out, const struct rmap_glass *glass)
{
    const bool constant = glass->coefficient[0] != 0;
    for (int part = 0; part < 2; part++) {
        const char *before = "";
        (void)fputs(part ? ", C: [" : "sellmeier: {B: [", out);
        if (constant)
            rmap_lens_put_number(out, part ? 0 : glass->coefficient[0]);
        before = constant ? ", " : "";
        for (size_t i = 1; i + 1 < glass->n_coefficient; i += 2)
            if (glass->coefficient[i] != 0) {
                (void)fputs(before, out);
                rmap_lens_put_number(out, glass->coefficient[i + (size_t)part]);
                before = ", ";
            }
        if (!*before) /* an index of 1 */
            (void)fputs("0", out);
        (void)fputc(']', out);
    }
    (void)fputc('}', out);
}

/* Formulas that scenes do not have: at the wavelengths of the file and between them, every 10 nm.
 */
static void put_table(FILE *out, const struct rmap_prescription *lens,
                      const struct rmap_glass *glass)
{
    enum { MOST = 128 };
    double nm[MOST];
    size_t n = 0;
    double low = HUGE_VAL, high = 0;
    for (size_t i = 0; i < lens->n_wavelength; i++) {
        nm[n++] = lens->wavelength_nm[i];
        low = fmin(low, lens->wavelength_nm[i]);
        high = fmax(high, lens->wavelength_nm[i]);
    }
    const double step = fmax(10, (high - low) / 50);
    for (double at = low + step; glass->formula && at < high && n < MOST; at += step)
        nm[n++] = at;
    for (size_t i = 1; i < n; i++)
        for (size_t k = i; k > 0 && nm[k - 1] > nm[k]; k--) {
            const double swap = nm[k];
            nm[k] = nm[k - 1];
            nm[k - 1] = swap;
        }
    for (int part = 0; part < 2; part++) {
        (void)fputs(part ? ", n: [" : "table: {wavelength: [", out);
        for (size_t i = 0; i < n; i++)
            if (i == 0 || nm[i] > nm[i - 1]) {
                (void)fputs(i ? ", " : "", out);
                rmap_lens_put_number(out, part ? rmap_glass_index(glass, nm[i]) : nm[i]);
            }
        (void)fputc(']', out);
    }
    (void)fputc('}', out);
}

static void put_gradient(FILE *out, const struct rmap_lens_plan *plan,
                         const struct rmap_lens_surface *surface)
{
    const char *before = "";
    (void)fprintf(out, "gradient: {type: zemax, gradient: %d, ", surface->gradient);
    for (size_t e = 0; e < plan->n_element; e++) /* where its surfaces are no lens's rows */
        if (plan->element[e].kind == RMAP_ELEMENT_SURFACE &&
            &plan->lens->surface[plan->row[plan->element[e].first].surface] == surface)
            (void)fprintf(out, "frame: %s, ", plan->element[e].name);
    (void)fputs("parameters: {", out);
    for (int i = 0; i < RMAP_LENS_GRADIENT_MAX; i++) {
        const char *name = rmap_zemax_parameter(surface->gradient, i);
        if (!name)
            break;
        if (i > 0 && surface->gradient_value[i] == 0)
            continue;
        (void)fprintf(out, "%s%s: ", before, name);
        rmap_lens_put_number(out, surface->gradient_value[i]);
        before = ", ";
    }
    (void)fprintf(out, "}}}   # %s of surface %d, the same at all wavelengths\n", surface->type,
                  surface->number);
}

static void put_medium(FILE *out, const struct rmap_lens_plan *plan,
                       const struct rmap_lens_medium *medium)
{
    (void)fprintf(out, "  %s: {", medium->name);
    if (medium->kind == RMAP_LENS_GRADIENT) {
        put_gradient(out, plan, medium->gradient);
        return;
    }
    if (medium->glass.formula == 2)
        put_sellmeier(out, &medium->glass);
    else
        put_table(out, plan->lens, &medium->glass);
    (void)fputc('}', out);
    if (medium->agf && medium->agf->n_row > 0) {
        (void)fprintf(out, "   # of the file, line %zu", medium->agf->line);
    } else if (medium->agf) {
        (void)fprintf(out, "   # formula %d of the catalogue file, line %zu", medium->agf->formula,
                      medium->agf->line);
        if (medium->agf->remark[0]) {
            (void)fputs(": ", out);
            rmap_lens_put_words(out, medium->agf->remark);
        }
    } else {
        (void)fputs("   # '", out);
        rmap_lens_put_words(out, medium->word);
        (void)fprintf(out, "': a model of nd %.7g, Vd %.5g", medium->nd, medium->vd);
    }
    (void)fputc('\n', out);
}

void rmap_lens_put_media(FILE *out, const struct rmap_lens_plan *plan)
{
    const struct rmap_prescription *lens = plan->lens;
    (void)fputs("media:\n  air: {index: 1}   # indices of lens files are relative to air", out);
    if (isfinite(lens->temperature_c) && isfinite(lens->pressure_atm))
        (void)fprintf(out, " (of the file: %g C, %.4g atm)", lens->temperature_c,
                      lens->pressure_atm);
    (void)fputs(", and so are those of all glasses here\n", out);
    for (size_t i = 1; i < plan->media.n; i++)
        if (plan->media.medium[i].kind != RMAP_LENS_CATALOGUE)
            put_medium(out, plan, &plan->media.medium[i]);
}

/* ---- sources ---- */

/* Of a field. */
static struct rmap_vec3 pupil_of(const struct rmap_lens_plan *plan, size_t field)
{
    return rmap_vec3(plan->aim[field][0], plan->aim[field][1],
                     isfinite(plan->order.entrance) ? plan->order.entrance : 0);
}

/* Whether a large image stands before the pupil in a beam along d, as a mirror's does; *along:
 * where from the pupil. */
static bool is_hidden(const struct rmap_lens_plan *plan, size_t field, struct rmap_vec3 d,
                      double *along)
{
    const struct rmap_vec3 image = plan->place[plan->lens->n_surface - 1].to_world.t;
    const struct rmap_vec3 to_image = rmap_sub(image, pupil_of(plan, field));
    const double radius = 0.5 * plan->order.entrance_diameter, much = 0.3;
    *along = rmap_dot(to_image, d);
    return -*along > radius && plan->image_half > much * radius &&
           rmap_length(rmap_axpy(-*along, d, to_image)) < radius + plan->image_half;
}

const struct rmap_lens_element *rmap_lens_filled(const struct rmap_lens_plan *plan)
{
    const struct rmap_lens_element *first = plan->element;
    const struct rmap_affine *a = &first->to_world;
    const size_t i = plan->row[first->first].surface;
    const bool upright = fabs(a->m[2][2] - 1) < 1e-12 && fabs(a->m[0][0] - 1) < 1e-12;
    const bool on_axis = hypot(a->t.x, a->t.y) == 0;
    double along = 0;
    for (size_t f = 0; f <= plan->lens->n_field; f++)
        if (plan->aim[f][0] != 0 || plan->aim[f][1] != 0)
            return NULL;
    if (is_hidden(plan, 0, rmap_vec3(0, 0, 1), &along) ||
        rmap_lens_is_outline(&plan->lens->surface[i].aperture))
        return NULL;
    return upright && on_axis && !plan->place[i].backwards && !isfinite(plan->order.object) ? first
                                                                                            : NULL;
}

static void put_vector(FILE *out, const char *key, struct rmap_vec3 v)
{
    (void)fprintf(out, ", %s: [%.15g, %.15g, %.15g]", key, v.x, v.y, v.z);
}

/* A parallel beam through the entrance pupil, from before everything but an image that it would
 * have to go through. */
static void put_beam(FILE *out, const struct rmap_lens_plan *plan, size_t field, const double xy[2],
                     bool *behind_image)
{
    double before = 0, along = 0;
    const struct rmap_vec3 d = rmap_normalize(rmap_vec3(xy[0], xy[1], 1));
    const struct rmap_vec3 pupil = pupil_of(plan, field);
    for (size_t i = 1; i < plan->lens->n_surface; i++)
        before = fmax(before, rmap_length(plan->place[i].to_world.t) + plan->place[i].semi);
    before = fmax(before, fabs(pupil.z));
    *behind_image = is_hidden(plan, field, d, &along);
    (void)fprintf(out, "type: collimated, shape: {disc: %.6g}",
                  0.525 * plan->order.entrance_diameter);
    put_vector(out, "at", rmap_axpy(*behind_image ? 0.8 * along : -2 * before, d, pupil));
    put_vector(out, "direction", d);
}

static void put_point(FILE *out, const struct rmap_lens_plan *plan, size_t field,
                      const double xy[2])
{
    const struct rmap_first_order *o = &plan->order;
    const struct rmap_vec3 at = rmap_vec3(xy[0] + 0.0, xy[1] + 0.0, -o->object); /* no -0 */
    const double radius = 0.525 * o->entrance_diameter, degrees = 180 / RMAP_PI, telecentric = 10;
    struct rmap_vec3 d = rmap_vec3(0, 0, 1);
    double half = plan->lens->pupil == RMAP_PUPIL_OBJECT_NA && plan->lens->pupil_value < 1
                      ? 1.05 * degrees * asin(plan->lens->pupil_value)
                      : telecentric;
    if (isfinite(o->entrance) && o->entrance + o->object != 0) { /* not in the pupil itself */
        d = rmap_sub(pupil_of(plan, field), at);
        half = degrees * atan(radius / fabs(d.z));
        d = rmap_scale(rmap_normalize(d), d.z < 0 ? -1 : 1);
    }
    (void)fputs("type: point", out);
    put_vector(out, "at", at);
    put_vector(out, "direction", d);
    (void)fprintf(out, ", distribution: {cone: %.6g}", fmax(1e-5, fmin(half, 89)));
}

static void put_spectrum(FILE *out, const struct rmap_prescription *lens, bool again)
{
    if (again) {
        (void)fputs(", spectrum: *light", out);
        return;
    }
    (void)fputs(", spectrum: &light {lines: {", out);
    double most = 0;
    for (size_t i = 0; i < lens->n_wavelength; i++)
        most = fmax(most, lens->wavelength_weight[i]);
    for (size_t i = 0; i < lens->n_wavelength; i++) {
        (void)fputs(i ? ", " : "", out);
        rmap_lens_put_number(out, lens->wavelength_nm[i]);
        (void)fprintf(out, ": %.6g", most > 0 ? fmax(lens->wavelength_weight[i], 0) : 1.0);
    }
    (void)fputs("}}", out);
}

static void put_field(FILE *out, const struct rmap_lens_plan *plan, size_t k)
{
    static const char *const what[] = {
        [RMAP_FIELD_ANGLE] = "deg",
        [RMAP_FIELD_OBJECT_HEIGHT] = "of the object's height",
        [RMAP_FIELD_IMAGE_HEIGHT] = "of the image's height (first order)",
        [RMAP_FIELD_REAL_HEIGHT] = "of the image's real height, taken to first order"};
    const struct rmap_lens_field *field = &plan->lens->field[k];
    const struct rmap_lens_element *filled = rmap_lens_filled(plan);
    const double degrees = 180 / RMAP_PI;
    double xy[2];
    bool behind_image = false;
    rmap_lens_field_at(plan, field, xy);
    (void)fprintf(out, "  - {name: field_%zu, ", k + 1);
    if (filled) {
        (void)fprintf(out, "type: collimated, fills: %s", filled->name);
        if (xy[0] != 0)
            (void)fprintf(out, ", field: [%.12g, %.12g]", degrees * atan(xy[0]),
                          degrees * atan(xy[1]));
        else if (xy[1] != 0)
            (void)fprintf(out, ", field: %.12g", degrees * atan(xy[1]));
    } else if (isfinite(plan->order.object)) {
        put_point(out, plan, k, xy);
    } else {
        put_beam(out, plan, k, xy, &behind_image);
    }
    if (field->weight != 1 && field->weight > 0)
        (void)fprintf(out, ", flux: %.6g", field->weight);
    put_spectrum(out, plan->lens, k > 0);
    (void)fprintf(out, ", medium: %s}", plan->media.medium[plan->media.behind[0]].name);
    (void)fprintf(
        out, "   # x %.6g, y %.6g %s%s\n", field->x, field->y, what[plan->lens->field_kind],
        behind_image ? "; begins behind the image, which would hide the lens from it" : "");
}

void rmap_lens_put_sources(FILE *out, const struct rmap_lens_plan *plan)
{
    (void)fputs("sources:\n", out);
    for (size_t k = 0; k < plan->lens->n_field; k++)
        put_field(out, plan, k);
}
