// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/quirk_effects.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>

#include "framework/mechanics/frames.h"
#include "framework/scene/dialect.h"
#include "tools/command/comparison.h"
#include "tools/command/session.h"
#include "tools/command/sofa_runs.h"

namespace stroma::command {
namespace {

using Json = nlohmann::ordered_json;

/// A state at the start and at the end, as State::position has it.
struct Movement {
  std::vector<RowKind> kinds;
  Index rows_per_node = 1;
  std::vector<Vec3> start, end;
};
struct Run {
  std::map<std::string, Movement> states;
  std::string refused;  ///< why there is no end
  double time = 0;
};

/// What a run without a quirk changes, of the kind of rows that it changes most.
struct Effect {
  std::string quirk, what, refused;
  double share = 0;  ///< largest difference at the end over the largest displacement
  std::string where;
};

std::vector<Vec3> rowsNow(const State& state) {
  std::vector<Vec3> rows;
  for (Index i = 0; i < state.size(); ++i) rows.push_back(valueOfRow(state.kindOf(i), state.x(), i));
  return rows;
}

/// The names and sentences of the quirks that a scene has, from the note that reading it leaves.
std::vector<std::pair<std::string, std::string>> quirksOf(const Scene& scene) {
  std::vector<std::pair<std::string, std::string>> found;
  for (const Problem& problem : scene.diagnostics.problems()) {
    if (problem.path != dialect_note) continue;
    static const std::regex name("(?:^|; |[)]: )([a-z]+(?:-[a-z]+)+): ");
    const std::string& text = problem.message;
    for (std::sregex_iterator at(text.begin(), text.end(), name), end; at != end;) {
      const auto from = std::size_t(at->position()) + std::size_t(at->length());
      const std::string quirk = (*at)[1];
      const std::size_t to = ++at == end ? text.size() : std::size_t(at->position());
      found.emplace_back(quirk, text.substr(from, to - from));
    }
  }
  return found;
}

class QuirkRuns {
 public:
  QuirkRuns(const std::string& scene, const Values& values, long steps) : scene_(scene), values_(values), steps_(steps) {
    if (values.count("without-quirk")) off_ = values["without-quirk"].as<std::vector<std::string>>();
  }

  /// Without those that the command line names and `more`.
  Run run(const std::vector<std::string>& more, std::vector<std::pair<std::string, std::string>>* quirks = nullptr) const {
    Run result;
    try {
      Session session;
      configure(session, values_);
      std::vector<std::string> off = off_;
      off.insert(off.end(), more.begin(), more.end());
      std::vector<Override> overrides = overridesOf(values_);
      if (!more.empty()) overrides.push_back({"/", "withoutQuirks", fmt::format("{}", fmt::join(off, " "))});
      session.setOverrides(overrides);
      Simulation& simulation = session.load(scene_);
      if (quirks) *quirks = quirksOf(simulation.scene());
      dropWriters(simulation);
      session.followMeshChanges();
      for (const State* state : simulation.states())
        if (state->isBound()) result.states[state->path()] = {state->row_kinds, state->rows_per_node, rowsNow(*state), {}};
      while (simulation.steps() < steps_) {
        const StepReport report = session.step();
        if (!report.failed()) continue;
        result.refused = fmt::format("the run ends at t = {:g}: {}", simulation.time(), report.reason);
        return result;
      }
      result.time = simulation.time();
      for (const State* state : simulation.states())
        if (const auto known = result.states.find(state->path()); known != result.states.end()) known->second.end = rowsNow(*state);
    } catch (const SceneError& error) {
      if (quirks) throw;
      for (const Problem& problem : error.diagnostics().problems())
        if (problem.severity == Severity::error && result.refused.empty()) result.refused = "the scene does not load: " + problem.text();
    }
    return result;
  }

