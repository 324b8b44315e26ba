/* SPDX-License-Identifier: MIT
 *
 * What the readers of gradient media (scene_field*.c) share. A field that is wrong is complained
 * of and left NULL.
 */
#ifndef RMAP_SCENE_FIELD_H
#define RMAP_SCENE_FIELD_H

#include "gradient/models.h"
#include "io/scene/scene_keys.h"

/* A field of any model: `type`, what the model asks for, and the frame that `at`, `rotate`,
 * `scale`, `matrix` of the same mapping give it. */
struct rmap_field_place {
    const char *path; /* among the bundle's: the medium's name, then "/1", "/2" for parts */
    bool whole;    /* a medium's: its frame is that of the place, and other keys may stand there */
    bool weighted; /* `weight` may stand there */
    bool scalar;   /* what an index is a function of, not an index */
    double size;   /* of what it fills, in its frame, about: for finite differences */
};
void rmap_reader_field(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const struct rmap_field_place *place, struct rmap_field **field_ret);

/* Makers take structures of doubles, one per channel: value[channel * width + k] is of name[k]. */
struct rmap_field_parameter {
    const char *name;
    double otherwise; /* NaN: required */
};
void rmap_reader_parameters(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const struct rmap_field_parameter *parameter, size_t width,
                            double *value, bool *good);

/* A list of numbers on the channels: value[channel * *width_ret + k], arena. NULL after a
 * complaint. */
void rmap_reader_channel_list(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                              const char *key, size_t n_max, size_t *width_ret, double **value_ret);

/* 1 where the rows of [n_channel][width] are the same, else the scene's number of channels. */
int rmap_reader_distinct(const struct rmap_reader *reader, const double *value, size_t width);

/* The scene's number of channels, or 1 where all have one wavelength. */
int rmap_reader_distinct_wavelengths(const struct rmap_reader *reader);

/* The grid that a mapping describes, of this name in the bundle, which it is put into first when it
 * comes from its file; left alone after a complaint. */
void rmap_reader_find_grid(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           const char *path, struct rmap_grid **grid_ret);

/* How a model is read: by a function of its own, or from its parameters alone. */
#define RMAP_FIELD_KEY_MAX 12
struct rmap_field_model {
    const char *type;
    struct rmap_field_parameter parameter[RMAP_FIELD_KEY_MAX]; /* ends with a NULL name */
    const char *key[RMAP_FIELD_KEY_MAX];                       /* others; ends with NULL */
    enum rmap_status (*make)(struct rmap_field **field_ret, int n_channel, const double *parameter,
                             struct rmap_error *err);
    void (*read)(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                 const struct rmap_field_place *place, struct rmap_field **field_ret);
};
/* The i-th model: of formulas in closed form, made of other fields, from files; NULL after the
 * last. */
const struct rmap_field_model *rmap_field_model_analytic(size_t i);
const struct rmap_field_model *rmap_field_model_made(size_t i);
const struct rmap_field_model *rmap_field_model_from_file(size_t i);

#endif
