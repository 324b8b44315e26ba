/* SPDX-License-Identifier: MIT
 *
 * MCPL, versions 2 and 3 (Kittelmann et al. 2017, doi:10.1016/j.cpc.2017.04.012): its photons. Read
 * here and not by the library of that name, which ends the program where a file is damaged.
 */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/rays/mcpl.h"
#include "io/rays/ray_reader.h"

struct mcpl {
    struct rmap_ray_bytes *bytes;
    struct rmap_mcpl_head head;
    double weight;   /* of all */
    size_t width;    /* of a number */
    bool octahedral; /* version 2 */
};

static enum rmap_status skip_text(struct mcpl *self)
{
    uint32_t n = 0;
    enum rmap_status st = rmap_ray_take(self->bytes, &n, sizeof n, "a text of its head");
    return st == RMAP_OK ? rmap_ray_skip(self->bytes, n, "a text of its head") : st;
}

static enum rmap_status take_head(struct mcpl *self)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_mcpl_head *head = &self->head;
    struct rmap_error *err = self->bytes->err;
    RMAP_TRY(rmap_ray_take(self->bytes, head, sizeof *head, "its head"));
    if (memcmp(head->magic, "MCPL", 4) != 0)
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "it does not begin with MCPL"));
    self->octahedral = memcmp(head->magic, "MCPL002L", 8) == 0;
    if (!self->octahedral && memcmp(head->magic, "MCPL003L", 8) != 0)
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT,
                                "it is of version %.4s: versions 2 and 3, little-endian, are read "
                                "(mcpltool --extract writes such files)",
                                head->magic + 4));
    self->width = head->single ? 4 : 8;
    const size_t n_number = 7U + (head->polarised ? 3U : 0U) + (head->one_weight ? 0U : 1U),
                 nbytes =
                     self->width * n_number + (head->one_code ? 0U : 4U) + (head->flags ? 4U : 0U);
    if (head->particle_nbytes != nbytes)
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT,
                                "its head says that a particle has %u bytes, and what it has takes "
                                "%zu",
                                (unsigned)head->particle_nbytes, nbytes));
    self->weight = 1.0;
    if (head->one_weight)
        RMAP_TRY(rmap_ray_take(self->bytes, &self->weight, sizeof self->weight, "its head"));
    /* The program, remarks, names of data and data. */
    for (uint64_t i = 0; i < 1 + (uint64_t)head->n_remark + 2 * (uint64_t)head->n_data; i++)
        RMAP_TRY(skip_text(self));
out:
    return st;
}

static double number(const struct mcpl *self, const uint8_t **at)
{
    float narrow;
    double wide;
    if (self->width == 4) {
        memcpy(&narrow, *at, sizeof narrow);
        wide = (double)narrow;
    } else {
        memcpy(&wide, *at, sizeof wide);
    }
    *at += self->width;
    return wide;
}

/* Two of the direction's parts, 1/z in the place of one where z is not the greatest, and the sign
 * of that which is left out. */
static void unpack(const double packed[2], bool minus, double d[3])
{
    const bool first = fabs(packed[0]) > 1.0, second = !first && fabs(packed[1]) > 1.0;
    const int left_out = first ? 0 : second ? 1 : 2;
    d[0] = packed[0];
    d[1] = packed[1];
    if (first || second)
        d[2] = 1.0 / packed[left_out];
    const double a = d[(left_out + 1) % 3], b = d[(left_out + 2) % 3], rest = 1.0 - a * a - b * b;
    d[left_out] = copysign(sqrt(rest > 0.0 ? rest : 0.0), minus ? -1.0 : 1.0);
}

/* Version 2: a place on the octahedron |x| + |y| + |z| = 1, its lower half folded out (Engelhardt &
 * Dachsbacher 2008); minus: z is 0. */
static void unpack_octahedral(const double packed[2], bool minus, double d[3])
{
    const double z = 1.0 - fabs(packed[0]) - fabs(packed[1]);
    for (int k = 0; k < 2; k++)
        d[k] = z < 0.0 ? copysign(1.0 - fabs(packed[1 - k]), packed[k]) : packed[k];
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + z * z);
    for (int k = 0; k < 2; k++)
        d[k] /= length;
    d[2] = minus ? 0.0 : z / length;
}

/* Of the Particle Data Group's number of a particle, in elementary charges; 0 of others than the
 * long-lived ones. */
static double charge_of(int32_t code)
{
    static const int32_t positive[] = {-11, -13, -15, 211, 321, 2212};
    if (code >= 1000000000)
        return (double)(code / 10000 % 1000);
    for (size_t i = 0; i < sizeof positive / sizeof *positive; i++)
        if (code == positive[i] || code == -positive[i])
            return code == positive[i] ? 1.0 : -1.0;
    return 0.0;
}