 private:
  const std::string& scene_;
  const Values& values_;
  long steps_;
  std::vector<std::string> off_;
};

Effect effectOf(const Run& all, const Run& without) {
  Effect effect;
  effect.refused = without.refused;
  if (!effect.refused.empty()) return effect;
  std::array<double, 3> sizes{}, differences{};
  std::array<std::string, 3> where;
  for (const auto& [path, own] : all.states) {
    const auto found = without.states.find(path);
    if (found == without.states.end() || found->second.end.size() != own.end.size()) {
      effect.refused = fmt::format("{} has other nodes at the end", path);
      return effect;
    }
    const Movement& other = found->second;
    for (std::size_t i = 0; i < own.end.size(); ++i) {
      const RowKind kind = i < own.kinds.size() ? own.kinds[i] : RowKind::place;
      const std::size_t k = std::size_t(kind);
      for (const Movement* each : {&own, &other})
        if (i < each->start.size()) sizes[k] = std::max(sizes[k], wayBetween(kind, each->start[i], each->end[i]).norm());
      const double difference = wayBetween(kind, own.end[i], other.end[i]).norm();
      if (difference <= differences[k]) continue;
      differences[k] = difference;
      where[k] = fmt::format("{} {} of {}", kind == RowKind::turn ? "orientation" : "node", Index(i) / own.rows_per_node, path);
    }
  }
  for (std::size_t k = 0; k < 3; ++k)
    if (const double share = differences[k] > 0 ? differences[k] / std::max(sizes[k], differences[k]) : 0; share > effect.share)
      effect.share = share, effect.where = where[k];
  return effect;
}

std::string lineOf(const Effect& effect) {
  const std::string end = effect.what.empty() ? "" : ": " + effect.what;
  if (!effect.refused.empty()) return fmt::format("  refused  {}{}\n           without it {}\n", effect.quirk, end, effect.refused);
  const std::string share = effect.share == 0 ? "0" : fmt::format("{:.3g} %", 100 * effect.share);
  return fmt::format("{:>9}  {}{}\n", share, effect.quirk, effect.where.empty() ? end : fmt::format("{}; most at {}", end, effect.where));
}

Json toJson(const Effect& effect) {
  Json json{{"quirk", effect.quirk}, {"what", effect.what}};
  if (effect.refused.empty())
    json["share"] = effect.share, json["where"] = effect.where;
  else
    json["refused"] = effect.refused;
  return json;
}

}  // namespace

int explainQuirks(const std::string& scene, const Values& values) {
  const long steps = values["steps"].as<long>();
  if (steps < 1) throw UsageError(fmt::format("-n {}: expected at least one step", steps));
  const QuirkRuns runs(scene, values, steps);
  std::vector<std::pair<std::string, std::string>> quirks;
  const Run all = runs.run({}, &quirks);
  std::erase_if(quirks, [](const auto& quirk) { return quirk.second.ends_with("switched off"); });
  if (quirks.empty()) throw UsageError(fmt::format("{} has none of SOFA's ways: there is nothing to leave out", scene));
  if (!all.refused.empty()) {
    fmt::print(stderr, "{}\n", all.refused);
    return exit_diverged;
  }
  std::vector<Effect> effects;
  std::vector<std::string> names;
  for (const auto& [name, what] : quirks) {
    effects.push_back(effectOf(all, runs.run({name})));
    effects.back().quirk = name, effects.back().what = what, names.push_back(name);
  }
  std::stable_sort(effects.begin(), effects.end(), [](const Effect& a, const Effect& b) {
    return std::pair(!a.refused.empty(), a.share) > std::pair(!b.refused.empty(), b.share);
  });
  Effect together = effectOf(all, runs.run(names));
  together.quirk = "without any of them";
  if (values.count("json")) {
    Json list = Json::array();
    for (const Effect& effect : effects) list.push_back(toJson(effect));
    const Json json{{"steps", steps}, {"time", all.time}, {"quirks", list}, {"without_any", toJson(together)}};
    fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
    return exit_done;
  }
  fmt::print("After {} steps (-n), at t = {:g}: what each of SOFA's ways changes in the positions, as a share of the largest "
             "displacement, of orientations of the largest rotation\n",
             steps, all.time);
  for (const Effect& effect : effects) fmt::print("{}", lineOf(effect));
  if (effects.size() > 1) fmt::print("{}", lineOf(together));
  return exit_done;
}

}  // namespace stroma::command
