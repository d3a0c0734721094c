// SPDX-License-Identifier: LGPL-2.1-or-later
// Lagrangian constraints on a condensed body: contact, joints, cables. With u_0 the displacement without the forces l,
//
//   u = u_0 + C J^T l,   g(x) holds,   J = dg/dx
//
// g is linearised at x_k, g(x_k) + J (u - u_k) = g(x_k) + J (u_0 - u_k) + W l, W = J C D^T, which gives l (condition_forces.h)
// and x_k+1; x_0 is the start of the step. If rotating directions make this oscillate, iterates are mixed. D = J, the
// directions of the forces, is updated as long as nodes move by more than 1e-9 of the body, in at most 40 rounds; then it is
// fixed for the step. From then on this is Newton's method for g(x_0 + C D^T l), and rounds end when g itself holds. C is read
// from the stored inverse only for the nodes of the conditions, so that the cost of a round does not grow with the body. With
// pulled nodes, along directions E, C is C - C E (E^T C E + S)^-1 E^T C. Other bodies (other_bodies.h) are further nodes with a C of
// their own, so that the forces between the two kinds are equal and opposite, and the conditions hold for both at once.
#include "components/condensation/condensed_conditions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "components/condensation/condensed_integrator.h"
#include "framework/mechanics/condition_roles.h"
#include "framework/scene/archive.h"
#include "framework/simulation/step_limits.h"

namespace stroma {
namespace {

bool isLive(const LagrangianRows::Row& row) { return row.kind != LagrangianRows::Kind::given || row.factor != 0; }

}  // namespace

void CondensedIntegrator::compileConditions(System& system) {
  CondensedConditions& c = conditions_;
  c.constraints = system.actors().lagrangian_constraints;
  if (c.constraints.empty() && body_.contacts().empty()) return;
  c.start.resize(system.allRows());
  Vec3 low = body_.reference()[body_.row(0)], high = low;
  for (Index row = 0; row < body_.reference().count(); ++row)
    if (!others_.hasRow(row))
      low = low.cwiseMin(Vec3(body_.reference()[row])), high = high.cwiseMax(Vec3(body_.reference()[row]));
  c.extent = (high - low).norm();
  c.nodes.clear(), c.old_nodes.clear();
  c.slot.assign(std::size_t(active_ + others_.count()), -1), c.old_slot = c.slot;
  c.stored.resize(0, 0), c.old_stored.resize(0, 0);
}

/// Before touched nodes are moved. System::beginStep() tells the rest itself where it is called.
void CondensedIntegrator::beginConditions(System& system, const StepContext& context, bool is_told) {
  if (!hasConditions() && !hasContact()) return;
  copy(system.x, conditions_.start);
  conditions_.beginSlots();
  if (!is_told) tellStepBegins(system, system.x, context.t, context.t_end);
}

std::string CondensedIntegrator::findConditions(const System& system) {
  CondensedConditions& c = conditions_;
  std::swap(c.rows, c.rows_before);
  c.rows.clear();
  c.ends.clear();
  c.entries.clear();
  c.first_entry.assign(1, 0);
  for (const LagrangianConstraint* constraint : c.constraints) {
    constraint->addConditions(system.x, c.start, c.rows);
    c.ends.push_back(c.rows.rows().size());
  }
  const auto& rows = c.rows.rows();
  c.solve.sizes.assign(rows.size(), 0);
  const std::size_t known = c.nodes.size();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    double square = 0;
    for (const auto& [row, gradient] : c.rows.entriesOf(rows[i])) {
      if (others_.hasRow(row)) {
        square += addOther(row, gradient, c.first_entry.back(), isLive(rows[i]));
        continue;
      }
      const Index free_node = body_.nodeOf(row), node = free_node - first_active_;
      if (free_node < 0) continue;  // held
      if (node < 0)
        return fmt::format("{} acts on {}, which is inside: {} only solves for the kept nodes; surfaceIndices keeps others, "
                           "condensed=\"false\" keeps all",
                           nameOfCondition(i), system.actors().describeRow(row), path());
      if (c.slot[node] < 0) c.slot[node] = Index(c.nodes.size()), c.nodes.push_back(node);
      const Vec3 along = body_.projector(free_node) * gradient;
      square += along.squaredNorm();
      c.entries.push_back({c.slot[node], along});
    }
    c.solve.sizes[i] = std::sqrt(square);
    c.first_entry.push_back(c.entries.size());
  }
  if (!others_.solveColumns()) return others_.fault();
  if (c.nodes.size() > known) readCompliance(known);
  if (!others_.lastLoads().empty()) readColumns();
  return {};
}

