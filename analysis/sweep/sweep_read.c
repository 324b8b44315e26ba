/* SPDX-License-Identifier: MIT
 *
 * A sweep's file: YAML with the scene's strictness, every mistake with its line.
 */
#include <math.h>
#include <string.h>

#include "analysis/sweep/sweep.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/scene/scene_reader.h"

enum { KEYS_MAX = 64, PARAMETERS_MAX = 64, ANSWERS_MAX = 256, VALUES_MAX = 1000000 };

struct reading {
    struct rmap_reader reader;
    struct rmap_bundle bundle; /* nothing: complaints ask it for --set */
    struct rmap_sweep *sweep;
};

/* The items of a mapping {NAME: ...} or a list, at most `most` of them. */
static bool check_items(struct reading *self, const struct rmap_yaml_node *node, const char *what,
                        enum rmap_yaml_kind kind, size_t most)
{
    if (node->kind != kind || node->n_item == 0) {
        rmap_reader_error(&self->reader, node, "%s must be %s that is not empty", what,
                          kind == RMAP_YAML_MAP ? "a mapping {NAME: {...}}" : "a list");
        return false;
    }
    if (node->n_item > most) {
        rmap_reader_error(&self->reader, node, "%s: %zu of them, and %zu are the most", what,
                          node->n_item, most);
        return false;
    }
    return true;
}

static bool ends_in(const char *name, const char *end)
{
    const size_t len = strlen(name), n = strlen(end);
    return len >= n && strcmp(name + len - n, end) == 0;
}

/* Names head columns of tables and stand in `require`. */
static bool check_name(struct reading *self, const struct rmap_yaml_item *item)
{
    const struct rmap_yaml_node at = {.line = item->line, .column = item->column};
    if (!rmap_reader_check_name(&self->reader, &at, item->key))
        return false;
    if (strcmp(item->key, "variant") == 0 || strcmp(item->key, "met") == 0 ||
        ends_in(item->key, "_error") || ends_in(item->key, "_difference"))
        rmap_reader_error(&self->reader, &at,
                          "'%s': the table has columns 'variant', 'met', and NAME_error and "
                          "NAME_difference of every answer: choose another name",
                          item->key);
    else if (strpbrk(item->key, "/,;<>= "))
        rmap_reader_error(&self->reader, &at,
                          "'%s' heads columns of the table: a name without / , ; < > = and blanks",
                          item->key);
    else
        return true;
    return false;
}

/* Either one text under `one`, or a list of them under `many`. */
static void read_keys(struct reading *self, const struct rmap_yaml_node *node, const char *name,
                      struct rmap_sweep_parameter *parameter)
{
    struct rmap_reader *reader = &self->reader;
    const struct rmap_yaml_node *list = rmap_yaml_get(node, "keys");
    const char *key = rmap_reader_text(reader, node, "key", RMAP_OPTIONAL);
    size_t n = 1;
    if (list && key)
        rmap_reader_error(reader, list, "give 'key', or several as 'keys', not both");
    if (list && check_items(self, list, "'keys'", RMAP_YAML_LIST, KEYS_MAX))
        n = list->n_item;
    parameter->key = rmap_reader_alloc(reader, n, sizeof *parameter->key);
    parameter->nominal = rmap_reader_alloc(reader, n, sizeof *parameter->nominal);
    if (!parameter->key || !parameter->nominal)
        return;
    parameter->n_key = n;
    parameter->key[0] = key ? key : name;
    for (size_t i = 0; list && list->kind == RMAP_YAML_LIST && i < n && list->n_item >= n; i++) {
        const struct rmap_yaml_node *one = list->item[i].value;
        parameter->key[i] = one->text;
        if (one->kind != RMAP_YAML_SCALAR || !one->text[0]) {
            rmap_reader_error(reader, one,
                              "a key of the scene must stand here, as objects.lens.at.3");
            parameter->key[i] = name;
        }
    }
    for (size_t i = 0; i < n; i++)
        if (strchr(parameter->key[i], '=') || strchr(parameter->key[i], '['))
            rmap_reader_error(
                reader, node,
                "'%.60s' is no key: write key.path as for --set, with parts of a list "
                "by number from 1 (objects.lens.at.3)",
                parameter->key[i]);
}

