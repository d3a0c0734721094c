# SPDX-License-Identifier: LGPL-2.1-or-later
# Asks a program of GoogleTest for its suites and writes them as tests of ctest: see suites.cmake.
function(list_suites program folder place list timeout shards)
  execute_process(COMMAND "${program}" --gtest_list_tests WORKING_DIRECTORY "${place}" TIMEOUT ${timeout}
    OUTPUT_VARIABLE listed RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${program} does not list its tests (${result}): ${listed}")
  endif()
  string(REGEX MATCHALL "(^|\n)[A-Za-z_0-9/]+\\." suites "${listed}")  # what a type of a typed suite is called stands behind it
  set(text "")
  foreach(suite IN LISTS suites)
    string(REGEX REPLACE "^\n|\\.$" "" suite "${suite}")
    set(count 1)
    foreach(shard IN LISTS shards)
      if(shard MATCHES "^${suite}=([0-9]+)$")
        set(count ${CMAKE_MATCH_1})
      endif()
    endforeach()
    math(EXPR last "${count} - 1")
    foreach(index RANGE ${last})
      set(name "${folder}.${suite}")
      set(environment "")
      if(count GREATER 1)
        string(APPEND name ".${index}")
        set(environment "GTEST_TOTAL_SHARDS=${count};GTEST_SHARD_INDEX=${index}")
      endif()
      string(APPEND text "add_test(\"${name}\" \"${program}\" \"--gtest_filter=${suite}.*\")\n"
        "set_tests_properties(\"${name}\" PROPERTIES WORKING_DIRECTORY \"${place}\" LABELS ${folder} TIMEOUT ${timeout} ENVIRONMENT \"${environment}\""
        " FAIL_REGULAR_EXPRESSION \"Running 0 tests\")\n")
    endforeach()
  endforeach()
  file(WRITE "${list}" "${text}")
endfunction()
