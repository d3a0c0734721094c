// SPDX-License-Identifier: LGPL-2.1-or-later
// Points that are moved, smoothed or paired, and the mass of a surface, before the first step.
//
// TransformPosition: output_position, input_position by `method`: translation; scale (about origin); rotation (degrees about x,
//   then y, then z); scaleTranslation; scaleRotationTranslation; projectOnPlane (origin, normal); affine (matrix, 16 numbers by rows);
//   random (up to maxRandomDisplacement along each axis, other ways for another seedValue).
//   Nodes in fixedIndices stay.
// SmoothMeshEngine: output_position, each of input_position replaced nb_iterations times by the mean of its neighbours on the
//   edges of the mesh; those in input_indices alone when they are given.
// NearestPointROI: for each node of object2 (of inputIndices2) the nearest one of object1 (of inputIndices1), where it is nearer
//   than radius: indices1 and indices2, pair by pair, and their distances.
// GenerateRigidMass: mass, volume, centre and inertia of what lies in a closed surface of triangles and quads, of a density:
//   rigidMass is mass, volume and the nine numbers of inertia / mass about the centre, as UniformMass of frames takes it.
//   By the divergence theorem with the tetrahedra of a point and each triangle: exact for the polyhedron.
//
// Source: names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="20" tolerance="1e-9"/>
//   <MeshTopology name="net" position="0 0 0  1 0 0  2 1 0" edges="0 1  1 2"/>
//   <TransformPosition name="moved" input_position="@net.position" method="translation" translation="0 0 1"/>
//   <SmoothMeshEngine name="smooth" topology="@net" input_position="@moved.output_position" input_indices="1"/>
//   <Node name="a">
//     <MechanicalObject name="one" position="@../smooth.output_position"/>
//     <UniformMass totalMass="1"/>
//   </Node>
//   <Node name="b">
//     <MechanicalObject name="other" position="0 0 1.1  9 9 9"/>
//     <UniformMass totalMass="1"/>
//   </Node>
//   <NearestPointROI name="pairs" object1="@a/one" object2="@b/other" radius="0.5"/>
//   <SpringForceField object1="@a/one" object2="@b/other" springsIndices1="@pairs.indices1" springsIndices2="@pairs.indices2"
//     stiffness="10" lengths="0.1"/>
//   <Node name="body">
//     <MeshTopology name="box" position="0 0 0  1 0 0  0 1 0  0 0 1" triangles="0 2 1  0 1 3  1 2 3  2 0 3"/>
//     <GenerateRigidMass name="mass" position="@box.position" triangles="@box.triangles" density="1000"/>
//     <MechanicalObject template="Rigid3" position="0 0 0 0 0 0 1"/>
//     <UniformMass vertexMass="@mass.rigidMass"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "components/selection/engine.h"
#include "components/selection/random_numbers.h"
#include "framework/mechanics/state.h"
#include "framework/mesh/mesh_loader.h"
#include "framework/mesh/topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class TransformPosition final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("input_position", input_).alias("inputPosition").help("points to move").unit("m");
    table.add("output_position", output_).alias("outputPosition").help("the moved ones").unit("m").output();
    table
        .addChoice("method", method_,
                   {"projectOnPlane", "translation", "rotation", "random", "scale", "scaleTranslation", "scaleRotationTranslation",
                    "affine", "fromFile"})
        .help("what is done; fromFile is refused");
    table.add("origin", origin_).help("a point of the plane, or the centre of the scale").unit("m");
    table.add("normal", normal_).help("of the plane").unit("-");
    table.add("translation", translation_).help("the way").unit("m");
    table.add("rotation", rotation_).help("about x, then y, then z").unit("degree");
    table.add("scale", scale_).help("factors along the axes").unit("-");
    table.add("matrix", matrix_).help("an affine matrix, by rows").unit("-");
    table.add("fixedIndices", fixed_).help("points that stay");
    table.add("maxRandomDisplacement", most_).help("of method random, along each axis").unit("m").min(0);
    table.add("seedValue", seed_).help("other numbers, other random ways");
    for (const char* name : {"drawInput", "drawOutput", "pointSize", "filename"}) table.addVisualOnly(name);
  }
  void init() override {
    if (method_ == Method::file)
      throw ComponentError("a matrix is not read from a file", "another method", "method=\"affine\" and matrix");
    if (method_ == Method::plane && !(normal_.norm() > 0)) throw ComponentError("normal is zero", "a vector that is not");
    const Mat3 turn = rotationFromDegrees(rotation_);
    Eigen::Matrix4d affine;
    for (int i = 0; i < 16; ++i) affine(i / 4, i % 4) = matrix_[std::size_t(i)];
    output_ = input_;
    RandomNumbers random(seed_);
    for (Vec3& p : output_) {
      if (method_ != Method::random) p = moved(p, turn, affine);
      for (int a = 0; method_ == Method::random && a < 3; ++a) p[a] += random.between(-most_, most_);
    }
    for (const int index : fixed_) {
      if (index < 0 || std::size_t(index) >= input_.size())
        throw ComponentError(fmt::format("fixedIndices names point {} of {}", index, input_.size()),
                             fmt::format("indices in 0 ... {}", long(input_.size()) - 1));
      output_[std::size_t(index)] = input_[std::size_t(index)];
    }
  }

 private:
  Vec3 moved(const Vec3& p, const Mat3& turn, const Eigen::Matrix4d& affine) const {
    const Vec3 n = normal_.norm() > 0 ? normal_.normalized() : Vec3::Zero();
    switch (method_) {
      case Method::plane:
        return p + n * (origin_ - p).dot(n);
      case Method::translation:
        return p + translation_;
      case Method::rotation:
        return turn * p;
      case Method::scale:
        return origin_ + (p - origin_).cwiseProduct(scale_);
      case Method::scale_translation:
        return p.cwiseProduct(scale_) + translation_;
      case Method::scale_rotation_translation:
        return turn * p.cwiseProduct(scale_) + translation_;
      case Method::random:
      case Method::file:
      case Method::affine:
        break;
    }
    const Eigen::Vector4d q = affine * p.homogeneous();
    constexpr double vanishing = 1e-10;  // of its terms
    const double terms = affine.row(3).cwiseAbs() * p.homogeneous().cwiseAbs();
    if (!(std::abs(q[3]) > vanishing * terms)) throw ComponentError("the matrix sends a point to infinity", "a last row 0 0 0 1");
    return q.hnormalized();
  }
  enum class Method : int {
    plane,
    translation,
    rotation,
    random,
    scale,
    scale_translation,
    scale_rotation_translation,
    affine,
    file
  };
  Method method_ = Method::plane;
  std::vector<Vec3> input_, output_;
  Vec3 origin_ = Vec3::Zero(), normal_ = Vec3::Zero(), translation_ = Vec3::Zero(), rotation_ = Vec3::Zero(), scale_ = Vec3::Ones();
  double most_ = 1;
  int seed_ = 0;
  std::array<double, 16> matrix_{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  std::vector<int> fixed_;
};

