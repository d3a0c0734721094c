// SPDX-License-Identifier: LGPL-2.1-or-later
// BeamInterpolation: beams on the edges of a mesh, with the frames of a state at their ends and a cubic curve between them.
//
//   P(s) = (1-s)^3 P0 + 3 s (1-s)^2 P1 + 3 s^2 (1-s) P2 + s^3 P3
//   P0 = c_a,  P1 = P0 + L/3 q_a e_x,  P2 = P3 - L/3 q_b e_x,  P3 = c_b
//
// c and q are centre and orientation of the frames, whose x goes along the beam, and L is the length of the curve where the scene
// starts, found in three rounds from the distance of the frames. edgeList says which edges are beams; all when it is not given.
//
// straight: at rest a beam is a straight line of the length L along the x of both frames. Else it is at rest as the frames lie
// in the rest positions of the state. AdaptiveBeamForceFieldAndMass has the forces and the inertia of the beams.
//
//   circular:     A = pi (r^2 - r_i^2), Iy = Iz = pi (r^4 - r_i^4)/4, J = Iy + Iz
//   rectangular:  A = ly lz, Iy = ly lz^3/12, Iz = lz ly^3/12, J = Iy + Iz
//
// Source: names, attributes, defaults and formulas are those of the plug-in BeamAdapter for SOFA. J of a rectangle is there the
// polar moment too, larger than its torsion constant.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MeshTopology edges="0 1  1 2"/>
//   <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   0.5 0 0  0 0 0 1   1 0 0  0 0 0 1"/>
//   <BeamInterpolation name="beams" radius="0.01" defaultYoungModulus="1e9" defaultPoissonRatio="0.3"/>
//   <AdaptiveBeamForceFieldAndMass interpolation="@beams" massDensity="1000"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "components/beams/beam_chain.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// The length of the curve, by four Gauss points of its speed.
double lengthOf(const Placement& a, const Placement& b, double length) {
  const Vec3 start = length / 3 * (a.turn * Vec3::UnitX()), end = length / 3 * (b.turn * Vec3::UnitX());
  const Vec3 middle = (b.centre - end) - (a.centre + start);
  constexpr std::array<std::array<double, 2>, 2> points{
      {{0.33998104358485626, 0.6521451548625461}, {0.8611363115940526, 0.34785484513745385}}};
  double sum = 0;
  for (const auto& [place, weight] : points)
    for (const double sign : {-1., 1.}) {
      const double s = (1 + sign * place) / 2;
      sum += weight / 2 * (3 * (1 - s) * (1 - s) * start + 6 * s * (1 - s) * middle + 3 * s * s * end).norm();
    }
  return sum;
}

class BeamInterpolation final : public BeamChain {
 public:
  void declare(DataTable& table) override {
    BeamChain::declare(table);
    table.addChoice("crossSectionShape", shape_, {"circular", "rectangular"}).help("of the beams");
    table.add("radius", radius_).recompiled().help("of a circular section").unit("m").min(0, false);
    table.add("innerRadius", inner_).recompiled().help("of its bore").unit("m").min(0);
    table.add("lengthY", side_y_).help("side of a rectangular section along y").unit("m").min(0, false);
    table.add("lengthZ", side_z_).help("side of a rectangular section along z").unit("m").min(0, false);
    table.add("defaultYoungModulus", young_)
        .recompiled()
        .help("Young's modulus, one for all or one for each beam")
        .unit("Pa")
        .min(0, false)
        .physical();
    table.add("defaultPoissonRatio", poisson_)
        .help("Poisson's ratio, one for all or one for each beam")
        .unit("-")
        .min(-1, false)
        .max(0.5);
    table.add("straight", straight_).help("at rest beams are straight lines; else as the frames lie in the rest positions");
    table.add("dofsAndBeamsAligned", aligned_).help("false has an effect with DOF0TransformNode0 and DOF1TransformNode1 only");
    table.add("edgeList", edge_list_).help("edges of the mesh that are beams; all by default").min(0);
    table.add("lengthList", length_list_).help("of each beam; found from the frames by default").unit("m").min(0, false);
    table.add("DOF0TransformNode0", first_)
        .help("axes of beams in the frames of their first nodes, 0 0 0 and a quaternion; without dofsAndBeamsAligned")
        .inValuesOf(7);
    table.add("DOF1TransformNode1", second_).help("the same in the frames of their second nodes").inValuesOf(7);
    for (const char* name : {"sideLength", "smallRadius", "largeRadius", "beamCollision", "curvAbsList"}) table.addVisualOnly(name);
  }

