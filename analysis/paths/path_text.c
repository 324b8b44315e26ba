/* SPDX-License-Identifier: MIT
 *
 * Paths as text: for people, and as the criterion of exactly these rays.
 */
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "analysis/criterion/path_order.h"
#include "analysis/criterion/path_regex.h"
#include "analysis/paths/path_key_internal.h"
#include "analysis/paths/path_text.h"
#include "base/alloc.h"

/* Beyond, the language refuses a path (path_automaton.c). */
enum { STEPS_MAX = 16000, ENTRIES_MAX = 4000000 };

/* Text that grows; keeps its first error until the end. */
struct text {
    char *bytes;
    size_t n, cap;
    enum rmap_status status;
    struct rmap_error *err;
};

static void RMAP_PRINTF(2, 3) add_text(struct text *text, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    int n = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    if (text->status != RMAP_OK || n < 0)
        return;
    text->status = RMAP_RESERVE(text->bytes, text->cap, text->n + (size_t)n + 1, text->err);
    if (text->status != RMAP_OK)
        return;
    va_start(arguments, format);
    (void)vsnprintf(text->bytes + text->n, (size_t)n + 1, format, arguments);
    va_end(arguments);
    text->n += (size_t)n;
}

static enum rmap_status finish(struct text *text, char **text_ret)
{
    add_text(text, "%s", "");
    if (text->status == RMAP_OK)
        *text_ret = text->bytes;
    else
        rmap_free(text->bytes);
    return text->status;
}

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

/* As a path takes it without quotes: [A-Za-z_]\w*(\.\w+)*, and no word of the language. */
static bool is_bare(const char *name)
{
    if (!is_letter(name[0]) || strcmp(name, "not") == 0 || strcmp(name, "and") == 0 ||
        strcmp(name, "or") == 0)
        return false;
    for (const char *c = name; *c; c++) {
        bool in_word = is_letter(*c) || (*c >= '0' && *c <= '9');
        if (!in_word && (*c != '.' || c[1] == '.' || c[1] == 0))
            return false;
    }
    return true;
}

static void add_name(struct text *text, const char *name)
{
    add_text(text, is_bare(name) ? "%s" : "'%s'", name);
}

enum rmap_status rmap_path_quote(const char *name, char **text_ret, struct rmap_error *err)
{
    struct text text = {.err = err};
    add_name(&text, name);
    return finish(&text, text_ret);
}

static uint32_t letter_of(rmap_path_step symbol)
{
    return symbol & ((1u << RMAP_PATH_LETTER_BITS) - 1);
}

/* Its name; NULL for none. *clash_ret: an object's or group's that a medium has, too, or the other
 * way round. *inside_ret: it is a medium. */
static const char *place_of(const struct rmap_path_keys *keys, rmap_path_step symbol,
                            bool *inside_ret, bool *clash_ret)
{
    const struct rmap_scene *scene = keys->scene;
    size_t place = symbol >> RMAP_PATH_LETTER_BITS;
    *inside_ret = *clash_ret = false;
    if (place == 0)
        return NULL;
    place--;
    if (place < keys->labels.n) {
        const char *name = keys->labels.name[place];
        for (size_t m = 0; m < scene->n_medium; m++)
            *clash_ret |= keys->clashes[m] && strcmp(scene->medium[m].name, name) == 0;
        return name;
    }
    place -= keys->labels.n;
    if (place < scene->n_medium) {
        *inside_ret = true;
        *clash_ret = keys->clashes[place];
        return scene->medium[place].name;
    }
    return scene->detector[place - scene->n_medium].name;
}

static void add_step(struct text *text, const struct rmap_path_keys *keys, rmap_path_step symbol)
{
    bool inside, clash;
    const uint32_t letter = letter_of(symbol);
    const char *name = place_of(keys, symbol, &inside, &clash);
    if (letter < RMAP_PATH_LETTER_COUNT)
        add_text(text, "%c", RMAP_PATH_LETTERS[letter]);
    else
        add_text(text, clash ? "[^SV]" : ".");
    if (!name)
        return;
    add_text(text, "@");
    add_name(text, name);
}

/* Symbols equal to the one at `at`, from there on. */
static size_t run_length(const rmap_path_step *symbol, size_t n, size_t at)
{
    size_t k = at + 1;
    while (k < n && symbol[k] == symbol[at])
        k++;
    return k - at;
}

/* One more step of a text of steps; '{3}' behind those that come in a row. mark: behind a
 * medium with the name of an object. */
