/* SPDX-License-Identifier: MIT
 *
 * In rounds, for what one step brings back to light (pieces that a wrong index hid) the next one
 * must look at as well.
 */
#include "mpi/upkeep/repair_run.h"

#include <string.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/file/directory.h"
#include "io/map/map_directory.h"
#include "io/map/map_lock.h"
#include "io/map/map_rays.h"
#include "io/map/named_rays.h"
#include "io/recovery/repair.h"
#include "io/recovery/salvage.h"
#include "io/recovery/verify_named.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/gather_findings.h"
#include "mpi/parallel/progress.h"
#include "mpi/scan/copy_run.h"
#include "mpi/trace/recover.h"

enum { ROUNDS_MAX = 8 };

/* What a round calls for. */
enum step { STEP_NONE, STEP_INDEX, STEP_PIECES, STEP_LEFTOVERS, STEP_NAMES };

struct repair {
    const struct rmap_context *context;
    const char *path;
    const struct rmap_run *scene;
    struct rmap_repair_result *result;
    struct rmap_verify_result round;
    struct rmap_leftover *leftover;
    size_t n_leftover;
    struct rmap_ray_set had;     /* rank 0 */
    struct rmap_findings before; /* of the last round in which pieces were mended */
    bool index_made, salvaged, changed;
    bool was_complete; /* before anything was done */
    uint64_t n_had;
};

void rmap_repair_result_fini(struct rmap_repair_result *result)
{
    rmap_findings_fini(&result->found);
    rmap_findings_fini(&result->done);
    rmap_findings_fini(&result->left);
    rmap_ray_set_fini(&result->lost);
}

/* ---- what to do next (rank 0) ---- */

static bool of_names(const struct rmap_finding *finding)
{
    char name[RMAP_RAYS_NAME_NBYTES];
    return rmap_named_rays_name(finding->file, name);
}

static bool of_index(const struct rmap_finding *finding)
{
    return strncmp(finding->file, "shard-", 6) != 0 && !of_names(finding);
}

static bool of_piece(const struct rmap_finding *finding)
{
    return strncmp(finding->file, "shard-", 6) == 0 && !strstr(finding->file, "/.piece-");
}

static bool same(const struct rmap_findings *a, const struct rmap_findings *b)
{
    bool equal = a->n == b->n;
    for (size_t i = 0; equal && i < a->n; i++)
        equal = strcmp(a->row[i].file, b->row[i].file) == 0 &&
                strcmp(a->row[i].text, b->row[i].text) == 0;
    return equal;
}

static enum step choose(const struct repair *self)
{
    const struct rmap_verify_result *round = &self->round;
    const struct rmap_findings *findings = &round->findings;
    struct rmap_map_summary summary = {0};
    bool index = !round->verification->map, pieces = false, names = false;
    for (size_t i = 0; i < findings->n; i++) {
        index = index || of_index(&findings->row[i]);
        pieces = pieces || of_piece(&findings->row[i]);
        names = names || of_names(&findings->row[i]);
    }
    if (index)
        return self->index_made ? STEP_NONE : STEP_INDEX;
    rmap_map_summarise(round->verification->map, &summary);
    for (size_t i = 0; i < rmap_map_n_piece(round->verification->map); i++)
        pieces = pieces || rmap_repair_replaces(round->verification, i);
    if (pieces && !same(findings, &self->before))
        return STEP_PIECES;
    if (self->n_leftover > 0 && !self->salvaged)
        return summary.complete ? STEP_PIECES : STEP_LEFTOVERS; /* first of all, incomplete */
    return names ? STEP_NAMES : STEP_NONE;
}

/* ---- steps; collective ---- */

static enum rmap_status mend_index(struct repair *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (self->context->rank == 0)
        st = rmap_repair_index(self->path, self->scene, &self->result->done, err);
    self->index_made = true;
    return rmap_agree_patiently(self->context, st, err);
}

static enum rmap_status mend_names(struct repair *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (self->context->rank == 0)
        st = rmap_remove_damaged_rays(self->round.verification->map, &self->result->done, err);
    return rmap_agree_patiently(self->context, st, err);
}

