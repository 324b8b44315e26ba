/* SPDX-License-Identifier: MIT
 *
 * The furniture of a figure: ticks at round numbers, a frame with labelled axes, a colour bar,
 * captions that fit.
 */
#include "analysis/table/figure_axes.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "io/export/raster.h"

static const char ink[] = "#222222";

double rmap_round_below(double longest)
{
    double power = pow(10.0, floor(log10(longest) + 1e-9));
    double lead = longest / power * (1.0 + 1e-9);
    return power * (lead >= 5.0 ? 5.0 : lead >= 2.0 ? 2.0 : 1.0);
}

/* Numbers of everyday size stay as they are; others lose a power of 1000. */
static int common_exponent(double largest)
{
    if (!(largest > 0.0) || (largest >= 1e-2 && largest < 1e5))
        return 0;
    return 3 * (int)floor(log10(largest) / 3.0 + 1e-9);
}

void rmap_ticks_linear(double low, double high, int most, struct rmap_ticks *ticks)
{
    *ticks = (struct rmap_ticks){0};
    double span = high - low;
    if (!(span > 0.0) || !isfinite(span))
        return;
    /* The smallest round step that leaves at most `most` ticks. */
    double power = pow(10.0, floor(log10(span / most))), step = power;
    static const double lead[] = {1.0, 2.0, 5.0, 10.0, 20.0, 50.0};
    for (int i = 0; i < 6; i++) {
        const double n =
            floor(high / (power * lead[i]) + 1e-9) - ceil(low / (power * lead[i]) - 1e-9) + 1.0;
        if (i > 0 && n < 2.0) /* one number alone tells no scale */
            break;
        step = power * lead[i];
        if (n <= fmin(most, RMAP_TICK_MAX))
            break;
    }
    for (double k = ceil(low / step - 1e-9); k <= floor(high / step + 1e-9); k++)
        if (ticks->n < RMAP_TICK_MAX)
            ticks->value[ticks->n++] = k * step;
    ticks->exponent = common_exponent(fmax(fabs(low), fabs(high)));
    double shown = step / pow(10.0, ticks->exponent);
    ticks->decimals = (int)fmin(fmax(ceil(-log10(shown) - 1e-9), 0.0), 9.0);
}

void rmap_ticks_degrees(double low, double high, int most, struct rmap_ticks *ticks)
{
    static const double step[] = {5.0, 10.0, 15.0, 30.0, 45.0, 90.0};
    *ticks = (struct rmap_ticks){0};
    int i = 0;
    while (i < 5 && (high - low) / step[i] + 1.0 > fmin(most, RMAP_TICK_MAX))
        i++;
    for (double k = ceil(low / step[i]); k <= floor(high / step[i]); k++)
        if (ticks->n < RMAP_TICK_MAX)
            ticks->value[ticks->n++] = k * step[i];
}

/* Ticks of an axis: angles have steps of their own. */
static void axis_ticks(const double range[2], bool powers, const char *unit, double room,
                       struct rmap_ticks *ticks)
{
    const int most = (int)fmax(room, 2.0);
    const double low = fmin(range[0], range[1]), high = fmax(range[0], range[1]);
    if (powers)
        rmap_ticks_powers(pow(10.0, low), pow(10.0, high), most, ticks);
    else if (strcmp(unit, "deg") == 0 && high - low > 25.0)
        rmap_ticks_degrees(low, high, most, ticks);
    else
        rmap_ticks_linear(low, high, most, ticks);
}

void rmap_ticks_decades(double low, double high, struct rmap_ticks *ticks)
{
    *ticks = (struct rmap_ticks){.decimals = -1};
    int first = (int)ceil(log10(low) - 1e-9), last = (int)floor(log10(high) + 1e-9);
    int step = (last - first) / 12 + 1;
    for (int k = first; k <= last && ticks->n < RMAP_TICK_MAX; k += step)
        ticks->value[ticks->n++] = pow(10.0, k);
}

void rmap_ticks_powers(double low, double high, int most, struct rmap_ticks *ticks)
{
    static const double step[] = {1.0, 2.0, 5.0};
    rmap_ticks_decades(low, high, ticks);
    if (ticks->n >= 3)
        return;
    *ticks = (struct rmap_ticks){.decimals = -1};
    for (int k = (int)floor(log10(low)); k <= (int)floor(log10(high) + 1e-9); k++)
        for (size_t i = 0; i < 3 && ticks->n < RMAP_TICK_MAX; i++) {
            double value = step[i] * pow(10.0, k);
            if (value >= low * (1.0 - 1e-9) && value <= high * (1.0 + 1e-9))
                ticks->value[ticks->n++] = value;
        }
    if (ticks->n < 3)
        rmap_ticks_linear(low, high, most, ticks);
}

