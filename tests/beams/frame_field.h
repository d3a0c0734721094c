// SPDX-License-Identifier: LGPL-2.1-or-later
// A force field between three rigid frames, the first one of its scene, and what each of them must be to its energy.
#pragma once
#include <gtest/gtest.h>

#include "framework/mechanics/frames.h"
#include "tests/support/random_rows.h"
#include "tests/support/scene_text.h"

namespace stroma::test {

struct FrameField {
  Simulation simulation;
  System& system;
  ForceField& field;
  explicit FrameField(const std::string& text)
      : simulation(simulationFromText(text)), system(*simulation.systems()[0]), field(*system.forceFields().at(0)) {}
  /// With weight.
  Vector forceAt(ConstRows x) {
    Vector f(system.allRows()), v(system.allRows());
    system.computeForce(x, v, f);
    return f;
  }
  Vector movedBy(double s, ConstRows d, ConstRows from) const {
    Vector x(system.allRows());
    copy(from, x);
    system.motion().advance(s, d, x);
    return x;
  }
  Vector product(ConstRows d) {
    Vector out(system.allRows());
    field.addStiffnessProduct(d, 1, out);
    return out;
  }
  /// The force at x against the slope of the energy along d, and K d against that of the force. The skew half of a torque is
  /// left out of stiffnesses.
  void expectSlopes(const Vector& x, const Vector& d) {
    const Vector f = forceAt(x);
    const double h = 1e-5;
    const Vector there = movedBy(h, d, x), back = movedBy(-h, d, x);
    const double slope = (system.potentialEnergy(there) - system.potentialEnergy(back)) / (2 * h);
    EXPECT_NEAR(slope, -dot(f, d), 1e-7 * (norm(f) * norm(d)));
    const Vector plus = forceAt(there), minus = forceAt(back);
    forceAt(x);
    const Vector along = product(d);
    for (Index i = 0; i < along.count(); ++i) {
      Vec3 exact = (plus[i] - minus[i]) / (2 * h);
      if (i % 2 == 1) exact -= 0.5 * Vec3(d[i]).cross(Vec3(f[i]));
      EXPECT_LT((exact - along[i]).norm(), 1e-7 * norm(along));
    }
  }
};

}  // namespace stroma::test
