/* SPDX-License-Identifier: MIT
 *
 * Lamps by their maker's files.
 */
#include "io/scene/scene_lamps.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "io/lamp/lamp_file.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_sources.h"
#include "io/scene/scene_tables.h"

static bool format_of(struct rmap_reader *reader, const struct rmap_yaml_node *at, const char *text,
                      enum rmap_lamp_format *format)
{
    const size_t len = strlen(at->text);
    const char *ending = len > 4 ? at->text + len - 4 : "";
    *format = RMAP_LAMP_IES;
    if (strcasecmp(ending, ".ies") == 0 || strncmp(text, "IES", 3) == 0)
        return true;
    *format = RMAP_LAMP_EULUMDAT;
    if (strcasecmp(ending, ".ldt") == 0)
        return true;
    rmap_reader_error(reader, at,
                      "'%.100s' is no lamp's file by its name: IES LM-63 ends in .ies, EULUMDAT in "
                      ".ldt",
                      at->text);
    return false;
}

static bool read_file(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      const char *key, struct rmap_lamp_file *file)
{
    static const struct rmap_text_kind kind = {"a lamp's file", "text", "", (size_t)16 << 20};
    const struct rmap_yaml_node *at = rmap_yaml_get(node, key);
    enum rmap_lamp_format format;
    static const struct rmap_range tilt = {-180, 180, "an angle in degrees", RMAP_DIMENSION_ANGLE};
    struct rmap_lamp_choice choice = {0};
    struct rmap_error why;
    uint64_t set = 0;
    size_t nbytes = 0;
    const char *text = rmap_reader_file(reader, node, key, &kind, &nbytes);
    if (!text || !format_of(reader, at, text, &format) ||
        (rmap_yaml_get(node, "set") &&
         !rmap_reader_whole(reader, node, "set", 1, RMAP_LAMP_SETS_MAX, &set)) ||
        !rmap_reader_number(reader, node, "tilt", RMAP_OPTIONAL, &tilt, &choice.tilt_deg))
        return false;
    choice.set = (size_t)set;
    const enum rmap_status st = rmap_lamp_file_read(text, nbytes, format, &choice, file, &why);
    if (st == RMAP_SYSTEM) {
        reader->failure = why;
        rmap_reader_fail(reader, st);
    } else if (st != RMAP_OK) {
        rmap_reader_error(reader, at, "%.100s: %s", at->text, why.text);
    }
    return st == RMAP_OK;
}

/* In place of the file's opening. */
static void read_emitter(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                         struct rmap_source *source)
{
    static const char *const shape[] = {"disc", "rectangle", "line", "mesh"};
    const struct rmap_yaml_node *emitter = rmap_yaml_get(node, "emitter");
    struct rmap_lamp *lamp = source->lamp;
    size_t n = 0, given = 0;
    if (!emitter)
        return;
    const char *word = emitter->kind == RMAP_YAML_SCALAR ? emitter->text : "";
    if (strcmp(word, "point") == 0)
        lamp->body = RMAP_LAMP_POINT;
    if (strcmp(word, "point") == 0 || strcmp(word, "opening") == 0)
        return;
    if (emitter->kind == RMAP_YAML_MAP &&
        !rmap_reader_check_keys(reader, emitter, "an emitter", shape, RMAP_COUNT(shape)))
        return;
    for (size_t i = 0; i < RMAP_COUNT(shape); i++)
        given += rmap_yaml_get(emitter, shape[i]) != NULL;
    if (given != 1) {
        rmap_reader_error(reader, emitter,
                          "an emitter is 'opening', 'point', {disc: radius}, {rectangle: [w, h]}, "
                          "{line: length} or {mesh: geometry}");
        return;
    }
    memset(lamp->size, 0, sizeof lamp->size);
    memset(lamp->side, 0, sizeof lamp->side);
    lamp->along = 2;
    lamp->body = RMAP_LAMP_BOX;
    if (rmap_yaml_get(emitter, "disc")) {
        lamp->body = RMAP_LAMP_CYLINDER;
        (void)rmap_reader_number(reader, emitter, "disc", RMAP_REQUIRED, &rmap_range_size,
                                 &lamp->size[0]);
        lamp->size[0] = lamp->size[1] = 2.0 * lamp->size[0];
    } else if (rmap_yaml_get(emitter, "rectangle")) {
        (void)rmap_reader_numbers(reader, emitter, "rectangle", RMAP_REQUIRED, &rmap_range_size, 1,
                                  2, lamp->size, &n);
        if (n == 1)
            lamp->size[1] = lamp->size[0];
    } else if (rmap_yaml_get(emitter, "line")) {
        (void)rmap_reader_number(reader, emitter, "line", RMAP_REQUIRED, &rmap_range_size,
                                 &lamp->size[1]);
    } else {
        lamp->body = RMAP_LAMP_POINT;
        rmap_reader_mesh_shape(reader, emitter, source);
    }
}

