/* SPDX-License-Identifier: MIT
 *
 * What an index says of the scene: its text and meshes, the names of what columns count, and its
 * light.
 */
#ifndef RMAP_INDEX_SCENE_H
#define RMAP_INDEX_SCENE_H

#include "io/map/map_format.h"
#include "io/map/map_writer.h"

/* Names lie at different offsets of different structs: a list of them is gathered by address. */
struct rmap_name_list {
    const char *path, *description;
    const void *first; /* struct 0 */
    size_t n, struct_nbytes, name_offset;
};

/* The lists of names of /name; they borrow from the scene. */
enum { RMAP_NAME_LISTS = 7 };
void rmap_index_name_lists(const struct rmap_scene *scene,
                           struct rmap_name_list list[RMAP_NAME_LISTS]);
const char *rmap_name_of(const struct rmap_name_list *list, size_t i);

/* What else /name has of struct rmap_object, of struct rmap_group. */
struct rmap_field_table rmap_index_object_fields(void);
struct rmap_field_table rmap_index_group_fields(void);

/* emitted: [sources] rays that each source's flux is shared out over. */
enum rmap_status rmap_index_scene_write(struct rmap_h5 *h5, const struct rmap_run *run,
                                        const double *emitted,
                                        struct rmap_error *err) RMAP_MUST_USE;

#endif
