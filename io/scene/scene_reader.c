/* SPDX-License-Identifier: MIT
 *
 * What the parts of the scene reader (scene_*.c, one per section of the file) share: the reader's
 * state, typed access to YAML values with complaints that say where and what to do, and names.
 */
#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/scene/scene_reader.h"

/* Complaints of the scene reader, checks of keys, and the reader's memory. */

static void complain(struct rmap_reader *reader, enum rmap_severity severity,
                     const struct rmap_yaml_node *at, const char *format, va_list args)
{
    const struct rmap_scene_options *options = &reader->bundle->options;
    char text[RMAP_ERROR_TEXT_LEN];
    if (reader->status != RMAP_OK)
        return;
    if (!at || at->line >= 0 || (size_t)-at->line > options->n_set) {
        rmap_diagnostics_vadd(reader->diagnostics, severity, at ? at->line : 0, at ? at->column : 0,
                              format, args);
        return;
    }
    (void)vsnprintf(text, sizeof text, format, args);
    rmap_diagnostics_add(reader->diagnostics, severity, 0, 0, "--set %.100s: %s",
                         options->set[-at->line - 1], text);
}

void rmap_reader_error(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                       const char *format, ...)
{
    va_list args;
    va_start(args, format);
    complain(reader, RMAP_SEVERITY_ERROR, at, format, args);
    va_end(args);
}

void rmap_reader_warn(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                      const char *format, ...)
{
    va_list args;
    va_start(args, format);
    complain(reader, RMAP_SEVERITY_WARNING, at, format, args);
    va_end(args);
}

/* "a, b, c" into text; more than fit end with "...". */
static void list_words(const char *const *word, size_t n_word, char *text, size_t nbytes)
{
    size_t used = 0;
    text[0] = 0;
    for (size_t i = 0; i < n_word; i++) {
        bool room = used + strlen(word[i]) + 8 < nbytes;
        int wrote =
            snprintf(text + used, nbytes - used, "%s%s", i ? ", " : "", room ? word[i] : "...");
        if (wrote < 0 || !room)
            return;
        used += (size_t)wrote;
    }
}

void rmap_reader_unknown(struct rmap_reader *reader, int line, int column, const char *what,
                         const char *word, const char *const *known, size_t n_known)
{
    const struct rmap_yaml_node at = {.line = line, .column = column};
    if (rmap_diagnostics_full(reader->diagnostics)) {
        rmap_reader_error(reader, &at, "%s", what);
        return;
    }
    const char *nearest = rmap_nearest_word(word, known, n_known);
    char choices[400];
    list_words(known, n_known, choices, sizeof choices);
    if (nearest)
        rmap_reader_error(reader, &at, "%s '%.60s' (did you mean '%.60s'?)", what, word, nearest);
    else if (n_known)
        rmap_reader_error(reader, &at, "%s '%.60s'; known: %s", what, word, choices);
    else
        rmap_reader_error(reader, &at, "%s '%.60s': there are none here", what, word);
}

/* Of {radius: 0,5} the 5: a key with nothing behind it. */
static bool is_decimal_tail(const struct rmap_yaml_item *item)
{
    return isdigit((unsigned char)item->key[0]) && item->value->kind == RMAP_YAML_SCALAR &&
           !item->value->text[0];
}

bool rmap_reader_check_keys(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const char *what, const char *const *known, size_t n_known)
{
    if (node->kind != RMAP_YAML_MAP) {
        rmap_reader_error(reader, node, "%s must be a mapping of keys and values", what);
        return false;
    }
    for (size_t i = 0; i < node->n_item; i++) {
        const struct rmap_yaml_item *item = &node->item[i];
        bool found = false;
        for (size_t k = 0; k < n_known && !found; k++)
            found = strcmp(item->key, known[k]) == 0;
        if (found)
            continue;
        if (i > 0 && is_decimal_tail(item)) {
            const struct rmap_yaml_node at = {.line = item->line, .column = item->column};
            const char *before = node->item[i - 1].value->text;
            rmap_reader_error(reader, &at,
                              "'%.40s,%.40s' is no number: decimals have a point, not a comma",
                              before ? before : "", item->key);
            continue;
        }
        char text[120];
        (void)snprintf(text, sizeof text, "unknown key in %s:", what);
        rmap_reader_unknown(reader, item->line, item->column, text, item->key, known, n_known);
    }
    return true;
}

bool rmap_reader_check_map(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           const char *what, const char *keys)
{
    struct rmap_words known;
    rmap_words_split(keys, &known);
    return rmap_reader_check_keys(reader, node, what, known.word, known.n);
}

