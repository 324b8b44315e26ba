/* SPDX-License-Identifier: MIT
 *
 * Rules that give objects their optical attributes.
 */
#include "io/scene/scene_attributes.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "base/glob.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_media.h"
#include "io/scene/scene_surfaces.h"

enum { RULES_MAX = 1000 };
#define TOLERANCE 0.02 /* of a colour: four steps of 255, as programs round */

const struct rmap_mapping rmap_attribute_keys = {"attributes", NULL, {{"a rule", "match set"}}};
const struct rmap_mapping rmap_match_keys = {
    "attributes", NULL, {{"what a rule matches", "name group id material color tolerance face"}}};
const struct rmap_mapping rmap_set_keys = {
    "attributes",
    NULL,
    {{"what a rule sets", "surface edge front back inside outside by_face omit"}}};

/* ---- colours ---- */

static bool hexadecimal(const char *text, double rgb[3])
{
    static const char digits[] = "0123456789abcdef";
    if (text[0] != '#' || strlen(text) != 7)
        return false;
    for (int k = 0; k < 6; k++) {
        const char *at = strchr(digits, text[1 + k] | 32);
        if (!at)
            return false;
        rgb[k / 2] = (k % 2 ? rgb[k / 2] : 0) + (double)(at - digits) / 255 * (k % 2 ? 1 : 16);
    }
    return true;
}

/* '#rrggbb' or [r, g, b] from 0 to 1. */
static bool read_colour(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        double rgb[3])
{
    bool good = node->kind == RMAP_YAML_SCALAR ? hexadecimal(node->text, rgb)
                                               : node->kind == RMAP_YAML_LIST && node->n_item == 3;
    for (size_t k = 0; good && node->kind == RMAP_YAML_LIST && k < 3; k++)
        good = rmap_reader_scalar(reader, node->item[k].value, "a colour's part", &rmap_range_share,
                                  &rgb[k]);
    if (!good)
        rmap_reader_error(reader, node,
                          "a colour is written '#cc3300' (in quotes) or [0.8, 0.2, 0]");
    return good;
}

void rmap_reader_check_labels(struct rmap_reader *reader, const struct rmap_yaml_node *node)
{
    double rgb[3];
    if (rmap_yaml_get(node, "color"))
        (void)read_colour(reader, rmap_yaml_get(node, "color"), rgb);
    (void)rmap_reader_text(reader, node, "material", RMAP_OPTIONAL);
}

/* ---- what a rule matches ---- */

static const char *text_of(const struct rmap_yaml_node *node, const char *key)
{
    const struct rmap_yaml_node *value = rmap_yaml_get(node, key);
    return value && value->kind == RMAP_YAML_SCALAR ? value->text : NULL;
}

static bool colour_fits(struct rmap_reader *reader, const struct rmap_yaml_node *match,
                        const struct rmap_yaml_node *wanted, const struct rmap_yaml_node *node)
{
    const struct rmap_yaml_node *own = rmap_yaml_get(node, "color");
    double tolerance = TOLERANCE, a[3], b[3], apart = 0;
    if (!own ||
        !rmap_reader_number(reader, match, "tolerance", RMAP_OPTIONAL, &rmap_range_share,
                            &tolerance) ||
        !read_colour(reader, wanted, a) || !read_colour(reader, own, b))
        return false;
    for (int k = 0; k < 3; k++)
        apart = fmax(apart, fabs(a[k] - b[k]));
    return apart <= tolerance;
}

static bool id_fits(const char *wanted, const char *id)
{
    wanted += strncasecmp(wanted, "0x", 2) == 0 ? 2 : 0;
    id += id && strncasecmp(id, "0x", 2) == 0 ? 2 : 0;
    return id && strcasecmp(wanted, id) == 0;
}

static bool one_fits(const char *key, const struct rmap_yaml_node *wanted,
                     const struct rmap_yaml_node *node, const struct rmap_attribute_above *above)
{
    const char *own = text_of(node, key);
    bool fits = false;
    if (wanted->kind != RMAP_YAML_SCALAR)
        return false;
    if (strcmp(key, "id") == 0)
        return id_fits(wanted->text, own);
    if (strcmp(key, "group") != 0)
        return own && rmap_glob(wanted->text, own);
    for (; above && !fits; above = above->next)
        fits = rmap_glob(wanted->text, above->name);
    return fits;
}

