// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mesh/mesh_loader.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <utility>
#include <variant>

#include "framework/mesh/cell_attributes.h"
#include "framework/mesh/cell_faces.h"
#include "framework/scene/load.h"
#include "framework/scene/written_units.h"
#include "tools/mesh_report/read_meshes.h"

namespace stroma {

namespace {

/// Appends the `candidates` whose set of nodes no cell of `cells` has.
template <class Cell>
void appendMissing(std::vector<Cell>& cells, const std::vector<Cell>& candidates) {
  const auto sorted = [](Cell cell) {
    std::sort(cell.begin(), cell.end());
    return cell;
  };
  std::vector<Cell> present;
  present.reserve(cells.size());
  for (const Cell& cell : cells) present.push_back(sorted(cell));
  std::sort(present.begin(), present.end());
  for (const Cell& cell : candidates)
    if (!std::binary_search(present.begin(), present.end(), sorted(cell))) cells.push_back(cell);
}

/// The same volume cell with its nodes in the order of the mirror image.
template <class Cell>
void mirror(Cell& cell) {
  if constexpr (std::tuple_size_v<Cell> == 8 || std::tuple_size_v<Cell> == 6) {
    const auto half = std::ptrdiff_t(cell.size() / 2);
    std::swap_ranges(cell.begin(), cell.begin() + half, cell.begin() + half);
  } else if constexpr (std::tuple_size_v<Cell> == 5) {
    std::swap(cell[1], cell[3]);
  } else if constexpr (std::tuple_size_v<Cell> >= 4) {
    std::swap(cell[1], cell[2]);
    if constexpr (std::tuple_size_v<Cell> == 10) {
      std::swap(cell[4], cell[6]);
      std::swap(cell[8], cell[9]);
    }
  }
}

/// Volume cells that a mirrored mesh has inside out; their number.
std::size_t turnInvertedCells(Mesh& mesh) {
  std::size_t count = 0;
  forEachCellList(
      [&](const CellKind& kind, auto& cells) {
        if (kind.dimension < 3) return;
        std::vector<Vec3> x(std::size_t(kind.nodes));
        for (auto& cell : cells) {
          for (std::size_t k = 0; k < cell.size(); ++k) x[k] = mesh.position[std::size_t(cell[k])];
          if (kind.size(x.data()) < 0) {
            mirror(cell);
            ++count;
          }
        }
      },
      mesh);
  return count;
}

thread_local Node* read_before = nullptr;  ///< root of the tree with loaders that have read

/// What nobody gave may have been found by init().
bool isTheSame(const Data& one, const Data& other) {
  if (one.name() != other.name() || one.isSet() != other.isSet()) return false;
  if (!one.isSet()) return true;
  const auto *file = std::get_if<FileName*>(&one.pointer()), *other_file = std::get_if<FileName*>(&other.pointer());
  const bool is_file = !file || !other_file || (*file)->found == (*other_file)->found;
  return is_file && one.print() == other.print();
}

void copyValue(const Data& from, const Data& to) {
  std::visit(
      [&from](const auto& value) {
        using Pointer = std::decay_t<decltype(value)>;
        const auto* const of_former = std::get_if<Pointer>(&from.pointer());
        if constexpr (!std::is_same_v<Pointer, ChoiceRef> && !std::is_same_v<Pointer, LinkBase*>)
          if (of_former) *value = **of_former;
      },
      to.pointer());
}

/// All that a loader knows of what it has read is in its outputs: there is nothing else to take.
bool takesReadMesh(MeshLoader& loader) {
  const Component* const former = read_before ? findComponent(*read_before, loader.path()) : nullptr;
  if (!dynamic_cast<const MeshLoader*>(former) || former->type() != loader.type() || former->hasFailed()) return false;
  const std::vector<Data>&own = loader.data().all(), &read = former->data().all();
  if (own.size() != read.size()) return false;
  for (std::size_t i = 0; i < own.size(); ++i)
    if (!own[i].isOutput() && !isTheSame(own[i], read[i])) return false;
  for (std::size_t i = 0; i < own.size(); ++i)
    if (own[i].isOutput()) copyValue(read[i], own[i]);
  return true;
}

}  // namespace

ReadMeshes::ReadMeshes(Node& root) : before_(std::exchange(read_before, &root)) {}
ReadMeshes::~ReadMeshes() { read_before = before_; }

void MeshLoader::declare(DataTable& table) {
  table.add("filename", filename_).help("mesh file").required().input();
  table.add("unit", unit_)
      .help("unit of the file's positions, as mm: they become metres before all else; empty: metres");
  table.add("translation", translation_).unit("m").help("moves the mesh, after rotation and scale");
  table.add("rotation", rotation_).unit("degree").help("Euler angles about x, then y, then z");
  table.add("scale3d", scale3d_).unit("-").help("factor for each axis, applied first");
  table.add("scale", scale_).unit("-").help("one factor for the three axes").shorthand();
  table.add("transformation", transformation_)
      .help(
          "4x4 matrix by rows; replaces translation, rotation and scale. Its last column is in metres, whatever unit "
          "is");
  table.add("flipNormals", flip_normals_).help("turn triangles and quads over");
  table.add("triangulate", triangulate_).help("split quads into triangles");
  table.add("createSubelements", create_subelements_).help("add the faces and edges of the volume cells");
  table.add("pointsOnly", points_only_).help("a file of nodes without cells is no error");
  table.add("onlyAttachedPoints", only_attached_points_)
      .help("leave nodes without cells out: later ones get new numbers");
  table.add("position", mesh_.position).alias("points").unit("m").help("nodes").output();
  forEachCellList(
      [&table](const CellKind& kind, auto& cells) {
        addCellList(table, kind, cells).help(fmt::format("{} of the file", kind.plural)).output();
      },
      mesh_);
}

void MeshLoader::declareDirections(DataTable& table) {
  table.add("directionArray", directions_.array)
      .help("cell or point data of 3, 6 or 9 numbers that go to tetrahedraDirections and its like: fibres, sheets");
  forEachCellList(
      [&table](const CellKind& kind, auto& directions) {
        if (kind.dimension < 3) return;
        table.add(fmt::format("{}Directions", kind.plural), directions)
            .unit("-")
            .help(
                fmt::format("directions of each {}, of cell data; they turn and stretch with the mesh", kind.singular))
            .output();
      },
      directions_.cells);
  table.add("nodeDirections", directions_.nodes).unit("-").help("the same of each node, of point data").output();
}

void MeshLoader::declareGroups(DataTable& table, const std::string& word) {
  forEachCellList(
      [&](const CellKind& kind, std::vector<int>& groups) {
        table.add(fmt::format("{}Groups", kind.plural), groups)
            .help(fmt::format("{} of each {} of the file", word, kind.singular))
            .output();
      },
      groups_);
}

void MeshLoader::init() {
  if (takesReadMesh(*this)) return;
  read(filename_.found, mesh_);
  if (mesh_.position.empty()) throw ComponentError(fmt::format("{} has no nodes", filename_.given), "a mesh");
  const bool has_cells = highestDimension(mesh_) > 0;
  if (!has_cells && !points_only_)
    throw ComponentError(fmt::format("{} has {} nodes but no cell that can be used", filename_.given, mesh_.nodes()),
                         "edges, triangles, quads, tetrahedra, hexahedra, prisms or pyramids");
  if (const std::string error = mesh_.firstError(); !error.empty())
    throw ComponentError(fmt::format("{}: {}", filename_.given, error));
  if (only_attached_points_) removeUnusedNodes();
  makeMetres(mesh_.position, unit_);
  transform();
  if (triangulate_) splitQuads();
  if (flip_normals_) flipFaces();
  // The complaint is about what the file has: faces added below would use every node of a cell anyway.
  if (const std::string complaint = has_cells ? meshComplaint(mesh_) : ""; !complaint.empty())
    warn(fmt::format("{}: {}", filename_.given, complaint));
  if (create_subelements_) addSubelements(mesh_);
}

void MeshLoader::removeUnusedNodes() {
  std::vector<Index> number(mesh_.position.size(), 0);
  const auto forEachNode = [&](auto&& visit) {
    forEachCellList(
        [&](const CellKind&, auto& cells) {
          for (auto& cell : cells)
            for (Index& node : cell) visit(node);
        },
        mesh_);
  };
  forEachNode([&](Index node) { number[node] = 1; });
  const auto keepUsed = [&](std::vector<Vec3>& values, std::size_t each) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (number[i / each]) values[kept++] = values[i];
    values.resize(kept);
  };
  if (!directions_.nodes.empty()) keepUsed(directions_.nodes, directions_.nodes.size() / mesh_.position.size());
  keepUsed(mesh_.position, 1);
  Index next = 0;
  for (Index& n : number) n = n ? next++ : -1;
  forEachNode([&](Index& node) { node = number[node]; });
}

