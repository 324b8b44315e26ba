/* SPDX-License-Identifier: MIT
 *
 * Rules of a user that a new revision of a model makes doubtful.
 */
#include "mpi/answer/model_rules.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/assembly/assembly_scene.h"
#include "io/file/input_file.h"
#include "io/scene/scene_attributes.h"
#include "mpi/command/model_store.h"

enum { TEXT_NBYTES_MAX = 64 << 20 };

struct doubt {
    const struct rmap_assembly *before, *after;
    const struct rmap_assembly_match *match;
    const struct rmap_yaml_node *rule;
    size_t part;  /* that is looked at: parts.yaml has them in their order */
    size_t first; /* whose faces are doubtful */
    size_t n;
};

static enum rmap_status parse(const char *path, const char *text, size_t nbytes,
                              struct rmap_yaml_node **root, struct rmap_error *err)
{
    struct rmap_diagnostics told; /* by `raymap check`, not here */
    rmap_diagnostics_init(&told, path);
    const enum rmap_status st = rmap_yaml_parse(text, nbytes, root, &told, err);
    rmap_diagnostics_fini(&told);
    return st;
}

static bool is_number(const struct rmap_yaml_node *node)
{
    return node && node->kind == RMAP_YAML_SCALAR && !node->quoted && node->text[0] >= '0' &&
           node->text[0] <= '9' && strspn(node->text, "0123456789.") == strlen(node->text);
}

static bool has_numbers(const struct rmap_yaml_node *faces)
{
    bool has = is_number(faces);
    for (size_t i = 0; faces && faces->kind == RMAP_YAML_LIST && i < faces->n_item && !has; i++)
        has = is_number(faces->item[i].value);
    return has;
}

/* As parts.yaml has them, hexadecimal; what is written otherwise may be anything. */
static bool may_have_colour(const struct rmap_yaml_node *match, const struct rmap_yaml_node *object)
{
    const struct rmap_yaml_node *wanted = rmap_yaml_get(match, "color"),
                                *own = rmap_yaml_get(object, "color"),
                                *within = rmap_yaml_get(match, "tolerance");
    const double tolerance = is_number(within) ? strtod(within->text, NULL) : 0.02;
    unsigned a[3], b[3];
    bool may = true;
    if (!wanted || wanted->kind != RMAP_YAML_SCALAR ||
        sscanf(wanted->text, "#%2x%2x%2x", &a[0], &a[1], &a[2]) != 3)
        return true;
    if (!own || own->kind != RMAP_YAML_SCALAR ||
        sscanf(own->text, "#%2x%2x%2x", &b[0], &b[1], &b[2]) != 3)
        return false;
    for (int k = 0; k < 3; k++)
        may &= fabs((double)a[k] - (double)b[k]) / 255 <= tolerance;
    return may;
}

static void walk(struct doubt *doubt, const struct rmap_yaml_node *list,
                 const struct rmap_attribute_above *above)
{
    const struct rmap_yaml_node *match = rmap_yaml_get(doubt->rule, "match");
    for (size_t i = 0; list && list->kind == RMAP_YAML_LIST && i < list->n_item; i++) {
        const struct rmap_yaml_node *node = list->item[i].value,
                                    *name = rmap_yaml_get(node, "name"),
                                    *objects = rmap_yaml_get(node, "objects");
        const struct rmap_attribute_above here = {above, name ? name->text : ""};
        const size_t part = doubt->part++;
        walk(doubt, objects, &here);
        if (objects || part >= doubt->after->n_part ||
            !(doubt->match->change[part] & RMAP_PART_RESHAPED) ||
            !rmap_attribute_fits(match, node, above) || !may_have_colour(match, node))
            continue;
        if (doubt->n++ == 0)
            doubt->first = part;
    }
}

static void tell(const struct doubt *doubt, struct rmap_diagnostics *findings)
{
    const struct rmap_assembly_part *part = &doubt->after->part[doubt->first],
                                    *old = &doubt->before->part[doubt->match->from[doubt->first]];
    char others[40] = "";
    if (doubt->n > 1)
        (void)snprintf(others, sizeof others, " and of %zu more", doubt->n - 1);
    rmap_diagnostics_add(
        findings, RMAP_SEVERITY_WARNING, doubt->rule->line, doubt->rule->column,
        "this rule names faces by number, and the shape of '%.60s'%s has changed (%zu faces, "
        "before %zu): look whether the numbers still mean the same faces",
        part->label, others, doubt->after->shape[part->shape].n_face,
        doubt->before->shape[old->shape].n_face);
}

static enum rmap_status check_file(struct doubt *doubt, const struct rmap_yaml_node *parts,
                                   const char *path, struct rmap_diagnostics *findings,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *text = NULL;
    size_t nbytes = 0;
    struct rmap_yaml_node *root = NULL;
    if (rmap_input_file_trouble(path))
        return RMAP_OK;
    RMAP_TRY(rmap_input_file_read(path, TEXT_NBYTES_MAX, &text, &nbytes, err));
    RMAP_TRY(parse(path, (const char *)text, nbytes, &root, err));
    const struct rmap_yaml_node *rules = rmap_yaml_get(root, "attributes");
    for (size_t i = 0; rules && rules->kind == RMAP_YAML_LIST && i < rules->n_item; i++) {
        doubt->rule = rules->item[i].value;
        if (!has_numbers(rmap_yaml_get(rmap_yaml_get(doubt->rule, "match"), "face")))
            continue;
        doubt->part = doubt->n = 0;
        walk(doubt, rmap_yaml_get(parts, "objects"), NULL);
        if (doubt->n > 0)
            tell(doubt, findings);
    }
out:
    rmap_free(text);
    rmap_yaml_destroy(root);
    return st == RMAP_SYSTEM ? st
                             : RMAP_OK; /* what is wrong with a text is told where it is used */
}

static bool any_reshaped(const struct doubt *doubt)
{
    for (size_t i = 0; i < doubt->after->n_part; i++)
        if (doubt->match->change[i] & RMAP_PART_RESHAPED)
            return true;
    return false;
}

enum rmap_status rmap_model_check_rules(const char *folder, const struct rmap_assembly *before,
                                        const struct rmap_assembly *after,
                                        const struct rmap_assembly_match *match,
                                        struct rmap_diagnostics findings[RMAP_MODEL_RULE_FILES],
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct doubt doubt = {.before = before, .after = after, .match = match};
    static const char *const name[] = {RMAP_ASSEMBLY_ATTRIBUTES, "scene.yaml"};
    char *text = NULL, *path = NULL;
    size_t nbytes = 0;
    struct rmap_yaml_node *parts = NULL;
    FILE *memory = any_reshaped(&doubt) ? open_memstream(&text, &nbytes) : NULL;
    if (!memory)
        return RMAP_OK;
    st = rmap_assembly_put_parts(after, memory, err);
    if (fclose(memory) != 0 && st == RMAP_OK)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for parts");
    RMAP_TRY(st);
    RMAP_TRY(parse(RMAP_ASSEMBLY_PARTS, text, nbytes, &parts, err));
    for (int k = 0; k < RMAP_MODEL_RULE_FILES; k++) {
        path = rmap_model_path(folder, name[k]);
        if (!path)
            RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a file's name"));
        rmap_diagnostics_init(&findings[k], path);
        RMAP_TRY(check_file(&doubt, parts, path, &findings[k], err));
        rmap_free(path);
        path = NULL;
    }
out:
    free(text);
    rmap_free(path);
    rmap_yaml_destroy(parts);
    return st;
}
