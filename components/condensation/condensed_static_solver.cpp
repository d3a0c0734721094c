// SPDX-License-Identifier: LGPL-2.1-or-later
// CondensedStaticSolver: the equilibrium of a linear body by a precomputed inverse, using only the columns of loaded nodes
// (Bro-Nielsen and Cotin 1996: CS; with condensed="false" FS).
//
// With K = -df/dx constant, f the loads at the initial positions, s the kept nodes (the surface) and i those inside:
//
//   K*_ss = K_ss - K_si K_ii^-1 K_is,   f*_s = f_s - K_si K_ii^-1 f_i,   u_s = K*_ss^-1 f*_s
//   u_i = K_ii^-1 (f_i - K_is u_s), when somebody reads it
//
// Fixed nodes are left out of K. The interior is eliminated by a sparse Cholesky factorisation and K*_ss^-1 computed from the
// remaining dense factor; the interior then costs nothing in a step. Constant loads are multiplied once. For changing loads,
// u_s = sum over the loaded nodes j of column_j f_j: three columns for each loaded node (selective product), or, if fewer
// nodes have changed than are loaded, for each changed one, added to the last u_s. After 256 such steps u_s is recomputed, so
// that round-off does not accumulate.
//
// A node that a constraint moves (LinearMovementProjectiveConstraint) is an unknown load: with E its directions and d its
// displacement, lambda = (E^T C E)^-1 (d - E^T C f). lambda is the force of the motion [N]: dragForces, for draggedNodes.
//
// Inputs (pulling by hand) act on kept nodes; with condensed="false" on every node. Lagrangian constraints and contacts of
// ConstraintContact hold on the same nodes, by forces that the entries of K*_ss^-1 at these nodes give. So do barriers
// (BarrierContact) and penalties, by Newton's method on the nodes that they push (condensed_contact.cpp).
//
// Pressure on a surface is a dead load on the rest shape. Everything is valid for small rotations and strains only; a warning
// is printed at the end of runs that exceed rotationBound or strainBound on the surface. This is checked at the end, at every
// record of the displacements, and on a 64th of the surface in other steps. Velocities are zero except for nodes with a
// prescribed motion. The time step does not matter.
//
// Example:
// <Node name="root" dt="0.02" gravity="0 0 0">
//   <CondensedStaticSolver/>
//   <RegularGridTopology n="3 3 5" min="0 0 0" max="0.1 0.1 0.2"/>
//   <MechanicalObject/>
//   <HexahedronFEMForceField youngModulus="5000" poissonRatio="0.4" method="small"/>
//   <FixedProjectiveConstraint indices="0 1 2 3 4 5 6 7 8"/>
//   <ConstantForceField indices="40" totalForce="0.01 0 0"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>

#include "components/condensation/condensed_integrator.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// Steps by differences between two that sum anew.
constexpr int longest_chain = 256;

class CondensedStaticSolver final : public CondensedIntegrator {
 public:
  void declare(DataTable& table) override {
    CondensedIntegrator::declare(table);
    table.add("incremental", incremental_).help("add only what changed in the loads since the last step");
    table.add("multipliedNodes", multiplied_).help("columns of how many nodes the last step multiplied").output();
  }
  StepReport step(System& system, const StepContext& context) override;
  bool movesInTime() const override { return false; }
  void reset() override;
  void serialize(Archive& archive) override;

 protected:
  bool isDynamic() const override { return false; }
  Form form() const override { return Form::columns; }
  std::unique_ptr<PartialCholesky> makeFactor() const override { return makePartialCholesky(); }
  void prepare(System& system) override;
  std::string stepText() const override {
    return fmt::format("{} static: K^-1 of {} nodes in {} precision, three columns for each loaded node",
                       condensed_ ? "condensed" : "full", active(), isSingle() ? "single" : "double");
  }
  void complianceOf(const Touch& touch, double* column) override;
  Mat3 complianceBlock(Index i, Index j) override;
  void addResponse(const std::vector<Index>& nodes, const std::vector<std::array<double, 3>>& forces,
                   double* u) override {
    addColumns(nodes, forces, u);
  }
  void forward(double* y) override { eliminated_.forward(y, sweep_work_.data()); }
  void backward(double* y) override { eliminated_.backward(y, sweep_work_.data()); }

 private:
  using Force = std::array<double, 3>;
  bool isHeld() const { return hasConditions() || hasContact(); }
  static bool isZero(const Force& f) { return f[0] == 0 && f[1] == 0 && f[2] == 0; }
  void addColumns(const std::vector<Index>& nodes, const std::vector<Force>& forces, double* u) const;
  double entry(Index i, Index j) const;
  void multiplyConstantLoads();
  void gatherLoads();
  void addTouches();
  void compare(Index node, const Force& now, const Force& before);
  void compareHands();
  void update();
  StepReport giveUp(System& system, const std::string& reason, bool is_stopped = false);

  bool incremental_ = true;
  int multiplied_ = 0;

