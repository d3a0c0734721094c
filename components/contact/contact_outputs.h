// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>

#include "components/contact/contact_friction.h"
#include "components/contact/wrenches.h"

namespace stroma::contact {

/// What can be read of contact after a step, as attributes of a component.
class Outputs {
 public:
  void declare(DataTable& table);
  /// Those that do not depend on how bodies are kept apart.
  void declareForces(DataTable& table);
  /// `bodies` are the states that the surfaces of the law are of, in order; obstacles come after them.
  void compile(const BarrierLaw& law, const std::vector<State*>& bodies) { wrenches_.compile(law, bodies); }
  /// Touches at the positions x of all vertices; `bodies` as in compile().
  void note(const BarrierLaw& law, const std::vector<Touch>& touches, const Friction& friction, const std::vector<Vec3>& x,
            const std::vector<State*>& bodies);
  /// After a step: whether its friction has settled, and the shares of the surface, which would change forces by `shares`.
  void noteSettling(double shares);
  /// A sentence when that was not so in some steps, or empty.
  std::string doubt() const;
  void reset() { crossings = unsettled_ = unsettled_shares_ = 0, worst_change_ = worst_shares_ = open_stiffness_ = 0; }
  void serialize(Archive& archive);
  /// What lies in one another after the step, as a sentence, or empty. `name` says what a vertex is.
  std::string overlap(const std::string& path, const std::vector<Candidates::Crossing>& crossings, const Surfaces& surfaces,
                      const std::function<std::string(int)>& name) const;

  int crossings = 0;           ///< steps after which surfaces crossed
  double friction_change = 0;  ///< of another solve, relative
  double moved_start = 0;      ///< the longest way of a node before the first step [m]

 private:
  double smallest_gap_ = 0, queries_ = 0;
  double open_stiffness_ = 0;  ///< [Pa]
  int unsettled_ = 0;        ///< steps
  double worst_change_ = 0;  ///< of friction_change
  int unsettled_shares_ = 0;  ///< steps
  double worst_shares_ = 0;   ///< what another solve with other shares of the surface would change of forces, as a part
  bool touched_ = false;  ///< something is in reach
  std::vector<Vec3> contact_forces_, friction_forces_, forces_;
  Wrenches wrenches_;

  void clearNodes(std::size_t nodes, double far);
  void noteNodes(const BarrierLaw& law, const Touch& touch, const State& first);
  void noteSlides(const Surfaces& surfaces, const Friction& friction, const State& first);
  // ---- of each node of mstate ----
  std::vector<double> pressures_, areas_, gaps_;  ///< [Pa], [m^2], [m]
  std::vector<double> rubs_;                      ///< the largest friction there; work space [N]
  std::vector<int> states_;                       ///< 0: nothing pushes, 1: sticks, 2: slides
  bool is_clear_ = false;                         ///< nothing of all this is of a contact
};

}  // namespace stroma::contact
