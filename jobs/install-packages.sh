#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Installs the Debian packages that Raymap is built from, those that are missing only.
#   jobs/install-packages.sh          what building and running need
#   jobs/install-packages.sh cad      and what raymap-step is built from, which brings STEP and IGES files
#   jobs/install-packages.sh tests    and what the tests need
set -euo pipefail

build_packages=(
    gcc libc6-dev make cmake ninja-build pkg-config git
    libembree-dev libopenmpi-dev openmpi-bin openssh-client libhdf5-dev
    zlib1g-dev libdeflate-dev libyaml-dev libjansson-dev libxxhash-dev
    librandom123-dev libpng-dev libedit-dev libassimp-dev libmuparser-dev librsvg2-dev libxml2-dev
    libmicrohttpd-dev libopenexr-dev fonts-dejavu-core libjs-three libjs-codemirror libjs-d3
)
# 40 MB to download and 175 MB installed, half a minute: for who brings CAD files.
cad_packages=(g++ libocct-data-exchange-dev libocct-ocaf-dev libocct-modeling-algorithms-dev)
test_packages=(
    g++ libcmocka-dev python3 python3-numpy python3-h5py python3-pil python3-jsonschema python3-yaml python3-pip python3-venv
    python3-setuptools
    hdf5-tools clang-format binutils dpkg-dev file strace iproute2
    chromium libmcpl1
)
# A test brings up a Slurm of its own. Debian's daemons start only where a slurm.conf is, and a
# machine that has one, or a Slurm from elsewhere, is left as it is.
slurm_packages=(slurmctld slurmd slurm-client slurm-wlm-basic-plugins munge)
if [ ! -e /etc/slurm/slurm.conf ] && ! command -v slurmctld slurmd >/dev/null; then
    test_packages+=("${slurm_packages[@]}")
fi
# The page's test drives a browser from Node.js, Debian's or another.
command -v npm >/dev/null || test_packages+=(nodejs npm)

case "${1:-build}" in
build) wanted=("${build_packages[@]}") ;;
cad) wanted=("${build_packages[@]}" "${cad_packages[@]}") ;;
tests) wanted=("${build_packages[@]}" "${cad_packages[@]}" "${test_packages[@]}") ;;
*)
    echo "usage: install-packages.sh [build|cad|tests]" >&2
    exit 2
    ;;
esac

installed() {
    [ "$(dpkg-query --show --showformat='${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

if ! command -v dpkg-query >/dev/null; then
    echo "This is no Debian system. Raymap needs the counterparts of: ${wanted[*]}" >&2
    exit 0
fi
missing=()
for package in "${wanted[@]}"; do
    installed "$package" || missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
        echo "Packages are missing, and this is neither root nor is there sudo. As root, run:" >&2
        echo "  apt-get install --no-install-recommends ${missing[*]}" >&2
        exit 1
    fi
    as_root=(sudo)
fi
echo "Installing ${#missing[@]} packages: ${missing[*]}" >&2
apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=400)
"${apt[@]}" update >&2
"${apt[@]}" install -y --no-install-recommends "${missing[@]}" >&2
