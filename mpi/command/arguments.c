/* SPDX-License-Identifier: MIT
 *
 * Command lines: options before or after operands, from one table per command that also makes the
 * command's --help.
 */
#include <ctype.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "io/file/diagnostics.h"
#include "io/file/shell_word.h"
#include "mpi/command/arguments.h"
#include "mpi/command/command.h"

enum { OPTION_MAX = 48, FIRST_CODE = 256 };

static const struct rmap_option common_option[] = {
    {"threads", 0, "N", "worker threads per rank (default: the rank's share of the cores)"},
    {"json", 0, NULL, "print exactly one JSON document"},
    {"quiet", 'q', NULL,
     "no progress and no remarks; results, and warnings that they are not of all rays, stay"},
    {"help", 'h', NULL, "this text"},
    {NULL, 0, NULL, NULL},
};

const struct rmap_option *rmap_common_options(void)
{
    return common_option;
}

/* The command's options followed by the common ones. */
struct option_set {
    size_t n;
    const struct rmap_option *option[OPTION_MAX];
    struct option long_option[OPTION_MAX + 1];
    char letters[2 * OPTION_MAX + 2];
};

static void add_option(struct option_set *set, const struct rmap_option *option)
{
    if (set->n == OPTION_MAX)
        return;
    set->long_option[set->n] = (struct option){
        .name = option->name,
        .has_arg = option->argument ? required_argument : no_argument,
        .val = FIRST_CODE + (int)set->n,
    };
    set->option[set->n++] = option;
    if (option->letter) {
        size_t len = strlen(set->letters);
        set->letters[len++] = option->letter;
        if (option->argument)
            set->letters[len++] = ':';
        set->letters[len] = 0;
    }
}

static void collect_options(const struct rmap_command *command, struct option_set *set)
{
    memset(set, 0, sizeof *set);
    set->letters[0] = ':'; /* getopt tells a missing argument from an unknown option */
    for (const struct rmap_option *option = command->options; option && option->name; option++)
        add_option(set, option);
    for (const struct rmap_option *option = common_option; option->name; option++)
        add_option(set, option);
}

static const struct rmap_option *option_of(const struct option_set *set, int code)
{
    if (code >= FIRST_CODE)
        return set->option[code - FIRST_CODE];
    for (size_t i = 0; i < set->n; i++)
        if (set->option[i]->letter == code)
            return set->option[i];
    return NULL;
}

static enum rmap_status refuse_option(const struct rmap_command *command,
                                      const struct option_set *set, int code, const char *word,
                                      struct rmap_error *err)
{
    if (code == ':')
        return rmap_error_set(err, RMAP_USAGE, "option '%s' needs a value; see: raymap %s --help",
                              word, command->name);
    if (strncmp(word, "--", 2) != 0)
        return rmap_error_set(err, RMAP_USAGE, "unknown option '-%c'; see: raymap %s --help",
                              optopt, command->name);
    char name[64];
    (void)snprintf(name, sizeof name, "%s", word + 2);
    char *equals = strchr(name, '=');
    if (equals)
        *equals = 0;
    for (size_t i = 0; i < set->n; i++)
        if (equals && strcmp(set->option[i]->name, name) == 0)
            return rmap_error_set(err, RMAP_USAGE, "option '--%s' takes no value", name);
    const char *candidate[OPTION_MAX], *nearest = NULL;
    for (size_t i = 0; i < set->n; i++) {
        candidate[i] = set->option[i]->name;
        if (!nearest && *name && strncmp(candidate[i], name, strlen(name)) == 0)
            nearest = candidate[i];
    }
    if (!nearest)
        nearest = rmap_nearest_word(name, candidate, set->n);
    if (nearest)
        return rmap_error_set(err, RMAP_USAGE,
                              "unknown option '--%s' (did you mean '--%s'?); see: raymap %s --help",
                              name, nearest, command->name);
    return rmap_error_set(err, RMAP_USAGE, "unknown option '--%s'; see: raymap %s --help", name,
                          command->name);
}

