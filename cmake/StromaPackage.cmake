# SPDX-License-Identifier: LGPL-2.1-or-later
# Debian packages, one for each component of the installation (`tools/setup package` makes them). What needs heavy libraries,
# or libraries under the GPL, is apart from the command: without it, messages name the package to install.
#
#   stroma          the command, the framework, modules that need small libraries, the live view, scenes, documents
#   stroma-vtk      VTK's formats: VTKExporter, MeshVTKLoader's reader, the reader of segmented images; `stroma picture`
#   stroma-mesh     `stroma mesh` (CGAL, GPL)
#   stroma-solvers  direct solvers and condensed bodies (CHOLMOD and BLAS, GPL)
#   python3-stroma  the Python module
#   stroma-dev      headers, stroma-config.cmake and the indexer, for modules outside the tree
# `cpack -G DEB` packs any whole build. That of `tools/setup package` is for all instruction sets, and in Debian's folders.
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/parts.packages CONTENT "${parts_packaged}" @ONLY)
set(CPACK_CUSTOM_INSTALL_VARIABLES STROMA_IS_PACKED=ON)
# A file for packages alone.
function(stroma_packed_file file destination component)
  install(CODE "if(STROMA_IS_PACKED)
  file(INSTALL \"${file}\" DESTINATION \"\${CMAKE_INSTALL_PREFIX}/${destination}\")
endif()" COMPONENT ${component})
endfunction()
stroma_packed_file(${CMAKE_BINARY_DIR}/parts.packages ${CMAKE_INSTALL_LIBDIR}/stroma runtime)
if(left_out)
  list(JOIN left_out ", " left_out)
  install(CODE "if(STROMA_IS_PACKED)
  message(FATAL_ERROR \"A package has all parts. Left out here: ${left_out}. 'tools/setup package' installs what they need\")
endif()" COMPONENT runtime)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME stroma)
set(CPACK_PACKAGE_VENDOR "Stroma")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each component has its own
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR}/lib)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_COMPONENTS_IGNORE_GROUPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_OUTPUT_FILE_PREFIX packages)
# Who packs says so as Debian's tools want it, in DEBFULLNAME and DEBEMAIL.
set(name "$ENV{DEBFULLNAME}")
set(address "$ENV{DEBEMAIL}")
if(NOT name OR NOT address)
  set(name "Whoever built this package")
  set(address "root@localhost")
endif()
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${name} <${address}>")
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # SOURCE_DATE_EPOCH, where it is set
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/debian/changelog CONTENT "stroma (${PROJECT_VERSION}) unstable; urgency=medium

  * The changes are listed in /usr/share/doc/stroma/CHANGELOG.md.

 -- ${CPACK_DEBIAN_PACKAGE_MAINTAINER}  ${date}
" @ONLY)
execute_process(COMMAND gzip -9nkf ${CMAKE_BINARY_DIR}/debian/changelog COMMAND_ERROR_IS_FATAL ANY)

set(CPACK_COMPONENTS_ALL "")
# stroma_package(COMPONENT NAME SUMMARY text DESCRIPTION text [DEPENDS text] [RECOMMENDS text] [SUGGESTS text])
macro(stroma_package component package)
  cmake_parse_arguments(arg "" "SUMMARY;DESCRIPTION;DEPENDS;RECOMMENDS;SUGGESTS" "" ${ARGN})
  string(TOUPPER ${component} key)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME ${package})
  set(CPACK_DEBIAN_${key}_DESCRIPTION "${arg_SUMMARY}\n${arg_DESCRIPTION}")
  set(CPACK_COMPONENT_${key}_DESCRIPTION "${arg_SUMMARY}\n${arg_DESCRIPTION}")
  set(CPACK_DEBIAN_${key}_PACKAGE_DEPENDS "${arg_DEPENDS}")
  set(CPACK_DEBIAN_${key}_PACKAGE_RECOMMENDS "${arg_RECOMMENDS}")
  set(CPACK_DEBIAN_${key}_PACKAGE_SUGGESTS "${arg_SUGGESTS}")
  stroma_packed_file(${CMAKE_SOURCE_DIR}/cmake/debian/copyright ${CMAKE_INSTALL_DATADIR}/doc/${package} ${component})
  stroma_packed_file(${CMAKE_BINARY_DIR}/debian/changelog.gz ${CMAKE_INSTALL_DATADIR}/doc/${package} ${component})
endmacro()

set(same "= ${PROJECT_VERSION}")
stroma_package(runtime stroma
  RECOMMENDS "stroma-vtk (${same}), stroma-solvers (${same}), stroma-mesh (${same})"
  SUGGESTS "stroma-dev (${same}), paraview"
  SUMMARY "simulation of soft tissue from an XML scene"
  DESCRIPTION "A scene names a mesh, a material, loads and a solver. The command runs it,
or shows it live in the browser. Corotational and hyperelastic elements,
viscosity, fluid in tissue, muscles, membranes and springs, with implicit and
explicit integrators. Names and attributes are those of SOFA.")
stroma_package(vtk stroma-vtk DEPENDS "stroma (${same}), libegl-mesa0, libgl1-mesa-dri"
  SUMMARY "simulation of soft tissue - formats of VTK, pictures"
  DESCRIPTION "Writes results for ParaView. Reads the meshes of VTK, and the segmented images
that 'stroma mesh' fills with tetrahedra. Draws pictures without a display.")
stroma_package(solvers stroma-solvers DEPENDS "stroma (${same})"
  SUMMARY "simulation of soft tissue - direct solvers and condensed bodies"
  DESCRIPTION "Sparse factorisations, and linear bodies that are inverted beforehand. Under
the GPL, because the supernodal part of CHOLMOD is.")
stroma_package(mesh stroma-mesh DEPENDS "stroma (${same})" RECOMMENDS "stroma-vtk (${same})"
  SUMMARY "simulation of soft tissue - meshes from images and surfaces"
  DESCRIPTION "Fills segmented images and closed surfaces with tetrahedra. Under the GPL,
because the mesh generator of CGAL is.")
stroma_package(python python3-stroma DEPENDS "stroma (${same}), python3, python3-numpy" RECOMMENDS "python3-scipy"
  SUMMARY "simulation of soft tissue - Python module"
  DESCRIPTION "Loads or builds a scene in Python, steps it, and has its states as arrays of
NumPy without copies.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
stroma_package(dev stroma-dev
  DEPENDS "stroma (${same}), cmake (>= 3.25), g++, libeigen3-dev (>= 3.4), libfmt-dev, libxsimd-dev"
  SUMMARY "simulation of soft tissue - for modules of one's own"
  DESCRIPTION "Headers, the CMake package and the indexer, for components that are built
outside the tree of Stroma.")
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)

# The framework library is for the packages of this version alone; the loader's cache is told of it.
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${CMAKE_SOURCE_DIR}/cmake/debian/triggers)
stroma_packed_file(${CMAKE_SOURCE_DIR}/cmake/debian/overrides/stroma ${CMAKE_INSTALL_DATADIR}/lintian/overrides runtime)
include(CPack)