class SmoothMeshEngine final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.addLink("topology", topology_).help("mesh whose edges say what is beside what; that of this node or above by default");
    table.add("input_position", input_).help("points to smooth").unit("m");
    table.add("output_position", output_).help("the smoothed ones").unit("m").output();
    table.add("input_indices", indices_).help("which of them; all when empty");
    table.add("nb_iterations", times_).help("how often").min(0);
    for (const char* name : {"showInput", "showOutput"}) table.addVisualOnly(name);
  }
  void init() override {
    const Topology* topology = topology_.get() ? topology_.get() : find<Topology>(true);
    if (!topology) throw ComponentError("there is no mesh that says what is beside what", "a topology in this node or above");
    const Adjacency& around = topology->mesh().nodesAroundNode();
    std::vector<Index> chosen(indices_.begin(), indices_.end());
    if (chosen.empty()) {
      chosen.resize(input_.size());
      std::iota(chosen.begin(), chosen.end(), 0);
    }
    if (Index(input_.size()) > around.size())
      throw ComponentError(fmt::format("there are {} points, and {} has {} nodes", input_.size(), topology->path(), around.size()));
    output_ = input_;
    for (int time = 0; time < times_; ++time) {
      const std::vector<Vec3> before = output_;
      for (const Index i : chosen) {
        if (i < 0 || std::size_t(i) >= input_.size()) throw ComponentError(fmt::format("input_indices names {} of {}", i, input_.size()));
        Vec3 sum = Vec3::Zero();
        for (Index k = around.start[i]; k < around.start[i + 1]; ++k) sum += before[around.values[k]];
        if (const Index count = around.start[i + 1] - around.start[i]; count > 0) output_[i] = sum / count;
      }
    }
  }

 private:
  Link<Topology> topology_{"topology"};
  std::vector<Vec3> input_, output_;
  std::vector<int> indices_;
  int times_ = 1;
};

