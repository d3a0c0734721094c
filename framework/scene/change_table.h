// SPDX-License-Identifier: LGPL-2.1-or-later
// One table of everything that SOFA renamed, so that old and new scenes load: the loader maps old names (with one
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
/// A component of SOFA without a successor of one name: what to write instead.
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
/// What to do instead of an attribute, or empty.
std::string_view adviceOn(std::string_view attribute);
/// Components of SOFA that only draw, load plugins or schedule: accepted without effect, summed up in one line.
const std::vector<std::string_view>& acceptedWithoutEffect();
/// Those of them that draw the body of a node.
const std::vector<std::string_view>& visualModels();
/// What a node that only carries a visual model holds beside it: the mapping that moves it and the mesh it is made of.
bool servesVisualModels(std::string_view type);
/// Attributes any component may carry that only matter for drawing or for SOFA's own bookkeeping.
const std::vector<std::string_view>& visualAttributes();

}  // namespace stroma
