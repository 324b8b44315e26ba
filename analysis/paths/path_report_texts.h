/* SPDX-License-Identifier: MIT
 *
 * Sequences and criteria of classes of paths.
 */
#ifndef RMAP_PATH_REPORT_TEXTS_H
#define RMAP_PATH_REPORT_TEXTS_H

#include "analysis/paths/path_report.h"

/* From the first ray of each row, which is read again. */
enum rmap_status rmap_path_report_add_texts(struct rmap_path_report *report,
                                            struct rmap_error *err) RMAP_MUST_USE;

#endif
