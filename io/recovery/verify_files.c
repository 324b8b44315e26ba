/* SPDX-License-Identifier: MIT
 *
 * Which files of a map are missing, or known to nobody.
 */
#include <errno.h>
#include <stdio.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/file/publish.h"
#include "io/map/map_internal.h"
#include "io/map/map_scan.h"
#include "io/recovery/verify_internal.h"

static const struct rmap_piece_info *find_piece(const struct rmap_map_content *content, int shard,
                                                int number)
{
    for (size_t i = 0; i < content->n_piece; i++)
        if (content->piece[i].shard == shard && (number < 0 || content->piece[i].number == number))
            return &content->piece[i];
    return NULL;
}

enum rmap_status rmap_verify_missing_shards(struct rmap_verification *self,
                                            struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map_content *claimed = self->claimed;
    for (size_t i = 0; i < claimed->n_piece && st == RMAP_OK; i++) {
        struct stat info;
        int shard = claimed->piece[i].shard;
        if (i > 0 && claimed->piece[i - 1].shard == shard)
            continue;
        char *path = rmap_path_format("%s/shard-%05d", self->path, shard);
        if (!path)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        bool gone = stat(path, &info) != 0 && errno == ENOENT; /* else its pieces tell */
        rmap_free(path);
        if (!gone)
            continue;
        struct rmap_finding finding;
        char name[32];
        size_t n = 0;
        (void)snprintf(name, sizeof name, "shard-%05d", shard);
        for (size_t k = 0; k < claimed->n_piece; k++)
            n += claimed->piece[k].shard == shard;
        rmap_finding_set(&finding, name, "", "the shard is missing, with %s of it",
                         rmap_counted(n, "piece").text);
        for (size_t k = 0; k < claimed->n_portion; k++)
            if (claimed->portion[k].shard == shard)
                rmap_finding_add_portion(&finding, &claimed->portion[k]);
        st = rmap_findings_add(findings, &finding, err);
        for (size_t k = 0; self->map && k < claimed->n_piece; k++)
            if (claimed->piece[k].shard == shard)
                rmap_verification_flag_piece(self, k, RMAP_PIECE_GONE);
    }
    return st;
}

static enum rmap_status extra_piece(const struct rmap_verification *self,
                                    const struct rmap_piece_name *name,
                                    struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_piece_info info = {.shard = name->shard, .number = name->number};
    struct rmap_map_content content = {0};
    struct rmap_piece_origin origin = {0};
    struct rmap_error why = {0};
    struct rmap_finding finding;
    rmap_piece_name_set(&info);
    const char *shard =
        find_piece(self->claimed, name->shard, -1) ? "" : ", nor any other piece of its shard";
    enum rmap_status st =
        rmap_piece_read(self->path, name->shard, name->number, &content, &origin, &why);
    if (st == RMAP_SYSTEM)
        return rmap_error_set(err, st, "%s", why.text);
    if (st != RMAP_OK)
        rmap_finding_set(&finding, info.name, "",
                         "map.h5 does not list it%s, and it is damaged: %s", shard, why.text);
    else
        rmap_finding_set(&finding, info.name, "",
                         "map.h5 does not list it%s: extra, with %s from ray %llu on", shard,
                         rmap_counted(content.piece[0].n_row[RMAP_TABLE_RAY], "ray").text,
                         content.n_portion ? (unsigned long long)content.portion[0].first_ray : 0);
    rmap_map_content_fini(&content);
    return rmap_findings_add(findings, &finding, err);
}

/* A map in the making has pieces that its index does not know yet: they are part of it. */
enum rmap_status rmap_verify_extra_pieces(struct rmap_verification *self,
                                          const struct rmap_piece_name *name, size_t n,
                                          struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (self->map && !self->map->summary.complete)
        return RMAP_OK;
    for (size_t i = 0; i < n && st == RMAP_OK && self->claimed->n_piece > 0; i++)
        if (!find_piece(self->claimed, name[i].shard, name[i].number))
            st = extra_piece(self, &name[i], findings, err);
    return st;
}
