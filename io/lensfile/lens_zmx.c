/* SPDX-License-Identifier: MIT
 *
 * Zemax's .zmx: a line has a word of four letters and its numbers; what stands under SURF belongs
 * to that surface. Nothing of it is published; words are read as their names and the manual's
 * terms for the same data say, and as files of the public domain use them.
 *
 * Coordinate breaks turn right-handed about x, the new y and the new z after their shift; with
 * their flag set in the other order, before it.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/count.h"
#include "io/lensfile/lens_text.h"
#include "io/lensfile/lens_zmx_config.h"
#include "io/lensfile/lens_zmx_shape.h"

enum { KEY_LETTERS = 4 };

struct zmx {
    struct rmap_prescription *lens;
    struct rmap_lens_lines lines;
    struct rmap_error *err;
    struct rmap_lens_surface *surface; /* NULL: before the first */
    struct rmap_zmx_numbers numbers;   /* of the surface */
    bool behind;                       /* the surfaces */
    struct rmap_zmx_changes changes;   /* of the configuration */
    bool indented;                     /* lines of surfaces are: one that is not ends the last */
    size_t n_wavelength_said;          /* FTYP; 0: not said */
    double list_wavelength[RMAP_PRESCRIPTION_WAVELENGTHS_MAX];
    char seen[32][5]; /* words that were told as not understood */
    size_t n_seen;
};

static void end_surface(struct zmx *z)
{
    struct rmap_lens_surface *surface = z->surface;
    if (!surface)
        return;
    rmap_zmx_shape(z->lens, surface, &z->numbers);
    if (strcmp(surface->type, "STANDARD") == 0)
        surface->type[0] = 0;
    surface->number = (int)(surface - z->lens->surface);
    rmap_zmx_change_surface(&z->changes, z->lens, surface);
}

/* ---- words of a surface ---- */

/* Words that only say how a value came about. */
static const struct {
    const char *word, *text;
} solves[] = {
    {"MAZH", "thickness by a solve (marginal ray height), as stored"},
    {"CHZH", "thickness by a solve (chief ray height), as stored"},
    {"EDGE", "thickness by a solve (edge thickness), as stored"},
    {"PZUP", "thickness by a pickup, as stored"},
    {"PCUR", "curvature by a pickup, as stored"},
    {"PKUP", "curvature by a pickup, as stored"},
    {"PPAR", "a parameter by a pickup, as stored"},
    {"PCON", "conic by a pickup, as stored"},
    {"PSEM", "semi-diameter by a pickup, as stored"},
    {"MARG", "curvature by a solve (marginal ray angle), as stored"},
    {"FNUM", "curvature by a solve (F/#), as stored"},
    {"COMP", "thickness by a solve (compensator), as stored"},
    {"TCOM", "thickness by a solve (compensator), as stored"},
    {"TOLE", "thickness by a solve (position), as stored"},
    {"POSI", "thickness by a solve (position), as stored"},
};

/* Words without a meaning for the scene: pictures, variables, tolerances, physical optics. */
static const char harmless[] =
    " SSID FIMP HIDE MIRR SLAB POPS MEMA OEMA DRAW SCOL SCBD VCUR VDSZ VCON VPAR VXDT TCED TCMM "
    "MNCA MNCG "
    "MXCA MXCG MNEA MNEG RGLA VERS AUTH IWDP PFIL LANG GFAC PUSH SDMA OMMA ROPD "
    "HYPR "
    "PICB VANN ZVAN POLS GLRS GSTD NSCD COFN LUID EERA BLNK TOL MOFF TELE TRAC GLCZ STUD EFFL PUPD "
    "DMFS OPDX CONF FWGT DBDT FLAP WWGN WAVN VNDX UNIV ISNA PIKO QOMA RSCE RWRE NOTE LTTL MIND "
    "MAXD "
    "FCOM TOTR PMAG XFLD CBMA HEAD YFLD NSOH NSOO NSOP NSOS ";

