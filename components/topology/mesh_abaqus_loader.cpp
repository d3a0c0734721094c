// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads the mesh of an input file (.inp) of Abaqus or CalculiX: nodes, elements, sets and surfaces.
//
// Elements: C3D4 tetrahedra, C3D8 hexahedra, C3D6 prisms, C3D5 pyramids, C3D10 quadratic tetrahedra; S3, STRI3, M3D3, CPS3,
// CPE3 and R3D3 triangles; S4, M3D4, CPS4, CPE4 and R3D4 quads; STRI65, S6, M3D6, CPS6 and CPE6 quadratic triangles; B31, B21,
// T3D2 and T2D2 edges; with the letters that may follow, as C3D8R or C3D10M. Others without a counterpart are counted and
// reported; C3D15, C3D20 and the shells of eight nodes are an error. As by MeshGmshLoader the faces and edges of volume cells
// are added to the lists of the file unless createSubelements="false".
//
// Regions: `regions` lists element sets. `tetrahedraGroups` and its like hold 1 for cells of the first of them, 2 for those
// of the second, and 0 for all others; a cell of several is of the first. Without `regions` they are the sets that have a
// section (*SOLID SECTION, ELSET=...), or else those that lines *ELEMENT name, in the order of the file; a note lists them.
// ValuesFromLabels turns them into a material of each cell. Materials, loads and steps of the file are not read.
//
// Selections: with group="NAME" `groupIndices` holds the nodes of that node set, element set or surface, ascending, and
// `groupTriangleIndices` and its like its faces: those of a *SURFACE of faces S1 to S6, turned out of the body, or the shell
// elements of a set. Names are case-insensitive. Use one loader per selection.
//
// A file has one part and one instance of it; nodes of the assembly, such as reference points, are left out. A displacement of
// the instance in the assembly is ignored, with a warning. Units are those of the file: set unit="mm" for millimetres.
//
// Source: "Input Syntax Rules" and the keywords *NODE, *ELEMENT, *NSET, *ELSET and *SURFACE in the manuals of Abaqus and
// CalculiX. SOFA has no such loader.
//
// Example:
// <Node name="root">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-9"/>
//   <MeshAbaqusLoader name="loader" filename="meshes/block.inp" group="base"/>
//   <TetrahedronSetTopologyContainer name="tets" src="@loader"/>
//   <MechanicalObject name="dofs"/>
//   <UniformMass totalMass="1"/>
//   <TetrahedronFEMForceField method="polar" youngModulus="1e4" poissonRatio="0.3"/>
//   <FixedProjectiveConstraint indices="@loader.groupIndices"/>
// </Node>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "components/topology/abaqus_file.h"
#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"
#include "framework/scene/text.h"

namespace stroma {
namespace {

/// Faces S1, S2, ... by local nodes: seen from outside they turn clockwise. Of quadratic ones corners, then middles.
constexpr std::array<std::array<int, 3>, 4> abaqus_tetrahedron{{{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}};
constexpr std::array<std::array<int, 6>, 4> abaqus_quadratic{
    {{0, 1, 2, 4, 5, 6}, {0, 3, 1, 7, 8, 4}, {1, 3, 2, 8, 9, 5}, {2, 3, 0, 9, 7, 6}}};
constexpr std::array<std::array<int, 4>, 6> abaqus_hexahedron{
    {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1}, {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}}};
/// Those of two triangles come first, the base of a pyramid too.
constexpr std::array<std::array<int, 3>, 2> abaqus_prism_ends{{{0, 1, 2}, {3, 5, 4}}};
constexpr std::array<std::array<int, 4>, 3> abaqus_prism_sides{{{0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}}};
constexpr std::array<int, 4> abaqus_pyramid_base{0, 1, 2, 3};
constexpr std::array<std::array<int, 3>, 4> abaqus_pyramid_sides{{{0, 4, 1}, {1, 4, 2}, {2, 4, 3}, {3, 4, 0}}};

class MeshAbaqusLoader final : public MeshLoader {
 public:
  MeshAbaqusLoader() { create_subelements_ = true; }

  void declare(DataTable& table) override {
    MeshLoader::declare(table);
    table.add("regions", regions_).help("element sets whose cells have the labels 1, 2, ..., with blanks between");
    table.add("group", group_).help("node set, element set or surface whose nodes go to groupIndices");
    table.add("groupIndices", group_indices_).help("nodes of the group, ascending").output();
    table.add("groupTriangleIndices", group_triangles_).help("triangles of the group, by their index").output();
    table.add("groupQuadIndices", group_quads_)
        .help("quads of the group, by their index; not to be used with triangulate")
        .output();
    table.add("groupQuadraticTriangleIndices", group_quadratic_triangles_)
        .help("quadratic triangles of the group, by their index")
        .output();
    declareGroups(table, "region");
  }

 protected:
  void read(const std::string& file, Mesh& mesh) override {
    AbaqusFile content = readAbaqus(file);
    tellSkipped(content);
    label(content);
    if (!group_.empty()) select(content);
    mesh = std::move(content.mesh);
  }

