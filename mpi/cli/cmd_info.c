/* SPDX-License-Identifier: MIT
 *
 * raymap info: what a map holds.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/map/history_file.h"
#include "io/map/map_chunks.h"
#include "io/map/map_content.h"
#include "io/map/map_directory.h"
#include "io/map/map_rays.h"
#include "io/map/map_reader.h"
#include "io/map/selection.h"
#include "mpi/answer/kept_columns_out.h"
#include "mpi/answer/named_rays_out.h"
#include "mpi/answer/unfinished_out.h"
#include "mpi/command/balance.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/progress.h"
#include "portion/weight.h"

static const struct rmap_option options[] = {{NULL}};

/* Sum of the registrations that a detector's image holds. */
static uint64_t registered(const struct rmap_map *map, size_t detector)
{
    const struct rmap_scene *scene = rmap_map_scene(map);
    const uint32_t *cells = scene->detector[detector].cells;
    double total = 0.0;
    for (size_t s = 0; s < scene->n_source; s++) {
        const double *image = rmap_tally_image(rmap_map_tally(map), detector, s);
        for (size_t i = 0; i < (size_t)cells[0] * cells[1]; i++)
            total += image[i];
    }
    return rmap_weight_whole(total);
}

static const char *detector_type(const struct rmap_detector *detector)
{
    return detector->camera.radius > 0.0           ? "camera"
           : detector->type == RMAP_DETECTOR_PLANE ? "plane"
                                                   : "intensity";
}

/* Of what it shows. */
static const uint32_t *cells_of(const struct rmap_detector *detector)
{
    return detector->camera.radius > 0.0 ? detector->camera.pixels : detector->cells;
}

static json_t *objects_json(const struct rmap_scene *scene)
{
    json_t *list = json_array();
    for (size_t o = 0; o < scene->n_object; o++) {
        const struct rmap_object *object = &scene->object[o];
        char id[17];
        (void)snprintf(id, sizeof id, "%llx", (unsigned long long)object->id);
        (void)json_array_append_new(
            list, json_pack("{s:s, s:s, s:s?, s:s, s:s, s:s}", "name", object->name, "id", id,
                            "group", object->parent >= 0 ? scene->group[object->parent].name : NULL,
                            "geometry", scene->geometry[object->geometry].name, "surface_front",
                            scene->surface[object->surface_front].name, "surface_back",
                            scene->surface[object->surface_back].name));
    }
    return list;
}

static json_t *detectors_json(const struct rmap_map *map)
{
    const struct rmap_scene *scene = rmap_map_scene(map);
    json_t *list = json_array();
    for (size_t d = 0; d < scene->n_detector; d++) {
        const struct rmap_detector *detector = &scene->detector[d];
        (void)json_array_append_new(list, json_pack("{s:s, s:s, s:[I,I], s:I}", "name",
                                                    detector->name, "type", detector_type(detector),
                                                    "cells", (json_int_t)cells_of(detector)[0],
                                                    (json_int_t)cells_of(detector)[1], "registered",
                                                    (json_int_t)registered(map, d)));
    }
    return list;
}

static json_t *shards_json(const struct rmap_map *map)
{
    json_t *list = json_array();
    for (size_t i = 0; i < rmap_map_n_piece(map); i++) {
        const struct rmap_piece_info *piece = rmap_map_piece(map, i);
        (void)json_array_append_new(
            list, json_pack("{s:i, s:s, s:s, s:b, s:I, s:I, s:I, s:I}", "shard", (int)piece->shard,
                            "piece", piece->name, "encoding",
                            rmap_encoding_name((enum rmap_encoding)piece->encoding), "open",
                            (int)piece->is_open, "bytes", (json_int_t)piece->nbytes, "rays",
                            (json_int_t)piece->n_row[RMAP_TABLE_RAY], "segments",
                            (json_int_t)piece->n_row[RMAP_TABLE_SEGMENT], "registrations",
                            (json_int_t)piece->n_row[RMAP_TABLE_REGISTRATION]));
    }
    return list;
}

static json_t *spaces_json(const struct rmap_map *map)
{
    json_t *list = json_array();
    for (size_t i = 0; i < rmap_map_n_space(map); i++) {
        const struct rmap_channels *channels = &rmap_map_scene_of(map, i)->channels;
        (void)json_array_append_new(
            list,
            json_pack("{s:s, s:i}", "mode", channels->mode == RMAP_COLOUR_RGB ? "rgb" : "spectral",
                      "channels", channels->n));
    }
    return list;
}

