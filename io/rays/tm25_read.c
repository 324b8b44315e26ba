/* SPDX-License-Identifier: MIT
 *
 * ANSI/IES TM-25-13 and -20: a head of 256 bytes, 8 flags of what is known, 9 texts of 1000
 * UTF-32 letters, spectra, names of further columns, a text, and rows of float, all little-endian.
 */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/search.h"
#include "io/rays/ray_reader.h"
#include "io/rays/tm25.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are read as they lie");

enum { TABLES_MAX = 4096, KNOTS_MAX = 1 << 20, COLUMNS_MAX = 4096 };

/* A spectrum: powers per nm added up from knot to knot. */
struct spectrum {
    size_t n;
    double *nm, *value, *below;
};

struct tm25 {
    struct rmap_ray_bytes *bytes;
    struct rmap_tm25_head head;
    int32_t known[RMAP_TM25_FLAGS];
    struct spectrum *table; /* [head.n_table] */
    size_t n_table;
    size_t n_column;         /* of a row */
    size_t power, nm, index; /* columns; 0: not there */
};

static enum rmap_status wrong(const struct tm25 *self, const char *what, int32_t is,
                              const char *should)
{
    return rmap_error_set(self->bytes->err, RMAP_INPUT, "%s is %d: %s", what, (int)is, should);
}

static enum rmap_status take_head(struct tm25 *self)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_tm25_head *head = &self->head;
    RMAP_TRY(rmap_ray_take(self->bytes, head, sizeof *head, "its head"));
    RMAP_TRY(rmap_ray_take(self->bytes, self->known, sizeof self->known, "its flags"));
    if (memcmp(head->magic, "TM25", 4) != 0)
        RMAP_TRY(rmap_error_set(self->bytes->err, RMAP_INPUT,
                                "it does not begin with TM25, as a TM-25 file does"));
    if (head->version < 2013 || head->version > 2099)
        RMAP_TRY(wrong(self, "its version", head->version, "2013 and later are known"));
    if (head->spectrum < 0 || head->spectrum > 4)
        RMAP_TRY(wrong(self, "its spectral data identifier", head->spectrum, "0 to 4 are known"));
    if (head->n_table < 0 || head->n_table > TABLES_MAX)
        RMAP_TRY(wrong(self, "its number of spectra", head->n_table, "0 to 4096 can be read"));
    if (head->n_more < 0 || head->n_more > COLUMNS_MAX)
        RMAP_TRY(
            wrong(self, "its number of further columns", head->n_more, "0 to 4096 can be read"));
    if (head->text_nbytes < 0)
        RMAP_TRY(wrong(self, "the size of its text", head->text_nbytes, "it is 0 or more bytes"));
    for (int i = 0; i < RMAP_TM25_FLAGS; i++)
        if (self->known[i] != 0 && self->known[i] != 1)
            RMAP_TRY(wrong(self, "a flag of what is known", self->known[i], "it is 0 or 1"));
    if (!self->known[RMAP_TM25_POSITION] || !self->known[RMAP_TM25_DIRECTION])
        RMAP_TRY(rmap_error_set(self->bytes->err, RMAP_INPUT,
                                "its flags say that positions or directions are not known"));
out:
    return st;
}

static enum rmap_status take_spectrum(struct tm25 *self, struct spectrum *of, uint64_t *nbytes)
{
    enum rmap_status st = RMAP_OK;
    int32_t n = 0;
    float pair[2];
    RMAP_TRY(rmap_ray_take(self->bytes, &n, sizeof n, "a spectrum"));
    if (n < 1 || n > KNOTS_MAX)
        RMAP_TRY(wrong(self, "the number of rows of a spectrum", n, "1 to 1048576 can be read"));
    of->nm = rmap_alloc((size_t)n, sizeof *of->nm);
    of->value = rmap_alloc((size_t)n, sizeof *of->value);
    of->below = rmap_alloc((size_t)n, sizeof *of->below);
    if (!of->nm || !of->value || !of->below)
        RMAP_TRY(rmap_error_set(self->bytes->err, RMAP_SYSTEM, "out of memory for a spectrum"));
    for (; of->n < (size_t)n; of->n++) {
        const size_t k = of->n;
        RMAP_TRY(rmap_ray_take(self->bytes, pair, sizeof pair, "a spectrum"));
        of->nm[k] = (double)pair[0];
        of->value[k] = (double)pair[1];
        if (!(pair[0] > 0.0F && pair[0] < 1e9F && (k == 0 || of->nm[k] > of->nm[k - 1])) ||
            !(pair[1] >= 0.0F && pair[1] < 1e30F))
            RMAP_TRY(rmap_error_set(self->bytes->err, RMAP_INPUT,
                                    "a spectrum has %g at %g nm: wavelengths ascend, powers are 0 "
                                    "or more",
                                    (double)pair[1], (double)pair[0]));
        of->below[k] = k == 0 ? 0.0
                              : of->below[k - 1] + 0.5 * (of->value[k - 1] + of->value[k]) *
                                                       (of->nm[k] - of->nm[k - 1]);
    }
    if (n > 1 && !(of->below[n - 1] > 0.0))
        RMAP_TRY(rmap_error_set(self->bytes->err, RMAP_INPUT, "a spectrum has no light"));
    *nbytes += 4 + 8 * (uint64_t)n;
out:
    return st;
}

