/* SPDX-License-Identifier: MIT
 *
 * Rays to a TM-25 or an MCPL file.
 */
#include "io/rays/ray_write.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <time.h>

#include "base/alloc.h"
#include "io/rays/mcpl.h"
#include "io/rays/ray_reader.h"
#include "io/rays/tm25.h"
#include "version.h"

#define PROGRAM "Raymap " RMAP_VERSION

enum { BLOCK = 1 << 18, LONGEST = 64 };

struct rmap_ray_writer {
    FILE *out;
    bool tm25;
    size_t used;
    uint8_t *block; /* [BLOCK] of rays that are not written yet */
    uint64_t n;
    double sum, least_nm, greatest_nm;
    bool lumens, coloured;
    struct rmap_tm25_head tm25_head;
    struct rmap_mcpl_head mcpl_head;
};

/* ---- heads ---- */

static void put_letters(FILE *out, const char *text, size_t nbytes)
{
    for (size_t i = 0; i < nbytes / 4; i++) {
        const uint32_t letter = *text ? (uint32_t)(unsigned char)*text++ : 0;
        (void)fwrite(&letter, sizeof letter, 1, out);
    }
}

static void begin_tm25(struct rmap_ray_writer *self, const char *title)
{
    const int32_t known[RMAP_TM25_FLAGS] = {1, 1, !self->lumens, self->coloured, self->lumens, 0,
                                            0, 0};
    static const char *const more[] = {"portion", "number"};
    char date[sizeof self->tm25_head.date + 1] = "";
    const time_t now = time(NULL);
    struct tm at;
    if (gmtime_r(&now, &at))
        (void)strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%S+00:00", &at);
    self->tm25_head = (struct rmap_tm25_head){.magic = {'T', 'M', '2', '5'},
                                              .version = 2013,
                                              .spectrum = self->coloured && !self->lumens ? 2 : 0,
                                              .nm = (float)NAN,
                                              .n_more = 2};
    memcpy(self->tm25_head.date, date, sizeof self->tm25_head.date);
    (void)fwrite(&self->tm25_head, sizeof self->tm25_head, 1, self->out);
    (void)fwrite(known, sizeof known, 1, self->out);
    const char *const text[RMAP_TM25_TEXTS] = {title, "", "", PROGRAM, PROGRAM};
    for (int i = 0; i < RMAP_TM25_TEXTS; i++)
        put_letters(self->out, text[i] ? text[i] : "", (size_t)4 * RMAP_TM25_LETTERS);
    for (int i = 0; i < 2; i++)
        put_letters(self->out, more[i], RMAP_TM25_NAME_NBYTES);
}

static void begin_mcpl(struct rmap_ray_writer *self, const char *title)
{
    const char *const text[] = {PROGRAM, title};
    self->mcpl_head = (struct rmap_mcpl_head){.magic = {'M', 'C', 'P', 'L', '0', '0', '3', 'L'},
                                              .n_remark = 1,
                                              .flags = 1,
                                              .one_code = 22,
                                              .particle_nbytes = 8 * 8 + 4};
    (void)fwrite(&self->mcpl_head, sizeof self->mcpl_head, 1, self->out);
    for (int i = 0; i < 2; i++) {
        const uint32_t n = (uint32_t)strlen(text[i]);
        (void)fwrite(&n, sizeof n, 1, self->out);
        (void)fwrite(text[i], 1, n, self->out);
    }
}

enum rmap_status rmap_ray_writer_begin(FILE *out, enum rmap_ray_format format, bool lumens,
                                       bool coloured, const char *title,
                                       struct rmap_ray_writer **writer_ret, struct rmap_error *err)
{
    struct rmap_ray_writer *self = rmap_alloc(1, sizeof *self);
    uint8_t *block = rmap_alloc_unset(BLOCK, 1);
    if (!self || !block) {
        rmap_free(self);
        rmap_free(block);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a file of rays");
    }
    *self = (struct rmap_ray_writer){.out = out,
                                     .tm25 = format == RMAP_RAYS_TM25,
                                     .block = block,
                                     .least_nm = HUGE_VAL,
                                     .lumens = lumens,
                                     .coloured = coloured};
    if (self->tm25)
        begin_tm25(self, title);
    else
        begin_mcpl(self, title);
    *writer_ret = self;
    return RMAP_OK;
}