static json_t *trouble_json(const struct rmap_map *map)
{
    json_t *list = json_array();
    for (size_t i = 0; i < rmap_map_n_trouble(map); i++)
        (void)json_array_append_new(list, json_string(rmap_map_trouble(map, i)));
    return list;
}

/* Flux of the picked rays of each source; rmap_free. NULL: all rays are there, or no memory. */
static double *picked_flux(const struct rmap_map *map)
{
    size_t n = rmap_map_scene(map)->n_source;
    double *flux = rmap_map_selection(map) ? rmap_alloc(n, sizeof *flux) : NULL;
    for (size_t s = 0; flux && s < n; s++)
        flux[s] = rmap_map_flux_per_weight(map)[s] * rmap_map_tally(map)->emitted[s];
    return flux;
}

/* null of a map that holds all rays that were traced. */
static json_t *selection_json(const struct rmap_selection *selection)
{
    if (!selection)
        return json_null();
    json_t *steps = json_array(), *emitted = json_array();
    for (size_t i = 0; i < selection->n; i++) {
        const struct rmap_selection_step *step = &selection->step[i];
        (void)json_array_append_new(steps, json_pack("{s:i, s:s, s:s, s:s}", "part",
                                                     (int)step->part, "map", step->map, "criterion",
                                                     step->criterion, "answer", step->answer));
    }
    for (size_t s = 0; s < selection->n_source; s++)
        (void)json_array_append_new(emitted, json_integer((json_int_t)selection->emitted[s]));
    return json_pack("{s:o, s:s, s:I, s:b, s:o}", "steps", steps, "digest", selection->digest,
                     "rays", (json_int_t)selection->n_ray, "complete", (int)selection->complete,
                     "emitted", emitted);
}

static json_t *info_json(const struct rmap_map *map, const struct rmap_map_summary *summary,
                         const struct rmap_history_files *indexes,
                         const struct rmap_columns_survey *kept,
                         const struct rmap_named_rays_list *named,
                         const struct rmap_findings *unfinished_files)
{
    char digest[33];
    rmap_digest_text(summary->digest, digest);
    double *flux = picked_flux(map);
    json_t *sources = rmap_balance_json(rmap_map_tally(map), flux);
    rmap_free(flux);
    json_t *versions = json_pack("{s:s, s:s, s:s, s:s, s:s, s:i}", "raymap",
                                 summary->program_version, "git", summary->git_revision, "hdf5",
                                 summary->hdf5_version, "embree", summary->embree_version, "isa",
                                 summary->isa, "tracer", (int)summary->tracer_revision);
    json_t *info = json_pack(
        "{s:I, s:I, s:I, s:I, s:b, s:I, s:s, s:s, s:o, s:o, s:o, s:o, s:i, s:o, s:o, "
        "s:o, s:{s:I, s:I, s:I, s:s}, s:o}",
        "rays", (json_int_t)summary->n_row[RMAP_TABLE_RAY], "segments",
        (json_int_t)summary->n_row[RMAP_TABLE_SEGMENT], "registrations",
        (json_int_t)summary->n_row[RMAP_TABLE_REGISTRATION], "bytes", (json_int_t)summary->nbytes,
        "complete", (int)summary->complete, "seed", (json_int_t)summary->seed, "digest", digest,
        "units", rmap_map_scene(map)->unit, "sources", sources, "objects",
        objects_json(rmap_map_scene(map)), "detectors", detectors_json(map), "shards",
        shards_json(map), "ranks", summary->n_rank, "versions", versions, "spaces",
        spaces_json(map), "trouble", trouble_json(map), "index", "pieces", (json_int_t)indexes->n,
        "bytes", (json_int_t)indexes->nbytes, "unused", (json_int_t)indexes->n, "why",
        indexes->n > 0 ? "history indexes are no longer used" : "", "selection",
        selection_json(rmap_map_selection(map)));
    uint64_t asked = 0;
    const bool is_known = rmap_rays_asked(map, &asked);
    if (info)
        (void)json_object_set_new(info, "kept", rmap_kept_columns_json(kept));
    if (info)
        (void)json_object_set_new(info, "selections", rmap_named_rays_json(named));
    if (info)
        (void)json_object_set_new(info, "unfinished", rmap_unfinished_json(unfinished_files));
    if (info)
        (void)json_object_set_new(info, "rays_asked",
                                  is_known ? json_integer((json_int_t)asked) : json_null());
    if (info)
        (void)json_object_set_new(info, "rays_traced",
                                  json_integer((json_int_t)summary->n_row[RMAP_TABLE_RAY]));
    if (info && *summary->parent)
        (void)json_object_set_new(info, "parent", json_string(summary->parent));
    if (info && rmap_scene_is_curved(rmap_map_scene(map)))
        (void)json_object_set_new(info, "curve_points",
                                  json_integer((json_int_t)summary->n_row[RMAP_TABLE_CURVE]));
    return info;
}

