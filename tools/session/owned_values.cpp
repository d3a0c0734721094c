// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/owned_values.h"

#include <algorithm>
#include <stdexcept>

namespace stroma {

Entries valuesOf(const std::string& owner, const Entries& all) {
  Entries found;
  const std::string start = owner + ":";
  for (auto at = all.lower_bound(start); at != all.end() && at->first.starts_with(start); ++at) {
    const std::string name = at->first.substr(start.size());
    if (!name.starts_with("state:") && !name.starts_with("system:") && !name.starts_with("linear solver:")) found.insert(*at);
  }
  return found;
}

bool takesAll(Component& component, const Entries& values) {
  try {
    Archive archive(values);
    archive.enter(component.path());
    component.serialize(archive);
    archive.checkAllRead();
    return true;
  } catch (const std::runtime_error&) {
    return false;
  }
}

bool areTheSame(const Entries& a, const Entries& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& one, const auto& other) {
    return one.first == other.first && one.second.bytes == other.second.bytes;
  });
}

}  // namespace stroma