static void add_run(struct text *text, const struct rmap_path_keys *keys, rmap_path_step symbol,
                    size_t n_times, const char *mark)
{
    bool inside, clash;
    if (text->n > 0 && text->bytes[text->n - 1] != '"')
        add_text(text, " ");
    add_step(text, keys, symbol);
    (void)place_of(keys, symbol, &inside, &clash);
    if (inside && clash)
        add_text(text, "%s", mark);
    if (n_times > 1)
        add_text(text, "{%zu}", n_times);
}

void rmap_path_shorten(const char *text, size_t most, char *to, size_t to_nbytes)
{
    static const char gap[] = " ... ";
    const size_t n = strlen(text);
    size_t head = most - most / 3, tail = n - most / 3;
    for (; n > most && head > 0 && text[head] != ' '; head--)
        ;
    for (; n > most && tail < n && text[tail] != ' '; tail++)
        ;
    if (n <= most || head == 0 || tail >= n || head >= tail)
        (void)snprintf(to, to_nbytes, "%s", text);
    else
        (void)snprintf(to, to_nbytes, "%.*s%s%s", (int)head, text, gap, text + tail + 1);
}

/* Writes the middle's place into the text itself. */
static void shorten(struct text *text, size_t most)
{
    char *copy = text->status == RMAP_OK ? rmap_strdup(text->bytes ? text->bytes : "") : NULL;
    if (text->status == RMAP_OK && !copy)
        text->status = rmap_error_set(text->err, RMAP_SYSTEM, "out of memory for a path's text");
    if (text->status == RMAP_OK && text->n > most) {
        rmap_path_shorten(copy, most, text->bytes, text->n + 1);
        text->n = strlen(text->bytes);
    }
    rmap_free(copy);
}

enum rmap_status rmap_path_key_text(const struct rmap_path_keys *keys, const rmap_path_step *symbol,
                                    size_t n, size_t most_nbytes, char **text_ret,
                                    struct rmap_error *err)
{
    struct text text = {.err = err};
    for (size_t i = 0; i < n && text.status == RMAP_OK;) {
        size_t run = run_length(symbol, n, i);
        add_run(&text, keys, symbol[i], run, "[medium]");
        i += run;
    }
    if (most_nbytes > 0)
        shorten(&text, most_nbytes);
    return finish(&text, text_ret);
}

/* Whether the language takes it: steps, and states times symbols. */
static bool is_short(const rmap_path_step *symbol, size_t n)
{
    rmap_path_step seen[64];
    size_t n_seen = 0;
    for (size_t i = 0; i < n && n_seen < 64; i++) {
        size_t k = 0;
        while (k < n_seen && seen[k] != symbol[i])
            k++;
        if (k == n_seen)
            seen[n_seen++] = symbol[i];
    }
    size_t n_symbol = n_seen < 64 ? n_seen : n;
    return n <= STEPS_MAX && n_symbol < 500 && (n + 4) * (2 * n_symbol + 8) <= ENTRIES_MAX;
}

/* What the path's expression leaves open: names shared by an object and a medium, and ends at no
 * object. An absorption is a ray's last step. */
static void add_rest(struct text *text, const struct rmap_path_keys *keys, rmap_path_step last)
{
    bool inside, clash;
    const uint32_t letter = letter_of(last);
    const char *name = place_of(keys, last, &inside, &clash);
    const char c = letter < RMAP_PATH_LETTER_COUNT ? RMAP_PATH_LETTERS[letter] : '.';
    if (!name && (c == 'K' || c == 'E'))
        add_text(text, " and not hit('*', %s)", c == 'K' ? "limit" : "error");
    if (!clash || (c != 'A' && c != '.'))
        return;
    if (inside)
        add_text(text, " and not hit('%s', absorb)", name);
    else if (c == 'A')
        add_text(text, " and hit('%s', absorb)", name);
    else
        add_text(text, " and not (path(\".* A@'%s' V*\") and not hit('%s', absorb))", name, name);
}

static rmap_path_step last_step(const rmap_path_step *symbol, size_t n)
{
    while (n > 1 && letter_of(symbol[n - 1]) == RMAP_PATH_LETTER_V)
        n--;
    return symbol[n - 1];
}

enum rmap_status rmap_path_with_source(const struct rmap_path_keys *keys, int32_t source,
                                       const char *steps, char **text_ret, struct rmap_error *err)
{
    struct text text = {.err = err};
    add_text(&text, "%s: %s", keys->scene->source[source].name, steps);
    return finish(&text, text_ret);
}

/* Whether a step of a collapsed path stands for several: not the registration with which a history
 * ends, nor the step of any letter before that. */
