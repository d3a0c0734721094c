// SPDX-License-Identifier: LGPL-2.1-or-later
// Text to values. Numbers are read by std::from_chars: the locale of the process plays no part, and a value that is not
// read to its last character is an error.
#include <charconv>
#include <cmath>

#include "framework/scene/data.h"
#include "framework/scene/text.h"
#include "framework/scene/written_units.h"

namespace stroma {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view space = " \t\n\r\f\v";
  const auto first = text.find_first_not_of(space);
  return first == std::string_view::npos ? std::string_view() : text.substr(first, text.find_last_not_of(space) - first + 1);
}

std::string_view Words::next() {
  constexpr std::string_view separators = " \t\n\r\f\v,";
  const auto first = rest_.find_first_not_of(separators);
  if (first == std::string_view::npos) return rest_ = {}, rest_;
  rest_.remove_prefix(first);
  const std::string_view word = rest_.substr(0, rest_.find_first_of(separators));
  rest_.remove_prefix(word.size());
  return word;
}

namespace {

/// A range such as "0-2000000000" must not become memory.
constexpr std::size_t longest_expanded_list = 50'000'000;

struct Failure {
  std::string message, suggestion;
};

bool readNumber(std::string_view word, double& out, Failure& why) {
  const std::string_view written = word;
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), out);
  if (code == std::errc::result_out_of_range) {
    why.message = inQuotes(written) + " does not fit a double";
  } else if (code != std::errc() || end != word.data() + word.size()) {
    why.message = inQuotes(written) + " is not a real number";
  } else if (!std::isfinite(out)) {
    why.message = inQuotes(written) + " is not a finite number";
  } else {
    return true;
  }
  return false;
}

bool readNumber(std::string_view word, int& out, Failure& why) {
  const std::string_view written = word;
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), out);
  if (code == std::errc() && end == word.data() + word.size()) return true;
  why.message = inQuotes(written) + (code == std::errc::result_out_of_range ? " does not fit a 32-bit integer" : " is not an integer");
  return false;
}

bool readNumber(std::string_view word, bool& out, Failure& why) {
  if (word == "true" || word == "1") return out = true, true;
  if (word == "false" || word == "0") return out = false, true;
  why.message = inQuotes(word) + " is neither true nor false";
  why.suggestion = nearest(word, {"true", "false"});
  return false;
}

/// "1,5" is what many write for 1.5: what to write instead, or empty.
std::string withPoint(std::string_view word) {
  const auto isDigit = [word](std::size_t i) { return i < word.size() && word[i] >= '0' && word[i] <= '9'; };
  const std::size_t comma = word.find(',');
  if (comma == word.npos || comma == 0 || !isDigit(comma - 1) || !isDigit(comma + 1)) return {};
  return "write " + std::string(word.substr(0, comma)) + "." + std::string(word.substr(comma + 1));
}

template <class T>
bool readScalar(std::string_view text, T& out, Failure& why) {
  const std::string_view word = trimmed(text);
  if (word.empty()) return why.message = "the value is empty", false;
  if (readNumber(word, out, why)) return true;
  if (std::is_same_v<T, double> && word.size() < 30) why.suggestion = withPoint(word);
  return false;
}

/// Exactly `count` numbers.
template <class T>
bool readFixed(std::string_view text, T* out, std::size_t count, Failure& why) {
  Words words(text);
  std::size_t found = 0;
  for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++found)
    if (found < count && !readNumber(word, out[found], why)) return false;
  if (found == count) return true;
  why.message = std::to_string(found) + (found == 1 ? " number" : " numbers") + " instead of " + std::to_string(count);
  return false;
}

bool readValue(std::string_view text, bool& out, Failure& why) { return readScalar(text, out, why); }
bool readValue(std::string_view text, int& out, Failure& why) { return readScalar(text, out, why); }
bool readValue(std::string_view text, double& out, Failure& why) { return readScalar(text, out, why); }
bool readValue(std::string_view text, std::string& out, Failure&) { return out = text, true; }
bool readValue(std::string_view text, FileName& out, Failure&) { return out.given = trimmed(text), out.found.clear(), true; }
bool readValue(std::string_view text, Vec3& out, Failure& why) { return readFixed(text, out.data(), 3, why); }
template <class T, std::size_t n>
bool readValue(std::string_view text, std::array<T, n>& out, Failure& why) {
  return readFixed(text, out.data(), n, why);
}

bool readValue(std::string_view text, std::vector<std::string>& out, Failure&) {
  Words words(text);
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) out.emplace_back(word);
  return true;
}

template <class T>
bool readFlat(std::string_view text, std::vector<T>& out, Failure& why) {
  Words words(text);
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    // SOFA writes matrices as "[1 0 0,0 1 0,0 0 1]"
    if (std::is_same_v<T, double> && word.size() > 1 && word.front() == '[') word.remove_prefix(1);
    if (std::is_same_v<T, double> && word.size() > 1 && word.back() == ']') word.remove_suffix(1);
    T value{};
    if (!readNumber(word, value, why)) return why.message += " (item " + std::to_string(out.size() + 1) + ")", false;
    out.push_back(value);
  }
  return true;
}

bool readValue(std::string_view text, std::vector<bool>& out, Failure& why) { return readFlat(text, out, why); }
bool readValue(std::string_view text, std::vector<double>& out, Failure& why) { return readFlat(text, out, why); }

