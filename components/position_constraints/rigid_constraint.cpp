// SPDX-License-Identifier: LGPL-2.1-or-later
// RigidConstraint: a set of nodes moves as one rigid body.
//
//   x_i = c + Q a_i,   a_i = R X_i: the rest shape from its centre of mass, turned as it was at the start of the step
//
// c is the centre of mass of the nodes that the integrator has moved, and Q the rotation of the step for which
//   sum m_i s_i x (Q a_i) = sum m_i s_i x (x_i - c),   s_i the position from the centre at the start (a_i to round-off)
// (Moser and Veselov's discrete rigid body, what SHAKE converges to with all distances held): momentum and angular
// momentum are those of the unconstrained nodes, m_i their lumped masses whatever the mass of the scene. A set that
// turns by more than a quarter in one step (w dt > 1, as I sin(angle) = dt L) has no such Q: it turns by a quarter, and
// the step's report says so. Then v_i = v_c + w x (x_i - c) with the same momenta. The distances between the nodes are
// those of the rest shape to round-off, however long the run: no error piles up.
//
// Nodes of the set that projective constraints hold, or move as prescribed, lead the body: one is a pivot, two are an
// axis, three or more that are not in a line place it entirely. A node that is held in some directions only cannot be
// part of a rigid set.
//
// Source: rigid objects of the breathing model that Nesme et al. 2005, section 4, builds on; Moser and Veselov 1991.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerExplicitSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1" velocity="0 0 1  0 0 2  0 0 3  0 1 0"/>
//   <UniformMass totalMass="4"/>
//   <RigidConstraint indices="0 1 2 3"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "components/position_constraints/best_rotation.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/position_constraint.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// sum q x e of E = sum e q^T
Vec3 axial(const Mat3& e) { return {e(2, 1) - e(1, 2), e(0, 2) - e(2, 0), e(1, 0) - e(0, 1)}; }

/// (tr(M) I - M)^-1 b; components about the axis of points on a line, where there is no inertia, are zero.
Vec3 solveInertia(const Mat3& m, const Vec3& b) {
  const Mat3 inertia = m.trace() * Mat3::Identity() - m;
  Eigen::SelfAdjointEigenSolver<Mat3> eigen;
  eigen.computeDirect(Mat3(0.5 * (inertia + inertia.transpose())));
  // the closed form is a preconditioner only; two steps with the matrix itself reach round-off
  const auto rough = [&](const Vec3& r) {
    Vec3 x = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
      const double value = eigen.eigenvalues()[i];
      if (value > 1e-12 * m.trace()) x += eigen.eigenvectors().col(i).dot(r) / value * eigen.eigenvectors().col(i);
    }
    return x;
  };
  Vec3 x = rough(b);
  for (int step = 0; step < 2; ++step) x += rough(b - inertia * x);
  return x;
}

/// The shortest turn from one direction to another. (Quaternion::FromTwoVectors has a singular value decomposition for
/// opposite ones, which takes a compiler ten seconds.)
Mat3 turnBetween(const Vec3& from, const Vec3& to) {
  const Vec3 a = from.normalized(), b = to.normalized();
  const double cosine = b.dot(a);
  if (cosine < -1 + 1e-12) return Eigen::AngleAxisd(M_PI, a.unitOrthogonal()).toRotationMatrix();
  const double s = std::sqrt((1 + cosine) * 2);
  const Vec3 axis = a.cross(b) * (1 / s);
  return Eigen::Quaterniond(s * 0.5, axis.x(), axis.y(), axis.z()).toRotationMatrix();
}

/// The turn d with A d = missing, A = tr(M) I - M, along `line` only where that is not zero. Least squares with a
/// trace of damping: |missing| falls along d where A is singular too (a quarter turn; about the line of a bar).
Vec3 turnFor(const Mat3& m, const Vec3& missing, const Vec3& line) {
  Mat3 a = m.trace() * Mat3::Identity() - m;
  if (!line.isZero(0)) a = line.dot(a * line) * line * line.transpose();
  const Mat3 square = a.transpose() * a;
  return Mat3(square + 1e-14 * square.trace() * Mat3::Identity()).ldlt().solve(a.transpose() * missing);
}

