// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace stroma::view {

/// A message with arrays: "SRM1", the length of a JSON header (a multiple of 8), the header, and the arrays that its member
/// `arrays` lists with type, offset and length. Little-endian; each array begins at a multiple of 8, so that a page reads it
/// in place.
class Packet {
 public:
  using Values = std::variant<std::vector<float>, std::vector<std::uint16_t>, std::vector<std::int32_t>,
                              std::vector<std::uint8_t>>;

  explicit Packet(nlohmann::json header) : header_(std::move(header)) {}
  void add(std::string name, Values values) { arrays_.emplace_back(std::move(name), std::move(values)); }
  nlohmann::json& header() { return header_; }
  const nlohmann::json& header() const { return header_; }
  const std::vector<std::pair<std::string, Values>>& arrays() const { return arrays_; }
  std::string bytes() const;

 private:
  nlohmann::json header_;
  std::vector<std::pair<std::string, Values>> arrays_;
};

/// The same frame with positions as 16-bit parts of each body's box: a third of a thousandth of a percent of its size. `boxes`
/// of the header has the boxes: lx ly lz hx hy hz.
Packet withShortPositions(const Packet& frame);

}  // namespace stroma::view
