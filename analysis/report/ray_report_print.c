/* SPDX-License-Identifier: MIT
 *
 * A ray as a table for people, and as JSON.
 */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "analysis/report/ray_report.h"
#include "analysis/report/ray_report_print.h"
#include "analysis/table/text_table.h"
#include "io/export/json_number.h"
#include "scene/events.h"

static const char *name_or_dash(const char *name)
{
    return name ? name : "-";
}

static const char *object_name(const struct rmap_scene *scene, int32_t object)
{
    return object >= 0 && (size_t)object < scene->n_object ? scene->object[object].name : NULL;
}

static const char *medium_name(const struct rmap_scene *scene, int32_t medium)
{
    return medium >= 0 && (size_t)medium < scene->n_medium ? scene->medium[medium].name : NULL;
}

static const char *detector_name(const struct rmap_scene *scene, int32_t detector)
{
    return detector >= 0 && (size_t)detector < scene->n_detector ? scene->detector[detector].name
                                                                 : NULL;
}

/* Does the registration stand after the step of its segment? Light arriving at an object does;
 * light passing a detector free in space is registered on the way. */
static bool after_step(const struct rmap_scene *scene, int32_t detector)
{
    if (!detector_name(scene, detector))
        return false;
    return scene->detector[detector].on_object >= 0 || scene->detector[detector].on_group >= 0;
}

static void append(char *text, size_t size, const char *word)
{
    size_t len = strlen(text);
    (void)snprintf(text + len, size - len, "%s%s", len ? ", " : "", word);
}

static void event_words(uint32_t events, char *text, size_t size)
{
    text[0] = 0;
    for (uint32_t bit = 1; bit; bit <<= 1)
        if ((events & bit) && rmap_event_word(bit))
            append(text, size, rmap_event_word(bit));
}

/* One live channel: its wavelength; few: their shares; many: how many. */
static void colour_words(const struct rmap_channels *channels, const double *colour, char *text,
                         size_t size)
{
    int n_live = 0, last = 0;
    for (int c = 0; c < channels->n; c++)
        if (colour[c] > 0.0) {
            n_live++;
            last = c;
        }
    text[0] = 0;
    char word[48];
    if (channels->mode == RMAP_COLOUR_RGB)
        (void)snprintf(text, size, "rgb %.3g %.3g %.3g", colour[0], colour[1], colour[2]);
    else if (n_live == 1)
        (void)snprintf(text, size, "%.6g nm", channels->wavelength_nm[last]);
    else if (n_live > 4)
        (void)snprintf(text, size, "%d wavelengths", n_live);
    else
        for (int c = 0; c < channels->n; c++)
            if (colour[c] > 0.0) {
                (void)snprintf(word, sizeof word, "%.6g nm %.3g", channels->wavelength_nm[c],
                               colour[c]);
                append(text, size, word);
            }
}

static void add_number(struct rmap_text_table *table, int digits, double value)
{
    if (isnan(value))
        rmap_text_table_add(table, "-");
    else
        rmap_text_table_add(table, "%.*g", digits, value);
}

static void add_registration(struct rmap_text_table *table, const struct rmap_ray_report *report,
                             const struct rmap_report_registration *r)
{
    const char *name = detector_name(report->scene, r->detector);
    bool plane = name && report->scene->detector[r->detector].type == RMAP_DETECTOR_PLANE;
    rmap_text_table_add(table, "%" PRIu32, r->step);
    rmap_text_table_add(table, "%s", r->registered ? "V" : "");
    rmap_text_table_add(table, "%s", name_or_dash(name));
    for (int c = 0; c < 6; c++)
        rmap_text_table_add(table, "%s", "");
    rmap_text_table_add(table,
                        "%s: %s %.9g, %s %.9g %s, cell %" PRIu32 " %" PRIu32
                        ", angle %.6g deg, optical path %.*g",
                        r->registered ? "registered" : "only crossed", plane ? "x" : "theta", r->x,
                        plane ? "y" : "phi", r->y, plane ? report->scene->unit : "deg", r->cell[0],
                        r->cell[1], r->angle_deg, report->digits, r->optical_path);
}

static void add_registrations(struct rmap_text_table *table, const struct rmap_ray_report *report,
                              size_t step, bool after)
{
    size_t first;
    const size_t end = rmap_ray_report_registrations(report, step, &first);
    for (size_t i = first; i < end; i++) {
        const struct rmap_report_registration *r = &report->registration[i];
        if (after_step(report->scene, r->detector) == after)
            add_registration(table, report, r);
    }
}

