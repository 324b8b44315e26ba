/* SPDX-License-Identifier: MIT
 *
 * Files put into the program at build time (cmake/PageAssets.cmake): the page's own from
 * analysis/page/, and the libraries. Texts that end with a zero byte.
 */
#ifndef RMAP_PAGE_ASSET_H
#define RMAP_PAGE_ASSET_H

/* The page of `draw -o x.html`. */
extern const char rmap_page_asset_html[];    /* with <!--raymap:NAME--> where parts go */
extern const char rmap_page_asset_style[];   /* CSS */
extern const char rmap_page_asset_library[]; /* licence, three.js, OrbitControls */
extern const char rmap_page_asset_script[];  /* the page's scripts, one behind the other */

/* The workbench, which has the same scripts and more, CodeMirror and d3 beside three.js. */
extern const char rmap_workbench_asset_html[];
extern const char rmap_workbench_asset_style[];
extern const char rmap_workbench_asset_library[];
extern const char rmap_workbench_asset_script[];

#endif
