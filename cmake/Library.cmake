# libraymap, for other programs: what of the storeys below `mpi` it needs, and nothing of that seen from outside.
# The number goes up when a caller would have to be compiled again.
set(RAYMAP_ABI 1)
set(exports ${PROJECT_SOURCE_DIR}/analysis/library/exports.txt)
add_library(raymap_library SHARED ${library})
add_library(raymap::raymap ALIAS raymap_library)
raymap_compiled(raymap_library)
target_link_libraries(raymap_library PRIVATE rmap_analysis)
target_include_directories(raymap_library INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/analysis/library>
                           $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_link_options(raymap_library PRIVATE LINKER:--version-script=${exports} LINKER:--as-needed)
set_target_properties(raymap_library PROPERTIES OUTPUT_NAME raymap EXPORT_NAME raymap C_VISIBILITY_PRESET hidden
                      LINK_DEPENDS ${exports} VERSION ${RAYMAP_ABI}.${PROJECT_VERSION} SOVERSION ${RAYMAP_ABI})

install(TARGETS raymap_library EXPORT raymap)
install(FILES analysis/library/raymap.h TYPE INCLUDE)
install(FILES docs/libraymap.3 DESTINATION ${CMAKE_INSTALL_MANDIR}/man3)
include(CMakePackageConfigHelpers)
set(config ${CMAKE_INSTALL_LIBDIR}/cmake/raymap)
install(EXPORT raymap NAMESPACE raymap:: FILE raymapConfig.cmake DESTINATION ${config})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/raymapConfigVersion.cmake COMPATIBILITY SameMinorVersion)
file(RELATIVE_PATH up /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(${PROJECT_SOURCE_DIR}/cmake/raymap.pc.in ${PROJECT_BINARY_DIR}/raymap.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/raymapConfigVersion.cmake DESTINATION ${config})
install(FILES ${PROJECT_BINARY_DIR}/raymap.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
