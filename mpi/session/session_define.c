/* SPDX-License-Identifier: MIT
 *
 * Names that a session gives to criteria (`let NAME = CRITERION`); a later definition of a name
 * takes the place of the earlier one.
 */
#include "mpi/session/session_define.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"

/* The new text, then those of the old definitions that it does not replace: so that places in
 * messages are those of the line. */
static enum rmap_status join(const struct rmap_criteria *old, const struct rmap_criteria *fresh,
                             const char *text, char **joined_ret, struct rmap_error *err)
{
    size_t len = strlen(text) + 1, n = old ? rmap_criteria_count(old) : 0;
    for (size_t i = 0; i < n; i++)
        len += strlen(rmap_criteria_reference(old, i)) + strlen(rmap_criteria_definition(old, i)) +
               sizeof "\nlet  = ";
    char *joined = rmap_alloc(len, 1);
    if (!joined)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the definitions");
    size_t at = strlen(text);
    memcpy(joined, text, at + 1);
    for (size_t i = 0; i < n; i++)
        if (rmap_criteria_find(fresh, rmap_criteria_name(old, i)) == SIZE_MAX)
            at += (size_t)snprintf(joined + at, len - at, "\nlet %s = %s",
                                   rmap_criteria_reference(old, i) + 1,
                                   rmap_criteria_definition(old, i));
    *joined_ret = joined;
    return RMAP_OK;
}

/* That each of them means something, with all that it refers to. */
static enum rmap_status check(const struct rmap_criteria *all, const struct rmap_scene *scene,
                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; st == RMAP_OK && i < rmap_criteria_count(all); i++) {
        struct rmap_criterion *criterion = NULL;
        st = rmap_criterion_compile_with(rmap_criteria_reference(all, i), all, scene, &criterion,
                                         err);
        rmap_criterion_destroy(criterion);
    }
    return st;
}

enum rmap_status rmap_session_define(struct rmap_criteria **criteria, const char *text,
                                     const struct rmap_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_criteria *fresh = NULL, *all = NULL;
    char *joined = NULL;
    RMAP_TRY(rmap_criteria_create(text, RMAP_CRITERION_LABEL, &fresh, err));
    RMAP_TRY(join(*criteria, fresh, text, &joined, err));
    RMAP_TRY(rmap_criteria_create(joined, RMAP_CRITERION_LABEL, &all, err));
    RMAP_TRY(check(all, scene, err));
    rmap_criteria_destroy(*criteria);
    *criteria = all;
    all = NULL;
out:
    rmap_criteria_destroy(all);
    rmap_criteria_destroy(fresh);
    rmap_free(joined);
    return st;
}
