// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "components/contact/contact_friction.h"

namespace stroma::contact {

/// Repeats the solves of a step until friction, with lagged normal forces and directions, no longer changes.
class FrictionRounds {
 public:
  int most = 10;  ///< maximum number of solves per step

  /// A step begins, or is restarted; `friction` has the contacts at its start.
  void begin(const Friction& friction) { rounds_ = 0, is_to_change_ = friction.hasSlid() && !friction.slides.empty(); }
  /// Reduces the slip of sticking contacts (Friction::sharpen()), with the same number of further solves.
  void sharpen(Friction& friction, const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved) {
    rounds_ = 0;
    friction.sharpen(law, x, start, moved);
  }
  /// Contacts may be held: another solve may follow this one.
  bool mayHold() const { return rounds_ + 1 < most; }
  /// The present solve is only intermediate: friction is expected to change enough afterwards to need another one.
  bool goOn(const Friction& friction) const {
    return rounds_ + 2 < most && is_to_change_ && !friction.isHolding() && !friction.isRelaxed();
  }
  /// `change`: of the friction forces between two solves, see relativeChange(). Held contacts give no information on slip.
  bool changes(double change, bool was_held) {
    constexpr double settled = 1e-3, usual_factor = 0.1, surely = 3;
    is_to_change_ = !was_held && usual_factor * change > surely * settled;
    return change > settled;
  }
  bool takeAnother() { return ++rounds_ < most; }

 private:
  int rounds_ = 0;
  bool is_to_change_ = false;
};

}  // namespace stroma::contact
