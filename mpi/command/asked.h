/* SPDX-License-Identifier: MIT
 *
 * The criteria that a command is given: texts, the names they use (--criteria FILE), and a filter
 * string of Zemax (--zemax).
 */
#ifndef RMAP_ASKED_H
#define RMAP_ASKED_H

#include "analysis/criterion/criterion_file.h"
#include "analysis/query/which.h"
#include "io/map/map_reader.h"
#include "mpi/command/command.h"

/* Entries of an option table. */
#define RMAP_ASKED_OPTIONS                                                                         \
    {"criteria", 0, "FILE", "named criteria: let NAME = CRITERION ..., used as @NAME"},            \
    {                                                                                              \
        "zemax", 0, "FILTER", "a filter string of Zemax, such as 'H3 & R5 & !G', as a criterion"   \
    }

#define RMAP_ASKED_WHICH_OPTION                                                                    \
    {                                                                                              \
        "which", 0, "W",                                                                           \
            "of the registrations those for which W holds, as 'ghost_order == 2' or "              \
            "'rect(-1, -1, 1, 1) where angle < 10' (default: as the criterion says)"               \
    }

struct rmap_asked {
    size_t n;                       /* criteria: the texts, then the filter; or the file's */
    struct rmap_criteria *criteria; /* or NULL */
    const char *zemax;              /* or NULL; borrowed */
    const char *const *text;        /* [n_text], borrowed */
    size_t n_text;
    bool whole_file;
    bool told_time; /* that `time` is the phase path's here */
};

/* Collective. Rank 0 reads the file; all ranks get what it says. RMAP_INPUT with the file's line
 * and column. rmap_asked_fini whatever happened. */
enum rmap_status rmap_asked_load(const struct rmap_context *context,
                                 const struct rmap_arguments *given, const char *const *text,
                                 size_t n_text, struct rmap_asked *asked,
                                 struct rmap_error *err) RMAP_MUST_USE;
void rmap_asked_fini(struct rmap_asked *asked);

/* The same for a command that takes one criterion as --where, or --zemax, or none: n is 0 or 1.
 * where: borrowed. RMAP_USAGE when both are given. */
enum rmap_status rmap_asked_load_where(const struct rmap_context *context,
                                       const struct rmap_arguments *given, const char *const *where,
                                       struct rmap_asked *asked,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Where nothing is asked, asks for every definition of the file, in its order. */
void rmap_asked_take_file(struct rmap_asked *asked);

/* Criterion `index` in [0, n). Rank 0 prints the translation of a filter to stderr. */
enum rmap_status rmap_asked_compile(const struct rmap_context *context, struct rmap_asked *asked,
                                    size_t index, const struct rmap_scene *scene,
                                    struct rmap_criterion **criterion_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Rank 0 says once what `time` is in maps without times, where it is asked for (`of`). */
void rmap_asked_tell_time(const struct rmap_context *context, struct rmap_asked *asked, bool of);

/* Rank 0 says that x and y of some detectors are lengths and of others angles, where they are mixed
 * (`of`) in the text. */
void rmap_asked_tell_mixed(const struct rmap_context *context, const struct rmap_scene *scene,
                           const char *text, bool of);

/* Rank 0 says of a map of rays that a query picked that all registrations of those rays count,
 * where they do. */
void rmap_asked_tell_picked(const struct rmap_context *context, const struct rmap_map *map,
                            const struct rmap_which *which, const char *detector);

/* The registrations on these detectors that count: of --which, else as the criterion (NULL: all
 * rays) has it. Rank 0 prints a remark where a test chooses rays alone. which_ret:
 * rmap_which_destroy.
 */
enum rmap_status
rmap_asked_which(const struct rmap_context *context, const struct rmap_arguments *given,
                 const struct rmap_asked *asked, const struct rmap_scene *scene,
                 const struct rmap_index_set *detector, const struct rmap_criterion *criterion,
                 struct rmap_which **which_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
