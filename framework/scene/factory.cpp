// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/factory.h"

#include <stdexcept>

namespace stroma {

std::unique_ptr<Component> Factory::make(const std::string& type) const {
  const ComponentEntry* entry = find(type);
  if (!entry) return nullptr;
  std::unique_ptr<Component> component = entry->make();
  component->type_ = component->name_ = type;
  component->declare(component->data_);
  return component;
}

const ComponentEntry* Factory::find(const std::string& type) const {
  const auto found = entries_.find(type);
  return found == entries_.end() ? nullptr : &found->second;
}

std::vector<const ComponentEntry*> Factory::entries() const {
  std::vector<const ComponentEntry*> list;
  list.reserve(entries_.size());
  for (const auto& [type, entry] : entries_) list.push_back(&entry);
  return list;
}

void Factory::insert(ComponentEntry entry) {
  const auto [found, inserted] = entries_.emplace(entry.type, entry);
  if (!inserted)
    throw std::logic_error("component '" + entry.type + "' is registered twice: by module '" + found->second.module +
                           "' and by module '" + entry.module + "'");
}

}  // namespace stroma
