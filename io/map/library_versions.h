/* SPDX-License-Identifier: MIT */
#ifndef RMAP_LIBRARY_VERSIONS_H
#define RMAP_LIBRARY_VERSIONS_H

/* A library that files are read and written with, and its version as it runs. */
struct rmap_library_version {
    const char *name;
    char version[32];
};

enum { RMAP_LIBRARY_COUNT = 5 };

void rmap_library_versions(struct rmap_library_version list[RMAP_LIBRARY_COUNT]);

#endif
