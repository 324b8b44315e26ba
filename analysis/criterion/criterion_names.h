/* SPDX-License-Identifier: MIT
 *
 * Names of a scene, as a criterion resolves them.
 */
#ifndef RMAP_CRITERION_NAMES_H
#define RMAP_CRITERION_NAMES_H

#include "analysis/criterion/criterion_lex.h"
#include "analysis/criterion/criterion_tree.h"

enum rmap_name_kind {
    RMAP_NAME_OBJECT,
    RMAP_NAME_GROUP,
    RMAP_NAME_SOURCE,
    RMAP_NAME_DETECTOR,
    RMAP_NAME_SURFACE,
    RMAP_NAME_MEDIUM,
    RMAP_NAME_KIND_COUNT
};

/* What a place in a criterion wants. A group stands for its members. */
enum rmap_name_wanted {
    RMAP_WANTED_OBJECT,
    RMAP_WANTED_SOURCE,
    RMAP_WANTED_DETECTOR,
    RMAP_WANTED_SURFACE,
    RMAP_WANTED_MEDIUM,
    RMAP_WANTED_PLACE,   /* an object or a medium: for messages alone */
    RMAP_WANTED_ANYWHERE /* or a detector: also */
};

struct rmap_name {
    const char *text; /* borrowed from the scene */
    enum rmap_name_kind kind;
    int32_t index;
};

struct rmap_names {
    const struct rmap_scene *scene;
    struct rmap_name *name; /* [n], sorted by text, then kind, then index */
    size_t n;
};

enum rmap_status rmap_names_create(const struct rmap_scene *scene, struct rmap_names **names_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;
void rmap_names_destroy(struct rmap_names *names);

/* What a name of this kind is ("an object"), and the test that asks for it ("hit"). */
const char *rmap_name_kind_phrase(enum rmap_name_kind kind);
const char *rmap_name_kind_usage(enum rmap_name_kind kind);

/* First name that equals the text, or NULL. */
const struct rmap_name *rmap_names_lookup(const struct rmap_names *names, const char *text);

/* Plain text of a WORD or QUOTED token, quotes removed. */
void rmap_token_name(const char *text, const struct rmap_token *token,
                     char name[RMAP_TOKEN_NAME_NBYTES + 1]);

/* Marks what the name or pattern stands for in the zeroed mark[], one per index of the wanted
 * kind; *found_ret says whether any name fitted (it may still have no members). */
void rmap_names_mark(const struct rmap_names *names, const char *name, bool wildcards,
                     enum rmap_name_wanted wanted, uint8_t *mark, bool *found_ret);

/* How many indices the wanted kind has. */
size_t rmap_names_count(const struct rmap_names *names, enum rmap_name_wanted wanted);

/* Writes the message for a name of which there is none of the wanted kind, with a hint. */
enum rmap_status rmap_names_fail(const struct rmap_names *names, const char *text,
                                 const struct rmap_token *token, enum rmap_name_wanted wanted,
                                 struct rmap_error *err);

#endif
