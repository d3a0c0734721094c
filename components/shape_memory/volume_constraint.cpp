// SPDX-License-Identifier: LGPL-2.1-or-later
// VolumeConstraint: the volume inside a closed surface is kept, whatever force that takes.
//
//   V(x) = 1/6 sum over triangles a.(b x c) = V_target(t)
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
// all alike) when there are none. A quad counts as the mean of its two cuttings, which is the volume under its bilinear
// patch.
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
#include <cmath>
#include <map>

#include "framework/mechanics/factor_over_time.h"
#include "framework/mechanics/position_constraint.h"
#include "framework/mesh/topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// a0 + a1 s + a2 s^2 + a3 s^3
struct Cubic {
  double a[4]{};
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
    return fmt::format("volume of {} triangles kept at {:.6g} m^3{}", faces_.size(), volume_,
                       factor_.varies() ? " times a factor over time" : "");
  }

 private:
  struct Face {
    Index a, b, c;  ///< indices in nodes_
    double weight;  ///< 1, or 1/2 for the halves of both cuttings of a quad
  };
  void addFace(Index a, Index b, Index c, double weight) { faces_.push_back({a, b, c, weight}); }
  void collectSurface(const Mesh& mesh);
  static void checkClosed(const std::vector<Triangle>& triangles, const std::vector<Quad>& quads);
  void gradientAt(ConstRows x);
  Cubic along(ConstRows x) const;

  Link<Topology> topology_{"topology"};
  double volume_ = 0, tolerance_ = 1e-12;
  FactorOverTime factor_;

  std::vector<Index> nodes_;  ///< of the surface, ascending
  std::vector<Face> faces_;
  Vector gradient_;   ///< grad V [m^2], shape (nodes_)
  Vector direction_;  ///< W grad V, shape (nodes_)
  double target_ = 0, rate_ = 0, reached_ = 0;
  double allowed_ = 0;      ///< tolerance of this step [m^3]
  const char* stuck_ = "";  ///< why the volume cannot be reached, the end of a sentence
  bool gradient_is_new_ = false;
};

void VolumeConstraint::declare(DataTable& table) {
  PositionConstraint::declare(table);
  table.addLink("topology", topology_).help("mesh that holds the surface; the node's own, or the nearest above");
  table.add("volume", volume_).unit("m^3").help("volume to keep; 0: that of the rest shape").min(0);
  factor_.declare(table, "the volume", FactorOverTime::Sign::positive);
  table.add("tolerance", tolerance_)
      .unit("-")
      .min(0, false)
      .help("relative error of the volume that counts as none; never below what the round-off of positions makes");
}

void VolumeConstraint::init() {
  PositionConstraint::init();
  factor_.check();
  const Topology* topology = topology_.target() ? topology_.get() : find<Topology>(true);
  if (!topology) throw ComponentError("there is no mesh", "a topology with a closed surface in this node or above");
  collectSurface(topology->mesh());
  if (faces_.empty())
    throw ComponentError(fmt::format("{} has no surface", topology->path()), "volume cells, or triangles or quads");
  double rest = 0;
  for (const Face& face : faces_) {
    const auto p = [&](Index i) {
      return Vec3(state().rest_position[std::size_t(nodes_[std::size_t(i)])] -
                  state().rest_position[std::size_t(nodes_[0])]);
    };
    rest += face.weight / 6 * p(face.a).dot(p(face.b).cross(p(face.c)));
  }
  if (!(rest > 0))
    throw ComponentError(fmt::format("the surface holds a volume of {:.6g} m^3", rest), "faces that are turned outward",
                         "turn every triangle and quad round");
  if (volume_ == 0) volume_ = rest;
}