static void read_glass(struct zmx *z, char *const *word, size_t n)
{
    struct rmap_lens_surface *s = z->surface;
    if (n < 2)
        return;
    if (rmap_lens_is(word[1], "MIRROR")) {
        s->is_mirror = true;
        return;
    }
    s->is_model = rmap_lens_is(word[1], "___BLANK");
    rmap_lens_copy(s->glass, sizeof s->glass, word[1]);
    s->nd = rmap_lens_value(word, n, 4, 0);
    s->vd = rmap_lens_value(word, n, 5, 0);
    if (!s->is_model && s->nd == 1.5 && s->vd == 40) /* what stands there where nothing is said */
        s->nd = s->vd = 0;
    if (rmap_lens_value(word, n, 2, 0) == 4) /* an offset from the catalogue's */
        rmap_lens_lost(z->lens, z->lines.number, s,
                       "the offset of its glass, nd %+.6g and Vd %+.6g, is left out",
                       rmap_lens_value(word, n, 10, 0), rmap_lens_value(word, n, 11, 0));
    if (s->is_model && rmap_lens_value(word, n, 6, 0) != 0)
        rmap_lens_lost(z->lens, z->lines.number, s,
                       "the partial dispersion of its model glass is left out");
}

static void read_thickness(struct zmx *z, char *const *word, size_t n)
{
    double value = 0;
    if (n > 1 && rmap_lens_is(word[1], "INFINITY"))
        z->surface->thickness = HUGE_VAL;
    else if (n > 1 && rmap_lens_number(word[1], &value))
        z->surface->thickness = fabs(value) >= 1e10 ? HUGE_VAL : value;
    else
        rmap_lens_lost(z->lens, z->lines.number, z->surface, "its thickness is no number");
}

static void read_opening(struct rmap_lens_opening *opening, enum rmap_opening shape,
                         char *const *word, size_t n)
{
    opening->shape = shape;
    if (shape == RMAP_OPENING_CIRCLE) {
        opening->inner = fabs(rmap_lens_value(word, n, 1, 0));
        opening->half[0] = opening->half[1] = fabs(rmap_lens_value(word, n, 2, 0));
    } else {
        opening->half[0] = fabs(rmap_lens_value(word, n, 1, 0));
        opening->half[1] = fabs(rmap_lens_value(word, n, 2, 0));
    }
    if (!(opening->half[0] > 0 && opening->half[1] > 0))
        opening->shape = RMAP_OPENING_NONE;
}

static bool read_openings(struct zmx *z, const char *key, char *const *word, size_t n)
{
    static const struct {
        const char *key;
        enum rmap_opening shape;
        bool is_plate;
    } openings[] = {{"CLAP", RMAP_OPENING_CIRCLE, false},   {"OBSC", RMAP_OPENING_CIRCLE, true},
                    {"CLOB", RMAP_OPENING_CIRCLE, true},    {"SQAP", RMAP_OPENING_RECTANGLE, false},
                    {"SQOB", RMAP_OPENING_RECTANGLE, true}, {"ELAP", RMAP_OPENING_ELLIPSE, false},
                    {"ELOB", RMAP_OPENING_ELLIPSE, true}};
    struct rmap_lens_surface *s = z->surface;
    for (size_t i = 0; i < RMAP_COUNT(openings); i++)
        if (strcmp(key, openings[i].key) == 0) {
            read_opening(openings[i].is_plate ? &s->obscuration : &s->aperture, openings[i].shape,
                         word, n);
            return true;
        }
    if (strcmp(key, "SPID") == 0) {
        const double arms = rmap_lens_value(word, n, 2, 0);
        s->arm_width = fabs(rmap_lens_value(word, n, 1, 0));
        s->n_arm = arms >= 1 && arms <= 64 && s->arm_width > 0 ? (int)arms : 0;
    } else if (strcmp(key, "OBDC") == 0) {
        for (int i = 0; i < 2; i++)
            s->aperture.centre[i] = s->obscuration.centre[i] =
                rmap_lens_value(word, n, (size_t)i + 1, 0);
    } else if (strcmp(key, "UDAD") == 0 || strcmp(key, "USAP") == 0 || strcmp(key, "UDOB") == 0) {
        rmap_lens_lost(z->lens, z->lines.number, s, "its aperture %s is not understood", key);
    } else {
        return false;
    }
    return true;
}

