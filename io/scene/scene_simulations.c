/* SPDX-License-Identifier: MIT
 *
 * Named simulations, and what of the scene takes part.
 *
 * `only` (and a simulation's `objects`, `sources`, `detectors`) restricts each kind (objects,
 * sources, detectors) of which it names something; `without` then takes away.
 */
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_channels.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_simulations.h"

static bool is_named(const struct rmap_yaml_node *node, const char *name)
{
    const struct rmap_yaml_node *own = rmap_yaml_get(node, "name");
    return own && own->kind == RMAP_YAML_SCALAR && strcmp(own->text, name) == 0;
}

void rmap_reader_choose_simulation(struct rmap_reader *reader)
{
    enum { SHOWN = 64 };
    const char *known[SHOWN];
    size_t n = 0;
    const char *wanted = reader->bundle->options.simulation;
    const struct rmap_yaml_node *list = rmap_yaml_get(reader->root, "simulations");
    if (!wanted)
        return;
    for (size_t i = 0; list && list->kind == RMAP_YAML_LIST && i < list->n_item; i++) {
        const struct rmap_yaml_node *name = rmap_yaml_get(list->item[i].value, "name");
        if (is_named(list->item[i].value, wanted)) {
            reader->simulation = list->item[i].value;
            return;
        }
        if (name && name->kind == RMAP_YAML_SCALAR && n < SHOWN)
            known[n++] = name->text;
    }
    rmap_reader_unknown(reader, 0, 0, "unknown simulation", wanted, known, n);
}

enum rmap_status rmap_reader_set_simulation(struct rmap_reader *reader)
{
    const char *wanted = reader->bundle->options.simulation;
    const struct rmap_yaml_node *list = rmap_yaml_get(reader->root, "simulations"), *set = NULL;
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; wanted && list && list->kind == RMAP_YAML_LIST && i < list->n_item && !set;
         i++)
        if (is_named(list->item[i].value, wanted))
            set = rmap_yaml_get(list->item[i].value, "set");
    for (size_t i = 0; set && set->kind == RMAP_YAML_MAP && i < set->n_item && st == RMAP_OK; i++)
        st = rmap_yaml_put(reader->own, &set->item[i], reader->diagnostics, reader->err);
    return st;
}

static bool read_time(struct rmap_reader *reader, const struct rmap_yaml_node *node, double *time_s)
{
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "time_limit");
    const char *text = rmap_reader_text(reader, node, "time_limit", RMAP_OPTIONAL), *unit = NULL;
    double value = 0;
    if (!text)
        return true;
    if (rmap_reader_parse_quantity(text, &value, &unit) && value > 0) {
        const struct rmap_written_unit *of =
            rmap_unit_of_scene(unit[0] ? unit : "s", RMAP_DIMENSION_TIME);
        if (of) {
            *time_s = value * of->size;
            return true;
        }
    }
    rmap_reader_error(reader, at,
                      "'time_limit' must be a time greater than 0, as in '60 s', '5 min' or '2 h', "
                      "not '%.40s'",
                      text);
    return false;
}

/* ---- selection ---- */

enum keep { KEEP_DEFAULT, KEEP_CHOSEN, KEEP_LEFT_OUT };

struct selection {
    struct rmap_reader *reader;
    enum keep *object, *source, *detector;
    bool only_objects, only_sources, only_detectors;
};

static void mark_member(struct selection *s, const struct rmap_name *name, enum keep mark)
{
    const struct rmap_scene *scene = s->reader->scene;
    bool chosen = mark == KEEP_CHOSEN;
    if (name->index < 0)
        return;
    switch ((enum rmap_member)name->kind) {
    case RMAP_MEMBER_OBJECT:
        s->object[name->index] = mark;
        s->only_objects |= chosen;
        return;
    case RMAP_MEMBER_GROUP:
        for (size_t i = 0; i < scene->n_object; i++)
            if (rmap_scene_in_group(scene, (int32_t)i, name->index))
                s->object[i] = mark;
        for (size_t i = 0; mark == KEEP_LEFT_OUT && i < scene->n_source; i++)
            if (rmap_scene_group_within(scene, scene->source[i].parent, name->index))
                s->source[i] = mark;
        s->only_objects |= chosen;
        return;
    case RMAP_MEMBER_SOURCE:
        s->source[name->index] = mark;
        s->only_sources |= chosen;
        return;
    case RMAP_MEMBER_DETECTOR:
        s->detector[name->index] = mark;
        s->only_detectors |= chosen;
        return;
    }
}

