# The optical materials and the published surfaces go into the program as the texts that they are, by the assembler: no rank looks for a file.
enable_language(ASM)
set(MATERIALS ${PROJECT_SOURCE_DIR}/src/optics/materials.txt)
set(FINISHES ${PROJECT_SOURCE_DIR}/io/scene/finishes.yaml)
configure_file(${PROJECT_SOURCE_DIR}/cmake/materials.S.in ${PROJECT_BINARY_DIR}/generated/materials.S @ONLY)
set_source_files_properties(${PROJECT_BINARY_DIR}/generated/materials.S PROPERTIES OBJECT_DEPENDS "${MATERIALS};${FINISHES}")
add_library(rmap_materials STATIC ${PROJECT_BINARY_DIR}/generated/materials.S)
set_target_properties(rmap_materials PROPERTIES LINKER_LANGUAGE C)
