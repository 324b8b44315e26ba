/* SPDX-License-Identifier: MIT
 *
 * Typed values of a scene file: numbers with units, words, names.
 */
#include "io/scene/scene_values.h"

#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/scene/scene_reader.h"

#define FINITE      -DBL_MAX, DBL_MAX, "a finite number"
#define POSITIVE    DBL_MIN, DBL_MAX, "greater than 0"
#define NONNEGATIVE 0, DBL_MAX, "0 or greater"
const struct rmap_range rmap_range_any = {FINITE, RMAP_DIMENSION_NONE};
const struct rmap_range rmap_range_positive = {POSITIVE, RMAP_DIMENSION_NONE};
const struct rmap_range rmap_range_nonnegative = {NONNEGATIVE, RMAP_DIMENSION_NONE};
const struct rmap_range rmap_range_share = {0, 1, "between 0 and 1", RMAP_DIMENSION_SHARE};
const struct rmap_range rmap_range_length = {FINITE, RMAP_DIMENSION_LENGTH};
const struct rmap_range rmap_range_positive_length = {POSITIVE, RMAP_DIMENSION_LENGTH};
const struct rmap_range rmap_range_nonnegative_length = {NONNEGATIVE, RMAP_DIMENSION_LENGTH};
const struct rmap_range rmap_range_angle = {FINITE, RMAP_DIMENSION_ANGLE};
const struct rmap_range rmap_range_polar = {0, 180, "between 0 and 180 degrees",
                                            RMAP_DIMENSION_ANGLE};
const struct rmap_range rmap_range_wavelength = {POSITIVE, RMAP_DIMENSION_WAVELENGTH};
const struct rmap_range rmap_range_photon_energy = {POSITIVE, RMAP_DIMENSION_ENERGY};
const struct rmap_range rmap_range_temperature = {POSITIVE, RMAP_DIMENSION_TEMPERATURE};
const struct rmap_range rmap_range_delay = {NONNEGATIVE, RMAP_DIMENSION_TIME};
const struct rmap_range rmap_range_curvature = {FINITE, RMAP_DIMENSION_PER_LENGTH};
const struct rmap_range rmap_range_attenuation = {NONNEGATIVE, RMAP_DIMENSION_PER_LENGTH};
const struct rmap_range rmap_range_size = {DBL_MIN, RMAP_SCENE_REACH_MAX, "greater than 0",
                                           RMAP_DIMENSION_LENGTH};

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

/* What a number without a unit is in, as units have their sizes. */
static double scene_unit(const struct rmap_reader *reader, enum rmap_dimension dimension)
{
    if (dimension == RMAP_DIMENSION_LENGTH)
        return reader->scene->unit_m;
    if (dimension == RMAP_DIMENSION_PER_LENGTH)
        return 1 / reader->scene->unit_m;
    if (dimension == RMAP_DIMENSION_ENERGY)
        return RMAP_EV_J;
    return dimension == RMAP_DIMENSION_WAVELENGTH || dimension == RMAP_DIMENSION_TIME ? 1e-9 : 1;
}

static enum rmap_dimension dimension_of_units(enum rmap_dimension dimension)
{
    return dimension == RMAP_DIMENSION_WAVELENGTH ? RMAP_DIMENSION_LENGTH : dimension;
}

/* A wavelength that is told by the energy of its photons. */
static bool from_energy(const char *unit, double *nm)
{
    const struct rmap_written_unit *of = rmap_unit_of_scene(unit, RMAP_DIMENSION_ENERGY);
    if (of)
        *nm = RMAP_HC_J / (*nm * of->size);
    return of && *nm > 0.0 && isfinite(*nm);
}

bool rmap_reader_parse_wavelength(const char *text, double *nm_ret)
{
    const char *unit = NULL;
    if (!rmap_reader_parse_quantity(text, nm_ret, &unit))
        return false;
    if (from_energy(unit, nm_ret))
        return true;
    const struct rmap_written_unit *of =
        rmap_unit_of_scene(unit[0] ? unit : "nm", RMAP_DIMENSION_LENGTH);
    if (of)
        *nm_ret = rmap_unit_convert(*nm_ret, of->size, 1e-9);
    return of && *nm_ret > 0;
}

/* Behind a number stands something that is no unit of it. */
static void wrong_unit(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const char *what, const char *unit, enum rmap_dimension dimension)
{
    const char *word[RMAP_UNITS_MAX];
    char fit[120];
    size_t n = rmap_unit_words(dimension_of_units(dimension), word);
    rmap_words_list(word, n, fit, sizeof fit);
    if (n)
        rmap_reader_error(reader, node, "%s has no unit '%.40s'; those that fit: %s", what, unit,
                          fit);
    else
        rmap_reader_error(reader, node, "%s is a number without a unit: leave '%.40s' out", what,
                          unit);
}

