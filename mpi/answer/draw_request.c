/* SPDX-License-Identifier: MIT
 *
 * What `raymap draw` is asked for.
 */
#include "mpi/answer/draw_request.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "base/unit.h"
#include "mpi/answer/page_run.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/output.h"

enum { DEFAULT_LIMIT = 300, LARGEST_LIMIT = 1000000 };

static enum rmap_status read_view(const char *text, enum rmap_view_kind *kind,
                                  struct rmap_error *err)
{
    static const char *const word[] = {"auto", "yz", "xz", "xy", "3d"};
    for (size_t i = 0; i < sizeof word / sizeof *word; i++)
        if (!text || strcmp(text, word[i]) == 0) {
            *kind = (enum rmap_view_kind)i;
            return RMAP_OK;
        }
    return rmap_error_set(err, RMAP_USAGE, "--view '%s': say yz, xz, xy or 3d", text);
}

static enum rmap_status read_paint(const char *text, enum rmap_paint_kind *kind,
                                   struct rmap_error *err)
{
    for (int i = 0; i < RMAP_PAINT_KIND_COUNT; i++)
        if (!text || strcmp(text, rmap_paint_word((enum rmap_paint_kind)i)) == 0) {
            *kind = (enum rmap_paint_kind)i;
            return RMAP_OK;
        }
    return rmap_error_set(err, RMAP_USAGE, "--color '%s': say natural, path, criterion or order",
                          text);
}

static enum rmap_status read_level(const char *text, struct rmap_draw_request *request,
                                   struct rmap_error *err)
{
    request->has_level = text != NULL;
    for (int i = 0; i < RMAP_PATH_LEVEL_COUNT; i++)
        if (!text || strcmp(text, rmap_path_level_word((enum rmap_path_level)i)) == 0) {
            request->level = (enum rmap_path_level)i;
            return RMAP_OK;
        }
    return rmap_error_set(err, RMAP_USAGE, "--by '%s': say surface, object or group", text);
}

static enum rmap_status read_format(const char *path, enum rmap_draw_format *format,
                                    struct rmap_error *err)
{
    static const struct {
        const char *suffix;
        enum rmap_draw_format format;
    } known[] = {{".svg", RMAP_DRAW_PICTURE},  {".png", RMAP_DRAW_PICTURE},
                 {".apng", RMAP_DRAW_PICTURE}, {".html", RMAP_DRAW_PAGE},
                 {".json", RMAP_DRAW_PAGE},    {".vtp", RMAP_DRAW_POLYDATA},
                 {".glb", RMAP_DRAW_GLTF},     {".gltf", RMAP_DRAW_GLTF}};
    const char *suffix = path ? strrchr(path, '.') : NULL;
    if (!path)
        return rmap_error_set(err, RMAP_USAGE,
                              "say where to: -o OUT.svg or -o OUT.png (also .html, .vtp, .glb)");
    for (size_t i = 0; suffix && i < sizeof known / sizeof *known; i++)
        if (strcasecmp(suffix, known[i].suffix) == 0) {
            *format = known[i].format;
            return RMAP_OK;
        }
    return RMAP_OK; /* rmap_output_check tells the suffixes */
}

/* "rays,detectors" */
static enum rmap_status read_parts(const char *text, struct rmap_draw_request *request,
                                   struct rmap_error *err)
{
    static const struct {
        const char *word;
        unsigned part;
    } known[] = {
        {"scene", RMAP_PAGE_SCENE}, {"rays", RMAP_PAGE_RAYS}, {"detectors", RMAP_PAGE_DETECTORS}};
    const char *suffix = request->output_path ? strrchr(request->output_path, '.') : NULL;
    request->is_data = suffix && strcasecmp(suffix, ".json") == 0;
    request->parts = text ? 0 : RMAP_PAGE_ALL;
    if (text && !request->is_data)
        return rmap_error_set(err, RMAP_USAGE, "--parts is for the data of a page: -o OUT.json");
    for (const char *at = text; at; at = *at ? at + 1 : NULL) {
        const size_t n = strcspn(at, ",");
        unsigned part = 0;
        for (size_t i = 0; i < sizeof known / sizeof *known; i++)
            if (strlen(known[i].word) == n && memcmp(known[i].word, at, n) == 0)
                part = known[i].part;
        if (!part)
            return rmap_error_set(err, RMAP_USAGE,
                                  "--parts '%s': say some of scene, rays and detectors", text);
        request->parts |= part;
        at += n;
    }
    return RMAP_OK;
}

