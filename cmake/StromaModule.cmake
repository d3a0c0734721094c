# SPDX-License-Identifier: LGPL-2.1-or-later
# stroma_module(NAME COMPONENTS stem... [KERNELS stem...] [SHARED stem...] [LIBRARIES lib...] [LEVELS] [PACKAGE part]
#   [UNITY size] [WITH name...] [KERNELS_OF name...])
#   Builds the components stem.cpp of the current folder as one runtime module, NAME.so, with its index and manual beside
#   it: the target stroma_NAME. A folder whose first scenes need few of its components has two, so that nobody waits for the
#   others to be compiled, or opens them: the second takes the SHARED sources of the first WITH it, and the KERNELS_OF it where
#   its files are no unities. With LEVELS it is built once for each instruction set of STROMA_LEVELS. KERNELS are
#   private sources that are compiled like components. SHARED are those that hold no element loops: they are compiled
#   once, for all levels, as stroma_NAME_shared, which the family's tests link too. The generated registry lists every
#   component by name, so nothing depends on static initialisers. PACKAGE names the package that brings the module, where its
#   libraries are too heavy for the one of the command: stroma-<part> (cmake/StromaInstall.cmake). UNITY: see stroma_unity().
#   Outside this tree, after find_package(stroma), the same call builds NAME.so with NAME.index and NAME.manual beside it in
#   the current build folder; a folder like that is named in STROMA_MODULE_PATH.

# What a module lacks is seen when it is opened. The libraries that it brings are bound call by call (BLAS and LAPACK have 17,000
# symbols, of which a run calls a few dozen): modules are opened lazily, but for themselves.
set(stroma_bound_at_once -Wl,-z,now)

define_property(GLOBAL PROPERTY STROMA_MODULES BRIEF_DOCS "names of the modules" FULL_DOCS "names of the modules")
if(NOT TARGET stroma::stroma_flags)
  add_custom_target(stroma_modules_index ALL)  # all modules of the tree
endif()

# Parts: what may be missing, in a build that is not complete or among installed packages. moduleFolder() gets a list of
# them, from which messages say how to get a missing one (framework/scene/services.h).
function(stroma_part name target file package)
  set_property(GLOBAL APPEND PROPERTY STROMA_PARTS_TARGETS ${target})
  set_property(GLOBAL APPEND_STRING PROPERTY STROMA_PARTS_BUILT "${name}\t${target}\t${file}\n")
  set_property(GLOBAL APPEND_STRING PROPERTY STROMA_PARTS_PACKAGED "${name}\t${package}\n")
endfunction()

# A part that is left out: because something is not installed here, or because it is not wanted.
function(stroma_left_out part why)
  message(STATUS "${part} is left out: ${why}")
  set_property(GLOBAL APPEND PROPERTY STROMA_LEFT_OUT "${part} (${why})")
endfunction()

# PACKAGE of a call as the component of its install rules and the name of the package.
macro(stroma_package_of part)
  set(install_component runtime)
  set(package stroma)
  if(NOT "${part}" STREQUAL "")
    set(install_component ${part})
    set(package stroma-${part})
  endif()
endmacro()

# What every target of the project compiles with. (The installed package brings it along.)
if(NOT TARGET stroma::stroma_flags)
  add_library(stroma_flags INTERFACE)
  target_compile_options(stroma_flags INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
    -fopenmp-simd -fno-math-errno -fno-trapping-math -fvisibility-inlines-hidden
  -fpch-preprocess  # for ccache
  # GCC tidies up its memory when it has 0.8 GB, not at each 0.25 GB: less time, and the same code
  $<BUILD_INTERFACE:$<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=400000>>
  # false alarms of GCC 12 in ordinary string and variant code
  -Wno-restrict -Wno-maybe-uninitialized -Wno-array-bounds -Wno-stringop-overflow
  # in units of several files, names of the other files are no surroundings
  $<$<BOOL:$<TARGET_PROPERTY:UNITY_BUILD>>:-Wno-shadow$<SEMICOLON>-Wno-subobject-linkage>)
endif()
if(STROMA_WERROR)
  target_compile_options(stroma_flags INTERFACE -Werror)
endif()
if(STROMA_SANITIZE)
  # with our assertions and those of the standard library; line numbers are all that reports need of debug information
  target_compile_options(stroma_flags INTERFACE -fsanitize=${STROMA_SANITIZE} -fno-omit-frame-pointer
    -UNDEBUG -D_GLIBCXX_ASSERTIONS -g1)
  target_link_options(stroma_flags INTERFACE -fsanitize=${STROMA_SANITIZE})
