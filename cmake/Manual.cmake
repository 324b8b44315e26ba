# The manual page and the completion of bash, printed by the program from its own tables. (Of a
# build with sanitisers the leaks of MPI are not asked for here.)
function(raymap_printed option file)
  add_custom_command(OUTPUT ${file} DEPENDS raymap VERBATIM
    COMMAND ${CMAKE_COMMAND} -E env ASAN_OPTIONS=detect_leaks=0 $<TARGET_FILE:raymap> help ${option} > ${file})
endfunction()
raymap_printed(--man ${PROJECT_BINARY_DIR}/raymap.1)
raymap_printed(--completion ${PROJECT_BINARY_DIR}/raymap.bash)
add_custom_target(manual ALL DEPENDS ${PROJECT_BINARY_DIR}/raymap.1 ${PROJECT_BINARY_DIR}/raymap.bash)

install(FILES ${PROJECT_BINARY_DIR}/raymap.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${PROJECT_BINARY_DIR}/raymap.bash RENAME raymap
        DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
