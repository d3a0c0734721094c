// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/collision/contact_rules.h"

#include <fmt/format.h>

#include <cstdlib>
#include <sstream>

#include "components/collision/contact_of_surfaces.h"
#include "framework/scene/node.h"

namespace stroma::collision {

namespace {

constexpr const char* pushing = "PenalityContactForceField";
constexpr const char* rubbing = "FrictionContactConstraint";

bool rubs(const std::string& word) { return word == rubbing || word == "FrictionContact"; }

/// A model of this name or of the group of this number; * is any.
bool speaksOf(const std::string& word, const CollisionModel& model) {
  if (word == "*") return true;
  if (word.find_first_not_of("-0123456789") != std::string::npos) return word == model.name();
  return model.isInGroup(std::atoi(word.c_str()));
}

}  // namespace

void ContactRules::declare(DataTable& table) {
  table.add("response", response_)
      .help("how contacts are answered: PenalityContactForceField or FrictionContactConstraint, contact by contact; BarrierContact (no "
            "penetration), ConstraintContact or PenaltyContact, of whole surfaces");
  table.add("responseParams", parameters_)
      .help("mu=... of friction; 0.8 by default. Of a contact of whole surfaces also its attributes, as mu=0.3&stiffness=1e4, and no "
            "friction by default");
  table.add("rules", rules_)
      .help("for pairs of models, three words each: two names, group numbers or *, and a response; the first match is used");
}

bool ContactRules::isKnown(const std::string& word) {
  return rubs(word) || word.empty() || word == pushing || word == "default";
}

/// "mu=0.6&tol=1e-3": each a name and a number; tol is SOFA's, a tolerance of its solvers.
Answer ContactRules::withParameters(Answer answer, const std::string& parameters) {
  constexpr const char* expected = "mu=NUMBER, zero or more; several are joined by &";
  std::istringstream parts(parameters);
  for (std::string part; std::getline(parts, part, '&');) {
    const auto at = part.find('=');
    const std::string name = part.substr(0, at), text = at == std::string::npos ? "" : part.substr(at + 1);
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != 0) throw ComponentError(fmt::format("responseParams has \"{}\"", part), expected);
    if (name == "mu") {
      if (!(number >= 0)) throw ComponentError(fmt::format("mu is {:g}", number), expected);
      answer.mu = number;
    } else if (name != "tol") {
      throw ComponentError(fmt::format("responseParams has \"{}\", which is not a parameter", part), expected);
    }
  }
  return answer;
}

/// "FrictionContactConstraint?mu=0.6".
Answer ContactRules::parsed(const std::string& word, const char* attribute) {
  const auto mark = word.find('?');
  const std::string name = word.substr(0, mark);
  if (!isKnown(name))
    throw ComponentError(fmt::format("{} has \"{}\", which is not a response{}", attribute, name,
                                     collision::isOfSurfaces(name) ? " of single contacts" : ""),
                         fmt::format("{} or {}?mu=0.6", pushing, rubbing),
                         collision::isOfSurfaces(name) ? fmt::format("response=\"{}\" without rules, for all contacts", name) : "");
  Answer answer;
  answer.rubs = rubs(name);
  return withParameters(answer, mark == std::string::npos ? "" : word.substr(mark + 1));
}

bool ContactRules::isOfSurfaces() const { return rules_.empty() && collision::isOfSurfaces(response_); }

bool ContactRules::mayPush() const { return answers_.empty() ? !rubs(response_) : any_pushes_; }

Answer ContactRules::find(const CollisionModel& a, const CollisionModel& b) const {
  std::vector<Answer> own;  // all are parsed, so that a misspelt one is an error even where it is not used
  for (const CollisionModel* model : {&a, &b})
    if (!model->response().empty()) own.push_back(parsed(model->response(), "contactResponse"));
  const bool disagree = own.size() == 2 && a.response() != b.response();
  if (!own.empty() && !(disagree && rules_.empty())) return own.front();
  for (std::size_t i = 0; i < rules_.size(); i += 3)
    if ((speaksOf(rules_[i], a) && speaksOf(rules_[i + 1], b)) || (speaksOf(rules_[i], b) && speaksOf(rules_[i + 1], a)))
      return parsed(rules_[i + 2], "rules");
  return withParameters(parsed(response_, "response"), rubs(response_) ? parameters_ : "");
}

void ContactRules::read(const std::vector<ModelPair>& pairs) {
  if (rules_.size() % 3 != 0)
    throw ComponentError(fmt::format("rules has {} words", rules_.size()),
                         "three for each rule, as \"* * FrictionContactConstraint\"");
  if (!rules_.empty() && collision::isOfSurfaces(response_))
    throw ComponentError(fmt::format("there are rules, and {} is the response of all contacts", response_), "one of both");
  for (std::size_t i = 2; i < rules_.size(); i += 3) parsed(rules_[i], "rules");
  if (rubs(response_)) withParameters({}, parameters_);
  answers_.clear();
  any_rubs_ = any_pushes_ = false;
  for (const ModelPair& pair : pairs) {
    const Answer answer = find(*pair.a, *pair.b);
    answers_[{pair.a, pair.b}] = answers_[{pair.b, pair.a}] = answer;
    (answer.rubs ? any_rubs_ : any_pushes_) = true;
  }
}

}  // namespace stroma::collision
