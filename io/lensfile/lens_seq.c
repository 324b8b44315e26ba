/* SPDX-License-Identifier: MIT
 *
 * CODE V's sequence files (.seq): commands of letters with their values, several in a line with ';'
 * between them, '!' before remarks, '&' at the end of a line that goes on. A command is known by
 * its first three letters; `S radius thickness glass` is the next surface.
 *
 * XDE YDE ZDE move the axes at a surface and ADE BDE CDE turn them, about x and y left-handed,
 * about z right-handed; DAR turns back behind it, BEN turns once more (a mirror that bends the
 * axis), REV does the inverse behind it instead.
 */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/count.h"
#include "io/lensfile/lens_seq_shape.h"
#include "io/lensfile/lens_text.h"

enum decentre { DECENTRE_BASIC, DECENTRE_RETURN, DECENTRE_BEND, DECENTRE_REVERSE };

struct seq {
    struct rmap_prescription *lens;
    struct rmap_lens_lines lines;
    struct rmap_error *err;
    size_t at; /* the surface that commands are about, from 1; 0: none yet */
    bool radii, mode_said, done;
    struct rmap_seq_shape shape; /* of that surface */
    bool in_private;             /* in the private catalogue */
    double private_um[RMAP_AGF_ROWS];
    size_t n_private;
    int configuration;            /* zoom position, from 1 */
    double shift[3], tilt_deg[3]; /* of that surface */
    enum decentre decentre;
    double defocus; /* SI's thickness */
    char seen[32][4];
    size_t n_seen;
};

static struct rmap_lens_surface *current(struct seq *s)
{
    return s->at ? &s->lens->surface[s->at - 1] : NULL;
}

/* ---- places ---- */

static void end_surface(struct seq *s)
{
    struct rmap_lens_surface *surface = current(s);
    const double tilt[3] = {-s->tilt_deg[0], -s->tilt_deg[1], s->tilt_deg[2]};
    const double none[3] = {0, 0, 0}, quarter[3] = {0, 0, 90};
    bool turned = false;
    if (surface) {
        const struct rmap_affine there = rmap_lens_turn(s->shift, tilt);
        struct rmap_affine back = rmap_affine_identity();
        (void)rmap_affine_invert(&there, &back);
        surface->before = s->decentre == DECENTRE_REVERSE ? rmap_affine_identity() : there;
        surface->after = s->decentre == DECENTRE_BASIC  ? rmap_affine_identity()
                         : s->decentre == DECENTRE_BEND ? rmap_lens_turn(none, tilt)
                                                        : back;
        rmap_seq_shape_end(surface, &s->shape, &turned);
    }
    if (turned) {
        const struct rmap_affine turn = rmap_lens_turn(none, quarter);
        struct rmap_affine turn_back = rmap_affine_identity();
        (void)rmap_affine_invert(&turn, &turn_back);
        surface->before = rmap_affine_compose(&surface->before, &turn);
        surface->after = rmap_affine_compose(&turn_back, &surface->after);
    }
    memset(&s->shape, 0, sizeof s->shape);
    memset(s->shift, 0, sizeof s->shift);
    memset(s->tilt_deg, 0, sizeof s->tilt_deg);
    s->decentre = DECENTRE_BASIC;
}

static bool read_decentre(struct seq *s, const char *key, double value)
{
    static const char *const shifts[] = {"XDE", "YDE", "ZDE"},
                             *const tilts[] = {"ADE", "BDE", "CDE"},
                             *const kinds[] = {"DEC", "DAR", "BEN", "REV"};
    for (int i = 0; i < 3; i++)
        if (strcmp(key, shifts[i]) == 0) {
            s->shift[i] = value;
            return true;
        } else if (strcmp(key, tilts[i]) == 0) {
            s->tilt_deg[i] = value;
            return true;
        }
    for (size_t i = 0; i < RMAP_COUNT(kinds); i++)
        if (strcmp(key, kinds[i]) == 0) {
            s->decentre = (enum decentre)i;
            return true;
        }
    return false;
}

