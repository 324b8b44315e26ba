# `cpack -G DEB` in the build's folder makes a package of it for the Debian that it was built on, `cpack -G
# TGZ` an archive of the installed files.
set(CPACK_PACKAGE_NAME raymap)
set(CPACK_PACKAGE_VENDOR "Raymap")
set(CPACK_PACKAGE_CONTACT "the authors of Raymap <raymap@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "trace light into ray maps and ask questions about it")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS openmpi-bin)
include(CPack)
