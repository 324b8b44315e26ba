/* SPDX-License-Identifier: MIT
 *
 * The little of HDF5 that a map needs, with its error stack turned into rmap_error.
 */
#include "io/hdf5/h5.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/count.h"
#include "io/codec/codec.h"
#include "io/file/seal.h"
#include "io/hdf5/h5_inside.h"

/* Before any call of a thread: no printing. The error stack is per thread. */
static void begin(void)
{
    (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    (void)H5Eclear2(H5E_DEFAULT);
}

struct innermost {
    char text[400];
    bool is_system; /* a call of the system failed, whatever the file holds */
};

static herr_t take_innermost(unsigned n, const H5E_error2_t *error, void *context)
{
    struct innermost *found = context;
    static const char reason[] = "error message = '";
    if (n > 0)
        return 0;
    /* Of a failed system call HDF5 tells file, time and address too, over several lines. */
    const char *from = strstr(error->desc, reason);
    if (from) {
        found->is_system = true;
        from += sizeof reason - 1;
        (void)snprintf(found->text, sizeof found->text, "%.*s", (int)strcspn(from, "'"), from);
    } else {
        (void)snprintf(found->text, sizeof found->text, "HDF5: %s: %s", error->func_name,
                       error->desc);
    }
    return 0;
}

enum rmap_status rmap_h5_fail(struct rmap_h5 *h5, const char *what, struct rmap_error *err)
{
    struct innermost found = {"", false};
    (void)H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_innermost, &found);
    (void)H5Eclear2(H5E_DEFAULT);
    if (h5->on_error == RMAP_SYSTEM)
        h5->failed = true;
    enum rmap_status st = found.is_system ? RMAP_SYSTEM : h5->on_error;
    return rmap_error_set(err, st, "%s: %s failed (%s)", h5->path, what,
                          found.text[0] ? found.text : "HDF5: missing, or of another type");
}

enum rmap_status rmap_h5_check_alive(struct rmap_h5 *h5, struct rmap_error *err)
{
    if (h5->failed)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: an earlier write failed", h5->path);
    begin();
    return RMAP_OK;
}

struct rmap_h5_unit rmap_h5_unit_of(enum rmap_unit unit, const char *length, double length_m)
{
    switch (unit) {
    case RMAP_UNIT_LENGTH:
        return (struct rmap_h5_unit){length, length_m, {1}};
    case RMAP_UNIT_NM:
        return (struct rmap_h5_unit){"nm", 1e-9, {1}};
    case RMAP_UNIT_NS:
        return (struct rmap_h5_unit){"ns", 1e-9, {[2] = 1}};
    case RMAP_UNIT_ONE:
        break;
    }
    return (struct rmap_h5_unit){"1", 1.0, {0}};
}

hid_t rmap_h5_type(enum rmap_element element)
{
    switch (element) {
    case RMAP_U8:
        return H5T_STD_U8LE;
    case RMAP_U16:
        return H5T_STD_U16LE;
    case RMAP_I16:
        return H5T_STD_I16LE;
    case RMAP_U32:
        return H5T_STD_U32LE;
    case RMAP_I32:
        return H5T_STD_I32LE;
    case RMAP_U64:
        return H5T_STD_U64LE;
    case RMAP_F32:
        return H5T_IEEE_F32LE;
    case RMAP_F64:
        break;
    }
    return H5T_IEEE_F64LE;
}

static enum rmap_status set_path(struct rmap_h5 *h5, const char *path, enum rmap_status on_error,
                                 struct rmap_error *err)
{
    *h5 = (struct rmap_h5){.file = H5I_INVALID_HID, .on_error = on_error};
    h5->path = rmap_strdup(path);
    return h5->path ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory");
}

enum rmap_status rmap_h5_create(struct rmap_h5 *h5, const char *path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    hid_t create = H5I_INVALID_HID, access = H5I_INVALID_HID;
    begin();
    RMAP_TRY(set_path(h5, path, RMAP_SYSTEM, err));
    create = H5Pcreate(H5P_FILE_CREATE);
    access = H5Pcreate(H5P_FILE_ACCESS);
    if (create < 0 || access < 0 || H5Pset_obj_track_times(create, false) < 0 ||
        H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_V110) < 0 ||
        H5Pset_fclose_degree(access, H5F_CLOSE_SEMI) < 0 ||
        (h5->file = H5Fcreate(path, H5F_ACC_EXCL, create, access)) < 0)
        st = rmap_h5_fail(h5, "creating the file", err);
