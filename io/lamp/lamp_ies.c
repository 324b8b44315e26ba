/* SPDX-License-Identifier: MIT
 *
 * IES LM-63 of 1986 to 2019: intensities in candela on a grid of vertical and horizontal angles of
 * a goniometer of type C, B or A (ANSI/IES LM-63-19; the types: LM-75). Angles around: those of C
 * are counter-clockwise as seen from where the light goes to, those of B and A clockwise; the polar
 * axis of B is horizontal, C 0; that of A vertical, and its vertical angles are from the horizon.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/lamp/lamp_reader.h"

enum type { TYPE_C = 1, TYPE_B, TYPE_A };
enum { ANGLES_MAX = 4000, TILTS_MAX = 1000, METRES = 2 };

struct head {
    int year; /* of the standard */
    enum type type;
    size_t n_vertical, n_horizontal;
    double size_m[3]; /* width, length, height, with the file's signs */
    double factor;    /* of the intensities */
};

static bool starts(const char *line, size_t n, const char *word)
{
    return n >= strlen(word) && strncmp(line, word, strlen(word)) == 0;
}

/* 1986 had no first line of its own. */
static int year_of(const char *line, size_t n)
{
    const char *at = n > 0 ? memchr(line, ':', n) : NULL;
    char word[16] = "";
    if (starts(line, n, "IESNA91"))
        return 1991;
    if (!starts(line, n, "IES"))
        return 1986;
    if (at)
        memcpy(word, at + 1, (size_t)(line + n - at - 1) < 15 ? (size_t)(line + n - at - 1) : 15);
    const char *dash = strrchr(word, '-');
    const int year = dash ? atoi(dash + 1) : 0;
    return year >= 1986 ? year : year > 80 && year < 100 ? 1900 + year : 2000 + year;
}

/* Ascending, from the first to the last one that may be. */
static enum rmap_status take_angles(struct rmap_lamp_text *scan, const char *what, double low,
                                    double high, size_t n, double *angle, struct rmap_error *err)
{
    const struct rmap_lamp_range range = {low, high};
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < n; i++) {
        RMAP_TRY(rmap_lamp_number(scan, what, &range, &angle[i], err));
        if (i > 0 && !(angle[i] > angle[i - 1]))
            RMAP_TRY(rmap_error_set(err, RMAP_INPUT,
                                    "line %zu: %s of %g comes after %g: they ascend", scan->line,
                                    what, angle[i], angle[i - 1]));
    }
out:
    return st;
}

/* TILT=INCLUDE: factors of the intensity over the tilt of the luminaire. */
static enum rmap_status take_tilts(struct rmap_lamp_text *scan, double tilt_deg, double *factor,
                                   struct rmap_error *err)
{
    static const struct rmap_lamp_range geometry = {1, 3, true}, count = {1, TILTS_MAX, true},
                                        factors = {0, 100};
    enum rmap_status st = RMAP_OK;
    double number, angle[TILTS_MAX], value[TILTS_MAX];
    RMAP_TRY(rmap_lamp_number(scan, "the lamp's place in the luminaire", &geometry, &number, err));
    RMAP_TRY(rmap_lamp_number(scan, "the number of tilts", &count, &number, err));
    const size_t n = (size_t)number;
    RMAP_TRY(take_angles(scan, "a tilt", -360, 360, n, angle, err));
    for (size_t i = 0; i < n; i++)
        RMAP_TRY(rmap_lamp_number(scan, "a factor of a tilt", &factors, &value[i], err));
    if (tilt_deg == 0.0 && !(angle[0] <= 0.0 && angle[n - 1] >= 0.0))
        return RMAP_OK;
    if (tilt_deg < angle[0] || tilt_deg > angle[n - 1])
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT,
                                "a tilt of %g degrees: its factors are for %g to %g", tilt_deg,
                                angle[0], angle[n - 1]));
    size_t i = 1;
    while (i + 1 < n && angle[i] < tilt_deg)
        i++;
    *factor = n == 1 ? value[0]
                     : value[i - 1] + (value[i] - value[i - 1]) * (tilt_deg - angle[i - 1]) /
                                          (angle[i] - angle[i - 1]);
out:
    return st;
}

