// SPDX-License-Identifier: LGPL-2.1-or-later
// Values to text, and the words for their types.
#include <charconv>

#include "framework/scene/data.h"
#include "framework/scene/text.h"

namespace stroma {

std::string printReal(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

namespace {

void append(std::string& out, bool value) { out += value ? "true" : "false"; }
void append(std::string& out, int value) { out += std::to_string(value); }
void append(std::string& out, double value) { out += printReal(value); }
void append(std::string& out, const std::string& value) { out += value; }
void append(std::string& out, const FileName& value) { out += value.given; }
void append(std::string& out, const Vec3& value) { for (int i = 0; i < 3; ++i) out += (i ? " " : "") + printReal(value[i]); }
template <class T, std::size_t n>
void append(std::string& out, const std::array<T, n>& value) {
  for (std::size_t i = 0; i < n; ++i) {
    if (i) out += ' ';
    append(out, value[i]);
  }
}
template <class T>
void append(std::string& out, const std::vector<T>& list) {
  bool first = true;
  for (const auto& item : list) {
    if (!first) out += ' ';
    first = false;
    if constexpr (std::is_same_v<T, bool>) {
      append(out, bool(item));
    } else {
      append(out, item);
    }
  }
}

struct TypeWords {
  std::string operator()(const bool*) const { return "true or false"; }
  std::string operator()(const int*) const { return "integer"; }
  std::string operator()(const double*) const { return "real"; }
  std::string operator()(const std::string*) const { return "text"; }
  std::string operator()(const Vec3*) const { return "3 reals"; }
  std::string operator()(const std::array<int, 3>*) const { return "3 integers"; }
  std::string operator()(const std::array<double, 16>*) const { return "16 reals (a 4 x 4 matrix, row by row)"; }
  std::string operator()(const std::vector<bool>*) const { return "list of true or false"; }
  std::string operator()(const std::vector<int>*) const { return "list of integers"; }
  std::string operator()(const std::vector<double>*) const { return "list of reals"; }
  std::string operator()(const std::vector<Vec3>*) const { return "list of 3 reals"; }
  std::string operator()(const std::vector<std::string>*) const { return "list of words"; }
  template <std::size_t n>
  std::string operator()(const std::vector<std::array<Index, n>>*) const { return "list of " + std::to_string(n) + " indices"; }
  std::string operator()(const FileName*) const { return "file"; }
  std::string operator()(const ChoiceRef& choice) const {
    std::string out = "one of: ";
    for (std::size_t i = 0; i < choice.words.size(); ++i) out += (i ? ", " : "") + choice.words[i];
    return out;
  }
  std::string operator()(const LinkBase* link) const { return "link to a component (" + link->roleText() + ")"; }
};

}  // namespace

std::string Data::print() const {
  return std::visit(
      [](const auto& pointer) -> std::string {
        using Pointer = std::decay_t<decltype(pointer)>;
        if constexpr (std::is_same_v<Pointer, ChoiceRef>) {
          const auto value = std::size_t(*pointer.value);
          return value < pointer.words.size() ? pointer.words[value] : std::string();
        } else if constexpr (std::is_same_v<Pointer, LinkBase*>) {
          return pointer->path;
        } else {
          std::string out;
          append(out, *pointer);
          return out;
        }
      },
      pointer_);
}

std::string Data::typeText() const {
  if (value_width_ > 1) return "list of " + std::to_string(value_width_) + " reals";
  return std::visit(TypeWords(), pointer_);
}

}  // namespace stroma
