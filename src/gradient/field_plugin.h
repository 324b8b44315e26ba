/* SPDX-License-Identifier: MIT
 *
 * Fields from shared objects (gradient/raymap_field.h).
 */
#ifndef RMAP_FIELD_PLUGIN_H
#define RMAP_FIELD_PLUGIN_H

#include "gradient/field.h"
#include "gradient/raymap_field.h"

/* Loads the shared object and makes its field. RMAP_INPUT: it cannot be loaded, is no plug-in or
 * one of another ABI, or refuses the setup; err says which, and what to do. */
enum rmap_status rmap_field_plugin(struct rmap_field **field_ret, const char *path,
                                   const struct raymap_field_setup *setup,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Stands for a field that cannot be had, as in a map whose plug-in must not be loaded: no value
 * anywhere. n_channel: what is reported. */
enum rmap_status rmap_field_absent(struct rmap_field **field_ret, int n_channel,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