static double *new_values(struct reading *self, struct rmap_sweep_parameter *parameter, size_t n)
{
    parameter->value = rmap_reader_alloc(&self->reader, n, sizeof *parameter->value);
    parameter->text = rmap_reader_alloc(&self->reader, n, sizeof *parameter->text);
    parameter->n_value = parameter->value && parameter->text ? n : 0;
    return parameter->n_value ? parameter->value : NULL;
}

static void read_values(struct reading *self, const struct rmap_yaml_node *list,
                        struct rmap_sweep_parameter *parameter)
{
    if (!check_items(self, list, "'values'", RMAP_YAML_LIST, VALUES_MAX) ||
        !new_values(self, parameter, list->n_item))
        return;
    for (size_t i = 0; i < list->n_item; i++) {
        const struct rmap_yaml_node *one = list->item[i].value;
        const bool is_text = one->kind == RMAP_YAML_SCALAR && one->text[0];
        parameter->text[i] = is_text ? one->text : "0";
        if (!is_text)
            rmap_reader_error(&self->reader, one, "a number or a word must stand here");
        else if (parameter->of_simulation || one->quoted ||
                 !rmap_reader_parse_number(one->text, strlen(one->text), &parameter->value[i])) {
            parameter->value[i] = (double)NAN;
            if (parameter->change != RMAP_SWEEP_REPLACE)
                rmap_reader_error(&self->reader, one,
                                  "'%.60s' is no number, and '%s' is said of numbers", one->text,
                                  parameter->change == RMAP_SWEEP_PLUS ? "plus" : "times");
        }
    }
}

/* Both ends are among the values. */
static void read_range(struct reading *self, const struct rmap_yaml_node *node,
                       struct rmap_sweep_parameter *parameter)
{
    struct rmap_reader *reader = &self->reader;
    uint64_t count = 0;
    if (!rmap_reader_check_map(reader, node, "'range'", "from to count") ||
        !rmap_reader_number(reader, node, "from", RMAP_REQUIRED, &rmap_range_any,
                            &parameter->from) ||
        !rmap_reader_number(reader, node, "to", RMAP_REQUIRED, &rmap_range_any, &parameter->to))
        return;
    if (!rmap_yaml_get(node, "count"))
        rmap_reader_error(reader, node, "'range' wants a 'count' of values from 'from' to 'to'");
    else if (rmap_reader_whole(reader, node, "count", 2, VALUES_MAX, &count) &&
             new_values(self, parameter, (size_t)count))
        for (size_t i = 0; i < count; i++) {
            const double part = (double)i / (double)(count - 1);
            parameter->value[i] = i + 1 == count
                                      ? parameter->to
                                      : parameter->from + part * (parameter->to - parameter->from);
        }
}

static void read_distribution(struct reading *self, const struct rmap_yaml_node *node,
                              struct rmap_sweep_parameter *parameter)
{
    struct rmap_reader *reader = &self->reader;
    const struct rmap_yaml_node *normal, *uniform;
    if (!rmap_reader_check_map(reader, node, "'distribution'", "normal uniform"))
        return;
    normal = rmap_yaml_get(node, "normal");
    uniform = rmap_yaml_get(node, "uniform");
    if (!normal == !uniform) {
        rmap_reader_error(reader, node,
                          "'distribution' is one of {normal: {mean, sigma, cut}} and {uniform: "
                          "{from, to}}");
    } else if (normal && rmap_reader_check_map(reader, normal, "'normal'", "mean sigma cut")) {
        parameter->spread = RMAP_SWEEP_NORMAL;
        parameter->mean = parameter->change == RMAP_SWEEP_TIMES ? 1.0 : 0.0;
        (void)rmap_reader_number(reader, normal, "mean",
                                 parameter->change == RMAP_SWEEP_REPLACE ? RMAP_REQUIRED
                                                                         : RMAP_OPTIONAL,
                                 &rmap_range_any, &parameter->mean);
        (void)rmap_reader_number(reader, normal, "sigma", RMAP_REQUIRED, &rmap_range_nonnegative,
                                 &parameter->sigma);
        static const struct rmap_range cut = {0.1, 100.0, "a number of sigmas from 0.1 to 100",
                                              RMAP_DIMENSION_NONE};
        (void)rmap_reader_number(reader, normal, "cut", RMAP_OPTIONAL, &cut, &parameter->cut);
    } else if (uniform && rmap_reader_check_map(reader, uniform, "'uniform'", "from to")) {
        parameter->spread = RMAP_SWEEP_UNIFORM;
        if (rmap_reader_number(reader, uniform, "from", RMAP_REQUIRED, &rmap_range_any,
                               &parameter->from) &&
            rmap_reader_number(reader, uniform, "to", RMAP_REQUIRED, &rmap_range_any,
                               &parameter->to) &&
            !(parameter->from < parameter->to))
            rmap_reader_error(reader, uniform, "'from' must be less than 'to'");
    }
}

