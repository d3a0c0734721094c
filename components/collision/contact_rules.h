// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <string>
#include <vector>

#include "components/collision/collision_method.h"

namespace stroma::collision {

/// The response to the contacts of two models.
struct Answer {
  bool rubs = false;  ///< forces of constraint with friction; else penalties
  double mu = 0.8;    ///< of friction
};

/// The responses for each pair of models: a `contactResponse` of one of the two, otherwise the first of `rules` that matches
/// them, otherwise `response`. If both models have different `contactResponse`s it is `response`, or with `rules` that of the first.
class ContactRules {
 public:
  void declare(DataTable& table);
  /// Whether there is any response, by the single default or by rules.
  bool act() const { return !rules_.empty() || isKnown(response_); }
  std::string response() const { return response_; }
  const std::string& parameters() const { return parameters_; }
  /// The response is a contact of whole surfaces (contact_of_surfaces.h).
  bool isOfSurfaces() const;
  /// For these pairs. Throws ComponentError where a word is not a response.
  void read(const std::vector<ModelPair>& pairs);
  bool anyRubs() const { return any_rubs_; }
  bool anyPushes() const { return any_pushes_; }
  /// The same where no models may collide, by the response that they would have.
  bool mayPush() const;
  const Answer& of(const CollisionModel& a, const CollisionModel& b) const { return answers_.at({&a, &b}); }

 private:
  static bool isKnown(const std::string& word);
  static Answer parsed(const std::string& word, const char* attribute);
  static Answer withParameters(Answer answer, const std::string& parameters);
  Answer find(const CollisionModel& a, const CollisionModel& b) const;

  std::string response_ = "PenalityContactForceField", parameters_;
  std::vector<std::string> rules_;  ///< three words each
  std::map<std::pair<const CollisionModel*, const CollisionModel*>, Answer> answers_;
  bool any_rubs_ = false, any_pushes_ = false;
};

}  // namespace stroma::collision
