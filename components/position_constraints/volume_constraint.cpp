// SPDX-License-Identifier: LGPL-2.1-or-later
// VolumeConstraint: the volume inside a closed surface is kept, whatever force that takes.
//
//   V(x) = 1/3 sum x_a . A_a(x) = V_target(t)
//
// with A_a the area vectors of the nodes of the faces, so that grad V at a node is the sum of those of its faces.
//
// After each step nodes of the surface move by lambda d with d = W grad V (W: inverse masses and free directions of the
// nodes; grad V points along their normals, at the start of the step). V(x + lambda d) is a cubic in lambda, so lambda
// is found exactly. No node moves by more than half the size of the body (cube root of its volume) at a time, and not
// beyond the lambda at which the volume turns: what cannot be reached so does not hold, and the step's report says it,
// because the other roots of the cubic turn a body inside out. Where nothing is held, the momentum and angular momentum
// of the step (of lumped masses, whatever the mass of the scene) do not change: grad V of a closed surface sums to
// zero, and so does its moment. Then the velocities lose the part that would change the volume (or get the part that
// the prescribed change asks for).
//
// The surface: the border of the tetrahedra and hexahedra of the topology, or its triangles and quads (turned outward
// all alike) when there are none. A quad is a bilinear patch.
//
// V_target is `volume`, or that of the rest shape, times a factor that may change over time (breathing). With fixed
// nodes, rigid sets and planes, all constraints of a system correct in turns until all hold.
//
// Source: Promayon, Baconnier, Puech 1996, as summarised in Nesme et al. 2005, section 4 (total incompressibility of a
// contour, constraints as non-quantified forces); corrections as in SHAKE and RATTLE.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-8"/>
//   <RegularGridTopology n="4 4 4" min="0 0 0" max="0.1 0.1 0.1"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="1"/>
//   <ShapeMemoryForceField stiffness="1000"/>
//   <VolumeConstraint/>
//   <PlaneConstraint normal="0 0 1" d="0"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "framework/mechanics/factor_over_time.h"
#include "framework/mechanics/position_constraint.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "framework/mesh/closed_surface.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// The coefficients of V(x + s d), a cubic in s. V is a symmetric form in three positions, so that with areas A(x) and
/// A(d) of the surface at x and of the one that has d for its positions
///   V(x + s d) = 1/3 sum x.A(x) + s sum d.A(x) + s^2 sum x.A(d) + s^3 1/3 sum d.A(d).
template <class Position, class Direction>
std::array<double, 4> volumeAlong(const std::vector<Face>& faces, const Position& position,
                                  const Direction& direction) {
  const Vec3 origin = position(faces[0].nodes[0]);
  std::array<double, 4> sums{};
  for (const Face& face : faces) {
    const area_vectors::Corners x = area_vectors::cornersOf(face, position, origin), d = area_vectors::cornersOf(face, direction);
    const area_vectors::Corners areas_x = area_vectors::of(x, face.corners), areas_d = area_vectors::of(d, face.corners);
    for (std::size_t a = 0; a < std::size_t(face.corners); ++a) {
      sums[0] += x[a].dot(areas_x[a]) / 3;
      sums[1] += d[a].dot(areas_x[a]);
      sums[2] += x[a].dot(areas_d[a]);
      sums[3] += d[a].dot(areas_d[a]) / 3;
    }
  }
  return sums;
}

/// a0 + a1 s + a2 s^2 + a3 s^3
struct Cubic {
  std::array<double, 4> a{};
  double at(double s) const { return ((a[3] * s + a[2]) * s + a[1]) * s + a[0]; }
  double slope(double s) const { return (3 * a[3] * s + 2 * a[2]) * s + a[1]; }
  /// The root in the piece around zero in which the cubic is monotonic, at most `reach` from zero; NaN when there is
  /// none. Roots of other pieces are solutions too, with a body that is turned inside out.
  double rootNearZero(double reach) const {
    double low = -reach, high = reach;
    const auto cut = [&](double turning) {
      if (turning <= 0) low = std::max(low, turning);
      if (turning >= 0) high = std::min(high, turning);
    };
    const double discriminant = a[2] * a[2] - 3 * a[1] * a[3];
    if (discriminant > 0) {
      const double q = -(a[2] + std::copysign(std::sqrt(discriminant), a[2]));
      if (a[3] != 0) cut(q / (3 * a[3]));
      if (q != 0) cut(a[1] / q);
    }
    return at(low) * at(high) > 0 ? NAN : rootBetween(low, high);
  }

