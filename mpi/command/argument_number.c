/* SPDX-License-Identifier: MIT
 *
 * Numbers as people write them on a command line.
 */
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mpi/command/arguments.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

struct suffix {
    const char *word;
    double factor;
};

static const struct suffix count_suffix[] = {
    {"", 1}, {"k", 1e3}, {"M", 1e6}, {"G", 1e9}, {"Ki", 0x1p10}, {"Mi", 0x1p20}, {"Gi", 0x1p30}};
static const struct suffix second_suffix[] = {{"", 1},     {"s", 1},    {"ms", 1e-3}, {"m", 60},
                                              {"min", 60}, {"h", 3600}, {"d", 86400}};
static const struct suffix no_suffix[] = {{"", 1}};

/* A finite decimal number and one of the suffixes, with blanks between them allowed. */
static bool read_number(const char *text, const struct suffix *suffix, size_t n_suffix,
                        double *value)
{
    if (!isdigit((unsigned char)text[0]) && text[0] != '.' && text[0] != '-' && text[0] != '+')
        return false; /* strtod would take "nan" and "inf" */
    char *end;
    double number = strtod(text, &end);
    if (end == text || !isfinite(number))
        return false;
    while (isspace((unsigned char)*end))
        end++;
    for (size_t i = 0; i < n_suffix; i++)
        if (strcmp(end, suffix[i].word) == 0) {
            *value = number * suffix[i].factor;
            return true;
        }
    return false;
}

static bool all_digits(const char *text)
{
    return *text && strspn(text, "0123456789") == strlen(text);
}

enum rmap_status rmap_parse_count(const char *text, const char *what, uint64_t *value,
                                  struct rmap_error *err)
{
    if (all_digits(text)) { /* exact over all 64 bits */
        uint64_t number = 0;
        for (const char *digit = text; *digit; digit++) {
            uint64_t unit = (uint64_t)(*digit - '0');
            if (number > (UINT64_MAX - unit) / 10)
                return rmap_error_set(err, RMAP_USAGE, "%s %s is too large", what, text);
            number = 10 * number + unit;
        }
        *value = number;
        return RMAP_OK;
    }
    double number;
    if (!read_number(text, count_suffix, COUNT(count_suffix), &number) || number < 0 ||
        number != floor(number) || number > 0x1p53)
        return rmap_error_set(err, RMAP_USAGE,
                              "%s must be a whole number from 0 (1000000, 1e6, 2.5M), not '%s'",
                              what, text);
    *value = (uint64_t)number;
    return RMAP_OK;
}

static const char *dashed(const char *name, char *buffer, size_t len)
{
    (void)snprintf(buffer, len, "--%s", name);
    return buffer;
}

enum rmap_status rmap_argument_count(const struct rmap_arguments *arguments, const char *name,
                                     uint64_t *value, struct rmap_error *err)
{
    char what[64];
    const char *text = rmap_argument(arguments, name);
    return text ? rmap_parse_count(text, dashed(name, what, sizeof what), value, err) : RMAP_OK;
}

enum rmap_status rmap_argument_number(const struct rmap_arguments *arguments, const char *name,
                                      double *value, struct rmap_error *err)
{
    const char *text = rmap_argument(arguments, name);
    if (!text || read_number(text, no_suffix, COUNT(no_suffix), value))
        return RMAP_OK;
    return rmap_error_set(err, RMAP_USAGE, "--%s must be a number, not '%s'", name, text);
}

enum rmap_status rmap_argument_seconds(const struct rmap_arguments *arguments, const char *name,
                                       double *value, struct rmap_error *err)
{
    const char *text = rmap_argument(arguments, name);
    double seconds;
    if (!text)
        return RMAP_OK;
    if (!read_number(text, second_suffix, COUNT(second_suffix), &seconds) || seconds <= 0)
        return rmap_error_set(err, RMAP_USAGE,
                              "--%s must be a time above 0 (90, 90s, 1.5min, 2h), not '%s'", name,
                              text);
    *value = seconds;
    return RMAP_OK;
}
