// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <numeric>

#include "components/integrators/exact_tangent.h"
#include "components/integrators/solve_potential.h"
#include "components/integrators/light_bodies.h"
#include "components/integrators/newton.h"
#include "components/integrators/whole_matrix.h"
#include "framework/simulation/step_limits.h"
#include "framework/simulation/system.h"
#include "framework/simulation/system_report.h"

namespace stroma {

/// The number of fixed directions of nodes.
inline long heldDirections(const ConstraintSet& constraints) {
  const auto count = [](long sum, const NodeProjector& held) { return sum + 3 - std::lround(held.projector.trace()); };
  return std::accumulate(constraints.projectors().begin(), constraints.projectors().end(),
                         long(constraints.relations().heldDirections()), count);
}

/// Allocates the vector on first use: most steps need few of the vectors of a solver.
inline Vector& provided(Vector& vector, Index rows) {
  if (vector.count() != rows) vector.resize(rows);
  return vector;
}

/// Equilibrium of a part s of a step, f(x) - (1 - s) f0 = 0 in the free directions, with the iterate in System::x; f0 is
/// the unbalanced force at the start of the step.
class Equilibrium final : public NonlinearProblem {
 public:
  void compile(System& system) {
    system_ = &system;
    limits_.compile(system), whole_.compile(system), measure_.compile(system.motion()), bodies_.compile(system);
    lends_energy_ = !system.isConservative();
    start_.resize(system.independentRows());
    loads_.resize(system.allRows());
  }
  void begin() {
    copy(rows(), start_);
    share_ = 1;
  }
  void giveUp() { copy(start_, rows()); }
  void serialize(Archive& archive) { measure_.serialize(archive, "force_length"); }
  /// R is then that of a part of the step that started at begin().
  void setShare(double share) { share_ = share; }
  /// The present R becomes the unbalanced force at the end of a part of the step.
  void keepStartForce() { residual(provided(start_force_, start_.count())); }
  void residual(Rows out) override {
    system_->computeForce(system_->x, system_->v, system_->f);
    copy(system_->independent(system_->f), out);
    leaveOut(out);
    system_->constraints().project(out);
    bodies_.narrow(out);
  }
  LightBodies* lightBodies() override { return &bodies_; }
  /// out -= (1 - s) f0
  void leaveOut(Rows out) const {
    if (share_ < 1) axpy(share_ - 1, start_force_, out);
  }
  void projectToFree(Rows d) const override { stroma::projectToFree(*system_, d); }
  bool useDefiniteTangent(bool definite) override { return useDefiniteTangents(*system_, definite); }
  SystemMatrix& tangent() override { return whole_.of(system_->matrix().withFactors({.stiffness = -1})); }
  /// The gradient of the second part is (1 - s) f0.
  double energy() override {
    double sum = system_->potentialEnergy(system_->x) + (lends_energy_ ? solvePotential(*system_) : 0);
    if (share_ == 1) return sum;
    copy(start_, provided(product_, start_.count()));
    system_->motion().difference(rows(), product_);
    return sum + (1 - share_) * dot(start_force_, product_);
  }
  void updateNorms() override {
    if (system_->motion().turns()) measure_.take(tangent());
  }
  double sizeOf(ConstRows residual) const override { return measure_.force(residual); }
  double lengthOf(ConstRows d) const override { return measure_.way(d); }
  double loadScale() const override { return measure_.force(system_->f); }
  Rows unknowns() override { return rows(); }
  double longestStep(ConstRows d) override { return limits_.longest(d); }
  bool mayMeetBarriers() const override { return !limits_.empty(); }
  bool updatesLagged() override { return limits_.solvesAgain(); }
  bool hasRemainingMotion() override { return limits_.hasRemainingMotion(); }
  bool addPush(Rows residual) override {
    const Rows push = system_->f;
    limits_.push(push);
    const Rows of_free = system_->independent(push);
    system_->constraints().project(of_free);
    axpy(1, of_free, residual);
    return largest(of_free) > 0;
  }
  bool advanceRemainingMotion(Rows d, bool wholly) override {
    const double part = limits_.longest(d, 1, true, true);
    if (wholly && part < 1) return false;
    addTo(rows(), part, d);
    limits_.advanceRemainingMotion(part);
    return true;
  }
  bool isIntermediate() override { return limits_.isIntermediate(); }
  /// Whether something blocks the prescribed motion d, or d together with the `carried` motion; the report then
  /// says so.
  bool isBlocked(ConstRows d, bool carries, ConstRows carried, StepReport& report) {
    if (limits_.empty()) return false;
    copy(d, provided(product_, start_.count()));
    bool is_free = limits_.longest(product_, 1, true) == 1;
    if (carries) axpy(1, carried, product_);
    is_free = is_free && (!carries || limits_.longest(product_, 1, true) == 1);
    if (is_free) return false;
    report.newton_converged = false;
    report.reason = "the prescribed motion of the step moves bodies through each other at its start";
    return true;
  }
  void addTo(Rows u, double s, ConstRows d) const override { system_->motion().advance(s, d, u); }
  void unknownsChanged() override {}
  double displacementPerUnknown() const override { return 1; }
  ConstRows positions() const override { return rows(); }
  const Motion* motionOfFrames() const override { return system_->motion().turns() ? &system_->motion() : nullptr; }
  double travelled() const override {
    if (!system_->motion().turns()) return distance(rows(), start_);
    Vector way(start_.count());
    copy(start_, way);
    system_->motion().difference(rows(), way);
    return measure_.way(way);
  }
  bool isForceBalance() const override { return true; }
  double loads() override { return loadsOn(*system_, measure_, loads_); }
  RoundOff roundOff() override {
    const Index rows = start_.count();
    return positionRoundOff(*system_, measure_, provided(error_, rows), provided(product_, rows));
  }

 private:
  Rows rows() const { return system_->independent(system_->x); }
  System* system_ = nullptr;
  StepLimits limits_;
  WholeIfNeeded whole_;
  ForceMeasure measure_;
  LightBodies bodies_;
  bool lends_energy_ = false;  ///< some forces have a potential only within a solve
  Vector start_, loads_;
  Vector start_force_, error_, product_;  ///< see provided()
  double share_ = 1;
};

}  // namespace stroma