void rmap_words_split(const char *text, struct rmap_words *words)
{
    char *rest = words->text;
    words->n = 0;
    (void)snprintf(words->text, sizeof words->text, "%s", text);
    for (char *word; words->n < RMAP_COUNT(words->word) && (word = strtok_r(rest, " ", &rest));) {
        size_t same = 0;
        while (same < words->n && strcmp(words->word[same], word) != 0)
            same++;
        words->word[same] = word;
        words->n += same == words->n;
    }
}

bool rmap_reader_check_list(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const char *what)
{
    if (node->kind == RMAP_YAML_LIST)
        return true;
    rmap_reader_error(reader, node, "%s must be a list", what);
    return false;
}

void rmap_reader_fail(struct rmap_reader *reader, enum rmap_status status)
{
    if (reader->status == RMAP_OK && reader->err)
        *reader->err = reader->failure;
    if (reader->status == RMAP_OK)
        reader->status = status;
}

void rmap_reader_no_memory(struct rmap_reader *reader)
{
    rmap_reader_fail(reader, rmap_error_set(&reader->failure, RMAP_SYSTEM,
                                            "out of memory while reading the scene"));
}

void rmap_reader_made(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      enum rmap_status status)
{
    if (status == RMAP_INPUT)
        rmap_reader_error(reader, node, "%s", reader->failure.text);
    else if (status != RMAP_OK)
        rmap_reader_fail(reader, status);
}

/* Each block begins with the address of the one before it, in a space that keeps what follows
 * aligned for any type. */
union block_head {
    void *before;
    double align_double;
    long double align_long_double;
};

void *rmap_reader_alloc(struct rmap_reader *reader, size_t n, size_t size)
{
    union block_head *head = NULL;
    if (!size || n <= (SIZE_MAX - sizeof(union block_head)) / size)
        head = rmap_alloc(1, sizeof *head + n * size);
    if (!head) {
        rmap_reader_no_memory(reader);
        return NULL;
    }
    head->before = reader->arena;
    reader->arena = head;
    return head + 1;
}

void rmap_reader_release(struct rmap_reader *reader)
{
    for (union block_head *head = reader->arena; head;) {
        union block_head *before = head->before;
        rmap_free(head);
        head = before;
    }
    reader->arena = NULL;
}

char *rmap_reader_strdup(struct rmap_reader *reader, const char *text)
{
    char *copy = rmap_strdup(text);
    if (!copy)
        rmap_reader_no_memory(reader);
    return copy;
}

bool rmap_reader_room(struct rmap_reader *reader, void *array_address, size_t *cap, size_t n,
                      size_t size)
{
    char *array;
    if (rmap_reserve_array(array_address, cap, n + 1, size, NULL) != RMAP_OK) {
        rmap_reader_no_memory(reader);
        return false;
    }
    memcpy(&array, array_address, sizeof array);
    memset(array + n * size, 0, size);
    return true;
}

/* Typed access to YAML values; every refusal says where, what and what to do. */

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
const struct rmap_range rmap_range_wavelength = {POSITIVE, RMAP_DIMENSION_WAVELENGTH};
const struct rmap_range rmap_range_temperature = {POSITIVE, RMAP_DIMENSION_TEMPERATURE};
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
    return dimension == RMAP_DIMENSION_WAVELENGTH ? 1e-9 : 1;
}

/* Divides by what is above 1, so that 5 mm are the double nearest to 0.005 m. */
static double convert(double value, double from, double to)
{
    double times = from >= to ? from / to : to / from, whole = round(times);
    if (fabs(times - whole) < 1e-12 * whole)
        times = whole;
    return from >= to ? value * times : value / times;
}

static enum rmap_dimension dimension_of_units(enum rmap_dimension dimension)
{
    return dimension == RMAP_DIMENSION_WAVELENGTH ? RMAP_DIMENSION_LENGTH : dimension;
}

bool rmap_reader_parse_wavelength(const char *text, double *nm_ret)
{
    const char *unit = NULL;
    if (!rmap_reader_parse_quantity(text, nm_ret, &unit))
        return false;
    const struct rmap_written_unit *of =
        rmap_unit_of_scene(unit[0] ? unit : "nm", RMAP_DIMENSION_LENGTH);
    if (of)
        *nm_ret = convert(*nm_ret, of->size, 1e-9);
    return of && *nm_ret > 0;
}

