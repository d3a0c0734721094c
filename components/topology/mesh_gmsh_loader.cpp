// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads a Gmsh mesh: .msh formats 1, 2.2, 4.0 and 4.1, ASCII or binary (4.0: ASCII, as Gmsh itself).
//
// Edges, triangles, quads, tetrahedra, hexahedra, prisms and pyramids are read, and quadratic triangles (6 nodes) and
// tetrahedra (10 nodes), whose nodes are brought to VTK's order; points and quadratic edges are counted and reported; other
// quadratic elements are an error. Nodes keep the order of the file, whatever their tags. As in SOFA the faces and edges of
// the volume cells are added to the lists of the file unless createSubelements="false".
//
// Physical groups: `tetrahedraGroups` and its like hold the tag of each cell of the file (0: none). With group="NAME"
// (or a tag), `groupIndices` holds the nodes of the cells of that group, ascending: a surface named in the mesher is a
// selection in the scene. `groupTriangleIndices` and `groupQuadIndices` are its faces, which loads take.
// ValuesFromLabels turns tetrahedraGroups into a material of each tetrahedron.
//
// Directions: directionArray="fibres" names a view of the file ($ElementData or $NodeData) of three numbers each, or
// nine for a frame by rows; `tetrahedraDirections`, `hexahedraDirections` and `nodeDirections` hold them, turned with
// the mesh, as AnisotropyDirections takes them.
//
// Values: valueArray="young" names a view ($ElementData) of one number each; `tetrahedraValues` and `hexahedraValues` hold
// them, times `valueFactor`: youngModulus="@loader.tetrahedraValues" is a Young's modulus from computed tomography.
//
// Source: the chapter "File formats" of the Gmsh reference manual; the attributes are SOFA's.
//
// Example:
// <Node name="root">
//   <MeshGmshLoader name="loader" filename="meshes/block.msh"/>
//   <TetrahedronSetTopologyContainer name="tets" src="@loader"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "components/topology/cell_values.h"
#include "components/topology/gmsh_reader.h"
#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class MeshGmshLoader : public MeshLoader {
 public:
  MeshGmshLoader() { create_subelements_ = true; }

  void declare(DataTable& table) override {
    MeshLoader::declare(table);
    table.add("group", group_).help("physical group, by name or tag, whose nodes go to groupIndices");
    table.add("groupIndices", group_indices_).help("nodes of the physical group, ascending").output();
    table.add("groupTriangleIndices", group_triangles_)
        .help("triangles of the physical group, by their index")
        .output();
    table.add("groupQuadIndices", group_quads_)
        .help("quads of the physical group, by their index; not to be used with triangulate")
        .output();
    table.add("groupQuadraticTriangleIndices", group_quadratic_triangles_)
        .help("quadratic triangles of the physical group, by their index")
        .output();
    declareGroups(table, "physical group");
    declareDirections(table);
    values_.declare(table);
  }

 protected:
  void read(const std::string& file, Mesh& mesh) override {
    GmshFile content = readGmsh(file);
    for (const auto& [what, count] : content.skipped) {
      std::string number = fmt::format("{} {}", count, what);
      if (count == 1 && number.ends_with('s')) number.pop_back();
      inform(fmt::format("{} of the file {} not used", number, count == 1 ? "is" : "are"));
    }
    if (!group_.empty()) selectGroup(content);
    if (!directions_.array.empty()) readDirections(content);
    if (!values_.array.empty()) readValues(content);
    groups_ = std::move(content.groups);
    mesh = std::move(content.mesh);
  }

 private:
  void selectGroup(const GmshFile& content);
  void readDirections(const GmshFile& content);
  void readValues(const GmshFile& content);
  const GmshData& viewOf(const GmshFile& content, const std::string& view) const;
  int tagOf(const GmshFile& content, int dimension, bool& known) const;

  CellValues values_;
  std::string group_;
  std::vector<int> group_indices_, group_triangles_, group_quads_, group_quadratic_triangles_;
};