enum rmap_status rmap_read_eye(const char *text, double eye[2], struct rmap_error *err)
{
    char *end = NULL, *last = NULL;
    eye[0] = strtod(text, &end);
    bool fine = end != text && *end == ',';
    eye[1] = fine ? strtod(end + 1, &last) : 0.0;
    if (fine && last != end + 1 && *last == 0 && fabs(eye[0]) <= 360.0 && fabs(eye[1]) <= 90.0)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_USAGE,
                          "--eye '%s': say AZIMUTH,ELEVATION in degrees, such as -62,28 (elevation "
                          "from -90 to 90)",
                          text);
}

static enum rmap_status read_numbers(const struct rmap_arguments *given,
                                     struct rmap_draw_request *request, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool page = request->format == RMAP_DRAW_PAGE;
    request->limit = page ? RMAP_PAGE_DEFAULT_RAYS : DEFAULT_LIMIT;
    RMAP_TRY(rmap_argument_count(given, "limit", &request->limit, err));
    request->thin = request->format == RMAP_DRAW_PICTURE && !rmap_argument(given, "limit");
    int largest = page ? RMAP_PAGE_MOST_RAYS : LARGEST_LIMIT;
    if (request->limit < 1 || request->limit > (uint64_t)largest)
        return rmap_error_set(err, RMAP_USAGE, "--limit must lie between 1 and %d", largest);
    RMAP_TRY(rmap_argument_number(given, "opacity", &request->opacity, err));
    if (rmap_argument(given, "opacity") && !(request->opacity > 0.0 && request->opacity <= 1.0))
        return rmap_error_set(err, RMAP_USAGE, "--opacity must be greater than 0 and at most 1");
    request->has_cut = rmap_argument(given, "cut") != NULL;
    RMAP_TRY(rmap_argument_number(given, "cut", &request->cut, err));
    if (!isfinite(request->cut))
        return rmap_error_set(err, RMAP_USAGE, "--cut must be a length");
    RMAP_TRY(rmap_argument_number(given, "stretch", &request->stretch, err));
    if (rmap_argument(given, "stretch") &&
        (!(request->stretch >= 1e-6 && request->stretch <= 1e6) || request->camera ||
         request->kind == RMAP_VIEW_3D || request->format != RMAP_DRAW_PICTURE))
        return rmap_error_set(err, RMAP_USAGE,
                              "--stretch X is for sections, OUT.svg or OUT.png, and lies between "
                              "1e-6 and 1e6");
    RMAP_TRY(rmap_argument_number(given, "near", &request->near, err));
    if (rmap_argument(given, "near") && !(request->near > 0.0 && isfinite(request->near)))
        return rmap_error_set(err, RMAP_USAGE, "--near must be a length above 0");
    if (request->near > 0.0 && (request->camera || request->format != RMAP_DRAW_PICTURE))
        return rmap_error_set(err, RMAP_USAGE,
                              "--near is for sections: OUT.svg or OUT.png, seen "
                              "along an axis");
    if (request->camera && (request->has_eye || request->has_cut || rmap_argument(given, "view")))
        return rmap_error_set(err, RMAP_USAGE,
                              "--camera says where the scene is seen from: leave out --view, --eye "
                              "and --cut");
    if (request->camera && request->format != RMAP_DRAW_PICTURE)
        return rmap_error_set(err, RMAP_USAGE, "--camera is for pictures: OUT.svg or OUT.png");
    if (request->has_eye && request->kind == RMAP_VIEW_AUTO)
        request->kind = RMAP_VIEW_3D;
    if (request->has_cut && request->kind == RMAP_VIEW_3D)
        return rmap_error_set(err, RMAP_USAGE, "--cut moves a section: say --view yz, xz or xy");
    if (request->has_eye && request->kind != RMAP_VIEW_3D)
        return rmap_error_set(err, RMAP_USAGE, "--eye turns a view of solids: say --view 3d");
out:
    return st;
}

enum rmap_status rmap_frame_path(const char *path, uint32_t frame, char out[RMAP_FRAME_PATH_LEN],
                                 struct rmap_error *err)
{
    const char *suffix = strrchr(path, '.');
    const int n = snprintf(out, RMAP_FRAME_PATH_LEN, "%.*s-%04u%s", (int)(suffix - path), path,
                           frame + 1, suffix);
    return n < RMAP_FRAME_PATH_LEN ? RMAP_OK
                                   : rmap_error_set(err, RMAP_USAGE, "-o: the name is too long");
}

