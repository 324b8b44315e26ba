/* SPDX-License-Identifier: MIT
 *
 * Bytes as text (RFC 4648, section 4).
 */
#include "io/file/base64.h"

#include <string.h>

static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

void rmap_base64_four(const uint8_t *bytes, size_t n, char four[4])
{
    const uint32_t word = (uint32_t)bytes[0] << 16 | (n > 1 ? (uint32_t)bytes[1] << 8 : 0) |
                          (n > 2 ? (uint32_t)bytes[2] : 0);
    four[0] = digit[word >> 18];
    four[1] = digit[word >> 12 & 63];
    four[2] = n > 1 ? digit[word >> 6 & 63] : '=';
    four[3] = n > 2 ? digit[word & 63] : '=';
}

bool rmap_base64_bytes(const char *text, size_t n, uint8_t *bytes, size_t *nbytes_ret)
{
    size_t nbytes = 0;
    uint32_t word = 0;
    if (n % 4 != 0)
        return false;
    for (int i = 0; i < 2 && n > 0 && text[n - 1] == '='; i++)
        n--;
    for (size_t i = 0; i < n; i++) {
        const char *found = text[i] ? strchr(digit, text[i]) : NULL;
        if (!found)
            return false;
        word = word << 6 | (uint32_t)(found - digit);
        if (i % 4 != 0)
            bytes[nbytes++] = (uint8_t)(word >> (6 - 2 * (i % 4)));
    }
    *nbytes_ret = nbytes;
    return true;
}
