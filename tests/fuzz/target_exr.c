/* SPDX-License-Identifier: MIT
 *
 * An OpenEXR picture of the surroundings from a stranger: it is refused with a sentence, or its
 * pixels are numbers of light.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "io/export/exr.h"
#include "target.h"

const unsigned rmap_fuzz_rounds = 3000;

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    if (nbytes > 65536)
        return 0;
    rmap_fuzz_picture(data, nbytes);
    return 0;
}

/* A header attribute: name, type, its bytes. */
static uint8_t *put(uint8_t *at, const char *name, const char *type, const void *value, uint32_t n)
{
    const char *const text[] = {name, type};
    for (int k = 0; k < 2; k++) {
        memcpy(at, text[k], strlen(text[k]) + 1);
        at += strlen(text[k]) + 1;
    }
    memcpy(at, &n, sizeof n);
    memcpy(at + sizeof n, value, n);
    return at + sizeof n + n;
}

/* Two rows of two grey half floats, as they are. */
static size_t seed_grey(uint8_t *to)
{
    static const uint8_t head[] = {0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0};
    static const uint8_t channels[] = {'Y', 0, 1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0};
    static const int32_t box[4] = {0, 0, 1, 1};
    static const float one = 1, nought[2] = {0, 0};
    static const uint16_t half[2] = {0x3c00, 0x4000};
    uint8_t *at = to + sizeof head, zero = 0;
    memcpy(to, head, sizeof head);
    at = put(at, "channels", "chlist", channels, sizeof channels);
    at = put(at, "compression", "compression", &zero, 1);
    at = put(at, "dataWindow", "box2i", box, sizeof box);
    at = put(at, "displayWindow", "box2i", box, sizeof box);
    at = put(at, "lineOrder", "lineOrder", &zero, 1);
    at = put(at, "pixelAspectRatio", "float", &one, sizeof one);
    at = put(at, "screenWindowCenter", "v2f", nought, sizeof nought);
    at = put(at, "screenWindowWidth", "float", &one, sizeof one);
    *at++ = 0;
    uint64_t offset = (uint64_t)(at - to) + 16;
    for (int row = 0; row < 2; row++, offset += 12, at += 8)
        memcpy(at, &offset, sizeof offset);
    for (int32_t row = 0; row < 2; row++, at += 12) {
        const int32_t n = 4;
        memcpy(at, &row, 4);
        memcpy(at + 4, &n, 4);
        memcpy(at + 8, half, 4);
    }
    return (size_t)(at - to);
}

/* What this program writes: packed, three channels. */
static size_t seed_written(uint8_t *to, size_t cap)
{
    static const float rgb[3 * 6] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 0.5F, 0, 1e4F, 1, 1, 1, 2, 2, 2};
    const struct rmap_exr image = {.size = {3, 2}, .rgb = rgb, .comment = "seed"};
    char path[] = "/tmp/raymap-fuzz-XXXXXX";
    struct rmap_error err = {0};
    const int file = mkstemp(path);
    rmap_fuzz_demand(file >= 0 && rmap_exr_write(&image, path, &err) == RMAP_OK, "a seed");
    (void)close(file);
    FILE *in = fopen(path, "rb");
    rmap_fuzz_demand(in != NULL, "a seed");
    const size_t n = fread(to, 1, cap, in);
    (void)fclose(in);
    (void)unlink(path);
    return n;
}

size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    return k > 1 || cap < 1024 ? 0 : k == 0 ? seed_grey(to) : seed_written(to, cap);
}
