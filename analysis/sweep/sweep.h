/* SPDX-License-Identifier: MIT
 *
 * A sweep: a scene with other values of some of its keys, variant by variant, and what is asked of
 * each. Variant 0 is the scene as it is, the nominal one.
 *
 * Every variant has the same rays (seed and ids), so that what differs between two of them is the
 * scene's doing more than chance's.
 */
#ifndef RMAP_SWEEP_H
#define RMAP_SWEEP_H

#include "io/file/diagnostics.h"
#include "io/mesh/bundle.h"
#include "io/scene/yaml_tree.h"

enum rmap_sweep_mode {
    RMAP_SWEEP_GRID,  /* every value with every other, the last parameter fastest */
    RMAP_SWEEP_LIST,  /* the first of each, the second of each ... */
    RMAP_SWEEP_RANDOM /* drawn */
};
#define RMAP_SWEEP_MODES "grid list random"

enum rmap_sweep_spread { RMAP_SWEEP_VALUES, RMAP_SWEEP_NORMAL, RMAP_SWEEP_UNIFORM };

enum rmap_sweep_change {
    RMAP_SWEEP_REPLACE, /* the value stands in the place of the scene's */
    RMAP_SWEEP_PLUS,    /* is added to it */
    RMAP_SWEEP_TIMES    /* is its factor */
};

/* What a scene has at a key. */
struct rmap_sweep_nominal {
    bool is_number;
    double value;
    const char *unit; /* written behind it, "" mostly; lives as long as `sweep->scene` */
    bool in_unit;     /* was brought to the parameter's unit, in which its values are */
    const struct rmap_yaml_node *node; /* of `sweep->scene`; NULL: the key is new */
};

struct rmap_sweep_parameter {
    const char *name, *unit;            /* unit: for people, "" where none is said */
    const char **key;                   /* [n_key] as --set names them; they move together */
    struct rmap_sweep_nominal *nominal; /* [n_key] */
    size_t n_key;
    const struct rmap_yaml_node *node; /* for complaints */
    enum rmap_sweep_change change;
    enum rmap_sweep_spread spread;
    bool of_simulation;      /* key `simulation`: the values are names of the scene's simulations */
    size_t n_value;          /* of VALUES */
    double *value;           /* [n_value]; NaN where it is no number, and: */
    const char **text;       /* [n_value] as it is written */
    double mean, sigma, cut; /* NORMAL; cut: at so many sigmas, 0: nowhere */
    double from, to;         /* UNIFORM */
};

/* What is asked of a variant: rays that match, or light on a detector, or a statistic of a number.
 */
enum rmap_sweep_kind {
    RMAP_SWEEP_FLUX, /* of the rays that match */
    RMAP_SWEEP_RAYS, /* how many */
    RMAP_SWEEP_DETECTOR,
    RMAP_SWEEP_STATISTIC
};
#define RMAP_SWEEP_OF_DETECTOR                                                                     \
    "flux mean peak least greatest u0 ud registrations centroid_x centroid_y rms_radius "          \
    "radius_50 "                                                                                   \
    "radius_80 radius_90"
enum rmap_sweep_of_detector {
    RMAP_SWEEP_OF_FLUX,
    RMAP_SWEEP_OF_MEAN,
    RMAP_SWEEP_OF_PEAK,
    RMAP_SWEEP_OF_LEAST,
    RMAP_SWEEP_OF_GREATEST,
    RMAP_SWEEP_OF_U0,
    RMAP_SWEEP_OF_UD,
    RMAP_SWEEP_OF_REGISTRATIONS,
    RMAP_SWEEP_OF_CENTROID_X, /* from here on of its spot */
    RMAP_SWEEP_OF_CENTROID_Y,
    RMAP_SWEEP_OF_RMS_RADIUS,
    RMAP_SWEEP_OF_RADIUS_50,
    RMAP_SWEEP_OF_RADIUS_80,
    RMAP_SWEEP_OF_RADIUS_90
};
#define RMAP_SWEEP_OF_STATISTIC "mean deviation skewness kurtosis flux"
enum rmap_sweep_of_statistic {
    RMAP_SWEEP_THE_MEAN,
    RMAP_SWEEP_THE_DEVIATION,
    RMAP_SWEEP_THE_SKEWNESS,
    RMAP_SWEEP_THE_KURTOSIS,
    RMAP_SWEEP_THE_FLUX
};

