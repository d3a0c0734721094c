// SPDX-License-Identifier: LGPL-2.1-or-later
// WireBeamInterpolation: beams of a rod whose shape and stuff are those of a WireRestShape, on the edges of a mesh between rigid frames.
//
// An InterventionalRadiologyController that names it says which part of the rod is out and which edges carry it. Without one all of
// the mesh carries the rod from its handle on: an edge has the beam from the length of the edges before it to its own end,
// measured along the rod where the scene starts.
//
// A rod is far stiffer along than across: a step of one linear solve (newtonIterations="0") can press it by more than what buckles
// it, and then it swings too far. Take Newton's method.
//
// Source: names and attributes are those of the plug-in BeamAdapter for SOFA, which does nothing without a controller.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <RodSpireSection name="hook" length="0.1" radius="0.001" youngModulus="1e8" massDensity="1000" spireDiameter="1" spireHeight="0"/>
//   <WireRestShape name="shape" wireMaterials="@hook"/>
//   <EulerImplicitSolver newtonIterations="20"/>
//   <SparseLDLSolver/>
//   <MeshTopology edges="0 1  1 2"/>
//   <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   0.05 0 0  0 0 0 1   0.1 0 0  0 0 0 1"/>
//   <WireBeamInterpolation name="wire" WireRestShape="@shape"/>
//   <AdaptiveBeamForceFieldAndMass interpolation="@wire"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include <fmt/format.h>

#include "components/beams/wire_chain.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class WireBeamInterpolation final : public WireChain {
 public:
  void declare(DataTable& table) override {
    BeamChain::declare(table);
    table.addLink("WireRestShape", link_).help("shape and stuff of the rod").required();
    for (const char* name : {"radius", "innerRadius", "straight", "dofsAndBeamsAligned", "defaultYoungModulus", "defaultPoissonRatio",
                             "edgeList", "lengthList", "curvAbsList", "beamCollision", "crossSectionShape"})
      table.addVisualOnly(name);  // the plug-in reads none of them here
  }

  void init() override {
    BeamChain::init();
    shape_ = link_.get();
    if (!shape_) throw ComponentError("WireRestShape is not given", "WireRestShape=\"@...\"");
    beams_ = noBeams();
    double from = 0;
    for (ChainBeam& beam : beams_) {
      const double length = (placementOf(beam.b, false).centre - placementOf(beam.a, false).centre).norm();
      if (!(length > 0) || from + length > shape_->length() * (1 + 1e-9)) break;
      beam.is_there = true;
      shape_->fill(beam, from, from + length);
      from = beam.to;
    }
    publish();
  }
  void checkBeams() const override {
    for (const ChainBeam& beam : beams_)
      if (!isPushed() && !beam.is_there)
        throw ComponentError(fmt::format("{}: the edge of nodes {} {} has no part of the rod, since it has no length or the mesh is longer "
                                         "than the rod, and no InterventionalRadiologyController pushes it",
                                         path(), beam.a, beam.b),
                             fmt::format("frames along {:g} m of the rod, or a controller", shape_->length()));
  }

 private:
  Link<RodShape> link_{"shape of a rod"};
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(wire_beam_interpolation) {
  factory.add<stroma::WireBeamInterpolation>("WireBeamInterpolation", "beams of a rod with the shape of a WireRestShape");
}