  void init() override {
    BeamChain::init();
    for (const char* size : {"radius", "lengthY", "lengthZ"})
      if ((shape_ == Shape::circular) == (size[0] == 'r') && !data().find(size)->isSet())
        warn(fmt::format("{} is not given: the default {} m is used", size, data().find(size)->defaultText()));
    std::vector<int> chosen = edge_list_;
    if (const Data* list = data().find("edgeList"); list->isSet() && chosen.empty())
      warn("edgeList is given and empty: all edges are beams", "the edges that are beams");
    for (std::size_t i = 0; edge_list_.empty() && i < edges().size(); ++i) chosen.push_back(int(i));
    checkSizes(chosen.size());
    beams_.clear();
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      if (std::size_t(chosen[i]) >= edges().size())
        throw ComponentError(fmt::format("edgeList names edge {}", chosen[i]), fmt::format("0 to {}", edges().size() - 1));
      addBeam(i, edges()[std::size_t(chosen[i])]);
    }
    publish();
  }

  double wholeLength() const override {
    double sum = 0;
    for (const ChainBeam& beam : beams_) sum += beam.length;
    return sum;
  }

 private:
  void checkSizes(std::size_t beams) const {
    const auto check = [beams](const char* name, std::size_t numbers, std::size_t per_beam, bool may_be_one) {
      if (numbers == beams * per_beam || (may_be_one && numbers == per_beam)) return;
      throw ComponentError(fmt::format("{} has {} numbers for {} beams", name, numbers, beams),
                           may_be_one ? "one, or one for each beam" : fmt::format("{} for each beam", per_beam));
    };
    check("defaultYoungModulus", young_.size(), 1, true), check("defaultPoissonRatio", poisson_.size(), 1, true);
    if (!length_list_.empty()) check("lengthList", length_list_.size(), 1, false);
    if (aligned_ && !(first_.empty() && second_.empty()))
      throw ComponentError("DOF0TransformNode0 and DOF1TransformNode1 are given and dofsAndBeamsAligned is true",
                           "dofsAndBeamsAligned=\"false\"");
    if (!first_.empty()) check("DOF0TransformNode0", first_.size(), 7, false);
    if (!second_.empty()) check("DOF1TransformNode1", second_.size(), 7, false);
  }

  RodSection sectionOf(std::size_t beam) const {
    const double young = young_[young_.size() == 1 ? 0 : beam], poisson = poisson_[poisson_.size() == 1 ? 0 : beam];
    if (shape_ == Shape::circular) return roundSection(radius_, inner_, young, poisson);
    return {0,      side_y_ * side_z_, side_y_ * side_z_ * side_z_ * side_z_ / 12, side_z_ * side_y_ * side_y_ * side_y_ / 12, young,
            poisson};
  }

  /// `size`: how far the ends are apart [m].
  static Quaternion read(const std::vector<double>& all, std::size_t beam, double size) {
    constexpr double round_off = 1e-12;
    if (all.empty()) return Quaternion::Identity();
    const double* v = all.data() + 7 * beam;
    if (!(Vec3(v[0], v[1], v[2]).norm() <= round_off * size))
      throw ComponentError(fmt::format("beam {} does not begin or end at the centre of its frame, which is not supported", beam),
                           "0 0 0 and a quaternion");
    return Quaternion(v[6], v[3], v[4], v[5]).normalized();
  }

  void addBeam(std::size_t i, const Edge& edge) {
    ChainBeam beam;
    beam.a = edge[0], beam.b = edge[1];
    beam.section = sectionOf(i);
    const double apart = (placementOf(beam.b, false).centre - placementOf(beam.a, false).centre).norm();
    beam.axes_a = read(first_, i, apart), beam.axes_b = read(second_, i, apart);
    const auto end = [this](Index node, const Quaternion& axes, bool at_rest) {
      const Placement frame = placementOf(node, at_rest);
      return Placement{frame.centre, frame.turn * axes};
    };
    const Placement a = end(beam.a, beam.axes_a, false), b = end(beam.b, beam.axes_b, false);
    beam.length = (b.centre - a.centre).norm();
    if (!(beam.length > 0))
      throw ComponentError(fmt::format("beam {} (nodes {} {}) has no length", i, beam.a, beam.b), "two different places");
    for (int round = 0; round < 3; ++round) beam.length = lengthOf(a, b, beam.length);
    if (!length_list_.empty()) beam.length = length_list_[i];
    beam.from = i == 0 ? 0 : beams_.back().to, beam.to = beam.from + beam.length;
    if (straight_) {
      beam.rest_way = beam.length * Vec3::UnitX();
      warnWhereTurned(i, a, b);
    } else {
      const Placement rest_a = end(beam.a, beam.axes_a, true), rest_b = end(beam.b, beam.axes_b, true);
      beam.rest_way = rest_a.turn.conjugate() * (rest_b.centre - rest_a.centre);
      beam.rest_turn = rotationVector(rest_a.turn.conjugate() * rest_b.turn);
    }
    beams_.push_back(beam);
  }

  void warnWhereTurned(std::size_t beam, const Placement& a, const Placement& b) const {
    const Vec3 along = (b.centre - a.centre).normalized();
    if (along.dot(a.turn * Vec3::UnitX()) > 0.5 || is_warned_) return;
    warn(fmt::format("beam {} goes along {:.3g} {:.3g} {:.3g}, and the x of its first frame along {:.3g} {:.3g} {:.3g}: it starts far "
                     "from its "
                     "straight shape at rest",
                     beam, along.x(), along.y(), along.z(), (a.turn * Vec3::UnitX()).x(), (a.turn * Vec3::UnitX()).y(),
                     (a.turn * Vec3::UnitX()).z()),
         "frames whose x goes along the beams");
    is_warned_ = true;
  }

  enum class Shape : int { circular, rectangular } shape_ = Shape::circular;
  double radius_ = 1, inner_ = 0, side_y_ = 1, side_z_ = 1;
  std::vector<double> young_{1e5}, poisson_{0.4}, length_list_, first_, second_;
  std::vector<int> edge_list_;
  bool straight_ = true, aligned_ = true;
  mutable bool is_warned_ = false;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(beam_interpolation) {
  factory.add<stroma::BeamInterpolation>("BeamInterpolation", "beams between rigid frames, with a cubic curve between them");
}
