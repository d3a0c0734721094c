// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/surface_selection.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "framework/mesh/cell_faces.h"

namespace stroma {

namespace {
bool isSet(const Component& load, const char* attribute) { return load.data().find(attribute)->isSet(); }
bool isTrue(const Component& load, const char* attribute) {
  const Data* found = load.data().find(attribute);
  return found && **std::get_if<bool*>(&found->pointer());
}

/// What helps when a mesh of volume cells lists no faces.
std::string addsFaces() {
  return "createSubelements=\"true\" on the mesh loader, which lists faces of volume cells, or min and max here, not indices";
}

template <class Cell>
Cell withSortedNodes(Cell cell) {
  std::sort(cell.begin(), cell.end());
  return cell;
}

template <class Cell>
std::vector<Cell> sortedSets(const std::vector<Cell>& cells) {
  std::vector<Cell> sets;
  for (const Cell& cell : cells) sets.push_back(withSortedNodes(cell));
  std::sort(sets.begin(), sets.end());
  return sets;
}

/// Faces between two volume cells: loaders list them beside those of the surface, and no load acts on them from outside.
template <class Cell>
std::vector<Cell> innerFaces(const std::vector<Cell>& faces, const std::vector<Cell>& boundary) {
  const std::vector<Cell> all = sortedSets(faces), outer = sortedSets(boundary);
  std::vector<Cell> inner;
  std::set_difference(all.begin(), all.end(), outer.begin(), outer.end(), std::back_inserter(inner));
  return inner;
}
}  // namespace

void SurfaceSelection::declare(DataTable& table) {
  table.add("triangleIndices", triangle_indices_).help("loaded triangles of the mesh");
  table.add("quadIndices", quad_indices_).help("loaded quads of the mesh");
  table.add("quadraticTriangleIndices", quadratic_indices_).help("loaded quadratic triangles of the mesh");
  table.add("min", low_).help("a corner of the box that selects faces, if none are listed").unit("m");
  table.add("max", high_).help("the other corner; if neither is given: everywhere").unit("m");
}

std::vector<Face> SurfaceSelection::faces(const Component& load, const Mesh& mesh, const State& state) const {
  const bool lists = isSet(load, "triangleIndices") || isSet(load, "quadIndices") || isSet(load, "quadraticTriangleIndices");
  std::vector<Face> faces = lists ? listed(load, mesh) : inBox(load, mesh, state);
  if (faces.empty()) throw ComponentError("no face of the mesh is loaded", "a triangle or a quad");
  return faces;
}

std::vector<Face> SurfaceSelection::listed(const Component& load, const Mesh& mesh) const {
  std::vector<Face> faces;
  if (isSet(load, "min") || isSet(load, "max")) throw ComponentError("faces are listed and the box min, max is given too", "one of them");
  const auto take = [&](const char* name, const std::vector<int>& indices, const auto& cells, const char* word) {
    if (isSet(load, name) && indices.empty())
      throw ComponentError(
          cells.empty() ? fmt::format("{} lists no face, and the mesh lists no {}", name, word) : fmt::format("{} lists no face", name),
          cells.empty() ? addsFaces() : fmt::format("at least one of the {}", word),
          cells.empty() ? "" : "if a selection is linked here, check that its box contains faces");
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (indices[i] < 0 || std::size_t(indices[i]) >= cells.size())
        throw ComponentError(fmt::format("{}[{}] is {}, and the mesh lists {} {}", name, i, indices[i], cells.size(), word),
                             cells.empty() ? addsFaces() : fmt::format("indices in 0 ... {}", cells.size() - 1));
      faces.push_back(cells[indices[i]]);
    }
    if (!isSet(load, name) && !cells.empty())
      load.inform(fmt::format("{} is not given: none of the {} {} of the mesh is loaded", name, cells.size(), word));
  };
  take("triangleIndices", triangle_indices_, mesh.triangles, "triangles");
  take("quadIndices", quad_indices_, mesh.quads, "quads");
  take("quadraticTriangleIndices", quadratic_indices_, mesh.quadratic_triangles, "quadratic triangles");
  return faces;
}

std::vector<Face> SurfaceSelection::inBox(const Component& load, const Mesh& mesh, const State& state) const {
  std::vector<Face> faces;
  if (const bool low = isSet(load, "min"); low != isSet(load, "max"))
    throw ComponentError(fmt::format("{} is given without {}", low ? "min" : "max", low ? "max" : "min"), "both, or none of them");
  const bool everywhere = !isSet(load, "min"), given = !mesh.triangles.empty() || !mesh.quads.empty() || !mesh.quadratic_triangles.empty();
  if (!everywhere && low_ == high_)
    throw ComponentError(fmt::format("min and max are the same point {:g} {:g} {:g}", low_.x(), low_.y(), low_.z()),
                         "two corners of a box, or none of them for the whole surface");
  Eigen::AlignedBox3d nodes;
  for (const Vec3& p : state.rest_position) nodes.extend(p);
  const double size = std::min((high_ - low_).cwiseAbs().maxCoeff(), nodes.sizes().maxCoeff());
  const double border = isTrue(load, "exactBorder") ? 0 : 1e-9 * size;  // for round-off
  const Vec3 lower = low_.cwiseMin(high_) - Vec3::Constant(border), upper = low_.cwiseMax(high_) + Vec3::Constant(border);
  const auto take = [&]<class Cell>(const std::vector<Cell>& cells, const std::vector<Cell>& inner) {
    for (const Cell& cell : cells) {
      const bool inside = everywhere || std::all_of(cell.begin(), cell.end(), [&](Index node) {
                            return (state.rest_position[node] - lower).cwiseMin(upper - state.rest_position[node]).minCoeff() >= 0;
                          });
      if (inside && !std::binary_search(inner.begin(), inner.end(), withSortedNodes(cell))) faces.push_back(cell);
    }
  };
  if (!given) {
    take(mesh.boundaryTriangles(), {}), take(mesh.boundaryQuads(), {}), take(mesh.boundaryQuadraticTriangles(), {});
    return faces;
  }
  take(mesh.triangles, innerFaces(mesh.triangularFaces(), mesh.boundaryTriangles()));
  take(mesh.quads, innerFaces(uniqueQuads(mesh, false), mesh.boundaryQuads()));
  take(mesh.quadratic_triangles, innerFaces(uniqueQuadraticTriangles(mesh, false), mesh.boundaryQuadraticTriangles()));
  return faces;
}

}  // namespace stroma
