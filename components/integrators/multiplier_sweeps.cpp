// SPDX-License-Identifier: LGPL-2.1-or-later
// Of the forces of constraint: those that ConstraintSweeps finds; constraint_sweeps.cpp says how.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
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
                  {"ProjectedGaussSeidel", "UnbuiltGaussSeidel", "NonsmoothNonlinearConjugateGradient", "NonlinearComplementarity"})
      .atOnce()
      .help("sweeps that go on from the step before, that begin at zero, as steps of conjugate gradients, or with the error of contacts");
  table.add("keepsContactForces", goes_on_).atOnce().help("contacts that persist start from their forces of the previous step");
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

/// The push alone, and then friction with what this has moved, up to its cone. off_ is g + W l of the block.
void ConstraintSweeps::pushBlock(const Block& block, Eigen::VectorXd& l) {
  const auto w = w_.block(block.first, block.first, block.width, block.width);
  auto force = l.segment(block.first, block.width);
  const double before = force[0];
  force[0] -= off_[0] / w(0, 0);
  if (force[0] < 0) return force.setZero(), void();
  if (block.width == 1) return;
  const double answers = w(1, 1) + w(2, 2);
  if (!(answers > 0)) return;
  for (int k = 1; k < 3; ++k) force[k] -= 2 * (off_[k] + w(k, 0) * (force[0] - before)) / answers;
  const double rubs = std::hypot(force[1], force[2]), most = block.mu * force[0];
  if (rubs > most) force.tail(2) *= most / rubs;
}

ConstraintSweeps::Sweep ConstraintSweeps::sweep(const Eigen::VectorXd& g, const std::vector<Block>& blocks, double tolerance,
                                                Eigen::VectorXd& l) {
  Sweep done;
  for (const Block& each : blocks) {
    const int first = each.first;
    const auto block = w_.block(first, first, each.width, each.width);
    off_.noalias() = w_.middleRows(first, each.width) * l;
    off_ += g.segment(first, each.width);
    Numbers change = Numbers::Zero(each.width);
    if (block(0, 0) > 0 && each.kind != Block::Kind::equal) {
      const Numbers before = l.segment(first, each.width);
      pushBlock(each, l);
      change = l.segment(first, each.width) - before;
    } else if (block.diagonal().minCoeff() > 0) {
      change = -Square(block).partialPivLu().solve(off_);
      l.segment(first, each.width) += change;
    }  // else nothing that moves is in it
    double moved = 0;
    for (int row = 0; row < each.width; ++row) {
      const double by = block.row(row).transpose().cwiseProduct(change).norm();
      moved += by, done.verified = done.verified && by <= tolerance;
    }
    if (each.turns && turn_tolerance_ > 0) {
      done.verified = done.verified && moved <= turn_tolerance_;
      moved *= tolerance / turn_tolerance_;
    }
    done.error += method_ == Method::complementarity ? (block * change).norm() : moved;
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
  double tolerance = tolerance_ * (scales_ && !all_verified_ ? double(g.size()) : 1.0);
  if (method_ == Method::complementarity) {
    const auto rubs = std::count_if(blocks.begin(), blocks.end(), [](const Block& each) { return each.kind == Block::Kind::rub; });
    tolerance = tolerance_ * (rubs > 0 ? double(rubs + 1) : 1.0);
  }
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

namespace {

/// Of what finds contacts in SOFA's order, three numbers for each: place of a node, pair, number. Null: its rows are not for sweeps.
const std::vector<int>* namesOf(const LagrangianConstraint& constraint) {
  const Component& component = dynamic_cast<const Component&>(constraint);
  const Data *names = component.data().find("sweepNames"), *lists = component.data().find("sofaLists");
  if (!names || !lists || !*std::get<bool*>(lists->pointer())) return nullptr;
  return std::get<std::vector<int>*>(names->pointer());
}

/// Nodes above and before come first.
void number(const Node& node, std::map<const Node*, int>& places) {
  places.emplace(&node, int(places.size()));
  for (const auto& child : node.children()) number(*child, places);
}

}  // namespace

/// Rows that are solved together, in the order of sweeps. False, with the row that is not for them.
bool Multipliers::findBlocks(std::size_t& other) {
  using Kind = LagrangianRows::Kind;
  using Block = ConstraintSweeps::Block;
  std::map<const Node*, int> places;
  number(system_->integrator().node().root(), places);
  struct Placed {
    int node;
    bool is_shared;
    Block block;
  };
  std::vector<Placed> placed;
  std::size_t begin = 0;
  const auto& constraints = system_->actors().lagrangian_constraints;
  for (std::size_t i = 0; i < constraints.size(); begin = ends_[i++]) {
    const std::vector<int>* names = namesOf(*constraints[i]);
    const int own = places.at(&dynamic_cast<const Component&>(*constraints[i]).node());
    std::size_t contact = 0;
    for (std::size_t row = begin; row < ends_[i]; row += std::size_t(placed.back().block.width)) {
      other = row;
      Block block;
      block.first = int(row);
      int place = own;
      if (rows_.rows()[row].kind == Kind::push && names && 3 * contact + 2 < names->size()) {
        place = (*names)[3 * contact];
        block.name = {(*names)[3 * contact + 1], (*names)[3 * contact + 2]};
        ++contact;
        const bool rubs = row + 2 < ends_[i] && rows_.rows()[row + 1].kind == Kind::rub;
        block.kind = rubs ? Block::Kind::rub : Block::Kind::push, block.width = rubs ? 3 : 1;
        block.goes_on = false;
        if (rubs) block.mu = rows_.rows()[row + 1].factor;
      } else if (rows_.rows()[row].kind == Kind::equal) {
        const auto entries = rows_.entriesOf(rows_.rows()[row]);
        const bool is_point = holdsPoint(row), is_pair_of_frames = is_point && entries.size() == 2 && isOfFrame(entries[0].row);
        block.width = is_point ? 3 : 1, block.turns = is_pair_of_frames && isTurn(entries[0].row);
        block.goes_on = is_point && !is_pair_of_frames;
      } else {
        return false;
      }
      placed.push_back({place, names != nullptr, block});
    }
  }
  std::stable_sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) {
    return std::pair(a.node, a.is_shared) < std::pair(b.node, b.is_shared);
  });
  blocks_.clear();
  for (const Placed& each : placed) blocks_.push_back(each.block);
  return true;
}

