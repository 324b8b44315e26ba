/* SPDX-License-Identifier: MIT
 *
 * What a surface of a scene makes of light, for `raymap check --surface`.
 */
#include "mpi/answer/surface_out.h"

#include <math.h>
#include <string.h>

#include "analysis/figure/figure_detector.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/export/json_number.h"
#include "io/export/raster.h"
#include "io/file/diagnostics.h"
#include "scatter/dust.h"
#include "scatter/table.h"

/* Degrees from one row to the next, and the last row. */
enum { STEP_DEG = 5, LAST_DEG = 90 };

static bool has(const struct rmap_scene *scene, const struct rmap_object *object, bool front,
                const struct rmap_surface *surface)
{
    const int32_t its = front ? object->surface_front : object->surface_back;
    return its >= 0 && &scene->surface[its] == surface;
}

/* Sides of the first object with the surface, the one outside first; how many. */
static size_t find_sides(const struct rmap_scene *scene, const struct rmap_surface *surface,
                         struct rmap_surface_side side[RMAP_SURFACE_SIDES_MAX])
{
    size_t n = 0;
    for (size_t o = 0; o < scene->n_object && n == 0; o++) {
        const struct rmap_object *object = &scene->object[o];
        const bool first = object->medium_back != object->medium_outside ||
                           object->medium_front == object->medium_outside;
        if (has(scene, object, first, surface))
            side[n++] = (struct rmap_surface_side){object, first};
        if (has(scene, object, !first, surface) &&
            (n == 0 || surface->type == RMAP_SURFACE_FRESNEL || surface->is_metal ||
             surface->scatter_transmit > 0))
            side[n++] = (struct rmap_surface_side){object, !first};
    }
    return n;
}

/* False: no object has it. */
static bool ask(const struct rmap_scene *scene, const struct rmap_surface *surface,
                struct rmap_surface_question *question)
{
    *question = (struct rmap_surface_question){
        .scene = scene, .surface = surface, .channel = scene->channels.n / 2};
    question->n_side = find_sides(scene, surface, question->side);
    return question->n_side > 0;
}

static enum rmap_status tell_unknown(const struct rmap_scene *scene, const char *name,
                                     struct rmap_error *err)
{
    const char **known = rmap_alloc(scene->n_surface, sizeof *known), *near = NULL;
    for (size_t i = 0; known && i < scene->n_surface; i++)
        known[i] = scene->surface[i].name;
    if (known)
        near = rmap_nearest_word(name, known, scene->n_surface);
    rmap_free(known);
    return rmap_error_set(
        err, RMAP_INPUT,
        "--surface %s: the scene has no such surface%s%s%s: raymap check lists them", name,
        near ? " (did you mean '" : "", near ? near : "", near ? "'?)" : "");
}

enum rmap_status rmap_surface_ask(const struct rmap_scene *scene, const char *name,
                                  struct rmap_surface_question *question, struct rmap_error *err)
{
    const struct rmap_surface *surface = NULL;
    for (size_t i = 0; i < scene->n_surface && !surface; i++)
        if (strcmp(scene->surface[i].name, name) == 0)
            surface = &scene->surface[i];
    if (!surface)
        return tell_unknown(scene, name, err);
    return ask(scene, surface, question)
               ? RMAP_OK
               : rmap_error_set(err, RMAP_INPUT,
                                "--surface %s: no object has it, and what it does depends on the "
                                "media beside it",
                                name);
}

static const char *medium_name(const struct rmap_scene *scene, int32_t medium)
{
    return medium >= 0 ? scene->medium[medium].name : "any medium";
}

static const char *near_name(const struct rmap_scene *scene, const struct rmap_surface_side *side)
{
    return medium_name(scene, side->front ? side->object->medium_front : side->object->medium_back);
}

static const char *far_name(const struct rmap_scene *scene, const struct rmap_surface_side *side)
{
    return medium_name(scene, side->front ? side->object->medium_back : side->object->medium_front);
}

static const char *side_word(const struct rmap_surface_side *side)
{
    return side->front ? "front" : "back";
}

