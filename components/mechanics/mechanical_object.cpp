// SPDX-License-Identifier: LGPL-2.1-or-later
// MechanicalObject: the nodes of a body, their positions x, velocities v and rest positions X.
//
// The positions come, in this order, from `position`, from `rest_position`, from the mesh of the same node
// (`useTopology`), are `size` nodes at the origin, or come from the mesh of the nearest node above, up to one with a
// state of its own, whose mesh that is. They are then scaled (`scale3d`), rotated (`rotation`, degrees,
// about x, then y, then z: R = Rz Ry Rx) and translated (`translation`):
//
//   x = R S x_given + t
//
// The rest positions, unless given, are restScale times these. `rotation2` and `translation2` move the initial
// positions only, so that the body starts rotated or translated against its rest shape. Attribute names and the order
// of these operations are those of SOFA.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject name="dofs" position="0 0 0  1 0 0" velocity="0 1 0  0 1 0" rotation="0 0 90"
//     translation="0 2 0"/>
//   <UniformMass totalMass="2"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <numbers>

#include "framework/mechanics/state.h"
#include "framework/mechanics/state_topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

Mat3 rotationXyz(const Vec3& degrees) {
  const Vec3 angle = degrees * (std::numbers::pi / 180);
  return (Eigen::AngleAxisd(angle.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(angle.y(), Vec3::UnitY()) *
          Eigen::AngleAxisd(angle.x(), Vec3::UnitX()))
      .toRotationMatrix();
}

class MechanicalObject final : public State {
 public:
  void declare(DataTable& table) override {
    declareVectors(table);
    declareTransforms(table);
    for (const char* drawing : {"showObject", "showObjectScale", "showIndices", "showIndicesScale", "showVectors",
                                "showVectorsScale", "showColor", "drawMode", "reserve"})
      table.addVisualOnly(drawing);
  }

  void init() override {
    if (template_ != "Vec3" && template_ != "Vec3d" && template_ != "Vec3f")
      throw ComponentError(fmt::format("nodes of type {} do not exist here", template_), "Vec3");
    readShorthands();
    findPositions();
    checkFinite(position, "position");
    transform();
    if (rest_position.empty()) {
      rest_position = position;
      for (Vec3& point : rest_position) point *= rest_scale_;
    } else if (data().find("restScale")->isSet()) {
      throw ComponentError("rest_position and restScale are both given", "one of them");
    }
    const Mat3 rotation = rotationXyz(rotation2_);
    if (!rotation2_.isZero(0))
      for (Vec3& point : position) point = rotation * point;
    for (Vec3& point : position) point += translation2_;
    if (velocity.empty()) velocity.assign(position.size(), Vec3::Zero());
    checkSizes();
    reset_position_ = position;
    size_ = size();
  }

 private:
  void declareVectors(DataTable& table) {
    table.add("template", template_).help("type of a node; only Vec3 (three coordinates)");
    table.add("position", position).help("initial positions; from the mesh of this node when not given").unit("m");
    table.add("velocity", velocity).help("initial velocities; zero when not given").unit("m/s");
    table.add("rest_position", rest_position)
        .help("positions without stress; the transformed positions when not given")
        .unit("m");
    table.add("reset_position", reset_position_).help("positions that a reset returns to").unit("m").output();
    table.add("size", size_).help("number of nodes, at the origin, when no positions are given").min(0);
    table.add("useTopology", use_topology_).help("take positions from the mesh of this node when none are given");
    table.addLink("topology", topology_).help("mesh that gives the positions; the one of this node when not given");
    table.add("restScale", rest_scale_)
        .help("scale of the rest positions only: the body starts stressed")
        .unit("-")
        .min(0, false);
  }

  void declareTransforms(DataTable& table) {
    table.add("translation", translation_).help("added to the positions, last").unit("m");
    table.add("rotation", rotation_)
        .help("rotation of the positions about the origin: about x, then y, then z")
        .unit("degree");
    table.add("scale3d", scale_).help("scale of the positions along the axes, first").unit("-");
    table.add("translation2", translation2_)
        .help("added to the initial positions, not to the rest positions")
        .unit("m");
    table.add("rotation2", rotation2_)
        .help("rotation of the initial positions, not of the rest positions")
        .unit("degree");
    table.add("scale", uniform_scale_).help("scale3d with three equal numbers").unit("-").shorthand();
    static constexpr const char* names[5][3] = {
        {"dx", "dy", "dz"}, {"rx", "ry", "rz"}, {"sx", "sy", "sz"}, {"dx2", "dy2", "dz2"}, {"rx2", "ry2", "rz2"}};
    static constexpr const char* wholes[5] = {"translation", "rotation", "scale3d", "translation2", "rotation2"};
    static constexpr const char* units[5] = {"m", "degree", "-", "m", "degree"};
    Vec3* const targets[5] = {&translation_, &rotation_, &scale_, &translation2_, &rotation2_};
    for (std::size_t i = 0; i < 5; ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        Shorthand& shorthand = shorthands_[3 * i + c];
        shorthand = {names[i][c], wholes[i], 0, &(*targets[i])[Eigen::Index(c)]};
        table.add(shorthand.name, shorthand.value).help(fmt::format("{}[{}]", wholes[i], c)).unit(units[i]).shorthand();
      }
  }

  void readShorthands() {
    const auto isSet = [this](const std::string& name) { return data().find(name)->isSet(); };
    const auto refuseBoth = [&](const std::string& name, const std::string& whole) {
      if (isSet(whole)) throw ComponentError(fmt::format("{} and {} are both given", name, whole), "one of them");
    };
    if (isSet("scale")) {
      refuseBoth("scale", "scale3d");
      scale_.setConstant(uniform_scale_);
    }
    for (const Shorthand& shorthand : shorthands_) {
      if (!isSet(shorthand.name)) continue;
      refuseBoth(shorthand.name, shorthand.whole);
      *shorthand.target = shorthand.value;
    }
    if ((scale_.array() == 0).any()) throw ComponentError("a scale of zero flattens the body", "numbers other than 0");
  }

  void findPositions() {
    if (!position.empty()) return;
    const Topology* mesh = topology_.get();
    if (!mesh && rest_position.empty() && use_topology_) mesh = firstTopology(*this, false);
    if (!mesh && rest_position.empty() && use_topology_ && size_ == 0) mesh = meshAbove();
    if (!rest_position.empty()) {
      position = rest_position;
    } else if (mesh) {
      position = mesh->mesh().position;
      if (position.empty())
        throw ComponentError("the mesh " + mesh->path() + " has no nodes",
                             "a mesh with nodes, or position=\"x y z ...\"");
    } else if (size_ > 0) {
      position.assign(size_, Vec3::Zero());
    } else {
      warn(
          "no positions: neither position, rest_position, size nor a mesh in this node or above; one node at the "
          "origin is made",
          "position=\"@loader.position\", or a topology in the same node");
      position.assign(1, Vec3::Zero());
    }
  }

  /// A mesh above that no other state has between it and this node, or beside it.
  const Topology* meshAbove() const {
    for (const Node* above = node().parent(); above; above = above->parent()) {
      const Topology* found = nullptr;
      for (const auto& component : above->components()) {
        if (dynamic_cast<const State*>(component.get())) return nullptr;
        auto* topology = dynamic_cast<Topology*>(component.get());
        if (!found && topology && topology->answersLookup()) found = topology;
      }
      if (!found) continue;
      const_cast<Topology*>(found)->ensureReady();
      return found;
    }
    return nullptr;
  }

  void transform() {
    const Mat3 rotation = rotationXyz(rotation_);
    const bool rotates = !rotation_.isZero(0);
    for (Vec3& point : position) {
      point = point.cwiseProduct(scale_);
      if (rotates) point = rotation * point;
      point += translation_;
    }
  }

  void checkFinite(const std::vector<Vec3>& points, const char* name) const {
    for (std::size_t i = 0; i < points.size(); ++i)
      if (!points[i].allFinite())
        throw ComponentError(
            fmt::format("{}[{}] is not finite ({} {} {})", name, i, points[i][0], points[i][1], points[i][2]),
            "finite coordinates");
  }

  void checkSizes() const {
    checkFinite(rest_position, "rest_position");
    checkFinite(velocity, "velocity");
    const auto require = [this](std::size_t found, const char* name) {
      if (found != position.size())
        throw ComponentError(fmt::format("{} has {} entries and there are {} positions", name, found, position.size()),
                             fmt::format("{} entries", position.size()));
    };
    require(rest_position.size(), "rest_position");
    require(velocity.size(), "velocity");
    if (data().find("size")->isSet() && std::size_t(size_) != position.size())
      throw ComponentError(fmt::format("size is {} and there are {} positions", size_, position.size()),
                           "size only when no positions are given");
  }

  struct Shorthand {
    std::string name, whole;
    double value = 0;
    double* target = nullptr;
  };

  std::string template_ = "Vec3";
  std::vector<Vec3> reset_position_;
  int size_ = 0;
  bool use_topology_ = true;
  Link<Topology> topology_{"topology"};
  double rest_scale_ = 1, uniform_scale_ = 1;
  Vec3 translation_ = Vec3::Zero(), rotation_ = Vec3::Zero(), scale_ = Vec3::Ones();
  Vec3 translation2_ = Vec3::Zero(), rotation2_ = Vec3::Zero();
  std::array<Shorthand, 15> shorthands_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mechanical_object) {
  factory.add<stroma::MechanicalObject>("MechanicalObject",
                                        "The nodes of a body: positions, velocities and rest positions");
}
