# SPDX-License-Identifier: MIT
#
# Sourced, not run: what Open MPI wants to hear on a laptop, in a container or as root. Set only
# where nothing else is said, so a cluster's own settings win.

if [ "$(id -u)" -eq 0 ]; then
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi
# More ranks than cores are fine, and no rank is nailed to one core: each runs threads of its own.
export OMPI_MCA_rmaps_base_oversubscribe="${OMPI_MCA_rmaps_base_oversubscribe:-1}"
export OMPI_MCA_hwloc_base_binding_policy="${OMPI_MCA_hwloc_base_binding_policy:-none}"
# Containers forbid the cross-memory attach that is the default of shared-memory transport.
export OMPI_MCA_btl_vader_single_copy_mechanism="${OMPI_MCA_btl_vader_single_copy_mechanism:-none}"
# Looking for network cards takes half of the time of a start and warns where there are none. Memory
# within a host and TCP between hosts need none; a queue's own nodes may have better.
if [ -z "${SLURM_JOB_ID:-}${PBS_JOBID:-}" ]; then
    export OMPI_MCA_pml="${OMPI_MCA_pml:-ob1}" OMPI_MCA_btl="${OMPI_MCA_btl:-vader,tcp,self}"
fi
# hwloc's plugins call at X servers about graphics cards: a twentieth of a start of two ranks, for nothing.
export HWLOC_PLUGINS_PATH="${HWLOC_PLUGINS_PATH:-/nonexistent}"
# Without /sys (a bare chroot) hwloc would complain in every rank.
export HWLOC_HIDE_ERRORS="${HWLOC_HIDE_ERRORS:-2}"
# Each file of a map has one writer; locks only fail on file systems without them.
export HDF5_USE_FILE_LOCKING="${HDF5_USE_FILE_LOCKING:-FALSE}"
