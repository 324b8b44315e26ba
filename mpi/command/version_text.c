/* SPDX-License-Identifier: MIT
 *
 * What the program is made of.
 */
#include "mpi/command/version_text.h"

#include <mpi.h>
#include <string.h>
#include <zlib.h>

#include <jansson.h>

#include "accel/accel.h"
#include "io/map/library_versions.h"
#include "trace/tracer_revision.h"
#include "version.h"

void rmap_version_print(FILE *out)
{
    char mpi_library[MPI_MAX_LIBRARY_VERSION_STRING];
    struct rmap_library_version library[RMAP_LIBRARY_COUNT];
    int len = 0;
    if (MPI_Get_library_version(mpi_library, &len) != MPI_SUCCESS)
        len = 0;
    mpi_library[len] = 0;
    mpi_library[strcspn(mpi_library, ",\n")] = 0;
    fprintf(out, "raymap %s (%s)\n", RMAP_VERSION, RMAP_GIT_REVISION);
    fprintf(out, "tracer     revision %d\n", RMAP_TRACER_REVISION);
    fprintf(out, "compiler   %s\n", RMAP_COMPILER);
    fprintf(out, "Embree     %s\n", rmap_accel_embree_version());
    fprintf(out, "MPI        %s\n", mpi_library);
    rmap_library_versions(library);
    for (int i = 0; i < RMAP_LIBRARY_COUNT; i++)
        fprintf(out, "%-10s %s\n", library[i].name, library[i].version);
    fprintf(out, "zlib       %s\n", zlibVersion());
    fprintf(out, "jansson    %s\n", jansson_version_str());
}