static bool read_of_surface(struct zmx *z, const char *key, char *const *word, size_t n)
{
    struct rmap_lens_surface *s = z->surface;
    if (strcmp(key, "TYPE") == 0 && n > 1)
        rmap_lens_copy(s->type, sizeof s->type, word[1]);
    else if (strcmp(key, "CURV") == 0)
        s->curvature = rmap_lens_value(word, n, 1, 0);
    else if (strcmp(key, "CONI") == 0)
        s->conic = rmap_lens_value(word, n, 1, 0);
    else if (strcmp(key, "DISZ") == 0)
        read_thickness(z, word, n);
    else if (strcmp(key, "GLAS") == 0)
        read_glass(z, word, n);
    else if (strcmp(key, "DIAM") == 0)
        s->semi = fabs(rmap_lens_value(word, n, 1, 0));
    else if (strcmp(key, "STOP") == 0)
        s->is_stop = true;
    else if (strcmp(key, "PARM") == 0) {
        const double k = rmap_lens_value(word, n, 1, 0);
        if (k >= 1 && k <= RMAP_ZMX_PARAMETERS)
            z->numbers.parameter[(int)k] = rmap_lens_value(word, n, 2, 0);
    } else if (strcmp(key, "XDAT") == 0) {
        const double k = rmap_lens_value(word, n, 1, 0);
        if (k >= 1 && k <= RMAP_ZMX_EXTRA)
            z->numbers.extra[(int)k] = rmap_lens_value(word, n, 2, 0);
    } else if (strcmp(key, "COAT") == 0 && n > 1)
        rmap_lens_lost(z->lens, z->lines.number, s, "its coating '%.40s' is left out", word[1]);
    else
        return read_openings(z, key, word, n);
    return true;
}

/* ---- words of the whole ---- */

static void read_values(char *const *word, size_t n, double *first, size_t stride)
{
    for (size_t i = 1; i < n && i <= RMAP_PRESCRIPTION_FIELDS_MAX; i++)
        first[(i - 1) * stride] = rmap_lens_value(word, n, i, 0);
}

static void read_type_of_fields(struct zmx *z, char *const *word, size_t n)
{
    static const enum rmap_lens_field_kind kind[] = {RMAP_FIELD_ANGLE, RMAP_FIELD_OBJECT_HEIGHT,
                                                     RMAP_FIELD_IMAGE_HEIGHT,
                                                     RMAP_FIELD_REAL_HEIGHT};
    const double type = rmap_lens_value(word, n, 1, 0), fields = rmap_lens_value(word, n, 3, 1),
                 waves = rmap_lens_value(word, n, 4, 0);
    if (type >= 0 && type < (double)RMAP_COUNT(kind))
        z->lens->field_kind = kind[(int)type];
    else
        rmap_lens_lost(z->lens, z->lines.number, NULL,
                       "type %g of its fields is not understood: their numbers are taken as angles",
                       type);
    z->lens->n_field = fields >= 1 && fields <= RMAP_PRESCRIPTION_FIELDS_MAX ? (size_t)fields : 1;
    if (waves >= 1 && waves <= RMAP_PRESCRIPTION_WAVELENGTHS_MAX)
        z->n_wavelength_said = (size_t)waves;
}

static void read_wavelength(struct zmx *z, char *const *word, size_t n)
{
    const double k = rmap_lens_value(word, n, 1, 0), um = rmap_lens_value(word, n, 2, 0);
    struct rmap_prescription *lens = z->lens;
    if (!(k >= 1 && k <= RMAP_PRESCRIPTION_WAVELENGTHS_MAX && um > 0))
        return;
    const size_t i = (size_t)k - 1;
    lens->wavelength_nm[i] = rmap_lens_nm(um);
    lens->wavelength_weight[i] = rmap_lens_value(word, n, 3, 1);
    lens->n_wavelength = i + 1 > lens->n_wavelength ? i + 1 : lens->n_wavelength;
}