static struct rmap_surface_shares shares_at(const struct rmap_surface_question *self, size_t s,
                                            int channel, int angle_deg)
{
    return rmap_side_shares(self->scene, self->side[s], channel, angle_deg);
}

static void describe(const struct rmap_surface_question *self, char *text, size_t cap)
{
    const struct rmap_surface *surface = self->surface;
    static const char *const coat[] = {", bare", ", coated", ", ideal coat", ", film "};
    const bool has_film = surface->coat == RMAP_COAT_FILM;
    (void)snprintf(text, cap, "surface %s: %s%s%s, on %s", surface->name,
                   rmap_surface_model[surface->type].name,
                   has_film || surface->type == RMAP_SURFACE_FRESNEL ? coat[surface->coat] : "",
                   has_film ? self->scene->film[surface->film].name : "",
                   self->side[0].object->name);
}

/* The model beside it; NULL: none. */
static const struct rmap_scatter *next_to(const struct rmap_surface_question *self,
                                          const struct rmap_scatter *its)
{
    return its->next > 0 ? &self->scene->scatter[its->next - 1] : NULL;
}

/* Of a way's model, or of both with particles; NULL: none. */
static const char *model_name(const struct rmap_surface_question *self, bool passes)
{
    static const char *const with_particles[] = {
#define ROW(number, symbol, name, keys, reciprocal) name " and contamination",
        RMAP_SCATTER_TABLE(ROW)
#undef ROW
    };
    const struct rmap_scatter *its = rmap_surface_scatter(self->scene, self->surface, passes);
    return !its            ? NULL
           : its->next > 0 ? with_particles[its->model]
                           : rmap_scatter_name[its->model].name;
}

static void name_models(const struct rmap_surface_question *self, char *text, size_t cap)
{
    const char *reflect = model_name(self, false), *transmit = model_name(self, true);
    const bool differ = reflect && transmit && strcmp(reflect, transmit) != 0;
    (void)snprintf(text, cap, "scatters by %s%s%s", reflect ? reflect : transmit,
                   differ ? " and, passing, by " : "", differ ? transmit : "");
}

/* Whether all of its models are. */
static bool is_reciprocal(const struct rmap_surface_question *self)
{
    bool is = true;
    for (int way = 0; way < 2; way++) {
        const struct rmap_scatter *its = rmap_surface_scatter(self->scene, self->surface, way == 1);
        for (; its; its = next_to(self, its))
            is = is && rmap_scatter_name[its->model].reciprocal &&
                 !(its->by_roughness && its->model == RMAP_SCATTER_HARVEY);
    }
    return is;
}

/* Of a measured model: how far it is from reciprocal; else NaN. */
static double asymmetry(const struct rmap_surface_question *self, bool passes)
{
    const struct rmap_scatter *its = rmap_surface_scatter(self->scene, self->surface, passes);
    return its && rmap_scatter_is_table(its)
               ? rmap_table_asymmetry(its, self->channel, passes, self->side[0].front)
               : (double)NAN;
}

static void print_scattering(const struct rmap_surface_question *self, FILE *out)
{
    const struct rmap_scatter *its = rmap_surface_scatter(self->scene, self->surface, false);
    const bool facets = its && rmap_scatter_is_facets(its);
    for (const struct rmap_scatter *one = its; one; one = next_to(self, one))
        if (one->dust)
            fprintf(out, "  particles cover %.4g %% of it\n", 100.0 * one->dust->coverage);
    char by[200];
    name_models(self, by, sizeof by);
    fprintf(out, "  %s, %s\n", by, is_reciprocal(self) ? "reciprocal" : "not reciprocal");
    for (int way = 0; way < 2; way++)
        if (!isnan(asymmetry(self, way == 1)))
            fprintf(out, "  asymmetry %.3g %% of its %s light: mean |f(a, b) - f(b, a)| over f\n",
                    100.0 * asymmetry(self, way == 1), way ? "transmitted" : "reflected");
    for (size_t s = 0; s < self->n_side; s++) {
        fprintf(out,
                "  from %s into %s, from the %s\n  angle  reflected   scattered  transmitted   "
                "scattered    absorbed%s\n",
                near_name(self->scene, &self->side[s]), far_name(self->scene, &self->side[s]),
                side_word(&self->side[s]), facets ? "   of it by other facets" : "");
        for (int angle = 0; angle <= LAST_DEG; angle += STEP_DEG) {
            const struct rmap_surface_shares its_shares = shares_at(self, s, self->channel, angle);
            fprintf(out, "  %5d %10.6f %11.5e %12.6f %11.5e %11.6f", angle,
                    its_shares.reflect_specular, its_shares.reflect_diffuse,
                    its_shares.transmit_specular, its_shares.transmit_diffuse, its_shares.absorb);
            if (facets)
                fprintf(out, " %11.6f", its_shares.missing);
            fputc('\n', out);
        }
    }
}

