/* SPDX-License-Identifier: MIT
 *
 * Standard output and error as a terminal may be shown them: whatever the program prints goes
 * through base/visible_text.h, so that no name steers the terminal. Results that go to files hold
 * names as they are.
 */
#ifndef RMAP_TERMINAL_H
#define RMAP_TERMINAL_H

/* Once, before anything is printed. Where memory is short, or the C library is another one, the
 * streams stay as they are. */
void rmap_terminal_guard(void);

#endif