/* Words of people, up to the line of TILT. */
static enum rmap_status take_labels(struct rmap_lamp_text *scan,
                                    const struct rmap_lamp_choice *choice, struct head *head,
                                    struct rmap_lamp_file *file, struct rmap_error *err)
{
    static const char *const named[] = {"[MANUFAC]", "[LUMINAIRE]"};
    const char *line;
    size_t n = rmap_lamp_line(scan, &line);
    head->year = year_of(line, n);
    while (!starts(line, n, "TILT=")) {
        for (size_t k = 0; k < sizeof named / sizeof *named; k++) {
            size_t skip = strlen(named[k]);
            if (starts(line, n, named[k])) {
                skip += skip < n && line[skip] == ' ';
                rmap_lamp_title(file, line + skip, n - skip);
            }
        }
        if (scan->at == scan->end)
            return rmap_error_set(err, RMAP_INPUT,
                                  "it has no line that begins with TILT=: no file of IES LM-63");
        n = rmap_lamp_line(scan, &line);
    }
    if (n == strlen("TILT=INCLUDE") && starts(line, n, "TILT=INCLUDE"))
        return take_tilts(scan, choice->tilt_deg, &head->factor, err);
    if (choice->tilt_deg != 0.0 && !(n == strlen("TILT=NONE") && starts(line, n, "TILT=NONE")))
        return rmap_error_set(err, RMAP_INPUT,
                              "line %zu: its factors of tilts are in '%.*s': put them here, behind "
                              "TILT=INCLUDE",
                              scan->line - 1, (int)(n < 60 ? n : 60) - 5, line + 5);
    return RMAP_OK;
}

static enum rmap_status take_head(struct rmap_lamp_text *scan, struct head *head,
                                  struct rmap_error *err)
{
    enum { LAMPS, LUMENS, MULTIPLIER, VERTICAL, HORIZONTAL, TYPE, UNIT, WIDTH, LENGTH, HEIGHT };
    enum { BALLAST = HEIGHT + 1, BALLAST_LAMP, WATTS, NUMBERS };
    static const struct {
        const char *what;
        struct rmap_lamp_range range;
    } due[NUMBERS] = {{"the number of lamps", {0, 1e6, true}},
                      {"the lumens of a lamp", {-1, 1e9}},
                      {"the multiplier of candelas", {0, 1e9}},
                      {"the number of vertical angles", {2, ANGLES_MAX, true}},
                      {"the number of horizontal angles", {1, ANGLES_MAX, true}},
                      {"the photometric type", {TYPE_C, TYPE_A, true}},
                      {"the unit of lengths", {1, METRES, true}},
                      {"the width", {-1e6, 1e6}},
                      {"the length", {-1e6, 1e6}},
                      {"the height", {-1e6, 1e6}},
                      {"the ballast factor", {0, 1e6}},
                      {"the ballast-lamp factor", {-1e6, 1e6}},
                      {"the input watts", {-1e9, 1e9}}};
    enum rmap_status st = RMAP_OK;
    double value[NUMBERS];
    for (int i = 0; i < NUMBERS; i++)
        RMAP_TRY(rmap_lamp_number(scan, due[i].what, &due[i].range, &value[i], err));
    head->n_vertical = (size_t)value[VERTICAL];
    head->n_horizontal = (size_t)value[HORIZONTAL];
    head->type = (enum type)value[TYPE];
    /* From 1995 on that place was kept free, and 2019 gives it another meaning. */
    head->factor *=
        value[MULTIPLIER] * value[BALLAST] * (head->year < 1995 ? value[BALLAST_LAMP] : 1.0);
    for (int k = 0; k < 3; k++)
        head->size_m[k] = value[WIDTH + k] * (value[UNIT] == METRES ? 1.0 : 0.3048);
    if (!(head->factor >= 0.0))
        st = rmap_error_set(err, RMAP_INPUT, "line %zu: a factor of the intensities is negative",
                            scan->line);
out:
    return st;
}

/* Width is along y, across C 0, and length along x; a negative one is round (LM-63-19, table 1; a
 * zero for one of a circle's, a sphere's or a cylinder's diameters is that of 1995 and before). */
