# SPDX-License-Identifier: LGPL-2.1-or-later
# stroma_suites(TARGET FOLDER [SHARDS SUITE=COUNT...])
#   Each suite of a program of GoogleTest as one test of ctest, FOLDER.SUITE: one process, which opens its libraries and its modules
#   once. To start one for each test took longer than what most tests do. A suite that calculates long is shared among COUNT processes.
#   Which test failed, or crashed, is the last that a suite has said to RUN; tools/summarise_tests.py counts tests, not suites.
#
# ctest includes list_suites() when it begins, and calls it where the program, or one of these two files, is newer than its list.
function(stroma_suites target folder)
  cmake_parse_arguments(arg "" "" "SHARDS" ${ARGN})
  set(list "${CMAKE_CURRENT_BINARY_DIR}/${target}_suites.cmake")
  set(include "${CMAKE_CURRENT_BINARY_DIR}/${target}_include.cmake")
  file(GENERATE OUTPUT "${include}" CONTENT "
if(NOT EXISTS \"$<TARGET_FILE:${target}>\")
  add_test(${target}_NOT_BUILT ${target}_NOT_BUILT)
else()
  if(NOT EXISTS \"${list}\" OR NOT \"${list}\" IS_NEWER_THAN \"$<TARGET_FILE:${target}>\"
     OR NOT \"${list}\" IS_NEWER_THAN \"\${CMAKE_CURRENT_LIST_FILE}\"
     OR NOT \"${list}\" IS_NEWER_THAN \"${CMAKE_SOURCE_DIR}/cmake/list_suites.cmake\")
    include(\"${CMAKE_SOURCE_DIR}/cmake/list_suites.cmake\")
    list_suites(\"$<TARGET_FILE:${target}>\" ${folder} \"${CMAKE_CURRENT_BINARY_DIR}\" \"${list}\" ${STROMA_TEST_TIMEOUT} \"${arg_SHARDS}\")
  endif()
  include(\"${list}\")
endif()
")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES "${include}")
endfunction()
