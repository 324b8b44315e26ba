/* SPDX-License-Identifier: MIT
 *
 * Which rays the tracer makes. Raised whenever some (scene, seed, id) gives another ray than
 * before: a map holds the rays of one revision. docs/map.md says what each one changed; the test
 * cli.test_tracer_revision has digests of rays of each.
 */
#ifndef RMAP_TRACER_REVISION_H
#define RMAP_TRACER_REVISION_H

#define RMAP_TRACER_REVISION 3 /* maps that do not say are of 1: older than the number */

#endif