 private:
  void tellSkipped(const AbaqusFile& content);
  void label(const AbaqusFile& content);
  void select(AbaqusFile& content);
  void tellLost(long count, const char* what);
  void selectElements(const AbaqusFile& content, const std::vector<long>& numbers);
  void selectFaces(AbaqusFile& content, const std::vector<AbaqusFile::Faces>& surface);
  void addFace(Mesh& mesh, const AbaqusFile::Place& place, std::size_t face);

  std::string regions_, group_;
  std::vector<int> group_indices_, group_triangles_, group_quads_, group_quadratic_triangles_;
};

void MeshAbaqusLoader::tellSkipped(const AbaqusFile& content) {
  for (const auto& [type, count] : content.skipped) {
    const std::string number = fmt::format("{} {} {} of the file", count, count == 1 ? "element" : "elements", type);
    if (type.starts_with("C3D"))
      warn(number + " without a counterpart here: the body has holes there", "C3D4, C3D5, C3D6, C3D8 and C3D10 alone");
    else
      inform(fmt::format("{} {} not used", number, count == 1 ? "is" : "are"));
  }
  if (!content.moved.empty())
    warn(fmt::format("the assembly moves the instance {}: its nodes are read where its part has them", content.moved),
         "translation and rotation of this loader");
}

void MeshAbaqusLoader::label(const AbaqusFile& content) {
  std::vector<std::string> names;
  for (Words words(regions_);;) {
    const std::string_view word = words.next();
    if (word.empty()) break;
    names.push_back(abaqusName(word));
  }
  const bool are_given = !names.empty();
  if (!are_given) names = content.sections.empty() ? content.element_lines : content.sections;
  forEachCellList([](const CellKind&, const auto& cells, std::vector<int>& groups) { groups.assign(cells.size(), 0); },
                  content.mesh, groups_);
  std::vector<std::string> labels;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto set = content.element_sets.find(names[i]);
    if (set == content.element_sets.end()) {
      if (!are_given) continue;
      std::vector<std::string> known;
      for (const auto& [name, numbers] : content.element_sets) known.push_back(name);
      throw ComponentError(fmt::format("the file has no element set '{}'", names[i]), "one of its sets",
                           nearest(names[i], known));
    }
    labels.push_back(fmt::format("{} {}", i + 1, names[i]));
    for (const long number : set->second) {
      const auto place = content.elements.find(number);
      if (place == content.elements.end()) continue;  // of a kind that is left out
      forEachCellList(
          [&](const CellKind& kind, std::vector<int>& groups) {
            if (kind.type == place->second.type && groups[std::size_t(place->second.number)] == 0)
              groups[std::size_t(place->second.number)] = int(i + 1);
          },
          groups_);
    }
  }
  if (!are_given && labels.size() > 1) inform(fmt::format("the labels of the regions are {}", fmt::join(labels, ", ")));
}

void MeshAbaqusLoader::select(AbaqusFile& content) {
  const std::string name = abaqusName(group_);
  const auto nodes = content.node_sets.find(name);
  const auto elements = content.element_sets.find(name);
  const auto surface = content.surfaces.find(name);
  if (nodes == content.node_sets.end() && elements == content.element_sets.end() && surface == content.surfaces.end()) {
    std::vector<std::string> known;
    for (const auto& [other, numbers] : content.node_sets) known.push_back(other);
    for (const auto& [other, numbers] : content.element_sets) known.push_back(other);
    for (const auto& [other, faces] : content.surfaces) known.push_back(other);
    throw ComponentError(fmt::format("the file has no set or surface '{}'", group_),
                         known.empty() ? "a file with *NSET, *ELSET or *SURFACE" : "one of its names",
                         nearest(name, known));
  }
  if (nodes != content.node_sets.end()) {
    long lost = 0;
    for (const long number : nodes->second)
      if (const auto node = content.nodes.find(number); node != content.nodes.end())
        group_indices_.push_back(int(node->second));
      else
        ++lost;
    tellLost(lost, "nodes");
  }
  if (elements != content.element_sets.end()) selectElements(content, elements->second);
  if (surface != content.surfaces.end()) selectFaces(content, surface->second);
  for (std::vector<int>* numbers : {&group_indices_, &group_triangles_, &group_quads_, &group_quadratic_triangles_}) {
    std::ranges::sort(*numbers);
    numbers->erase(std::unique(numbers->begin(), numbers->end()), numbers->end());
  }
  if (group_indices_.empty()) throw ComponentError(fmt::format("the group '{}' has no node", group_));
}

/// Their nodes, and those that are faces themselves.
void MeshAbaqusLoader::selectElements(const AbaqusFile& content, const std::vector<long>& numbers) {
  long lost = 0;
  for (const long number : numbers) {
    const auto place = content.elements.find(number);
    if (place == content.elements.end()) {
      ++lost;
      continue;
    }
    const auto& [type, at] = place->second;
    if (type == CellType::triangle) group_triangles_.push_back(int(at));
    if (type == CellType::quad) group_quads_.push_back(int(at));
    if (type == CellType::quadratic_triangle) group_quadratic_triangles_.push_back(int(at));
    forEachCellList(
        [&, type = type, at = at](const CellKind& kind, const auto& cells) {
          if (kind.type == type)
            group_indices_.insert(group_indices_.end(), cells[std::size_t(at)].begin(), cells[std::size_t(at)].end());
        },
        content.mesh);
  }
  tellLost(lost, "elements");
}

/// Sets that are generated may have gaps.
void MeshAbaqusLoader::tellLost(long count, const char* what) {
  if (count > 0) inform(fmt::format("the group '{}' names {} {} that are not in the file or were left out", group_, count, what));
}

void MeshAbaqusLoader::selectFaces(AbaqusFile& content, const std::vector<AbaqusFile::Faces>& surface) {
  std::set<std::pair<long, char>> made;
  for (const auto& [of, face, of_nodes] : surface) {
    const bool is_number = !of.empty() && of.size() < 18 && of.find_first_not_of("0123456789") == std::string::npos;
    std::vector<long> numbers;
    if (of_nodes && is_number && !content.node_sets.contains(of)) {
      const auto node = content.nodes.find(std::stol(of));
      node == content.nodes.end() ? tellLost(1, "nodes") : group_indices_.push_back(int(node->second));
      continue;
    }
    if (const auto set = content.element_sets.find(of); set != content.element_sets.end() && !of_nodes)
      numbers = set->second;
    else if (const auto nodes = content.node_sets.find(of); nodes != content.node_sets.end()) {  // TYPE=NODE
      for (const long number : nodes->second)
        if (const auto node = content.nodes.find(number); node != content.nodes.end())
          group_indices_.push_back(int(node->second));
      continue;
    } else if (is_number) {
      numbers = {std::stol(of)};
    } else {
      throw ComponentError(fmt::format("the surface '{}' is of {}, which is no set of the file", group_, of));
    }
    const bool is_face = face.size() == 2 && face[0] == 'S' && face[1] >= '1' && face[1] <= '6';
    for (const long number : numbers) {
      const auto place = content.elements.find(number);
      if (place == content.elements.end()) continue;
      const CellType type = place->second.type;
      if (kindOf(type).dimension == 3) {
        const std::size_t faces = kindOf(type).faces.size();
        if (!is_face || std::size_t(face[1] - '0') > faces)
          throw ComponentError(fmt::format("the surface '{}' names the face '{}' of element {}", group_, face, number),
                               fmt::format("S1 to S{}", faces));
        if (made.emplace(number, face[1]).second) addFace(content.mesh, place->second, std::size_t(face[1] - '1'));
      } else {
        selectElements(content, {number});
      }
    }
  }
}

/// A face of a volume cell, turned out of it, behind the cells that the file lists.
void MeshAbaqusLoader::addFace(Mesh& mesh, const AbaqusFile::Place& place, std::size_t face) {
  const auto add = [&](const auto& cell, const auto& of_cell, auto& faces, std::vector<int>& numbers,
                       std::vector<int>& groups) {
    auto& made = faces.emplace_back();
    for (std::size_t k = 0; k < made.size(); ++k) made[k] = cell[std::size_t(of_cell[k])];
    const std::size_t corners = made.size() == 4 ? 4 : 3;
    std::reverse(made.begin() + 1, made.begin() + std::ptrdiff_t(corners)),
        std::reverse(made.begin() + std::ptrdiff_t(corners), made.end());
    numbers.push_back(int(faces.size()) - 1), groups.push_back(0);
    group_indices_.insert(group_indices_.end(), made.begin(), made.end());
  };
  const auto at = std::size_t(place.number);
  if (place.type == CellType::tetrahedron)
    add(mesh.tetrahedra[at], abaqus_tetrahedron[face], mesh.triangles, group_triangles_, groups_.triangles);
  if (place.type == CellType::hexahedron)
    add(mesh.hexahedra[at], abaqus_hexahedron[face], mesh.quads, group_quads_, groups_.quads);
  if (place.type == CellType::prism && face < 2)
    add(mesh.prisms[at], abaqus_prism_ends[face], mesh.triangles, group_triangles_, groups_.triangles);
  if (place.type == CellType::prism && face >= 2)
    add(mesh.prisms[at], abaqus_prism_sides[face - 2], mesh.quads, group_quads_, groups_.quads);
  if (place.type == CellType::pyramid && face == 0)
    add(mesh.pyramids[at], abaqus_pyramid_base, mesh.quads, group_quads_, groups_.quads);
  if (place.type == CellType::pyramid && face > 0)
    add(mesh.pyramids[at], abaqus_pyramid_sides[face - 1], mesh.triangles, group_triangles_, groups_.triangles);
  if (place.type == CellType::quadratic_tetrahedron)
    add(mesh.quadratic_tetrahedra[at], abaqus_quadratic[face], mesh.quadratic_triangles, group_quadratic_triangles_,
        groups_.quadratic_triangles);
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_abaqus_loader) {
  factory.add<stroma::MeshAbaqusLoader>("MeshAbaqusLoader", "reads the mesh of an Abaqus or CalculiX .inp file");
}
