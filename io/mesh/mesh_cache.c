/* SPDX-License-Identifier: MIT
 *
 * Meshes as they were read before.
 */
#include "io/mesh/mesh_cache.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "io/mesh/bundle_pack.h"

enum { LEFT_OUT = 4 }; /* numbers of struct rmap_mesh_left_out at the body's beginning */

enum rmap_status rmap_mesh_kept_init(struct rmap_kept *kept, const char *path,
                                     const struct rmap_mesh_reading *how, const uint8_t *bytes,
                                     size_t nbytes, struct rmap_error *err)
{
    char text[80];
    (void)snprintf(text, sizeof text, "%a %u", how->scale, how->keep);
    return rmap_kept_init(kept, how->cache, path, text, ".mesh", bytes, nbytes, err);
}

static enum rmap_status unpack(const uint8_t *body, size_t nbytes, struct rmap_mesh **mesh_ret,
                               struct rmap_mesh_left_out *left_out, struct rmap_error *err)
{
    struct rmap_bundle *bundle = NULL;
    uint64_t n[LEFT_OUT];
    if (nbytes < sizeof n)
        return rmap_error_set(err, RMAP_FORMAT, "it is no mesh");
    memcpy(n, body, sizeof n);
    enum rmap_status st = rmap_bundle_unpack(body + sizeof n, nbytes - sizeof n, &bundle, err);
    if (st == RMAP_OK && bundle->n_mesh != 1)
        st = rmap_error_set(err, RMAP_FORMAT, "it holds %zu meshes", bundle->n_mesh);
    if (st == RMAP_OK) {
        *mesh_ret = rmap_mesh_hold(bundle->mesh[0].mesh);
        *left_out = (struct rmap_mesh_left_out){.degenerate = (size_t)n[0],
                                                .undefined = (size_t)n[1],
                                                .first = (size_t)n[2],
                                                .untrue = (size_t)n[3]};
    }
    rmap_bundle_destroy(bundle);
    return st;
}

enum rmap_status rmap_mesh_kept_read(const struct rmap_kept *kept, struct rmap_mesh **mesh_ret,
                                     struct rmap_mesh_left_out *left_out_ret,
                                     struct rmap_error *err)
{
    uint8_t *bytes = NULL;
    const uint8_t *body = NULL;
    size_t nbytes = 0;
    enum rmap_status st = rmap_kept_read(kept, &bytes, &body, &nbytes, err);
    if (bytes) {
        st = unpack(body, nbytes, mesh_ret, left_out_ret, err);
        if (st != RMAP_OK)
            rmap_error_context(err, "%s", kept->path);
    }
    rmap_free(bytes);
    return st;
}

enum rmap_status rmap_mesh_kept_write(const struct rmap_kept *kept, struct rmap_mesh *mesh,
                                      const struct rmap_mesh_left_out *left_out,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bundle *bundle = NULL;
    const uint64_t n[LEFT_OUT] = {left_out->degenerate, left_out->undefined, left_out->first,
                                  left_out->untrue};
    uint8_t *blob = NULL, *body = NULL;
    size_t nbytes = 0;
    RMAP_TRY(rmap_bundle_of_text("", "", NULL, &bundle, err));
    RMAP_TRY(rmap_bundle_add_mesh(bundle, "", mesh, err));
    (void)rmap_mesh_hold(mesh);
    bundle->meshes_complete = 1;
    RMAP_TRY(rmap_bundle_pack(bundle, &blob, &nbytes, err));
    body = rmap_alloc(sizeof n + nbytes, 1);
    if (!body)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a mesh"));
    memcpy(body, n, sizeof n);
    memcpy(body + sizeof n, blob, nbytes);
    st = rmap_kept_write(kept, body, sizeof n + nbytes, err);
out:
    rmap_free(blob);
    rmap_free(body);
    rmap_bundle_destroy(bundle);
    return st;
}