out:
    if (create >= 0)
        (void)H5Pclose(create);
    if (access >= 0)
        (void)H5Pclose(access);
    if (st != RMAP_OK)
        rmap_h5_drop(h5);
    return st;
}

/* HDF5 refuses a file that others in the process, such as h5py, have open to be closed in another
 * way: theirs is tried, HDF5's own first. */
static hid_t open_as_others(const char *path, hid_t access)
{
    static const H5F_close_degree_t degree[] = {H5F_CLOSE_WEAK, H5F_CLOSE_STRONG, H5F_CLOSE_SEMI};
    hid_t file = H5I_INVALID_HID;
    for (size_t k = 0; access >= 0 && file < 0 && k < RMAP_COUNT(degree); k++) {
        struct innermost why = {"", false};
        if (H5Pset_fclose_degree(access, degree[k]) >= 0)
            file = H5Fopen(path, H5F_ACC_RDONLY, access);
        if (file < 0)
            (void)H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_innermost, &why);
        if (!strstr(why.text, "close degree"))
            break;
    }
    return file;
}

enum rmap_status rmap_h5_open(struct rmap_h5 *h5, const char *path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    hid_t access = H5I_INVALID_HID;
    int inside = 0;
    begin();
    RMAP_TRY(set_path(h5, path, RMAP_FORMAT, err));
    RMAP_TRY(rmap_seal_check(path, err));
    access = H5Pcreate(H5P_FILE_ACCESS);
    h5->file = open_as_others(path, access);
    if (h5->file < 0)
        st = rmap_h5_fail(h5, "opening it as an HDF5 file", err);
    RMAP_TRY(st);
    inside = rmap_h5_links_inside(h5->file);
    if (inside < 0)
        st = rmap_h5_fail(h5, "looking at its links", err);
    else if (inside == 0)
        st = rmap_error_set(
            err, RMAP_FORMAT,
            "%s has links that lead out of it, which no ray map has: it is not read", path);
out:
    if (access >= 0)
        (void)H5Pclose(access);
    if (st != RMAP_OK)
        rmap_h5_drop(h5);
    return st;
}

enum rmap_status rmap_h5_close(struct rmap_h5 *h5, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_h5_check_alive(h5, err));
    if (H5Fflush(h5->file, H5F_SCOPE_LOCAL) < 0 || H5Fclose(h5->file) < 0)
        return rmap_h5_fail(h5, "flushing and closing", err);
    h5->file = H5I_INVALID_HID;
    rmap_h5_drop(h5);
out:
    return st;
}

/* What a failure left open would keep the file open. */
static void close_left(hid_t file)
{
    hid_t left[16];
    ssize_t n = 1;
    for (int tries = 0; n > 0 && tries < 1000; tries++) {
        n = H5Fget_obj_ids(file, H5F_OBJ_LOCAL | (H5F_OBJ_ALL & ~H5F_OBJ_FILE), RMAP_COUNT(left),
                           left);
        for (ssize_t k = 0; k < n; k++)
            (void)H5Idec_ref(left[k]);
    }
}

void rmap_h5_drop(struct rmap_h5 *h5)
{
    if (h5->path && h5->file >= 0 && !h5->failed) {
        begin();
        close_left(h5->file);
        (void)H5Fclose(h5->file);
    }
    rmap_free(h5->path);
    *h5 = (struct rmap_h5){.file = H5I_INVALID_HID, .failed = h5->failed};
}

enum rmap_status rmap_h5_group(struct rmap_h5 *h5, const char *path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_h5_check_alive(h5, err));
    hid_t create = H5Pcreate(H5P_GROUP_CREATE);
    hid_t group = H5I_INVALID_HID;
    if (create >= 0 && H5Pset_obj_track_times(create, false) >= 0)
        group = H5Gcreate2(h5->file, path, H5P_DEFAULT, create, H5P_DEFAULT);
    if (group < 0 || H5Gclose(group) < 0)
        st = rmap_h5_fail(h5, path, err);
    if (create >= 0)
        (void)H5Pclose(create);
out:
    return st;
}
