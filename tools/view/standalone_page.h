// SPDX-License-Identifier: LGPL-2.1-or-later
// One HTML file with the page and a run in it, that needs no server: index.html with script and style inline, and the packets
// of the scene and of its frames (16-bit positions), each behind its length, compressed with gzip, in base64.
#pragma once
#include <memory>
#include <string>
#include <string_view>

namespace stroma::view {

constexpr std::size_t most_page_bytes = 50u << 20;

/// Compresses what it is given at once: of a run only what the file will have is kept.
class StandalonePage {
 public:
  StandalonePage();
  ~StandalonePage();
  /// Packet::bytes() of "scene", "held", perhaps "cells", then of "frame"s. Throws std::runtime_error for a packet of 4 GiB.
  void add(std::string_view packet);
  /// Bytes of the file as far as it is known: the last few hundred kB may still be missing.
  std::size_t size() const;
  /// The text of the file. Nothing can follow.
  std::string finish();

 private:
  class Part;
  std::unique_ptr<Part> part_;  ///< that is being compressed
  std::string parts_;           ///< whole ones: texts of JSON with commas between
  std::size_t without_parts_;   ///< bytes of the page
};

}  // namespace stroma::view
