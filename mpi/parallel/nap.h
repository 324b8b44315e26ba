/* SPDX-License-Identifier: MIT
 *
 * For who waits for others: the cores are left to those that work.
 */
#ifndef RMAP_NAP_H
#define RMAP_NAP_H

void rmap_nap(void); /* a millisecond */

#endif
