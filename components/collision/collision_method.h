// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/collision/collision_model.h"

namespace stroma::collision {

/// Which parts of two surfaces are tested against each other, and from which distance on.
class Method : public Component {
 public:
  enum class Rule { proximity, local_minimum, proximity_and_triangles, discrete, continuous };
  std::string roleText() const override { return "intersection method"; }
  void declare(DataTable& table) override;
  /// Whether parts of these kinds are tested.
  bool meet(CollisionModel::Kind a, CollisionModel::Kind b) const;
  /// Whether edges of triangles are tested against lines and other edges.
  bool edgesOfTrianglesMeet() const { return rule == Rule::proximity_and_triangles && line_line_; }
  /// Whether a sphere is tested against the edges and corners of triangles.
  bool trianglesTakeEdges() const { return rule == Rule::proximity_and_triangles; }
  double contactDistance() const { return rule == Rule::discrete ? 0 : contact_distance_; }
  double alarmDistance() const { return rule == Rule::discrete ? 0 : alarm_distance_; }
  /// Whether parts reject contacts outside their normal cones (normal_cones.h), and the parameters that widen the cones.
  bool hasCones() const { return rule == Rule::local_minimum && filters_ && !filtered_elsewhere_; }
  double angleCone() const { return angle_cone_; }
  double coneFactor() const { return cone_factor_; }
  /// Whether contacts are also found on the straight paths of the nodes at their velocities.
  bool followsPaths() const { return rule == Rule::continuous && path_ != Path::none; }
  /// By how much the motion of a step may deviate from these paths, as far as that is taken into account [m].
  double pathDeviation() const;
  /// The method of the scene; null if it has none. Throws ComponentError where there are several.
  static const Method* of(const Node& root);

  Rule rule = Rule::proximity;  ///< set by the registration of a name

 private:
  enum class Path { none, inertia, free_motion };
  Path path_ = Path::none;
  double contact_distance_ = 0.5, alarm_distance_ = 1;
  bool point_point_ = true, line_point_ = true, line_line_ = true, sphere_triangle_ = true, normals_ = false;
  double angle_cone_ = 0, cone_factor_ = 0.5;
  bool filters_ = true, filtered_elsewhere_ = false;
};

/// Two models that may collide; a model with itself where a == b.
struct ModelPair {
  const CollisionModel *a, *b;
};
/// Of a scene whose models are ready. The default method is that of DiscreteIntersection.
std::vector<ModelPair> modelPairs(const Node& root, const Method* method);

/// Searches for contacts in each step.
class ContactWatch {
 public:
  virtual ~ContactWatch() = default;
};

/// Acts on the contacts found, and makes a watch unnecessary.
class ContactAnswer {
 public:
  virtual ~ContactAnswer() = default;
  /// Empty: it acts. Otherwise the reason why it does not, as a sentence.
  virtual std::string idle() const = 0;
  /// Another component acts instead, and needs nobody to find contacts.
  virtual bool leavesAllToAnother() const { return false; }
};

}  // namespace stroma::collision
