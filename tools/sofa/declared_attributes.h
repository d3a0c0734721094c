// SPDX-License-Identifier: LGPL-2.1-or-later
// The attributes that SOFA's components declare (declared_attributes.txt), and what happens to each in its dialect.
#pragma once
#include <string_view>
#include <vector>

#include "framework/scene/data.h"

namespace stroma::sofa {

struct DeclaredAttribute {
  std::string_view name;
  std::vector<std::string_view> aliases;
  std::string_view default_text;  ///< numbers with commas between, or a word; empty: not known, or an empty list
};

/// Classes of SOFA whose attributes are known: components, and what they derive from.
std::vector<std::string_view> declaringTypes();
/// The type of the component that takes the place of SOFA's.
std::string_view componentFor(std::string_view type);
/// Of a type of SOFA, those of its bases included; empty: they are not known.
const std::vector<DeclaredAttribute>& declaredAttributes(std::string_view type);
/// By name or alias; null: there is none, or the type's are not known.
const DeclaredAttribute* findDeclared(std::string_view type, std::string_view name);
/// Whether a written value is the default: bools as words or numbers, numbers in any notation.
bool isDefault(const DeclaredAttribute& attribute, std::string_view value);

/// What becomes of an attribute of SOFA.
enum class Treatment { read, no_effect, refused };
/// `type` is SOFA's name of the component, and `here` the attributes of what takes its place.
Treatment treatmentOf(std::string_view type, std::string_view attribute, const DataTable& here);

}  // namespace stroma::sofa