static void read_change(struct reading *self, const struct rmap_yaml_node *node,
                        struct rmap_sweep_parameter *parameter)
{
    bool plus = false, times = false;
    (void)rmap_reader_bool(&self->reader, node, "plus", &plus);
    (void)rmap_reader_bool(&self->reader, node, "times", &times);
    if (plus && times)
        rmap_reader_error(&self->reader, node, "'plus' and 'times': give one");
    parameter->change = plus ? RMAP_SWEEP_PLUS : times ? RMAP_SWEEP_TIMES : RMAP_SWEEP_REPLACE;
}

static void read_parameter(struct reading *self, const struct rmap_yaml_item *item,
                           struct rmap_sweep_parameter *parameter)
{
    struct rmap_reader *reader = &self->reader;
    const struct rmap_yaml_node *node = item->value;
    *parameter = (struct rmap_sweep_parameter){.name = item->key, .unit = "", .node = node};
    if (!check_name(self, item) ||
        !rmap_reader_check_map(reader, node, "a parameter",
                               "key keys values range distribution plus times unit"))
        return;
    const char *unit = rmap_reader_text(reader, node, "unit", RMAP_OPTIONAL);
    parameter->unit = unit ? unit : "";
    read_change(self, node, parameter);
    read_keys(self, node, item->key, parameter);
    parameter->of_simulation =
        parameter->n_key == 1 && strcmp(parameter->key[0], "simulation") == 0;
    const struct rmap_yaml_node *values = rmap_yaml_get(node, "values");
    const struct rmap_yaml_node *range = rmap_yaml_get(node, "range");
    const struct rmap_yaml_node *spread = rmap_yaml_get(node, "distribution");
    if (!!values + !!range + !!spread != 1)
        rmap_reader_error(reader, node,
                          "a parameter has one of 'values: [...]', 'range: {from, to, count}' and "
                          "'distribution: {...}'");
    else if (values)
        read_values(self, values, parameter);
    else if (range)
        read_range(self, range, parameter);
    else
        read_distribution(self, spread, parameter);
    if (parameter->of_simulation && (!values || parameter->change != RMAP_SWEEP_REPLACE))
        rmap_reader_error(reader, node,
                          "'simulation' takes 'values: [NAME, ...]' of the scene's simulations");
    if (!spread && parameter->n_value == 0 && reader->diagnostics->n_error == 0)
        rmap_reader_no_memory(reader);
}

/* A criterion under `key`, which may be `all`. */
static const char *read_criterion(struct reading *self, const struct rmap_yaml_node *node,
                                  const char *key)
{
    const char *text = rmap_reader_text(&self->reader, node, key, RMAP_OPTIONAL);
    return text && strcmp(text, "all") != 0 ? text : NULL;
}

