// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes in the text of a test, with the components that only these tests have.
#pragma once
#include "tests/support/mechanics_components.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {

inline const bool test_components_registered = (registerTestComponents(factory()), true);

/// A component on four nodes in a row, of 1 kg and the same velocity each, under no force.
inline std::string fourNodes(const std::string& component) {
  return R"(<Node name="root" gravity="0 0 0"><TestIntegrator/>
    <MechanicalObject name="dofs" position="0 0 0 1 0 0 2 0 0 3 0 0" velocity="1 2 3 1 2 3 1 2 3 1 2 3"/>
    <UniformMass totalMass="4"/>)" +
         component + "</Node>";
}

}  // namespace stroma::test
