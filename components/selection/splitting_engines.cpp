// SPDX-License-Identifier: LGPL-2.1-or-later
// Points joined, projected and shared out, before the first step.
//
// JoinPoints: mergedPoints, `points` of which those nearer than `distance` are one: each in its order takes its nearest neighbour,
//   both become their mean (weighed by how many points each stands for), as long as there is one.
// ProjectiveTransformEngine: output_position = f/z (x, y, z) with (x, y, z) = proj_mat (p, 1) of input_position p and f = focal_distance:
//   pictures of a pinhole camera whose 3x4 matrix is proj_mat.
// MeshSplittingEngine: position1, position2, ..., the points of `position` that lie in the lists indices1, indices2, ... or on cells
//   that edgeIndices1, triangleIndices1, ... list, each in the first such list; the points of no list come last. indexPairs has the
//   list (from 0) and the place in it for each point, as SubsetMultiMapping takes them (at most seven lists).
//
// Source: names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <JoinPoints name="joined" points="0 0 1  0.1 0 1  2 0 1" distance="0.5"/>
//   <ProjectiveTransformEngine name="picture" input_position="@joined.mergedPoints" focal_distance="1"
//     proj_mat="1 0 0 0  0 1 0 0  0 0 1 0"/>
//   <MeshSplittingEngine name="split" position="@picture.output_position" nbInputs="1" indices1="1"/>
//   <Node name="one">
//     <EulerExplicitSolver/>
//     <MechanicalObject position="@../split.position1"/>
//     <UniformMass totalMass="1"/>
//   </Node>
//   <Node name="other">
//     <EulerExplicitSolver/>
//     <MechanicalObject position="@../split.position2"/>
//     <UniformMass totalMass="1"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <list>

#include "components/selection/engine.h"
#include "framework/mesh/cell_lists.h"
#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class JoinPoints final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("points", points_).help("points to join").unit("m").required();
    table.add("distance", distance_).help("points nearer than this are one").unit("m").min(0);
    table.add("mergedPoints", merged_).help("the points that are left").unit("m").output();
  }
  void init() override {
    struct Group {
      Vec3 place;
      double count;
    };
    std::list<Group> groups;
    for (const Vec3& p : points_) groups.push_back({p, 1});
    for (auto group = groups.begin(); group != groups.end();) {
      auto nearest = groups.end();
      double least = distance_;
      for (auto other = groups.begin(); other != groups.end(); ++other) {
        const double way = (other->place - group->place).norm();
        if (other != group && way < least) nearest = other, least = way;
      }
      if (nearest == groups.end()) {
        ++group;
        continue;
      }
      const double count = group->count + nearest->count;
      *group = {(group->count * group->place + nearest->count * nearest->place) / count, count};
      groups.erase(nearest);
    }
    merged_.clear();
    for (const Group& group : groups) merged_.push_back(group.place);
  }

 private:
  std::vector<Vec3> points_, merged_;
  double distance_ = 0;
};

class ProjectiveTransformEngine final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("input_position", input_).help("points in space").unit("m");
    table.add("output_position", output_).help("their pictures").unit("m").output();
    table.add("proj_mat", matrix_).help("3x4 matrix of the camera, row by row").required();
    table.add("focal_distance", focal_).help("where the plane of the picture lies").unit("m");
  }
  void init() override {
    if (matrix_.size() != 12) throw ComponentError(fmt::format("proj_mat has {} numbers", matrix_.size()), "3 rows of 4");
    output_.clear();
    for (const Vec3& p : input_) {
      Vec3 seen;
      for (Index k = 0; k < 3; ++k) {
        const double* row = matrix_.data() + 4 * k;
        seen[k] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
      }
      const double size = Vec3::Map(matrix_.data() + 8).norm() * p.norm() + std::abs(matrix_[11]);
      if (!(std::abs(seen[2]) > 1e-12 * size))
        throw ComponentError(fmt::format("the point {} {} {} lies in the plane of the camera: it has no picture", p[0], p[1], p[2]),
                             "points before or behind it");
      output_.push_back(focal_ / seen[2] * seen);
    }
  }

 private:
  std::vector<Vec3> input_, output_;
  std::vector<double> matrix_;
  double focal_ = 1;
};

