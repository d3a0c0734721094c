// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/surface_selection.h"

#include <fmt/format.h>

#include <algorithm>

namespace stroma {

namespace {
bool isSet(const Component& load, const char* attribute) { return load.data().find(attribute)->isSet(); }
}  // namespace

void SurfaceSelection::declare(DataTable& table) {
  table.add("triangleIndices", triangle_indices_).help("loaded triangles of the mesh");
  table.add("quadIndices", quad_indices_).help("loaded quads of the mesh");
  table.add("min", low_).help("a corner of the box that faces must lie in, when none are listed").unit("m");
  table.add("max", high_).help("the other corner; neither given: everywhere").unit("m");
}

std::vector<Face> SurfaceSelection::faces(const Component& load, const Mesh& mesh, const State& state) const {
  const bool lists = isSet(load, "triangleIndices") || isSet(load, "quadIndices");
  std::vector<Face> faces = lists ? listed(load, mesh) : inBox(load, mesh, state);
  if (faces.empty()) throw ComponentError("no face of the mesh is loaded", "a triangle or a quad");
  return faces;
}

std::vector<Face> SurfaceSelection::listed(const Component& load, const Mesh& mesh) const {
  std::vector<Face> faces;
  if (isSet(load, "min") || isSet(load, "max"))
    throw ComponentError("faces are listed and the box min, max is given too", "one of them");
  const auto take = [&](const char* name, const std::vector<int>& indices, const auto& cells, const char* word) {
    if (isSet(load, name) && indices.empty())
      throw ComponentError(fmt::format("{} lists no face", name), fmt::format("at least one of the {}", word),
                           "when a selection is linked here, check that its box holds faces");
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (indices[i] < 0 || std::size_t(indices[i]) >= cells.size())
        throw ComponentError(
            fmt::format("{}[{}] is {}, and the mesh lists {} {}", name, i, indices[i], cells.size(), word),
            cells.empty() ? "min and max, which select faces of volume cells as well"
                          : fmt::format("indices in 0 ... {}", cells.size() - 1));
      faces.push_back(cells[indices[i]]);
    }
    if (!isSet(load, name) && !cells.empty())
      load.inform(fmt::format("{} is not given: none of the {} {} of the mesh is loaded", name, cells.size(), word));
  };
  take("triangleIndices", triangle_indices_, mesh.triangles, "triangles");
  take("quadIndices", quad_indices_, mesh.quads, "quads");
  return faces;
}

std::vector<Face> SurfaceSelection::inBox(const Component& load, const Mesh& mesh, const State& state) const {
  std::vector<Face> faces;
  if (isSet(load, "min") != isSet(load, "max"))
    throw ComponentError(
        fmt::format("{} is given without {}", isSet(load, "min") ? "min" : "max", isSet(load, "min") ? "max" : "min"),
        "both corners of the box, or none of them");
  const bool everywhere = !isSet(load, "min"), given = !mesh.triangles.empty() || !mesh.quads.empty();
  if (!everywhere && low_ == high_)
    throw ComponentError(fmt::format("min and max are the same point {:g} {:g} {:g}", low_.x(), low_.y(), low_.z()),
                         "two corners of a box, or none of them for the whole surface");
  const Vec3 lower = low_.cwiseMin(high_), upper = low_.cwiseMax(high_);
  const auto take = [&](const auto& cells) {
    for (const auto& cell : cells)
      if (everywhere || std::all_of(cell.begin(), cell.end(), [&](Index node) {
            const Vec3& p = state.rest_position[node];
            return p.cwiseMax(lower).cwiseMin(upper) == p;
          }))
        faces.push_back(cell);
  };
  take(given ? mesh.triangles : mesh.boundaryTriangles());
  take(given ? mesh.quads : mesh.boundaryQuads());
  return faces;
}

}  // namespace stroma
