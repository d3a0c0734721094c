// SPDX-License-Identifier: LGPL-2.1-or-later
// SparseGridMultipleTopology: the cells of a box that are inside, or cut by, several closed surfaces with different materials.
//
// The surfaces are position1, triangles1, quads1, position2, ... (at most eight). Box, cells, nodes and their order are those of
// SparseGridTopology for all surfaces together. Each surface has a factor s on the stiffness (stiffnessCoefs) and one on the mass
// (massCoefs), by default 1. The surfaces are applied in their order. A cell of the finest level gets
//
//   s                if it is inside the surface (or on its border, with fillWeighted="false")
//   (f + s)/2        if it is on its border, where f is its previous factor, 0 at first. With erasePreviousCoef: s
//
// A cell counts as inside if it is inside one of the surfaces. Coarser cells have the mean of their eight. cellFactors and partFactors are
// those of the stiffness, massFactors and partMassFactors those of the mass. With computeRamifications a cell has a copy for each connected
// part of the bodies in it, as in SparseGridRamificationTopology, but all cells with a common side are connected.
//
// Source: names, attributes and rules are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-9"/>
//   <SparseGridMultipleTopology name="grid" n="5 5 5" stiffnessCoefs="1 20" massCoefs="1 2"
//     position1="0 0 0  1 0 0  0 1 0  0 0 1" triangles1="0 2 1  0 1 3  1 2 3  2 0 3"
//     position2="0 0 0  0.4 0 0  0 0.4 0  0 0 0.4" triangles2="0 2 1  0 1 3  1 2 3  2 0 3"/>
//   <MechanicalObject/>
//   <MeshMatrixMass massDensity="1" cellFactors="@grid.massFactors"/>
//   <HexahedronFEMForceField youngModulus="1e4" poissonRatio="0.3" localStiffnessFactor="@grid.cellFactors"/>
//   <FixedProjectiveConstraint indices="0 1"/>
// </Node>
#include "components/topology/sparse_grid.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class SparseGridMultipleTopology final : public SparseGridTopology {
 public:
  static constexpr std::size_t most = 8;

  void declare(DataTable& table) override {
    SparseGridTopology::declare(table);
    for (std::size_t i = 0; i < most; ++i) {
      Surface& surface = surfaces_[i];
      table.add(fmt::format("position{}", i + 1), surface.nodes).help(fmt::format("nodes of surface {}", i + 1)).unit("m");
      table.add(fmt::format("triangles{}", i + 1), surface.triangles).help(fmt::format("triangles of surface {}", i + 1));
      table.add(fmt::format("quads{}", i + 1), surface.quads).help(fmt::format("quads of surface {}", i + 1));
    }
    table.add("stiffnessCoefs", coefficients_[0]).help("factor on the stiffness in each surface; 1 by default").unit("-").min(0);
    table.add("massCoefs", coefficients_[1]).help("the same on the mass").unit("-").min(0);
    table.add("erasePreviousCoef", erases_).help("on a border the factors of a later surface replace those of earlier ones");
    table.add("computeRamifications", splits_).help("a copy of a cell for each part of the bodies in it");
    table.add("massFactors", mass_factors_).help("factor on the mass of each cell").unit("-").output();
    table.add("partMassFactors", part_mass_factors_).help("the same of each part of each cell").unit("-").output();
    for (const char* name : {"fileTopologies", "finestConnectivity"}) table.addVisualOnly(name);
  }

 protected:
  bool splitsCells() const override { return splits_; }
  bool isUniform() const override { return false; }

  void gather() override {
    for (const char* name : {"position", "triangles", "quads"})
      if (data().find(name)->isSet())
        throw ComponentError(fmt::format("{} belongs to no surface", name), fmt::format("{0}1, and {0}2 of the next one", name));
    mesh_.position.clear(), triangles_.clear();
    for (Surface& surface : surfaces_) {
      const auto shift = Index(mesh_.position.size());
      const auto add = [&](Index a, Index b, Index c) {
        for (const Index node : {a, b, c})
          if (node < 0 || std::size_t(node) >= surface.nodes.size())
            throw ComponentError(fmt::format("a face of surface {} names node {} of {}", 1 + (&surface - surfaces_.data()), node,
                                             surface.nodes.size()));
        triangles_.push_back({a + shift, b + shift, c + shift});
      };
      for (const Triangle& t : surface.triangles) add(t[0], t[1], t[2]);
      for (const Quad& q : surface.quads) add(q[0], q[1], q[2]), add(q[0], q[2], q[3]);
      mesh_.position.insert(mesh_.position.end(), surface.nodes.begin(), surface.nodes.end());
      surface.end = triangles_.size();
    }
  }

  void mark(const std::vector<Vec3>& nodes, Cells& fine) override {
    using sparse_grid::Place;
    for (std::size_t cell = 0; cell < fine.size(); ++cell) fine.setPlace(cell, Place::outside);
    for (auto& list : fine_factors_) list.assign(fine.size(), 0);
    std::size_t first = 0;
    for (std::size_t i = 0; i < most; first = surfaces_[i++].end) {
      if (surfaces_[i].end == first) continue;
      Cells own = fine.empty();
      markTriangles(nodes, first, surfaces_[i].end, own);
      own.markOutside();
      for (std::size_t cell = 0; cell < fine.size(); ++cell) {
        if (own.placeOf(cell) == Place::outside) continue;
        const bool is_border = own.placeOf(cell) == Place::border && weighted_;
        if (!is_border || fine.placeOf(cell) == Place::outside) fine.setPlace(cell, is_border ? Place::border : Place::unknown);
        for (std::size_t of = 0; of < 2; ++of) {
          const double factor = i < coefficients_[of].size() ? coefficients_[of][i] : 1;
          double& last = fine_factors_[of][cell];
          last = is_border && !erases_ ? (last + factor) / 2 : factor;
        }
      }
    }
  }
  std::array<double, 2> factorsOf(std::size_t cell, bool) const override {
    return {fine_factors_[0][cell], fine_factors_[1][cell]};
  }

 private:
  struct Surface {
    std::vector<Vec3> nodes;
    std::vector<Triangle> triangles;
    std::vector<Quad> quads;
    std::size_t end = 0;  ///< of its triangles among all
  };
  std::array<Surface, most> surfaces_;
  std::array<std::vector<double>, 2> coefficients_, fine_factors_;  ///< of stiffness and mass
  bool erases_ = false, splits_ = true;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(sparse_grid_multiple_topology) {
  factory.add<stroma::SparseGridMultipleTopology>("SparseGridMultipleTopology", "the cells of a box that lie in several surfaces");
}