endif()
if(STROMA_FUZZ)
  # what libFuzzer sees of the code, and undefined behaviour as an end
  target_compile_options(stroma_flags INTERFACE -fsanitize=fuzzer-no-link -fno-sanitize-recover=all -O1)
endif()

# stroma_unity(TARGET SIZE): compiles at most SIZE sources of a target as one unit, equal numbers in each (STROMA_UNITY). The
# size is a trade: what they include is read and instantiated once for all of them (three units of four integrators took 18 s,
# one of twelve 10 s), and a change in one compiles all of them again. Names in anonymous namespaces must then differ between
# the files of a target.
function(stroma_unity target size)
  if(STROMA_UNITY)
    get_target_property(sources ${target} SOURCES)
    list(FILTER sources INCLUDE REGEX "[.]cpp$")
    list(LENGTH sources count)
    math(EXPR units "(${count} + ${size} - 1) / ${size}")
    math(EXPR size "(${count} + ${units} - 1) / ${units}")
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${size})
  endif()
endfunction()

# stroma_alone(file...): sources that take the compiler so long that each stays a unit.
function(stroma_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# stroma_precompiled(NAME OPTIONS option... [HEADERS header...] [HIDDEN])
#   Precompiled headers for all targets with these compiler options: a target takes them with
#   target_precompile_headers(TARGET REUSE_FROM NAME). GCC takes -O from the headers too, whatever the target says: give it
#   those of the same -O, and compile programs with -fPIC too.
function(stroma_precompiled name)
  cmake_parse_arguments(arg "HIDDEN" "" "OPTIONS;HEADERS" ${ARGN})
  set(source ${CMAKE_BINARY_DIR}/generated/${name}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "// generated: a target needs a source\n" @ONLY)
  add_library(${name} OBJECT ${source})
  target_link_libraries(${name} PRIVATE stroma)
  target_compile_options(${name} PRIVATE ${arg_OPTIONS})
  if(arg_HIDDEN)
    set_target_properties(${name} PROPERTIES CXX_VISIBILITY_PRESET hidden)
  endif()
  target_precompile_headers(${name} PRIVATE ${CMAKE_SOURCE_DIR}/cmake/precompiled.h ${arg_HEADERS})
endfunction()

# The options of modules built for a level; "baseline" is what the framework itself is built for.
function(stroma_level_options level result)
  if(level STREQUAL baseline)
    set(options -march=x86-64-v2)
  else()
    set(options -march=${level} $<$<CONFIG:Release>:-O3>)
    if(level STREQUAL x86-64-v4)
      # GCC 12 warns of its own AVX-512 headers (the deliberately undefined operand of masked intrinsics)
      list(APPEND options -mprefer-vector-width=512 -Wno-uninitialized -Wno-maybe-uninitialized)
    endif()
  endif()
  set(${result} ${options} PARENT_SCOPE)
endfunction()

if(NOT TARGET stroma::stroma_flags)
  foreach(level baseline ${STROMA_LEVELS})
    stroma_level_options(${level} options)
    # with what nearly all components include
    set(headers ${CMAKE_SOURCE_DIR}/framework/scene/factory.h ${CMAKE_SOURCE_DIR}/framework/mechanics/state_topology.h)
    if(NOT level STREQUAL baseline)
      list(APPEND headers <xsimd/xsimd.hpp>)
    endif()
    stroma_precompiled(stroma_precompiled_${level} OPTIONS ${options} HEADERS ${headers} HIDDEN)
  endforeach()
endif()

function(stroma_module name)
  cmake_parse_arguments(arg "LEVELS" "PACKAGE;UNITY" "COMPONENTS;KERNELS;SHARED;LIBRARIES;WITH;KERNELS_OF" ${ARGN})
  if(NOT arg_UNITY)
    set(arg_UNITY 12)
  endif()
  set(registry ${CMAKE_CURRENT_BINARY_DIR}/${name}_registry.cpp)
  set(declarations "")
  set(calls "")
  set(sources ${registry})
  set(manual_sources "")
  foreach(stem ${arg_COMPONENTS})
    string(APPEND declarations "extern \"C\" void stroma_register_${stem}(stroma::Factory&);\n")
    string(APPEND calls "  stroma_register_${stem}(factory);\n")
    list(APPEND sources ${stem}.cpp)
    list(APPEND manual_sources ${CMAKE_CURRENT_SOURCE_DIR}/${stem}.cpp)
  endforeach()
  list(TRANSFORM arg_KERNELS APPEND .cpp)
  list(APPEND sources ${arg_KERNELS})
  set(text "// generated: the components of module ${name}\n#include \"framework/scene/abi.h\"\n#include \"framework/scene/modules.h\"\n\n${declarations}
static void registerComponents(stroma::Factory& factory) {\n${calls}}\n
extern \"C\" __attribute__((visibility(\"default\"))) const stroma::ModuleInfo* stroma_module() {
  static const stroma::ModuleInfo info{STROMA_ABI, \"${name}\", registerComponents};
  return &info;\n}\n")
  file(CONFIGURE OUTPUT ${registry} CONTENT "${text}" @ONLY)

  if(TARGET stroma::stroma_flags)
    if(arg_LEVELS)
      message(FATAL_ERROR "stroma_module(${name}): LEVELS is only for modules inside the Stroma tree; use target_compile_options")
    endif()
    foreach(stem ${arg_SHARED})
      list(APPEND sources ${stem}.cpp)
    endforeach()
    stroma_outside_module(${name} "${sources}" "${manual_sources}" "${arg_LIBRARIES}")
    return()
  endif()

  stroma_package_of("${arg_PACKAGE}")
  if(arg_LEVELS)
    set(levels ${STROMA_LEVELS})
  else()
    set(levels baseline)
  endif()
  set(shared "")
  if(arg_SHARED)
    list(TRANSFORM arg_SHARED APPEND .cpp)
    add_library(stroma_${name}_shared OBJECT ${arg_SHARED})
    target_link_libraries(stroma_${name}_shared PUBLIC stroma PRIVATE ${arg_LIBRARIES})
    stroma_level_options(baseline options)
    target_compile_options(stroma_${name}_shared PRIVATE ${options})
    set_target_properties(stroma_${name}_shared PROPERTIES CXX_VISIBILITY_PRESET hidden)
    stroma_unity(stroma_${name}_shared ${arg_UNITY})
    target_precompile_headers(stroma_${name}_shared REUSE_FROM stroma_precompiled_baseline)
    set(shared $<TARGET_OBJECTS:stroma_${name}_shared>)
    get_filename_component(folder ${CMAKE_CURRENT_SOURCE_DIR} NAME)
    set_property(GLOBAL APPEND PROPERTY STROMA_SHARED_${folder} stroma_${name}_shared)
  endif()
  foreach(other ${arg_WITH})
    list(APPEND shared $<TARGET_OBJECTS:stroma_${other}_shared>)
  endforeach()
  set(built "")
  foreach(level ${levels})
    set(target stroma_${name}_${level})
    # A linker keeps the first of equal inline functions: those of the level come first.
    set(kernels "")
    foreach(other ${arg_KERNELS_OF})
      list(APPEND kernels $<FILTER:$<TARGET_OBJECTS:stroma_${other}_${level}>,EXCLUDE,_registry.cpp>)
    endforeach()
    add_library(${target} MODULE ${sources} ${kernels} ${shared})
    target_link_options(${target} PRIVATE -Wl,-Bsymbolic-functions ${stroma_bound_at_once})
    target_link_libraries(${target} PRIVATE stroma ${arg_LIBRARIES})
    if(STROMA_SANITIZE)
      # With both sanitizers a file of element kernels did not compile in five minutes at -O1; at -O0 it takes less than one.
      if(name MATCHES "elasticity|shape_memory")
        target_compile_options(${target} PRIVATE -O0)
      else()
        target_compile_options(${target} PRIVATE -O1)
      endif()
    endif()
    set_target_properties(${target} PROPERTIES PREFIX "" OUTPUT_NAME ${name} CXX_VISIBILITY_PRESET hidden)
    if(level STREQUAL baseline)
      set(folder stroma)
    else()
      set(folder stroma/${level})
    endif()
    if(NOT name MATCHES "elasticity")
      stroma_unity(${target} ${arg_UNITY})
    endif()
    stroma_level_options(${level} options)
    target_compile_options(${target} PRIVATE ${options})
    target_precompile_headers(${target} REUSE_FROM stroma_precompiled_${level})
    set_target_properties(${target} PROPERTIES
      LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/${folder}
      INSTALL_RPATH "$ORIGIN/..:$ORIGIN/../..")
    install(TARGETS ${target} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/${folder} COMPONENT ${install_component})
    list(APPEND built ${target})
  endforeach()
  # The index and the manual of the module, made by opening its first build once; afterwards nobody needs to.
  set(folder ${CMAKE_BINARY_DIR}/lib/stroma)
  list(GET built 0 first)
  add_custom_command(
    OUTPUT ${folder}/${name}.index BYPRODUCTS ${folder}/${name}.manual
    COMMAND stroma-index ${folder} ${name} $<TARGET_FILE:${first}> ${manual_sources}
    DEPENDS stroma-index stroma ${built} ${manual_sources}
    COMMENT "Indexing ${name}" VERBATIM)
  add_custom_target(stroma_${name} DEPENDS ${folder}/${name}.index)
  add_dependencies(stroma_modules_index stroma_${name})
  # With the command whatever package has the module: `list` knows all components, and what a missing one needs.
  install(FILES ${folder}/${name}.index ${folder}/${name}.manual DESTINATION ${CMAKE_INSTALL_LIBDIR}/stroma COMPONENT runtime)
  stroma_part(${name} stroma_${name} ${folder}/${name}.index ${package})
  set_property(GLOBAL APPEND PROPERTY STROMA_MODULES ${name})
  set_property(GLOBAL PROPERTY STROMA_MODULE_${name}_SOURCES ${manual_sources})
endfunction()

function(stroma_outside_module name sources manual_sources libraries)
  add_library(${name} MODULE ${sources})
  target_compile_features(${name} PRIVATE cxx_std_20)
  target_link_options(${name} PRIVATE ${stroma_bound_at_once})
  target_link_libraries(${name} PRIVATE stroma::stroma ${libraries})
  set_target_properties(${name} PROPERTIES PREFIX "" CXX_EXTENSIONS ON CXX_VISIBILITY_PRESET hidden
    LIBRARY_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
  add_custom_command(TARGET ${name} POST_BUILD
    COMMAND stroma::stroma-index ${CMAKE_CURRENT_BINARY_DIR} ${name} $<TARGET_FILE:${name}> ${manual_sources}
    COMMENT "Indexing ${name}" VERBATIM)
endfunction()

# stroma_service(NAME SOURCES file... LIBRARIES lib... [PACKAGE part])
#   Builds a shared library beside the modules that framework/scene/services.h opens by name. It has no level: what it does
#   is not done in a step.
function(stroma_service name)
  cmake_parse_arguments(arg "" "PACKAGE" "SOURCES;LIBRARIES" ${ARGN})
  stroma_package_of("${arg_PACKAGE}")
  add_library(${name} MODULE ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE stroma ${arg_LIBRARIES})
  target_link_options(${name} PRIVATE ${stroma_bound_at_once})
  set_target_properties(${name} PROPERTIES PREFIX "" CXX_VISIBILITY_PRESET hidden
    LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/stroma INSTALL_RPATH "$ORIGIN/..")
  install(TARGETS ${name} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/stroma COMPONENT ${install_component})
  stroma_part(${name} ${name} ${CMAKE_BINARY_DIR}/lib/stroma/${name}.so ${package})
endfunction()

# stroma_reader(NAME SOURCES file... LIBRARIES lib... [PACKAGE part])
#   Builds a program beside the modules that reads files with the libraries of others (framework/scene/reader_process.h).
function(stroma_reader name)
  cmake_parse_arguments(arg "" "PACKAGE" "SOURCES;LIBRARIES" ${ARGN})
  stroma_package_of("${arg_PACKAGE}")
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE stroma ${arg_LIBRARIES})
  set_target_properties(${name} PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/stroma INSTALL_RPATH "$ORIGIN/..")
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_LIBDIR}/stroma COMPONENT ${install_component})
  stroma_part(${name} ${name} ${CMAKE_BINARY_DIR}/lib/stroma/${name} ${package})
endfunction()

# Where the components of modules that are not built yet would come from: tools/platform/modules.cpp looks there for a
# name that no module has.
function(stroma_write_module_sources)
  get_property(modules GLOBAL PROPERTY STROMA_MODULES)
  set(lines "")
  foreach(name ${modules})
    get_property(sources GLOBAL PROPERTY STROMA_MODULE_${name}_SOURCES)
    list(JOIN sources "\t" sources)
    string(APPEND lines "${name}\t${sources}\n")
  endforeach()
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/lib/stroma/modules.sources CONTENT "${lines}" @ONLY)
  file(REMOVE ${CMAKE_BINARY_DIR}/lib/stroma/modules.index)  # a build folder may hold the one index of all modules
endfunction()
