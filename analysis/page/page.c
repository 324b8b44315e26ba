/* SPDX-License-Identifier: MIT
 *
 * A page to explore a map: one HTML file with everything in it, the scene, rays with all their
 * columns, classes of their paths, images of detectors, and the program that shows them (WebGL
 * through three.js, bundled at build time).
 */
#include <string.h>

#include "analysis/overlay/light_times.h"
#include "analysis/page/page.h"
#include "analysis/page/page_asset.h"
#include "analysis/page/page_colour.h"
#include "analysis/page/page_pack.h"
#include "analysis/page/page_parts.h"
#include "base/alloc.h"
#include "io/export/json_memory.h"
#include "io/export/json_number.h"
#include "io/file/whole_file.h"
#include "portion/event.h"
#include "version.h"

/* A column of whole numbers of any stored type, as int32. */
static json_t *integers(const struct rmap_portion *rays, enum rmap_column column)
{
    const struct rmap_column_info *info = rmap_column_info(column);
    const void *from = rmap_portion_column(rays, column);
    size_t n = rays->n_row[info->table] * (size_t)info->width;
    int32_t *value = rmap_alloc(n + 1, sizeof *value);
    if (!value)
        return NULL;
    for (size_t i = 0; i < n; i++)
        switch (info->element) {
        case RMAP_U8:
            value[i] = ((const uint8_t *)from)[i];
            break;
        case RMAP_U16:
            value[i] = ((const uint16_t *)from)[i];
            break;
        case RMAP_I16:
            value[i] = ((const int16_t *)from)[i];
            break;
        case RMAP_U32:
            value[i] = (int32_t)((const uint32_t *)from)[i];
            break;
        default:
            value[i] = ((const int32_t *)from)[i];
        }
    json_t *json = rmap_page_integers(value, n);
    rmap_free(value);
    return json;
}

static json_t *floats(const struct rmap_portion *rays, enum rmap_column column)
{
    const struct rmap_column_info *info = rmap_column_info(column);
    return rmap_page_floats(rmap_portion_column(rays, column),
                            rays->n_row[info->table] * (size_t)info->width);
}

static json_t *doubles(const struct rmap_portion *rays, enum rmap_column column)
{
    const struct rmap_column_info *info = rmap_column_info(column);
    return rmap_page_doubles(rmap_portion_column(rays, column), rays->n_row[info->table]);
}

static json_t *fluxes(const struct rmap_page *page)
{
    const struct rmap_portion *rays = page->rays;
    const double *per_weight = rmap_map_flux_per_weight(page->map);
    size_t n = rays->n_row[RMAP_TABLE_RAY];
    double *value = rmap_alloc(n + 1, sizeof *value);
    if (!value)
        return NULL;
    for (size_t i = 0; i < n; i++)
        value[i] = rays->ray.weight[i] * per_weight[rays->ray.source[i]];
    json_t *flux = rmap_page_doubles(value, n);
    rmap_free(value);
    return flux;
}

static json_t *ray_columns(const struct rmap_page *page)
{
    const struct rmap_portion *rays = page->rays;
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "id",
                     rmap_page_words(rays->ray.id, rays->n_row[RMAP_TABLE_RAY]), "flux",
                     fluxes(page), "source", integers(rays, RMAP_RAY_source), "stop",
                     integers(rays, RMAP_RAY_stop), "legs", integers(rays, RMAP_RAY_segment_count),
                     "registrations", integers(rays, RMAP_RAY_registration_count), "wavelength",
                     doubles(rays, RMAP_RAY_wavelength), "path_length",
                     doubles(rays, RMAP_RAY_path_length), "optical_path",
                     doubles(rays, RMAP_RAY_optical_path), "start", floats(rays, RMAP_RAY_start),
                     "start_object", integers(rays, RMAP_RAY_start_object), "end_direction",
                     floats(rays, RMAP_RAY_end_direction));
}

