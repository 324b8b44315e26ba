/* SPDX-License-Identifier: MIT
 *
 * A file of rays from a stranger, TM-25, LightTools text, CSV or MCPL: it is refused with a
 * sentence, or becomes rays that have starts and directions, each with its row.
 */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/rays/mcpl.h"
#include "io/rays/ray_file.h"
#include "io/rays/tm25.h"
#include "target.h"

const unsigned rmap_fuzz_rounds = 60000;

enum { LONGEST = 60000, DRAWS = 64 };

static void use(const struct rmap_file_rays *set)
{
    for (uint64_t i = 0; i < DRAWS; i++) {
        struct rmap_vec3 p, d;
        const size_t row = rmap_file_rays_row(set, i * 0x9e3779b97f4a7c15U >> (i & 63));
        rmap_fuzz_demand(row < set->n, "a row");
        rmap_file_rays_get(set, row, &p, &d);
        rmap_fuzz_demand(isfinite(rmap_dot(p, p)) && rmap_dot(d, d) > 0.0, "a ray");
        rmap_fuzz_demand(!(rmap_file_rays_nm(set, row) <= 0.0), "a wavelength");
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    struct rmap_ray_wanted wanted = {.steps = data != NULL && nbytes > 0 && (data[0] & 4)};
    struct rmap_file_rays *set = NULL;
    struct rmap_error err = {0};
    const int64_t live = rmap_alloc_live();
    if (nbytes < 2 || nbytes > LONGEST)
        return 0;
    static const enum rmap_ray_format format[] = {RMAP_RAYS_TM25, RMAP_RAYS_LIGHTTOOLS,
                                                  RMAP_RAYS_CSV, RMAP_RAYS_MCPL};
    uint8_t *copy = rmap_alloc(nbytes, 1);
    rmap_fuzz_demand(copy != NULL, "memory");
    memcpy(copy, data + 1, nbytes - 1);
    FILE *in = fmemopen(copy, nbytes - 1, "rb");
    rmap_fuzz_demand(in != NULL, "memory");
    enum rmap_status st =
        rmap_ray_stream_read(in, nbytes - 1, format[data[0] & 3], &wanted, &set, &err);
    if (st == RMAP_OK)
        st = rmap_file_rays_finish(set, &err);
    if (st == RMAP_OK)
        use(set);
    else
        rmap_fuzz_demand(st == RMAP_INPUT && err.text[0], "what is wrong is said");
    rmap_file_rays_drop(set);
    (void)fclose(in);
    rmap_free(copy);
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
    return 0;
}

static size_t seed_tm25(uint8_t *to, size_t cap)
{
    enum { TEXTS = 4 * RMAP_TM25_TEXTS * RMAP_TM25_LETTERS, N = 3, WIDTH = 8 };
    struct rmap_tm25_head head = {.magic = "TM25", .version = 2013, .n_ray = N, .spectrum = 4};
    const int32_t known[RMAP_TM25_FLAGS] = {1, 1, 1, 0, 0, 0, 0, 1}, n = 2;
    const float table[4] = {450, 1, 650, 2};
    const float row[N][WIDTH] = {{0, 0, 0, 0, 0, 1, 1, 1}, {1, 0, 0, 0, 1, 0, 2, 1}};
    const size_t nbytes = 1 + sizeof head + sizeof known + TEXTS + 32 + sizeof row;
    if (cap < nbytes)
        return 0;
    head.n_table = 1;
    memset(to, 0, nbytes);
    uint8_t *at = to + 1;
    memcpy(at, &head, sizeof head);
    memcpy(at + sizeof head, known, sizeof known);
    at += sizeof head + sizeof known + TEXTS;
    memcpy(at, &n, sizeof n);
    memcpy(at + 4, table, sizeof table);
    memcpy(at + 32, row, sizeof row);
    at[32 + 2 * sizeof *row + 20] = 1; /* a direction of the last one */
    return nbytes;
}

static size_t seed_mcpl(uint8_t *to, size_t cap, char version)
{
    enum { N = 2 };
    struct rmap_mcpl_head head = {.magic = {'M', 'C', 'P', 'L', '0', '0', '3', 'L'},
                                  .n = N,
                                  .flags = 1,
                                  .single = 1,
                                  .particle_nbytes = 40};
    head.magic[6] = version;
    const uint32_t empty = 0, flags = 7;
    const float row[8] = {1, 2, 3, 0.5F, 0.5F, 2e-6F, 1, 1};
    const int32_t code = 22;
    if (cap < 1 + sizeof head + 4 + N * 40)
        return 0;
    uint8_t *at = to;
    *at++ = 3;
    memcpy(at, &head, sizeof head);
    memcpy(at + sizeof head, &empty, 4);
    at += sizeof head + 4;
    for (int i = 0; i < N; i++, at += 40) {
        memcpy(at, row, sizeof row);
        memcpy(at + 32, &code, 4);
        memcpy(at + 36, &flags, 4);
    }
    return (size_t)(at - to);
}

size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    static const char *const seed[] = {
        "1# A\nlt_datatype: luminous_flux\nlt_color_info: wavelength\nlt_length_units: inches\n"
        "lt_radiant_flux: 2\nlt_data_origin: 0 0 0\nlt_startofdata\n1 2 3 0 0 1 1 500\n"
        "4 5 6 0.6 0.8 -1e-016 3 600\nlt_endofdata",
        "2x (mm),y [mm],z(mm),dx,dy,dz,wavelength (um),time (ps),weight,event\n"
        "1,2,3,0,0,1,0.5,10,1,2\n4;5;6;0;1;0;0.6;20;3;2\n",
        "2x,y,z,kx,ky,kz,energy (keV)\n1 2 3 0 0 1 2.5e-3\n",
        "6x (m),y (m),z (m),dx,dy,dz,length (m),energy (keV),time,event,charge,beta\n"
        "1,2,3,0,0,1,0.1,20,1,7,-1,0.9\n4,5,6,0,1,0,0.2,30,2,6,2,1\n",
    };
    if (k < sizeof seed / sizeof *seed)
        return rmap_fuzz_seed_text(seed, sizeof seed / sizeof *seed, k, to, cap);
    return k < 6 ? seed_mcpl(to, cap, k == 4 ? '3' : '2') : k == 6 ? seed_tm25(to, cap) : 0;
}
