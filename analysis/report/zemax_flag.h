/* SPDX-License-Identifier: MIT
 *
 * A filter string being translated, for the files that do it.
 */
#ifndef RMAP_ZEMAX_FLAG_H
#define RMAP_ZEMAX_FLAG_H

#include <stdbool.h>

#include "analysis/criterion/criterion_lex.h"
#include "scene/scene.h"

enum { RMAP_ZEMAX_ANY = 0 };

struct rmap_zemax_translation {
    const struct rmap_scene *scene;
    const char *text;
    size_t at;
    int depth;
    struct rmap_error *err;
};

/* A text that grows. */
struct rmap_zemax_draft {
    char *text;
    size_t nbytes, cap;
};

#define RMAP_ZEMAX_FAIL(t, from, to, ...)                                                          \
    rmap_criterion_fail((t)->text, from, to, (t)->err, __VA_ARGS__)

/* A flag's number: of an object, a source, a wavelength; RMAP_ZEMAX_ANY (0) where that is allowed.
 */
struct rmap_zemax_flag {
    char letter;
    size_t begin, end;
    bool has_number;
    size_t number;
};

/* Appends a text; each of some texts in turn, up to a NULL. */
enum rmap_status rmap_zemax_put(struct rmap_zemax_translation *t, struct rmap_zemax_draft *draft,
                                const char *text) RMAP_MUST_USE;
enum rmap_status rmap_zemax_put_all(struct rmap_zemax_translation *t,
                                    struct rmap_zemax_draft *draft, ...) RMAP_MUST_USE;

/* That the flag has a number in [1, n]. */
enum rmap_status rmap_zemax_check_number(const struct rmap_zemax_translation *t,
                                         const struct rmap_zemax_flag *flag, const char *noun,
                                         size_t n) RMAP_MUST_USE;

/* `hit(NAME, EVENT)` for an object, or for 0 any of those. */
enum rmap_status rmap_zemax_put_hit(struct rmap_zemax_translation *t,
                                    const struct rmap_zemax_flag *flag, const char *event,
                                    struct rmap_zemax_draft *draft) RMAP_MUST_USE;

/* What a flag of a letter and a number says. */
enum rmap_status rmap_zemax_put_flag(struct rmap_zemax_translation *t,
                                     const struct rmap_zemax_flag *flag,
                                     struct rmap_zemax_draft *draft) RMAP_MUST_USE;

/* RMAP_INPUT: why it cannot be said. */
enum rmap_status rmap_zemax_fail_unsupported(const struct rmap_zemax_translation *t,
                                             const struct rmap_zemax_flag *flag);

#endif
