// SPDX-License-Identifier: LGPL-2.1-or-later
// Positions and meshes made of others, before the first step. What they make is linked to: position="@engine.output_position".
//
// TransformEngine: output_position = input_position scaled, then turned (rotation in degrees about x, then y, then z, or
//   quaternion x y z w), then moved; inverse="true" does the opposite in the opposite order.
// PointsFromIndices: indices_position, the positions of `indices`, each place once, in their order.
// MergeMeshes: the nbMeshes meshes position1, edges1, triangles1, ..., position2, ... one after another, with the numbers of
//   their nodes shifted (at most eight).
// MeshBoundaryROI: indices of the nodes on edges that belong to a single triangle or quad, ascending. With inputROI only the cells
//   whose nodes are all among it count.
//
// Source: names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerExplicitSolver/>
//   <MeshTopology name="one" position="0 0 0  1 0 0  1 1 0  0 1 0" triangles="0 1 2  0 2 3"/>
//   <TransformEngine name="moved" input_position="@one.position" translation="0 0 1" rotation="0 0 90" scale="2 2 2"/>
//   <MergeMeshes name="both" nbMeshes="2" position1="@one.position" triangles1="@one.triangles"
//     position2="@moved.output_position" triangles2="@one.triangles"/>
//   <MeshBoundaryROI name="border" triangles="@both.triangles"/>
//   <PointsFromIndices name="corners" position="@both.position" indices="0 2"/>
//   <Node name="body">
//     <MechanicalObject position="@../both.position"/>
//     <UniformMass totalMass="1"/>
//     <FixedProjectiveConstraint indices="@../border.indices"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <numbers>
#include <set>

#include "components/selection/engine.h"
#include "framework/mesh/cell_lists.h"
#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class TransformEngine final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("input_position", input_).help("positions to move").unit("m");
    table.add("output_position", output_).help("the moved ones").unit("m").output();
    table.add("scale", scale_).help("along the axes, first").unit("-");
    table.add("rotation", rotation_).help("about x, then y, then z").unit("degree");
    table.add("quaternion", quaternion_).help("x y z w, instead of rotation").unit("-");
    table.add("translation", translation_).help("last").unit("m");
    table.add("inverse", inverse_).help("the opposite movement");
  }
  void init() override {
    Mat3 turn = rotationFromDegrees(rotation_);
    if (!quaternion_.empty()) {
      if (quaternion_.size() != 4) throw ComponentError(fmt::format("quaternion has {} numbers", quaternion_.size()), "x y z w");
      turn = turn * Eigen::Quaterniond(quaternion_[3], quaternion_[0], quaternion_[1], quaternion_[2]).normalized().toRotationMatrix();
    }
    if (inverse_ && (scale_.array() == 0).any()) throw ComponentError("a scale of zero has no inverse", "other numbers");
    output_ = input_;
    for (Vec3& p : output_)
      p = inverse_ ? Vec3((turn.transpose() * (p - translation_)).cwiseQuotient(scale_))
                   : Vec3(turn * p.cwiseProduct(scale_) + translation_);
  }

 private:
  std::vector<Vec3> input_, output_;
  Vec3 scale_ = Vec3::Ones(), rotation_ = Vec3::Zero(), translation_ = Vec3::Zero();
  std::vector<double> quaternion_;
  bool inverse_ = false;
};

class PointsFromIndices final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("position", position_).alias("points").help("positions to choose from").unit("m");
    table.add("indices", indices_).help("which");
    table.add("indices_position", chosen_).help("the chosen ones").unit("m").output();
  }
  void init() override {
    if (indices_.empty()) warn("indices names no point", "check that the selection linked here contains nodes");
    chosen_.clear();
    std::set<std::array<double, 3>> taken;
    for (const int index : indices_) {
      if (index < 0 || std::size_t(index) >= position_.size())
        throw ComponentError(fmt::format("indices names {}, and there are {} positions", index, position_.size()));
      const Vec3& p = position_[std::size_t(index)];
      if (taken.insert({p.x(), p.y(), p.z()}).second) chosen_.push_back(p);
    }
  }

 private:
  std::vector<Vec3> position_, chosen_;
  std::vector<int> indices_;
};

