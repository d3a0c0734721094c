// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/picture/png.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string_view>

namespace stroma::picture {
namespace {

constexpr int best = 9, quick = 6;  // of zlib's levels

struct Rectangle {
  int x = 0, y = 0, width = 0, height = 0;
};

void addNumber(std::string& out, std::uint32_t number) {
  for (int shift = 24; shift >= 0; shift -= 8) out += char(number >> shift & 255);
}
void addShort(std::string& out, std::uint32_t number) { out += char(number >> 8 & 255), out += char(number & 255); }

void addChunk(std::string& out, std::string_view kind, std::string_view data) {
  addNumber(out, std::uint32_t(data.size()));
  const std::size_t start = out.size();
  out.append(kind).append(data);
  addNumber(out, std::uint32_t(crc32(0, reinterpret_cast<const Bytef*>(out.data() + start), uInt(out.size() - start))));
}

int paeth(int left, int above, int corner) {
  const int p = left + above - corner;
  const int a = std::abs(p - left), b = std::abs(p - above), c = std::abs(p - corner);
  return a <= b && a <= c ? left : b <= c ? above : corner;
}

constexpr std::size_t kinds = 5;  ///< of filters, numbered as in the standard

/// A row as differences to its neighbours, by each filter; the sums of their sizes.
std::array<long, kinds> filterRow(const std::vector<std::uint8_t>& row, const std::vector<std::uint8_t>& above,
                                  std::size_t channels, std::array<std::vector<std::uint8_t>, kinds>& out) {
  std::array<long, kinds> sums{};
  for (std::size_t i = 0; i < row.size(); ++i) {
    const int left = i >= channels ? row[i - channels] : 0, up = above[i],
              corner = i >= channels ? above[i - channels] : 0;
    const std::array<int, kinds> guess{0, left, up, (left + up) / 2, paeth(left, up, corner)};
    for (std::size_t k = 0; k < kinds; ++k) {
      out[k][i] = std::uint8_t(row[i] - guess[k]);
      sums[k] += std::abs(int(std::int8_t(out[k][i])));
    }
  }
  return sums;
}

/// Each row behind the number of the filter whose differences are least in sum.
std::string filtered(const Image& image, const Rectangle& part, std::size_t channels) {
  const std::size_t size = channels * std::size_t(part.width);
  std::vector<std::uint8_t> row(size), above(size, 0);
  std::array<std::vector<std::uint8_t>, kinds> differences;
  for (auto& one : differences) one.resize(size);
  std::string out;
  out.reserve((size + 1) * std::size_t(part.height));
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x)
      std::copy_n(image.at(part.x + x, part.y + y), channels, row.data() + channels * std::size_t(x));
    const std::array<long, kinds> sums = filterRow(row, above, channels, differences);
    const auto kind = std::size_t(std::min_element(sums.begin(), sums.end()) - sums.begin());
    out += char(kind);
    out.append(reinterpret_cast<const char*>(differences[kind].data()), size);
    row.swap(above);
  }
  return out;
}

std::string compressed(const std::string& bytes, int level) {
  uLongf size = compressBound(uLong(bytes.size()));
  std::string out(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                uLong(bytes.size()), level) != Z_OK)
    throw std::runtime_error("the picture cannot be compressed");
  out.resize(size);
  return out;
}

std::string opening(const Image& image, bool transparent, const Words& words, const std::string& animation) {
  std::string out("\x89PNG\r\n\x1a\n");
  std::string header;
  addNumber(header, std::uint32_t(image.width)), addNumber(header, std::uint32_t(image.height));
  header += '\x08', header += transparent ? '\x06' : '\x02', header.append(3, '\0');
  addChunk(out, "IHDR", header);
  addChunk(out, "sRGB", std::string_view("\0", 1));
  if (!animation.empty()) addChunk(out, "acTL", animation);
  for (const auto& [key, text] : words)
    addChunk(out, "iTXt", key + std::string(5, '\0') + text);  // no compression, no language
  return out;
}

/// What of `next` differs from `last`; a pixel when nothing does.
Rectangle difference(const Image& last, const Image& next) {
  if (last.rgba.empty()) return {0, 0, next.width, next.height};
  int left = next.width, right = -1, top = next.height, bottom = -1;
  for (int y = 0; y < next.height; ++y)
    for (int x = 0; x < next.width; ++x) {
      if (std::equal(next.at(x, y), next.at(x, y) + 4, last.at(x, y))) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  if (right < 0) return {0, 0, 1, 1};
  return {left, top, right - left + 1, bottom - top + 1};
}

bool isOpaque(const Image& image) {
  for (std::size_t i = 3; i < image.rgba.size(); i += 4)
    if (image.rgba[i] != 255) return false;
  return true;
}

}  // namespace

std::string png(const Image& image, const Words& words) {
  const bool transparent = !isOpaque(image);
  std::string out = opening(image, transparent, words, {});
  addChunk(out, "IDAT", compressed(filtered(image, {0, 0, image.width, image.height}, transparent ? 4 : 3), best));
  addChunk(out, "IEND", {});
  return out;
}

void AnimatedPng::add(const Image& frame) {
  const Rectangle part = difference(last_, frame);
  std::string control;
  addNumber(control, sequence_++);
  for (const int number : {part.width, part.height, part.x, part.y}) addNumber(control, std::uint32_t(number));
  double parts = 10000;  // of a second; fewer for a frame that is shown long, as both numbers have 16 bits
  while (parts > 1 && parts / fps_ > 65535) parts /= 10;
  addShort(control, std::uint32_t(std::lround(std::clamp(parts / fps_, 1., 65535.))));
  addShort(control, std::uint32_t(parts));
  control.append(2, '\0');  // it stays, and takes the place of what was there
  addChunk(chunks_, "fcTL", control);
  const std::string data = compressed(filtered(frame, part, transparent_ ? 4 : 3), quick);
  if (count_++ == 0) {
    addChunk(chunks_, "IDAT", data);
  } else {
    std::string numbered;
    addNumber(numbered, sequence_++);
    addChunk(chunks_, "fdAT", numbered + data);
  }
  last_ = frame;
}

std::string AnimatedPng::finish() const {
  if (count_ == 0) throw std::logic_error("an animation without a frame");
  std::string animation;
  addNumber(animation, count_), addNumber(animation, 0);
  std::string out = opening(last_, transparent_, words_, animation) + chunks_;
  addChunk(out, "IEND", {});
  return out;
}

}  // namespace stroma::picture