void VolumeConstraint::collectSurface(const Mesh& mesh) {
  const bool solid = !mesh.tetrahedra.empty() || !mesh.hexahedra.empty();
  if (mesh.overlap != 1 && solid)
    throw ComponentError("the cells cover the body more than once, so they have no single border",
                         "a mesh that covers it once, or its surface as triangles");
  const auto& triangles = solid ? mesh.boundaryTriangles() : mesh.triangles;
  const auto& quads = solid ? mesh.boundaryQuads() : mesh.quads;
  checkClosed(triangles, quads);
  std::vector<Index> index(std::size_t(state().size()), -1);
  const auto mark = [&](const auto& cells) {
    for (const auto& cell : cells)
      for (const Index node : cell) {
        if (node >= state().size())
          throw ComponentError(
              fmt::format("the surface names node {} and {} has {}", node, state().path(), state().size()),
              "a mesh of the state's nodes");
        index[std::size_t(node)] = 0;
      }
  };
  mark(triangles), mark(quads);
  for (std::size_t node = 0; node < index.size(); ++node)
    if (index[node] == 0) index[node] = Index(nodes_.size()), nodes_.push_back(Index(node));
  const auto at = [&index](Index node) { return index[std::size_t(node)]; };
  for (const Triangle& t : triangles) addFace(at(t[0]), at(t[1]), at(t[2]), 1);
  for (const Quad& q : quads)
    for (std::size_t i = 0; i < 4; ++i) addFace(at(q[i]), at(q[(i + 1) % 4]), at(q[(i + 2) % 4]), 0.5);
}

/// Each edge must occur once in each direction.
void VolumeConstraint::checkClosed(const std::vector<Triangle>& triangles, const std::vector<Quad>& quads) {
  std::map<Edge, int> seen;
  const auto count = [&seen](const auto& cells) {
    for (const auto& cell : cells)
      for (std::size_t i = 0; i < cell.size(); ++i) ++seen[{cell[i], cell[(i + 1) % cell.size()]}];
  };
  count(triangles), count(quads);
  for (const auto& [edge, times] : seen) {
    const auto back = seen.find({edge[1], edge[0]});
    const int opposite = back == seen.end() ? 0 : back->second;
    if (times == opposite) continue;
    if (times + opposite == 1)
      throw ComponentError(fmt::format("the surface is open: edge {} {} belongs to one face only", edge[0], edge[1]),
                           "a closed surface");
    throw ComponentError(
        fmt::format("the surface is badly turned: {} of the {} faces at edge {} {} run along it in the same direction",
                    std::max(times, opposite), times + opposite, edge[0], edge[1]),
        "faces that are all turned outward");
  }
}

// ---- a step ----

void VolumeConstraint::gradientAt(ConstRows x) {
  clear(gradient_);
  const Vec3 origin = x[row(nodes_[0])];
  for (const Face& face : faces_) {
    const auto p = [&](Index i) { return Vec3(x[row(nodes_[std::size_t(i)])] - origin); };
    const Vec3 a = p(face.a), b = p(face.b), c = p(face.c);
    const double share = face.weight / 6;
    gradient_[face.a] += share * b.cross(c);
    gradient_[face.b] += share * c.cross(a);
    gradient_[face.c] += share * a.cross(b);
  }
}

/// V(x + s direction_)
Cubic VolumeConstraint::along(ConstRows x) const {
  Cubic v;
  const Vec3 origin = x[row(nodes_[0])];
  for (const Face& face : faces_) {
    const auto p = [&](Index i) { return Vec3(x[row(nodes_[std::size_t(i)])] - origin); };
    const Vec3 a = p(face.a), b = p(face.b), c = p(face.c);
    const Vec3 da = direction_[face.a], db = direction_[face.b], dc = direction_[face.c];
    const double share = face.weight / 6;
    v.a[0] += share * a.dot(b.cross(c));
    v.a[1] += share * (da.dot(b.cross(c)) + a.dot(db.cross(c)) + a.dot(b.cross(dc)));
    v.a[2] += share * (da.dot(db.cross(c)) + da.dot(b.cross(dc)) + a.dot(db.cross(dc)));
    v.a[3] += share * da.dot(db.cross(dc));
  }
  return v;
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
  Cubic volume = along(x);
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