class NearestPointROI final : public Engine {
 public:
  std::string roleText() const override { return "selection"; }
  void declare(DataTable& table) override {
    table.addLink("object1", one_).help("the state whose nodes are looked for");
    table.addLink("object2", other_).help("the state whose nodes look");
    table.add("inputIndices1", indices_one_).help("nodes of object1; all when empty");
    table.add("inputIndices2", indices_other_).help("nodes of object2; all when empty");
    table.add("radius", radius_).help("how near").unit("m").min(0);
    table.add("useRestPosition", rest_).help("distances at rest, not at the start");
    table.add("indices1", found_one_).help("nodes of object1, one for each pair").output();
    table.add("indices2", found_other_).help("nodes of object2, one for each pair").output();
    table.add("distances", distances_).help("of the pairs").unit("m").output();
    table.add("edges", edges_).help("of DistanceMultiMapping: 2 i and 2 i + 1, i the node of object2").output();
    table.add("indexPairs", index_pairs_)
        .help("of it and SubsetMultiMapping: 0 and the node of object1, 1 and that of object2, for each pair")
        .output();
    table.addVisualOnly("drawPairs");
  }
  void init() override {
    if (!one_.get() || !other_.get()) throw ComponentError("two states are needed", "object1=\"@...\" and object2=\"@...\"");
    const std::vector<Vec3>&a = rest_ ? one_.get()->rest_position : one_.get()->position,
          &b = rest_ ? other_.get()->rest_position : other_.get()->position;
    const std::vector<int> these = nodes(indices_one_, a.size(), "inputIndices1"),
                           those = nodes(indices_other_, b.size(), "inputIndices2");
    found_one_.clear();
    found_other_.clear();
    distances_.clear();
    edges_.clear();
    index_pairs_.clear();
    std::vector<std::size_t> along(these.size());  // places in `these`, by x
    std::iota(along.begin(), along.end(), std::size_t(0));
    const auto at = [&](std::size_t k) -> const Vec3& { return a[std::size_t(these[k])]; };
    std::stable_sort(along.begin(), along.end(), [&](std::size_t i, std::size_t k) { return at(i).x() < at(k).x(); });
    for (const int j : those) {
      const Vec3& p = b[std::size_t(j)];
      const auto middle =
          std::lower_bound(along.begin(), along.end(), p.x(), [&](std::size_t k, double x) { return at(k).x() < x; });
      std::size_t nearest = these.size();
      double least = radius_;
      const auto look = [&](std::size_t k) {  // of equally near ones the first in the list
        const double d = (at(k) - p).norm();
        if (d < least || (d == least && nearest < these.size() && k < nearest)) {
          least = d;
          nearest = k;
        }
      };
      for (auto next = middle; next != along.end() && at(*next).x() - p.x() <= least; ++next) look(*next);
      for (auto next = middle; next != along.begin() && p.x() - at(*(next - 1)).x() <= least; --next) look(*(next - 1));
      if (nearest == these.size()) continue;
      found_one_.push_back(these[nearest]);
      found_other_.push_back(j);
      distances_.push_back(least);
      edges_.push_back({2 * j, 2 * j + 1});
      index_pairs_.insert(index_pairs_.end(), {0, these[nearest], 1, j});
    }
    if (found_one_.empty()) warn("no node is that near to another", "a larger radius");
  }

