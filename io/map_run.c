/* SPDX-License-Identifier: MIT */
#include "io/map_run.h"

#include "io/map_internal.h"

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
                                  .selection = map->selection};
    return RMAP_OK;
}

void rmap_map_run_fini(struct rmap_map_run *self)
{
    rmap_bundle_destroy(self->options);
    *self = (struct rmap_map_run){0};
}
