# Every library Raymap builds on, as an imported target rmap::NAME. All are Debian packages; the
# headers count as system headers, so that our warnings speak of our code only.
include(CheckCSourceCompiles)
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(MPI REQUIRED COMPONENTS C)

function(rmap_pkg name module)
  pkg_check_modules(${name} REQUIRED IMPORTED_TARGET ${module})
  add_library(rmap::${name} ALIAS PkgConfig::${name})
endfunction()

# `hdf5` alone may mean the MPI build on some machines; the serial one is asked for by name. Programs
# take the static library where there is one: Debian's shared one brings 35 others (its reader of
# remote files has them), a fifth of the processor time of a start.
option(RAYMAP_STATIC_HDF5 "Link programs with HDF5's static library where it is installed" ON)
pkg_check_modules(hdf5 REQUIRED IMPORTED_TARGET hdf5-serial)
find_library(HDF5_STATIC libhdf5.a HINTS ${hdf5_LIBRARY_DIRS})
set(static_hdf5 ${HDF5_STATIC} sz z ${CMAKE_DL_LIBS} m)
if(HDF5_STATIC)
  set(CMAKE_REQUIRED_INCLUDES ${hdf5_INCLUDE_DIRS})
  set(CMAKE_REQUIRED_LIBRARIES ${static_hdf5})
  check_c_source_compiles("#include <hdf5.h>\nint main(void) { return H5open(); }" RAYMAP_STATIC_HDF5_LINKS)
  unset(CMAKE_REQUIRED_INCLUDES)
  unset(CMAKE_REQUIRED_LIBRARIES)
endif()
add_library(rmap_hdf5 INTERFACE)
add_library(rmap::hdf5 ALIAS rmap_hdf5)
target_include_directories(rmap_hdf5 SYSTEM INTERFACE ${hdf5_INCLUDE_DIRS})
if(RAYMAP_STATIC_HDF5 AND RAYMAP_STATIC_HDF5_LINKS)
  set(is_static $<AND:$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>,$<NOT:$<BOOL:$<TARGET_PROPERTY:SHARED_HDF5>>>>)
  target_link_libraries(rmap_hdf5 INTERFACE
                        "$<IF:${is_static},${static_hdf5},PkgConfig::hdf5>")
else()
  target_link_libraries(rmap_hdf5 INTERFACE PkgConfig::hdf5)
endif()
rmap_pkg(zlib zlib)
rmap_pkg(yaml yaml-0.1)
rmap_pkg(jansson jansson)
rmap_pkg(xxhash libxxhash)
rmap_pkg(png libpng)
rmap_pkg(edit libedit)
rmap_pkg(muparser muparser) # its C interface: formulas of gradient media

# What few commands need is loaded by those that do (src/base/late_library.h): headers, and the name
# to load it by as RMAP_LIBNAME.
function(rmap_late name module)
  pkg_check_modules(${name} REQUIRED ${module})
  list(GET ${name}_LINK_LIBRARIES 0 file)
  execute_process(COMMAND ${CMAKE_OBJDUMP} -p ${file} OUTPUT_VARIABLE about COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCH "SONAME +([^ \n]+)" found "${about}")
  string(TOUPPER "RMAP_LIB${name}" macro)
  add_library(rmap::${name} INTERFACE IMPORTED)
  target_include_directories(rmap::${name} SYSTEM INTERFACE ${${name}_INCLUDE_DIRS})
  target_compile_definitions(rmap::${name} INTERFACE "${macro}=\"${CMAKE_MATCH_1}\"")
  set(RAYMAP_LATE_LIBRARIES ${RAYMAP_LATE_LIBRARIES} ${CMAKE_MATCH_1} PARENT_SCOPE)
endfunction()

rmap_late(assimp assimp)
rmap_late(xml libxml-2.0)
rmap_late(microhttpd libmicrohttpd)
rmap_late(rsvg librsvg-2.0) # and cairo, which draws for it

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