/// Each step renumbers them, so that its sums do not depend on earlier ones. Entries of C that have been read are kept.
void CondensedConditions::beginSlots() {
  for (const Index node : old_nodes) old_slot[node] = -1;
  std::swap(nodes, old_nodes), std::swap(slot, old_slot), stored.swap(old_stored);
  nodes.clear();
}

/// Slots from `known` on are new.
void CondensedIntegrator::readCompliance(std::size_t known) {
  CondensedConditions& c = conditions_;
  const auto count = Eigen::Index(c.nodes.size());
  c.stored.conservativeResize(3 * count, 3 * count);
  for (Eigen::Index j = Eigen::Index(known); j < count; ++j)
    for (Eigen::Index i = 0; i <= j; ++i) {
      const Index a = c.nodes[std::size_t(i)], b = c.nodes[std::size_t(j)], s = c.old_slot[a], t = c.old_slot[b];
      Mat3 block = Mat3::Zero();
      if (a >= active_ || b >= active_) {
        if (a >= active_ && b >= active_) block = others_.compliance(a - active_, b - active_);
      } else if (s >= 0 && t >= 0)
        block = c.old_stored.block<3, 3>(3 * s, 3 * t);
      else
        block = a <= b ? complianceBlock(a, b) : Mat3(complianceBlock(b, a).transpose());
      c.stored.block<3, 3>(3 * i, 3 * j) = block;
      if (i != j) c.stored.block<3, 3>(3 * j, 3 * i) = block.transpose();
    }
}

/// C and displacements of the slots for this step: what touched nodes hold, and u_0.
void CondensedIntegrator::prepareSlots(const System& system, const double* u) {
  CondensedConditions& c = conditions_;
  const auto count = Eigen::Index(c.nodes.size());
  c.c = c.stored.topLeftCorner(3 * count, 3 * count);  // where there is no slot, nobody has read any, and those of before are there
  if (!touches_.empty()) {
    Eigen::MatrixXd& at = c.touched;
    at.resize(Eigen::Index(touches_.size()), 3 * count);
    at.setZero();
    for (Eigen::Index s = 0; s < count; ++s)
      if (const Index node = c.nodes[std::size_t(s)]; node < active_)
        at.middleCols<3>(3 * s) = touch_columns_.middleRows<3>(3 * node).transpose();
    if (weights_.size() > 0) at = weights_.asDiagonal() * at;
    touch_factor_.matrixL().solveInPlace(at);
    c.c.noalias() -= at.transpose() * at;
  }
  c.free.resize(3 * count), c.u.resize(3 * count);
  for (Eigen::Index s = 0; s < count; ++s) {
    const Index node = c.nodes[std::size_t(s)];
    if (const Index k = node - active_; k >= 0) {
      c.free.segment<3>(3 * s) = others_.turned(k, others_.free(k)), c.u.segment<3>(3 * s) = others_.now(k);
      continue;
    }
    c.free.segment<3>(3 * s) = Eigen::Map<const Vec3>(u + 3 * node);
    c.u.segment<3>(3 * s) = system.x[activeRow(node)] - Eigen::Map<const Vec3>(origin_.data() + 3 * node);
  }
}

