/* SPDX-License-Identifier: MIT
 *
 * A prescription as the text of a scene.
 */
#include "io/lensfile/lens_scene.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "io/lensfile/lens_write.h"

static void put_first_order(FILE *out, const struct rmap_lens_plan *plan)
{
    const struct rmap_first_order *o = &plan->order;
    const struct rmap_prescription *lens = plan->lens;
    (void)fprintf(out,
                  "# First order at %.7g nm, along the axis: ", lens->wavelength_nm[lens->primary]);
    if (isfinite(o->focal_length))
        (void)fprintf(out, "focal length %.8g %s, back focus %.8g %s, f/%.5g,\n# ", o->focal_length,
                      lens->unit, o->back_focus, lens->unit, o->f_number);
    else
        (void)fputs("afocal, ", out);
    if (isfinite(o->across[0]))
        (void)fprintf(out, "in x focal length %.8g %s, back focus %.8g %s,\n# ", o->across[0],
                      lens->unit, o->across[1], lens->unit);
    else if (!isnan(o->across[0]))
        (void)fputs("afocal in x, ", out);
    (void)fprintf(out, "entrance pupil %.7g %s across", o->entrance_diameter, lens->unit);
    if (isfinite(o->entrance))
        (void)fprintf(out, ", %.7g %s behind surface 1", o->entrance, lens->unit);
    if (isfinite(o->object))
        (void)fprintf(out, "; object %.7g %s before it, magnification %.6g", o->object, lens->unit,
                      o->magnification);
    (void)fputs(".\n", out);
}

static void put_notes(FILE *out, const struct rmap_prescription *lens)
{
    enum { LONGEST = 400 };
    if (lens->notes)
        (void)fputs("#\n# The file's own remarks:\n", out);
    for (const char *at = lens->notes; at && *at;) {
        char line[LONGEST];
        const size_t n = strcspn(at, "\n"), cut = n < LONGEST - 1 ? n : LONGEST - 1;
        memcpy(line, at, cut);
        line[cut] = 0;
        (void)fputs("#   ", out);
        rmap_lens_put_words(out, line);
        (void)fputc('\n', out);
        at += n + (at[n] == '\n');
    }
}

static void put_findings(FILE *out, const struct rmap_prescription *lens)
{
    const struct rmap_diagnostics *d = lens->findings;
    if (d->n == 0)
        return;
    (void)fputs("#\n# Not in this scene, or not as the file has it:\n", out);
    for (size_t i = 0; i < d->n; i++) {
        (void)fputs("#   ", out);
        if (d->item[i].line > 0)
            (void)fprintf(out, "line %d: ", d->item[i].line);
        rmap_lens_put_words(out, d->item[i].text);
        (void)fputc('\n', out);
    }
}

static void put_head(FILE *out, const struct rmap_lens_plan *plan, const char *file)
{
    const struct rmap_prescription *lens = plan->lens;
    (void)fputs("# ", out);
    rmap_lens_put_words(out, lens->title[0] ? lens->title : file);
    (void)fputs("\n#\n# Imported from ", out);
    rmap_lens_put_words(out, file);
    (void)fprintf(out, " (%s%s", lens->format, lens->version[0] ? " " : "");
    rmap_lens_put_words(out, lens->version);
    (void)fputs(
        ") by `raymap import`.\n"
        "# Light travels towards +z; the origin is the vertex of surface 1. Numbers behind rows "
        "and\n# objects are those of the file's surfaces.\n",
        out);
    put_first_order(out, plan);
    put_notes(out, lens);
    put_findings(out, lens);
    (void)fprintf(out, "raymap: 1\nunits: %s\nspectrum: {mode: spectral, wavelengths: [",
                  lens->unit);
    for (size_t i = 0; i < lens->n_wavelength; i++) {
        (void)fputs(i ? ", " : "", out);
        rmap_lens_put_number(out, lens->wavelength_nm[i]);
    }
    (void)fputs("]}\n\n", out);
}

