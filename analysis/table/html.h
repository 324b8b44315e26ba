/* SPDX-License-Identifier: MIT
 *
 * A page that stands alone: no scripts, nothing from a network; reads well in light and dark, and
 * on paper. Writing never fails on the spot: the stream keeps its error.
 */
#ifndef RMAP_HTML_H
#define RMAP_HTML_H

#include <stdio.h>

#include "io/export/svg.h"

/* Everything up to <main>, and from </main> on. */
void rmap_html_begin(FILE *out, const char *title);
void rmap_html_end(FILE *out);

/* Text as text: nothing in it is read as HTML. */
void rmap_html_text(FILE *out, const char *text);

/* printf, as text. */
void rmap_html_printf(FILE *out, const char *format, ...) RMAP_PRINTF(2, 3);

/* The picture in line, which ends it. Its ids get `number` in front: pictures do not share them. */
enum rmap_status rmap_html_picture(FILE *out, struct rmap_svg *svg, int number,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
