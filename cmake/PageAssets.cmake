# The pages that the program writes and serves: their files and libraries go into the program as they are, by
# the assembler. analysis/page has that of `raymap draw -o x.html`; the workbench of `raymap open` is the same
# with more scripts, made from the same HTML. Libraries from elsewhere: -DRAYMAP_THREE_DIR=... (r111: later ones
# have no examples/js), -DRAYMAP_CODEMIRROR_DIR=... (5), -DRAYMAP_D3_DIR=... (3).
set(RAYMAP_THREE_DIR /usr/share/javascript/three CACHE PATH "three.js: build/ and examples/js/")
set(RAYMAP_CODEMIRROR_DIR /usr/share/javascript/codemirror CACHE PATH "CodeMirror 5: lib/, addon/ and mode/")
set(RAYMAP_D3_DIR /usr/share/javascript/d3 CACHE PATH "d3 3: d3.min.js")
set(PAGE_DIR ${PROJECT_SOURCE_DIR}/analysis/page)
set(page_files "")

# The lines of the assembler that hold these files, one behind the other.
function(raymap_hold variable)
  set(lines "")
  foreach(file IN LISTS ARGN)
    if(NOT EXISTS ${file})
      message(FATAL_ERROR "${file} is missing: install libjs-three, libjs-codemirror and libjs-d3, or set "
                          "RAYMAP_THREE_DIR, RAYMAP_CODEMIRROR_DIR and RAYMAP_D3_DIR")
    endif()
    string(APPEND lines "    .incbin \"${file}\"\n    .ascii \"\\n\"\n")
  endforeach()
  set(${variable} "${lines}" PARENT_SCOPE)
  set(page_files ${page_files} ${ARGN} PARENT_SCOPE)
endfunction()

set(three ${PAGE_DIR}/three-licence.txt ${RAYMAP_THREE_DIR}/build/three.min.js
          ${RAYMAP_THREE_DIR}/examples/js/controls/OrbitControls.js)
set(mirror ${RAYMAP_CODEMIRROR_DIR})
set(editor ${PAGE_DIR}/codemirror-licence.txt ${mirror}/lib/codemirror.js ${mirror}/addon/hint/show-hint.js
           ${mirror}/addon/edit/matchbrackets.js ${mirror}/addon/mode/simple.js ${mirror}/mode/yaml/yaml.js)
set(charts ${PAGE_DIR}/d3-licence.txt ${RAYMAP_D3_DIR}/d3.min.js)
# Later files use earlier ones.
set(scripts data camera stage shape scene rays marker pick report classes objects detector region play main)
list(TRANSFORM scripts REPLACE "(.+)" "${PAGE_DIR}/\\1.js")
set(workbench_scripts editor live criteria edit tree move histogram steps start)
list(TRANSFORM workbench_scripts REPLACE "(.+)" "${PAGE_DIR}/workbench_\\1.js")

raymap_hold(PAGE_STYLE ${PAGE_DIR}/page.css)
raymap_hold(PAGE_LIBRARY ${three})
raymap_hold(PAGE_SCRIPT ${scripts})
raymap_hold(WORKBENCH_STYLE ${mirror}/lib/codemirror.css ${mirror}/addon/hint/show-hint.css ${PAGE_DIR}/page.css ${PAGE_DIR}/workbench.css)
raymap_hold(WORKBENCH_LIBRARY ${three} ${editor} ${charts})
raymap_hold(WORKBENCH_SCRIPT ${PAGE_DIR}/workbench_ask.js ${scripts} ${workbench_scripts})

# The workbench's HTML: styles and scripts are files of their own there, and its panels come behind the page's.
set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PAGE_DIR}/page.html ${PAGE_DIR}/workbench.html)
file(READ ${PAGE_DIR}/page.html html)
file(READ ${PAGE_DIR}/workbench.html panels)
string(REGEX REPLACE "<meta http-equiv[^\n]*\n" "" html "${html}")
string(REPLACE "<!--raymap:title-->" "Raymap" html "${html}")
string(REGEX REPLACE "<style>.*</style>" "<link rel=\"icon\" href=\"data:,\">\n<link rel=\"stylesheet\" href=\"/workbench.css\">" html "${html}")
string(REGEX REPLACE "<script type.*</script>" "<script src=\"/library.js\"></script>\n<script src=\"/workbench.js\"></script>" html "${html}")
string(REPLACE "</main>" "${panels}</main>" html "${html}")
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/generated/workbench.html CONTENT "${html}" @ONLY)

enable_language(ASM)
configure_file(${PROJECT_SOURCE_DIR}/cmake/page_assets.S.in ${PROJECT_BINARY_DIR}/generated/page_assets.S @ONLY)
set_source_files_properties(${PROJECT_BINARY_DIR}/generated/page_assets.S PROPERTIES
                            OBJECT_DEPENDS "${page_files};${PAGE_DIR}/page.html;${PROJECT_BINARY_DIR}/generated/workbench.html")
add_library(rmap_page_assets STATIC ${PROJECT_BINARY_DIR}/generated/page_assets.S)
set_target_properties(rmap_page_assets PROPERTIES LINKER_LANGUAGE C)
