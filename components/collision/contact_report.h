// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>
#include <vector>

#include "components/collision/contact_pairs.h"
#include "framework/mesh/mesh.h"

namespace stroma {
class Archive;
}

namespace stroma::collision {

/// The results of the contacts of a step, as attributes of a component: one entry for each contact.
class ContactReport {
 public:
  void declare(DataTable& table);
  /// Sets the pairs of models that contacts belong to.
  void compile(const std::vector<ModelPair>& pairs);
  /// Called at the start of a step; no contact exerts a force yet.
  void note(const std::vector<Contact>& contacts);
  void setForce(std::size_t contact, const Vec3& force) { forces_[contact] = force; }
  /// Called when all forces are set.
  void sumForces();
  void setMultipliers(std::span<const double> forces) { multipliers_.assign(forces.begin(), forces.end()); }
  void clear();
  void serialize(Archive& archive);
  /// It comes from a checkpoint, and the contacts recorded are others.
  bool isRestored() const { return is_restored_; }

 private:
  Index numberOf(const CollisionModel& model) const;

  std::vector<const CollisionModel*> models_;
  std::vector<std::string> names_;                            ///< of models_
  std::vector<Quad> pairs_;                                   ///< model, part, model, part
  std::vector<Vec3> normals_, first_points_, second_points_;  ///< unit; [m]
  std::vector<double> gaps_;                                  ///< [m]
  std::vector<Vec3> forces_;                                  ///< [N]
  std::vector<double> multipliers_;                           ///< [N]
  std::vector<std::string> pair_names_;                       ///< two of each pair of models
  std::vector<Index> pair_of_;                                ///< by two numbers of models; -1: they do not meet
  std::vector<Vec3> pair_wrenches_;                           ///< of each pair [N], [N m]
  bool is_restored_ = false;
  mutable std::size_t last_ = 0;  ///< model that was looked for
};

}  // namespace stroma::collision
