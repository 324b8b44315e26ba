/* SPDX-License-Identifier: MIT
 *
 * A picture of the surroundings from a stranger, in Radiance's format: it is refused with a
 * sentence, or its pixels are numbers of light.
 */
#include "target.h"

const unsigned rmap_fuzz_rounds = 300000;

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    if (nbytes > 65536 || (nbytes > 0 && data[0] == 0x76)) /* target_exr.c */
        return 0;
    rmap_fuzz_picture(data, nbytes);
    return 0;
}

size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    static const char *const seed[] = {
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\nCOLORCORR=1 2 1\n\n-Y 2 +X "
        "2\nabc\x80"
        "abc\x81"
        "abc\x82"
        "abc\x83",
        "#?RGBE\n\n+X 1 -Y 4\nabc\x80\x01\x01\x01\x02zzz\x82",
        "#?RADIANCE\n\n-Y 1 +X 260\n\x02\x02\x01\x04\xff"
        "a\xff"
        "a\x86"
        "a\xff"
        "a\xff"
        "a\x86"
        "a\xff"
        "a\xff"
        "a\x86"
        "a\xff\x80\xff\x80\x86\x80",
    };
    return rmap_fuzz_seed_text(seed, sizeof seed / sizeof *seed, k, to, cap);
}