/* "   # 3 stop: words of the file; remark" */
static void put_remark(FILE *out, const struct rmap_lens_plan *plan, size_t i, bool say_stop)
{
    const struct rmap_lens_surface *s = &plan->lens->surface[i];
    (void)fprintf(out, "   # %d", s->number);
    if (say_stop && s->is_stop)
        (void)fputs(", the stop", out);
    for (int part = 0; part < 2; part++) {
        const char *text = part ? s->remark : s->comment;
        if (!text[0])
            continue;
        (void)fputs(part && s->comment[0] ? "; " : ": ", out);
        rmap_lens_put_words(out, text);
    }
    (void)fputc('\n', out);
}

/* The side of a mirror that light meets. */
static const char *mirror_sides(const struct rmap_lens_plan *plan, size_t i)
{
    return plan->place[i].backwards ? "{front: mirror, back: absorber}"
                                    : "{front: absorber, back: mirror}";
}

static void put_semi(FILE *out, const struct rmap_lens_plan *plan, size_t i)
{
    const struct rmap_lens_opening *aperture = &plan->lens->surface[i].aperture;
    (void)fputs(", aperture: ", out);
    if (rmap_lens_is_outline(aperture))
        rmap_lens_put_outline(out, aperture);
    else if (plan->place[i].computed)
        (void)fprintf(out, "%.7g", plan->place[i].semi);
    else
        rmap_lens_put_number(out, plan->place[i].semi);
}

/* To the next row, as the file writes it unless something lies between. */
static double gap(const struct rmap_lens_plan *plan, const struct rmap_element_row *row,
                  const struct rmap_element_row *next)
{
    const size_t a = row->surface, b = next->surface;
    return a + 1 == b   ? plan->lens->surface[a].thickness
           : b + 1 == a ? -plan->lens->surface[b].thickness
                        : next->z - row->z;
}

static void put_row(FILE *out, const struct rmap_lens_plan *plan,
                    const struct rmap_element_row *row, const struct rmap_element_row *next)
{
    const struct rmap_lens_surface *s = &plan->lens->surface[row->surface];
    (void)fputs("      - {", out);
    rmap_lens_put_shape(out, s);
    if (next) {
        (void)fputs(", thickness: ", out);
        rmap_lens_put_number(out, gap(plan, row, next));
    }
    (void)fprintf(out, ", medium: %s", plan->media.medium[row->medium].name);
    put_semi(out, plan, row->surface);
    const bool has_plate = s->is_stop && !s->is_mirror && !rmap_lens_is_outline(&s->aperture);
    if (has_plate)
        (void)fputs(", stop: true", out);
    if (s->is_mirror)
        (void)fprintf(out, ", surface: %s", mirror_sides(plan, row->surface));
    (void)fputc('}', out);
    put_remark(out, plan, row->surface, !has_plate);
}

/* Radius of a plate about an opening: it holds back what would go past the lens; where mirrors send
 * light to and fro it stands in nobody's way. */
static double plate_radius(const struct rmap_lens_plan *plan, double opening)
{
    double most = opening;
    for (size_t i = 1; i + 1 < plan->lens->n_surface; i++)
        if (plan->lens->surface[i].is_mirror)
            return 1.4 * opening;
        else if (plan->place[i].role != RMAP_ROLE_NOTHING)
            most = fmax(most, plan->place[i].semi);
    return 1.2 * most;
}

/* Plates that lie in the plane of an element, in its frame: four about a hole, or arms. */
struct part {
    double size[2], at[2], turn_deg;
};

enum { PARTS_MAX = 64 };

