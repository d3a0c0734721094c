// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace stroma {

/// Options that a force field chooses if the scene leaves them open, and that an integrator may choose for it.
class OpenChoices {
 public:
  virtual ~OpenChoices() = default;
  /// What was chosen, for the plan ("mean dilatation"); or empty.
  virtual std::string choice() const { return {}; }
  /// Switches to the exact derivative of the force from the next addForce() on, if ForceField::traits().exact_tangent is
  /// false, or back to the stiffness that the scene specifies. May increase ForceField::patternRevision(). Returns false
  /// and changes nothing if the field has only one stiffness.
  virtual bool useExactTangent(bool) { return false; }
  /// Switches to a stiffness without unstable directions from the next addForce() on, or back to the one that the scene
  /// specifies. Returns false and changes nothing if the field has none.
  virtual bool useDefiniteTangent(bool) { return false; }
};

}  // namespace stroma