void MeshLoader::transform() {
  const DataTable& table = data();
  const bool parts = table.find("translation")->isSet() || table.find("rotation")->isSet() ||
                     table.find("scale3d")->isSet() || table.find("scale")->isSet();
  if (table.find("scale")->isSet() && table.find("scale3d")->isSet())
    throw ComponentError("both scale and scale3d are given", "one of them");
  if (table.find("scale")->isSet()) scale3d_ = Vec3::Constant(scale_);
  Mat3 linear;
  Vec3 shift;
  if (table.find("transformation")->isSet()) {
    if (parts) warn("transformation is given: translation, rotation and scale are not used");
    const auto& m = transformation_;
    if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
      throw ComponentError("the last row of transformation is not that of an affine map", "0 0 0 1");
    linear << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
    shift << m[3], m[7], m[11];
    if (metresOf(unit_) != 1 && shift != Vec3::Zero())
      warn(fmt::format("the last column of transformation is in metres: unit=\"{}\" is that of the file", unit_),
           fmt::format("write metres, or leave unit out and scale by {}", metresOf(unit_)));
  } else {
    if (!parts) return;
    linear = rotationFromDegrees(rotation_) * scale3d_.asDiagonal();
    shift = translation_;
  }
  // of columns of length one, so that thin is not flat; a column of zeros makes it no number
  const bool is_flat = !(std::abs(linear.colwise().normalized().determinant()) > 1e-14);
  if (is_flat && highestDimension(mesh_) == 3)
    throw ComponentError(
        "the mesh is flattened: its volume cells have none left",
        table.find("transformation")->isSet() ? "a transformation that can be undone" : "scales other than 0");
  for (Vec3& p : mesh_.position) p = linear * p + shift;
  const std::size_t turned = linear.determinant() < 0 ? turnInvertedCells(mesh_) : 0;
  if (turned > 0) {
    flipFaces();  // they would look into the body
    inform(fmt::format("the mesh is mirrored, and the nodes of its {} volume cells and of their faces are put in the order of the image",
                       turned));
  }
  const auto turn = [&linear](std::vector<Vec3>& list) {
    for (Vec3& v : list) v = linear * v;
  };
  turn(directions_.nodes);
  forEachCellList([&](const CellKind&, std::vector<Vec3>& list) { turn(list); }, directions_.cells);
}