static int make_parts(const struct rmap_lens_plan *plan, const struct rmap_lens_element *e,
                      struct part part[PARTS_MAX])
{
    const size_t i = plan->row[e->first].surface;
    const struct rmap_lens_surface *s = &plan->lens->surface[i];
    const struct rmap_lens_opening *a = &s->aperture;
    const double outer = plate_radius(plan, plan->place[i].semi);
    int n = 0;
    if (e->kind == RMAP_ELEMENT_SPIDER)
        for (; n < s->n_arm && n < PARTS_MAX; n++) {
            const double turn = 360.0 * n / s->n_arm, angle = turn * RMAP_PI / 180;
            const double length = plan->place[i].semi;
            part[n] = (struct part){{length, s->arm_width},
                                    {0.5 * length * cos(angle), 0.5 * length * sin(angle)},
                                    turn};
        }
    else
        for (; n < 4; n++) {
            const int k = n / 2; /* beside it in x, then above and below */
            const double sign = n % 2 ? -1 : 1, side = outer - a->half[k];
            part[n] = (struct part){
                {k ? 2 * a->half[0] : side, k ? side : 2 * outer}, {a->centre[0], a->centre[1]}, 0};
            part[n].at[k] += sign * (a->half[k] + 0.5 * side);
        }
    return n;
}

/* Their geometries; or the objects of their group. */
static void put_parts(FILE *out, const struct rmap_lens_plan *plan,
                      const struct rmap_lens_element *e, bool objects)
{
    struct part part[PARTS_MAX];
    const int n = make_parts(plan, e, part);
    for (int k = 0; k < n; k++) {
        if (!objects) {
            (void)fprintf(out, "  %s_%d: {type: rectangle, size: [%.12g, %.12g]}\n", e->name, k + 1,
                          part[k].size[0], part[k].size[1]);
            continue;
        }
        (void)fprintf(out, "      {name: %s_%d, geometry: %s_%d, at: [%.12g, %.12g, 0]", e->name,
                      k + 1, e->name, k + 1, part[k].at[0], part[k].at[1]);
        if (part[k].turn_deg != 0)
            (void)fprintf(out, ", rotate: [0, 0, %.12g]", part[k].turn_deg);
        (void)fprintf(out, ", surface: absorber}%s\n", k + 1 < n ? "," : "");
    }
}

/* Its radii at the two rows, and where it begins along z. */
static double tube(const struct rmap_lens_plan *plan, const struct rmap_lens_element *e,
                   double radius[2], double *length)
{
    double z[2];
    for (size_t k = 0; k < 2; k++) {
        const size_t i = plan->row[k ? e->first + e->n - 1 : e->first].surface;
        radius[k] = e->kind == RMAP_ELEMENT_BORE ? plan->place[i].hole : plan->place[i].semi;
        const struct rmap_shape shape = rmap_lens_shape(&plan->lens->surface[i], radius[k]);
        z[k] = (k ? e->gap : 0) + rmap_shape_sag(&shape, radius[k]);
    }
    *length = z[1] - z[0];
    return z[0];
}

static void put_tube(FILE *out, const struct rmap_lens_plan *plan,
                     const struct rmap_lens_element *e)
{
    double radius[2], length = 0;
    (void)tube(plan, e, radius, &length);
    (void)fprintf(out, "  %s: {type: cone, radius: %.15g, radius2: %.15g, length: %.15g}\n",
                  e->name, radius[0], radius[1], length);
}

static void put_geometry(FILE *out, const struct rmap_lens_plan *plan,
                         const struct rmap_lens_element *e)
{
    const struct rmap_element_row *row = &plan->row[e->first];
    const struct rmap_lens_surface *s = &plan->lens->surface[row->surface];
    const struct rmap_lens_place *place = &plan->place[row->surface];
    switch (e->kind) {
    case RMAP_ELEMENT_LENS:
        (void)fprintf(out, "  %s:\n    type: lens\n    surface: polished\n    surfaces:\n",
                      e->name);
        for (size_t k = 0; k < e->n; k++)
            put_row(out, plan, &row[k], k + 1 < e->n ? &row[k + 1] : NULL);
        break;
    case RMAP_ELEMENT_SURFACE:
        (void)fprintf(out, "  %s: {type: conic, ", e->name);
        rmap_lens_put_shape(out, s);
        put_semi(out, plan, row->surface);
        if (place->hole > 0)
            (void)fprintf(out, ", inner: %.6g", place->hole);
        (void)fputs("}\n", out);
        break;
    case RMAP_ELEMENT_OBSCURATION:
        (void)fprintf(out, "  %s: {type: conic, ", e->name);
        rmap_lens_put_shape(out, s);
        (void)fputs(", aperture: ", out);
        if (rmap_lens_is_outline(&s->obscuration))
            rmap_lens_put_outline(out, &s->obscuration);
        else
            rmap_lens_put_number(out, s->obscuration.half[0]);
        (void)fputs("}\n", out);
        break;
    case RMAP_ELEMENT_PLATE:
        if (s->aperture.shape == RMAP_OPENING_RECTANGLE)
            put_parts(out, plan, e, false);
        else
            (void)fprintf(out, "  %s: {type: disc, inner: %.15g, radius: %.6g}\n", e->name,
                          s->aperture.shape ? s->aperture.half[0] : place->semi,
                          plate_radius(plan, place->semi));
        break;
    case RMAP_ELEMENT_SPIDER:
        put_parts(out, plan, e, false);
        break;
    case RMAP_ELEMENT_EDGE:
    case RMAP_ELEMENT_BORE:
        put_tube(out, plan, e);
        break;
    }
}

