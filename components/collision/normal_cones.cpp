// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/collision/normal_cones.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "framework/scene/node.h"

namespace stroma::collision {

namespace {

constexpr double rounding = 1e-9;
/// Faces and lines leave out a strip at their rim, a millionth of their size: what comes down there is met by their edges and ends.
constexpr double rim = 1.001e-6;

/// The lines of the surface whose nodes the model's points are; null when there are none.
const CollisionModel* linesOf(const CollisionModel& points) {
  for (const Node* at = &points.node(); at; at = at->parent())
    for (const auto& component : at->components())
      if (const auto* model = dynamic_cast<const CollisionModel*>(component.get()))
        if (model->kind() == CollisionModel::Kind::line && &model->state() == &points.state()) return model;
  return nullptr;
}

}  // namespace

void NormalCones::compile(const CollisionModel& model, double angle_cone, double cone_factor) {
  model_ = &model, angle_cone_ = angle_cone, cone_factor_ = cone_factor;
  faces_.clear(), ends_.clear();
  if (model.kind() == CollisionModel::Kind::line) compileLines();
  if (model.kind() == CollisionModel::Kind::point) compilePoints();
}

void NormalCones::compileLines() {
  std::map<Edge, std::vector<Triangle>> around;
  for (const Triangle& face : model_->faces())
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = face[i], b = face[(i + 1) % 3];
      around[{std::min(a, b), std::max(a, b)}].push_back({a, b, face[(i + 2) % 3]});
    }
  for (const Part& part : model_->parts()) {
    const auto [low, high] = std::minmax(part.node[0], part.node[1]);
    const auto found = around.find({low, high});
    faces_.push_back(found == around.end() ? std::vector<Triangle>() : found->second);
  }
}

void NormalCones::compilePoints() {
  const CollisionModel* lines = linesOf(*model_);
  if (!lines) return;
  faces_.resize(std::size_t(model_->state().nodes()));
  ends_.resize(faces_.size());
  for (const Triangle& face : lines->faces())
    for (const Index node : face) faces_.at(std::size_t(node)).push_back(face);
  for (const Edge& edge : lines->edges())
    for (std::size_t i = 0; i < 2; ++i) ends_.at(std::size_t(edge[i])).push_back(edge[1 - i]);
}

Vec3 NormalCones::normalOf(const Triangle& face) const {
  const Vec3 a = model_->place(face[0]);
  return (model_->place(face[1]) - a).cross(model_->place(face[2]) - a).normalized();
}

/// `size`: of the face or line on that side [m].
bool NormalCones::isWithin(const Vec3& out, const Vec3& normal, const Vec3& way, double size) const {
  const double cone = cone_factor_ * std::max(0.0, normal.dot(out)) + angle_cone_;
  return out.dot(way) >= -(cone + rounding) * way.norm() - rim * size;
}

bool NormalCones::hold(const Part& part, const Vec3& way) const {
  if (!model_) return true;
  switch (model_->kind()) {
    case CollisionModel::Kind::triangle: return model_->hasTwoSides() || normalOf(part.node).dot(way) >= 0;
    case CollisionModel::Kind::line: return lineHolds(part, way);
    case CollisionModel::Kind::point: return faces_.empty() || pointHolds(part.node[0], way);
    case CollisionModel::Kind::sphere: break;
  }
  return true;
}

bool NormalCones::lineHolds(const Part& part, const Vec3& way) const {
  const std::vector<Triangle>& faces = faces_[std::size_t(&part - model_->parts().data())];
  if (faces.size() != 2) {
    const Vec3 along = (model_->place(part.node[1]) - model_->place(part.node[0])).normalized();
    return std::abs(along.dot(way)) <= (angle_cone_ + 1e-4) * way.norm();
  }
  const Vec3 first = normalOf(faces[0]), second = normalOf(faces[1]), normal = (first + second).normalized();
  if (!model_->hasTwoSides() && normal.dot(way) < -rounding * way.norm()) return false;
  const auto isBeside = [&](const Triangle& face, const Vec3& n) {
    const Vec3 end = model_->place(face[0]), out = (model_->place(face[1]) - end).cross(n).normalized();
    return isWithin(out, normal, way, out.dot(end - model_->place(face[2])));
  };
  return isBeside(faces[0], first) && isBeside(faces[1], second);
}

bool NormalCones::pointHolds(Index node, const Vec3& way) const {
  const std::vector<Triangle>& faces = faces_[std::size_t(node)];
  std::vector<Vec3> outward;
  double size = 0;
  for (const Index end : ends_[std::size_t(node)]) {
    const Vec3 line = model_->place(node) - model_->place(end);
    size = std::max(size, line.norm()), outward.push_back(line.normalized());
  }
  Vec3 normal = Vec3::Zero();
  for (const Triangle& face : faces) normal += normalOf(face);
  if (faces.empty())
    for (const Vec3& out : outward) normal += out;
  const double length = normal.norm();
  if (length > 1e-10) {
    normal /= length;
    if (!model_->hasTwoSides() && normal.dot(way) < -(angle_cone_ + rounding) * way.norm()) return false;
  } else {
    normal = Vec3::Zero();
  }
  return std::all_of(outward.begin(), outward.end(), [&](const Vec3& out) { return isWithin(out, normal, way, 2 * size); });
}

}  // namespace stroma::collision