/* C 0 goes around the lamp's axis. */
static void read_spin(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      struct rmap_source *source)
{
    static const struct rmap_range turn = {-36000, 36000, "an angle in degrees",
                                           RMAP_DIMENSION_ANGLE};
    double spin = 0.0;
    if (!rmap_reader_number(reader, node, "spin", RMAP_OPTIONAL, &turn, &spin) || spin == 0.0)
        return;
    const double c = cos(spin * RMAP_PI / 180.0), s = sin(spin * RMAP_PI / 180.0);
    const struct rmap_affine about = {{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}, {0, 0, 0}};
    source->frame = rmap_affine_compose(&source->frame, &about);
}

/* Intensities of the file under `key`, and its flux where the scene is silent. */
static bool take_lamp(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      const char *key, struct rmap_source *source, struct rmap_source_light *light,
                      struct rmap_lamp_file *file)
{
    struct rmap_error why;
    source->distribution = RMAP_DISTRIBUTION_LAMP;
    source->lamp = rmap_alloc(1, sizeof *source->lamp);
    if (!source->lamp) {
        rmap_reader_no_memory(reader);
        return false;
    }
    if (!read_file(reader, node, key, file))
        return false;
    struct rmap_lamp *lamp = source->lamp;
    const enum rmap_status st = rmap_lamp_init(file->around_deg, file->n_around, file->polar_deg,
                                               file->n_polar, file->candela, lamp, &why);
    if (st == RMAP_SYSTEM) {
        reader->failure = why;
        rmap_reader_fail(reader, st);
    } else if (st != RMAP_OK) {
        rmap_reader_error(reader, rmap_yaml_get(node, key), "%.100s: %s",
                          rmap_yaml_get(node, key)->text, why.text);
    }
    memcpy(lamp->title, file->title, sizeof lamp->title);
    for (int k = 0; k < 3; k++)
        lamp->axis[k] = rmap_vec3(file->axis[k][0], file->axis[k][1], file->axis[k][2]);
    if (!rmap_yaml_get(light->node, "flux")) {
        light->flux = lamp->flux;
        light->unit = RMAP_FLUX_LM;
    }
    return true;
}

void rmap_reader_distribution_file(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                   const char *key, struct rmap_source *source,
                                   struct rmap_source_light *light)
{
    struct rmap_lamp_file file = {0};
    if (take_lamp(reader, node, key, source, light, &file) && source->type == RMAP_SOURCE_POINT) {
        source->type = RMAP_SOURCE_LAMP;
        source->shape = RMAP_EMITTER_BODY;
        source->lamp->body = RMAP_LAMP_POINT;
        source->lamp->along = 2;
    }
    rmap_lamp_file_fini(&file);
}

void rmap_reader_read_lamp(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           struct rmap_source *source, struct rmap_source_light *light)
{
    struct rmap_lamp_file file = {0};
    source->shape = RMAP_EMITTER_BODY;
    read_spin(reader, node, source);
    if (take_lamp(reader, node, "file", source, light, &file)) {
        struct rmap_lamp *lamp = source->lamp;
        lamp->body = file.body;
        lamp->along = file.along;
        for (int k = 0; k < 2; k++)
            lamp->side[k] = file.side_m[k] / reader->scene->unit_m;
        for (int k = 0; k < 3; k++)
            lamp->size[k] = file.size_m[k] / reader->scene->unit_m;
        read_emitter(reader, node, source);
    }
    rmap_lamp_file_fini(&file);
}
