// SPDX-License-Identifier: LGPL-2.1-or-later
// MultiAdaptiveBeamMapping: a chain of points on all rods that an InterventionalRadiologyController pushes, for contacts and pictures.
//
// The last node is at the farthest tip. From there back to the opening the spacing of points is that of the contact model of
// their rod (numEdgesCollis of a WireRestShape, nbEdgesCollis of sections), of the outermost one for nested rods. Where a rod
// comes out of another there is a point at the tip of the outer one. Unused points, the first ones, wait at the opening, and
// come out one after another as rods are pushed; if there are too few, the stretch next to the opening has none. On a beam a
// point x at the part s of its length L is on the cubic curve between the frames of its ends,
//
//   x = w_a (c_a + q_a p_a) + w_b (c_b + q_b p_b)
//   w_a = (1-s)^3 + 3 s (1-s)^2,   p_a = s (1-s)^2/w_a L e_x,   w_b = 1 - w_a,   p_b = -s^2 (1-s)/w_b L e_x
//
// and forces on it are those on the curve. By default its node has as many points as needed for the edges of
// MultiAdaptiveBeamTopologicalMapping.
//
// Source: name, attributes and the choice of points are those of the plug-in BeamAdapter for SOFA, which fills the edges of
// its node itself. There points keep the velocities of the rods; here too, except in a step in which they are redistributed.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <WireRestShape name="catheter" length="0.2" straightLength="0.2" densityOfBeams="8" numEdgesCollis="10" radius="0.001"
//     youngModulus="1e8" massDensity="1000"/>
//   <WireRestShape name="guide" length="0.3" straightLength="0.3" densityOfBeams="12" numEdgesCollis="16" radius="0.0005"
//     youngModulus="1e9" massDensity="1000"/>
//   <EulerImplicitSolver newtonIterations="20" newtonTolerance="1e-10" rayleighStiffness="0.1" rayleighMass="0.1"/>
//   <SparseLDLSolver/>
//   <RegularGridTopology n="40 1 1" min="0 0 0" max="0.3 0 0"/>
//   <MechanicalObject template="Rigid3"/>
//   <WireBeamInterpolation name="outer" WireRestShape="@catheter"/>
//   <AdaptiveBeamForceFieldAndMass interpolation="@outer"/>
//   <WireBeamInterpolation name="inner" WireRestShape="@guide"/>
//   <AdaptiveBeamForceFieldAndMass interpolation="@inner"/>
//   <InterventionalRadiologyController name="push" instruments="@outer @inner" xtip="0.05 0.08" controlledInstrument="1"
//     speed="0.1" threshold="0.001"/>
//   <Node name="skin">
//     <MultiAdaptiveBeamTopologicalMapping ircontroller="@../push"/>
//     <MechanicalObject/>
//     <MultiAdaptiveBeamMapping ircontroller="@../push"/>
//     <ConstantForceField indices="16" forces="0 0 1e-3"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <algorithm>

#include "components/mappings/points_on_beams.h"
#include "framework/mechanics/projective_constraint.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class MultiAdaptiveBeamMapping final : public PointsOnBeams {
 public:
  void declare(DataTable& table) override {
    FrameMapping::declare(table);
    table.addLink("ircontroller", link_).help("what pushes the rods; the one of a node above by default");
    table.find("ircontroller")->alias("controller");
    table.add("useCurvAbs", by_length_).help("SOFA's; only true is supported");
    table.addVisualOnly("parallelMapping");
  }

  void init() override {
    FrameMapping::init();
    start();
    if (!by_length_)
      throw ComponentError("useCurvAbs is false: lengths of the rods would be read as numbers of beams", "useCurvAbs=\"true\"");
    if (!output().hasPointsOnly()) throw ComponentError(output().path() + " has other nodes than points", "points");
    findController();
    attach();
    placeChild(false);
  }

  /// Rods come out at the start of a step.
  void apply(Rows x) const override {
    if (*nodes_ != known_nodes_ || *points_ != known_points_) self_->start(), self_->attach();
    FrameMapping::apply(x);
  }

 private:
  /// Another family has it: by its attributes.
  void findController() {
    Component* mover = link_.get();
    for (Node* here = &node(); !mover && !link_.target() && here; here = here->parent())
      for (const auto& other : here->components())
        if (!mover && other->data().find("collisionCurvAbs")) mover = other.get(), mover->ensureReady();
    const auto listOf = [mover](const char* name) -> const std::vector<double>* {
      const Data* data = mover ? mover->data().find(name) : nullptr;
      const auto* const* found = data ? std::get_if<std::vector<double>*>(&data->pointer()) : nullptr;
      return found ? *found : nullptr;
    };
    nodes_ = listOf("CurvAbs"), points_ = listOf("collisionCurvAbs");
    if (!nodes_ || !points_)
      throw ComponentError("there is no controller that pushes rods", "ircontroller=\"@...\", an InterventionalRadiologyController");
    const auto* pusher = dynamic_cast<const ProjectiveConstraint*>(mover);
    if (pusher && &pusher->state() != &input())
      throw ComponentError(fmt::format("{} pushes frames of {}", mover->path(), pusher->state().path()),
                           fmt::format("what pushes those of {}", input().path()));
  }

  void attach() {
    known_nodes_ = *nodes_, known_points_ = *points_;
    const Index first = input().nodes() - Index(known_nodes_.size());
    const std::size_t waiting = std::size_t(output().nodes()) - std::min(std::size_t(output().nodes()), known_points_.size());
    for (std::size_t i = 0; i < std::size_t(output().nodes()); ++i)
      addPoint(amongAll(at(first, i < waiting ? 0 : known_points_[std::size_t(output().nodes()) - 1 - i])));
  }
  std::vector<Carried> at(Index first, double place) const {
    if (known_nodes_.size() < 2) return {{first, 1, Vec3::Zero()}};
    std::size_t n = 0;
    while (n + 2 < known_nodes_.size() && place > known_nodes_[n + 1]) ++n;
    const Beam beam{first + Index(n), first + Index(n) + 1, known_nodes_[n + 1] - known_nodes_[n]};
    return onCurve(beam, std::clamp((place - known_nodes_[n]) / beam.length, 0., 1.), Vec3::Zero());
  }

  Link<Component> link_{"mover of rods"};
  bool by_length_ = true;
  const std::vector<double>*nodes_ = nullptr, *points_ = nullptr;  ///< of the controller, which stay
  std::vector<double> known_nodes_, known_points_;                ///< those that the points are on
  MultiAdaptiveBeamMapping* const self_ = this;  ///< what carries a point follows from the rods, whenever it is asked for
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(multi_adaptive_beam_mapping) {
  factory.add<stroma::MultiAdaptiveBeamMapping>("MultiAdaptiveBeamMapping", "points on all rods that are pushed, for contacts");
}
