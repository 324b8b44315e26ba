/* SPDX-License-Identifier: MIT
 *
 * Boxes of a scene's objects in the world, kept for later starts.
 */
#include "io/scene/scene_boxes.h"

#include <float.h>
#include <math.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "scene/bounds.h"

/* Of all that boxes are made of. */
static bool digest(const struct rmap_scene *scene, XXH128_hash_t *digest_ret)
{
    XXH3_state_t *state = XXH3_createState();
    if (!state)
        return false;
    (void)XXH3_128bits_reset(state);
    for (size_t i = 0; i < scene->n_geometry; i++) {
        const struct rmap_mesh *mesh =
            scene->geometry[i].kind == RMAP_GEOMETRY_MESH ? scene->geometry[i].mesh : NULL;
        const uint64_t what[2] = {mesh ? 1 + mesh->n_vertex : 0, mesh && mesh->surface};
        (void)XXH3_128bits_update(state, what, sizeof what);
        if (mesh)
            (void)XXH3_128bits_update(state, mesh->vertex, mesh->n_vertex * sizeof *mesh->vertex);
    }
    for (size_t i = 0; i < scene->n_object; i++) {
        const struct rmap_object *object = &scene->object[i];
        (void)XXH3_128bits_update(state, &object->geometry, sizeof object->geometry);
        (void)XXH3_128bits_update(state, &object->to_world, sizeof object->to_world);
    }
    *digest_ret = XXH3_128bits_digest(state);
    (void)XXH3_freeState(state);
    return true;
}

static bool are_finite(const double *number, size_t n)
{
    bool finite = true;
    for (size_t i = 0; i < n; i++)
        finite &= fabs(number[i]) <= DBL_MAX;
    return finite;
}

void rmap_boxes_find(struct rmap_reader *reader, struct rmap_boxes *boxes)
{
    struct rmap_scene *scene = reader->scene;
    const struct rmap_bundle *bundle = reader->bundle;
    const size_t wanted = scene->n_object * sizeof(double[6]);
    const uint8_t *body = NULL;
    size_t nbytes = 0;
    XXH128_hash_t content;
    if (!rmap_bundle_is_kept(bundle) || wanted < RMAP_KEPT_LEAST || !digest(scene, &content) ||
        rmap_kept_init(&boxes->kept, bundle->options.cache, bundle->path, "boxes", ".boxes",
                       &content, sizeof content, NULL) != RMAP_OK ||
        rmap_kept_read(&boxes->kept, &boxes->bytes, &body, &nbytes, NULL) != RMAP_OK ||
        nbytes != wanted || !are_finite((const double *)(const void *)body, 6 * scene->n_object))
        return; /* what is damaged is written anew */
    scene->known_box = (const double *)(const void *)body;
}

void rmap_boxes_keep(struct rmap_reader *reader, enum rmap_status finished,
                     struct rmap_boxes *boxes)
{
    struct rmap_scene *scene = reader->scene;
    const size_t nbytes = scene->n_object * sizeof(double[6]);
    const bool wanted = finished == RMAP_OK && boxes->kept.path && !scene->known_box;
    double(*box)[6] = wanted ? rmap_alloc(nbytes, 1) : NULL;
    for (size_t i = 0; box && i < scene->n_object; i++) {
        const struct rmap_bounds *own = &scene->object_bounds[i];
        const double side[6] = {own->lower.x, own->lower.y, own->lower.z,
                                own->upper.x, own->upper.y, own->upper.z};
        memcpy(box[i], side, sizeof side);
    }
    if (box &&
        are_finite(box[0],
                   6 * scene->n_object)) /* where it cannot be written, meshes and text say so */
        (void)!rmap_kept_write(&boxes->kept, (const uint8_t *)box, nbytes, NULL);
    scene->known_box = NULL;
    rmap_free(box);
    rmap_free(boxes->bytes);
    rmap_kept_fini(&boxes->kept);
}
