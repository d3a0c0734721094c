// SPDX-License-Identifier: LGPL-2.1-or-later
// OscillatorProjectiveConstraint: nodes that swing about a mean position, each in its own direction.
//
//   x(t) = mean + amplitude sin(pulsation t + phase),   v(t) = pulsation amplitude cos(pulsation t + phase)
//
// `oscillators` has nine numbers for each node: its index, the mean (x y z) [m], the amplitude (x y z) [m], the
// pulsation [rad/s] and the phase [rad]. Of a rigid frame it has sixteen: the mean has seven numbers (centre and quaternion) and
// the amplitude six (of the centre, and a rotation vector [rad] in fixed axes).
//
// With `indices` instead, the mean is the initial position of each listed node, and the amplitude is `translation` plus, for
// plates of a rheometer, rotation x (X - centre): a rotation vector [rad], small enough that paths along the tangent are those of
// a turning body (a radius grows by half the square of the angle); pulsation and phase are then those of the attributes. The
// orientation of a frame is exp(sin(pulsation t + phase) rotation) q, with q the mean one.
//
// Source: name and `oscillators` are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="0.3"/>
//   <SpringForceField springsIndices1="0 1" springsIndices2="1 2" lengths="1 1" stiffness="200"/>
//   <OscillatorProjectiveConstraint oscillators="0  0 0 0  0 0.1 0  6.28 0"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "framework/mechanics/signs.h"
#include "framework/mechanics/motion.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/projective_constraint.h"
#include "framework/mechanics/right_side.h"
#include "framework/mechanics/start_velocity.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class OscillatorProjectiveConstraint final : public ProjectiveConstraint, public StartVelocity, public ProjectsRightSide {
 public:
  void declare(DataTable& table) override {
    ProjectiveConstraint::declare(table);
    table.add("oscillators", given_).help("for each node: index, mean, amplitude, pulsation, phase");
    table.add("indices", indices_).help("nodes that swing about their initial positions with the attributes below");
    table.add("translation", translation_).unit("m").help("amplitude of the nodes of indices");
    table.add("rotation", rotation_)
        .unit("rad")
        .help("rotation vector; its part of the amplitude is rotation x (X - centre)");
    table.add("centre", centre_).unit("m").help("a point of the rotation's axis");
    table.add("pulsation", pulsation_).unit("rad/s").help("of the nodes of indices");
    table.add("phase", phase_).unit("rad").help("of the nodes of indices");
    table.add("late", late_).help("in a step the nodes go where they were to be at its start, with velocities of then, as SOFA's");
    table.add("inMatrix", in_matrix_)
        .help("false: the nodes are free in the matrix of an implicit step of one linear solve, and are placed after it: SOFA's way with "
              "assembled matrices");
  }

  void init() override {
    ProjectiveConstraint::init();
    const bool frames = state().hasFrames();
    const std::size_t numbers = frames ? 16 : 9, amplitude = frames ? 8 : 4;  // of each node, and where its amplitude begins
    if (given_.empty() == indices_.empty())
      throw ComponentError(given_.empty() ? "no node is named" : "oscillators and indices are both given",
                           "oscillators, or indices with translation, rotation, pulsation and phase");
    if (given_.size() % numbers != 0)
      throw ComponentError(fmt::format("oscillators has {} numbers", given_.size()),
                           frames ? "sixteen for each frame" : "nine for each node");
    const auto vector = [this](std::size_t i) { return Vec3(given_[i], given_[i + 1], given_[i + 2]); };
    std::vector<int> named = indices_;
    oscillators_.clear();
    for (std::size_t i = 0; i < given_.size(); i += numbers) {
      named.push_back(int(given_[i]));
      if (given_[i] != named.back())
        throw ComponentError(fmt::format("{} is no index of a node", given_[i]), "an integer");
      Oscillator o{named.back(), vector(i + 1), vector(i + amplitude), given_[i + numbers - 2], given_[i + numbers - 1]};
      if (frames) {
        const Quaternion turn(given_[i + 7], given_[i + 4], given_[i + 5], given_[i + 6]);
        if (!(turn.norm() > 0)) throw ComponentError("oscillators has an orientation of length zero", "x y z w of length 1");
        o.mean_turn = signedRotationVector(turn.normalized()), o.swing = vector(i + amplitude + 3);
      }
      oscillators_.push_back(o);
    }
    const std::vector<Index> rows = checkedNodesInOrder(named, state(), given_.empty() ? "indices" : "oscillators");
    if (!state().hasPointsOnly() && !frames)
      throw ComponentError(fmt::format("the nodes of {} are no points", state().path()), "points or rigid frames");
    for (std::size_t i = 0; i < oscillators_.size(); ++i) oscillators_[i].node = rows[i];
    for (const Index node : given_.empty() ? rows : std::vector<Index>()) {
      const Vec3& mean = state().position[std::size_t(node)];
      oscillators_.push_back({node, mean, translation_ + rotation_.cross(mean - centre_), pulsation_, phase_});
      if (frames) {
        oscillators_.back().mean_turn = state().position[std::size_t(node + 1)];
        oscillators_.back().swing = rotation_;
      }
    }
  }

  bool prescribesMotion() const override { return true; }
  void addProjectors(double, std::vector<NodeProjector>& out) const override {
    for (const Oscillator& o : oscillators_)
      for (Index k = 0; k < state().rows_per_node; ++k)
        out.push_back({state().firstRow() + o.node + k, in_matrix_ ? Mat3(Mat3::Zero()) : Mat3(Mat3::Identity())});
  }
  bool leavesMatrix() const override { return !in_matrix_; }
  void projectRightSide(Rows b) const override {
    for (const Oscillator& o : oscillators_)
      for (Index k = 0; k < state().rows_per_node; ++k) b[state().firstRow() + o.node + k] = Vec3(Vec3::Zero());
  }
  bool keepsStartVelocity() const override { return late_; }
  void placeStart(double t, Rows x, Rows v) const override {
    if (late_ && activeIn(t, t)) prescribe(t, x, v);  // SOFA projects before the first step too
  }
  void prescribe(double time, Rows x, Rows v) const override {
    const double t = std::max(time - (late_ ? node().dt() : 0), std::min(time, node().root().root_time));
    for (const Oscillator& o : oscillators_) {
      const double angle = o.pulsation * t + o.phase;
      x[state().firstRow() + o.node] = o.mean + std::sin(angle) * o.amplitude;
      v[state().firstRow() + o.node] = o.pulsation * std::cos(angle) * o.amplitude;
      if (!state().hasFrames()) continue;
      const Index turn = state().firstRow() + o.node + 1;
      placeRow(RowKind::turn, o.mean_turn, x, turn);
      Motion::turnBy(std::sin(angle) * o.swing, x.data + std::size_t(turn) * row_doubles);
      v[turn] = o.pulsation * std::cos(angle) * o.swing;
    }
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  struct Oscillator {
    Index node;               ///< first row
    Vec3 mean, amplitude;     ///< [m]
    double pulsation, phase;  ///< [rad/s], [rad]
    Vec3 mean_turn = Vec3::Zero(), swing = Vec3::Zero();  ///< of frames [rad]
  };
  std::vector<double> given_;
  std::vector<int> indices_;
  Vec3 translation_ = Vec3::Zero(), rotation_ = Vec3::Zero(), centre_ = Vec3::Zero();
  double pulsation_ = 0, phase_ = 0;
  bool late_ = false, in_matrix_ = true;
  std::vector<Oscillator> oscillators_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(oscillator_projective_constraint) {
  factory.add<stroma::OscillatorProjectiveConstraint>("OscillatorProjectiveConstraint",
                                                      "Nodes that swing about a mean position");
}
