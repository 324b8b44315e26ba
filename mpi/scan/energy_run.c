/* SPDX-License-Identifier: MIT
 *
 * raymap report MAP --energy: where the light went.
 */
#include "mpi/scan/energy_run.h"

#include <string.h>
#include <strings.h>

#include "analysis/figure/figure_detector.h"
#include "analysis/figure/figure_energy.h"
#include "io/export/raster.h"
#include "io/file/whole_file.h"
#include "io/map/map_json.h"
#include "mpi/command/asked.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/map_name.h"
#include "mpi/command/output.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"

static const char *const suffixes[] = {".csv", ".json", ".svg", ".png", NULL};

enum rmap_status rmap_energy_run(const struct rmap_context *context, const struct rmap_map *map,
                                 const struct rmap_choice *choice, struct rmap_energy_scope *scope,
                                 struct rmap_energy_sums **sums_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_energy_sums *sums = NULL;
    const bool ends = choice->criterion || rmap_scene_changes_weights(rmap_map_scene(map));
    *scope = (struct rmap_energy_scope){.scene = rmap_map_scene(map), .ends = ends};
    const struct rmap_fold fold = {.kind = &rmap_energy_kind,
                                   .context = scope,
                                   .map = map,
                                   .criterion = choice->criterion,
                                   .which = choice->which,
                                   .columns = rmap_energy_columns(scope),
                                   .deferred = rmap_energy_columns(scope)};
    if (ends || rmap_energy_needs_scan(scope->scene)) {
        void *state = NULL;
        RMAP_TRY(rmap_fold_run(context, &fold, &state, err));
        sums = state;
    } else if (context->rank == 0) {
        st = rmap_energy_sums_create(scope, &sums, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
    if (sums && !ends)
        rmap_energy_sums_take_tally(sums, rmap_map_tally(map));
    *sums_ret = sums;
out:
    return st;
}

static enum rmap_status write_file(const struct rmap_energy *energy, const char *path,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_whole_file whole = {0};
    RMAP_TRY(rmap_whole_file_open(&whole, path, err));
    if (strcasecmp(strrchr(path, '.'), ".csv") == 0)
        rmap_energy_csv(energy, whole.file);
    else
        RMAP_TRY(rmap_json_print(rmap_json_of_map(rmap_energy_json(energy), energy->of), whole.file,
                                 err));
    st = rmap_whole_file_finish(&whole, err);
out:
    rmap_whole_file_fini(&whole);
    return st;
}

static enum rmap_status write_picture(const struct rmap_energy *energy, const char *path,
                                      struct rmap_error *err)
{
    struct rmap_svg *svg = NULL;
    enum rmap_status st = rmap_figure_energy(energy, &svg, err);
    if (st == RMAP_OK)
        st = rmap_picture_write(svg, path, RMAP_FIGURE_SCALE, err);
    rmap_svg_destroy(svg);
    return st;
}

/* On rank 0. */
static enum rmap_status show(const struct rmap_context *context, const struct rmap_energy *energy,
                             const char *path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (path && rmap_picture_kind(path) != RMAP_PICTURE_NONE)
        st = write_picture(energy, path, err);
    else if (path)
        st = write_file(energy, path, err);
    if (st != RMAP_OK)
        return st;
    if (context->json)
        return rmap_json_print(rmap_json_of_map(rmap_energy_json(energy), energy->of), stdout, err);
    return rmap_energy_print(energy, stdout, err);
}

enum rmap_status rmap_report_energy(const struct rmap_context *context,
                                    const struct rmap_arguments *given, struct rmap_error *err)
{
    struct rmap_map *map = NULL;
    struct rmap_asked asked = {0};
    struct rmap_criterion *criterion = NULL;
    struct rmap_which *which = NULL;
    struct rmap_energy_scope scope;
    struct rmap_energy_sums *sums = NULL;
    struct rmap_energy *energy = NULL;
    const char *where = rmap_argument(given, "where"), *path = rmap_argument(given, "output");
    char name[RMAP_MAP_NAME_LEN];
    rmap_map_name(given->operand[0], name);
    enum rmap_status st = RMAP_OK;
    if (path)
        st = rmap_output_check(path, suffixes, rmap_argument(given, "force") != NULL, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_asked_load_where(context, given, &where, &asked, err));
    RMAP_TRY(rmap_load_map(context, given->operand[0], &map, err));
    if (asked.n > 0)
        st = rmap_asked_compile(context, &asked, 0, rmap_map_scene(map), &criterion, err);
    if (st == RMAP_OK) {
        const struct rmap_index_set all = {.span = (uint32_t)rmap_map_scene(map)->n_detector};
        st = rmap_asked_which(context, NULL, &asked, rmap_map_scene(map), &all, criterion, &which,
                              err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(
        rmap_energy_run(context, map, &(struct rmap_choice){criterion, which}, &scope, &sums, err));
    if (context->rank == 0) {
        st = rmap_energy_create(map, name, criterion ? rmap_criterion_text(criterion) : NULL, sums,
                                &energy, err);
        if (st == RMAP_OK) {
            energy->which = which;
            st = show(context, energy, path, err);
        }
    }
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_energy_destroy(energy);
    rmap_energy_sums_destroy(sums);
    rmap_which_destroy(which);
    rmap_criterion_destroy(criterion);
    rmap_asked_fini(&asked);
    rmap_map_close(map);
    return st;
}