static void read_answer(struct reading *self, const struct rmap_yaml_item *item,
                        struct rmap_sweep_answer *answer)
{
    struct rmap_reader *reader = &self->reader;
    const struct rmap_yaml_node *node = item->value;
    *answer = (struct rmap_sweep_answer){.name = item->key, .line = item->line};
    if (!check_name(self, item) ||
        !rmap_reader_check_map(reader, node, "an answer",
                               "flux rays detector statistic of where unit"))
        return;
    const bool flux = rmap_yaml_get(node, "flux"), rays = rmap_yaml_get(node, "rays");
    const bool statistic = rmap_yaml_get(node, "statistic");
    answer->detector = rmap_reader_text(reader, node, "detector", RMAP_OPTIONAL);
    answer->unit = rmap_reader_text(reader, node, "unit", RMAP_OPTIONAL);
    answer->where = read_criterion(self, node, "where");
    const bool detector = answer->detector && !statistic;
    if (flux + rays + statistic + detector != 1) {
        rmap_reader_error(reader, node,
                          "an answer is one of 'flux: CRITERION', 'rays: CRITERION', 'detector: "
                          "NAME' and 'statistic: NUMBER'");
        return;
    }
    if ((flux || rays) && (answer->where || answer->unit || rmap_yaml_get(node, "of"))) {
        rmap_reader_error(reader, node,
                          "'of', 'where' and 'unit' are said of a detector or a statistic; the "
                          "criterion stands behind '%s'",
                          flux ? "flux" : "rays");
    } else if (flux || rays) {
        answer->kind = flux ? RMAP_SWEEP_FLUX : RMAP_SWEEP_RAYS;
        answer->where = read_criterion(self, node, flux ? "flux" : "rays");
    } else if (statistic) {
        answer->kind = RMAP_SWEEP_STATISTIC;
        answer->number = rmap_reader_text(reader, node, "statistic", RMAP_REQUIRED);
        (void)rmap_reader_choice(reader, node, "of", RMAP_OPTIONAL, RMAP_SWEEP_OF_STATISTIC,
                                 &answer->of);
    } else {
        answer->kind = RMAP_SWEEP_DETECTOR;
        (void)rmap_reader_choice(reader, node, "of", RMAP_OPTIONAL, RMAP_SWEEP_OF_DETECTOR,
                                 &answer->of);
        if (answer->unit &&
            (answer->of < RMAP_SWEEP_OF_MEAN || answer->of > RMAP_SWEEP_OF_GREATEST))
            rmap_reader_error(reader, node, "'unit' is said of values of cells, not of this");
    }
}

/* "NAME < NUMBER" */
static void read_require(struct reading *self, const struct rmap_yaml_node *at)
{
    struct rmap_sweep *sweep = self->sweep;
    struct rmap_sweep_require *require = &sweep->require[sweep->n_require];
    const char *text = at->kind == RMAP_YAML_SCALAR ? at->text : "", *sign = strpbrk(text, "<>");
    if (!sign) {
        rmap_reader_error(&self->reader, at,
                          "a requirement is 'ANSWER < NUMBER' or 'ANSWER > NUMBER'");
        return;
    }
    size_t len = (size_t)(sign - text), n = 0;
    const char *name[ANSWERS_MAX];
    *require = (struct rmap_sweep_require){
        .text = text, .answer = SIZE_MAX, .below = sign[0] == '<', .or_equal = sign[1] == '='};
    while (len > 0 && text[len - 1] == ' ')
        len--;
    const char *number = sign + 1 + require->or_equal;
    number += strspn(number, " ");
    char word[80] = {0};
    memcpy(word, text, len < sizeof word ? len : sizeof word - 1);
    for (size_t i = 0; i < sweep->n_answer; i++) {
        name[n++] = sweep->answer[i].name;
        if (strcmp(word, sweep->answer[i].name) == 0)
            require->answer = i;
    }
    if (require->answer == SIZE_MAX)
        rmap_reader_unknown(&self->reader, at->line, at->column, "unknown answer", word, name, n);
    else if (!rmap_reader_parse_number(number, strlen(number), &require->limit))
        rmap_reader_error(&self->reader, at, "'%.40s' is no number", number);
    else
        sweep->n_require++;
}

