/* SPDX-License-Identifier: MIT
 *
 * Whether the rays that a map keeps by name are sound.
 */
#include "io/recovery/verify_named.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/map/map_internal.h"
#include "io/map/named_rays.h"

typedef enum rmap_status rmap_damage_visitor(const char *path, const char *file,
                                             const struct rmap_error *why,
                                             struct rmap_findings *findings,
                                             struct rmap_error *err);

static enum rmap_status visit_damaged(const struct rmap_map *map, rmap_damage_visitor *visit,
                                      struct rmap_findings *findings, struct rmap_error *err)
{
    struct rmap_named_rays_list list;
    enum rmap_status st = rmap_named_rays_list(map, &list, err);
    for (size_t i = 0; i < list.n && st == RMAP_OK; i++) {
        struct rmap_id_set set = {0};
        struct rmap_error why = {0};
        enum rmap_status read = rmap_named_rays_read(map, list.row[i].name, &set, NULL, &why);
        char *path = rmap_named_rays_path(map->path, list.row[i].name);
        rmap_id_set_fini(&set);
        if (!path || read == RMAP_SYSTEM)
            st = rmap_error_set(err, RMAP_SYSTEM, "%s", path ? why.text : "out of memory");
        else if (read == RMAP_FORMAT)
            st = visit(path, path + strlen(map->path) + 1, &why, findings, err);
        rmap_free(path);
    }
    rmap_named_rays_list_fini(&list);
    return st;
}

static enum rmap_status tell(const char *path, const char *file, const struct rmap_error *why,
                             struct rmap_findings *findings, struct rmap_error *err)
{
    (void)path;
    return rmap_findings_note(findings, file, why->text, err);
}

enum rmap_status rmap_verify_named_rays(const struct rmap_map *map, struct rmap_findings *findings,
                                        struct rmap_error *err)
{
    return visit_damaged(map, tell, findings, err);
}

static enum rmap_status take_away(const char *path, const char *file, const struct rmap_error *why,
                                  struct rmap_findings *findings, struct rmap_error *err)
{
    (void)why;
    if (unlink(path) != 0)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be removed: %s", path, strerror(errno));
    return rmap_findings_note(findings, file,
                              "removed: it was damaged; raymap select selects again", err);
}

enum rmap_status rmap_remove_damaged_rays(const struct rmap_map *map, struct rmap_findings *done,
                                          struct rmap_error *err)
{
    return visit_damaged(map, take_away, done, err);
}