static json_t *segment_columns(const struct rmap_portion *rays)
{
    return json_pack("{s:o, s:o, s:o, s:o, s:o}", "object", integers(rays, RMAP_SEGMENT_object),
                     "primitive", integers(rays, RMAP_SEGMENT_primitive), "event",
                     integers(rays, RMAP_SEGMENT_event), "medium",
                     integers(rays, RMAP_SEGMENT_medium), "position",
                     floats(rays, RMAP_SEGMENT_position));
}

enum rmap_status rmap_page_which(const struct rmap_page *page,
                                 const struct rmap_index_set *detector,
                                 struct rmap_which **which_ret, struct rmap_error *err)
{
    const struct rmap_scene *scene = rmap_scene_with(page->map, page->overlay);
    if (page->n_where > 0)
        return rmap_which_create_any(scene, detector, page->where, page->n_where,
                                     rmap_map_flux_per_weight(page->map), which_ret, err);
    return rmap_which_create(scene, detector, NULL, NULL, page->any, which_ret, err);
}

/* Which registrations count: a bit for each switch, the lowest where there are none. NULL: memory
 * is short. */
static json_t *counted(const struct rmap_page *page)
{
    const struct rmap_scene *scene = rmap_scene_with(page->map, page->overlay);
    const struct rmap_index_set all = {.span = (uint32_t)scene->n_detector};
    const size_t n = page->rays->n_row[RMAP_TABLE_REGISTRATION];
    enum rmap_status st = RMAP_OK;
    int32_t *bits = rmap_alloc(n + 1, sizeof *bits);
    uint8_t *chosen = rmap_alloc(n + 1, 1);
    struct rmap_which *which = NULL;
    json_t *json = NULL;
    if (!bits || !chosen)
        goto out;
    for (size_t k = 0; k < (page->n_where > 0 ? page->n_where : 1); k++) {
        RMAP_TRY(rmap_which_create(scene, &all, NULL, NULL,
                                   page->n_where > 0 ? page->where[k] : page->any, &which, NULL));
        RMAP_TRY(rmap_which_mark(which, page->rays, chosen, NULL));
        for (size_t i = 0; i < n; i++)
            bits[i] |= (int32_t)chosen[i] << k;
        rmap_which_destroy(which);
        which = NULL;
    }
    json = rmap_page_integers(bits, n);
out:
    rmap_which_destroy(which);
    rmap_free(chosen);
    rmap_free(bits);
    return st == RMAP_OK ? json : NULL;
}

static json_t *registration_columns(const struct rmap_page *page)
{
    const struct rmap_portion *rays = page->rays;
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "leg",
                     integers(rays, RMAP_REGISTRATION_segment), "detector",
                     integers(rays, RMAP_REGISTRATION_detector), "relative",
                     integers(rays, RMAP_REGISTRATION_relative), "registered",
                     integers(rays, RMAP_REGISTRATION_registered), "counted", counted(page),
                     "direction", floats(rays, RMAP_REGISTRATION_direction), "optical_path",
                     doubles(rays, RMAP_REGISTRATION_optical_path));
}

/* Points of curved segments with the row of their segment. */
static json_t *curve_columns(const struct rmap_portion *rays)
{
    size_t n = rays->n_row[RMAP_TABLE_CURVE], segment = 0, at;
    int32_t *of = rmap_alloc(n + 1, sizeof *of);
    if (!of)
        return NULL;
    for (size_t i = 0; n > 0 && i < rays->n_row[RMAP_TABLE_RAY]; i++) {
        size_t n_point = rmap_portion_curve_of(rays, rays->ray.id[i], &at);
        for (size_t k = 0; k < n_point; k++)
            of[at + k] = (int32_t)(segment + rays->curve.segment[at + k]);
        segment += rays->ray.segment_count[i];
    }
    json_t *json = json_pack("{s:o, s:o}", "leg", rmap_page_integers(of, n), "position",
                             floats(rays, RMAP_CURVE_position));
    rmap_free(of);
    return json;
}

