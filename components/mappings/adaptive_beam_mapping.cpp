// SPDX-License-Identifier: LGPL-2.1-or-later
// AdaptiveBeamMapping: points on and around the beams of a BeamInterpolation or a WireBeamInterpolation.
//
//   x = w_a (c_a + q_a p_a) + w_b (c_b + q_b p_b)
//   w_a = (1-s)^3 + 3 s (1-s)^2,   p_a = s (1-s)^2/w_a L e_x + (0, y, z),   w_b = 1 - w_a,   p_b = -s^2 (1-s)/w_b L e_x + (0, y, z)
//
// which is the cubic curve between the frames of both ends (beam_interpolation.cpp), with the offsets y and z, rotated with
// the ends. Forces on the points act on the curve: a load between two nodes bends the beams as in the closed form.
//
// `points` has (l, y, z) for each node, l the length of the rod from its handle on; without useCurvAbs the number of the beam
// plus s. They are the positions of the nodes by default. Nodes on a part of a rod that is not pushed out are at the opening.
// As a rod is pushed, nodes keep their position on it.
//
// Source: names, attributes and formulas are those of the plug-in BeamAdapter for SOFA, which turns the offsets of places on the
// curve by an axis between those of the ends, and those of forces as here.
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
//   <Node name="skin">
//     <MechanicalObject position="0.25 0 0  0.75 0.01 0  1 0 0.01"/>
//     <AdaptiveBeamMapping interpolation="@../beams"/>
//     <ConstantForceField indices="1" forces="0 0 0.1"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "components/mappings/points_on_beams.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class AdaptiveBeamMapping final : public PointsOnBeams {
 public:
  void declare(DataTable& table) override {
    FrameMapping::declare(table);
    table.addLink("interpolation", link_).help("the beams; those of a node above by default");
    table.add("points", points_).help("places on the rod: length, and offsets along y and z; the positions of the nodes by default")
        .unit("m");
    table.add("useCurvAbs", by_length_).help("the first number of a point is a length of the rod, not the number of a beam");
    table.add("nbPointsPerBeam", per_beam_).help("SOFA's; only 0 is supported").unit("-");
    table.add("contactDuplicate", is_copy_).help("SOFA's; only false is supported");
    table.add("proximity", proximity_).help("SOFA's; only 0 is supported").unit("m");
    for (const char* name : {"nameOfInputMap", "segmentsCurvAbs"}) table.addVisualOnly(name);
  }

  void init() override {
    FrameMapping::init();
    start();
    if (per_beam_ != 0) throw ComponentError("nbPointsPerBeam is given: a number of nodes that changes is not supported", "points");
    if (is_copy_ || proximity_ != 0)
      throw ComponentError("contactDuplicate and proximity are not supported", "a mapping without them, and the distance in the contact");
    if (!output().hasPointsOnly()) throw ComponentError(output().path() + " has other nodes than points", "points");
    findBeams();
    if (points_.empty()) points_ = output().position;
    if (Index(points_.size()) != output().nodes())
      throw ComponentError(fmt::format("points has {} places, and {} has {} nodes", points_.size(), output().path(), output().nodes()),
                           "a position in the state for each point");
    attach();
    placeChild(false);
  }

  /// Rods come out at the start of a step.
  void apply(Rows x) const override {
    if (*beams_ != known_) self_->start(), self_->attach();
    FrameMapping::apply(x);
  }

 private:
  struct Out {
    Beam beam;
    double from, to;  ///< lengths of the rod [m]
  };

  /// Another family has them: by their role and its attribute.
  void findBeams() {
    Component* chain = link_.get();
    for (Node* here = &node(); !chain && !link_.target() && here; here = here->parent())
      for (const auto& other : here->components())
        if (!chain && other->roleText() == role) chain = other.get(), chain->ensureReady();
    const Data* data = chain ? chain->data().find("beams") : nullptr;
    const auto* const* found = data ? std::get_if<std::vector<double>*>(&data->pointer()) : nullptr;
    if (!found) throw ComponentError("there are no beams to follow",
                                   "interpolation=\"@...\", a BeamInterpolation or a WireBeamInterpolation");
    beams_ = *found;
    changes_ = chain->data().find("WireRestShape") != nullptr;
    for (std::size_t i = 0; i + 1 < beams_->size(); i += 14)
      if ((*beams_)[i] >= double(input().nodes()) || (*beams_)[i + 1] >= double(input().nodes()))
        throw ComponentError(fmt::format("{} joins frames that {} does not have", chain->path(), input().path()), "the state of the beams");
  }

  void attach() {
    known_ = *beams_;
    std::vector<Out> out;
    for (std::size_t i = 0; i < known_.size(); i += 14) {
      const double* n = known_.data() + i;
      if (n[2] != 0)
        out.push_back({{Index(n[0]), Index(n[1]), n[3], Quaternion(n[9], n[6], n[7], n[8]), Quaternion(n[13], n[10], n[11], n[12])},
                       n[4],
                       n[5]});
    }
    for (const Vec3& point : points_) {
      const std::vector<Carried> by = out.empty() ? std::vector<Carried>{{input().nodes() - 1, 1, Vec3::Zero()}} : carriersOf(point, out);
      addPoint(changes_ ? amongAll(by) : by);
    }
  }

  std::vector<Carried> carriersOf(const Vec3& point, const std::vector<Out>& out) const {
    std::size_t i = 0;
    double s = 0;
    if (by_length_) {
      while (i + 1 < out.size() && point.x() > out[i].to) ++i;
      s = std::clamp((point.x() - out[i].from) / (out[i].to - out[i].from), 0., 1.);
    } else {
      i = std::size_t(std::clamp(std::floor(point.x()), 0., double(out.size() - 1)));
      s = std::clamp(point.x() - double(i), 0., 1.);
    }
    return onCurve(out[i].beam, s, Vec3(0, point.y(), point.z()));
  }

  static constexpr const char* role = "interpolation of beams";
  Link<Component> link_{role};
  std::vector<Vec3> points_;
  bool by_length_ = true, is_copy_ = false;
  double per_beam_ = 0, proximity_ = 0;
  const std::vector<double>* beams_ = nullptr;  ///< of the interpolation, which stay
  std::vector<double> known_;                   ///< those that the points are on
  bool changes_ = false;                        ///< they may change in a run
  AdaptiveBeamMapping* const self_ = this;      ///< what carries a point follows from the beams, whenever it is asked for
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(adaptive_beam_mapping) {
  factory.add<stroma::AdaptiveBeamMapping>("AdaptiveBeamMapping", "points on beams and on rods that are pushed");
}
