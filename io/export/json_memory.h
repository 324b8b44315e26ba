/* SPDX-License-Identifier: MIT
 *
 * Memory of JSON documents. They are made by many small calls of jansson, and one that cannot have
 * its memory leaves its part out: a document is only good if none failed.
 */
#ifndef RMAP_JSON_MEMORY_H
#define RMAP_JSON_MEMORY_H

#include <stdbool.h>

/* From now on jansson's memory is had through base/alloc.h and its failures are seen. Once in a
 * process, before any document is made; never in a process that does not want it. */
void rmap_json_memory_watch(void);

/* Whether memory for JSON could not be had since then: no document since is to be trusted. */
bool rmap_json_memory_failed(void);

#endif
