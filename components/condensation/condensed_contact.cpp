// SPDX-License-Identifier: LGPL-2.1-or-later
// Barriers and penalties on a condensed body (BarrierContact, PenaltyContact, CollisionResponse). Their force f(u) is
// nonlinear, that of barriers changes by orders of magnitude within a step, and the body has one matrix A with the inverse C.
// With u_0 the displacement without f, a step ends where
//
//   u = u_0 + C f(u)
//
// With H = -df/du, Newton's method has u' = u_0 + C q, where q is a force on the pushed nodes only:
//
//   q = f + H (u - u'),   (I + H C) q = f + H (u - u_0)
//
// C is read from the stored inverse for the pushed nodes, and I + H C is a small dense matrix. The effect of a correction on
// the whole surface is C (q - p), one product. A step starts at the u_s of the previous step, which has no penetration.
// Iterates are
//
//   u = u_s + s (u_0 - u_s) + C p,   s and p from 0 on;  a part a of a correction: s += a (1 - s), p += a (q - p)
//
// and every correction goes as far as the path of the surface is free (StepLimits). Until s is 1 there is no line search,
// because moving towards u_0 applies the loads to the body. After that the energy 1/2 p.C p + E(u) decreases along the
// correction, with the slope (p - f).d; the line search accepts a part with a flatter slope. If d is not a descent direction,
// barriers use their definite tangent.
#include "components/condensation/condensed_contact.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "components/condensation/condensed_integrator.h"
#include "framework/mechanics/open_choices.h"

