// SPDX-License-Identifier: LGPL-2.1-or-later
// The marks of a state file, which state_file.h shows.
#pragma once
#include <fmt/format.h>
#include <zlib.h>

#include <string>
#include <string_view>

#include "framework/mechanics/state.h"

namespace stroma {

/// Numbers of a row in the line `label`: an orientation is a quaternion among positions, a vector elsewhere.
inline int numbersOf(RowKind kind, std::string_view label) {
  if (kind == RowKind::turn && label.starts_with("X")) return 4;
  return kind == RowKind::value ? 1 : 3;
}

constexpr std::string_view state_file_head = "# stroma state", state_file_whole = "# whole ", state_file_end = "# end";

/// The line that ends the instant with the lines `text`.
inline std::string wholeMark(std::string_view text) {
  const auto sum = crc32_z(0, reinterpret_cast<const unsigned char*>(text.data()), text.size());
  return fmt::format("{}{:08x}\n", state_file_whole, sum);
}

}  // namespace stroma
