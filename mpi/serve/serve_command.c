/* SPDX-License-Identifier: MIT
 *
 * Requests that are commands of the command line, run on what is in memory.
 */
#include "mpi/serve/serve_command.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "mpi/parallel/agree.h"
#include "mpi/serve/serve_capture.h"
#include "mpi/serve/serve_picture.h"

enum { ARGUMENTS_MAX = 256, KEY_LEN = 64 };

#define WHERE "where zemax "
#define ASKED "criterion=where " WHERE

/* No option that names a file to read or to write is among them. */
static const struct rmap_serve_command table[] = {
    {"query", &rmap_command_query, "count", "criterion", WHERE "by until explain", NULL},
    {"sample", &rmap_command_query, "", "criterion", WHERE "rays=sample seed limit top of", NULL},
    {"report", &rmap_command_report, "", "ray", ASKED "energy", NULL},
    {"detector", &rmap_command_detector, "", "name",
     ASKED "which until cells region rotate quantity unit frame over xyz spot mtf frequency tally "
           "by dim maintenance photometry planes gammas table values=table",
     NULL},
    {"stats", &rmap_command_stats, "", "",
     ASKED "of which until dim maintenance detector unit bins range log by top quantiles", NULL},
    {"paths", &rmap_command_paths, "", "",
     ASKED "which by no-events collapse detector first top sort exact no-peaks matrix", NULL},
    {"ghosts", &rmap_command_ghosts, "", "detector", ASKED "cells top by", NULL},
    {"draw", &rmap_command_draw, "", "",
     ASKED "limit view cut near stretch eye camera color colour=color by opacity",
     "svg png glb html"},
    {"model", &rmap_command_draw, "", "", ASKED "limit view color colour=color by parts", "json"},
    {"render", &rmap_command_render, "", "", "camera samples size exposure clamp seed", "png exr"},
    {"check", &rmap_command_check, "", "", "seed surface lamp planes gammas", NULL},
};

const struct rmap_serve_command *rmap_serve_command_at(size_t index)
{
    return index < sizeof table / sizeof *table ? &table[index] : NULL;
}

const struct rmap_serve_command *rmap_serve_command_find(const char *name)
{
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        if (strcmp(name, table[i].name) == 0)
            return &table[i];
    return NULL;
}

/* A command line in the making. */
struct line {
    const struct rmap_serve_command *known;
    char *word[ARGUMENTS_MAX + 1];
    int n;
};

static void fini(struct line *line)
{
    for (int i = 0; i < line->n; i++)
        rmap_free(line->word[i]);
    line->n = 0;
}

/* prefix: "--where=", or "". */
static enum rmap_status put(struct line *line, const char *prefix, const char *text,
                            struct rmap_error *err)
{
    const size_t n = strlen(prefix) + strlen(text) + 1;
    char *word = line->n < ARGUMENTS_MAX ? rmap_alloc(n, 1) : NULL;
    if (!word)
        return rmap_error_set(err, RMAP_USAGE, "more than %d arguments", ARGUMENTS_MAX);
    (void)snprintf(word, n, "%s%s", prefix, text);
    line->word[line->n++] = word;
    return RMAP_OK;
}

/* A value, or each of a list. An option without an argument is `true`. */
static enum rmap_status put_value(struct line *line, const char *key, const char *option,
                                  const json_t *value, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char prefix[KEY_LEN + 4] = "", number[32];
    if (option)
        (void)snprintf(prefix, sizeof prefix, "--%s%s", option, json_is_boolean(value) ? "" : "=");
    if (json_is_array(value)) {
        for (size_t i = 0; i < json_array_size(value) && st == RMAP_OK; i++)
            st = json_is_array(json_array_get(value, i))
                     ? rmap_error_set(err, RMAP_USAGE, "'%s' holds a list in a list", key)
                     : put_value(line, key, option, json_array_get(value, i), err);
        return st;
    }
    if (json_is_string(value))
        return put(line, prefix, json_string_value(value), err);
    if (json_is_integer(value))
        (void)snprintf(number, sizeof number, "%lld", (long long)json_integer_value(value));
    else if (json_is_real(value))
        (void)snprintf(number, sizeof number, "%.17g", json_real_value(value));
    else if (option && json_is_true(value))
        return put(line, prefix, "", err);
    else if (json_is_false(value) || json_is_null(value))
        return RMAP_OK;
    else
        return rmap_error_set(err, RMAP_USAGE,
                              "'%s' is a text, a number, true or false, or a list of these", key);
    return put(line, prefix, number, err);
}

