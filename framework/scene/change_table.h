// SPDX-License-Identifier: LGPL-2.1-or-later
// One table of everything that SOFA has renamed, so that old and new scenes load: the loader maps old names (with one
// note), and a test checks that every replacement exists. The table is in tools/sofa.
#pragma once
#include <string_view>
#include <vector>

namespace stroma {

struct TypeChange {
  std::string_view old_type, new_type, since;
};
struct AttributeChange {
  std::string_view type, old_attribute, new_attribute;
};
/// A component of SOFA without a single successor: what to write instead.
struct TypeRemoval {
  std::string_view type, advice;
};

/// An attribute of SOFA that has no counterpart: what to write instead.
struct AttributeRemoval {
  std::string_view attribute, advice;
};

const std::vector<TypeChange>& typeChanges();
const std::vector<TypeRemoval>& typeRemovals();
/// The present name of `type`: itself unless the table renames it.
std::string_view presentType(std::string_view type);
const std::vector<AttributeChange>& attributeChanges();
/// What to use instead of an attribute, or empty.
std::string_view adviceOn(std::string_view attribute);
/// Components of SOFA that only draw, load plugins or schedule: accepted without effect and summarised in one line.
const std::vector<std::string_view>& acceptedWithoutEffect();
/// The subset that draws the body of a node.
const std::vector<std::string_view>& visualModels();
/// Components that accompany a visual model in its node: its mapping and its mesh.
bool servesVisualModels(std::string_view type);
/// Attributes of any component that only matter for drawing or for SOFA's internal bookkeeping.
const std::vector<std::string_view>& visualAttributes();

}  // namespace stroma
