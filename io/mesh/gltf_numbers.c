/* SPDX-License-Identifier: MIT
 *
 * glTF 2.0 files (Khronos Group, "glTF 2.0 Specification", 2021): the JSON document and the
 * numbers that its accessors stand for.
 */
#include "io/mesh/gltf_numbers.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "io/file/base64.h"
#include "io/file/input_file.h"
#include "io/file/publish.h"

/* Beyond what the file's bytes are good for: parts that stand in many places, vertices of value 0.
 */
#define FREE_CHARGE     ((size_t)10000000)
#define CHARGE_PER_BYTE 16
#define COUNT_MAX       ((json_int_t)1 << 53)

struct rmap_gltf_buffer {
    uint8_t *own; /* or NULL */
    const uint8_t *bytes;
    size_t nbytes;
};

/* `n` elements, `stride` apart. */
struct place {
    const uint8_t *bytes;
    size_t stride;
};

enum component { I8 = 5120, U8, I16, U16, I32, U32, F32 };
static const size_t component_nbytes[] = {1, 1, 2, 2, 4, 4, 4};

enum rmap_status rmap_gltf_refuse(const struct rmap_gltf *gltf, const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return rmap_error_set(gltf->err, RMAP_INPUT, "%s", text);
}

bool rmap_gltf_count(const json_t *object, const char *key, size_t missing, size_t *count)
{
    const json_t *value = json_object_get(object, key);
    const json_int_t number = json_integer_value(value);
    *count = value ? (size_t)number : missing;
    return !value || (json_is_integer(value) && number >= 0 && number <= COUNT_MAX);
}

/* ---- the file ---- */

