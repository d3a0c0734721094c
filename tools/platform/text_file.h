// SPDX-License-Identifier: LGPL-2.1-or-later
// Files of a build in a program, as they are: nothing is read before somebody looks.
#pragma once
#include <string_view>

/// Declares `std::string_view NAME()`, the bytes of a file. CMake names the file for the source that does so.
#define STROMA_TEXT_FILE(name, file)                                                                               \
  asm(".section .rodata\n.global " #name "_begin\n.global " #name "_end\n.balign 16\n" #name "_begin:\n.incbin \"" \
      file "\"\n" #name "_end:\n.byte 0\n.text\n");                                                                \
  extern "C" __attribute__((visibility("hidden"))) const char name##_begin[], name##_end[];                        \
  inline std::string_view name() { return {name##_begin, std::size_t(name##_end - name##_begin)}; }
