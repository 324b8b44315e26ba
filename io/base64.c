/* SPDX-License-Identifier: MIT */
#include "io/base64.h"

void rmap_base64_four(const uint8_t *bytes, size_t n, char four[4])
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const uint32_t word = (uint32_t)bytes[0] << 16 | (n > 1 ? (uint32_t)bytes[1] << 8 : 0) |
                          (n > 2 ? (uint32_t)bytes[2] : 0);
    four[0] = digit[word >> 18];
    four[1] = digit[word >> 12 & 63];
    four[2] = n > 1 ? digit[word >> 6 & 63] : '=';
    four[3] = n > 2 ? digit[word & 63] : '=';
}
