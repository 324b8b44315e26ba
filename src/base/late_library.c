/* SPDX-License-Identifier: MIT */
#include "base/late_library.h"

#include <dlfcn.h>
#include <string.h>

enum rmap_status rmap_late_library(const char *soname, const char *need, const char *const *name,
                                   size_t n, void *functions, struct rmap_error *err)
{
    void *library = dlopen(soname, RTLD_LAZY | RTLD_LOCAL);
    for (size_t i = 0; library && i < n; i++) {
        void *symbol = dlsym(library, name[i]);
        if (!symbol)
            library = NULL;
        /* POSIX's way from an object pointer to a function pointer. */
        memcpy((char *)functions + i * sizeof symbol, &symbol, sizeof symbol);
    }
    const char *why = library ? NULL : dlerror();
    return library ? RMAP_OK
                   : rmap_error_set(err, RMAP_SYSTEM, "%s, which cannot be loaded: %s", need,
                                    why ? why : "unknown");
}
