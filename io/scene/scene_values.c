/* SPDX-License-Identifier: MIT
 *
 * Typed access to YAML values; every refusal says where, what and what to do.
 */
#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_reader.h"

const struct rmap_range rmap_range_any = {-DBL_MAX, DBL_MAX, "a finite number"};
const struct rmap_range rmap_range_positive = {DBL_MIN, DBL_MAX, "greater than 0"};
const struct rmap_range rmap_range_nonnegative = {0, DBL_MAX, "0 or greater"};
const struct rmap_range rmap_range_share = {0, 1, "between 0 and 1"};

/* A number as people write it: sign, digits, point, exponent; nothing that strtod also takes. */
static bool looks_like_number(const char *text, size_t len)
{
    size_t i = 0, digits = 0;
    if (i < len && (text[i] == '+' || text[i] == '-'))
        i++;
    for (; i < len && isdigit((unsigned char)text[i]); i++)
        digits++;
    if (i < len && text[i] == '.')
        for (i++; i < len && isdigit((unsigned char)text[i]); i++)
            digits++;
    if (!digits)
        return false;
    if (i < len && (text[i] == 'e' || text[i] == 'E')) {
        i++;
        if (i < len && (text[i] == '+' || text[i] == '-'))
            i++;
        size_t first = i;
        while (i < len && isdigit((unsigned char)text[i]))
            i++;
        if (i == first)
            return false;
    }
    return i == len;
}

bool rmap_reader_parse_number(const char *text, size_t len, double *value)
{
    if (!looks_like_number(text, len))
        return false;
    double parsed = strtod(text, NULL);
    if (!isfinite(parsed))
        return false;
    *value = parsed;
    return true;
}

bool rmap_reader_parse_quantity(const char *text, double *value, const char **unit_ret)
{
    const char *end = text;
    while (isdigit((unsigned char)*end) || *end == '.' || *end == '+' || *end == '-' ||
           ((*end == 'e' || *end == 'E') &&
            (isdigit((unsigned char)end[1]) || end[1] == '-' || end[1] == '+')))
        end++;
    if (!rmap_reader_parse_number(text, (size_t)(end - text), value))
        return false;
    while (*end == ' ')
        end++;
    *unit_ret = end;
    return true;
}

bool rmap_reader_scalar(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const char *what, const struct rmap_range *range, double *value)
{
    double parsed = 0;
    if (node->kind != RMAP_YAML_SCALAR) {
        rmap_reader_error(reader, node, "%s must be a number, not a %s", what,
                          node->kind == RMAP_YAML_LIST ? "list" : "mapping");
        return false;
    }
    if (!rmap_reader_parse_number(node->text, strlen(node->text), &parsed)) {
        rmap_reader_error(reader, node, "%s must be a finite number, not '%.40s'", what,
                          node->text);
        return false;
    }
    if (!(parsed >= range->from && parsed <= range->to)) {
        rmap_reader_error(reader, node, "%s must be %s, not %.40s", what, range->text, node->text);
        return false;
    }
    *value = parsed;
    return true;
}

static void missing(struct rmap_reader *reader, const struct rmap_yaml_node *map, const char *key)
{
    rmap_reader_error(reader, map, "'%s' is missing: add it", key);
}

bool rmap_reader_number(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                        const char *key, enum rmap_need need, const struct rmap_range *range,
                        double *value)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(map, key);
    char what[80];
    (void)snprintf(what, sizeof what, "'%s'", key);
    if (node)
        return rmap_reader_scalar(reader, node, what, range, value);
    if (need == RMAP_REQUIRED)
        missing(reader, map, key);
    return need == RMAP_OPTIONAL;
}

bool rmap_reader_whole(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                       const char *key, uint64_t from, uint64_t to, uint64_t *value)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(map, key);
    double number = 0;
    char what[80];
    if (!node)
        return true;
    (void)snprintf(what, sizeof what, "'%s'", key);
    if (!rmap_reader_scalar(reader, node, what, &rmap_range_any, &number))
        return false;
    if (number != floor(number) || number < (double)from || number > (double)to) {
        rmap_reader_error(reader, node, "'%s' must be a whole number from %llu to %llu, not %.40s",
                          key, (unsigned long long)from, (unsigned long long)to, node->text);
        return false;
    }
    *value = (uint64_t)number;
    return true;
}

