// SPDX-License-Identifier: LGPL-2.1-or-later
// The steps of the condensed solvers, without what makes their matrices (condensed_precomputation.cpp).
#include "components/condensation/condensed_integrator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "framework/scene/node.h"

namespace stroma {

void CondensedIntegrator::declare(DataTable& table) {
  table.add("condensed", condensed_)
      .help("only kept nodes are solved for, and the inside is computed on demand; false: all nodes are kept");
  table.add("surfaceIndices", surface_indices_)
      .help("nodes that are kept; those on the boundary of the cells by default");
  table.addChoice("precision", precision_, {"double", "single"})
      .help(
          "of the stored inverse: single halves its bytes; entries are then wrong by up to 6e-8 of themselves, and "
          "dragForces by as much more as the compliance of the dragged nodes is near to singular");
  table.add("cacheFolder", cache_folder_)
      .help("folder for files of precomputed data; auto: the user's cache folder; empty: none");
  table.add("memoryLimit", memory_limit_)
      .help("memory limit of the precomputation; 0: the available memory")
      .unit("GB")
      .min(0);
  table.add("rotationBound", rotation_bound_)
      .help("largest turn of a surface triangle for which linear elasticity is taken for right")
      .unit("rad")
      .min(0);
  table.add("strainBound", strain_bound_).help("largest strain of a surface triangle, likewise").unit("-").min(0);
  table.add("keptNodes", kept_count_).help("how many nodes are solved for").unit("-").output();
  table.add("interiorNodes", interior_count_).help("how many nodes were condensed").unit("-").output();
  table.add("fromCache", from_cache_).help("the precomputation came from a file").output();
  table.add("draggedNodes", dragged_nodes_).help("nodes moved by position in the last step").output();
  table.add("dragForces", drag_forces_)
      .help(
          "force that moves each of draggedNodes: with the opposite sign, the feedback of a haptic device")
      .unit("N")
      .output();
}

// ---- nodes moved by position ----

void CondensedIntegrator::moveTouched(System& system, const StepContext& context) {
  system.setTime(context.t_end);
  const bool moves = body_.movingRows() != nullptr;
  const bool begins = (moves && !body_.constraintsAreFixed()) || others_.hasConstraints();
  beginConditions(system, context, begins);
  if (!others_.empty()) others_.keep(system);
  if (begins) system.beginStep(context);
  others_fault_.clear();
  if (!others_.empty() && !others_.begin(system, context))
    others_fault_ = others_.fault();
  if (!moves && !others_.hasConstraints() && !hands_changed_ && hands_.empty()) return;
  if (moves && !begins) {
    for (ProjectiveConstraint* constraint : system.constraints().all())
      if (constraint->prescribesMotion() && constraint->activeIn(context.t, context.t_end))
        constraint->beginMotion(context.t, system.x);
  }
  const bool other_moved = moves && findMoved(system), other_pulls = hands_changed_ && findHands(system);
  if (other_moved || other_pulls) compileTouches();
  if (!hands_.empty()) gatherHands(system);
  if (!moves && !others_.hasConstraints()) return;
  for (std::size_t i = 0; i < touching_.size(); ++i) touched_before_[i] = system.x[touching_[i].row];
  system.constraints().placePrescribed(context, system.x, system.v);
  if (!others_.empty()) others_.placeMapped(system);
  for (std::size_t k = 0; k < moved_.size(); ++k) {
    const Index row = activeRow(moved_[k].node);
    wanted_[Index(k)] = moved_[k].direction.dot(system.x[row] - body_.reference()[row]);
  }
}

void CondensedIntegrator::restoreTouched(System& system) {
  for (std::size_t i = 0; i < touching_.size(); ++i) system.x[touching_[i].row] = touched_before_[i];
  if (!others_.empty()) others_.restore(system);
}

/// The directions that a projector leaves, at a node.
void CondensedIntegrator::addDirections(Index node, const Mat3& projector, double stiffness, std::vector<Touch>& to) {
  if (projector.isIdentity()) {
    for (int c = 0; c < 3; ++c) to.push_back({node, Vec3::Unit(c), stiffness});
    return;
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(projector);
  for (int c = 0; c < 3; ++c)
    if (axes.eigenvalues()[c] > 0.5) to.push_back({node, axes.eigenvectors().col(c), stiffness});
}

// The directions that constraints hold now beyond those that are always held. False when they are those of before.
bool CondensedIntegrator::findMoved(const System& system) {
  touching_now_.clear();
  for (const NodeProjector& held : system.constraints().projectors())
    if ((*body_.movingRows())[held.row]) touching_now_.push_back(held);
  const auto same = [](const NodeProjector& a, const NodeProjector& b) {
    return a.row == b.row && a.projector == b.projector;
  };
  if (std::equal(touching_.begin(), touching_.end(), touching_now_.begin(), touching_now_.end(), same)) return false;
  touching_ = touching_now_;
  touched_before_.resize(touching_.size());
  moved_.clear();
  dragged_nodes_.clear();
  for (const NodeProjector& held : touching_) {
    const Index node = body_.nodeOf(held.row);
    addDirections(node - first_active_, body_.projector(node) - held.projector, 0, moved_);
    for (const State* state : system.states())
      if (const Index local = held.row - state->firstRow(); local >= 0 && local < state->size())
        dragged_nodes_.push_back(local);
  }
  drag_forces_.assign(touching_.size(), Vec3::Zero());
  return true;
}

/// E, C E and the factor of E^T C E + S. Columns that were there before a pull came or went are kept.
void CondensedIntegrator::compileTouches() {
  std::vector<Touch> before = std::exchange(touches_, moved_);
  touches_.insert(touches_.end(), pulls_.begin(), pulls_.end());
  if (std::none_of(touches_.begin(), touches_.end(), isPull) && std::none_of(before.begin(), before.end(), isPull))
    before.clear();
  const Index count = Index(touches_.size());
  wanted_.setZero(count), reaction_.setZero(count);
  const Eigen::MatrixXd columns = std::exchange(touch_columns_, Eigen::MatrixXd(Index(padded()), count));
  Eigen::MatrixXd small(count, count);
  for (Index k = 0; k < count; ++k) {
    const Touch& touch = touches_[k];
    const auto same = std::find_if(before.begin(), before.end(), [&touch](const Touch& other) {
      return other.node == touch.node && other.direction == touch.direction;
    });
    if (same != before.end())
      touch_columns_.col(k) = columns.col(same - before.begin());
    else
      complianceOf(touch, touch_columns_.col(k).data());
    for (Index l = 0; l < count; ++l)
      small(l, k) = touches_[l].direction.dot(touch_columns_.col(k).segment<3>(3 * touches_[l].node));
  }
  small = ((small + small.transpose()) / 2).eval();
  weigh(small);
  factorTouches(small);
}

// With W = diag(1 + S/diag(E^T C E))^-1/2, W (E^T C E + S) W has the diagonal of E^T C E: its condition is that of the
// body, however soft the springs are. A spring of no stiffness has the weight 0, and no reaction.
void CondensedIntegrator::weigh(Eigen::MatrixXd& small) {
  weights_.resize(0);
  if (pulls_.empty()) return;
  weights_.setOnes(small.rows());
  const Eigen::VectorXd diagonal = small.diagonal();
  for (Index k = Index(moved_.size()); k < small.rows(); ++k)
    weights_[k] = 1 / std::sqrt(1 + 1 / (touches_[k].stiffness * diagonal[k]));
  small = (weights_.asDiagonal() * small * weights_.asDiagonal()).eval();
  small.diagonal() = diagonal;
}

// The entries of C are right to the numbers they are stored in. Where E^T C E is nearly singular, the reactions lose as
// many digits as its condition has.
void CondensedIntegrator::factorTouches(const Eigen::MatrixXd& small) {
  touch_fault_.clear();
  if (small.rows() == 0) return;
  touch_factor_.compute(small);
  if (touch_factor_.info() != Eigen::Success) {
    touch_fault_ = fmt::format(
        "the compliance of the {} {} that are moved by position{} is not positive definite in {} precision: {}",
        pulls_.empty() ? touching_.size() : touches_.size(), pulls_.empty() ? "nodes" : "directions",
        pulls_.empty() ? "" : " or pulled", isSingle() ? "single" : "double",
        isSingle() ? "use precision=\"double\"" : "move fewer nodes, or soften the body (poissonRatio near 1/2)");
    return;
  }
  touch_error_ = std::max(touch_error_, (isSingle() ? 6e-8 : 1.1e-16) / touch_factor_.rcond());
}

const Eigen::VectorXd& CondensedIntegrator::solveTouches(const double* u) {
  for (std::size_t k = 0; k < touches_.size(); ++k)
    reaction_[Index(k)] =
        wanted_[Index(k)] - touches_[k].direction.dot(Eigen::Map<const Vec3>(u + 3 * touches_[k].node));
  if (weights_.size() > 0) reaction_.array() *= weights_.array();
  touch_factor_.solveInPlace(reaction_);
  if (weights_.size() > 0) reaction_.array() *= weights_.array();
  return reaction_;
}

// ---- other bodies ----

/// Adds a gradient on a row of another body, or of a point mapped onto it, to the condition whose entries start at `first`.
/// `is_live`: it may have a force. Returns the square of the gradient, or 0 if it moves nothing.
double CondensedIntegrator::addOther(Index row, const Vec3& gradient, std::size_t first, bool is_live) {
  CondensedConditions& c = conditions_;
  bool moves = false;
  others_.pull(row, gradient, [&](Index k, const Vec3& along) {
    Index& slot = c.slot[std::size_t(active_ + k)];
    if (slot < 0) slot = Index(c.nodes.size()), c.nodes.push_back(active_ + k);
    const auto known = std::find_if(c.entries.begin() + std::ptrdiff_t(first), c.entries.end(),
                                    [slot](const CondensedConditions::Entry& entry) { return entry.slot == slot; });
    if (known != c.entries.end())
      known->gradient += along;
    else
      c.entries.push_back({slot, along});
    moves = moves || !along.isZero(0);
    if (is_live) others_.load(k);
  });
  return moves ? gradient.squaredNorm() : 0;
}

/// C of slots that are loaded for the first time in this step.
void CondensedIntegrator::readColumns() {
  CondensedConditions& c = conditions_;
  for (const Index l : others_.lastLoads()) {
    const Index t = c.slot[std::size_t(active_ + l)];
    for (std::size_t s = 0; s < c.nodes.size(); ++s) {
      if (c.nodes[s] < active_) continue;
      const Mat3 block = others_.compliance(c.nodes[s] - active_, l);
      c.stored.block<3, 3>(3 * Eigen::Index(s), 3 * t) = block;
      c.stored.block<3, 3>(3 * t, 3 * Eigen::Index(s)) = block.transpose();
    }
  }
  c.c.resize(0, 0);  // prepareSlots() follows
}

// ---- the inside ----

bool CondensedIntegrator::reduceTimedInterior(double* out) {
  const auto& timed = body_.timedNodes();
  if (insideIsActive() || timed.empty() || timed.front() >= body_.interior()) return false;
  std::fill(timed_reduced_.begin(), timed_reduced_.end(), 0.0);
  for (const Index node : timed) {
    if (node >= body_.interior()) break;
    Eigen::Map<Vec3>(timed_reduced_.data() + 3 * node) = body_.timedForce(node);
  }
  checkFactor();
  forward(timed_reduced_.data());
  std::copy(timed_reduced_.begin() + 3 * body_.interior(), timed_reduced_.end(), out);
  return true;
}

void CondensedIntegrator::complete(System& system) {
  if (!behind_) return;
  checkFactor();
  behind_ = false;
  const std::size_t inside = 3 * std::size_t(body_.interior());
  const auto sweep = [&](const Rows& rows, ConstRows origin, bool loads) {
    for (std::size_t i = 0; i < inside; ++i)
      sweep_[i] = loads ? interior_constant_[i] + (timed_reduced_.empty() ? 0 : timed_reduced_[i]) : 0;
    for (Index node = body_.interior(); node < body_.free(); ++node)
      Eigen::Map<Vec3>(sweep_.data() + 3 * node) = rows[body_.row(node)] - origin[body_.row(node)];
    backward(sweep_.data());
    for (Index node = 0; node < body_.interior(); ++node)
      rows[body_.row(node)] = origin[body_.row(node)] + Eigen::Map<Vec3>(sweep_.data() + 3 * node);
  };
  sweep(system.x, body_.reference(), true);
  if (isDynamic()) sweep(system.v, body_.zero(), false);
}

// ---- the end of a step ----

bool CondensedIntegrator::writeActive(System& system, const double* u, const double* v) {
  const std::size_t count = 3 * std::size_t(active_);
  double sum = 0;
#pragma omp simd reduction(+ : sum)
  for (std::size_t i = 0; i < count; ++i) sum += u[i] * u[i];
  if (!std::isfinite(sum) || (!others_.empty() && !others_.finish(system, conditions_.others))) return false;
  square_ = sum;
  const double* __restrict origin = origin_.data();
  double* __restrict x = system.x.rows().data;
  for (Index node = 0; node < active_; ++node) {
    double* row = x + std::size_t(activeRow(node)) * row_doubles;
    for (int c = 0; c < 3; ++c) row[c] = origin[3 * node + c] + u[3 * node + c];
  }
  if (v)
    for (Index node = 0; node < active_; ++node)
      for (int c = 0; c < 3; ++c)
        system.v.rows().data[std::size_t(activeRow(node)) * row_doubles + std::size_t(c)] = v[3 * node + c];
  return true;
}

void CondensedIntegrator::finish(System& system) {
  for (Vec3& force : drag_forces_) force.setZero();
  std::size_t at = 0;
  for (std::size_t k = 0; k < moved_.size(); ++k) {
    while (body_.nodeOf(touching_[at].row) - first_active_ != touches_[k].node) ++at;
    drag_forces_[at] += reaction_[Index(k)] * touches_[k].direction;
  }
  if (!asks_force_) return;
  behind_ = leavesInside();
  complete(system);
  system.computeForce(system.x, system.v, system.f);
}

void CondensedIntegrator::stepTaken(const StepContext& context) {
  behind_ = leavesInside() && !asks_force_;
  conditions_.swinging += conditions_.swings;
  if (hasConditions())
    conditions_.taken.assign(conditions_.solve.l.data(), conditions_.solve.l.data() + conditions_.solve.l.size());
  range_.look(square_, context.t_end);
}

StepReport CondensedIntegrator::failure(const std::string& reason) const {
  StepReport report;
  report.diverged = true;
  report.reason = reason;
  return report;
}

std::string CondensedIntegrator::doubt() const {
  std::string text;
  if (touch_error_ > 0.01)
    text = fmt::format("{}: dragForces may be wrong by {:.0f} %: moved nodes are too strongly coupled for {} precision",
                       path(), std::min(100 * touch_error_, 100.0), isSingle() ? "single" : "double");
  if (conditions_.swinging > 0)
    text += fmt::format("{}{}: in {} steps the directions of forces of constraint had not come to rest; a smaller dt helps",
                        text.empty() ? "" : "; ", path(), conditions_.swinging);
  const std::string beyond = range_.sentence(rotation_bound_, strain_bound_);
  if (beyond.empty()) return text;
  return text + fmt::format(
                    "{}{}: {}: linear elasticity is right for small turns and strains only; a corotational method "
                    "(method=\"large\") follows large ones",
                    text.empty() ? "" : "; ", path(), beyond);
}

void CondensedIntegrator::reset() {
  behind_ = false;
  touch_error_ = 0;
  range_.reset();
  touching_.clear();
  moved_.clear();
  dragged_nodes_.clear();
  drag_forces_.clear();
  pulls_.clear();
  touches_.clear();
  hands_.clear();
  touch_fault_.clear();
  conditions_.taken.clear(), conditions_.swinging = 0;
  hands_changed_ = true, others_.reset();
}

void CondensedIntegrator::serialize(Archive& archive) {
  archive.value("touch_error", touch_error_);
  range_.serialize(archive);
  if (hasConditions()) {
    archive.list("forces_of_constraint", conditions_.taken);
    archive.value("swinging", conditions_.swinging);
  }
  others_.serialize(archive);
}

std::string CondensedIntegrator::describe() const {
  std::string text = stepText() + measuredText();
  if (body_.interior() > 0 && !insideIsActive())
    text += fmt::format("; {} nodes inside are computed only after steps in which they are read{}", body_.interior(),
                        asks_force_ ? ": each, because forces are read" : "");
  if (!body_.timedNodes().empty() && body_.timedNodes().front() < body_.interior() && !insideIsActive())
    text += "; loads on inside nodes change in time: a sweep through the factor of the inside in each step";
  if (body_.movingRows()) text += "; nodes moved by position are loads through their compliance";
  if (hasConditions()) text += "; forces of constraint through the compliance of the nodes that they act on";
  if (hasContact()) text += "; contact by Newton's method on the nodes that it pushes";
  if (!others_.empty()) text += others_.describe();
  if (range_.isEmpty())
    text += "; the range of linear elasticity is not checked: no surface of volume cells moves";
  else if (range_.watched() == 0)
    text += "; the range of linear elasticity is checked after the last step only: surface nodes are not kept";
  return text + (from_cache_ ? "; precomputed in " + file_name_ : "");
}

}  // namespace stroma
