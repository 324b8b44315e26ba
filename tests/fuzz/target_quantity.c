/* SPDX-License-Identifier: MIT
 *
 * What statistics are asked of, from a stranger: lines of --of, --of again, --detector and --range.
 * It ends in numbers, finite ones, or in a message.
 */
#include <math.h>
#include <string.h>

#include "analysis/query/quantity.h"
#include "analysis/query/quantity_read.h"
#include "fuzz_map.h"

const unsigned rmap_fuzz_rounds = 20000;

enum { LINES = 4, LONGEST = 2048 };

static void demand_message(enum rmap_status st, const struct rmap_error *err)
{
    rmap_fuzz_demand((st == RMAP_INPUT || st == RMAP_USAGE) && err->text[0],
                     "a refusal says what is wrong");
}

static void read_range(const struct rmap_quantities *quantities, const char *text)
{
    for (size_t i = 0; i < quantities->n; i++) {
        struct rmap_error err = {0};
        double range[2];
        enum rmap_status st = rmap_quantity_range(quantities, i, text, "--range", range, &err);
        if (st == RMAP_OK)
            rmap_fuzz_demand(isfinite(range[0]) && isfinite(range[1]), "a range is finite");
        else
            demand_message(st, &err);
    }
}

static void read_numbers(const struct rmap_quantities *quantities)
{
    const struct rmap_matched all = {.portion = fuzz_map_rays,
                                     .n_match = fuzz_map_rays->n_row[RMAP_TABLE_RAY]};
    struct rmap_readings readings = {0};
    struct rmap_error err = {0};
    rmap_fuzz_demand(rmap_quantities_read(quantities, &all, &readings, &err) == RMAP_OK,
                     "a number can be read");
    for (size_t i = 0; i < quantities->n; i++)
        for (size_t k = 0; k < readings.n; k++)
            rmap_fuzz_demand(isfinite(readings.value[i][k]), "a reading is finite");
    rmap_readings_fini(&readings);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    const struct rmap_map *map = fuzz_map();
    char text[LONGEST + 1];
    const char *line[LINES] = {0};
    struct rmap_quantities *quantities = NULL;
    struct rmap_error err = {0};
    int64_t live = rmap_alloc_live();
    if (nbytes > LONGEST)
        return 0;
    memcpy(text, data, nbytes);
    text[nbytes] = 0;
    char *at = text;
    for (int i = 0; i < LINES && at; i++) {
        line[i] = at;
        at = strchr(at, '\n');
        if (at)
            *at++ = 0;
    }
    enum rmap_status st =
        rmap_quantities_create(map, line, line[1] && *line[1] ? 2 : 1,
                               line[2] && *line[2] ? line[2] : NULL, &quantities, &err);
    if (st == RMAP_OK) {
        read_range(quantities, line[3] ? line[3] : "");
        read_numbers(quantities);
    } else {
        demand_message(st, &err);
    }
    rmap_quantities_destroy(quantities);
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
    return 0;
}

size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    static const char *const seed[] = {
        "x(film)\ny(film)\n\n-2..2 mm",
        "wavelength\npath_length\nfilm\n400..700 nm",
        "angle\n\nfilm\n0..1 rad",
        "hit(housing.*, reflect)\nghost_order\n\n0..3",
        "registered(film, rect(0, 0, 1, 1))\nscatter_order(film)\n*\n-1e3..1.5e+3",
        "cell_i(film)\ncell(film)\n\n0..1e9",
        "time(film)\noptical_path(film)\n\n1 ps..2 ns",
        "event(scatter_volume)\nbounces",
        "crossed(film)\nflux\n\n0..1 uW",
    };
    return rmap_fuzz_seed_text(seed, sizeof seed / sizeof *seed, k, to, cap);
}
