/* SPDX-License-Identifier: MIT
 *
 * What an import of a model found, and what an update changed.
 */
#include "mpi/answer/model_out.h"

#include <string.h>

#include "io/assembly/assembly_guess.h"
#include "io/file/shell_word.h"
#include "mpi/answer/model_rules.h"
#include "mpi/command/json_out.h"

/* ---- an import ---- */

struct counts {
    size_t part, group, closed, clear, material;
};

static struct counts count(const struct rmap_assembly *a)
{
    struct counts n = {0};
    for (size_t i = 0; i < a->n_part; i++) {
        const struct rmap_assembly_part *part = &a->part[i];
        struct rmap_assembly_guess guess = {0};
        if (part->shape < 0) {
            n.group++;
            continue;
        }
        const bool closed = a->shape[part->shape].closed;
        if (closed && part->material && part->material[0])
            rmap_assembly_guess(a, part->material, &part->colour, closed, &guess);
        n.part++;
        n.closed += closed;
        n.clear += guess.inside[0] != 0;
        n.material += part->material && part->material[0];
    }
    return n;
}

static const char *plural(size_t n)
{
    return n == 1 ? "" : "s";
}

static const char *label_of(const struct rmap_assembly *a, const char *id)
{
    for (size_t i = 0; i < a->n_part; i++)
        if (strcmp(a->part[i].id, id) == 0)
            return a->part[i].label;
    return id;
}

static void print_touching(const struct rmap_assembly *a, FILE *out)
{
    enum { MOST = 5 };
    (void)fprintf(out, "  %zu pair%s of parts touch%s", a->n_touch, plural(a->n_touch),
                  a->n_touch == 1 ? "es" : "");
    for (size_t i = 0; i < a->n_touch && i < MOST; i++)
        (void)fprintf(out, "%s %s and %s", i ? "," : ":", label_of(a, a->touch[i].part[0]),
                      label_of(a, a->touch[i].part[1]));
    (void)fputs(a->n_touch > MOST ? " ... (--json has them all)\n" : "\n", out);
}

void rmap_model_print(const struct rmap_assembly *a, const char *scene, FILE *out)
{
    const struct counts n = count(a);
    (void)fprintf(out, "%s\n  %s: %zu part%s of %zu shape%s in %zu group%s\n", scene, a->schema,
                  n.part, plural(n.part), a->n_shape, plural(a->n_shape), n.group, plural(n.group));
    if (n.closed < n.part)
        (void)fprintf(out, "  %zu part%s not closed: no body of glass\n", n.part - n.closed,
                      n.part - n.closed == 1 ? " is" : "s are");
    if (n.clear > 0)
        (void)fprintf(out, "  %zu part%s transparent by %s material\n", n.clear,
                      n.clear == 1 ? " is" : "s are", n.clear == 1 ? "its" : "their");
    if (a->n_touch > 0)
        print_touching(a, out);
    (void)fputs("next:\n  raymap render", out);
    rmap_shell_word_put(out, scene);
    (void)fputs(" -o model.png\n  attributes.yaml beside it says what parts are made of\n", out);
}

json_t *rmap_model_json(const struct rmap_assembly *a, const char *path, const char *scene)
{
    const struct counts n = count(a);
    json_t *touching = json_array();
    for (size_t i = 0; i < a->n_touch; i++)
        (void)json_array_append_new(
            touching, json_pack("{s:[s, s], s:f}", "parts", label_of(a, a->touch[i].part[0]),
                                label_of(a, a->touch[i].part[1]), "area", a->touch[i].area));
    return json_pack("{s:s, s:s, s:s, s:s, s:s, s:I, s:I, s:I, s:I, s:I, s:o, s:b, s:o}", "path",
                     path, "scene", scene, "format", a->schema, "title", a->writer, "units", "mm",
                     "parts", (json_int_t)n.part, "groups", (json_int_t)n.group, "shapes",
                     (json_int_t)a->n_shape, "closed", (json_int_t)n.closed, "transparent",
                     (json_int_t)n.clear, "touching", touching, "understood", a->findings.n == 0,
                     "findings", rmap_json_findings(&a->findings));
}

/* ---- an update ---- */

