// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/collision/contact_report.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "framework/scene/archive.h"

namespace stroma::collision {
namespace {

/// Where it is now.
Vec3 placeOf(const CollisionModel& model, const PartPoint& point) {
  std::array<Vec3, 3> places;
  Vec3 sum = Vec3::Zero();
  const std::span<const Vec3> corners = model.corners(*point.part, places);
  for (std::size_t i = 0; i < corners.size(); ++i) sum += point.weight[i] * corners[i];
  return sum;
}

Index numberIn(const CollisionModel& model, const Part& part) { return Index(&part - model.parts().data()); }

}  // namespace

void ContactReport::declare(DataTable& table) {
  table.add("models", names_).help("paths of the collision models that may meet").output();
  table.add("pairs", pairs_)
      .help("of each contact: the first model, as a number in models, its point, line, triangle or sphere, and both of the second")
      .output();
  table.add("firstPoints", first_points_)
      .help("of each contact: its point of the first surface, where the step started")
      .unit("m")
      .output();
  table.add("secondPoints", second_points_).help("the same of the second surface").unit("m").output();
  table.add("normals", normals_).help("of each contact: from the first surface to the second, in all the step").unit("-").output();
  table.add("gaps", gaps_)
      .help("of each contact: how much farther than their contact distance the surfaces were apart, where the step started")
      .unit("m")
      .output();
  table.add("forces", forces_)
      .help("of each contact: force on the second surface in the last step, with friction; of penalties the last one")
      .unit("N")
      .output();
  table.add("multipliers", multipliers_)
      .help("with friction: that force of each contact, along the normal and two tangents; along the normal alone where mu is 0")
      .unit("N")
      .output();
  table.add("modelPairs", pair_names_).help("the collision models of each pair that may meet, two paths for each").output();
  table.add("pairWrenches", pair_wrenches_)
      .help("of each of modelPairs: the force of the second on the first, with friction [N], and its moment about the origin [N m]")
      .output();
}

void ContactReport::compile(const std::vector<ModelPair>& pairs) {
  models_.clear(), names_.clear();
  for (const ModelPair& pair : pairs)
    for (const CollisionModel* model : {pair.a, pair.b})
      if (std::find(models_.begin(), models_.end(), model) == models_.end())
        models_.push_back(model), names_.push_back(model->path());
  pair_of_.assign(models_.size() * models_.size(), -1), pair_names_.clear();
  for (const ModelPair& pair : pairs) {
    Index& place = pair_of_[std::size_t(numberOf(*pair.a)) * models_.size() + std::size_t(numberOf(*pair.b))];
    if (place >= 0) continue;
    place = Index(pair_names_.size() / 2);
    pair_names_.push_back(pair.a->path()), pair_names_.push_back(pair.b->path());
  }
  clear();
}

Index ContactReport::numberOf(const CollisionModel& model) const {
  if (last_ >= models_.size() || models_[last_] != &model)  // neighbours in the list are mostly of one pair
    last_ = std::size_t(std::find(models_.begin(), models_.end(), &model) - models_.begin());
  return Index(last_);
}

void ContactReport::note(const std::vector<Contact>& contacts) {
  clear();
  for (const Contact& contact : contacts) {
    const CollisionModel &a = *contact.model_a, &b = *contact.model_b;
    pairs_.push_back({numberOf(a), numberIn(a, *contact.a.part), numberOf(b), numberIn(b, *contact.b.part)});
    const Vec3 p = placeOf(a, contact.a), q = placeOf(b, contact.b);
    normals_.push_back(contact.normal);
    first_points_.push_back(p + contact.a.part->radius * contact.normal);
    second_points_.push_back(q - contact.b.part->radius * contact.normal);
    gaps_.push_back((q - p).dot(contact.normal) - contact.contact);
  }
  forces_.resize(contacts.size(), Vec3::Zero());
}

void ContactReport::sumForces() {
  pair_wrenches_.assign(pair_names_.size(), Vec3::Zero());
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const std::size_t a = std::size_t(pairs_[i][0]), b = std::size_t(pairs_[i][2]);
    const Index direct = pair_of_[a * models_.size() + b], turned = pair_of_[b * models_.size() + a];
    if (direct < 0 && turned < 0) continue;
    const Vec3 force = direct >= 0 ? Vec3(-forces_[i]) : forces_[i];
    const std::size_t at = 2 * std::size_t(direct >= 0 ? direct : turned);
    pair_wrenches_[at] += force;
    pair_wrenches_[at + 1] += (direct >= 0 ? first_points_ : second_points_)[i].cross(force);
  }
}

void ContactReport::clear() {
  pair_wrenches_.assign(pair_names_.size(), Vec3::Zero());
  pairs_.clear();
  normals_.clear();
  first_points_.clear();
  second_points_.clear();
  gaps_.clear();
  forces_.clear();
  multipliers_.clear();
  is_restored_ = false;
}

void ContactReport::serialize(Archive& archive) {
  std::vector<Index> numbers;
  for (const Quad& pair : pairs_) numbers.insert(numbers.end(), pair.begin(), pair.end());
  archive.list("pairs", numbers);
  archive.list("first_points", first_points_), archive.list("second_points", second_points_);
  archive.list("normals", normals_), archive.list("gaps", gaps_);
  archive.list("forces", forces_), archive.list("multipliers", multipliers_);
  archive.list("pair_wrenches", pair_wrenches_);
  if (!archive.isReading()) return;
  pairs_.resize(numbers.size() / 4);
  for (std::size_t i = 0; i < 4 * pairs_.size(); ++i) pairs_[i / 4][i % 4] = numbers[i];
  is_restored_ = true;
}

}  // namespace stroma::collision