static enum rmap_status copy_good(struct repair *self, struct rmap_map_content *copied,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_verification *what = self->round.verification;
    size_t n = what->content->n_portion, n_copied = 0;
    uint8_t *skip = rmap_alloc(n, 1);
    int shard = 0;
    if (!skip)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of portions");
    if (st == RMAP_OK && self->context->rank == 0)
        st = rmap_repair_free_shard(self->path, &shard, err);
    RMAP_TRY(rmap_agree(self->context, st, err));
    RMAP_TRY(RMAP_MPI(MPI_Bcast(&shard, 1, MPI_INT, 0, self->context->comm)));
    for (size_t i = 0; i < n; i++) {
        skip[i] = !rmap_repair_replaces(what, (size_t)what->content->portion[i].piece) ||
                  what->portion_flag[i] & RMAP_PORTION_LOST;
        n_copied += !skip[i];
    }
    const struct rmap_copy_plan plan = {.map = what->map,
                                        .skip = skip,
                                        .to = self->path,
                                        .shard = shard,
                                        .encoding = RMAP_ENCODING_COUNT};
    if (n_copied > 0)
        RMAP_TRY(rmap_copy_run(self->context, &plan, copied, err));
out:
    rmap_free(skip);
    return st;
}

static enum rmap_status mend_pieces(struct repair *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_content copied = {0};
    const struct rmap_verification *what = self->round.verification;
    RMAP_TRY(copy_good(self, &copied, err));
    if (self->context->rank == 0) {
        st = rmap_repair_write(what, &copied, self->round.tally, false, err);
        if (st == RMAP_OK)
            st = rmap_repair_remove(what, &self->result->done, err);
        rmap_findings_fini(&self->before);
        if (st == RMAP_OK)
            st = rmap_findings_append(&self->before, self->round.findings.row,
                                      self->round.findings.n, err);
    }
    RMAP_TRY(rmap_agree_patiently(self->context, st, err));
out:
    rmap_map_content_fini(&copied);
    return st;
}

static const char unfinished[] = "removed: nothing of it was finished";

static enum rmap_status salvage_one(const struct repair *self, const struct rmap_leftover *leftover,
                                    struct rmap_findings *done, struct rmap_error *err)
{
    struct rmap_map_content made = {0};
    struct rmap_salvaged salvaged;
    struct rmap_error why = {0};
    struct rmap_finding finding;
    enum rmap_status st =
        rmap_salvage(self->round.verification->map, leftover, &made, &salvaged, &why);
    if (st == RMAP_OK && salvaged.n_piece == 0 && salvaged.n_ray_lost == 0) {
        st = rmap_findings_note(done, leftover->name, unfinished, err);
    } else if (st == RMAP_OK) {
        rmap_finding_set(&finding, leftover->name, "", "salvaged: %s in %s; damaged of it: %s",
                         rmap_counted(salvaged.n_ray, "ray").text,
                         rmap_counted(salvaged.n_piece, "piece").text,
                         rmap_counted(salvaged.n_ray_lost, "ray").text);
        st = rmap_findings_add(done, &finding, err);
    } else if (st == RMAP_FORMAT) {
        st = rmap_repair_remove_leftover(self->path, leftover->name, done, err);
    } else if (err) {
        *err = why;
    }
    rmap_map_content_fini(&made);
    return st;
}

static enum rmap_status mend_leftovers(struct repair *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_findings done = {0};
    size_t rank = (size_t)self->context->rank, size = (size_t)self->context->size;
    for (size_t i = rank; i < self->n_leftover && st == RMAP_OK; i += size)
        st = salvage_one(self, &self->leftover[i], &done, err);
    RMAP_TRY(rmap_agree_patiently(self->context, st, err));
    RMAP_TRY(rmap_gather_findings(self->context, &done, err));
    if (self->context->rank == 0)
        st = rmap_findings_append(&self->result->done, done.row, done.n, err);
    RMAP_TRY(rmap_agree(self->context, st, err));
    self->salvaged = true;
out:
    rmap_findings_fini(&done);
    return st;
}

