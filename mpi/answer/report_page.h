/* SPDX-License-Identifier: MIT
 *
 * raymap report MAP --html: a page about a whole map.
 */
#ifndef RMAP_REPORT_PAGE_H
#define RMAP_REPORT_PAGE_H

#include "mpi/command/command.h"

/* Collective. The command. */
enum rmap_status rmap_report_page(const struct rmap_context *context,
                                  const struct rmap_arguments *given,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif
