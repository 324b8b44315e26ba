/* SPDX-License-Identifier: MIT
 *
 * A lamp maker's file from a stranger, IES LM-63 or EULUMDAT: it is refused with a sentence, or
 * becomes a lamp whose light has directions, places and an intensity.
 */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/lamp/lamp_file.h"
#include "target.h"

const unsigned rmap_fuzz_rounds = 300000;

enum { LONGEST = 16384, DRAWS = 8 };

static void use(const struct rmap_lamp_file *file, struct rmap_lamp *lamp)
{
    lamp->body = file->body;
    lamp->along = file->along;
    for (int k = 0; k < 3; k++) {
        lamp->size[k] = file->size_m[k];
        lamp->axis[k] = rmap_vec3(file->axis[k][0], file->axis[k][1], file->axis[k][2]);
    }
    for (int k = 0; k < 2; k++)
        lamp->side[k] = file->side_m[k];
    for (uint64_t i = 0; i < DRAWS; i++) {
        const double u[3] = {((double)i + 0.5) / DRAWS, fmod(0.618 * ((double)i + 1.0), 1.0),
                             fmod(0.382 * ((double)i + 1.0), 1.0)};
        const struct rmap_vec3 d = rmap_lamp_draw(lamp, u), p = rmap_lamp_point(lamp, d, u);
        rmap_fuzz_demand(fabs(rmap_length(d) - 1.0) < 1e-9, "a direction");
        rmap_fuzz_demand(rmap_lamp_intensity(lamp, d) >= 0.0, "an intensity");
        const double at[3] = {p.x, p.y, p.z};
        for (int k = 0; k < 3; k++)
            rmap_fuzz_demand(fabs(at[k]) <= 0.5 * lamp->size[k] * (1.0 + 1e-9), "a place in it");
    }
}

static void check_grid(const struct rmap_lamp_file *file)
{
    for (size_t a = 0; a < file->n_around; a++)
        rmap_fuzz_demand(file->around_deg[a] >= 0.0 && file->around_deg[a] < 360.0 &&
                             (a == 0 || file->around_deg[a] > file->around_deg[a - 1]),
                         "azimuths ascend");
    for (size_t p = 0; p < file->n_polar; p++)
        rmap_fuzz_demand(file->polar_deg[p] >= 0.0 && file->polar_deg[p] <= 180.0 &&
                             (p == 0 || file->polar_deg[p] > file->polar_deg[p - 1]),
                         "polar angles ascend");
    for (size_t i = 0; i < file->n_around * file->n_polar; i++)
        rmap_fuzz_demand(file->candela[i] >= 0.0 && isfinite(file->candela[i]), "candelas");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    struct rmap_lamp_file file;
    struct rmap_lamp lamp = {.n_around = 0};
    struct rmap_error err = {0};
    const int64_t live = rmap_alloc_live();
    if (nbytes < 2 || nbytes > LONGEST)
        return 0;
    const struct rmap_lamp_choice choice = {.set = data[0] >> 1 & 3,
                                            .tilt_deg = data[0] & 8 ? 30.0 : 0.0};
    char *text = rmap_alloc(nbytes, 1); /* its last byte stays 0 */
    rmap_fuzz_demand(text != NULL, "memory");
    memcpy(text, data + 1, nbytes - 1);
    enum rmap_status st = rmap_lamp_file_read(
        text, nbytes - 1, data[0] & 1 ? RMAP_LAMP_EULUMDAT : RMAP_LAMP_IES, &choice, &file, &err);
    if (st == RMAP_OK) {
        check_grid(&file);
        st = rmap_lamp_init(file.around_deg, file.n_around, file.polar_deg, file.n_polar,
                            file.candela, &lamp, &err);
    }
    if (st == RMAP_OK)
        use(&file, &lamp);
    else
        rmap_fuzz_demand(st == RMAP_INPUT && err.text[0], "what is wrong is said");
    rmap_lamp_fini(&lamp);
    rmap_lamp_file_fini(&file);
    rmap_free(text);
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
    return 0;
}

size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    static const char *const seed[] = {
        "0IESNA:LM-63-2002\n[MANUFAC] A\n[LUMINAIRE] B\nTILT=NONE\n1 -1 1 3 1 1 2 -0.1 -0.1 0\n1 1 "
        "20\n0 45 90\n0\n100 80.5 0\n",
        "8IESNA91\nTILT=INCLUDE\n1\n2\n0 90\n1 .5\n1 350 2 3 3 1 1 .1 .2 .3\n.9 .8 20\n0 90 180\n0 "
        "45 90\n1 2 3 4 5 6 7 8 9\n",
        "0Lamps of 1986\nTILT=NONE\n1 350 2 2 2 2 1 0 -.2 .3\n.9 .8 20\n0 90\n0 90\n1 2 3 4\n",
        "0IES:LM-63-2019\nTILT=NONE\n1 350 2 3 3 3 2 -.1 .2 -.1\n1 1 20\n-90 0 90\n-90 0 90\n1 2 3 "
        "4 "
        "5 6 7 8 9\n",
        "1A\n1\n1\n1\n0\n3\n45\n\nB\n\n\n\n0\n0\n0\n300\n0\n0\n0\n0\n0\n50\n100\n1\n0\n1\n1\nLED\n"
        "1000\n\n\n\n0\n0\n0\n0\n0\n0\n0\n0\n0\n0\n0\n0\n45\n90\n100,5\n80\n0\n",
        "5A\n2\n3\n4\n90\n2\n90\n\nB\n\n\n\n0\n0\n0\n300\n100\n50\n0\n50\n0\n50\n100\n1\n0\n2\n1\n"
        "LED\n1000\n\n\n\n-1\nLED\n500\n\n\n\n0\n0\n0\n0\n0\n0\n0\n0\n0\n0\n0\n90\n180\n270\n0\n"
        "90\n1\n2\n3\n4\n5\n6\n",
    };
    return rmap_fuzz_seed_text(seed, sizeof seed / sizeof *seed, k, to, cap);
}