 private:
  static std::vector<int> nodes(const std::vector<int>& given, std::size_t count, const char* name) {
    for (const int node : given)
      if (node < 0 || std::size_t(node) >= count) throw ComponentError(fmt::format("{} names node {} of {}", name, node, count));
    if (!given.empty()) return given;
    std::vector<int> all(count);
    std::iota(all.begin(), all.end(), 0);
    return all;
  }
  Link<State> one_{"mechanical state"}, other_{"mechanical state"};
  std::vector<int> indices_one_, indices_other_, found_one_, found_other_;
  std::vector<double> distances_;
  std::vector<Edge> edges_;
  std::vector<int> index_pairs_;
  double radius_ = 1;
  bool rest_ = true;
};

class GenerateRigidMass final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("density", density_).help("of the body").unit("kg/m^3").min(0, false).physical();
    table.add("position", position_).help("nodes of the surface").unit("m");
    table.add("triangles", triangles_).help("its triangles, outward");
    table.add("quads", quads_).help("its quads, outward");
    table.add("rigidMass", rigid_mass_).help("mass, volume and inertia / mass").output();
    table.add("mass", mass_).help("mass").unit("kg").output();
    table.add("volume", volume_).help("volume").unit("m^3").output();
    table.add("inertiaMatrix", inertia_).help("inertia about the centre, by rows").unit("kg m^2").output();
    table.add("massCenter", centre_).help("centre of the mass").unit("m").output();
    table.add("centerToOrigin", to_origin_).help("from there to the origin").unit("m").output();
    table.addVisualOnly("polygons");
  }
  void init() override {
    std::vector<Triangle> faces = triangles_;
    for (const Quad& q : quads_) {
      faces.push_back({q[0], q[1], q[2]});
      faces.push_back({q[0], q[2], q[3]});
    }
    if (faces.empty()) throw ComponentError("the surface has no cells", "position and triangles, as by src=\"@loader\"");
    volume_ = 0;
    Vec3 first = Vec3::Zero();
    Mat3 second = Mat3::Zero();  // integral of x x^T
    for (const Triangle& t : faces) {
      for (const Index node : t)
        if (node < 0 || std::size_t(node) >= position_.size())
          throw ComponentError(fmt::format("a cell names node {} of {}", node, position_.size()));
      const Vec3 &a = position_[t[0]], &b = position_[t[1]], &c = position_[t[2]], sum = a + b + c;
      const double v = a.dot(b.cross(c)) / 6;
      volume_ += v;
      first += v / 4 * sum;
      second += v / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
    }
    if (!(volume_ > 0)) throw ComponentError(fmt::format("the surface encloses {:.3g} m^3", volume_), "a closed one with normals outward");
    centre_ = first / volume_;
    to_origin_ = -centre_;
    mass_ = density_ * volume_;
    second = density_ * (second - volume_ * centre_ * centre_.transpose());
    const Mat3 inertia = second.trace() * Mat3::Identity() - second;
    rigid_mass_ = {mass_, volume_};
    for (int i = 0; i < 9; ++i) {
      inertia_[std::size_t(i)] = inertia(i / 3, i % 3);
      rigid_mass_.push_back(inertia(i / 3, i % 3) / mass_);
    }
  }

 private:
  double density_ = 1000, mass_ = 0, volume_ = 0;
  std::vector<Vec3> position_;
  std::vector<Triangle> triangles_;
  std::vector<Quad> quads_;
  std::vector<double> rigid_mass_, inertia_ = std::vector<double>(9, 0.0);
  Vec3 centre_ = Vec3::Zero(), to_origin_ = Vec3::Zero();
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(transform_engines) {
  factory.add<stroma::TransformPosition>("TransformPosition", "points that are moved by a chosen method");
  factory.add<stroma::SmoothMeshEngine>("SmoothMeshEngine", "points that go to the mean of their neighbours");
  factory.add<stroma::NearestPointROI>("NearestPointROI", "pairs of near nodes of two states");
  factory.add<stroma::GenerateRigidMass>("GenerateRigidMass", "mass and inertia of what a surface encloses");
}