/// The tag that `group` means for cells of a dimension: the same name may have a tag in each.
int MeshGmshLoader::tagOf(const GmshFile& content, int dimension, bool& known) const {
  for (const auto& [key, name] : content.group_names)
    if (key.first == dimension && name == group_) return known = true, key.second;
  int tag = 0;
  const char* end = group_.data() + group_.size();
  const auto [stop, error] = std::from_chars(group_.data(), end, tag);
  if (error == std::errc() && stop == end && tag > 0) return known = true, tag;
  return -1;
}

const GmshData& MeshGmshLoader::viewOf(const GmshFile& content, const std::string& view) const {
  const auto found = content.data.find(view);
  if (found == content.data.end()) {
    std::vector<std::string> names;
    names.reserve(content.data.size());
    for (const auto& [name, data] : content.data) names.push_back(name);
    throw ComponentError(
        fmt::format("the mesh has no view '{}'", view),
        names.empty() ? "a file with $ElementData or $NodeData after its elements" : "a view of the file",
        nearest(view, names));
  }
  if (found->second.repeated) warn(fmt::format("the view '{}' has several time steps: its first is taken", view));
  return found->second;
}

void MeshGmshLoader::readValues(const GmshFile& content) {
  const GmshData& data = viewOf(content, values_.array);
  if (data.width != 1)
    throw ComponentError(fmt::format("the view '{}' has {} components", values_.array, data.width), "one number per element");
  std::size_t count = 0;
  forEachCellList(
      [&](const CellKind& kind, std::vector<double>& values) {
        for (const double value : data.cells[std::size_t(kind.type)]) values_.add(values, value), ++count;
      },
      values_.lists);
  if (count == 0)
    throw ComponentError(fmt::format("the view '{}' has no values of volume elements", values_.array), "$ElementData of them");
}

void MeshGmshLoader::readDirections(const GmshFile& content) {
  const GmshData& data = viewOf(content, directions_.array);
  if (data.width != 3 && data.width != 9)
    throw ComponentError(fmt::format("the view '{}' has {} components", directions_.array, data.width),
                         "3 (a direction) or 9 (a frame, by rows)");
  const auto vectors = [](const std::vector<double>& values) {
    std::vector<Vec3> out;
    for (std::size_t i = 0; i + 2 < values.size(); i += 3) out.emplace_back(values[i], values[i + 1], values[i + 2]);
    return out;
  };
  directions_.nodes = vectors(data.nodes);
  forEachCellList([&](const CellKind& kind,
                      std::vector<Vec3>& directions) { directions = vectors(data.cells[std::size_t(kind.type)]); },
                  directions_.cells);
}

void MeshGmshLoader::selectGroup(const GmshFile& content) {
  bool known = false;
  const auto collect = [&](const CellKind& kind, const auto& cells, const std::vector<int>& groups) {
    const int tag = tagOf(content, kind.dimension, known);
    std::vector<int>* faces = kind.type == CellType::triangle             ? &group_triangles_
                              : kind.type == CellType::quad               ? &group_quads_
                              : kind.type == CellType::quadratic_triangle ? &group_quadratic_triangles_
                                                                          : nullptr;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      if (groups[c] != tag) continue;
      group_indices_.insert(group_indices_.end(), cells[c].begin(), cells[c].end());
      if (faces) faces->push_back(int(c));
    }
  };
  forEachCellList(collect, content.mesh, content.groups);
  std::vector<std::string> names;
  names.reserve(content.group_names.size());
  for (const auto& [key, name] : content.group_names) names.push_back(name);
  if (!known)
    throw ComponentError(fmt::format("the mesh has no physical group '{}'", group_),
                         names.empty() ? "a tag: the file names no group" : "a name or a tag", nearest(group_, names));
  std::sort(group_indices_.begin(), group_indices_.end());
  group_indices_.erase(std::unique(group_indices_.begin(), group_indices_.end()), group_indices_.end());
  if (group_indices_.empty()) throw ComponentError(fmt::format("the physical group '{}' has no cell", group_));
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_gmsh_loader) { factory.add<stroma::MeshGmshLoader>("MeshGmshLoader", "reads a Gmsh .msh file"); }
