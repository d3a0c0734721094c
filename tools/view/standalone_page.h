// SPDX-License-Identifier: LGPL-2.1-or-later
// One HTML file with the page and a run in it, that needs no server: index.html with script and style inline, and the packets
// of the scene and of its frames (16-bit positions), each behind its length, compressed with gzip, in base64.
#pragma once
#include <string>
#include <vector>

namespace stroma::view {

constexpr std::size_t most_page_bytes = 50u << 20;

/// The text of the file. `packets`: Packet::bytes() of "scene", "held", perhaps "cells", and of "frame"s.
std::string standalonePage(const std::vector<std::string>& packets);

}  // namespace stroma::view