  Array<double> u_, reduced_;       ///< now; of inside loads; shape (padded)
  Array<double> held_;              ///< u with forces of constraint
  std::vector<Index> candidates_;   ///< nodes that can have a load that changes
  std::vector<Force> load_, last_;  ///< on candidates, now and in u_, also when the step is not taken
  std::vector<Index> nodes_, changed_nodes_;
  std::vector<Force> forces_, changes_;  ///< those that are not zero
  std::vector<Index> place_;             ///< of an active node in candidates_, or -1
  std::vector<Index> hand_nodes_;        ///< in u_, also when the step is not taken
  std::vector<Force> hand_last_;         ///< on them
  Array<double> at_touches_;             ///< u without reactions, where touches read it
  int chain_ = longest_chain;
  bool started_ = false;
};

void CondensedStaticSolver::prepare(System& system) {
  for (Array<double>* vector : {&u_, &at_touches_, &held_}) vector->assign(padded(), 0.0);
  if (base_.empty()) multiplyConstantLoads();
  std::vector<char> can_change(std::size_t(active()), 0);
  const auto& timed = body_.timedNodes();
  const bool inside = !timed.empty() && timed.front() < firstActive();
  if (inside) {
    reduced_.assign(padded(), 0.0);
    std::fill(can_change.begin(), can_change.end(), 1);
  }
  for (const Index node : timed)
    if (node >= firstActive()) can_change[node - firstActive()] = 1;
  if (const auto* moving = body_.movingRows())
    for (Index node = 0; node < active(); ++node) can_change[node] |= (*moving)[activeRow(node)];
  place_.assign(active(), -1);
  candidates_.clear();
  for (Index node = 0; node < active(); ++node)
    if (can_change[node]) {
      place_[node] = Index(candidates_.size());
      candidates_.push_back(node);
    }
  load_.assign(candidates_.size(), Force{});
  last_ = load_;
  for (auto* list : {&nodes_, &changed_nodes_}) list->reserve(candidates_.size());
  for (auto* list : {&forces_, &changes_}) list->reserve(candidates_.size());
  clear(system.v);
}

void CondensedStaticSolver::multiplyConstantLoads() {
  base_.assign(padded(), 0.0);
  std::vector<Index> loaded;
  std::vector<Force> forces;
  for (Index node = 0; node < active(); ++node) {
    const double* f = constantForce().data() + 3 * node;
    if (f[0] == 0 && f[1] == 0 && f[2] == 0) continue;
    loaded.push_back(node);
    forces.push_back({f[0], f[1], f[2]});
  }
  addColumns(loaded, forces, base_.data());
}

void CondensedStaticSolver::addColumns(const std::vector<Index>& nodes, const std::vector<Force>& forces,
                                       double* u) const {
  const auto add = [&](const auto& panels) { panels.addColumns(nodes.data(), forces.data(), nodes.size(), u); };
  if (isSingle()) {
    add(ColumnPanels<float>{static_cast<const float*>(compliance()), std::size_t(active())});
  } else {
    add(ColumnPanels<double>{static_cast<const double*>(compliance()), std::size_t(active())});
  }
}

double CondensedStaticSolver::entry(Index i, Index j) const {
  const std::size_t row = std::size_t(i), column = std::size_t(j), count = std::size_t(active());
  return isSingle() ? ColumnPanels<float>{static_cast<const float*>(compliance()), count}.at(row, column)
                    : ColumnPanels<double>{static_cast<const double*>(compliance()), count}.at(row, column);
}

void CondensedStaticSolver::complianceOf(const Touch& touch, double* column) {
  const std::vector<Index> node{touch.node};
  const Vec3& d = touch.direction;
  Array<double> sum(padded(), 0.0);  // aligned, which the caller's column need not be
  addColumns(node, {Force{d[0], d[1], d[2]}}, sum.data());
  std::copy(sum.begin(), sum.end(), column);
}

Mat3 CondensedStaticSolver::complianceBlock(Index i, Index j) {
  Mat3 block;
  for (Index a = 0; a < 3; ++a)
    for (Index b = 0; b < 3; ++b) block(a, b) = entry(3 * i + a, 3 * j + b);
  return block;
}

/// Loads that change in time, on candidates.
void CondensedStaticSolver::gatherLoads() {
  std::fill(load_.begin(), load_.end(), Force{});
  if (body_.timedNodes().empty()) return;
  body_.updateTimedForces();
  if (!reduced_.empty()) {
    reduceTimedInterior(reduced_.data());
    for (std::size_t i = 0; i < load_.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) load_[i][c] = reduced_[3 * std::size_t(candidates_[i]) + c];
  }
  for (const Index node : body_.timedNodes()) {
    if (node < firstActive()) continue;
    const Vec3 force = body_.timedForce(node);
    Force& sum = load_[place_[(node - firstActive())]];
    for (std::size_t c = 0; c < 3; ++c) sum[c] += force[Index(c)];
  }
}

