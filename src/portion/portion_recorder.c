/* SPDX-License-Identifier: MIT
 *
 * Records rays into a portion: float positions, int16 normals, 16-bit colours.
 */
#include "portion/portion_recorder.h"

#include <math.h>
#include <string.h>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

#if defined(__GNUC__)
#define RMAP_SELDOM __attribute__((noinline))
#else
#define RMAP_SELDOM
#endif

/* One NaN and no -0, so that equal rays have equal bytes. */
static double plain(double x)
{
    return isnan(x) ? (double)NAN : x + 0.0;
}

static RMAP_SELDOM void store_nan(float *out)
{
    for (int i = 0; i < 3; i++)
        out[i] = isnan(out[i]) ? NAN : out[i];
}

static inline void store_float3(float *out, const struct rmap_vec3 *v)
{
    float x = (float)v->x + 0.0f, y = (float)v->y + 0.0f, z = (float)v->z + 0.0f;
    out[0] = x;
    out[1] = y;
    out[2] = z;
    if (isnan(x + y + z)) /* rarely; infinities may do that too */
        store_nan(out);
}

/* As fmax(low, fmin(high, x)), NaN included, which are calls. */
static double clamp(double x, double low, double high)
{
    double lesser = x < high ? x : high;
    return lesser > low ? lesser : low;
}

/* Components in [-1, 1] times 32767, rounded half away from zero; clamped as above. Written out, as
 * compilers make branches of it, and whether a wall's normal is 1 or a hair less is anybody's
 * guess. */
#ifdef __SSE2__
/* In memory as they are used: compilers put together what is written as one number. */
static const _Alignas(16) double one[2] = {1.0, 1.0}, half[2] = {0.5, 0.5};
static const _Alignas(16) double top[2] = {32767.0, 32767.0}, minus[2] = {-0.0, -0.0};
static const _Alignas(16) int16_t bottom[8] = {-32767, -32767, -32767, -32767,
                                               -32767, -32767, -32767, -32767};

/* Two at a time; those below -1 come out below -32767. */
static inline __m128i quantise_cosines(__m128d x)
{
    __m128d scaled = _mm_mul_pd(_mm_min_pd(x, _mm_load_pd(one)), _mm_load_pd(top)); /* NaN: 1 */
    __m128d sign = _mm_and_pd(scaled, _mm_load_pd(minus));
    return _mm_cvttpd_epi32(_mm_add_pd(scaled, _mm_or_pd(sign, _mm_load_pd(half))));
}

static inline void store_normal(int16_t *out, const struct rmap_vec3 *n)
{
    __m128i xy = quantise_cosines(_mm_loadu_pd(&n->x)), z = quantise_cosines(_mm_load_sd(&n->z));
    __m128i xyz = _mm_packs_epi32(_mm_unpacklo_epi64(xy, z), z);
    xyz = _mm_max_epi16(xyz, _mm_load_si128((const __m128i *)(const void *)bottom));
    int32_t first = _mm_cvtsi128_si32(xyz);
    memcpy(out, &first, sizeof first);
    out[2] = (int16_t)_mm_extract_epi16(xyz, 2);
}
#else
static int16_t quantise_cosine(double x)
{
    double scaled = 32767.0 * clamp(x, -1.0, 1.0);
    return (int16_t)(scaled + copysign(0.5, scaled));
}

static inline void store_normal(int16_t *out, const struct rmap_vec3 *n)
{
    out[0] = quantise_cosine(n->x);
    out[1] = quantise_cosine(n->y);
    out[2] = quantise_cosine(n->z);
}
#endif

static uint16_t quantise_relative(double x)
{
    return (uint16_t)(65535.0 * clamp(x, 0.0, 1.0) + 0.5);
}

/* Gives the units that rounding down left over to the largest remainders. Rounding may also have
 * made the floors one too many: then the smallest remainder gives one back. */
static void settle(double *remainder, int n, int missing, uint16_t *quantised)
{
    for (; missing > 0; missing--) {
        int best = 0;
        for (int i = 1; i < n; i++)
            if (remainder[i] > remainder[best])
                best = i;
        quantised[best]++;
        remainder[best] -= 1.0;
    }
    for (; missing < 0; missing++) {
        int best = -1;
        for (int i = 0; i < n; i++)
            if (quantised[i] > 0 && (best < 0 || remainder[i] < remainder[best]))
                best = i;
        quantised[best]--;
        remainder[best] += 1.0;
    }
}

/* The only channel that is not 0, or -1. */
static int only_channel(const double *colour, int n_channel)
{
    int first = 0, last = n_channel - 1;
    while (first < n_channel && colour[first] == 0.0)
        first++;
    while (last > first && colour[last] == 0.0)
        last--;
    return first == last ? first : -1;
}

