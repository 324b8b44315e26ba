/* SPDX-License-Identifier: MIT
 *
 * Improved noise (Perlin 2002, doi:10.1145/566654.566636) in octaves: turbulence, striae.
 */
#include "gradient/field_noise.h"

#include "base/alloc.h"
#include "base/rng.h"
#include "gradient/field_internal.h"

enum { CELLS = 256 };

struct octave {
    double per_length, weight;
    uint8_t permutation[CELLS];
};

struct noise {
    struct rmap_field field;
    double scale;
    int n_octave;
    struct octave octave[RMAP_NOISE_OCTAVE_MAX];
    struct {
        double mean, amplitude;
    } of_channel[]; /* [n_channel] */
};

/* The 12 edges of a cube, four of them twice (Perlin 2002, fig. 3). */
static const signed char edge[16][3] = {
    {1, 1, 0}, {-1, 1, 0}, {1, -1, 0}, {-1, -1, 0}, {1, 0, 1}, {-1, 0, 1}, {1, 0, -1}, {-1, 0, -1},
    {0, 1, 1}, {0, -1, 1}, {0, 1, -1}, {0, -1, -1}, {1, 1, 0}, {0, -1, 1}, {-1, 1, 0}, {0, -1, -1}};

/* A place along one axis: its cell, and weight and slope of the upper corner:
 * 6 t^5 - 15 t^4 + 10 t^3. */
struct along {
    int cell;
    double t, fade, slope;
};

static struct along along_axis(double x)
{
    double floor_x = floor(x), t = x - floor_x, back = t - 1.0;
    /* The remainder is exact, and small enough for an int. */
    double cell = floor_x - CELLS * floor(floor_x / CELLS);
    return (struct along){(int)cell & (CELLS - 1), t, t * t * t * (t * (6.0 * t - 15.0) + 10.0),
                          30.0 * t * t * back * back};
}

/* Value and slope of one octave, in cells. Trilinear in the fades of what each corner's gradient
 * says; the slope is its derivative. */
static double octave_at(const struct octave *octave, struct rmap_vec3 p, struct rmap_vec3 *slope)
{
    const uint8_t *of = octave->permutation;
    const struct along x = along_axis(p.x), y = along_axis(p.y), z = along_axis(p.z);
    double value = 0.0;
    *slope = rmap_vec3(0, 0, 0);
    for (int corner = 0; corner < 8; corner++) {
        int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
        uint8_t a = of[(x.cell + i) & (CELLS - 1)];
        uint8_t b = of[(a + y.cell + j) & (CELLS - 1)];
        const signed char *e = edge[of[(b + z.cell + k) & (CELLS - 1)] & 15];
        double wx = i ? x.fade : 1.0 - x.fade, wy = j ? y.fade : 1.0 - y.fade;
        double wz = k ? z.fade : 1.0 - z.fade, w = wx * wy * wz;
        double says = e[0] * (x.t - i) + e[1] * (y.t - j) + e[2] * (z.t - k);
        value += w * says;
        slope->x += w * e[0] + (i ? x.slope : -x.slope) * wy * wz * says;
        slope->y += w * e[1] + (j ? y.slope : -y.slope) * wx * wz * says;
        slope->z += w * e[2] + (k ? z.slope : -z.slope) * wx * wy * says;
    }
    return value;
}

static bool at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
               struct rmap_vec3 *gradient)
{
    const struct noise *noise = (const struct noise *)field;
    double sum = 0.0, amplitude = noise->of_channel[channel].amplitude;
    struct rmap_vec3 slope = {0, 0, 0};
    if (!isfinite(rmap_dot(p, p)))
        return false;
    for (int o = 0; o < noise->n_octave; o++) {
        const struct octave *octave = &noise->octave[o];
        struct rmap_vec3 of_octave;
        sum += octave->weight * octave_at(octave, rmap_scale(p, octave->per_length), &of_octave);
        slope = rmap_axpy(octave->weight * octave->per_length, of_octave, slope);
    }
    *n = noise->of_channel[channel].mean + amplitude * sum;
    *gradient = rmap_scale(slope, amplitude);
    return true;
}

static double best_step(const struct rmap_field *field, struct rmap_vec3 p,
                        struct rmap_vec3 direction)
{
    (void)p;
    (void)direction;
    return 0.25 * ((const struct noise *)field)->scale;
}

static const struct rmap_field_ops ops = {.model = "noise", .at = at, .best_step = best_step};

/* Fisher and Yates's shuffle. */
static void shuffle(uint64_t seed, uint32_t number, uint8_t permutation[CELLS])
{
    for (int i = 0; i < CELLS; i++)
        permutation[i] = (uint8_t)i;
    for (int i = CELLS - 1; i > 0; i--) {
        double uniform[4];
        rmap_rng(seed, (uint64_t)i, number, RMAP_RNG_NOISE, uniform);
        int j = (int)(uniform[0] * (i + 1));
        uint8_t kept = permutation[i];
        permutation[i] = permutation[j];
        permutation[j] = kept;
    }
}

static enum rmap_status check(const struct rmap_noise *given, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct {
        struct rmap_parameter is;
        double value;
    } parameter[] = {{{"mean", RMAP_NEED_FINITE}, given->mean},
                     {{"amplitude", RMAP_NEED_FINITE}, given->amplitude},
                     {{"length", RMAP_NEED_POSITIVE}, given->length},
                     {{"persistence", RMAP_NEED_NOT_NEGATIVE}, given->persistence},
                     {{"lacunarity", RMAP_NEED_POSITIVE}, given->lacunarity}};
    for (size_t i = 0; i < sizeof parameter / sizeof parameter[0]; i++)
        RMAP_TRY(rmap_parameter_check("noise", &parameter[i].is, parameter[i].value, err));
    if (given->n_octave < 1 || given->n_octave > RMAP_NOISE_OCTAVE_MAX)
        st = rmap_error_set(err, RMAP_INPUT, "noise: octaves is %d; give 1 to %d", given->n_octave,
                            RMAP_NOISE_OCTAVE_MAX);
out:
    return st;
}

enum rmap_status rmap_field_noise(struct rmap_field **field_ret, int n_channel,
                                  const struct rmap_noise *parameter, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (int c = 0; c < n_channel; c++)
        RMAP_TRY(check(&parameter[c], err));
    struct noise *noise = NULL;
    size_t nbytes = sizeof *noise + (size_t)n_channel * sizeof noise->of_channel[0];
    noise = (struct noise *)rmap_field_new(nbytes, &ops, n_channel, err);
    if (!noise)
        return RMAP_SYSTEM;
    noise->scale = parameter->length;
    noise->n_octave = parameter->n_octave;
    noise->field.step = 1e-4 * parameter->length;
    double finer = 1.0, weight = 1.0;
    for (int o = 0; o < parameter->n_octave; o++) {
        noise->octave[o].per_length = finer / parameter->length;
        noise->octave[o].weight = weight;
        finer *= parameter->lacunarity;
        weight *= parameter->persistence;
        shuffle(parameter->seed, (uint32_t)o, noise->octave[o].permutation);
    }
    for (int c = 0; c < n_channel; c++) {
        noise->of_channel[c].mean = parameter[c].mean;
        noise->of_channel[c].amplitude = parameter[c].amplitude;
    }
    *field_ret = &noise->field;
out:
    return st;
}