void rmap_surface_print(const struct rmap_surface_question *self, FILE *out)
{
    char text[400];
    describe(self, text, sizeof text);
    fprintf(out, "%s, at %g nm\n", text, self->scene->channels.wavelength_nm[self->channel]);
    if (rmap_surface_scatters(self->surface)) {
        print_scattering(self, out);
        return;
    }
    for (size_t s = 0; s < self->n_side; s++) {
        fprintf(out,
                "  from %s into %s, from the %s\n  angle  reflected  transmitted    absorbed\n",
                near_name(self->scene, &self->side[s]), far_name(self->scene, &self->side[s]),
                side_word(&self->side[s]));
        for (int angle = 0; angle <= LAST_DEG; angle += STEP_DEG) {
            const struct rmap_surface_shares its = shares_at(self, s, self->channel, angle);
            fprintf(out, "  %5d %10.6f %12.6f %11.6f\n", angle,
                    its.reflect_specular + its.reflect_diffuse,
                    its.transmit_specular + its.transmit_diffuse, its.absorb);
        }
    }
}

/* One curve of numbers for each share. */
static json_t *curves_json(const struct rmap_surface_question *self, size_t s, bool by_angle)
{
    json_t *list[6], *at = json_array();
    const int n = by_angle ? LAST_DEG / STEP_DEG + 1 : self->scene->channels.n;
    for (int k = 0; k < 6; k++)
        list[k] = json_array();
    for (int i = 0; i < n; i++) {
        const struct rmap_surface_shares its =
            shares_at(self, s, by_angle ? self->channel : i, by_angle ? i * STEP_DEG : 0);
        const double share[6] = {its.reflect_specular, its.reflect_diffuse, its.transmit_specular,
                                 its.transmit_diffuse, its.absorb,          its.missing};
        (void)json_array_append_new(
            at, json_real(by_angle ? i * STEP_DEG : self->scene->channels.wavelength_nm[i]));
        for (int k = 0; k < 6; k++)
            (void)json_array_append_new(list[k], rmap_json_number(share[k]));
    }
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o}", by_angle ? "angle" : "wavelength", at,
                     "reflect_specular", list[0], "reflect_diffuse", list[1], "transmit_specular",
                     list[2], "transmit_diffuse", list[3], "absorb", list[4], "missing", list[5]);
}

/* In the plane of incidence, at some angles of incidence. */
static json_t *bsdf_json(const struct rmap_surface_question *self, size_t s)
{
    json_t *all = json_array();
    for (size_t i = 0; rmap_surface_scatters(self->surface) && i < RMAP_FIGURE_INCIDENCES; i++) {
        json_t *list[3] = {json_array(), json_array(), json_array()};
        for (int angle = 1 - LAST_DEG; angle < LAST_DEG; angle++) {
            (void)json_array_append_new(list[0], json_integer(angle));
            for (int way = 0; way < 2; way++)
                (void)json_array_append_new(
                    list[1 + way],
                    rmap_json_number(rmap_side_bsdf(self->scene, self->side[s], self->channel,
                                                    rmap_figure_incidence[i], angle, way == 1)));
        }
        (void)json_array_append_new(all, json_pack("{s:f, s:o, s:o, s:o}", "incidence",
                                                   rmap_figure_incidence[i], "angle", list[0],
                                                   "reflected", list[1], "transmitted", list[2]));
    }
    return all;
}

