/* SPDX-License-Identifier: MIT
 *
 * A ray as lines of text: one line of its path in letters, or CSV rows.
 */
#include "mpi/scan/ray_lines.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "analysis/table/csv_field.h"
#include "scene/events.h"

#define CSV_HEADER                                                                                 \
    "ray,source,stop,flux,wavelength,step,object,face,primitive,events,medium,x0,y0,z0,x,y,z,nx,"  \
    "ny,nz,length,detectors,angle,reflectance"

static void write_number(FILE *out, int digits, double value)
{
    fputc(',', out);
    if (isfinite(value)) /* undefined: an empty cell */
        fprintf(out, "%.*g", digits, value);
}

static void write_point(FILE *out, int digits, struct rmap_vec3 p)
{
    write_number(out, digits, p.x);
    write_number(out, digits, p.y);
    write_number(out, digits, p.z);
}

static void write_events(FILE *out, uint32_t events)
{
    const char *between = "";
    for (uint32_t bit = 1; bit; bit <<= 1)
        if ((events & bit) && rmap_event_word(bit)) {
            fprintf(out, "%s%s", between, rmap_event_word(bit));
            between = "+";
        }
}

static const char *medium_name(const struct rmap_scene *scene, int32_t medium)
{
    return medium >= 0 && (size_t)medium < scene->n_medium ? scene->medium[medium].name : "";
}

static const char *object_name(const struct rmap_scene *scene, int32_t object)
{
    return object >= 0 && (size_t)object < scene->n_object ? scene->object[object].name : "";
}

/* The name of the detector of the next registration, from *next to before `end`; NULL: no more. */
static const char *next_detector(const struct rmap_ray_report *report, size_t *next, size_t end)
{
    while (*next < end) {
        const struct rmap_report_registration *registration = &report->registration[(*next)++];
        if (registration->registered)
            return report->scene->detector[registration->detector].name;
    }
    return NULL;
}

static void write_detectors(FILE *out, const struct rmap_ray_report *report, size_t step)
{
    const char *name, *quote = "", *between = "";
    size_t first;
    const size_t end = rmap_ray_report_registrations(report, step, &first);
    for (size_t r = first; (name = next_detector(report, &r, end));)
        if (rmap_csv_needs_quotes(name))
            quote = "\"";
    fprintf(out, ",%s", quote);
    for (size_t r = first; (name = next_detector(report, &r, end)); between = ";") {
        fputs(between, out);
        rmap_csv_put_inside(name, out);
    }
    fputs(quote, out);
}

static void write_curve(FILE *out, const struct rmap_ray_report *report,
                        const struct rmap_report_step *step)
{
    for (size_t k = 0; k < step->n_point; k++) {
        struct rmap_vec3 p = report->point[step->first_point + k].position;
        fprintf(out, "%s%.*g %.*g %.*g", k > 0 ? ";" : ",", report->digits, p.x, report->digits,
                p.y, report->digits, p.z);
    }
    if (step->n_point == 0)
        fputc(',', out);
}

enum rmap_status rmap_ray_csv_write(const struct rmap_ray_report *report, FILE *out,
                                    struct rmap_error *err)
{
    const struct rmap_scene *scene = report->scene;
    const bool curved = rmap_scene_is_curved(scene), events = rmap_scene_has_events(scene);
    uint64_t event = 0;
    const bool has = events && rmap_scene_event(scene, report->ray, &event);
    struct rmap_vec3 from = report->start;
    (void)err;
    for (size_t i = 0; i < report->n_step; i++) {
        const struct rmap_report_step *step = &report->step[i];
        fprintf(out, "%" PRIu64, report->ray);
        rmap_csv_put_text(scene->source[report->source].name, out);
        fprintf(out, ",%s", rmap_stop_word(report->stop) ? rmap_stop_word(report->stop) : "");
        write_number(out, 17, report->flux);
        write_number(out, 17, report->wavelength_nm);
        fprintf(out, ",%zu", i);
        rmap_csv_put_text(object_name(scene, step->object), out);
        fprintf(out, ",%d,%d,", (int)step->face, (int)step->primitive);
        write_events(out, step->events);
        rmap_csv_put_text(medium_name(scene, step->medium), out);
        write_point(out, report->digits, from);
        write_point(out, report->digits, step->position);
        write_point(out, report->digits, step->normal);
        write_number(out, report->digits, step->length);
        write_detectors(out, report, i);
        write_number(out, report->digits, step->incidence_deg);
        write_number(out, report->digits, step->reflectance);
        if (curved)
            write_curve(out, report, step);
        if (events)
            fprintf(out, has ? ",%" PRIu64 : ",", event);
        fputc('\n', out);
        from = step->position;
    }
    return RMAP_OK;
}

const char *rmap_ray_csv_header(const struct rmap_scene *scene)
{
    const bool events = rmap_scene_has_events(scene);
    if (rmap_scene_is_curved(scene))
        return events ? CSV_HEADER ",curve,event\n" : CSV_HEADER ",curve\n";
    return events ? CSV_HEADER ",event\n" : CSV_HEADER "\n";
}

static bool lies_on_object(const struct rmap_detector *detector)
{
    return detector->on_object >= 0 || detector->on_group >= 0;
}

static void write_registrations(const struct rmap_ray_report *report, size_t step, bool on_object,
                                FILE *out)
{
    size_t first;
    const size_t end = rmap_ray_report_registrations(report, step, &first);
    for (size_t r = first; r < end; r++) {
        const struct rmap_report_registration *registration = &report->registration[r];
        const struct rmap_detector *detector = &report->scene->detector[registration->detector];
        if (registration->registered && lies_on_object(detector) == on_object)
            fprintf(out, " V@%s", detector->name);
    }
}

enum rmap_status rmap_ray_path_write(const struct rmap_ray_report *report, FILE *out,
                                     struct rmap_error *err)
{
    const struct rmap_scene *scene = report->scene;
    (void)err;
    fprintf(out, "%" PRIu64 " ", report->ray);
    for (size_t i = 0; i < report->n_step; i++) {
        const struct rmap_report_step *step = &report->step[i];
        char letter = rmap_event_letter(step->events);
        const char *name = object_name(scene, step->object);
        if (!*name && letter != 'X')
            name = medium_name(scene, step->medium);
        write_registrations(report, i, false, out);
        if (letter)
            fprintf(out, *name ? " %c@%s" : " %c%s", letter, name);
        write_registrations(report, i, true, out);
    }
    fputc('\n', out);
    return RMAP_OK;
}