void rmap_colour_quantise(const double *colour, int n_channel, uint16_t *quantised)
{
    double remainder[RMAP_CHANNEL_MAX];
    double sum = 0.0;
    int missing = 65535, only = only_channel(colour, n_channel);
    if (only >= 0) {
        memset(quantised, 0, (size_t)n_channel * sizeof *quantised);
        quantised[only] = 65535;
        return;
    }
    for (int i = 0; i < n_channel; i++)
        sum += colour[i];
    for (int i = 0; i < n_channel; i++) {
        double share = 65535.0 * clamp(colour[i] / sum, 0.0, 1.0);
        quantised[i] = (uint16_t)share;
        remainder[i] = share - quantised[i];
        missing -= quantised[i];
    }
    settle(remainder, n_channel, missing, quantised);
}

static inline uint64_t bits_of(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* Bit by bit. Of three channels mostly: without a branch for each. */
static inline bool same_colour(const struct rmap_known_colour *known, const double *colour, int n)
{
    const double *share = known->share;
    if (n == 3)
        return ((bits_of(share[0]) ^ bits_of(colour[0])) |
                (bits_of(share[1]) ^ bits_of(colour[1])) |
                (bits_of(share[2]) ^ bits_of(colour[2]))) == 0;
    int i = 0;
    while (i < n && bits_of(share[i]) == bits_of(colour[i]))
        i++;
    return i == n;
}

/* Another colour than that of the segment before: the other one that is known, or a new one in its
 * place. */
static void change_colour(struct rmap_portion_recorder *self, const double *colour)
{
    int n = self->portion->n_channel;
    struct rmap_known_colour *known =
        self->last == &self->colour[0] ? &self->colour[1] : &self->colour[0];
    self->last = known;
    if (same_colour(known, colour, n))
        return;
    rmap_colour_quantise(colour, n, known->quantised);
    memcpy(known->share, colour, (size_t)n * sizeof *colour);
}

static RMAP_SELDOM void store_any_colour(struct rmap_portion_recorder *self, const double *colour,
                                         uint16_t *out)
{
    int n = self->portion->n_channel;
    if (!same_colour(self->last, colour, n))
        change_colour(self, colour);
    memcpy(out, self->last->quantised, (size_t)n * sizeof *out);
}

/* Three channels, of the colour that was last, on the shortest way. */
static inline void store_colour(struct rmap_portion_recorder *self, int n, const double *colour,
                                uint16_t *out)
{
    if (n == 3 && same_colour(self->last, colour, 3))
        memcpy(out, self->last->quantised, 3 * sizeof *out);
    else
        store_any_colour(self, colour, out);
}

/* Room for a row more, or false once memory ran short. */
static RMAP_SELDOM bool make_room(struct rmap_portion_recorder *self, enum rmap_table table)
{
    struct rmap_portion *portion = self->portion;
    if (self->status == RMAP_OK && portion->n_row[table] == portion->cap[table])
        self->status = rmap_portion_reserve(portion, table, 1, RMAP_COLUMNS_ALL, NULL);
    return self->status == RMAP_OK;
}

static inline bool is_full(const struct rmap_portion_recorder *self, enum rmap_table table)
{
    return self->status != RMAP_OK || self->portion->n_row[table] == self->portion->cap[table];
}

/* A new row of the table, or false once memory ran short. */
static inline bool next_row(struct rmap_portion_recorder *self, enum rmap_table table,
                            size_t *row_ret)
{
    struct rmap_portion *portion = self->portion;
    if (is_full(self, table) && !make_room(self, table))
        return false;
    *row_ret = portion->n_row[table]++;
    return true;
}

static void emit(struct rmap_recorder *base, const struct rmap_emission *emission)
{
    struct rmap_portion_recorder *self = (struct rmap_portion_recorder *)base;
    struct rmap_portion *portion = self->portion;
    struct rmap_ray_columns *ray = &portion->ray;
    size_t i;
    if (!next_row(self, RMAP_TABLE_RAY, &i))
        return;
    if (i == 0 || emission->ray < portion->first_ray)
        portion->first_ray = emission->ray;
    ray->id[i] = emission->ray;
    ray->source[i] = emission->source;
    ray->registration_count[i] = 0;
    self->first_segment = portion->n_row[RMAP_TABLE_SEGMENT];
    ray->start_object[i] = emission->object;
    ray->start_primitive[i] = emission->primitive;
    store_float3(ray->start + 3 * i, &emission->position);
    store_normal(ray->start_normal + 3 * i, &emission->normal);
}

static void step(struct rmap_recorder *base, const struct rmap_step *segment);

static RMAP_SELDOM void step_with_room(struct rmap_recorder *base, const struct rmap_step *segment)
{
    if (make_room((struct rmap_portion_recorder *)base, RMAP_TABLE_SEGMENT))
        step(base, segment);
}

/* Calls come last here, so that nothing need be kept over them: it runs once a segment. */
static void step(struct rmap_recorder *base, const struct rmap_step *segment)
{
    struct rmap_portion_recorder *self = (struct rmap_portion_recorder *)base;
    struct rmap_portion *portion = self->portion;
    struct rmap_segment_columns *row = &portion->segment;
    if (is_full(self, RMAP_TABLE_SEGMENT)) {
        step_with_room(base, segment);
        return;
    }
    size_t i = portion->n_row[RMAP_TABLE_SEGMENT]++;
    int n_channel = portion->n_channel;
    row->object[i] = segment->object;
    row->primitive[i] = segment->primitive;
    row->event[i] = segment->events;
    row->medium[i] = (int16_t)segment->medium;
    store_float3(row->position + 3 * i, &segment->position);
    store_normal(row->normal + 3 * i, &segment->normal);
    store_colour(self, n_channel, segment->colour, portion->colour + i * (size_t)n_channel);
}

/* Of the ray that was emitted last. */
static void curve(struct rmap_recorder *base, const struct rmap_curve_point *point)
{
    struct rmap_portion_recorder *self = (struct rmap_portion_recorder *)base;
    struct rmap_portion *portion = self->portion;
    size_t i;
    if (!next_row(self, RMAP_TABLE_CURVE, &i))
        return;
    portion->curve.ray[i] = portion->ray.id[portion->n_row[RMAP_TABLE_RAY] - 1];
    portion->curve.segment[i] = point->segment;
    store_float3(portion->curve.position + 3 * i, &point->position);
}

static void registration(struct rmap_recorder *base, const struct rmap_registration *hit)
{
    struct rmap_portion_recorder *self = (struct rmap_portion_recorder *)base;
    struct rmap_portion *portion = self->portion;
    struct rmap_registration_columns *out = &portion->registration;
    size_t i;
    if (!next_row(self, RMAP_TABLE_REGISTRATION, &i))
        return;
    out->segment[i] = hit->segment;
    out->detector[i] = hit->detector;
    for (size_t k = 0; k < 2; k++) {
        out->cell[2 * i + k] = (uint16_t)hit->cell[k];
        out->relative[2 * i + k] = quantise_relative(hit->relative[k]);
    }
    out->registered[i] = hit->registered;
    store_float3(out->direction + 3 * i, &hit->direction);
    out->optical_path[i] = plain(hit->optical_path);
    if (portion->timed) {
        out->group_path[i] = plain(hit->group_path);
        out->delay[i] = plain(hit->delay_ns);
    }
    portion->ray.registration_count[portion->n_row[RMAP_TABLE_RAY] - 1]++;
}

static void end(struct rmap_recorder *base, const struct rmap_ending *ending)
{
    struct rmap_portion_recorder *self = (struct rmap_portion_recorder *)base;
    struct rmap_ray_columns *ray = &self->portion->ray;
    if (self->status != RMAP_OK)
        return;
    const size_t *n_row = self->portion->n_row;
    size_t i = n_row[RMAP_TABLE_RAY] - 1;
    ray->segment_count[i] = (uint32_t)(n_row[RMAP_TABLE_SEGMENT] - self->first_segment);
    ray->stop[i] = (uint8_t)ending->stop;
    ray->weight[i] = plain(ending->weight);
    ray->wavelength[i] = plain(ending->wavelength_nm);
    ray->path_length[i] = plain(ending->path_length);
    ray->optical_path[i] = plain(ending->optical_path);
    if (self->portion->timed) {
        ray->group_path[i] = plain(ending->group_path);
        ray->delay[i] = plain(ending->delay_ns);
    }
    store_float3(ray->end_direction + 3 * i, &ending->direction);
    if (ending->predicted)
        return;
    if (self->unpredicted.n < RMAP_UNPREDICTED_MAX)
        self->unpredicted.ray[self->unpredicted.n] = (uint32_t)i;
    self->unpredicted.n++;
}

void rmap_portion_recorder_init(struct rmap_portion_recorder *recorder,
                                struct rmap_portion *portion)
{
    *recorder = (struct rmap_portion_recorder){.base = {.emit = emit,
                                                        .step = step,
                                                        .curve = curve,
                                                        .registration = registration,
                                                        .end = end},
                                               .portion = portion};
    for (int i = 0; i < 2; i++) /* bits of no colour */
        memset(recorder->colour[i].share, 0xff, sizeof recorder->colour[i].share);
    recorder->last = recorder->colour;
}

void rmap_portion_recorder_restart(struct rmap_portion_recorder *recorder, uint64_t first_ray)
{
    rmap_portion_clear(recorder->portion);
    recorder->portion->first_ray = first_ray;
    recorder->portion->unpredicted = &recorder->unpredicted;
    recorder->unpredicted.n = 0;
}