static const struct {
    unsigned change;
    const char *word;
} changes[] = {{RMAP_PART_MOVED, "moved"},         {RMAP_PART_RESHAPED, "changed"},
               {RMAP_PART_SCALED, "scaled"},       {RMAP_PART_RENAMED, "renamed"},
               {RMAP_PART_REGROUPED, "regrouped"}, {RMAP_PART_RECOLOURED, "recoloured"}};
enum { N_CHANGE = sizeof changes / sizeof *changes };

struct tally {
    size_t kept, change[N_CHANGE], fresh, gone;
};

/* Parts, not groups; but of groups that moved. */
static struct tally tally(const struct rmap_model_revision *r)
{
    struct tally n = {0};
    for (size_t i = 0; i < r->after->n_part; i++) {
        const bool part = r->after->part[i].shape >= 0;
        n.fresh += part && r->match->from[i] < 0;
        n.kept += part && r->match->from[i] >= 0 && r->match->change[i] == 0;
        for (size_t k = 0; k < N_CHANGE; k++)
            n.change[k] += r->match->from[i] >= 0 && (r->match->change[i] & changes[k].change);
    }
    for (size_t i = 0; i < r->before->n_part; i++)
        n.gone += r->before->part[i].shape >= 0 && r->match->to[i] < 0;
    return n;
}

static const char *group_of(const struct rmap_assembly *a, size_t i)
{
    const int32_t up = a->part[i].parent;
    return up < 0 ? "the top" : a->part[up].label;
}

static void print_motion(const struct rmap_part_motion *motion, unsigned change, FILE *out)
{
    if (change & RMAP_PART_MOVED && motion->distance > 0)
        (void)fprintf(out, "   by %.6g mm", motion->distance);
    if (change & RMAP_PART_MOVED && motion->turn > 0)
        (void)fprintf(out, "   turned by %.6g degrees", motion->turn);
    if (change & RMAP_PART_SCALED)
        (void)fprintf(out, "   to %.6g times its size", motion->scale);
}

static void print_change(const struct rmap_model_revision *r, size_t i, FILE *out)
{
    const struct rmap_assembly_part *part = &r->after->part[i];
    const unsigned change = r->match->change[i];
    const char *before = "";
    if (r->match->from[i] < 0) {
        (void)fprintf(out, "  new         %s\n", part->label);
        return;
    }
    (void)fputs("  ", out);
    size_t width = 0;
    for (size_t k = 0; k < N_CHANGE; k++)
        if (change & changes[k].change) {
            width += (size_t)fprintf(out, "%s%s", before, changes[k].word);
            before = ", ";
        }
    (void)fprintf(out, "%*s%s", width < 12 ? (int)(12 - width) : 1, "", part->label);
    print_motion(&r->match->motion[i], change, out);
    if (change & RMAP_PART_RENAMED)
        (void)fprintf(out, "   '%s' -> '%s' in the file; the scene keeps its name",
                      r->before->part[r->match->from[i]].name, part->name);
    if (change & RMAP_PART_REGROUPED)
        (void)fprintf(out, "   from %s to %s", group_of(r->before, (size_t)r->match->from[i]),
                      group_of(r->after, i));
    (void)fputc('\n', out);
}

void rmap_revision_print(const struct rmap_model_revision *r, const char *scene, FILE *out)
{
    enum { MOST = 200 };
    const struct tally n = tally(r);
    size_t told = 0, left = 0;
    (void)fprintf(out, "%s%s\n  %zu kept", scene,
                  r->dry_run ? ": nothing is written, as --dry-run asks" : "", n.kept);
    for (size_t k = 0; k < N_CHANGE; k++)
        (void)fprintf(out, ", %zu %s", n.change[k], changes[k].word);
    (void)fprintf(out, ", %zu new, %zu gone\n", n.fresh, n.gone);
    for (size_t i = 0; i < r->after->n_part; i++) {
        if (r->match->from[i] < 0 ? r->after->part[i].shape < 0 : r->match->change[i] == 0)
            continue;
        if (told++ < MOST)
            print_change(r, i, out);
        else
            left++;
    }
    for (size_t i = 0; i < r->before->n_part; i++) {
        if (r->before->part[i].shape < 0 || r->match->to[i] >= 0)
            continue;
        if (told++ < MOST)
            (void)fprintf(out, "  gone        %s\n", r->before->part[i].label);
        else
            left++;
    }
    if (left > 0)
        (void)fprintf(out, "  and %zu more: --json has them all\n", left);
    if (!r->dry_run)
        (void)fprintf(out, "  meshes: %zu kept, %zu written, %zu removed\n", r->stored->n_mesh_kept,
                      r->stored->n_mesh_written, r->stored->n_mesh_removed);
}

