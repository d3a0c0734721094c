// SPDX-License-Identifier: LGPL-2.1-or-later
// The layouts follow the chapter "File formats" of the Gmsh reference manual and VTK's description of its XML formats.
#include "tools/mesh/labelled_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <tuple>

#include "framework/mesh/cell_kind.h"

namespace stroma {

namespace {

/// A run of cells with one physical group.
struct Group {
  int dimension, tag;
  std::string name;
  std::vector<Index> cells;  ///< of tetrahedra or of triangles
};

struct Content {
  std::vector<RegionTriangle> triangles;
  std::vector<Group> groups;  ///< triangles first
};

Content contentOf(const LabelledMesh& mesh, const LabelNames& names) {
  Content content{regionTriangles(mesh), {}};
  const auto& triangles = content.triangles;
  const bool several = std::ranges::any_of(triangles, [](const RegionTriangle& one) { return one.cavity > 1; });
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const RegionTriangle& now = triangles[t];
    const auto key = [](const RegionTriangle& one) { return std::tuple(one.inside, one.outside, one.cavity); };
    if (t == 0 || key(now) != key(triangles[t - 1])) {
      const std::string outside = now.outside  ? nameOf(now.outside, names)
                                  : now.cavity ? fmt::format("cavity{}", several ? fmt::format("_{}", now.cavity) : "")
                                               : "outside";
      content.groups.push_back({2, int(content.groups.size()) + 1, nameOf(now.inside, names) + "." + outside, {}});
    }
    content.groups.back().cells.push_back(Index(t));
  }
  std::map<int, std::vector<Index>> regions;
  for (std::size_t c = 0; c < mesh.labels.size(); ++c) regions[mesh.labels[c]].push_back(Index(c));
  for (auto& [label, cells] : regions) content.groups.push_back({3, label, nameOf(label, names), std::move(cells)});
  return content;
}

using Out = std::back_insert_iterator<std::string>;

void addNames(Out out, const Content& content) {
  fmt::format_to(out, "$PhysicalNames\n{}\n", content.groups.size());
  for (const Group& group : content.groups)
    fmt::format_to(out, "{} {} \"{}\"\n", group.dimension, group.tag, group.name);
  fmt::format_to(out, "$EndPhysicalNames\n");
}

void addPosition(Out out, const Vec3& p) { fmt::format_to(out, "{:.9g} {:.9g} {:.9g}\n", p.x(), p.y(), p.z()); }

void addNodesOf(Out out, const LabelledMesh& mesh, const Content& content, const Group& group, Index cell) {
  if (group.dimension == 2)
    for (const Index n : content.triangles[cell].nodes) fmt::format_to(out, " {}", n + 1);
  else
    for (const Index n : mesh.tetrahedra[cell]) fmt::format_to(out, " {}", n + 1);
  *out = '\n';
}

/// Calls visit(group, cell, number of the element from 1).
template <class Before, class Visit>
void forEachElement(const Content& content, Before&& before, Visit&& visit) {
  std::size_t number = 0;
  for (const Group& group : content.groups) {
    before(group);
    for (const Index cell : group.cells) visit(group, cell, ++number);
  }
}

/// Triangles and tetrahedra are all that a labelled mesh has.
constexpr const CellKind& kindOf(const Group& group) {
  return group.dimension == 2 ? cell_kinds::triangle : cell_kinds::tetrahedron;
}

void addBody22(Out out, const LabelledMesh& mesh, const Content& content) {
  fmt::format_to(out, "$Nodes\n{}\n", mesh.position.size());
  for (std::size_t n = 0; n < mesh.position.size(); ++n)
    fmt::format_to(out, "{} ", n + 1), addPosition(out, mesh.position[n]);
  fmt::format_to(out, "$EndNodes\n$Elements\n{}\n", content.triangles.size() + mesh.tetrahedra.size());
  forEachElement(
      content, [](const Group&) {},
      [&](const Group& group, Index cell, std::size_t number) {
        fmt::format_to(out, "{} {} 2 {} {}", number, kindOf(group).gmsh.number, group.tag, group.tag);
        addNodesOf(out, mesh, content, group, cell);
      });
  fmt::format_to(out, "$EndElements\n");
}

void addEntities41(Out out, const LabelledMesh& mesh, const Content& content) {
  Vec3 low = mesh.position.front(), high = low;
  for (const Vec3& p : mesh.position) low = low.cwiseMin(p), high = high.cwiseMax(p);
  std::size_t surfaces = 0;
  for (const Group& group : content.groups) surfaces += group.dimension == 2;
  fmt::format_to(out, "$Entities\n0 0 {} {}\n", surfaces, content.groups.size() - surfaces);
  for (const Group& group : content.groups)
    fmt::format_to(out, "{} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} 1 {} 0\n", group.tag, low.x(), low.y(), low.z(),
                   high.x(), high.y(), high.z(), group.tag);
  fmt::format_to(out, "$EndEntities\n");
}

void addBody41(Out out, const LabelledMesh& mesh, const Content& content) {
  addEntities41(out, mesh, content);
  const std::size_t nodes = mesh.position.size(), elements = content.triangles.size() + mesh.tetrahedra.size();
  // which entity a node belongs to matters to mesh generators only: all are listed under the last region
  fmt::format_to(out, "$Nodes\n1 {} 1 {}\n3 {} 0 {}\n", nodes, nodes, content.groups.back().tag, nodes);
  for (std::size_t n = 0; n < nodes; ++n) fmt::format_to(out, "{}\n", n + 1);
  for (const Vec3& p : mesh.position) addPosition(out, p);
  fmt::format_to(out, "$EndNodes\n$Elements\n{} {} 1 {}\n", content.groups.size(), elements, elements);
  forEachElement(
      content,
      [&](const Group& group) {
        fmt::format_to(out, "{} {} {} {}\n", group.dimension, group.tag, kindOf(group).gmsh.number, group.cells.size());
      },
      [&](const Group& group, Index cell, std::size_t number) {
        fmt::format_to(out, "{}", number);
        addNodesOf(out, mesh, content, group, cell);
      });
  fmt::format_to(out, "$EndElements\n");
}

}  // namespace