static void read_unit(struct zmx *z, char *const *word, size_t n)
{
    static const struct {
        const char *word, *unit;
    } units[] = {{"MM", "mm"},   {"CM", "cm"},   {"IN", "in"},
                 {"INCH", "in"}, {"METER", "m"}, {"M", "m"}};
    for (size_t i = 0; n > 1 && i < RMAP_COUNT(units); i++)
        if (rmap_lens_is(word[1], units[i].word)) {
            z->lens->unit = units[i].unit;
            return;
        }
    rmap_lens_lost(z->lens, z->lines.number, NULL, "unit '%.20s' is not understood: mm is taken",
                   n > 1 ? word[1] : "");
}

static void read_pupil(struct zmx *z, const char *key, char *const *word, size_t n)
{
    static const struct {
        const char *key;
        enum rmap_lens_pupil pupil;
    } pupils[] = {{"ENPD", RMAP_PUPIL_DIAMETER},
                  {"FNUM", RMAP_PUPIL_F_NUMBER},
                  {"OBNA", RMAP_PUPIL_OBJECT_NA},
                  {"FLOA", RMAP_PUPIL_STOP}};
    for (size_t i = 0; i < RMAP_COUNT(pupils); i++)
        if (strcmp(key, pupils[i].key) == 0)
            z->lens->pupil = pupils[i].pupil;
    z->lens->pupil_value = fabs(rmap_lens_value(word, n, 1, 0));
    if (rmap_lens_value(word, n, 2, 0) != 1)
        return;
    /* With a 1 behind it, FNUM is the paraxial working F/#, and OBNA the object's cone angle. */
    if (z->lens->pupil == RMAP_PUPIL_F_NUMBER)
        z->lens->pupil = RMAP_PUPIL_WORKING_F_NUMBER;
    else if (z->lens->pupil == RMAP_PUPIL_OBJECT_NA)
        z->lens->pupil_value = sin(z->lens->pupil_value * RMAP_PI / 180);
}

static bool read_of_lens(struct zmx *z, const char *key, char *const *word, size_t n)
{
    struct rmap_prescription *lens = z->lens;
    struct rmap_lens_field *f = lens->field;
    const size_t stride = sizeof *f / sizeof(double);
    if (strcmp(key, "UNIT") == 0)
        read_unit(z, word, n);
    else if (strcmp(key, "ENPD") == 0 || strcmp(key, "FNUM") == 0 || strcmp(key, "OBNA") == 0 ||
             strcmp(key, "FLOA") == 0)
        read_pupil(z, key, word, n);
    else if (strcmp(key, "MODE") == 0) {
        if (n > 1 && !rmap_lens_is(word[1], "SEQ"))
            rmap_lens_lost(lens, z->lines.number, NULL,
                           "MODE %.20s: a non-sequential system; its objects are not understood, "
                           "and its surfaces are taken as those of a sequential one",
                           word[1]);
    } else if (strcmp(key, "RAIM") == 0) /* 0: off; 1: paraxial; 2: real */
        lens->aims_at_stop = rmap_lens_value(word, n, 2, 0) > 0;
    else if (strcmp(key, "FTYP") == 0)
        read_type_of_fields(z, word, n);
    else if (strcmp(key, "XFLN") == 0)
        read_values(word, n, &f->x, stride);
    else if (strcmp(key, "YFLN") == 0)
        read_values(word, n, &f->y, stride);
    else if (strcmp(key, "FWGN") == 0)
        read_values(word, n, &f->weight, stride);
    else if (strcmp(key, "VDXN") == 0 || strcmp(key, "ZVDX") == 0)
        read_values(word, n, &f->vx[0], stride);
    else if (strcmp(key, "VDYN") == 0 || strcmp(key, "ZVDY") == 0)
        read_values(word, n, &f->vy[0], stride);
    else if (strcmp(key, "VCXN") == 0 || strcmp(key, "ZVCX") == 0)
        read_values(word, n, &f->vx[1], stride);
    else if (strcmp(key, "VCYN") == 0 || strcmp(key, "ZVCY") == 0)
        read_values(word, n, &f->vy[1], stride);
    else if (strcmp(key, "WAVM") == 0)
        read_wavelength(z, word, n);
    else if (strcmp(key, "WAVL") == 0) {
        read_values(word, n, z->list_wavelength, 1);
        for (size_t i = 0; i + 1 < n && i < RMAP_PRESCRIPTION_WAVELENGTHS_MAX; i++)
            if (z->list_wavelength[i] > 0) {
                lens->wavelength_nm[i] = rmap_lens_nm(z->list_wavelength[i]);
                lens->wavelength_weight[i] = 1;
                lens->n_wavelength = i + 1;
            }
    } else if (strcmp(key, "WWGT") == 0)
        read_values(word, n, lens->wavelength_weight, 1);
    else if (strcmp(key, "PWAV") == 0) {
        const double k = rmap_lens_value(word, n, 1, 1);
        lens->primary = k >= 1 && k <= RMAP_PRESCRIPTION_WAVELENGTHS_MAX ? (size_t)k - 1 : 0;
    } else if (strcmp(key, "ENVD") == 0) {
        lens->temperature_c = rmap_lens_value(word, n, 1, (double)NAN);
        lens->pressure_atm = rmap_lens_value(word, n, 2, (double)NAN);
    } else
        return false;
    return true;
}

