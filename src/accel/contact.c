/* SPDX-License-Identifier: MIT
 *
 * The list of surfaces that coincide at the ray's start. Along the first direction, entries
 * [0, passed) lie behind and [passed, n) ahead; a surface that touches it belongs to the point, one
 * further on begins a new point.
 */
#include <string.h>

#include "accel/accel.h"

static bool is_entry(const struct rmap_contact *contact, int32_t k, const struct rmap_hit *hit)
{
    return k >= 0 && k < contact->n && contact->surface[k].object == hit->object &&
           contact->surface[k].primitive == hit->primitive;
}

/* Entry of the hit, put into the list where it is new. */
static int32_t enter(struct rmap_contact *contact, const struct rmap_hit *hit)
{
    int32_t k = contact->backward ? contact->passed - 1 : contact->passed;
    if (hit->t == 0 && is_entry(contact, k, hit))
        return k;
    if (hit->t > 0 || contact->backward) {
        contact->backward = false; /* a new point, or an edge met on the way back */
        k = 0;
    }
    if (k == RMAP_CONTACT_MAX) { /* forget the oldest */
        memmove(&contact->surface[0], &contact->surface[1],
                (RMAP_CONTACT_MAX - 1) * sizeof(contact->surface[0]));
        k--;
    }
    contact->surface[k].object = hit->object;
    contact->surface[k].primitive = hit->primitive;
    contact->n = k + 1;
    return k;
}

void rmap_contact_pass(struct rmap_contact *contact, const struct rmap_hit *hit)
{
    int32_t k = enter(contact, hit);
    contact->passed = contact->backward ? k : k + 1;
}

void rmap_contact_turn(struct rmap_contact *contact, const struct rmap_hit *hit)
{
    int32_t k = enter(contact, hit);
    contact->passed = contact->backward ? k + 1 : k;
    contact->backward = !contact->backward;
}
