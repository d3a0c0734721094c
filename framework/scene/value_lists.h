// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace stroma {

using Reals = std::vector<double>;
using Integers = std::vector<std::int64_t>;
using Texts = std::vector<std::string>;

/// Named lists and their bytes: how one process passes data to another on the same machine.
class ValueLists {
 public:
  template <class List>
  void add(const std::string& name, List list) {
    lists_[name] = std::move(list);
  }
  /// The list of this name; empty when there is none. Throws std::runtime_error when it is of another type.
  template <class List>
  const List& get(const std::string& name) const {
    static const List none;
    const auto found = lists_.find(name);
    if (found == lists_.end()) return none;
    const List* list = std::get_if<List>(&found->second);
    if (!list) failType(name);
    return *list;
  }
  bool has(const std::string& name) const { return lists_.contains(name); }

  std::string bytes() const;
  /// Throws std::runtime_error for any `bytes` that did not come from bytes().
  static ValueLists fromBytes(std::string_view bytes);

 private:
  [[noreturn]] static void failType(const std::string& name);
  std::map<std::string, std::variant<Reals, Integers, Texts>> lists_;
};

}  // namespace stroma