static void set_opening(const struct head *head, struct rmap_lamp_file *file)
{
    const double w = head->size_m[0], l = head->size_m[1], h = head->size_m[2];
    const double size[3] = {fabs(l), fabs(w), fabs(h)};
    memcpy(file->size_m, size, sizeof size);
    file->side_m[0] = file->side_m[1] = size[2];
    if (w >= 0.0 && l >= 0.0 && h >= 0.0) {
        file->body = w + l + h > 0.0 ? RMAP_LAMP_BOX : RMAP_LAMP_POINT;
    } else if (h < 0.0 && l > 0.0) {
        file->body = RMAP_LAMP_CYLINDER;
        file->along = 0;
        file->size_m[1] = w != 0.0 ? size[1] : size[2];
    } else if (h < 0.0 && w > 0.0) {
        file->body = RMAP_LAMP_CYLINDER;
        file->along = 1;
        file->size_m[0] = l != 0.0 ? size[0] : size[2];
    } else if (h < 0.0 || w > 0.0 || l > 0.0) {
        const bool upright = head->year >= 2002; /* a disc that looks along C 0 */
        file->body = RMAP_LAMP_ELLIPSOID;
        file->size_m[0] = l != 0.0 || upright ? size[0] : size[1] > 0.0 ? size[1] : size[2];
        file->size_m[1] = w != 0.0 || upright ? size[1] : size[0] > 0.0 ? size[0] : size[2];
    } else {
        file->body = RMAP_LAMP_CYLINDER;
        file->size_m[0] = l != 0.0 ? size[0] : size[1];
        file->size_m[1] = w != 0.0 ? size[1] : size[0];
    }
}

static void set_axes(enum type type, struct rmap_lamp_file *file)
{
    static const double b[3][3] = {{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}},
                        a[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    if (type != TYPE_C)
        memcpy(file->axis, type == TYPE_B ? b : a, sizeof b);
}

/* Symmetries go by the first and the last angles. */
static enum rmap_status write_out(const struct head *head, struct rmap_lamp_file *file,
                                  struct rmap_error *err)
{
    const size_t n = file->n_around;
    const double first = file->around_deg[0], last = file->around_deg[n - 1];
    enum rmap_status st = RMAP_OK;
    unsigned turn = RMAP_LAMP_AS_IT_IS;
    if (head->type != TYPE_C) {
        for (size_t i = 0; i < file->n_polar; i++)
            file->polar_deg[i] += 90.0;
        if (file->polar_deg[0] == 90.0 && head->type == TYPE_B)
            RMAP_TRY(rmap_lamp_mirror_polar(file, err));
        turn = first == 0.0 ? RMAP_LAMP_MIRROR_0 | RMAP_LAMP_DARK : RMAP_LAMP_DARK;
    } else if (n == 1) {
        file->around_deg[0] = 0.0;
    } else if (first == 0.0 && last == 90.0) {
        turn = RMAP_LAMP_MIRROR_0 | RMAP_LAMP_MIRROR_90;
    } else if (first == 0.0 && last == 180.0) {
        turn = RMAP_LAMP_MIRROR_0;
    } else if (first == 90.0 && last == 270.0) {
        turn = RMAP_LAMP_MIRROR_90;
    } else if (!rmap_lamp_is_whole_turn(file->around_deg, n)) {
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT,
                                "its horizontal angles go from %g to %g: type C has 0 alone, or 0 "
                                "to 90, 0 to 180, 90 to 270, or 0 to 360",
                                first, last));
    }
    RMAP_TRY(rmap_lamp_write_out(file, turn, err));
out:
    return st;
}

enum rmap_status rmap_lamp_ies_read(struct rmap_lamp_text *scan,
                                    const struct rmap_lamp_choice *choice,
                                    struct rmap_lamp_file *file, struct rmap_error *err)
{
    static const struct rmap_lamp_range candela = {0, 1e12};
    struct head head = {.factor = 1.0};
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(take_labels(scan, choice, &head, file, err));
    RMAP_TRY(take_head(scan, &head, err));
    const size_t n = head.n_vertical * head.n_horizontal;
    if (n > (size_t)(scan->end - scan->at))
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "it ends before its %zu x %zu candelas",
                                head.n_horizontal, head.n_vertical));
    RMAP_TRY(rmap_lamp_grid(file, head.n_horizontal, head.n_vertical, err));
    const bool is_c = head.type == TYPE_C;
    RMAP_TRY(take_angles(scan, "a vertical angle", is_c ? 0 : -90, is_c ? 180 : 90, head.n_vertical,
                         file->polar_deg, err));
    RMAP_TRY(take_angles(scan, "a horizontal angle", is_c ? 0 : -180, is_c ? 360 : 180,
                         head.n_horizontal, file->around_deg, err));
    for (size_t i = 0; i < n; i++) {
        RMAP_TRY(rmap_lamp_number(scan, "an intensity", &candela, &file->candela[i], err));
        file->candela[i] *= head.factor;
    }
    set_opening(&head, file);
    set_axes(head.type, file);
    RMAP_TRY(write_out(&head, file, err));
out:
    return st;
}