/* getopt takes the beginning of a name for the name; a script that has it would change its meaning
 * with the next option that begins so. */
static bool is_abbreviated(const struct option_set *set, int code, const char *word)
{
    return code >= FIRST_CODE &&
           strcspn(word + 2, "=") != strlen(set->option[code - FIRST_CODE]->name);
}

static enum rmap_status append_value(struct rmap_arguments *arguments,
                                     const struct rmap_option *option, const char *text,
                                     struct rmap_error *err)
{
    enum rmap_status st =
        RMAP_RESERVE(arguments->value, arguments->cap_value, arguments->n_value + 1, err);
    if (st != RMAP_OK)
        return st;
    arguments->value[arguments->n_value++] =
        (struct rmap_argument_value){.option = option, .text = text ? text : ""};
    return RMAP_OK;
}

/* What a second value would make forgotten without a word: a file, a question. Of numbers the last
 * one counts, as in other programs. */
static enum rmap_status check_repeats(const struct rmap_arguments *arguments,
                                      struct rmap_error *err)
{
    static const char *const once[] = {"output", "where", "criteria", "zemax", "receivers", NULL};
    for (size_t i = 1; i < arguments->n_value; i++) {
        const struct rmap_option *option = arguments->value[i].option;
        bool asked = false, before = false;
        for (size_t k = 0; once[k]; k++)
            asked |= strcmp(once[k], option->name) == 0;
        for (size_t k = 0; k < i; k++)
            before |= arguments->value[k].option == option;
        if (asked && before && !strstr(option->argument, RMAP_ARGUMENT_AGAIN))
            return rmap_error_set(err, RMAP_USAGE, "option '--%s' is given twice", option->name);
    }
    return RMAP_OK;
}

/* An option that would be ignored is a mistake in what was meant. */
static enum rmap_status check_company(const struct rmap_arguments *arguments,
                                      struct rmap_error *err)
{
    for (size_t i = 0; i < arguments->n_value; i++) {
        const struct rmap_option *option = arguments->value[i].option;
        char list[96] = "", name[32];
        bool accompanied = !option->goes_with;
        for (const char *word = option->goes_with; word && *word;) {
            const size_t len = strcspn(word, " "), at = strlen(list);
            (void)snprintf(name, sizeof name, "%.*s", (int)len, word);
            (void)snprintf(list + at, sizeof list - at, "%s--%s", at ? " or " : "", name);
            accompanied |= rmap_argument(arguments, name) != NULL;
            word += len + (word[len] == ' ');
        }
        if (!accompanied)
            return rmap_error_set(err, RMAP_USAGE,
                                  "option '--%s' goes with %s; see: raymap %s "
                                  "--help",
                                  option->name, list, arguments->command->name);
    }
    return RMAP_OK;
}

/* An unset variable in a script: -o "$OUT". */
static enum rmap_status check_output(const struct rmap_arguments *arguments, struct rmap_error *err)
{
    for (size_t i = 0; i < arguments->n_value; i++)
        if (strcmp(arguments->value[i].option->name, "output") == 0 &&
            arguments->value[i].text[0] == '\0')
            return rmap_error_set(err, RMAP_USAGE, "option '--output' is given an empty name");
    return RMAP_OK;
}

/* The first operand that is not there, as the usage line calls it: "NAME" of "MAP NAME [-o OUT]".
 */
static enum rmap_status refuse_missing(const struct rmap_arguments *arguments,
                                       struct rmap_error *err)
{
    const struct rmap_command *command = arguments->command;
    const char *word = command->operands;
    for (int k = 0; k < arguments->n_operand; k++) {
        word += strcspn(word, " ");
        word += strspn(word, " ");
    }
    int len = (int)strcspn(word, " .");
    return rmap_error_set(err, RMAP_USAGE,
                          "%.*s is missing; usage: raymap %s %s\nsee: raymap %s --help", len, word,
                          command->name, command->operands, command->name);
}

