/* SPDX-License-Identifier: MIT
 *
 * A file of receivers: detectors that were not in the scene when it was traced, to be laid over
 * its map.
 */
#include "io/scene/receivers.h"

#include "io/file/text_file.h"

static const struct rmap_text_kind receivers_file = {"a file of receivers", "YAML text", "",
                                                     (size_t)1 << 20};

enum rmap_status rmap_receivers_open(const char *path, char **text_ret, size_t *nbytes_ret,
                                     struct rmap_error *err)
{
    return rmap_text_file_read(path, &receivers_file, text_ret, nbytes_ret, err);
}