/// Of the step that has ended.
void Multipliers::keepContactForces() {
  contact_forces_.clear();
  if (!is_swept_ || !sweeps_->goesOnWithContacts()) return;
  for (const ConstraintSweeps::Block& block : blocks_)
    for (int k = 0; block.kind != ConstraintSweeps::Block::Kind::equal && k < block.width; ++k)
      contact_forces_[block.name][std::size_t(k)] = sweeping_[block.first + k];
}

/// Forces of the step before, by constraint: contacts come and go between them.
void Multipliers::takeSwept() {
  Eigen::VectorXd taken = Eigen::VectorXd::Zero(solve_.g.size());
  for (std::size_t i = 0, begin = 0, before = 0; i < ends_.size(); ++i) {
    const std::size_t count = ends_[i] - begin, old_end = i < swept_ends_.size() ? swept_ends_[i] : before;
    if (old_end - before == count && old_end <= std::size_t(sweeping_.size()))
      taken.segment(Eigen::Index(begin), Eigen::Index(count)) = sweeping_.segment(Eigen::Index(before), Eigen::Index(count));
    begin = ends_[i], before = old_end;
  }
  sweeping_ = taken;
}

/// False: they are not found by sweeps.
bool Multipliers::sweepForces(StopToken stop) {
  if (!sweeps_ || !isOnce()) return false;
  if (std::size_t other = 0; !findBlocks(other)) {
    if (not_swept_.empty()) not_swept_ = nameOf(other);
    return false;
  }
  if (!is_swept_) takeSwept();
  is_swept_ = true;
  for (const ConstraintSweeps::Block& block : blocks_)
    if (!block.goes_on || sweeps_->startsFromZero()) sweeping_.segment(block.first, block.width).setZero();
  for (const ConstraintSweeps::Block& block : blocks_) {
    const auto kept = contact_forces_.find(block.name);
    if (block.kind == ConstraintSweeps::Block::Kind::equal || kept == contact_forces_.end()) continue;
    for (int k = 0; k < block.width; ++k) sweeping_[block.first + k] = kept->second[std::size_t(k)];
  }
  solve_.rounds += sweeps_->solve(solve_.w, solve_.g, blocks_, rule_.weight, stop, sweeping_);
  solve_.l = sweeping_;
  return true;
}

/// Other forces than those that the scene asks for have been found.
std::string Multipliers::doubt() const {
  if (not_swept_.empty()) return {};
  return fmt::format("{} had no effect in some steps: the conditions of {} are neither equalities nor contacts with sofaLists. "
                     "There all conditions were solved to round-off, which is right, without its tolerance",
                     sweeps_->path(), not_swept_);
}

}  // namespace stroma
