// SPDX-License-Identifier: LGPL-2.1-or-later
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "components/condensation/other_bodies.h"
#include "framework/mechanics/frames.h"
#include "framework/simulation/held_size.h"
#include "framework/simulation/input_forces.h"

namespace stroma {

/// What acts on these bodies alone, for their matrix.
void OtherBodies::compileFields(System& system) {
  is_inverted_ = false, assembled_.reset(), pattern_ = -1, clusters_.clear();
  has_inputs_ = system.inputs() != nullptr;
  actors_ = system.actors();
  actors_.force_fields = fields_, actors_.masses = masses_, actors_.mappings.clear();
  const auto isMapped = [&](const State* state) { return state->firstRow() >= system.independentRows(); };
  const bool reach_mapped =
      std::ranges::any_of(fields_, [&](const ForceField* field) { return std::ranges::any_of(field->states(), isMapped); });
  if (reach_mapped) actors_.mappings = mappings_;
  if (const InputForces* inputs = system.inputs())
    for (ForceField* field : system.forceFields())
      if (field == inputs) actors_.force_fields.push_back(field);
  sortByTraits(actors_);
  chain_ = MappingChain();
  chain_.compile(actors_);
  if (!actors_.stiff_fields.empty() || !actors_.damped_fields.empty() || reach_mapped ||
      !std::ranges::all_of(masses_, [](const Mass* mass) { return mass->isDiagonal(); }))
    assembled_ = std::make_unique<AssembledMatrix>(actors_, chain_, system.constraints());
}

Mat3 OtherBodies::projector(const System& system, Index k) const {
  const Index slot = system.constraints().projectorOf(rows_[std::size_t(k)]);
  return slot < 0 ? Mat3::Identity() : system.constraints().projectors()[std::size_t(slot)].projector;
}

/// force_ = f + (h + rK) K v - rM M v, not projected.
void OtherBodies::computeForce(System& system) {
  for (const State* state : states_) clear(state->segment(force_.rows()));
  for (std::size_t k = 0; k < rows_.size(); ++k) force_[rows_[k]] = gravity_[k];
  if (!actors_.force_fields.empty()) {
    for (ForceField* field : actors_.force_fields) field->addForce(system.x, system.v, force_);
    chain_.noteForce(force_);
    chain_.pullBack(force_);
    const ConstRows v = chain_.beginProduct(system.v);
    const Rows sum = chain_.beginSum(force_);
    const MatrixFactors factors{.stiffness = h_, .rayleigh_stiffness = 1};
    for (const ForceField* field : actors_.stiff_fields)
      if (const double factor = factors.of(*field); factor != 0) field->addStiffnessProduct(v, factor, sum);
    chain_.finishProduct(v, h_, sum, force_);
  }
  for (const Mass* mass : masses_)
    if (const double alpha = rayleigh_mass_ + mass->rayleigh_mass; alpha != 0) mass->addProduct(system.v, -alpha, force_);
}

/// Where only masses act.
Mat3 OtherBodies::massBlock(Index k) const {
  Mat3 sum = Mat3::Zero();
  const Index row = rows_[std::size_t(k)];
  for (const Mass* mass : masses_) {
    const Index local = row - mass->state().firstRow();
    if (local < 0 || local >= mass->state().size()) continue;
    const double factor = 1 + h_ * (rayleigh_mass_ + mass->rayleigh_mass);
    sum += factor * mass->lumped()[std::size_t(local)] * Mat3::Identity();
    for (const TurningInertia& each : mass->turningInertias()) {
      if (each.row != local) continue;
      const Mat3 turn = each.turns ? start_turn_[std::size_t(k)].toRotationMatrix() : Mat3(Mat3::Identity());
      sum += factor * (turn * (each.inertia - each.inertia.trace() / 3 * Mat3::Identity()) * turn.transpose());
    }
  }
  return sum;
}

void OtherBodies::findClusters() {
  std::vector<std::size_t> leader(rows_.size());
  std::iota(leader.begin(), leader.end(), 0);
  const auto find = [&](std::size_t k) {
    while (leader[k] != k) k = leader[k] = leader[leader[k]];
    return k;
  };
  if (assembled_) {
    const BlockMatrix& pattern = assembled_->pattern();
    for (std::size_t k = 0; k < rows_.size(); ++k)
      for (Index s = pattern.rowStart()[std::size_t(rows_[k])]; s < pattern.rowStart()[std::size_t(rows_[k]) + 1]; ++s) {
        const std::size_t a = find(k), b = find(std::size_t(number_[std::size_t(pattern.columns()[std::size_t(s)])]));
        leader[std::max(a, b)] = std::min(a, b);
      }
    pattern_ = assembled_->patternRevision();
  }
  clusters_.clear(), cluster_of_.assign(rows_.size(), 0), place_in_.assign(rows_.size(), 0);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const std::size_t first = find(k);
    cluster_of_[k] = first == k ? clusters_.size() : cluster_of_[first];
    if (first == k) clusters_.emplace_back();
    Cluster& cluster = clusters_[cluster_of_[k]];
    place_in_[k] = Index(cluster.rows.size());
    cluster.rows.push_back(Index(k));
  }
}

