// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes the moving mesh of a state to files for other programs.
//
// OBJExporter: the surface as Wavefront .obj. STLExporter: as .stl, binary unless binaryformat="false". The surface is the
//   mesh's triangles and quads, else the faces of its volume cells that belong to one cell.
// MeshExporter: the mesh in the format `format`: vtk (legacy, all cells), gmsh (.msh 2.2, all cells), obj, netgen (.mesh: nodes,
//   tetrahedra and triangles), or ALL of them. A quadratic triangle of a surface is four flat ones; of quadratic tetrahedra netgen
//   has the corners.
//
// Files are called filename, a number of five digits unless it is written once only, and the ending of the format. They are
// written after every exportEveryNumberOfSteps steps (0: never), and with exportAtBegin and exportAtEnd before the first step
// and after the last. Without any of the three the last state is written.
//
// Source: names and attributes are SOFA's; there, nothing is written unless one of them is set.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-9"/>
//   <RegularGridTopology n="3 2 2" min="0 0 0" max="0.2 0.1 0.1"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="1"/>
//   <HexahedronFEMForceField youngModulus="1e4" poissonRatio="0.3"/>
//   <OBJExporter filename="skin" exportEveryNumberOfSteps="5"/>
//   <STLExporter filename="skin" exportAtEnd="true"/>
//   <MeshExporter filename="body" format="gmsh" exportAtEnd="true"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>

#include "framework/mechanics/state_positions.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/scene/output_file.h"
#include "framework/simulation/observer.h"
#include "framework/simulation/simulation.h"

