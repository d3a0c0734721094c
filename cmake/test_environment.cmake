# SPDX-License-Identifier: LGPL-2.1-or-later
# What every test of ctest has in its environment, unless its caller has given it. ctest includes this when it begins.
# OpenBLAS has one thread, as in the command: those of NumPy wait for each other in a loop, on cores that other tests want.
# The engine has one thread too, because ctest runs tests at once; tests of threads give their numbers.
# What a test frees stays in its process: programs of many small bodies took a fifth of their time to give memory back and to take it
# again. (The command does so by itself: tools/platform/heap.h.)
foreach(given OPENBLAS_NUM_THREADS=1 STROMA_THREADS=1 MALLOC_TRIM_THRESHOLD_=1073741824 MALLOC_TOP_PAD_=16777216 MALLOC_MMAP_THRESHOLD_=33554432)
  string(REGEX MATCH "^([^=]+)=(.*)" given "${given}")
  if(NOT DEFINED ENV{${CMAKE_MATCH_1}})
    set(ENV{${CMAKE_MATCH_1}} ${CMAKE_MATCH_2})
  endif()
endforeach()