static void print_detectors(const struct rmap_map *map, FILE *out)
{
    const struct rmap_scene *scene = rmap_map_scene(map);
    for (size_t d = 0; d < scene->n_detector; d++) {
        const struct rmap_detector *detector = &scene->detector[d];
        fprintf(out, "  detector %s: %s, %u x %u cells, %s\n", detector->name,
                detector_type(detector), (unsigned)cells_of(detector)[0],
                (unsigned)cells_of(detector)[1],
                rmap_counted(registered(map, d), "registration").text);
    }
}

static void print_selection(const struct rmap_selection *selection, FILE *out)
{
    for (size_t i = 0; i < selection->n; i++) {
        const struct rmap_selection_step *step = &selection->step[i];
        bool first = i == 0 || step->part != step[-1].part;
        fprintf(out, "  %s %s: %s",
                !first       ? "  and then from"
                : step->part ? "  and from"
                             : "picked from",
                step->map, step->criterion);
        if (strcmp(step->answer, "all") != 0)
            fprintf(out, " (%s)", step->answer);
        fputc('\n', out);
    }
    fprintf(out, "  traced: %s, digest %s%s; fluxes are those in that map\n",
            rmap_counted(selection->n_ray, "ray").text, selection->digest,
            selection->complete ? "" : ", not complete then");
}

/* Why a map is not complete. */
static const char *unfinished(const char *path, const struct rmap_map *map)
{
    if (rmap_map_selection(map))
        return "NOT complete: rays that the query picked are missing; ask again with --force";
    if (rmap_map_n_piece(map) == 0)
        return "NOT complete: it holds no rays yet";
    return rmap_map_is_live(path)
               ? "NOT complete: it is being traced"
               : "NOT complete: rays that were asked for are missing (--resume traces them)";
}

static void print_info(const char *path, const struct rmap_map *map,
                       const struct rmap_map_summary *summary,
                       const struct rmap_history_files *indexes,
                       const struct rmap_columns_survey *kept,
                       const struct rmap_named_rays_list *named, bool damaged, FILE *out)
{
    const struct rmap_scene *scene = rmap_map_scene(map);
    const char *encodings = rmap_map_content_encodings(rmap_map_contents(map));
    char digest[33];
    rmap_digest_text(summary->digest, digest);
    double n_segment = (double)summary->n_row[RMAP_TABLE_SEGMENT];
    uint64_t asked = 0;
    fprintf(out, "%s: %s\n", path,
            summary->complete ? "complete"
            : damaged         ? "damaged: pieces are missing or cut off"
                              : unfinished(path, map));
    if (rmap_rays_asked(map, &asked) && asked != summary->n_row[RMAP_TABLE_RAY])
        fprintf(out, "  asked for: %s\n", rmap_counted(asked, "ray").text);
    fprintf(out, "  %s, %s, %s", rmap_counted(summary->n_row[RMAP_TABLE_RAY], "ray").text,
            rmap_counted(summary->n_row[RMAP_TABLE_SEGMENT], "segment").text,
            rmap_counted(summary->n_row[RMAP_TABLE_REGISTRATION], "registration").text);
    if (rmap_scene_is_curved(scene))
        fprintf(out, ", %s of curved segments",
                rmap_counted(summary->n_row[RMAP_TABLE_CURVE], "point").text);
    fputc('\n', out);
    fprintf(out, "  %.1f MB", 1e-6 * (double)summary->nbytes);
    if (n_segment > 0)
        fprintf(out, ", %.2f bytes per segment", (double)summary->nbytes / n_segment);
    fprintf(out, ", %s, %s%s%s\n", rmap_counted((uint64_t)summary->n_shard, "shard").text,
            rmap_counted(rmap_map_n_piece(map), "piece").text, *encodings ? ", " : "", encodings);
    if (indexes->n > 0)
        fprintf(out,
                "  history indexes of %s, %.1f MB beside that, are no longer used: raymap repair "
                "removes them\n",
                rmap_counted(indexes->n, "piece").text, 1e-6 * (double)indexes->nbytes);
    rmap_kept_columns_print(kept, out);
    fprintf(out, "  digest %s, seed %llu, ranks %d\n", digest, (unsigned long long)summary->seed,
            summary->n_rank);
    if (*summary->parent)
        fprintf(out, "  traced from the map with digest %s, of an earlier version of the scene\n",
                summary->parent);
    fprintf(out, "  made by raymap %s (%s, tracer revision %d) with Embree %s (%s), HDF5 %s\n",
            summary->program_version, summary->git_revision, (int)summary->tracer_revision,
            summary->embree_version, summary->isa, summary->hdf5_version);
    fprintf(out, "  scene: %s, %s, %s, %zu medi%s, lengths in %s\n",
            rmap_counted(scene->n_object, "object").text,
            rmap_counted(scene->n_geometry, "geometry").text,
            rmap_counted(scene->n_surface, "surface").text, scene->n_medium,
            scene->n_medium == 1 ? "um" : "a", scene->unit);
    if (rmap_map_selection(map))
        print_selection(rmap_map_selection(map), out);
    for (size_t i = 0; i < rmap_map_n_space(map); i++) {
        const struct rmap_channels *channels = &rmap_map_scene_of(map, i)->channels;
        fprintf(out, "  colour space %zu: %s, %s\n", i,
                channels->mode == RMAP_COLOUR_RGB ? "rgb" : "spectral",
                rmap_counted((uint64_t)channels->n, "channel").text);
    }
    print_detectors(map, out);
    rmap_named_rays_print(NULL, named, out);
    double *flux = picked_flux(map);
    rmap_balance_print(rmap_map_tally(map), flux, out);
    rmap_free(flux);
}