namespace stroma {
namespace {

/// The triangles of the surface: quads as two each, quadratic triangles as four, or with corners_only as one.
std::vector<Triangle> skinOf(const Mesh& mesh, bool corners_only = false) {
  const bool has_faces = !mesh.triangles.empty() || !mesh.quads.empty() || !mesh.quadratic_triangles.empty();
  std::vector<Triangle> skin = has_faces ? mesh.triangles : mesh.boundaryTriangles();
  for (const Quad& q : has_faces ? mesh.quads : mesh.boundaryQuads())
    skin.push_back({q[0], q[1], q[2]}), skin.push_back({q[0], q[2], q[3]});
  for (const QuadraticTriangle& t : has_faces ? mesh.quadratic_triangles : mesh.boundaryQuadraticTriangles()) {
    if (corners_only)
      skin.push_back({t[0], t[1], t[2]});
    else
      skin.insert(skin.end(), {{t[0], t[3], t[5]}, {t[3], t[1], t[4]}, {t[5], t[4], t[2]}, {t[3], t[4], t[5]}});
  }
  return skin;
}

std::string objOf(const Mesh& mesh, const std::vector<Vec3>& x) {
  std::string text = "# written by Stroma\n";
  for (const Vec3& p : x) text += fmt::format("v {} {} {}\n", p[0], p[1], p[2]);
  for (const Triangle& t : skinOf(mesh)) text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

std::string stlOf(const Mesh& mesh, const std::vector<Vec3>& x, bool binary) {
  const std::vector<Triangle> skin = skinOf(mesh);
  std::string text = binary ? std::string(80, ' ') : "solid stroma\n";
  const auto append = [&text](const auto& value) { text.append(reinterpret_cast<const char*>(&value), sizeof value); };
  if (binary) append(std::uint32_t(skin.size()));
  for (const Triangle& t : skin) {
    const Vec3 n = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).normalized();
    const Vec3 corners[4] = {n, x[t[0]], x[t[1]], x[t[2]]};
    if (binary) {
      for (const Vec3& p : corners)
        for (int c = 0; c < 3; ++c) append(float(p[c]));
      append(std::uint16_t(0));
      continue;
    }
    text += fmt::format("facet normal {} {} {}\nouter loop\n", n[0], n[1], n[2]);
    for (int k = 1; k < 4; ++k) text += fmt::format("vertex {} {} {}\n", corners[k][0], corners[k][1], corners[k][2]);
    text += "endloop\nendfacet\n";
  }
  return binary ? text : text + "endsolid stroma\n";
}

/// line(number, nodes) for each cell, with the number and in the order of a format; cells ascend in dimension.
template <class Line>
std::size_t forCells(const Mesh& mesh, CellFormat CellKind::*format, Line&& line) {
  std::size_t count = 0;
  std::vector<Index> nodes;
  forEachCellList(
      [&](const CellKind& kind, const auto& cells) {
        const CellFormat& written = kind.*format;
        nodes.resize(written.order.size());
        for (const auto& cell : cells) {
          for (std::size_t k = 0; k < nodes.size(); ++k) nodes[k] = cell[std::size_t(written.order[k])];
          line(written.number, nodes), ++count;
        }
      },
      mesh);
  return count;
}

std::string vtkOf(const Mesh& mesh, const std::vector<Vec3>& x) {
  std::string text = "# vtk DataFile Version 3.0\nwritten by Stroma\nASCII\nDATASET UNSTRUCTURED_GRID\n";
  text += fmt::format("POINTS {} double\n", x.size());
  for (const Vec3& p : x) text += fmt::format("{} {} {}\n", p[0], p[1], p[2]);
  std::string cells, kinds;
  std::size_t numbers = 0;
  const std::size_t count = forCells(mesh, &CellKind::vtk, [&](int kind, const std::vector<Index>& nodes) {
    cells += fmt::format("{} {}\n", nodes.size(), fmt::join(nodes, " "));
    kinds += fmt::format("{}\n", kind);
    numbers += nodes.size() + 1;
  });
  return text + fmt::format("CELLS {} {}\n{}CELL_TYPES {}\n{}", count, numbers, cells, count, kinds);
}

std::string gmshOf(const Mesh& mesh, const std::vector<Vec3>& x) {
  std::string text = fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", x.size());
  for (std::size_t i = 0; i < x.size(); ++i) text += fmt::format("{} {} {} {}\n", i + 1, x[i][0], x[i][1], x[i][2]);
  std::string cells;
  std::size_t number = 0;
  const std::size_t count = forCells(mesh, &CellKind::gmsh, [&](int type, const std::vector<Index>& nodes) {
    cells += fmt::format("{} {} 0", ++number, type);
    for (const Index node : nodes) cells += fmt::format(" {}", node + 1);
    cells += '\n';
  });
  return text + fmt::format("$EndNodes\n$Elements\n{}\n{}$EndElements\n", count, cells);
}

std::string netgenOf(const Mesh& mesh, const std::vector<Vec3>& x) {
  std::string text = fmt::format("{}\n", x.size());
  for (const Vec3& p : x) text += fmt::format("{} {} {}\n", p[0], p[1], p[2]);
  text += fmt::format("{}\n", mesh.tetrahedra.size() + mesh.quadratic_tetrahedra.size());
  const auto add = [&text](const auto& t) { text += fmt::format("1 {} {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1, t[3] + 1); };
  std::for_each(mesh.tetrahedra.begin(), mesh.tetrahedra.end(), add);
  std::for_each(mesh.quadratic_tetrahedra.begin(), mesh.quadratic_tetrahedra.end(), add);
  const std::vector<Triangle> skin = skinOf(mesh, true);
  text += fmt::format("{}\n", skin.size());
  for (const Triangle& t : skin) text += fmt::format("1 {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

class MeshFileExporter : public Observer {
 public:
  void declare(DataTable& table) override {
    table.add("filename", filename_).help("start of the names of the files; default: the component's name");
    table.add("exportEveryNumberOfSteps", every_).help("steps from one export to the next; 0: none").min(0);
    table.add("exportAtBegin", at_begin_).help("export the initial state");
    table.add("exportAtEnd", at_end_).help("export the last state");
    table.add("enable", enable_).help("export at all");
    table.addLink("mstate", mstate_).help("the state; default: that of the node or above");
    topology_link_.declare(table, "mesh to export");
    for (const char* name : {"position", "triangle", "quad", "edge", "tetras", "hexas"}) table.addVisualOnly(name);
  }
  void init() override {
    state_ = mstate_.target() ? mstate_.get() : find<State>(true);
    topology_ = state_ ? topology_link_.find(*this, *state_) : nullptr;
    if (!state_ || !topology_) warn("there is no state with a mesh here or above: nothing will be written", "mstate and topology");
    if (every_ == 0 && !at_begin_) at_end_ = true;
  }
  void begin(const Simulation& simulation) override {
    if (simulation.steps() == 0) number_ = 0;
    if (at_begin_ && simulation.steps() == 0) write();
  }
  void afterStep(const Simulation& simulation, const StepContext&) override {
    if (every_ > 0 && simulation.steps() % every_ == 0) write();
  }
  void end(const Simulation&) override {
    if (at_end_) write();
  }
  bool readsAllNodes(const StepContext& context) const override { return every_ > 0 && context.index % every_ == 0; }
  std::vector<std::string> files() const override {
    std::vector<std::string> all;
    if (writes())
      for (const std::string& ending : endings()) all.push_back(pathOf(ending));
    return all;
  }
  bool replacesFiles() const override { return true; }
  void serialize(Archive& archive) override { archive.value("number", number_); }
  std::string describe() const override {
    return writes() ? fmt::format("writes {}", fmt::join(files(), ", ")) : "writes nothing";
  }

 protected:
  virtual std::vector<std::string> endings() const = 0;
  virtual std::string textOf(const std::string& ending, const Mesh& mesh, const std::vector<Vec3>& x) const = 0;

 private:
  bool writes() const { return enable_ && state_ && topology_; }
  bool isSeries() const { return every_ > 0 || (at_begin_ && at_end_); }
  std::string pathOf(const std::string& ending) const {
    std::string path = filename_.empty() ? name() : filename_.found;
    if (path.ends_with(ending)) path.resize(path.size() - ending.size());
    return isSeries() ? fmt::format("{}{:05}{}", path, number_, ending) : path + ending;
  }
  void write() {
    if (!writes()) return;
    std::vector<Vec3> x;
    for (Index node = 0; node < state_->nodes(); ++node) {
      const Index row = node * state_->rows_per_node;
      x.push_back(state_->isBound() ? Vec3(state_->x()[row]) : state_->position[std::size_t(row)]);
    }
    for (const std::string& ending : endings()) writeWholeFile(pathOf(ending), textOf(ending, topology_->mesh(), x));
    ++number_;
  }
  FileName filename_;
  Link<State> mstate_{"mechanical state"};
  TopologyLink topology_link_;
  int every_ = 0;
  bool at_begin_ = false, at_end_ = false, enable_ = true;
  State* state_ = nullptr;
  const Topology* topology_ = nullptr;
  long number_ = 0;
};

class ObjExporter final : public MeshFileExporter {
  std::vector<std::string> endings() const override { return {".obj"}; }
  std::string textOf(const std::string&, const Mesh& mesh, const std::vector<Vec3>& x) const override { return objOf(mesh, x); }
};

class StlExporter final : public MeshFileExporter {
 public:
  void declare(DataTable& table) override {
    MeshFileExporter::declare(table);
    table.add("binaryformat", binary_).help("binary, else text");
  }

 private:
  std::vector<std::string> endings() const override { return {".stl"}; }
  std::string textOf(const std::string&, const Mesh& mesh, const std::vector<Vec3>& x) const override { return stlOf(mesh, x, binary_); }
  bool binary_ = true;
};

class MeshExporter final : public MeshFileExporter {
 public:
  void declare(DataTable& table) override {
    MeshFileExporter::declare(table);
    table.addChoice("format", format_, {"ALL", "vtk", "gmsh", "obj", "netgen"}).help("which format");
    for (const char* name : {"writeEdges", "writeTriangles", "writeQuads", "writeTetras", "writeHexas"}) table.addVisualOnly(name);
  }

 private:
  std::vector<std::string> endings() const override {
    const std::vector<std::string> all{".vtk", ".msh", ".obj", ".mesh"};
    return format_ == Format::all ? all : std::vector<std::string>{all[std::size_t(format_) - 1]};
  }
  std::string textOf(const std::string& ending, const Mesh& mesh, const std::vector<Vec3>& x) const override {
    if (ending == ".vtk") return vtkOf(mesh, x);
    if (ending == ".msh") return gmshOf(mesh, x);
    return ending == ".obj" ? objOf(mesh, x) : netgenOf(mesh, x);
  }
  enum class Format : int { all, vtk, gmsh, obj, netgen } format_ = Format::all;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_exporters) {
  factory.add<stroma::ObjExporter>("OBJExporter", "writes the moving surface as .obj");
  factory.add<stroma::StlExporter>("STLExporter", "writes the moving surface as .stl");
  factory.add<stroma::MeshExporter>("MeshExporter", "writes the moving mesh for VTK, Gmsh, Netgen or as .obj");
}
