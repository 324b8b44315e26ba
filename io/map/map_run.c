/* SPDX-License-Identifier: MIT
 *
 * Writing rays of an open map again: what its files say of their origin stays as it is.
 */
#include "io/map/map_run.h"

#include <string.h>

#include "io/map/map_internal.h"
#include "io/map/provenance.h"
#include "io/mesh/bundle_pack.h"

enum rmap_status rmap_map_run_init(const struct rmap_map *map, size_t space,
                                   enum rmap_encoding encoding, struct rmap_map_run *self,
                                   struct rmap_error *err)
{
    const struct rmap_map_space *of = &map->spaces.space[space];
    *self = (struct rmap_map_run){.bundle = *map->bundle};
    enum rmap_status st = rmap_bundle_unpack(of->options, of->options_nbytes, &self->options, err);
    if (st != RMAP_OK)
        return st;
    self->bundle.options = self->options->options;
    self->run = (struct rmap_run){.bundle = &self->bundle,
                                  .scene = map->scene[space],
                                  .seed = map->summary.seed,
                                  .n_rank = map->summary.n_rank,
                                  .encoding = encoding,
                                  .space = (int32_t)space,
                                  .isa = map->summary.isa,
                                  .embree_version = map->summary.embree_version,
                                  .tracer_revision = map->summary.tracer_revision,
                                  .parent = map->summary.parent,
                                  .selection = map->selection};
    return RMAP_OK;
}

void rmap_map_run_fini(struct rmap_map_run *self)
{
    rmap_bundle_destroy(self->options);
    *self = (struct rmap_map_run){0};
}

enum rmap_status rmap_map_check_scene(const struct rmap_map *map, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < map->spaces.n && st == RMAP_OK; i++) {
        struct rmap_map_run run;
        struct rmap_piece_origin is;
        st = rmap_map_run_init(map, i, RMAP_ENCODING_PLAIN, &run, err);
        if (st == RMAP_OK)
            st = rmap_piece_origin_of(&run.run, &is, err);
        if (st == RMAP_OK && strcmp(is.scene_digest, map->scene_digest) != 0)
            st = rmap_error_set(err, RMAP_FORMAT,
                                "holds another scene (digest %s) than its rays were traced in "
                                "(scene_digest %s)",
                                is.scene_digest, map->scene_digest);
        else if (st == RMAP_OK && strcmp(is.space_digest, map->spaces.space[i].digest) != 0)
            st = rmap_error_set(err, RMAP_FORMAT,
                                "its scene in colour space %zu has digest %s, where /space/digest "
                                "says %s",
                                i, is.space_digest, map->spaces.space[i].digest);
        rmap_map_run_fini(&run);
    }
    return st;
}
