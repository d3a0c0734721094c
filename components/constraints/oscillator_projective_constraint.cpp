// SPDX-License-Identifier: LGPL-2.1-or-later
// OscillatorProjectiveConstraint: nodes that swing about a mean position, each in its own direction.
//
//   x(t) = mean + amplitude sin(pulsation t + phase),   v(t) = pulsation amplitude cos(pulsation t + phase)
//
// `oscillators` has nine numbers for each node: its index, the mean (x y z) [m], the amplitude (x y z) [m], the
// pulsation [rad/s] and the phase [rad]. With `indices` instead, the mean is the initial position of each listed node,
// and the amplitude is `translation` plus, for plates of a rheometer, rotation x (X - centre): a rotation vector
// [rad], small enough that paths along the tangent are those of a turning body (a radius grows by half the square of
// the angle); pulsation and phase are then those of the attributes. Rigid frames take `indices` only: their orientation is
// exp(sin(pulsation t + phase) rotation) q.
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

#include "framework/mechanics/frames.h"
#include "framework/mechanics/motion.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/projective_constraint.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class OscillatorProjectiveConstraint final : public ProjectiveConstraint {
 public:
  void declare(DataTable& table) override {
    ProjectiveConstraint::declare(table);
    table.add("oscillators", given_).help("for each node: index, mean x y z, amplitude x y z, pulsation, phase");
    table.add("indices", indices_).help("nodes that swing about their initial positions with the attributes below");
    table.add("translation", translation_).unit("m").help("amplitude of the nodes of indices");
    table.add("rotation", rotation_)
        .unit("rad")
        .help("rotation vector; its part of the amplitude is rotation x (X - centre)");
    table.add("centre", centre_).unit("m").help("a point of the rotation's axis");
    table.add("pulsation", pulsation_).unit("rad/s").help("of the nodes of indices");
    table.add("phase", phase_).unit("rad").help("of the nodes of indices");
  }

  void init() override {
    ProjectiveConstraint::init();
    constexpr std::size_t numbers = 9;
    if (given_.empty() == indices_.empty())
      throw ComponentError(given_.empty() ? "no node is named" : "oscillators and indices are both given",
                           "oscillators, or indices with translation, rotation, pulsation and phase");
    if (given_.size() % numbers != 0)
      throw ComponentError(fmt::format("oscillators has {} numbers", given_.size()), "nine for each node");
    const auto vector = [this](std::size_t i) { return Vec3(given_[i], given_[i + 1], given_[i + 2]); };
    std::vector<int> named = indices_;
    oscillators_.clear();
    for (std::size_t i = 0; i < given_.size(); i += numbers) {
      named.push_back(int(given_[i]));
      if (given_[i] != named.back())
        throw ComponentError(fmt::format("{} is no index of a node", given_[i]), "an integer");
      oscillators_.push_back({named.back(), vector(i + 1), vector(i + 4), given_[i + 7], given_[i + 8]});
    }
    const std::vector<Index> rows = checkedNodesInOrder(named, state(), given_.empty() ? "indices" : "oscillators");
    if (!state().hasPointsOnly() && !(state().hasFrames() && given_.empty()))
      throw ComponentError(fmt::format("the nodes of {} are no points", state().path()),
                           "points; or indices of rigid frames with translation and rotation");
    for (const Index node : given_.empty() ? rows : std::vector<Index>()) {
      const Vec3& mean = state().position[std::size_t(node)];
      oscillators_.push_back({node, mean, translation_ + rotation_.cross(mean - centre_), pulsation_, phase_});
    }
  }

  bool prescribesMotion() const override { return true; }
  void addProjectors(double, std::vector<NodeProjector>& out) const override {
    for (const Oscillator& o : oscillators_)
      for (Index k = 0; k < state().rows_per_node; ++k) out.push_back({state().firstRow() + o.node + k, Mat3::Zero()});
  }
  void prescribe(double t, Rows x, Rows v) const override {
    for (const Oscillator& o : oscillators_) {
      const double angle = o.pulsation * t + o.phase;
      x[state().firstRow() + o.node] = o.mean + std::sin(angle) * o.amplitude;
      v[state().firstRow() + o.node] = o.pulsation * std::cos(angle) * o.amplitude;
      if (!state().hasFrames()) continue;
      const Index turn = state().firstRow() + o.node + 1;
      placeRow(RowKind::turn, state().position[std::size_t(o.node + 1)], x, turn);
      Motion::turnBy(std::sin(angle) * rotation_, x.data + std::size_t(turn) * row_doubles);
      v[turn] = o.pulsation * std::cos(angle) * rotation_;
    }
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  struct Oscillator {
    Index node;               ///< first row
    Vec3 mean, amplitude;     ///< [m]
    double pulsation, phase;  ///< [rad/s], [rad]
  };
  std::vector<double> given_;
  std::vector<int> indices_;
  Vec3 translation_ = Vec3::Zero(), rotation_ = Vec3::Zero(), centre_ = Vec3::Zero();
  double pulsation_ = 0, phase_ = 0;
  std::vector<Oscillator> oscillators_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(oscillator_projective_constraint) {
  factory.add<stroma::OscillatorProjectiveConstraint>("OscillatorProjectiveConstraint",
                                                      "Nodes that swing about a mean position");
}
