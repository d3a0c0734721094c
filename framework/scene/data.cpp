// SPDX-License-Identifier: LGPL-2.1-or-later
// The declaration side of an attribute and its look-up. Reading is in data_parse.cpp, printing in data_print.cpp,
// copying from another attribute in data_copy.cpp.
#include "framework/scene/data.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "framework/scene/text.h"

namespace stroma {

namespace {
constexpr const char* or_number = " or -";
}  // namespace

Data::Data(std::string name, DataPointer pointer) : name_(std::move(name)), pointer_(std::move(pointer)) { default_ = print(); }
void Data::keepIn(DataPointer pointer) { pointer_ = std::move(pointer); }
Data& Data::help(std::string text) { return help_ = std::move(text), *this; }
Data& Data::unit(std::string text) { return unit_ = std::move(text), *this; }
Data& Data::unitOrNumber(const std::string& text) { return unit(text + or_number); }
bool Data::settleUnit(const std::string& text) {
  if (unit_.ends_with(or_number)) unit_ = text;
  return unit_ == text;
}
/// Of a unit or a number the unit is meant where values are written in one.
void Data::closeUnit(std::string_view written) {
  if (!unit_.ends_with(or_number) || written.find_first_not_of("0123456789+-.eE%/ \t\n,") == written.npos) return;
  unit_.resize(unit_.size() - std::string_view(or_number).size());
}
Data& Data::alias(std::string other) { return aliases_.push_back(std::move(other)), *this; }
Data& Data::min(double value, bool inclusive) { return min_ = value, min_inclusive_ = inclusive, *this; }
Data& Data::max(double value, bool inclusive) { return max_ = value, max_inclusive_ = inclusive, *this; }
Data& Data::required() { return required_ = true, *this; }
Data& Data::physical() { return physical_ = true, *this; }
Data& Data::output() { return output_ = true, *this; }
Data& Data::input() { return input_ = true, *this; }
Data& Data::shorthand() { return shorthand_ = true, *this; }
Data& Data::atOnce() { return change_effect_ = ChangeEffect::at_once, *this; }
Data& Data::recompiled() { return change_effect_ = ChangeEffect::recompile, *this; }
Data& Data::inValuesOf(std::size_t numbers) { return value_width_ = numbers, *this; }

LinkBase* Data::link() const {
  const auto* link = std::get_if<LinkBase*>(&pointer_);
  return link ? *link : nullptr;
}

std::string Data::rangeText() const {
  const bool has_min = min_ > -std::numeric_limits<double>::infinity();
  const bool has_max = max_ < std::numeric_limits<double>::infinity();
  if (has_min && has_max) return (min_inclusive_ ? "[" : "(") + printReal(min_) + ", " + printReal(max_) + (max_inclusive_ ? "]" : ")");
  if (has_min) return (min_inclusive_ ? ">= " : "> ") + printReal(min_);
  if (has_max) return (max_inclusive_ ? "<= " : "< ") + printReal(max_);
  return {};
}

namespace {

template <class T>
struct IsNumber : std::bool_constant<std::is_same_v<T, int> || std::is_same_v<T, double>> {};

/// Calls f(number) for every number of a value; f returns false to stop. Values that hold none are skipped.
template <class T, class F>
bool allNumbers(const T& value, F&& f) {
  if constexpr (IsNumber<T>::value) {
    return f(double(value));
  } else if constexpr (std::is_same_v<T, Vec3>) {
    return f(value[0]) && f(value[1]) && f(value[2]);
  } else if constexpr (std::is_same_v<T, std::string> || std::is_same_v<T, FileName> || std::is_same_v<T, bool> ||
                       std::is_same_v<T, std::vector<bool>>) {
    return true;
  } else {
    for (const auto& item : value)
      if (!allNumbers(item, f)) return false;
    return true;
  }
}

}  // namespace

std::optional<Problem> Data::checkRange() const {
  bool is_extreme = false;  // for physics: squares of forces must be numbers too
  const auto inside = [&](double value) {
    is_extreme = physical_ && value != 0 && !(std::abs(value) >= 1e-100 && std::abs(value) <= 1e100);
    return !is_extreme && (min_inclusive_ ? value >= min_ : value > min_) && (max_inclusive_ ? value <= max_ : value < max_);
  };
  double count = 0, bad = 0;
  const bool good = std::visit(
      [&](const auto& pointer) {
        using Pointer = std::decay_t<decltype(pointer)>;
        if constexpr (std::is_same_v<Pointer, ChoiceRef> || std::is_same_v<Pointer, LinkBase*>) {
          return true;
        } else {
          return allNumbers(*pointer, [&](double value) { return ++count, bad = value, inside(value); });
        }
      },
      pointer_);
  if (good || (rangeText().empty() && !is_extreme)) return std::nullopt;
  Problem problem;
  problem.message = printReal(bad) + (count > 1 ? " (number " + printReal(count) + " of the value: commas separate them)" : "") +
                    " is outside the range of " + name_;
  const std::string range = is_extreme ? "of size 1e-100 to 1e100" : rangeText();
  problem.expected = std::string(range[0] == '[' || range[0] == '(' ? "a value in " : "a value ") + range +
                     (unit_.empty() || unit_ == "-" ? "" : " " + unit_);
  return problem;
}

Data& DataTable::addLink(std::string name, LinkBase& link) { return insert(Data(std::move(name), &link)); }
void DataTable::addVisualOnly(std::string name) { visual_only_.push_back(std::move(name)); }

Data& DataTable::insert(Data data) {
  if (find(data.name())) throw std::logic_error("attribute '" + data.name() + "' is declared twice");
  data_.push_back(std::move(data));
  return data_.back();
}

const Data* DataTable::find(std::string_view name_or_alias) const {
  for (const Data& data : data_)
    if (data.name() == name_or_alias) return &data;
  for (const Data& data : data_)
    if (std::find(data.aliases().begin(), data.aliases().end(), name_or_alias) != data.aliases().end()) return &data;
  return nullptr;
}

Data* DataTable::find(std::string_view name_or_alias) {
  return const_cast<Data*>(static_cast<const DataTable*>(this)->find(name_or_alias));
}

bool DataTable::isVisualOnly(std::string_view name) const {
  return std::find(visual_only_.begin(), visual_only_.end(), name) != visual_only_.end();
}

std::vector<std::string> DataTable::names() const {
  std::vector<std::string> names;
  for (const Data& data : data_) {
    names.push_back(data.name());
    names.insert(names.end(), data.aliases().begin(), data.aliases().end());
  }
  return names;
}

}  // namespace stroma
