/* SPDX-License-Identifier: MIT
 *
 * Guth's position index: how much less a source disturbs that is not looked at (CIE 117:1995, table
 * 4.1), linear between its values.
 */
#ifndef RMAP_POSITION_INDEX_H
#define RMAP_POSITION_INDEX_H

/* Of a source so far aside and above, over its distance along the line of sight, both >= 0; 0: it
 * lies beyond the table, and does not count. */
double rmap_position_index(double aside, double above);

#endif