class RigidConstraint final : public PositionConstraint {
 public:
  void declare(DataTable& table) override;
  void init() override;
  void compile() override;
  void begin(const PositionStep& step) override;
  double correctPositions(const PositionStep& step, Rows x, Rows reference) override;
  double correctVelocities(const PositionStep& step, ConstRows x, Rows v) override;
  std::string violation() const override {
    if (guided_ >= 0) return fmt::format("node {} is fixed in some directions only", guided_);
    if (misfit_)
      return fmt::format("fixed nodes do not keep their distances: one has an error of {:.3g} m", worst_ * allowed_);
    if (unturned_ > 0)
      return fmt::format(
          "it would have to turn by more than a quarter in one step; {:.2g} of its angular momentum is lost (a smaller "
          "dt)",
          unturned_);
    return fmt::format("a node is {:.3g} m from its place in the rigid set", worst_ * allowed_);
  }
  std::string describe() const override { return fmt::format("{} nodes move as one rigid body", nodes_.size()); }

 private:
  Index rowOf(std::size_t i) const { return row(nodes_[i]); }
  Mat3 fit(ConstRows x, const Vec3& centre) const;
  Mat3 turn(Mat3 q, ConstRows x, const Vec3& centre);
  Vec3 spin(ConstRows x, ConstRows v, const Vec3& centre, const Vec3& velocity) const;
  bool isPlaced() const { return leaders_.size() > 2 && !leaders_in_line_; }
  bool hasAxis() const { return leaders_.size() > 1 && leaders_in_line_; }
  Vec3 axis(ConstRows x) const { return (x[rowOf(leaders_.back())] - x[rowOf(leaders_[0])]).normalized(); }
  void weighNodes(const PositionStep& step);
  Vec3 centreOf(ConstRows x) const;

  std::vector<int> indices_;
  double tolerance_ = 0;

  std::vector<Index> nodes_;
  std::vector<Vec3> rest_;            ///< from the mean of the set [m], shape (nodes_)
  std::vector<Vec3> arm_;             ///< a_i of this step [m]
  std::vector<Vec3> start_;           ///< s_i of this step [m]
  std::vector<double> mass_;          ///< [kg]
  std::vector<std::size_t> leaders_;  ///< nodes of the set that are held or moved as prescribed
  bool leaders_in_line_ = false;
  double allowed_ = 0;  ///< tolerance of this step [m]
  double worst_ = 0;
  double unturned_ = 0;  ///< share of the angular momentum that no turn of this step keeps
  Index guided_ = -1;
  bool misfit_ = false;
};

void RigidConstraint::declare(DataTable& table) {
  PositionConstraint::declare(table);
  table.add("indices", indices_).help("nodes of the rigid set; every node by default");
  table.add("tolerance", tolerance_)
      .unit("m")
      .min(0)
      .help(
          "tolerated distance from the rigid position; 0: 1e-12 of the set's size. Never below the round-off of positions");
}

void RigidConstraint::init() {
  PositionConstraint::init();
  if (data().find("indices")->isSet()) {
    nodes_ = checkedNodes(indices_, state(), "indices");
  } else {
    nodes_.resize(state().size());
    std::iota(nodes_.begin(), nodes_.end(), 0);
  }
  if (nodes_.size() < 2) throw ComponentError("a rigid set of one node is no constraint", "two nodes or more");
  double size = 0;
  for (const Index node : nodes_)
    size = std::max(size, (state().rest_position[node] - state().rest_position[nodes_[0]]).norm());
  if (!(size > 0))
    throw ComponentError("all nodes of the rigid set lie in one place at rest", "nodes apart from each other");
  if (tolerance_ == 0) tolerance_ = 1e-12 * size;
}

void RigidConstraint::compile() {
  rest_.resize(nodes_.size());
  arm_.resize(nodes_.size());
  start_.resize(nodes_.size());
  mass_.resize(nodes_.size());
  leaders_.reserve(nodes_.size());
}

