/* SPDX-License-Identifier: MIT
 *
 * Draws of readings: slots of the random numbers by what they are for.
 */
#include "scene/reading.h"

#include "base/portable.h"
#include "base/rng.h"
#include "optics/photon_number.h"

enum purpose { PHOTO_ELECTRONS, DARK, DARK_TIME, CROSSTALK, CELL, AFTERPULSE, PURPOSES = 8 };

static enum rmap_rng_slot slot_of(const struct rmap_reading_of *of, enum purpose purpose)
{
    return (enum rmap_rng_slot)(RMAP_RNG_READING + of->detector * PURPOSES + (int)purpose);
}

/* One number after the other. */
struct stream {
    const struct rmap_reading_of *of;
    enum purpose purpose;
    uint64_t taken;
    double u[4];
};

static double next(struct stream *stream)
{
    if (stream->taken % 4 == 0)
        rmap_rng(stream->of->seed, stream->of->event, (uint32_t)(stream->taken / 4),
                 slot_of(stream->of, stream->purpose), stream->u);
    return stream->u[stream->taken++ % 4];
}

/* Further avalanches of so many, generation by generation; of a probability below 1 they end. */
static uint64_t borel(double p, const struct rmap_reading_of *of, uint64_t primary)
{
    const double mean = -rmap_portable_log(1.0 - p);
    uint64_t sum = 0;
    uint32_t step = 0;
    for (uint64_t n = primary; n > 0; sum += n)
        n = rmap_poisson(mean * (double)n, of->seed, of->event, slot_of(of, CROSSTALK), &step);
    return sum;
}

static uint64_t geometric(double p, const struct rmap_reading_of *of, uint64_t primary)
{
    struct stream stream = {.of = of, .purpose = CROSSTALK};
    uint64_t sum = 0;
    for (uint64_t i = 0; i < primary; i++)
        while (next(&stream) < p)
            sum++;
    return sum;
}

/* Of cells that have fired, dark counts first; within the window. A cell that fires by an
 * afterpulse has recovered, and has no other. */
static uint64_t afterpulses(const struct rmap_reading *reading, const struct rmap_reading_of *of,
                            const struct rmap_read *read, double mean_ns)
{
    struct stream stream = {.of = of, .purpose = AFTERPULSE};
    uint64_t sum = 0;
    for (uint64_t i = 0; i < read->cells && reading->afterpulse > 0.0; i++) {
        const double u[3] = {next(&stream), next(&stream), next(&stream)};
        const double at = i < read->dark  ? u[2] * reading->window_ns
                          : mean_ns > 0.0 ? mean_ns
                                          : 0.0;
        const double delay = -reading->afterpulse_ns * rmap_portable_log(u[1]);
        sum += u[0] < reading->afterpulse && at + delay < rmap_reading_until(reading);
    }
    return sum;
}

/* Avalanches fire cells at random; what fires one of them twice counts once. */
static uint64_t cells_of(const struct rmap_reading *reading, const struct rmap_reading_of *of,
                         uint64_t avalanches)
{
    struct stream stream = {.of = of, .purpose = CELL};
    uint64_t fired = 0;
    for (uint64_t i = 0; i < avalanches; i++)
        fired += next(&stream) * (double)reading->cells >= (double)fired;
    return fired;
}

void rmap_reading_draw(const struct rmap_reading *reading, const struct rmap_reading_of *of,
                       double photo_electrons, bool is_whole, double mean_ns,
                       struct rmap_read *read)
{
    uint32_t step = 0;
    read->photo_electrons = is_whole || !(photo_electrons > 0.0)
                                ? (uint64_t)(photo_electrons + 0.5)
                                : rmap_poisson(photo_electrons, of->seed, of->event,
                                               slot_of(of, PHOTO_ELECTRONS), &step);
    step = 0;
    const double dark = reading->dark_hz * 1e-9 * reading->window_ns;
    read->dark = dark > 0.0 ? rmap_poisson(dark, of->seed, of->event, slot_of(of, DARK), &step) : 0;
    const uint64_t primary = read->photo_electrons + read->dark;
    read->crosstalk = !(reading->crosstalk > 0.0) ? 0
                      : reading->model == RMAP_CROSSTALK_BOREL
                          ? borel(reading->crosstalk, of, primary)
                          : geometric(reading->crosstalk, of, primary);
    read->cells = primary + read->crosstalk;
    if (reading->cells > 0)
        read->cells = cells_of(reading, of, read->cells);
    read->afterpulses = afterpulses(reading, of, read, mean_ns);
    read->cells += read->afterpulses;
}

void rmap_reading_dark_times(const struct rmap_reading *reading, const struct rmap_reading_of *of,
                             uint64_t dark, double *early, size_t n)
{
    struct stream stream = {.of = of, .purpose = DARK_TIME};
    for (uint64_t i = 0; i < dark && n > 0; i++) {
        const double time = next(&stream) * reading->window_ns;
        if (time >= early[n - 1])
            continue;
        size_t k = n - 1;
        for (; k > 0 && early[k - 1] > time; k--)
            early[k] = early[k - 1];
        early[k] = time;
    }
}
