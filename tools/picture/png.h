// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes PNG files (ISO/IEC 15948) and animated ones (APNG 1.0, W3C PNG third edition: chunks acTL, fcTL, fdAT).
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace stroma::picture {

/// Rows from the top, four bytes a pixel: red, green, blue, opacity.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba{};

  Image() = default;
  Image(int w, int h) : width(w), height(h), rgba(4 * std::size_t(w) * std::size_t(h)) {}
  std::uint8_t* at(int x, int y) { return rgba.data() + 4 * (std::size_t(y) * std::size_t(width) + std::size_t(x)); }
  const std::uint8_t* at(int x, int y) const { return const_cast<Image*>(this)->at(x, y); }
};

using Words = std::map<std::string, std::string>;  ///< what a file says of itself: "Software", "Title", ... (UTF-8)

/// The bytes of a file. Opaque images have three channels.
std::string png(const Image& image, const Words& words);

/// An animation that is compressed frame by frame: of each frame only the rectangle that differs from the one before.
class AnimatedPng {
 public:
  /// `transparent`: four channels. A frame is shown for 1/fps s; the film is played again and again.
  AnimatedPng(double fps, bool transparent, Words words)
      : fps_(fps), transparent_(transparent), words_(std::move(words)) {}
  /// All frames have the size of the first.
  void add(const Image& frame);
  /// Throws std::logic_error without a frame.
  std::string finish() const;
  std::size_t frames() const { return count_; }

 private:
  double fps_;
  bool transparent_;
  Words words_;
  Image last_;
  std::uint32_t count_ = 0, sequence_ = 0;
  std::string chunks_;
};

}  // namespace stroma::picture
