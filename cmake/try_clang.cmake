# SPDX-License-Identifier: LGPL-2.1-or-later
# stroma_try_clang(CLANG RESULT): RESULT is ON where CLANG makes and uses a precompiled header as the tests have one, with GCC's
# standard library. One that is too old for it, or finds no library, would fail in the middle of the build. What works is not
# tried again.
function(stroma_try_clang clang result)
  set(script ${CMAKE_SOURCE_DIR}/cmake/with_clang.sh)
  file(SHA256 ${script} state)
  string(PREPEND state "${clang} ")
  set(${result} ON PARENT_SCOPE)
  if("${STROMA_TRIED_CLANG}" STREQUAL state)
    return()
  endif()
  set(folder ${CMAKE_BINARY_DIR}/CMakeFiles/try_clang)
  file(WRITE ${folder}/tried.h "#include <gtest/gtest.h>\n#include <algorithm>\n#include <memory>\n#include <ranges>\n")
  file(WRITE ${folder}/tried.cpp "TEST(Clang, CompilesTests) {
  const auto one = std::make_unique<std::vector<int>>(3, 1);
  EXPECT_EQ(std::ranges::count(*one, 1), 3);
}
")
  get_target_property(folders GTest::gtest INTERFACE_INCLUDE_DIRECTORIES)
  set(includes "")
  list(REMOVE_ITEM folders ${CMAKE_CXX_IMPLICIT_INCLUDE_DIRECTORIES})
  foreach(path ${folders})
    list(APPEND includes -isystem ${path})
  endforeach()
  set(compile sh ${script} ${CMAKE_CXX_COMPILER} ${clang} ${CMAKE_CXX_COMPILER} -std=gnu++20 -fPIC -O0 ${includes})
  execute_process(COMMAND ${compile} -x c++-header -c tried.h -o tried.h.gch WORKING_DIRECTORY ${folder}
    RESULT_VARIABLE failed OUTPUT_VARIABLE said ERROR_VARIABLE said)
  if(NOT failed)
    execute_process(COMMAND ${compile} -include tried.h -c tried.cpp -o tried.o WORKING_DIRECTORY ${folder}
      RESULT_VARIABLE failed OUTPUT_VARIABLE said ERROR_VARIABLE said)
  endif()
  if(failed)
    file(WRITE ${folder}/said.txt "${said}")
    message(STATUS "Tests: GCC compiles them, ${clang} does not (${folder}/said.txt)")
    set(${result} OFF PARENT_SCOPE)
  else()
    message(STATUS "Tests: ${clang} compiles them")
    set(STROMA_TRIED_CLANG "${state}" CACHE INTERNAL "clang that compiled a test, and the script's hash")
  endif()
endfunction()
