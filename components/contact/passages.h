// SPDX-License-Identifier: LGPL-2.1-or-later
// What goes into or through something although a contact pushes it: a penalty keeps nothing apart, and says so at the end of a run.
#pragma once
#include <functional>
#include <string>

#include "components/contact/contact_terms.h"
#include "framework/scene/archive.h"

namespace stroma::contact {

class Passages {
 public:
  /// Of a step that has gone from `start` to `end`, on straight lines; time [s] is that of its end. `ended` are its contacts there,
  /// with the normals of where it started.
  void look(const BarrierLaw& law, const std::vector<Touch>& ended, const std::vector<Vec3>& start, const std::vector<Vec3>& end,
            double time);
  /// A sentence about it, or empty.
  std::string doubt(const std::string& path, const std::function<std::string(int)>& name) const;
  void forget() { *this = {}; }
  void serialize(Archive& archive);

 private:
  int steps_ = 0;           ///< after which something was deeper than ever before, or had gone too far to be seen
  int one_ = -1, other_ = -1;  ///< vertices of the deepest; -1: a plane, or nothing was seen
  double first_ = 0, deepest_ = 0;  ///< end of the first of these steps [s]; depth [m]
  double farthest_ = 0;             ///< of what has gone too far to be seen [m]
};

}  // namespace stroma::contact
