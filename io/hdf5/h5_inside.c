/* SPDX-License-Identifier: MIT
 *
 * HDF5 files may say that parts of them lie in other files, of any name: in a stranger's file that
 * could be a secret of the reader's, or a pipe. And that a library is to be loaded for a filter.
 */
#include "io/hdf5/h5_inside.h"

#include <stdbool.h>
#include <string.h>

static herr_t stop_outside(hid_t group, const char *name, const H5L_info_t *link, void *unused)
{
    (void)group;
    (void)name;
    (void)unused;
    return link->type == H5L_TYPE_HARD ? 0 : 1;
}

int rmap_h5_links_inside(hid_t file)
{
    const herr_t outside = H5Lvisit(file, H5_INDEX_NAME, H5_ITER_NATIVE, stop_outside, NULL);
    return outside < 0 ? -1 : outside == 0;
}

/* Component by component, so that none is followed before it was looked at. */
static bool leads_inside(hid_t file, const char *path)
{
    H5L_info_t link;
    char part[1024]; /* no memory is asked for, which might be short */
    bool inside = strlen(path) < sizeof part;
    if (inside)
        memcpy(part, path, strlen(path) + 1);
    for (char *at = part; inside && *at;) {
        at += strspn(at, "/");
        at += strcspn(at, "/");
        const char rest = *at;
        *at = '\0';
        inside = H5Lget_info(file, part, &link, H5P_DEFAULT) >= 0 && link.type == H5L_TYPE_HARD;
        *at = rest;
    }
    return inside;
}

/* HDF5's own filters have numbers below those that it loads libraries for. */
static bool has_own_filters(hid_t create)
{
    const int n = H5Pget_layout(create) == H5D_CHUNKED ? H5Pget_nfilters(create) : 0;
    bool own = n >= 0;
    for (int k = 0; own && k < n; k++) {
        unsigned flags, config;
        size_t n_value = 0;
        const H5Z_filter_t filter =
            H5Pget_filter2(create, (unsigned)k, &flags, &n_value, NULL, 0, NULL, &config);
        own = filter >= 0 && filter < H5Z_FILTER_RESERVED;
    }
    return own;
}

static bool holds_its_data(hid_t set)
{
    const hid_t create = H5Dget_create_plist(set);
    const bool inside =
        create >= 0 && H5Pget_layout(create) != H5D_VIRTUAL &&
        (H5Pget_layout(create) != H5D_CONTIGUOUS || H5Pget_external_count(create) == 0) &&
        has_own_filters(create);
    if (create >= 0)
        (void)H5Pclose(create);
    return inside;
}

hid_t rmap_h5_dataset(hid_t file, const char *path)
{
    const hid_t set =
        leads_inside(file, path) ? H5Dopen2(file, path, H5P_DEFAULT) : H5I_INVALID_HID;
    if (set < 0 || holds_its_data(set))
        return set;
    (void)H5Dclose(set);
    return H5I_INVALID_HID;
}