static void read_requires(struct reading *self, const struct rmap_yaml_node *node)
{
    const bool is_list = node->kind == RMAP_YAML_LIST;
    if (is_list && !check_items(self, node, "'require'", RMAP_YAML_LIST, ANSWERS_MAX))
        return;
    self->sweep->require =
        rmap_reader_alloc(&self->reader, is_list ? node->n_item : 1, sizeof *self->sweep->require);
    if (!self->sweep->require)
        return;
    for (size_t i = 0; is_list && i < node->n_item; i++)
        read_require(self, node->item[i].value);
    if (!is_list)
        read_require(self, node);
}

/* Parameters' and answers' names head columns of one table. */
static void check_distinct(struct reading *self)
{
    const struct rmap_sweep *sweep = self->sweep;
    for (size_t i = 0; i < sweep->n_parameter; i++)
        for (size_t k = 0; k < sweep->n_answer; k++)
            if (strcmp(sweep->parameter[i].name, sweep->answer[k].name) == 0)
                rmap_reader_error(&self->reader, sweep->parameter[i].node,
                                  "'%s' is an answer, too: a parameter wants a name of its own",
                                  sweep->parameter[i].name);
}

static void count_variants(struct reading *self)
{
    struct rmap_sweep *sweep = self->sweep;
    double n = 1.0;
    for (size_t i = 0; i < sweep->n_parameter; i++) {
        const struct rmap_sweep_parameter *p = &sweep->parameter[i];
        const double own = (double)p->n_value;
        if (p->spread != RMAP_SWEEP_VALUES && sweep->mode != RMAP_SWEEP_RANDOM)
            rmap_reader_error(&self->reader, p->node,
                              "a distribution is drawn from: 'mode: random' with 'samples'");
        else if (sweep->mode == RMAP_SWEEP_LIST && i > 0 && n != own)
            rmap_reader_error(&self->reader, p->node,
                              "'mode: list' takes the first value of each parameter, then the "
                              "second: %.0f of '%s', and %.0f of '%s'",
                              own, p->name, n, sweep->parameter[0].name);
        n = sweep->mode == RMAP_SWEEP_LIST ? own : n * own;
    }
    if (sweep->mode == RMAP_SWEEP_RANDOM)
        n = (double)sweep->n_sample;
    if (n + 1.0 > RMAP_SWEEP_VARIANTS_MAX)
        rmap_reader_error(&self->reader, sweep->root, "%.0f variants, and %d are the most", n,
                          RMAP_SWEEP_VARIANTS_MAX - 1);
    else
        sweep->n_variant = 1 + (uint64_t)n;
}

static void read_mode(struct reading *self)
{
    struct rmap_reader *reader = &self->reader;
    struct rmap_sweep *sweep = self->sweep;
    const struct rmap_yaml_node *root = sweep->root;
    int mode = RMAP_SWEEP_GRID;
    for (size_t i = 0; i < sweep->n_parameter; i++)
        if (sweep->parameter[i].spread != RMAP_SWEEP_VALUES)
            mode = RMAP_SWEEP_RANDOM;
    (void)rmap_reader_choice(reader, root, "mode", RMAP_OPTIONAL, RMAP_SWEEP_MODES, &mode);
    sweep->mode = (enum rmap_sweep_mode)mode;
    sweep->sample_seed = 1;
    (void)rmap_reader_whole(reader, root, "samples", 1, RMAP_SWEEP_VARIANTS_MAX - 1,
                            &sweep->n_sample);
    (void)rmap_reader_whole(reader, root, "sample_seed", 0, UINT64_C(1) << 53, &sweep->sample_seed);
    if (sweep->mode == RMAP_SWEEP_RANDOM && !rmap_yaml_get(root, "samples"))
        rmap_reader_error(reader, root, "random values want 'samples: N'");
    if (sweep->mode != RMAP_SWEEP_RANDOM && rmap_yaml_get(root, "samples"))
        rmap_reader_error(reader, rmap_yaml_get(root, "samples"),
                          "'samples' are of 'mode: random'; here values say how many variants "
                          "there are");
}

