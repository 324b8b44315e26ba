/* SPDX-License-Identifier: MIT
 *
 * Radiance's pictures (Ward 1991, "Real pixels", Graphics Gems II; file format of Radiance 3): a
 * head of lines, the order of scan lines, and pixels of three mantissas with one exponent.
 */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/picture/picture.h"

struct reading {
    const uint8_t *at, *end;
    double divisor[3];
    bool flipped[2]; /* from the lower end; from the right */
    bool upright;    /* scan lines are columns */
    struct rmap_error *err;
};

static enum rmap_status damaged(const struct reading *in, const char *what)
{
    return rmap_error_set(in->err, RMAP_INPUT, "it is no whole RGBE picture: %s", what);
}

/* A line without its end; "" where there is none. */
static bool take_line(struct reading *in, char line[256])
{
    size_t n = 0;
    while (in->at < in->end && *in->at != '\n') {
        if (n + 1 < 256)
            line[n++] = (char)*in->at;
        in->at++;
    }
    const bool whole = in->at < in->end;
    in->at += whole;
    if (n > 0 && line[n - 1] == '\r')
        n--;
    line[n] = 0;
    return whole;
}

static enum rmap_status take_head_line(struct reading *in, const char *line)
{
    double value[3];
    if (strncmp(line, "FORMAT=", 7) == 0 && strcmp(line + 7, "32-bit_rle_rgbe") != 0)
        return rmap_error_set(in->err, RMAP_INPUT,
                              "its FORMAT is '%.40s', not 32-bit_rle_rgbe: convert it (ra_xyze -r)",
                              line + 7);
    const bool exposed = strncmp(line, "EXPOSURE=", 9) == 0;
    if (!exposed && strncmp(line, "COLORCORR=", 10) != 0)
        return RMAP_OK;
    const char *text = strchr(line, '=') + 1;
    char *rest;
    for (int k = 0; k < 3; k++) {
        value[k] = k > 0 && exposed ? value[0] : strtod(text, &rest);
        if (!(k > 0 && exposed) && rest == text)
            return damaged(in, "EXPOSURE and COLORCORR are numbers");
        text = rest;
        in->divisor[k] *= value[k];
        if (!(in->divisor[k] > 0.0) || !isfinite(in->divisor[k]))
            return damaged(in, "EXPOSURE and COLORCORR are greater than 0");
    }
    return RMAP_OK;
}

/* "-Y 512 +X 1024": the first axis leads from one scan line to the next. */
static enum rmap_status take_order(struct reading *in, uint64_t size[2])
{
    char line[256], axis[2], sign[2], rest;
    unsigned long count[2];
    (void)take_line(in, line);
    if (sscanf(line, "%c%c %9lu %c%c %9lu%c", &sign[0], &axis[0], &count[0], &sign[1], &axis[1],
               &count[1], &rest) != 6 ||
        axis[0] == axis[1])
        return damaged(in, "no line such as '-Y 512 +X 1024' ends its head");
    for (int k = 0; k < 2; k++) {
        const int which = axis[k] == 'X' ? 0 : 1;
        if ((axis[k] != 'X' && axis[k] != 'Y') || (sign[k] != '+' && sign[k] != '-'))
            return damaged(in, "its axes are +X, -X, +Y, -Y");
        size[which] = count[k];
        in->flipped[which] = sign[k] == (which == 0 ? '-' : '+');
    }
    in->upright = axis[0] == 'X';
    return RMAP_OK;
}

static enum rmap_status take_head(struct reading *in, uint64_t size[2])
{
    enum rmap_status st = RMAP_OK;
    char line[256];
    do {
        if (!take_line(in, line))
            return damaged(in, "its head has no end");
        RMAP_TRY(take_head_line(in, line));
    } while (line[0]);
    st = take_order(in, size);
out:
    return st;
}

