// SPDX-License-Identifier: LGPL-2.1-or-later
// The example scenes of manual pages, as a way to every force field of the factory.
#pragma once
#include <string>

#include "framework/mechanics/force_field.h"
#include "tests/support/manual_examples.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {

/// The scene below the line `Example:` of a component's manual page.
inline std::string exampleOf(const std::string& type) { return exampleIn(modules().manual(type)); }

/// The force field of an example: `type` itself, or the other name of the component under which the example has it.
inline std::string fieldOf(const std::string& example, const std::string& type) {
  const auto has = [&](const std::string& name) { return example.find("<" + name + " ") != std::string::npos; };
  if (has(type)) return type;
  for (const ComponentEntry* entry : factory().entries())
    if (has(entry->type) && dynamic_cast<ForceField*>(factory().make(entry->type).get())) return entry->type;
  return "";
}

}  // namespace stroma::test
