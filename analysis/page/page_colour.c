/* SPDX-License-Identifier: MIT
 *
 * The colours of a page's segments, each once: what to draw them with, and what to say of them.
 */
#include "analysis/page/page_colour.h"

#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "analysis/figure/figure_rays.h"
#include "analysis/page/page_pack.h"
#include "analysis/table/colour_map.h"
#include "base/alloc.h"
#include "optics/spectrum.h"

enum { STRONGEST = 4 };

/* Lightness (Oklab) that a line on a dark ground has at least. */
static const double NIGHT_LIGHTNESS = 0.68;

/* A colour's first segment, and the colour space that it is in. */
struct entry {
    size_t segment, space;
};

struct book {
    const struct rmap_portion *rays;
    size_t n, cap, n_slot; /* n_slot: a power of 2 */
    struct entry *entry;   /* [n] */
    int32_t *slot;         /* [n_slot] 1 + entry; 0: empty */
    int32_t *of;           /* [segments] */
};

static const uint16_t *row_of(const struct book *book, size_t segment)
{
    return book->rays->colour + segment * (size_t)book->rays->n_channel;
}

static size_t find_slot(const struct book *book, size_t segment, size_t space)
{
    size_t nbytes = (size_t)book->rays->n_channel * sizeof(uint16_t);
    size_t at = XXH3_64bits_withSeed(row_of(book, segment), nbytes, space) & (book->n_slot - 1);
    while (book->slot[at]) {
        const struct entry *entry = &book->entry[book->slot[at] - 1];
        if (entry->space == space &&
            memcmp(row_of(book, entry->segment), row_of(book, segment), nbytes) == 0)
            break;
        at = (at + 1) & (book->n_slot - 1);
    }
    return at;
}

static enum rmap_status add(struct book *book, size_t segment, size_t space, struct rmap_error *err)
{
    size_t at = find_slot(book, segment, space);
    if (!book->slot[at]) {
        enum rmap_status st = RMAP_RESERVE(book->entry, book->cap, book->n + 1, err);
        if (st != RMAP_OK)
            return st;
        book->entry[book->n++] = (struct entry){segment, space};
        book->slot[at] = (int32_t)book->n;
    }
    book->of[segment] = book->slot[at] - 1;
    return RMAP_OK;
}

static enum rmap_status fill(struct book *book, const struct rmap_map *map, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *rays = book->rays;
    size_t n_segment = rays->n_row[RMAP_TABLE_SEGMENT], segment = 0;
    book->n_slot = 1024;
    while (book->n_slot < 2 * n_segment)
        book->n_slot *= 2;
    book->slot = rmap_alloc(book->n_slot, sizeof *book->slot);
    book->of = rmap_alloc(n_segment + 1, sizeof *book->of);
    if (!book->slot || !book->of)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the colours of a page");
    for (size_t i = 0; i < rays->n_row[RMAP_TABLE_RAY]; i++) {
        size_t space = rmap_map_space_of_ray(map, rays->ray.id[i]);
        for (size_t end = segment + rays->ray.segment_count[i]; segment < end; segment++)
            RMAP_TRY(add(book, segment, space, err));
    }
out:
    return st;
}

static void night_ink(const struct rmap_scene *scene, const double *share, uint8_t byte[3])
{
    double rgb[3], lab[3];
    rmap_colour_display(&scene->channels, share, scene->flux_unit == RMAP_FLUX_LM, rgb);
    for (int k = 0; k < 3; k++)
        rgb[k] = fmin(fmax(rgb[k], 0.0), 1.0);
    rmap_rgb_to_oklab(rgb, lab);
    lab[0] = fmax(lab[0], NIGHT_LIGHTNESS);
    rmap_oklab_to_rgb(lab, rgb);
    rmap_srgb_encode(rgb, byte);
}

static void paper_ink(const struct rmap_scene *scene, const double *share, uint8_t byte[3])
{
    char ink[8];
    rmap_ray_ink(scene, share, ink);
    unsigned long rgb = strtoul(ink + 1, NULL, 16);
    for (int k = 0; k < 3; k++)
        byte[k] = (uint8_t)(rgb >> (16 - 8 * k));
}

/* The strongest channels of a row, strongest first, the shorter wavelength of equal ones. */
static int strongest(const uint16_t *row, int n, uint8_t channel[STRONGEST],
                     uint16_t share[STRONGEST])
{
    int live = 0;
    for (int c = 0; c < n; c++) {
        int at = live < STRONGEST ? live : STRONGEST;
        if (row[c] == 0)
            continue;
        live++;
        for (; at > 0 && row[c] > share[at - 1]; at--)
            if (at < STRONGEST) {
                channel[at] = channel[at - 1];
                share[at] = share[at - 1];
            }
        if (at < STRONGEST) {
            channel[at] = (uint8_t)c;
            share[at] = row[c];
        }
    }
    return live;
}

struct inks {
    uint8_t *paper, *night, *live, *channel;
    uint16_t *share;
};

static void mix(const struct book *book, const struct rmap_map *map, struct inks *inks)
{
    for (size_t i = 0; i < book->n; i++) {
        const struct rmap_scene *scene = rmap_map_scene_of(map, book->entry[i].space);
        const uint16_t *row = row_of(book, book->entry[i].segment);
        int n =
            scene->channels.n < book->rays->n_channel ? scene->channels.n : book->rays->n_channel;
        double share[RMAP_CHANNEL_MAX] = {0};
        for (int c = 0; c < n; c++)
            share[c] = row[c] / 65535.0;
        paper_ink(scene, share, inks->paper + 3 * i);
        night_ink(scene, share, inks->night + 3 * i);
        inks->live[i] =
            (uint8_t)strongest(row, n, inks->channel + STRONGEST * i, inks->share + STRONGEST * i);
    }
}

json_t *rmap_page_colours(const struct rmap_page *page, struct rmap_error *err)
{
    struct book book = {.rays = page->rays};
    struct inks inks = {0};
    json_t *json = NULL;
    enum rmap_status st = fill(&book, page->map, err);
    if (st != RMAP_OK)
        goto out;
    inks.paper = rmap_alloc(book.n + 1, 3);
    inks.night = rmap_alloc(book.n + 1, 3);
    inks.live = rmap_alloc(book.n + 1, 1);
    inks.channel = rmap_alloc(book.n + 1, STRONGEST);
    inks.share = rmap_alloc(book.n + 1, STRONGEST * sizeof *inks.share);
    if (inks.paper && inks.night && inks.live && inks.channel && inks.share) {
        mix(&book, page->map, &inks);
        json = json_pack("{s:o, s:o, s:o, s:o, s:o, s:o}", "of",
                         rmap_page_integers(book.of, page->rays->n_row[RMAP_TABLE_SEGMENT]),
                         "paper", rmap_page_bytes(inks.paper, 3 * book.n), "night",
                         rmap_page_bytes(inks.night, 3 * book.n), "live",
                         rmap_page_bytes(inks.live, book.n), "channel",
                         rmap_page_bytes(inks.channel, STRONGEST * book.n), "share",
                         rmap_page_shorts(inks.share, STRONGEST * book.n));
    }
    if (!json)
        (void)rmap_error_set(err, RMAP_SYSTEM, "out of memory for the colours of a page");
out:
    rmap_free(inks.paper);
    rmap_free(inks.night);
    rmap_free(inks.live);
    rmap_free(inks.channel);
    rmap_free(inks.share);
    rmap_free(book.entry);
    rmap_free(book.slot);
    rmap_free(book.of);
    return json;
}
