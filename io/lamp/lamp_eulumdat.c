/* SPDX-License-Identifier: MIT
 *
 * EULUMDAT (A. Stockmar 1990): a value in each line; intensities in cd/klm of the lamps, on planes
 * C and angles gamma. The luminaire's length is across C 0.
 */
#include <math.h>
#include <string.h>

#include "io/lamp/lamp_reader.h"

enum { PLANES_MAX = RMAP_LAMP_STEPS_MAX + 1, GAMMAS_MAX = RMAP_LAMP_STEPS_MAX + 1, RATIOS = 10 };
enum symmetry { SYMMETRY_NONE, SYMMETRY_ALL, SYMMETRY_0, SYMMETRY_90, SYMMETRY_BOTH };

static void skip_lines(struct rmap_lamp_text *scan, int n)
{
    const char *line;
    for (; n > 0; n--)
        (void)rmap_lamp_line(scan, &line);
}

/* The only number of its line. */
static enum rmap_status take(struct rmap_lamp_text *scan, const char *what,
                             const struct rmap_lamp_range *range, double *value,
                             struct rmap_error *err)
{
    const char *rest;
    const enum rmap_status st = rmap_lamp_number(scan, what, range, value, err);
    const size_t line = scan->line;
    if (st == RMAP_OK && rmap_lamp_line(scan, &rest) > 0)
        return rmap_error_set(err, RMAP_INPUT, "line %zu: %s stands alone in its line", line, what);
    return st;
}

/* Lines 16 to 21, mm; a width of 0 is a circle. */
static enum rmap_status take_opening(struct rmap_lamp_text *scan, struct rmap_lamp_file *file,
                                     struct rmap_error *err)
{
    static const struct rmap_lamp_range mm = {0, 1e6};
    static const char *const what[] = {
        "the length of the luminous area",          "the width of the luminous area",
        "the height of the luminous area at C 0",   "the height of the luminous area at C 90",
        "the height of the luminous area at C 180", "the height of the luminous area at C 270"};
    enum { LENGTH, WIDTH, C0, C90, C180, C270, NUMBERS };
    enum rmap_status st = RMAP_OK;
    double m[NUMBERS];
    for (int i = 0; i < NUMBERS; i++) {
        RMAP_TRY(take(scan, what[i], &mm, &m[i], err));
        m[i] *= 1e-3;
    }
    const bool round = m[WIDTH] == 0.0 && m[LENGTH] > 0.0;
    file->body = round ? RMAP_LAMP_CYLINDER : RMAP_LAMP_BOX;
    file->size_m[0] = round ? m[LENGTH] : m[WIDTH];
    file->size_m[1] = m[LENGTH];
    file->side_m[0] = 0.5 * (m[C0] + m[C180]);
    file->side_m[1] = 0.5 * (m[C90] + m[C270]);
    file->size_m[2] =
        round ? 0.5 * (file->side_m[0] + file->side_m[1]) : fmax(file->side_m[0], file->side_m[1]);
    if (!round && file->size_m[0] + file->size_m[1] + file->size_m[2] == 0.0)
        file->body = RMAP_LAMP_POINT;
out:
    return st;
}

/* Lines 22 to 26: what intensities are multiplied with. */
static enum rmap_status take_sets(struct rmap_lamp_text *scan, size_t set, double *factor,
                                  struct rmap_error *err)
{
    static const struct rmap_lamp_range any = {-1e9, 1e9}, conversion = {0, 1e9},
                                        sets = {1, RMAP_LAMP_SETS_MAX, true}, lumens = {0, 1e9};
    enum rmap_status st = RMAP_OK;
    double value, n_set;
    skip_lines(scan, 2); /* shares of the flux: they are in the intensities */
    RMAP_TRY(take(scan, "the conversion factor", &conversion, factor, err));
    skip_lines(scan, 1); /* the tilt while it was measured */
    RMAP_TRY(take(scan, "the number of sets of lamps", &sets, &n_set, err));
    if ((double)set > n_set)
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "set %zu is not there: it has %g", set, n_set));
    for (size_t i = 1; i <= (size_t)n_set; i++) {
        RMAP_TRY(take(scan, "a number of lamps", &any, &value, err)); /* negative: a luminaire's */
        skip_lines(scan, 1);
        RMAP_TRY(take(scan, "the lumens of a set of lamps", &lumens, &value, err));
        skip_lines(scan, 3);
        if (i == (set > 0 ? set : 1))
            *factor *= value / 1000.0;
    }
    skip_lines(scan, RATIOS);
out:
    return st;
}

/* Which of the n_plane planes are there, and how they fill the turn. */
static size_t planes_of(enum symmetry symmetry, size_t n_plane, size_t *first, unsigned *turn)
{
    *first = symmetry == SYMMETRY_90 ? n_plane - n_plane / 4 : 0;
    *turn = RMAP_LAMP_AS_IT_IS;
    switch (symmetry) {
    case SYMMETRY_NONE:
        return n_plane;
    case SYMMETRY_ALL:
        return 1;
    case SYMMETRY_0:
        *turn = RMAP_LAMP_MIRROR_0;
        return n_plane / 2 + 1;
    case SYMMETRY_90:
        *turn = RMAP_LAMP_MIRROR_90;
        return n_plane / 2 + 1;
    case SYMMETRY_BOTH:
        *turn = RMAP_LAMP_MIRROR_0 | RMAP_LAMP_MIRROR_90;
        return n_plane / 4 + 1;
    }
    return 0;
}

