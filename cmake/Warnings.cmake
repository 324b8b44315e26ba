set(RAYMAP_WARNINGS -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wcast-qual -Wstrict-prototypes
    -Wmissing-prototypes -Wvla -Wundef -Wdouble-promotion -Wformat=2 -Wwrite-strings
    -Wno-missing-field-initializers)
if(RAYMAP_WERROR)
  list(APPEND RAYMAP_WARNINGS -Werror)
endif()
