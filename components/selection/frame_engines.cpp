// SPDX-License-Identifier: LGPL-2.1-or-later
// Frames and their parts, and single numbers of lists, before the first step.
//
// QuatToRigidEngine: rigids, frames of `positions` and `orientations` (x y z w), one after another, as many as both lists have; a single
//   orientation counts for all. A frame with a colinearPositions c lies at c + z (z . (p - c)), z its third axis and p its position.
// RigidToQuatEngine: positions and orientations of `rigids`, and orientationsEuler, their angles about x, then y, then z [rad].
// SumEngine: output, the sum of all values of `input`, as `template` says what a value is.
// NormEngine: output, the length of each value of `input`: of normType 0 the largest number, 1 the sum of all, 2 Euclid's.
// AverageCoord: average, the mean of the positions `indices` of `vertices`; of all without indices.
// DilateEngine: output_position, the surface moved by `distance` along the normals of its nodes. A node's normal is the sum of n at each
//   corner there, n = (next - here) x (previous - here). Where the surface behind a node is nearer than minThickness, it is moved by
//   half of what is missing more.
// NormalsFromPoints: normals, the sums of n/|n|, or with useAngles of n/|n| times the corner's angle; invertNormals: the opposite ones.
// ROIValueMapper: outputValues, value1 at indices1, value2 at indices2, ... (nbROIs of them, at most eight), else defaultValue; the list
//   ends with the largest index. Where two regions share an index the later one counts.
//
// Source: names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerExplicitSolver/>
//   <MeshTopology name="plate" position="0 0 0  1 0 0  1 1 0  0 1 0" triangles="0 1 2  0 2 3"/>
//   <DilateEngine name="lifted" input_position="@plate.position" triangles="@plate.triangles" distance="0.5"/>
//   <QuatToRigidEngine name="frames" positions="@lifted.output_position" orientations="0 0 0 1"/>
//   <RigidToQuatEngine name="parts" rigids="@frames.rigids"/>
//   <AverageCoord name="middle" vertices="@parts.positions"/>
//   <SumEngine name="sum" template="Vec3" input="@parts.positions"/>
//   <NormEngine name="far" template="Vec3" input="@parts.positions"/>
//   <NormalsFromPoints name="up" position="@plate.position" triangles="@plate.triangles"/>
//   <ROIValueMapper name="stiff" nbROIs="2" indices1="0 2" value1="5" indices2="3" value2="7" defaultValue="1"/>
//   <MechanicalObject template="Rigid3" position="@frames.rigids"/>
//   <UniformMass totalMass="1"/>
//   <Node name="points">
//     <MechanicalObject position="@../middle.average"/>
//     <UniformMass totalMass="1"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "components/selection/engine.h"
#include "framework/mesh/cell_attributes.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class QuatToRigidEngine final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("positions", positions_).alias("position").help("centres").unit("m");
    table.add("orientations", orientations_).alias("orientation").help("x y z w of each, or of all").unit("-").inValuesOf(4);
    table.add("colinearPositions", lines_)
        .alias("colinearPosition")
        .help("points of lines along z of the first frames, on which they lie")
        .unit("m");
    table.add("rigids", frames_).alias("rigid").help("x y z and x y z w of each frame").unit("-").output().inValuesOf(7);
  }
  void init() override {
    if (positions_.empty() || orientations_.empty() || orientations_.size() % 4 != 0)
      throw ComponentError(fmt::format("there are {} positions and {} numbers of orientations", positions_.size(), orientations_.size()),
                           "at least one position, and four numbers for each orientation");
    const std::size_t turns = orientations_.size() / 4;
    if (turns > 1 && turns != positions_.size())
      warn(fmt::format("there are {} positions and {} orientations: the frames are as many as both", positions_.size(), turns),
           "as many, or a single orientation");
    frames_.clear();
    for (std::size_t i = 0; i < (turns == 1 ? positions_.size() : std::min(positions_.size(), turns)); ++i) {
      const auto turn = orientations_.begin() + std::ptrdiff_t(4 * (i % turns));
      Vec3 p = positions_[i];
      if (i < lines_.size()) {
        const Vec3 z = Eigen::Quaterniond(turn[3], turn[0], turn[1], turn[2]) * Vec3::UnitZ();
        p = lines_[i] + z * (z.dot(p - lines_[i]) / z.norm());
      }
      frames_.insert(frames_.end(), {p.x(), p.y(), p.z()});
      frames_.insert(frames_.end(), turn, turn + 4);
    }
  }

 private:
  std::vector<Vec3> positions_, lines_;
  std::vector<double> orientations_, frames_;
};

