// SPDX-License-Identifier: LGPL-2.1-or-later
// Inputs on a condensed body. A force is a load. A pull by a spring k towards a target p is an unknown load, like that of a
// node with a prescribed position, with the compliance 1/k of the spring added to that of the node:
//
//   lambda = k (d - E^T u), u = u_0 + C E lambda  =>  (E^T C E + 1/k) lambda = d - E^T u_0,   d = E^T (p - x_0)
//
// which is Woodbury's formula for (A + E k E^T)^-1. The factor of E^T C E + 1/k is valid as long as nodes and springs are the
// same, for any targets. Damping c acts in a dynamic step like the solver's own, c (u(t+dt) - u(t-dt))/2dt: a spring of c/2dt
// towards u(t-dt). In statics it has no effect.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "components/condensation/condensed_integrator.h"

namespace stroma {

void CondensedIntegrator::checkInputOn(const State& state, const Input& input) const {
  if (others_.has(state)) return;
  if (input.ball)
    throw ComponentError(
        fmt::format("no ball pushes {}: {} solves each step by a matrix that it has made before, and what a ball "
                    "touches follows from the shape at the end of the step",
                    state.path(), path()),
        "forces and pulls on nodes that are named", isDynamic() ? "EulerImplicitSolver" : "StaticSolver");
  if (!leavesInside()) return;
  for (const Index node : input.nodes)
    if (const Index free = body_.nodeOf(state.firstRow() + node); free >= 0 && free < body_.interior())
      throw ComponentError(
          fmt::format("no input acts on node {} of {}: it is inside, and {} solves for the kept nodes "
                      "alone",
                      node, state.path(), path()),
          data().find("surfaceIndices")->isSet() ? "nodes that surfaceIndices keeps" : "nodes of the surface",
          "keep it (surfaceIndices), or condensed=\"false\"");
}

double CondensedIntegrator::pullStiffness(const Input& input) const {
  return input.stiffness + (isDynamic() ? input.damping / (2 * dt_) : 0);
}

bool CondensedIntegrator::findHands(const System& system) {
  hands_changed_ = false;
  hands_.clear();
  std::vector<Touch> pulls;
  if (const InputForces* inputs = system.inputs())
    inputs->forNodes([&](Index row, const Input& input, std::size_t) {
      const Index node = body_.nodeOf(row);
      if (node < 0) return;  // held: no force moves it
      hands_.push_back({node - first_active_});
      if (const double stiffness = pullStiffness(input); stiffness > 0)
        addDirections(node - first_active_, body_.projector(node), stiffness, pulls);
    });
  std::sort(hands_.begin(), hands_.end(), [](const Hand& a, const Hand& b) { return a.node < b.node; });
  hands_.erase(std::unique(hands_.begin(), hands_.end(), [](const Hand& a, const Hand& b) { return a.node == b.node; }),
               hands_.end());
  std::swap(pulls_, pulls);
  return pulls_ != pulls;
}

CondensedIntegrator::Hand& CondensedIntegrator::handOn(Index node) {
  return *std::lower_bound(hands_.begin(), hands_.end(), node,
                           [](const Hand& hand, Index wanted) { return hand.node < wanted; });
}

/// Forces and targets of now; x and v are those of the start of the step.
void CondensedIntegrator::gatherHands(const System& system) {
  for (Hand& hand : hands_) hand.force.setZero();
  std::size_t at = moved_.size();
  system.inputs()->forNodes([&](Index row, const Input& input, std::size_t i) {
    const Index node = body_.nodeOf(row);
    if (node < 0) return;
    handOn(node - first_active_).force += body_.projector(node) * input.force;
    const double stiffness = pullStiffness(input);
    if (!(stiffness > 0)) return;
    const Vec3& reference = body_.reference()[row];
    Vec3 goal = input.targets.empty() ? Vec3(0, 0, 0) : Vec3(input.targets[i] - reference);
    if (const double damping = stiffness - input.stiffness; damping > 0) {
      const Vec3 before = system.x[row] - reference - dt_ * system.v[row];
      goal = (input.stiffness * goal + damping * before) / stiffness;
    }
    const std::size_t end = at + std::size_t(std::lround(body_.projector(node).trace()));
    for (; at < end; ++at) wanted_[Index(at)] = touches_[at].direction.dot(goal);
  });
}

}  // namespace stroma