 private:
  /// The root in [low, high], where the cubic is monotonic and changes its sign.
  double rootBetween(double low, double high) const {
    const bool rising = at(low) < 0;
    double s = std::clamp(0.0, low, high);
    for (int iteration = 0; iteration < 200; ++iteration) {
      ((at(s) < 0) == rising ? low : high) = s;
      double next = s - at(s) / slope(s);
      if (!(next > low && next < high)) next = low + (high - low) / 2;
      if (next == s || next == low || next == high) break;
      s = next;
    }
    return s;
  }
};

class VolumeConstraint final : public PositionConstraint {
 public:
  void declare(DataTable& table) override;
  void init() override;
  void compile() override { gradient_.resize(Index(nodes_.size())), direction_.resize(Index(nodes_.size())); }
  void begin(const PositionStep& step) override;
  double correctPositions(const PositionStep& step, Rows x, Rows reference) override;
  double correctVelocities(const PositionStep& step, ConstRows x, Rows v) override;
  std::string violation() const override {
    return fmt::format("the volume is {:.10g} m^3 instead of {:.10g} m^3{}", reached_, target_, stuck_);
  }
  std::string describe() const override {
    return fmt::format("volume behind {} faces kept at {:.6g} m^3{}", faces_.size(), volume_,
                       factor_.varies() ? " times a factor over time" : "");
  }

 private:
  void collectSurface(const Mesh& mesh);
  void checkClosed() const;
  void gradientAt(ConstRows x);

  TopologyLink topology_;
  double volume_ = 0, tolerance_ = 1e-12;
  FactorOverTime factor_;

  std::vector<Index> nodes_;  ///< of the surface, ascending
  std::vector<Face> faces_;   ///< of indices in nodes_
  Vector gradient_;           ///< grad V [m^2], shape (nodes_)
  Vector direction_;          ///< W grad V, shape (nodes_)
  double target_ = 0, rate_ = 0, reached_ = 0;
  double allowed_ = 0;      ///< tolerance of this step [m^3]
  const char* stuck_ = "";  ///< why the volume cannot be reached, the end of a sentence
  bool gradient_is_new_ = false;
};

void VolumeConstraint::declare(DataTable& table) {
  PositionConstraint::declare(table);
  topology_.declare(table, "mesh that holds the surface");
  table.add("volume", volume_).unit("m^3").help("volume to keep; 0: that of the rest shape").min(0);
  factor_.declare(table, "the volume", FactorOverTime::Sign::positive);
  table.add("tolerance", tolerance_)
      .unit("-")
      .min(0, false)
      .help("tolerated relative error of the volume; never below that from the round-off of positions");
}

void VolumeConstraint::init() {
  PositionConstraint::init();
  factor_.check();
  const Topology* topology = topology_.find(*this, state(), MeshNodes::first);
  if (!topology) throw ComponentError("there is no mesh", "a topology with a closed surface in this node or above");
  collectSurface(topology->mesh());
  if (faces_.empty())
    throw ComponentError(fmt::format("{} has no surface", topology->path()), "volume cells, or triangles or quads");
  const double rest =
      area_vectors::volumeBehind(faces_, [this](Index i) -> const Vec3& { return state().rest_position[nodes_[i]]; });
  if (!(rest > 0))
    throw ComponentError(fmt::format("the surface encloses a volume of {:.6g} m^3", rest), "faces that are turned outward",
                         "turn every triangle and quad round");
  if (volume_ == 0) volume_ = rest;
}

void VolumeConstraint::collectSurface(const Mesh& mesh) {
  const bool solid = highestDimension(mesh) == 3;
  if (mesh.overlap != 1 && solid)
    throw ComponentError("the cells cover the body more than once, so they have no single border",
                         "a mesh that covers it once, or its surface as triangles");
  const auto& triangles = solid ? mesh.boundaryTriangles() : mesh.triangles;
  const auto& quads = solid ? mesh.boundaryQuads() : mesh.quads;
  faces_.assign(triangles.begin(), triangles.end());
  faces_.insert(faces_.end(), quads.begin(), quads.end());
  const auto& quadratic = solid ? mesh.boundaryQuadraticTriangles() : mesh.quadratic_triangles;
  faces_.insert(faces_.end(), quadratic.begin(), quadratic.end());
  checkClosed();
  std::vector<Index> index(std::size_t(state().size()), -1);
  for (const Face& face : faces_)
    for (const Index node : face.nodes) index[node] = 0;
  for (std::size_t node = 0; node < index.size(); ++node)
    if (index[node] == 0) index[node] = Index(nodes_.size()), nodes_.push_back(Index(node));
  for (Face& face : faces_)
    for (Index& node : face.nodes) node = index[node];
}

