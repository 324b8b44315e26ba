/* SPDX-License-Identifier: MIT
 *
 * What the parts of the scene reader (scene_*.c, one per section of the file) share: the reader's
 * state, typed access to YAML values with complaints that say where and what to do, and names.
 *
 * A mistake is put into the diagnostics and reading goes on, with the broken item kept under its
 * name so that nothing else complains about it; the scene is thrown away in the end. That memory
 * ran short is kept in reader->status: what is read from there on does not count, but must not
 * crash.
 */
#ifndef RMAP_SCENE_READER_H
#define RMAP_SCENE_READER_H

#include <stdbool.h>
#include <stdint.h>

#include "base/unit.h"
#include "io/file/diagnostics.h"
#include "io/mesh/bundle.h"
#include "io/scene/receivers.h"
#include "io/scene/scene_values.h"
#include "io/scene/yaml_tree.h"
#include "optics/dispersion.h"
#include "optics/spectrum.h"
#include "scene/scene.h"

/* Names of one kind, hashed. Strings are borrowed. */
struct rmap_name {
    const char *text;
    int32_t kind, index;
    int32_t line;
};

struct rmap_names {
    struct rmap_name *name; /* [n], in order of entry */
    size_t n, cap;
    uint32_t *slot; /* [n_slot], index in name + 1, 0: free */
    size_t n_slot;
};

enum rmap_member {
    RMAP_MEMBER_OBJECT,
    RMAP_MEMBER_GROUP,
    RMAP_MEMBER_SOURCE,
    RMAP_MEMBER_DETECTOR
};

/* A row of a prescription. */
struct rmap_lens_row {
    struct rmap_shape shape; /* CONIC */
    double z;                /* of its vertex */
    double rim_z;            /* z + sag(aperture) */
    int32_t medium;          /* after it */
    bool stop;
    int32_t geometry, edge_geometry, stop_geometry; /* made on first use; -1: not yet */
    const struct rmap_yaml_node *node;
};

struct rmap_lens {
    struct rmap_lens_row *row;
    size_t n_row;
    double widest; /* semi-diameter */
    int32_t surface_front, surface_back, edge_front, edge_back;
    int n_edge; /* edge geometries made so far */
};

/* A geometry as the file has it. */
struct rmap_geometry_entry {
    const char *name;
    bool broken;
    struct rmap_lens *lens; /* or NULL: `geometry` of the scene */
    int32_t geometry;
};

/* Where a gradient medium's index lives. */
enum rmap_frame_kind { RMAP_FRAME_OBJECT, RMAP_FRAME_WORLD, RMAP_FRAME_NAMED };
struct rmap_medium_frame {
    int32_t medium;
    const struct rmap_yaml_node *node; /* of `gradient` */
    enum rmap_frame_kind kind;
    struct rmap_affine placement;       /* of the field inside the frame */
    int32_t shared;                     /* WORLD, NAMED: 1 + index of the one place; 0: not yet */
    int32_t first;                      /* OBJECT: first place made, or -1 */
    int32_t first_object, other_object; /* whose frames differ; -1 */
    bool lenient; /* of a formula, a grid or a plug-in, which may lack an index here and there */
    bool open;    /* OBJECT: a surface that closes no body by itself names the medium */
};

struct rmap_reader {
    struct rmap_bundle *bundle;
    struct rmap_yaml_node *root;
    struct rmap_scene *scene;
    struct rmap_diagnostics *diagnostics;
    struct rmap_error *err;
    enum rmap_status status;                 /* RMAP_SYSTEM once memory ran short; *err says it */
    struct rmap_error failure;               /* of the library call in hand */
    const struct rmap_yaml_node *simulation; /* the one chosen, or NULL */
    size_t cap_medium, cap_surface, cap_geometry, cap_object, cap_group, cap_source, cap_detector,
        cap_camera;
    struct rmap_names media, surfaces, geometries, members;
    struct rmap_names meshes, grids; /* of the bundle, as it was given */
    struct rmap_geometry_entry *entry;
    size_t n_entry, cap_entry;
    struct rmap_affine *group_to_world; /* [n_group] */
    size_t cap_group_to_world;
    struct rmap_medium_frame *frame; /* of the gradient media */
    size_t n_frame, cap_frame, cap_gradient;
    const struct rmap_receivers *receivers; /* read behind the scene's own detectors, or NULL */
    size_t n_receiver;                      /* the last ones of the scene's detectors */
    bool lenient_field;                     /* the field being read has a part that is `lenient` */
    void *arena;                            /* blocks that live as long as the reader */
};

