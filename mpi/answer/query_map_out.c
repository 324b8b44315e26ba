/* SPDX-License-Identifier: MIT
 *
 * The answer to a query as a ray map of its own.
 */
#include "mpi/answer/query_map_out.h"

#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/map/map_directory.h"
#include "io/map/map_json.h"
#include "io/map/map_lock.h"
#include "io/map/map_reader.h"
#include "io/map/map_run.h"
#include "io/write/index_writer.h"
#include "mpi/answer/query_rays_out.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/map_name.h"
#include "mpi/command/output.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/progress.h"

struct writing {
    struct rmap_map_lock lock; /* rank 0: of the new map */
    const struct rmap_map_answer *answer;
    enum rmap_encoding encoding;
    struct rmap_selection *selection;
    struct rmap_tally *tally;
    struct rmap_map_run run;         /* in the map's first colour space, for the index */
    struct rmap_map_content content; /* rank 0 */
    double begun;
    bool made; /* rank 0: a map stands there that this query began */
};

bool rmap_map_answer_is(const char *path)
{
    static const char suffix[] = ".raymap";
    size_t n = strlen(path);
    struct stat info;
    while (n > 1 && path[n - 1] == '/')
        n--;
    return (n > sizeof suffix - 1 &&
            strncmp(path + n - (sizeof suffix - 1), suffix, sizeof suffix - 1) == 0) ||
           (!rmap_query_rays_named(path) && stat(path, &info) == 0 && S_ISDIR(info.st_mode));
}

/* What the new map says of its rays: the questions before, and this one. */
static enum rmap_status describe(struct writing *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map_answer *answer = self->answer;
    const struct rmap_selection *before = rmap_map_selection(answer->map);
    char name[RMAP_MAP_NAME_LEN];
    rmap_map_name(answer->from, name);
    struct rmap_selection_step step = {.map = rmap_strdup(name),
                                       .criterion = rmap_strdup(answer->spelled),
                                       .answer = rmap_strdup(answer->answer)};
    struct rmap_map_summary summary;
    size_t n_source = rmap_map_scene(answer->map)->n_source;
    if (!step.map || !step.criterion || !step.answer)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for where rays come from"));
    if (before) {
        RMAP_TRY(rmap_selection_copy(before, &self->selection, err));
    } else {
        RMAP_TRY(rmap_selection_create(n_source, &self->selection, err));
        rmap_map_summarise(answer->map, &summary);
        rmap_digest_text(summary.digest, self->selection->digest);
        self->selection->complete = summary.complete;
        self->selection->n_ray = summary.n_row[RMAP_TABLE_RAY];
        memcpy(self->selection->emitted, rmap_map_emitted(answer->map),
               n_source * sizeof *self->selection->emitted);
    }
    RMAP_TRY(rmap_selection_ask(self->selection, &step, err));
out:
    rmap_free(step.map);
    rmap_free(step.criterion);
    rmap_free(step.answer);
    return st;
}

static enum rmap_status write_index(const struct writing *self,
                                    const struct rmap_map_content *content,
                                    const struct rmap_tally *tally, bool complete,
                                    struct rmap_error *err)
{
    const struct rmap_index index = {.run = &self->run.run,
                                     .before = self->answer->map,
                                     .content = content,
                                     .tally = tally,
                                     .complete = complete};
    return rmap_index_write_content(self->answer->to, &index, err);
}

/* Collective. A map without rays: what is left when writing is killed. */
static enum rmap_status prepare(const struct rmap_context *context, struct writing *self,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map_answer *answer = self->answer;
    const struct rmap_map *map = answer->map;
    self->encoding = answer->encoding;
    if (self->encoding == RMAP_ENCODING_COUNT)
        self->encoding = rmap_map_n_piece(map) > 0
                             ? (enum rmap_encoding)rmap_map_piece(map, 0)->encoding
                             : RMAP_ENCODING_PLAIN;
    if (rmap_same_place(answer->from, answer->to))
        RMAP_TRY(rmap_error_set(err, RMAP_USAGE,
                                "%s is %s: the answer cannot take the place of the map that is "
                                "asked; choose another name",
                                answer->to, answer->from));
    RMAP_TRY(describe(self, err));
    RMAP_TRY(rmap_tally_create(rmap_map_scene(map), &self->tally, err));
    if (context->rank != 0)
        goto out;
    RMAP_TRY(rmap_map_run_init(map, 0, self->encoding, &self->run, err));
    self->run.run.selection = self->selection;
    RMAP_TRY(rmap_map_create(answer->to, answer->force, "query", &self->lock, err));
    self->made = true;
    RMAP_TRY(write_index(self, NULL, NULL, false, err));
out:
    return rmap_agree(context, st, err);
}

/* Rank 0. */
static enum rmap_status summarise(const struct rmap_context *context, const struct writing *self,
                                  struct rmap_error *err)
{
    const struct rmap_map_answer *answer = self->answer;
    struct rmap_map *made = NULL;
    struct rmap_map_summary summary;
    char digest[33];
    enum rmap_status st = rmap_map_open(answer->to, &made, err);
    if (st != RMAP_OK)
        return st;
    rmap_map_summarise(made, &summary);
    rmap_digest_text(summary.digest, digest);
    double seconds = rmap_clock_seconds() - self->begun;
    if (context->json)
        st = rmap_json_print(
            rmap_json_of_map(
                json_pack("{s:s, s:s, s:s, s:s, s:I, s:I, s:I, s:s, s:f}", "output", answer->to,
                          "criterion", answer->criterion, "answer", answer->answer, "encoding",
                          rmap_encoding_name(self->encoding), "rays",
                          (json_int_t)summary.n_row[RMAP_TABLE_RAY], "segments",
                          (json_int_t)summary.n_row[RMAP_TABLE_SEGMENT], "bytes",
                          (json_int_t)summary.nbytes, "digest", digest, "seconds", seconds),
                answer->map),
            stdout, err);
    else if (!context->quiet)
        printf("%s: %s, %s, %s, %.1f MB\ndigest %s\n", answer->to,
               rmap_counted(summary.n_row[RMAP_TABLE_RAY], "ray").text,
               rmap_counted(summary.n_row[RMAP_TABLE_SEGMENT], "segment").text,
               rmap_encoding_name(self->encoding), 1e-6 * (double)summary.nbytes, digest);
    rmap_map_close(made);
    return st;
}

enum rmap_status rmap_map_answer_write(const struct rmap_context *context,
                                       const struct rmap_map_answer *answer, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct writing self = {.answer = answer, .begun = rmap_clock_seconds()};
    RMAP_TRY(prepare(context, &self, err));
    const struct rmap_pick_plan plan = {.map = answer->map,
                                        .pick = answer->pick,
                                        .deal = answer->deal == RMAP_DEAL_LOCAL ? RMAP_DEAL_LOCAL
                                                                                : RMAP_DEAL_SHARES,
                                        .to = answer->to,
                                        .encoding = self.encoding,
                                        .selection = self.selection};
    RMAP_TRY(rmap_pick_run(context, &plan, &self.content, self.tally, err));
    if (context->rank == 0)
        st = write_index(&self, &self.content, self.tally, true, err);
    if (context->rank == 0 && st == RMAP_OK)
        st = summarise(context, &self, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    if (st != RMAP_OK && self.made)
        rmap_discard_map(answer->to, err);
    rmap_map_lock_release(&self.lock);
    rmap_map_run_fini(&self.run);
    rmap_map_content_fini(&self.content);
    rmap_tally_destroy(self.tally);
    rmap_selection_destroy(self.selection);
    return st;
}
