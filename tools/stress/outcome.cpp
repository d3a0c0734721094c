// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/stress/outcome.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace stroma::stress {
namespace {

constexpr const char* words[endings] = {"good", "runs", "elsewhere", "doubt", "stops", "unfinished", "breaks"};

}  // namespace

const char* wordOf(Ending ending) { return words[int(ending)]; }

nlohmann::ordered_json toJson(const Outcome& outcome) {
  nlohmann::ordered_json json{{"ending", wordOf(outcome.ending)}, {"steps", outcome.steps}};
  // JSON knows no infinity: of a node so far away that the square of its distance is none any more
  if (outcome.distance >= 0) json["distance"] = std::min(outcome.distance, std::numeric_limits<double>::max());
  if (!outcome.sentences.empty()) json["sentences"] = outcome.sentences;
  return json;
}

Outcome outcomeFrom(const nlohmann::ordered_json& json) {
  const auto found = std::find(std::begin(words), std::end(words), json.at("ending").get<std::string>());
  if (found == std::end(words)) throw std::runtime_error("no ending of a case");
  Outcome outcome;
  outcome.ending = Ending(found - std::begin(words));
  outcome.steps = json.at("steps");
  outcome.distance = json.value("distance", -1.);
  outcome.sentences = json.value("sentences", std::vector<std::string>{});
  return outcome;
}

}  // namespace stroma::stress
