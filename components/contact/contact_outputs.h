// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <span>
#include <string>

#include "components/contact/contact_friction.h"
#include "components/contact/wrenches.h"

namespace stroma::contact {

class KeptGaps;

/// The outputs of a contact after a step, as attributes of a component.
class Outputs {
 public:
  void declare(DataTable& table);
  /// Outputs common to all methods.
  void declareForces(DataTable& table);
  /// `bodies` are the states of the surfaces of the law, in order; obstacles follow.
  void compile(const BarrierLaw& law, const std::vector<State*>& bodies) { wrenches_.compile(law, bodies); }
  /// Touches at the positions x of all vertices; `bodies` as in compile().
  void note(const BarrierLaw& law, const std::vector<Touch>& touches, const Friction& friction, const std::vector<Vec3>& x,
            const std::vector<State*>& bodies);
  /// The same for kept gaps with their `forces`: with `each` rows, normal and friction with the coefficient `mu` (kept_outputs.cpp).
  /// `tolerated`: error of gaps [m], a thousandth of which is no slide. Returns the number of gaps that push.
  int note(const BarrierLaw& law, KeptGaps& gaps, std::span<const double> forces, std::size_t each, double mu, double tolerated,
           const std::vector<Vec3>& x, const std::vector<State*>& bodies);
  /// Records after a step whether friction has settled, and by how much (`shares`) updated surface shares would change forces.
  void noteSettling(double shares);
  /// A warning if they had not settled in some steps, or empty.
  std::string doubt() const;
  void reset() { crossings = unsettled_ = unsettled_shares_ = 0, worst_change_ = worst_shares_ = open_stiffness_ = 0; }
  /// No contact, and no nodes.
  void clear();
  void serialize(Archive& archive);
  /// A description of intersections after the step, or empty. `name` describes a vertex.
  std::string overlap(const std::string& path, const std::vector<Candidates::Crossing>& crossings, const Surfaces& surfaces,
                      const std::function<std::string(int)>& name) const;

  int crossings = 0;           ///< number of steps that ended with an intersection
  double friction_change = 0;  ///< relative change in another solve
  double moved_start = 0;      ///< the largest displacement of a node before the first step [m]

 private:
  double smallest_gap_ = 0, queries_ = 0;
  double open_stiffness_ = 0;  ///< [Pa]
  int unsettled_ = 0;        ///< steps
  double worst_change_ = 0;  ///< largest friction_change
  int unsettled_shares_ = 0;  ///< steps
  double worst_shares_ = 0;   ///< largest relative change of forces with updated surface shares
  bool touched_ = false;  ///< some pair is in reach
  std::vector<Vec3> contact_forces_, friction_forces_, forces_;
  Wrenches wrenches_;

  void clearNodes(std::size_t nodes, double far);
  void noteNodes(const BarrierLaw& law, const Touch& touch, const State& first);
  void findPressure(const BarrierLaw& law, int vertex, const std::vector<Vec3>& x, const State& first);
  bool clearNoted(const Surfaces& surfaces, const State& first, double far);
  void noteSlides(const Surfaces& surfaces, const Friction& friction, const State& first);
  // ---- per node of mstate ----
  std::vector<double> pressures_, areas_, gaps_;  ///< [Pa], [m^2], [m]
  std::vector<double> rubs_;                      ///< largest friction force; work space [N]
  std::vector<int> states_;                       ///< 0: no contact, 1: sticks, 2: slides
  bool is_clear_ = false;                         ///< all outputs are cleared
  std::vector<int> noted_;                        ///< vertices whose nodes are not cleared, with kept gaps
  bool knows_noted_ = false;
};

}  // namespace stroma::contact
