// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/packet.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace stroma::view {
namespace {

static_assert(std::endian::native == std::endian::little, "packets are little-endian");

std::size_t roundedUp(std::size_t bytes) { return (bytes + 7) / 8 * 8; }

const char* typeOf(const Packet::Values& values) {
  constexpr const char* types[] = {"f32", "u16", "i32", "u8"};
  return types[values.index()];
}

bool isPositions(const std::string& name) { return name.ends_with(".x"); }

}  // namespace

std::string Packet::bytes() const {
  nlohmann::json arrays = nlohmann::json::object();
  std::size_t size = 0;
  for (const auto& [name, values] : arrays_)
    std::visit(
        [&](const auto& list) {
          arrays[name] = {{"type", typeOf(values)}, {"offset", size}, {"length", list.size()}};
          size += roundedUp(list.size() * sizeof(list[0]));
        },
        values);
  nlohmann::json header = header_;
  header["arrays"] = std::move(arrays);
  std::string text = header.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  text.resize(roundedUp(text.size()), ' ');

  std::string out("SRM1");
  const auto length = std::uint32_t(text.size());
  out.append(reinterpret_cast<const char*>(&length), sizeof length);
  out += text;
  const std::size_t start = out.size();
  out.resize(start + size);
  char* to = out.data() + start;
  for (const auto& entry : arrays_)
    std::visit(
        [&to](const auto& list) {
          if (!list.empty()) std::memcpy(to, list.data(), list.size() * sizeof(list[0]));
          to += roundedUp(list.size() * sizeof(list[0]));
        },
        entry.second);
  return out;
}

Packet withShortPositions(const Packet& frame) {
  nlohmann::json header = frame.header();
  header["format"] = "u16";
  header["boxes"] = nlohmann::json::array();
  std::vector<std::pair<std::string, Packet::Values>> arrays;
  for (const auto& [name, values] : frame.arrays()) {
    if (!isPositions(name)) {
      arrays.emplace_back(name, values);
      continue;
    }
    const auto& x = std::get<std::vector<float>>(values);
    float low[3], high[3];
    std::fill_n(low, 3, std::numeric_limits<float>::max()), std::fill_n(high, 3, std::numeric_limits<float>::lowest());
    for (std::size_t i = 0; i < x.size(); ++i)
      low[i % 3] = std::min(low[i % 3], x[i]), high[i % 3] = std::max(high[i % 3], x[i]);
    if (x.empty()) std::fill_n(low, 3, 0.f), std::fill_n(high, 3, 0.f);
    std::vector<std::uint16_t> parts(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const float width = high[i % 3] - low[i % 3];
      parts[i] = width > 0 ? std::uint16_t(std::lround(65535.f * ((x[i] - low[i % 3]) / width))) : std::uint16_t(0);
    }
    header["boxes"].push_back({low[0], low[1], low[2], high[0], high[1], high[2]});
    arrays.emplace_back(name, std::move(parts));
  }
  Packet shorter(std::move(header));
  for (auto& [name, values] : arrays) shorter.add(std::move(name), std::move(values));
  return shorter;
}

}  // namespace stroma::view
