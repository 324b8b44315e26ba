/* SPDX-License-Identifier: MIT
 *
 * A clock for how long things take; no ray knows of it.
 */
#ifndef RMAP_CLOCK_H
#define RMAP_CLOCK_H

double rmap_clock_seconds(void); /* monotonic */

#endif