/* mark is applied only if `apply`; names are checked in any case. kind: -1 for any. */
static void mark_name(struct selection *s, const struct rmap_yaml_node *at, const char *text,
                      const char *what, enum keep mark, bool apply)
{
    const struct rmap_name *name = rmap_names_find(&s->reader->members, text);
    if (!name)
        (void)rmap_reader_find(s->reader, &s->reader->members, what, at, text);
    else if (apply)
        mark_member(s, name, mark);
}

static void mark_list(struct selection *s, const struct rmap_yaml_node *node, const char *key,
                      enum keep mark, bool apply)
{
    struct rmap_reader *reader = s->reader;
    const struct rmap_yaml_node *list = rmap_yaml_get(node, key);
    char what[80];
    (void)snprintf(what, sizeof what, "name in '%s':", key);
    if (!list)
        return;
    if (list->kind == RMAP_YAML_SCALAR) {
        mark_name(s, list, list->text, what, mark, apply);
        return;
    }
    (void)snprintf(what, sizeof what, "'%s'", key);
    if (!rmap_reader_check_list(reader, list, what))
        return;
    (void)snprintf(what, sizeof what, "name in '%s':", key);
    for (size_t i = 0; i < list->n_item; i++) {
        const struct rmap_yaml_node *item = list->item[i].value;
        if (item->kind == RMAP_YAML_SCALAR)
            mark_name(s, item, item->text, what, mark, apply);
        else
            rmap_reader_error(reader, item, "a name must stand here");
    }
}

/* A simulation that selects no detectors at all says `detectors: []`. */
static void note_empty(struct selection *s, const struct rmap_yaml_node *node)
{
    const struct rmap_yaml_node *objects = rmap_yaml_get(node, "objects");
    const struct rmap_yaml_node *detectors = rmap_yaml_get(node, "detectors");
    s->only_objects |= objects && objects->kind == RMAP_YAML_LIST && !objects->n_item;
    s->only_detectors |= detectors && detectors->kind == RMAP_YAML_LIST && !detectors->n_item;
}

static const struct rmap_range rays = {1, 0x1p53, NULL};
const struct rmap_mapping rmap_simulation_keys = {
    "simulations",
    NULL,
    {{"a simulation",
      "name set rays time_limit time only without objects sources detectors color record limits"}},
    {{"rays", RMAP_KEY_WHOLE, offsetof(struct rmap_simulation, rays), &rays},
     {"record", RMAP_KEY_TRUTH, offsetof(struct rmap_simulation, record)}}};

static void read_simulation(struct selection *s, const struct rmap_yaml_node *node)
{
    struct rmap_reader *reader = s->reader;
    bool chosen = node == reader->simulation;
    struct rmap_simulation local = {.record = true};
    struct rmap_simulation *simulation = chosen ? &reader->scene->simulation : &local;
    int color = 0;
    if (!rmap_reader_known(reader, node, &rmap_simulation_keys, 0))
        return;
    (void)rmap_reader_name(reader, node);
    (void)rmap_reader_fill(reader, node, &rmap_simulation_keys, 0, simulation);
    const struct rmap_yaml_node *set = rmap_yaml_get(node, "set");
    if (set && set->kind != RMAP_YAML_MAP)
        rmap_reader_error(reader, set, "'set' is a mapping, as in {objects.image.at: [0, 0, 50]}");
    (void)read_time(reader, node, &simulation->time_limit_s);
    if (!chosen) {
        (void)rmap_reader_choice(reader, node, "color", RMAP_OPTIONAL, "spectral rgb", &color);
        (void)rmap_reader_choice(reader, node, "time", RMAP_OPTIONAL, "off on", &color);
    }
    uint64_t steps = reader->scene->limit_steps;
    double weight = reader->scene->limit_weight;
    rmap_reader_limits(reader, rmap_yaml_get(node, "limits"));
    if (!chosen) {
        reader->scene->limit_steps = steps;
        reader->scene->limit_weight = weight;
    }
    mark_list(s, node, "only", KEEP_CHOSEN, chosen);
    mark_list(s, node, "objects", KEEP_CHOSEN, chosen);
    mark_list(s, node, "sources", KEEP_CHOSEN, chosen);
    mark_list(s, node, "detectors", KEEP_CHOSEN, chosen);
    mark_list(s, node, "without", KEEP_LEFT_OUT, chosen);
    if (chosen)
        note_empty(s, node);
}