/* "0:12:0.5", "0:800:20 ps" */
static enum rmap_status read_time(const char *text, struct rmap_draw_request *request,
                                  struct rmap_error *err)
{
    enum { MOST = 9999 };
    const char *at = text;
    char *end = NULL;
    bool fine = true;
    double *time = request->time;
    for (int k = 0; k < 3 && fine; k++, at = end + 1) {
        time[k] = strtod(at, &end);
        fine = end != at && isfinite(time[k]) && (k == 2 || *end == ':');
    }
    if (fine && *end == ' ')
        end++;
    if (fine && *end) {
        const struct rmap_written_unit *unit = rmap_unit_of_scene(end, RMAP_DIMENSION_TIME);
        fine = unit != NULL;
        for (int k = 0; k < 3 && fine; k++)
            time[k] *= unit->size / 1e-9;
    }
    if (!fine || !(time[1] > time[0]) || !(time[2] > 0.0))
        return rmap_error_set(err, RMAP_USAGE,
                              "--time '%s': say FROM:TO:STEP in ns, such as 0:12:0.5, or with a "
                              "unit, 0:800:20 ps",
                              text);
    const double n = ceil((time[1] - time[0]) / time[2] * (1.0 - 1e-9));
    if (n > MOST)
        return rmap_error_set(err, RMAP_USAGE, "--time '%s': %.0f pictures, at most %d are drawn",
                              text, n, MOST);
    request->n_frame = (uint32_t)n;
    return RMAP_OK;
}

/* One film, or numbered pictures, none of which may stand there. */
static enum rmap_status check_film(struct rmap_draw_request *request, bool force,
                                   struct rmap_error *err)
{
    static const char *const suffixes[] = {".png", ".svg", ".apng", NULL};
    enum rmap_status st = RMAP_OK;
    request->animated = rmap_output_is(request->output_path, ".apng");
    RMAP_TRY(rmap_output_check(request->output_path, suffixes, force || !request->animated, err));
    for (uint32_t k = 0; k < request->n_frame && !request->animated; k++) {
        char path[RMAP_FRAME_PATH_LEN];
        RMAP_TRY(rmap_frame_path(request->output_path, k, path, err));
        RMAP_TRY(rmap_output_free(path, force, err));
    }
out:
    return st;
}

enum rmap_status rmap_draw_request_read(const struct rmap_arguments *given,
                                        struct rmap_draw_request *request, struct rmap_error *err)
{
    static const char *const suffixes[] = {".json", ".svg", ".png",  ".html",
                                           ".vtp",  ".glb", ".gltf", NULL};
    enum rmap_status st = RMAP_OK;
    *request = (struct rmap_draw_request){.map_path = given->operand[0],
                                          .output_path = rmap_argument(given, "output"),
                                          .camera = rmap_argument(given, "camera")};
    RMAP_TRY(read_format(request->output_path, &request->format, err));
    RMAP_TRY(read_paint(rmap_argument(given, "color"), &request->paint, err));
    RMAP_TRY(read_level(rmap_argument(given, "by"), request, err));
    RMAP_TRY(read_view(rmap_argument(given, "view"), &request->kind, err));
    const char *eye = rmap_argument(given, "eye");
    request->has_eye = eye != NULL;
    if (eye)
        RMAP_TRY(rmap_read_eye(eye, request->eye, err));
    if (rmap_argument(given, "by") && request->format == RMAP_DRAW_PICTURE &&
        request->paint != RMAP_PAINT_PATH)
        return rmap_error_set(
            err, RMAP_USAGE, "--by tells classes of paths apart: say --color path, or draw a page");
    RMAP_TRY(read_parts(rmap_argument(given, "parts"), request, err));
    RMAP_TRY(read_numbers(given, request, err));
    if (!(request->parts & RMAP_PAGE_RAYS))
        request->limit = 1; /* none is shown */
    RMAP_TRY(rmap_argument_each(given, "where", &request->where, &request->n_where, err));
    if (request->n_where > 1 && request->paint != RMAP_PAINT_CRITERION) {
        if (rmap_argument(given, "color"))
            return rmap_error_set(err, RMAP_USAGE,
                                  "several --where are for --color criterion; join them by 'or'");
        request->paint = RMAP_PAINT_CRITERION;
    }
    const bool force = rmap_argument(given, "force") != NULL;
    if (rmap_argument(given, "time")) {
        RMAP_TRY(read_time(rmap_argument(given, "time"), request, err));
        st = check_film(request, force, err);
    } else {
        st = rmap_output_check(request->output_path, suffixes, force, err);
    }
out:
    return st;
}

void rmap_draw_request_fini(struct rmap_draw_request *request)
{
    rmap_argument_list_free(request->where, request->n_where);
    *request = (struct rmap_draw_request){0};
}