static int32_t take_particle(const struct mcpl *self, const uint8_t *at,
                             double value[RMAP_RAY_COLUMNS])
{
    double packed[2], polarisation[3] = {0};
    int32_t code = self->head.one_code;
    for (int k = 0; self->head.polarised && k < 3; k++)
        polarisation[k] = number(self, &at);
    /* Of a step: cm, and the speed, which may be left out. */
    value[RMAP_RAY_LENGTH] = polarisation[0];
    value[RMAP_RAY_BETA] = polarisation[1] != 0.0 ? polarisation[1] : 1.0;
    for (int k = 0; k < 3; k++)
        value[k] = number(self, &at);
    for (int k = 0; k < 2; k++)
        packed[k] = number(self, &at);
    const double energy = number(self, &at);
    (self->octahedral ? unpack_octahedral : unpack)(packed, signbit(energy), value + RMAP_RAY_DX);
    value[RMAP_RAY_NM] = 1e-6 * RMAP_EV_NM / fabs(energy);
    value[RMAP_RAY_DEPOSIT] = fabs(energy);
    value[RMAP_RAY_TIME] = 1e6 * number(self, &at);
    value[RMAP_RAY_POWER] = self->head.one_weight ? self->weight : number(self, &at);
    if (!code)
        memcpy(&code, at, sizeof code);
    if (!self->head.one_code)
        at += sizeof code;
    uint32_t flags = 0;
    if (self->head.flags)
        memcpy(&flags, at, sizeof flags);
    value[RMAP_RAY_EVENT] = (double)flags;
    value[RMAP_RAY_CHARGE] = charge_of(code);
    return code;
}

static enum rmap_status take_particles(struct mcpl *self, struct rmap_ray_wanted *wanted,
                                       struct rmap_ray_rows *rows)
{
    enum { BLOCK = 1 << 18, PHOTON = 22 };
    enum rmap_status st = RMAP_OK;
    const size_t width = self->head.particle_nbytes, most = BLOCK / width;
    const uint64_t left = self->bytes->nbytes - self->bytes->at;
    uint8_t *block = rmap_alloc_unset(most * width, 1);
    if (!block)
        return rmap_error_set(self->bytes->err, RMAP_SYSTEM, "out of memory for particles");
    if (self->head.n > left / width)
        RMAP_TRY(rmap_error_set(
            self->bytes->err, RMAP_INPUT, "it says that it has %llu particles, and ends after %llu",
            (unsigned long long)self->head.n, (unsigned long long)(left / width)));
    for (uint64_t i = 0; i < self->head.n;) {
        const uint64_t due = self->head.n - i;
        const size_t n = due < most ? (size_t)due : most;
        RMAP_TRY(rmap_ray_take(self->bytes, block, n * width, "its particles"));
        for (size_t k = 0; k < n; k++, i++) {
            double value[RMAP_RAY_COLUMNS];
            const bool photon = take_particle(self, block + k * width, value) == PHOTON;
            if (!photon && !wanted->steps)
                wanted->n_passed_over++;
            else
                RMAP_TRY(rmap_ray_rows_add(rows, value, self->bytes->err));
        }
    }
out:
    rmap_free(block);
    return st;
}

enum rmap_status rmap_mcpl_read(struct rmap_ray_bytes *bytes, struct rmap_ray_wanted *wanted,
                                struct rmap_file_rays **set_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct mcpl self = {.bytes = bytes};
    struct rmap_ray_rows rows = {.set = NULL};
    bytes->err = err;
    RMAP_TRY(take_head(&self));
    if (wanted->steps && !self.head.polarised)
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT,
                                "it has no polarisation, where steps have their length (cm) and "
                                "beta"));
    rows.has[RMAP_RAY_TIME] = true;
    rows.has[RMAP_RAY_LENGTH] = wanted->steps;
    rows.has[RMAP_RAY_NM] = !wanted->steps;
    rows.has[RMAP_RAY_POWER] = !self.head.one_weight && !wanted->steps;
    rows.has[RMAP_RAY_EVENT] = self.head.flags != 0;
    RMAP_TRY(take_particles(&self, wanted, &rows));
    RMAP_TRY(rmap_ray_rows_finish(&rows, set_ret, err));
    (*set_ret)->unit_m = 1e-2;
    (*set_ret)->flux = (double)NAN; /* weights have no unit */
    (*set_ret)->loose = self.head.single ? RMAP_FILE_RAYS_LOOSE : 0.0;
out:
    rmap_file_rays_drop(rows.set);
    return st;
}
