/* SPDX-License-Identifier: MIT
 *
 * A small writer of SVG 1.1 pictures. The same calls give the same bytes: coordinates have two
 * decimals, nothing depends on the clock or the machine. Text stays text.
 *
 * Calls never fail on the spot: the first error (memory) is kept and reported by rmap_svg_finish.
 * Colours are SVG colours ("#1f77b4"); NULL means none. Coordinates in pixels, y down.
 */
#ifndef RMAP_SVG_H
#define RMAP_SVG_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct rmap_svg;

struct rmap_svg_style {
    const char *fill, *stroke; /* NULL: none */
    double width;              /* of the stroke; 0: 1 */
    double opacity;            /* of fill and stroke; 0: 1 */
    const char *dash;          /* "4 3"; NULL: solid */
};

enum rmap_svg_anchor { RMAP_SVG_START, RMAP_SVG_MIDDLE, RMAP_SVG_END };

struct rmap_svg_text {
    double x, y; /* of the baseline */
    double size; /* font size */
    enum rmap_svg_anchor anchor;
    double rotate_deg; /* clockwise about (x, y) */
    const char *fill;  /* NULL: black */
    const char *halo;  /* colour of a thin outline that keeps the text readable; NULL: none */
    int bold;
};

/* A picture of so many pixels with a white ground. `title` is for readers of the file. */
enum rmap_status rmap_svg_create(double width, double height, const char *title,
                                 struct rmap_svg **svg_ret, struct rmap_error *err) RMAP_MUST_USE;
void rmap_svg_destroy(struct rmap_svg *svg); /* NULL is fine */

/* Adds so many pixels above the picture, white ones: y is negative there. */
void rmap_svg_raise(struct rmap_svg *svg, double above);

double rmap_svg_width(const struct rmap_svg *svg);
double rmap_svg_height(const struct rmap_svg *svg);

/* Everything up to the matching close shares a style and is cut off outside the rectangle. */
void rmap_svg_open_clip(struct rmap_svg *svg, double x, double y, double width, double height);
void rmap_svg_close(struct rmap_svg *svg);

void rmap_svg_rect(struct rmap_svg *svg, double x, double y, double width, double height,
                   const struct rmap_svg_style *style);
void rmap_svg_circle(struct rmap_svg *svg, double x, double y, double radius,
                     const struct rmap_svg_style *style);
void rmap_svg_line(struct rmap_svg *svg, double x0, double y0, double x1, double y1,
                   const struct rmap_svg_style *style);

/* A polyline through n points; a point with a NaN lifts the pen. With a fill, each run of points
 * is a closed region (even-odd). */
void rmap_svg_path(struct rmap_svg *svg, const double (*point)[2], size_t n,
                   const struct rmap_svg_style *style);

/* `string` is UTF-8; what is not valid text is shown as '?'. */
void rmap_svg_string(struct rmap_svg *svg, const struct rmap_svg_text *text, const char *string);

/* Width that a string will take, near enough to lay out by (DejaVu Sans's mean advance). */
double rmap_svg_string_width(const char *string, double size);

/* A PNG image stretched to the rectangle. Viewers keep its pixels sharp; librsvg smooths them
 * unless image and output pixels coincide. */
void rmap_svg_image(struct rmap_svg *svg, double x, double y, double width, double height,
                    const uint8_t *png, size_t png_nbytes);

/* Ends the picture. The text is borrowed until destroy, [*nbytes_ret] bytes. RMAP_SYSTEM when
 * memory ran short on the way. */
enum rmap_status rmap_svg_finish(struct rmap_svg *svg, const char **text_ret, size_t *nbytes_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
