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
  std::vector<AveragedCells<Single>> all;
  for (const auto& [bulk, numbers] : materials(elements)) {
    AveragedCells<Single>& m = all.emplace_back();
    std::vector<double> volume;
    for (Index e : numbers) {
      m.cells.push_back(shapes.mesh().tetrahedra[e]);
      volume.push_back(shapes.weight(shapes.restEdges(m.cells.back())));
    }
    m.fans = gatherFans(m.cells, shapes.positions().size());
    std::vector<Fan> fans = m.fans;  // with numbers of the mesh
    for (Fan& fan : fans)
      for (Index& e : fan.element) e = e >= 0 ? numbers[e] : -1;
    m.storage = fanStorage<StorageOf<FanOf<Single>>>(fans, elements);
    for (Fan& fan : m.fans)
      for (Index& node : fan.nodes) node += elements.first_row;
    for (Tetrahedron& cell : m.cells)
      for (Index& node : cell) node += elements.first_row;
    m.average(bulk, volume);
  }
  return std::make_unique<NodalDilatation<Single>>(std::move(all));
}

}  // namespace stroma::tetrahedron
