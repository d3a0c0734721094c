// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
namespace stroma {
/// Besides a constraint that prescribes a motion: in a step its nodes have the velocity that prescribe() gives where the step starts.
class StartVelocity {
 public:
  virtual ~StartVelocity() = default;
  virtual bool keepsStartVelocity() const = 0;
};
}  // namespace stroma