static void read_simulations(struct selection *s)
{
    struct rmap_reader *reader = s->reader;
    const struct rmap_yaml_node *list = rmap_yaml_get(reader->root, "simulations");
    if (!list || !rmap_reader_check_list(reader, list, "'simulations'"))
        return;
    for (size_t i = 0; i < list->n_item; i++) {
        const struct rmap_yaml_node *name = rmap_yaml_get(list->item[i].value, "name");
        read_simulation(s, list->item[i].value);
        for (size_t k = 0; name && name->kind == RMAP_YAML_SCALAR && k < i; k++) {
            if (!is_named(list->item[k].value, name->text))
                continue;
            rmap_reader_error(reader, name,
                              "the name '%.60s' is taken by the simulation on line %d", name->text,
                              list->item[k].value->line);
            break;
        }
    }
}

static void mark_options(struct selection *s)
{
    const struct rmap_scene_options *options = &s->reader->bundle->options;
    const struct rmap_yaml_node nowhere = {.line = 0, .column = 0};
    for (size_t i = 0; i < options->n_only; i++)
        mark_name(s, &nowhere, options->only[i], "name in --only:", KEEP_CHOSEN, true);
    for (size_t i = 0; i < options->n_without; i++)
        mark_name(s, &nowhere, options->without[i], "name in --without:", KEEP_LEFT_OUT, true);
}

static bool kept(enum keep mark, bool only)
{
    return mark == KEEP_CHOSEN || (mark == KEEP_DEFAULT && !only);
}

static void drop_unchosen(struct selection *s)
{
    struct rmap_reader *reader = s->reader;
    const struct rmap_scene *scene = reader->scene;
    struct rmap_keep keep = {.object = rmap_reader_alloc(reader, scene->n_object, sizeof(bool)),
                             .source = rmap_reader_alloc(reader, scene->n_source, sizeof(bool)),
                             .detector =
                                 rmap_reader_alloc(reader, scene->n_detector, sizeof(bool))};
    if (!keep.object || !keep.source || !keep.detector)
        return;
    for (size_t i = 0; i < scene->n_object; i++)
        keep.object[i] = kept(s->object[i], s->only_objects);
    for (size_t i = 0; i < scene->n_source; i++)
        keep.source[i] = kept(s->source[i], s->only_sources);
    for (size_t i = 0; i < scene->n_detector; i++)
        keep.detector[i] =
            i >= scene->n_detector - reader->n_receiver || kept(s->detector[i], s->only_detectors);
    const size_t n_source = scene->n_source;
    rmap_reader_reduce(reader, &keep);
    if (!scene->n_source && n_source > 0)
        rmap_reader_error(reader, NULL, "no sources: all of them are left out");
}

void rmap_reader_read_simulations(struct rmap_reader *reader)
{
    struct rmap_scene *scene = reader->scene;
    struct selection s = {.reader = reader,
                          .object = rmap_reader_alloc(reader, scene->n_object, sizeof(enum keep)),
                          .source = rmap_reader_alloc(reader, scene->n_source, sizeof(enum keep)),
                          .detector =
                              rmap_reader_alloc(reader, scene->n_detector, sizeof(enum keep))};
    if (!s.object || !s.source || !s.detector)
        return;
    if (reader->simulation)
        scene->simulation.name = rmap_reader_strdup(reader, reader->bundle->options.simulation);
    read_simulations(&s);
    mark_options(&s);
    if (reader->diagnostics->n_error == 0)
        drop_unchosen(&s);
}
