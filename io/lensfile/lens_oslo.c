/* SPDX-License-Identifier: MIT
 *
 * OSLO's lens files (.len): a surface's commands up to NXT, the next one's then; the first is the
 * object, the last the image. TLA and TLB turn left-handed about x and the new y, TLC right-handed
 * about the new z, behind the shift DCX DCY DCZ (DT -1: in the other order, before it), and so
 * stands all that follows, unless RCO turns back or BEN turns once more.
 */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "base/count.h"
#include "io/lensfile/lens_text.h"

struct oslo {
    struct rmap_prescription *lens;
    struct rmap_lens_lines lines;
    struct rmap_error *err;
    double angle, height;         /* ANG, OBH; 0: not said */
    double shift[3], tilt_deg[3]; /* of the surface */
    bool tilt_first, returns, bends;
    char seen[32][8];
    size_t n_seen;
};

static struct rmap_lens_surface *current(struct oslo *o)
{
    return &o->lens->surface[o->lens->n_surface - 1];
}

static void end_surface(struct oslo *o)
{
    struct rmap_lens_surface *s = current(o);
    const double tilt[3] = {-o->tilt_deg[0], -o->tilt_deg[1], o->tilt_deg[2]}, none[3] = {0, 0, 0};
    struct rmap_affine back = rmap_affine_identity();
    s->before = rmap_lens_turn(o->shift, tilt);
    if (o->tilt_first) { /* about z, y and x, then the shift */
        const double back_shift[3] = {-o->shift[0], -o->shift[1], -o->shift[2]},
                     back_tilt[3] = {-tilt[0], -tilt[1], -tilt[2]};
        const struct rmap_affine inverse = rmap_lens_turn(back_shift, back_tilt);
        (void)rmap_affine_invert(&inverse, &s->before);
    }
    (void)rmap_affine_invert(&s->before, &back);
    s->after = o->returns ? back : o->bends ? rmap_lens_turn(none, tilt) : rmap_affine_identity();
    memset(o->shift, 0, sizeof o->shift);
    memset(o->tilt_deg, 0, sizeof o->tilt_deg);
    o->tilt_first = o->returns = o->bends = false;
}

static bool read_place(struct oslo *o, const char *key, char **word, size_t n)
{
    const double value = rmap_lens_value(word, n, 1, 0);
    const struct rmap_lens_surface *s = current(o);
    const char last = (char)(strlen(key) == 3 ? key[2] & ~0x20 : 0);
    if (strncasecmp(key, "DC", 2) == 0 && last >= 'X' && last <= 'Z')
        o->shift[last - 'X'] = value;
    else if (strncasecmp(key, "TL", 2) == 0 && last >= 'A' && last <= 'C')
        o->tilt_deg[last - 'A'] = value;
    else if (rmap_lens_is(key, "DT"))
        o->tilt_first = value < 0;
    else if (rmap_lens_is(key, "BEN"))
        o->bends = true;
    else if (rmap_lens_is(key, "RCO")) {
        o->returns = true;
        if (n > 1 && value != s->number)
            rmap_lens_lost(o->lens, o->lines.number, current(o),
                           "RCO %.20s: the axes go back to this surface's own instead", word[1]);
    } else
        return false;
    return true;
}

/* "GLA BK7", "GLA 1.5168", "GLA MOD name n1 n2 ..." at the wavelengths of WV. */
static enum rmap_status read_glass(struct oslo *o, char **word, size_t n)
{
    struct rmap_lens_surface *s = current(o);
    const bool is_model = rmap_lens_is(word[1], "MOD") && n > 3;
    double index = 0;
    if (rmap_lens_is(word[1], "REFLECT")) {
        s->is_mirror = true;
        return RMAP_OK;
    }
    rmap_lens_copy(s->glass, sizeof s->glass, word[is_model ? 2 : 1]);
    if (rmap_lens_number(word[1], &index)) {
        s->is_model = true;
        s->nd = index;
    }
    double um[RMAP_AGF_ROWS], value[RMAP_AGF_ROWS];
    size_t n_index = 0;
    for (;
         is_model && n_index + 3 < n && n_index < o->lens->n_wavelength && n_index < RMAP_AGF_ROWS;
         n_index++) {
        um[n_index] = 1e-3 * o->lens->wavelength_nm[n_index];
        value[n_index] = rmap_lens_value(word, n, n_index + 3, 0);
    }
    return rmap_lens_add_glass(o->lens, o->lines.number, s->glass, um, value, n_index, o->err);
}

static void set_fields(struct oslo *o)
{
    static const double share[] = {0, 0.7, 1};
    struct rmap_prescription *lens = o->lens;
    const double largest = o->angle != 0 ? o->angle : o->height;
    lens->field_kind = o->angle != 0 ? RMAP_FIELD_ANGLE : RMAP_FIELD_OBJECT_HEIGHT;
    lens->n_field = largest != 0 ? 3 : 1;
    for (size_t i = 0; i < lens->n_field; i++)
        lens->field[i] = (struct rmap_lens_field){.y = share[i] * largest, .weight = 1};
}

