// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
namespace stroma {
/// A role of a constraint that prescribes a motion: its nodes keep the velocity of prescribe() at the start of the step throughout.
class StartVelocity {
 public:
  virtual ~StartVelocity() = default;
  virtual bool keepsStartVelocity() const = 0;
};
}  // namespace stroma