/* ---- surfaces ---- */

/* "NBK7_SCHOTT": the maker behind; "569.631": nd - 1 without its point, and Vd / 100. */
static void set_glass(struct seq *s, struct rmap_lens_surface *surface, const char *word)
{
    const char *point = strchr(word, '.'), *colon = strchr(word, ':');
    double number = 0;
    if (rmap_lens_is(word, "REFL") || rmap_lens_is(word, "TIRO")) {
        surface->is_mirror = true;
        return;
    }
    if (rmap_lens_is(word, "AIR") || rmap_lens_is(word, "REFR"))
        return;
    rmap_lens_copy(surface->glass, sizeof surface->glass, word);
    if (!isdigit((unsigned char)word[0]) || !point)
        return;
    if (rmap_lens_number(word, &number) && number < 5) { /* nd; Vd follows */
        surface->is_model = true;
        surface->nd = number;
        return;
    }
    char digits[32];
    if (colon) { /* nd:Vd */
        rmap_lens_copy(digits, sizeof digits, word);
        digits[strcspn(digits, ":")] = 0;
        surface->is_model =
            rmap_lens_number(digits, &surface->nd) && rmap_lens_number(colon + 1, &surface->vd);
        return;
    }
    surface->is_model = true;
    rmap_lens_copy(digits, sizeof digits, word);
    digits[strcspn(digits, ".")] = 0;
    double whole = 0, part = 0;
    char behind[32] = "0";
    (void)snprintf(behind, sizeof behind, "0.%.24s", point + 1);
    if (!rmap_lens_number(digits, &whole) || !rmap_lens_number(behind, &part)) {
        rmap_lens_lost(s->lens, s->lines.number, surface, "glass '%.40s' is not understood", word);
        surface->is_model = false;
        return;
    }
    surface->nd = 1 + whole / pow(10, (double)strlen(digits));
    surface->vd = 100 * part;
}

static void set_shape(struct seq *s, struct rmap_lens_surface *surface, double radius_or_curvature)
{
    const bool flat = !s->radii || radius_or_curvature == 0;
    surface->curvature = flat ? (s->radii ? 0 : radius_or_curvature) : 1 / radius_or_curvature;
}

static double read_thickness(char *const *word, size_t n, size_t k)
{
    const double value = rmap_lens_value(word, n, k, 0);
    return fabs(value) >= 1e10 || (k < n && rmap_lens_is(word[k], "inf")) ? HUGE_VAL : value;
}

static enum rmap_status read_surface(struct seq *s, char **word, size_t n)
{
    end_surface(s);
    struct rmap_lens_surface *surface = rmap_lens_add(s->lens, s->lines.number, s->err);
    if (!surface)
        return s->err->status;
    s->at = s->lens->n_surface;
    for (size_t k = 0; k < 2 && k + 1 < n; k++) /* radius, thickness */
        if (!rmap_lens_is(word[k + 1], "inf"))
            rmap_lens_expect_number(s->lens, s->lines.number, surface, word[0], word[0], word + k,
                                    n - k);
    set_shape(s, surface, rmap_lens_value(word, n, 1, 0));
    surface->thickness = read_thickness(word, n, 2);
    for (size_t i = 3; i < n; i++)
        if (i == 4 && surface->is_model && surface->vd == 0) /* nd and Vd, each by itself */
            surface->vd = rmap_lens_value(word, n, i, 0);
        else
            set_glass(s, surface, word[i]);
    if (rmap_lens_is(word[0], "SI"))
        s->defocus = surface->thickness;
    return RMAP_OK;
}