static void add_history(struct rmap_text_table *table, const struct rmap_ray_report *report)
{
    static const char *const heading[] = {"step",   "",       "object", "face", "prim",
                                          "medium", "colour", "angle",  "R",    "events"};
    for (size_t c = 0; c < sizeof heading / sizeof *heading; c++)
        rmap_text_table_add(table, "%s", heading[c]);
    for (size_t i = 0; i < report->n_step; i++) {
        const struct rmap_report_step *step = &report->step[i];
        char colour[128], events[256];
        colour_words(&report->scene->channels, step->colour, colour, sizeof colour);
        event_words(step->events, events, sizeof events);
        add_registrations(table, report, i, false);
        rmap_text_table_add(table, "%zu", i);
        char letter = rmap_event_letter(step->events);
        rmap_text_table_add(table, "%c", letter ? letter : '-');
        rmap_text_table_add(table, "%s", name_or_dash(object_name(report->scene, step->object)));
        rmap_text_table_add(table, step->face >= 0 ? "%" PRId32 : "-", step->face);
        rmap_text_table_add(table, step->primitive >= 0 ? "%" PRId32 : "-", step->primitive);
        rmap_text_table_add(table, "%s", name_or_dash(medium_name(report->scene, step->medium)));
        rmap_text_table_add(table, "%s", colour);
        add_number(table, 5, step->incidence_deg);
        add_number(table, 4, step->reflectance);
        rmap_text_table_add(table, "%s", events);
        add_registrations(table, report, i, true);
    }
}

static void add_vector(struct rmap_text_table *table, int digits, struct rmap_vec3 v)
{
    add_number(table, digits, v.x);
    add_number(table, digits, v.y);
    add_number(table, digits, v.z);
}

static void add_point(struct rmap_text_table *table, const struct rmap_ray_report *report,
                      const struct rmap_report_point *point)
{
    rmap_text_table_add(table, "~");
    add_vector(table, report->digits, point->position);
    add_vector(table, report->digits, point->direction);
    add_number(table, report->digits, point->length);
    add_number(table, report->digits, point->optical_path);
}

static void add_geometry(struct rmap_text_table *table, const struct rmap_ray_report *report)
{
    static const char *const heading[] = {"step",        "x",           "y",
                                          "z",           "direction x", "direction y",
                                          "direction z", "length",      "optical path"};
    for (size_t c = 0; c < sizeof heading / sizeof *heading; c++)
        rmap_text_table_add(table, "%s", heading[c]);
    rmap_text_table_add(table, "start");
    add_vector(table, report->digits, report->start);
    for (int c = 0; c < 5; c++)
        rmap_text_table_add(table, "%s", "");
    for (size_t i = 0; i < report->n_step; i++) {
        const struct rmap_report_step *step = &report->step[i];
        for (size_t k = 0; k < step->n_point; k++)
            add_point(table, report, &report->point[step->first_point + k]);
        rmap_text_table_add(table, "%zu", i);
        add_vector(table, report->digits, step->position);
        add_vector(table, report->digits, step->direction);
        add_number(table, report->digits, step->length);
        add_number(table, report->digits, step->optical_path);
    }
}

static void print_header(const struct rmap_ray_report *report, FILE *out)
{
    const struct rmap_scene *scene = report->scene;
    const char *start = object_name(scene, report->start_object);
    fprintf(out, "ray           %" PRIu64 "\n", report->ray);
    fprintf(out, "source        %s%s%s\n", scene->source[report->source].name,
            start ? ", from object " : "", start ? start : "");
    uint64_t event = 0;
    if (rmap_scene_event(scene, report->ray, &event))
        fprintf(out, "event         %" PRIu64 "\n", event);
    fprintf(out, "stop          %s", name_or_dash(rmap_stop_word(report->stop)));
    if (report->n_step > 0) {
        const struct rmap_report_step *last = &report->step[report->n_step - 1];
        const char *where = object_name(scene, last->object);
        if (where)
            fprintf(out, " at %s", where);
        else if (report->stop != RMAP_STOP_LEFT && medium_name(scene, last->medium))
            fprintf(out, " in %s", medium_name(scene, last->medium));
    }
    fprintf(out, "\nflux          %.*g %s\n", report->digits, report->flux,
            rmap_flux_unit_name(scene));
    if (isnan(report->wavelength_nm))
        fprintf(out, "wavelength    undefined (more than one channel)\n");
    else
        fprintf(out, "wavelength    %.10g nm\n", report->wavelength_nm);
    fprintf(out, "path length   %.*g %s\n", report->digits, report->path_length, scene->unit);
    fprintf(out, "optical path  %.*g %s\n\n", report->digits, report->optical_path, scene->unit);
}