/* ---- scene_names.c ---- */

const struct rmap_name *rmap_names_find(const struct rmap_names *names, const char *text);
enum rmap_status rmap_names_add(struct rmap_names *names, const char *text, int32_t kind,
                                int32_t index, int32_t line, struct rmap_error *err) RMAP_MUST_USE;
void rmap_reader_add_name(struct rmap_reader *reader, struct rmap_names *names, const char *text,
                          int32_t kind, int32_t index, int32_t line);
void rmap_names_fini(struct rmap_names *names);

/* Stands for a name that is missing or no name; entered nowhere. */
#define RMAP_UNNAMED "\001"

/* Enters an object's, group's, source's or detector's name; complains when it is taken. */
void rmap_reader_add_member(struct rmap_reader *reader, const char *name, enum rmap_member kind,
                            int32_t index, const struct rmap_yaml_node *at);

/* Index of a named thing; -1 after a complaint with the nearest name. */
int32_t rmap_reader_find(struct rmap_reader *reader, const struct rmap_names *names,
                         const char *what, const struct rmap_yaml_node *at, const char *text);

/* ---- the sections ---- */

void rmap_reader_read_units(struct rmap_reader *reader);
void rmap_reader_read_limits(struct rmap_reader *reader);
void rmap_reader_limits(struct rmap_reader *reader, const struct rmap_yaml_node *node);
void rmap_reader_read_channels(struct rmap_reader *reader);
void rmap_reader_read_media(struct rmap_reader *reader);
void rmap_reader_read_surfaces(struct rmap_reader *reader);
void rmap_reader_read_geometries(struct rmap_reader *reader);
void rmap_reader_read_objects(struct rmap_reader *reader);
void rmap_reader_read_sources(struct rmap_reader *reader);
void rmap_reader_read_detectors(struct rmap_reader *reader);
/* The detectors of reader->receivers, with complaints in diagnostics of their own. */
void rmap_reader_read_receivers(struct rmap_reader *reader);
void rmap_reader_read_cameras(struct rmap_reader *reader);
void rmap_reader_read_background(struct rmap_reader *reader);

/* Finds the chosen simulation before anything else is read. */
void rmap_reader_choose_simulation(struct rmap_reader *reader);
/* Reads all of them, and leaves out of a scene without mistakes what is not chosen. */
void rmap_reader_read_simulations(struct rmap_reader *reader);

/* ---- shared between sections ---- */

/* The unit of length that `key` names; NULL when absent or wrong. */
const struct rmap_written_unit *rmap_reader_length_unit(struct rmap_reader *reader,
                                                        const struct rmap_yaml_node *map,
                                                        const char *key);

/* A file that the scene names, relative to the scene file's folder; arena. NULL: no memory. */
char *rmap_reader_path(struct rmap_reader *reader, const char *file);

/* `key` names a medium, or a glass of the built-in list, which then becomes one. *medium_ret is
 * untouched when the key is absent. */
void rmap_reader_medium(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                        const char *key, int32_t *medium_ret);

/* `air`, `vacuum`, or what most objects stand in; else a vacuum is made. */
void rmap_reader_surrounding_medium(struct rmap_reader *reader, int32_t *medium_ret);

/* The glass that `glass` of the mapping names; NULL after a complaint. */
const struct rmap_glass *rmap_reader_glass(struct rmap_reader *reader,
                                           const struct rmap_yaml_node *node);

