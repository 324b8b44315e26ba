/* SPDX-License-Identifier: MIT
 *
 * The colours of a page's segments, each once: what to draw them with, and what to say of them.
 */
#ifndef RMAP_PAGE_COLOUR_H
#define RMAP_PAGE_COLOUR_H

#include <jansson.h>

#include "analysis/page/page.h"

/* {"of": colour of each segment, "paper" and "night": sRGB bytes on a light and a dark ground,
 * "live": channels with light in them, "channel" and "share": the four strongest (share of 65535)}.
 * NULL with err set. */
json_t *rmap_page_colours(const struct rmap_page *page, struct rmap_error *err);

#endif
