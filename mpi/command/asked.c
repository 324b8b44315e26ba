/* SPDX-License-Identifier: MIT
 *
 * The criteria that a command is given: texts, the names they use (--criteria FILE), and a filter
 * string of Zemax (--zemax).
 */
#include "mpi/command/asked.h"

#include <stdio.h>
#include <string.h>

#include "analysis/report/zemax_filter.h"
#include "base/alloc.h"
#include "io/file/text_file.h"
#include "io/map/selection.h"
#include "mpi/parallel/agree.h"

static const struct rmap_text_kind criteria_file = {
    "a file of named criteria", "text: let NAME = CRITERION", "", (size_t)16 << 20};

static enum rmap_status load_criteria(const struct rmap_context *context, const char *path,
                                      struct rmap_criteria **criteria, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *text = NULL;
    size_t nbytes = 0;
    if (context->rank == 0)
        st = rmap_text_file_read(path, &criteria_file, &text, &nbytes, err);
    nbytes++; /* with the final 0 */
    RMAP_TRY(rmap_agree(context, st, err));
    uint8_t *blob = (uint8_t *)text;
    st = rmap_broadcast_blob(context, &blob, &nbytes, err);
    text = (char *)blob;
    RMAP_TRY(st);
    st = rmap_criteria_create(text, path, criteria, err);
    st = rmap_agree(context, st, err);
out:
    rmap_free(text);
    return st;
}

enum rmap_status rmap_asked_load(const struct rmap_context *context,
                                 const struct rmap_arguments *given, const char *const *text,
                                 size_t n_text, struct rmap_asked *asked, struct rmap_error *err)
{
    const char *path = rmap_argument(given, "criteria");
    *asked =
        (struct rmap_asked){.zemax = rmap_argument(given, "zemax"), .text = text, .n_text = n_text};
    asked->n = n_text + (asked->zemax != NULL);
    return path ? load_criteria(context, path, &asked->criteria, err) : RMAP_OK;
}

enum rmap_status rmap_asked_load_where(const struct rmap_context *context,
                                       const struct rmap_arguments *given, const char *const *where,
                                       struct rmap_asked *asked, struct rmap_error *err)
{
    if (*where && rmap_argument(given, "zemax"))
        return rmap_error_set(err, RMAP_USAGE, "give --where or --zemax, not both");
    return rmap_asked_load(context, given, where, *where != NULL, asked, err);
}

void rmap_asked_fini(struct rmap_asked *asked)
{
    rmap_criteria_destroy(asked->criteria);
    *asked = (struct rmap_asked){0};
}

void rmap_asked_take_file(struct rmap_asked *asked)
{
    asked->whole_file = asked->n == 0 && asked->criteria;
    if (asked->whole_file)
        asked->n = rmap_criteria_count(asked->criteria);
}

static enum rmap_status compile_zemax(const struct rmap_context *context, const char *filter,
                                      const struct rmap_scene *scene,
                                      struct rmap_criterion **criterion_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *text = NULL;
    RMAP_TRY(rmap_zemax_translate(filter, scene, &text, err));
    if (context->rank == 0 && !context->quiet)
        fprintf(stderr, "%s means: %s\n", filter, text);
    st = rmap_criterion_compile(text, scene, criterion_ret, err);
out:
    rmap_free(text);
    return st;
}

void rmap_asked_tell_time(const struct rmap_context *context, struct rmap_asked *asked, bool of)
{
    if (of && !asked->told_time && context->rank == 0 && !context->quiet)
        fprintf(stderr, "raymap: " RMAP_PHASE_TIME_HINT "\n");
    asked->told_time |= of;
}

void rmap_asked_tell_mixed(const struct rmap_context *context, const struct rmap_scene *scene,
                           const char *text, bool of)
{
    if (of && context->rank == 0 && !context->quiet)
        fprintf(stderr,
                "raymap: %s: x and y of far fields are in degrees, those of the other detectors in "
                "%s\n",
                text, scene->unit);
}

enum rmap_status rmap_asked_compile(const struct rmap_context *context, struct rmap_asked *asked,
                                    size_t index, const struct rmap_scene *scene,
                                    struct rmap_criterion **criterion_ret, struct rmap_error *err)
{
    if (!asked->whole_file && index >= asked->n_text)
        return compile_zemax(context, asked->zemax, scene, criterion_ret, err);
    const char *text =
        asked->whole_file ? rmap_criteria_reference(asked->criteria, index) : asked->text[index];
    enum rmap_status st =
        rmap_criterion_compile_with(text, asked->criteria, scene, criterion_ret, err);
    if (st == RMAP_OK) {
        rmap_asked_tell_time(context, asked, rmap_criterion_of_phase_time(*criterion_ret));
        rmap_asked_tell_mixed(context, scene, text, (*criterion_ret)->is_mixed);
    }
    return st;
}

enum rmap_status rmap_asked_which(const struct rmap_context *context,
                                  const struct rmap_arguments *given,
                                  const struct rmap_asked *asked, const struct rmap_scene *scene,
                                  const struct rmap_index_set *detector,
                                  const struct rmap_criterion *criterion,
                                  struct rmap_which **which_ret, struct rmap_error *err)
{
    enum rmap_status st =
        rmap_which_create(scene, detector, given ? rmap_argument(given, "which") : NULL,
                          asked->criteria, criterion, which_ret, err);
    if (st == RMAP_OK && given)
        st = rmap_which_detect(*which_ret, detector, err);
    if (st == RMAP_OK && (*which_ret)->remark && context->rank == 0 && !context->quiet)
        fprintf(stderr, "raymap: %s\n", (*which_ret)->remark);
    return st;
}

void rmap_asked_tell_picked(const struct rmap_context *context, const struct rmap_map *map,
                            const struct rmap_which *which, const char *detector)
{
    const struct rmap_selection *picked = rmap_map_selection(map);
    if (!picked || picked->n == 0 || which->from != RMAP_WHICH_ALL || context->rank > 0 ||
        context->quiet)
        return;
    fprintf(stderr,
            "raymap: this map holds rays picked by %s: all their registrations on %s are counted; "
            "--which chooses among them\n",
            picked->step[picked->n - 1].criterion, detector);
}