class MeshSplittingEngine final : public Engine {
 public:
  static constexpr std::size_t most = 8;
  void declare(DataTable& table) override {
    table.add("position", mesh_.position).help("points to share out").unit("m").required();
    forEachCellList(
        [&](const CellKind& kind, auto& cells) { table.add(std::string(kind.plural), cells).help("cells between them"); }, mesh_);
    table.add("nbInputs", count_).help("how many lists").min(0).max(int(most) - 1);
    for (std::size_t i = 0; i < most; ++i) {
      table.add(fmt::format("position{}", i + 1), parts_[i]).help(fmt::format("points of part {}", i + 1)).unit("m").output();
      if (i + 1 == most) break;
      table.add(fmt::format("indices{}", i + 1), nodes_[i]).help(fmt::format("points of part {}", i + 1));
      std::size_t which = 0;
      for (const char* kind : {"edge", "triangle", "quad", "tetrahedron", "hexahedron"})
        table.add(fmt::format("{}Indices{}", kind, i + 1), cells_[i][which++]).help(fmt::format("{}s of part {}", kind, i + 1));
    }
    table.add("indexPairs", pairs_).help("part and place in it of each point").output();
  }
  void init() override {
    const std::size_t count = std::size_t(count_), points = mesh_.position.size();
    std::vector<std::size_t> part(points, count);
    const auto put = [&](Index node, std::size_t i) {
      if (node >= 0 && std::size_t(node) < points) part[std::size_t(node)] = i;
    };
    for (std::size_t i = count; i-- > 0;) {  // the first list wins
      for (const int node : nodes_[i]) put(node, i);
      putCells(mesh_.edges, cells_[i][0], "edgeIndices", i, put), putCells(mesh_.triangles, cells_[i][1], "triangleIndices", i, put);
      putCells(mesh_.quads, cells_[i][2], "quadIndices", i, put);
      putCells(mesh_.tetrahedra, cells_[i][3], "tetrahedronIndices", i, put);
      putCells(mesh_.hexahedra, cells_[i][4], "hexahedronIndices", i, put);
    }
    for (auto& points_of : parts_) points_of.clear();
    pairs_.clear();
    for (std::size_t node = 0; node < points; ++node) {
      pairs_.insert(pairs_.end(), {int(part[node]), int(parts_[part[node]].size())});
      parts_[part[node]].push_back(mesh_.position[node]);
    }
  }

 private:
  template <class Cells, class Put>
  void putCells(const Cells& cells, const std::vector<int>& listed, const char* name, std::size_t i, const Put& put) const {
    for (const int cell : listed) {
      if (cell < 0 || std::size_t(cell) >= cells.size())
        throw ComponentError(fmt::format("{}{} names {}, and there are {}", name, i + 1, cell, cells.size()));
      for (const Index node : cells[std::size_t(cell)]) put(node, i);
    }
  }
  int count_ = 0;
  Mesh mesh_;
  std::array<std::vector<int>, most - 1> nodes_;
  std::array<std::array<std::vector<int>, 5>, most - 1> cells_;
  std::array<std::vector<Vec3>, most> parts_;
  std::vector<int> pairs_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(splitting_engines) {
  factory.add<stroma::JoinPoints>("JoinPoints", "points of which near ones are one");
  factory.add<stroma::ProjectiveTransformEngine>("ProjectiveTransformEngine", "pictures of points in a pinhole camera");
  factory.add<stroma::MeshSplittingEngine>("MeshSplittingEngine", "the points of a mesh shared out by lists");
}
