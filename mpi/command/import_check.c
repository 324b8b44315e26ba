/* SPDX-License-Identifier: MIT
 *
 * Whether `raymap check` takes what an import writes.
 */
#include "mpi/command/import_check.h"

#include <string.h>

#include "base/alloc.h"
#include "mpi/command/json_out.h"
#include "mpi/command/scene_check.h"

/* What is known of another simulation is not said again. */
static void merge(struct rmap_diagnostics *told, const struct rmap_diagnostics *its,
                  const char *simulation)
{
    const size_t n = told->n;
    for (size_t i = 0; i < its->n; i++) {
        const struct rmap_diagnostic *item = &its->item[i];
        int line = item->line;
        const char *part = rmap_diagnostics_place(its, item->line, &line);
        bool known = false;
        for (size_t k = 0; k < n && !known; k++)
            known = told->item[k].line == item->line && strstr(told->item[k].text, item->text);
        if (known)
            continue;
        if (part)
            rmap_diagnostics_begin_part(told, item->line - line + 1, part, strlen(part));
        rmap_diagnostics_add(told, item->severity, item->line, item->column, "%s%s%s%s",
                             simulation ? "simulation '" : "", simulation ? simulation : "",
                             simulation ? "': " : "", item->text);
    }
}

enum rmap_status rmap_import_check(const struct rmap_context *context,
                                   const struct rmap_import_text *text,
                                   struct rmap_diagnostics *told, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_scene_options options = {.simulation = rmap_strdup(text->simulation)};
    struct rmap_bundle *bundle = NULL;
    struct rmap_scene_checked checked = {0};
    struct rmap_diagnostics its;
    rmap_diagnostics_init(&its, text->path);
    if (text->simulation && !options.simulation)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene"));
    st = text->text ? rmap_bundle_of_text(text->path, text->text, &options, &bundle, err)
                    : rmap_bundle_open(text->path, &options, &bundle, err);
    if (st == RMAP_OK)
        st = rmap_scene_check(bundle, context->n_thread, 1, &its, &checked, err);
    if (st == RMAP_INPUT && its.n_error == 0)
        rmap_diagnostics_add(&its, RMAP_SEVERITY_ERROR, 0, 0, "%s", err->text);
    if (st == RMAP_INPUT)
        st = RMAP_OK;
    merge(told, &its, text->simulation);
out:
    rmap_scene_options_fini(&options);
    rmap_scene_checked_fini(&checked);
    rmap_bundle_destroy(bundle);
    rmap_diagnostics_fini(&its);
    return st;
}

enum rmap_status rmap_import_refused(const char *scene, const struct rmap_diagnostics *told,
                                     struct rmap_error *err)
{
    if (told->n_error == 0)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_INPUT,
                          "%s is written, but `raymap check` refuses it for %zu error%s: mend it, "
                          "or the file that it was made of, before it is traced",
                          scene, told->n_error, told->n_error == 1 ? "" : "s");
}

json_t *rmap_json_check(const struct rmap_diagnostics *told)
{
    return json_pack("{s:I, s:o}", "errors", (json_int_t)told->n_error, "diagnostics",
                     rmap_json_diagnostics(told));
}
