// SPDX-License-Identifier: LGPL-2.1-or-later
// BeamFEMForceField: beams of round section between rigid frames, for turns of any size and small strains.
//
// The axes of a beam are fixed in the frames of both of its ends: x from end a to end b at rest. With p and psi as the axes of
// b lie in those of a, the twist that leads from a to b along a helix is (rho, psi), rho = dexp^-1(psi) p, and
//
//   E = EA/2L (rho_x - L)^2 + GJ/2L psi_x^2 + EI/2L (psi_y^2 + psi_z^2) + 6 EI/L^3 (rho_y^2 + rho_z^2)
//   A = pi (r^2 - r_i^2),  I = pi (r^4 - r_i^4)/4,  J = 2 I,  G = E/(2 (1 + nu))
//
// For small displacements that is the matrix of Euler and Bernoulli, cubic in bending and without shear: loads at the ends
// of beams are exact. A beam that bends to an arc has no stretch, whatever the angle between its ends below half a turn.
// Forces and torques are those of the energy: they balance to round-off. Frames have a mass of their own: beams have none.
//
// axes = firstEnd has SOFA's forces instead (first_end_beam.h): the axes of a beam are those of the frame of its first end, and x
// is taken for its direction whatever it is.
//
// listSegment says which edges of the mesh are beams; all when it is not given.
//
// Source: names, attributes and the matrix at rest are SOFA's. The twist is
// that of V. Sonneville, A. Cardona and O. Bruels, "Geometrically exact beam finite element formulated on the special
// Euclidean group SE(3)", 2014, with the bending of Euler and Bernoulli in the place of shear.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MeshTopology edges="0 1  1 2"/>
//   <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   0.5 0 0  0 0 0 1   1 0 0  0 0 0 1"/>
//   <UniformMass totalMass="0.1" inertia="1e-5 1e-5 1e-5"/>
//   <BeamFEMForceField youngModulus="1e9" poissonRatio="0.3" radius="0.01"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <ConstantForceField indices="2" forces="0 -1 0  0 0 0"/>
// </Node>
#include <fmt/format.h>

#include <numbers>

#include "components/beams/first_end_beam.h"
#include "components/beams/frame_pair_field.h"
#include "components/beams/twist_wrench.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// From one direction to another. (Quaternion::FromTwoVectors has a singular value decomposition for opposite ones, which
/// takes a compiler many seconds.)
Quaternion shortestTurn(const Vec3& from, const Vec3& to) {
  const Vec3 a = from.normalized(), b = to.normalized();
  const double cosine = b.dot(a);
  if (cosine < -1 + 1e-12) return Quaternion(Eigen::AngleAxisd(std::numbers::pi, a.unitOrthogonal()));
  const double s = std::sqrt((1 + cosine) * 2);
  const Vec3 axis = a.cross(b) * (1 / s);
  return {s * 0.5, axis.x(), axis.y(), axis.z()};
}

class BeamFEMForceField final : public FramePairFieldOf<BeamFEMForceField> {
 public:
  void declare(DataTable& table) override {
    FramePairField::declare(table);
    table.add("youngModulus", young_).recompiled().help("Young's modulus").unit("Pa").min(0, false).physical();
    table.add("poissonRatio", poisson_).help("Poisson's ratio").unit("-").min(-1, false).max(0.5).physical();
    table.add("radius", radius_).recompiled().help("outer radius of the section").unit("m").min(0, false).physical();
    table.add("radiusInner", inner_).help("inner radius of a tube").unit("m").min(0);
    table.add("listSegment", segments_).help("edges of the mesh that are beams; all by default");
    table.add("partialListSegment", by_list_).help("SOFA's; without effect: listSegment is used where it is given");
    table.addChoice("axes", axes_, {"beam", "firstEnd"})
        .help(
            "beam: along the beam, fixed in both frames; firstEnd: those of the first frame, whose x is taken for the beam's, as in "
            "SOFA");
    for (const char* name : {"useSymmetricAssembly", "isTimoshenko"}) table.addVisualOnly(name);
    topology_.declare(table, "mesh whose edges are beams");
  }

  void init() override {
    ForceField::init();
    const std::vector<Edge>& edges = topology_.meshWith(cell_kinds::edge, *this, state()).edges;
    std::vector<int> chosen = segments_;
    if (chosen.empty())
      for (std::size_t i = 0; i < edges.size(); ++i) chosen.push_back(int(i));
    const std::vector<Vec3>& rest = state().rest_position;
    std::vector<Pair> pairs;
    lengths_.clear();
    for (const int edge : chosen) {
      if (edge < 0 || std::size_t(edge) >= edges.size())
        throw ComponentError(fmt::format("listSegment names edge {}", edge), fmt::format("0 to {}", edges.size() - 1));
      const auto [a, b] = edges[std::size_t(edge)];
      const Vec3 along = rest[std::size_t(2 * b)] - rest[std::size_t(2 * a)];
      if (!(along.norm() > 0))
        throw ComponentError(fmt::format("beam {} (nodes {} {}) has no length", edge, a, b), "two different places");
      const Quaternion turn_a = turnedBy(rest[std::size_t(2 * a + 1)]), turn_b = turnedBy(rest[std::size_t(2 * b + 1)]);
      const Quaternion axes = shortestTurn(turn_a * Vec3::UnitX(), along) * turn_a;
      pairs.push_back({2 * a, 2 * b, turn_a.conjugate() * axes, turn_b.conjugate() * axes, 0});
      lengths_.push_back(along.norm());
    }
    setPairs(std::move(pairs));
    batch_lengths_.clear();
    takeSection();
  }
  // The pairs stay.
  void recompile() override { takeSection(); }

