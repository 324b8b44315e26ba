/* SPDX-License-Identifier: MIT
 *
 * Values of JSON as YAML in a line.
 */
#include "io/scene/yaml_write.h"

#include <stdlib.h>
#include <string.h>

#include "base/count.h"

/* Whether a text says the same in YAML without quotes. */
static bool is_plain(const char *text)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789";
    const size_t n = strlen(text);
    if (n == 0 || text[n - 1] == ' ' || !strchr(letters, text[0]))
        return n > 1 && (text[0] == '-' || text[0] == '.') && strchr(letters, text[1]) &&
               is_plain(text + 1);
    for (size_t i = 0; i < n; i++)
        if (!strchr(letters, text[i]) && !strchr(" _.+-/%()*^", text[i]))
            return false;
    return true;
}

static void put_number(FILE *out, double value)
{
    char text[32];
    for (int digits = 15; digits <= 17; digits++) {
        (void)snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    fputs(text, out);
}

void rmap_yaml_write_value(FILE *out, const json_t *value)
{
    const char *key;
    json_t *item;
    size_t i = 0;
    if (json_is_real(value)) {
        put_number(out, json_real_value(value));
    } else if (json_is_string(value) && is_plain(json_string_value(value))) {
        fputs(json_string_value(value), out);
    } else if (json_is_array(value)) {
        for (fputc('[', out); i < json_array_size(value); i++) {
            fputs(i ? ", " : "", out);
            rmap_yaml_write_value(out, json_array_get(value, i));
        }
        fputc(']', out);
    } else if (json_is_object(value)) {
        fputc('{', out);
        json_object_foreach((json_t *)(uintptr_t)value, key, item)
        {
            fprintf(out, "%s", i++ ? ", " : "");
            json_t *name = json_string(key);
            rmap_yaml_write_value(out, name);
            json_decref(name);
            fputs(": ", out);
            rmap_yaml_write_value(out, item);
        }
        fputc('}', out);
    } else {
        (void)json_dumpf(value, out, JSON_ENCODE_ANY | JSON_COMPACT);
    }
}

bool rmap_yaml_has_named(const char *key, size_t n)
{
    static const char *const list[] = {"objects", "sources", "detectors", "cameras", "simulations"};
    bool is = false;
    for (size_t i = 0; i < RMAP_COUNT(list); i++)
        is = is || (strlen(list[i]) == n && memcmp(list[i], key, n) == 0);
    return is;
}

void rmap_yaml_write_named(FILE *out, const char *name, const json_t *value)
{
    json_t *item = json_pack("{s:s}", "name", name);
    (void)json_object_update(item, (json_t *)(uintptr_t)value);
    rmap_yaml_write_value(out, item);
    json_decref(item);
}

static void put_key(FILE *out, const char *key, size_t n)
{
    json_t *name = json_stringn(key, n);
    rmap_yaml_write_value(out, name);
    json_decref(name);
    fputs(": ", out);
}

void rmap_yaml_write_path(FILE *out, const char *path, const json_t *value)
{
    size_t n_map = 0, n;
    for (; path[n = strcspn(path, ".")] && !rmap_yaml_has_named(path, n); path += n + 1) {
        put_key(out, path, n);
        fputc('{', out);
        n_map++;
    }
    put_key(out, path, n);
    if (path[n]) {
        fputc('[', out);
        rmap_yaml_write_named(out, path + n + 1, value);
        fputc(']', out);
    } else {
        rmap_yaml_write_value(out, value);
    }
    for (; n_map > 0; n_map--)
        fputc('}', out);
}
