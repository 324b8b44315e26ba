/* SPDX-License-Identifier: MIT
 *
 * The functions of HDF5 that the program calls, each of which can be made to fail. The faults test
 * compares this list with what the program imports, so that none is forgotten.
 */
#include <dlfcn.h>
#include <hdf5.h>
#include <string.h>

#include "fault_plan.h"

/* name(parameters) passes its arguments on, or returns its error value when it is its turn. */
#define CALL_OR(error, type, name, parameters, arguments)                                          \
    type name parameters                                                                           \
    {                                                                                              \
        static __typeof__(name) *real;                                                             \
        if (!real) {                                                                               \
            void *found = dlsym(RTLD_NEXT, #name);                                                 \
            memcpy(&real, &found, sizeof found);                                                   \
        }                                                                                          \
        if (fault_decide(#name, "") != FAULT_NONE)                                                 \
            return error;                                                                          \
        return real arguments;                                                                     \
    }
#define CALL(type, name, parameters, arguments) CALL_OR(-1, type, name, parameters, arguments)
#define CALL1(type, name, A)                    CALL(type, name, (A a), (a))
#define CALL2(type, name, A, B)                 CALL(type, name, (A a, B b), (a, b))
#define CALL3(type, name, A, B, C)              CALL(type, name, (A a, B b, C c), (a, b, c))
#define CALL4(type, name, A, B, C, D)           CALL(type, name, (A a, B b, C c, D d), (a, b, c, d))
#define CALL5(type, name, A, B, C, D, E)                                                           \
    CALL(type, name, (A a, B b, C c, D d, E e), (a, b, c, d, e))
#define CALL6(type, name, A, B, C, D, E, F)                                                        \
    CALL(type, name, (A a, B b, C c, D d, E e, F f), (a, b, c, d, e, f))
#define CALL7(type, name, A, B, C, D, E, F, G)                                                     \
    CALL(type, name, (A a, B b, C c, D d, E e, F f, G g), (a, b, c, d, e, f, g))
#define CALL8(type, name, A, B, C, D, E, F, G, H)                                                  \
    CALL(type, name, (A a, B b, C c, D d, E e, F f, G g, H h), (a, b, c, d, e, f, g, h))

CALL1(herr_t, H5Aclose, hid_t)
CALL6(hid_t, H5Acreate2, hid_t, const char *, hid_t, hid_t, hid_t, hid_t)
CALL2(htri_t, H5Aexists, hid_t, const char *)
CALL1(hid_t, H5Aget_space, hid_t)
CALL4(htri_t, H5Aexists_by_name, hid_t, const char *, const char *, hid_t)
CALL1(hid_t, H5Aget_type, hid_t)
CALL3(hid_t, H5Aopen, hid_t, const char *, hid_t)
CALL5(hid_t, H5Aopen_by_name, hid_t, const char *, const char *, hid_t, hid_t)
CALL3(herr_t, H5Aread, hid_t, hid_t, void *)
CALL3(herr_t, H5Awrite, hid_t, hid_t, const void *)
CALL1(herr_t, H5Dclose, hid_t)
CALL7(hid_t, H5Dcreate2, hid_t, const char *, hid_t, hid_t, hid_t, hid_t, hid_t)
CALL5(herr_t, H5Dget_chunk_info_by_coord, hid_t, const hsize_t *, unsigned *, haddr_t *, hsize_t *)
CALL1(hid_t, H5Dget_create_plist, hid_t)
CALL1(hid_t, H5Dget_space, hid_t)
CALL1(hid_t, H5Dget_type, hid_t)
CALL3(hid_t, H5Dopen2, hid_t, const char *, hid_t)
CALL6(herr_t, H5Dread, hid_t, hid_t, hid_t, hid_t, hid_t, void *)
CALL2(herr_t, H5Dset_extent, hid_t, const hsize_t *)
CALL6(herr_t, H5Dwrite, hid_t, hid_t, hid_t, hid_t, hid_t, const void *)
CALL6(herr_t, H5Dwrite_chunk, hid_t, hid_t, uint32_t, const hsize_t *, size_t, const void *)
CALL1(herr_t, H5Fclose, hid_t)
CALL4(hid_t, H5Fcreate, const char *, unsigned, hid_t, hid_t)
CALL2(herr_t, H5Fflush, hid_t, H5F_scope_t)
CALL2(herr_t, H5Fget_filesize, hid_t, hsize_t *)
CALL4(ssize_t, H5Fget_obj_ids, hid_t, unsigned, size_t, hid_t *)
CALL3(hid_t, H5Fopen, const char *, unsigned, hid_t)
CALL1(herr_t, H5Gclose, hid_t)
CALL5(hid_t, H5Gcreate2, hid_t, const char *, hid_t, hid_t, hid_t)
CALL1(int, H5Idec_ref, hid_t)
CALL3(htri_t, H5Lexists, hid_t, const char *, hid_t)
CALL4(herr_t, H5Lget_info, hid_t, const char *, H5L_info_t *, hid_t)
CALL5(herr_t, H5Lvisit, hid_t, H5_index_t, H5_iter_order_t, H5L_iterate_t, void *)
CALL1(herr_t, H5Oclose, hid_t)
CALL3(htri_t, H5Oexists_by_name, hid_t, const char *, hid_t)
CALL3(hid_t, H5Oopen, hid_t, const char *, hid_t)
CALL1(herr_t, H5PLset_loading_state, unsigned)
CALL1(herr_t, H5Pclose, hid_t)
CALL1(hid_t, H5Pcreate, hid_t)
CALL1(H5D_layout_t, H5Pget_layout, hid_t)
CALL2(herr_t, H5Pget_virtual_count, hid_t, size_t *)
CALL4(ssize_t, H5Pget_virtual_dsetname, hid_t, size_t, char *, size_t)
CALL4(ssize_t, H5Pget_virtual_filename, hid_t, size_t, char *, size_t)
CALL2(hid_t, H5Pget_virtual_vspace, hid_t, size_t)
CALL3(herr_t, H5Pset_chunk, hid_t, int, const hsize_t *)
CALL2(herr_t, H5Pset_deflate, hid_t, unsigned)
CALL2(herr_t, H5Pset_fclose_degree, hid_t, H5F_close_degree_t)
CALL2(herr_t, H5Pset_fill_time, hid_t, H5D_fill_time_t)
CALL3(herr_t, H5Pset_fill_value, hid_t, hid_t, const void *)
CALL1(herr_t, H5Pset_fletcher32, hid_t)
CALL3(herr_t, H5Pset_libver_bounds, hid_t, H5F_libver_t, H5F_libver_t)
CALL2(herr_t, H5Pset_obj_track_times, hid_t, hbool_t)
CALL1(herr_t, H5Pset_shuffle, hid_t)
CALL5(herr_t, H5Pset_virtual, hid_t, hid_t, const char *, const char *, hid_t)
CALL1(herr_t, H5Sclose, hid_t)
CALL1(hid_t, H5Screate, H5S_class_t)
CALL3(hid_t, H5Screate_simple, int, const hsize_t *, const hsize_t *)
CALL3(herr_t, H5Sget_select_bounds, hid_t, hsize_t *, hsize_t *)
CALL3(int, H5Sget_simple_extent_dims, hid_t, hsize_t *, hsize_t *)
CALL1(int, H5Sget_simple_extent_ndims, hid_t)
CALL1(hssize_t, H5Sget_simple_extent_npoints, hid_t)
CALL1(herr_t, H5Sselect_all, hid_t)
CALL6(herr_t, H5Sselect_hyperslab, hid_t, H5S_seloper_t, const hsize_t *, const hsize_t *,
      const hsize_t *, const hsize_t *)
CALL1(herr_t, H5Tclose, hid_t)
CALL1(hid_t, H5Tcopy, hid_t)
CALL2(htri_t, H5Tequal, hid_t, hid_t)
CALL1(H5T_class_t, H5Tget_class, hid_t)
CALL1(H5T_cset_t, H5Tget_cset, hid_t)
CALL_OR(0, size_t, H5Tget_size, (hid_t a), (a))
CALL1(htri_t, H5Tis_variable_str, hid_t)
CALL2(herr_t, H5Tset_cset, hid_t, H5T_cset_t)
CALL2(herr_t, H5Tset_size, hid_t, size_t)
CALL2(herr_t, H5Tset_strpad, hid_t, H5T_str_t)
