// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace stroma {

/// What a force field decides where the scene leaves it open, and what an integrator may decide for it.
class OpenChoices {
 public:
  virtual ~OpenChoices() = default;
  /// What was chosen, for the plan ("mean dilatation"); or empty.
  virtual std::string choice() const { return {}; }
  /// Takes the derivative of the force for the stiffness from the next addForce() on, where
  /// ForceField::traits().exact_tangent is false; or what the scene asks for again. May make
  /// ForceField::patternRevision() grow. False, and nothing changes, for a field that has no other stiffness.
  virtual bool useExactTangent(bool) { return false; }
  /// Takes a stiffness without unstable directions from the next addForce() on, or again the one that the scene asks for.
  /// Returns false and changes nothing if the field has no such stiffness.
  virtual bool useDefiniteTangent(bool) { return false; }
};

}  // namespace stroma