  void compile() override {
    FramePairField::compile();
    if (batch_lengths_.size() == batches()) return;
    batch_lengths_ = lanesOf<1>(lengths_.size(), [this](std::size_t i, std::size_t) { return lengths_[i]; });
  }

  double energy(ConstRows x) const override {
    if (axes_ == Axes::beam) return FramePairFieldOf::energy(x);
    double sum = 0;
    for (std::size_t i = 0; i < beams_.size(); ++i) sum += beams_[i].energy(x, rows_[i]);
    return sum;
  }
  void addForce(ConstRows x, ConstRows v, Rows f) override {
    if (axes_ == Axes::beam) return FramePairField::addForce(x, v, f);
    turns_.resize(beams_.size());
    for (std::size_t i = 0; i < beams_.size(); ++i) {
      beams_[i].addForce(x, rows_[i], f);
      turns_[i] = orientationIn(x, rows_[i][1]).toRotationMatrix();
    }
    outdateTangents();
  }

  ForceTraits traits() const override {
    ForceTraits traits = FramePairField::traits();
    const bool has_energy = axes_ == Axes::beam;
    traits.forces_balance = traits.has_rest_shape = true;
    traits.conservative = traits.exact_tangent = traits.torques_balance = has_energy;
    return traits;
  }

  std::string worstElement(ConstRows x) const override {
    std::size_t worst = 0;
    double most = -1, turn = 0;
    for (std::size_t i = 0; i < pairs().size(); ++i) {
      const double length = (x[rows_[i][2]] - x[rows_[i][0]]).norm();
      if (const double strain = std::abs(length / lengths_[i] - 1); strain > most) {
        most = strain;
        worst = i;
      }
    }
    if (most < 0) return {};
    turn = rotationVector((orientationIn(x, rows_[worst][1]) * pairs()[worst].axes_a).conjugate() *
                          (orientationIn(x, rows_[worst][3]) * pairs()[worst].axes_b))
               .norm();
    return fmt::format("beam {} (nodes {} {}): length {:.4g} m, at rest {:.4g} m, {:.3g} rad between its ends", worst,
                       pairs()[worst].a / 2, pairs()[worst].b / 2, (1 + most) * lengths_[worst], lengths_[worst], turn);
  }

 protected:
  double drawnRadius() const override { return radius_; }

 private:
  friend FramePairFieldOf;
  enum class Axes : int { beam, firstEnd };
  /// Numbers of the section, and what follows from them.
  void takeSection() {
    if (!(inner_ < radius_))
      throw ComponentError(fmt::format("radiusInner is {:g} and radius {:g}", inner_, radius_), "radiusInner < radius");
    const double squares = radius_ * radius_ + inner_ * inner_;
    const double area = std::numbers::pi * (radius_ * radius_ - inner_ * inner_), second_moment = area * squares / 4;
    axial_ = young_ * area;
    bending_ = young_ * second_moment;
    twisting_ = bending_ / (1 + poisson_);
    if (axes_ == Axes::beam) return;
    const std::vector<Vec3>& rest = state().rest_position;
    beams_.clear();
    for (const Pair& pair : pairs())
      beams_.emplace_back(axial_, bending_, twisting_, rest[std::size_t(pair.a)], turnedBy(rest[std::size_t(pair.a + 1)]),
                          rest[std::size_t(pair.b)], turnedBy(rest[std::size_t(pair.b + 1)]));
  }
  void computeTangents() const override {
    if (axes_ == Axes::beam) return FramePairFieldOf::computeTangents();
    for (std::size_t i = 0; i < beams_.size(); ++i) beams_[i].setTangent(turns_[i], stiffness_[i]);
  }
  /// twist_wrench.h has the formulas.
  template <class T>
  Wrench<T> evaluate(std::size_t batch, const Triple<T>& p, const Triple<T>& psi, const InverseTerm<Pack>& term) const {
    const Pack length = packOf(batch_lengths_[batch][0]), stretch = axial_ / length, bend = bending_ / length;
    const Pack twist = twisting_ / length, shear = 12. * bend / (length * length);
    const T square = dot(psi, psi);
    const T c = chain(square, term.c, term.c1), slope = chain(square, 2. * term.c1, 2. * term.c2);
    const Triple<T> rho = inverseTimes(psi, c, p);
    const Triple<T> s{T(stretch) * (rho.x - T(length)), T(shear) * rho.y, T(shear) * rho.z};
    const Triple<T> couple{T(twist) * psi.x, T(bend) * psi.y, T(bend) * psi.z};
    Wrench<T> wrench;
    setTwistWrench(p, psi, c, slope, square, s, couple, wrench);
    wrench.energy = 0.5 * (valueOf(s.x) * (valueOf(rho.x) - length) + valueOf(s.y) * valueOf(rho.y) +
                           valueOf(s.z) * valueOf(rho.z) + valueOf(dot(couple, psi)));
    return wrench;
  }

  double young_ = 5000, poisson_ = 0.45, radius_ = 0.1, inner_ = 0;
  std::vector<int> segments_;
  bool by_list_ = false;
  Axes axes_ = Axes::beam;
  std::vector<FirstEndBeam> beams_;  ///< of axes firstEnd
  std::vector<Mat3> turns_;          ///< R_a of the last addForce(), of these
  TopologyLink topology_;
  std::vector<double> lengths_;                    ///< [m]
  std::vector<LanesOf<1>> batch_lengths_;          ///< the same of each batch of pairs
  double axial_ = 0, bending_ = 0, twisting_ = 0;  ///< EA [N], EI and GJ [N m^2]
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(beam_fem_force_field) {
  factory.add<stroma::BeamFEMForceField>("BeamFEMForceField", "beams of round section between rigid frames");
}
