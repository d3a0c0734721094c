// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/description.h"

namespace stroma {

namespace {

const AttributeDescription* findAttribute(const std::vector<AttributeDescription>& attributes, std::string_view name) {
  for (const AttributeDescription& attribute : attributes)
    if (attribute.name == name) return &attribute;
  return nullptr;
}

}  // namespace

const AttributeDescription* ComponentDescription::find(std::string_view attribute) const { return findAttribute(attributes, attribute); }

std::string ComponentDescription::name() const {
  const AttributeDescription* attribute = find("name");
  return attribute ? attribute->value : std::string();
}

const AttributeDescription* NodeDescription::find(std::string_view attribute) const { return findAttribute(attributes, attribute); }

std::string NodeDescription::name() const {
  const AttributeDescription* attribute = find("name");
  return attribute ? attribute->value : std::string();
}

}  // namespace stroma