json_t *rmap_surface_json(const struct rmap_surface_question *self)
{
    json_t *sides = json_array();
    for (size_t s = 0; s < self->n_side; s++)
        (void)json_array_append_new(
            sides,
            json_pack("{s:s, s:s, s:s, s:o, s:o, s:o}", "side", side_word(&self->side[s]), "from",
                      near_name(self->scene, &self->side[s]), "into",
                      far_name(self->scene, &self->side[s]), "by_angle", curves_json(self, s, true),
                      "by_wavelength", curves_json(self, s, false), "bsdf", bsdf_json(self, s)));
    json_t *scatter = json_null();
    if (rmap_surface_scatters(self->surface))
        scatter = json_pack("{s:s?, s:s?, s:b, s:{s:o, s:o}}", "reflect", model_name(self, false),
                            "transmit", model_name(self, true), "reciprocal", is_reciprocal(self),
                            "asymmetry", "reflect", rmap_json_number(asymmetry(self, false)),
                            "transmit", rmap_json_number(asymmetry(self, true)));
    return json_pack("{s:s, s:s, s:s, s:f, s:o, s:o}", "name", self->surface->name, "type",
                     rmap_surface_model[self->surface->type].name, "object",
                     self->side[0].object->name, "wavelength",
                     self->scene->channels.wavelength_nm[self->channel], "scatter", scatter,
                     "sides", sides);
}

enum rmap_status rmap_surface_draw(const struct rmap_surface_question *self,
                                   const struct rmap_scene *between, const char *path,
                                   struct rmap_error *err)
{
    struct rmap_svg *svg = NULL;
    struct rmap_surface_question more;
    char text[400], by[200] = "", title[sizeof text + sizeof by + 2];
    struct rmap_surface_picture its = {.scene = self->scene,
                                       .side = self->side,
                                       .n = self->n_side,
                                       .channel = self->channel,
                                       .title = title};
    enum rmap_status st = RMAP_OK;
    describe(self, text, sizeof text);
    if (rmap_surface_scatters(self->surface))
        name_models(self, by, sizeof by);
    (void)snprintf(title, sizeof title, "%s%s%s", text, *by ? ", " : "", by);
    if (between) {
        RMAP_TRY(rmap_surface_ask(between, self->surface->name, &more, err));
        its.between = between;
        its.side_between = more.side;
    }
    RMAP_TRY(rmap_figure_surface(&its, &svg, err));
    st = rmap_picture_write(svg, path, RMAP_FIGURE_SCALE, err);
out:
    rmap_svg_destroy(svg);
    return st;
}

/* The first surface with the film that an object has. */
static bool is_used(const struct rmap_scene *scene, size_t film,
                    struct rmap_surface_question *question)
{
    for (size_t i = 0; i < scene->n_surface; i++) {
        const struct rmap_surface *surface = &scene->surface[i];
        if (surface->coat == RMAP_COAT_FILM && (size_t)surface->film == film &&
            ask(scene, surface, question))
            return true;
    }
    return false;
}

void rmap_films_print(const struct rmap_scene *scene, FILE *out)
{
    enum { SHOWN_MAX = 8 };
    const int k = scene->channels.n / 2;
    for (size_t f = 0; f < scene->n_film; f++) {
        const struct rmap_thin_film *film = &scene->film[f];
        const struct rmap_thin_film_layer *layer = film->layer + (size_t)k * film->n_layer;
        struct rmap_surface_question question;
        if (film->n_angle > 0)
            fprintf(out, "    film %s: measured at %s", film->name,
                    rmap_counted((uint64_t)film->n_angle, "angle").text);
        else
            fprintf(out, "    film %s: %s", film->name,
                    rmap_counted((uint64_t)film->n_layer, "layer").text);
        for (size_t i = 0; i < film->n_layer && i < SHOWN_MAX; i++)
            fprintf(out, "%s %.4g nm of n %.4g%s", i ? "," : ":",
                    layer[i].thickness * scene->channels.wavelength_nm[k], layer[i].n,
                    layer[i].k > 0.0 ? " absorbing" : "");
        fputs(film->n_layer > SHOWN_MAX ? ", ...\n" : "\n", out);
        if (!is_used(scene, f, &question))
            continue;
        const struct rmap_surface_shares its = shares_at(&question, 0, k, 0);
        fprintf(out,
                "      from %s into %s, at %g nm straight on: reflects %.4g %%, absorbs %.4g %%\n",
                near_name(scene, &question.side[0]), far_name(scene, &question.side[0]),
                scene->channels.wavelength_nm[k], 100.0 * its.reflect_specular,
                100.0 * fmax(its.absorb, 0.0));
    }
}

