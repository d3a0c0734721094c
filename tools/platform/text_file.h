// SPDX-License-Identifier: LGPL-2.1-or-later
// Files embedded in a program. They are not read before first use.
#pragma once
#include <string_view>

/// Declares `std::string_view NAME()`, the bytes of a file that CMake associates with this source.
#define STROMA_TEXT_FILE(name, file)                                                                               \
  asm(".section .rodata\n.global " #name "_begin\n.global " #name "_end\n.balign 16\n" #name "_begin:\n.incbin \"" \
      file "\"\n" #name "_end:\n.byte 0\n.text\n");                                                                \
  extern "C" __attribute__((visibility("hidden"))) const char name##_begin[], name##_end[];                        \
  inline std::string_view name() { return {name##_begin, std::size_t(name##_end - name##_begin)}; }
