/* SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "version.h"

int main(void)
{
    puts("raymap " RMAP_VERSION);
    return 0;
}
