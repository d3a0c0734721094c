// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mesh/mesh_loader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "framework/mesh/cell_attributes.h"
#include "framework/mesh/cell_faces.h"
#include "framework/scene/written_units.h"

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

/// Of `keys`, those whose value another one before them has; ascending.
template <class Key>
std::vector<Index> secondOnes(std::vector<std::pair<Key, Index>> keys) {
  std::sort(keys.begin(), keys.end());
  std::vector<Index> second;
  for (std::size_t i = 1; i < keys.size(); ++i)
    if (keys[i].first == keys[i - 1].first) second.push_back(keys[i].second);
  std::sort(second.begin(), second.end());
  return second;
}

/// Volume cells are numbered through, tetrahedra first.
std::vector<Index> repeatedCells(const Mesh& mesh) {
  std::vector<Index> all;
  Index first = 0;
  forEachCellList(
      [&]<class Cell>(const CellKind& kind, const std::vector<Cell>& cells) {
        if (kind.dimension < 3) return;
        std::vector<std::pair<Cell, Index>> keys;
        keys.reserve(cells.size());
        for (Cell cell : cells) {
          std::sort(cell.begin(), cell.end());
          keys.emplace_back(cell, first++);
        }
        const std::vector<Index> second = secondOnes(std::move(keys));
        all.insert(all.end(), second.begin(), second.end());
      },
      mesh);
  return all;
}

/// Places are told apart to a share of the mesh's size that is round-off of files with nine digits.
std::vector<Index> coincidentNodes(const Mesh& mesh, const MeshReport& box) {
  constexpr double share = 1e-8;
  const double size = (box.high - box.low).maxCoeff();
  if (!(size > 0)) return {};
  std::vector<char> used(mesh.position.size(), 0);
  forEachCellList(
      [&used](const CellKind& kind, const auto& cells) {
        for (std::size_t c = 0; kind.dimension == 3 && c < cells.size(); ++c)
          for (const Index node : cells[c]) used[std::size_t(node)] = 1;
      },
      mesh);
  std::vector<std::pair<std::array<std::int64_t, 3>, Index>> keys;
  for (std::size_t n = 0; n < used.size(); ++n) {
    if (!used[n]) continue;
    const Vec3 place = (mesh.position[n] - box.low) / (share * size);
    keys.push_back({{std::llround(place.x()), std::llround(place.y()), std::llround(place.z())}, Index(n)});
  }
  return secondOnes(std::move(keys));
}

/// "3 nodes in the place of others (0 1 2)", at most five of them named.
std::string someOf(const std::vector<Index>& list, std::string_view what) {
  const std::size_t shown = std::min<std::size_t>(list.size(), 5);
  return fmt::format("{} {} ({}{})", list.size(), what,
                     fmt::join(list.begin(), list.begin() + std::ptrdiff_t(shown), " "),
                     shown < list.size() ? " ..." : "");
}

}  // namespace

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
  read(filename_.found, mesh_);
  if (mesh_.position.empty()) throw ComponentError(fmt::format("{} has no nodes", filename_.given), "a mesh");
  if (highestDimension(mesh_) == 0)
    throw ComponentError(fmt::format("{} has {} nodes but no cell that can be used", filename_.given, mesh_.nodes()),
                         "edges, triangles, quads, tetrahedra or hexahedra");
  if (const std::string error = mesh_.firstError(); !error.empty())
    throw ComponentError(fmt::format("{}: {}", filename_.given, error));
  if (only_attached_points_) removeUnusedNodes();
  makeMetres(mesh_.position, unit_);
  transform();
  if (triangulate_) splitQuads();
  if (flip_normals_) flipFaces();
  // The complaint is about what the file has: faces added below would use every node of a cell anyway.
  if (const std::string complaint = meshComplaint(mesh_); !complaint.empty())
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
  if (is_flat && !(mesh_.tetrahedra.empty() && mesh_.hexahedra.empty()))
    throw ComponentError(
        "the mesh is flattened: its volume cells have none left",
        table.find("transformation")->isSet() ? "a transformation that can be undone" : "scales other than 0");
  for (Vec3& p : mesh_.position) p = linear * p + shift;
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
          if (kind.dimension == 2) std::reverse(cell.begin() + 1, cell.end());
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
  appendMissing(mesh.triangles, uniqueFaces(mesh.tetrahedra, false));
  appendMissing(mesh.quads, uniqueFaces(mesh.hexahedra, false));
  // A mesh of its own, so that the lists derived from the cells before the new ones are not kept.
  const Mesh complete{mesh};
  appendMissing(mesh.edges, complete.allEdges());
}

std::string meshComplaint(const Mesh& mesh) {
  const MeshReport report = mesh.report();
  const bool no_volume = highestDimension(mesh) == 3 && !(report.volume > 0);
  std::string twice;
  if (const std::vector<Index> cells = repeatedCells(mesh); !cells.empty())
    twice = ", " + someOf(cells, "volume cells that are there already");
  if (const std::vector<Index> nodes = coincidentNodes(mesh, report); !nodes.empty())
    twice += ", " + someOf(nodes, "nodes in the place of others, which part the body unless something joins them");
  if (report.inverted.empty() && report.flat.empty() && report.unused_nodes.empty() && !no_volume && twice.empty())
    return {};
  return fmt::format("{}{}{}", no_volume ? "the mesh has no volume: " : "the mesh has faults: ", report.text(), twice);
}

}  // namespace stroma
