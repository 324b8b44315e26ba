/* SPDX-License-Identifier: MIT */
#include <math.h>

#include "analysis/report/ray_report.h"
#include "io/export/json_number.h"

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
    json_t *json =
        json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "object",
                  text_or_null(object ? scene->object[step->object].name : NULL), "face",
                  index_or_null(step->face), "primitive", index_or_null(step->primitive), "events",
                  event_list(step->events), "medium",
                  text_or_null(medium ? scene->medium[step->medium].name : NULL), "position",
                  vector(step->position), "normal", vector(step->normal), "direction",
                  vector(step->direction), "length", rmap_json_number(step->length), "colour",
                  colour_list(step->colour, scene->channels.n));
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
    return json_pack("{s:I, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "ray",
                     (json_int_t)report->ray, "source", report->scene->source[report->source].name,
                     "stop", text_or_null(rmap_stop_word(report->stop)), "flux",
                     rmap_json_number(report->flux), "wavelength",
                     rmap_json_number(report->wavelength_nm), "path_length",
                     rmap_json_number(report->path_length), "optical_path",
                     rmap_json_number(report->optical_path), "start", vector(report->start),
                     "steps", steps, "registrations", registrations);
}