/* ---- rounds ---- */

/* Collective. Looks at the map as it is now. */
static enum rmap_status look(struct repair *self, enum step *step, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int chosen = 0;
    rmap_verify_result_fini(&self->round);
    rmap_free(self->leftover);
    self->leftover = NULL;
    RMAP_TRY(rmap_verify_run(self->context, self->path, &self->round, err));
    RMAP_TRY(rmap_recover_list(self->context, self->path, &self->leftover, &self->n_leftover, err));
    if (self->context->rank == 0)
        chosen = (int)choose(self);
    RMAP_TRY(RMAP_MPI(MPI_Bcast(&chosen, 1, MPI_INT, 0, self->context->comm)));
    *step = (enum step)chosen;
out:
    return st;
}

/* Rank 0: what the map said to hold before anything was done. */
static enum rmap_status remember(struct repair *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_verification *what = self->round.verification;
    const struct rmap_map_content *said =
        what->claimed->n_portion > 0 ? what->claimed : what->content;
    const struct rmap_findings *findings = &self->round.findings;
    struct rmap_map_summary summary = {0};
    for (size_t i = 0; i < findings->n; i++)
        if (strstr(findings->row[i].text, "use a newer raymap"))
            return rmap_error_set(err, RMAP_FORMAT,
                                  "%s; it is not damaged, and nothing was changed",
                                  findings->row[i].text);
    RMAP_TRY(rmap_findings_append(&self->result->found, findings->row, findings->n, err));
    RMAP_TRY(rmap_rays_held(said, &self->had, err));
    for (size_t i = 0; i < said->n_portion; i++)
        self->n_had += said->portion[i].n_row[RMAP_TABLE_RAY];
    if (what->map)
        rmap_map_summarise(what->map, &summary);
    self->was_complete = summary.complete;
out:
    return st;
}

/* Rays of pieces that a complete map's index did not list: they belong to it now. */
static enum rmap_status tell_gained(struct repair *self, const struct rmap_ray_set *gained,
                                    struct rmap_error *err)
{
    struct rmap_finding finding;
    if (gained->n == 0)
        return RMAP_OK;
    rmap_finding_set(&finding, "map.h5", "", "took in %s of pieces that it did not list",
                     rmap_counted(rmap_ray_set_count(gained), "ray").text);
    return rmap_findings_add(&self->result->done, &finding, err);
}

/* Rank 0: the index of what there is now, complete if nothing is missing; and what is lost. */
static enum rmap_status conclude(struct repair *self, enum rmap_repair_mode mode,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_verification *what = self->round.verification;
    const struct rmap_map_content none = {0};
    const struct rmap_findings *findings = &self->round.findings;
    struct rmap_ray_set have = {0}, wanted = {0}, missing = {0}, gained = {0};
    if (!what->map && mode == RMAP_REPAIR_DO) {
        st = rmap_error_set(err, RMAP_FORMAT, "%s cannot be repaired: %s", self->path,
                            findings->n ? findings->row[0].text : "its index is unusable");
        goto out;
    }
    if (!what->map)
        goto out;
    RMAP_TRY(rmap_rays_held(what->content, &have, err));
    RMAP_TRY(rmap_rays_wanted(what->map, &wanted, err));
    RMAP_TRY(rmap_ray_set_minus(&wanted, &have, &missing, err));
    RMAP_TRY(rmap_ray_set_minus(&self->had, &have, &self->result->lost, err));
    RMAP_TRY(rmap_ray_set_minus(&have, &self->had, &gained, err));
    self->result->n_missing = rmap_ray_set_count(&missing);
    rmap_map_summarise(what->map, &self->result->summary);
    bool complete = missing.n == 0 && wanted.n > 0;
    self->result->is_picked = rmap_map_selection(what->map) != NULL;
    if (self->result->is_picked) { /* what else was picked, the map itself alone knew */
        uint64_t n_have = self->result->summary.n_row[RMAP_TABLE_RAY];
        self->result->n_missing = self->n_had > n_have ? self->n_had - n_have : 0;
        complete = self->was_complete && self->result->n_missing == 0;
    }
    if (mode == RMAP_REPAIR_SAY)
        goto out;
    RMAP_TRY(rmap_repair_remove_histories(self->path, &self->result->done, err));
    RMAP_TRY(tell_gained(self, &gained, err));
    RMAP_TRY(rmap_findings_append(&self->result->left, findings->row, findings->n, err));
    if (self->changed || complete != self->result->summary.complete) {
        RMAP_TRY(rmap_repair_write(what, &none, self->round.tally, complete, err));
        /* Of copies of a piece, an incomplete index takes one and finds no fault in others. */
        RMAP_TRY(rmap_repair_remove(what, &self->result->done, err));
    }
    self->result->summary.complete = complete;
out:
    rmap_ray_set_fini(&have);
    rmap_ray_set_fini(&wanted);
    rmap_ray_set_fini(&missing);
    rmap_ray_set_fini(&gained);
    return st;
}