/// W, and g where there are no forces.
void CondensedIntegrator::couple() {
  CondensedConditions& c = conditions_;
  const auto& rows = c.rows.rows();
  c.live.clear();
  for (std::size_t i = 0; i < rows.size(); ++i)  // nothing has to answer to a force that is given as zero
    if (isLive(rows[i])) c.live.push_back(Eigen::Index(i));
  const auto count = Eigen::Index(c.live.size());
  c.response.resize(c.c.rows(), count), c.solve.w.resize(count, count), c.solve.g.resize(Eigen::Index(rows.size()));
  for (Eigen::Index j = 0; j < c.solve.g.size(); ++j) {
    double value = rows[std::size_t(j)].value;
    for (const auto& [slot, gradient] : c.of(j, c.entries, c.first_entry))
      value += gradient.dot(c.free.segment<3>(3 * slot) - c.u.segment<3>(3 * slot));
    c.solve.g[j] = value;
  }
  for (Eigen::Index j = 0; j < count; ++j) {
    c.response.col(j).setZero();
    for (const auto& [slot, gradient] : c.of(c.live[std::size_t(j)], c.pushing, c.first_pushing))
      if (!gradient.isZero(0)) c.response.col(j).noalias() += c.c.middleCols<3>(3 * slot) * gradient;
  }
  for (Eigen::Index j = 0; j < count; ++j)
    for (Eigen::Index i = 0; i < count; ++i) {
      double sum = 0;
      for (const auto& [slot, gradient] : c.of(c.live[std::size_t(i)], c.entries, c.first_entry))
        sum += gradient.dot(c.response.col(j).segment<3>(3 * slot));
      c.solve.w(i, j) = sum;
    }
}

/// u of the slots from l; by how much it has changed at most.
double CondensedIntegrator::respond() {
  CondensedConditions& c = conditions_;
  c.force.setZero(c.c.rows());
  for (std::size_t i = 0; i < c.rows.rows().size(); ++i)
    for (const auto& [slot, gradient] : c.of(Eigen::Index(i), c.pushing, c.first_pushing))
      c.force.segment<3>(3 * slot) += c.solve.l[Eigen::Index(i)] * gradient;
  Eigen::VectorXd& next = c.next;
  next = c.free;
  next.noalias() += c.c * c.force;
  for (std::size_t s = 0; s < c.nodes.size() && !others_.empty(); ++s) {
    const Index k = c.nodes[s] - active_;
    if (k < 0 || Eigen::Index(3 * s) >= next.size()) continue;
    auto there = next.segment<3>(3 * Eigen::Index(s)), free = c.free.segment<3>(3 * Eigen::Index(s));
    const Vec3 linear = there - free + others_.free(k), turned = others_.turned(k, linear);
    there = turned, free = others_.free(k) + turned - linear;
  }
  const double change = (next - c.u).size() > 0 ? (next - c.u).cwiseAbs().maxCoeff() : 0;
  c.u.swap(next);
  c.before.swap(next);
  return change;
}

/// Positions at the u of the slots.
void CondensedIntegrator::placeSlots(System& system) {
  const CondensedConditions& c = conditions_;
  for (std::size_t s = 0; s < c.nodes.size(); ++s) {
    const Index node = c.nodes[s];
    if (node >= active_)
      others_.place(system, node - active_, c.u.segment<3>(3 * Eigen::Index(s)));
    else
      system.x[activeRow(node)] =
          Eigen::Map<const Vec3>(origin_.data() + 3 * node) + c.u.segment<3>(3 * Eigen::Index(s));
  }
  if (!others_.empty()) others_.placeMapped(system);
}