static enum rmap_status take_texts(struct tm25 *self, char title[RMAP_FILE_RAYS_TITLE])
{
    enum rmap_status st = RMAP_OK;
    uint32_t letter[RMAP_TM25_LETTERS];
    uint64_t nbytes = 0;
    for (int i = 0; i < RMAP_TM25_TEXTS; i++) {
        RMAP_TRY(rmap_ray_take(self->bytes, letter, sizeof letter, "its texts"));
        for (size_t k = 0; i == 0 && k + 1 < RMAP_FILE_RAYS_TITLE && letter[k]; k++)
            title[k] = letter[k] >= ' ' && letter[k] < 127 ? (char)letter[k] : '?';
    }
    self->table = rmap_alloc((size_t)self->head.n_table + 1, sizeof *self->table);
    if (!self->table)
        RMAP_TRY(rmap_error_set(self->bytes->err, RMAP_SYSTEM, "out of memory for spectra"));
    self->n_table = (size_t)self->head.n_table;
    for (size_t i = 0; i < self->n_table; i++)
        RMAP_TRY(take_spectrum(self, &self->table[i], &nbytes));
    RMAP_TRY(rmap_ray_skip(self->bytes, (32 - nbytes % 32) % 32, "its spectra"));
    RMAP_TRY(rmap_ray_skip(self->bytes,
                           (uint64_t)self->head.n_more * RMAP_TM25_NAME_NBYTES +
                               (uint64_t)self->head.text_nbytes,
                           "the names of its columns"));
out:
    return st;
}

static void find_columns(struct tm25 *self)
{
    const int32_t *known = self->known;
    size_t n = 6, luminous = 0;
    if (known[RMAP_TM25_RADIANT])
        self->power = n++;
    if (known[RMAP_TM25_WAVELENGTH])
        self->nm = n++;
    if (known[RMAP_TM25_LUMINOUS])
        luminous = n++;
    n += known[RMAP_TM25_STOKES] ? 6 : 0;
    n += known[RMAP_TM25_TRISTIMULUS] ? 2 : 0;
    if (known[RMAP_TM25_INDEX])
        self->index = n++;
    self->power = self->power ? self->power : luminous;
    self->n_column = n + (size_t)self->head.n_more;
}

/* The wavelength below which the share u of the light lies. */
static double draw_nm(const struct spectrum *of, double u)
{
    if (of->n == 1)
        return of->nm[0];
    const double level = u * of->below[of->n - 1];
    const size_t k = rmap_first_above(of->below, of->n, level);
    const double width = of->nm[k] - of->nm[k - 1], from = of->value[k - 1],
                 slope = (of->value[k] - from) / width, rest = level - of->below[k - 1],
                 square = from * from + 2.0 * slope * rest,
                 divisor = from + sqrt(square > 0.0 ? square : 0.0);
    return of->nm[k - 1] + (divisor > 0.0 ? rmap_min(2.0 * rest / divisor, width) : 0.0);
}

/* Rays that share a spectrum have its wavelengths in turn, evenly in power (Weyl's sequence of the
 * golden ratio). */
static double shared_nm(const struct tm25 *self, const float *row, size_t i)
{
    const float which = self->index ? row[self->index] : 1.0F;
    const double u = fmod(((double)i + 0.5) * 0.61803398874989484820, 1.0);
    return which >= 1.0F && (double)which < (double)self->n_table + 1.0
               ? draw_nm(&self->table[(size_t)which - 1], u)
               : (double)NAN;
}

