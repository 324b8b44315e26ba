#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: whoever builds the program by hand is told what is missing in one line (tests/slow), and may build
# it within a project of his own; from an archive that git made, with the same revision.
. "$(dirname "$0")/expect.bash"
rm -rf ./* && mkdir pkgconfig without
configure=(cmake -G Ninja -DCMAKE_BUILD_TYPE=Release)

# A machine with everything but cmocka.
if [ "${RAYMAP_TEST_SCALE:-1}" -gt 1 ]; then
    for folder in $(pkg-config --variable pc_path pkg-config | tr : ' '); do
        for file in "$folder"/*.pc; do
            [ ! -e "$file" ] || [[ $file == */cmocka.pc ]] || ln -sf "$file" pkgconfig/
        done
    done
    expect 1 'install libcmocka-dev, or give -DBUILD_TESTING=OFF' \
        env PKG_CONFIG_LIBDIR="$PWD/pkgconfig" "${configure[@]}" -S "$SOURCE_DIR" -B without
    expect 0 '' env PKG_CONFIG_LIBDIR="$PWD/pkgconfig" "${configure[@]}" -S "$SOURCE_DIR" -B without -DBUILD_TESTING=OFF
fi

source=$SOURCE_DIR
if [ -e "$SOURCE_DIR/.git" ]; then
    source=$PWD/archive
    git=(git -c "safe.directory=*" -C "$SOURCE_DIR")
    head=$("${git[@]}" rev-parse HEAD)
    "${git[@]}" archive --prefix=archive/ "$head" | tar -x
    export GIT_CEILING_DIRECTORIES=$PWD
fi
cat >CMakeLists.txt <<CMAKE
cmake_minimum_required(VERSION 3.25)
project(other LANGUAGES C)
include(CTest)
add_subdirectory("$source" raymap)
CMAKE
expect 0 '' "${configure[@]}" -DRAYMAP_CAD=OFF -S . -B within
expect 0 'raymap: phony' ninja -C within -t targets
! ninja -C within -t targets all | grep -q test_codec || { echo "FAILED: another project builds our tests"; failures=1; }
if [ "$source" != "$SOURCE_DIR" ]; then
    grep -qx "$head" archive/cmake/revision.txt || { echo "FAILED: the archive does not have its revision"; failures=1; }
    grep -q "\"${head:0:12}\"" within/raymap/generated/version.h || { echo "FAILED: what is built from the archive has another revision"; failures=1; }
fi
finish
