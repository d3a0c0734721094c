// SPDX-License-Identifier: LGPL-2.1-or-later
// Of the forces of constraint: those that ConstraintSweeps finds; constraint_sweeps.cpp says how.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "components/integrators/constraint_sweeps.h"
#include "components/integrators/multipliers.h"
#include "framework/scene/node.h"
#include "framework/simulation/integrator.h"

namespace stroma {

void ConstraintSweeps::declare(DataTable& table) {
  table.add("maxIterations", most_).atOnce().alias("maxIt").help("sweeps at most").unit("-").min(1);
  table.add("tolerance", tolerance_).atOnce().help("movement of the conditions in a sweep at which it is the last").unit("m").min(0);
  table.add("turnTolerance", turn_tolerance_).help("of how two frames are turned to each other; 0: as of the rest").unit("rad").min(0);
  table.add("scaleTolerance", scales_).atOnce().help("the tolerance is times the number of conditions");
  table.add("allVerified", all_verified_).atOnce().help("no condition may move by more than the tolerance, in the place of their sum");
  table.add("sor", relaxation_).atOnce().help("share of a sweep that forces go").unit("-").min(0, false).max(2, false);
  table.add("regularizationTerm", softness_).atOnce().help("by which conditions yield to impulses").unit("m/(N s)").min(0);
  table.add("keepsUnsettled", keeps_unsettled_)
      .help("forces that have not come to the tolerance in maxIterations sweeps count, as in SOFA, and the run goes on and tells of it");
  table.addChoice("resolutionMethod", method_,
                  {"ProjectedGaussSeidel", "UnbuiltGaussSeidel", "NonsmoothNonlinearConjugateGradient"})
      .atOnce()
      .help("sweeps that go on from the step before, that begin at zero, or as steps of conjugate gradients");
}

void ConstraintSweeps::tellIdle(const Component& asker, const std::string& why) {
  std::vector<ConstraintSweeps*> all;
  asker.node().root().collect(all);
  for (ConstraintSweeps* each : all)
    if (std::exchange(each->idle_, why) != why)
      each->warn(fmt::format("has no effect: {}", why), "EulerImplicitSolver with newtonIterations=\"1\" and oneRound");
}

bool ConstraintSweeps::isOver(const Sweep& sweep, double tolerance) {
  last_error_ = sweep.error;
  is_over_ = sweep.error == 0 || (all_verified_ ? sweep.verified : sweep.error < tolerance);
  return is_over_;
}

ConstraintSweeps::Sweep ConstraintSweeps::sweep(const Eigen::VectorXd& g, const std::vector<Block>& blocks, double tolerance,
                                                Eigen::VectorXd& l) {
  Sweep done;
  int first = 0;
  for (const Block& each : blocks) {
    const auto block = w_.block(first, first, each.width, each.width);
    off_ = g.segment(first, each.width) + w_.middleRows(first, each.width) * l;
    Eigen::VectorXd change = Eigen::VectorXd::Zero(each.width);
    if (block.diagonal().minCoeff() > 0) change = -block.partialPivLu().solve(off_);  // else nothing that moves is in it
    l.segment(first, each.width) += change;
    double moved = 0;
    for (int row = 0; row < each.width; ++row) {
      const double by = block.row(row).transpose().cwiseProduct(change).norm();
      moved += by, done.verified = done.verified && by <= tolerance;
    }
    if (each.turns && turn_tolerance_ > 0) {
      done.verified = done.verified && moved <= turn_tolerance_;
      moved *= tolerance / turn_tolerance_;
    }
    done.error += moved;
    first += each.width;
  }
  return done;
}

int ConstraintSweeps::searchByGradients(const Eigen::VectorXd& g, const std::vector<Block>& blocks, double tolerance, StopToken stop,
                                        Eigen::VectorXd& l) {
  old_ = l;
  isOver(sweep(g, blocks, tolerance, l), tolerance);
  last_change_ = old_ - l;
  way_ = -last_change_;
  if (last_change_.isZero(0)) return 1;
  for (int i = 1; i < most_; ++i) {
    if (stop.isStopAsked()) return i;
    old_ = l;
    if (isOver(sweep(g, blocks, tolerance, l), tolerance)) return i + 1;
    change_ = old_ - l;
    if (change_.isZero(0)) return is_over_ = true, i + 1;
    const double grown = change_.squaredNorm() / last_change_.squaredNorm();
    last_change_ = change_;
    if (grown > 1) {
      way_.setZero();
    } else {
      l += grown * way_;
      way_ = grown * way_ - change_;
    }
  }
  return most_;
}

int ConstraintSweeps::solve(const Eigen::MatrixXd& w, const Eigen::VectorXd& g, const std::vector<Block>& blocks, double impulse,
                            StopToken stop, Eigen::VectorXd& l) {
  const double tolerance = tolerance_ * (scales_ && !all_verified_ ? double(g.size()) : 1.0);
  w_ = w;
  w_.diagonal().array() += softness_ * impulse;
  is_over_ = false;
  const int sweeps = method_ == Method::gradients ? searchByGradients(g, blocks, tolerance, stop, l)
                                                  : search(g, blocks, tolerance, stop, l);
  unsettled_.clear();
  if (stop.isStopAsked()) return sweeps;
  // where the round-off of sums is more than the tolerance, nothing comes nearer
  const double round_off = 4 * std::numeric_limits<double>::epsilon() * (g.lpNorm<1>() + (w_.cwiseAbs() * l.cwiseAbs()).sum());
  if (!is_over_ && !(last_error_ <= round_off))
    unsettled_ = fmt::format("{} has made {} sweeps, the last of which still moved conditions by {:.3g} m in sum: the forces of Lagrangian "
                             "constraints are not found to its tolerance of {:.3g} m. maxIterations lets it go on",
                             path(), sweeps, last_error_, tolerance);
  return sweeps;
}

int ConstraintSweeps::search(const Eigen::VectorXd& g, const std::vector<Block>& blocks, double tolerance, StopToken stop,
                             Eigen::VectorXd& l) {
  for (int i = 1; i <= most_; ++i) {
    if (stop.isStopAsked()) return i - 1;
    if (relaxation_ != 1) old_ = l;
    const Sweep done = sweep(g, blocks, tolerance, l);
    if (relaxation_ != 1) l = relaxation_ * l + (1 - relaxation_) * old_;
    if (isOver(done, tolerance)) return i;
  }
  return most_;
}

ConstraintSweeps* Multipliers::findSweeps() const {
  std::vector<ConstraintSweeps*> found;
  system_->integrator().node().root().collect(found);
  for (std::size_t i = 1; i < found.size(); ++i)
    found[i]->warn(fmt::format("has no effect: {} stands before it", found.front()->path()), "one ConstraintSweeps in a scene");
  return found.empty() ? nullptr : found.front();
}

/// The row and the next two hold a point: along the three axes, of the same nodes.
bool Multipliers::holdsPoint(std::size_t row) const {
  if (row + 3 > rows_.rows().size()) return false;
  const auto of_first = rows_.entriesOf(rows_.rows()[row]);
  for (int axis = 0; axis < 3; ++axis) {
    const auto entries = rows_.entriesOf(rows_.rows()[row + std::size_t(axis)]);
    const auto isAlong = [axis](const LagrangianRows::Entry& a, const LagrangianRows::Entry& b) {
      return a.row == b.row && a.gradient.cwiseAbs() == Vec3::Unit(axis);
    };
    if (!std::equal(entries.begin(), entries.end(), of_first.begin(), of_first.end(), isAlong)) return false;
  }
  return true;
}

/// Of a row of all: what it is of.
const State* Multipliers::stateOf(Index row) const {
  for (const State* state : system_->states())
    if (row >= state->firstRow() && row < state->firstRow() + state->size()) return state;
  return nullptr;
}
bool Multipliers::isOfFrame(Index row) const {
  const State* state = stateOf(row);
  return state && state->hasFrames();
}
bool Multipliers::isTurn(Index row) const {
  const State* state = stateOf(row);
  return state && state->kindOf(row - state->firstRow()) == RowKind::turn;
}

/// False: they are not found by sweeps.
bool Multipliers::sweepForces(StopToken stop) {
  if (!sweeps_ || !isOnce()) return false;
  const auto other = std::ranges::find_if(rows_.rows(), [](const auto& row) { return row.kind != LagrangianRows::Kind::equal; });
  if (other != rows_.rows().end()) {
    if (not_swept_.empty()) not_swept_ = nameOf(std::size_t(other - rows_.rows().begin()));
    return false;
  }
  is_swept_ = true, blocks_.clear();
  sweeping_.conservativeResizeLike(Eigen::VectorXd::Zero(solve_.g.size()));
  if (sweeps_->startsFromZero()) sweeping_.setZero();
  for (std::size_t row = 0; row < rows_.rows().size(); row += std::size_t(blocks_.back().width)) {
    const auto entries = rows_.entriesOf(rows_.rows()[row]);
    const bool is_point = holdsPoint(row), is_pair_of_frames = is_point && entries.size() == 2 && isOfFrame(entries[0].row);
    blocks_.push_back({is_point ? 3 : 1, is_pair_of_frames && isTurn(entries[0].row)});
    if (!is_point || is_pair_of_frames) sweeping_.segment(Eigen::Index(row), blocks_.back().width).setZero();
  }
  solve_.rounds += sweeps_->solve(solve_.w, solve_.g, blocks_, rule_.weight, stop, sweeping_);
  solve_.l = sweeping_;
  return true;
}

/// Other forces than those that the scene asks for have been found.
std::string Multipliers::doubt() const {
  if (not_swept_.empty()) return {};
  return fmt::format("{} had no effect in some steps: the conditions of {} are not all equal ones. All held to round-off there, which is "
                     "right, without its tolerance",
                     sweeps_->path(), not_swept_);
}

}  // namespace stroma
