/* SPDX-License-Identifier: MIT
 *
 * What tells the paths of rays apart: a path as a row of symbols, written for people, and written
 * as the criterion that selects exactly the rays with that path.
 */
#include <xxhash.h>

#include "analysis/paths/path_key.h"
#include "analysis/paths/path_key_internal.h"
#include "analysis/paths/path_label.h"
#include "base/alloc.h"
#include "portion/event.h"

const char *rmap_path_level_word(enum rmap_path_level level)
{
    static const char *const word[] = {"surface", "object", "group"};
    return word[level];
}

/* What lies below a group: how many objects, and whether one entry of the scene file made them. */
struct members {
    size_t n;
    int32_t line, column;
    bool mixed;
};

static void add_member(struct members *members, const struct rmap_object *object)
{
    if (members->n > 0 && (members->line != object->line || members->column != object->column))
        members->mixed = true;
    members->line = object->line;
    members->column = object->column;
    members->n++;
}

/* The group that stands for the object, or -1: the object itself. */
static int32_t choose_group(const struct rmap_scene *scene, const struct rmap_object *object,
                            enum rmap_path_level level, const struct members *members)
{
    int32_t chosen = -1;
    if (level == RMAP_PATH_SURFACE)
        return -1;
    for (int32_t g = object->parent; g >= 0; g = scene->group[g].parent) {
        bool wider = members[g].n > (chosen < 0 ? 1 : members[chosen].n);
        if (level == RMAP_PATH_GROUP || (!members[g].mixed && wider))
            chosen = g;
    }
    return chosen;
}

/* Labels are numbered by their first objects. Released by fini whatever happened. */
static enum rmap_status path_labels_init(struct rmap_path_labels *labels,
                                         const struct rmap_scene *scene, enum rmap_path_level level,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int32_t *of_group = rmap_alloc(scene->n_group + 1, sizeof *of_group);
    struct members *members = rmap_alloc(scene->n_group + 1, sizeof *members);
    *labels = (struct rmap_path_labels){
        .name = rmap_alloc(scene->n_object + 1, sizeof *labels->name),
        .of_object = rmap_alloc(scene->n_object + 1, sizeof *labels->of_object)};
    if (!of_group || !members || !labels->name || !labels->of_object) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the names of %zu objects",
                            scene->n_object);
        goto out;
    }
    for (size_t o = 0; o < scene->n_object; o++)
        for (int32_t g = scene->object[o].parent; g >= 0; g = scene->group[g].parent)
            add_member(&members[g], &scene->object[o]);
    for (size_t o = 0; o < scene->n_object; o++) {
        int32_t group = choose_group(scene, &scene->object[o], level, members);
        int32_t label = group < 0 ? 0 : of_group[group];
        if (label == 0) {
            labels->name[labels->n++] =
                group < 0 ? scene->object[o].name : scene->group[group].name;
            label = (int32_t)labels->n;
        }
        if (group >= 0)
            of_group[group] = label;
        labels->of_object[o] = label - 1;
    }
out:
    rmap_free(of_group);
    rmap_free(members);
    return st;
}

static void path_labels_fini(struct rmap_path_labels *labels)
{
    rmap_free(labels->name);
    rmap_free(labels->of_object);
    *labels = (struct rmap_path_labels){0};
}

static enum rmap_status allocate(struct rmap_path_keys *keys, struct rmap_error *err)
{
    const struct rmap_scene *scene = keys->scene;
    keys->letter = rmap_alloc(RMAP_PATH_EVENT_CODES, 1);
    keys->met = rmap_alloc(RMAP_PATH_EVENT_CODES, sizeof *keys->met);
    keys->place = rmap_alloc(scene->n_object + 1, sizeof *keys->place);
    keys->hit = rmap_alloc(scene->n_detector + 1, sizeof *keys->hit);
    keys->clashes = rmap_alloc(scene->n_medium + 1, 1);
    if (keys->letter && keys->met && keys->place && keys->hit && keys->clashes)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the names of paths");
}

