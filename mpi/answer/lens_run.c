/* SPDX-License-Identifier: MIT
 *
 * Importing a lens file.
 */
#include "mpi/answer/lens_run.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/kept_edits.h"
#include "io/lensfile/lens_scene.h"
#include "io/scene/yaml_difference.h"
#include "mpi/answer/lens_out.h"
#include "mpi/command/import_check.h"
#include "mpi/command/import_folder.h"
#include "mpi/command/json_out.h"
#include "mpi/command/lens_read.h"
#include "mpi/parallel/interrupt.h"

enum { CONFIGURATIONS_MAX = 64, NAME_LETTERS = 80 };

/* ---- configurations ---- */

struct configurations {
    struct rmap_lens_import *lens;
    const struct rmap_yaml_node *base;
    char name[CONFIGURATIONS_MAX + 1][NAME_LETTERS];
};

static enum rmap_status parse(const struct rmap_lens_import *import, struct rmap_yaml_node **root,
                              struct rmap_error *err)
{
    struct rmap_diagnostics told;
    rmap_diagnostics_init(&told, import->scene);
    enum rmap_status st = rmap_yaml_parse(import->text, import->text_nbytes, root, &told, err);
    rmap_diagnostics_fini(&told);
    return st;
}

/* Those of a configuration that the stored one has not, in the scene, too. */
static void take_findings(struct rmap_diagnostics *all, const struct rmap_diagnostics *its,
                          const char *name, FILE *file)
{
    const size_t n = all->n;
    for (size_t i = 0; i < its->n; i++) {
        const struct rmap_diagnostic *item = &its->item[i];
        bool known = false;
        for (size_t k = 0; k < n && !known; k++)
            known = all->item[k].line == item->line && strcmp(all->item[k].text, item->text) == 0;
        if (known)
            continue;
        rmap_diagnostics_add(all, RMAP_SEVERITY_WARNING, item->line, 0, "%s: %s", name, item->text);
        (void)fputs("    # ", file);
        if (item->line > 0)
            (void)fprintf(file, "line %d: ", item->line);
        (void)fprintf(file, "%s\n", item->text);
    }
}

/* A simulation that sets what is other in configuration k. */
static enum rmap_status put_configuration(struct configurations *all, int k, FILE *file,
                                          struct rmap_error *err)
{
    struct rmap_lens_import other;
    struct rmap_yaml_node *root = NULL;
    char *set = NULL, *name = all->name[k];
    size_t nbytes = 0;
    rmap_lens_import_init(&other, all->lens->path, all->lens->scene, all->lens->given);
    enum rmap_status st = rmap_lens_import_read(&other, k, err);
    if (st == RMAP_OK)
        st = parse(&other, &root, err);
    FILE *memory = st == RMAP_OK ? open_memstream(&set, &nbytes) : NULL;
    if (st == RMAP_OK && !memory)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    if (memory) {
        const size_t n = rmap_yaml_difference(all->base, root, "      ", memory);
        const bool closed = fclose(memory) == 0;
        rmap_lens_configuration_name(&other.lens, k, name, NAME_LETTERS);
        for (int i = 1; i < k; i++)
            if (strcmp(all->name[i], name) == 0)
                (void)snprintf(name, NAME_LETTERS, "configuration_%d", k);
        (void)fprintf(file, "  - name: %s\n    rays: 200000\n", name);
        take_findings(&all->lens->findings, &other.findings, name, file);
        (void)fprintf(file, "%s%s", n ? "    set:\n" : "", closed && n ? set : "");
    }
    free(set);
    rmap_yaml_destroy(root);
    rmap_lens_import_fini(&other);
    return st;
}

/* Behind the text of the scene, whose last list they go on with. */
static enum rmap_status add_configurations(struct rmap_lens_import *lens,
                                           struct configurations *all, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_yaml_node *base = NULL;
    char *text = NULL;
    size_t nbytes = 0;
    const int n = lens->lens.n_configuration;
    FILE *memory = NULL;
    *all = (struct configurations){.lens = lens};
    if (n < 2)
        return RMAP_OK;
    if (n > CONFIGURATIONS_MAX)
        rmap_diagnostics_add(&lens->findings, RMAP_SEVERITY_WARNING, 0, 0,
                             "of its %d configurations the first %d are simulations", n,
                             CONFIGURATIONS_MAX);
    RMAP_TRY(parse(lens, &base, err));
    all->base = base;
    memory = open_memstream(&text, &nbytes);
    if (!memory)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene"));
    (void)fwrite(lens->text, 1, lens->text_nbytes, memory);
    for (int k = 1; k <= n && k <= CONFIGURATIONS_MAX && st == RMAP_OK; k++)
        st = put_configuration(all, k, memory, err);
    if (fclose(memory) != 0 && st == RMAP_OK)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    if (st == RMAP_OK) {
        free(lens->text);
        lens->text = text;
        lens->text_nbytes = nbytes;
        text = NULL;
    }
out:
    free(text);
    rmap_yaml_destroy(base);
    return st;
}

