// SPDX-License-Identifier: LGPL-2.1-or-later
// MultiAdaptiveBeamTopologicalMapping: the edges of the points that MultiAdaptiveBeamMapping puts on rods that are pushed.
//
// A chain of edges, each from a node to the next, the last node for the tip that is furthest out. It has as many edges as the contact
// model of the rod of `ircontroller` that has most of them (numEdgesCollis of a WireRestShape, nbEdgesCollis of sections), or
// nbEdges. It is the mesh of its node, or fills the container that `output` names.
//
// Source: the number is that of MultiAdaptiveBeamMapping of the plug-in BeamAdapter for SOFA, which fills the container of its node
// itself.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <RodStraightSection name="handle" length="0.3" radius="0.0005" youngModulus="1e9" massDensity="1000" nbEdgesCollis="12"/>
//   <WireRestShape name="guide" wireMaterials="@handle"/>
//   <EulerImplicitSolver newtonIterations="20" newtonTolerance="1e-10" rayleighStiffness="0.1" rayleighMass="0.1"/>
//   <SparseLDLSolver/>
//   <RegularGridTopology n="20 1 1" min="0 0 0" max="0.3 0 0"/>
//   <MechanicalObject template="Rigid3"/>
//   <WireBeamInterpolation name="wire" WireRestShape="@guide"/>
//   <AdaptiveBeamForceFieldAndMass interpolation="@wire"/>
//   <InterventionalRadiologyController name="push" instruments="@wire" xtip="0.05" speed="0.2" threshold="0.001"/>
//   <Node name="skin">
//     <EdgeSetTopologyContainer name="chain"/>
//     <MultiAdaptiveBeamTopologicalMapping ircontroller="@../push" output="@chain"/>
//     <MechanicalObject/>
//     <MultiAdaptiveBeamMapping ircontroller="@../push"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include "components/beams/wire_chain.h"
#include "framework/mesh/cell_attributes.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class MultiAdaptiveBeamTopologicalMapping final : public TopologicalMapping {
 public:
  void declare(DataTable& table) override {
    table.addLink("ircontroller", link_).help("what pushes the rods; the one of a node above by default");
    table.find("ircontroller")->alias("controller");
    table.addLink("output", output_).help("container of edges that is filled");
    table.add("nbEdges", count_).help("edges; 0: as many as the contact model with most of them").min(0);
    table.add("position", mesh_.position).help("nodes, all at one place").unit("m").output();
    addCellList(table, cell_kinds::edge, mesh_.edges).help("one from each node to the next").output();
  }

  void init() override {
    const MovesRods* mover = link_.get();
    for (Node* here = &node(); !mover && !link_.target() && here; here = here->parent())
      for (const auto& other : here->components())
        if (auto* each = dynamic_cast<MovesRods*>(other.get()); each && !mover) {
          mover = each;
          other->ensureReady();
        }
    if (!mover)
      throw ComponentError("there is no controller that pushes rods", "ircontroller=\"@...\", an InterventionalRadiologyController");
    const int edges = count_ > 0 ? count_ : mover->contactEdges(false), needed = mover->contactEdges(true);
    constexpr int most = 2000;  // each of their nodes may hang on any frame
    if (edges > most) throw ComponentError(fmt::format("the chain has {} edges", edges), fmt::format("at most {}", most));
    if (needed > edges)
      warn(fmt::format("the chain has {} edges, and {} are needed where all rods are out: those next to the opening are left out there",
                       edges, needed),
           fmt::format("nbEdges=\"{}\"", needed));
    mesh_ = Mesh();
    mesh_.position.assign(std::size_t(edges) + 1, Vec3::Zero());
    for (Index i = 0; i < edges; ++i) mesh_.edges.push_back({i, i + 1});
  }

 private:
  Link<MovesRods> link_{"mover of rods"};
  int count_ = 0;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(multi_adaptive_beam_topological_mapping) {
  factory.add<stroma::MultiAdaptiveBeamTopologicalMapping>("MultiAdaptiveBeamTopologicalMapping",
                                                           "the edges of points on rods that are pushed");
}
