// SPDX-License-Identifier: LGPL-2.1-or-later
// Detects penetration and tunnelling in spite of contact forces: a penalty does not prevent them, and warns at the end of a run.
#pragma once
#include <functional>
#include <string>

#include "components/contact/contact_terms.h"
#include "framework/scene/archive.h"

namespace stroma::contact {

class Passages {
 public:
  /// Checks a step from `start` to `end` on straight lines that ended at `time` [s]. `ended` are its contacts there, with the normals
  /// of its start.
  void look(const BarrierLaw& law, const std::vector<Touch>& ended, const std::vector<Vec3>& start, const std::vector<Vec3>& end,
            double time);
  /// A warning, or empty.
  std::string doubt(const std::string& path, const std::function<std::string(int)>& name) const;
  void forget() { *this = {}; }
  void serialize(Archive& archive);

 private:
  int steps_ = 0;           ///< number of steps that ended with a new maximum depth, or with undetectable motion
  int one_ = -1, other_ = -1;  ///< vertices of the deepest pair; -1: a plane, or none
  double first_ = 0, deepest_ = 0;  ///< end of the first of these steps [s]; depth [m]
  double farthest_ = 0;             ///< the largest undetectable motion [m]
};

}  // namespace stroma::contact