/* Behind a number stands something that is no unit of it. */
static void wrong_unit(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const char *what, const char *unit, enum rmap_dimension dimension)
{
    const char *word[RMAP_UNITS_MAX];
    char fit[120];
    size_t n = rmap_unit_words(dimension_of_units(dimension), word);
    list_words(word, n, fit, sizeof fit);
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
    const struct rmap_written_unit *of = rmap_unit_of_scene(unit, dimension_of_units(dimension));
    if (!of) {
        wrong_unit(reader, node, what, unit, dimension);
        return false;
    }
    *value = convert(*value, of->size, scene_unit(reader, dimension));
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
    (void)snprintf(what, sizeof what, "'%s'", key);
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

/* Names of a scene, hashed: a scene may have a hundred thousand objects. */

static size_t find_slot(const struct rmap_names *names, const char *text)
{
    size_t mask = names->n_slot - 1;
    size_t slot = (size_t)XXH3_64bits(text, strlen(text)) & mask;
    while (names->slot[slot] && strcmp(names->name[names->slot[slot] - 1].text, text) != 0)
        slot = (slot + 1) & mask;
    return slot;
}

static enum rmap_status grow(struct rmap_names *names, struct rmap_error *err)
{
    size_t n_slot = names->n_slot ? 2 * names->n_slot : 64;
    uint32_t *slot = rmap_alloc(n_slot, sizeof *slot);
    if (!slot)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory: %zu names", names->n);
    rmap_free(names->slot);
    names->slot = slot;
    names->n_slot = n_slot;
    for (size_t i = 0; i < names->n; i++)
        names->slot[find_slot(names, names->name[i].text)] = (uint32_t)(i + 1);
    return RMAP_OK;
}

const struct rmap_name *rmap_names_find(const struct rmap_names *names, const char *text)
{
    if (!names->n_slot)
        return NULL;
    uint32_t entry = names->slot[find_slot(names, text)];
    return entry ? &names->name[entry - 1] : NULL;
}

enum rmap_status rmap_names_add(struct rmap_names *names, const char *text, int32_t kind,
                                int32_t index, int32_t line, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (2 * (names->n + 1) > names->n_slot)
        RMAP_TRY(grow(names, err));
    RMAP_TRY(RMAP_RESERVE(names->name, names->cap, names->n + 1, err));
    size_t slot = find_slot(names, text);
    names->name[names->n++] = (struct rmap_name){text, kind, index, line};
    names->slot[slot] = (uint32_t)names->n;
out:
    return st;
}

void rmap_names_fini(struct rmap_names *names)
{
    rmap_free(names->name);
    rmap_free(names->slot);
    *names = (struct rmap_names){0};
}

void rmap_reader_add_name(struct rmap_reader *reader, struct rmap_names *names, const char *text,
                          int32_t kind, int32_t index, int32_t line)
{
    if (!text || rmap_names_add(names, text, kind, index, line, &reader->failure) != RMAP_OK)
        rmap_reader_fail(reader, RMAP_SYSTEM);
}

static bool is_receiver(const struct rmap_reader *reader, const struct rmap_name *name)
{
    return name->kind == RMAP_MEMBER_DETECTOR &&
           (size_t)name->index >= reader->scene->n_detector - reader->n_receiver;
}

void rmap_reader_add_member(struct rmap_reader *reader, const char *name, enum rmap_member kind,
                            int32_t index, const struct rmap_yaml_node *at)
{
    static const char *const word[] = {"object", "group", "source", "detector"};
    if (!name || name[0] == RMAP_UNNAMED[0])
        return;
    const struct rmap_name *taken = rmap_names_find(&reader->members, name);
    bool elsewhere = taken && reader->n_receiver > 0 && !is_receiver(reader, taken);
    if (elsewhere) {
        rmap_reader_error(reader, at, "the name '%.60s' is taken by a %s of the map's scene", name,
                          word[taken->kind]);
        return;
    }
    if (taken) {
        rmap_reader_error(reader, at,
                          "the name '%.60s' is taken by the %s on line %d: names are unique over "
                          "objects, groups, sources and detectors",
                          name, word[taken->kind], (int)taken->line);
        return;
    }
    rmap_reader_add_name(reader, &reader->members, name, (int32_t)kind, index, at ? at->line : 0);
}

int32_t rmap_reader_find(struct rmap_reader *reader, const struct rmap_names *names,
                         const char *what, const struct rmap_yaml_node *at, const char *text)
{
    const struct rmap_name *name = rmap_names_find(names, text);
    if (name)
        return name->index;
    char kind[80];
    (void)snprintf(kind, sizeof kind, "unknown %s", what);
    const char **word = rmap_alloc(names->n, sizeof *word);
    for (size_t i = 0; word && i < names->n; i++)
        word[i] = names->name[i].text;
    rmap_reader_unknown(reader, at->line, at->column, kind, text, word, word ? names->n : 0);
    rmap_free(word);
    return -1;
}