class MergeMeshes final : public Engine {
 public:
  std::string roleText() const override { return "mesh engine"; }
  static constexpr std::size_t most = 8;
  void declare(DataTable& table) override {
    table.add("nbMeshes", count_).help("how many meshes").min(1).max(int(most));
    for (std::size_t i = 0; i < most; ++i) {
      table.add(fmt::format("position{}", i + 1), in_[i].position).help(fmt::format("nodes of mesh {}", i + 1)).unit("m");
      forEachCellList(
          [&](const CellKind& kind, auto& cells) {
            table.add(fmt::format("{}{}", kind.plural, i + 1), cells).help(fmt::format("{} of mesh {}", kind.plural, i + 1));
          },
          in_[i]);
    }
    table.add("position", out_.position).help("all nodes").unit("m").output();
    table.add("npoints", points_).help("how many they are").output();
    forEachCellList(
        [&](const CellKind& kind, auto& cells) {
          table.add(std::string(kind.plural), cells).help(fmt::format("all {}", kind.plural)).output();
        },
        out_);
  }
  void init() override {
    out_ = Mesh();
    for (std::size_t i = 0; i < std::size_t(count_); ++i) {
      const auto shift = Index(out_.position.size());
      out_.position.insert(out_.position.end(), in_[i].position.begin(), in_[i].position.end());
      forEachCellList(
          [shift](const CellKind&, auto& all, const auto& cells) {
            for (auto cell : cells) {
              for (Index& node : cell) node += shift;
              all.push_back(cell);
            }
          },
          out_, in_[i]);
    }
    points_ = int(out_.position.size());
  }

 private:
  int count_ = 2, points_ = 0;
  std::array<Mesh, most> in_;
  Mesh out_;
};

class MeshBoundaryROI final : public Engine {
 public:
  std::string roleText() const override { return "selection"; }
  void declare(DataTable& table) override {
    table.add("triangles", triangles_).help("of the surface");
    table.add("quads", quads_).help("of the surface");
    table.add("inputROI", part_).help("nodes of the part that counts; all when empty");
    table.add("indices", indices_).help("nodes on its border").output();
    table.addVisualOnly("subset");
  }
  void init() override {
    std::map<Edge, int> uses;
    const std::set<Index> part(part_.begin(), part_.end());
    const auto counts = [&part](Index node) { return part.empty() || part.count(node) > 0; };
    const auto count = [&uses, &counts](const auto& cells) {
      for (const auto& cell : cells)
        for (std::size_t i = 0; i < cell.size() && std::all_of(cell.begin(), cell.end(), counts); ++i) {
          const Index a = cell[i], b = cell[(i + 1) % cell.size()];
          ++uses[{std::min(a, b), std::max(a, b)}];
        }
    };
    count(triangles_), count(quads_);
    indices_.clear();
    for (const auto& [edge, number] : uses)
      if (number == 1) indices_.insert(indices_.end(), {edge[0], edge[1]});
    std::sort(indices_.begin(), indices_.end());
    indices_.erase(std::unique(indices_.begin(), indices_.end()), indices_.end());
    if (indices_.empty()) warn("the surface has no border: it is closed, or has no cells");
  }

 private:
  std::vector<Triangle> triangles_;
  std::vector<Quad> quads_;
  std::vector<int> part_, indices_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(point_engines) {
  factory.add<stroma::TransformEngine>("TransformEngine", "positions that are scaled, turned and moved");
  factory.add<stroma::PointsFromIndices>("PointsFromIndices", "the positions of listed nodes");
  factory.add<stroma::MergeMeshes>("MergeMeshes", "several meshes as one");
  factory.add<stroma::MeshBoundaryROI>("MeshBoundaryROI", "selects the nodes on the border of a surface");
}