void OtherBodies::makeClusters(const System& system) {
  findClusters();
  has_large_ = false;
  for (Cluster& cluster : clusters_) makeLarge(system, cluster), has_large_ = has_large_ || cluster.matrix;
  loads_.assign(has_large_ ? rows_.size() : 0, 0);
}

/// A^-1 of each cluster, or the matrix of a large one. False: some A is singular.
bool OtherBodies::invert(System& system) {
  if (is_inverted_ && !assembled_ && !has_inertia_turns_) return true;
  if (clusters_.empty() || (assembled_ && pattern_ != assembled_->patternRevision())) makeClusters(system);
  const BlockMatrix* matrix = nullptr;
  if (assembled_) {
    for (Mass* mass : masses_)
      if (mass->turns()) mass->update(system.x);
    matrix = &assembled_->assemble(
        {.mass = 1 + h_ * rayleigh_mass_, .stiffness = -h_ * h_, .damping = -h_, .rayleigh_mass = h_, .rayleigh_stiffness = -h_});
  }
  bool is_finite = true;
  for (Cluster& cluster : clusters_) {
    if (cluster.matrix) {
      takeValues(cluster, *matrix);
      continue;
    }
    invertSmall(cluster, matrix);
    is_finite = is_finite && cluster.inverse.allFinite();
  }
  if (!is_finite) fault_ = "the matrix of the rigid bodies beside the condensed ones is singular";
  return is_inverted_ = is_finite;
}

void OtherBodies::invertSmall(Cluster& cluster, const BlockMatrix* matrix) const {
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(3 * Eigen::Index(cluster.rows.size()), 3 * Eigen::Index(cluster.rows.size()));
  for (const Index k : cluster.rows) {
    const Index at = 3 * place_in_[std::size_t(k)];
    if (!matrix) {
      const Mat3& free = projectors_[std::size_t(k)];
      const Mat3 mass = massBlock(k);
      a.block<3, 3>(at, at) = free * mass * free + heldSize(diagonalSize(mass)) * (Mat3::Identity() - free);
      continue;
    }
    const auto row = std::size_t(rows_[std::size_t(k)]);
    for (Index s = matrix->rowStart()[row]; s < matrix->rowStart()[row + 1]; ++s) {
      const Index other = place_in_[std::size_t(number_[std::size_t(matrix->columns()[std::size_t(s)])])];
      a.block<3, 3>(at, 3 * other) =
          Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix->values().data() + std::size_t(s) * 9);
    }
  }
  cluster.inverse = a.partialPivLu().inverse();
}

void OtherBodies::keep(const System& system) {
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const Index row = rows_[k];
    std::copy_n(system.x.rows().data + std::size_t(row) * row_doubles, row_doubles, start_[k].begin());
    if (system.motion().kindOf(row) == RowKind::turn) start_turn_[k] = orientationIn(system.x, row);
    kept_velocity_[k] = system.v[row];
  }
}

bool OtherBodies::begin(System& system, const StepContext& context) {
  h_ = context.dt, stop_ = context.stop, solved_ = {.stop = SolveStop::zero_right_side};
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    start_velocity_[k] = system.v[rows_[k]];
    const Mat3 free = projector(system, Index(k));
    if (free != projectors_[k]) {
      is_inverted_ = false, projectors_[k] = free;
      if (!clusters_.empty()) clusters_[cluster_of_[k]].columns.clear();
    }
    if (is_static_ && !isHeld(Index(k))) return fault_ = "in statics a body beside the condensed ones has become free", false;
  }
  if (inputs_changed_ && (has_inputs_ || system.inputs())) compileFields(system);
  inputs_changed_ = false;
  computeForce(system);
  if (!invert(system)) return false;
  std::fill(loads_.begin(), loads_.end(), 0), new_loads_.clear();
  for (Cluster& cluster : clusters_) {
    if (cluster.matrix && !findFreeChange(cluster)) return false;
    for (const Index k : cluster.rows) {
      if (cluster.matrix) break;
      Vec3 sum = Vec3::Zero();
      for (const Index l : cluster.rows)
        sum += cluster.inverse.block<3, 3>(3 * place_in_[std::size_t(k)], 3 * place_in_[std::size_t(l)]) *
               (h_ * (projectors_[std::size_t(l)] * force_[rows_[std::size_t(l)]]));
      free_change_[std::size_t(k)] = projectors_[std::size_t(k)] * sum;
    }
  }
  for (Index k = 0; k < count(); ++k) place(system, k, turned(k, free(k)));
  placeMapped(system);
  return true;
}