/* ---- the whole ---- */

static enum rmap_status put_scene(const void *context, FILE *file, struct rmap_error *err)
{
    const struct rmap_lens_import *lens = context;
    (void)err;
    (void)fwrite(lens->text, 1, lens->text_nbytes, file);
    return RMAP_OK;
}

static enum rmap_status check(const struct rmap_context *context,
                              const struct rmap_lens_import *lens,
                              const struct configurations *configurations,
                              struct rmap_diagnostics *told, struct rmap_error *err)
{
    struct rmap_import_text text = {lens->scene, lens->text, NULL};
    enum rmap_status st = rmap_import_check(context, &text, told, err);
    for (int k = 1; k <= CONFIGURATIONS_MAX && configurations->name[k][0] && st == RMAP_OK; k++) {
        text.simulation = configurations->name[k];
        st = rmap_import_check(context, &text, told, err);
    }
    return st;
}

static enum rmap_status refuse_strictly(const struct rmap_lens_import *lens, struct rmap_error *err)
{
    if (lens->findings.n == 0 || !rmap_argument(lens->given, "strict"))
        return RMAP_OK;
    const size_t n = lens->findings.n + lens->findings.n_dropped;
    return rmap_error_set(err, RMAP_INPUT,
                          "%s: %zu thing%s not understood; nothing is written, as --strict asks",
                          lens->path, n, n == 1 ? " is" : "s are");
}

static enum rmap_status tell(const struct rmap_context *context,
                             const struct rmap_lens_import *lens,
                             const struct rmap_diagnostics *told, struct rmap_error *err)
{
    if (context->json) {
        json_t *document = rmap_lens_json(&lens->plan, lens->path, lens->scene);
        (void)json_object_set_new(document, "check", rmap_json_check(told));
        return rmap_json_print(document, stdout, err);
    }
    if (!context->quiet && told->n_error == 0)
        rmap_lens_print(&lens->plan, lens->scene, stdout);
    return RMAP_OK;
}

enum rmap_status rmap_lens_import(const struct rmap_context *context,
                                  const struct rmap_arguments *given, const char *folder,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const bool force = rmap_argument(given, "force") != NULL;
    enum rmap_edits edits = RMAP_EDITS_NO_FILE;
    char *kept = NULL, *scene = rmap_import_path(folder, "scene.yaml");
    struct configurations configurations;
    struct rmap_import_folder place = {.path = folder};
    struct rmap_lens_import lens;
    struct rmap_diagnostics told;
    rmap_lens_import_init(&lens, given->operand[0], scene, given);
    rmap_diagnostics_init(&told, scene ? scene : "");
    if (!scene)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a file's name"));
    RMAP_TRY(rmap_import_folder_check(&place, RMAP_IMPORT_LENS, force, err)); /* before the work */
    RMAP_TRY(rmap_edits_find(scene, &edits, err));
    if (edits == RMAP_EDITS_MADE && !force)
        RMAP_TRY(rmap_edits_refuse(scene, err));
    st = rmap_lens_import_read(&lens, 0, err);
    if (st == RMAP_OK)
        st = add_configurations(&lens, &configurations, err);
    rmap_diagnostics_print(&lens.findings, stderr);
    RMAP_TRY(st);
    RMAP_TRY(refuse_strictly(&lens, err));
    RMAP_TRY(check(context, &lens, &configurations, &told, err));
    rmap_diagnostics_print(&told, stderr);
    RMAP_TRY(rmap_interrupt_stopped(err));
    RMAP_TRY(rmap_import_folder_make(&place, err));
    RMAP_TRY(rmap_edits_put(scene, force, put_scene, &lens, &kept, err));
    rmap_import_folder_replaced(&place, context->quiet);
    if (kept && !context->quiet)
        (void)fprintf(stderr, "%s: the scene that stood there, with its edits\n", kept);
    RMAP_TRY(tell(context, &lens, &told, err));
    st = rmap_import_refused(scene, &told, err);
out:
    rmap_import_folder_fini(&place, st);
    rmap_diagnostics_fini(&told);
    rmap_lens_import_fini(&lens);
    rmap_free(kept);
    rmap_free(scene);
    return st;
}
