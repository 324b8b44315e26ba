/* SPDX-License-Identifier: MIT
 *
 * Finishing what killed writers of a map left, on all ranks.
 */
#include "mpi/trace/recover.h"

#include <string.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/map/map_directory.h"
#include "io/recovery/salvage.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/gather_content.h"
#include "mpi/parallel/progress.h"

/* What one rank did, as it is sent to rank 0. */
struct result {
    uint64_t n_ray, n_ray_lost, n_damaged;
    char text[RMAP_ERROR_TEXT_LEN]; /* the first thing that was wrong; or empty */
};

static void note(struct result *result, const char *text)
{
    if (!result->text[0])
        (void)snprintf(result->text, sizeof result->text, "%s", text);
}

enum rmap_status rmap_recover_wait(const struct rmap_context *context, const char *map_path,
                                   struct rmap_map_listing *found, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *found = (struct rmap_map_listing){0};
    if (context->rank == 0)
        st = rmap_map_await_writers(map_path, found, err);
    return rmap_agree_patiently(context, st, err);
}

/* Collective. Rank 0's list, on every rank. */
static enum rmap_status share_list(const struct rmap_context *context, struct rmap_leftover **list,
                                   size_t *n, struct rmap_error *err)
{
    uint8_t *blob = (uint8_t *)*list;
    size_t nbytes = *n * sizeof **list;
    enum rmap_status st = rmap_broadcast_blob(context, &blob, &nbytes, err);
    *list = (struct rmap_leftover *)(void *)blob;
    *n = st == RMAP_OK ? nbytes / sizeof **list : 0;
    return st;
}

enum rmap_status rmap_recover_list(const struct rmap_context *context, const char *map_path,
                                   struct rmap_leftover **list_ret, size_t *n_ret,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *list_ret = NULL;
    *n_ret = 0;
    if (context->rank == 0)
        st = rmap_map_list_leftovers(map_path, list_ret, n_ret, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(share_list(context, list_ret, n_ret, err));
out:
    return st;
}

/* This rank's share. What is damaged stays where it is, and its rays are traced again. */
static enum rmap_status recover_some(const struct rmap_context *context, const struct rmap_map *map,
                                     const struct rmap_leftover *list, size_t n,
                                     struct rmap_map_content *content, struct result *result,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = (size_t)context->rank; st == RMAP_OK && i < n; i += (size_t)context->size) {
        struct rmap_salvaged salvaged = {0};
        struct rmap_error why = {0};
        enum rmap_status done = rmap_salvage(map, &list[i], content, &salvaged, &why);
        result->n_ray += salvaged.n_ray;
        result->n_ray_lost += salvaged.n_ray_lost;
        result->n_damaged += done == RMAP_FORMAT;
        note(result, done == RMAP_OK ? salvaged.first_lost : why.text);
        if (done != RMAP_OK && done != RMAP_FORMAT)
            st = rmap_error_set(err, done, "%s", why.text);
    }
    return st;
}

/* Rank 0. */
static void tell(const struct rmap_context *context, const struct result *result)
{
    struct result all = {0};
    for (int r = 0; r < context->size; r++) {
        all.n_ray += result[r].n_ray;
        all.n_ray_lost += result[r].n_ray_lost;
        all.n_damaged += result[r].n_damaged;
        note(&all, result[r].text);
    }
    if (all.n_ray > 0 && !context->quiet)
        fprintf(stderr, "raymap: %s of unfinished pieces %s recovered\n",
                rmap_counted(all.n_ray, "ray").text, all.n_ray == 1 ? "was" : "were");
    if (all.n_ray_lost > 0)
        fprintf(stderr, "raymap: warning: %s damaged, to be traced again; the first: %s\n",
                rmap_counted(all.n_ray_lost, "ray").text, all.text);
    else if (all.n_damaged > 0)
        fprintf(stderr, "raymap: warning: %s of no use, left as it stands; the first: %s\n",
                rmap_counted(all.n_damaged, "unfinished piece").text, all.text);
}

/* Collective. The finished pieces take the places of the unfinished ones. */
static enum rmap_status take_in(const struct rmap_context *context, struct rmap_map *map,
                                const struct rmap_map_content *mine, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_content all = {0};
    RMAP_TRY(rmap_gather_content(context, mine, &all, err));
    if (context->rank == 0)
        st = rmap_map_add_salvaged(map, &all, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_share_map(context, map, err));
out:
    rmap_map_content_fini(&all);
    return st;
}

enum rmap_status rmap_recover(const struct rmap_context *context, struct rmap_map *map,
                              struct rmap_map_listing *found, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_leftover *list = found->leftover;
    struct rmap_map_content mine = {0};
    struct result result = {0}, *all = NULL;
    size_t n = found->n_leftover;
    found->leftover = NULL;
    found->n_leftover = 0;
    RMAP_TRY(share_list(context, &list, &n, err));
    if (n == 0)
        goto out;
    all = rmap_alloc((size_t)context->size, sizeof *all);
    if (!all)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d ranks", context->size);
    else
        st = recover_some(context, map, list, n, &mine, &result, err);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    RMAP_TRY(RMAP_MPI(MPI_Gather(&result, sizeof result, MPI_BYTE, all, sizeof result, MPI_BYTE, 0,
                                 context->comm)));
    if (context->rank == 0)
        tell(context, all);
    RMAP_TRY(take_in(context, map, &mine, err));
out:
    rmap_map_content_fini(&mine);
    rmap_free(all);
    rmap_free(list);
    return st;
}