bool CondensedIntegrator::holdConditions(System& system, Array<double>& u, StopToken stop, StepReport& report) {
  constexpr int most_rounds = 60, most_turns = 40, most_changes = 100;
  constexpr double close = 1e-13, directed = 1e-9, still = 1e-6;  // of the place, of the body
  if (!hasConditions()) return true;
  CondensedConditions& c = conditions_;
  const double size = largest(c.start);
  double step = 0, last = 0;
  bool turns = true, is_mixed = false;
  int changes = 0;
  c.mixing.restart();
  c.swings = c.is_changing = false;
  for (int round = 0; round <= most_rounds; ++round) {
    if (report.reason = findConditions(system); !report.reason.empty()) break;
    // the last round finds what the conditions have become
    const bool stays = round > 0 && !others_.turns() && c.rows.hasGradientsOf(c.rows_before);
    if (stays) step = 0;
    const bool is_last = round == most_rounds;
    if (is_last || (round > 0 && !(step > close * size))) {
      if (!changeConditions(system)) break;
      if (c.is_changing = is_last || ++changes == most_changes; c.is_changing) break;
      turns = true, is_mixed = false, round = 1, c.mixing.restart();
      if (report.reason = findConditions(system); !report.reason.empty()) break;
    }
    if (round == most_turns) c.swings = turns && step > still * c.extent;
    turns = turns && (round < 2 || step > directed * c.extent) && round < most_turns;
    if (turns || c.first_pushing != c.first_entry)
      c.pushing = c.entries, c.first_pushing = c.first_entry;
    if (round == 0 || Eigen::Index(3 * c.nodes.size()) != c.c.rows()) prepareSlots(system, u.data());
    couple();
    if (round == 0 || std::size_t(c.solve.l.size()) != c.rows.rows().size()) {
      c.solve.contradiction = 0;
      c.solve.l.setZero(Eigen::Index(c.rows.rows().size()));
      if (c.taken.size() == c.rows.rows().size()) c.solve.l = Eigen::Map<Eigen::VectorXd>(c.taken.data(), c.solve.l.size());
    }
    findTolerances(c.constraints, c.ends, false, c.allowed);
    c.solve.solve(c.rows.rows(), stop, c.allowed);
    report.stopped = stop.isStopAsked();
    if (report.stopped) break;
    last = step;
    step = respond();
    if (!std::isfinite(step)) report.reason = "the forces of Lagrangian constraints are not finite";
    is_mixed = is_mixed || (round > 3 && step > 0.5 * last);
    if (is_mixed && turns && step > directed * c.extent) c.mix();
    placeSlots(system);
    if (!report.reason.empty()) break;
  }
  report.stopped = report.stopped || others_.wasStopped();
  if (report.stopped || !report.reason.empty()) {
    report.diverged = !report.stopped;
    copy(c.start, system.x);
    return false;
  }
  giveForces();
  judgeConditions(system, step, size, report);
  addForces(u);
  return true;
}

/// Which conditions there are may depend on the forces that have been found.
bool CondensedIntegrator::changeConditions(const System& system) {
  CondensedConditions& c = conditions_;
  std::vector<double> answers(c.rows.rows().size(), 0);
  for (std::size_t i = 0; i < c.live.size(); ++i) answers[std::size_t(c.live[i])] = c.solve.w(Eigen::Index(i), Eigen::Index(i));
  return ChangesConditions::changeAny(c.constraints, c.ends, system.x, c.solve.l.data(), answers.data());
}

void CondensedConditions::mix() {
  const auto bytes = std::size_t(u.size()) * sizeof(double);
  const Index whole_rows = Index((u.size() + row_doubles - 1) / row_doubles);
  if (from.count() != whole_rows) from.resize(whole_rows), to.resize(whole_rows), mixing.restart();
  std::memcpy(from.rows().data, before.data(), bytes);
  std::memcpy(to.rows().data, u.data(), bytes);
  mixing.next(from, to);
  std::memcpy(u.data(), to.rows().data, bytes);
}

/// To the constraints.
void CondensedIntegrator::giveForces() {
  CondensedConditions& c = conditions_;
  c.solve.l.conservativeResizeLike(Eigen::VectorXd::Zero(Eigen::Index(c.rows.rows().size())));
  std::size_t begin = 0;
  for (std::size_t i = 0; i < c.constraints.size(); begin = c.ends[i++])
    c.constraints[i]->takeForces({c.solve.l.data() + begin, c.ends[i] - begin});
}

/// u of all active nodes, and the reactions of those that are touched.
void CondensedIntegrator::addForces(Array<double>& u) {
  CondensedConditions& c = conditions_;
  c.loaded.clear(), c.loads.clear();
  std::fill(c.others.begin(), c.others.end(), Vec3::Zero());
  for (std::size_t s = 0; s < c.nodes.size() && Eigen::Index(3 * s) < c.force.size(); ++s) {
    const Vec3 force = c.force.segment<3>(3 * Eigen::Index(s));
    if (force.isZero(0)) continue;
    if (const Index k = c.nodes[s] - active_; k >= 0) {
      c.others[std::size_t(k)] = force;
      continue;
    }
    c.loaded.push_back(c.nodes[s]);
    c.loads.push_back({force[0], force[1], force[2]});
  }
  if (c.loaded.empty()) return;
  if (!touches_.empty()) {
    Eigen::VectorXd& reaction = c.reaction;
    reaction.setZero(Eigen::Index(touches_.size()));
    for (std::size_t k = 0; k < c.loaded.size(); ++k)
      reaction.noalias() -=
          touch_columns_.middleRows<3>(3 * c.loaded[k]).transpose() * Eigen::Map<const Vec3>(c.loads[k].data());
    if (weights_.size() > 0) reaction.array() *= weights_.array();
    touch_factor_.solveInPlace(reaction);
    if (weights_.size() > 0) reaction.array() *= weights_.array();
    Eigen::Map<Eigen::VectorXd>(u.data(), Eigen::Index(u.size())).noalias() += touch_columns_ * reaction;
    reaction_ += reaction;
  }
  addResponse(c.loaded, c.loads, u.data());
}