/* One of those that are listed. */
static bool some_fits(const char *key, const struct rmap_yaml_node *wanted,
                      const struct rmap_yaml_node *node, const struct rmap_attribute_above *above)
{
    bool fits = false;
    if (wanted->kind != RMAP_YAML_LIST)
        return one_fits(key, wanted, node, above);
    for (size_t i = 0; i < wanted->n_item && !fits; i++)
        fits = one_fits(key, wanted->item[i].value, node, above);
    return fits;
}

bool rmap_attribute_fits(const struct rmap_yaml_node *match, const struct rmap_yaml_node *node,
                         const struct rmap_attribute_above *above)
{
    static const char *const key[] = {"name", "group", "id", "material"};
    bool fits = true;
    for (size_t k = 0; k < RMAP_COUNT(key) && fits; k++) {
        const struct rmap_yaml_node *wanted = rmap_yaml_get(match, key[k]);
        fits = !wanted || some_fits(key[k], wanted, node, above);
    }
    return fits;
}

/* ---- what it sets ---- */

/* False where memory is short, which the reader then knows. */
static bool put(struct rmap_reader *reader, struct rmap_yaml_node *node, const char *key,
                const struct rmap_yaml_node *value)
{
    static const char *const same[][2] = {{"front", "outside"}, {"back", "inside"}};
    struct rmap_yaml_node *copy = NULL;
    if (rmap_yaml_copy(node, value, &copy, &reader->failure) != RMAP_OK) {
        rmap_reader_fail(reader, RMAP_SYSTEM);
        return false;
    }
    for (size_t i = node->n_item; i-- > 0;)
        for (size_t k = 0; k < RMAP_COUNT(same); k++) {
            const bool side = strcmp(key, same[k][0]) == 0 || strcmp(key, same[k][1]) == 0;
            const char *own = node->item[i].key;
            if (strcmp(own, key) == 0 ||
                (side && (strcmp(own, same[k][0]) == 0 || strcmp(own, same[k][1]) == 0))) {
                rmap_yaml_remove(node, i);
                break;
            }
        }
    if (rmap_yaml_append(node, key, value->line, value->column, copy, &reader->failure) == RMAP_OK)
        return true;
    rmap_reader_fail(reader, RMAP_SYSTEM);
    return false;
}

enum fitted { FITS_FACES, FITS_LENS, FITS_MESH, FITS_OTHER };

static void set_all(struct rmap_reader *reader, struct rmap_attribute_rule *rule,
                    enum fitted fitted, struct rmap_yaml_node *node)
{
    const struct rmap_yaml_node *set = rmap_yaml_get(rule->node, "set");
    for (size_t i = 0; set && i < set->n_item; i++) {
        const char *key = set->item[i].key;
        const bool of_lens = strcmp(key, "surface") == 0 || strcmp(key, "edge") == 0 ||
                             strcmp(key, "front") == 0 || strcmp(key, "outside") == 0;
        if ((fitted == FITS_LENS ? !of_lens : strcmp(key, "edge") == 0) ||
            (fitted != FITS_MESH && strcmp(key, "by_face") == 0))
            continue;
        if (!put(reader, node, key, set->item[i].value))
            return;
        rule->used |= 1U << i;
    }
}

/* A new item behind the object's own `faces`, at the rule's place. */
static void add_faces(struct rmap_reader *reader, struct rmap_attribute_rule *rule,
                      const struct rmap_yaml_node *faces, struct rmap_yaml_node *object)
{
    struct rmap_yaml_node *list = rmap_yaml_get(object, "faces"), *item = NULL;
    const int line = rule->node->line, column = rule->node->column;
    if (!list) {
        list = rmap_yaml_new(object, RMAP_YAML_LIST, line, column);
        if (!list ||
            rmap_yaml_append(object, "faces", line, column, list, &reader->failure) != RMAP_OK) {
            rmap_reader_no_memory(reader);
            return;
        }
    }
    item = rmap_yaml_new(list, RMAP_YAML_MAP, line, column);
    if (!item || rmap_yaml_append(list, NULL, line, column, item, &reader->failure) != RMAP_OK) {
        rmap_reader_no_memory(reader);
        return;
    }
    if (put(reader, item, "faces", faces))
        set_all(reader, rule, FITS_FACES, item);
}

