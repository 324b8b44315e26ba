/* SPDX-License-Identifier: MIT
 *
 * Rules that fit nothing, or set what nothing takes: what stands in their way.
 */
#include <string.h>

#include "io/scene/scene_attributes.h"

/* ---- ids ---- */

struct nearest {
    const char *word, *id, *name;
    size_t apart;
};

static const char *text_of(const struct rmap_yaml_node *node, const char *key)
{
    const struct rmap_yaml_node *value = rmap_yaml_get(node, key);
    return value && value->kind == RMAP_YAML_SCALAR ? value->text : NULL;
}

static void find_nearest(const struct rmap_yaml_node *list, struct nearest *nearest)
{
    for (size_t i = 0; list && list->kind == RMAP_YAML_LIST && i < list->n_item; i++) {
        const struct rmap_yaml_node *object = list->item[i].value;
        const char *id = text_of(object, "id");
        find_nearest(rmap_yaml_get(object, "objects"), nearest);
        const size_t apart =
            id ? rmap_word_distance(nearest->word, id, nearest->apart) : nearest->apart;
        if (apart >= nearest->apart)
            continue;
        nearest->apart = apart;
        nearest->id = id;
        nearest->name = text_of(object, "name");
    }
}

/* Of the first id that is asked for. */
static bool tell_id(struct rmap_reader *reader, const struct rmap_attribute_rule *rule)
{
    const struct rmap_yaml_node *id = rmap_yaml_get(rmap_yaml_get(rule->node, "match"), "id");
    if (id && id->kind == RMAP_YAML_LIST && id->n_item > 0)
        id = id->item[0].value;
    if (!id || id->kind != RMAP_YAML_SCALAR)
        return false;
    struct nearest nearest = {.word = id->text, .apart = strlen(id->text) / 2 + 1};
    find_nearest(rmap_yaml_get(reader->root, "objects"), &nearest);
    if (!nearest.id)
        rmap_reader_warn(reader, rule->node, "this rule fits no object: none has the id '%.40s'",
                         id->text);
    else if (nearest.apart == 0)
        return false; /* it is there: something else does not fit */
    else
        rmap_reader_warn(reader, rule->node,
                         "this rule fits no object: none has the id '%.40s' (did you mean '%.40s', "
                         "of '%.60s'?)",
                         id->text, nearest.id, nearest.name ? nearest.name : "");
    return true;
}

/* ---- all ---- */

static void tell_no_fit(struct rmap_reader *reader, const struct rmap_attribute_rule *rule)
{
    const char *what = rule->of_faces ? "face" : "object";
    int line = 0;
    if (rule->omitted_line > 0) {
        const char *part = rmap_diagnostics_place(reader->diagnostics, rule->omitted_line, &line);
        rmap_reader_warn(reader, rule->node,
                         "this rule fits no %s: '%s' is left out by the rule at line %d%s%.200s",
                         what, rule->body, line, part ? " of " : "", part ? part : "");
    } else if (rule->n_face > 0) {
        rmap_reader_warn(reader, rule->node,
                         "this rule fits no face: '%s' has the faces 0 to %zu; ranges are written "
                         "0..%zu",
                         rule->body, rule->n_face - 1, rule->n_face - 1);
    } else if (!tell_id(reader, rule)) {
        rmap_reader_warn(reader, rule->node, "this rule fits no %s", what);
    }
}

void rmap_reader_check_attributes(struct rmap_reader *reader)
{
    for (size_t i = 0; i < reader->n_rule; i++) {
        const struct rmap_attribute_rule *rule = &reader->rule[i];
        const struct rmap_yaml_node *set = rmap_yaml_get(rule->node, "set");
        if (rule->n_fit == 0)
            tell_no_fit(reader, rule);
        for (size_t k = 0; k < set->n_item && rule->n_fit > 0; k++)
            if (!(rule->used >> k & 1) && strcmp(set->item[k].key, "omit") != 0 &&
                !text_of(set, "omit"))
                rmap_reader_warn(reader, set->item[k].value,
                                 "'%s' says nothing of what this rule fits: %s", set->item[k].key,
                                 strcmp(set->item[k].key, "edge") == 0 ? "'edge' is of lenses"
                                 : strcmp(set->item[k].key, "by_face") == 0
                                     ? "'by_face' is of whole meshes"
                                     : "the rows of a lens say what is inside");
    }
}