/* "S5", "SO", "SI" before the values: another surface than the last one. */
static struct rmap_lens_surface *addressed(struct seq *s, char **word, size_t *n)
{
    struct rmap_lens_surface *surface = current(s);
    double number = 0;
    if (*n < 2 || toupper((unsigned char)word[1][0]) != 'S' || !surface)
        return surface;
    if (rmap_lens_is(word[1], "SO"))
        surface = s->lens->surface;
    else if (!rmap_lens_number(word[1] + 1, &number))
        return surface;
    else if (number >= 0 && number < (double)s->lens->n_surface)
        surface = &s->lens->surface[(size_t)number];
    else {
        rmap_lens_lost(s->lens, s->lines.number, NULL,
                       "%.8s %.12s: the lens has no such surface here", word[0], word[1]);
        *n = 0;
        return surface;
    }
    memmove(&word[1], &word[2], (*n - 2) * sizeof *word);
    --*n;
    return surface;
}

static bool read_asphere(struct seq *s, struct rmap_lens_surface *surface, const char *key,
                         double value)
{
    static const char letters[] = "ABCDEFGHJ"; /* of r^4, r^6 ... r^20 */
    const char *letter = key[1] == 0 ? strchr(letters, key[0]) : NULL;
    if (letter && *letter) {
        if (!rmap_lens_set_asphere(surface, 4 + 2 * (int)(letter - letters), value))
            rmap_lens_lost(s->lens, s->lines.number, surface, "coefficient %s is left out", key);
        return true;
    }
    if (strcmp(key, "K") != 0)
        return false;
    surface->conic = value;
    return true;
}

static void read_aperture(struct rmap_lens_surface *surface, const char *key, char **word, size_t n)
{
    const bool plate = n > 2 && rmap_lens_is(word[1], "OBS");
    if (n > 2 && rmap_lens_is(word[1], "HOL") && strcmp(key, "CIR") == 0)
        surface->aperture.inner = fabs(rmap_lens_value(word, n, n - 1, 0));
    if (n > 2 && !plate) {
        if (!rmap_lens_is(word[1], "CLR"))
            return; /* EDG: of its edge */
    }
    struct rmap_lens_opening *opening = plate ? &surface->obscuration : &surface->aperture;
    const double value = fabs(rmap_lens_value(word, n, n - 1, 0));
    if (!(value > 0))
        return;
    if (strcmp(key, "CIR") == 0) {
        opening->shape = RMAP_OPENING_CIRCLE;
        opening->half[0] = opening->half[1] = value;
        if (!plate)
            surface->semi = value;
    } else {
        opening->shape = key[0] == 'R' ? RMAP_OPENING_RECTANGLE : RMAP_OPENING_ELLIPSE;
        opening->half[key[2] == 'Y'] = value;
        if (!(opening->half[key[2] != 'Y'] > 0))
            opening->half[key[2] != 'Y'] = value;
    }
}

