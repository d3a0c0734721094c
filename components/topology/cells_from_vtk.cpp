// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/topology/cells_from_vtk.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "components/topology/lists_of_vtk.h"
#include "framework/scene/diagnostics.h"

namespace stroma {
namespace {

// VTK's numbers (vtkCellType.h) of the kinds that are no kind of ours
constexpr int poly_line = 4, triangle_strip = 6, polygon = 7, pixel = 8, voxel = 11, quadratic_edge = 21;

/// The kind that VTK's number stands for, and which of our nodes each of VTK's is; null for others.
struct Numbering {
  const CellKind* kind = nullptr;
  std::span<const int> order;
};

Numbering numberingOf(int type) {
  // axis-aligned cells in VTK's order of images
  static constexpr std::array<int, 8> image_order{0, 1, 3, 2, 4, 5, 7, 6};
  if (type == pixel) return {&cell_kinds::quad, {image_order.data(), 4}};
  if (type == voxel) return {&cell_kinds::hexahedron, image_order};
  const CellKind* kind = kindByNumber(&CellKind::vtk, type);
  return kind ? Numbering{kind, kind->vtk.order} : Numbering{};
}

}  // namespace

VtkMesh::VtkMesh(const ValueLists& lists, std::string name)
    : cell_arrays(lists.get<Texts>(vtk_lists::cell_arrays)),
      point_arrays(lists.get<Texts>(vtk_lists::point_arrays)),
      name_(std::move(name)),
      types_(lists.get<Integers>(vtk_lists::types)),
      offsets_(lists.get<Integers>(vtk_lists::offsets)),
      nodes_(lists.get<Integers>(vtk_lists::nodes)) {
  const Reals& points = lists.get<Reals>(vtk_lists::points);
  const std::size_t count = points.size() / 3;
  if (points.size() % 3 != 0 || count > std::size_t(std::numeric_limits<Index>::max()))
    fail(fmt::format("{} coordinates", points.size()));
  position.reserve(count);
  for (std::size_t n = 0; n < count; ++n) position.emplace_back(points[3 * n], points[3 * n + 1], points[3 * n + 2]);
  if (offsets_.size() != types_.size() + 1 || offsets_.front() != 0 ||
      !std::is_sorted(offsets_.begin(), offsets_.end()) || std::size_t(offsets_.back()) != nodes_.size())
    fail(fmt::format("{} cells and {} ends of cells that do not fit {} nodes", types_.size(), offsets_.size(),
                     nodes_.size()));
  const Integers &kinds = lists.get<Integers>(vtk_lists::kinds), &linear = lists.get<Integers>(vtk_lists::kinds_linear);
  const Texts& names = lists.get<Texts>(vtk_lists::kinds_names);
  for (std::size_t k = 0; k < std::min({kinds.size(), linear.size(), names.size()}); ++k)
    kinds_[int(kinds[k])] = {names[k], linear[k] != 0};
  labels = arrayOf(lists, vtk_lists::labels, cells());
  cell_directions = arrayOf(lists, vtk_lists::cell_directions, cells());
  point_directions = arrayOf(lists, vtk_lists::point_directions, count);
  cell_values = arrayOf(lists, vtk_lists::cell_values, cells());
}

VtkArray VtkMesh::arrayOf(const ValueLists& lists, const std::string& list, std::size_t entries) const {
  VtkArray array{lists.has(list), 0, lists.get<Reals>(list)};
  if (!array.found) return array;
  const Integers& width = lists.get<Integers>(list + vtk_lists::width);
  array.width = width.size() == 1 && width[0] > 0 ? std::size_t(width[0]) : 0;
  if (array.width == 0 || array.values.size() % array.width != 0 || array.values.size() / array.width != entries)
    fail(fmt::format("{} values of {}, which are {}", array.values.size(), list, entries));
  return array;
}

void VtkMesh::fail(const std::string& why) const {
  throw ComponentError(fmt::format("{}: VTK's reader found {}", name_, why), "a file that is not damaged");
}

const CellKind* VtkMesh::kindOfCell(std::size_t cell) const { return numberingOf(int(types_[cell])).kind; }

std::map<std::string, long> VtkMesh::addCells(const std::vector<int>& label_of_cell, Mesh& mesh,
                                              PerCellList<std::vector<int>>& groups) const {
  std::map<std::string, long> skipped;
  std::vector<Index> cell;
  for (std::size_t c = 0; c < cells(); ++c) {
    cell.clear();
    for (std::int64_t k = offsets_[c]; k < offsets_[c + 1]; ++k) {
      const std::int64_t node = nodes_[std::size_t(k)];
      if (node < 0 || node >= std::int64_t(position.size()))
        throw ComponentError(
            fmt::format("{}: cell {} names node {}, but there are {} nodes", name_, c, node, position.size()));
      cell.push_back(Index(node));
    }
    addCell(int(types_[c]), cell, mesh, skipped);
    if (label_of_cell.empty()) continue;
    const int label = label_of_cell[c];  // of all that the cell has become
    forEachCellList([label](const CellKind&, auto& of_cells, const auto& all) { of_cells.resize(all.size(), label); },
                    groups, mesh);
  }
  return skipped;
}

void VtkMesh::addCell(int type, const std::vector<Index>& n, Mesh& mesh, std::map<std::string, long>& skipped) const {
  if (type == poly_line) {
    for (std::size_t i = 0; i + 1 < n.size(); ++i) mesh.edges.push_back({n[i], n[i + 1]});
  } else if (type == triangle_strip) {
    // Every second triangle of a strip turns the other way.
    for (std::size_t i = 0; i + 2 < n.size(); ++i)
      mesh.triangles.push_back(i % 2 ? Triangle{n[i + 1], n[i], n[i + 2]} : Triangle{n[i], n[i + 1], n[i + 2]});
  } else if (type == polygon && n.size() != 4) {
    for (std::size_t i = 1; i + 1 < n.size(); ++i) mesh.triangles.push_back({n[0], n[i], n[i + 1]});
  } else {
    const auto [of_cell, order] = numberingOf(type == polygon ? cell_kinds::quad.vtk.number : type);
    if (!of_cell || of_cell->dimension == 0) return skip(type, skipped);
    if (n.size() != std::size_t(of_cell->nodes))
      throw ComponentError(fmt::format("{}: a {} with {} nodes", name_, of_cell->singular, n.size()),
                           fmt::format("{} nodes", of_cell->nodes));
    forEachCellList(
        [&, kind = of_cell, numbers = order](const CellKind& each, auto& of_mesh) {
          if (&each != kind) return;
          auto& cell = of_mesh.emplace_back();
          for (std::size_t k = 0; k < cell.size(); ++k) cell[numbers[k]] = n[k];
        },
        mesh);
  }
}

void VtkMesh::skip(int type, std::map<std::string, long>& skipped) const {
  const auto found = kinds_.find(type);
  if (found == kinds_.end()) fail(fmt::format("cells of kind {}", type));
  const auto& [kind, is_linear] = found->second;
  if (!is_linear && type != quadratic_edge)
    throw ComponentError(fmt::format("{}: cells of kind {} are not supported", name_, kind),
                         "linear cells, quadratic tetrahedra or triangles");
  ++skipped[kind];
}

}  // namespace stroma