static bool may_repeat(const struct rmap_path_keys *keys, rmap_path_step symbol, bool is_last)
{
    bool opened = letter_of(symbol) == RMAP_PATH_LETTER_ANY && !keys->view.without_events;
    return !opened && !(is_last && keys->view.until_detector);
}

/* The inside of the path's quotes. */
static void add_expression(struct text *text, const struct rmap_path_keys *keys,
                           const rmap_path_step *symbol, size_t n)
{
    for (size_t i = 0; i < n && text->status == RMAP_OK;) {
        size_t run = run_length(symbol, n, i);
        add_run(text, keys, symbol[i], run, "");
        i += run;
        if (keys->view.collapsed && may_repeat(keys, symbol[i - 1], i == n))
            add_text(text, "+");
    }
}

enum rmap_status rmap_path_criterion_of(const struct rmap_path_keys *keys, int32_t source,
                                        const rmap_path_step *symbol, size_t n, uint64_t only_ray,
                                        char **text_ret, struct rmap_error *err)
{
    struct text text = {.err = err};
    *text_ret = NULL;
    if (!is_short(symbol, n)) {
        if (only_ray == RMAP_PATH_MANY_RAYS)
            return RMAP_OK;
        add_text(&text, "ray == %" PRIu64, only_ray);
        return finish(&text, text_ret);
    }
    add_text(&text, "source(");
    add_name(&text, keys->scene->source[source].name);
    if (n == 0) {
        add_text(&text, ") and segments == 0");
        return finish(&text, text_ret);
    }
    add_text(&text, ") and ");
    if (keys->view.until_detector) { /* so that it chooses the registrations, too */
        bool inside, clash;
        add_text(&text, "registered(");
        add_name(&text, place_of(keys, symbol[n - 1], &inside, &clash));
        add_text(&text, " where ");
    }
    add_text(&text, "path(\"");
    add_expression(&text, keys, symbol, n);
    add_text(&text, keys->view.until_detector ? "\"))" : "\")");
    if (!keys->view.until_detector)
        add_rest(&text, keys, last_step(symbol, n));
    return finish(&text, text_ret);
}

static bool can_reflect(const struct rmap_scene *scene, int32_t surface)
{
    return surface >= 0 && strchr(rmap_surface_model[scene->surface[surface].type].events, 'R');
}

/* Steps that change neither order: no scatter, and no specular reflection but at objects that
 * make no ghosts. */
static void add_plain_steps(struct text *text, const struct rmap_path_keys *keys,
                            const struct rmap_path_order *order)
{
    const struct rmap_object *object = keys->scene->object;
    add_text(text, "([^RDdS]");
    for (size_t o = 0; o < order->n_object; o++)
        if (order->makes_ghosts[o] != 3 && (can_reflect(keys->scene, object[o].surface_front) ||
                                            can_reflect(keys->scene, object[o].surface_back))) {
            add_text(text, "|R@");
            add_name(text, object[o].name);
        }
    add_text(text, ")*");
}

/* A reflection that makes a ghost at an object of this label. */
static void add_ghost(struct text *text, const struct rmap_path_keys *keys,
                      const struct rmap_path_order *order, size_t label)
{
    const struct rmap_object *object = keys->scene->object;
    const char *joint = "(";
    for (size_t o = 0; o < order->n_object; o++)
        if (order->makes_ghosts[o] && (size_t)keys->labels.of_object[o] == label) {
            add_text(text, "%sR@", joint);
            add_name(text, object[o].name);
            joint = "|";
        }
    add_text(text, ")");
}

enum rmap_status rmap_path_ghost_criterion(const struct rmap_path_keys *keys,
                                           const struct rmap_path_order *order, size_t first,
                                           size_t second, int32_t detector, char **text_ret,
                                           struct rmap_error *err)
{
    struct text text = {.err = err};
    const size_t pair[2] = {first, second};
    add_text(&text, "registered(");
    add_name(&text, keys->scene->detector[detector].name);
    /* A path has no sides: where they matter, that it makes two ghosts and no more is said, too. */
    add_text(&text, order->by_side ? " where ghost_order == 2 and path(\"" : " where path(\"");
    for (int k = 0; k < 2; k++) {
        add_plain_steps(&text, keys, order);
        add_text(&text, " ");
        add_ghost(&text, keys, order, pair[k]);
        add_text(&text, " ");
    }
    add_plain_steps(&text, keys, order);
    add_text(&text, keys->hit[detector].follows ? " [^V] V* V@" : " V@");
    add_name(&text, keys->scene->detector[detector].name);
    add_text(&text, "\"))");
    return finish(&text, text_ret);
}
