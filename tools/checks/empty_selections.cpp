// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/checks/empty_selections.h"

#include <fmt/format.h>

#include <type_traits>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/lagrangian_constraint.h"
#include "framework/mechanics/mapping.h"
#include "framework/mechanics/mass.h"
#include "framework/mechanics/position_constraint.h"
#include "framework/mechanics/projective_constraint.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/observer.h"

namespace stroma {
namespace {

template <class... Roles>
bool playsOneOf(const Component& component) {
  return (... || (dynamic_cast<const Roles*>(&component) != nullptr));
}

/// Lists of whole numbers name nodes or cells.
template <class T>
constexpr bool is_selection = false;
template <>
constexpr bool is_selection<std::vector<int>> = true;
template <std::size_t n>
constexpr bool is_selection<std::vector<std::array<Index, n>>> = true;

bool isEmptySelection(const Data& data) {
  return std::visit(
      [](const auto& member) {
        using Member = std::remove_cvref_t<decltype(member)>;
        if constexpr (std::is_pointer_v<Member>)
          if constexpr (is_selection<std::remove_pointer_t<Member>>) return member->empty();
        return false;
      },
      data.pointer());
}

}  // namespace

void warnOfEmptySelections(const Node& root, Diagnostics& diagnostics) {
  std::vector<Component*> components;
  root.collect(components);
  for (const Component* component : components) {
    if (!playsOneOf<ForceField, Mass, ProjectiveConstraint, PositionConstraint, LagrangianConstraint, Mapping, Integrator,
                    Observer>(*component))
      continue;
    for (const Data& data : component->data().all())
      if (data.isSet() && !data.isOutput() && isEmptySelection(data))
        diagnostics.warning(component->where(), component->path() + "." + data.name(),
                            fmt::format("{} is empty ({})", data.name(), data.helpText()),
                            "check the linked selection, or omit the attribute");
  }
}

}  // namespace stroma