class RigidToQuatEngine final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("rigids", frames_).alias("rigid").help("x y z and x y z w of each frame").unit("-").inValuesOf(7);
    table.add("positions", positions_).alias("position").help("their centres").unit("m").output();
    table.add("orientations", orientations_).alias("orientation").help("x y z w of each").unit("-").output().inValuesOf(4);
    table.add("orientationsEuler", angles_).help("angles about x, then y, then z").unit("rad").output();
  }
  void init() override {
    if (frames_.size() % 7 != 0) throw ComponentError(fmt::format("rigids has {} numbers", frames_.size()), "seven for each frame");
    positions_.clear();
    orientations_.clear();
    angles_.clear();
    for (std::size_t i = 0; i < frames_.size(); i += 7) {
      const double* v = frames_.data() + i;
      positions_.emplace_back(v[0], v[1], v[2]);
      orientations_.insert(orientations_.end(), v + 3, v + 7);
      const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
      if (!(q.norm() > 0)) throw ComponentError(fmt::format("frame {} has no orientation", i / 7), "x y z w, not all of them zero");
      const Mat3 r = q.normalized().toRotationMatrix();  // R_z R_y R_x
      angles_.emplace_back(std::atan2(r(2, 1), r(2, 2)), std::asin(std::clamp(-r(2, 0), -1., 1.)), std::atan2(r(1, 0), r(0, 0)));
    }
  }

 private:
  std::vector<double> frames_, orientations_;
  std::vector<Vec3> positions_, angles_;
};

class SumEngine final : public TypedEngine {
 public:
  SumEngine() : TypedEngine(3) {}
  void declare(DataTable& table) override {
    TypedEngine::declare(table);
    addList(table, "input", in_).help("values");
    addList(table, "output", out_).help("their sum").output();
  }
  void init() override {
    checkWhole(in_, "input");
    out_.clear();
    withNumbers(
        [this](const auto& in, auto& out) {
          out.assign(width_, 0);
          for (std::size_t i = 0; i < in.size(); ++i) out[i % width_] += in[i];
        },
        in_, out_);
  }

 private:
  ValueList in_, out_;
};

class NormEngine final : public TypedEngine {
 public:
  NormEngine() : TypedEngine(3) {}
  void declare(DataTable& table) override {
    TypedEngine::declare(table);
    addList(table, "input", in_).help("values");
    table.add("normType", kind_).help("0: the largest number, 1: the sum of all, 2: Euclid's length").min(0).max(2);
    table.add("output", out_).help("the length of each").output();
  }
  void init() override {
    checkWhole(in_, "input");
    out_.assign(count(in_), 0);
    withNumbers(
        [this](const auto& in) {
          for (std::size_t i = 0; i < in.size(); ++i) {
            const double size = std::abs(double(in[i]));
            double& norm = out_[i / width_];
            norm = kind_ == 0 ? std::max(norm, size) : norm + (kind_ == 1 ? size : size * size);
          }
        },
        in_);
    if (kind_ == 2)
      for (double& norm : out_) norm = std::sqrt(norm);
  }

 private:
  ValueList in_;
  int kind_ = 2;
  std::vector<double> out_;
};

