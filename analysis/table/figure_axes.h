/* SPDX-License-Identifier: MIT
 *
 * The furniture of a figure: ticks at round numbers, a frame with labelled axes, a colour bar,
 * captions that fit.
 */
#ifndef RMAP_FIGURE_AXES_H
#define RMAP_FIGURE_AXES_H

#include <stdbool.h>
#include <stddef.h>

#include "analysis/table/colour_map.h"
#include "io/export/svg.h"

#define RMAP_TICK_MAX 24

/* A unit as it is written by hand: "W/(m² sr)" of "W/(m2 sr)". It lives to the end of its
 * statement. */
struct rmap_unit_text {
    char text[64];
};
struct rmap_unit_text rmap_unit_text(const char *unit);

/* Sizes of type, in pixels. */
#define RMAP_TITLE_SIZE 18.0
#define RMAP_LABEL_SIZE 14.0
#define RMAP_TICK_SIZE  12.5

struct rmap_ticks {
    int n;
    double value[RMAP_TICK_MAX];
    int decimals; /* that tell them apart, once divided by 10^exponent */
    int exponent; /* multiple of 3 taken out of the numbers */
};

/* Multiples of 1, 2 or 5 times a power of ten in [low, high], at most `most` of them (>= 2). */
void rmap_ticks_linear(double low, double high, int most, struct rmap_ticks *ticks);

/* The same for angles: multiples of 5, 10, 15, 30, 45 or 90. */
void rmap_ticks_degrees(double low, double high, int most, struct rmap_ticks *ticks);

/* Powers of ten in [low, high], 0 < low < high. */
void rmap_ticks_decades(double low, double high, struct rmap_ticks *ticks);

/* 1, 2 and 5 times powers of ten in [low, high], 0 < low < high; powers alone where these are many;
 * where they are few, as rmap_ticks_linear. */
void rmap_ticks_powers(double low, double high, int most, struct rmap_ticks *ticks);

/* Round length (1, 2 or 5 times a power of ten) not above `longest` > 0. */
double rmap_round_below(double longest);

/* A plot area in pixels and the ranges that it shows; values grow to the right and upwards. */
struct rmap_axes {
    double x, y, width, height; /* upper left corner and size */
    double x_range[2], y_range[2];
    const char *x_label, *y_label, *x_unit, *y_unit;
    bool x_powers, y_powers; /* the range is of decimal logarithms of what the ticks say */
};

double rmap_axes_x(const struct rmap_axes *axes, double value);
double rmap_axes_y(const struct rmap_axes *axes, double value);

void rmap_axes_draw(struct rmap_svg *svg, const struct rmap_axes *axes);

struct rmap_colour_bar {
    double x, y, width, height;
    double range[2]; /* of the values */
    bool logarithmic;
    const char *label, *unit;
};

/* Place of a value on the bar, 0 to 1. */
double rmap_colour_bar_place(const struct rmap_colour_bar *bar, double value);

enum rmap_status rmap_colour_bar_draw(struct rmap_svg *svg, const struct rmap_colour_bar *bar,
                                      const struct rmap_colour_map *map,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* One line of text, shortened with an ellipsis where it would exceed `width` pixels. */
void rmap_caption(struct rmap_svg *svg, const struct rmap_svg_text *text, double width,
                  const char *string);

/* Bytes of a text's first line, such as has room in `width` pixels: up to a blank, within a word
 * that is wider; all of it where it is. */
size_t rmap_line_nbytes(const char *string, double size, double width);

/* Title and lines of text above a picture that was laid out for one row of each, in the order in
 * which they stand: x from both edges. What is longer goes on in rows below, and the picture grows
 * upwards by them. */
void rmap_captions(struct rmap_svg *svg, double x, const char *const string[], size_t n);

#endif