/* The option that a key stands for; false: it is none that this command takes. */
static bool option_of(const struct rmap_serve_command *known, const char *key, char option[KEY_LEN])
{
    const size_t n_key = strlen(key);
    for (const char *at = known->takes; *at;) {
        const size_t n = strcspn(at, " ");
        const char *equal = memchr(at, '=', n);
        const size_t n_name = equal ? (size_t)(equal - at) : n;
        const char *from = equal ? equal + 1 : at;
        bool same = n_name == n_key;
        for (size_t i = 0; same && i < n_key; i++)
            same = at[i] == (key[i] == '_' ? '-' : key[i]);
        if (same) {
            (void)snprintf(option, KEY_LEN, "%.*s", (int)(at + n - from), from);
            return true;
        }
        at += n + (at[n] == ' ');
    }
    return false;
}

static enum rmap_status refuse_key(const struct rmap_serve_command *known, const char *key,
                                   struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_USAGE, "'%s' has no '%.60s'; it takes: %s%s%s", known->name,
                          key, known->operand, *known->operand ? " " : "", known->takes);
}

static enum rmap_status put_options(struct line *line, const json_t *message,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_serve_command *known = line->known;
    const char *key;
    json_t *value;
    char option[KEY_LEN];
    json_object_foreach((json_t *)(uintptr_t)message, key, value)
    {
        const bool is_own = strcmp(key, "id") == 0 || strcmp(key, "command") == 0 ||
                            strcmp(key, known->operand) == 0 ||
                            (known->command == &rmap_command_check && strcmp(key, "text") == 0) ||
                            (known->formats && strcmp(key, "format") == 0);
        if (is_own)
            continue;
        if (!option_of(known, key, option))
            return refuse_key(known, key, err);
        RMAP_TRY(put_value(line, key, option, value, err));
    }
out:
    return st;
}

static enum rmap_status put_format(struct line *line, const char *output, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!output)
        return RMAP_OK;
    RMAP_TRY(put(line, "--output=", output, err));
    RMAP_TRY(put(line, "--force", "", err));
out:
    return st;
}

static enum rmap_status compose(struct line *line, const struct rmap_serve *self,
                                const json_t *message, const char *output, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_serve_command *known = line->known;
    const json_t *operand = json_object_get(message, known->operand);
    RMAP_TRY(put(line, "", known->command->name, err));
    if (*known->fixed)
        RMAP_TRY(put(line, "--", known->fixed, err));
    RMAP_TRY(put_options(line, message, err));
    RMAP_TRY(put_format(line, output, err));
    RMAP_TRY(put(line, "--", "", err)); /* what follows is no option, whatever it looks like */
    RMAP_TRY(put(line, "", self->at_hand.path, err));
    if (operand)
        RMAP_TRY(put_value(line, known->operand, NULL, operand, err));
    line->word[line->n] = NULL;
out:
    return st;
}

static enum rmap_status run_line(struct rmap_serve *self, struct line *line, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_arguments given = {0};
    char *argument[ARGUMENTS_MAX + 1]; /* getopt puts them into another order */
    memcpy(argument, line->word, sizeof argument);
    st = rmap_arguments_parse(line->known->command, line->n, argument, &given, err);
    RMAP_TRY(rmap_agree(&self->context, st, err));
    st = line->known->command->run(&self->context, &given, err);
out:
    rmap_arguments_fini(&given);
    return st;
}

enum rmap_status rmap_serve_command_run(struct rmap_serve *self,
                                        const struct rmap_serve_command *known,
                                        const json_t *message, json_t **result_ret,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct line line = {.known = known};
    char *output = NULL;
    const char *type = NULL;
    if (known->formats)
        st = rmap_serve_picture_name(self, known->formats, message, &output, &type, err);
    if (st == RMAP_OK)
        st = compose(&line, self, message, output, err);
    RMAP_TRY(rmap_agree(&self->context, st, err));
    st = run_line(self, &line, err);
    if (self->context.rank == 0) {
        json_t *printed = rmap_serve_capture_take(self->capture);
        const bool is_midway = self->at_hand.steps && !json_is_object(printed);
        if (st == RMAP_OK && output && !is_midway)
            st = rmap_serve_picture_take(output, type, printed, result_ret, err);
        else if (st == RMAP_OK && !is_midway)
            *result_ret = json_incref(printed);
        else if (json_is_object(printed)) /* check says what is wrong and fails */
            self->details = json_incref(printed);
        json_decref(printed);
    }
    st = rmap_agree(&self->context, st, err);
out:
    if (output && self->context.rank == 0)
        (void)unlink(output);
    rmap_free(output);
    fini(&line);
    return st;
}
