/* SPDX-License-Identifier: MIT
 *
 * The scene file as a JSON Schema, made of the tables by which it is read: editors complete and
 * check keys by it.
 */
#ifndef RMAP_SCENE_SCHEMA_H
#define RMAP_SCENE_SCHEMA_H

#include <jansson.h>

/* Draft 7. NULL without memory. */
json_t *rmap_scene_schema(void);

#endif
