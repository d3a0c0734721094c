// SPDX-License-Identifier: LGPL-2.1-or-later
// Components that only tests of the mechanics have. Compiled once: their tables of attributes take longer than a test.
#pragma once
#include "framework/scene/factory.h"

namespace stroma::test {

/// TestIntegrator, TestSolver, TestMesh, TestLinearNet, TestSprings, TestUnsymmetric, TestDrag, TestPlane, TestTurningPlane,
/// TestMean.
void registerTestComponents(Factory& factory);
/// How often a TestLinearNet or TestSprings was assembled.
long assembliesOf(const Component& net);

}  // namespace stroma::test