json_t *rmap_films_json(const struct rmap_scene *scene)
{
    static const char *const substrate[] = {"inside", "front", "back"};
    const int k = scene->channels.n / 2;
    json_t *list = json_array();
    for (size_t f = 0; f < scene->n_film; f++) {
        const struct rmap_thin_film *film = &scene->film[f];
        const struct rmap_thin_film_layer *layer = film->layer + (size_t)k * film->n_layer;
        json_t *layers = json_array();
        for (size_t i = 0; i < film->n_layer; i++)
            (void)json_array_append_new(
                layers, json_pack("{s:f, s:f, s:f}", "thickness_nm",
                                  layer[i].thickness * scene->channels.wavelength_nm[k], "n",
                                  layer[i].n, "k", layer[i].k));
        (void)json_array_append_new(list,
                                    json_pack("{s:s, s:s, s:f, s:o, s:I}", "name", film->name,
                                              "substrate", substrate[film->substrate], "wavelength",
                                              scene->channels.wavelength_nm[k], "layers", layers,
                                              "measured_angles", (json_int_t)film->n_angle));
    }
    return list;
}

static const int tis_deg[] = {0, 30, 60, 80};
enum { N_TIS = sizeof tis_deg / sizeof *tis_deg };

void rmap_scatters_print(const struct rmap_scene *scene, FILE *out)
{
    for (size_t i = 0; i < scene->n_surface; i++) {
        struct rmap_surface_question question;
        const struct rmap_surface *surface = &scene->surface[i];
        if (!rmap_surface_scatters(surface) || !ask(scene, surface, &question))
            continue;
        for (int way = 0; way < 2; way++) {
            if (!model_name(&question, way == 1))
                continue;
            fprintf(out, "    surface %s: %s scatters", surface->name,
                    model_name(&question, way == 1));
            for (size_t k = 0; k < N_TIS; k++) {
                const struct rmap_surface_shares its =
                    shares_at(&question, 0, question.channel, tis_deg[k]);
                fprintf(out, "%s %.4g %%", k ? "," : "",
                        100.0 * (way ? its.transmit_diffuse : its.reflect_diffuse));
            }
            fprintf(out, " of the light %s at 0, 30, 60, 80 degrees (%g nm)\n",
                    way ? "onwards" : "back", scene->channels.wavelength_nm[question.channel]);
        }
    }
}

json_t *rmap_scatters_json(const struct rmap_scene *scene)
{
    json_t *all = json_array();
    for (size_t i = 0; i < scene->n_surface; i++) {
        struct rmap_surface_question question;
        json_t *list[3] = {NULL, NULL, NULL};
        if (!rmap_surface_scatters(&scene->surface[i]) ||
            !ask(scene, &scene->surface[i], &question))
            continue;
        for (int k = 0; k < 3; k++)
            list[k] = json_array();
        for (size_t k = 0; k < N_TIS; k++) {
            const struct rmap_surface_shares its =
                shares_at(&question, 0, question.channel, tis_deg[k]);
            (void)json_array_append_new(list[0], json_integer(tis_deg[k]));
            (void)json_array_append_new(list[1], rmap_json_number(its.reflect_diffuse));
            (void)json_array_append_new(list[2], rmap_json_number(its.transmit_diffuse));
        }
        (void)json_array_append_new(
            all,
            json_pack("{s:s, s:s?, s:s?, s:b, s:f, s:o, s:o, s:o}", "surface",
                      scene->surface[i].name, "reflect", model_name(&question, false), "transmit",
                      model_name(&question, true), "reciprocal", is_reciprocal(&question),
                      "wavelength", scene->channels.wavelength_nm[question.channel], "angle",
                      list[0], "reflect_diffuse", list[1], "transmit_diffuse", list[2]));
    }
    return all;
}