class AverageCoord final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("vertices", positions_).alias("position").help("positions").unit("m");
    table.add("indices", indices_).help("which; all by default");
    table.add("average", mean_).help("their mean").unit("m").output();
  }
  void init() override {
    if (positions_.empty()) throw ComponentError("there are no positions", "vertices=\"@mesh.position\"");
    std::vector<int> indices = indices_;
    for (std::size_t i = 0; indices_.empty() && i < positions_.size(); ++i) indices.push_back(int(i));
    Vec3 sum = Vec3::Zero();
    for (const int index : indices) {
      if (index < 0 || std::size_t(index) >= positions_.size())
        throw ComponentError(fmt::format("indices names {}, and there are {} positions", index, positions_.size()));
      sum += positions_[std::size_t(index)];
    }
    mean_.assign(1, sum / double(indices.size()));
  }

 private:
  std::vector<Vec3> positions_, mean_;
  std::vector<int> indices_;
};

class SurfaceEngine : public Engine {
 protected:
  void declareSurface(DataTable& table, const char* position, const char* other) {
    table.add(position, in_).alias(other).help("nodes of a surface").unit("m");
    addCellList(table, cell_kinds::triangle, triangles_).help("its triangles");
    addCellList(table, cell_kinds::quad, quads_).help("its quads");
    table.add("normals", normals_).alias("normal").help("normals of the nodes").unit("-").output();
  }
  enum class Weight { area, one, angle };
  void makeNormals(Weight weight) {
    if (triangles_.empty() && quads_.empty())
      throw ComponentError("there is no surface", "triangles or quads", "triangles=\"@mesh.triangles\"");
    normals_.assign(in_.size(), Vec3::Zero());
    const auto add = [this, weight](const auto& cells) {
      for (const auto& cell : cells) {
        for (const Index node : cell)
          if (node < 0 || std::size_t(node) >= in_.size())
            throw ComponentError(fmt::format("a cell names node {}, and there are {}", node, in_.size()));
        const std::size_t n = cell.size();
        for (std::size_t i = 0; i < n; ++i) {
          const Vec3& here = in_[std::size_t(cell[i])];
          const Vec3 next = in_[std::size_t(cell[(i + 1) % n])] - here, previous = in_[std::size_t(cell[(i + n - 1) % n])] - here;
          const Vec3 normal = next.cross(previous);
          const double size = normal.norm(), angle = std::atan2(size, next.dot(previous));
          const double factor = weight == Weight::area ? 1 : (weight == Weight::one ? 1 : angle) / size;
          if (size > 0) normals_[std::size_t(cell[i])] += factor * normal;
        }
      }
    };
    add(triangles_), add(quads_);
    std::size_t without = 0;
    for (Vec3& normal : normals_) {
      const double size = normal.norm();
      size > 0 ? void(normal /= size) : void(++without);
    }
    if (without > 0) warn(fmt::format("{} of {} nodes lie on no cell with an area, and have no normal", without, in_.size()));
  }
  /// From a node against its normal to the first triangle that it is no corner of [m]; 0: there is none.
  double thicknessAt(std::size_t node) const {
    double least = 0;
    const auto look = [&](Index a, Index b, Index c) {
      if (std::size_t(a) == node || std::size_t(b) == node || std::size_t(c) == node) return;
      const Vec3 &p = in_[std::size_t(a)], e = in_[std::size_t(b)] - p, f = in_[std::size_t(c)] - p, from = in_[node] - p;
      const Vec3 h = normals_[node].cross(f), q = from.cross(e);
      const double volume = -e.dot(h);
      if (volume == 0) return;
      const double u = -from.dot(h) / volume, v = -normals_[node].dot(q) / volume, way = f.dot(q) / volume;
      if (u >= 0 && v >= 0 && u + v <= 1 && way > 0 && (least == 0 || way < least)) least = way;
    };
    for (const Triangle& t : triangles_) look(t[0], t[1], t[2]);
    for (const Quad& q : quads_) {
      look(q[0], q[1], q[2]);
      look(q[0], q[2], q[3]);
    }
    return least;
  }
  std::vector<Vec3> in_, normals_;

 private:
  std::vector<Triangle> triangles_;
  std::vector<Quad> quads_;
};