static void read_lists(struct reading *self)
{
    struct rmap_reader *reader = &self->reader;
    struct rmap_sweep *sweep = self->sweep;
    const struct rmap_yaml_node *parameters = rmap_yaml_get(sweep->root, "parameters");
    const struct rmap_yaml_node *answers = rmap_yaml_get(sweep->root, "answers");
    if (!parameters || !answers) {
        rmap_reader_error(reader, sweep->root, "a sweep wants 'parameters' and 'answers'");
        return;
    }
    if (!check_items(self, parameters, "'parameters'", RMAP_YAML_MAP, PARAMETERS_MAX) ||
        !check_items(self, answers, "'answers'", RMAP_YAML_MAP, ANSWERS_MAX))
        return;
    sweep->parameter = rmap_reader_alloc(reader, parameters->n_item, sizeof *sweep->parameter);
    sweep->answer = rmap_reader_alloc(reader, answers->n_item, sizeof *sweep->answer);
    if (!sweep->parameter || !sweep->answer)
        return;
    for (size_t i = 0; i < parameters->n_item; i++)
        read_parameter(self, &parameters->item[i], &sweep->parameter[sweep->n_parameter++]);
    for (size_t i = 0; i < answers->n_item; i++)
        read_answer(self, &answers->item[i], &sweep->answer[sweep->n_answer++]);
    check_distinct(self);
    if (rmap_yaml_get(sweep->root, "require"))
        read_requires(self, rmap_yaml_get(sweep->root, "require"));
}

static void read_root(struct reading *self)
{
    struct rmap_reader *reader = &self->reader;
    struct rmap_sweep *sweep = self->sweep;
    int keep = 0;
    if (!rmap_reader_check_map(reader, sweep->root, "a sweep",
                               "scene simulation rays seed mode samples sample_seed parameters "
                               "answers require keep"))
        return;
    sweep->scene_path = rmap_reader_text(reader, sweep->root, "scene", RMAP_REQUIRED);
    sweep->simulation = rmap_reader_text(reader, sweep->root, "simulation", RMAP_OPTIONAL);
    (void)rmap_reader_whole(reader, sweep->root, "rays", 1, UINT64_C(1) << 40, &sweep->n_ray);
    sweep->seed = 1;
    (void)rmap_reader_whole(reader, sweep->root, "seed", 0, UINT64_C(1) << 53, &sweep->seed);
    (void)rmap_reader_choice(reader, sweep->root, "keep", RMAP_OPTIONAL, "answers maps", &keep);
    sweep->keeps_maps = keep == 1;
    read_lists(self);
    if (reader->diagnostics->n_error == 0 && reader->status == RMAP_OK)
        read_mode(self);
    if (reader->diagnostics->n_error == 0 && reader->status == RMAP_OK)
        count_variants(self);
}

enum rmap_status rmap_sweep_read(const char *path, const char *text, size_t nbytes,
                                 struct rmap_diagnostics *diagnostics,
                                 struct rmap_sweep **sweep_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_sweep *sweep = rmap_alloc(1, sizeof *sweep);
    if (!sweep)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a sweep");
    struct reading self = {.sweep = sweep, .reader = {.diagnostics = diagnostics, .err = err}};
    self.reader.bundle = &self.bundle;
    sweep->path = path;
    sweep->text = rmap_strdup(text);
    if (!sweep->text)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a sweep"));
    st = rmap_yaml_parse(sweep->text, nbytes, &sweep->root, diagnostics, err);
    if (st == RMAP_OK && diagnostics->n_error == 0)
        read_root(&self);
    sweep->arena = self.reader.arena;
    if (st == RMAP_OK)
        st = self.reader.status;
    if ((st == RMAP_OK || st == RMAP_INPUT) && diagnostics->n_error > 0)
        st = rmap_error_set(err, RMAP_INPUT, "%s in %s",
                            rmap_counted(diagnostics->n_error, "mistake").text, path);
    RMAP_TRY(st);
    *sweep_ret = sweep;
    sweep = NULL;
out:
    rmap_sweep_destroy(sweep);
    return st;
}

void rmap_sweep_destroy(struct rmap_sweep *sweep)
{
    if (!sweep)
        return;
    struct rmap_reader reader = {.arena = sweep->arena};
    rmap_reader_release(&reader);
    rmap_yaml_destroy(sweep->scene);
    rmap_yaml_destroy(sweep->root);
    rmap_free(sweep->text);
    rmap_free(sweep);
}