/// The point that the body turns about, from `x`: the mean of the leaders, else the centre of mass.
Vec3 RigidConstraint::centreOf(ConstRows x) const {
  // from a node of the set: far from the origin, sums of positions lose what distances keep
  const Vec3 first = x[rowOf(0)];
  Vec3 sum = Vec3::Zero();
  if (!leaders_.empty()) {
    for (const std::size_t i : leaders_) sum += x[rowOf(i)] - first;
    return first + sum / double(leaders_.size());
  }
  double mass = 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) sum += mass_[i] * (x[rowOf(i)] - first), mass += mass_[i];
  return first + sum / mass;
}

/// Which nodes lead, and the masses of the others (leaders count as 1 where nothing else has mass).
void RigidConstraint::weighNodes(const PositionStep& step) {
  leaders_.clear();
  guided_ = -1;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const bool held = step.mobility.isHeld(rowOf(i));
    if (held) leaders_.push_back(i);
    if (step.mobility.isGuided(rowOf(i))) guided_ = nodes_[i];
    mass_[i] = held ? 0 : 1 / step.mobility.inverseMass(rowOf(i));
  }
}

void RigidConstraint::begin(const PositionStep& step) {
  weighNodes(step);
  unturned_ = 0;
  allowed_ = std::max(tolerance_, roundOff(step.x_start, nodes_));
  // rest shape from the point that it turns about, and its orientation at the start of the step
  Vec3 rest_centre = Vec3::Zero();
  double total = 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const double weight = leaders_.empty() ? mass_[i] : double(mass_[i] == 0);
    rest_centre += weight * state().rest_position[nodes_[i]], total += weight;
  }
  rest_centre /= total;
  const Vec3 centre = centreOf(step.x_start);
  Mat3 a = Mat3::Zero();
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    rest_[i] = state().rest_position[nodes_[i]] - rest_centre;
    const double weight = mass_[i] > 0 ? mass_[i] : 1;
    start_[i] = step.x_start[rowOf(i)] - centre;
    a += weight * start_[i] * rest_[i].transpose();
  }
  const Mat3 r = bestRotation(a);
  Vec3 rest = Vec3::Zero();  // round-off in the centre of the arms would push the body at every step
  for (std::size_t i = 0; i < nodes_.size(); ++i) arm_[i] = r * rest_[i], rest += mass_[i] / total * arm_[i];
  for (Vec3& arm : arm_) arm -= leaders_.empty() ? rest : Vec3::Zero();
  leaders_in_line_ = true;
  for (std::size_t k = 2; k < leaders_.size(); ++k) {
    const Vec3 along = rest_[leaders_.back()] - rest_[leaders_[0]], other = rest_[leaders_[k - 1]] - rest_[leaders_[0]];
    leaders_in_line_ = leaders_in_line_ && along.cross(other).norm() <= 1e-6 * along.squaredNorm();
  }
}

/// The rotation that takes the arms to x best; by the leaders alone when they place the body.
Mat3 RigidConstraint::fit(ConstRows x, const Vec3& centre) const {
  Mat3 a = Mat3::Zero();
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (isPlaced() && mass_[i] > 0) continue;
    a += (mass_[i] > 0 ? mass_[i] : 1) * (x[rowOf(i)] - centre) * arm_[i].transpose();
  }
  Mat3 q = bestRotation(a);
  if (!hasAxis()) return q;
  const Vec3 turned = q * (arm_[leaders_.back()] - arm_[leaders_[0]]);
  return turnBetween(turned, axis(x)) * q;
}