/* Its faces that have the colour. */
static void set_coloured_faces(struct rmap_reader *reader, struct rmap_attribute_rule *rule,
                               const struct rmap_yaml_node *colour, struct rmap_yaml_node *object)
{
    const struct rmap_yaml_node *match = rmap_yaml_get(rule->node, "match"),
                                *list = rmap_yaml_get(object, "faces");
    for (size_t i = 0; list && list->kind == RMAP_YAML_LIST && i < list->n_item; i++) {
        if (!colour_fits(reader, match, colour, list->item[i].value))
            continue;
        rule->n_fit++;
        set_all(reader, rule, FITS_FACES, list->item[i].value);
    }
}

/* ---- the tree ---- */

static const struct rmap_geometry_entry *geometry_of(const struct rmap_reader *reader,
                                                     const struct rmap_yaml_node *object)
{
    const char *name = text_of(object, "geometry");
    const struct rmap_name *found = name ? rmap_names_find(&reader->geometries, name) : NULL;
    return found ? &reader->entry[found->index] : NULL;
}

/* What the rule makes of the object; true: it is to be left out. */
static bool apply(struct rmap_reader *reader, struct rmap_attribute_rule *rule,
                  struct rmap_yaml_node *object, const struct rmap_attribute_above *above)
{
    const struct rmap_yaml_node *match = rmap_yaml_get(rule->node, "match"),
                                *set = rmap_yaml_get(rule->node, "set"),
                                *face = rmap_yaml_get(match, "face"),
                                *colour = rmap_yaml_get(match, "color");
    const struct rmap_geometry_entry *entry = geometry_of(reader, object);
    const bool is_lens = entry && entry->lens,
               is_mesh =
                   entry && entry->geometry >= 0 && reader->scene->geometry[entry->geometry].mesh;
    bool omit = false;
    if (!rmap_attribute_fits(match, object, above))
        return false;
    if (colour && !face)
        set_coloured_faces(reader, rule, colour, object);
    if (colour && !colour_fits(reader, match, colour, object))
        return false;
    if (face && is_mesh)
        add_faces(reader, rule, face, object);
    if (face)
        return false;
    rule->n_fit++;
    (void)rmap_reader_bool(reader, set, "omit", &omit);
    if (!omit)
        set_all(reader, rule, is_lens ? FITS_LENS : is_mesh ? FITS_MESH : FITS_OTHER, object);
    return omit;
}

/* What an earlier rule left out is nothing for the later ones, which say so. */
static void tell_omitted(struct rmap_reader *reader, size_t by, const struct rmap_yaml_node *object,
                         const struct rmap_attribute_above *above)
{
    for (size_t r = by + 1; r < reader->n_rule; r++) {
        struct rmap_attribute_rule *rule = &reader->rule[r];
        const char *name = text_of(object, "name");
        if (rule->omitted_line > 0 ||
            !rmap_attribute_fits(rmap_yaml_get(rule->node, "match"), object, above))
            continue;
        rule->omitted_line = reader->rule[by].node->line;
        (void)snprintf(rule->body, sizeof rule->body, "%s", name ? name : "");
    }
}

static void walk(struct rmap_reader *reader, struct rmap_yaml_node *list,
                 const struct rmap_attribute_above *above)
{
    size_t n = 0;
    for (size_t i = 0; list->kind == RMAP_YAML_LIST && i < list->n_item; i++) {
        struct rmap_yaml_node *node = list->item[i].value;
        const char *name = text_of(node, "name");
        const struct rmap_attribute_above here = {above, name ? name : ""};
        const bool group = rmap_yaml_get(node, "objects") || rmap_yaml_get(node, "sources");
        bool omit = false;
        if (rmap_yaml_get(node, "objects"))
            walk(reader, rmap_yaml_get(node, "objects"), &here);
        for (size_t r = 0; r < reader->n_rule && !group && node->kind == RMAP_YAML_MAP && !omit;
             r++) {
            omit = apply(reader, &reader->rule[r], node, above);
            if (omit)
                tell_omitted(reader, r, node, above);
        }
        if (!omit)
            list->item[n++] = list->item[i];
    }
    if (list->kind == RMAP_YAML_LIST)
        list->n_item = n;
}

