/* SPDX-License-Identifier: MIT
 *
 * Zemax's multi-configuration operands, which stand behind MNUM as `THIC surface configuration
 * value`.
 */
#ifndef RMAP_LENS_ZMX_CONFIG_H
#define RMAP_LENS_ZMX_CONFIG_H

#include "io/lensfile/prescription.h"

struct rmap_zmx_change {
    char key[5], text[64]; /* the value as a word */
    size_t index, line;
    double value;
};

/* Its thickness makes the sum of those from another surface on, or of those two alone. */
struct rmap_zmx_sum {
    size_t surface, from;
    bool of_two;
    double sum;
};

struct rmap_zmx_changes {
    struct rmap_zmx_sum total[64];
    size_t n_total;
    char seen[32][5]; /* words that were told as not understood */
    size_t n_seen;
    struct rmap_zmx_change *change; /* [n] of the configuration that was asked for */
    size_t n, cap;
};

/* Reads them, and how many configurations there are, from a text that stays as it is. */
enum rmap_status rmap_zmx_read_changes(const char *text, struct rmap_prescription *lens,
                                       struct rmap_zmx_changes *changes,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_zmx_changes_fini(struct rmap_zmx_changes *changes);

void rmap_zmx_add_sum(struct rmap_zmx_changes *changes, struct rmap_zmx_sum sum);

/* Applies those of a surface that is read, by its number; and those of the whole, at the end. */
void rmap_zmx_change_surface(const struct rmap_zmx_changes *changes, struct rmap_prescription *lens,
                             struct rmap_lens_surface *surface);
void rmap_zmx_change_lens(const struct rmap_zmx_changes *changes, struct rmap_prescription *lens);

#endif