/* Media that have the name of an object or a group. */
static void find_clashes(struct rmap_path_keys *keys)
{
    const struct rmap_scene *scene = keys->scene;
    for (size_t m = 0; m < scene->n_medium; m++) {
        const char *name = scene->medium[m].name;
        for (size_t o = 0; o < scene->n_object && !keys->clashes[m]; o++)
            keys->clashes[m] = strcmp(scene->object[o].name, name) == 0;
        for (size_t g = 0; g < scene->n_group && !keys->clashes[m]; g++)
            keys->clashes[m] = strcmp(scene->group[g].name, name) == 0;
    }
}

static void fill_letters(struct rmap_path_keys *keys)
{
    for (uint32_t events = 0; events < RMAP_PATH_EVENT_CODES; events++) {
        const char c = rmap_event_letter(events);
        const uint32_t letter =
            c ? (uint32_t)(strchr(RMAP_PATH_LETTERS, c) - RMAP_PATH_LETTERS) : RMAP_PATH_LETTER_ANY;
        keys->letter[events] = (uint8_t)letter;
        keys->met[events] = keys->view.without_events ? RMAP_PATH_LETTER_ANY : (uint8_t)letter;
    }
}

static void fill_hits(struct rmap_path_keys *keys)
{
    const struct rmap_scene *scene = keys->scene;
    for (size_t d = 0; d < scene->n_detector; d++) {
        const size_t place = 1 + keys->labels.n + scene->n_medium + d;
        keys->hit[d] = (struct rmap_path_hit){
            (rmap_path_step)(place << RMAP_PATH_LETTER_BITS) | RMAP_PATH_LETTER_V,
            scene->detector[d].on_object >= 0 || scene->detector[d].on_group >= 0};
    }
}

enum rmap_status rmap_path_keys_create(const struct rmap_scene *scene,
                                       const struct rmap_path_view *view,
                                       struct rmap_path_keys **keys_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_keys *keys = rmap_alloc(1, sizeof *keys);
    if (!keys)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the names of paths");
    *keys = (struct rmap_path_keys){.scene = scene, .view = *view};
    RMAP_TRY(path_labels_init(&keys->labels, scene, view->level, err));
    RMAP_TRY(allocate(keys, err));
    fill_letters(keys);
    for (size_t o = 0; o < scene->n_object; o++)
        keys->place[o + 1] = (uint32_t)(1 + keys->labels.of_object[o]) << RMAP_PATH_LETTER_BITS;
    fill_hits(keys);
    for (size_t m = 0; m < scene->n_medium; m++)
        keys->reads_media |= scene->medium[m].absorbing || scene->medium[m].scattering_at_all;
    find_clashes(keys);
    *keys_ret = keys;
    keys = NULL;
out:
    rmap_path_keys_destroy(keys);
    return st;
}

void rmap_path_keys_destroy(struct rmap_path_keys *keys)
{
    if (!keys)
        return;
    path_labels_fini(&keys->labels);
    rmap_free(keys->letter);
    rmap_free(keys->met);
    rmap_free(keys->place);
    rmap_free(keys->hit);
    rmap_free(keys->clashes);
    rmap_free(keys);
}

const struct rmap_path_view *rmap_path_keys_view(const struct rmap_path_keys *keys)
{
    return &keys->view;
}

rmap_column_set rmap_path_keys_columns(const struct rmap_path_keys *keys)
{
    rmap_column_set columns =
        RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_source) |
        RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |
        RMAP_COLUMN_BIT(RMAP_SEGMENT_object) | RMAP_COLUMN_BIT(RMAP_SEGMENT_event) |
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) |
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered);
    return keys->reads_media ? columns | RMAP_COLUMN_BIT(RMAP_SEGMENT_medium) : columns;
}

/* Where symbols go. */
struct writer {
    rmap_path_step *symbol;
    size_t n;
    bool collapsed;
};