static json_t *change_json(const struct rmap_model_revision *r, size_t i)
{
    const struct rmap_assembly_part *part = &r->after->part[i];
    json_t *words = json_array();
    if (r->match->from[i] < 0)
        (void)json_array_append_new(words, json_string("new"));
    for (size_t k = 0; k < N_CHANGE; k++)
        if (r->match->from[i] >= 0 && r->match->change[i] & changes[k].change)
            (void)json_array_append_new(words, json_string(changes[k].word));
    json_t *json =
        json_pack("{s:s, s:s, s:o}", "name", part->label, "in_file", part->name, "change", words);
    const unsigned change = r->match->from[i] >= 0 ? r->match->change[i] : 0;
    const struct rmap_part_motion *motion = &r->match->motion[i];
    if (change & RMAP_PART_MOVED) {
        (void)json_object_set_new(json, "moved_by", json_real(motion->distance));
        (void)json_object_set_new(json, "turned_by", json_real(motion->turn));
    }
    if (change & RMAP_PART_SCALED)
        (void)json_object_set_new(json, "scaled_by", json_real(motion->scale));
    if (change & RMAP_PART_RENAMED)
        (void)json_object_set_new(json, "was",
                                  json_string(r->before->part[r->match->from[i]].name));
    if (change & RMAP_PART_REGROUPED)
        (void)json_object_set_new(json, "groups",
                                  json_pack("[s, s]",
                                            group_of(r->before, (size_t)r->match->from[i]),
                                            group_of(r->after, i)));
    return json;
}

json_t *rmap_revision_json(const struct rmap_model_revision *r, const char *path, const char *scene)
{
    const struct tally n = tally(r);
    json_t *parts = json_array();
    json_t *json = json_pack("{s:s, s:s, s:b, s:I}", "path", path, "scene", scene, "dry_run",
                             r->dry_run, "kept", (json_int_t)n.kept);
    for (size_t k = 0; k < N_CHANGE; k++)
        (void)json_object_set_new(json, changes[k].word, json_integer((json_int_t)n.change[k]));
    (void)json_object_set_new(json, "new", json_integer((json_int_t)n.fresh));
    (void)json_object_set_new(json, "gone", json_integer((json_int_t)n.gone));
    for (size_t i = 0; i < r->after->n_part; i++)
        if (r->match->from[i] < 0 ? r->after->part[i].shape >= 0 : r->match->change[i] != 0)
            (void)json_array_append_new(parts, change_json(r, i));
    for (size_t i = 0; i < r->before->n_part; i++)
        if (r->before->part[i].shape >= 0 && r->match->to[i] < 0)
            (void)json_array_append_new(
                parts, json_pack("{s:s, s:s, s:[s]}", "name", r->before->part[i].label, "in_file",
                                 r->before->part[i].name, "change", "gone"));
    (void)json_object_set_new(json, "parts", parts);
    (void)json_object_set_new(json, "meshes",
                              json_pack("{s:I, s:I, s:I}", "kept",
                                        (json_int_t)r->stored->n_mesh_kept, "written",
                                        (json_int_t)r->stored->n_mesh_written, "removed",
                                        (json_int_t)r->stored->n_mesh_removed));
    json_t *findings = rmap_json_findings(&r->before->findings), *more;
    (void)json_array_extend(findings, more = rmap_json_findings(&r->after->findings));
    json_decref(more);
    for (int k = 0; k < RMAP_MODEL_RULE_FILES; k++) {
        (void)json_array_extend(findings, more = rmap_json_findings(&r->rules[k]));
        for (size_t i = 0; i < json_array_size(more); i++)
            (void)json_object_set_new(json_array_get(more, i), "file",
                                      json_string(r->rules[k].file));
        json_decref(more);
    }
    (void)json_object_set_new(json, "findings", findings);
    return json;
}
