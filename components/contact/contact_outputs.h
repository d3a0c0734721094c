// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>

#include "components/contact/contact_friction.h"

namespace stroma::contact {

/// What can be read of contact after a step, as attributes of a component.
class Outputs {
 public:
  void declare(DataTable& table);
  /// At the positions x of all vertices; `bodies` are the states that surfaces are of, in order.
  void note(const BarrierLaw& law, const Friction& friction, const std::vector<Vec3>& x,
            const std::vector<State*>& bodies);
  /// After a step: whether its friction has settled.
  void noteFriction();
  /// A sentence when that was not so in some steps, or empty.
  std::string doubt() const;
  void reset() { crossings = unsettled_ = 0, worst_change_ = open_stiffness_ = 0; }
  void serialize(Archive& archive);
  /// What lies in one another after the step, as a sentence, or empty. `name` says what a vertex is.
  std::string overlap(const std::string& path, const std::vector<Candidates::Crossing>& crossings, const Surfaces& surfaces,
                      const std::function<std::string(int)>& name) const;

  int crossings = 0;           ///< steps after which surfaces crossed
  double friction_change = 0;  ///< of another solve, relative

 private:
  double smallest_gap_ = 0, queries_ = 0;
  double open_stiffness_ = 0;  ///< [Pa]
  int unsettled_ = 0;        ///< steps
  double worst_change_ = 0;  ///< of friction_change
  bool touched_ = false;  ///< something is in reach
  std::vector<Vec3> contact_forces_, wrenches_, forces_;
};

}  // namespace stroma::contact
