// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "components/contact/contact_friction.h"

namespace stroma::contact {

/// Solves of a step that are repeated until friction, which has the normal forces and directions of the solve before, no longer changes.
class FrictionRounds {
 public:
  int most = 10;  ///< solves of a step

  /// A step begins, or begins again; `friction` has the slides of its start.
  void begin(const Friction& friction) { rounds_ = 0, is_to_change_ = friction.hasSlid() && !friction.slides.empty(); }
  /// What sticks is to creep by less (Friction::sharpen()), in as many solves again.
  void sharpen(Friction& friction, const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved) {
    rounds_ = 0;
    friction.sharpen(law, x, start, moved);
  }
  /// What is off may be held: another solve may follow this one.
  bool mayHold() const { return rounds_ + 1 < most; }
  /// The present solve is but a place to go on from: friction is expected to change after it by so much that another one follows.
  bool goOn(const Friction& friction) const {
    return rounds_ + 2 < most && is_to_change_ && !friction.isHolding() && !friction.isEased();
  }
  /// `change`: of the forces of friction between two solves, see relativeChange(). What was held in the last one says nothing of slip.
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
