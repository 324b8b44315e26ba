/* SPDX-License-Identifier: MIT
 *
 * The classes of paths with most flux, for statistics of each.
 */
#include "mpi/scan/stats_paths_run.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "mpi/parallel/agree.h"

/* Rank 0's classes as bytes: the key and the name of each, with its final 0. */
static enum rmap_status pack(const struct rmap_path_report *report, uint8_t **bytes_ret,
                             size_t *nbytes_ret, struct rmap_error *err)
{
    const struct rmap_scene *scene = report->scene;
    size_t nbytes = 0, at = 0;
    for (size_t k = 0; k < report->n_row; k++)
        nbytes += sizeof(struct rmap_key) + strlen(scene->source[report->row[k].source].name) +
                  strlen(report->row[k].sequence) + sizeof ": ";
    uint8_t *bytes = rmap_alloc(nbytes + 1, 1);
    if (!bytes)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for classes of paths");
    for (size_t k = 0; k < report->n_row; k++) {
        const struct rmap_path_row *row = &report->row[k];
        memcpy(bytes + at, &row->key, sizeof row->key);
        at += sizeof row->key;
        at += 1 + (size_t)snprintf((char *)bytes + at, nbytes - at, "%s: %s",
                                   scene->source[row->source].name, row->sequence);
    }
    *bytes_ret = bytes;
    *nbytes_ret = nbytes;
    return RMAP_OK;
}

static enum rmap_status unpack(const uint8_t *bytes, size_t nbytes, size_t most,
                               struct rmap_stats_paths *paths, struct rmap_error *err)
{
    paths->key = rmap_alloc(most + 1, sizeof *paths->key);
    paths->name = rmap_alloc(most + 1, sizeof *paths->name);
    if (!paths->key || !paths->name)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for classes of paths");
    for (size_t at = 0; at < nbytes && paths->n < most; paths->n++) {
        memcpy(&paths->key[paths->n], bytes + at, sizeof *paths->key);
        at += sizeof *paths->key;
        paths->name[paths->n] = rmap_strdup((const char *)bytes + at);
        if (!paths->name[paths->n])
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for classes of paths");
        at += strlen(paths->name[paths->n]) + 1;
    }
    return RMAP_OK;
}

enum rmap_status rmap_stats_paths_run(const struct rmap_context *context,
                                      const struct rmap_stats_paths_question *question,
                                      struct rmap_stats_paths *paths, struct rmap_error *err)
{
    const struct rmap_quantities *quantities = question->quantities;
    const bool until = quantities->of_registrations && quantities->detector.span == 1;
    struct rmap_path_report *report = NULL;
    uint8_t *bytes = NULL;
    size_t nbytes = 0;
    struct rmap_path_request request = {.map = quantities->map,
                                        .overlay = question->overlay,
                                        .criterion = question->criterion,
                                        .which = until ? question->which : NULL,
                                        .view = {.level = question->level,
                                                 .until_detector = until,
                                                 .detector = until ? quantities->detector.low : -1},
                                        .top = question->top,
                                        .most_classes = RMAP_PATH_CLASSES_MOST};
    enum rmap_status st =
        rmap_path_keys_create(quantities->scene, &request.view, &paths->keys, err);
    RMAP_TRY(rmap_agree(context, st, err));
    request.keys = paths->keys;
    RMAP_TRY(rmap_path_run(context, &request, &report, err));
    if (report)
        st = pack(report, &bytes, &nbytes, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_broadcast_blob(context, &bytes, &nbytes, err));
    st = rmap_agree(context, unpack(bytes, nbytes, (size_t)question->top, paths, err), err);
out:
    rmap_path_report_destroy(report);
    rmap_free(bytes);
    return st;
}
