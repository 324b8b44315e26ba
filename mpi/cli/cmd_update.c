/* SPDX-License-Identifier: MIT
 *
 * raymap update: a new revision of an imported model.
 */
#include "mpi/answer/model_run.h"
#include "mpi/command/command.h"
#include "mpi/parallel/agree.h"

static const struct rmap_option options[] = {
    {"dry-run", 'n', NULL, "tell what would change, and write nothing"},
    RMAP_MODEL_OPTIONS,
    {"force", 'f', NULL,
     "keep an edited parts.yaml as parts.yaml.bak, and write a new one; take a model that has "
     "nothing "
     "of the one before"},
    {NULL}};

/* Rank 0 does it all. */
static enum rmap_status run_update(const struct rmap_context *context,
                                   const struct rmap_arguments *given, struct rmap_error *err)
{
    enum rmap_status st = rmap_model_check_options(given, given->operand[1], err);
    if (st == RMAP_OK && context->rank == 0)
        st = rmap_model_update(context, given, err);
    return rmap_agree(context, st, err);
}

const struct rmap_command rmap_command_update = {
    .name = "update",
    .summary = "bring a new revision of an imported model",
    .operands = "FOLDER MODEL",
    .help =
        "Takes the next revision of a model into the FOLDER that `raymap import` made: parts are\n"
        "found again by their ids, names, places and shapes, keep their names and ids in the scene "
        "and\n"
        "so all that rules in attributes.yaml give them. Meshes that are as they were stay "
        "untouched;\n"
        "scene.yaml and attributes.yaml are not written. --chord, --angle and --unit are those of "
        "the\n"
        "import. Tells what was kept, moved, changed, renamed, is new, is gone.\n\n"
        "  raymap import lamp-a.step -o lamp\n"
        "  raymap update lamp lamp-b.step",
    .options = options,
    .min_operands = 2,
    .max_operands = 2,
    .run = run_update,
    .stops_in_order = true,
};