namespace stroma {
namespace {
constexpr int most_iterations = 200;
constexpr double balanced = 1e-9;  // |f - p| of the forces
constexpr double nothing = 1e-14;  // a correction, of the body
constexpr double tolerated = 1e-6;  // |f - p| where no correction leads down
}  // namespace

void CondensedIntegrator::compileContact(System& system) {
  CondensedContact& c = contact_;
  c.fields = body_.contacts();
  if (!hasContact()) return;
  if (hasConditions())
    throw ComponentError(
        fmt::format(
            "{} pushes by forces that follow from gaps, and {} by forces of constraint: {} finds either, not both",
            c.fields.front()->path(), dynamic_cast<const Component&>(*conditions_.constraints.front()).path(), type()),
        "contact by constraint forces together with other constraints", "<ConstraintContact/> in its place");
  c.limits.compile(system);
  for (Array<double>* vector : {&c.now, &c.goal, &c.way, &c.from, &c.still}) vector->assign(padded(), 0.0);
  c.force.resize(system.allRows()), c.rows.resize(system.independentRows());
  clear(c.rows);
  c.place.assign(std::size_t(system.allRows()), -1);
  c.revisions.clear(), c.touched.clear();
}

/// x of the surface, and the forces of barriers there.
void CondensedIntegrator::pushAt(System& system, const Array<double>& u) {
  CondensedContact& c = contact_;
  if (c.is_at_start) copy(conditions_.start, system.x);  // to the bit: barriers know by that
  for (Index node = 0; node < active_ && !c.is_at_start; ++node)
    system.x[activeRow(node)] =
        Eigen::Map<const Vec3>(origin_.data() + 3 * node) + Eigen::Map<const Vec3>(u.data() + 3 * node);
  clear(c.force);
  for (ForceField* field : c.fields) field->addForce(system.x, system.v, c.force);
}

/// H where the last forces are, on all rows.
void CondensedIntegrator::assembleContact(const System& system) {
  CondensedContact& c = contact_;
  std::vector<long> revisions;
  for (const ForceField* field : c.fields) revisions.push_back(field->patternRevision());
  if (revisions != c.revisions || c.stiffness.rows() != system.allRows()) {
    BlockPattern pattern(system.allRows());
    for (const ForceField* field : c.fields) field->addPattern(pattern);
    c.stiffness = BlockMatrix(std::move(pattern));
    for (ForceField* field : c.fields) field->prepareAssembly(c.stiffness);
    c.revisions = std::move(revisions);
  }
  c.stiffness.clear();
  for (const ForceField* field : c.fields) field->addStiffness(-1, c.stiffness);
}

/// Rows that are pushed get slots. Empty, or what is wrong with them.
std::string CondensedIntegrator::findTouched(const System& system) {
  CondensedContact& c = contact_;
  CondensedConditions& slots = conditions_;
  for (const Index row : c.touched) c.place[std::size_t(row)] = -1;
  c.touched.clear();
  const std::size_t known = slots.nodes.size();
  const auto& start = c.stiffness.rowStart();
  const double* values = c.stiffness.values().data();
  for (Index row = 0; row < system.independentRows(); ++row) {
    const bool acts = !Vec3(c.force[row]).isZero(0) ||
                      std::any_of(values + 9 * std::size_t(start[row]), values + 9 * std::size_t(start[row + 1]),
                                  [](double value) { return value != 0; });
    const Index free_node = acts ? body_.nodeOf(row) : -1, node = free_node - first_active_;
    if (free_node < 0) continue;  // nothing acts, or it is held
    if (node < 0)
      return fmt::format("{} pushes {}, which is inside: {} only solves for the kept nodes", c.fields.front()->path(),
                         system.actors().describeRow(row), path());
    c.place[std::size_t(row)] = Index(c.touched.size());
    c.touched.push_back(row);
    if (slots.slot[node] < 0) slots.slot[node] = Index(slots.nodes.size()), slots.nodes.push_back(node);
  }
  if (slots.nodes.size() > known) readCompliance(known);
  const auto count = Eigen::Index(3 * slots.nodes.size());
  if (slots.c.rows() != count || c.push.size() != count) {
    prepareSlots(system, c.goal.data());
    c.push.conservativeResizeLike(Eigen::VectorXd::Zero(count));
  }
  return {};
}

/// q, and how far f is from p.
void CondensedIntegrator::findPush() {
  CondensedContact& c = contact_;
  const CondensedConditions& slots = conditions_;
  const auto count = Eigen::Index(c.touched.size());
  const auto nodeOf = [&](Eigen::Index i) { return body_.nodeOf(c.touched[std::size_t(i)]) - first_active_; };
  const auto slotOf = [&](Eigen::Index i) { return 3 * slots.slot[nodeOf(i)]; };
  c.compliance.resize(3 * count, 3 * count), c.right.resize(3 * count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < count; ++j)
      c.compliance.block<3, 3>(3 * i, 3 * j) = slots.c.block<3, 3>(slotOf(i), slotOf(j));
  c.matrix.setIdentity(3 * count, 3 * count);
  c.next_push.setZero(c.push.size());
  for (Eigen::Index i = 0; i < count; ++i) {
    const Index row = c.touched[std::size_t(i)];
    const Mat3 own = body_.projector(body_.nodeOf(row));
    Vec3 sum = own * c.force[row];
    c.next_push.segment<3>(slotOf(i)) = sum;
    for (Index s = c.stiffness.rowStart()[row]; s < c.stiffness.rowStart()[row + 1]; ++s) {
      const Index j = c.place[std::size_t(c.stiffness.columns()[s])];
      if (j < 0) continue;
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(c.stiffness.values().data() +
                                                                                 std::size_t(s) * 9);
      const Mat3 h = own * block * body_.projector(body_.nodeOf(c.touched[std::size_t(j)]));
      const Index other = 3 * nodeOf(j);
      sum += h * (Eigen::Map<const Vec3>(c.now.data() + other) - Eigen::Map<const Vec3>(c.goal.data() + other));
      c.matrix.middleRows<3>(3 * i).noalias() += h * c.compliance.middleRows<3>(3 * j);
    }
    c.right.segment<3>(3 * i) = sum;
  }
  const double size = std::max(c.next_push.norm(), c.push.norm());
  c.residual = size > 0 ? (c.next_push - c.push).norm() / size : 0;
  if (c.residual <= balanced && c.part == 1) return;
  c.next_push.setZero();
  if (count == 0) return;
  c.factor.compute(c.matrix);
  c.right = c.factor.solve(c.right);
  for (Eigen::Index i = 0; i < count; ++i) c.next_push.segment<3>(slotOf(i)) = c.right.segment<3>(3 * i);
}

/// d of the whole surface; reaction_ becomes that of all of it.
void CondensedIntegrator::findWay() {
  CondensedContact& c = contact_;
  CondensedConditions& slots = conditions_;
  for (std::size_t i = 0; i < c.way.size(); ++i) c.way[i] = (1 - c.part) * (c.goal[i] - c.still[i]);
  slots.force = c.next_push - c.push;
  addForces(c.way);
}

/// (p - f).d where the last forces are, p on the way by `part` of the correction.
double CondensedIntegrator::slopeOnWay(double part) const {
  const CondensedContact& c = contact_;
  const CondensedConditions& slots = conditions_;
  double sum = 0;
  for (std::size_t s = 0; s < slots.nodes.size(); ++s) {
    const auto at = 3 * Eigen::Index(s);
    const Vec3 push = c.push.segment<3>(at) + part * (c.next_push.segment<3>(at) - c.push.segment<3>(at));
    sum += push.dot(Eigen::Map<const Vec3>(c.way.data() + 3 * slots.nodes[s]));
  }
  for (Index node = 0; node < active_; ++node)
    sum -= c.force[activeRow(node)].dot(Eigen::Map<const Vec3>(c.way.data() + 3 * node));
  return sum;
}

void CondensedIntegrator::goOnWay(System& system, double part) {
  CondensedContact& c = contact_;
  c.is_at_start = c.is_at_start && part == 0;
  for (std::size_t i = 0; i < c.now.size(); ++i) c.now[i] = c.from[i] + part * c.way[i];
  pushAt(system, c.now);
}

/// Goes a part of the correction, at most `longest`; returns it.
double CondensedIntegrator::searchWay(System& system, double slope, double longest) {
  constexpr int most = 40;
  constexpr double enough = 0.5, edge = 0.1;
  double low = 0, high = longest, at_low = slope, at = longest;
  for (int i = 0; i < most; ++i) {
    goOnWay(system, at);
    const double now = slopeOnWay(at);
    if (std::abs(now) <= enough * std::abs(slope) || (now < 0 && at == longest)) return at;
    double share = 0.5;
    if (now < 0)
      low = at, at_low = now;
    else
      high = at, share = std::isfinite(now) ? at_low / (at_low - now) : 0.5;
    at = low + std::clamp(share, edge, 1 - edge) * (high - low);
  }
  goOnWay(system, at);
  return at;
}

/// One correction. False: it is the last one.
bool CondensedIntegrator::correctContact(System& system, StepReport& report) {
  CondensedContact& c = contact_;
  double slope = 0;
  const Eigen::VectorXd reaction = reaction_;
  for (const bool definite : {false, true}) {
    if (definite) {
      for (ForceField* field : c.fields)
        if (auto* choices = dynamic_cast<OpenChoices*>(field)) choices->useDefiniteTangent(true);
      pushAt(system, c.now);
      for (ForceField* field : c.fields)
        if (auto* choices = dynamic_cast<OpenChoices*>(field)) choices->useDefiniteTangent(false);
    }
    assembleContact(system);
    if (report.reason = findTouched(system); !report.reason.empty()) return false;
    findPush();
    if (c.part == 1 && c.residual <= balanced) return false;
    reaction_ = reaction;
    findWay();
    slope = slopeOnWay(0);
    if (c.part < 1 || slope < 0) break;
  }
  double size = 0;
  for (const double value : c.way) size = std::max(size, std::abs(value));
  if (!std::isfinite(size)) return report.reason = "the forces of contact are not finite", false;
  const bool is_round_off = size <= nothing * conditions_.extent;
  if (c.part == 1 && (is_round_off || !(slope < 0))) {
    reaction_ = reaction;
    if (is_round_off) c.residual = std::min(c.residual, balanced);
    return false;
  }
  for (Index node = 0; node < active_; ++node)
    c.rows[activeRow(node)] = Eigen::Map<const Vec3>(c.way.data() + 3 * node);
  const double longest = c.limits.longest(c.rows);
  std::copy(c.now.begin(), c.now.end(), c.from.begin());
  double part = longest;
  if (c.part < 1)
    goOnWay(system, longest);
  else
    part = searchWay(system, slope, longest);
  c.part = part == 1 ? 1 : c.part + part * (1 - c.part);
  c.push += part * (c.next_push - c.push);
  if (reaction.size() > 0) reaction_ = reaction + part * (reaction_ - reaction);
  return true;
}

bool CondensedIntegrator::holdContact(System& system, Array<double>& u, StopToken stop, StepReport& report) {
  if (!hasContact()) return true;
  CondensedContact& c = contact_;
  const ConstRows start = conditions_.start;
  std::copy(u.begin(), u.end(), c.goal.begin());
  for (Index node = 0; node < active_; ++node)
    Eigen::Map<Vec3>(c.still.data() + 3 * node) =
        start[activeRow(node)] - Eigen::Map<const Vec3>(origin_.data() + 3 * node);
  std::copy(c.still.begin(), c.still.end(), c.now.begin());
  c.part = 0, c.push.setZero(0), c.is_at_start = true;
  c.limits.advanceRemainingMotion();
  do {
    pushAt(system, c.now);
    int iteration = 0;
    while (iteration < most_iterations && !(report.stopped = stop.isStopAsked()) && correctContact(system, report))
      ++iteration;
    report.newton_iterations += iteration;
    report.newton_converged = report.reason.empty() && c.part == 1 && iteration < most_iterations && c.residual <= tolerated;
  } while (report.newton_converged && !report.stopped && c.limits.moveOn());
  report.newton_residual = c.residual;
  if (report.stopped || !report.reason.empty() || c.part < 1) {
    if (report.reason.empty() && !report.stopped)
      report.reason =
          fmt::format("{} has gone {:.2g} of the way of its loads and motions in {} iterations: something is in its way",
                      path(), c.part, most_iterations);
    report.diverged = !report.stopped;
    copy(conditions_.start, system.x);
    return false;
  }
  if (!report.newton_converged)
    report.reason = fmt::format("the contact forces on {} have a relative error of {:.2g} after {} iterations",
                                path(), c.residual, most_iterations);
  std::copy(c.now.begin(), c.now.end(), u.begin());
  return true;
}

}  // namespace stroma