void VolumeConstraint::checkClosed() const {
  const auto open = firstOpenEdge(faces_);
  if (!open) return;
  const auto [a, b] = open->nodes;
  if (open->along + open->back == 1)
    throw ComponentError(fmt::format("the surface is open: edge {} {} belongs to one face only", a, b),
                         "a closed surface");
  throw ComponentError(
      fmt::format("the surface is badly turned: {} of the {} faces at edge {} {} run along it in the same direction",
                  std::max(open->along, open->back), open->along + open->back, a, b),
      "faces that are all turned outward");
}

// ---- a step ----

void VolumeConstraint::gradientAt(ConstRows x) {
  clear(gradient_);
  const auto position = [&](Index i) -> Vec3 { return x[row(nodes_[i])]; };
  const Vec3 origin = position(0);
  for (const Face& face : faces_) {
    const auto areas = area_vectors::of(area_vectors::cornersOf(face, position, origin), face.corners);
    for (std::size_t a = 0; a < std::size_t(face.corners); ++a) gradient_[face.nodes[a]] += areas[a];
  }
}

void VolumeConstraint::begin(const PositionStep& step) {
  target_ = volume_ * factor_.at(step.t_end);
  rate_ = factor_.varies() ? (target_ - volume_ * factor_.at(step.t_end - step.dt)) / step.dt : 0;
  gradientAt(step.x_start);
  gradient_is_new_ = false;
  double sizes = 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) sizes += gradient_[Index(i)].norm();
  allowed_ = std::max(tolerance_ * target_, roundOff(step.x_start, nodes_) * sizes);
}

double VolumeConstraint::correctPositions(const PositionStep& step, Rows x, Rows) {
  // lengths of direction_ are of the order of the body's, so that the cubic is well scaled
  double largest = 0, span = std::cbrt(volume_);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    direction_[Index(i)] = step.mobility.times(row(nodes_[i]), gradient_[Index(i)]);
    largest = std::max(largest, direction_[Index(i)].norm());
  }
  stuck_ = largest > 0 ? "" : ", and no node that may move would change it";
  if (largest > 0) scale(span / largest, direction_);
  Cubic volume{volumeAlong(
      faces_, [&](Index i) -> Vec3 { return x[row(nodes_[i])]; }, [this](Index i) -> Vec3 { return direction_[i]; })};
  reached_ = volume.a[0];
  const double violation = std::abs(reached_ - target_) / allowed_;
  if (*stuck_ || !(violation > 0)) return violation;
  for (double& coefficient : volume.a) coefficient /= target_;
  volume.a[0] -= 1;
  const double lambda = volume.rootNearZero(0.5);
  if (std::isnan(lambda)) {
    if (violation > 1) stuck_ = ", and no displacement by up to half the size of the body along its normals reaches it";
    return violation;
  }
  for (std::size_t i = 0; i < nodes_.size(); ++i) x[row(nodes_[i])] += lambda * direction_[Index(i)];
  return violation;
}

double VolumeConstraint::correctVelocities(const PositionStep& step, ConstRows x, Rows v) {
  if (!gradient_is_new_) gradientAt(x);
  gradient_is_new_ = true;
  double change = -rate_, stiffness = 0, fastest = 0, sizes = 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Index at = row(nodes_[i]);
    const Vec3 g = gradient_[Index(i)];
    change += g.dot(v[at]);
    sizes += g.norm();
    stiffness += g.dot(step.mobility.times(at, g));
    fastest = std::max(fastest, v[at].norm());
  }
  if (!(stiffness > 0)) return 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Index at = row(nodes_[i]);
    v[at] -= change / stiffness * step.mobility.times(at, gradient_[Index(i)]);
  }
  return std::abs(change) / std::max(1e-12 * (sizes * fastest + std::abs(rate_)), allowed_ / step.dt);
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(volume_constraint) {
  factory.add<stroma::VolumeConstraint>("VolumeConstraint", "Keeps the volume inside a closed surface");
}