static json_t *words(void)
{
#define WORD(symbol, bit, letter, word, meaning) word,
    static const char *const event[] = {RMAP_EVENT_TABLE(WORD)};
#undef WORD
    json_t *events = json_array(), *letters = json_array(), *stops = json_array();
    for (size_t i = 0; i < sizeof event / sizeof *event; i++) {
        char letter = rmap_event_letter(1u << i);
        json_array_append_new(events, json_string(event[i]));
        json_array_append_new(letters, json_stringn(&letter, letter ? 1 : 0));
    }
    for (int i = 0; i < RMAP_STOP_COUNT; i++)
        json_array_append_new(stops, json_string(rmap_stop_word(i)));
    return json_pack("{s:o, s:o, s:o, s:s}", "event", events, "letter", letters, "stop", stops,
                     "precedence", "EKOFSIRTDdAX");
}

/* Columns of rays, segments, registrations and points of curved segments. */
static json_t *page_rays(const struct rmap_page *page, struct rmap_error *err)
{
    json_t *colours = rmap_page_colours(page, err);
    if (!colours)
        return NULL;
    json_t *json =
        json_pack("{s:o, s:o, s:o, s:o, s:o, s:o}", "colour", colours, "ray", ray_columns(page),
                  "leg", segment_columns(page->rays), "registration", registration_columns(page),
                  "curve", curve_columns(page->rays), "words", words());
    if (!json)
        (void)rmap_error_set(err, RMAP_SYSTEM, "out of memory for the rays of a page");
    return json;
}

/* Arrival times, ns; of a leg that leaves when it began and how long it takes per length. */
static json_t *page_times(const struct rmap_page *page, struct rmap_error *err)
{
    const size_t *n = page->rays->n_row;
    struct rmap_light_times *times = NULL;
    if (rmap_light_times_create(page->map, page->rays, &times, err) != RMAP_OK)
        return NULL;
    json_t *json = json_pack("{s:o, s:o, s:o}", "begin",
                             rmap_page_doubles(times->begin, n[RMAP_TABLE_SEGMENT]), "end",
                             rmap_page_doubles(times->end, n[RMAP_TABLE_SEGMENT]), "leaving",
                             rmap_page_doubles(times->leaving, n[RMAP_TABLE_RAY]));
    rmap_light_times_destroy(times);
    if (!json)
        (void)rmap_error_set(err, RMAP_SYSTEM, "out of memory for the times of a page");
    return json;
}

static json_t *view_json(const struct rmap_page *page)
{
    struct rmap_view view;
    rmap_view_choose(rmap_scene_with(page->map, page->overlay),
                     page->kind == RMAP_VIEW_AUTO ? RMAP_VIEW_3D : page->kind, page->rays, &view);
    return json_pack("{s:[f, f, f], s:[f, f, f]}", "toward", view.toward.x, view.toward.y,
                     view.toward.z, "up", view.up.x, view.up.y, view.up.z);
}

/* Adds a part under its name; takes its reference. */
static enum rmap_status put(json_t *data, const char *name, json_t *part, struct rmap_error *err)
{
    if (!part)
        return err->status; /* its maker has reported it */
    if (json_object_set_new(data, name, part) == 0)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a page");
}

/* The rays, and what of each of them the page tells. */
static enum rmap_status put_rays(json_t *data, const struct rmap_page *page, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(put(data, "rays", page_rays(page, err), err));
    if (rmap_map_scene(page->map)->timed)
        RMAP_TRY(put(data, "times", page_times(page, err), err));
    RMAP_TRY(put(data, "classes", rmap_page_classes(page, err), err));
    RMAP_TRY(put(data, "order", rmap_page_orders(page, err), err));
    RMAP_TRY(put(data, "where", rmap_page_where(page, err), err));
out:
    return st;
}

