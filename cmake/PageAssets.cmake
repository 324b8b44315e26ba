# The page of `raymap draw -o x.html`: its files and three.js go into the program as they are, by the
# assembler. -DRAYMAP_THREE_DIR=... takes three.js from elsewhere (r111: later ones have no
# examples/js).
set(RAYMAP_THREE_DIR /usr/share/javascript/three CACHE PATH "three.js: build/ and examples/js/")
set(PAGE_THREE ${RAYMAP_THREE_DIR}/build/three.min.js)
set(PAGE_ORBIT ${RAYMAP_THREE_DIR}/examples/js/controls/OrbitControls.js)
foreach(file IN ITEMS ${PAGE_THREE} ${PAGE_ORBIT})
  if(NOT EXISTS ${file})
    message(FATAL_ERROR "${file} is missing: install libjs-three, or set RAYMAP_THREE_DIR")
  endif()
endforeach()

enable_language(ASM)
set(PAGE_DIR ${PROJECT_SOURCE_DIR}/analysis/page)
# Later files use earlier ones.
set(page_scripts data camera stage scene rays marker pick report classes objects detector region play main)
set(PAGE_SCRIPTS "")
set(page_files ${PAGE_THREE} ${PAGE_ORBIT} ${PAGE_DIR}/page.html ${PAGE_DIR}/page.css
               ${PAGE_DIR}/three-licence.txt)
foreach(script IN LISTS page_scripts)
  string(APPEND PAGE_SCRIPTS "    .incbin \"${PAGE_DIR}/${script}.js\"\n")
  list(APPEND page_files ${PAGE_DIR}/${script}.js)
endforeach()
configure_file(${PROJECT_SOURCE_DIR}/cmake/page_assets.S.in ${PROJECT_BINARY_DIR}/generated/page_assets.S @ONLY)
set_source_files_properties(${PROJECT_BINARY_DIR}/generated/page_assets.S PROPERTIES
                            OBJECT_DEPENDS "${page_files}")
add_library(rmap_page_assets STATIC ${PROJECT_BINARY_DIR}/generated/page_assets.S)
set_target_properties(rmap_page_assets PROPERTIES LINKER_LANGUAGE C)