static bool read_of_surface(struct seq *s, const char *key, char **word, size_t n)
{
    struct rmap_lens_surface *surface = addressed(s, word, &n);
    const double value = rmap_lens_value(word, n, 1, 0);
    if (!surface || n == 0)
        return n == 0;
    rmap_lens_expect_number(
        s->lens, s->lines.number, surface,
        "RDY CUY K A B C D E F G H J CIR:$ REX:$ REY:$ ELX:$ ELY:$ ADX ADY ARO XDE "
        "YDE ZDE ADE BDE CDE",
        key, word, n);
    if (strcmp(key, "STO") == 0)
        surface->is_stop = true;
    else if (strcmp(key, "RDY") == 0 || strcmp(key, "CUY") == 0)
        surface->curvature = key[0] == 'C' ? value : value == 0 ? 0 : 1 / value;
    else if (strcmp(key, "THI") == 0 && n > 1 && strpbrk(word[1], "0123456789"))
        surface->thickness = read_thickness(word, n, 1);
    else if (strcmp(key, "THI") == 0)
        rmap_lens_remark(surface, "thickness by a solve (%.10s), as stored", n > 1 ? word[1] : "");
    else if (strcmp(key, "GLA") == 0 && n > 1)
        set_glass(s, surface, word[1]);
    else if (strcmp(key, "RMD") == 0 && n > 1)
        set_glass(s, surface, word[1]);
    else if (strcmp(key, "SLB") == 0 && n > 1)
        rmap_lens_copy(surface->comment, sizeof surface->comment, word[1]);
    else if (strcmp(key, "PIM") == 0)
        rmap_lens_remark(surface, "thickness by a solve (paraxial image), as stored");
    else if (strcmp(key, "PIK") == 0)
        rmap_lens_remark(surface, "a value by a pickup, as stored");
    else if (strcmp(key, "UMY") == 0 || strcmp(key, "HMY") == 0)
        rmap_lens_remark(surface, "a value by a solve (%s), as stored", key);
    else if (strcmp(key, "CIR") == 0 || strcmp(key, "REX") == 0 || strcmp(key, "REY") == 0 ||
             strcmp(key, "ELX") == 0 || strcmp(key, "ELY") == 0)
        read_aperture(surface, key, word, n);
    else if (strcmp(key, "ADX") == 0 || strcmp(key, "ADY") == 0)
        surface->aperture.centre[key[2] == 'Y'] = surface->obscuration.centre[key[2] == 'Y'] =
            value;
    else if (strcmp(key, "GRT") == 0 || strcmp(key, "DIF") == 0 || strcmp(key, "HOE") == 0)
        rmap_lens_lost(s->lens, s->lines.number, surface,
                       "diffraction (%s%s%.10s) is not understood: its surface stands there "
                       "without it",
                       key, n > 1 ? " " : "", n > 1 ? word[1] : "");
    else if (strcmp(key, "COA") == 0 || strcmp(key, "MLT") == 0)
        rmap_lens_lost(s->lens, s->lines.number, surface, "its coating is left out");
    else if (strcmp(key, "ARO") == 0 && value != 0)
        rmap_lens_lost(s->lens, s->lines.number, surface, "its aperture is not turned: ARO %g",
                       value);
    else
        return read_asphere(s, surface, key, value) ||
               (surface == current(s) && (read_decentre(s, key, value) ||
                                          rmap_seq_shape_command(s->lens, s->lines.number, surface,
                                                                 &s->shape, key, word, n)));
    return true;
}

/* ---- the whole ---- */

static void read_fields(struct seq *s, const char *key, char **word, size_t n)
{
    struct rmap_prescription *lens = s->lens;
    lens->field_kind = strcmp(key + 1, "AN") == 0   ? RMAP_FIELD_ANGLE
                       : strcmp(key + 1, "OB") == 0 ? RMAP_FIELD_OBJECT_HEIGHT
                       : strcmp(key + 1, "RI") == 0 ? RMAP_FIELD_REAL_HEIGHT
                                                    : RMAP_FIELD_IMAGE_HEIGHT;
    for (size_t i = 1; i < n && i <= RMAP_PRESCRIPTION_FIELDS_MAX; i++) {
        const double value = rmap_lens_value(word, n, i, 0);
        *(key[0] == 'X' ? &lens->field[i - 1].x : &lens->field[i - 1].y) = value;
        lens->field[i - 1].weight = 1;
        lens->n_field = i > lens->n_field ? i : lens->n_field;
    }
}

static void read_vignetting(struct seq *s, const char *key, char **word, size_t n)
{
    for (size_t i = 1; i < n && i <= RMAP_PRESCRIPTION_FIELDS_MAX; i++) {
        struct rmap_lens_field *f = &s->lens->field[i - 1];
        (key[2] == 'X' ? f->vx : f->vy)[key[1] == 'U'] = rmap_lens_value(word, n, i, 0);
    }
}

static void read_wavelengths(struct seq *s, char **word, size_t n)
{
    struct rmap_prescription *lens = s->lens;
    lens->n_wavelength = 0;
    for (size_t i = 1; i < n && i <= RMAP_PRESCRIPTION_WAVELENGTHS_MAX; i++) {
        const double nm = rmap_lens_value(word, n, i, 0);
        if (!(nm > 0))
            break;
        lens->wavelength_nm[i - 1] = nm;
        lens->wavelength_weight[i - 1] = 1;
        lens->n_wavelength = i;
    }
    lens->primary = lens->n_wavelength / 2;
}

