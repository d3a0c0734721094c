// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

#include "framework/scene/component.h"

namespace stroma {

/// A field as written: "label=owner.field", of which the first two may be missing.
struct FieldWord {
  std::string label, owner, field;

  explicit FieldWord(const std::string& word) {
    const std::size_t equals = word.find('=');
    field = equals == std::string::npos ? word : word.substr(equals + 1);
    if (equals != std::string::npos) label = word.substr(0, equals);
    const std::size_t dot = field.rfind('.');
    if (dot == std::string::npos || dot <= field.rfind('/') + 1) return;
    owner = field.substr(0, dot);
    field = field.substr(dot + 1);
  }
};

/// The owner of a field as written in the node `from`: "fem" (there, else in the nearest node above), "@fem",
/// "@../body/fem", "@/body/fem". Throws ComponentError.
Component& componentAt(Node& from, std::string_view path);

}  // namespace stroma
