// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/vtk_io/field_word.h"

#include <fmt/format.h>

namespace stroma {

Component& componentAt(Node& from, std::string_view path) {
  const std::string whole(path);
  if (path.starts_with('@')) path.remove_prefix(1);
  Node* at = &from;
  if (path.starts_with('/')) {
    at = &from.root();
    path.remove_prefix(1);
  }
  for (std::size_t slash = path.find('/'); at && slash != std::string_view::npos; slash = path.find('/')) {
    const std::string_view part = path.substr(0, slash);
    if (part == "..")
      at = at->parent();
    else if (part != ".")
      at = at->findChild(part);
    path.remove_prefix(slash + 1);
  }
  const bool name_only = whole.find('/') == std::string::npos;
  Component* found = at ? at->findByName(path) : nullptr;
  for (; !found && name_only && at->parent(); found = at->findByName(path)) at = at->parent();
  if (!found) throw ComponentError(fmt::format("there is no component '{}'", whole), "a path like fem or @../body/fem");
  return *found;
}

}  // namespace stroma