Mat3 OtherBodies::compliance(Index k, Index l) const {
  if (cluster_of_[std::size_t(k)] != cluster_of_[std::size_t(l)]) return Mat3::Zero();
  const Cluster& cluster = clusters_[cluster_of_[std::size_t(k)]];
  if (cluster.matrix) {
    const bool is_other = !loads_[std::size_t(l)];
    if (is_other && !loads_[std::size_t(k)]) return Mat3::Zero();
    const auto known = cluster.columns.find(is_other ? k : l);
    Mat3 block;
    for (int c = 0; c < 3; ++c)
      block.col(c) = projectors_[std::size_t(is_other ? l : k)] * known->second[std::size_t(c)][place_in_[std::size_t(is_other ? l : k)]];
    return h_ * h_ * (is_other ? Mat3(block.transpose()) : block);
  }
  const Eigen::MatrixXd& inverse = cluster.inverse;
  return h_ * h_ * (projectors_[std::size_t(k)] * inverse.block<3, 3>(3 * place_in_[std::size_t(k)], 3 * place_in_[std::size_t(l)]) *
                    projectors_[std::size_t(l)]);
}

/// w' of J(exp(h w') q) w' = L by Newton's method, L the momentum that the linear solve gives for v0 + `change`. Held directions keep
/// theirs. The turn by w' is additive in the derivative, which costs iterations only.
Vec3 OtherBodies::velocity(Index k, const Vec3& change) const {
  const auto at = std::size_t(k);
  Vec3 w = start_velocity_[at] + change;
  if (turning_of_[at] < 0 || isHeld(k)) return w;
  const Turning& body = turning_[std::size_t(turning_of_[at])];
  if (!body.turns) return w;
  const auto inertiaAt = [&](const Vec3& turn) {
    const Mat3 r = (turnedBy(turn) * start_turn_[at]).toRotationMatrix();
    return Mat3(r * body.inertia * r.transpose());
  };
  const Mat3 &free = projectors_[at], held = Mat3::Identity() - free;
  const Vec3 momentum = inertiaAt(Vec3::Zero()) * w;
  double before = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < 50; ++iteration) {
    const Mat3 inertia = inertiaAt(h_ * w);
    const Vec3 spin = inertia * w;
    const Mat3 slope = inertia + h_ * (inertia * crossMatrix(w) - crossMatrix(spin));
    const Vec3 step = (free * slope * free + held).partialPivLu().solve(free * (momentum - spin));
    const double size = step.norm();
    if (!(size > 1e-15 * w.norm()) || (iteration > 8 && size >= before)) break;
    before = size, w += step;
  }
  return w;
}

Vec3 OtherBodies::turned(Index k, const Vec3& linear) const {
  const auto at = std::size_t(k);
  return turning_of_[at] < 0 ? linear : Vec3(h_ * velocity(k, linear / h_ - start_velocity_[at]));
}

void OtherBodies::place(System& system, Index k, const Vec3& displacement) {
  const Index row = rows_[std::size_t(k)];
  now_[std::size_t(k)] = displacement;
  std::copy_n(start_[std::size_t(k)].begin(), row_doubles, system.x.rows().data + std::size_t(row) * row_doubles);
  system.motion().advanceRow(displacement, system.x, row);
  outdated_ = true;
}

void OtherBodies::placeMapped(System& system) {
  for (const Mapping* mapping : mappings_) mapping->apply(system.x);
}

void OtherBodies::updateJacobians() {
  for (std::size_t m = 0; m < mappings_.size(); ++m)
    if (!mappings_[m]->isLinear()) blocks_[m].clear(), mappings_[m]->addJacobian(blocks_[m]);
  outdated_ = false;
}

bool OtherBodies::finish(System& system, const std::vector<Vec3>& forces) {
  bool is_finite = true;
  pushed_.resize(clusters_.size());
  for (std::vector<Index>& rows : pushed_) rows.clear();
  for (Index k = 0; k < count(); ++k)
    if (!forces[std::size_t(k)].isZero(0)) pushed_[cluster_of_[std::size_t(k)]].push_back(k);
  for (Index k = 0; k < count(); ++k) {
    Vec3 change = Vec3::Zero();
    for (const Index l : pushed_[cluster_of_[std::size_t(k)]]) change += compliance(k, l) * forces[std::size_t(l)];
    const Vec3 v = velocity(k, free_change_[std::size_t(k)] + change / h_);
    is_finite = is_finite && v.allFinite();
    place(system, k, h_ * v);
    system.v[rows_[std::size_t(k)]] = v;
  }
  placeMapped(system);
  for (const Mapping* mapping : mappings_) mapping->applyJ(system.v);
  return is_finite;
}

void OtherBodies::restore(System& system) const {
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    std::copy_n(start_[k].begin(), row_doubles, system.x.rows().data + std::size_t(rows_[k]) * row_doubles);
    system.v[rows_[k]] = kept_velocity_[k];
  }
  for (const Mapping* mapping : mappings_) mapping->apply(system.x), mapping->applyJ(system.v);
}

}  // namespace stroma