/* Lines from C 0 on: of the planes, those that are there are kept. */
static enum rmap_status take_planes(struct rmap_lamp_text *scan, size_t n_plane, size_t first,
                                    struct rmap_lamp_file *file, struct rmap_error *err)
{
    static const struct rmap_lamp_range degrees = {0, 360};
    enum rmap_status st = RMAP_OK;
    double angle, before = -1.0;
    for (size_t i = 0; i < n_plane; i++) {
        const size_t row = (i + n_plane - first) % n_plane;
        RMAP_TRY(take(scan, "a plane C", &degrees, &angle, err));
        if (!(angle > before))
            RMAP_TRY(rmap_error_set(err, RMAP_INPUT,
                                    "line %zu: plane C %g comes after %g: they ascend",
                                    scan->line - 1, angle, before));
        before = angle;
        if (row < file->n_around)
            file->around_deg[row] = angle;
    }
out:
    return st;
}

static enum rmap_status take_grid(struct rmap_lamp_text *scan, double factor,
                                  struct rmap_lamp_file *file, struct rmap_error *err)
{
    static const struct rmap_lamp_range degrees = {0, 180}, intensity = {0, 1e12};
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < file->n_polar; i++) {
        RMAP_TRY(take(scan, "an angle gamma", &degrees, &file->polar_deg[i], err));
        if (i > 0 && !(file->polar_deg[i] > file->polar_deg[i - 1]))
            RMAP_TRY(rmap_error_set(err, RMAP_INPUT,
                                    "line %zu: gamma %g comes after %g: they ascend",
                                    scan->line - 1, file->polar_deg[i], file->polar_deg[i - 1]));
    }
    for (size_t i = 0; i < file->n_around * file->n_polar; i++) {
        RMAP_TRY(take(scan, "an intensity", &intensity, &file->candela[i], err));
        file->candela[i] *= factor;
    }
out:
    return st;
}

/* First and last of the planes that are there. */
static enum rmap_status check_turn(enum symmetry symmetry, const struct rmap_lamp_file *file,
                                   struct rmap_error *err)
{
    static const double due[][2] = {
        [SYMMETRY_0] = {0, 180}, [SYMMETRY_90] = {270, 90}, [SYMMETRY_BOTH] = {0, 90}};
    const double low = file->around_deg[0], high = file->around_deg[file->n_around - 1];
    if (symmetry == SYMMETRY_NONE || symmetry == SYMMETRY_ALL)
        return symmetry == SYMMETRY_ALL || rmap_lamp_is_whole_turn(file->around_deg, file->n_around)
                   ? RMAP_OK
                   : rmap_error_set(err, RMAP_INPUT,
                                    "its planes go from C %g to %g: without a symmetry they fill "
                                    "the turn",
                                    low, high);
    if (low != due[symmetry][0] || high != due[symmetry][1])
        return rmap_error_set(err, RMAP_INPUT,
                              "its planes go from C %g to %g: with symmetry %d (line 3) they go "
                              "from %g to %g",
                              low, high, (int)symmetry, due[symmetry][0], due[symmetry][1]);
    return RMAP_OK;
}

enum rmap_status rmap_lamp_eulumdat_read(struct rmap_lamp_text *scan,
                                         const struct rmap_lamp_choice *choice,
                                         struct rmap_lamp_file *file, struct rmap_error *err)
{
    static const struct rmap_lamp_range kinds = {0, SYMMETRY_BOTH, true},
                                        planes = {1, PLANES_MAX, true},
                                        gammas = {2, GAMMAS_MAX, true}, step = {0, 360};
    enum rmap_status st = RMAP_OK;
    double kind, n_plane, n_gamma, unused, factor = 1.0;
    const char *line;
    size_t first;
    unsigned turn;
    scan->commas = true;
    size_t n = rmap_lamp_line(scan, &line);
    rmap_lamp_title(file, line, n);
    skip_lines(scan, 1);
    RMAP_TRY(take(scan, "the symmetry", &kinds, &kind, err));
    RMAP_TRY(take(scan, "the number of planes C", &planes, &n_plane, err));
    RMAP_TRY(take(scan, "the step of the planes C", &step, &unused, err));
    RMAP_TRY(take(scan, "the number of angles gamma", &gammas, &n_gamma, err));
    skip_lines(scan, 2);
    n = rmap_lamp_line(scan, &line);
    rmap_lamp_title(file, line, n);
    skip_lines(scan, 6);
    RMAP_TRY(take_opening(scan, file, err));
    RMAP_TRY(take_sets(scan, choice->set, &factor, err));
    const enum symmetry symmetry = (enum symmetry)kind;
    const size_t n_row = planes_of(symmetry, (size_t)n_plane, &first, &turn);
    RMAP_TRY(rmap_lamp_grid(file, n_row, (size_t)n_gamma, err));
    RMAP_TRY(take_planes(scan, (size_t)n_plane, first, file, err));
    RMAP_TRY(take_grid(scan, factor, file, err));
    RMAP_TRY(check_turn(symmetry, file, err));
    if (symmetry == SYMMETRY_ALL)
        file->around_deg[0] = 0.0;
    RMAP_TRY(rmap_lamp_write_out(file, turn, err));
out:
    return st;
}