static void put_image_shape(FILE *out, const struct rmap_lens_plan *plan)
{
    const struct rmap_lens_surface *image = &plan->lens->surface[plan->lens->n_surface - 1];
    if (image->curvature == 0 && image->n_asphere == 0 && image->figure.n_term == 0 &&
        !image->figure.is_biconic && !image->figure.is_toroid) {
        (void)fprintf(out, "  image: {type: rectangle, size: [%.6g, %.6g]}\n", 2 * plan->image_half,
                      2 * plan->image_half);
        return;
    }
    (void)fputs("  image: {type: conic, ", out);
    rmap_lens_put_shape(out, image);
    (void)fprintf(out, ", aperture: %.6g}\n", fmin(plan->image_half, rmap_lens_reach(image)));
}

/* How far a surface rises towards the light within its aperture. */
static double rise(const struct rmap_lens_surface *s, const struct rmap_lens_place *place)
{
    const struct rmap_shape shape = rmap_lens_shape(s, place->semi);
    const double sag = rmap_shape_sag(&shape, place->semi);
    return isfinite(sag) ? fmax(0, place->backwards ? sag : -sag) : 0;
}

static void put_object(FILE *out, const struct rmap_lens_plan *plan,
                       const struct rmap_lens_element *e)
{
    const struct rmap_element_row *row = &plan->row[e->first];
    const struct rmap_lens_surface *s = &plan->lens->surface[row->surface];
    const struct rmap_lens_place *place = &plan->place[row->surface];
    struct rmap_affine to_world = e->to_world;
    double before = 0; /* plates stand before what they lie on, which is no hole */
    const bool parts =
        e->kind == RMAP_ELEMENT_SPIDER ||
        (e->kind == RMAP_ELEMENT_PLATE && s->aperture.shape == RMAP_OPENING_RECTANGLE);
    if (e->kind == RMAP_ELEMENT_OBSCURATION || e->kind == RMAP_ELEMENT_SPIDER || place->spot)
        before = 1e-5 * place->semi;
    if (e->kind == RMAP_ELEMENT_SPIDER)
        before += rise(s, place);
    if (e->kind == RMAP_ELEMENT_EDGE || e->kind == RMAP_ELEMENT_BORE) {
        double radius[2], length = 0;
        before = -tube(plan, e, radius, &length);
    }
    if (e->kind == RMAP_ELEMENT_PLATE && !parts)
        to_world.t = rmap_affine_point(&to_world,
                                       rmap_vec3(s->aperture.centre[0], s->aperture.centre[1], 0));
    else
        to_world.t =
            rmap_affine_point(&to_world, rmap_vec3(0, 0, place->backwards ? before : -before));
    (void)fprintf(out, "  - {name: %s", e->name);
    if (!parts)
        (void)fprintf(out, ", geometry: %s", e->name);
    rmap_lens_put_place(out, &to_world);
    if (e->kind == RMAP_ELEMENT_PLATE && s->aperture.shape == RMAP_OPENING_ELLIPSE)
        (void)fprintf(out, ", scale: [1, %.15g, 1]", s->aperture.half[1] / s->aperture.half[0]);
    if (e->kind == RMAP_ELEMENT_LENS) {
        (void)fputs(", outside: air}\n", out);
        return;
    }
    if (parts)
        (void)fputs(", objects: [", out);
    else if (e->kind != RMAP_ELEMENT_SURFACE)
        (void)fputs(", surface: absorber}", out);
    else if (s->is_mirror)
        (void)fprintf(out, ", surface: %s}", mirror_sides(plan, row->surface));
    else
        (void)fprintf(out, ", surface: polished, back: %s, front: %s}",
                      plan->media.medium[e->before].name, plan->media.medium[row->medium].name);
    put_remark(out, plan, row->surface, true);
    if (parts) {
        put_parts(out, plan, e, true);
        (void)fputs("    ]}\n", out);
    }
}