/* Texts that are not cut into words. */
static bool read_text(struct zmx *z, const char *key, const char *rest, enum rmap_status *st)
{
    struct rmap_prescription *lens = z->lens;
    if (strcmp(key, "NAME") == 0 && !z->surface)
        rmap_lens_copy(lens->title, sizeof lens->title, rest);
    else if (strcmp(key, "VERS") == 0)
        rmap_lens_copy(lens->version, sizeof lens->version, rest);
    else if (strcmp(key, "GCAT") == 0)
        rmap_lens_copy(lens->catalogues, sizeof lens->catalogues, rest);
    else if (strcmp(key, "COMM") == 0 && z->surface)
        rmap_lens_copy(z->surface->comment, sizeof z->surface->comment, rest);
    else if (strcmp(key, "NOTE") == 0 && rest[0] == '0') {
        rest += 1;
        rest += strspn(rest, " ");
        *st = rmap_lens_note(lens, rest, z->err);
    } else
        return false;
    return true;
}

static void tell_unknown(struct zmx *z, const char *key)
{
    char spaced[8];
    (void)snprintf(spaced, sizeof spaced, " %.4s ", key);
    for (size_t i = 0; i < z->n_seen; i++)
        if (strncmp(z->seen[i], key, 4) == 0)
            return;
    if (strstr(harmless, spaced) || z->n_seen >= RMAP_COUNT(z->seen))
        return;
    rmap_lens_copy(z->seen[z->n_seen++], sizeof z->seen[0], key);
    rmap_lens_lost(z->lens, z->lines.number, z->surface, "'%.4s' is not understood", key);
}

static size_t lens_index(const struct zmx *z)
{
    return (size_t)(z->surface - z->lens->surface);
}

static enum rmap_status begin_surface(struct zmx *z)
{
    end_surface(z);
    memset(&z->numbers, 0, sizeof z->numbers);
    z->surface = rmap_lens_add(z->lens, z->lines.number, z->err);
    return z->surface ? RMAP_OK : z->err->status;
}

