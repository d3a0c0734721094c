// SPDX-License-Identifier: LGPL-2.1-or-later
// The value of one attribute into another: what a data link does. Equal types are copied; numbers go between scalars,
// lists and lists of tuples when they mean the same (a flat list of reals and a list of 3 reals, one value and a list
// of one), integers also into reals. Nothing else is converted.
#include <type_traits>

#include "framework/scene/data.h"

namespace stroma {

namespace {

/// How the numbers of a type are grouped: width 0 means that it holds none.
template <class N, std::size_t w, bool list>
struct NumberShape {
  using Number = N;
  static constexpr std::size_t width = w;
  static constexpr bool is_list = list;
};
template <class T>
struct Shape : NumberShape<void, 0, false> {};
template <>
struct Shape<int> : NumberShape<int, 1, false> {};
template <>
struct Shape<double> : NumberShape<double, 1, false> {};
template <>
struct Shape<Vec3> : NumberShape<double, 3, false> {};
template <class T, std::size_t n>
struct Shape<std::array<T, n>> : NumberShape<T, n, false> {};
template <class T>
struct Shape<std::vector<T>> : NumberShape<typename Shape<T>::Number, Shape<T>::width, true> {};

template <class T, class F>
void forNumbers(T& value, F&& f) {
  if constexpr (std::is_arithmetic_v<std::remove_const_t<T>>) {
    f(value);
  } else if constexpr (std::is_same_v<std::remove_const_t<T>, Vec3>) {
    for (int i = 0; i < 3; ++i) f(value[i]);
  } else {
    for (auto& item : value) forNumbers(item, f);
  }
}

/// False when the number of values does not fit the target.
template <class To, class From>
bool regroup(To& to, const From& from) {
  std::vector<typename Shape<From>::Number> flat;
  forNumbers(from, [&](auto number) { flat.push_back(number); });
  constexpr std::size_t width = Shape<To>::width;
  if constexpr (Shape<To>::is_list) {
    if (flat.size() % width != 0) return false;
    to.resize(flat.size() / width);
  } else if (flat.size() != width) {
    return false;
  }
  std::size_t next = 0;
  forNumbers(to, [&](auto& number) { number = std::remove_reference_t<decltype(number)>(flat[next++]); });
  return true;
}

/// False when the value does not fit or the types have nothing in common.
template <class To, class From>
bool assign(To& to, const From& from) {
  if constexpr (std::is_same_v<To, From>) {
    return to = from, true;
  } else if constexpr (std::is_same_v<To, std::vector<bool>> && std::is_same_v<From, bool>) {
    return to = {from}, true;
  } else if constexpr (std::is_same_v<To, std::vector<std::string>> && std::is_same_v<From, std::string>) {
    return to = {from}, true;
  } else if constexpr (std::is_same_v<To, std::string> && std::is_same_v<From, FileName>) {
    return to = from.given, true;
  } else if constexpr (Shape<To>::width != 0 && Shape<From>::width != 0) {
    using ToNumber = typename Shape<To>::Number;
    using FromNumber = typename Shape<From>::Number;
    constexpr bool same_width = Shape<To>::width == Shape<From>::width;
    constexpr bool flat = Shape<To>::width == 1 || Shape<From>::width == 1;
    constexpr bool same_number = std::is_same_v<ToNumber, FromNumber>;
    // An integer may become a real, never the other way; tuples of indices never become points.
    constexpr bool widening = std::is_same_v<ToNumber, double> && Shape<From>::width == 1;
    if constexpr ((same_width || flat) && (same_number || widening)) {
      return regroup(to, from);
    } else {
      return false;
    }
  } else {
    return false;
  }
}

template <class Pointer>
constexpr bool holds_value = !std::is_same_v<Pointer, ChoiceRef> && !std::is_same_v<Pointer, LinkBase*>;

bool assignChoice(const ChoiceRef& to, const ChoiceRef& from) {
  for (std::size_t i = 0; i < to.words.size(); ++i)
    if (to.words[i] == from.words[std::size_t(*from.value)]) return *to.value = int(i), true;
  return false;
}

}  // namespace

std::optional<Problem> Data::copyFrom(const Data& source) {
  std::optional<Problem> out_of_range;
  const bool good = std::visit(
      [&](auto& to, const auto& from) -> bool {
        using To = std::decay_t<decltype(to)>;
        using From = std::decay_t<decltype(from)>;
        if constexpr (std::is_same_v<To, ChoiceRef> && std::is_same_v<From, ChoiceRef>) {
          return assignChoice(to, from);
        } else if constexpr (holds_value<To> && holds_value<From>) {
          const std::size_t width = value_width_ > 0 ? value_width_ : Shape<std::decay_t<decltype(*to)>>::width;
          const std::size_t given = source.value_width_ > 0 ? source.value_width_ : Shape<std::decay_t<decltype(*from)>>::width;
          if (width > 1 && given > 1 && width != given) return false;
          auto value = *to;
          if (!assign(value, *from)) return false;
          std::swap(*to, value);
          out_of_range = checkRange();
          if (out_of_range) std::swap(*to, value);
          return true;
        } else {
          return false;
        }
      },
      pointer_, source.pointer_);
  if (out_of_range) return out_of_range;
  if (good) return origin_ = DataOrigin::linked, std::nullopt;
  Problem problem;
  problem.message = "the value of " + source.name() + " (" + source.typeText() + ") does not fit " + name_;
  problem.expected = typeText();
  return problem;
}

}  // namespace stroma
