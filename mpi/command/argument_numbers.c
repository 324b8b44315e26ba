/* SPDX-License-Identifier: MIT
 *
 * Numbers on a command line: counts, decimals, times.
 */
#include "mpi/command/argument_numbers.h"

#include <ctype.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"

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

/* A finite decimal number; *text goes on behind it and the blanks that follow. */
static bool read_decimal(const char **text, double *value)
{
    const char *from = *text;
    if (!isdigit((unsigned char)from[0]) && from[0] != '.' && from[0] != '-' && from[0] != '+')
        return false; /* strtod would take "nan" and "inf" */
    char *end;
    *value = strtod(from, &end);
    if (end == from || !isfinite(*value))
        return false;
    while (isspace((unsigned char)*end))
        end++;
    *text = end;
    return true;
}

/* 0: none of the suffixes is the word. */
static double factor_of(const char *word, size_t len, const struct suffix *suffix, size_t n_suffix)
{
    for (size_t i = 0; i < n_suffix; i++)
        if (strlen(suffix[i].word) == len && memcmp(word, suffix[i].word, len) == 0)
            return suffix[i].factor;
    return 0.0;
}

/* A number and one of the suffixes. */
static bool read_number(const char *text, const struct suffix *suffix, size_t n_suffix,
                        double *value)
{
    double number;
    if (!read_decimal(&text, &number))
        return false;
    const double factor = factor_of(text, strlen(text), suffix, n_suffix);
    *value = number * factor;
    return factor > 0.0;
}

/* "3h50min", "1 d 12 h", "90": numbers with units that get smaller; one alone may have none. */
static bool read_spans(const char *text, double *seconds)
{
    const bool alone = !text[strspn(text, "0123456789.+-eE \t")];
    double sum = 0.0, largest = INFINITY;
    do {
        double number;
        if (!read_decimal(&text, &number) || number < 0.0)
            return false;
        const size_t len = strspn(text, "abcdefghijklmnopqrstuvwxyz");
        const double factor = factor_of(text, len, second_suffix, COUNT(second_suffix));
        if (factor <= 0.0 || factor >= largest || (len == 0 && !alone))
            return false;
        sum += number * factor;
        largest = factor;
        text += len + strspn(text + len, " ");
    } while (*text);
    *seconds = sum;
    return true;
}

/* As Slurm writes times, with two parts at least: days-hours[:minutes[:seconds]],
 * hours:minutes:seconds, minutes:seconds. */
static bool read_clock(const char *text, double *seconds)
{
    const bool days = strchr(text, '-') != NULL;
    double part[4] = {0.0};
    size_t n = 0;
    for (char end = ':'; end; n++) {
        const size_t len = strspn(text, "0123456789");
        end = text[len];
        if (len == 0 || n == COUNT(part) - !days || (end && end != (days && n == 0 ? '-' : ':')))
            return false;
        part[n] = strtod(text, NULL);
        text += len + 1;
    }
    if (days)
        *seconds = 86400.0 * part[0] + 3600.0 * part[1] + 60.0 * part[2] + part[3];
    else if (n == 3)
        *seconds = 3600.0 * part[0] + 60.0 * part[1] + part[2];
    else
        *seconds = 60.0 * part[0] + part[1];
    return n > 1;
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
        number != floor(number))
        return rmap_error_set(err, RMAP_USAGE,
                              "%s must be a whole number without a sign (1000000, 1e6, 2.5M), not "
                              "'%s'",
                              what, text);
    if (number > 0x1p53)
        return rmap_error_set(err, RMAP_USAGE,
                              "%s %s is too large: up to 2^53, or up to 2^64 - 1 written in digits",
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
    double seconds = 0.0;
    if (!text)
        return RMAP_OK;
    if ((!read_spans(text, &seconds) && !read_clock(text, &seconds)) || seconds <= 0)
        return rmap_error_set(err, RMAP_USAGE,
                              "--%s must be a time above 0 (90, 90s, 1.5min, 3h50min, 1:30:00, "
                              "1-00:00:00), not '%s'",
                              name, text);
    *value = seconds;
    return RMAP_OK;
}

enum rmap_status rmap_argument_numbers(const struct rmap_arguments *arguments, const char *name,
                                       double **list_ret, size_t *n_ret, struct rmap_error *err)
{
    char **text = NULL;
    size_t n = 0;
    double *list = NULL;
    enum rmap_status st = rmap_argument_list(arguments, name, &text, &n, err);
    if (st == RMAP_OK && n > 0 && !(list = rmap_alloc(n, sizeof *list)))
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for --%s", name);
    for (size_t i = 0; i < n && st == RMAP_OK; i++)
        if (!read_number(text[i], no_suffix, COUNT(no_suffix), &list[i]))
            st = rmap_error_set(err, RMAP_USAGE,
                                "--%s '%.40s': say numbers with commas between, as 0,30,90", name,
                                text[i]);
    rmap_argument_list_free(text, n);
    *list_ret = st == RMAP_OK ? list : NULL;
    *n_ret = st == RMAP_OK ? n : 0;
    if (st != RMAP_OK)
        rmap_free(list);
    return st;
}
