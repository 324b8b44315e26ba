/* SPDX-License-Identifier: MIT
 *
 * What was made of a file and is kept of it for later starts.
 */
#define _XOPEN_SOURCE 700 /* realpath */
#include "io/file/kept_file.h"

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
#include "version.h"

struct head {
    char magic[8];
    uint64_t key[2];
    uint64_t body_nbytes;
    uint64_t sum[2]; /* XXH3-128 of all before and behind */
};

static const char magic[8] = "rmapkept";

static void put_sum(const struct head *head, const uint8_t *body, uint64_t sum[2])
{
    const XXH128_hash_t part[2] = {XXH3_128bits(head, offsetof(struct head, sum)),
                                   XXH3_128bits(body, (size_t)head->body_nbytes)};
    const XXH128_hash_t whole = XXH3_128bits(part, sizeof part);
    sum[0] = whole.low64;
    sum[1] = whole.high64;
}

enum rmap_status rmap_kept_init(struct rmap_kept *kept, const char *folder, const char *path,
                                const char *how, const char *ending, const void *bytes,
                                size_t nbytes, struct rmap_error *err)
{
    char *source = realpath(path, NULL), program[200];
    if (!source)
        return rmap_error_set(err, RMAP_SYSTEM, "cannot tell where %s is", path);
    const XXH128_hash_t place[2] = {XXH3_128bits(source, strlen(source)),
                                    XXH3_128bits(how, strlen(how))};
    const XXH128_hash_t name = XXH3_128bits(place, sizeof place);
    free(source);
    (void)snprintf(program, sizeof program, "%s %s %s", RMAP_VERSION, RMAP_GIT_REVISION,
                   RMAP_LIBASSIMP);
    const XXH128_hash_t content[2] = {XXH3_128bits(bytes, nbytes),
                                      XXH3_128bits(program, strlen(program))};
    const XXH128_hash_t key = XXH3_128bits(content, sizeof content);
    kept->key[0] = key.low64;
    kept->key[1] = key.high64;
    kept->path = rmap_path_format("%s/%016" PRIx64 "%016" PRIx64 "%s", folder, name.high64,
                                  name.low64, ending);
    return kept->path ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a name");
}

void rmap_kept_fini(struct rmap_kept *kept)
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
        return rmap_error_set(err, RMAP_FORMAT, "it is nothing that a cache keeps, or cut off");
    put_sum(head, bytes + sizeof *head, sum);
    return memcmp(sum, head->sum, sizeof sum) == 0
               ? RMAP_OK
               : rmap_error_set(err, RMAP_FORMAT, "its checksum does not hold");
}

enum rmap_status rmap_kept_read(const struct rmap_kept *kept, uint8_t **bytes_ret,
                                const uint8_t **body_ret, size_t *nbytes_ret,
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
    if (memcmp(head.key, kept->key, sizeof head.key) != 0)
        goto out;
    *bytes_ret = bytes;
    *body_ret = bytes + sizeof head;
    *nbytes_ret = nbytes - sizeof head;
    bytes = NULL;
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

enum rmap_status rmap_kept_write(const struct rmap_kept *kept, const uint8_t *body, size_t nbytes,
                                 struct rmap_error *err)
{
    struct head head = {.key = {kept->key[0], kept->key[1]}, .body_nbytes = nbytes};
    size_t had = 0;
    char *folder =
        rmap_path_format("%.*s", (int)(strrchr(kept->path, '/') - kept->path), kept->path);
    if (!folder)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a name");
    enum rmap_status st = rmap_folder_make_all(folder, &had, err);
    rmap_free(folder);
    if (st != RMAP_OK)
        return st;
    memcpy(head.magic, magic, sizeof magic);
    put_sum(&head, body, head.sum);
    return rmap_whole_file_put(kept->path, put_parts, &(struct parts){&head, body}, err);
}
