// SPDX-License-Identifier: LGPL-2.1-or-later
// Of an implicit step: bodies whose inertia turns with them.
#include <algorithm>
#include <limits>

#include "components/integrators/implicit_step.h"

namespace stroma {

void ImplicitStep::startBodies() {
  bodies_.momenta(x(), v(), start_momenta_);
  if (!scheme_.has_history) std::fill(momentum_predictor.begin(), momentum_predictor.end(), Vec3::Zero());
}

/// out -= share (M(x0) - M(x)) (u - v0 - velocity_predictor), which work_ has, M that of masses that follow others along curved ways:
/// a rule that weighs F(x0, v0) with this share of the whole is of second order with the same share of M(x0), else of first.
void ImplicitStep::addMassWhereTheStepStarts(Rows out) const {
  const System& s = *system_;
  const MappingChain& chain = s.mappingChain();
  const double share = scheme_.old_weight / (scheme_.weight + scheme_.old_weight);
  for (const bool at_start : {true, false}) {
    const ConstRows x_all = chain.positions(at_start ? ConstRows(x0_) : ConstRows(s.x));
    for (Mass* mass : s.masses())
      if (mass->turns()) mass->update(x_all);
    const ConstRows p = chain.beginProduct(work_);
    const Rows all = chain.beginSum(out);
    for (const Mass* mass : s.masses())
      if (mass->state().firstRow() >= s.independentRows()) mass->addProduct(p, at_start ? -share : share, all);
    chain.finishProduct(p, 0, all, out);
  }
}

/// That of a body in the step if its velocity stays w0.
Vec3 ImplicitStep::predictedTurn(std::size_t body, const Vec3& w0) const {
  const Vec3 turn = scheme_.drift * w0;
  return scheme_.has_history ? turn + position_predictor[bodies_.row(body)] : turn;
}

/// What the momentum of a body changes by in the step, in first order, if its velocity stays that of the start. Masses that follow
/// bodies take their share of forces by what velocities change by: a linear solve for both has this on its right side.
Vec3 ImplicitStep::turnedMomentum(std::size_t body) const {
  if (!system_->hasCurvedInertia() || !bodies_.turns(body)) return Vec3::Zero();
  const Vec3 w0 = v()[bodies_.row(body)], turn = predictedTurn(body, w0);
  return turn.cross(bodies_.times(body, x(), w0)) - bodies_.times(body, x(), turn.cross(w0));
}

/// The linear solve has found the change of momentum J dv of each body, but for turnedMomentum(); what change of velocity that is
/// follows from where the body has turned to.
void ImplicitStep::turnBodies() {
  for (std::size_t b = 0; b < bodies_.count(); ++b) {
    const Index row = bodies_.row(b);
    const Vec3 w0 = v()[row];
    Vec3 momentum = start_momenta_[b] + bodies_.times(b, x(), change_[row]);
    if (system_->hasCurvedInertia()) momentum += turnedMomentum(b);
    const Vec3 w = bodies_.solve(b, x(), predictedTurn(b, w0), scheme_.displacement, w0, momentum, w0 + change_[row]);
    bodies_.put(b, w - w0, change_);
  }
}

/// As in turnBodies(): a correction d of a body is the change J d of its momentum. Whatever torques it leaves out of balance,
/// without any the momentum is kept after each iteration.
void ImplicitStep::addTo(Rows u, double s, ConstRows d, RowRange rows) const {
  if (s == 0) return;
  std::vector<Vec3>& velocities = velocities_;
  velocities.resize(bodies_.count());
  for (std::size_t b = 0; b < velocities.size(); ++b) {
    const Index row = bodies_.row(b);
    const Vec3 w0 = v0_[row];
    velocities[b] = bodies_.corrected(b, x0_, predictedTurn(b, w0), scheme_.displacement, w0, u[row], s * d[row]);
  }
  axpy(s, rows.of(d), rows.of(u));
  for (std::size_t b = 0; b < velocities.size(); ++b) bodies_.put(b, velocities[b], u);
}

/// From the first row that d moves by more than round-off to the last one; bodies are among them, whose velocities addTo() rounds.
ImplicitStep::RowRange ImplicitStep::rowsMovedBy(ConstRows d) const {
  const double round_off = 4 * std::numeric_limits<double>::epsilon() * largest(x0_) / scheme_.displacement;
  const auto moves = [&](Index row) { return !(d[row].cwiseAbs().maxCoeff() <= round_off); };
  RowRange rows{0, d.count};
  while (rows.first < rows.end && !moves(rows.first)) ++rows.first;
  while (rows.end > rows.first && !moves(rows.end - 1)) --rows.end;
  for (std::size_t b = 0; b < bodies_.count(); ++b)
    rows = {std::min(rows.first, bodies_.row(b)), std::max(rows.end, bodies_.row(b) + 1)};
  return rows;
}

/// The momentum of each body, beside its own or what its torque makes of it in the step: those of light ones are little
/// beside the forces on others.
double ImplicitStep::residualOfParts(ConstRows residual) const {
  constexpr double round_off = 1e-15;  // of a turn [rad]
  double largest = 0;
  for (std::size_t b = 0; b < bodies_.count(); ++b) {
    const double torque = scheme_.weight * bodies_.sum(b, system_->independent(system_->f)).norm();
    const Vec3 left = bodies_.sum(b, residual);
    // a body at rest has a momentum and a torque of round-off, and nothing is large beside them
    if (!(scheme_.displacement * bodies_.inverse(b, system_->independent(system_->x), left).norm() > round_off)) continue;
    largest = std::max(largest, left.norm() / std::max(start_momenta_[b].norm(), torque));
  }
  return largest;
}

}  // namespace stroma
