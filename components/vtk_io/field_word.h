// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

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

}  // namespace stroma
