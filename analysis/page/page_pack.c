/* SPDX-License-Identifier: MIT
 *
 * Arrays of numbers inside JSON: an object {"t": type, "d": little-endian bytes in base64} with
 * the types f32, f64, u8, u16, i32, u64; integers may say "o", which is to be added to each of
 * them.
 */
#include "analysis/page/page_pack.h"

#include <string.h>

#include "base/alloc.h"
#include "io/file/base64.h"

/* As a JSON string. */
static json_t *base64(const uint8_t *byte, size_t n)
{
    const size_t length = (n + 2) / 3 * 4;
    char *text = rmap_alloc(length + 1, 1);
    if (!text)
        return NULL;
    for (size_t i = 0; i < n; i += 3)
        rmap_base64_four(byte + i, n - i, text + i / 3 * 4);
    json_t *string = json_stringn_nocheck(text, length);
    rmap_free(text);
    return string;
}

/* Values of so many bytes each, from the words of a machine of any byte order. */
static json_t *packed(const char *type, const uint64_t *word, size_t n, size_t width, int offset)
{
    uint8_t *byte = rmap_alloc(n * width + 1, 1);
    if (!byte)
        return NULL;
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < width; k++)
            byte[i * width + k] = (uint8_t)(word[i] >> (8 * k));
    json_t *data = base64(byte, n * width);
    rmap_free(byte);
    if (!data)
        return NULL;
    return offset ? json_pack("{s:s, s:i, s:o}", "t", type, "o", offset, "d", data)
                  : json_pack("{s:s, s:o}", "t", type, "d", data);
}

json_t *rmap_page_floats(const float *value, size_t n)
{
    uint64_t *word = rmap_alloc(n + 1, sizeof *word);
    for (size_t i = 0; word && i < n; i++) {
        uint32_t bits;
        memcpy(&bits, &value[i], sizeof bits);
        word[i] = bits;
    }
    json_t *json = word ? packed("f32", word, n, 4, 0) : NULL;
    rmap_free(word);
    return json;
}

json_t *rmap_page_doubles(const double *value, size_t n)
{
    uint64_t *word = rmap_alloc(n + 1, sizeof *word);
    if (word && n > 0)
        memcpy(word, value, n * sizeof *word);
    json_t *json = word ? packed("f64", word, n, 8, 0) : NULL;
    rmap_free(word);
    return json;
}

json_t *rmap_page_words(const uint64_t *value, size_t n)
{
    return packed("u64", value, n, 8, 0);
}

json_t *rmap_page_bytes(const uint8_t *value, size_t n)
{
    json_t *data = base64(value, n);
    return data ? json_pack("{s:s, s:o}", "t", "u8", "d", data) : NULL;
}

json_t *rmap_page_shorts(const uint16_t *value, size_t n)
{
    uint64_t *word = rmap_alloc(n + 1, sizeof *word);
    for (size_t i = 0; word && i < n; i++)
        word[i] = value[i];
    json_t *json = word ? packed("u16", word, n, 2, 0) : NULL;
    rmap_free(word);
    return json;
}

json_t *rmap_page_integers(const int32_t *value, size_t n)
{
    uint64_t *word = rmap_alloc(n + 1, sizeof *word);
    int32_t least = 0, most = 0;
    for (size_t i = 0; i < n; i++) {
        least = value[i] < least ? value[i] : least;
        most = value[i] > most ? value[i] : most;
    }
    /* Most columns have -1 for "none" and small numbers else. */
    int offset = least < 0 && least >= -128 && most < UINT16_MAX - 128 ? least : 0;
    for (size_t i = 0; word && i < n; i++)
        word[i] = (uint32_t)(value[i] - offset);
    json_t *json = NULL;
    if (word && least >= offset && most - offset <= UINT8_MAX)
        json = packed("u8", word, n, 1, offset);
    else if (word && least >= offset && most - offset <= UINT16_MAX)
        json = packed("u16", word, n, 2, offset);
    else if (word)
        json = packed("i32", word, n, 4, 0);
    rmap_free(word);
    return json;
}

json_t *rmap_page_string(const char *text)
{
    if (!text)
        return json_null();
    json_t *string = json_string(text);
    if (string)
        return string;
    char *plain = rmap_strdup(text); /* not UTF-8: what of it is ASCII */
    size_t n = 0;
    for (size_t i = 0; plain && plain[i]; i++)
        if ((unsigned char)plain[i] < 0x80)
            plain[n++] = plain[i];
    if (plain)
        plain[n] = 0;
    string = plain ? json_string(plain) : NULL;
    rmap_free(plain);
    return string;
}

json_t *rmap_page_vector(struct rmap_vec3 v)
{
    return json_pack("[f, f, f]", v.x, v.y, v.z);
}
