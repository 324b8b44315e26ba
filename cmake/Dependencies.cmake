# Every library Raymap builds on, as an imported target rmap::NAME. All are Debian packages; the
# headers count as system headers, so that our warnings speak of our code only.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(MPI REQUIRED COMPONENTS C)

function(rmap_pkg name module)
  pkg_check_modules(${name} REQUIRED IMPORTED_TARGET ${module})
  add_library(rmap::${name} ALIAS PkgConfig::${name})
endfunction()

# `hdf5` alone may mean the MPI build on some machines; the serial one is asked for by name.
rmap_pkg(hdf5 hdf5-serial)
rmap_pkg(zlib zlib)
rmap_pkg(yaml yaml-0.1)
rmap_pkg(jansson jansson)
rmap_pkg(xxhash libxxhash)
rmap_pkg(png libpng)
rmap_pkg(edit libedit)
rmap_pkg(microhttpd libmicrohttpd)
rmap_pkg(assimp assimp)
rmap_pkg(muparser muparser) # its C interface: formulas of gradient media
rmap_pkg(xml libxml-2.0)

# Headers alone: io/export/raster.c loads it, with cairo that draws for it, where it is wanted.
pkg_check_modules(rsvg REQUIRED librsvg-2.0)
add_library(rmap::rsvg INTERFACE IMPORTED)
target_include_directories(rmap::rsvg SYSTEM INTERFACE ${rsvg_INCLUDE_DIRS})

# Of OpenEXR its C interface alone, since version 3.1; the rest is C++.
pkg_check_modules(openexr REQUIRED OpenEXR>=3.1)
find_library(OPENEXR_CORE_LIBRARY NAMES OpenEXRCore OpenEXRCore-3_1 REQUIRED
             HINTS ${openexr_LIBRARY_DIRS})
find_path(OPENEXR_INCLUDE openexr.h REQUIRED HINTS ${openexr_INCLUDE_DIRS})
add_library(rmap::openexr INTERFACE IMPORTED)
target_include_directories(rmap::openexr SYSTEM INTERFACE ${OPENEXR_INCLUDE})
target_link_libraries(rmap::openexr INTERFACE ${OPENEXR_CORE_LIBRARY})

# Embree's own CMake files pull in its C++ targets' needs; header and library are all we use.
find_path(EMBREE_INCLUDE embree3/rtcore.h REQUIRED)
find_library(EMBREE_LIBRARY embree3 REQUIRED)
add_library(rmap::embree INTERFACE IMPORTED)
target_include_directories(rmap::embree SYSTEM INTERFACE ${EMBREE_INCLUDE})
target_link_libraries(rmap::embree INTERFACE ${EMBREE_LIBRARY})

find_path(RANDOM123_INCLUDE Random123/philox.h REQUIRED)
add_library(rmap::random123 INTERFACE IMPORTED)
target_include_directories(rmap::random123 SYSTEM INTERFACE ${RANDOM123_INCLUDE})

# zlib alone will do; libdeflate is several times faster.
option(RAYMAP_LIBDEFLATE "Use libdeflate, where it is installed, in the place of zlib" ON)
add_library(rmap_deflate INTERFACE)
add_library(rmap::deflate ALIAS rmap_deflate)
pkg_check_modules(deflate IMPORTED_TARGET libdeflate)
if(deflate_FOUND AND RAYMAP_LIBDEFLATE)
  target_link_libraries(rmap_deflate INTERFACE PkgConfig::deflate)
  target_compile_definitions(rmap_deflate INTERFACE RAYMAP_HAVE_LIBDEFLATE=1)
endif()

pkg_check_modules(cmocka IMPORTED_TARGET cmocka)
