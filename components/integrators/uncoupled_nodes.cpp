// SPDX-License-Identifier: LGPL-2.1-or-later
// What UncoupledConstraintCorrection computes; uncoupled_constraint_correction.cpp says it.
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <utility>

#include "components/integrators/uncoupled_constraint_correction.h"
#include "framework/mechanics/frames.h"
#include "framework/scene/node.h"

namespace stroma {

void UncoupledConstraintCorrection::declare(DataTable& table) {
  table.addLink("mstate", mstate_).help("state that it moves; the one of this node by default");
  table.add("compliance", compliance_).help("of each node, one for all, or 7 numbers for all frames").unit("1/kg");
  table.add("defaultCompliance", default_compliance_).help("of all nodes without one").unit("1/kg").min(0, false);
  table.add("useOdeSolverIntegrationFactors", by_rule_)
      .alias("useIntegrationSchemeIntegrationFactors")
      .help("positions and velocities change by the rule of the integrator; without, as in SOFA with factors of their own, a warning");
  for (const char* name : {"correctionVelocityFactor", "correctionPositionFactor", "odeSolver", "verbose", "topology"})
    table.addVisualOnly(name);
}

void UncoupledConstraintCorrection::init() {
  state_ = mstate_.get() ? mstate_.get() : find<State>(false);
  if (!state_) throw ComponentError("there is no state that it could move", "a MechanicalObject in the same node, or mstate=\"@path\"");
  state_->ensureReady();
  const auto nodes = std::size_t(state_->nodes());
  each_.clear();
  if (!by_rule_)
    warn("useOdeSolverIntegrationFactors=\"false\" has no effect: positions and velocities change by the rule of the integrator", "true");
  const bool has_default = data().find("defaultCompliance")->isSet(), has_frames = state_->hasFrames();
  const bool is_of_all = compliance_.size() == (has_frames ? 7 : nodes);
  if (has_default && is_of_all && !compliance_.empty()) warn("defaultCompliance has no effect: compliance is given", "one of the two");
  if (has_default && compliance_.size() == 1 && !is_of_all && compliance_[0] != default_compliance_)
    warn("compliance has no effect: defaultCompliance is given", "one of the two");
  if (has_frames) {
    if (is_of_all) each_ = compliance_;
    if (!is_of_all && has_default) each_ = {default_compliance_, 1, 0, 0, 1, 0, 1};
    if (!is_of_all && !compliance_.empty())
      warn(fmt::format("compliance has {} numbers and no effect: that of frames has 7", compliance_.size()),
           "that of places, and the upper half of that of turns");
    return;
  }
  each_.assign(nodes, compliance_.empty() || has_default ? default_compliance_ : compliance_[0]);
  if (compliance_.size() == nodes) each_ = compliance_;
  if (compliance_.size() > 1 && compliance_.size() != nodes)
    warn(fmt::format("compliance has {} values for {} nodes: all take {:g}", compliance_.size(), nodes, each_.empty() ? 0 : each_[0]),
         "one for each node");
}

void UncoupledConstraintCorrection::tellIdle(const Component& integrator, const std::string& why) {
  std::vector<UncoupledConstraintCorrection*> all;
  integrator.node().root().collect(all);
  for (UncoupledConstraintCorrection* each : all)
    if (std::exchange(each->idle_, why) != why)
      each->warn(fmt::format("has no effect: {} {}, and forces of constraint are found with its matrix", integrator.path(), why),
                 "EulerImplicitSolver with newtonIterations=\"1\", or no correction");
}

void UncoupledConstraintCorrection::takeMasses(const System& system) {
  if (!state_->hasFrames()) return;
  const auto follows = [&](const Mass* mass) { return mass->state().firstRow() >= system.independentRows(); };
  if (each_.empty() && std::any_of(system.masses().begin(), system.masses().end(), follows)) return takeWhole(system);
  const auto rows = std::size_t(state_->size());
  inverses_.assign(rows, Mat3::Zero());
  if (each_.empty()) {
    for (const Mass* mass : system.masses())
      if (&mass->state() == state_) addMass(*mass);
    for (Mat3& block : inverses_) block = block.determinant() > 0 ? Mat3(block.inverse()) : Mat3(Mat3::Zero());
    return;
  }
  Mat3 turn;
  turn << each_[1], each_[2], each_[3], each_[2], each_[4], each_[5], each_[3], each_[5], each_[6];
  for (std::size_t row = 0; row < rows; ++row) inverses_[row] = row % 2 == 0 ? Mat3(each_[0] * Mat3::Identity()) : turn;
}

void UncoupledConstraintCorrection::addMass(const Mass& mass) {
  std::vector<Mat3> tensors(inverses_.size());
  for (std::size_t row = 0; row < tensors.size(); ++row) tensors[row] = mass.lumped()[row] * Mat3::Identity();
  for (const TurningInertia& one : mass.turningInertias()) {
    const Mat3 turn = one.turns ? orientationIn(state_->x(), one.row).toRotationMatrix() : Mat3(Mat3::Identity());
    tensors[std::size_t(one.row)] = turn * one.inertia * turn.transpose();
  }
  for (std::size_t row = 0; row < tensors.size(); ++row) inverses_[row] += tensors[row];
}

/// Masses that follow a frame have a centre of their own, so that a force on the frame turns it too: the inverse of six rows.
void UncoupledConstraintCorrection::takeWhole(const System& system) {
  using Six = Eigen::Matrix<double, 6, 6>;
  for (Vector* vector : {&unit_, &momentum_})
    if (vector->count() != system.independentRows()) vector->resize(system.independentRows());
  for (Mass* mass : system.masses())
    if (mass->turns()) mass->update(system.mappingChain().positions(system.x));
  inverses_.assign(std::size_t(state_->size()), Mat3::Zero());
  couplings_.assign(std::size_t(state_->nodes()), Mat3::Zero());
  for (Index frame = 0; frame < state_->nodes(); ++frame) {
    const Index row = 2 * frame, at = state_->firstRow() + row;
    Six inertia;
    for (int i = 0; i < 6; ++i) {
      clear(unit_), clear(momentum_);
      unit_[at + i / 3][i % 3] = 1;
      system.addMassProduct(unit_, 1, momentum_);
      inertia.col(i) << momentum_[at], momentum_[at + 1];
    }
    const Eigen::FullPivLU<Six> factors(inertia);
    if (!factors.isInvertible()) continue;
    const Six inverse = factors.inverse();
    inverses_[std::size_t(row)] = inverse.topLeftCorner<3, 3>(), inverses_[std::size_t(row) + 1] = inverse.bottomRightCorner<3, 3>();
    couplings_[std::size_t(frame)] = inverse.topRightCorner<3, 3>();
  }
}

void UncoupledConstraintCorrection::respond(ConstRows direction, Rows response) const {
  const Index first = state_->firstRow();
  for (Index row = 0; row < state_->size(); ++row) {
    const Vec3 push = direction[first + row];
    if (state_->hasFrames())
      response[first + row] = inverses_[std::size_t(row)] * push;
    else
      response[first + row] = each_[std::size_t(row / state_->rows_per_node)] * push;
  }
  for (std::size_t frame = 0; frame < couplings_.size(); ++frame) {
    const Index row = first + 2 * Index(frame);
    response[row] += couplings_[frame] * direction[row + 1];
    response[row + 1] += couplings_[frame].transpose() * direction[row];
  }
}

}  // namespace stroma
