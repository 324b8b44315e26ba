/* SPDX-License-Identifier: MIT
 *
 * raymap import: a scene of what lens designers and CAD programs have.
 */
#include "mpi/answer/lens_run.h"
#include "mpi/answer/model_run.h"
#include "mpi/command/command.h"
#include "mpi/command/model_read.h"
#include "mpi/parallel/agree.h"

static const struct rmap_option options[] = {
    {"output", 'o', "FOLDER", "where the scene goes, as FOLDER/scene.yaml"},
    {"glass", 0, "FILE.agf" RMAP_ARGUMENT_AGAIN,
     "a glass catalogue; those beside the lens file are read without being named"},
    RMAP_MODEL_OPTIONS,
    {"strict", 0, NULL, "write nothing if anything is not understood: status 3"},
    {"force", 'f', NULL, "keep an edited scene.yaml as scene.yaml.bak, and write a new one"},
    {NULL}};

/* Rank 0 does it all. */
static enum rmap_status run_import(const struct rmap_context *context,
                                   const struct rmap_arguments *given, struct rmap_error *err)
{
    const char *folder = rmap_argument(given, "output"), *path = given->operand[0];
    enum rmap_status st = RMAP_OK;
    if (!folder)
        st = rmap_error_set(err, RMAP_USAGE, "-o FOLDER is missing: where the scene goes");
    else
        st = rmap_model_check_options(given, path, err);
    if (st == RMAP_OK && context->rank == 0)
        st = rmap_model_is_one(path) ? rmap_model_import(context, given, folder, err)
                                     : rmap_lens_import(context, given, folder, err);
    return rmap_agree(context, st, err);
}

const struct rmap_command rmap_command_import = {
    .name = "import",
    .summary = "write a scene of a lens or CAD file",
    .operands = "FILE -o FOLDER",
    .help =
        "Reads a lens of Zemax (.zmx, .zar), CODE V (.seq) or OSLO (.len) and writes "
        "FOLDER/scene.yaml,\n"
        "to be read and edited like any other: glasses by their names, apertures, stops, mirrors,\n"
        "tilts, fields as sources, the image as a detector. What is not understood is told with\n"
        "its line and surface, and stands as a remark in the scene; --strict makes it a mistake.\n"
        "A scene of an import is replaced; one that was edited since is not, unless --force is "
        "given,\n"
        "which keeps it as scene.yaml.bak. What is written is checked as by `raymap check`: status "
        "3\n"
        "where that refuses it.\n\n"
        "Of a model (STEP and IGES where raymap-step is installed, glTF, OBJ, STL, PLY) the tree "
        "of\n"
        "parts goes to FOLDER/parts.yaml and their meshes to FOLDER/meshes; scene.yaml and\n"
        "attributes.yaml, rules that say what parts are made of, are for you to edit: `raymap\n"
        "update` brings the model's next revision and keeps them.\n\n"
        "  raymap import double-gauss.zmx -o lens\n"
        "  raymap trace lens/scene.yaml -n 1M -o lens.raymap\n"
        "  raymap ghosts lens.raymap sensor\n"
        "  raymap import lamp.step -o lamp",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_import,
    .stops_in_order = true,
};
