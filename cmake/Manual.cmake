# The manual pages and the completion of bash, printed by the program from its own tables. (Of a
# build with sanitisers the leaks of MPI are not asked for here.)
function(raymap_printed file)
  add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/${file} DEPENDS raymap VERBATIM
    COMMAND ${CMAKE_COMMAND} -E env ASAN_OPTIONS=detect_leaks=0 $<TARGET_FILE:raymap> help ${ARGN}
            > ${PROJECT_BINARY_DIR}/${file})
  set(printed ${printed} ${PROJECT_BINARY_DIR}/${file} PARENT_SCOPE)
endfunction()
raymap_printed(raymap.1 --man)
file(GLOB commands CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/mpi/cli/cmd_*.c)
foreach(file ${commands})
  string(REGEX REPLACE ".*/cmd_(.*)\\.c" "\\1" command ${file})
  raymap_printed(raymap-${command}.1 --man ${command})
endforeach()
install(FILES ${printed} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
raymap_printed(raymap.bash --completion)
add_custom_target(manual ALL DEPENDS ${printed})
install(FILES ${PROJECT_BINARY_DIR}/raymap.bash RENAME raymap
        DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