static enum rmap_status check_operands(const struct rmap_arguments *arguments,
                                       struct rmap_error *err)
{
    const struct rmap_command *command = arguments->command;
    if (rmap_argument(arguments, "help"))
        return RMAP_OK;
    if (arguments->n_operand < command->min_operands)
        return refuse_missing(arguments, err);
    if (arguments->n_operand > command->max_operands)
        return rmap_error_set(err, RMAP_USAGE, "'%s' is one word too many; usage: raymap %s %s",
                              arguments->operand[command->max_operands], command->name,
                              command->operands);
    return RMAP_OK;
}

enum rmap_status rmap_arguments_parse(const struct rmap_command *command, int argc, char **argv,
                                      struct rmap_arguments *arguments, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct option_set set;
    collect_options(command, &set);
    *arguments = (struct rmap_arguments){.command = command};
    opterr = 0;
    optind = 1;
    int code;
    while ((code = getopt_long(argc, argv, set.letters, set.long_option, NULL)) != -1) {
        const bool apart = optarg && optarg == argv[optind - 1];
        const char *word = argv[optind - 1 - apart];
        if (code == '?' || code == ':')
            RMAP_TRY(refuse_option(command, &set, code, argv[optind - 1], err));
        if (is_abbreviated(&set, code, word))
            RMAP_TRY(refuse_option(command, &set, '?', word, err));
        RMAP_TRY(append_value(arguments, option_of(&set, code), optarg, err));
        optarg = NULL;
    }
    arguments->n_operand = argc - optind;
    arguments->operand = argv + optind;
    RMAP_TRY(check_operands(arguments, err));
    if (!rmap_argument(arguments, "help")) {
        RMAP_TRY(check_repeats(arguments, err));
        RMAP_TRY(check_output(arguments, err));
        RMAP_TRY(check_company(arguments, err));
    }
out:
    if (st != RMAP_OK)
        rmap_arguments_fini(arguments);
    return st;
}

void rmap_arguments_fini(struct rmap_arguments *arguments)
{
    rmap_free(arguments->value);
    *arguments = (struct rmap_arguments){0};
}

char *rmap_arguments_again(const struct rmap_arguments *arguments, const char *option)
{
    char *text = NULL, *copy = NULL;
    size_t nbytes = 0;
    FILE *line = open_memstream(&text, &nbytes);
    if (!line)
        return NULL;
    fprintf(line, "raymap %s", arguments->command->name);
    for (int i = 0; i < arguments->n_operand; i++)
        rmap_shell_word_put(line, arguments->operand[i]);
    for (size_t i = 0; i < arguments->n_value; i++) {
        fprintf(line, " --%s", arguments->value[i].option->name);
        if (arguments->value[i].option->argument)
            rmap_shell_word_put(line, arguments->value[i].text);
    }
    fprintf(line, " --%s", option);
    if (fclose(line) == 0)
        copy = rmap_strdup(text);
    free(text);
    return copy;
}

const char *rmap_argument(const struct rmap_arguments *arguments, const char *name)
{
    for (size_t i = arguments->n_value; i-- > 0;)
        if (strcmp(arguments->value[i].option->name, name) == 0)
            return arguments->value[i].text;
    return NULL;
}

static enum rmap_status append_piece(char ***list, size_t *n, size_t *cap, const char *from,
                                     size_t len, struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(*list, *cap, *n + 1, err);
    if (st != RMAP_OK)
        return st;
    char *copy = rmap_alloc(len + 1, 1);
    if (!copy)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the command line");
    memcpy(copy, from, len);
    (*list)[(*n)++] = copy;
    return RMAP_OK;
}

/* separator 0: values whole */
void rmap_argument_list_free(char **list, size_t n)
{
    for (size_t i = 0; i < n; i++)
        rmap_free(list[i]);
    rmap_free(list);
}