enum rmap_status rmap_ray_report_print(const struct rmap_ray_report *report, FILE *out,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_text_table history, geometry;
    rmap_text_table_init(&history, 10);
    rmap_text_table_init(&geometry, 9);
    add_history(&history, report);
    add_geometry(&geometry, report);
    print_header(report, out);
    RMAP_TRY(rmap_text_table_print(&history, "rllrrllrrl", out, err));
    fprintf(out, "\nends of legs and directions, in %s%s\n", report->scene->unit,
            report->n_point > 0 ? "; ~: points of curved legs" : "");
    RMAP_TRY(rmap_text_table_print(&geometry, "rrrrrrrrr", out, err));
out:
    rmap_text_table_fini(&history);
    rmap_text_table_fini(&geometry);
    return st;
}

static json_t *vector(struct rmap_vec3 v)
{
    if (isnan(v.x))
        return json_null();
    return json_pack("[o, o, o]", rmap_json_number(v.x), rmap_json_number(v.y),
                     rmap_json_number(v.z));
}

static json_t *index_or_null(int32_t index)
{
    return index >= 0 ? json_integer(index) : json_null();
}

static json_t *text_or_null(const char *text)
{
    return text ? json_string(text) : json_null();
}

static json_t *event_list(uint32_t events)
{
    json_t *list = json_array();
    for (uint32_t bit = 1; bit; bit <<= 1)
        if ((events & bit) && rmap_event_word(bit))
            json_array_append_new(list, json_string(rmap_event_word(bit)));
    return list;
}

static json_t *colour_list(const double *colour, int n)
{
    json_t *list = json_array();
    for (int c = 0; c < n; c++)
        json_array_append_new(list, rmap_json_number(colour[c]));
    return list;
}

static json_t *curve_list(const struct rmap_ray_report *report, const struct rmap_report_step *step)
{
    json_t *list = json_array();
    for (size_t k = 0; k < step->n_point; k++)
        json_array_append_new(list, vector(report->point[step->first_point + k].position));
    return list;
}

static json_t *step_json(const struct rmap_ray_report *report, const struct rmap_report_step *step)
{
    const struct rmap_scene *scene = report->scene;
    bool object = step->object >= 0 && (size_t)step->object < scene->n_object;
    bool medium = step->medium >= 0 && (size_t)step->medium < scene->n_medium;
    json_t *json = json_pack(
        "{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "object",
        text_or_null(object ? scene->object[step->object].name : NULL), "face",
        index_or_null(step->face), "primitive", index_or_null(step->primitive), "events",
        event_list(step->events), "medium",
        text_or_null(medium ? scene->medium[step->medium].name : NULL), "position",
        vector(step->position), "normal", vector(step->normal), "direction",
        vector(step->direction), "length", rmap_json_number(step->length), "angle_of_incidence",
        rmap_json_number(step->incidence_deg), "reflectance", rmap_json_number(step->reflectance),
        "colour", colour_list(step->colour, scene->channels.n));
    if (json && (step->events & RMAP_EVENT_GRADIENT))
        json_object_set_new(json, "curve", curve_list(report, step));
    if (json && !isnan(step->first_direction.x))
        json_object_set_new(json, "first_direction", vector(step->first_direction));
    if (json && !isnan(step->optical_path))
        json_object_set_new(json, "optical_path", rmap_json_number(step->optical_path));
    return json;
}

static json_t *registration_json(const struct rmap_scene *scene,
                                 const struct rmap_report_registration *r)
{
    bool known = r->detector >= 0 && (size_t)r->detector < scene->n_detector;
    return json_pack("{s:o, s:i, s:[i, i], s:o, s:o, s:o, s:o, s:b}", "detector",
                     text_or_null(known ? scene->detector[r->detector].name : NULL), "step",
                     (int)r->step, "cell", (int)r->cell[0], (int)r->cell[1], "x",
                     rmap_json_number(r->x), "y", rmap_json_number(r->y), "angle",
                     rmap_json_number(r->angle_deg), "optical_path",
                     rmap_json_number(r->optical_path), "registered", (int)r->registered);
}

json_t *rmap_ray_report_json(const struct rmap_ray_report *report)
{
    json_t *steps = json_array(), *registrations = json_array();
    for (size_t i = 0; i < report->n_step; i++)
        json_array_append_new(steps, step_json(report, &report->step[i]));
    for (size_t i = 0; i < report->n_registration; i++)
        json_array_append_new(registrations,
                              registration_json(report->scene, &report->registration[i]));
    json_t *json = json_pack(
        "{s:I, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "ray", (json_int_t)report->ray,
        "source", report->scene->source[report->source].name, "stop",
        text_or_null(rmap_stop_word(report->stop)), "flux", rmap_json_number(report->flux),
        "wavelength", rmap_json_number(report->wavelength_nm), "path_length",
        rmap_json_number(report->path_length), "optical_path",
        rmap_json_number(report->optical_path), "start", vector(report->start), "steps", steps,
        "registrations", registrations);
    uint64_t event = 0;
    if (json && rmap_scene_event(report->scene, report->ray, &event))
        (void)json_object_set_new(json, "event", json_integer((json_int_t)event));
    return json;
}
