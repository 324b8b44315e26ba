/* SPDX-License-Identifier: MIT
 *
 * Sources whose light charged particles make along their steps.
 */
#include "io/scene/scene_steps.h"

#include <string.h>

#include "io/scene/scene_channels.h"
#include "io/scene/scene_placement.h"
#include "io/scene/scene_ray_files.h"
#include "scene/file_rays.h"

static const char *const light_word[RMAP_PHOTON_KINDS] = {"scintillation", "cherenkov"};

/* A word, or a list of them. */
static void read_emit(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      struct rmap_steps *steps)
{
    const struct rmap_yaml_node *emit = rmap_yaml_get(node, "emit");
    const bool list = emit && emit->kind == RMAP_YAML_LIST;
    for (size_t i = 0; emit && i < (list ? emit->n_item : 1); i++) {
        const struct rmap_yaml_node *at = list ? emit->item[i].value : emit;
        const char *text = at->kind == RMAP_YAML_SCALAR ? at->text : "";
        int kind = 0;
        while (kind < RMAP_PHOTON_KINDS && strcmp(text, light_word[kind]) != 0)
            kind++;
        if (kind < RMAP_PHOTON_KINDS)
            steps->emits[kind] = true;
        else
            rmap_reader_unknown(reader, at->line, at->column, "unknown light of steps", text,
                                light_word, RMAP_PHOTON_KINDS);
    }
    if (list && emit->n_item == 0)
        rmap_reader_error(reader, emit, "'emit' must not be empty");
}

static void read_choices(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                         struct rmap_steps *steps)
{
    int counted = 0;
    size_t n = 0;
    (void)rmap_reader_choice(reader, node, "count", RMAP_OPTIONAL, "weighted counted", &counted);
    steps->counted = counted == 1;
    if (rmap_yaml_get(node, "seed"))
        (void)rmap_reader_whole(reader, node, "seed", 0, UINT32_MAX, &steps->seed);
    if (rmap_yaml_get(node, "seed") && !steps->counted)
        rmap_reader_error(reader, rmap_yaml_get(node, "seed"),
                          "'seed' is of the numbers of photons with 'count: counted'");
    if (rmap_reader_numbers(reader, node, "wavelengths", RMAP_OPTIONAL, &rmap_range_wavelength, 2,
                            2, steps->range_nm, &n) &&
        n == 2 && !(steps->range_nm[0] < steps->range_nm[1]))
        rmap_reader_error(reader, rmap_yaml_get(node, "wavelengths"),
                          "'wavelengths' are from and to, which is greater");
    read_emit(reader, node, steps);
}

static void copy_steps(const struct rmap_file_rays *set, double times, struct rmap_steps *steps)
{
    for (size_t i = 0; i < set->n; i++) {
        struct rmap_track_step *step = &steps->step[i];
        rmap_file_rays_get(set, i, &step->position, &step->direction);
        step->position = rmap_scale(step->position, times);
        step->length = times * set->step[i][0];
        step->energy_mev = set->step[i][1];
        step->charge = set->step[i][2];
        step->beta = set->step[i][3];
        step->time_ns = set->delay_ns ? set->delay_ns[i] : 0.0;
        step->event = set->event ? set->event[i] : 0;
    }
}

void rmap_reader_read_steps(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            struct rmap_source *source)
{
    const struct rmap_written_unit *unit = rmap_reader_length_unit(reader, node, "unit");
    (void)rmap_reader_placement(reader, node, &source->frame);
    const struct rmap_file_rays *set = rmap_reader_file_rays(reader, node, true);
    source->distribution = RMAP_DISTRIBUTION_STEPS;
    if (!set)
        return;
    if (!set->step) { /* of a stranger's map */
        rmap_reader_error(reader, node, "the rows of source '%.60s' are no steps", source->name);
        return;
    }
    if (rmap_steps_create(set->n, &source->steps, &reader->failure) != RMAP_OK) {
        rmap_reader_no_memory(reader);
        return;
    }
    const double unit_m = unit ? unit->size : set->unit_m;
    read_choices(reader, node, source->steps);
    copy_steps(set, unit_m > 0.0 ? unit_m / reader->scene->unit_m : 1.0, source->steps);
}

static void place(const struct rmap_affine *to_world, struct rmap_steps *steps)
{
    for (size_t i = 0; i < steps->n; i++) {
        struct rmap_track_step *step = &steps->step[i];
        const struct rmap_vec3 along =
            rmap_affine_vector(to_world, rmap_normalize(step->direction));
        step->position = rmap_affine_point(to_world, step->position);
        step->direction = rmap_normalize(along);
        step->length *= rmap_length(along);
    }
}

void rmap_reader_settle_steps(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                              struct rmap_source *source)
{
    struct rmap_steps *steps = source->steps;
    const struct rmap_yaml_node *emit = rmap_yaml_get(node, "emit");
    if (!steps || source->medium < 0)
        return;
    if (emit && !steps->emits[RMAP_PHOTON_SCINTILLATION] && !steps->emits[RMAP_PHOTON_CHERENKOV])
        return; /* complained of already */
    const struct rmap_medium *medium = &reader->scene->medium[source->medium];
    place(&source->frame, steps);
    source->frame = rmap_affine_identity();
    source->frame.t = steps->step[0].position;
    if (!emit) {
        steps->emits[RMAP_PHOTON_SCINTILLATION] = medium->scintillation != NULL;
        steps->emits[RMAP_PHOTON_CHERENKOV] = !medium->field;
    }
    if (steps->emits[RMAP_PHOTON_SCINTILLATION] && !medium->scintillation)
        rmap_reader_error(reader, emit,
                          "medium '%.60s' of source '%.60s' does not scintillate: give it "
                          "'scintillation', or 'emit' without that",
                          medium->name, source->name);
    else if (steps->emits[RMAP_PHOTON_CHERENKOV] && medium->field)
        rmap_reader_error(reader, emit,
                          "medium '%.60s' of source '%.60s' is a gradient medium: Cherenkov light "
                          "wants one index",
                          medium->name, source->name);
    else {
        const struct rmap_steps_medium of = rmap_source_steps_medium(reader->scene, source);
        rmap_reader_made(reader, rmap_yaml_get(node, "file"),
                         rmap_steps_prepare(steps, &of, source->colour, &reader->failure));
    }
}