static enum rmap_status put_row(struct tm25 *self, const float *row, size_t i,
                                struct rmap_file_rays *set)
{
    memcpy(set->narrow[i], row, sizeof *set->narrow);
    if (set->below)
        set->below[i] = (double)row[self->power];
    if (!set->wavelength_nm)
        return RMAP_OK;
    const double nm = self->nm ? (double)row[self->nm] : shared_nm(self, row, i);
    if (self->index && isnan(nm))
        return rmap_error_set(self->bytes->err, RMAP_INPUT,
                              "ray %zu: it is of spectrum %g, and there are %zu", i + 1,
                              (double)row[self->index], self->n_table);
    set->wavelength_nm[i] = (float)nm;
    return RMAP_OK;
}

static enum rmap_status take_rows(struct tm25 *self, struct rmap_file_rays *set)
{
    enum { BLOCK = 65536 };
    enum rmap_status st = RMAP_OK;
    const size_t width = self->n_column, most = BLOCK / width > 0 ? BLOCK / width : 1;
    float *block = rmap_alloc_unset(most * width, sizeof *block);
    if (!block)
        return rmap_error_set(self->bytes->err, RMAP_SYSTEM, "out of memory for rays");
    for (size_t i = 0; i < set->n;) {
        const size_t n = set->n - i < most ? set->n - i : most;
        RMAP_TRY(rmap_ray_take(self->bytes, block, n * width * sizeof *block, "its rays"));
        for (size_t k = 0; k < n; k++, i++)
            RMAP_TRY(put_row(self, block + k * width, i, set));
    }
out:
    rmap_free(block);
    return st;
}

/* All powers not a number: not known, and so alike. */
static void forget_unknown(struct rmap_file_rays *set)
{
    for (size_t i = 0; i < set->n; i++)
        if (!isnan(set->below[i]))
            return;
    rmap_free(set->below);
    set->below = NULL;
}

static enum rmap_status take_rays(struct tm25 *self, struct rmap_file_rays **set_ret)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_tm25_head *head = &self->head;
    const uint64_t left = self->bytes->nbytes - self->bytes->at;
    bool has[RMAP_RAY_COLUMNS] = {false};
    find_columns(self);
    has[RMAP_RAY_POWER] = self->power > 0;
    has[RMAP_RAY_NM] = self->nm || self->index || (head->spectrum == 3 && self->n_table > 0);
    if (head->n_ray > left / (self->n_column * sizeof(float)))
        RMAP_TRY(rmap_error_set(self->bytes->err, RMAP_INPUT,
                                "it says that it has %llu rays of %zu numbers, and ends after "
                                "%llu",
                                (unsigned long long)head->n_ray, self->n_column,
                                (unsigned long long)(left / (self->n_column * sizeof(float)))));
    RMAP_TRY(rmap_file_rays_create((size_t)head->n_ray, false, set_ret, self->bytes->err));
    RMAP_TRY(rmap_file_rays_columns(*set_ret, has, self->bytes->err));
    RMAP_TRY(take_rows(self, *set_ret));
    struct rmap_file_rays *set = *set_ret;
    set->unit_m = 1e-3;
    set->loose = RMAP_FILE_RAYS_LOOSE;
    const bool lumens = !self->known[RMAP_TM25_RADIANT] && self->known[RMAP_TM25_LUMINOUS];
    set->flux_unit = lumens ? RMAP_FLUX_LM : RMAP_FLUX_W;
    const float flux = lumens ? head->lumens : head->watts;
    if (head->spectrum == 1 && !set->wavelength_nm && head->nm > 0.0F)
        set->all_nm = (double)head->nm;
    if (set->below)
        forget_unknown(set);
    if (set->below)
        RMAP_TRY(rmap_file_rays_weigh(set, self->bytes->err));
    if (flux > 0.0F && flux < 1e30F)
        set->flux = (double)flux;
out:
    return st;
}

enum rmap_status rmap_tm25_read(struct rmap_ray_bytes *bytes, struct rmap_file_rays **set_ret,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct tm25 self = {.bytes = bytes};
    struct rmap_file_rays *set = NULL;
    char title[RMAP_FILE_RAYS_TITLE] = "";
    bytes->err = err;
    RMAP_TRY(take_head(&self));
    RMAP_TRY(take_texts(&self, title));
    RMAP_TRY(take_rays(&self, &set));
    memcpy(set->title, title, sizeof title);
    *set_ret = set;
    set = NULL;
out:
    for (size_t i = 0; i < self.n_table; i++) {
        rmap_free(self.table[i].nm);
        rmap_free(self.table[i].value);
        rmap_free(self.table[i].below);
    }
    rmap_free(self.table);
    rmap_file_rays_drop(set);
    return st;
}
