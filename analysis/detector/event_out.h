/* SPDX-License-Identifier: MIT
 *
 * Readings of events for people, as CSV and as JSON.
 */
#ifndef RMAP_EVENT_OUT_H
#define RMAP_EVENT_OUT_H

#include "analysis/detector/event_table.h"

enum rmap_status rmap_event_print(const struct rmap_event_table *table,
                                  const struct rmap_event_summary *summary, FILE *out,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* New references; NULL when memory is short. rows: with a row for each event. */
json_t *rmap_event_json(struct rmap_event_table *table, const struct rmap_event_summary *summary,
                        bool rows);

/* Lines of "# key: value", then event,rays,fired,coincident and for each detector its values:
 * "sum(right)". */
void rmap_event_csv(struct rmap_event_table *table, FILE *out);

#endif
