// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes in the text of a test, with the components that only these tests have.
#pragma once
#include <gtest/gtest.h>

#include "tests/support/mechanics_components.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {

inline const bool test_components_registered = (registerTestComponents(factory()), true);

inline void expectContains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" is not in:\n" << text;
}

}  // namespace stroma::test