static bool read_of_lens(struct oslo *o, const char *key, char **word, size_t n)
{
    struct rmap_prescription *lens = o->lens;
    const double value = rmap_lens_value(word, n, 1, 0);
    if (rmap_lens_is(key, "LEN")) {
        if (n > 2)
            rmap_lens_copy(lens->title, sizeof lens->title, word[2]);
    } else if (rmap_lens_is(key, "EBR")) {
        lens->pupil = RMAP_PUPIL_DIAMETER;
        lens->pupil_value = 2 * fabs(value);
    } else if (rmap_lens_is(key, "NAO") || rmap_lens_is(key, "NA") || rmap_lens_is(key, "FNO") ||
               rmap_lens_is(key, "FNB")) {
        lens->pupil = rmap_lens_is(key, "NAO")  ? RMAP_PUPIL_OBJECT_NA
                      : rmap_lens_is(key, "NA") ? RMAP_PUPIL_IMAGE_NA
                                                : RMAP_PUPIL_WORKING_F_NUMBER;
        lens->pupil_value = fabs(value);
    } else if (rmap_lens_is(key, "ANG")) {
        o->angle = value;
    } else if (rmap_lens_is(key, "OBH")) {
        o->height = fabs(value);
    } else if (rmap_lens_is(key, "UNI")) {
        lens->unit = value == 10 ? "cm" : value == 1000 ? "m" : value == 25.4 ? "in" : "mm";
    } else if (rmap_lens_is(key, "WV") || rmap_lens_is(key, "WW")) {
        for (size_t i = 1; i < n && i <= RMAP_PRESCRIPTION_WAVELENGTHS_MAX; i++) {
            const double number = rmap_lens_value(word, n, i, 0);
            if (rmap_lens_is(key, "WW")) {
                lens->wavelength_weight[i - 1] = fabs(number);
            } else if (number > 0) {
                lens->wavelength_nm[i - 1] = rmap_lens_nm(number);
                lens->wavelength_weight[i - 1] = 1;
                lens->n_wavelength = i;
            }
        }
    } else {
        return false;
    }
    return true;
}

static void read_asphere(struct oslo *o, const char *key, char **word, size_t n, double value)
{
    struct rmap_lens_surface *s = current(o);
    double k = 0;
    if (rmap_lens_is(key, "ASP")) {
        if (n > 1 && !rmap_lens_is(word[1], "ASR"))
            rmap_lens_lost(
                o->lens, o->lines.number, s,
                "asphere ASP %.8s is not understood: its coefficients are taken as those "
                "of r^2, r^4 and so on",
                word[1]);
    } else if (strlen(key) == 2 && !isdigit((unsigned char)key[1])) { /* AD AE AF AG: r^4 on */
        (void)rmap_lens_set_asphere(s, 4 + 2 * ((key[1] | 0x20) - 'd'), value);
    } else if (!rmap_lens_number(key + 2, &k) ||
               !rmap_lens_set_asphere(s, 2 * (int)fmin(k, 100) + 2, value)) { /* AS0: r^2 */
        rmap_lens_lost(o->lens, o->lines.number, s, "coefficient %.8s is left out", key);
    }
}

/* What has no counterpart in a scene. */
static bool tell_lost(struct oslo *o, const char *key)
{
    struct rmap_lens_surface *s = current(o);
    if (rmap_lens_is(key, "GSP") || rmap_lens_is(key, "GOR"))
        rmap_lens_lost(o->lens, o->lines.number, s,
                       "diffraction grating (%s) is not understood: its surface stands there "
                       "without it",
                       key);
    else if (rmap_lens_is(key, "PFL") || rmap_lens_is(key, "PFM"))
        rmap_lens_lost(o->lens, o->lines.number, s,
                       "an ideal lens (%s) is not understood: no surface does what it does", key);
    else if (rmap_lens_is(key, "PK") || rmap_lens_is(key, "PY") || rmap_lens_is(key, "PU") ||
             rmap_lens_is(key, "PUC") || rmap_lens_is(key, "PYC"))
        rmap_lens_remark(s, "a value by a %s (%s), as stored",
                         (key[1] | 0x20) == 'k' ? "pickup" : "solve", key);
    else
        return false;
    return true;
}