std::string nameOf(int label, const LabelNames& names) {
  const auto found = names.find(label);
  return found == names.end() ? fmt::format("label_{}", label) : found->second;
}

std::string gmshText(const LabelledMesh& mesh, const LabelNames& names, bool format_22) {
  const Content content = contentOf(mesh, names);
  std::string text = fmt::format("$MeshFormat\n{} 0 8\n$EndMeshFormat\n", format_22 ? "2.2" : "4.1");
  const Out out(text);
  addNames(out, content);
  format_22 ? addBody22(out, mesh, content) : addBody41(out, mesh, content);
  return text;
}

std::string vtuText(const LabelledMesh& mesh) {
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n"
      "<Points>\n<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n",
      mesh.position.size(), mesh.tetrahedra.size());
  const Out out(text);
  const auto array = [&](const char* type, const char* name) {
    fmt::format_to(out, "</DataArray>\n<DataArray type=\"{}\" Name=\"{}\" format=\"ascii\">\n", type, name);
  };
  for (const Vec3& p : mesh.position) addPosition(out, p);
  fmt::format_to(
      out, "</DataArray>\n</Points>\n<Cells>\n<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">\n");
  for (const Tetrahedron& t : mesh.tetrahedra) fmt::format_to(out, "{} {} {} {}\n", t[0], t[1], t[2], t[3]);
  array("Int32", "offsets");
  for (std::size_t c = 1; c <= mesh.tetrahedra.size(); ++c)
    fmt::format_to(out, "{}\n", cell_kinds::tetrahedron.nodes * c);
  array("UInt8", "types");
  for (std::size_t c = 0; c < mesh.tetrahedra.size(); ++c)
    fmt::format_to(out, "{}\n", cell_kinds::tetrahedron.vtk.number);
  fmt::format_to(out,
                 "</DataArray>\n</Cells>\n<CellData Scalars=\"label\">\n<DataArray type=\"Int32\" Name=\"label\" "
                 "format=\"ascii\">\n");
  for (const int label : mesh.labels) fmt::format_to(out, "{}\n", label);
  text += "</DataArray>\n</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  return text;
}

}  // namespace stroma
