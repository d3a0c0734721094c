// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/names.h"

#include <unordered_map>
#include <unordered_set>

#include "framework/scene/change_table.h"

namespace stroma {

namespace {

template <class List, class TypeOf>
std::vector<std::string> namesOf(const List& list, TypeOf typeOf) {
  std::unordered_set<std::string> taken;
  for (const auto& item : list)
    if (std::string name = item.name(); !name.empty()) taken.insert(std::move(name));
  std::vector<std::string> names;
  std::unordered_map<std::string, int> count;
  for (const auto& item : list) {
    std::string name = item.name();
    if (name.empty()) {
      const std::string type = typeOf(item);
      do {
        const int number = ++count[type];
        name = number == 1 ? type : type + std::to_string(number);
      } while (!taken.insert(name).second);
    }
    names.push_back(std::move(name));
  }
  return names;
}

}  // namespace

std::vector<std::string> componentNames(const NodeDescription& node) {
  return namesOf(node.components, [](const ComponentDescription& component) { return std::string(presentType(component.type)); });
}

std::vector<std::string> childNames(const NodeDescription& node) {
  return namesOf(node.children, [](const NodeDescription&) { return std::string("Node"); });
}

std::string joinPath(const std::string& parent, const std::string& name) { return (parent == "/" ? parent : parent + "/") + name; }

}  // namespace stroma