static void superscript(int exponent, char *text, size_t size)
{
    static const char *const digit[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    char plain[16];
    (void)snprintf(plain, sizeof plain, "%d", exponent);
    text[0] = 0;
    for (const char *p = plain; *p; p++) {
        size_t len = strlen(text);
        (void)snprintf(text + len, size - len, "%s", *p == '-' ? "⁻" : digit[*p - '0']);
    }
}

static void tick_label(const struct rmap_ticks *ticks, int i, char *text, size_t size)
{
    if (ticks->decimals < 0) { /* powers of ten, or 2 or 5 times one */
        char power[64];
        int exponent = (int)floor(log10(ticks->value[i]) + 1e-9);
        int times = (int)lround(ticks->value[i] / pow(10.0, exponent));
        superscript(exponent, power, sizeof power);
        if (exponent >= -2 && exponent <= 3)
            (void)snprintf(text, size, "%g", ticks->value[i]);
        else if (times == 1)
            (void)snprintf(text, size, "10%s", power);
        else
            (void)snprintf(text, size, "%d·10%s", times, power);
        return;
    }
    double value = ticks->value[i] / pow(10.0, ticks->exponent);
    (void)snprintf(text, size, "%.*f", ticks->decimals, fabs(value) < 1e-12 ? 0.0 : value);
    if (text[0] == '-') { /* a minus sign, not a hyphen */
        char digits[64];
        (void)snprintf(digits, sizeof digits, "%s", text + 1);
        (void)snprintf(text, size, "−%s", digits);
    }
}

struct rmap_unit_text rmap_unit_text(const char *unit)
{
    struct rmap_unit_text shown = {""};
    for (size_t len = 0; *unit && len + 4 < sizeof shown.text; unit++, len = strlen(shown.text)) {
        const bool squared = unit[0] == '2' && len > 0 && shown.text[len - 1] == 'm';
        (void)snprintf(shown.text + len, sizeof shown.text - len, squared ? "²" : "%c", unit[0]);
    }
    return shown;
}

/* "x, mm" or "irradiance, 10⁶ W/m²". */
static void axis_label(const char *label, const char *unit, const struct rmap_ticks *ticks,
                       char *text, size_t size)
{
    char power[64];
    const struct rmap_unit_text written = rmap_unit_text(unit);
    const char *shown = written.text;
    superscript(ticks->exponent, power, sizeof power);
    if (ticks->exponent != 0 && ticks->decimals >= 0)
        (void)snprintf(text, size, "%s, 10%s %s", label, power, shown);
    else
        (void)snprintf(text, size, "%s%s%s", label, *shown ? ", " : "", shown);
}

double rmap_axes_x(const struct rmap_axes *axes, double value)
{
    return axes->x +
           axes->width * (value - axes->x_range[0]) / (axes->x_range[1] - axes->x_range[0]);
}

double rmap_axes_y(const struct rmap_axes *axes, double value)
{
    return axes->y + axes->height *
                         (1.0 - (value - axes->y_range[0]) / (axes->y_range[1] - axes->y_range[0]));
}

static void draw_x_axis(struct rmap_svg *svg, const struct rmap_axes *axes)
{
    struct rmap_ticks ticks;
    char text[128];
    double bottom = axes->y + axes->height;
    axis_ticks(axes->x_range, axes->x_powers, axes->x_unit, axes->width / 70.0, &ticks);
    for (int i = 0; i < ticks.n; i++) {
        double at = axes->x_powers ? log10(ticks.value[i]) : ticks.value[i];
        double x = rmap_axes_x(axes, at);
        rmap_svg_line(svg, x, bottom, x, bottom + 5, &(struct rmap_svg_style){.stroke = ink});
        tick_label(&ticks, i, text, sizeof text);
        rmap_svg_string(svg,
                        &(struct rmap_svg_text){.x = x,
                                                .y = bottom + 19,
                                                .size = RMAP_TICK_SIZE,
                                                .anchor = RMAP_SVG_MIDDLE,
                                                .fill = ink},
                        text);
    }
    axis_label(axes->x_label, axes->x_unit, &ticks, text, sizeof text);
    rmap_svg_string(svg,
                    &(struct rmap_svg_text){.x = axes->x + 0.5 * axes->width,
                                            .y = bottom + 41,
                                            .size = RMAP_LABEL_SIZE,
                                            .anchor = RMAP_SVG_MIDDLE,
                                            .fill = ink},
                    text);
}

static void draw_y_axis(struct rmap_svg *svg, const struct rmap_axes *axes)
{
    struct rmap_ticks ticks;
    char text[128];
    double widest = 0.0;
    axis_ticks(axes->y_range, axes->y_powers, axes->y_unit, axes->height / 40.0, &ticks);
    for (int i = 0; i < ticks.n; i++) {
        double at = axes->y_powers ? log10(ticks.value[i]) : ticks.value[i];
        double y = rmap_axes_y(axes, at);
        rmap_svg_line(svg, axes->x - 5, y, axes->x, y, &(struct rmap_svg_style){.stroke = ink});
        tick_label(&ticks, i, text, sizeof text);
        widest = fmax(widest, rmap_svg_string_width(text, RMAP_TICK_SIZE));
        rmap_svg_string(svg,
                        &(struct rmap_svg_text){.x = axes->x - 8,
                                                .y = y + 0.35 * RMAP_TICK_SIZE,
                                                .size = RMAP_TICK_SIZE,
                                                .anchor = RMAP_SVG_END,
                                                .fill = ink},
                        text);
    }
    axis_label(axes->y_label, axes->y_unit, &ticks, text, sizeof text);
    rmap_svg_string(svg,
                    &(struct rmap_svg_text){.x = fmax(axes->x - widest - 18, RMAP_LABEL_SIZE),
                                            .y = axes->y + 0.5 * axes->height,
                                            .size = RMAP_LABEL_SIZE,
                                            .anchor = RMAP_SVG_MIDDLE,
                                            .rotate_deg = -90,
                                            .fill = ink},
                    text);
}

void rmap_axes_draw(struct rmap_svg *svg, const struct rmap_axes *axes)
{
    rmap_svg_rect(svg, axes->x, axes->y, axes->width, axes->height,
                  &(struct rmap_svg_style){.stroke = ink});
    draw_x_axis(svg, axes);
    draw_y_axis(svg, axes);
}

double rmap_colour_bar_place(const struct rmap_colour_bar *bar, double value)
{
    if (bar->logarithmic)
        return value > 0.0 ? log(value / bar->range[0]) / log(bar->range[1] / bar->range[0]) : 0.0;
    return (value - bar->range[0]) / (bar->range[1] - bar->range[0]);
}

static void draw_bar_ticks(struct rmap_svg *svg, const struct rmap_colour_bar *bar)
{
    struct rmap_ticks ticks;
    char text[128];
    double right = bar->x + bar->width, widest = 0.0;
    if (bar->logarithmic)
        rmap_ticks_decades(bar->range[0], bar->range[1], &ticks);
    else
        rmap_ticks_linear(bar->range[0], bar->range[1], (int)fmax(bar->height / 45.0, 2.0), &ticks);
    for (int i = 0; i < ticks.n; i++) {
        double y = bar->y + bar->height * (1.0 - rmap_colour_bar_place(bar, ticks.value[i]));
        rmap_svg_line(svg, right, y, right + 5, y, &(struct rmap_svg_style){.stroke = ink});
        tick_label(&ticks, i, text, sizeof text);
        widest = fmax(widest, rmap_svg_string_width(text, RMAP_TICK_SIZE));
        rmap_svg_string(svg,
                        &(struct rmap_svg_text){.x = right + 8,
                                                .y = y + 0.35 * RMAP_TICK_SIZE,
                                                .size = RMAP_TICK_SIZE,
                                                .fill = ink},
                        text);
    }
    axis_label(bar->label, bar->unit, &ticks, text, sizeof text);
    rmap_svg_string(svg,
                    &(struct rmap_svg_text){.x = right + widest + 26,
                                            .y = bar->y + 0.5 * bar->height,
                                            .size = RMAP_LABEL_SIZE,
                                            .anchor = RMAP_SVG_MIDDLE,
                                            .rotate_deg = -90,
                                            .fill = ink},
                    text);
}

enum rmap_status rmap_colour_bar_draw(struct rmap_svg *svg, const struct rmap_colour_bar *bar,
                                      const struct rmap_colour_map *map, struct rmap_error *err)
{
    uint8_t column[RMAP_COLOUR_MAP_STEPS][3], *png = NULL;
    size_t nbytes = 0;
    for (int i = 0; i < RMAP_COLOUR_MAP_STEPS; i++)
        memcpy(column[i], map->rgb[RMAP_COLOUR_MAP_STEPS - 1 - i], 3);
    enum rmap_status st =
        rmap_png_encode(&column[0][0], 1, RMAP_COLOUR_MAP_STEPS, &png, &nbytes, err);
    if (st != RMAP_OK)
        return st;
    rmap_svg_image(svg, bar->x, bar->y, bar->width, bar->height, png, nbytes);
    rmap_free(png);
    rmap_svg_rect(svg, bar->x, bar->y, bar->width, bar->height,
                  &(struct rmap_svg_style){.stroke = ink});
    draw_bar_ticks(svg, bar);
    return RMAP_OK;
}

void rmap_caption(struct rmap_svg *svg, const struct rmap_svg_text *text, double width,
                  const char *string)
{
    char line[512];
    (void)snprintf(line, sizeof line - 8, "%s", string);
    size_t len = strlen(line);
    bool cut = strlen(string) > len;
    while (len > 0 && (rmap_svg_string_width(line, text->size) > width ||
                       (cut && ((unsigned char)line[len - 1] & 0x80)))) {
        line[--len] = 0;
        cut = true;
    }
    if (cut)
        (void)snprintf(line + len, sizeof line - len, "…");
    rmap_svg_string(svg, text, line);
}

size_t rmap_line_nbytes(const char *string, double size, double width)
{
    char part[512];
    size_t word = 0, best = 0;
    for (size_t len = 1; len < sizeof part && string[len - 1]; len++) {
        if (((unsigned char)string[len] & 0xC0) == 0x80) /* within a character */
            continue;
        (void)snprintf(part, sizeof part, "%.*s", (int)len, string);
        if (rmap_svg_string_width(part, size) > width && best > 0)
            return word > 0 ? word : best;
        best = len;
        if (string[len] == ' ' || string[len] == 0)
            word = len;
    }
    return word > 0 ? word : best;
}

/* Rows that a caption takes at most, and their distance; the first text is the title. */
enum { CAPTION_ROWS = 6, CAPTION_ROW = 18, TITLE_ROW = 22, TITLE_BASE = 30, CAPTION_BASE = 50 };

/* Places or, without svg, counts the rows of a caption, from text->y on. */
static int caption_rows(struct rmap_svg *svg, struct rmap_svg_text text, double width,
                        const char *string)
{
    int n = 0;
    do {
        char row[512];
        const size_t len =
            ++n < CAPTION_ROWS ? rmap_line_nbytes(string, text.size, width) : strlen(string);
        (void)snprintf(row, sizeof row, "%.*s", (int)len, string);
        if (svg)
            rmap_caption(svg, &text, width, row);
        text.y += text.bold ? TITLE_ROW : CAPTION_ROW;
        string += len;
        string += *string == ' ';
    } while (*string);
    return n;
}

void rmap_captions(struct rmap_svg *svg, double x, const char *const string[], size_t n)
{
    const double width = rmap_svg_width(svg) - 2.0 * x;
    const struct rmap_svg_text title = {.x = x, .size = RMAP_TITLE_SIZE, .bold = 1},
                               line = {.x = x, .size = RMAP_TICK_SIZE, .fill = "#444444"};
    double rise = 0.0;
    for (size_t k = 0; k < n; k++)
        rise += (caption_rows(NULL, k ? line : title, width, string[k]) - 1) *
                (k ? CAPTION_ROW : TITLE_ROW);
    if (rise > 0.0)
        rmap_svg_raise(svg, rise);
    for (size_t k = 0; k < n; k++) {
        struct rmap_svg_text text = k ? line : title;
        text.y = (k ? CAPTION_BASE + CAPTION_ROW * (double)(k - 1) : TITLE_BASE) - rise;
        rise -= (caption_rows(svg, text, width, string[k]) - 1) * (k ? CAPTION_ROW : TITLE_ROW);
    }
}