/// "3-7" and "3-7-2": first, last, step. False with an empty message: the word is not a range.
bool readRange(std::string_view word, std::vector<int>& out, Failure& why) {
  int bounds[3] = {0, 0, 1};
  const char *at = word.data(), *end = word.data() + word.size();
  for (int i = 0; i < 3; ++i) {
    const auto [next, code] = std::from_chars(at, end, bounds[i]);
    if (code != std::errc()) return false;
    at = next;
    if (at == end) {
      if (i == 0) return false;
      break;
    }
    if (i == 2 || *at++ != '-') return false;
  }
  const auto [first, last, step] = bounds;
  if (first < 0 || last < first || step < 1) return why.message = inQuotes(word) + " is not an ascending range", false;
  if (out.size() + std::size_t(last - first) / std::size_t(step) >= longest_expanded_list)
    return why.message = "the range " + inQuotes(word) + " makes the list too long", false;
  for (long value = first; value <= last; value += step) out.push_back(int(value));
  return true;
}

bool readValue(std::string_view text, std::vector<int>& out, Failure& why) {
  Words words(text);
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    int value = 0;
    if (readNumber(word, value, why)) {
      out.push_back(value);
      continue;
    }
    Failure no_range;
    if (readRange(word, out, no_range)) continue;
    if (!no_range.message.empty()) return why = no_range, false;
    return why.message += " (item " + std::to_string(out.size() + 1) + ")", false;
  }
  return true;
}

/// Numbers in groups of `width`, each group one item made by `make`.
template <class Number, std::size_t width, class Item, class Make>
bool readGroups(std::string_view text, std::vector<Item>& out, Failure& why, Make make) {
  Words words(text);
  std::array<Number, width> group{};
  std::size_t count = 0;
  for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++count) {
    Number& number = group[count % width];
    if (!readNumber(word, number, why)) return why.message += " (number " + std::to_string(count + 1) + ")", false;
    if constexpr (std::is_same_v<Number, Index>)
      if (number < 0) return why.message = inQuotes(word) + " is not an index: indices count from 0", false;
    if (count % width == width - 1) out.push_back(make(group));
  }
  if (count % width == 0) return true;
  why.message = std::to_string(count) + " numbers are not a multiple of " + std::to_string(width);
  constexpr std::size_t rigid_width = 7;
  if (std::is_same_v<Item, Vec3> && count % rigid_width == 0)
    why.suggestion = "rigid frames have seven numbers each: template=\"Rigid3\" where the nodes are frames";
  return false;
}

bool readValue(std::string_view text, std::vector<Vec3>& out, Failure& why) {
  return readGroups<double, 3>(text, out, why, [](const auto& g) { return Vec3(g[0], g[1], g[2]); });
}
template <std::size_t width>
bool readValue(std::string_view text, std::vector<std::array<Index, width>>& out, Failure& why) {
  return readGroups<Index, width>(text, out, why, [](const auto& group) { return group; });
}

bool readChoice(std::string_view text, const ChoiceRef& choice, Failure& why) {
  const std::string_view word = trimmed(text);
  for (std::size_t i = 0; i < choice.words.size(); ++i)
    if (choice.words[i] == word) return *choice.value = int(i), true;
  why.message = inQuotes(word) + " is not a word for it";
  why.suggestion = nearest(word, choice.words);
  return false;
}

template <class T>
constexpr bool holds_reals = std::is_same_v<T, double> || std::is_same_v<T, Vec3> || std::is_same_v<T, std::vector<double>> ||
                             std::is_same_v<T, std::vector<Vec3>> || std::is_same_v<T, std::array<double, 16>>;

/// What was refused as plain numbers, once more as numbers with units or fractions.
template <class T>
bool readWithUnits(std::string_view text, const std::string& unit, T& out, Failure& why, std::string& expected) {
  if constexpr (holds_reals<T>) {
    try {
      const std::optional<std::string> plain = withoutUnits(text, unit);
      if (!plain) return false;
      if (std::is_same_v<T, double> && plain->find(' ') != plain->npos)
        return why.message = inQuotes(trimmed(text)) + " is more than one number", false;
      out = T{};
      return readValue(*plain, out, why = {});
    } catch (const ComponentError& error) {
      why = {error.what(), error.suggestion};
      expected = error.expected;
    }
  }
  return false;
}

}  // namespace

std::optional<Problem> Data::parse(std::string_view text, DataOrigin origin) {
  Problem problem;
  problem.expected = typeText();
  if (output_) {
    problem.message = name_ + " is computed by the component and cannot be written";
    problem.expected.clear();
    return problem;
  }
  Failure why;
  const bool good = std::visit(
      [&](auto& pointer) {
        using Pointer = std::decay_t<decltype(pointer)>;
        if constexpr (std::is_same_v<Pointer, ChoiceRef>) {
          return readChoice(text, pointer, why);
        } else if constexpr (std::is_same_v<Pointer, LinkBase*>) {
          return pointer->path = trimmed(text), true;
        } else {
          std::decay_t<decltype(*pointer)> value{};
          if (!readValue(text, value, why)) {
            if (!readWithUnits(text, unit_, value, why, problem.expected)) return false;
            closeUnit(text);
          }
          std::swap(*pointer, value);
          const std::optional<Problem> out_of_range = checkRange();
          if (!out_of_range) return true;
          std::swap(*pointer, value);
          why.message = out_of_range->message;
          problem.expected = out_of_range->expected;
          return false;
        }
      },
      pointer_);
  if (good) return origin_ = origin, std::nullopt;
  problem.message = std::move(why.message);
  const bool is_path = text.find_first_of("+-.0123456789") != 0 && text.find('.') < text.find_first_of(" \t\n,");
  problem.suggestion = why.suggestion.empty() && is_path ? "@" + std::string(text) : std::move(why.suggestion);
  return problem;
}

}  // namespace stroma
