/* SPDX-License-Identifier: MIT
 *
 * A small writer of SVG 1.1 pictures.
 */
#include "io/export/svg.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "io/file/base64.h"
#include "io/file/xml_text.h"

#define FONT "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif"

struct rmap_svg {
    double width, height;
    double above; /* of it: the part with y below 0 */
    char *text;
    size_t nbytes, cap;
    int n_clip, depth;
    enum rmap_status status;
};

static void put_bytes(struct rmap_svg *svg, const char *bytes, size_t n)
{
    if (svg->status != RMAP_OK)
        return;
    svg->status = RMAP_RESERVE(svg->text, svg->cap, svg->nbytes + n, NULL);
    if (svg->status != RMAP_OK)
        return;
    memcpy(svg->text + svg->nbytes, bytes, n);
    svg->nbytes += n;
}

static void put(struct rmap_svg *svg, const char *text)
{
    put_bytes(svg, text, strlen(text));
}

/* Two decimals, without trailing zeros. */
static void put_number(struct rmap_svg *svg, double value)
{
    char text[64];
    if (!isfinite(value) || fabs(value) > 1e9)
        value = 0.0;
    int n = snprintf(text, sizeof text, "%.2f", value);
    while (n > 0 && text[n - 1] == '0')
        n--;
    if (n > 0 && text[n - 1] == '.')
        n--;
    text[n] = 0;
    put(svg, strcmp(text, "-0") == 0 ? "0" : text);
}

static void put_attribute(struct rmap_svg *svg, const char *name, double value)
{
    put(svg, " ");
    put(svg, name);
    put(svg, "=\"");
    put_number(svg, value);
    put(svg, "\"");
}

static void put_word(struct rmap_svg *svg, const char *name, const char *value)
{
    put(svg, " ");
    put(svg, name);
    put(svg, "=\"");
    put(svg, value);
    put(svg, "\"");
}

static void put_escaped(struct rmap_svg *svg, const char *string)
{
    const unsigned char *s = (const unsigned char *)string;
    while (*s) {
        size_t n = rmap_xml_character_nbytes(s);
        const char *entity = rmap_xml_entity((char)*s);
        if (entity)
            put(svg, entity);
        else if (n == 0)
            put(svg, "?");
        else
            put_bytes(svg, (const char *)s, n);
        s += n ? n : 1;
    }
}

/* Opacity of fill and stroke one by one: `opacity` would make every line a layer of its own. */
static void put_style(struct rmap_svg *svg, const struct rmap_svg_style *style)
{
    bool faint = style->opacity > 0.0 && style->opacity < 1.0;
    put_word(svg, "fill", style->fill ? style->fill : "none");
    if (style->fill && faint)
        put_attribute(svg, "fill-opacity", fmax(style->opacity, 0.01));
    if (style->stroke) {
        put_word(svg, "stroke", style->stroke);
        put_attribute(svg, "stroke-width", style->width > 0.0 ? style->width : 1.0);
        if (faint)
            put_attribute(svg, "stroke-opacity", fmax(style->opacity, 0.01));
    }
    if (style->dash)
        put_word(svg, "stroke-dasharray", style->dash);
    put(svg, "/>\n");
}

enum rmap_status rmap_svg_create(double width, double height, const char *title,
                                 struct rmap_svg **svg_ret, struct rmap_error *err)
{
    struct rmap_svg *svg = rmap_alloc(1, sizeof *svg);
    if (!svg)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    svg->width = width;
    svg->height = height;
    put(svg, "<title>");
    put_escaped(svg, title);
    put(svg, "</title>\n");
    rmap_svg_rect(svg, 0, 0, width, height, &(struct rmap_svg_style){.fill = "#ffffff"});
    *svg_ret = svg;
    return RMAP_OK;
}

void rmap_svg_destroy(struct rmap_svg *svg)
{
    if (!svg)
        return;
    rmap_free(svg->text);
    rmap_free(svg);
}

void rmap_svg_raise(struct rmap_svg *svg, double above)
{
    rmap_svg_rect(svg, 0, -svg->above - above, svg->width, above,
                  &(struct rmap_svg_style){.fill = "#ffffff"});
    svg->above += above;
    svg->height += above;
}

double rmap_svg_width(const struct rmap_svg *svg)
{
    return svg->width;
}

double rmap_svg_height(const struct rmap_svg *svg)
{
    return svg->height;
}

static void put_box(struct rmap_svg *svg, double x, double y, double width, double height)
{
    put_attribute(svg, "x", x);
    put_attribute(svg, "y", y);
    put_attribute(svg, "width", width);
    put_attribute(svg, "height", height);
}

void rmap_svg_open_clip(struct rmap_svg *svg, double x, double y, double width, double height)
{
    char id[32];
    (void)snprintf(id, sizeof id, "clip%d", ++svg->n_clip);
    put(svg, "<clipPath");
    put_word(svg, "id", id);
    put(svg, "><rect");
    put_box(svg, x, y, width, height);
    put(svg, "/></clipPath>\n<g clip-path=\"url(#");
    put(svg, id);
    put(svg, ")\">\n");
    svg->depth++;
}

void rmap_svg_close(struct rmap_svg *svg)
{
    put(svg, "</g>\n");
    svg->depth--;
}

