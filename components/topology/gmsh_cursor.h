// SPDX-License-Identifier: LGPL-2.1-or-later
// A position in the bytes of a .msh file: words, numbers and binary values, none beyond the end.
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <string>
#include <string_view>

#include "framework/scene/diagnostics.h"

namespace stroma {

class GmshCursor {
 public:
  /// `bytes` must outlive the cursor; `name` of the file is for messages.
  GmshCursor(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  bool binary = false;   ///< numbers are binary from here on
  bool swapped = false;  ///< in the other byte order

  std::size_t remaining() const { return bytes_.size() - at_; }
  std::string_view rest() const { return bytes_.substr(at_); }
  /// Moves on, at most to the end.
  void skip(std::size_t bytes) { at_ += std::min(bytes, remaining()); }

  /// "liver.msh:12: message" in text, "liver.msh: byte 345: message" in binary data.
  [[noreturn]] void fail(const std::string& message, const std::string& expected = {}) const {
    if (binary) throw ComponentError(fmt::format("{}: byte {}: {}", name_, at_, message), expected);
    const auto lines = std::count(bytes_.begin(), bytes_.begin() + std::ptrdiff_t(at_), '\n');
    throw ComponentError(fmt::format("{}:{}: {}", name_, lines + 1, message), expected);
  }

  /// The next word of text; empty at the end.
  std::string_view word() {
    skipBlanks();
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && !isBlank(bytes_[at_])) ++at_;
    return bytes_.substr(begin, at_ - begin);
  }
  /// The rest of the line, without its end.
  std::string_view line() {
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    std::string_view text = bytes_.substr(at_, end - at_);
    at_ = std::min(end + 1, bytes_.size());
    if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
    return text;
  }

  /// A number in text, whatever `binary` says.
  template <class T>
  T textNumber(const char* what) {
    skipBlanks();
    T value{};
    const char* end = bytes_.data() + bytes_.size();
    const char* begin = bytes_.data() + at_;
    if (begin != end && *begin == '+') ++begin;
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (error != std::errc() || (stop != end && !isBlank(*stop))) failNumber(what, error);
    at_ = std::size_t(stop - bytes_.data());
    return value;
  }
  /// The next number: as text, or as `T` in binary.
  template <class T>
  T number(const char* what) {
    if (!binary) return textNumber<T>(what);
    if (remaining() < sizeof(T)) fail(fmt::format("the file ends inside {}", what));
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data() + at_, sizeof(T));
    if (swapped) std::reverse(raw.begin(), raw.end());
    at_ += sizeof(T);
    return std::bit_cast<T>(raw);
  }
  /// A count of things of at least `least_bytes` each: refused when the rest of the file cannot hold them.
  std::size_t checkCount(std::int64_t count, std::size_t least_bytes, const char* what) {
    if (count < 0 || std::uint64_t(count) > remaining() / least_bytes)
      fail(fmt::format("{} {} are declared, but only {} bytes follow", count, what, remaining()));
    return std::size_t(count);
  }

 private:
  static bool isBlank(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }
  /// Spaces, tabs and ends of lines: text of this format has no other structure.
  void skipBlanks() {
    while (at_ < bytes_.size() && isBlank(bytes_[at_])) ++at_;
  }
  /// Says what stands where `what` should be a number.
  [[noreturn]] void failNumber(const char* what, std::errc error) {
    if (at_ == bytes_.size()) fail(fmt::format("the file ends inside {}", what));
    const std::size_t begin = at_;
    const std::string found(word().substr(0, 40));
    at_ = begin;
    fail(fmt::format("'{}' is not {}", found,
                     error == std::errc::result_out_of_range ? "a number in range" : "a number"),
         fmt::format("a number in {}", what));
  }

  std::string_view bytes_;
  std::string name_;
  /// The next byte; never beyond the end.
  std::size_t at_ = 0;
};

}  // namespace stroma