static bool read_of_lens(struct seq *s, const char *key, char **word, size_t n)
{
    static const struct {
        const char *key;
        enum rmap_lens_pupil pupil;
    } pupils[] = {{"EPD", RMAP_PUPIL_DIAMETER},
                  {"FNO", RMAP_PUPIL_WORKING_F_NUMBER},
                  {"NAO", RMAP_PUPIL_OBJECT_NA},
                  {"NA", RMAP_PUPIL_IMAGE_NA}};
    struct rmap_prescription *lens = s->lens;
    const double value = rmap_lens_value(word, n, 1, 0);
    rmap_lens_expect_number(
        lens, s->lines.number, NULL,
        "EPD FNO NAO NA WL:99 WTW:99 REF XAN:99 YAN:99 XOB:99 YOB:99 XIM:99 YIM:99 "
        "XRI:99 YRI:99 VUX:99 VUY:99 VLX:99 VLY:99 TEM PRE",
        key, word, n);
    for (size_t i = 0; i < RMAP_COUNT(pupils); i++)
        if (strcmp(key, pupils[i].key) == 0) {
            lens->pupil = pupils[i].pupil;
            lens->pupil_value = fabs(value);
            return true;
        }
    if (strcmp(key, "RDM") == 0) {
        s->radii = !(n > 1 && toupper((unsigned char)word[1][0]) == 'N');
        s->mode_said = true;
    } else if (strcmp(key, "TIT") == 0 && n > 2 && toupper((unsigned char)word[1][0]) == 'Z') {
        if (rmap_lens_value((char *[]){word[1] + 1}, 1, 0, 0) == s->configuration)
            rmap_lens_copy(lens->configuration_name, sizeof lens->configuration_name, word[2]);
    } else if (strcmp(key, "TIT") == 0 && n > 1)
        rmap_lens_copy(lens->title, sizeof lens->title, word[1]);
    else if (strcmp(key, "DIM") == 0 && n > 1)
        lens->unit = toupper((unsigned char)word[1][0]) == 'C'   ? "cm"
                     : toupper((unsigned char)word[1][0]) == 'I' ? "in"
                                                                 : "mm";
    else if (strcmp(key, "WL") == 0)
        read_wavelengths(s, word, n);
    else if (strcmp(key, "WTW") == 0)
        for (size_t i = 1; i < n && i <= RMAP_PRESCRIPTION_WAVELENGTHS_MAX; i++)
            lens->wavelength_weight[i - 1] = fabs(rmap_lens_value(word, n, i, 1));
    else if (strcmp(key, "REF") == 0)
        lens->primary =
            value >= 1 && value <= RMAP_PRESCRIPTION_WAVELENGTHS_MAX ? (size_t)value - 1 : 0;
    else if (strlen(key) == 3 && strchr("XY", key[0]) && strstr("AN OB IM RI", key + 1))
        read_fields(s, key, word, n);
    else if (key[0] == 'V' && strlen(key) == 3 && strchr("UL", key[1]) && strchr("XY", key[2]))
        read_vignetting(s, key, word, n);
    else if (strcmp(key, "TEM") == 0)
        lens->temperature_c = value;
    else if (strcmp(key, "PRE") == 0)
        lens->pressure_atm = value / 760;
    else if (strcmp(key, "GO") == 0)
        s->done = true;
    else
        return false;
    return true;
}

/* ---- private glasses, zoom positions ---- */

/* PRV; PWL wavelengths; 'NAME' indices; END. */
static enum rmap_status read_private(struct seq *s, char **word, size_t n)
{
    if (rmap_lens_is(word[0], "END")) {
        s->in_private = false;
        return RMAP_OK;
    }
    if (rmap_lens_is(word[0], "PWL")) {
        s->n_private = 0;
        for (size_t i = 1; i < n && i <= RMAP_AGF_ROWS; i++)
            s->private_um[s->n_private++] = 1e-3 * rmap_lens_value(word, n, i, 0);
        return RMAP_OK;
    }
    double index[RMAP_AGF_ROWS];
    size_t n_index = 0;
    for (; n_index + 1 < n && n_index < s->n_private; n_index++)
        index[n_index] = rmap_lens_value(word, n, n_index + 1, 0);
    return rmap_lens_add_glass(s->lens, s->lines.number, word[0], s->private_um, index, n_index,
                               s->err);
}

