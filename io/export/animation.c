/* SPDX-License-Identifier: MIT
 *
 * Pictures of one size one after the other, as animated PNG. Each is made as a PNG of its own; its
 * image data go over under another name.
 */
#include "io/export/animation.h"

#include <stdio.h>
#include <string.h>

#include <zlib.h>

#include "base/alloc.h"
#include "io/export/raster.h"
#include "io/file/whole_file.h"

enum { HEAD = 8 /* signature */, FRAME = 12 /* of a chunk: length, name, checksum */ };

struct rmap_animation {
    struct rmap_whole_file whole;
    uint32_t n_frame, n_added, sequence;
    uint16_t per_second;
    uint8_t size[8]; /* of the first picture, width and height as in IHDR */
};

static uint32_t get_u32(const uint8_t *from)
{
    return (uint32_t)from[0] << 24 | (uint32_t)from[1] << 16 | (uint32_t)from[2] << 8 | from[3];
}

static void set_u32(uint8_t *to, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        to[i] = (uint8_t)(value >> (24 - 8 * i));
}

/* first: bytes before the data, or none. Errors are found when the file is finished. */
static void put_chunk(struct rmap_animation *self, const char name[5], const uint8_t *first,
                      uint32_t n_first, const uint8_t *data, uint32_t n_data)
{
    uint8_t word[4];
    uLong sum = crc32(0, (const Bytef *)name, 4);
    set_u32(word, n_first + n_data);
    (void)fwrite(word, 1, 4, self->whole.file);
    (void)fwrite(name, 1, 4, self->whole.file);
    if (n_first > 0) {
        (void)fwrite(first, 1, n_first, self->whole.file);
        sum = crc32(sum, first, n_first);
    }
    if (n_data > 0) {
        (void)fwrite(data, 1, n_data, self->whole.file);
        sum = crc32(sum, data, n_data);
    }
    set_u32(word, (uint32_t)sum);
    (void)fwrite(word, 1, 4, self->whole.file);
}

enum rmap_status rmap_animation_create(const char *path, uint32_t n_frame, uint16_t per_second,
                                       struct rmap_animation **animation_ret,
                                       struct rmap_error *err)
{
    struct rmap_animation *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for an animation");
    self->n_frame = n_frame;
    self->per_second = per_second;
    const enum rmap_status st = rmap_whole_file_open(&self->whole, path, err);
    if (st == RMAP_OK)
        *animation_ret = self;
    else
        rmap_animation_destroy(self);
    return st;
}

/* The picture is the whole canvas, in place of the one before. */
static void put_frame_control(struct rmap_animation *self)
{
    uint8_t control[26] = {0}; /* number, width, height, place, delay as 1 / per_second, ways */
    set_u32(control, self->sequence++);
    memcpy(control + 4, self->size, sizeof self->size);
    control[21] = 1;
    control[22] = (uint8_t)(self->per_second >> 8);
    control[23] = (uint8_t)self->per_second;
    put_chunk(self, "fcTL", control, sizeof control, NULL, 0);
}

static void put_image_data(struct rmap_animation *self, const uint8_t *data, uint32_t n)
{
    uint8_t number[4];
    if (self->n_added == 0) {
        put_chunk(self, "IDAT", NULL, 0, data, n);
        return;
    }
    set_u32(number, self->sequence++);
    put_chunk(self, "fdAT", number, sizeof number, data, n);
}

static enum rmap_status put_picture(struct rmap_animation *self, const uint8_t *png, size_t n,
                                    struct rmap_error *err)
{
    if (self->n_added == 0) {
        uint8_t control[8] = {0}; /* pictures, and how often they are played: for ever */
        set_u32(control, self->n_frame);
        (void)fwrite(png, 1, HEAD, self->whole.file);
        put_chunk(self, "IHDR", NULL, 0, png + HEAD + 8, 13);
        memcpy(self->size, png + HEAD + 8, sizeof self->size);
        put_chunk(self, "acTL", control, sizeof control, NULL, 0);
    }
    if (memcmp(self->size, png + HEAD + 8, sizeof self->size) != 0)
        return rmap_error_set(err, RMAP_INTERNAL, "pictures of an animation differ in size");
    put_frame_control(self);
    for (size_t at = HEAD; at + FRAME <= n; at += FRAME + get_u32(png + at))
        if (memcmp(png + at + 4, "IDAT", 4) == 0)
            put_image_data(self, png + at + 8, get_u32(png + at));
    self->n_added++;
    return RMAP_OK;
}

enum rmap_status rmap_animation_add(struct rmap_animation *self, struct rmap_svg *svg, double scale,
                                    struct rmap_error *err)
{
    uint8_t *png = NULL;
    size_t nbytes = 0;
    enum rmap_status st = rmap_picture_png(svg, scale, &png, &nbytes, err);
    if (st == RMAP_OK)
        st = put_picture(self, png, nbytes, err);
    rmap_free(png);
    return st;
}

enum rmap_status rmap_animation_finish(struct rmap_animation *self, struct rmap_error *err)
{
    put_chunk(self, "IEND", NULL, 0, NULL, 0);
    return rmap_whole_file_finish(&self->whole, err);
}

void rmap_animation_destroy(struct rmap_animation *self)
{
    if (!self)
        return;
    rmap_whole_file_fini(&self->whole);
    rmap_free(self);
}