bool rmap_reader_numbers(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                         const char *key, enum rmap_need need, const struct rmap_range *range,
                         size_t n_min, size_t n_max, double *value, size_t *n_ret)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(map, key);
    char what[80];
    if (!node) {
        if (need == RMAP_REQUIRED)
            missing(reader, map, key);
        return need == RMAP_OPTIONAL;
    }
    (void)snprintf(what, sizeof what, "'%s'", key);
    if (node->kind == RMAP_YAML_SCALAR && n_min == 1) {
        *n_ret = 1;
        return rmap_reader_scalar(reader, node, what, range, value);
    }
    if (node->kind != RMAP_YAML_LIST || node->n_item < n_min || node->n_item > n_max) {
        if (n_min == n_max)
            rmap_reader_error(reader, node, "'%s' must be a list of %zu numbers", key, n_min);
        else
            rmap_reader_error(reader, node, "'%s' must be a list of %zu to %zu numbers", key, n_min,
                              n_max);
        return false;
    }
    bool good = true;
    for (size_t i = 0; i < node->n_item; i++)
        good &= rmap_reader_scalar(reader, node->item[i].value, what, range, &value[i]);
    *n_ret = node->n_item;
    return good;
}

bool rmap_reader_vec3(struct rmap_reader *reader, const struct rmap_yaml_node *map, const char *key,
                      struct rmap_vec3 *value)
{
    double v[3] = {value->x, value->y, value->z};
    size_t n = 0;
    if (!rmap_reader_numbers(reader, map, key, RMAP_OPTIONAL, &rmap_range_any, 3, 3, v, &n))
        return false;
    *value = rmap_vec3(v[0], v[1], v[2]);
    return true;
}

bool rmap_reader_direction(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                           const char *key, struct rmap_vec3 *value)
{
    struct rmap_vec3 v = *value;
    if (!rmap_reader_vec3(reader, map, key, &v))
        return false;
    double largest = fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z)));
    if (!(largest > 0)) {
        rmap_reader_error(reader, rmap_yaml_get(map, key), "'%s' must not be zero", key);
        return false;
    }
    /* Twice: the first scaling keeps the square of huge and tiny vectors in range. */
    *value = rmap_normalize(rmap_scale(v, 1.0 / largest));
    return true;
}

bool rmap_reader_bool(struct rmap_reader *reader, const struct rmap_yaml_node *map, const char *key,
                      bool *value)
{
    int choice = *value ? 0 : 3;
    bool good =
        rmap_reader_choice(reader, map, key, RMAP_OPTIONAL, "true yes on false no off", &choice);
    *value = choice < 3;
    return good;
}

bool rmap_reader_choice(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                        const char *key, enum rmap_need need, const char *words, int *choice_ret)
{
    struct rmap_words known;
    rmap_words_split(words, &known);
    return rmap_reader_one_of(reader, map, key, need, known.word, known.n, choice_ret);
}

bool rmap_reader_one_of(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                        const char *key, enum rmap_need need, const char *const *word,
                        size_t n_word, int *choice_ret)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(map, key);
    if (!node) {
        if (need == RMAP_REQUIRED)
            missing(reader, map, key);
        return need == RMAP_OPTIONAL;
    }
    if (node->kind != RMAP_YAML_SCALAR) {
        rmap_reader_error(reader, node, "'%s' must be a word", key);
        return false;
    }
    for (size_t i = 0; i < n_word; i++) {
        if (strcmp(node->text, word[i]) == 0) {
            *choice_ret = (int)i;
            return true;
        }
    }
    char what[80];
    (void)snprintf(what, sizeof what, "unknown %s", key);
    rmap_reader_unknown(reader, node->line, node->column, what, node->text, word, n_word);
    return false;
}

const char *rmap_reader_text(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                             const char *key, enum rmap_need need)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(map, key);
    if (!node) {
        if (need == RMAP_REQUIRED)
            missing(reader, map, key);
        return NULL;
    }
    if (node->kind != RMAP_YAML_SCALAR || !node->text[0]) {
        rmap_reader_error(reader, node, "'%s' must be a word", key);
        return NULL;
    }
    return node->text;
}

bool rmap_reader_check_name(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                            const char *name)
{
    enum { LONGEST = 200 };
    size_t len = strlen(name);
    bool good = len > 0 && len <= LONGEST && name[0] != ' ' && name[len ? len - 1 : 0] != ' ';
    for (size_t i = 0; i < len && good; i++)
        good = (unsigned char)name[i] >= ' ' && name[i] != 127 && !strchr("*?'\"", name[i]);
    if (!good)
        rmap_reader_error(reader, at,
                          "'%.60s' is no name: 1 to 200 characters, without * ? ' \" and without "
                          "spaces at its ends",
                          name);
    return good;
}

const char *rmap_reader_name(struct rmap_reader *reader, const struct rmap_yaml_node *map)
{
    const char *name = rmap_reader_text(reader, map, "name", RMAP_REQUIRED);
    if (!name || !rmap_reader_check_name(reader, rmap_yaml_get(map, "name"), name))
        return RMAP_UNNAMED;
    return name;
}