static enum rmap_status read_words(struct seq *s, char **word, size_t n);

/* "ZOO THI S5 1 2 3": the command with the value of the position. */
static enum rmap_status read_zoom(struct seq *s, char **word, size_t n)
{
    double value = 0;
    if (n < 2 || strncmp(word[1], "TIT", 3) == 0 || rmap_lens_is(word[1], "THC"))
        return RMAP_OK;
    if (n == 2 && rmap_lens_number(word[1], &value)) {
        s->lens->n_configuration = value >= 1 && value < 1000 ? (int)value : 1;
        return RMAP_OK;
    }
    const bool has_target = n > 2 && strchr("SsFf", word[2][0]);
    const size_t first = has_target ? 3 : 2, at = first + (size_t)s->configuration - 1;
    if (first >= n)
        return RMAP_OK;
    char *chosen = word[at < n ? at : n - 1];
    if (has_target && toupper((unsigned char)word[2][0]) == 'F') {
        const double field = rmap_lens_value((char *[]){word[2] + 1}, 1, 0, 0);
        if (!(field >= 1 && field <= RMAP_PRESCRIPTION_FIELDS_MAX) || strlen(word[1]) != 3 ||
            !rmap_lens_number(chosen, &value)) {
            rmap_lens_lost(s->lens, s->lines.number, NULL, "ZOO %.8s %.8s %.40s is left out",
                           word[1], word[2], chosen);
            return RMAP_OK;
        }
        struct rmap_lens_field *f = &s->lens->field[(size_t)field - 1];
        const char c = (char)toupper((unsigned char)word[1][0]);
        if (c == 'V')
            (toupper((unsigned char)word[1][2]) == 'X'
                 ? f->vx
                 : f->vy)[toupper((unsigned char)word[1][1]) == 'U'] = value;
        else if (c == 'X' || c == 'Y')
            *(c == 'X' ? &f->x : &f->y) = value;
        return RMAP_OK;
    }
    word[first] = chosen;
    return read_words(s, word + 1, first);
}

/* Without a meaning for the scene: variables, couplings, weights, derivatives, pictures. */
static const char harmless[] = " LEN INI CCY THC KC ASP CON SPH AC BC CC DC EC FC GC HC JC CUF DER "
                               "WTF RSL DES LAB CUM THM XDC YDC ZDC "
                               "ADC BDC CDC GLC WTX WTY MFL SPC CLS POL CA NOA DOR HOR HWL HCT HCO "
                               "HCC GRO GRX GRY GRZ SCC CON "
                               "VER PRO CIN BUY SAV PCC ";

static void tell_unknown(struct seq *s, const char *key)
{
    char spaced[8];
    (void)snprintf(spaced, sizeof spaced, " %.3s ", key);
    for (size_t i = 0; i < s->n_seen; i++)
        if (strcmp(s->seen[i], key) == 0)
            return;
    if (strstr(harmless, spaced) || s->n_seen >= RMAP_COUNT(s->seen))
        return;
    rmap_lens_copy(s->seen[s->n_seen++], sizeof s->seen[0], key);
    rmap_lens_lost(s->lens, s->lines.number, current(s), "'%s' is not understood", key);
}

static bool is_surface(const char *word)
{
    const size_t n = strlen(word);
    return toupper((unsigned char)word[0]) == 'S' &&
           (n == 1 || rmap_lens_is(word, "SO") || rmap_lens_is(word, "SI") ||
            strspn(word + 1, "0123456789") == n - 1);
}