static uint32_t word_at(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

/* Of a binary file, its JSON and its first binary chunk. */
static enum rmap_status split(struct rmap_gltf *gltf, const uint8_t **json, size_t *json_nbytes)
{
    enum { HEAD = 12, CHUNK_HEAD = 8, JSON = 0x4e4f534a, BIN = 0x004e4942 };
    const uint8_t *bytes = *json, *chunk = bytes + HEAD;
    size_t left = *json_nbytes;
    if (left < 4 || memcmp(bytes, "glTF", 4) != 0)
        return RMAP_OK;
    if (left < HEAD + CHUNK_HEAD || word_at(bytes + 4) != 2 || word_at(bytes + 8) > left ||
        word_at(chunk + 4) != JSON || word_at(chunk) > left - HEAD - CHUNK_HEAD)
        return rmap_gltf_refuse(gltf, "it is no GLB file of version 2, or cut off");
    *json = chunk + CHUNK_HEAD;
    *json_nbytes = word_at(chunk);
    left -= HEAD + CHUNK_HEAD + *json_nbytes;
    chunk = *json + *json_nbytes;
    if (left < CHUNK_HEAD || word_at(chunk + 4) != BIN)
        return RMAP_OK;
    if (word_at(chunk) > left - CHUNK_HEAD)
        return rmap_gltf_refuse(gltf, "its binary chunk is cut off");
    gltf->body = chunk + CHUNK_HEAD;
    gltf->body_nbytes = word_at(chunk);
    return RMAP_OK;
}

/* Extensions that change nothing of a mesh's form may be there. */
static enum rmap_status check_version(const struct rmap_gltf *gltf)
{
    static const char *const known[] = {"KHR_materials_", "KHR_texture_", "EXT_texture_",
                                        "KHR_lights_", "KHR_mesh_quantization"};
    const json_t *required = json_object_get(gltf->root, "extensionsRequired");
    const char *version =
        json_string_value(json_object_get(json_object_get(gltf->root, "asset"), "version"));
    if (!version || strncmp(version, "2.", 2) != 0)
        return rmap_gltf_refuse(gltf, "it is not glTF 2.0");
    for (size_t i = 0; i < json_array_size(required); i++) {
        const char *name = json_string_value(json_array_get(required, i));
        bool fits = false;
        for (size_t k = 0; name && k < sizeof known / sizeof known[0]; k++)
            fits |= strncmp(name, known[k], strlen(known[k])) == 0;
        if (!fits)
            return rmap_gltf_refuse(gltf, "it needs the extension '%.100s', which is not read",
                                    name ? name : "");
    }
    return RMAP_OK;
}

enum rmap_status rmap_gltf_init(struct rmap_gltf *gltf, const char *path, const uint8_t *bytes,
                                size_t nbytes, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    json_error_t wrong = {0};
    *gltf = (struct rmap_gltf){.path = path, .nbytes = nbytes, .err = err};
    RMAP_TRY(split(gltf, &bytes, &nbytes));
    gltf->root = json_loadb((const char *)bytes, nbytes, JSON_REJECT_DUPLICATES, &wrong);
    if (!gltf->root && json_error_code(&wrong) == json_error_out_of_memory)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu bytes of JSON", nbytes);
    if (!gltf->root)
        return rmap_gltf_refuse(gltf, "line %d: %s (is the file whole?)", wrong.line, wrong.text);
    RMAP_TRY(check_version(gltf));
    gltf->n_buffer = json_array_size(json_object_get(gltf->root, "buffers"));
    gltf->buffer = rmap_alloc(gltf->n_buffer, sizeof *gltf->buffer);
    if (!gltf->buffer)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu buffers", gltf->n_buffer);
out:
    return st;
}

void rmap_gltf_fini(struct rmap_gltf *gltf)
{
    for (size_t i = 0; gltf->buffer && i < gltf->n_buffer; i++)
        rmap_free(gltf->buffer[i].own);
    rmap_free(gltf->buffer);
    json_decref(gltf->root);
    *gltf = (struct rmap_gltf){0};
}

/* ---- buffers ---- */

static enum rmap_status decode(struct rmap_gltf *gltf, const char *uri,
                               struct rmap_gltf_buffer *buffer)
{
    const char *comma = strchr(uri, ',');
    const size_t head = comma ? (size_t)(comma - uri) : 0, len = strlen(uri);
    if (head < 7 || memcmp(comma - 7, ";base64", 7) != 0)
        return rmap_gltf_refuse(gltf, "a buffer's data: URI is not base64");
    buffer->own = rmap_alloc_unset((len - head) / 4 * 3, 1);
    if (!buffer->own)
        return rmap_error_set(gltf->err, RMAP_SYSTEM, "out of memory for a buffer");
    if (!rmap_base64_bytes(comma + 1, len - head - 1, buffer->own, &buffer->nbytes))
        return rmap_gltf_refuse(gltf, "a buffer's data: URI is not base64");
    return RMAP_OK;
}

static int hex_digit(char c)
{
    static const char digit[] = "0123456789abcdef0123456789ABCDEF";
    const char *found = c ? strchr(digit, c) : NULL;
    return found ? (int)(found - digit) % 16 : -1;
}

/* %20 is a blank (RFC 3986, 2.1); what cannot be meant stays as it is. */
static void unescape(char *text)
{
    char *to = text;
    for (const char *from = text; *from; from++) {
        const int high = *from == '%' ? hex_digit(from[1]) : -1;
        const int low = high >= 0 ? hex_digit(from[2]) : -1;
        if (low >= 0 && high + low > 0) {
            *to++ = (char)(16 * high + low);
            from += 2;
        } else {
            *to++ = *from;
        }
    }
    *to = 0;
}

/* Beside the document. */
static enum rmap_status read_file(struct rmap_gltf *gltf, const char *uri,
                                  struct rmap_gltf_buffer *buffer)
{
    const char *slash = strrchr(gltf->path, '/');
    const int folder = slash && uri[0] != '/' ? (int)(slash - gltf->path) + 1 : 0;
    char *path = rmap_path_format("%.*s%s", folder, gltf->path, uri);
    if (!path)
        return rmap_error_set(gltf->err, RMAP_SYSTEM, "out of memory for a name");
    unescape(path + folder);
    gltf->elsewhere = true;
    const size_t most =
        gltf->nbytes < RMAP_MESH_NBYTES_MAX ? RMAP_MESH_NBYTES_MAX - gltf->nbytes : 0;
    const enum rmap_status st =
        rmap_input_file_read(path, most, &buffer->own, &buffer->nbytes, gltf->err);
    if (st == RMAP_INPUT)
        rmap_error_context(gltf->err, "its buffer %.300s", path);
    rmap_free(path);
    return st;
}

static enum rmap_status find_buffer(struct rmap_gltf *gltf, size_t index,
                                    const struct rmap_gltf_buffer **found)
{
    enum rmap_status st = RMAP_OK;
    const json_t *entry = json_array_get(json_object_get(gltf->root, "buffers"), index);
    const json_t *uri = json_object_get(entry, "uri");
    size_t nbytes = 0;
    if (!json_is_object(entry) || !rmap_gltf_count(entry, "byteLength", 0, &nbytes) ||
        (uri && !json_is_string(uri)))
        return rmap_gltf_refuse(gltf, "its buffer %zu is not there or wrong", index);
    struct rmap_gltf_buffer *buffer = &gltf->buffer[index];
    *found = buffer;
    if (buffer->bytes)
        return RMAP_OK;
    const char *text = json_string_value(uri);
    if (!text && index == 0 && gltf->body) {
        *buffer = (struct rmap_gltf_buffer){NULL, gltf->body, gltf->body_nbytes};
    } else if (!text) {
        return rmap_gltf_refuse(gltf, "its buffer %zu has no 'uri'", index);
    } else {
        RMAP_TRY(strncmp(text, "data:", 5) == 0 ? decode(gltf, text, buffer)
                                                : read_file(gltf, text, buffer));
        gltf->nbytes += buffer->nbytes;
        buffer->bytes = buffer->own;
    }
    if (buffer->nbytes < nbytes)
        return rmap_gltf_refuse(gltf, "its buffer %zu is cut off: %zu bytes of %zu", index,
                                buffer->nbytes, nbytes);
out:
    return st;
}

/* ---- accessors ---- */

enum rmap_status rmap_gltf_charge(struct rmap_gltf *gltf, size_t n)
{
    const size_t most = FREE_CHARGE + CHARGE_PER_BYTE * gltf->nbytes;
    if (n > most - gltf->charged)
        return rmap_gltf_refuse(gltf, "it unfolds to more than %zu vertices and corners", most);
    gltf->charged += n;
    return RMAP_OK;
}

/* n elements of so many bytes that begin at `offset` of a view. */
static enum rmap_status find_place(struct rmap_gltf *gltf, size_t view, size_t offset, size_t n,
                                   size_t nbytes, struct place *place)
{
    enum rmap_status st = RMAP_OK;
    const json_t *entry = json_array_get(json_object_get(gltf->root, "bufferViews"), view);
    const struct rmap_gltf_buffer *buffer = NULL;
    size_t index, begin, len, stride;
    if (!json_is_object(entry) || !rmap_gltf_count(entry, "buffer", SIZE_MAX, &index) ||
        !rmap_gltf_count(entry, "byteOffset", 0, &begin) ||
        !rmap_gltf_count(entry, "byteLength", 0, &len) ||
        !rmap_gltf_count(entry, "byteStride", 0, &stride) || (stride && stride < nbytes))
        return rmap_gltf_refuse(gltf, "its buffer view %zu is not there or wrong", view);
    RMAP_TRY(find_buffer(gltf, index, &buffer));
    place->stride = stride ? stride : nbytes;
    if (begin > buffer->nbytes || len > buffer->nbytes - begin || offset > len ||
        (n > 0 && (nbytes > len - offset || n - 1 > (len - offset - nbytes) / place->stride)))
        return rmap_gltf_refuse(gltf,
                                "its buffer view %zu, or what is read there, ends behind its "
                                "buffer",
                                view);
    place->bytes = buffer->bytes + begin + offset;
out:
    return st;
}

static double component_at(const uint8_t *bytes, size_t type, bool normalized)
{
    static const double most[] = {127, 255, 32767, 65535};
    const uint16_t half = (uint16_t)(bytes[0] | (type >= I16 ? bytes[1] << 8 : 0));
    double value = 0;
    float real;
    uint32_t word;
    switch (type) {
    case I8:
        value = (int8_t)bytes[0];
        break;
    case U8:
        value = bytes[0];
        break;
    case I16:
        value = (int16_t)half;
        break;
    case U16:
        value = half;
        break;
    case U32:
        return word_at(bytes);
    default:
        word = word_at(bytes);
        memcpy(&real, &word, sizeof real);
        return (double)real;
    }
    return !normalized ? value : value < -most[type - I8] ? -1 : value / most[type - I8];
}

static bool find_type(const json_t *entry, size_t *type, size_t *nbytes)
{
    const bool good = rmap_gltf_count(entry, "componentType", 0, type) && *type >= I8 &&
                      *type <= F32 && *type != I32;
    *nbytes = good ? component_nbytes[*type - I8] : 0;
    return good;
}

/* What an accessor has in some places instead. */
static enum rmap_status replace(struct rmap_gltf *gltf, const json_t *sparse, size_t type,
                                bool normalized, size_t n_component, struct rmap_gltf_numbers *to)
{
    enum rmap_status st = RMAP_OK;
    const json_t *where = json_object_get(sparse, "indices"),
                 *what = json_object_get(sparse, "values");
    struct place index, value;
    size_t n, index_type, index_nbytes, view[2], offset[2];
    const size_t nbytes = component_nbytes[type - I8];
    if (!rmap_gltf_count(sparse, "count", 0, &n) || !find_type(where, &index_type, &index_nbytes) ||
        index_type == F32 || !rmap_gltf_count(where, "bufferView", SIZE_MAX, &view[0]) ||
        !rmap_gltf_count(where, "byteOffset", 0, &offset[0]) ||
        !rmap_gltf_count(what, "bufferView", SIZE_MAX, &view[1]) ||
        !rmap_gltf_count(what, "byteOffset", 0, &offset[1]))
        return rmap_gltf_refuse(gltf, "a sparse accessor is wrong");
    RMAP_TRY(rmap_gltf_charge(gltf, n));
    RMAP_TRY(find_place(gltf, view[0], offset[0], n, index_nbytes, &index));
    RMAP_TRY(find_place(gltf, view[1], offset[1], n, n_component * nbytes, &value));
    for (size_t i = 0; i < n; i++) {
        const double at = component_at(index.bytes + i * index.stride, index_type, false);
        if (!(at >= 0 && at < (double)to->n))
            return rmap_gltf_refuse(gltf, "a sparse accessor replaces what is not there");
        for (size_t k = 0; k < n_component; k++)
            to->value[(size_t)at * n_component + k] =
                component_at(value.bytes + i * value.stride + k * nbytes, type, normalized);
    }
out:
    return st;
}

enum rmap_status rmap_gltf_numbers(struct rmap_gltf *gltf, size_t accessor, size_t n_component,
                                   struct rmap_gltf_numbers *to)
{
    enum rmap_status st = RMAP_OK;
    static const char *const type_of[] = {"SCALAR", "VEC2", "VEC3"};
    const json_t *entry = json_array_get(json_object_get(gltf->root, "accessors"), accessor);
    const json_t *sparse = json_object_get(entry, "sparse");
    const char *shape = json_string_value(json_object_get(entry, "type"));
    struct place place = {0};
    size_t type, nbytes, view, offset;
    if (!find_type(entry, &type, &nbytes) || !rmap_gltf_count(entry, "count", 0, &to->n) ||
        !rmap_gltf_count(entry, "bufferView", SIZE_MAX, &view) ||
        !rmap_gltf_count(entry, "byteOffset", 0, &offset) || !shape ||
        strcmp(shape, type_of[n_component - 1]) != 0)
        return rmap_gltf_refuse(gltf, "its accessor %zu is not there or wrong", accessor);
    if (view != SIZE_MAX)
        RMAP_TRY(find_place(gltf, view, offset, to->n, n_component * nbytes, &place));
    RMAP_TRY(rmap_gltf_charge(gltf, to->n));
    RMAP_TRY(RMAP_RESERVE(to->value, to->cap, to->n * n_component, gltf->err));
    const bool normalized = json_is_true(json_object_get(entry, "normalized"));
    for (size_t i = 0; i < to->n; i++)
        for (size_t k = 0; k < n_component; k++)
            to->value[i * n_component + k] =
                place.bytes
                    ? component_at(place.bytes + i * place.stride + k * nbytes, type, normalized)
                    : 0;
    if (sparse)
        RMAP_TRY(replace(gltf, sparse, type, normalized, n_component, to));
out:
    return st;
}
