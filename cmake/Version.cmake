# generated/version.h: the project's version (stated once, in CMakeLists.txt), the git revision and
# the compiler, for --version and for every map.
find_package(Git QUIET)
set(RAYMAP_GIT_REVISION "unknown")
if(GIT_FOUND)
  execute_process(COMMAND ${GIT_EXECUTABLE} describe --always --dirty --abbrev=12
                  WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE described
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
  if(NOT failed)
    set(RAYMAP_GIT_REVISION ${described})
  endif()
endif()
# An archive that git made has the revision in place of that format.
if(RAYMAP_GIT_REVISION STREQUAL "unknown")
  file(STRINGS ${PROJECT_SOURCE_DIR}/cmake/revision.txt archived LIMIT_COUNT 1)
  if(archived MATCHES "^[0-9a-f]+$")
    string(SUBSTRING ${archived} 0 12 RAYMAP_GIT_REVISION)
  endif()
endif()
configure_file(${PROJECT_SOURCE_DIR}/cmake/version.h.in ${PROJECT_BINARY_DIR}/generated/version.h @ONLY)