static enum rmap_status read_line(struct zmx *z)
{
    char *word[RMAP_LENS_WORDS_MAX], key[5] = "";
    char *at = z->lines.line + strspn(z->lines.line, " \t");
    const size_t n_key = strcspn(at, " \t");
    enum rmap_status st = RMAP_OK;
    if (n_key == 0)
        return RMAP_OK;
    if (n_key > KEY_LETTERS) {
        tell_unknown(z, at);
        return RMAP_OK;
    }
    memcpy(key, at, n_key);
    if (strcmp(key, "SURF") == 0)
        return begin_surface(z);
    if (z->surface && at > z->lines.line)
        z->indented = true;
    else if (z->indented || strcmp(key, "MNUM") == 0 || z->behind) {
        z->behind = true; /* tolerances, a merit function, configurations: lens_zmx_config.h */
        return RMAP_OK;
    }
    if (read_text(z, key, at + n_key + strspn(at + n_key, " \t"), &st))
        return st;
    const size_t n = rmap_lens_words(at, "", word);
    for (size_t i = 0; z->surface && i < RMAP_COUNT(solves); i++)
        if (strcmp(solves[i].word, key) == 0) {
            rmap_lens_remark(z->surface, "%s", solves[i].text);
            if (strcmp(key, "TCOM") == 0 || strcmp(key, "TOLE") == 0)
                rmap_zmx_add_sum(
                    &z->changes,
                    (struct rmap_zmx_sum){.surface = lens_index(z),
                                          .from = (size_t)fmax(rmap_lens_value(word, n, 1, 0), 0),
                                          .of_two = key[1] == 'C',
                                          .sum = rmap_lens_value(word, n, 2, 0)});
            else if (z->lens->n_configuration > 1 && strstr(solves[i].text, "by a solve"))
                rmap_lens_lost(z->lens, z->lines.number, z->surface,
                               "%s: it is not solved again in other configurations",
                               solves[i].text);
            return RMAP_OK;
        }
    rmap_lens_expect_number(z->lens, z->lines.number, z->surface,
                            z->surface ? "CURV CONI DIAM PARM:2 XDAT:2 CLAP:2 OBSC:2 CLOB:2 SQAP:2 "
                                         "SQOB:2 ELAP:2 ELOB:2 SPID:2 OBDC:2"
                                       : "ENPD FNUM OBNA FTYP:4 WAVM:3 PWAV ENVD:2 XFLN:99 YFLN:99 "
                                         "FWGN:99 VDXN:99 VDYN:99 VCXN:99 VCYN:99 WAVL:99 WWGT:99",
                            key, word, n);
    if (!(z->surface && read_of_surface(z, key, word, n)) && !read_of_lens(z, key, word, n))
        tell_unknown(z, key);
    return RMAP_OK;
}

/* VDY and VCY, by which Zemax shifts and narrows the pupil, as what is cut at either end. */
static void cut_pupils(struct rmap_prescription *lens)
{
    for (size_t i = 0; i < lens->n_field; i++) {
        double *ends[2] = {lens->field[i].vx, lens->field[i].vy};
        for (int k = 0; k < 2; k++) {
            const double shift = ends[k][0], narrow = ends[k][1];
            ends[k][0] = narrow + shift;
            ends[k][1] = narrow - shift;
        }
        if (lens->field[i].weight == 0)
            lens->field[i].weight = 1;
    }
}

enum rmap_status rmap_lens_read_zmx(char *text, struct rmap_prescription *lens,
                                    struct rmap_error *err)
{
    struct zmx z = {.lens = lens, .lines = {.at = text}, .err = err};
    enum rmap_status st = rmap_zmx_read_changes(text, lens, &z.changes, err);
    lens->format = "Zemax";
    while (st == RMAP_OK && rmap_lens_next_line(&z.lines))
        st = read_line(&z);
    if (st == RMAP_OK) {
        end_surface(&z);
        rmap_zmx_change_lens(&z.changes, lens);
    }
    rmap_zmx_changes_fini(&z.changes);
    if (st != RMAP_OK)
        return st;
    if (lens->n_surface == 0)
        return rmap_error_set(err, RMAP_INPUT, "it has no line 'SURF 0': is it a Zemax file?");
    if (z.n_wavelength_said > 0 && z.n_wavelength_said < lens->n_wavelength)
        lens->n_wavelength = z.n_wavelength_said; /* 24 stand there in any case */
    cut_pupils(lens);
    return RMAP_OK;
}