class DilateEngine final : public SurfaceEngine {
 public:
  void declare(DataTable& table) override {
    declareSurface(table, "input_position", "position");
    table.add("distance", distance_).help("way along the normals").unit("m");
    table.add("minThickness", least_).help("what is thinner is moved further").unit("m").min(0);
    table.add("thickness", thickness_).help("behind each node, with minThickness").unit("m").output();
    table.add("output_position", out_).help("the moved nodes").unit("m").output();
  }
  void init() override {
    makeNormals(Weight::area);
    out_ = in_;
    thickness_.clear();
    for (std::size_t i = 0; i < in_.size(); ++i) {
      if (least_ > 0) thickness_.push_back(thicknessAt(i));
      out_[i] += (distance_ + (least_ > 0 ? std::max(least_ - thickness_[i], 0.) / 2 : 0)) * normals_[i];
    }
  }

 private:
  std::vector<Vec3> out_;
  std::vector<double> thickness_;
  double distance_ = 0, least_ = 0;
};

class NormalsFromPoints final : public SurfaceEngine {
 public:
  void declare(DataTable& table) override {
    declareSurface(table, "position", "points");
    table.add("invertNormals", opposite_).help("the opposite normals");
    table.add("useAngles", by_angles_).help("corners count by their angles");
  }
  void init() override {
    makeNormals(by_angles_ ? Weight::angle : Weight::one);
    if (opposite_)
      for (Vec3& normal : normals_) normal = -normal;
  }

 private:
  bool opposite_ = false, by_angles_ = false;
};

class RoiValueMapper final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("nbROIs", count_).help("how many regions there are").min(0).max(double(most));
    for (std::size_t i = 0; i < most; ++i) {
      const std::string number = std::to_string(i + 1);
      table.add("indices" + number, indices_[i]).help("a region");
      table.add("value" + number, values_[i]).help("the value there");
    }
    table.add("defaultValue", otherwise_).help("the value elsewhere");
    table.add("outputValues", out_).help("the list").output();
  }
  void init() override {
    for (std::size_t i = std::size_t(count_); i < most; ++i)
      for (const char* name : {"indices", "value"})
        if (const std::string given = name + std::to_string(i + 1); data().find(given)->isSet())
          throw ComponentError(fmt::format("{} is given, and nbROIs is {}", given, count_), "a region for each number",
                               fmt::format("nbROIs=\"{}\"", i + 1));
    out_.clear();
    for (std::size_t i = 0; i < std::size_t(count_); ++i)
      for (const int index : indices_[i]) {
        constexpr int largest = 10'000'000;
        if (index < 0 || index > largest)
          throw ComponentError(fmt::format("indices{} names {}", i + 1, index), fmt::format("numbers from 0 to {}", largest));
        if (out_.size() <= std::size_t(index)) out_.resize(std::size_t(index) + 1, otherwise_);
        out_[std::size_t(index)] = values_[i];
      }
  }

 private:
  static constexpr std::size_t most = 8;
  int count_ = 0;
  std::array<std::vector<int>, most> indices_;
  std::array<double, most> values_{};
  double otherwise_ = 0;
  std::vector<double> out_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(frame_engines) {
  factory.add<stroma::QuatToRigidEngine>("QuatToRigidEngine", "frames of positions and orientations");
  factory.add<stroma::RigidToQuatEngine>("RigidToQuatEngine", "positions and orientations of frames");
  factory.add<stroma::SumEngine>("SumEngine", "the sum of a list of values");
  factory.add<stroma::NormEngine>("NormEngine", "the lengths of a list of values");
  factory.add<stroma::AverageCoord>("AverageCoord", "the mean of some positions");
  factory.add<stroma::DilateEngine>("DilateEngine", "a surface moved along its normals");
  factory.add<stroma::NormalsFromPoints>("NormalsFromPoints", "the normals of the nodes of a surface");
  factory.add<stroma::RoiValueMapper>("ROIValueMapper", "a list with the values of some regions");
}