static inline void write_symbol(struct writer *writer, rmap_path_step symbol)
{
    if (!writer->collapsed || writer->n == 0 || writer->symbol[writer->n - 1] != symbol)
        writer->symbol[writer->n++] = symbol;
}

static void write_steps(const struct rmap_path_keys *keys, const struct rmap_segment_columns *rows,
                        size_t first, size_t last, struct writer *writer)
{
    for (size_t i = first; i < last; i++)
        write_symbol(writer, rmap_path_step_of(keys, rows, i));
}

/* Steps up to where a registration stands; *at is moved there. With `last` the step at the object
 * on which its detector lies is of any letter. */
static void write_before(const struct rmap_path_keys *keys, const struct rmap_portion *portion,
                         size_t first, size_t row, size_t n_segment, bool last, size_t *at,
                         struct writer *writer)
{
    int32_t detector = portion->registration.detector[row];
    size_t place = (size_t)portion->registration.segment[row] + keys->hit[detector].follows;
    place = place < n_segment ? place : n_segment;
    bool opens = last && keys->hit[detector].follows && place > *at;
    if (place > *at)
        write_steps(keys, &portion->segment, first + *at, first + place - opens, writer);
    if (opens) {
        rmap_path_step symbol = rmap_path_step_of(keys, &portion->segment, first + place - 1);
        write_symbol(writer, (symbol >> RMAP_PATH_LETTER_BITS << RMAP_PATH_LETTER_BITS) |
                                 RMAP_PATH_LETTER_ANY);
    }
    *at = place > *at ? place : *at;
}

/* The whole path. False: the ray has none. */
static inline bool walk(const struct rmap_path_keys *keys, const struct rmap_portion *portion,
                        const struct rmap_path_place_of_ray *place, struct writer *writer)
{
    const size_t n_segment = portion->ray.segment_count[place->ray];
    const size_t n_hit = portion->ray.registration_count[place->ray];
    size_t at = 0;
    for (size_t i = place->registration; i < place->registration + n_hit; i++) {
        if (!portion->registration.registered[i])
            continue;
        int32_t detector = portion->registration.detector[i];
        const bool last = keys->view.until_detector && detector == keys->view.detector &&
                          (place->until == 0 || place->until == i + 1);
        write_before(keys, portion, place->segment, i, n_segment, last, &at, writer);
        write_symbol(writer, keys->hit[detector].step);
        if (last)
            return true;
    }
    write_steps(keys, &portion->segment, place->segment + at, place->segment + n_segment, writer);
    return !keys->view.until_detector;
}

bool rmap_path_key_of(const struct rmap_path_keys *keys, const struct rmap_portion *portion,
                      const struct rmap_path_place_of_ray *place, rmap_path_step *symbol,
                      size_t *n_ret)
{
    struct writer writer = {.symbol = symbol, .collapsed = keys->view.collapsed};
    bool has_path = walk(keys, portion, place, &writer);
    *n_ret = writer.n;
    return has_path;
}

/* Sources are told apart in either half: cells and the sketch go by the lower one. Not by a seed,
 * with which short paths of two sources were seen to share 64 bits. */
struct rmap_key rmap_path_key_hash(const rmap_path_step *symbol, size_t n, int32_t source)
{
    enum { SOURCE_BITS = 20 };
    const uint64_t its = (uint32_t)source;
    const XXH128_hash_t hash = XXH3_128bits(symbol, n * sizeof *symbol);
    return (struct rmap_key){hash.low64 + (its + 1) * UINT64_C(0x9e3779b97f4a7c15),
                             UINT64_C(1) << 63 | hash.high64 << SOURCE_BITS | its};
}

size_t rmap_path_n_label(const struct rmap_path_keys *keys)
{
    return keys->labels.n;
}

const char *rmap_path_label(const struct rmap_path_keys *keys, size_t label)
{
    return keys->labels.name[label];
}

const int32_t *rmap_path_labels(const struct rmap_path_keys *keys)
{
    return keys->labels.of_object;
}
