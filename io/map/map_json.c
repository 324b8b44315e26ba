/* SPDX-License-Identifier: MIT
 *
 * What every JSON document about a map says of it: whether it is all that was asked for.
 */
#include "io/map/map_json.h"

#include "io/map/map_dim.h"
#include "io/map/map_rays.h"

json_t *rmap_json_of_map(json_t *document, const struct rmap_map *map)
{
    struct rmap_map_summary summary;
    uint64_t asked = 0;
    rmap_map_summarise(map, &summary);
    json_t *n = rmap_rays_asked(map, &asked) ? json_integer((json_int_t)asked) : json_null();
    if (document &&
        json_object_set_new(document, "complete", json_boolean(rmap_map_is_whole(map))) == 0 &&
        json_object_set(document, "rays_asked", n) == 0 &&
        json_object_set_new(document, "rays_traced",
                            json_integer((json_int_t)summary.n_row[RMAP_TABLE_RAY])) == 0) {
        json_decref(n);
        rmap_json_add_dim(document, map);
        return document;
    }
    json_decref(n);
    json_decref(document);
    return NULL;
}

void rmap_json_add_part(json_t *document, const struct rmap_map_part *part)
{
    if (document && part && part->relative > 0.0)
        (void)json_object_set_new(document, "until",
                                  json_pack("{s:f, s:b, s:I, s:I}", "relative", part->relative,
                                            "reached", (int)part->is_reached, "rays",
                                            (json_int_t)part->n_ray, "of_rays",
                                            (json_int_t)part->all_rays));
}