void rmap_svg_rect(struct rmap_svg *svg, double x, double y, double width, double height,
                   const struct rmap_svg_style *style)
{
    put(svg, "<rect");
    put_box(svg, x, y, width, height);
    put_style(svg, style);
}

void rmap_svg_circle(struct rmap_svg *svg, double x, double y, double radius,
                     const struct rmap_svg_style *style)
{
    put(svg, "<circle");
    put_attribute(svg, "cx", x);
    put_attribute(svg, "cy", y);
    put_attribute(svg, "r", radius);
    put_style(svg, style);
}

void rmap_svg_line(struct rmap_svg *svg, double x0, double y0, double x1, double y1,
                   const struct rmap_svg_style *style)
{
    put(svg, "<line");
    put_attribute(svg, "x1", x0);
    put_attribute(svg, "y1", y0);
    put_attribute(svg, "x2", x1);
    put_attribute(svg, "y2", y1);
    put_style(svg, style);
}

void rmap_svg_path(struct rmap_svg *svg, const double (*point)[2], size_t n,
                   const struct rmap_svg_style *style)
{
    int down = 0, any = 0;
    size_t begun = svg->nbytes;
    put(svg, "<path d=\"");
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(point[i][0]) || !isfinite(point[i][1])) {
            down = 0;
            continue;
        }
        if (style->fill && !down && any)
            put(svg, "Z");
        put(svg, down ? "L" : "M");
        put_number(svg, point[i][0]);
        put(svg, " ");
        put_number(svg, point[i][1]);
        down = any = 1;
    }
    if (!any) {
        svg->nbytes = begun;
        return;
    }
    put(svg, style->fill ? "Z\" fill-rule=\"evenodd\"" : "\"");
    put_style(svg, style);
}

void rmap_svg_string(struct rmap_svg *svg, const struct rmap_svg_text *text, const char *string)
{
    static const char *const anchor[] = {"start", "middle", "end"};
    put(svg, "<text");
    put_attribute(svg, "x", text->x);
    put_attribute(svg, "y", text->y);
    put_attribute(svg, "font-size", text->size);
    if (text->anchor != RMAP_SVG_START)
        put_word(svg, "text-anchor", anchor[text->anchor]);
    put_word(svg, "fill", text->fill ? text->fill : "#000000");
    if (text->bold)
        put_word(svg, "font-weight", "bold");
    if (text->halo) {
        put_word(svg, "stroke", text->halo);
        put_attribute(svg, "stroke-width", text->size * 0.25);
        put_word(svg, "paint-order", "stroke");
    }
    if (text->rotate_deg < 0.0 || text->rotate_deg > 0.0) {
        put(svg, " transform=\"rotate(");
        put_number(svg, text->rotate_deg);
        put(svg, " ");
        put_number(svg, text->x);
        put(svg, " ");
        put_number(svg, text->y);
        put(svg, ")\"");
    }
    put(svg, ">");
    put_escaped(svg, string);
    put(svg, "</text>\n");
}

double rmap_svg_string_width(const char *string, double size)
{
    size_t n = 0;
    for (const unsigned char *s = (const unsigned char *)string; *s; s++)
        n += (*s & 0xc0) != 0x80;
    return 0.6 * size * (double)n;
}

static void put_base64(struct rmap_svg *svg, const uint8_t *bytes, size_t n)
{
    char four[4];
    for (size_t i = 0; i < n; i += 3) {
        rmap_base64_four(bytes + i, n - i, four);
        put_bytes(svg, four, 4);
    }
}

void rmap_svg_image(struct rmap_svg *svg, double x, double y, double width, double height,
                    const uint8_t *png, size_t png_nbytes)
{
    put(svg, "<image");
    put_box(svg, x, y, width, height);
    put(svg, " preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\""
             " xlink:href=\"data:image/png;base64,");
    put_base64(svg, png, png_nbytes);
    put(svg, "\"/>\n");
}

/* What stands before all: its size is known at the end. */
static void put_head(struct rmap_svg *svg)
{
    struct rmap_svg head = {0};
    put(&head,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\""
        " xmlns:xlink=\"http://www.w3.org/1999/xlink\" version=\"1.1\"");
    put_attribute(&head, "width", svg->width);
    put_attribute(&head, "height", svg->height);
    put(&head, " viewBox=\"0 ");
    put_number(&head, -svg->above);
    put(&head, " ");
    put_number(&head, svg->width);
    put(&head, " ");
    put_number(&head, svg->height);
    put(&head, "\" font-family=\"" FONT "\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n");
    put_bytes(&head, svg->text ? svg->text : "", svg->nbytes);
    rmap_free(svg->text);
    svg->text = head.text;
    svg->nbytes = head.nbytes;
    svg->cap = head.cap;
    if (svg->status == RMAP_OK)
        svg->status = head.status;
}

enum rmap_status rmap_svg_finish(struct rmap_svg *svg, const char **text_ret, size_t *nbytes_ret,
                                 struct rmap_error *err)
{
    while (svg->depth > 0)
        rmap_svg_close(svg);
    put(svg, "</svg>\n");
    put_head(svg);
    if (svg->status != RMAP_OK)
        return rmap_error_set(err, svg->status, "out of memory for a picture");
    *text_ret = svg->text;
    *nbytes_ret = svg->nbytes;
    return RMAP_OK;
}
