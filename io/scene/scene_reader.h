/* SPDX-License-Identifier: MIT
 *
 * What the parts of the scene reader (scene_*.c, one per section of the file) share: the reader's
 * state, complaints that say where and what to do, names; typed values are in scene_values.h.
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

#include "base/count.h"
#include "base/pool.h"
#include "io/file/diagnostics.h"
#include "io/file/text_file.h"
#include "io/mesh/bundle.h"
#include "io/scene/receivers.h"
#include "io/scene/scene_values.h"
#include "io/scene/yaml_tree.h"
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
    struct rmap_shape shape;             /* CONIC */
    double z;                            /* of its vertex */
    double rim_z;                        /* z + sag(aperture) */
    int32_t medium;                      /* after it */
    int32_t surface_front, surface_back; /* -1: those of the lens */
    bool stop;
    int32_t geometry, edge_geometry[4], stop_geometry; /* made on first use; -1: not yet */
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
    bool closed; /* a tube with caps, each -1 where there is none */
    int32_t bottom, top;
    double length;
};

/* Some faces of a mesh geometry as a geometry of their own. */
struct rmap_mesh_part {
    int32_t of, geometry;
    const uint8_t *face; /* [n_face] of the whole */
};

/* A rule of `attributes`, and how many objects or faces it fits. */
struct rmap_attribute_rule {
    const struct rmap_yaml_node *node;
    size_t n_fit;
    bool of_faces;
    unsigned used;    /* a bit for each key of its `set` that something took */
    int omitted_line; /* of an earlier rule that left out what it would fit; 0: none did */
    char body[64];    /* that of what it would fit; or whose faces it was asked for */
    size_t n_face;    /* of the body; 0: none was asked */
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

/* A sky or a sun, until it is known what it lights. */
enum rmap_sky_measure {
    RMAP_SKY_FLUX,
    RMAP_SKY_IRRADIANCE /* of what faces its pole */,
    RMAP_SKY_RADIANCE /* of what is 1 now */
};
enum rmap_sky_unit { RMAP_SKY_ANY, RMAP_SKY_CD, RMAP_SKY_W };
struct rmap_sky_plan {
    int32_t source;
    const struct rmap_yaml_node *node;
    enum rmap_sky_measure measure;
    double amount;
    enum rmap_sky_unit unit; /* of a picture */
};

/* A source that is written in a group. */
struct rmap_placed_source {
    const struct rmap_yaml_node *node;
    const char *name; /* whole */
    int32_t parent;
    struct rmap_affine to_world;
};

struct rmap_reader {
    struct rmap_bundle *bundle;
    const struct rmap_yaml_node *root;
    struct rmap_yaml_node *own; /* the same, which changes while it is read; NULL: it is borrowed */
    struct rmap_scene *scene;
    struct rmap_diagnostics *diagnostics;
    struct rmap_error *err;
    enum rmap_status status;                 /* RMAP_SYSTEM once memory ran short; *err says it */
    struct rmap_error failure;               /* of the library call in hand */
    const struct rmap_yaml_node *simulation; /* the one chosen, or NULL */
    size_t cap_medium, cap_film, cap_scatter, cap_surface, cap_geometry, cap_object, cap_group,
        cap_source, cap_detector, cap_camera;
    struct rmap_names media, films, surfaces, geometries, members;
    struct rmap_names meshes, grids; /* of the bundle, as it was given */
    struct rmap_geometry_entry *entry;
    size_t n_entry, cap_entry;
    struct rmap_mesh_part *mesh_part;
    size_t n_mesh_part, cap_mesh_part;
    struct rmap_attribute_rule *rule;
    size_t n_rule, cap_rule;
    bool has_bad_rule; /* what comes after it would be mistakes of its making */
    struct rmap_placed_source *placed;
    size_t n_placed, cap_placed;
    struct rmap_sky_plan *sky;
    size_t n_sky, cap_sky;
    struct rmap_medium_frame *frame; /* of the gradient media */
    size_t n_frame, cap_frame, cap_gradient;
    const struct rmap_receivers *receivers; /* read behind the scene's own detectors, or NULL */
    size_t n_receiver;                      /* the last ones of the scene's detectors */
    double beside;      /* the scene's wavelengths are so much beside its own, a share of them */
    bool lenient_field; /* the field being read has a part that is `lenient` */
    struct rmap_pool arena; /* what lives as long as the reader */
};

void rmap_reader_error(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                       const char *format, ...) RMAP_PRINTF(3, 4);
void rmap_reader_warn(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                      const char *format, ...) RMAP_PRINTF(3, 4);

/* "what 'word' (did you mean 'x'?)" + remedy */
void rmap_reader_unknown(struct rmap_reader *reader, int line, int column, const char *what,
                         const char *word, const char *const *known, size_t n_known);

/* The words of a text that blanks part, each once. */
struct rmap_words {
    size_t n;
    const char *word[32];
    char text[400];
};
void rmap_words_split(const char *text, struct rmap_words *words);
/* Whether one of them is that; a single blank parts two. */
bool rmap_words_have(const char *text, const char *word);
/* "a, b, c", as far as there is room. */
void rmap_words_list(const char *const *word, size_t n_word, char *text, size_t nbytes);

/* False, with a complaint, when node is no mapping. Complains about keys that are not known: words,
 * or an array of them. */
bool rmap_reader_check_map(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           const char *what, const char *keys);
bool rmap_reader_check_keys(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const char *what, const char *const *known, size_t n_known);
bool rmap_reader_check_list(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const char *what);

/* The text (bytes, of kinds without a format) of a file that the scene names under `key`, which
 * goes with the scene's bundle; NULL after a complaint. Borrowed. */
const char *rmap_reader_file(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                             const char *key, const struct rmap_text_kind *kind,
                             size_t *nbytes_ret);

/* The scene cannot be read, for what reader->failure says; for want of memory. */
void rmap_reader_fail(struct rmap_reader *reader, enum rmap_status status);
void rmap_reader_no_memory(struct rmap_reader *reader);

/* Hands a library's outcome on, whose text is in reader->failure: RMAP_INPUT becomes a complaint at
 * node. */
void rmap_reader_made(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      enum rmap_status status);

/* Zeroed memory that lives as long as the reader; NULL when short, which the reader then knows. */
void *rmap_reader_alloc(struct rmap_reader *reader, size_t n, size_t size);
void rmap_reader_release(struct rmap_reader *reader); /* all of it */
/* A copy that the scene owns; so NULL. */
char *rmap_reader_strdup(struct rmap_reader *reader, const char *text);

/* A zeroed new element at the end of an array, or NULL. */
#define RMAP_READER_NEW(reader, array, n, cap)                                                     \
    (rmap_reader_room((reader), &(array), &(cap), (n), sizeof *(array)) ? &(array)[(n)++] : NULL)
bool rmap_reader_room(struct rmap_reader *reader, void *array_address, size_t *cap, size_t n,
                      size_t size);

const struct rmap_name *rmap_names_find(const struct rmap_names *names, const char *text);
enum rmap_status rmap_names_add(struct rmap_names *names, const char *text, int32_t kind,
                                int32_t index, int32_t line, struct rmap_error *err) RMAP_MUST_USE;
void rmap_reader_add_name(struct rmap_reader *reader, struct rmap_names *names, const char *text,
                          int32_t kind, int32_t index, int32_t line);
void rmap_names_fini(struct rmap_names *names);

/* The items of a section {name: one, ...} whose name is good and not among `names`; `read` adds it
 * there. */
void rmap_reader_each_named(struct rmap_reader *reader, const char *section, const char *one,
                            const struct rmap_names *names,
                            void (*read)(struct rmap_reader *reader,
                                         const struct rmap_yaml_item *item));

/* Stands for a name that is missing or no name; entered nowhere. */
#define RMAP_UNNAMED "\001"

/* Enters an object's, group's, source's or detector's name; complains when it is taken. */
void rmap_reader_add_member(struct rmap_reader *reader, const char *name, enum rmap_member kind,
                            int32_t index, const struct rmap_yaml_node *at);

/* Index of a named thing; -1 after a complaint with the nearest name. */
int32_t rmap_reader_find(struct rmap_reader *reader, const struct rmap_names *names,
                         const char *what, const struct rmap_yaml_node *at, const char *text);

/* The object or group of that name; NULL after a complaint, which calls an unknown name `what`. */
const struct rmap_name *rmap_reader_find_body(struct rmap_reader *reader, const char *what,
                                              const struct rmap_yaml_node *at, const char *text);

/* What takes part: [n_object], [n_source], [n_detector]. */
struct rmap_keep {
    bool *object, *source, *detector;
};
/* Leaves the rest out, with emptied groups, unused geometries, and detectors that lay on them. */
void rmap_reader_reduce(struct rmap_reader *reader, const struct rmap_keep *keep);

/* ---- shared between sections ---- */

/* `gradient:` of a medium: how light is traced through it, and the frame of its index. */
void rmap_reader_gradient(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          int32_t medium_index);

/* Once all objects stand: the fields of the gradient media. */
void rmap_reader_make_gradients(struct rmap_reader *reader);

/* A gradient medium on a side of an object gets its place; 0 for any other. closes: the side is
 * the inside of a closed body, or of an element of a lens. */
struct rmap_object_side {
    int32_t object, medium;
    const struct rmap_affine *to_world; /* frame of the medium's `frame: object` */
    bool closes;
};
/* Objects as they are made. */
struct rmap_object_plan {
    const char *name;
    const struct rmap_yaml_node *node;
    bool derived; /* part of a lens: its id comes from its name, not from the node */
    int32_t parent, geometry;
    struct rmap_affine to_world;
    const struct rmap_affine *placement; /* in the group; NULL: as the group stands */
    int32_t surface_front, surface_back, medium_front, medium_back;
    bool in_lens; /* around which is: */
    int32_t outside;
    /* Of an element of a lens: the frame of a gradient medium on that side; NULL: to_world. */
    const struct rmap_affine *element_front, *element_back;
};

#endif
