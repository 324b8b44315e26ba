/* SPDX-License-Identifier: MIT
 *
 * A shared object that leaves a file when it is loaded, and would go on to be no plug-in at all.
 */
#include <stdio.h>

__attribute__((constructor)) static void run(void)
{
    FILE *trace = fopen("constructor-ran", "w");
    if (trace)
        (void)fclose(trace);
}
