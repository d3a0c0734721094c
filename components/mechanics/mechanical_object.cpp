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
// `template` says what a node is: a point ("Vec3"), a rigid frame ("Rigid3"), or one, two or six numbers ("Vec1", "Vec2",
// "Vec6"). A frame has seven numbers in positions, its centre and its orientation, a quaternion x y z w, and six in
// velocities: of its centre, and its angular velocity in fixed axes [rad/s]. Scale and translation act on its centre,
// rotations on both. An increment dx, dw moves it to x + dx and exp(dw) q.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject name="dofs" position="0 0 0  1 0 0" velocity="0 1 0  0 1 0" rotation="0 0 90"
//     translation="0 2 0"/>
//   <UniformMass totalMass="2"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "framework/mechanics/signs.h"
#include "framework/mechanics/mapping.h"
#include "framework/mechanics/state_topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// The sign is that of a motion about each axis in turn: w < 0 after more than half a turn.
Quaternion rotationXyz(const Vec3& degrees) {
  const Vec3 angle = degrees * (std::numbers::pi / 180);
  return Eigen::AngleAxisd(angle.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(angle.y(), Vec3::UnitY()) *
         Eigen::AngleAxisd(angle.x(), Vec3::UnitX());
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

  /// Positions of frames and numbers are flat lists.
  void chooseTemplate(const std::string& word) override {
    const NodeType* type = typeOf(word);
    if (!type || type->kinds.empty()) return;
    const auto keep = [this, type](const char* name, std::vector<double>& list, bool turns) {
      std::size_t width = 0;
      for (const RowKind kind : type->kinds) width += kind == RowKind::value ? 1 : kind == RowKind::turn && turns ? 4 : 3;
      data().find(name)->inValuesOf(width).keepIn(&list);
    };
    keep("position", flat_position_, true), keep("velocity", flat_velocity_, false);
    keep("rest_position", flat_rest_, true), keep("reset_position", flat_reset_, true);
  }

  void init() override {
    const NodeType* type = typeOf(template_);
    if (!type)
      throw ComponentError(fmt::format("nodes of type {} do not exist here", template_), "Vec3, Rigid3, Vec1, Vec2 or Vec6",
                           template_ == "Rigid2" ? "Rigid3 with PartialFixedProjectiveConstraint, fixedDirections=\"0 0 1 1 1 0\""
                                                 : nearest(template_, {"Vec3", "Rigid3", "Vec1", "Vec2", "Vec6"}));
    kinds_ = type->kinds;
    readShorthands();
    if (!kinds_.empty()) readFlat();
    findPositions();
    if (!kinds_.empty()) makeRows();
    checkFinite(position, "position");
    transform();
    if (rest_position.empty()) {
      rest_position = position;
      for (std::size_t i = 0; i < rest_position.size(); ++i)
        if (kindOf(Index(i)) != RowKind::turn) rest_position[i] *= rest_scale_;
    } else if (data().find("restScale")->isSet()) {
      throw ComponentError("rest_position and restScale are both given", "one of them");
    }
    if (!rotation2_.isZero(0)) turnBy(rotationXyz(rotation2_));
    translateBy(translation2_);
    if (velocity.empty()) velocity.assign(position.size(), Vec3::Zero());
    if (velocity.size() == 1) velocity.resize(position.size(), Vec3(velocity[0]));
    while (repeats_velocity_ && velocity.size() < position.size())
      velocity.push_back(velocity[velocity.size() - std::size_t(rows_per_node)]);
    if (repeats_velocity_ && velocity.size() > position.size()) {
      warn(fmt::format("velocity has {} nodes and the mesh {}: the others are ignored, as in SOFA",
                       velocity.size() / std::size_t(rows_per_node), nodes()));
      velocity.resize(position.size());
    }
    checkSizes();
    if (kinds_.empty()) {
      reset_position_ = position;
    } else {
      flat_position_ = flat_reset_ = flat(position, true), flat_rest_ = flat(rest_position, true);
      flat_velocity_ = flat(velocity, false);
    }
    size_ = nodes();
  }

 private:
  /// What the rows of a node are; none: it is a point.
  struct NodeType {
    std::string_view word;
    std::vector<RowKind> kinds;
  };
  static const NodeType* typeOf(std::string_view word) {
    static const std::vector<NodeType> types{{"Vec3", {}},
                                             {"Rigid3", {RowKind::place, RowKind::turn}},
                                             {"Vec1", {RowKind::value}},
                                             {"Vec2", {2, RowKind::value}},
                                             {"Vec6", {6, RowKind::value}}};
    if (word.ends_with('d') || word.ends_with('f')) word.remove_suffix(1);  // SOFA's words for two sizes of numbers
    for (const NodeType& type : types)
      if (type.word == word) return &type;
    return nullptr;
  }

  // ---- frames and numbers: flat lists as the scene has them, and rows ----

  int numbersOfNode(bool in_positions) const {
    int numbers = 0;
    for (const RowKind kind : kinds_)
      numbers += kind == RowKind::value ? 1 : kind == RowKind::place || !in_positions ? 3 : 4;
    return numbers;
  }

  std::vector<Vec3> rowsOf(const std::vector<double>& flat, bool in_positions, const char* name) const {
    const std::size_t numbers = std::size_t(numbersOfNode(in_positions));
    if (flat.size() % numbers != 0)
      throw ComponentError(fmt::format("{} has {} numbers", name, flat.size()),
                           fmt::format("{} numbers for each node of type {}", numbers, template_));
    std::vector<Vec3> rows;
    for (const double* at = flat.data(); at != flat.data() + flat.size();)
      for (const RowKind kind : kinds_) {
        if (kind == RowKind::value) {
          rows.emplace_back(*at++, 0, 0);
        } else if (kind == RowKind::place || !in_positions) {
          rows.emplace_back(at[0], at[1], at[2]), at += 3;
        } else {
          const Quaternion q(at);
          if (!(q.norm() > 1e-6) || !std::isfinite(q.norm()))
            throw ComponentError(fmt::format("{}: frame {} has the quaternion {} {} {} {}, which is not an orientation",
                                             name, rows.size() / 2, at[0], at[1], at[2], at[3]),
                                 "x y z w of length one", "0 0 0 1 does not turn");
          if (std::abs(q.norm() - 1) > 1e-3)
            warn(fmt::format("{}: the quaternion of frame {} has the length {:.4g}: it is made one", name,
                             rows.size() / 2, q.norm()));
          rows.push_back(signedRotationVector(q.normalized())), at += 4;
        }
      }
    return rows;
  }

  std::vector<double> flat(const std::vector<Vec3>& rows, bool in_positions) const {
    std::vector<double> numbers;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const RowKind kind = kindOf(Index(i));
      Quaternion q =
          kind == RowKind::turn && in_positions ? turnedBy(rows[i]) : Quaternion(0, rows[i][0], rows[i][1], rows[i][2]);
      numbers.insert(numbers.end(), q.coeffs().data(),
                     q.coeffs().data() + (kind == RowKind::value                  ? 1
                                          : kind == RowKind::turn && in_positions ? 4
                                                                                  : 3));
    }
    return numbers;
  }

  void readFlat() {
    position = rowsOf(flat_position_, true, "position");
    rest_position = rowsOf(flat_rest_, true, "rest_position");
    velocity = rowsOf(flat_velocity_, false, "velocity");
    if (velocity.size() == kinds_.size() && position.size() > velocity.size())  // one for all
      for (std::size_t i = kinds_.size(); i < position.size(); ++i) velocity.push_back(velocity[i % kinds_.size()]);
  }

  /// Of points that a mesh gives: frames that are not turned, or numbers, which are the coordinates, or zero of nodes at the origin.
  void makeRows() {
    rows_per_node = Index(kinds_.size());
    if (position_is_of_points_) {
      const std::vector<Vec3> points = std::move(position);
      position.clear();
      for (const Vec3& point : points)
        for (std::size_t k = 0; k < kinds_.size(); ++k)
          position.push_back(kinds_[k] == RowKind::place                ? point
                             : kinds_[k] == RowKind::value && k < 3 ? Vec3(point[Eigen::Index(k)], 0, 0)
                                                                    : Vec3(Vec3::Zero()));
    }
    row_kinds.clear();
    while (row_kinds.size() < position.size()) row_kinds.insert(row_kinds.end(), kinds_.begin(), kinds_.end());
  }

  void turnBy(const Quaternion& given) {
    const Mat3 rotation = given.toRotationMatrix();
    Quaternion turn(rotation);
    if (turn.dot(given) < 0) turn.coeffs() = -turn.coeffs();
    for (std::size_t i = 0; i < position.size(); ++i) {
      if (kindOf(Index(i)) == RowKind::place) position[i] = rotation * position[i];
      if (kindOf(Index(i)) == RowKind::turn) position[i] = signedRotationVector(turn * turnedBy(position[i]));
    }
  }
  void translateBy(const Vec3& way) {
    for (std::size_t i = 0; i < position.size(); ++i)
      if (kindOf(Index(i)) == RowKind::place) position[i] += way;
  }

  void declareVectors(DataTable& table) {
    table.add("template", template_).help("type of a node: Vec3, Rigid3, Vec1, Vec2 or Vec6");
    table.add("position", position).help("initial positions; from the mesh of this node by default").unit("m");
    table.add("velocity", velocity).help("initial velocities, one for each node or one for all; zero by default").unit("m/s");
    table.add("rest_position", rest_position)
        .help("stress-free positions; the transformed positions by default")
        .unit("m");
    table.add("reset_position", reset_position_).help("positions that a reset returns to").unit("m").output();
    table.add("size", size_).help("number of nodes, at the origin, when no positions are given").min(0);
    table.add("useTopology", use_topology_).help("take positions from the mesh of this node when none are given");
    table.add("valuesFromMesh", values_from_mesh_)
        .help("numbers that are not given are the coordinates of the mesh of this node, of a Vec1 the first, as in SOFA");
    table.add("repeatVelocity", repeats_velocity_)
        .help("a velocity list that is too short is continued with its last entry, and one that is too long is cut, as in SOFA");
    table.addLink("topology", topology_).help("mesh that gives the positions; the one of this node by default");
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
    position_is_of_points_ = position.empty() && rest_position.empty();
    if (!position.empty()) return;
    if (!kinds_.empty() && kinds_[0] == RowKind::value && rest_position.empty()) {  // a mapping may say how many
      if (const Topology* mesh = values_from_mesh_ ? firstTopology(*this, false) : nullptr) position = mesh->mesh().position;
      if (position.empty()) position.assign(std::size_t(std::max(size_, 1)), Vec3::Zero());
      return;
    }
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
      if (!isMapped())
        warn(
            "no positions: neither position, rest_position, size nor a mesh in this node or above; one node at the "
            "origin is made",
            "position=\"@loader.position\", or a topology in the same node");
      position.assign(1, Vec3::Zero());
    }
  }

  /// A mapping may say where its nodes are: one that names this state, wherever it stands, or one beside it that names none.
  bool isMapped() const {
    std::vector<Mapping*> mappings;
    node().root().collect(mappings);
    return std::any_of(mappings.begin(), mappings.end(), [this](const Mapping* mapping) {
      const Data* output = mapping->data().find("output");
      const Component* named = output && output->link() ? output->link()->target() : nullptr;
      return named ? named == this : &mapping->node() == &node();
    });
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
    for (std::size_t i = 0; i < position.size(); ++i)
      if (kindOf(Index(i)) == RowKind::place) position[i] = position[i].cwiseProduct(scale_);
    if (!rotation_.isZero(0)) turnBy(rotationXyz(rotation_));
    translateBy(translation_);
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
      const std::size_t rows = std::size_t(rows_per_node);
      if (found != position.size())
        throw ComponentError(
            fmt::format("{} has {} entries and there are {} positions", name, found / rows, position.size() / rows),
            fmt::format("{} entries", position.size() / rows));
    };
    require(rest_position.size(), "rest_position");
    require(velocity.size(), "velocity");
    if (data().find("size")->isSet() && size_ != nodes())
      throw ComponentError(fmt::format("size is {} and there are {} positions", size_, nodes()),
                           "size only when no positions are given");
  }

  struct Shorthand {
    std::string name, whole;
    double value = 0;
    double* target = nullptr;
  };

  std::string template_ = "Vec3";
  std::vector<RowKind> kinds_;  ///< of one node; empty for points
  std::vector<double> flat_position_, flat_velocity_, flat_rest_, flat_reset_;
  bool position_is_of_points_ = false;
  std::vector<Vec3> reset_position_;
  int size_ = 0;
  bool use_topology_ = true, values_from_mesh_ = false, repeats_velocity_ = false;
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