struct rmap_sweep_answer {
    const char *name;
    int line; /* of the file */
    enum rmap_sweep_kind kind;
    const char *where;    /* a criterion; NULL: all rays */
    const char *detector; /* of DETECTOR, and of a statistic of registrations; or NULL */
    const char *number;   /* STATISTIC: of what */
    const char *unit;     /* asked for; NULL: the usual one */
    int of;
};

/* "spot < 0.02" */
struct rmap_sweep_require {
    size_t answer;
    const char *text;
    bool below, or_equal;
    double limit;
};

struct rmap_sweep {
    const char *path;             /* for messages */
    char *text;                   /* of the file; owned */
    struct rmap_yaml_node *root;  /* owns the texts below */
    struct rmap_yaml_node *scene; /* the scene's tree, once the nominal values have been found */
    struct rmap_pool arena;       /* the arrays below */
    const char *scene_path;       /* as the file has it, beside which it is looked for */
    const char *simulation;       /* or NULL */
    uint64_t n_ray, seed;         /* n_ray 0: the simulation's */
    bool has_seed, keeps_maps;
    enum rmap_sweep_mode mode;
    uint64_t n_sample, sample_seed;
    struct rmap_sweep_parameter *parameter; /* [n_parameter] */
    struct rmap_sweep_answer *answer;       /* [n_answer] */
    struct rmap_sweep_require *require;     /* [n_require] */
    size_t n_parameter, n_answer, n_require;
    uint64_t n_variant; /* the nominal one included */
};

#define RMAP_SWEEP_VARIANTS_MAX 1000000

/* text: [nbytes], with a 0 behind it. Every mistake goes to the diagnostics; RMAP_INPUT when there
 * is one. rmap_sweep_destroy. */
enum rmap_status rmap_sweep_read(const char *path, const char *text, size_t nbytes,
                                 struct rmap_diagnostics *diagnostics,
                                 struct rmap_sweep **sweep_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;
void rmap_sweep_destroy(struct rmap_sweep *sweep);

/* What the scene has at the parameters' keys. bundle: of the scene, which has been read.
 * RMAP_INPUT with the mistakes in the diagnostics (of the sweep's file). */
enum rmap_status rmap_sweep_find_nominal(struct rmap_sweep *sweep, const struct rmap_bundle *bundle,
                                         struct rmap_diagnostics *diagnostics,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Value of a parameter in a variant, as the parameter has it: of the nominal one 0 of PLUS, 1 of
 * TIMES, else the scene's, NaN where that is no number. *text_ret: NULL, or what stands for a value
 * that is none. */
double rmap_sweep_value(const struct rmap_sweep *sweep, uint64_t variant, size_t parameter,
                        const char **text_ret);

/* Name of the simulation that a variant is of; NULL: none is said. */
const char *rmap_sweep_simulation(const struct rmap_sweep *sweep, uint64_t variant);

/* "key=value" of --set, in order, n of them; none of the nominal variant. *set_ret:
 * rmap_sweep_settings_free. */
enum rmap_status rmap_sweep_settings(const struct rmap_sweep *sweep, uint64_t variant,
                                     char ***set_ret, size_t *n_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_sweep_settings_free(char **set, size_t n);

/* Whether variants may share the bundle of the nominal scene: no key of theirs says how a mesh, a
 * field or a file of rays is read. */
bool rmap_sweep_shares_files(const struct rmap_sweep *sweep, const struct rmap_bundle *bundle);

#endif
