/* SPDX-License-Identifier: MIT
 *
 * Being asked to stop: SIGTERM, SIGINT or SIGUSR1 (what a batch system or mpirun sends).
 */
#ifndef RMAP_INTERRUPT_H
#define RMAP_INTERRUPT_H

/* From now on the first of these signals is remembered; a second one of its kind kills, as ever. */
void rmap_interrupt_watch(void);

/* Number of the signal that came, or 0. */
int rmap_interrupt_caught(void);

/* "SIGTERM" */
const char *rmap_interrupt_name(int number);

#endif