/* ---- rays ---- */

static size_t tm25_row(const struct rmap_ray_writer *self, const struct rmap_ray_written *ray,
                       float *row)
{
    const double mm = 1e3;
    size_t n = 0;
    row[n++] = (float)(mm * ray->position.x);
    row[n++] = (float)(mm * ray->position.y);
    row[n++] = (float)(mm * ray->position.z);
    row[n++] = (float)ray->direction.x;
    row[n++] = (float)ray->direction.y;
    row[n++] = (float)ray->direction.z;
    if (!self->lumens)
        row[n++] = (float)ray->flux;
    if (self->coloured)
        row[n++] = (float)ray->nm;
    if (self->lumens)
        row[n++] = (float)ray->flux;
    row[n++] = (float)(ray->id / 4096);
    row[n++] = (float)(ray->id % 4096);
    return n * sizeof *row;
}

/* Adaptive projection: the greatest part of the direction is left out but for its sign; where that
 * is not z, 1/z stands in its place. */
static size_t mcpl_particle(const struct rmap_ray_written *ray, uint8_t *to)
{
    const double cm = 1e2, d[3] = {ray->direction.x, ray->direction.y, ray->direction.z},
                 x = fabs(d[0]), y = fabs(d[1]), z = fabs(d[2]);
    const int greatest = x > z && x >= y ? 0 : y > z ? 1 : 2;
    double value[8] = {cm * ray->position.x,
                       cm * ray->position.y,
                       cm * ray->position.z,
                       d[0],
                       d[1],
                       copysign(1e-6 * RMAP_EV_NM / ray->nm, d[greatest]),
                       1e-6 * ray->time_ns,
                       ray->flux};
    if (greatest < 2)
        value[3 + greatest] = 1.0 / d[2];
    const uint32_t flags = (uint32_t)ray->id;
    memcpy(to, value, sizeof value);
    memcpy(to + sizeof value, &flags, sizeof flags);
    return sizeof value + sizeof flags;
}

void rmap_ray_writer_add(struct rmap_ray_writer *self, const struct rmap_ray_written *ray)
{
    float row[LONGEST / sizeof(float)];
    if (self->used + 2 * LONGEST > BLOCK) {
        (void)fwrite(self->block, 1, self->used, self->out);
        self->used = 0;
    }
    uint8_t *to = self->block + self->used;
    if (self->tm25) {
        const size_t nbytes = tm25_row(self, ray, row);
        memcpy(to, row, nbytes);
        self->used += nbytes;
    } else {
        self->used += mcpl_particle(ray, to);
    }
    self->n++;
    self->sum += ray->flux;
    self->least_nm = fmin(self->least_nm, ray->nm);
    self->greatest_nm = fmax(self->greatest_nm, ray->nm);
}

enum rmap_status rmap_ray_writer_finish(struct rmap_ray_writer *self, struct rmap_error *err)
{
    const float none = (float)NAN, flux = (float)self->sum;
    (void)fwrite(self->block, 1, self->used, self->out);
    self->tm25_head.n_ray = self->mcpl_head.n = self->n;
    self->tm25_head.lumens = self->lumens ? flux : none;
    self->tm25_head.watts = self->lumens ? none : flux;
    self->tm25_head.least_nm = self->coloured && self->n ? (float)self->least_nm : none;
    self->tm25_head.greatest_nm = self->coloured && self->n ? (float)self->greatest_nm : none;
    const bool good =
        fflush(self->out) == 0 && fseeko(self->out, 0, SEEK_SET) == 0 &&
        (self->tm25 ? fwrite(&self->tm25_head, sizeof self->tm25_head, 1, self->out)
                    : fwrite(&self->mcpl_head, sizeof self->mcpl_head, 1, self->out)) == 1;
    const int why = errno;
    rmap_ray_writer_destroy(self);
    return good ? RMAP_OK
                : rmap_error_set(err, RMAP_SYSTEM, "cannot write rays: %s", strerror(why));
}

void rmap_ray_writer_destroy(struct rmap_ray_writer *self)
{
    if (!self)
        return;
    rmap_free(self->block);
    rmap_free(self);
}
