// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
namespace stroma {
/// A role beside a constraint's that prescribes a motion: in a step its nodes have the velocity of prescribe() at the step's start.
class StartVelocity {
 public:
  virtual ~StartVelocity() = default;
  virtual bool keepsStartVelocity() const = 0;
};
}  // namespace stroma
