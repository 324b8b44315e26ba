set(RAYMAP_WARNINGS -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wcast-qual -Wstrict-prototypes
    -Wmissing-prototypes -Wvla -Wundef -Wdouble-promotion -Wformat=2 -Wwrite-strings
    -Wno-missing-field-initializers)
if(CMAKE_C_COMPILER_ID MATCHES Clang)
  # What gcc takes as it is meant: branches of a macro that are not taken, INFINITY as a float.
  list(APPEND RAYMAP_WARNINGS -Wno-shift-count-negative -Wno-sign-conversion -Wno-double-promotion
       -Wno-format-nonliteral -Wno-format-zero-length -Wno-bitwise-instead-of-logical
       -Wno-bitwise-conditional-parentheses)
endif()
if(RAYMAP_WERROR)
  list(APPEND RAYMAP_WARNINGS -Werror)
endif()
