/* SPDX-License-Identifier: MIT
 *
 * A browser, started with an address.
 */
#ifndef RMAP_SERVE_BROWSER_H
#define RMAP_SERVE_BROWSER_H

/* $BROWSER, or xdg-open; where neither can be started the address is there to be copied. */
void rmap_serve_browser(const char *url);

#endif