/* What the index holds is printed even if pieces are missing; the status then says so. */
static enum rmap_status tell(const struct rmap_context *context, const char *path,
                             struct rmap_map *map, struct rmap_error *err)
{
    struct rmap_map_summary summary;
    rmap_map_summarise(map, &summary);
    enum rmap_status st = rmap_map_compare_directory(map, err);
    if (st != RMAP_OK)
        return st;
    enum rmap_status pieces = rmap_map_check_pieces(map, err);
    if (pieces == RMAP_FORMAT) /* trouble names them all */
        pieces = rmap_error_set(err, pieces, "%s: pieces are missing or damaged", path);
    for (size_t i = 0; i < rmap_map_n_trouble(map); i++)
        fprintf(stderr, "raymap: %s\n", rmap_map_trouble(map, i));
    summary.complete = summary.complete && pieces == RMAP_OK;
    struct rmap_history_files indexes;
    struct rmap_columns_survey kept;
    struct rmap_named_rays_list named;
    struct rmap_findings left = {0};
    st = rmap_history_files_measure(map, &indexes, err);
    if (st == RMAP_OK)
        st = rmap_map_columns_survey(map, &kept, err);
    if (st == RMAP_OK)
        st = rmap_named_rays_list(map, &named, err);
    if (st != RMAP_OK)
        return st;
    st = rmap_map_note_unfinished(path, &left, err);
    if (st == RMAP_OK && context->json)
        st = rmap_json_print(info_json(map, &summary, &indexes, &kept, &named, &left), stdout, err);
    else if (st == RMAP_OK)
        print_info(path, map, &summary, &indexes, &kept, &named, pieces != RMAP_OK, stdout);
    if (st == RMAP_OK && !context->json)
        rmap_unfinished_print(&left, stdout);
    rmap_findings_fini(&left);
    rmap_named_rays_list_fini(&named);
    return st == RMAP_OK ? pieces : st;
}

static enum rmap_status run_info(const struct rmap_context *context,
                                 const struct rmap_arguments *given, struct rmap_error *err)
{
    struct rmap_map *map = NULL;
    enum rmap_status st = RMAP_OK;
    if (context->rank == 0) { /* the index alone is read: there is nothing to share out */
        st = rmap_map_open(given->operand[0], &map, err);
        if (st == RMAP_OK)
            st = tell(context, given->operand[0], map, err);
    }
    st = rmap_agree(context, st, err);
    rmap_map_close(map);
    return st;
}

const struct rmap_command rmap_command_info = {
    .name = "info",
    .summary = "say what a ray map holds, where it comes from, if it is complete",
    .operands = "MAP",
    .help = "Rays, segments, registrations, bytes, names, shards, provenance, digest and the\n"
            "energy balance of each source.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_info,
};
