/* SPDX-License-Identifier: MIT
 *
 * Short names for histories written down by hand in the scene of criterion_scene.h: events by their
 * letters, objects, media and detectors by their indices.
 */
#ifndef RMAP_TEST_CRITERION_LETTERS_H
#define RMAP_TEST_CRITERION_LETTERS_H

#include "portion/event.h"

enum {
    R = RMAP_EVENT_REFLECT_SPECULAR,
    D = RMAP_EVENT_REFLECT_DIFFUSE,
    T = RMAP_EVENT_TRANSMIT_SPECULAR,
    d = RMAP_EVENT_TRANSMIT_DIFFUSE,
    I = RMAP_EVENT_TOTAL_REFLECTION,
    A = RMAP_EVENT_ABSORB,
    S = RMAP_EVENT_SCATTER_VOLUME,
    F = RMAP_EVENT_FLUORESCE,
    G = RMAP_EVENT_GRADIENT,
    O = RMAP_EVENT_ELEMENT,
    X = RMAP_EVENT_LEFT,
    K = RMAP_EVENT_LIMIT,
    E = RMAP_EVENT_ERROR
};
enum { AIR, GLASS, INK };
enum { LENS1, TUBE, LENS2, COVER, MIRROR, ODD, NONE = -1 };
enum { SENSOR, SCREEN, FAR_GRID };

#endif