static bool read_of_surface(struct oslo *o, const char *key, char **word, size_t n,
                            enum rmap_status *st)
{
    struct rmap_lens_surface *s = current(o);
    const double value = rmap_lens_value(word, n, 1, 0);
    double ignored = 0;
    const bool is_asphere =
        (key[0] | 0x20) == 'a' &&
        (rmap_lens_is(key, "AD") || rmap_lens_is(key, "AE") || rmap_lens_is(key, "AF") ||
         rmap_lens_is(key, "AG") || rmap_lens_is(key, "ASP") ||
         (strncasecmp(key, "AS", 2) == 0 && isdigit((unsigned char)key[2])));
    if (is_asphere)
        read_asphere(o, key, word, n, value);
    else if (rmap_lens_is(key, "RD"))
        s->curvature = value == 0 ? 0 : 1 / value;
    else if (rmap_lens_is(key, "CV"))
        s->curvature = value;
    else if (rmap_lens_is(key, "CVX")) { /* of its toroid, across */
        s->figure.is_toroid = true;
        s->figure.turn = value != 0 ? 1 / value : HUGE_VAL;
    } else if (rmap_lens_is(key, "CC"))
        s->conic = value;
    else if (rmap_lens_is(key, "TH"))
        s->thickness = fabs(value) >= 1e10 ? HUGE_VAL : value;
    else if (rmap_lens_is(key, "AP") || rmap_lens_is(key, "APN")) {
        const double radius = fabs(rmap_lens_value(word, n, n - 1, 0));
        for (size_t k = 1; k + 1 < n; k++)
            if (!rmap_lens_is(word[k], "CHK") && !rmap_lens_number(word[k], &ignored))
                rmap_lens_lost(o->lens, o->lines.number, s, "AP %.20s is not understood", word[k]);
        s->semi = radius < 1e10 ? radius : 0;
    } else if (rmap_lens_is(key, "AST"))
        s->is_stop = true;
    else if (rmap_lens_is(key, "AIR"))
        s->glass[0] = 0;
    else if (rmap_lens_is(key, "RFL") || rmap_lens_is(key, "RFH"))
        s->is_mirror = true;
    else if (rmap_lens_is(key, "GLA") && n > 1)
        *st = read_glass(o, word, n);
    else if (rmap_lens_is(key, "NOT") || rmap_lens_is(key, "SNO")) {
        if (n > 1)
            rmap_lens_copy(s->comment, sizeof s->comment, word[n - 1]);
    } else
        return read_place(o, key, word, n) || tell_lost(o, key);
    return true;
}

/* Without a meaning for the scene. */
static const char harmless[] =
    " NXT DES DLRS DLNF DLID SDI WAV BEG DRW AMO SDAD SDDC TCE RFS AFO TEL SNO1 SNO2 DLVA DLAS ";

static void tell_unknown(struct oslo *o, const char *key)
{
    char spaced[16];
    (void)snprintf(spaced, sizeof spaced, " %.7s ", key);
    for (size_t i = 0; i < o->n_seen; i++)
        if (strncmp(o->seen[i], key, sizeof o->seen[0] - 1) == 0)
            return;
    if (strstr(harmless, spaced) || o->n_seen >= RMAP_COUNT(o->seen))
        return;
    rmap_lens_copy(o->seen[o->n_seen++], sizeof o->seen[0], key);
    rmap_lens_lost(o->lens, o->lines.number, current(o), "'%.20s' is not understood", key);
}

enum rmap_status rmap_lens_read_oslo(char *text, struct rmap_prescription *lens,
                                     struct rmap_error *err)
{
    struct oslo o = {.lens = lens, .lines = {.at = text}, .err = err};
    char *word[RMAP_LENS_WORDS_MAX];
    lens->format = "OSLO";
    lens->aims_at_stop = true;
    if (!rmap_lens_add(lens, 1, err))
        return err->status;
    while (rmap_lens_next_line(&o.lines)) {
        char *remark = strstr(o.lines.line, "//");
        if (remark)
            *remark = 0;
        const size_t n = rmap_lens_words(o.lines.line, "", word);
        if (n == 0)
            continue;
        if (strncmp(word[0], "END", 3) == 0)
            break;
        enum rmap_status st = RMAP_OK;
        if (rmap_lens_is(word[0], "NXT")) {
            end_surface(&o);
            if (!rmap_lens_add(lens, o.lines.number, err))
                return err->status;
        } else {
            rmap_lens_expect_number(
                lens, o.lines.number, current(&o),
                "RD CV CVX CC TH EBR NAO NA FNO FNB ANG OBH UNI WV:99 WW:99 AP:$ APN:$ "
                "DCX DCY DCZ TLA TLB TLC DT AD AE AF AG",
                word[0], word, n);
            if (!read_of_lens(&o, word[0], word, n) && !read_of_surface(&o, word[0], word, n, &st))
                tell_unknown(&o, word[0]);
        }
        if (st != RMAP_OK)
            return st;
    }
    end_surface(&o);
    set_fields(&o);
    if (lens->n_surface < 2)
        return rmap_error_set(err, RMAP_INPUT, "it has no line 'NXT': is it an OSLO lens file?");
    return RMAP_OK;
}
