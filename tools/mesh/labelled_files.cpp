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

std::vector<Edge> edgesOf(const LabelledMesh& mesh, std::optional<int> label) {
  std::vector<Edge> edges;
  for (std::size_t c = 0; c < mesh.tetrahedra.size(); ++c)
    if (const Tetrahedron& t = mesh.tetrahedra[c]; !label || mesh.labels[c] == *label)
      for (const auto& [a, b] : cell_tables::tetrahedron_middles)
        edges.push_back({std::min(t[a], t[b]), std::max(t[a], t[b])});
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

/// A run of cells with one physical group.
struct Group {
  int dimension, tag;
  std::string name;
  std::vector<Index> cells;  ///< of tetrahedra or of triangles
};

/// The nodes of a mesh of first or second order.
class Nodes {
 public:
  Nodes(const LabelledMesh& mesh, int order) : position_(mesh.position), corners_(Index(mesh.position.size())) {
    if (order == 1) return;
    edges_ = edgesOf(mesh, {});
    for (const auto& [a, b] : edges_) position_.push_back((position_[a] + position_[b]) / 2);
  }
  const std::vector<Vec3>& position() const { return position_; }
  bool isQuadratic() const { return !edges_.empty(); }
  const CellKind& kindOf(int dimension) const {
    if (dimension == 2) return isQuadratic() ? cell_kinds::quadratic_triangle : cell_kinds::triangle;
    return isQuadratic() ? cell_kinds::quadratic_tetrahedron : cell_kinds::tetrahedron;
  }
  /// visit(node) for those of a cell with these corners, in the order of a format.
  template <class Corners, class Visit>
  void forEach(const Corners& corners, const CellFormat& format, Visit&& visit) const {
    for (const int k : format.order)
      if (k < int(corners.size())) {
        visit(corners[std::size_t(k)]);
      } else {
        const auto [a, b] = corners.size() == 3 ? cell_tables::triangle_middles[std::size_t(k) - 3]
                                                : cell_tables::tetrahedron_middles[std::size_t(k) - 4];
        const Edge edge = sorted(corners[std::size_t(a)], corners[std::size_t(b)]);
        visit(corners_ + Index(std::lower_bound(edges_.begin(), edges_.end(), edge) - edges_.begin()));
      }
  }

 private:
  static Edge sorted(Index a, Index b) { return {std::min(a, b), std::max(a, b)}; }
  std::vector<Vec3> position_;
  Index corners_;
  std::vector<Edge> edges_;  ///< ascending; node corners_ + i lies on edge i. None: first order
};

struct Content {
  std::vector<RegionTriangle> triangles;
  std::vector<Group> groups;  ///< triangles first
  Nodes nodes;
};

Content contentOf(const LabelledMesh& mesh, const LabelNames& names, int order) {
  Content content{regionTriangles(mesh), {}, Nodes(mesh, order)};
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
  const auto add = [&](Index node) { fmt::format_to(out, " {}", node + 1); };
  const CellFormat& format = content.nodes.kindOf(group.dimension).gmsh;
  if (group.dimension == 2)
    content.nodes.forEach(content.triangles[cell].nodes, format, add);
  else
    content.nodes.forEach(mesh.tetrahedra[cell], format, add);
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

void addBody22(Out out, const LabelledMesh& mesh, const Content& content) {
  const std::vector<Vec3>& position = content.nodes.position();
  fmt::format_to(out, "$Nodes\n{}\n", position.size());
  for (std::size_t n = 0; n < position.size(); ++n) {
    fmt::format_to(out, "{} ", n + 1);
    addPosition(out, position[n]);
  }
  fmt::format_to(out, "$EndNodes\n$Elements\n{}\n", content.triangles.size() + mesh.tetrahedra.size());
  forEachElement(
      content, [](const Group&) {},
      [&](const Group& group, Index cell, std::size_t number) {
        fmt::format_to(out, "{} {} 2 {} {}", number, content.nodes.kindOf(group.dimension).gmsh.number, group.tag,
                       group.tag);
        addNodesOf(out, mesh, content, group, cell);
      });
  fmt::format_to(out, "$EndElements\n");
}

void addEntities41(Out out, const LabelledMesh& mesh, const Content& content) {
  Vec3 low = mesh.position.front(), high = low;
  for (const Vec3& p : mesh.position) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
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
  const std::vector<Vec3>& position = content.nodes.position();
  const std::size_t nodes = position.size(), elements = content.triangles.size() + mesh.tetrahedra.size();
  // which entity a node belongs to matters to mesh generators only: all are listed under the last region
  fmt::format_to(out, "$Nodes\n1 {} 1 {}\n3 {} 0 {}\n", nodes, nodes, content.groups.back().tag, nodes);
  for (std::size_t n = 0; n < nodes; ++n) fmt::format_to(out, "{}\n", n + 1);
  for (const Vec3& p : position) addPosition(out, p);
  fmt::format_to(out, "$EndNodes\n$Elements\n{} {} 1 {}\n", content.groups.size(), elements, elements);
  forEachElement(
      content,
      [&](const Group& group) {
        fmt::format_to(out, "{} {} {} {}\n", group.dimension, group.tag,
                       content.nodes.kindOf(group.dimension).gmsh.number, group.cells.size());
      },
      [&](const Group& group, Index cell, std::size_t number) {
        fmt::format_to(out, "{}", number);
        addNodesOf(out, mesh, content, group, cell);
      });
  fmt::format_to(out, "$EndElements\n");
}

}  // namespace

Index countMiddles(const LabelledMesh& mesh, std::optional<int> label) { return Index(edgesOf(mesh, label).size()); }

std::string nameOf(int label, const LabelNames& names) {
  const auto found = names.find(label);
  return found == names.end() ? fmt::format("label_{}", label) : found->second;
}

std::string gmshText(const LabelledMesh& mesh, const LabelNames& names, bool format_22, int order) {
  const Content content = contentOf(mesh, names, order);
  std::string text = fmt::format("$MeshFormat\n{} 0 8\n$EndMeshFormat\n", format_22 ? "2.2" : "4.1");
  const Out out(text);
  addNames(out, content);
  format_22 ? addBody22(out, mesh, content) : addBody41(out, mesh, content);
  return text;
}

std::string vtuText(const LabelledMesh& mesh, int order) {
  const Nodes nodes(mesh, order);
  const CellKind& kind = nodes.kindOf(3);
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n"
      "<Points>\n<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n",
      nodes.position().size(), mesh.tetrahedra.size());
  const Out out(text);
  const auto array = [&](const char* type, const char* name) {
    fmt::format_to(out, "</DataArray>\n<DataArray type=\"{}\" Name=\"{}\" format=\"ascii\">\n", type, name);
  };
  for (const Vec3& p : nodes.position()) addPosition(out, p);
  fmt::format_to(
      out, "</DataArray>\n</Points>\n<Cells>\n<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">\n");
  for (const Tetrahedron& t : mesh.tetrahedra) {
    const std::size_t before = text.size();
    nodes.forEach(t, kind.vtk, [&](Index n) { fmt::format_to(out, " {}", n); });
    text.erase(before, 1) += '\n';
  }
  array("Int32", "offsets");
  for (std::size_t c = 1; c <= mesh.tetrahedra.size(); ++c) fmt::format_to(out, "{}\n", std::size_t(kind.nodes) * c);
  array("UInt8", "types");
  for (std::size_t c = 0; c < mesh.tetrahedra.size(); ++c) fmt::format_to(out, "{}\n", kind.vtk.number);
  fmt::format_to(out,
                 "</DataArray>\n</Cells>\n<CellData Scalars=\"label\">\n<DataArray type=\"Int32\" Name=\"label\" "
                 "format=\"ascii\">\n");
  for (const int label : mesh.labels) fmt::format_to(out, "{}\n", label);
  text += "</DataArray>\n</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  return text;
}

}  // namespace stroma
