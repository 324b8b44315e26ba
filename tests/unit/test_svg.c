/* SPDX-License-Identifier: MIT
 *
 * Pictures: the same calls give the same bytes, text is well-formed XML whatever it holds, and a
 * rasterised image has the pixels that were put in, sharp.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>
#include <png.h>

#include "base/alloc.h"
#include "io/export/raster.h"

static void draw(struct rmap_svg **svg)
{
    assert_int_equal(rmap_svg_create(200, 100, "a <title> & \"more\"", svg, NULL), RMAP_OK);
    const double path[][2] = {{(double)NAN, 0}, {1, 2.5}, {3.25, 4}, {(double)NAN, 0}, {5, 6}};
    rmap_svg_path(*svg, path, 5, &(struct rmap_svg_style){.stroke = "#ff0000", .width = 2});
    rmap_svg_path(*svg, path, 1, &(struct rmap_svg_style){.stroke = "#00ff00"});
    rmap_svg_string(*svg, &(struct rmap_svg_text){.x = 10, .y = 20, .size = 12},
                    "5 µm < \x01\xff\xed\xa0\x80 \xf0\x9f\x98\x80");
}

static void bytes_are_the_same_and_text_is_escaped(void **state)
{
    (void)state;
    const char *text[2];
    size_t n[2];
    struct rmap_svg *svg[2];
    for (int i = 0; i < 2; i++) {
        draw(&svg[i]);
        assert_int_equal(rmap_svg_finish(svg[i], &text[i], &n[i], NULL), RMAP_OK);
    }
    assert_int_equal(n[0], n[1]);
    assert_memory_equal(text[0], text[1], n[0]);
    char *copy = rmap_alloc(n[0] + 1, 1);
    memcpy(copy, text[0], n[0]);
    assert_non_null(strstr(copy, "<title>a &lt;title&gt; &amp; &quot;more&quot;</title>"));
    assert_non_null(strstr(copy, "d=\"M1 2.5L3.25 4M5 6\""));
    assert_null(strstr(copy, "#00ff00"));
    assert_non_null(strstr(copy, ">5 µm &lt; ????? \xf0\x9f\x98\x80</text>"));
    assert_non_null(strstr(copy, "</svg>\n"));
    rmap_free(copy);
    rmap_svg_destroy(svg[0]);
    rmap_svg_destroy(svg[1]);
}

/* Stripes one pixel wide, at output resolution, come through untouched. */
static void images_stay_sharp(void **state)
{
    (void)state;
    enum { SIDE = 200 };
    static uint8_t put[SIDE][SIDE][3], got[SIDE][SIDE][3];
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++)
            memcpy(put[y][x], ((uint8_t[3]){(uint8_t)(x % 2 * 255), (uint8_t)y, 40}), 3);
    uint8_t *png = NULL;
    size_t n = 0;
    struct rmap_svg *svg = NULL;
    assert_int_equal(rmap_png_encode(&put[0][0][0], SIDE, SIDE, &png, &n, NULL), RMAP_OK);
    assert_int_equal(rmap_svg_create(SIDE / 2 + 10, SIDE / 2 + 10, "t", &svg, NULL), RMAP_OK);
    rmap_svg_image(svg, 5, 5, SIDE / 2, SIDE / 2, png, n);
    assert_int_equal(rmap_picture_write(svg, "sharp.png", 2.0, NULL), RMAP_OK);
    rmap_svg_destroy(svg);
    rmap_free(png);

    png_image image = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&image, "sharp.png"));
    image.format = PNG_FORMAT_RGB;
    assert_int_equal(image.width, SIDE + 20);
    assert_int_equal(image.height, SIDE + 20);
    static uint8_t pixel[SIDE + 20][SIDE + 20][3];
    assert_true(png_image_finish_read(&image, NULL, pixel, 0, NULL));
    for (int y = 0; y < SIDE; y++)
        memcpy(got[y], pixel[y + 10][10], sizeof got[y]);
    assert_memory_equal(got, put, sizeof put);
    assert_memory_equal(pixel[0][0], ((uint8_t[3]){255, 255, 255}), 3);
    remove("sharp.png");
}

static void bad_names_are_refused(void **state)
{
    (void)state;
    struct rmap_svg *svg;
    struct rmap_error err = {0};
    draw(&svg);
    assert_int_equal(rmap_picture_write(svg, "x.jpeg", 1.0, &err), RMAP_USAGE);
    assert_non_null(strstr(err.text, "x.jpeg"));
    assert_int_equal(rmap_picture_write(svg, "no/such/folder/x.svg", 1.0, &err), RMAP_SYSTEM);
    rmap_svg_destroy(svg);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void short_memory_is_told(void **state)
{
    (void)state;
    struct rmap_svg *svg = NULL;
    const char *text;
    size_t n;
    rmap_alloc_fail_at(1);
    assert_int_equal(rmap_svg_create(10, 10, "t", &svg, NULL), RMAP_SYSTEM);
    rmap_alloc_fail_at(2);
    assert_int_equal(rmap_svg_create(10, 10, "t", &svg, NULL), RMAP_OK);
    assert_int_equal(rmap_svg_finish(svg, &text, &n, NULL), RMAP_SYSTEM);
    rmap_alloc_fail_at(0);
    rmap_svg_destroy(svg);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_the_same_and_text_is_escaped),
        cmocka_unit_test(images_stay_sharp),
        cmocka_unit_test(bad_names_are_refused),
        cmocka_unit_test(short_memory_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