static enum rmap_status make_data(const struct rmap_page *page, json_t **data_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_scene_with(page->map, page->overlay);
    struct rmap_map_summary summary;
    rmap_map_summarise(page->map, &summary);
    json_t *data =
        json_pack("{s:o, s:s, s:o, s:I, s:I, s:o, s:s}", "title", rmap_page_string(page->title),
                  "program", "raymap " RMAP_VERSION, "criterion", rmap_page_string(page->criterion),
                  "total", (json_int_t)summary.n_row[RMAP_TABLE_RAY], "matched",
                  (json_int_t)page->n_matched, "flux_matched", rmap_json_number(page->flux_matched),
                  "color", rmap_paint_word(page->paint));
    if (!data)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a page"));
    if (page->parts & RMAP_PAGE_SCENE) {
        RMAP_TRY(put(data, "view", view_json(page), err));
        RMAP_TRY(put(data, "scene", rmap_page_scene(scene, err), err));
        RMAP_TRY(put(data, "geometries", rmap_page_geometries(scene, err), err));
    }
    if (page->parts & RMAP_PAGE_RAYS)
        RMAP_TRY(put_rays(data, page, err));
    if (page->parts & RMAP_PAGE_DETECTORS)
        RMAP_TRY(put(data, "detectors", rmap_page_detectors(page, err), err));
    *data_ret = data;
    data = NULL;
out:
    json_decref(data);
    return st;
}

/* What stands for itself in no part of a page. */
static void put_escaped(const char *text, FILE *out)
{
    for (; *text; text++)
        if (strchr("<>&\"'", *text))
            fprintf(out, "&#%d;", *text);
        else
            putc(*text, out);
}

/* Inside <script>, "</script" and "<!--" would not be data. Text is ASCII, < only in strings. */
static int put_json(const char *buffer, size_t n, void *context)
{
    FILE *out = context;
    for (size_t i = 0; i < n; i++)
        if (buffer[i] == '<')
            fputs("\\u003c", out);
        else
            putc(buffer[i], out);
    return 0;
}

static bool is_part(const char *name, size_t n, const char *part)
{
    return n == strlen(part) && memcmp(name, part, n) == 0;
}

static enum rmap_status put_part(const char *name, size_t n, const struct rmap_page *page,
                                 const json_t *data, FILE *out, struct rmap_error *err)
{
    if (is_part(name, n, "title"))
        put_escaped(page->title, out);
    else if (is_part(name, n, "style"))
        fputs(rmap_page_asset_style, out);
    else if (is_part(name, n, "library"))
        fputs(rmap_page_asset_library, out);
    else if (is_part(name, n, "script"))
        fputs(rmap_page_asset_script, out);
    else if (!is_part(name, n, "data"))
        return rmap_error_set(err, RMAP_INTERNAL, "no part '%.*s' of a page", (int)n, name);
    else if (json_dump_callback(data, put_json, out, JSON_COMPACT | JSON_ENSURE_ASCII) != 0 ||
             rmap_json_memory_failed())
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a page");
    return RMAP_OK;
}

static enum rmap_status put_page(const struct rmap_page *page, const json_t *data, FILE *out,
                                 struct rmap_error *err)
{
    static const char begin[] = "<!--raymap:", end[] = "-->";
    enum rmap_status st = RMAP_OK;
    const char *at = rmap_page_asset_html, *mark;
    while ((mark = strstr(at, begin))) {
        const char *name = mark + strlen(begin), *after = strstr(name, end);
        if (!after)
            return rmap_error_set(err, RMAP_INTERNAL, "a part of a page has no end");
        (void)fwrite(at, 1, (size_t)(mark - at), out);
        RMAP_TRY(put_part(name, (size_t)(after - name), page, data, out, err));
        at = after + strlen(end);
    }
    fputs(at, out);
out:
    return st;
}

enum rmap_status rmap_page_write(const struct rmap_page *page, const char *path,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_whole_file whole = {0};
    json_t *data = NULL;
    RMAP_TRY(make_data(page, &data, err));
    RMAP_TRY(rmap_whole_file_open(&whole, path, err));
    if (page->is_data)
        RMAP_TRY(put_part("data", strlen("data"), page, data, whole.file, err));
    else
        RMAP_TRY(put_page(page, data, whole.file, err));
    st = rmap_whole_file_finish(&whole, err);
out:
    rmap_whole_file_fini(&whole);
    json_decref(data);
    return st;
}
