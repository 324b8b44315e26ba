/* SPDX-License-Identifier: MIT
 *
 * OSLO's lens files (.len): a surface's commands up to NXT, the next one's then; the first is the
 * object, the last the image.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/count.h"
#include "io/lensfile/lens_text.h"

struct oslo {
    struct rmap_prescription *lens;
    struct rmap_lens_lines lines;
    struct rmap_error *err;
    double angle, height; /* ANG, OBH; 0: not said */
    char seen[32][8];
    size_t n_seen;
};

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
                                                : RMAP_PUPIL_F_NUMBER;
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
                lens->wavelength_nm[i - 1] = 1e3 * number;
                lens->wavelength_weight[i - 1] = 1;
                lens->n_wavelength = i;
            }
        }
    } else {
        return false;
    }
    return true;
}

static bool read_of_surface(struct oslo *o, const char *key, char **word, size_t n)
{
    struct rmap_lens_surface *s = &o->lens->surface[o->lens->n_surface - 1];
    const double value = rmap_lens_value(word, n, 1, 0);
    if (rmap_lens_is(key, "RD"))
        s->curvature = value == 0 ? 0 : 1 / value;
    else if (rmap_lens_is(key, "CV"))
        s->curvature = value;
    else if (rmap_lens_is(key, "CC"))
        s->conic = value;
    else if (rmap_lens_is(key, "TH"))
        s->thickness = fabs(value) >= 1e10 ? HUGE_VAL : value;
    else if (rmap_lens_is(key, "AP") || rmap_lens_is(key, "APN")) {
        const double radius = fabs(rmap_lens_value(word, n, n - 1, 0));
        s->semi = radius < 1e10 ? radius : 0;
    } else if (rmap_lens_is(key, "AST"))
        s->is_stop = true;
    else if (rmap_lens_is(key, "AIR"))
        s->glass[0] = 0;
    else if (rmap_lens_is(key, "RFL") || rmap_lens_is(key, "RFH"))
        s->is_mirror = true;
    else if (rmap_lens_is(key, "GLA") && n > 1) {
        rmap_lens_copy(s->glass, sizeof s->glass, word[1]);
        if (rmap_lens_is(word[1], "REFLECT"))
            s->is_mirror = true;
    } else if (rmap_lens_is(key, "AD") || rmap_lens_is(key, "AE") || rmap_lens_is(key, "AF") ||
               rmap_lens_is(key, "AG"))
        (void)rmap_lens_set_asphere(s, 4 + 2 * ((key[1] | 0x20) - 'd'), value);
    else if (rmap_lens_is(key, "NOT") || rmap_lens_is(key, "SNO")) {
        if (n > 1)
            rmap_lens_copy(s->comment, sizeof s->comment, word[n - 1]);
    } else if (rmap_lens_is(key, "TLA") || rmap_lens_is(key, "TLB") || rmap_lens_is(key, "TLC") ||
               rmap_lens_is(key, "DCX") || rmap_lens_is(key, "DCY") || rmap_lens_is(key, "DCZ")) {
        if (value != 0)
            rmap_lens_lost(o->lens, o->lines.number, s, "%s: tilts and shifts are not understood",
                           key);
    } else
        return false;
    return true;
}

/* Without a meaning for the scene. */
static const char harmless[] = " NXT DES DLRS DLNF DLID SDI WAV BEG DT DRW AMO SDAD SDDC ";

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
    rmap_lens_lost(o->lens, o->lines.number, &o->lens->surface[o->lens->n_surface - 1],
                   "'%.20s' is not understood", key);
}

enum rmap_status rmap_lens_read_oslo(char *text, struct rmap_prescription *lens,
                                     struct rmap_error *err)
{
    struct oslo o = {.lens = lens, .lines = {.at = text}, .err = err};
    char *word[RMAP_LENS_WORDS_MAX];
    lens->format = "OSLO";
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
        if (rmap_lens_is(word[0], "NXT")) {
            if (!rmap_lens_add(lens, o.lines.number, err))
                return err->status;
        } else if (!read_of_lens(&o, word[0], word, n) && !read_of_surface(&o, word[0], word, n)) {
            tell_unknown(&o, word[0]);
        }
    }
    set_fields(&o);
    if (lens->n_surface < 2)
        return rmap_error_set(err, RMAP_INPUT, "it has no line 'NXT': is it an OSLO lens file?");
    return RMAP_OK;
}