/* Collective. */
static enum rmap_status mend(struct repair *self, enum step step, struct rmap_error *err)
{
    if (step == STEP_NAMES)
        return mend_names(self, err);
    self->changed = true;
    return step == STEP_INDEX    ? mend_index(self, err)
           : step == STEP_PIECES ? mend_pieces(self, err)
                                 : mend_leftovers(self, err);
}

/* Collective. What a writer at work has in hand is no leftover: it must be gone before anybody
 * looks. Of what is no directory, looking says more. */
static enum rmap_status await_writers(const struct rmap_context *context, const char *path,
                                      struct rmap_map_lock *lock, struct rmap_findings *done,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_listing found = {0};
    struct stat info = {0};
    int is_directory = 0;
    if (context->rank == 0)
        st = rmap_path_look(path, &info, err);
    RMAP_TRY(rmap_agree(context, st, err));
    is_directory = S_ISDIR(info.st_mode);
    RMAP_TRY(RMAP_MPI(MPI_Bcast(&is_directory, 1, MPI_INT, 0, context->comm)));
    if (is_directory && context->rank == 0)
        st = rmap_map_lock_take(path, "repair", lock, err);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    if (is_directory)
        RMAP_TRY(rmap_recover_wait(context, path, &found, err));
    for (size_t i = 0; i < found.n_half && st == RMAP_OK; i++)
        st = rmap_findings_note(done, found.half[i].name, unfinished, err);
    st = rmap_agree(context, st, err);
out:
    rmap_map_listing_fini(&found);
    return st;
}

enum rmap_status rmap_repair_run(const struct rmap_context *context, const char *path,
                                 const struct rmap_run *scene, enum rmap_repair_mode mode,
                                 struct rmap_repair_result *result, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_lock lock = {0};
    struct repair self = {.context = context, .path = path, .scene = scene, .result = result};
    enum step step = STEP_NONE;
    double begun = rmap_clock_seconds();
    if (mode == RMAP_REPAIR_DO)
        RMAP_TRY(await_writers(context, path, &lock, &result->done, err));
    for (int round = 0; round < ROUNDS_MAX; round++) {
        RMAP_TRY(look(&self, &step, err));
        if (round == 0 && context->rank == 0)
            st = remember(&self, err);
        RMAP_TRY(rmap_agree(context, st, err));
        if (step == STEP_NONE || mode == RMAP_REPAIR_SAY || round == ROUNDS_MAX - 1)
            break; /* what is concluded from must have been looked at */
        RMAP_TRY(mend(&self, step, err));
    }
    if (context->rank == 0)
        st = conclude(&self, mode, err);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    result->seconds = rmap_clock_seconds() - begun;
out:
    rmap_map_lock_release(&lock);
    rmap_verify_result_fini(&self.round);
    rmap_findings_fini(&self.before);
    rmap_ray_set_fini(&self.had);
    rmap_free(self.leftover);
    return st;
}
