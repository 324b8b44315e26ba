/* SPDX-License-Identifier: MIT
 *
 * The versions of the libraries that a map was written with, as its index states them.
 */
#include "io/map/library_versions.h"

#include <assimp/version.h>
#include <hdf5.h>
#include <stdio.h>
#include <xxhash.h>
#include <yaml.h>

#include "base/count.h"
#include "base/late_library.h"
#include "io/codec/zlib_stream.h"

#define ASSIMP(X) X(aiGetVersionMajor) X(aiGetVersionMinor) X(aiGetVersionPatch)
struct assimp {
    ASSIMP(RMAP_LATE_MEMBER)
};
static const char *const assimp_name[] = {ASSIMP(RMAP_LATE_NAME)};

static void set(struct rmap_library_version *library, const char *name, unsigned major,
                unsigned minor, unsigned patch)
{
    library->name = name;
    (void)snprintf(library->version, sizeof library->version, "%u.%u.%u", major, minor, patch);
}

void rmap_library_versions(struct rmap_library_version list[RMAP_LIBRARY_COUNT])
{
    unsigned major = 0, minor = 0, patch = 0, xxhash = XXH_versionNumber();
    int yaml[3] = {0};
    (void)H5get_libversion(&major, &minor, &patch);
    set(&list[0], "HDF5", major, minor, patch);
    list[1].name = "libdeflate";
    (void)snprintf(list[1].version, sizeof list[1].version, "%s",
                   *rmap_libdeflate_version() ? rmap_libdeflate_version() : "not used");
    set(&list[2], "xxHash", xxhash / 10000, xxhash / 100 % 100, xxhash % 100);
    yaml_get_version(&yaml[0], &yaml[1], &yaml[2]);
    set(&list[3], "libyaml", (unsigned)yaml[0], (unsigned)yaml[1], (unsigned)yaml[2]);
    struct assimp by;
    list[4] = (struct rmap_library_version){.name = "Assimp", .version = "not there"};
    if (rmap_late_library(RMAP_LIBASSIMP, "assimp", assimp_name, RMAP_COUNT(assimp_name), &by,
                          NULL) == RMAP_OK)
        set(&list[4], "Assimp", by.aiGetVersionMajor(), by.aiGetVersionMinor(),
            by.aiGetVersionPatch());
}