static bool read_scalar(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const char *what, enum rmap_dimension dimension, double *value)
{
    const char *unit = NULL;
    if (rmap_reader_parse_number(node->text, strlen(node->text), value))
        return true;
    if (!rmap_reader_parse_quantity(node->text, value, &unit) ||
        (!rmap_unit_named(unit, strlen(unit)) && dimension == RMAP_DIMENSION_NONE)) {
        rmap_reader_error(reader, node, "%s must be a finite number, not '%.40s'%s", what,
                          node->text, strchr(node->text, ',') ? " (decimals have a point)" : "");
        return false;
    }
    if (dimension == RMAP_DIMENSION_WAVELENGTH && from_energy(unit, value))
        return true;
    const struct rmap_written_unit *of = rmap_unit_of_scene(unit, dimension_of_units(dimension));
    if (!of) {
        wrong_unit(reader, node, what, unit, dimension);
        return false;
    }
    *value = rmap_unit_convert(*value, of->size, scene_unit(reader, dimension));
    return true;
}

bool rmap_reader_scalar(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const char *what, const struct rmap_range *range, double *value)
{
    double parsed = 0;
    if (node->kind != RMAP_YAML_SCALAR) {
        rmap_reader_error(reader, node, "%s must be a number, not a %s", what,
                          node->kind == RMAP_YAML_MAP ? "mapping"
                          : node->n_item == 2         ? "list (decimals have a point)"
                                                      : "list");
        return false;
    }
    if (!read_scalar(reader, node, what, range->dimension, &parsed))
        return false;
    if (parsed > range->to && parsed >= RMAP_OBJECTS_RADIUS_MAX) {
        rmap_reader_error(reader, node, "%s is too large: at most %g, not %.40s", what, range->to,
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

/* Without snprintf, since a scene has some numbers for each of a hundred thousand objects. */
static void quote(const char *key, char *what, size_t nbytes)
{
    const size_t n = strnlen(key, nbytes - 3);
    what[0] = '\'';
    memcpy(what + 1, key, n);
    memcpy(what + 1 + n, "'", 2);
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
    quote(key, what, sizeof what);
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
    quote(key, what, sizeof what);
    if (!rmap_reader_scalar(reader, node, what, &rmap_range_any, &number))
        return false;
    if (number > (double)to) {
        rmap_reader_error(reader, node, "'%s' is too large: at most %llu, not %.40s", key,
                          (unsigned long long)to, node->text);
        return false;
    }
    if (number != floor(number) || number < (double)from) {
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
    char what[120];
    if (!node) {
        if (need == RMAP_REQUIRED)
            missing(reader, map, key);
        return need == RMAP_OPTIONAL;
    }
    quote(key, what, sizeof what);
    if (node->kind == RMAP_YAML_SCALAR && n_min == 1) {
        *n_ret = 1;
        return rmap_reader_scalar(reader, node, what, range, value);
    }
    if (node->kind != RMAP_YAML_LIST || node->n_item < n_min || node->n_item > n_max) {
        if (n_min == n_max)
            rmap_reader_error(reader, node, "'%s' must be a list of %zu numbers%s", key, n_min,
                              node->kind == RMAP_YAML_LIST && node->n_item > n_max
                                  ? " (decimals have a point, not a comma)"
                                  : "");
        else
            rmap_reader_error(reader, node, "'%s' must be a list of %zu to %zu numbers", key, n_min,
                              n_max);
        return false;
    }
    bool good = true;
    if (range->from > 0 && node->n_item == 2 && node->item[0].value->text &&
        strcmp(node->item[0].value->text, "0") == 0)
        (void)snprintf(what, sizeof what, "'%.60s' (decimals have a point, not a comma)", key);
    for (size_t i = 0; i < node->n_item; i++)
        good &= rmap_reader_scalar(reader, node->item[i].value, what, range, &value[i]);
    *n_ret = node->n_item;
    return good;
}

bool rmap_reader_vec3(struct rmap_reader *reader, const struct rmap_yaml_node *map, const char *key,
                      const struct rmap_range *range, struct rmap_vec3 *value)
{
    double v[3] = {value->x, value->y, value->z};
    size_t n = 0;
    if (!rmap_reader_numbers(reader, map, key, RMAP_OPTIONAL, range, 3, 3, v, &n))
        return false;
    *value = rmap_vec3(v[0], v[1], v[2]);
    return true;
}

bool rmap_reader_direction(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                           const char *key, struct rmap_vec3 *value)
{
    struct rmap_vec3 v = *value;
    if (!rmap_reader_vec3(reader, map, key, &rmap_range_any, &v))
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
    if (node->kind == RMAP_YAML_MAP && node->n_item > 0) {
        rmap_reader_error(reader, node,
                          "'%s' must be a word: what is described here gets a name in a section of "
                          "its own, and the name stands here",
                          key);
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
