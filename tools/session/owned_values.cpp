// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/owned_values.h"

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

void visitEdits(Archive& archive, std::vector<Override>& edits) {
  std::size_t count = edits.size();
  archive.value("count", count);
  edits.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string number = std::to_string(i) + " ";
    archive.value(number + "path", edits[i].path);
    archive.value(number + "attribute", edits[i].attribute);
    archive.value(number + "text", edits[i].value);
  }
}

}  // namespace stroma
