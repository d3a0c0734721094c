# SPDX-License-Identifier: LGPL-2.1-or-later
# What `cmake --install` puts where, in components: runtime (the command, the framework, modules, scenes, documents), dev
# (headers and stroma-config.cmake, for modules outside this tree with find_package(stroma)), and a component for each PACKAGE
# of cmake/StromaModule.cmake. Every file is found from the place of the command or the framework library, so that the
# whole can be moved. cmake/StromaPackage.cmake makes a Debian package of each component.
include(CMakePackageConfigHelpers)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/stroma)
set(data_folder ${CMAKE_INSTALL_DATADIR}/stroma)

install(TARGETS stroma EXPORT stroma-targets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT dev)
install(TARGETS stroma_flags EXPORT stroma-targets)
set_target_properties(stroma-index PROPERTIES INSTALL_RPATH "$ORIGIN/..")
install(TARGETS stroma-index EXPORT stroma-targets RUNTIME DESTINATION ${CMAKE_INSTALL_LIBDIR}/stroma COMPONENT dev)
install(DIRECTORY framework DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stroma COMPONENT dev FILES_MATCHING PATTERN "*.h")
install(FILES ${CMAKE_BINARY_DIR}/generated/framework/scene/headers_digest.h
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stroma/framework/scene COMPONENT dev)
install(EXPORT stroma-targets NAMESPACE stroma:: DESTINATION ${package_folder} COMPONENT dev)
configure_package_config_file(cmake/stroma-config.cmake.in ${CMAKE_BINARY_DIR}/stroma-config.cmake
  INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/stroma-config-version.cmake COMPATIBILITY ExactVersion)
install(FILES cmake/StromaModule.cmake ${CMAKE_BINARY_DIR}/stroma-config.cmake ${CMAKE_BINARY_DIR}/stroma-config-version.cmake
  DESTINATION ${package_folder} COMPONENT dev)

# Scenes with their meshes and the stored states that `stroma regress` compares with. The sample module is an example too.
install(DIRECTORY scenes/examples scenes/python scenes/benchmarks scenes/meshes scenes/regression
  DESTINATION ${data_folder}/scenes COMPONENT runtime PATTERN "__pycache__" EXCLUDE)
install(FILES README.md CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)
install(DIRECTORY docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs COMPONENT runtime PATTERN "__pycache__" EXCLUDE)
# Programs of a build folder find the scenes where those of an installed tree do.
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/share/stroma)
file(CREATE_LINK ${CMAKE_SOURCE_DIR}/scenes ${CMAKE_BINARY_DIR}/share/stroma/scenes SYMBOLIC)

# ---- parts that may be missing ----

get_property(parts_built GLOBAL PROPERTY STROMA_PARTS_BUILT)
get_property(parts_packaged GLOBAL PROPERTY STROMA_PARTS_PACKAGED)
get_property(left_out GLOBAL PROPERTY STROMA_LEFT_OUT)
string(REGEX REPLACE "\t[^\t\n]*\n" "\n" parts_targets "${parts_built}")
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/lib/stroma/parts.targets CONTENT "${parts_targets}" @ONLY)

# Everything but the tests.
get_property(targets GLOBAL PROPERTY STROMA_PARTS_TARGETS)
add_custom_target(stroma_all DEPENDS stroma-command stroma-index stroma_manual stroma_schema ${targets})

# `cmake --install` builds nothing. What a build that is not complete lacks is said before anything is installed.
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/parts.built CONTENT "stroma\tstroma-command\t${CMAKE_BINARY_DIR}/bin/stroma
stroma-index\tstroma-index\t${CMAKE_BINARY_DIR}/bin/stroma-index
the manual\tstroma_manual\t${CMAKE_BINARY_DIR}/share/man/man1/stroma.1
the schema\tstroma_schema\t${CMAKE_BINARY_DIR}/share/stroma/stroma.xsd
${parts_built}" @ONLY)
configure_file(cmake/check_build.cmake.in ${CMAKE_BINARY_DIR}/check_build.cmake @ONLY)
