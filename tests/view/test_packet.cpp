// SPDX-License-Identifier: LGPL-2.1-or-later
// Packets are read back by a reader of its own that follows their description.
#include <gtest/gtest.h>

#include <cstring>

#include "tools/view/packet.h"

namespace stroma::view {
namespace {

using nlohmann::json;

/// The header of a packet, and where its data begin.
json headerOf(const std::string& bytes, std::size_t& data) {
  EXPECT_EQ(bytes.substr(0, 4), "SRM1");
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 4, 4);
  EXPECT_EQ(length % 8, 0u);
  data = 8 + length;
  return json::parse(bytes.substr(8, length));
}

template <class T>
std::vector<T> arrayOf(const std::string& bytes, const std::string& name, const char* type) {
  std::size_t data = 0;
  const json entry = headerOf(bytes, data).at("arrays").at(name);
  EXPECT_EQ(entry.at("type"), type);
  const std::size_t offset = entry.at("offset");
  EXPECT_EQ(offset % 8, 0u);
  std::vector<T> values(entry.at("length").get<std::size_t>());
  EXPECT_LE(data + offset + values.size() * sizeof(T), bytes.size());
  std::memcpy(values.data(), bytes.data() + data + offset, values.size() * sizeof(T));
  return values;
}

TEST(Packet, ArraysOfOddLengthsAreReadBack) {
  Packet packet({{"is", "frame"}, {"step", 3}});
  packet.add("0.x", std::vector<float>{1, 2, 3});
  packet.add("kind", std::vector<std::uint8_t>{7});
  packet.add("none", std::vector<std::int32_t>{});
  packet.add("links", std::vector<std::int32_t>{-1, 5, 70000});
  const std::string bytes = packet.bytes();
  EXPECT_EQ(bytes.size() % 8, 0u);
  std::size_t data = 0;
  EXPECT_EQ(headerOf(bytes, data).at("step"), 3);
  EXPECT_EQ(arrayOf<float>(bytes, "0.x", "f32"), (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(arrayOf<std::uint8_t>(bytes, "kind", "u8"), (std::vector<std::uint8_t>{7}));
  EXPECT_TRUE(arrayOf<std::int32_t>(bytes, "none", "i32").empty());
  EXPECT_EQ(arrayOf<std::int32_t>(bytes, "links", "i32"), (std::vector<std::int32_t>{-1, 5, 70000}));
}

TEST(Packet, TextThatIsNoUtf8DoesNotKeepAPacketFromBeingSent) {
  Packet packet(json{{"name", "organ\xff.xml"}});
  std::size_t data = 0;
  EXPECT_TRUE(headerOf(packet.bytes(), data).at("name").is_string());
}

TEST(Packet, ShortPositionsAreWithinHalfAPartOfTheBox) {
  Packet frame({{"is", "frame"}, {"format", "f32"}});
  std::vector<float> x;
  for (int i = 0; i < 300; ++i) x.push_back(i % 3 == 1 ? 0.25f : 0.01f * float(i * i % 97) - 0.3f);
  frame.add("0.x", x);
  frame.add("f2", std::vector<float>{5, 6});
  const std::string bytes = withShortPositions(frame).bytes();
  std::size_t data = 0;
  const json header = headerOf(bytes, data);
  EXPECT_EQ(header.at("format"), "u16");
  const auto parts = arrayOf<std::uint16_t>(bytes, "0.x", "u16");
  ASSERT_EQ(parts.size(), x.size());
  const json box = header.at("boxes").at(0);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double low = box.at(i % 3), high = box.at(3 + i % 3);
    EXPECT_NEAR(low + parts[i] / 65535. * (high - low), x[i], 0.5001 * (high - low) / 65535 + 1e-7) << i;
  }
  EXPECT_EQ(arrayOf<float>(bytes, "f2", "f32"), (std::vector<float>{5, 6}));
}

}  // namespace
}  // namespace stroma::view
