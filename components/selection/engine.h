// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "framework/scene/component.h"

namespace stroma {

/// Computes values from other values before the first step; links lead to its outputs.
class Engine : public Component {
 public:
  std::string roleText() const override { return "engine"; }
};

/// Lists of numbers, points or frames, as `template` says: reals, or whole numbers.
struct ValueList {
  std::vector<double> reals;
  std::vector<int> wholes;
  std::size_t size(bool whole, std::size_t width) const { return (whole ? wholes.size() : reals.size()) / width; }
  void clear() { reals.clear(), wholes.clear(); }
};

/// An engine whose values are numbers, points or frames. Lists hold whole values of `width` numbers.
class TypedEngine : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("template", template_).help("of what the values are: double, int, Vec2, Vec3, Vec6 or Rigid3");
  }
  void chooseTemplate(const std::string& word) override {
    const auto has = [&word](const char* part) { return word.find(part) != std::string::npos; };
    width_ = has("Rigid3") ? 7 : has("Vec6") ? 6 : has("Vec4") ? 4 : has("Vec3") ? 3 : has("Vec2") ? 2 : 1;
    whole_ = width_ == 1 && (has("int") || has("Index") || has("bool") || has("unsigned"));
    for (auto& [name, list] : lists_)
      if (Data* found = data().find(name)) {
        found->inValuesOf(width_);
        whole_ ? found->keepIn(DataPointer(&list->wholes)) : found->keepIn(DataPointer(&list->reals));
      }
  }

 protected:
  explicit TypedEngine(std::size_t width = 1) : width_(width) {}
  Data& addList(DataTable& table, const std::string& name, ValueList& list) {
    lists_.emplace_back(name, &list);
    return table.add(name, list.reals);
  }
  std::size_t count(const ValueList& list) const { return list.size(whole_, width_); }
  /// call(list of numbers...) for the kind of numbers that the template says.
  template <class Call, class... Lists>
  void withNumbers(Call&& call, Lists&... lists) {
    whole_ ? call(lists.wholes...) : call(lists.reals...);
  }
  /// Appends value i of `from` to `to`.
  template <class List>
  void copyValue(const List& from, std::size_t i, List& to) const {
    for (std::size_t c = 0; c < width_; ++c) to.push_back(from[i * width_ + c]);
  }
  void checkWhole(const ValueList& list, const char* name) const {
    if ((whole_ ? list.wholes.size() : list.reals.size()) % width_ != 0)
      throw ComponentError(std::string(name) + " does not hold whole values", std::to_string(width_) + " numbers for each");
  }

  std::size_t width_;
  bool whole_ = false;

 private:
  std::string template_;
  std::vector<std::pair<std::string, ValueList*>> lists_;
};

}  // namespace stroma
