// SPDX-License-Identifier: LGPL-2.1-or-later
// UniformMass: the same mass m at every node, whatever the cells around it.
//
//   M = m I,  m = vertexMass, or totalMass / (number of nodes)
//
// `vertexMass` wins when both are given. With `indices` or `localRange` only these nodes have mass. On a mesh with
// cells of different sizes the density is then not uniform: DiagonalMass and MeshMatrixMass make it so.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0"/>
//   <UniformMass totalMass="3"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "framework/algebra/parallel.h"
#include "framework/mechanics/mass.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class UniformMass final : public Mass {
 public:
  void declare(DataTable& table) override {
    Mass::declare(table);
    table.add("vertexMass", vertex_mass_)
        .recompiled()
        .help("mass of each node; wins over totalMass")
        .unit("kg")
        .min(0, false);
    table.add("totalMass", total_mass_).recompiled().help("mass of all nodes together").unit("kg").min(0, false);
    table.add("indices", indices_).help("nodes that have mass; all when not given");
    table.add("localRange", range_).help("first and last node that have mass; -1 -1: all");
    for (const char* without_effect : {"preserveTotalMass", "compute_mapping_inertia"})
      table.addVisualOnly(without_effect);
  }

  void init() override {
    Mass::init();
    const std::vector<Index> nodes = chosenNodes();
    const bool by_vertex = data().find("vertexMass")->isSet(), by_total = data().find("totalMass")->isSet();
    if (!by_vertex && !by_total)
      warn("neither totalMass nor vertexMass is given: the total mass is taken as 1 kg", "give totalMass [kg]");
    if (by_vertex && by_total) warn("both vertexMass and totalMass are given: vertexMass is used", "remove totalMass");
    if (by_vertex) {
      total_mass_ = vertex_mass_ * double(nodes.size());
    } else {
      vertex_mass_ = total_mass_ / double(nodes.size());
    }
    masses_.assign(state().size(), 0.0);
    for (Index node : nodes) masses_[node] = vertex_mass_;
    everywhere_ = nodes.size() == masses_.size();
  }

  const std::vector<double>& lumped() const override { return masses_; }
  bool isDiagonal() const override { return true; }

  void addProduct(ConstRows p, double factor, Rows out) const override {
    if (!everywhere_) return Mass::addProduct(p, factor, out);
    constexpr Index piece_rows = 16384;
    const Index size = state().size();
    const ConstRows from = state().segment(p);
    const Rows to = state().segment(out);
    parallelFor(int((size + piece_rows - 1) / piece_rows), [&](int piece) {
      const Index first = piece * piece_rows, count = std::min(piece_rows, size - first);
      axpy(factor * vertex_mass_, from.segment(first, count), to.segment(first, count));
    });
  }

 private:
  std::vector<Index> chosenNodes() const {
    const bool by_range = data().find("localRange")->isSet() && !(range_ == std::vector<int>{-1, -1});
    const bool by_indices = data().find("indices")->isSet();
    if (by_range && by_indices) throw ComponentError("indices and localRange are both given", "one of them");
    if (by_indices) return checkedNodes(indices_, state(), "indices");
    std::vector<Index> nodes(std::size_t(state().size()));
    std::iota(nodes.begin(), nodes.end(), 0);
    if (!by_range) return nodes;
    if (range_.size() != 2 || range_[0] > range_[1])
      throw ComponentError("localRange is not a range", "two indices, the first and the last node");
    for (std::size_t i = 0; i < 2; ++i) checkNode(range_[i], i, state(), "localRange");
    return {nodes.begin() + range_[0], nodes.begin() + range_[1] + 1};
  }

  double vertex_mass_ = 1, total_mass_ = 1;
  std::vector<int> indices_, range_{-1, -1};
  std::vector<double> masses_;
  bool everywhere_ = true;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(uniform_mass) { factory.add<stroma::UniformMass>("UniformMass", "The same mass at every node"); }
