/* SPDX-License-Identifier: MIT
 *
 * For who waits for others: the cores are left to those that work.
 */
#include "mpi/parallel/nap.h"

#include <time.h>

void rmap_nap(void)
{
    const struct timespec millisecond = {.tv_nsec = 1000000};
    (void)nanosleep(&millisecond, NULL);
}