static enum rmap_status list_values(const struct rmap_arguments *arguments, const char *name,
                                    char separator, char ***list_ret, size_t *n_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char **list = NULL;
    size_t n = 0, cap = 0;
    for (size_t i = 0; i < arguments->n_value; i++) {
        if (strcmp(arguments->value[i].option->name, name) != 0)
            continue;
        const char *from = arguments->value[i].text;
        for (;;) {
            const char *to = separator ? strchr(from, separator) : NULL;
            RMAP_TRY(
                append_piece(&list, &n, &cap, from, to ? (size_t)(to - from) : strlen(from), err));
            if (!to)
                break;
            from = to + 1;
        }
    }
    *list_ret = list;
    *n_ret = n;
    return RMAP_OK;
out:
    rmap_argument_list_free(list, n);
    return st;
}

enum rmap_status rmap_argument_list(const struct rmap_arguments *arguments, const char *name,
                                    char ***list_ret, size_t *n_ret, struct rmap_error *err)
{
    return list_values(arguments, name, ',', list_ret, n_ret, err);
}

enum rmap_status rmap_argument_each(const struct rmap_arguments *arguments, const char *name,
                                    char ***list_ret, size_t *n_ret, struct rmap_error *err)
{
    return list_values(arguments, name, 0, list_ret, n_ret, err);
}

enum { HELP_COLUMN = 27, HELP_WIDTH = 80 };

/* Words from a column on, in lines of HELP_WIDTH characters. */
static void print_words(const char *text, const char *end, size_t column, FILE *out)
{
    size_t at = column;
    while (text < end) {
        size_t len = strcspn(text, " \n");
        if (text + len > end)
            len = (size_t)(end - text);
        if (at > column && at + 1 + len > HELP_WIDTH) {
            fprintf(out, "\n%*s", (int)column, "");
            at = column;
        } else if (at > column) {
            fputc(' ', out);
            at++;
        }
        fprintf(out, "%.*s", (int)len, text);
        at += len;
        text += len + 1;
    }
    fputc('\n', out);
}

/* Lines of prose are broken anew; empty ones and those that begin with a space stay as they are. */
static void print_prose(const char *text, FILE *out)
{
    while (*text) {
        const char *end = text;
        bool more = *text != ' ' && *text != '\n';
        do {
            end += strcspn(end, "\n");
            more = more && end[0] && end[1] != ' ' && end[1] != '\n' && end[1];
            end += more;
        } while (more);
        if (*text == ' ')
            fprintf(out, "%.*s\n", (int)(end - text), text);
        else
            print_words(text, end, 0, out);
        text = *end ? end + 1 : end;
    }
}

static void print_option(const struct rmap_option *option, FILE *out)
{
    char left[64];
    int n =
        snprintf(left, sizeof left, "  %c%c%s --%s%s%s", option->letter ? '-' : ' ',
                 option->letter ? option->letter : ' ', option->letter ? "," : " ", option->name,
                 option->argument ? " " : "", option->argument ? option->argument : "");
    fprintf(out, "%-*s", HELP_COLUMN, left);
    if (n >= HELP_COLUMN) /* the text stands below */
        fprintf(out, "\n%*s", HELP_COLUMN, "");
    print_words(option->help, option->help + strlen(option->help), HELP_COLUMN, out);
}

void rmap_arguments_help(const struct rmap_command *command, FILE *out)
{
    const int column = fprintf(out, "usage: raymap %s ", command->name);
    print_words(command->operands, command->operands + strlen(command->operands), (size_t)column,
                out);
    fputc('\n', out);
    print_prose(command->help, out);
    fprintf(out, "\noptions:\n");
    for (const struct rmap_option *option = command->options; option && option->name; option++)
        print_option(option, out);
    for (const struct rmap_option *option = common_option; option->name; option++)
        print_option(option, out);
}