/// From near, the rotation with sum m s x (Q a) = sum m s x b, b = x - centre; about the axis only when there is one.
/// With M = sum m (Q a) s^T, a turn by d changes the left side by (tr(M) I - M) d. A turn is halved until what is
/// missing falls, so that where there is no solution (I sin(angle) = dt L, a quarter turn is the largest) Q is the turn
/// that misses least; unturned_ says what share it misses.
Mat3 RigidConstraint::turn(Mat3 q, ConstRows x, const Vec3& centre) {
  Mat3 inertia = Mat3::Zero();
  Vec3 moment = Vec3::Zero();
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    inertia += mass_[i] * arm_[i] * start_[i].transpose();
    moment += mass_[i] * start_[i].cross(x[rowOf(i)] - centre);
  }
  const Vec3 line = hasAxis() ? axis(x) : Vec3::Zero();
  const auto counted = [&](const Vec3& moments) { return hasAxis() ? Vec3(line.dot(moments) * line) : moments; };
  const auto missingAt = [&](const Mat3& rotation) { return counted(moment - axial(rotation * inertia)); };
  const double round_off = 1e-13 * inertia.norm();
  Vec3 missing = missingAt(q);
  for (int iteration = 0; iteration < 60; ++iteration) {
    Vec3 d = turnFor(q * inertia, missing, line);
    if (!(d.norm() > 0)) break;
    if (d.norm() > 1) d.normalize();
    double share = 1;
    const auto turned = [&] {
      return Mat3(Eigen::AngleAxisd(share * d.norm(), d.normalized()).toRotationMatrix() * q);
    };
    while (share > 1e-12 && !(missingAt(turned()).norm() < missing.norm()))
      share = missing.norm() > round_off ? share / 2 : 0;
    if (!(share > 1e-12)) break;
    q = turned();
    missing = missingAt(q);
  }
  if (missing.norm() > 1e-12 * inertia.norm()) unturned_ = std::max(unturned_, missing.norm() / counted(moment).norm());
  return q;
}

double RigidConstraint::correctPositions(const PositionStep&, Rows x, Rows) {
  const Vec3 centre = centreOf(x);
  Mat3 q = fit(x, centre);
  if (!isPlaced()) q = turn(q, x, centre);
  double farthest = 0, misfit = 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Vec3 place = centre + q * arm_[i];
    const double distance = (place - x[rowOf(i)]).norm();
    if (mass_[i] > 0)
      farthest = std::max(farthest, distance), x[rowOf(i)] = place;
    else
      misfit = std::max(misfit, distance);
  }
  // prescribed motions carry more round-off than a solution of our own
  misfit_ = misfit > 1e3 * allowed_;
  worst_ = std::max(farthest, misfit_ ? misfit : 0) / allowed_;
  return guided_ >= 0 || unturned_ > 0 ? std::max(worst_, 2.) : worst_;
}

/// The angular velocity of the body about `centre`, which moves with `velocity`.
Vec3 RigidConstraint::spin(ConstRows x, ConstRows v, const Vec3& centre, const Vec3& velocity) const {
  Mat3 inertia = Mat3::Zero();
  Vec3 momentum = Vec3::Zero();
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const double weight = isPlaced() ? double(mass_[i] == 0) : mass_[i];
    const Vec3 arm = x[rowOf(i)] - centre;
    inertia += weight * arm * arm.transpose();
    momentum += weight * arm.cross(v[rowOf(i)] - velocity);
  }
  if (!hasAxis()) return solveInertia(inertia, momentum);
  const Vec3 line = axis(x), d = x[rowOf(leaders_.back())] - x[rowOf(leaders_[0])];
  const Vec3 across = line.cross(v[rowOf(leaders_.back())] - v[rowOf(leaders_[0])]) / d.norm();
  const Mat3 full = inertia.trace() * Mat3::Identity() - inertia;
  const double resistance = line.dot(full * line);
  return across + (resistance > 0 ? line.dot(momentum - full * across) / resistance : 0) * line;
}

double RigidConstraint::correctVelocities(const PositionStep& step, ConstRows x, Rows v) {
  const Vec3 centre = centreOf(x), velocity = centreOf(v), w = spin(x, v, centre, velocity);
  double change = 0, fastest = 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Vec3 rigid = velocity + w.cross(x[rowOf(i)] - centre);
    fastest = std::max(fastest, rigid.norm());
    if (mass_[i] == 0) continue;
    change = std::max(change, (rigid - v[rowOf(i)]).norm());
    v[rowOf(i)] = rigid;
  }
  return change / std::max(1e-12 * fastest, allowed_ / step.dt);
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(rigid_constraint) {
  factory.add<stroma::RigidConstraint>("RigidConstraint", "A set of nodes moves as one rigid body");
}
