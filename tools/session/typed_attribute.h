// SPDX-License-Identifier: LGPL-2.1-or-later
// An attribute of a description with a typed value, so that long lists need not be converted to text and back.
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "framework/scene/data.h"
#include "framework/scene/description.h"

namespace stroma {

template <class T>
AttributeDescription typedAttribute(std::string name, std::vector<T> list, const SourceLocation& where) {
  struct Owned {
    std::vector<T> list{};
    Data data;
    explicit Owned(const std::string& of) : data(of, &list) {}  // while it is empty: what it has is printed there
  };
  const auto owned = std::make_shared<Owned>(name);
  owned->list = std::move(list);
  AttributeDescription attribute{std::move(name), {}, where};
  attribute.typed = std::shared_ptr<const Data>(owned, &owned->data);
  return attribute;
}

}  // namespace stroma
