# SPDX-License-Identifier: LGPL-2.1-or-later
# The installed package: headers, the framework library, modules, the command and stroma-config.cmake, so that a module
# can be built outside this tree with find_package(stroma).
include(CMakePackageConfigHelpers)
install(DIRECTORY framework DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stroma FILES_MATCHING PATTERN "*.h")
install(FILES ${CMAKE_BINARY_DIR}/generated/framework/scene/headers_digest.h
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stroma/framework/scene)
install(TARGETS stroma stroma_flags EXPORT stroma-targets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
set_target_properties(stroma-index PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
install(TARGETS stroma-index EXPORT stroma-targets RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(EXPORT stroma-targets NAMESPACE stroma:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/stroma)
install(FILES cmake/StromaModule.cmake DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/stroma)
configure_package_config_file(cmake/stroma-config.cmake.in ${CMAKE_BINARY_DIR}/stroma-config.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/stroma)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/stroma-config-version.cmake COMPATIBILITY ExactVersion)
install(FILES ${CMAKE_BINARY_DIR}/stroma-config.cmake ${CMAKE_BINARY_DIR}/stroma-config-version.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/stroma)