/// The reactions of touched nodes as loads: u without them is needed at these nodes alone.
void CondensedStaticSolver::addTouches() {
  if (touches().empty()) return;
  for (const Touch& touch : touches())
    for (Index c = 0; c < 3; ++c) {
      const Index row = 3 * touch.node + c;
      double sum = base_[row];
      for (std::size_t k = 0; k < load_.size(); ++k) {
        const Force& f = load_[k];
        if (isZero(f)) continue;
        for (Index d = 0; d < 3; ++d) sum += entry(row, 3 * candidates_[k] + d) * f[d];
      }
      for (const Hand& hand : hands())
        for (Index d = 0; d < 3 && !hand.force.isZero(0); ++d) sum += entry(row, 3 * hand.node + d) * hand.force[d];
      at_touches_[row] = sum;
    }
  const Eigen::VectorXd& reaction = solveTouches(at_touches_.data());
  for (std::size_t k = 0; k < moved(); ++k) {
    Force& sum = load_[place_[touches()[k].node]];
    for (std::size_t c = 0; c < 3; ++c) sum[c] += reaction[Index(k)] * touches()[k].direction[Index(c)];
  }
  for (std::size_t k = moved(); k < touches().size(); ++k)
    handOn(touches()[k].node).force += reaction[Index(k)] * touches()[k].direction;
}

void CondensedStaticSolver::compare(Index node, const Force& now, const Force& before) {
  if (!isZero(now)) {
    nodes_.push_back(node);
    forces_.push_back(now);
  }
  if (now == before) return;
  changed_nodes_.push_back(node);
  changes_.push_back({now[0] - before[0], now[1] - before[1], now[2] - before[2]});
}

/// Hands on other nodes than before: everything is summed anew, so that one that has gone leaves nothing behind.
void CondensedStaticSolver::compareHands() {
  if (hands().empty() && hand_nodes_.empty()) return;
  const auto is_on = [](const Hand& hand, Index node) { return hand.node == node; };
  if (!std::equal(hands().begin(), hands().end(), hand_nodes_.begin(), hand_nodes_.end(), is_on)) {
    started_ = false;
    hand_nodes_.clear();
    for (const Hand& hand : hands()) hand_nodes_.push_back(hand.node);
    hand_last_.assign(hand_nodes_.size(), Force{});
  }
  for (std::size_t i = 0; i < hand_nodes_.size(); ++i) {
    const Vec3& force = hands()[i].force;
    const Force now{force[0], force[1], force[2]};
    compare(hand_nodes_[i], now, hand_last_[i]);
    hand_last_[i] = now;
  }
}

/// u_ follows load_ and the hands by the shorter of two lists: what is loaded, or what has changed.
void CondensedStaticSolver::update() {
  nodes_.clear();
  forces_.clear();
  changed_nodes_.clear();
  changes_.clear();
  for (std::size_t i = 0; i < load_.size(); ++i) compare(candidates_[i], load_[i], last_[i]);
  last_ = load_;
  compareHands();
  if (started_ && changed_nodes_.empty()) {
    multiplied_ = 0;
    return;
  }
  if (started_ && incremental_ && changed_nodes_.size() < nodes_.size() && chain_ < longest_chain) {
    addColumns(changed_nodes_, changes_, u_.data());
    ++chain_;
    multiplied_ = int(changed_nodes_.size());
    return;
  }
  std::copy(base_.begin(), base_.end(), u_.begin());
  addColumns(nodes_, forces_, u_.data());
  chain_ = 0;
  started_ = true;
  multiplied_ = int(nodes_.size());
}

StepReport CondensedStaticSolver::step(System& system, const StepContext& context) {
  moveTouched(system, context);
  if (!touchFault().empty()) return giveUp(system, touchFault(), context.stop.isStopAsked());
  gatherLoads();
  addTouches();
  update();
  StepReport report;
  if (isHeld()) {
    std::copy(u_.begin(), u_.end(), held_.begin());
    if (!holdConditions(system, held_, context.stop, report) || !holdContact(system, held_, context.stop, report))
      return giveUp(system, report.reason, report.stopped);
  }
  if (writeActive(system, isHeld() ? held_.data() : u_.data(), nullptr)) {
    finish(system);
    others().addTo(report);
    return report;
  }
  return giveUp(system, "a load is not finite, or the body has left the range of numbers");
}

StepReport CondensedStaticSolver::giveUp(System& system, const std::string& reason, bool is_stopped) {
  restoreTouched(system);
  started_ = false;
  StepReport report = failure(reason);
  report.diverged = !is_stopped, report.stopped = is_stopped;
  return report;
}

void CondensedStaticSolver::serialize(Archive& archive) {
  CondensedIntegrator::serialize(archive);
  archive.value("started", started_);
  archive.value("chain", chain_);
  archive.rows("displacement", u_.data(), u_.size());
  archive.list("loads", last_);
  archive.list("hand nodes", hand_nodes_);
  archive.list("hand loads", hand_last_);
}

void CondensedStaticSolver::reset() {
  CondensedIntegrator::reset();
  started_ = false;
  chain_ = longest_chain;
  hand_nodes_.clear(), hand_last_.clear();
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(condensed_static_solver) {
  factory.add<stroma::CondensedStaticSolver>("CondensedStaticSolver",
                                             "linear statics by an inverse of the surface computed beforehand");
}