void MeshLoader::flipFaces() {
  forEachCellList(
      [](const CellKind& kind, auto& cells) {
        for (auto& cell : cells)
          if (kind.dimension == 2) {  // corners and middles apart
            const auto middles = cell.begin() + std::ptrdiff_t(cell.size()) / kind.order;
            std::reverse(cell.begin() + 1, middles), std::reverse(middles, cell.end());
          }
      },
      mesh_);
}

void MeshLoader::splitQuads() {
  for (const Quad& q : mesh_.quads) {
    mesh_.triangles.push_back({q[0], q[1], q[2]});
    mesh_.triangles.push_back({q[0], q[2], q[3]});
  }
  mesh_.quads.clear();
}

Mat3 rotationFromDegrees(const Vec3& angles) {
  const Vec3 a = angles * (std::numbers::pi / 180);
  using Turn = Eigen::AngleAxisd;
  return (Turn(a.z(), Vec3::UnitZ()) * Turn(a.y(), Vec3::UnitY()) * Turn(a.x(), Vec3::UnitX())).toRotationMatrix();
}

void addSubelements(Mesh& mesh) {
  appendMissing(mesh.triangles, uniqueTriangles(mesh, false));
  appendMissing(mesh.quads, uniqueQuads(mesh, false));
  appendMissing(mesh.quadratic_triangles, uniqueQuadraticTriangles(mesh, false));
  // A mesh of its own, so that the lists derived from the cells before the new ones are not kept.
  const Mesh complete{mesh};
  appendMissing(mesh.edges, complete.allEdges());
}

}  // namespace stroma
