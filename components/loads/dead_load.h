// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces that do not depend on where the nodes are: K = 0, and the energy is -f . x.
#pragma once
#include "framework/mechanics/force_field.h"

namespace stroma {

class DeadLoad : public ForceField {
 public:
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = traits.symmetric = traits.conservative = traits.exact_tangent = true;
    traits.has_stiffness = false;
    return traits;
  }
  void addStiffnessProduct(ConstRows, double, Rows) const override {}
  void addPattern(BlockPattern&) const override {}
  void addStiffness(double, BlockMatrix&) const override {}
  void addStiffnessDiagonal(double, std::vector<double>&) const override {}
};

}  // namespace stroma