/// The constraint that a row is of.
std::string CondensedIntegrator::nameOfCondition(std::size_t row) const {
  const auto end = std::upper_bound(conditions_.ends.begin(), conditions_.ends.end(), row);
  return dynamic_cast<const Component&>(*conditions_.constraints[std::size_t(end - conditions_.ends.begin())]).path();
}

/// " (node 3 of /a/dofs, node 4 of /b/dofs)"
std::string CondensedIntegrator::nodesOfCondition(const System& system, std::size_t row) const {
  constexpr std::size_t most = 4;
  std::string nodes;
  const auto entries = conditions_.rows.entriesOf(conditions_.rows.rows()[row]);
  for (std::size_t i = 0; i < std::min(most, entries.size()); ++i)
    nodes += (i == 0 ? " (" : ", ") + system.actors().describeRow(entries[i].row);
  return nodes.empty() ? nodes : nodes + (entries.size() > most ? " and others)" : ")");
}

/// What has not come to rest and what does not hold, at the end of the step.
void CondensedIntegrator::judgeConditions(const System& system, double step, double size, StepReport& report) {
  // of the body: conditions and, less, what directions of forces still move it by; of the place
  constexpr double exact = 1e-9, still = 1e-6, rounding = 1e-13;
  CondensedConditions& c = conditions_;
  bool is_kept = true;
  const auto refuse = [&](std::string reason) {
    report.constraints_converged = is_kept;
    report.constraint_reason = std::move(reason);
  };
  if (c.rows.rows().empty()) return;
  if (c.is_changing) {
    is_kept = false;
    return refuse(fmt::format("the conditions that {} finds forces for still change by these forces where its rounds end, as of a "
                              "point that goes to and fro over corners of its curve. A smaller dt helps",
                              path()));
  }
  const double held = exact * c.extent + rounding * size;
  ConditionForces::Violation worst;
  for (const bool kept : {true, false}) {  // what is beyond all, or beyond what holds
    findTolerances(c.constraints, c.ends, kept, c.allowed);
    if (is_kept) worst = c.solve.worst(c.rows.rows(), c.allowed), is_kept = !kept || worst.off <= held;
  }
  if (!(worst.off <= held)) {
    const std::string name = nameOfCondition(worst.row), nodes = nodesOfCondition(system, worst.row);
    if (worst.rubs)
      return refuse(fmt::format("the friction of {} is not Coulomb's: a slide is off by {:.3g} m{}", name, worst.off, nodes));
    const auto entries = c.rows.entriesOf(c.rows.rows()[worst.row]);
    if (std::all_of(entries.begin(), entries.end(), [](const auto& entry) { return entry.gradient.isZero(0); }))
      return refuse(fmt::format("the Lagrangian constraint {} does not hold and no force mends it: the step goes farther than what "
                                "it can prove to be free{}. A smaller dt helps, or larger gaps",
                                name, nodes));
    return refuse(fmt::format("the Lagrangian constraint {} does not hold: a condition is off by {:.3g}{}", name,
                              std::abs(c.rows.rows()[worst.row].value), nodes));
  }
  if (!(step <= still * c.extent + rounding * size)) {
    is_kept = false;
    refuse(fmt::format("the forces of Lagrangian constraints that {} finds still move bodies by {:.2g} of their "
                       "size when their rounds end",
                       path(), step / c.extent));
  }
}

}  // namespace stroma
