// SPDX-License-Identifier: LGPL-2.1-or-later
// BeamLinearMapping: points on and around a chain of beams between consecutive rigid frames.
//
//   x = (1 - s) (c_j + q_j L_j u) + s (c_j+1 + q_j+1 L_j (u - e_x)),   s = 3 u_x^2 - 2 u_x^3
//
// L_j is the initial distance of the frames j and j + 1. u, for the beam j, is measured along x of frame 0, as if the chain
// were straight: with p the position of the point in the axes of frame 0, j is the beam whose span contains p_x, and u is (p_x
// minus the lengths before, p_y, p_z) / L_j. Before the first frame and behind the last the formula of the end beam is
// extrapolated. With localCoord the positions of the points are (j + u_x, u_y, u_z) themselves. The points start where the
// frames have them.
//
// Source: the formula and the attributes are SOFA's. Scenes in its dialect leave out the geometric stiffness, as it does.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   1 0 0  0 0 0 1   2 0 0  0 0 0 1"/>
//   <MeshTopology edges="0 1  1 2"/>
//   <UniformMass totalMass="1" inertia="0.01 0.01 0.01"/>
//   <BeamFEMForceField radius="0.1" youngModulus="1e6" poissonRatio="0.3"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <Node name="surface">
//     <MechanicalObject position="0.5 0.1 0  1.5 0.1 0  2 0 0.1"/>
//     <BeamLinearMapping/>
//     <ConstantForceField indices="2" forces="0 0 1"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "components/mappings/frame_mapping.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class BeamLinearMapping final : public FrameMapping {
 public:
  void declare(DataTable& table) override {
    FrameMapping::declare(table);
    table.add("localCoord", is_local_).help("the points are given by beam and place on it");
  }

  void init() override {
    FrameMapping::init();
    start();
    if (!output().hasPointsOnly()) throw ComponentError(output().path() + " has other nodes than points", "points");
    if (input().nodes() < 2) throw ComponentError(input().path() + " has one frame", "two or more: a beam lies between two");
    std::vector<double> lengths;
    for (Index j = 0; j + 1 < input().nodes(); ++j) {
      lengths.push_back((centre(j + 1) - centre(j)).norm());
      if (!(lengths.back() > 0))
        throw ComponentError(fmt::format("frames {} and {} of {} are at one place", j, j + 1, input().path()), "beams with a length");
    }
    for (const Vec3& place : std::vector<Vec3>(output().position)) {
      const Vec3 along = is_local_ ? place : placeAlong(place, lengths);
      const Index j = std::clamp(Index(std::floor(along[0])), Index(0), Index(lengths.size()) - 1);
      const Vec3 u = along - double(j) * Vec3::UnitX();
      const double s = u[0] * u[0] * (3 - 2 * u[0]), length = lengths[std::size_t(j)];
      addPoint({{j, 1 - s, length * u}, {j + 1, s, length * (u - Vec3::UnitX())}});
    }
    placeChild(false);
  }

 private:
  /// Beams and their share along x, in lengths of the beam across.
  Vec3 placeAlong(const Vec3& place, const std::vector<double>& lengths) const {
    Vec3 p = orientation(0).conjugate() * (place - centre(0));
    std::size_t j = 0;
    while (j < lengths.size() && p[0] >= lengths[j]) p[0] -= lengths[j++];
    p /= lengths[std::min(j, lengths.size() - 1)];
    p[0] += double(j);
    return p;
  }
  bool is_local_ = false;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(beam_linear_mapping) {
  factory.add<stroma::BeamLinearMapping>("BeamLinearMapping", "points about a chain of beams");
}
