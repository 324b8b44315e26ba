/* SPDX-License-Identifier: MIT
 *
 * Being asked to stop: SIGTERM, SIGINT or SIGUSR1 (what a batch system or mpirun sends).
 */
#ifndef RMAP_INTERRUPT_H
#define RMAP_INTERRUPT_H

#include <stdbool.h>

#include "base/status.h"

/* From now on the first of these signals is remembered; a second one of its kind kills, as ever. */
void rmap_interrupt_watch(void);

/* The same for SIGINT alone, as often as it comes: at a prompt it clears the line, and stops the
 * question that is being answered. Waiting for input ends with EINTR. */
void rmap_interrupt_watch_questions(void);
bool rmap_interrupt_stops_question(void);
void rmap_interrupt_forget(void);        /* for the next question */
void rmap_interrupt_stop_question(void); /* as SIGINT would; of any thread */

/* Number of the signal that came, or 0. */
int rmap_interrupt_caught(void);

/* RMAP_STOPPED where one came. */
enum rmap_status rmap_interrupt_stopped(struct rmap_error *err) RMAP_MUST_USE;

/* "SIGTERM" */
const char *rmap_interrupt_name(int number);

#endif
