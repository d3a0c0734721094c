// SPDX-License-Identifier: LGPL-2.1-or-later
// Kernels of tetrahedra whose volume change is averaged at the nodes (nodal_dilatation.h).
#pragma once
#include <map>

#include "components/elasticity/nodal_dilatation.h"
#include "components/elasticity/tetrahedron_kernels.h"

namespace stroma::tetrahedron {

/// Cells by their bulk modulus.
inline std::map<double, std::vector<Index>> materials(const Elements& elements) {
  const Mesh& mesh = elements.shapes.mesh();
  std::map<double, std::vector<Index>> cells;
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) cells[elements.lame(e).bulk()].push_back(Index(e));
  constexpr std::size_t most = 100;
  if (cells.size() > most)
    throw ComponentError(fmt::format("the mean dilatation is taken over cells with equal constants, and there are {} "
                                     "bulk moduli",
                                     cells.size()),
                         fmt::format("at most {} materials", most), "dilatation=\"local\"");
  return cells;
}

/// `Single`: a model of averaged_models.h.
template <class Single>
std::unique_ptr<ElementKernels> averagedKernelsOf(const Elements& elements) {
  const TetrahedronShapes& shapes = elements.shapes;
  std::map<double, std::vector<Index>> cells = materials(elements);
  std::vector<AveragedCells<Single>> all;
  std::vector<std::vector<Fan>> fans_of_mesh;  // with cells and nodes of the mesh
  for (const auto& [bulk, numbers] : cells) {
    AveragedCells<Single>& m = all.emplace_back();
    std::vector<double> volume;
    for (Index e : numbers) {
      m.cells.push_back(shapes.mesh().tetrahedra[e]);
      volume.push_back(shapes.weight(shapes.restEdges(m.cells.back())));
    }
    m.fans = gatherFans(m.cells, shapes.positions().size());
    std::vector<Fan>& fans = fans_of_mesh.emplace_back(m.fans);
    for (Fan& fan : fans)
      for (Index& e : fan.element) e = e >= 0 ? numbers[e] : -1;
    m.storage = fanStorage<StorageOf<FanOf<Single>>>(fans, elements);
    for (Fan& fan : m.fans)
      for (Index& node : fan.nodes) node += elements.first_row;
    for (Tetrahedron& cell : m.cells)
      for (Index& node : cell) node += elements.first_row;
    m.average(bulk, volume);
  }
  // other constants: only where the same cells have equal ones
  auto fill = [cells = std::move(cells), fans = std::move(fans_of_mesh), &shapes = elements.shapes,
               first_row = elements.first_row, lame = elements.lame](std::vector<AveragedCells<Single>>& stored) {
    const std::map<double, std::vector<Index>> now = materials({shapes, first_row, lame});
    std::size_t i = 0;
    for (auto a = cells.begin(), b = now.begin(); i < stored.size() || b != now.end(); ++a, ++b, ++i)
      if (i == stored.size() || b == now.end() || a->second != b->second) return false;
    i = 0;
    for (const auto& [bulk, numbers] : now) {
      fillFans(stored[i].storage, fans[i], shapes, lame);
      stored[i++].setBulk(bulk);
    }
    return true;
  };
  return std::make_unique<NodalDilatation<Single>>(std::move(all), std::move(fill));
}

}  // namespace stroma::tetrahedron
