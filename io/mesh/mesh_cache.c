/* SPDX-License-Identifier: MIT
 *
 * Meshes as they were read before.
 */
#define _XOPEN_SOURCE 700 /* realpath */
#include "io/mesh/mesh_cache.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/input_file.h"
#include "io/file/publish.h"
#include "io/file/whole_file.h"
#include "io/mesh/bundle_pack.h"
#include "version.h"

struct head {
    char magic[8];
    uint64_t key[2];      /* XXH3-128 of the mesh's file, with the program's versions */
    uint64_t left_out[4]; /* as of struct rmap_mesh_left_out */
    uint64_t body_nbytes;
    uint64_t sum[2]; /* XXH3-128 of all before and behind */
};

static const char magic[8] = "rmapmesh";

static void put_sum(const struct head *head, const uint8_t *body, uint64_t sum[2])
{
    const XXH128_hash_t part[2] = {XXH3_128bits(head, offsetof(struct head, sum)),
                                   XXH3_128bits(body, (size_t)head->body_nbytes)};
    const XXH128_hash_t whole = XXH3_128bits(part, sizeof part);
    sum[0] = whole.low64;
    sum[1] = whole.high64;
}

enum rmap_status rmap_mesh_kept_init(struct rmap_mesh_kept *kept, const char *path,
                                     const struct rmap_mesh_reading *how, const uint8_t *bytes,
                                     size_t nbytes, struct rmap_error *err)
{
    char *source = realpath(path, NULL), text[200];
    if (!source)
        return rmap_error_set(err, RMAP_SYSTEM, "cannot tell where %s is", path);
    (void)snprintf(text, sizeof text, "%a %u", how->scale, how->keep);
    const XXH128_hash_t place[2] = {XXH3_128bits(source, strlen(source)),
                                    XXH3_128bits(text, strlen(text))};
    const XXH128_hash_t name = XXH3_128bits(place, sizeof place);
    free(source);
    (void)snprintf(text, sizeof text, "%s %s %s", RMAP_VERSION, RMAP_GIT_REVISION, RMAP_LIBASSIMP);
    const XXH128_hash_t content[2] = {XXH3_128bits(bytes, nbytes),
                                      XXH3_128bits(text, strlen(text))};
    const XXH128_hash_t key = XXH3_128bits(content, sizeof content);
    kept->key[0] = key.low64;
    kept->key[1] = key.high64;
    kept->path = rmap_path_format("%s/%016" PRIx64 "%016" PRIx64 ".mesh", how->cache, name.high64,
                                  name.low64);
    return kept->path ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a name");
}

void rmap_mesh_kept_fini(struct rmap_mesh_kept *kept)
{
    rmap_free(kept->path);
}

/* The first bytes may be of anything. */
static enum rmap_status check(const struct head *head, const uint8_t *bytes, size_t nbytes,
                              struct rmap_error *err)
{
    uint64_t sum[2];
    if (nbytes < sizeof *head || memcmp(head->magic, magic, sizeof magic) != 0 ||
        head->body_nbytes != nbytes - sizeof *head)
        return rmap_error_set(err, RMAP_FORMAT, "it is no mesh of a cache, or cut off");
    put_sum(head, bytes + sizeof *head, sum);
    return memcmp(sum, head->sum, sizeof sum) == 0
               ? RMAP_OK
               : rmap_error_set(err, RMAP_FORMAT, "its checksum does not hold");
}

static enum rmap_status unpack(const struct head *head, const uint8_t *bytes, size_t nbytes,
                               struct rmap_mesh **mesh_ret, struct rmap_mesh_left_out *left_out,
                               struct rmap_error *err)
{
    struct rmap_bundle *bundle = NULL;
    enum rmap_status st =
        rmap_bundle_unpack(bytes + sizeof *head, nbytes - sizeof *head, &bundle, err);
    if (st == RMAP_OK && bundle->n_mesh != 1)
        st = rmap_error_set(err, RMAP_FORMAT, "it holds %zu meshes", bundle->n_mesh);
    if (st == RMAP_OK) {
        *mesh_ret = rmap_mesh_hold(bundle->mesh[0].mesh);
        *left_out = (struct rmap_mesh_left_out){
            .degenerate = (size_t)head->left_out[0],
            .undefined = (size_t)head->left_out[1],
            .first = (size_t)head->left_out[2],
            .untrue = (size_t)head->left_out[3],
        };
    }
    rmap_bundle_destroy(bundle);
    return st;
}

enum rmap_status rmap_mesh_kept_read(const struct rmap_mesh_kept *kept, struct rmap_mesh **mesh_ret,
                                     struct rmap_mesh_left_out *left_out_ret,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct stat info;
    struct head head = {0};
    uint8_t *bytes = NULL;
    size_t nbytes = 0;
    RMAP_TRY(rmap_path_look(kept->path, &info, err));
    if (info.st_mode == 0)
        return RMAP_OK;
    RMAP_TRY(rmap_input_file_read(kept->path, SIZE_MAX - 1, &bytes, &nbytes, err));
    memcpy(&head, bytes, nbytes < sizeof head ? nbytes : sizeof head);
    RMAP_TRY(check(&head, bytes, nbytes, err));
    if (memcmp(head.key, kept->key, sizeof head.key) == 0)
        st = unpack(&head, bytes, nbytes, mesh_ret, left_out_ret, err);
out:
    rmap_free(bytes);
    if (st != RMAP_OK)
        rmap_error_context(err, "%s", kept->path);
    return st;
}

struct parts {
    const struct head *head;
    const uint8_t *body;
};

static enum rmap_status put_parts(const void *context, FILE *file, struct rmap_error *err)
{
    const struct parts *parts = context;
    (void)err; /* the file keeps its errors */
    (void)fwrite(parts->head, sizeof *parts->head, 1, file);
    (void)fwrite(parts->body, 1, (size_t)parts->head->body_nbytes, file);
    return RMAP_OK;
}

enum rmap_status rmap_mesh_kept_write(const struct rmap_mesh_kept *kept, struct rmap_mesh *mesh,
                                      const struct rmap_mesh_left_out *left_out,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bundle *bundle = NULL;
    struct head head = {
        .key = {kept->key[0], kept->key[1]},
        .left_out = {left_out->degenerate, left_out->undefined, left_out->first, left_out->untrue}};
    uint8_t *body = NULL;
    size_t nbytes = 0, had = 0;
    char *folder =
        rmap_path_format("%.*s", (int)(strrchr(kept->path, '/') - kept->path), kept->path);
    if (!folder)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a name"));
    RMAP_TRY(rmap_folder_make_all(folder, &had, err));
    RMAP_TRY(rmap_bundle_of_text("", "", NULL, &bundle, err));
    RMAP_TRY(rmap_bundle_add_mesh(bundle, "", mesh, err));
    (void)rmap_mesh_hold(mesh);
    bundle->meshes_complete = 1;
    RMAP_TRY(rmap_bundle_pack(bundle, &body, &nbytes, err));
    memcpy(head.magic, magic, sizeof magic);
    head.body_nbytes = nbytes;
    put_sum(&head, body, head.sum);
    st = rmap_whole_file_put(kept->path, put_parts, &(struct parts){&head, body}, err);
out:
    rmap_free(folder);
    rmap_free(body);
    rmap_bundle_destroy(bundle);
    return st;
}
