/* SPDX-License-Identifier: MIT
 *
 * A session's map as it is on disk by now: with what a running trace has committed since.
 */
#ifndef RMAP_SESSION_REFRESH_H
#define RMAP_SESSION_REFRESH_H

#include "mpi/session/session_answer.h"

/* Collective. Opens the map once more in the place of the session's, which forgets what it kept of
 * it; rank 0 tells how many rays there are now. RMAP_INPUT: it cannot be opened, and the session
 * has the map as it was. */
enum rmap_status rmap_session_refresh(struct rmap_session *session,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