static enum rmap_status read_words(struct seq *s, char **word, size_t n)
{
    char key[4];
    if (s->in_private)
        return read_private(s, word, n);
    if (is_surface(word[0]))
        return read_surface(s, word, n);
    rmap_lens_copy(key, sizeof key, word[0]);
    for (char *c = key; *c; c++)
        *c = (char)toupper((unsigned char)*c);
    if (strcmp(key, "ZOO") == 0)
        return read_zoom(s, word, n);
    if (strcmp(key, "PRV") == 0)
        s->in_private = true;
    else if (!read_of_lens(s, key, word, n) && !read_of_surface(s, key, word, n))
        tell_unknown(s, key);
    return RMAP_OK;
}

static enum rmap_status read_command(struct seq *s, char *text)
{
    char *word[RMAP_LENS_WORDS_MAX];
    const size_t n = rmap_lens_words(text, ",", word);
    return n == 0 || s->done ? RMAP_OK : read_words(s, word, n);
}

/* Where a remark or the next command begins, outside quotes. */
static char *end_of_command(char *at)
{
    char quote = 0;
    for (; *at && (quote || !strchr("!;", *at)); at++)
        if (quote ? *at == quote : *at == '"' || *at == '\'')
            quote = quote ? 0 : *at;
    return at;
}

static enum rmap_status read_line(struct seq *s, char *line)
{
    enum rmap_status st = RMAP_OK;
    for (char *at = line; st == RMAP_OK && *at;) {
        char *end = end_of_command(at);
        const char mark = *end;
        *end = 0;
        st = read_command(s, at);
        if (mark == '!')
            break;
        at = mark ? end + 1 : end;
    }
    return st;
}

/* Without RDM numbers are curvatures. What is written by hand may forget it: a curvature of 2 and
 * more is none of a lens. */
static void check_mode(struct seq *s)
{
    struct rmap_prescription *lens = s->lens;
    double most = 0;
    for (size_t i = 0; i < lens->n_surface && !s->mode_said; i++)
        if (lens->surface[i].curvature != 0)
            most = fmax(most, 1 / fabs(lens->surface[i].curvature));
    if (s->mode_said)
        return;
    if (most >= 2) {
        rmap_lens_lost(lens, 0, NULL,
                       "without RDM its surfaces would have curvatures up to %.4g: they are taken "
                       "to be radii",
                       most);
        return;
    }
    for (size_t i = 0; i < lens->n_surface; i++)
        if (lens->surface[i].curvature != 0)
            lens->surface[i].curvature = 1 / lens->surface[i].curvature;
}

enum rmap_status rmap_lens_read_seq(char *text, struct rmap_prescription *lens,
                                    struct rmap_error *err)
{
    enum { LONGEST = 4096 };
    char joined[LONGEST];
    size_t n = 0;
    struct seq s = {.lens = lens, .lines = {.at = text}, .err = err, .radii = true};
    s.configuration = lens->configuration > 0 ? lens->configuration : 1;
    enum rmap_status st = RMAP_OK;
    lens->format = "CODE V";
    lens->aims_at_stop = true;
    while (st == RMAP_OK && rmap_lens_next_line(&s.lines)) {
        const size_t length = strlen(s.lines.line);
        if (n + length + 2 > LONGEST)
            return rmap_error_set(err, RMAP_INPUT, "line %zu is too long", s.lines.number);
        memcpy(joined + n, s.lines.line, length + 1);
        n += length;
        if (n > 0 && joined[n - 1] == '&') {
            joined[n - 1] = ' ';
            continue;
        }
        st = read_line(&s, joined);
        n = 0;
    }
    if (st != RMAP_OK)
        return st;
    end_surface(&s);
    check_mode(&s);
    if (lens->n_surface < 2)
        return rmap_error_set(err, RMAP_INPUT,
                              "it has no surfaces 'SO', 'S', 'SI': is it a CODE V "
                              "sequence?");
    if (isfinite(s.defocus))
        lens->surface[lens->n_surface - 2].thickness += s.defocus;
    return RMAP_OK;
}
