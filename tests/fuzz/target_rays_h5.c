/* SPDX-License-Identifier: MIT
 *
 * HDF5 files of rays and of steps whose contents are a stranger's: datasets of any name, shape,
 * type and unit, missing or doubled, with any numbers. They are refused with a sentence, or become
 * rays. (Bytes of HDF5's own structures are its library's to check.)
 */
#include <hdf5.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/rays/ray_file.h"
#include "target.h"

const unsigned rmap_fuzz_rounds = 1500;

enum { SETS_MAX = 16, ROWS_MAX = 8 };

static const char *const names[] = {"position", "direction", "x",     "y",       "z",
                                    "dx",       "dy",        "dz",    "power",   "flux",
                                    "weight",   "time",      "event", "energy",  "wavelength",
                                    "length",   "charge",    "beta",  "deposit", "detector"};
static const char *const units[] = {"",   "mm", "m",  "cm", "nm",  "um",
                                    "ns", "eV", "ps", "W",  "MeV", "a unit too long to be one"};

static char path[] = "/tmp/raymap-fuzz-XXXXXX";

static void set_unit(hid_t set, uint8_t which, bool variable)
{
    const char *unit = units[which % (sizeof units / sizeof *units)];
    if (!unit[0])
        return;
    hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
    (void)H5Tset_size(type, variable ? H5T_VARIABLE : strlen(unit));
    hid_t at = H5Acreate2(set, "unit", type, space, H5P_DEFAULT, H5P_DEFAULT);
    (void)H5Awrite(at, type, variable ? (const void *)&unit : unit);
    (void)H5Aclose(at);
    (void)H5Sclose(space);
    (void)H5Tclose(type);
}

/* 5 bytes: name, shape, type, unit, kind of numbers; numbers follow, a byte each. */
static void add_set(hid_t file, const uint8_t **data, size_t *nbytes)
{
    uint8_t op[5];
    int8_t raw[3 * ROWS_MAX];
    double value[3 * ROWS_MAX] = {0};
    rmap_fuzz_take(data, nbytes, op, sizeof op);
    const char *name = names[op[0] % (sizeof names / sizeof *names)];
    const hsize_t dims[2] = {op[1] % (ROWS_MAX + 1), 1 + (op[1] >> 4) % 3};
    const int rank = op[0] < 40 ? (dims[1] == 3 || op[0] & 1 ? 2 : 1) : (op[1] >> 6) % 3;
    rmap_fuzz_take(data, nbytes, raw, (size_t)(dims[0] * dims[1]));
    for (size_t i = 0; i < dims[0] * dims[1]; i++)
        value[i] = op[4] == 255 ? (double)NAN : op[4] == 254 ? 1e300 * raw[i] : 0.25 * raw[i];
    hid_t type = op[2] % 8 == 6   ? H5T_NATIVE_FLOAT
                 : op[2] % 8 == 5 ? H5T_NATIVE_INT32
                 : op[2] % 8 == 4 ? H5T_NATIVE_UINT8
                                  : H5T_NATIVE_DOUBLE;
    hid_t text = H5Tcopy(H5T_C_S1),
          space = rank ? H5Screate_simple(rank, dims, NULL) : H5Screate(H5S_SCALAR);
    hid_t set = H5Dcreate2(file, name, op[2] % 8 == 7 ? text : type, space, H5P_DEFAULT,
                           H5P_DEFAULT, H5P_DEFAULT);
    if (set >= 0 && op[2] % 8 != 7)
        (void)H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, value);
    if (set >= 0) {
        set_unit(set, op[3], op[3] & 128);
        (void)H5Dclose(set);
    }
    (void)H5Sclose(space);
    (void)H5Tclose(text);
}

static void write_file(const uint8_t *data, size_t nbytes)
{
    (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    for (int k = 0; k < SETS_MAX && nbytes > 0; k++)
        add_set(file, &data, &nbytes);
    (void)H5Fclose(file);
}

static void finish(void)
{
    (void)unlink(path);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    struct rmap_file_rays *set = NULL;
    struct rmap_error err = {0};
    if (path[sizeof path - 2] == 'X') {
        const int file = mkstemp(path);
        rmap_fuzz_demand(file >= 0, "a file");
        (void)close(file);
        (void)atexit(finish);
    }
    if (nbytes < 2)
        return 0;
    const int64_t live = rmap_alloc_live();
    struct rmap_ray_wanted wanted = {.steps = data[0] & 1};
    write_file(data + 1, nbytes - 1);
    const enum rmap_status st = rmap_ray_file_read(path, RMAP_RAYS_HDF5, &wanted, &set, &err);
    if (st == RMAP_OK)
        for (size_t row = 0; row < set->n; row++) {
            struct rmap_vec3 p, d;
            rmap_file_rays_get(set, row, &p, &d);
            rmap_fuzz_demand(isfinite(rmap_dot(p, p)) && rmap_dot(d, d) > 0.0, "a ray");
        }
    else
        rmap_fuzz_demand(st == RMAP_INPUT && err.text[0], "what is wrong is said");
    rmap_file_rays_drop(set);
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
    return 0;
}

size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    /* Of two rows: position, direction; power, wavelength of rays; length, energy, event of steps.
     */
    static const uint8_t seed[2][96] = {
        {0, 0, 0x22, 0, 1, 0,    1, 2, 3, 4, 5, 6,  1,    0x22, 0, 0, 0,   0,  0,
         4, 0, 4,    0, 8, 0x02, 0, 9, 0, 4, 8, 14, 0x02, 0,    4, 0, 100, 110},
        {1, 0,  0x22, 0, 2, 0, 1, 2, 3,  4,    5, 6,  1, 0x22, 0, 0,  0,    0, 0, 4, 0, 4,
         0, 15, 0x02, 0, 1, 0, 4, 8, 13, 0x02, 0, 10, 0, 8,    9, 12, 0x02, 5, 0, 0, 4, 8}};
    if (k > 1 || cap < sizeof seed[0])
        return 0;
    const size_t n = k == 0 ? 37 : 44;
    memcpy(to, seed[k], n);
    return n;
}