/* Texts, or lists of them. */
static bool check_match(struct rmap_reader *reader, const struct rmap_yaml_node *match)
{
    double rgb[3];
    bool good = rmap_reader_known(reader, match, &rmap_match_keys, 0);
    for (size_t i = 0; good && i < match->n_item; i++) {
        const struct rmap_yaml_node *value = match->item[i].value;
        if (strcmp(match->item[i].key, "color") == 0)
            good = read_colour(reader, value, rgb);
        bool texts = true;
        for (size_t k = 0; value->kind == RMAP_YAML_LIST && k < value->n_item; k++)
            texts &= value->item[k].value->kind == RMAP_YAML_SCALAR;
        if (value->kind == RMAP_YAML_MAP || !texts) {
            rmap_reader_error(reader, value,
                              "'%.40s' is a word, a pattern of * and ?, or a list of "
                              "them",
                              match->item[i].key);
            good = false;
        }
    }
    return good;
}

/* Names of surfaces and media: a mistake in them is one of the rule, not of all that it fits. */
static void check_set(struct rmap_reader *reader, const struct rmap_yaml_node *set)
{
    static const char *const sides[] = {"front", "back", "inside", "outside"};
    static const char *const surfaces[] = {"surface", "edge"};
    bool omit = false, by_face = false;
    for (size_t k = 0; k < RMAP_COUNT(surfaces); k++)
        if (rmap_yaml_get(set, surfaces[k]))
            rmap_reader_surface_pair(reader, set, surfaces[k], NULL, NULL);
    for (size_t k = 0; k < RMAP_COUNT(sides); k++)
        if (rmap_yaml_get(set, sides[k]))
            rmap_reader_medium(reader, set, sides[k], NULL);
    (void)rmap_reader_bool(reader, set, "omit", &omit);
    (void)rmap_reader_bool(reader, set, "by_face", &by_face);
}

static void read_rule(struct rmap_reader *reader, const struct rmap_yaml_node *node)
{
    const struct rmap_yaml_node *match = rmap_yaml_get(node, "match"),
                                *set = rmap_yaml_get(node, "set");
    if (!rmap_reader_known(reader, node, &rmap_attribute_keys, 0))
        return;
    if (!set) {
        rmap_reader_error(reader, node,
                          "'set' is missing, as in {match: {name: 'lens*'}, set: "
                          "{surface: fresnel, inside: N-BK7}}");
        return;
    }
    if (!match || match->n_item == 0) {
        rmap_reader_error(reader, match ? match : node,
                          "'match' says of no part what it is: for all of them {name: '*'}");
        return;
    }
    if (!check_match(reader, match) || !rmap_reader_known(reader, set, &rmap_set_keys, 0))
        return;
    if (set->n_item == 0) {
        rmap_reader_error(reader, set,
                          "'set' sets nothing: give one of surface, edge, front, back, inside, "
                          "outside, by_face, omit, or take the rule away");
        return;
    }
    check_set(reader, set);
    struct rmap_attribute_rule *rule =
        RMAP_READER_NEW(reader, reader->rule, reader->n_rule, reader->cap_rule);
    if (rule)
        *rule = (struct rmap_attribute_rule){.node = node,
                                             .of_faces = rmap_yaml_get(match, "face") != NULL};
}

void rmap_reader_apply_attributes(struct rmap_reader *reader)
{
    struct rmap_yaml_node *list = rmap_yaml_get(reader->root, "attributes"),
                          *objects = rmap_yaml_get(reader->root, "objects");
    if (!list || !rmap_reader_check_list(reader, list, "'attributes'"))
        return;
    if (list->n_item > RULES_MAX) {
        rmap_reader_error(reader, list, "%zu rules: a scene has %d at most", list->n_item,
                          RULES_MAX);
        return;
    }
    const size_t n_error = reader->diagnostics->n_error;
    for (size_t i = 0; i < list->n_item; i++)
        read_rule(reader, list->item[i].value);
    reader->has_bad_rule = reader->diagnostics->n_error > n_error;
    if (objects && !reader->has_bad_rule)
        walk(reader, objects, NULL);
}

struct rmap_attribute_rule *rmap_reader_rule_of(struct rmap_reader *reader,
                                                const struct rmap_yaml_node *item)
{
    for (size_t i = 0; i < reader->n_rule; i++)
        if (reader->rule[i].of_faces && reader->rule[i].node->line == item->line &&
            reader->rule[i].node->column == item->column)
            return &reader->rule[i];
    return NULL;
}