/* Rows of the file that are no object, as remarks, so that none is lost without a word. */
static void put_absent(FILE *out, const struct rmap_lens_plan *plan)
{
    for (size_t i = 1; i + 1 < plan->lens->n_surface; i++) {
        const struct rmap_lens_surface *s = &plan->lens->surface[i];
        const struct rmap_lens_place *place = &plan->place[i];
        if (place->role != RMAP_ROLE_NOTHING && place->role != RMAP_ROLE_AGAIN)
            continue;
        (void)fprintf(out, "  # %d", s->number);
        if (place->role == RMAP_ROLE_AGAIN)
            (void)fprintf(out, " is surface %d, which light meets again",
                          plan->lens->surface[place->again].number);
        else
            (void)fputs(s->is_break ? " moves the axes" : " changes nothing", out);
        for (int part = 0; part < 2; part++)
            if ((part ? s->remark : s->comment)[0]) {
                (void)fputs("; ", out);
                rmap_lens_put_words(out, part ? s->remark : s->comment);
            }
        (void)fputc('\n', out);
    }
}

static bool has_mirror(const struct rmap_prescription *lens)
{
    for (size_t i = 1; i + 1 < lens->n_surface; i++)
        if (lens->surface[i].is_mirror)
            return true;
    return false;
}

void rmap_lens_configuration_name(const struct rmap_prescription *lens, int k, char *name,
                                  size_t cap)
{
    size_t n = 0;
    bool letters = false;
    for (const char *c = lens->configuration_name; *c && n + 8 < cap; c++) {
        name[n++] = isalnum((unsigned char)*c) || strchr("-.", *c) ? *c : '_';
        letters = letters || isalpha((unsigned char)*c);
    }
    name[n] = 0;
    if (!letters || !isalpha((unsigned char)name[0]) || strcmp(name, "quick") == 0)
        (void)snprintf(name, cap, "configuration_%d", k);
}

void rmap_lens_scene_write(const struct rmap_lens_plan *plan, const char *file, FILE *out)
{
    const struct rmap_prescription *lens = plan->lens;
    const size_t image = lens->n_surface - 1;
    put_head(out, plan, file);
    rmap_lens_put_media(out, plan);
    (void)fputs("\nsurfaces:\n  polished: {type: fresnel}   # uncoated\n", out);
    if (has_mirror(lens))
        (void)fputs("  mirror: {type: mirror, reflectance: 1}\n", out);
    (void)fputs("\ngeometries:\n", out);
    for (size_t e = 0; e < plan->n_element; e++)
        put_geometry(out, plan, &plan->element[e]);
    put_image_shape(out, plan);
    (void)fputs("\nobjects:\n", out);
    for (size_t e = 0; e < plan->n_element; e++)
        put_object(out, plan, &plan->element[e]);
    (void)fputs("  - {name: image, geometry: image", out);
    rmap_lens_put_place(out, &plan->place[image].to_world);
    (void)fputs(", surface: absorber}", out);
    put_remark(out, plan, image, false);
    put_absent(out, plan);
    (void)fputc('\n', out);
    rmap_lens_put_sources(out, plan);
    (void)fputs("\ndetectors:\n  - {name: sensor, type: plane, on: image, cells: [200, 200]}\n\n"
                "simulations:\n  - {name: quick, rays: 200000}\n",
                out);
}
