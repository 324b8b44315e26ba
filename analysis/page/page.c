/* SPDX-License-Identifier: MIT */
#include "analysis/page/page.h"

#include <string.h>

#include "analysis/page/page_asset.h"
#include "analysis/page/page_pack.h"
#include "analysis/page/page_parts.h"
#include "io/export/json_memory.h"
#include "io/export/json_number.h"
#include "io/file/whole_file.h"
#include "version.h"

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
        return err->status; /* its maker has told */
    if (json_object_set_new(data, name, part) == 0)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a page");
}

static enum rmap_status make_data(const struct rmap_page *page, json_t **data_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_scene_with(page->map, page->overlay);
    struct rmap_map_summary summary;
    rmap_map_summarise(page->map, &summary);
    json_t *data = json_pack(
        "{s:o, s:s, s:o, s:I, s:I, s:o, s:o, s:s}", "title", rmap_page_string(page->title),
        "program", "raymap " RMAP_VERSION, "criterion", rmap_page_string(page->criterion), "total",
        (json_int_t)summary.n_row[RMAP_TABLE_RAY], "matched", (json_int_t)page->n_matched,
        "flux_matched", rmap_json_number(page->flux_matched), "view", view_json(page), "color",
        rmap_paint_word(page->paint));
    if (!data)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a page"));
    RMAP_TRY(put(data, "scene", rmap_page_scene(scene, err), err));
    RMAP_TRY(put(data, "geometries", rmap_page_geometries(scene, err), err));
    RMAP_TRY(put(data, "rays", rmap_page_rays(page, err), err));
    RMAP_TRY(put(data, "classes", rmap_page_classes(page, err), err));
    RMAP_TRY(put(data, "order", rmap_page_orders(page, err), err));
    RMAP_TRY(put(data, "where", rmap_page_where(page, err), err));
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
    RMAP_TRY(put_page(page, data, whole.file, err));
    st = rmap_whole_file_finish(&whole, err);
out:
    rmap_whole_file_fini(&whole);
    json_decref(data);
    return st;
}