/* {B: [..], C: [..]}, with C brought to um^2 from the square of unit_um. False after a complaint.
 */
bool rmap_reader_sellmeier(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           double unit_um, struct rmap_sellmeier *sellmeier);

/* A new medium `vacuum` of index 1; there must be none of that name. */
void rmap_reader_vacuum(struct rmap_reader *reader, int32_t *medium_ret);

/* `key`: a surface's name or {front: a, back: b}; untouched when absent. */
void rmap_reader_surface_pair(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                              const char *key, int32_t *front_ret, int32_t *back_ret);
void rmap_reader_builtin_surface(struct rmap_reader *reader, enum rmap_surface_type type,
                                 int32_t *surface_ret);

/* A reflectance-like quantity on the channels: number, {wavelength, value}, {rgb}. value[n]. */
void rmap_reader_quantity(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                          const char *key, enum rmap_need need, const struct rmap_range *range,
                          double *value);

/* Columns of a table over wavelength, by their keys: "wavelength n k", the first of which strictly
 * increases; the others are as long, and the first n_required must be there. Arena memory; columns
 * absent stay NULL. */
void rmap_reader_table(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const char *keys, size_t n_required, const struct rmap_range *range,
                       size_t *n_ret, double **column);

/* A source's `spectrum`, absent: equal. */
void rmap_reader_source_spectrum(struct rmap_reader *reader, const struct rmap_yaml_node *source,
                                 struct rmap_spectrum *spectrum);

/* Channel of a wavelength; -1 after a complaint. */
int32_t rmap_reader_channel(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                            double wavelength_nm);

/* `at`, `rotate`, `scale`, `matrix`: a map from the item's frame to its parent's. */
bool rmap_reader_placement(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                           struct rmap_affine *placement);

/* Unit x, y, z axes of a placement; orthogonal only if it has no shear. */
void rmap_placement_axes(const struct rmap_affine *placement, struct rmap_vec3 axis[3]);
/* The orthonormal frame that keeps the placement's z, origin and handedness. */
struct rmap_affine rmap_placement_rigid(const struct rmap_affine *placement);
/* Unit x and y of a plane whose unit normal is `axis`: x is the projection of the first world
 * axis (X, Y, Z) that is not within 26 degrees of it; y points along the world axis, of the other
 * two, that it is nearest to. Plain planes so have the world's own axes. */
void rmap_placement_plane(struct rmap_vec3 axis, struct rmap_vec3 *x, struct rmap_vec3 *y);

/* A new geometry of the scene; *index_ret its index. The name is copied. */
void rmap_reader_add_shape(struct rmap_reader *reader, const char *name,
                           const struct rmap_shape *shape, int32_t *index_ret);

/* `gradient:` of a medium: how light is traced through it, and the frame of its index. */
void rmap_reader_gradient(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          int32_t medium_index);

/* Once all objects stand: the fields of the gradient media. */
void rmap_reader_make_gradients(struct rmap_reader *reader);

/* Once the scene is finished: mistakes of gradient media that show where they are. */
void rmap_reader_probe_gradients(struct rmap_reader *reader);

/* The same: warns of objects in them that light may pass unseen. */
void rmap_reader_probe_sag(struct rmap_reader *reader);

/* A gradient medium on a side of an object gets its place; 0 for any other. closes: the side is
 * the inside of a closed body, or of an element of a lens. */
struct rmap_object_side {
    int32_t object, medium;
    const struct rmap_affine *to_world; /* frame of the medium's `frame: object` */
    bool closes;
};
void rmap_reader_place_side(struct rmap_reader *reader, const struct rmap_object_side *side,
                            int32_t *gradient_ret);
/* Once all names are known: frames by name, and media that need one. */
void rmap_reader_settle_frames(struct rmap_reader *reader);
/* The place of the medium in which a source or camera stands, as far as the scene file says it
 * (`within`); 0: not, or uniform. */
void rmap_reader_place_within(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                              int32_t medium, int32_t *gradient_ret);

#endif