/* Flat, or of runs as of old: a pixel (1, 1, 1, n) repeats the one before. */
static enum rmap_status take_old(struct reading *in, uint8_t (*pixel)[4], size_t n)
{
    unsigned shift = 0;
    for (size_t i = 0; i < n;) {
        if (in->end - in->at < 4)
            return damaged(in, "it ends early");
        const uint8_t *p = in->at;
        in->at += 4;
        if (p[0] != 1 || p[1] != 1 || p[2] != 1) {
            memcpy(pixel[i++], p, 4);
            shift = 0;
            continue;
        }
        if (i == 0 || shift > 16)
            return damaged(in, "a run repeats nothing");
        size_t run = (size_t)p[3] << shift;
        if (run > n - i)
            return damaged(in, "a run is longer than its line");
        for (; run > 0; run--, i++)
            memcpy(pixel[i], pixel[i - 1], 4);
        shift += 8;
    }
    return RMAP_OK;
}

/* Each of the four bytes of all pixels in runs of its own. */
static enum rmap_status take_new(struct reading *in, uint8_t (*pixel)[4], size_t n)
{
    for (int k = 0; k < 4; k++)
        for (size_t i = 0; i < n;) {
            if (in->end - in->at < 2)
                return damaged(in, "it ends early");
            size_t count = *in->at++;
            const bool run = count > 128;
            count -= run ? 128 : 0;
            if (count == 0 || count > n - i)
                return damaged(in, "a run is longer than its line");
            if (!run && (size_t)(in->end - in->at) < count)
                return damaged(in, "it ends early");
            for (size_t c = 0; c < count; c++)
                pixel[i++][k] = run ? *in->at : in->at[c];
            in->at += run ? 1 : count;
        }
    return RMAP_OK;
}

static enum rmap_status take_scan_line(struct reading *in, uint8_t (*pixel)[4], size_t n)
{
    const uint8_t *p = in->at;
    if (n < 8 || n > 32767 || in->end - p < 4 || p[0] != 2 || p[1] != 2 || p[2] >= 128)
        return take_old(in, pixel, n);
    if (((size_t)p[2] << 8 | p[3]) != n)
        return damaged(in, "a line has another length than the head says");
    in->at += 4;
    return take_new(in, pixel, n);
}

static void put_pixel(const struct reading *in, const uint8_t from[4], float to[3])
{
    for (int k = 0; k < 3; k++)
        to[k] = from[3] ? (float)(ldexp((double)from[k], (int)from[3] - 136) / in->divisor[k]) : 0;
}

enum rmap_status rmap_picture_rgbe(const uint8_t *bytes, size_t nbytes,
                                   struct rmap_picture *picture, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct reading in = {
        .at = bytes, .end = bytes + nbytes, .divisor = {1.0, 1.0, 1.0}, .err = err};
    uint64_t size[2] = {0, 0};
    uint8_t(*pixel)[4] = NULL;
    RMAP_TRY(take_head(&in, size));
    const size_t n = (size_t)size[in.upright ? 1 : 0], n_line = (size_t)size[in.upright ? 0 : 1];
    if (n_line > (size_t)(in.end - in.at)) /* before memory is taken for it */
        RMAP_TRY(damaged(&in, "it ends early"));
    RMAP_TRY(rmap_picture_init(picture, size[0], size[1], err));
    pixel = rmap_alloc(n, sizeof *pixel);
    if (!pixel)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture"));
    for (size_t l = 0; l < n_line; l++) {
        RMAP_TRY(take_scan_line(&in, pixel, n));
        for (size_t i = 0; i < n; i++) {
            size_t x = in.upright ? l : i, y = in.upright ? i : l;
            x = in.flipped[0] ? (size_t)size[0] - 1 - x : x;
            y = in.flipped[1] ? (size_t)size[1] - 1 - y : y;
            put_pixel(&in, pixel[i], picture->rgb + 3 * (y * (size_t)size[0] + x));
        }
    }
out:
    rmap_free(pixel);
    return st;
}
